// SPDX-License-Identifier: Apache-2.0
// The headers of RGL's interface are C, too, and their enumerations have the sizes that the library's functions expect.
#include <rgl/api/core.h>
#include <rgl/api/extensions/pcl.h>
#include <rgl/api/extensions/ros2.h>
#include <rgl/api/extensions/tape.h>

_Static_assert(sizeof(rgl_status_t) == 4 && sizeof(rgl_field_t) == 4 && sizeof(rgl_axis_t) == 4, "as int32_t");
_Static_assert(sizeof(rgl_return_mode_t) == 4 && sizeof(rgl_log_level_t) == 4, "as int32_t");
_Static_assert(sizeof(rgl_extension_t) == 4 && sizeof(rgl_radar_object_class_t) == 4, "as int32_t");
_Static_assert(sizeof(rgl_return_type_t) == 1, "as a value of RGL_FIELD_RETURN_TYPE_U8");

int main(void) {
  int32_t major = -1, minor = -1, patch = -1;
  const rgl_status_t status = rgl_get_version_info(&major, &minor, &patch);
  return status == RGL_SUCCESS && major >= 0 && minor >= 16 && patch >= 0 ? 0 : 1;
}

// SPDX-License-Identifier: Apache-2.0
// The fields of points, and the levels of the interface, whose numbers for them differ.
#pragma once

#include <rgl/api/core.h>

#include <cstddef>
#include <string>
#include <vector>

namespace gnosphere::rgl {

using Fields = std::vector<rgl_field_t>;

/// The name of a field as messages have it: XYZ_VEC3_F32, without its prefix.
const char* nameOf(rgl_field_t field);
/// Bytes of a field's value. Throws Failure(RGL_INVALID_ARGUMENT) for a number that is no field.
size_t sizeOf(rgl_field_t field);
bool isPadding(rgl_field_t field);

/// The level that the environment variable GNOSPHERE_RGL_ABI chooses: 16 for 0.16, 17 for 0.17, else 18 to 21.
int level();
/// The version that rgl_get_version_info() tells: GNOSPHERE_RGL_VERSION, or else that of the level.
struct Version {
  int major = 0, minor = 20, patch = 0;
};
Version version();

/// The field that a number means at this level. Throws Failure(RGL_INVALID_ARGUMENT) if it means none.
rgl_field_t fieldOf(rgl_field_t number);
Fields fieldsOf(const rgl_field_t* numbers, int32_t count);

}  // namespace gnosphere::rgl

// SPDX-License-Identifier: Apache-2.0
// How fast a surface goes away along the beam, as the Doppler shift of an FMCW sensor tells it.
#ifndef GNOSPHERE_EFFECTS_MOTION_H
#define GNOSPHERE_EFFECTS_MOTION_H

#include "arithmetic.h"

#ifdef __cplusplus
namespace gnosphere::gpu {
#endif

// m/s, positive going away: a point that moves with `point` seen along the unit vector `direction` by a sensor that
// moves with `sensor`, all in one frame.
GNO_INLINE float radialSpeed(vec3 direction, vec3 point, vec3 sensor) {
  GNO_PRECISE float result =
      direction.x * (point.x - sensor.x) + direction.y * (point.y - sensor.y) + direction.z * (point.z - sensor.z);
  return result;
}

#ifdef __cplusplus
}  // namespace gnosphere::gpu
#endif
#endif

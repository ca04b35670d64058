// SPDX-License-Identifier: Apache-2.0
// The speed at which a surface recedes along the beam; an FMCW sensor measures it as a Doppler shift.
#ifndef GNOSPHERE_EFFECTS_DOPPLER_H
#define GNOSPHERE_EFFECTS_DOPPLER_H

#include "arithmetic.h"

#ifdef __cplusplus
namespace gnosphere::gpu {
#endif

// Returns the radial speed in m/s, positive if the point recedes. `point` and `sensor` are the velocities of the point
// and the sensor, `direction` is the unit vector from the sensor to the point; all are in one frame.
GNO_INLINE float radialSpeed(vec3 direction, vec3 point, vec3 sensor) {
  GNO_PRECISE float result =
      direction.x * (point.x - sensor.x) + direction.y * (point.y - sensor.y) + direction.z * (point.z - sensor.z);
  return result;
}

#ifdef __cplusplus
}  // namespace gnosphere::gpu
#endif
#endif

// SPDX-License-Identifier: Apache-2.0
// The requests whose time is measured: each effect alone, with typical parameters.
#pragma once

#include <string>
#include <vector>

#include "gnosphere/gnosphere.hpp"

namespace gnosphere::bench {

/// How the ranges of returned surfaces compare with those of a bare scan.
enum class Ranges {
  same,   ///< equal, bit by bit
  near,   ///< equal up to agreementOf(), because the effect traces its own line along the beam
  other,  ///< different
};

struct Variant {
  std::string name;
  std::string effect;  ///< of effectNames(); empty: several effects
  Effects request;     ///< this effect alone, plus intensity where the effect needs it
  std::vector<Field> fields = {};
  Ranges ranges = Ranges::other;
};

/// Returns every effect alone, and at last all at once. `dust` is the place of a box of dust in the world.
std::vector<Variant> variantsOf(const Vec3& dust);

/// A motion from `pose` on at 15 m/s along the sensor's x axis, with a rotation of 30 degrees a second.
SensorMotion drivenFrom(const Pose& pose, double seconds);

/// Moves the town's vehicles at 10 m/s along their own x axis; in another scene, all instances.
std::vector<InstanceMotion> drivenVehicles(const Scene& scene, double seconds);

}  // namespace gnosphere::bench

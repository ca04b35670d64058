// SPDX-License-Identifier: Apache-2.0
// The requests whose cost is measured: each effect alone, with figures that a user would ask for.
#pragma once

#include <string>
#include <vector>

#include "gnosphere/gnosphere.hpp"

namespace gnosphere::bench {

/// Where the surfaces are that are returned, beside those that a bare scan sees.
enum class Ranges {
  same,   ///< there, bit by bit
  near,   ///< as agreementOf() has it: a line of sight of its own, along the beam
  other,  ///< elsewhere
};

struct Variant {
  std::string name;
  std::string effect;  ///< of effectNames(); empty: several
  Effects request;     ///< nothing else, but for intensity where it is needed
  std::vector<Field> fields = {};
  Ranges ranges = Ranges::other;
};

/// Every effect alone and last all of them at once. `dust`: where a box of it stands, world.
std::vector<Variant> variantsOf(const Vec3& dust);

/// From `pose` on, at 15 m/s along the sensor's x axis and turning by 30 degrees a second.
SensorMotion drivenFrom(const Pose& pose, double seconds);

/// The vehicles of the town at 10 m/s along their own x axis; in another scene whatever there is.
std::vector<InstanceMotion> drivenVehicles(const Scene& scene, double seconds);

}  // namespace gnosphere::bench

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <compare>

#include "town/mesh_builder.hpp"

namespace gnosphere::town {

enum class VehicleKind : uint8_t { hatchback, saloon, estate, van, bus };

inline constexpr double kHalfWheelbase = 1.3;  ///< metres from the middle of a car to its axles, about

/// A road vehicle that stands on z = 0, centred, and faces +x.
struct Vehicle {
  VehicleKind kind = VehicleKind::saloon;
  Surface paint = Surface::paintSilver;
  bool fine = true;  ///< wheel arches, mirrors, rounder wheels

  auto operator<=>(const Vehicle&) const = default;
};

Mesh vehicleMesh(const Vehicle& vehicle);

}  // namespace gnosphere::town

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <compare>

#include "town/mesh_builder.hpp"

namespace gnosphere::town {

// Pieces of ground, in centimetres so that equal pieces compare equal. Carriageways lie at z = 0.

inline constexpr double kKerbHeight = 0.12;  ///< height of blocks above the carriageway
inline constexpr int kCornerRadius = 450;    ///< cm, of the kerb at a crossing

/// A straight carriageway along x from 0 to `length`, centred on y = 0.
struct Road {
  int length = 0;
  int halfWidth = 0;
  bool avenue = false;  ///< two lanes each way; else one lane each way and parked cars

  auto operator<=>(const Road&) const = default;
};

/// The crossing of a road along x (half width `halfY`) and one along y (`halfX`); reaches kCornerRadius into each arm.
struct Crossing {
  int halfX = 0;
  int halfY = 0;

  auto operator<=>(const Crossing&) const = default;
};

/// Kerb, sidewalk and the ground that they enclose. One corner is at the origin; the block extends to +x and +y.
struct Block {
  int width = 0;
  int depth = 0;
  int sidewalk = 0;
  Surface inside = Surface::grass;

  auto operator<=>(const Block&) const = default;
};

Mesh roadMesh(const Road& road);
Mesh crossingMesh(const Crossing& crossing);
Mesh blockMesh(const Block& block);

}  // namespace gnosphere::town

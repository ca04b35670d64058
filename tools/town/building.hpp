// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <compare>

#include "town/mesh_builder.hpp"

namespace gnosphere::town {

enum class BuildingKind : uint8_t { rowHouse, apartments, office, shopHouse, house, hall, church };
enum class RoofKind : uint8_t { flat, gable, hip };

/// A building in whole metres. Its front stands on y = 0 and faces -y; it is centred on x and reaches to y = depth.
struct Building {
  BuildingKind kind = BuildingKind::rowHouse;
  int width = 10;
  int depth = 10;
  int floors = 3;
  RoofKind roof = RoofKind::flat;
  Surface wall = Surface::brick;
  Surface cover = Surface::roofTile;  ///< of pitched roofs
  bool openSides = true;              ///< windows left and right, too; else these walls are party walls
  int style = 0;                      ///< varies details between buildings of one kind

  auto operator<=>(const Building&) const = default;
};

Mesh buildingMesh(const Building& building);

}  // namespace gnosphere::town

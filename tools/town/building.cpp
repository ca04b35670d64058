// SPDX-License-Identifier: Apache-2.0
#include "town/building.hpp"

#include <algorithm>

#include "town/facade.hpp"
#include "town/roof.hpp"

namespace gnosphere::town {
namespace {

/// The dimensions of a kind of building, in metres.
struct Measures {
  double groundHeight, floorHeight;
  double sill, windowHeight, windowWidth;
  double bay;  ///< width of wall per window
};

Measures measuresOf(const Building& building) {
  switch (building.kind) {
    case BuildingKind::rowHouse: return {3.1, 2.9, 0.9, 1.5, 1.1, 2.6};
    case BuildingKind::apartments: return {3.2, 2.9, 0.8, 1.6, 1.5, 3.2};
    case BuildingKind::office: return {4.0, 3.5, 0.7, 2.1, 2.3, 2.9};
    case BuildingKind::shopHouse: return {3.9, 3.0, 0.9, 1.6, 1.2, 2.6};
    case BuildingKind::house: return {2.9, 2.7, 0.9, 1.3, 1.2, 3.3};
    case BuildingKind::hall: return {5.5, 4.5, 3.0, 1.4, 3.0, 5.0};
    case BuildingKind::church: return {9.0, 4.0, 2.0, 5.0, 1.2, 3.6};
  }
  return {};
}

std::vector<double> rowEdges(const Building& building, const Measures& m) {
  const bool shop = building.kind == BuildingKind::shopHouse || building.kind == BuildingKind::office;
  std::vector<double> rows = {0};
  const double groundSill = shop ? 0.5 : m.sill;
  rows.push_back(groundSill);
  rows.push_back(shop ? m.groundHeight - 0.7 : m.sill + m.windowHeight);
  for (int floor = 1; floor < building.floors; ++floor) {
    const double base = m.groundHeight + (floor - 1) * m.floorHeight;
    rows.push_back(base + m.sill);
    rows.push_back(base + m.sill + m.windowHeight);
  }
  rows.push_back(m.groundHeight + (building.floors - 1) * m.floorHeight);
  return rows;
}

Opening frontOpening(const Building& building, int column, int row, int columns) {
  const bool isBay = column % 2 == 1, isWindowRow = row % 2 == 1;
  const bool shop = building.kind == BuildingKind::shopHouse || building.kind == BuildingKind::office;
  const int bays = columns / 2;
  const int doorColumn = 2 * (building.style % std::max(bays, 1)) + 1;
  if (row <= (building.kind == BuildingKind::church ? 0 : 1) && column == doorColumn) return Opening::door;
  const bool nearDoor = column == doorColumn - 1 || column == doorColumn + 1;
  if (shop && row == 1 && column > 0 && column + 1 < columns && !nearDoor) return Opening::display;
  if (!isBay || !isWindowRow) return Opening::none;
  const bool dwelling = building.kind != BuildingKind::office && building.kind != BuildingKind::hall &&
                        building.kind != BuildingKind::church;
  const int pick = static_cast<int>(Dice(building.style, column, row, building.width).next() % 9);
  return dwelling && pick == 0 ? Opening::shuttered : Opening::window;
}

Opening plainOpening(const Building& building, int column, int row) {
  if (column % 2 == 0 || row % 2 == 0) return Opening::none;
  return (column * 7 + row * 3 + building.style) % 11 == 0 ? Opening::shuttered : Opening::window;
}

/// Adds the four walls and the floor. Returns the upper edge of the walls, counter-clockwise from above.
Loop addWalls(MeshBuilder& builder, const Building& building, const Measures& m) {
  const double halfWidth = building.width / 2.0;
  const double width = building.width, depth = building.depth;
  const auto rows = rowEdges(building, m);
  const int frontBays = std::max(1, static_cast<int>(width / m.bay));
  const int sideBays = building.openSides ? std::max(1, static_cast<int>(depth / m.bay)) : 0;
  Facade sides[4];
  sides[0] = {{-halfWidth, 0, 0}, {1, 0, 0}, evenFields(width, frontBays, m.windowWidth), rows, building.wall, {}};
  sides[1] = {{halfWidth, 0, 0}, {0, 1, 0}, evenFields(depth, sideBays, m.windowWidth), rows, building.wall, {}};
  sides[2] = {{halfWidth, depth, 0}, {-1, 0, 0}, sides[0].columns, rows, building.wall, {}};
  sides[3] = {{-halfWidth, depth, 0}, {0, -1, 0}, sides[1].columns, rows, building.wall, {}};
  const int columns = static_cast<int>(sides[0].columns.size()) - 1;
  sides[0].opening = [&](int column, int row) { return frontOpening(building, column, row, columns); };
  for (int i = 1; i < 4; ++i)
    sides[i].opening = [&](int column, int row) { return plainOpening(building, column, row); };
  Loop top, bottom;
  for (const Facade& side : sides) {
    addFacade(builder, side);
    for (size_t c = 0; c + 1 < side.columns.size(); ++c) {
      bottom.push_back(side.at(side.columns[c], 0));
      top.push_back(side.at(side.columns[c], rows.back()));
    }
  }
  builder.fan(building.wall, Loop(bottom.rbegin(), bottom.rend()), {0, depth / 2, 0});
  return top;
}

void addBalcony(MeshBuilder& builder, double x, double z, double halfWidth) {
  constexpr double kOut = 1.3, kRail = 1.0;
  builder.box(Surface::concrete, {x - halfWidth, -kOut, z - 0.16}, {x + halfWidth, 0, z});
  const Vec3 corners[4] = {{x - halfWidth + 0.05, 0, z},
                           {x - halfWidth + 0.05, 0.05 - kOut, z},
                           {x + halfWidth - 0.05, 0.05 - kOut, z},
                           {x + halfWidth - 0.05, 0, z}};
  for (int i = 0; i < 3; ++i) {
    const Vec3 a = corners[i], b = corners[i + 1], up = {0, 0, kRail};
    const Vec3 low = {0, 0, kRail - 0.06};
    builder.quad(Surface::railing, a + low, b + low, b + up, a + up);
    const int bars = i == 1 ? 14 : 6;
    for (int k = 1; k < bars; ++k) {
      const Vec3 p = a + static_cast<double>(k) / bars * (b - a);
      const Vec3 half = 0.018 * normalized(b - a);
      builder.quad(Surface::railing, p - half, p + half, p + half + low, p - half + low);
    }
  }
}

void addBalconies(MeshBuilder& builder, const Building& building, const Measures& m) {
  const int bays = std::max(1, static_cast<int>(building.width / m.bay));
  const double bay = static_cast<double>(building.width) / bays;
  for (int floor = 1; floor < building.floors; ++floor)
    for (int i = 0; i < bays; ++i) {
      if ((i + building.style) % 2 != 0) continue;
      const double x = -building.width / 2.0 + (i + 0.5) * bay;
      addBalcony(builder, x, m.groundHeight + (floor - 1) * m.floorHeight + 0.1, bay * 0.45);
    }
}

void addShopFront(MeshBuilder& builder, const Building& building, const Measures& m) {
  const double halfWidth = building.width / 2.0 - 0.4;
  const double z = m.groundHeight - 0.55;
  if (building.style % 2 == 0)
    builder.quad(Surface::awning, {-halfWidth, -1.4, z - 0.35}, {halfWidth, -1.4, z - 0.35},
                 {halfWidth, -0.02, z + 0.15}, {-halfWidth, -0.02, z + 0.15});
  const Surface board = building.style % 3 == 0 ? Surface::paintBlue : Surface::paintYellow;
  builder.box(board, {-halfWidth * 0.6, -0.12, z + 0.2}, {halfWidth * 0.6, 0, z + 0.75});
}

/// Adds a square tower with a spire beside the nave of a church.
void addTower(MeshBuilder& builder, const Building& building, double eaves) {
  const double x0 = -building.width / 2.0 - 5.2, x1 = x0 + 5.4, y0 = 0.5, y1 = 5.9, top = eaves + 11;
  builder.box(building.wall, {x0, y0, 0}, {x1, y1, top});
  builder.box(Surface::concrete, {x0 - 0.2, y0 - 0.2, top - 0.4}, {x1 + 0.2, y1 + 0.2, top});
  const double x = (x0 + x1) / 2, y = (y0 + y1) / 2;
  builder.rod(building.cover, {x, y, top}, {x, y, top + 10}, 3.6, 0.05, 8);
  builder.rod(Surface::metalDark, {x, y, top + 9.9}, {x, y, top + 11.6}, 0.06, 0.06, 5);
  builder.box(Surface::metalDark, {x - 0.5, y - 0.05, top + 10.7}, {x + 0.5, y + 0.05, top + 10.82});
  for (int i = 0; i < 2; ++i)  // louvres of the bell chamber
    builder.box(Surface::wood, {x - 0.8, i == 0 ? y0 - 0.08 : y1 - 0.02, top - 3.6},
                {x + 0.8, i == 0 ? y0 + 0.02 : y1 + 0.08, top - 1.2});
}

std::string nameOf(BuildingKind kind) {
  switch (kind) {
    case BuildingKind::rowHouse: return "row house";
    case BuildingKind::apartments: return "apartments";
    case BuildingKind::office: return "office";
    case BuildingKind::shopHouse: return "shop house";
    case BuildingKind::house: return "house";
    case BuildingKind::hall: return "hall";
    case BuildingKind::church: return "church";
  }
  return {};
}

}  // namespace

Mesh buildingMesh(const Building& building) {
  MeshBuilder builder;
  const Measures m = measuresOf(building);
  const Loop eaves = addWalls(builder, building, m);
  switch (building.roof) {
    case RoofKind::flat: addFlatRoof(builder, building, eaves); break;
    case RoofKind::gable: addGableRoof(builder, building, eaves); break;
    case RoofKind::hip: addHipRoof(builder, building, eaves); break;
  }
  if (building.kind == BuildingKind::apartments) addBalconies(builder, building, m);
  if (building.kind == BuildingKind::shopHouse) addShopFront(builder, building, m);
  if (building.kind == BuildingKind::church) addTower(builder, building, eaves.front().z);
  return builder.finish(nameOf(building.kind));
}

}  // namespace gnosphere::town

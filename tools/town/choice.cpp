// SPDX-License-Identifier: Apache-2.0
#include "town/choice.hpp"

namespace gnosphere::town {
namespace {

Surface anyPaint(Dice& dice) {
  constexpr Surface kPaints[] = {Surface::paintWhite, Surface::paintSilver, Surface::paintSilver, Surface::paintBlack,
                                 Surface::paintBlack, Surface::paintRed,    Surface::paintBlue,   Surface::paintWhite};
  return kPaints[dice.below(8)];
}

}  // namespace

Surface anyWall(Dice& dice) {
  constexpr Surface kWalls[] = {Surface::brick, Surface::brickDark, Surface::plasterWhite, Surface::plasterSand,
                                Surface::plasterRose};
  return kWalls[dice.below(5)];
}

int anyRowWidth(Dice& dice) {
  constexpr int kWidths[] = {8, 10, 10, 12, 12, 14, 16};
  return kWidths[dice.below(7)];
}

Building anyRowBuilding(Dice& dice, int width, int depth, bool corner) {
  Building building;
  constexpr BuildingKind kKinds[] = {BuildingKind::rowHouse, BuildingKind::rowHouse, BuildingKind::apartments,
                                     BuildingKind::shopHouse};
  building.kind = kKinds[dice.below(4)];
  building.width = width;
  building.depth = depth;
  const bool low = building.kind == BuildingKind::rowHouse;
  building.floors = low ? 2 + dice.below(3) : 3 + dice.below(3);
  building.roof = building.kind == BuildingKind::apartments || dice.chance(25) ? RoofKind::flat : RoofKind::gable;
  building.wall = anyWall(dice);
  building.cover = dice.chance(70) ? Surface::roofTile : Surface::roofSlate;
  building.openSides = corner;
  building.style = dice.below(6);
  return building;
}

Building anyHouse(Dice& dice) {
  Building house;
  house.kind = BuildingKind::house;
  house.width = 9 + dice.below(3);
  house.depth = 8 + dice.below(2);
  house.floors = 1 + dice.below(2);
  house.roof = dice.chance(50) ? RoofKind::gable : RoofKind::hip;
  house.wall = anyWall(dice);
  house.cover = dice.chance(65) ? Surface::roofTile : Surface::roofSlate;
  house.style = dice.below(6);
  return house;
}

Tree anyTree(Dice& dice, const Detail& detail) {
  constexpr TreeKind kKinds[] = {TreeKind::broadleaf, TreeKind::broadleaf, TreeKind::conifer, TreeKind::broadleaf,
                                 TreeKind::poplar};
  const TreeKind kind = kKinds[dice.below(5)];
  return {kind, detail.treeLeaves, dice.below(6)};
}

Vehicle anyCar(Dice& dice, bool fine) {
  constexpr VehicleKind kKinds[] = {VehicleKind::hatchback, VehicleKind::saloon, VehicleKind::estate,
                                    VehicleKind::hatchback, VehicleKind::saloon, VehicleKind::van};
  const VehicleKind kind = kKinds[dice.below(6)];
  return {kind, kind == VehicleKind::van && dice.chance(70) ? Surface::paintWhite : anyPaint(dice), fine};
}

}  // namespace gnosphere::town

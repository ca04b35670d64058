// SPDX-License-Identifier: Apache-2.0
#include "town/roof.hpp"

#include <algorithm>

namespace gnosphere::town {
namespace {

constexpr double kOverhang = 0.45;
constexpr double kThickness = 0.2;

void addChimney(MeshBuilder& builder, double x, double y, double bottom, double top) {
  builder.box(Surface::brickDark, {x - 0.35, y - 0.3, bottom}, {x + 0.35, y + 0.3, top});
  builder.rod(Surface::metalDark, {x, y, top - 0.05}, {x, y, top + 0.35}, 0.12, 0.12, 6);
}

void addPlant(MeshBuilder& builder, const Building& building, double z) {
  Dice dice(building.style, building.width, building.depth, building.floors);
  const double halfWidth = building.width / 2.0 - 2.2, depth = building.depth;
  for (int i = 0, count = 1 + building.width / 9; i < count; ++i) {
    const double x = dice.between(-halfWidth, halfWidth), y = dice.between(2.4, depth - 2.4);
    const double size = dice.between(0.6, 1.1);
    builder.box(Surface::metal, {x - size, y - 0.6, z - 0.02}, {x + size, y + 0.6, z + dice.between(0.8, 1.5)});
  }
  if (building.floors >= 4)  // the top of the staircase
    builder.box(building.wall, {-1.6, depth - 5.2, z - 0.02}, {1.6, depth - 1.8, z + 2.5});
}

}  // namespace

void addFlatRoof(MeshBuilder& builder, const Building& building, const Loop& eaves) {
  constexpr double kParapet = 0.7, kWidth = 0.25;
  const double halfWidth = building.width / 2.0, depth = building.depth, z = eaves.front().z;
  Loop outer = eaves, inner, sunk;
  for (Vec3& p : outer) {
    p.z += kParapet;
    inner.push_back(
        {std::clamp(p.x, kWidth - halfWidth, halfWidth - kWidth), std::clamp(p.y, kWidth, depth - kWidth), p.z});
    sunk.push_back({inner.back().x, inner.back().y, z});
  }
  builder.band(building.wall, eaves, outer);
  builder.band(Surface::concrete, outer, inner);
  builder.band(building.wall, inner, sunk);
  builder.fan(Surface::roofFelt, sunk, {0, depth / 2, z});
  addPlant(builder, building, z);
}

void addGableRoof(MeshBuilder& builder, const Building& building, const Loop& eaves) {
  const double halfWidth = building.width / 2.0, depth = building.depth, z = eaves.front().z;
  const double slope = building.kind == BuildingKind::church ? 1.1 : building.kind == BuildingKind::hall ? 0.2 : 0.75;
  const double rise = slope * depth / 2;
  builder.fan(building.wall, eaves, {0, depth / 2, z});
  // The attic is a prism just inside the walls; the roof lies over it. Both loops are seen from the right end.
  const double right = halfWidth - 0.02;
  const Loop attic = {{right, 0.02, z - 0.05}, {right, depth - 0.02, z - 0.05}, {right, depth / 2, z + rise - 0.02}};
  builder.extrude(building.wall, building.wall, Loop(attic.rbegin(), attic.rend()), {-2 * right, 0, 0});
  const double end = halfWidth + (building.openSides ? kOverhang : 0);
  const double drop = slope * kOverhang;
  const std::vector<Vec3> under = {
      {end, -kOverhang, z - drop}, {end, depth / 2, z + rise}, {end, depth + kOverhang, z - drop}};
  const Vec3 up = {0, 0, kThickness}, along = {-2 * end, 0, 0};
  const auto slab = [&](const Vec3& low, const Vec3& high) {  // one half of the chevron
    builder.extrude(building.cover, building.cover, {low, low + up, high + up, high}, along);
  };
  slab(under[0], under[1]);
  builder.extrude(building.cover, building.cover, {under[1], under[1] + up, under[2] + up, under[2]}, along);
  if (building.kind != BuildingKind::hall && building.kind != BuildingKind::church)
    addChimney(builder, halfWidth * 0.55, depth * 0.62, z, z + rise + 0.8);
}

void addHipRoof(MeshBuilder& builder, const Building& building, const Loop& eaves) {
  const double depth = building.depth, z = eaves.front().z;
  const double halfWidth = building.width / 2.0 + kOverhang;
  const double low = -kOverhang, high = depth + kOverhang;
  const double run = (high - low) / 2, top = z + 0.6 * run;
  const double halfRidge = std::max(halfWidth - run, 0.2);
  builder.fan(building.wall, eaves, {0, depth / 2, z});
  const Loop base = {{-halfWidth, low, z - 0.02},
                     {halfWidth, low, z - 0.02},
                     {halfWidth, high, z - 0.02},
                     {-halfWidth, high, z - 0.02}};
  Loop rim = base;
  for (Vec3& p : rim) p.z += kThickness;
  const Vec3 left = {-halfRidge, depth / 2, top}, right = {halfRidge, depth / 2, top};
  builder.face(building.cover, Loop(base.rbegin(), base.rend()));
  builder.band(building.cover, base, rim);
  builder.quad(building.cover, rim[0], rim[1], right, left);
  builder.quad(building.cover, rim[2], rim[3], left, right);
  builder.triangle(building.cover, rim[1], rim[2], right);
  builder.triangle(building.cover, rim[3], rim[0], left);
  addChimney(builder, halfRidge, depth * 0.6, z, top + 0.7);
}

}  // namespace gnosphere::town

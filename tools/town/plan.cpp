// SPDX-License-Identifier: Apache-2.0
#include "town/plan.hpp"

#include <algorithm>
#include <cmath>

namespace gnosphere::town {
namespace {

struct MeshOf {
  Mesh operator()(const Road& road) const { return roadMesh(road); }
  Mesh operator()(const Crossing& crossing) const { return crossingMesh(crossing); }
  Mesh operator()(const Block& block) const { return blockMesh(block); }
  Mesh operator()(const Building& building) const { return buildingMesh(building); }
  Mesh operator()(const Tree& tree) const { return treeMesh(tree); }
  Mesh operator()(const Vehicle& vehicle) const { return vehicleMesh(vehicle); }
  Mesh operator()(const Prop& prop) const { return propMesh(prop); }
  Mesh operator()(const Piece&) const { throw std::bad_variant_access(); }
};

}  // namespace

Mesh meshOf(const Thing& thing) {
  return std::visit(MeshOf{}, thing);
}

Mesh Plan::meshOf(const Thing& thing) const {
  const Piece* piece = std::get_if<Piece>(&thing);
  return piece ? pieces[piece->index] : town::meshOf(thing);
}

void Plan::add(const Thing& thing, const Vec3& at, double turns, double scale) {
  const double ahead = std::holds_alternative<Building>(thing) ? 10 : 0;  // houses come before the objects around them
  placements.push_back(
      {thing, place(at, turns, scale), blendedReach(std::max(std::abs(at.x), std::abs(at.y)) - ahead, blockReach)});
}

void Plan::addGround(const Thing& thing, const Vec3& at, double turns, const Vec3& min, const Vec3& max) {
  constexpr double kAhead = 12;  // metres by which ground comes before the first object on it
  const double nearX = std::max({0.0, min.x, -max.x}), nearY = std::max({0.0, min.y, -max.y});
  placements.push_back(
      {thing, place(at, turns), blendedReach(std::max(0.0, std::max(nearX, nearY) - kAhead), blockReach)});
}

}  // namespace gnosphere::town

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "town/opendrive/road_mesh.hpp"
#include "town/plan.hpp"

namespace gnosphere::town::opendrive {

/// The ground between the roads: a grid of heights, slightly below every road on it and smooth in between. Its border
/// is level, at z = 0.
class Terrain {
 public:
  Terrain(const Network& network, const Area& area);
  double at(double x, double y) const;
  std::vector<GroundPiece> tiles() const;  ///< of 16 x 16 cells

 private:
  size_t node(size_t i, size_t j) const { return j * (columns_ + 1) + i; }
  void pin(size_t i, size_t j, double height);
  void pinBorder();
  void pinUnder(const Road& road);
  void stretch();

  Area area_;
  size_t columns_, rows_;  ///< cells in each direction
  double stepX_, stepY_;
  std::vector<double> heights_;
  std::vector<bool> pinned_;
};

/// Marks occupied ground, in squares of about half a metre.
class Occupancy {
 public:
  enum Use : uint8_t { nothing, road, thing };

  Occupancy(const Network& network, const Area& area);
  /// The rectangle around `at`, whose first side has the direction `x` (a unit vector).
  bool isFree(const Vec3& at, const Vec3& x, double halfLength, double halfWidth) const;
  void take(const Vec3& at, const Vec3& x, double halfLength, double halfWidth);

 private:
  template <typename Visit>
  void visit(const Vec3& at, const Vec3& x, double halfLength, double halfWidth, Visit&& visit) const;
  size_t cell(double x, double y) const;

  Area area_;
  double step_;
  size_t columns_, rows_;
  std::vector<Use> uses_;
};

}  // namespace gnosphere::town::opendrive

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include "town/mesh_builder.hpp"

namespace gnosphere::town {

/// The content of one field of a facade.
enum class Opening : uint8_t { none, window, shuttered, door, display };

/// A vertical wall divided into fields. Rows and columns are distances along the wall and heights; openings are
/// recessed, and neighbouring fields with the same opening merge.
struct Facade {
  Vec3 corner;  ///< lower left, seen from outside
  Vec3 along;   ///< unit vector to the right, seen from outside
  std::vector<double> columns;
  std::vector<double> rows;
  Surface wall = Surface::brick;
  std::function<Opening(int column, int row)> opening;

  Vec3 at(double column, double row, double depth = 0) const;
};

void addFacade(MeshBuilder& builder, const Facade& facade);

/// Returns the edges of `count` openings of equal width along a length: 0, left, right, left, right, ..., length. The
/// fields with odd index are openings.
std::vector<double> evenFields(double length, int count, double width);

}  // namespace gnosphere::town

// SPDX-License-Identifier: Apache-2.0
// Origins for meshes whose files state positions as doubles, so that georeferenced files keep their millimetres.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "gnosphere/scene.hpp"

namespace gnosphere {

/// The box around corners of triangles. Corners that are not finite, or beyond 1e12, are errors and no places, so they
/// are outside.
struct CornerBox {
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();
  std::array<double, 3> low = {kInfinity, kInfinity, kInfinity}, high = {-kInfinity, -kInfinity, -kInfinity};
  bool isExact = true;  ///< whether floats hold every coordinate

  /// Adds the vertices that these indices name, out of coordinates x y z.
  void add(std::span<const uint32_t> indices, std::span<const double> coordinates);
  void add(const CornerBox& other);
};

/// Returns the origins of a file's meshes, of which each has a box. The origins are 0 if floats hold every coordinate
/// exactly. Else all meshes have the centre of all boxes, rounded to a unit, so that meshes which touch have the same
/// positions. A mesh that is so far from it that floats are 2 mm apart gets the centre of its own box, rounded to 1024
/// m because neighbours mostly share it then. `unit` is the length of the file's unit in metres.
std::vector<Vec3> originsOf(std::span<const CornerBox> boxes, double unit);

/// Appends one of the coordinates' vertices to the positions of a mesh, relative to its origin.
void appendPosition(Mesh& mesh, std::span<const double> coordinates, size_t vertex);

/// Sets the origin of the only mesh of a file, which has its indices, and its positions from doubles x y z.
void storePositions(Mesh& mesh, std::span<const double> coordinates);

}  // namespace gnosphere

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>
#include <unordered_map>
#include <vector>

#include "town/geometry.hpp"
#include "town/surfaces.hpp"

namespace gnosphere::town {

using Loop = std::vector<Vec3>;

/// A circle in a plane of constant z, counter-clockwise from above.
Loop circle(const Vec3& centre, double radius, int segments, double turns = 0);

/// Collects triangles, merges equal vertices and returns a Mesh with one part per surface. Solids are closed; their
/// faces are counter-clockwise seen from outside.
class MeshBuilder {
 public:
  void triangle(Surface surface, const Vec3& a, const Vec3& b, const Vec3& c);
  void quad(Surface surface, const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);
  /// Joins two loops of equal size by quads.
  void band(Surface surface, const Loop& outer, const Loop& inner);
  /// Adds a flat face: a convex loop around a point inside it.
  void fan(Surface surface, const Loop& loop, const Vec3& centre);
  /// Adds a flat face: a convex loop without collinear corners.
  void face(Surface surface, const Loop& loop);

  void box(Surface surface, const Vec3& min, const Vec3& max);
  /// Joins rings of equal size, each counter-clockwise seen from the next; both ends are closed.
  void loft(Surface side, Surface cap, const std::vector<Loop>& rings);
  /// Extrudes a loop (counter-clockwise seen against `along`) along a vector.
  void extrude(Surface side, Surface cap, const Loop& loop, const Vec3& along);
  /// Adds a round rod from one point to another.
  void rod(Surface surface, const Vec3& from, const Vec3& to, double radiusFrom, double radiusTo, int segments);
  void ellipsoid(Surface surface, const Vec3& centre, const Vec3& radii, int segments, int rings);

  size_t triangleCount() const;
  Mesh finish(std::string name) const;

 private:
  struct Corner {
    std::array<float, 3> at;
    bool operator==(const Corner&) const = default;
  };
  struct CornerHash {
    size_t operator()(const Corner& corner) const;
  };
  uint32_t vertex(const Vec3& p);

  std::vector<float> positions_;
  std::unordered_map<Corner, uint32_t, CornerHash> known_;
  std::array<std::vector<uint32_t>, static_cast<size_t>(Surface::count)> indices_;
};

}  // namespace gnosphere::town

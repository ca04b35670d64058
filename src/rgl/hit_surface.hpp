// SPDX-License-Identifier: Apache-2.0
// A triangle that a ray has hit, as the fields of points need it.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "rgl/math.hpp"
#include "rgl/scene.hpp"

namespace gnosphere::rgl {

/// A triangle that was hit, in the world.
struct HitSurface {
  const EntityObject* entity = nullptr;
  uint32_t triangle = 0;
  Vec corners[3];

  /// Normal to the triangle by the right-hand rule, as long as twice its area; in double, for distances and angles.
  Vec3 areaNormal() const {
    const auto& [a, b, c] = corners;
    const Vec3 u{double{b.x} - a.x, double{b.y} - a.y, double{b.z} - a.z};
    const Vec3 v{double{c.x} - a.x, double{c.y} - a.y, double{c.z} - a.z};
    return {u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x};
  }
  Vec3 normal() const {
    const Vec3 n = areaNormal();
    const double norm = std::sqrt(n.x * n.x + n.y * n.y + n.z * n.z);
    return {n.x / norm, n.y / norm, n.z / norm};
  }
  /// Cosine of the angle between the normal and a direction, never negative.
  double incidence(const Vec& direction) const {
    const Vec3 n = normal();
    return std::abs(n.x * direction.x + n.y * direction.y + n.z * direction.z);
  }
};

/// The weights of a triangle's corners at a point of its plane.
inline std::array<float, 3> weightsAt(const HitSurface& surface, const Vec& at) {
  const auto& [a, b, c] = surface.corners;
  const Vec n = cross(b - a, c - a), w = at - a;
  const double square = double{n.x} * n.x + double{n.y} * n.y + double{n.z} * n.z;
  if (square == 0) return {1, 0, 0};
  const auto second = static_cast<float>(dot(n, cross(w, c - a)) / square);
  const auto third = static_cast<float>(dot(n, cross(b - a, w)) / square);
  return {1 - second - third, second, third};
}

}  // namespace gnosphere::rgl

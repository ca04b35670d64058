// SPDX-License-Identifier: Apache-2.0
// Intersects one beam with one triangle in double: the inside test has the exact sign, the range is a convex
// combination.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

#include "base/quaternion.hpp"
#include "base/vector.hpp"
#include "gnosphere/scan.hpp"

namespace gnosphere::reference {

/// A total order of points. Any order will do that is the same for all triangles that share a corner.
inline bool before(const Vec3& a, const Vec3& b) {
  if (a.x != b.x) return a.x < b.x;
  if (a.y != b.y) return a.y < b.y;
  return a.z < b.z;
}

/// A pose as a matrix. Positions are subtracted before anything is rotated, so that a world far from its origin adds
/// only the rounding error of its own coordinates.
struct SensorFrame {
  explicit SensorFrame(const Pose& pose) : position(pose.position) {
    const Quaternion q = withUsableLength(pose.orientation);
    const double s = 2 / (q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);  // Shoemake 1985; also normalises
    axes[0] = {1 - s * (q.y * q.y + q.z * q.z), s * (q.x * q.y + q.w * q.z), s * (q.x * q.z - q.w * q.y)};
    axes[1] = {s * (q.x * q.y - q.w * q.z), 1 - s * (q.x * q.x + q.z * q.z), s * (q.y * q.z + q.w * q.x)};
    axes[2] = {s * (q.x * q.z + q.w * q.y), s * (q.y * q.z - q.w * q.x), 1 - s * (q.x * q.x + q.y * q.y)};
  }
  Vec3 toSensor(const Vec3& world) const {
    const Vec3 p = world - position;
    return {dot(axes[0], p), dot(axes[1], p), dot(axes[2], p)};
  }
  Vec3 directionToWorld(const Vec3& d) const { return d.x * axes[0] + d.y * axes[1] + d.z * axes[2]; }

  Vec3 position;
  Vec3 axes[3];  ///< of the sensor, in the world
};

/// A triangle in the world. Its corners are sorted by before(): every triangle then walks a shared edge in the same
/// direction, and any rotation of its indices gives the same bits.
struct Triangle {
  Vec3 corners[3];
  uint32_t instance = 0;
  uint32_t index = 0;  ///< within the instance's mesh
  int8_t front = 0;    ///< sign of normal . direction for a beam that hits the reflecting side; 0: both sides reflect
  uint8_t order[3] = {0, 1, 2};  ///< index of each corner in the mesh's triangle
  uint32_t sweep = kStill;       ///< entry of Sweeps::velocities
  static constexpr uint32_t kStill = 0xffffffffu;
};

/// x * y - product without loss, where product is x * y rounded (Dekker 1971). std::fma would do, but the C library of
/// MinGW rounds it twice.
inline double lostOf(double x, double y, double product) {
  const auto halves = [](double value) {
    const double scaled = 134217729 * value;  // 2^27 + 1
    const double high = scaled - (scaled - value);
    return std::pair(high, value - high);
  };
  const auto [a, b] = halves(x);
  const auto [c, d] = halves(y);
  return ((a * c - product) + a * d + b * c) + b * d;
}

/// d . (a x b), rounded only at the end, so that its sign is exact. The product is positive if the edge a -> b passes
/// the direction d counter-clockwise, seen against d. The 24 parts of the six products are summed without loss
/// (two-term products and grow-expansion of Shewchuk 1997, Adaptive Precision Floating-Point Arithmetic).
inline double edgeExact(const Vec3& d, const Vec3& a, const Vec3& b) {
  std::array<double, 24> parts = {};
  size_t count = 0;
  const auto add = [&](double value) {
    for (size_t i = 0; i < count; ++i) {
      const double sum = value + parts[i];
      const double taken = sum - value;
      parts[i] = (value - (sum - taken)) + (parts[i] - taken);
      value = sum;
    }
    parts[count++] = value;
  };
  const auto addProduct = [&](double x, double y, double z) {
    const double high = x * y;
    for (double part : {lostOf(x, y, high), high}) {
      const double product = part * z;
      add(lostOf(part, z, product));
      add(product);
    }
  };
  addProduct(d.x, a.y, b.z);
  addProduct(-d.x, a.z, b.y);
  addProduct(d.y, a.z, b.x);
  addProduct(-d.y, a.x, b.z);
  addProduct(d.z, a.x, b.y);
  addProduct(-d.z, a.y, b.x);
  double value = 0;  // parts do not overlap and grow in size, so the last non-zero one has the sign
  for (double part : parts) value += part;
  return value;
}

/// As edgeExact(), but in plain double if its error bound decides the sign. As b is first made relative to a, the error
/// is below 6 * 2^-53 of the sum of absolute products (Shewchuk's "A" bound for one subtraction, two products, a
/// difference and a sum of three); the factor 8 leaves a margin.
inline double edge(const Vec3& d, const Vec3& a, const Vec3& b) {
  constexpr double kBound = 8 * 0x1p-53;
  const Vec3 e = b - a;
  const double value = d.x * (a.y * e.z - a.z * e.y) + d.y * (a.z * e.x - a.x * e.z) + d.z * (a.x * e.y - a.y * e.x);
  const double size = std::abs(d.x) * (std::abs(a.y * e.z) + std::abs(a.z * e.y)) +
                      std::abs(d.y) * (std::abs(a.z * e.x) + std::abs(a.x * e.z)) +
                      std::abs(d.z) * (std::abs(a.x * e.y) + std::abs(a.y * e.x));
  return std::abs(value) > kBound * size ? value : edgeExact(d, a, b);
}

/// The intersection of a beam's line with a triangle's plane.
struct Pierce {
  bool inside = false;
  double range = 0;                    ///< along the beam; negative behind the sensor
  double facing = 0;                   ///< normal . direction, not normalised; the normal is that of corners 0, 1, 2
  std::array<double, 3> weights = {};  ///< barycentric coordinates
};

/// Corners are in the sensor frame, ordered as in Triangle. Points on an edge or a corner are inside, so no beam slips
/// between triangles that share an edge. A triangle seen exactly edge-on is never hit.
/// The depth is the mean of the corners' depths, weighted by the doubled areas of the triangle's three parts seen along
/// the beam (barycentric coordinates; Moller and Trumbore 1997 in homogeneous form), so the range cannot leave the
/// triangle's depth interval.
inline Pierce pierce(const Vec3& d, const Vec3& a, const Vec3& b, const Vec3& c) {
  const double ab = edge(d, a, b);
  const double bc = edge(d, b, c);
  if ((ab < 0 && bc > 0) || (ab > 0 && bc < 0)) return {};
  const double ca = -edge(d, a, c);
  const bool inside = (ab >= 0 && bc >= 0 && ca >= 0) || (ab <= 0 && bc <= 0 && ca <= 0);
  const double area = ab + bc + ca;
  if (!inside || area == 0) return {};
  return {true, (bc * dot(a, d) + ca * dot(b, d) + ab * dot(c, d)) / area, area, {bc / area, ca / area, ab / area}};
}

}  // namespace gnosphere::reference

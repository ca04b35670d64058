// SPDX-License-Identifier: Apache-2.0
// Defines ties and tolerances: how a single-precision simulator may deviate on one beam and one triangle.
//
// The model: let u = 2^-24, the unit roundoff of single precision. A correct simulator sees corner i at most
//   d_i = 16 u c |v_i| + f            metres from its true place v_i in the sensor frame, and
// the beam turned by at most 2 u radians, so that in the plane across the beam a corner at depth z_i = v_i . direction
// is displaced by at most
//   r_i = d_i + 2 u z_i.
// 16 u is the worst case of: x - pivot, a rounded 3x3 matrix, three products and three sums (6 u of the sum of absolute
// products, which is at most sqrt(3) |v| for a rotation: 10 u), and the turn of the corner into the beam's frame by two
// plane rotations (6 u on top of the 2 u that belong to the beam). c >= 1 is the condition of the instance's matrix and
// f the part of the error that does not shrink with the distance: PlacedMesh::condition and absoluteError() of
// world.hpp.
//
// All else follows, without another constant, from asking what the triangle could be with its corners moved that far.
// Moving corners by r_i and asking for the origin is the same as asking for the points Q of the unmoved triangle with
// |Q| <= r(Q), r interpolated between the corners:
// - *near*: the beam is within r of an edge, in or out: some Q on the edge has |Q| <= r(Q). A triangle seen so edge-on
//   that its height H is below r is near wherever it could be hit.
// - *facing in doubt*: corners moved by r can turn the triangle over: H <= 2 max r.
// - *depth*: the range of the moved triangle is the depth of a point Q, so within G r + d of the range t of the plane,
//   where G = |gradient of the depth across the beam| = cot(grazing angle), and in any case within the triangle's own
//   depth interval, widened by max d. For H > 4 max r the first bound holds with r, d taken on the beam and divided by
//   1 - 2 max r / H; for thinner triangles only the interval is promised.
// - *arithmetic*: the weighted mean of depths adds 4 u (|z_i| weighted, and |P_i||P_j||z_k - t| / doubled area, the
//   rounding of the edge products); it stays in the depth interval too.
#pragma once

#include <algorithm>

#include "reference/hit.hpp"
#include "sensor/beams.hpp"

namespace gnosphere::reference {

inline constexpr double kUnitRoundoff = 0x1p-24;
inline constexpr double kCornerError = 16 * kUnitRoundoff;     ///< relative to the corner's distance
inline constexpr double kDirectionError = 2 * kUnitRoundoff;   ///< radians
inline constexpr double kArithmeticError = 4 * kUnitRoundoff;  ///< relative to the terms of the weighted mean

/// Error of a corner's position in a single-precision simulator: `relative` times its distance plus `absolute` metres.
struct CornerError {
  double relative = kCornerError;
  double absolute = 0;
};

/// Two unit vectors perpendicular to a direction.
struct Across {
  explicit Across(const Vec3& direction) : d(direction) {
    const Vec3 other = std::abs(d.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
    const Vec3 n = cross(d, other);
    u = (1 / lengthOf(n)) * n;
    v = cross(d, u);
  }
  Vec3 d, u, v;
};

/// The ranges that a single-precision simulator may report for this beam and triangle.
struct Doubt {
  bool possible = false;  ///< it may report a hit
  bool certain = false;   ///< it must report a hit
  double nearest = 0;     ///< the least range that it may report
  double farthest = 0;
};

/// A corner in coordinates along and across the beam.
struct SeenCorner {
  double x, y;      ///< across the beam
  double depth;     ///< along the beam
  double place;     ///< d_i: error of its position
  double distance;  ///< from the beam
  double reach;     ///< r_i: error of its position across the beam
};

inline double cross(const SeenCorner& a, const SeenCorner& b) {
  return a.x * b.y - a.y * b.x;
}

/// Returns whether a point Q of the edge is closer to the beam than its error. With Q = a + s (b - a), |Q|^2 - r(Q)^2
/// is a parabola in s; its minimum is tested if it lies on the edge, besides the ends.
inline bool near(const SeenCorner& a, const SeenCorner& b) {
  if (a.distance <= a.reach || b.distance <= b.reach) return true;
  const double x = b.x - a.x, y = b.y - a.y, r = b.reach - a.reach;
  const double square = x * x + y * y - r * r;
  const double slope = a.x * x + a.y * y - a.reach * r;
  if (!(square > 0) || slope >= 0 || -slope >= square) return false;
  const double s = -slope / square;
  return lengthOf(a.x + s * x, a.y + s * y) <= a.reach + s * r;
}

/// Bounds the ranges: by the triangle's plane if it is wide enough, and always by the depths of its corners.
inline void depths(const SeenCorner (&c)[3], double area, double thinness, Doubt& doubt) {
  const double place = std::max({c[0].place, c[1].place, c[2].place});
  doubt.nearest = std::min({c[0].depth, c[1].depth, c[2].depth}) - place;
  doubt.farthest = std::max({c[0].depth, c[1].depth, c[2].depth}) + place;
  if (!(thinness < 0.5)) return;
  double range = 0, reach = 0, error = 0, size = 0;
  for (int k = 0; k < 3; ++k) {
    const double weight = cross(c[(k + 1) % 3], c[(k + 2) % 3]) / area;
    range += weight * c[k].depth;
    reach += std::abs(weight) * c[k].reach;
    error += std::abs(weight) * c[k].place;
    size += std::abs(weight * c[k].depth);
  }
  for (int k = 0; k < 3; ++k)
    size += c[(k + 1) % 3].distance * c[(k + 2) % 3].distance * std::abs((c[k].depth - range) / area);
  const double x1 = c[1].x - c[0].x, y1 = c[1].y - c[0].y, z1 = c[1].depth - c[0].depth;
  const double x2 = c[2].x - c[0].x, y2 = c[2].y - c[0].y, z2 = c[2].depth - c[0].depth;
  const double gradient = lengthOf(y1 * z2 - z1 * y2, z1 * x2 - x1 * z2) / std::abs(area);
  const double spread = (gradient * reach + error) / (1 - thinness) + kArithmeticError * size;
  doubt.nearest = std::max(doubt.nearest, range - spread);
  doubt.farthest = std::min(doubt.farthest, range + spread);
}

/// `corners` are in the sensor frame; `front` is Triangle::front.
inline Doubt doubtOf(const Across& beam, const Vec3 (&corners)[3], int front, const CornerError& error,
                     const RangeWindow& window) {
  SeenCorner c[3];
  for (int k = 0; k < 3; ++k) {
    const Vec3& v = corners[k];
    c[k].x = dot(beam.u, v);
    c[k].y = dot(beam.v, v);
    c[k].depth = dot(beam.d, v);
    c[k].place = error.relative * lengthOf(v) + error.absolute;
    c[k].reach = c[k].place + kDirectionError * c[k].depth;
  }
  // Most triangles are clearly beside the beam.
  const double reach = std::max({c[0].reach, c[1].reach, c[2].reach});
  const auto beside = [&](double x0, double x1, double x2) {
    return std::min({x0, x1, x2}) > 2 * reach || std::max({x0, x1, x2}) < -2 * reach;
  };
  if (beside(c[0].x, c[1].x, c[2].x) || beside(c[0].y, c[1].y, c[2].y)) return {};
  for (SeenCorner& corner : c) corner.distance = lengthOf(corner.x, corner.y);
  const double ab = cross(c[0], c[1]), bc = cross(c[1], c[2]), ca = cross(c[2], c[0]);
  const bool inside = (ab > 0 && bc > 0 && ca > 0) || (ab < 0 && bc < 0 && ca < 0);
  const bool edgy = near(c[0], c[1]) || near(c[1], c[2]) || near(c[2], c[0]);
  if (!inside && !edgy) return {};

  const double area = ab + bc + ca;
  const double longest =
      std::max({lengthOf(c[1].x - c[0].x, c[1].y - c[0].y), lengthOf(c[2].x - c[1].x, c[2].y - c[1].y),
                lengthOf(c[0].x - c[2].x, c[0].y - c[2].y)});
  const double thinness = 2 * reach * longest / std::abs(area);  // 2 max r / H; infinite where edge-on
  const bool turns = front != 0 && !(thinness < 1);
  if (front != 0 && !turns && (area > 0) != (front > 0)) return {};

  Doubt doubt;
  depths(c, area, thinness, doubt);
  doubt.possible = doubt.farthest > 0 && doubt.farthest >= window.least && doubt.nearest <= window.most;
  doubt.certain =
      inside && !edgy && !turns && doubt.nearest > 0 && doubt.nearest >= window.least && doubt.farthest <= window.most;
  return doubt;
}

}  // namespace gnosphere::reference

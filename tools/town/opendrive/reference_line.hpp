// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "town/geometry.hpp"

namespace gnosphere::town::opendrive {

/// a + b ds + c ds^2 + d ds^3 with ds = s - start; applies from `start` on.
struct Cubic {
  double start = 0;
  double a = 0, b = 0, c = 0, d = 0;
};

/// Cubics sorted by their starts, each valid up to the next one; 0 before the first.
using Profile = std::vector<Cubic>;

double valueAt(const Profile& profile, double s);
double slopeAt(const Profile& profile, double s);  ///< its derivative

/// A point of a plane curve and the unit vector along it. z is 0.
struct CurvePoint {
  Vec3 at, along;
};

enum class Shape : uint8_t { line, arc, spiral, poly3, paramPoly3 };

/// One <geometry> of a plan view (ASAM OpenDRIVE 1.8, section 9.3).
struct Geometry {
  Shape shape = Shape::line;
  double s = 0, length = 0;  ///< where it starts on the road's reference line, and its length, in metres
  Vec3 start;
  double heading = 0;                              ///< radians
  double curvature = 0, curvatureAtEnd = 0;        ///< 1/m; they differ only in spirals (clothoids)
  std::array<double, 4> u = {0, 1, 0, 0}, v = {};  ///< coefficients of poly3 (v over u) and paramPoly3 (u and v over p)
  double parameterRange = 0;                       ///< p at the end of a paramPoly3: its length, or 1

  /// Returns the point `ds` metres along it.
  CurvePoint at(double ds) const;
};

}  // namespace gnosphere::town::opendrive

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <filesystem>

#include "town/opendrive/reference_line.hpp"

namespace gnosphere::test {

inline const std::filesystem::path kJunction = std::filesystem::path(GNOSPHERE_TEST_DATA) / "junction.xodr";

inline double distance(const Vec3& a, const Vec3& b) {
  return std::hypot(a.x - b.x, a.y - b.y, a.z - b.z);
}

inline town::opendrive::Geometry curve(town::opendrive::Shape shape, double length, double from = 0, double to = 0) {
  town::opendrive::Geometry geometry;
  geometry.shape = shape;
  geometry.length = length;
  geometry.curvature = from;
  geometry.curvatureAtEnd = to;
  return geometry;
}

}  // namespace gnosphere::test

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <filesystem>
#include <string>

#include "folder.hpp"
#include "town/opendrive/reference_line.hpp"

namespace gnosphere::test {

inline const std::filesystem::path kJunction = std::filesystem::path(GNOSPHERE_TEST_DATA) / "junction.xodr";

/// A file of a network in a folder of its own, which the destructor removes.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::string& text) : path(put(folder_ / "network.xodr", text)) {}

 private:
  Folder folder_;

 public:
  const fs::path path;
};

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

// SPDX-License-Identifier: Apache-2.0
// Where the nearest hits of beams are written.
#pragma once

#include "gnosphere/scan.hpp"

namespace gnosphere {

/// The addresses of the arrays that every scan has, with an entry per beam; null for arrays that nobody wants.
struct Places {
  float* points = nullptr;  ///< three per entry
  float* ranges = nullptr;
  uint32_t* triangles = nullptr;
  uint32_t* instances = nullptr;

  /// Returns the places from an entry on.
  Places from(size_t entry) const {
    const auto moved = [entry](auto* array, size_t each) { return array ? array + each * entry : nullptr; };
    return {moved(points, 3), moved(ranges, 1), moved(triangles, 1), moved(instances, 1)};
  }
};

/// Returns the arrays of a scan; those that are empty are not wanted.
inline Places placesOf(Scan& scan) {
  const auto of = [](auto& array) { return array.empty() ? nullptr : array.data(); };
  return {of(scan.points), of(scan.ranges), of(scan.triangles), of(scan.instances)};
}

}  // namespace gnosphere

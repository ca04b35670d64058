// SPDX-License-Identifier: Apache-2.0
// Divides boxes into runs of neighbours by the surface area heuristic, as the builders of ray tracing's trees do:
// a beam meets a box with a probability in proportion to its surface.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace gnosphere {

/// An axis-aligned box. A new one contains no point.
struct BoundingBox {
  float low[3] = {kLargest, kLargest, kLargest}, high[3] = {-kLargest, -kLargest, -kLargest};

  void add(const float* point) { enclose(point, point); }
  void add(const BoundingBox& other) { enclose(other.low, other.high); }
  /// Half the surface.
  float halfArea() const;

 private:
  static constexpr float kLargest = std::numeric_limits<float>::max();
  void enclose(const float* least, const float* most);
};

/// A permutation of boxes, cut into runs.
struct Partition {
  std::vector<uint32_t> order;  ///< indices of boxes, run after run
  std::vector<size_t> ends;     ///< where each run ends in `order`
};

/// Divides boxes into runs of at most `most`. `runCost` says how much work a run is for a beam that meets its box,
/// besides that for the boxes in it, each of which is 1.
Partition partition(std::span<const BoundingBox> boxes, size_t most, float runCost);

}  // namespace gnosphere

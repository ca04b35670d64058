// SPDX-License-Identifier: Apache-2.0
// Divides boxes into runs of neighbours by the surface area heuristic, as builders of bounding volume hierarchies do:
// the probability that a beam meets a box is in proportion to the surface of the box.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace gnosphere {

/// A bounding box along the axes. A new box contains no point.
struct BoundingBox {
  float low[3] = {kLargest, kLargest, kLargest}, high[3] = {-kLargest, -kLargest, -kLargest};

  void add(const float* point) { enclose(point, point); }
  void add(const BoundingBox& other) { enclose(other.low, other.high); }
  /// Half the surface area of the box.
  float halfArea() const;

 private:
  static constexpr float kLargest = std::numeric_limits<float>::max();
  void enclose(const float* least, const float* most);
};

/// An item with its box.
struct Boxed {
  BoundingBox box;
  uint32_t index = 0;  ///< the caller's number of the item
};

/// Items in an order in which those of a run are neighbours.
struct Partition {
  std::vector<Boxed> items;
  std::vector<size_t> ends;  ///< where each run ends in `items`
};

/// Divides items into runs of at most `most` items. A beam that meets the box of a run takes the work `runCost`, and 1
/// for each item of the run.
Partition partition(std::vector<Boxed> items, size_t most, float runCost);

}  // namespace gnosphere

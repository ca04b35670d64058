// SPDX-License-Identifier: Apache-2.0
// Divides what has a box into runs of neighbours by the surface area heuristic, as the builders of ray tracing's trees
// do: a beam meets a box with a probability in proportion to its surface.
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

/// An item that is divided, with its box.
struct Boxed {
  BoundingBox box;
  uint32_t index = 0;  ///< says what it is; of no meaning here
};

/// Items in an order in which those of a run are neighbours.
struct Partition {
  std::vector<Boxed> items;
  std::vector<size_t> ends;  ///< where each run ends in `items`
};

/// Divides items into runs of at most `most`. `runCost` says how much work a run is for a beam that meets its box,
/// besides that for the items in it, each of which is 1.
Partition partition(std::vector<Boxed> items, size_t most, float runCost);

}  // namespace gnosphere

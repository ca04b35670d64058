// SPDX-License-Identifier: Apache-2.0
#include "geometry/partition.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <utility>

namespace gnosphere {
namespace {

// Many boxes are divided between two of this many bins of equal width, after Wald, "On fast construction of SAH-based
// bounding volume hierarchies" (2007).
constexpr size_t kBins = 16;
// Fewer boxes than this are sorted, and divided at the best of all places.
constexpr size_t kFew = 64;
// Below this depth boxes are halved, so that no scene makes the recursion deep.
constexpr int kDeepest = 64;

float centre(const BoundingBox& box, int axis) {
  return 0.5f * box.low[axis] + 0.5f * box.high[axis];
}

struct Bin {
  BoundingBox box;
  size_t count = 0;

  void add(const Bin& other) {
    box.add(other.box);
    count += other.count;
  }
};

/// A place to divide boxes: before a bin or before a position, along an axis.
struct Split {
  float cost = std::numeric_limits<float>::infinity();
  int axis = -1;  // none was found
  size_t at = 0;
};

class Partitioner {
 public:
  Partitioner(std::vector<Boxed> items, size_t most, float runCost)
      : most_(most), runCost_(runCost), items_(std::move(items)) {}

  Partition run() {
    if (!items_.empty()) divide(0, items_.size(), 0);
    return {std::move(items_), std::move(ends_)};
  }

 private:
  // The work for a beam that comes near boxes, if they fill as few runs as possible.
  float cost(const BoundingBox& box, size_t count) const {
    const size_t runs = (count + most_ - 1) / most_;
    return box.halfArea() * (runCost_ * static_cast<float>(runs) + static_cast<float>(count));
  }

  void divide(size_t first, size_t end, int depth) {
    if (end - first <= most_) {
      ends_.push_back(end);
      return;
    }
    const std::span<Boxed> items = std::span(items_).subspan(first, end - first);
    const size_t middle = first + (depth == kDeepest      ? items.size() / 2
                                   : items.size() <= kFew ? splitSorted(items)
                                                          : splitBinned(items));
    divide(first, middle, std::min(depth + 1, kDeepest));
    divide(middle, end, std::min(depth + 1, kDeepest));
  }

  using Keys = std::array<std::pair<float, size_t>, kFew>;  // centres and positions

  static void sort(std::span<const Boxed> items, int axis, Keys& keys) {
    for (size_t i = 0; i < items.size(); ++i) keys[i] = {centre(items[i].box, axis), i};
    std::sort(keys.begin(), keys.begin() + static_cast<ptrdiff_t>(items.size()));
  }

  size_t splitSorted(std::span<Boxed> items) const {
    const size_t count = items.size();
    Split best;
    Keys keys;
    std::array<float, kFew> before;
    for (int axis = 0; axis < 3; ++axis) {
      sort(items, axis, keys);
      BoundingBox box;
      for (size_t i = 0; i < count; ++i) {
        box.add(items[keys[i].second].box);
        before[i] = cost(box, i + 1);
      }
      box = {};
      for (size_t i = count - 1; i > 0; --i) {
        box.add(items[keys[i].second].box);
        const float sum = before[i - 1] + cost(box, count - i);
        if (sum < best.cost) best = {sum, axis, i};
      }
    }
    if (best.axis < 0) return count / 2;
    sort(items, best.axis, keys);
    std::array<Boxed, kFew> sorted;
    for (size_t i = 0; i < count; ++i) sorted[i] = items[keys[i].second];
    std::copy_n(sorted.begin(), count, items.begin());
    return best.at;
  }

  size_t splitBinned(std::span<Boxed> items) const {
    BoundingBox centres;
    for (const Boxed& item : items) {
      const float point[3] = {centre(item.box, 0), centre(item.box, 1), centre(item.box, 2)};
      centres.add(point);
    }
    float scale[3];
    for (int axis = 0; axis < 3; ++axis) {
      const float width = centres.high[axis] - centres.low[axis];
      // The quotient is infinite for centres that differ by a denormal number only.
      scale[axis] = width > 1e-30f ? static_cast<float>(kBins) / width : 0.0f;
    }
    const auto binOf = [&](const Boxed& item, int axis) {
      return std::min(static_cast<size_t>((centre(item.box, axis) - centres.low[axis]) * scale[axis]), kBins - 1);
    };
    std::array<std::array<Bin, kBins>, 3> bins;
    for (const Boxed& item : items)
      for (int axis = 0; axis < 3; ++axis) bins[axis][binOf(item, axis)].add({item.box, 1});
    Split best;
    for (int axis = 0; axis < 3; ++axis) {
      std::array<Bin, kBins> before;
      Bin sum;
      for (size_t k = 0; k < kBins; ++k) {
        before[k] = sum;
        sum.add(bins[axis][k]);
      }
      sum = {};
      for (size_t k = kBins - 1; k > 0; --k) {
        sum.add(bins[axis][k]);
        if (sum.count == 0 || before[k].count == 0) continue;
        const float total = cost(before[k].box, before[k].count) + cost(sum.box, sum.count);
        if (total < best.cost) best = {total, axis, k};
      }
    }
    if (best.axis < 0) return items.size() / 2;
    const auto middle =
        std::partition(items.begin(), items.end(), [&](const Boxed& item) { return binOf(item, best.axis) < best.at; });
    return static_cast<size_t>(middle - items.begin());
  }

  size_t most_;
  float runCost_;
  std::vector<Boxed> items_;
  std::vector<size_t> ends_;
};

}  // namespace

void BoundingBox::enclose(const float* least, const float* most) {
  for (int axis = 0; axis < 3; ++axis) {
    low[axis] = std::min(low[axis], least[axis]);
    high[axis] = std::max(high[axis], most[axis]);
  }
}

float BoundingBox::halfArea() const {
  const float x = high[0] - low[0], y = high[1] - low[1], z = high[2] - low[2];
  return x * y + y * z + z * x;
}

Partition partition(std::vector<Boxed> items, size_t most, float runCost) {
  return Partitioner(std::move(items), most, runCost).run();
}

}  // namespace gnosphere

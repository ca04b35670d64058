// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdint>
#include <memory>
#include <nanoflann.hpp>
#include <tuple>
#include <vector>

#include "base/vector.hpp"
#include "gnosphere/eval/accuracy.hpp"

namespace gnosphere {
namespace {

/// The hits of a scan in the form that the k-d tree reads.
struct Points {
  explicit Points(const Scan& scan) : scan_(scan) {
    for (size_t entry = 0; entry < scan.triangles.size(); ++entry)
      if (scan.hit(entry)) entries_.push_back(entry);
  }
  size_t kdtree_get_point_count() const { return entries_.size(); }
  double kdtree_get_pt(size_t point, size_t axis) const { return scan_.points[3 * entries_[point] + axis]; }
  template <typename Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }

 private:
  const Scan& scan_;
  std::vector<size_t> entries_;
};

using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Points>, Points, 3, uint32_t>;

size_t binOf(double distance) {
  size_t bin = 0;
  while (bin < kNearestBins.size() && !(distance < kNearestBins[bin])) ++bin;
  return bin;
}

}  // namespace

NearestHistogram nearestHistogram(const Scan& reference, const Scan& other) {
  const Points points(reference);
  std::unique_ptr<Tree> tree;  // made when first needed, which is rare
  NearestHistogram histogram{};
  for (size_t entry = 0; entry < other.triangles.size(); ++entry) {
    if (!other.hit(entry)) continue;
    const float* p = &other.points[3 * entry];
    const double query[3] = {p[0], p[1], p[2]};
    // The nearest point is that of the same entry or a nearer one; both fall into the first bin.
    if (entry < reference.triangles.size() && reference.hit(entry)) {
      const float* own = &reference.points[3 * entry];
      if (binOf(lengthOf({query[0] - own[0], query[1] - own[1], query[2] - own[2]})) == 0) {
        ++histogram[0];
        continue;
      }
    }
    if (points.kdtree_get_point_count() == 0) {
      ++histogram.back();
      continue;
    }
    if (!tree) {
      tree = std::make_unique<Tree>(3, points, nanoflann::KDTreeSingleIndexAdaptorParams(16));
      tree->buildIndex();
    }
    uint32_t index = 0;
    double squared = 0;
    std::ignore = tree->knnSearch(query, 1, &index, &squared);
    ++histogram[binOf(std::sqrt(squared))];
  }
  return histogram;
}

}  // namespace gnosphere

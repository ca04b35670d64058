// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <memory>
#include <nanoflann.hpp>
#include <tuple>
#include <unordered_map>
#include <utility>
#include <vector>

#include "view/cloud.hpp"

namespace gnosphere::cli {
namespace {

enum Match { kSame, kApart, kOnlyA, kOnlyB };

/// For each point the distance to the point of the other cloud that it is compared with; NaN if there is none.
using Distances = std::vector<double>;

double distanceOf(const ViewCloud& a, size_t i, const ViewCloud& b, size_t j) {
  const float *p = &a.points[3 * i], *q = &b.points[3 * j];
  return std::hypot(double{p[0]} - q[0], double{p[1]} - q[1], double{p[2]} - q[2]);
}

Distances toSameBeam(const ViewCloud& from, const ViewCloud& to) {
  std::unordered_map<uint64_t, size_t> places;
  const std::vector<uint64_t>&theirs = *to.returns, &ours = *from.returns;
  for (size_t j = 0; j < theirs.size(); ++j) places[theirs[j]] = j;
  Distances distances;
  for (size_t i = 0; i < ours.size(); ++i) {
    const auto found = places.find(ours[i]);
    distances.push_back(found == places.end() ? NAN : distanceOf(from, i, to, found->second));
  }
  return distances;
}

/// The points of a cloud in the form that the k-d tree reads.
struct TreePoints {
  const ViewCloud& cloud;
  size_t kdtree_get_point_count() const { return cloud.size(); }
  double kdtree_get_pt(size_t point, size_t axis) const { return cloud.points[3 * point + axis]; }
  template <typename Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

Distances toNearest(const ViewCloud& from, const ViewCloud& to) {
  using Tree =
      nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, TreePoints>, TreePoints, 3, uint32_t>;
  if (to.size() == 0) return Distances(from.size(), NAN);
  const TreePoints points{to};
  Tree tree(3, points, nanoflann::KDTreeSingleIndexAdaptorParams(16));
  tree.buildIndex();
  Distances distances;
  for (size_t i = 0; i < from.size(); ++i) {
    const double query[3] = {from.points[3 * i], from.points[3 * i + 1], from.points[3 * i + 2]};
    uint32_t nearest = 0;
    double squared = 0;
    std::ignore = tree.knnSearch(query, 1, &nearest, &squared);
    distances.push_back(std::sqrt(squared));
  }
  return distances;
}

void append(const ViewCloud& part, ViewCloud& all) {
  const size_t before = all.size();
  all.points.insert(all.points.end(), part.points.begin(), part.points.end());
  all.misses += part.misses;
  for (const ViewColumn& column : part.columns)
    if (!all.find(column.name)) {
      all.columns.push_back({column.name, column.isId, {}, column.names});
      all.columns.back().values.resize(before, NAN);
    }
  for (ViewColumn& out : all.columns) {
    const ViewColumn* column = part.find(out.name);
    if (column) {
      out.isId = out.isId && column->isId;
      out.values.insert(out.values.end(), column->values.begin(), column->values.end());
    }
    out.values.resize(all.size(), NAN);
  }
}

}  // namespace

bool comparesBeams(const ViewCloud& a, const ViewCloud& b) {
  return a.returns && b.returns;
}

ViewCloud differenceOf(const ViewCloud& a, const ViewCloud& b, double distance) {
  const bool byBeam = comparesBeams(a, b);
  ViewColumn cloud{"cloud", true, {}, {{0, "A"}, {1, "B"}}};
  ViewColumn difference{
      "difference", true, {}, {{kSame, "same in A and B"}, {kOnlyA, "only in A"}, {kOnlyB, "only in B"}}};
  ViewColumn apart{"distance", false, {}, {}};
  if (byBeam) difference.names[kApart] = "apart in A and B";
  const auto add = [&](const ViewCloud& from, const ViewCloud& to, int number, Match alone) {
    for (double d : byBeam ? toSameBeam(from, to) : toNearest(from, to)) {
      cloud.values.push_back(number);
      apart.values.push_back(d);
      const bool same = d <= distance, paired = byBeam && !std::isnan(d);
      difference.values.push_back(same ? kSame : paired ? kApart : alone);
    }
  };
  add(a, b, 0, kOnlyA);
  add(b, a, 1, kOnlyB);
  ViewCloud both;
  both.origin = a.origin;
  append(a, both);
  append(b, both);
  both.columns.insert(both.columns.begin(), {std::move(difference), std::move(apart), std::move(cloud)});
  return both;
}

}  // namespace gnosphere::cli

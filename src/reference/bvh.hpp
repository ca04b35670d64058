// SPDX-License-Identifier: Apache-2.0
// A tree of boxes over triangles; finds the triangles that a beam may hit; the hits themselves are computed elsewhere.
#pragma once

#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include "reference/hit.hpp"

namespace gnosphere::reference {

struct Box {
  Vec3 min{kInfinity, kInfinity, kInfinity};
  Vec3 max{-kInfinity, -kInfinity, -kInfinity};

  void add(const Vec3& p) {
    min = {std::min(min.x, p.x), std::min(min.y, p.y), std::min(min.z, p.z)};
    max = {std::max(max.x, p.x), std::max(max.y, p.y), std::max(max.z, p.z)};
  }
  void add(const Box& box) {
    add(box.min);
    add(box.max);
  }
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();
};

/// The motion of moving triangles: their corners move in straight lines.
struct Sweeps {
  std::vector<std::array<Vec3, 3>> velocities;  ///< m/s of the corners
  double first = 0, last = 0;                   ///< seconds: the time span that the boxes must cover

  /// Returns the triangle at a time.
  Triangle at(Triangle triangle, double time) const {
    if (triangle.sweep == Triangle::kStill) return triangle;
    const auto& velocity = velocities[triangle.sweep];
    for (size_t k = 0; k < 3; ++k) triangle.corners[k] = triangle.corners[k] + time * velocity[k];
    return triangle;
  }
};

Box boxOf(const Triangle& triangle);
/// The box of all its positions.
Box boxOf(const Triangle& triangle, const Sweeps& sweeps);

/// A beam in the world, widened: a box counts as hit if the beam passes within `spread` times the distance of the box's
/// farthest corner (in the 1-norm, which is no less than the true distance) plus `floor` metres.
struct Ray {
  Ray(const Vec3& from, const Vec3& direction, double spread, double floor);
  /// Returns where the ray enters the box: 0 if it starts inside, infinity if it misses.
  double enter(const Box& box) const {
    const Vec3 low = box.min - origin;
    const Vec3 high = box.max - origin;
    const double far = std::max(-low.x, high.x) + std::max(-low.y, high.y) + std::max(-low.z, high.z);
    const double pad = spread * far + floor;
    const double x0 = (low.x - pad) * inverse.x, x1 = (high.x + pad) * inverse.x;
    const double y0 = (low.y - pad) * inverse.y, y1 = (high.y + pad) * inverse.y;
    const double z0 = (low.z - pad) * inverse.z, z1 = (high.z + pad) * inverse.z;
    const double in = std::max({std::min(x0, x1), std::min(y0, y1), std::min(z0, z1), 0.0});
    const double out = std::min({std::max(x0, x1), std::max(y0, y1), std::max(z0, z1)});
    return in <= out ? in : Box::kInfinity;
  }

  Vec3 origin;
  Vec3 inverse;
  double spread;
  double floor;
};

/// A binary tree, split by the surface area heuristic with 16 bins (Wald 2007, On fast Construction of SAH-based
/// Bounding Volume Hierarchies). The same triangles in the same order give the same tree on any number of threads.
class Bvh {
 public:
  explicit Bvh(std::vector<Triangle> triangles, Sweeps sweeps = {});

  const std::vector<Triangle>& triangles() const { return triangles_; }
  const Sweeps& sweeps() const { return sweeps_; }
  Box bounds() const { return nodes_.empty() ? Box{} : nodes_.front().box; }
  size_t bytes() const { return triangles_.size() * sizeof(Triangle) + nodes_.size() * sizeof(Node); }

  /// Calls `limit = visit(index of triangle, limit)` for every triangle in a box that the ray enters within `limit`,
  /// nearer boxes first. A visitor ends the walk by returning a negative limit.
  template <typename Visit>
  void walk(const Ray& ray, double limit, Visit&& visit) const;

 private:
  /// The first child of an inner node follows it in the array.
  struct Node {
    Box box;
    uint32_t next = 0;   ///< the second child, or a leaf's first triangle
    uint32_t count = 0;  ///< triangles of a leaf; 0 in an inner node
  };
  struct Item;
  void build(std::vector<Item>& items, size_t begin, size_t end, int depth, std::vector<Node>& nodes) const;

  /// From this depth on, splits halve the triangles, so that their 32-bit count bounds the depth to kMaxDepth.
  static constexpr int kHalvingDepth = 48;
  static constexpr int kMaxDepth = kHalvingDepth + 32;

  std::vector<Triangle> triangles_;
  Sweeps sweeps_;
  std::vector<Node> nodes_;
};

template <typename Visit>
void Bvh::walk(const Ray& ray, double limit, Visit&& visit) const {
  struct Entry {
    uint32_t node;
    double in;
  };
  std::array<Entry, kMaxDepth + 1> stack;
  size_t size = 0;
  const auto push = [&](uint32_t node, double in) {
    if (in <= limit && in < Box::kInfinity) stack[size++] = {node, in};
  };
  if (!nodes_.empty()) push(0, ray.enter(nodes_[0].box));
  while (size > 0) {
    const Entry entry = stack[--size];
    if (entry.in > limit) continue;
    const Node& node = nodes_[entry.node];
    for (uint32_t i = 0; i < node.count; ++i) {
      limit = visit(node.next + i, limit);
      if (limit < 0) return;
    }
    if (node.count > 0) continue;
    const double first = ray.enter(nodes_[entry.node + 1].box);
    const double second = ray.enter(nodes_[node.next].box);
    if (first <= second) {
      push(node.next, second);
      push(entry.node + 1, first);
    } else {
      push(entry.node + 1, first);
      push(node.next, second);
    }
  }
}

}  // namespace gnosphere::reference

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
    min = lowest(min, p);
    max = highest(max, p);
  }
  void add(const Box& box) {
    add(box.min);
    add(box.max);
  }
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();
};

/// N boxes, coordinate by coordinate.
template <size_t N>
struct Boxes {
  double minX[N], minY[N], minZ[N], maxX[N], maxY[N], maxZ[N];

  void set(size_t i, const Box& box) {
    minX[i] = box.min.x, minY[i] = box.min.y, minZ[i] = box.min.z;
    maxX[i] = box.max.x, maxY[i] = box.max.y, maxZ[i] = box.max.z;
  }
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
  /// Returns how many metres along the ray each box begins: 0 if the ray starts inside, infinity if it misses.
  template <size_t N>
  std::array<double, N> enter(const Boxes<N>& boxes) const {
    std::array<double, N> result;
    for (size_t i = 0; i < N; ++i) {  // without branches, so that compilers compute several boxes at once
      const double lowX = boxes.minX[i] - origin.x, highX = boxes.maxX[i] - origin.x;
      const double lowY = boxes.minY[i] - origin.y, highY = boxes.maxY[i] - origin.y;
      const double lowZ = boxes.minZ[i] - origin.z, highZ = boxes.maxZ[i] - origin.z;
      const double far = std::max(-lowX, highX) + std::max(-lowY, highY) + std::max(-lowZ, highZ);
      const double pad = spread * far + floor;
      const double x0 = (lowX - pad) * inverse.x, x1 = (highX + pad) * inverse.x;
      const double y0 = (lowY - pad) * inverse.y, y1 = (highY + pad) * inverse.y;
      const double z0 = (lowZ - pad) * inverse.z, z1 = (highZ + pad) * inverse.z;
      const double in = std::max(std::max(std::min(x0, x1), std::min(y0, y1)), std::max(std::min(z0, z1), 0.0));
      const double out = std::min(std::min(std::max(x0, x1), std::max(y0, y1)), std::max(z0, z1));
      result[i] = in <= out ? in : Box::kInfinity;
    }
    return result;
  }
  double enter(const Box& box) const {
    Boxes<1> boxes;
    boxes.set(0, box);
    return enter(boxes)[0];
  }

  Vec3 origin;
  Vec3 inverse;
  double spread;
  double floor;
};

/// A tree in which each node has up to four children. First a binary tree is split by the surface area heuristic with
/// 16 bins (Wald 2007, On fast Construction of SAH-based Bounding Volume Hierarchies). Then the largest children give
/// way to their own children. The same triangles in the same order give the same tree on any number of threads.
class Bvh {
 public:
  explicit Bvh(std::vector<Triangle> triangles, Sweeps sweeps = {});

  const std::vector<Triangle>& triangles() const { return triangles_; }
  const Sweeps& sweeps() const { return sweeps_; }
  const Box& bounds() const { return bounds_; }
  size_t bytes() const { return triangles_.size() * sizeof(Triangle) + nodes_.size() * sizeof(Node); }

  /// Calls `limit = visit(index of triangle, limit)` for every triangle in a box that the ray enters within `limit`,
  /// nearer boxes first. A visitor ends the walk by returning a negative limit.
  template <typename Visit>
  void walk(const Ray& ray, double limit, Visit&& visit) const;

 private:
  static constexpr size_t kChildren = 4;
  /// Places without a child repeat the box of the first one, so that all of them can be tested at once.
  struct Node {
    Boxes<kChildren> boxes;
    uint32_t next[kChildren];   ///< the child's node, or a leaf's first triangle
    uint32_t count[kChildren];  ///< triangles of a leaf; 0 for a node
    uint32_t children = 0;
  };
  struct Item;
  struct BinaryNode;
  void build(std::vector<Item>& items, size_t begin, size_t end, int depth, std::vector<BinaryNode>& nodes) const;
  void addNode(const std::vector<BinaryNode>& binary, uint32_t from);

  /// From this depth on, splits halve the triangles, so that their 32-bit count bounds the depth to kMaxDepth.
  static constexpr int kHalvingDepth = 48;
  static constexpr int kMaxDepth = kHalvingDepth + 32;

  std::vector<Triangle> triangles_;
  Sweeps sweeps_;
  Box bounds_;
  std::vector<Node> nodes_;
};

template <typename Visit>
void Bvh::walk(const Ray& ray, double limit, Visit&& visit) const {
  struct Entry {
    double in;
    uint32_t next, count;
  };
  std::array<Entry, (kChildren - 1) * kMaxDepth + 1> stack;
  size_t size = 0;
  if (!nodes_.empty()) stack[size++] = {0, 0, 0};
  while (size > 0) {
    const Entry entry = stack[--size];
    if (entry.in > limit) continue;
    for (uint32_t i = 0; i < entry.count; ++i) {
      limit = visit(entry.next + i, limit);
      if (limit < 0) return;
    }
    if (entry.count > 0) continue;
    const Node& node = nodes_[entry.next];
    const std::array<double, kChildren> in = ray.enter(node.boxes);
    const size_t first = size;
    for (size_t i = 0; i < node.children; ++i) {
      if (in[i] > limit || in[i] == Box::kInfinity) continue;
      size_t place = size++;
      for (; place > first && stack[place - 1].in < in[i]; --place) stack[place] = stack[place - 1];
      stack[place] = {in[i], node.next[i], node.count[i]};
    }
  }
}

}  // namespace gnosphere::reference

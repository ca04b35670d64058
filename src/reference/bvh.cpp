// SPDX-License-Identifier: Apache-2.0
#include "reference/bvh.hpp"

#include <future>
#include <system_error>
#include <utility>

namespace gnosphere::reference {

namespace {

constexpr size_t kLeafSize = 4;
constexpr int kBins = 16;
/// In the first levels, subtrees of more triangles than this are built on a thread of their own.
constexpr size_t kTaskSize = 5000;
constexpr int kTaskDepth = 3;

/// Choosing a split needs only single precision; the boxes of the nodes are computed from the triangles in double.
struct RoughBox {
  float min[3] = {3e38f, 3e38f, 3e38f};
  float max[3] = {-3e38f, -3e38f, -3e38f};

  void add(const RoughBox& box) {
    for (int axis = 0; axis < 3; ++axis) {
      min[axis] = std::min(min[axis], box.min[axis]);
      max[axis] = std::max(max[axis], box.max[axis]);
    }
  }
  double area() const {
    const double x = double{max[0]} - min[0], y = double{max[1]} - min[1], z = double{max[2]} - min[2];
    return x < 0 ? 0 : x * y + y * z + z * x;
  }
};

}  // namespace

/// The first child of an inner node follows it in the array.
struct Bvh::BinaryNode {
  Box box;
  uint32_t next = 0;   ///< the second child, or a leaf's first triangle
  uint32_t count = 0;  ///< triangles of a leaf; 0 in an inner node
};

struct Bvh::Item {
  RoughBox box;
  uint32_t triangle = 0;
  float centre(int axis) const { return 0.5f * box.min[axis] + 0.5f * box.max[axis]; }
};

namespace {

/// Finds the cheapest plane between bins along the longest axis of the centres, and returns the first item behind it;
/// returns the middle if no plane separates the items.
template <typename Iterator>
Iterator split(Iterator begin, Iterator end, bool halve) {
  RoughBox centres;
  for (Iterator item = begin; item != end; ++item) {
    RoughBox point;
    for (int axis = 0; axis < 3; ++axis) point.min[axis] = point.max[axis] = item->centre(axis);
    centres.add(point);
  }
  int axis = 0;
  for (int other = 1; other < 3; ++other)
    if (centres.max[other] - centres.min[other] > centres.max[axis] - centres.min[axis]) axis = other;
  const float low = centres.min[axis];
  const float extent = centres.max[axis] - low;
  const Iterator middle = begin + (end - begin) / 2;
  if (!(extent > 0 && extent < 3e38f)) return middle;  // boxes beyond the range of floats fit no bins
  if (halve) {
    std::nth_element(begin, middle, end, [axis](const auto& a, const auto& b) {
      return std::pair(a.centre(axis), a.triangle) < std::pair(b.centre(axis), b.triangle);
    });
    return middle;
  }

  const auto binOf = [=](const auto& item) {
    return std::min(kBins - 1, static_cast<int>((item.centre(axis) - low) / extent * kBins));
  };
  std::array<RoughBox, kBins> boxes;
  std::array<size_t, kBins> counts = {};
  for (Iterator item = begin; item != end; ++item) {
    const auto bin = static_cast<size_t>(binOf(*item));
    boxes[bin].add(item->box);
    ++counts[bin];
  }
  std::array<double, kBins> behind = {};
  RoughBox box;
  size_t count = 0;
  for (size_t bin = kBins - 1; bin > 0; --bin) {
    box.add(boxes[bin]);
    count += counts[bin];
    behind[bin] = static_cast<double>(count) * box.area();
  }
  box = {};
  count = 0;
  int best = 1;
  double bestCost = Box::kInfinity;
  for (size_t bin = 1; bin < kBins; ++bin) {
    box.add(boxes[bin - 1]);
    count += counts[bin - 1];
    const double cost = static_cast<double>(count) * box.area() + behind[bin];
    if (cost >= bestCost) continue;
    bestCost = cost;
    best = static_cast<int>(bin);
  }
  const Iterator plane = std::partition(begin, end, [&](const auto& item) { return binOf(item) < best; });
  return plane == begin || plane == end ? middle : plane;
}

}  // namespace

Box boxOf(const Triangle& triangle) {
  Box box;
  for (const Vec3& corner : triangle.corners) box.add(corner);
  return box;
}

Box boxOf(const Triangle& triangle, const Sweeps& sweeps) {
  Box box = boxOf(sweeps.at(triangle, sweeps.first));
  if (triangle.sweep != Triangle::kStill) box.add(boxOf(sweeps.at(triangle, sweeps.last)));
  return box;
}

Ray::Ray(const Vec3& from, const Vec3& direction, double spread_, double floor_)
    : origin(from), spread(spread_), floor(floor_) {
  // A finite inverse avoids 0 * infinity in the box test.
  const auto invert = [](double c) { return 1 / (std::abs(c) < 1e-30 ? std::copysign(1e-30, c) : c); };
  inverse = {invert(direction.x), invert(direction.y), invert(direction.z)};
}

Bvh::Bvh(std::vector<Triangle> triangles, Sweeps sweeps)
    : triangles_(std::move(triangles)), sweeps_(std::move(sweeps)) {
  if (triangles_.empty()) return;
  Box all;
  for (const Triangle& triangle : triangles_) all.add(boxOf(triangle, sweeps_));
  const Vec3 anchor = 0.5 * all.min + 0.5 * all.max;
  std::vector<Item> items(triangles_.size());
  for (size_t i = 0; i < items.size(); ++i) {
    const Box box = boxOf(triangles_[i], sweeps_);
    const Vec3 min = box.min - anchor, max = box.max - anchor;
    items[i] = {{{static_cast<float>(min.x), static_cast<float>(min.y), static_cast<float>(min.z)},
                 {static_cast<float>(max.x), static_cast<float>(max.y), static_cast<float>(max.z)}},
                static_cast<uint32_t>(i)};
  }
  std::vector<BinaryNode> binary;
  build(items, 0, items.size(), 0, binary);
  bounds_ = binary.front().box;
  addNode(binary, 0);
  std::vector<Triangle> sorted(triangles_.size());
  for (size_t i = 0; i < items.size(); ++i) sorted[i] = triangles_[items[i].triangle];
  triangles_ = std::move(sorted);
}

void Bvh::build(std::vector<Item>& items, size_t begin, size_t end, int depth, std::vector<BinaryNode>& nodes) const {
  const size_t self = nodes.size();
  nodes.emplace_back();
  if (end - begin <= kLeafSize) {
    Box box;
    for (size_t i = begin; i < end; ++i) box.add(boxOf(triangles_[items[i].triangle], sweeps_));
    nodes[self] = {box, static_cast<uint32_t>(begin), static_cast<uint32_t>(end - begin)};
    return;
  }
  const auto first = items.begin();
  const auto plane =
      split(first + static_cast<ptrdiff_t>(begin), first + static_cast<ptrdiff_t>(end), depth >= kHalvingDepth);
  const auto middle = static_cast<size_t>(plane - first);
  std::future<std::vector<BinaryNode>> task;
  if (depth < kTaskDepth && end - middle > kTaskSize) {
    try {
      task = std::async(std::launch::async, [&, middle, end, depth] {
        std::vector<BinaryNode> branch;
        build(items, middle, end, depth + 1, branch);
        return branch;
      });
    } catch (const std::system_error&) {  // The system starts no more threads, so this one builds both branches.
    } catch (const std::bad_alloc&) {     // There is no memory for a thread.
    }
  }
  build(items, begin, middle, depth + 1, nodes);
  const auto second = static_cast<uint32_t>(nodes.size());
  if (task.valid()) {
    for (BinaryNode node : task.get()) {
      if (node.count == 0) node.next += second;
      nodes.push_back(node);
    }
  } else {
    build(items, middle, end, depth + 1, nodes);
  }
  nodes[self].next = second;
  nodes[self].box = nodes[self + 1].box;
  nodes[self].box.add(nodes[second].box);
}

// Adds a node in the place of one of the binary tree, and the nodes below it. A child gives way to its own two
// children, the largest one first, until there are four.
void Bvh::addNode(const std::vector<BinaryNode>& binary, uint32_t from) {
  std::array<uint32_t, kChildren> children = {from};
  uint32_t count = 1;
  while (count < kChildren) {
    const auto areaOf = [&](uint32_t child) {
      const Vec3 size = binary[child].box.max - binary[child].box.min;
      return binary[child].count > 0 ? -1 : size.x * size.y + size.y * size.z + size.z * size.x;
    };
    uint32_t& largest = *std::max_element(children.begin(), children.begin() + count,
                                          [&](uint32_t a, uint32_t b) { return areaOf(a) < areaOf(b); });
    if (binary[largest].count > 0) break;  // all are leaves
    children[count++] = binary[largest].next;
    ++largest;
  }
  const size_t self = nodes_.size();
  nodes_.emplace_back().children = count;
  for (size_t i = 0; i < kChildren; ++i) {
    const BinaryNode& child = binary[children[i < count ? i : 0]];
    if (i < count && child.count == 0) {
      const auto next = static_cast<uint32_t>(nodes_.size());
      addNode(binary, children[i]);
      nodes_[self].next[i] = next;
    }
    Node& node = nodes_[self];
    if (child.count > 0) node.next[i] = child.next;
    node.count[i] = child.count;
    node.boxes.set(i, child.box);
  }
}

}  // namespace gnosphere::reference

// SPDX-License-Identifier: Apache-2.0
// Shared by the formats with polygons: triangulation, and the scene of meshes without materials.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "scene/readers.hpp"

namespace gnosphere {
namespace {

using Point = std::array<double, 2>;

/// Twice the signed area of a triangle.
double area(const Point& a, const Point& b, const Point& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

constexpr double kRounding = 1e-6;  // of an area

size_t indexOfLargest(const std::array<double, 3>& values) {
  return static_cast<size_t>(std::ranges::max_element(values) - values.begin());
}

/// Projects the polygon to its plane (Newell's normal), counter-clockwise. The normal of a polygon that crosses itself
/// may be 0; then it is projected along the axis that shows most of its triangles.
std::vector<Point> flattened(std::span<const uint32_t> corners, std::span<const double> coordinates) {
  const auto at = [&](size_t i) { return &coordinates[3 * size_t{corners[i % corners.size()]}]; };
  std::array<double, 3> normal = {}, sizes = {}, shown = {};
  for (size_t i = 0; i < corners.size(); ++i)
    for (size_t k = 0; k < 3; ++k) {
      const size_t u = (k + 1) % 3, v = (k + 2) % 3;
      const double *o = at(0), *a = at(i), *b = at(i + 1);
      const double part = (a[u] - o[u]) * (b[v] - o[v]) - (a[v] - o[v]) * (b[u] - o[u]);
      normal[k] += part;
      shown[k] += std::abs(part);
    }
  std::ranges::transform(normal, sizes.begin(), [](double value) { return std::abs(value); });
  size_t k = indexOfLargest(sizes);
  if (sizes[k] < kRounding * std::ranges::max(shown)) k = indexOfLargest(shown);
  const size_t u = (k + 1) % 3, v = (k + 2) % 3;
  const double sign = normal[k] < 0 ? -1 : 1;
  std::vector<Point> points(corners.size());
  for (size_t i = 0; i < points.size(); ++i) points[i] = {at(i)[u] - at(0)[u], sign * (at(i)[v] - at(0)[v])};
  return points;
}

/// The corners of a polygon, until they are removed, in the cells of a grid around them: about one corner in each.
class CornerGrid {
 public:
  explicit CornerGrid(const std::vector<Point>& points)
      : points_(points), side_(static_cast<size_t>(std::sqrt(points.size()))), next_(points.size()) {
    Point high = {};  // the first corner is at 0, 0
    for (const Point& p : points)
      for (size_t axis = 0; axis < 2; ++axis) {
        low_[axis] = std::min(low_[axis], p[axis]);
        high[axis] = std::max(high[axis], p[axis]);
      }
    for (size_t axis = 0; axis < 2; ++axis)
      cellsPerUnit_[axis] = static_cast<double>(side_) / (high[axis] - low_[axis]);
    first_.assign(side_ * side_, kNoCorner);
    for (size_t i = 0; i < points.size(); ++i) {
      next_[i] = firstAt(points[i]);
      firstAt(points[i]) = i;
    }
  }

  void remove(size_t corner) {
    size_t* at = &firstAt(points_[corner]);
    while (*at != corner) at = &next_[*at];
    *at = next_[corner];
  }

  /// Whether another corner lies in this counter-clockwise triangle. Corners may coincide with those of the triangle,
  /// as at a slit to a hole; such corners are not in it. Adds the cells and corners that it looked at to `work`.
  bool isAnyIn(const Point& a, const Point& b, const Point& c, size_t& work) const {
    const auto [left, right] = std::minmax({a[0], b[0], c[0]});
    const auto [bottom, top] = std::minmax({a[1], b[1], c[1]});
    const size_t endColumn = cellOf(right, 0) + 1, endRow = cellOf(top, 1) + 1;
    for (size_t row = cellOf(bottom, 1); row < endRow; ++row)
      for (size_t column = cellOf(left, 0); column < endColumn; ++column, ++work)
        for (size_t i = first_[row * side_ + column]; i != kNoCorner; i = next_[i], ++work) {
          const Point& p = points_[i];
          if (p == a || p == b || p == c) continue;
          if (area(a, b, p) >= 0 && area(b, c, p) >= 0 && area(c, a, p) >= 0) return true;
        }
    return false;
  }

 private:
  static constexpr size_t kNoCorner = std::numeric_limits<size_t>::max();

  /// The column or row of a coordinate; 0 for NaN.
  size_t cellOf(double coordinate, size_t axis) const {
    const double cell = (coordinate - low_[axis]) * cellsPerUnit_[axis];
    return cell > 0 ? static_cast<size_t>(std::min(cell, static_cast<double>(side_ - 1))) : 0;
  }
  size_t& firstAt(const Point& p) { return first_[cellOf(p[1], 1) * side_ + cellOf(p[0], 0)]; }

  const std::vector<Point>& points_;
  const size_t side_;
  Point low_ = {}, cellsPerUnit_ = {};
  std::vector<size_t> first_, next_;  // by cell, and by corner: the next one of the same cell
};

/// Calls `triangle` for each ear that it cuts off the polygon, and returns the corners that are left. Ears are mostly
/// near each other, so the work is seldom more than some cells for each corner. The search ends where no ear is left,
/// as in a polygon that crosses itself, or when it has taken about 0.1 ms for each corner.
template <typename Triangle>
std::vector<size_t> cutEars(const std::vector<Point>& points, const Triangle& triangle) {
  const size_t count = points.size(), limit = count * std::min<size_t>(20 * count, 40'000);
  std::vector<size_t> before(count), after(count), left;
  for (size_t i = 0; i < count; ++i) {
    before[i] = (i + count - 1) % count;
    after[i] = (i + 1) % count;
  }
  std::vector<bool> isCut(count);
  CornerGrid grid(points);
  size_t rest = count, i = 0;
  for (size_t tried = 0, work = 0; rest > 3 && tried < rest && work < limit; ++work) {
    const size_t a = before[i], c = after[i];
    if (!(area(points[a], points[i], points[c]) > 0) || grid.isAnyIn(points[a], points[i], points[c], work)) {
      i = c;
      ++tried;
      continue;
    }
    triangle(a, i, c);
    after[a] = c;
    before[c] = a;
    isCut[i] = true;
    grid.remove(i);
    --rest;
    i = a;
    tried = 0;
  }
  for (size_t k = 0; k < count; ++k)
    if (!isCut[k]) left.push_back(k);
  return left;
}

}  // namespace

bool appendPolygon(std::vector<uint32_t>& indices, std::span<const uint32_t> corners,
                   std::span<const double> coordinates) {
  if (corners.size() < 3) return true;
  if (corners.size() == 3) {
    indices.insert(indices.end(), corners.begin(), corners.end());
    return true;
  }
  const auto triangle = [&](size_t a, size_t b, size_t c) {
    indices.insert(indices.end(), {corners[a], corners[b], corners[c]});
  };
  const std::vector<Point> points = flattened(corners, coordinates);
  bool convex = true;
  double whole = 0;
  for (size_t k = 0; k < points.size(); ++k) {
    const Point &b = points[(k + 1) % points.size()], &c = points[(k + 2) % points.size()];
    convex = convex && area(points[k], b, c) >= 0;
    whole += area(points[0], b, c);
  }
  std::vector<size_t> left(corners.size());
  std::iota(left.begin(), left.end(), size_t{0});
  if (!convex) left = cutEars(points, triangle);
  double reversed = 0;  // of the fan that finishes the polygon, the area that lies outside or more than once
  for (size_t k = 1; k + 1 < left.size(); ++k) {
    triangle(left[0], left[k], left[k + 1]);
    reversed = std::max(reversed, -area(points[left[0]], points[left[k]], points[left[k + 1]]));
  }
  return !(reversed > kRounding * whole);
}

Scene sceneOf(std::vector<Mesh>&& meshes) {
  Scene scene;
  scene.materials.emplace_back();
  for (Mesh& mesh : meshes) {
    mesh.parts = {{0, static_cast<uint32_t>(mesh.triangleCount()), 0}};
    scene.instances.push_back({mesh.name, static_cast<uint32_t>(scene.instances.size())});
  }
  scene.meshes = std::move(meshes);
  return scene;
}

}  // namespace gnosphere

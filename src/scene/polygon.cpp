// SPDX-License-Identifier: Apache-2.0
// Shared by the formats with polygons: triangulation, and the scene of a single mesh.
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "scene/readers.hpp"

namespace gnosphere {
namespace {

using Point = std::array<double, 2>;

/// Twice the signed area of a triangle.
double area(const Point& a, const Point& b, const Point& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/// Projects the polygon to its plane (Newell's normal), counter-clockwise. All points are zero if it has no area.
std::vector<Point> flattened(std::span<const uint32_t> corners, std::span<const double> coordinates) {
  const auto at = [&](size_t i) { return &coordinates[3 * size_t{corners[i % corners.size()]}]; };
  std::array<double, 3> normal = {};
  for (size_t i = 0; i < corners.size(); ++i)
    for (size_t k = 0; k < 3; ++k) {
      const size_t u = (k + 1) % 3, v = (k + 2) % 3;
      const double *o = at(0), *a = at(i), *b = at(i + 1);
      normal[k] += (a[u] - o[u]) * (b[v] - o[v]) - (a[v] - o[v]) * (b[u] - o[u]);
    }
  size_t k = 0;
  for (size_t i = 1; i < 3; ++i)
    if (std::abs(normal[i]) > std::abs(normal[k])) k = i;
  const size_t u = (k + 1) % 3, v = (k + 2) % 3;
  const double sign = normal[k] < 0 ? -1 : 1;
  std::vector<Point> points(corners.size());
  for (size_t i = 0; i < points.size(); ++i) points[i] = {at(i)[u] - at(0)[u], sign * (at(i)[v] - at(0)[v])};
  return points;
}

bool isEar(const std::vector<Point>& points, const std::vector<size_t>& left, size_t i, size_t& work) {
  const size_t n = left.size();
  const Point &a = points[left[(i + n - 1) % n]], &b = points[left[i]], &c = points[left[(i + 1) % n]];
  if (!(area(a, b, c) > 0)) return false;
  for (size_t j = 0; j < n; ++j) {
    if (j == i || j == (i + 1) % n || j == (i + n - 1) % n) continue;
    const Point& p = points[left[j]];
    ++work;
    // Corners may coincide with those of the ear (a slit to a hole); such corners do not block it.
    if (p == a || p == b || p == c) continue;
    if (area(a, b, p) >= 0 && area(b, c, p) >= 0 && area(c, a, p) >= 0) return false;
  }
  return true;
}

}  // namespace

void appendPolygon(std::vector<uint32_t>& indices, std::span<const uint32_t> corners,
                   std::span<const double> coordinates) {
  if (corners.size() < 3) return;
  if (corners.size() == 3) {
    indices.insert(indices.end(), corners.begin(), corners.end());
    return;
  }
  const auto triangle = [&](size_t a, size_t b, size_t c) {
    indices.insert(indices.end(), {corners[a], corners[b], corners[c]});
  };
  const std::vector<Point> points = flattened(corners, coordinates);
  std::vector<size_t> left(corners.size());
  std::iota(left.begin(), left.end(), size_t{0});

  bool convex = true;
  for (size_t k = 0; k < points.size(); ++k)
    convex = convex && area(points[k], points[(k + 1) % points.size()], points[(k + 2) % points.size()]) >= 0;
  // Ears are mostly near each other, so the search takes about the square of the number of corners. A polygon that
  // takes longer, crosses itself or is not finite is finished as a fan, since no triangulation of it is correct.
  constexpr size_t kMaximumCorners = 2000;
  const size_t limit = 20 * corners.size() * corners.size();
  size_t work = 0, i = 0, tried = 0;
  while (!convex && corners.size() <= kMaximumCorners && left.size() > 3 && tried < left.size() && work < limit) {
    const size_t n = left.size();
    if (!isEar(points, left, i, work)) {
      i = (i + 1) % n;
      ++tried;
      continue;
    }
    triangle(left[(i + n - 1) % n], left[i], left[(i + 1) % n]);
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(i));
    i = i == 0 ? n - 2 : i - 1;
    tried = 0;
  }
  for (size_t k = 1; k + 1 < left.size(); ++k) triangle(left[0], left[k], left[k + 1]);
}

Scene sceneOf(Mesh&& mesh) {
  Scene scene;
  scene.materials.emplace_back();
  mesh.parts = {{0, static_cast<uint32_t>(mesh.triangleCount()), 0}};
  scene.meshes.push_back(std::move(mesh));
  scene.instances.emplace_back();
  return scene;
}

}  // namespace gnosphere

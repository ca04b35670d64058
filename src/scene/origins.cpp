// SPDX-License-Identifier: Apache-2.0
#include "scene/origins.hpp"

#include <algorithm>
#include <cmath>

#include "base/single_precision.hpp"

namespace gnosphere {
namespace {

constexpr double kFarthestPlace = 1e12;

/// The centre of a box, rounded to multiples of a step; 0 along axes without any coordinate.
Vec3 centreOf(const CornerBox& box, double step) {
  std::array<double, 3> centre = {};
  for (size_t c = 0; c < 3; ++c)
    if (box.low[c] <= box.high[c]) centre[c] = std::round((box.low[c] / 2 + box.high[c] / 2) / step) * step;
  return {centre[0], centre[1], centre[2]};
}

/// The farthest coordinate of a box from an origin.
double reachFrom(const Vec3& origin, const CornerBox& box) {
  const std::array<double, 3> from = {origin.x, origin.y, origin.z};
  double reach = 0;
  for (size_t c = 0; c < 3; ++c) reach = std::max({reach, from[c] - box.low[c], box.high[c] - from[c]});
  return reach;
}

}  // namespace

void CornerBox::add(std::span<const uint32_t> indices, std::span<const double> coordinates) {
  for (const uint32_t vertex : indices) {
    const auto corner = coordinates.subspan(3 * size_t{vertex}, 3);
    if (!std::ranges::all_of(corner, [](double value) { return std::abs(value) < kFarthestPlace; })) continue;
    for (size_t c = 0; c < 3; ++c) {
      isExact = isExact && static_cast<double>(static_cast<float>(corner[c])) == corner[c];
      low[c] = std::min(low[c], corner[c]);
      high[c] = std::max(high[c], corner[c]);
    }
  }
}

void CornerBox::add(const CornerBox& other) {
  isExact = isExact && other.isExact;
  for (size_t c = 0; c < 3; ++c) {
    low[c] = std::min(low[c], other.low[c]);
    high[c] = std::max(high[c], other.high[c]);
  }
}

std::vector<Vec3> originsOf(std::span<const CornerBox> boxes, double unit) {
  CornerBox all;
  for (const CornerBox& box : boxes) all.add(box);
  if (all.isExact) return std::vector<Vec3>(boxes.size());
  const Vec3 shared = centreOf(all, 1);
  std::vector<Vec3> origins(boxes.size(), shared);
  for (size_t i = 0; i < boxes.size(); ++i) {
    const double reach = reachFrom(shared, boxes[i]);
    if (unit * reach < kCoarseFrom) continue;
    const Vec3 own = centreOf(boxes[i], 1024 / unit);
    if (reachFrom(own, boxes[i]) < reach / 2) origins[i] = own;
  }
  return origins;
}

void appendPosition(Mesh& mesh, std::span<const double> coordinates, size_t vertex) {
  const double* at = &coordinates[3 * vertex];
  const Vec3& origin = mesh.origin;
  for (const double value : {at[0] - origin.x, at[1] - origin.y, at[2] - origin.z})
    mesh.positions.push_back(static_cast<float>(value));
}

void storePositions(Mesh& mesh, std::span<const double> coordinates) {
  CornerBox box;
  box.add(mesh.indices, coordinates);
  mesh.origin = originsOf({&box, 1}, 1)[0];
  mesh.positions.reserve(coordinates.size());
  for (size_t i = 0; i < coordinates.size() / 3; ++i) appendPosition(mesh, coordinates, i);
}

}  // namespace gnosphere

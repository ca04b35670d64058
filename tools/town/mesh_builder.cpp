// SPDX-License-Identifier: Apache-2.0
#include "town/mesh_builder.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

namespace gnosphere::town {

Loop circle(const Vec3& centre, double radius, int segments, double turns) {
  Loop loop;
  for (int i = 0; i < segments; ++i) {
    const double angle = turns + static_cast<double>(i) / segments;
    loop.push_back(centre + Vec3{radius * cosine(angle), radius * sine(angle), 0});
  }
  return loop;
}

size_t MeshBuilder::CornerHash::operator()(const Corner& corner) const {
  uint64_t hash = 0;
  for (float value : corner.at) hash = (hash ^ std::bit_cast<uint32_t>(value)) * 0x9e3779b97f4a7c15u;
  return static_cast<size_t>(hash ^ (hash >> 32));
}

uint32_t MeshBuilder::vertex(const Vec3& p) {
  // Adding 0 turns -0 into +0, so that equal points have equal bits.
  const Corner corner = {{static_cast<float>(p.x) + 0.f, static_cast<float>(p.y) + 0.f, static_cast<float>(p.z) + 0.f}};
  const auto [entry, isNew] = known_.try_emplace(corner, static_cast<uint32_t>(positions_.size() / 3));
  if (isNew) positions_.insert(positions_.end(), corner.at.begin(), corner.at.end());
  return entry->second;
}

void MeshBuilder::triangle(Surface surface, const Vec3& a, const Vec3& b, const Vec3& c) {
  auto& indices = indices_[static_cast<size_t>(surface)];
  indices.insert(indices.end(), {vertex(a), vertex(b), vertex(c)});
}

void MeshBuilder::quad(Surface surface, const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  triangle(surface, a, b, c);
  triangle(surface, a, c, d);
}

void MeshBuilder::band(Surface surface, const Loop& outer, const Loop& inner) {
  for (size_t i = 0; i < outer.size(); ++i) {
    const size_t j = (i + 1) % outer.size();
    quad(surface, outer[i], outer[j], inner[j], inner[i]);
  }
}

void MeshBuilder::fan(Surface surface, const Loop& loop, const Vec3& centre) {
  for (size_t i = 0; i < loop.size(); ++i) triangle(surface, loop[i], loop[(i + 1) % loop.size()], centre);
}

void MeshBuilder::face(Surface surface, const Loop& loop) {
  for (size_t i = 1; i + 1 < loop.size(); ++i) triangle(surface, loop[0], loop[i], loop[i + 1]);
}

void MeshBuilder::box(Surface surface, const Vec3& min, const Vec3& max) {
  const Loop base = {{min.x, min.y, min.z}, {max.x, min.y, min.z}, {max.x, max.y, min.z}, {min.x, max.y, min.z}};
  extrude(surface, surface, base, {0, 0, max.z - min.z});
}

void MeshBuilder::loft(Surface side, Surface cap, const std::vector<Loop>& rings) {
  for (size_t r = 0; r + 1 < rings.size(); ++r) {
    const size_t count = rings[r].size();
    for (size_t i = 0; i < count; ++i) {
      const size_t j = (i + 1) % count;
      quad(side, rings[r][i], rings[r][j], rings[r + 1][j], rings[r + 1][i]);
    }
  }
  face(cap, Loop(rings.front().rbegin(), rings.front().rend()));
  face(cap, rings.back());
}

void MeshBuilder::extrude(Surface side, Surface cap, const Loop& loop, const Vec3& along) {
  Loop end;
  for (const Vec3& p : loop) end.push_back(p + along);
  loft(side, cap, {loop, end});
}

void MeshBuilder::rod(Surface surface, const Vec3& from, const Vec3& to, double radiusFrom, double radiusTo,
                      int segments) {
  const Vec3 axis = normalized(to - from);
  const Vec3 u = normalized(cross(std::abs(axis.z) < 0.9 ? Vec3{0, 0, 1} : Vec3{1, 0, 0}, axis));
  const Vec3 v = cross(axis, u);
  Loop start, end;
  for (const Vec3& p : circle({}, 1, segments)) {
    const Vec3 offset = p.x * u + p.y * v;
    start.push_back(from + radiusFrom * offset);
    end.push_back(to + radiusTo * offset);
  }
  loft(surface, surface, {start, end});
}

void MeshBuilder::ellipsoid(Surface surface, const Vec3& centre, const Vec3& radii, int segments, int rings) {
  std::vector<Loop> loops;
  for (int r = 1; r < rings; ++r) {
    const double angle = -0.25 + 0.5 * r / rings;
    Loop loop = circle({0, 0, sine(angle)}, cosine(angle), segments);
    for (Vec3& p : loop) p = centre + Vec3{radii.x * p.x, radii.y * p.y, radii.z * p.z};
    loops.push_back(std::move(loop));
  }
  const Vec3 pole = {0, 0, radii.z};
  for (size_t r = 0; r + 1 < loops.size(); ++r)
    for (size_t i = 0; i < loops[r].size(); ++i) {
      const size_t j = (i + 1) % loops[r].size();
      quad(surface, loops[r][i], loops[r][j], loops[r + 1][j], loops[r + 1][i]);
    }
  fan(surface, Loop(loops.front().rbegin(), loops.front().rend()), centre - pole);
  fan(surface, loops.back(), centre + pole);
}

size_t MeshBuilder::triangleCount() const {
  size_t count = 0;
  for (const auto& indices : indices_) count += indices.size() / 3;
  return count;
}

Mesh MeshBuilder::finish(std::string name) const {
  Mesh mesh;
  mesh.name = std::move(name);
  mesh.positions = positions_;
  for (size_t s = 0; s < indices_.size(); ++s) {
    if (indices_[s].empty()) continue;
    mesh.parts.push_back({static_cast<uint32_t>(mesh.triangleCount()), static_cast<uint32_t>(indices_[s].size() / 3),
                          static_cast<uint32_t>(s)});
    mesh.indices.insert(mesh.indices.end(), indices_[s].begin(), indices_[s].end());
  }
  return mesh;
}

}  // namespace gnosphere::town

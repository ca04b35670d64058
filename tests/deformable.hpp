// SPDX-License-Identifier: Apache-2.0
// Random deformable meshes, and where their vertices should be.
#pragma once

#include <vector>

#include "gnosphere/gnosphere.hpp"
#include "support.hpp"

namespace gnosphere::test {

/// A map that turns about an axis of any direction and shifts.
inline Transform randomTurn(Random& random, double angle, double shift) {
  const Vec3 axis = {random(), random(), random()};
  const double length = std::sqrt(axis.x * axis.x + axis.y * axis.y + axis.z * axis.z) + 1e-9;
  const double c = std::cos(angle), s = std::sin(angle), t = 1 - c;
  const double x = axis.x / length, y = axis.y / length, z = axis.z / length;
  return {{t * x * x + c, t * x * y - s * z, t * x * z + s * y, shift * random(),  //
           t * x * y + s * z, t * y * y + c, t * y * z - s * x, shift * random(),  //
           t * x * z - s * y, t * y * z + s * x, t * z * z + c, shift * random()}};
}

inline Transform around(const Vec3& centre, const Transform& map) {
  return translation(centre.x, centre.y, centre.z) * map * translation(-centre.x, -centre.y, -centre.z);
}

/// A tube of 4 m whose vertices follow `influences` of the joints along it, and morph targets that bulge it.
inline Mesh limb(Random& random, uint32_t joints, uint32_t influences, uint32_t targets, const Vec3& origin = {}) {
  constexpr uint32_t kRings = 24, kSides = 10;
  MeshBuilder builder;
  for (uint32_t ring = 0; ring <= kRings; ++ring)
    for (uint32_t side = 0; side < kSides; ++side) {
      const double angle = 2 * std::numbers::pi * side / kSides, radius = 0.5 + 0.02 * random();
      builder.vertex({radius * std::cos(angle), radius * std::sin(angle), 4.0 * ring / kRings - 2});
    }
  for (uint32_t ring = 0; ring < kRings; ++ring)
    for (uint32_t side = 0; side < kSides; ++side) {
      const uint32_t a = ring * kSides + side, b = ring * kSides + (side + 1) % kSides;
      builder.triangle(a, b, a + kSides);
      builder.triangle(b, b + kSides, a + kSides);
    }
  Mesh mesh = builder.take();
  mesh.origin = origin;
  mesh.influences = influences;
  mesh.jointCount = influences > 0 ? joints : 0;
  for (uint32_t vertex = 0; influences > 0 && vertex < mesh.vertexCount(); ++vertex) {
    const double along = (double{mesh.positions[3 * vertex + 2]} + 2) / 4 * (joints - 1);
    const auto nearest = static_cast<uint32_t>(along + 0.5);
    // The weights are as inexact as a mesh's may be.
    float left = 1 + 9e-4f * static_cast<float>(random());
    for (uint32_t k = 0; k < influences; ++k) {
      mesh.joints.push_back(static_cast<uint16_t>((nearest + k) % joints));
      const float weight = k + 1 == influences ? left : left * static_cast<float>(0.6 + 0.3 * random());
      mesh.jointWeights.push_back(weight);
      left -= weight;
    }
  }
  for (uint32_t target = 0; target < targets; ++target) {
    std::vector<float>& offsets = mesh.morphTargets.emplace_back();
    for (size_t i = 0; i < mesh.positions.size(); ++i) offsets.push_back(static_cast<float>(0.1 * random()));
  }
  return mesh;
}

inline Deformation bend(Random& random, const Mesh& mesh) {
  Deformation deformation;
  for (uint32_t joint = 0; joint < mesh.jointCount; ++joint)
    deformation.joints.push_back(around(mesh.origin, randomTurn(random, 0.5 * random(), 0.3)));
  for (size_t target = 0; target < mesh.morphTargets.size(); ++target)
    deformation.morphWeights.push_back(static_cast<float>(random()));
  return deformation;
}

/// The deformed vertices in the mesh frame, in double, from the definitions in sections 3.7.2.2 and 3.7.3 of glTF 2.0.
inline std::vector<Vec3> expectedPositions(const Mesh& mesh, const Deformation& deformation) {
  std::vector<Vec3> result;
  for (size_t v = 0; v < mesh.vertexCount(); ++v) {
    double p[3];
    for (size_t axis = 0; axis < 3; ++axis) {
      p[axis] = mesh.positions[3 * v + axis];
      for (size_t t = 0; t < mesh.morphTargets.size(); ++t)
        p[axis] += double{deformation.morphWeights[t]} * mesh.morphTargets[t][3 * v + axis];
    }
    const Vec3 morphed = {mesh.origin.x + p[0], mesh.origin.y + p[1], mesh.origin.z + p[2]};
    if (mesh.influences == 0) {
      result.push_back(morphed);
      continue;
    }
    Vec3 sum, shift = mesh.origin;
    double weights = 0;
    for (size_t k = v * mesh.influences; k < (v + 1) * mesh.influences; ++k) weights += mesh.jointWeights[k];
    for (size_t k = v * mesh.influences; k < (v + 1) * mesh.influences; ++k) {
      const Vec3 moved = deformation.joints[mesh.joints[k]] * morphed;
      const double weight = mesh.jointWeights[k] / weights;
      // These sum to 1 only within rounding, so far from the origin only differences may be weighted.
      sum = {sum.x + weight * (moved.x - shift.x), sum.y + weight * (moved.y - shift.y),
             sum.z + weight * (moved.z - shift.z)};
    }
    result.push_back({shift.x + sum.x, shift.y + sum.y, shift.z + sum.z});
  }
  return result;
}

/// A floor, and limbs around the sensor, each with joints and morph targets of its own.
inline Scene limbs(Random& random, uint32_t count) {
  MeshBuilder floor;
  floor.quad({-30, -30, -3}, {60, 0, 0}, {0, 60, 0}, 4);
  Scene scene = sceneOf(floor.take());
  for (uint32_t i = 0; i < count; ++i) {
    const uint32_t influences = i % 3 == 2 ? 0 : 1 + 3 * (i % 3);
    // The clusters of a limb with 60 joints follow more of them than a subgroup of 8 has lanes.
    Mesh mesh = limb(random, i % 3 == 1 ? 60 : 5 + i, influences, influences == 0 || i % 2 == 0 ? 2 : 0);
    mesh.deformation = bend(random, mesh);
    scene.meshes.push_back(std::move(mesh));
    const double angle = 2 * std::numbers::pi * i / count;
    scene.instances.push_back({"", i + 1, translation(6 * std::cos(angle), 6 * std::sin(angle), 0.2)});
  }
  return scene;
}

}  // namespace gnosphere::test

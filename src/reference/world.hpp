// SPDX-License-Identifier: Apache-2.0
// Scene -> triangles in the world, each checked.
#pragma once

#include <vector>

#include "gnosphere/simulator.hpp"
#include "reference/bvh.hpp"

namespace gnosphere::reference {

/// Further out, in the mesh's or in the sensor's frame, a coordinate counts as broken.
inline constexpr double kFarthest = 1e9;

/// False for NaN.
inline bool within(const Vec3& p, double limit) {
  return std::abs(p.x) <= limit && std::abs(p.y) <= limit && std::abs(p.z) <= limit;
}

/// What is known of an instance before there is a pose.
struct PlacedMesh {
  double condition = 1;
  Vec3 origin;  ///< of the mesh, in the world
};

std::vector<PlacedMesh> placedMeshesOf(const Scene& scene);

/// The absolute part of a corner's error, seen from `position`: 1e-9 m, some roundings of the world's doubles (2^-53
/// each), and what is left of a pivot that is split into a float and a float remainder (2^-48) and moved through a
/// rounded matrix.
double absoluteError(const PlacedMesh& place, const Vec3& position);

/// All triangles of the scene. Those of instances that move get their velocities into `sweeps`, over a turn of `period`
/// seconds. What is dropped is counted.
std::vector<Triangle> placeAll(const Scene& scene, Faces faces, std::span<const InstanceMotion> motions, double period,
                               Sweeps& sweeps, Counters& counters);

}  // namespace gnosphere::reference

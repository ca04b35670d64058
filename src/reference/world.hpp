// SPDX-License-Identifier: Apache-2.0
// Transforms the triangles of a scene to the world and checks each.
#pragma once

#include <map>
#include <span>
#include <vector>

#include "gnosphere/simulator.hpp"
#include "reference/bvh.hpp"

namespace gnosphere::reference {

/// A coordinate beyond this, in the mesh's or in the sensor's frame, counts as invalid.
inline constexpr double kFarthest = 1e9;

/// False if a coordinate is NaN.
inline bool within(const Vec3& p, double limit) {
  return std::abs(p.x) <= limit && std::abs(p.y) <= limit && std::abs(p.z) <= limit;
}

/// Properties of an instance that do not depend on the pose.
struct PlacedMesh {
  double condition = 1;
  Vec3 origin;  ///< of the mesh, in the world
};

std::vector<PlacedMesh> placedMeshesOf(const Scene& scene);

/// Absolute part of a corner's error, seen from `position`: 1e-9 m, some roundings of the world's doubles (2^-53 each),
/// and the remainder of a pivot that is split into two floats (2^-48) and transformed by a rounded matrix.
double absoluteError(const PlacedMesh& place, const Vec3& position);

/// Instances and meshes that move during a scan, and for how long.
struct Movement {
  std::span<const InstanceMotion> instances;
  std::map<size_t, std::vector<float>> positions;  ///< by mesh: where its vertices are at the end; only if they move
  double period = 0;                               ///< seconds
};

/// Returns the triangles that a shot of a world sees, without those of ignored instances (`ignored` has a 1 for them,
/// and may be shorter than the instances). For instances that move, `sweeps` gets the corner velocities. The counters
/// of triangles become those of the world, and those that are dropped are counted.
std::vector<Triangle> placeAll(const Scene& scene, uint32_t world, ReflectingFaces faces,
                               std::span<const uint8_t> ignored, const Movement& movement, Sweeps& sweeps,
                               Counters& counters);

}  // namespace gnosphere::reference

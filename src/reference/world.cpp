// SPDX-License-Identifier: Apache-2.0
#include "reference/world.hpp"

#include <utility>

#include "base/limits.hpp"
#include "base/transform.hpp"
#include "effects/trajectory.hpp"

namespace gnosphere::reference {

namespace {

/// Beyond this, a double does not resolve a decimetre; such a coordinate is invalid from any pose.
constexpr double kFarthestWorld = 1e15;
/// A map whose determinant is at most this share of the product of its columns' lengths flattens a mesh.
constexpr double kFlatVolume = 1e-6f;  // rounded as on devices

/// Returns the velocities of an instance's vertices; none if it stands still. `end` is its transform at the end, or
/// null if that does not change.
std::vector<Vec3> velocitiesOf(const Instance& instance, const Mesh& mesh, const Transform* end,
                               const Movement& movement) {
  const auto moved = movement.positions.find(instance.mesh);
  const bool deformed = moved != movement.positions.end();
  if (!end && !deformed) return {};
  const Transform velocity = end ? velocityOf(instance.transform, *end, movement.period) : Transform{};
  std::vector<Vec3> velocities(mesh.vertexCount());
  for (size_t v = 0; v < velocities.size(); ++v) {
    const float* p = &mesh.positions[3 * v];
    const Vec3 local = mesh.origin + Vec3{p[0], p[1], p[2]};
    if (!deformed) {
      velocities[v] = velocity * local;
      continue;
    }
    const float* q = &moved->second[3 * v];
    const Vec3 last = (end ? *end : instance.transform) * (mesh.origin + Vec3{q[0], q[1], q[2]});
    velocities[v] = (1 / movement.period) * (last - instance.transform * local);
  }
  return velocities;
}

/// Transforms the triangles of one instance to the world. `velocities` are those of its vertices; none if it stands
/// still.
void placeInstance(const Scene& scene, uint32_t index, ReflectingFaces faces, const std::vector<Vec3>& velocities,
                   std::vector<Triangle>& triangles, Sweeps& sweeps, Counters& counters) {
  const Instance& instance = scene.instances[index];
  const Mesh& mesh = scene.meshes[instance.mesh];
  std::vector<Vec3> world(mesh.vertexCount());
  std::vector<uint8_t> broken(mesh.vertexCount());
  for (size_t v = 0; v < world.size(); ++v) {
    const float* p = &mesh.positions[3 * v];
    const Vec3 position = {p[0], p[1], p[2]};  // seen from the mesh's origin, as devices do
    world[v] = instance.transform * (mesh.origin + position);
    broken[v] = !within(position, kFarthest) || !within(world[v], kFarthestWorld);
  }
  const auto samePoint = [&](uint32_t a, uint32_t b) {
    const float* p = &mesh.positions[3 * size_t{a}];
    const float* q = &mesh.positions[3 * size_t{b}];
    return p[0] == q[0] && p[1] == q[1] && p[2] == q[2];
  };
  // A map that flattens the mesh does not mirror it, whichever sign rounding leaves.
  const double volume = determinant(instance.transform);
  const auto& rows = instance.transform.rows;
  double box = 1;
  for (int k = 0; k < 3; ++k) box *= lengthOf({rows[k], rows[4 + k], rows[8 + k]});
  const int8_t outside = volume < -kFlatVolume * box ? 1 : -1;
  size_t part = 0;
  for (size_t t = 0; t < mesh.triangleCount(); ++t) {
    const uint32_t* corner = &mesh.indices[3 * t];
    if (broken[corner[0]] || broken[corner[1]] || broken[corner[2]]) {
      ++counters.nonFinite;
      continue;
    }
    if (samePoint(corner[0], corner[1]) || samePoint(corner[1], corner[2]) || samePoint(corner[2], corner[0])) {
      ++counters.degenerate;
      continue;
    }
    while (part < mesh.parts.size() && t >= size_t{mesh.parts[part].firstTriangle} + mesh.parts[part].triangleCount)
      ++part;
    const bool oneSided =
        faces == ReflectingFaces::front || (faces == ReflectingFaces::material && part < mesh.parts.size() &&
                                            !scene.materials[mesh.parts[part].material].doubleSided);
    Triangle placed = {{world[corner[0]], world[corner[1]], world[corner[2]]}, index, static_cast<uint32_t>(t), 0};
    int8_t turn = outside;
    const auto order = [&](size_t a, size_t b) {
      if (!before(placed.corners[b], placed.corners[a])) return;
      std::swap(placed.corners[a], placed.corners[b]);
      std::swap(placed.order[a], placed.order[b]);
      turn = static_cast<int8_t>(-turn);
    };
    order(0, 1);
    order(1, 2);
    order(0, 1);
    if (oneSided) placed.front = turn;
    if (!velocities.empty()) {
      placed.sweep = static_cast<uint32_t>(sweeps.velocities.size());
      const auto of = [&](size_t k) { return velocities[corner[placed.order[k]]]; };
      sweeps.velocities.push_back({of(0), of(1), of(2)});
    }
    triangles.push_back(placed);
  }
}

}  // namespace

std::vector<PlacedMesh> placedMeshesOf(const Scene& scene) {
  // No single-precision simulator can use a worse matrix, and a larger error bound would only widen every beam.
  const auto worst = static_cast<double>(limits::kCondition.most);
  std::vector<PlacedMesh> places;
  for (const Instance& instance : scene.instances)
    places.push_back(instance.mesh == kNoMesh ? PlacedMesh{}
                                              : PlacedMesh{std::min(conditionOf(instance.transform), worst),
                                                           instance.transform * scene.meshes[instance.mesh].origin});
  return places;
}

double absoluteError(const PlacedMesh& place, const Vec3& position) {
  return 1e-9 + 0x1p-48 * (lengthOf(place.origin) + lengthOf(position)) + 0x1p-45 * lengthOf(place.origin - position);
}

std::vector<Triangle> placeAll(const Scene& scene, uint32_t world, ReflectingFaces faces,
                               std::span<const uint8_t> ignored, const Movement& movement, Sweeps& sweeps,
                               Counters& counters) {
  std::vector<Triangle> triangles;
  counters = {};
  const auto isSeen = [&](const Instance& instance) {
    return instance.mesh != kNoMesh && (instance.world == 0 || instance.world == world);
  };
  for (const Instance& instance : scene.instances)
    if (isSeen(instance)) counters.triangles += scene.meshes[instance.mesh].triangleCount();
  triangles.reserve(counters.triangles);
  std::vector<const Transform*> ends(scene.instances.size());
  for (const InstanceMotion& motion : movement.instances) ends[motion.instance] = &motion.end;
  for (uint32_t i = 0; i < scene.instances.size(); ++i) {
    if (!isSeen(scene.instances[i]) || (i < ignored.size() && ignored[i])) continue;
    const Instance& instance = scene.instances[i];
    const std::vector<Vec3> velocities = velocitiesOf(instance, scene.meshes[instance.mesh], ends[i], movement);
    placeInstance(scene, i, faces, velocities, triangles, sweeps, counters);
  }
  return triangles;
}

}  // namespace gnosphere::reference

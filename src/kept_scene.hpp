// SPDX-License-Identifier: Apache-2.0
// The parts of the scene that a simulator keeps, and its changes.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "base/index_pool.hpp"
#include "effects/sensor_plan.hpp"
#include "gnosphere/simulator.hpp"
#include "pipeline/backend.hpp"
#include "scan/class_table.hpp"

namespace gnosphere {

/// The materials, meshes and instances of a simulator without their vertices and triangles, which the backend keeps.
/// Each change allocates what it needs first, then changes the backend, which may fail, and then notes the change,
/// which cannot. Changes throw Error as the functions of Simulator with their names do.
class KeptScene {
 public:
  /// Throws Error(invalidArgument) if the scene is wrong. `planner` shares the textures of the scene.
  KeptScene(const Scene& scene, SensorPlanner& planner);
  /// Sets the backend that changes go to.
  void changeIn(Backend& backend) { backend_ = &backend; }

  /// Meshes have only their parts, and instances only their mesh and world.
  const Scene& scene() const { return scene_; }
  const ClassTable& classes() const { return classes_; }
  /// Whether the visible materials, or what else sensors are planned for, may have changed since the last setPlanned().
  bool isStale() const { return stale_; }
  void setStale() { stale_ = true; }
  void setPlanned() { stale_ = false; }

  bool hasInstance(size_t instance) const { return instances_.has(instance); }
  /// Throw Error(invalidArgument), whose message begins with `which`, if an instance does not exist or a shot moves
  /// what cannot move.
  void checkInstance(size_t instance, const std::string& which) const { instances_.check(instance, which); }
  void checkMotions(const Shot& shot, const std::string& which) const;

  size_t addMaterial(Material material, const AlphaImage* image);
  void setMaterial(size_t index, Material material, const AlphaImage* image);
  void removeMaterial(size_t index);
  size_t addMesh(const Mesh& mesh);
  void removeMesh(size_t index);
  void setPositions(size_t mesh, std::span<const float> positions);
  void setDeformation(size_t mesh, const Deformation& deformation);
  void setVertices(size_t mesh, const CallerVertices& buffer);
  void setTransforms(const CallerTransforms& buffer);
  size_t addInstance(uint32_t mesh, const Transform& transform, uint16_t classId, uint32_t world);
  std::vector<uint32_t> addInstances(std::span<const Instance> instances);
  AddedScene addScene(const Scene& scene, const Transform& transform);
  void removeInstance(size_t index);
  void removeInstances(std::span<const uint32_t> instances);
  void setTransform(size_t instance, const Transform& transform);
  void setTransforms(std::span<const uint32_t> instances, std::span<const double> values);
  void setTransforms(std::span<const uint32_t> instances, std::span<const float> values);

 private:
  struct KeptMesh {
    Mesh mesh;  // without its vertices and triangles
    size_t vertexCount;
    ClassTable::Runs classes;
  };

  bool ownsImage(size_t material) const;
  std::vector<uint32_t> unusedImages(size_t count);
  uint64_t trianglesOf(size_t mesh) const;
  void checkDeformation(size_t mesh, const Deformation& deformation, const std::string& which) const;
  template <typename Exchange>
  void changeMaterials(const Exchange& exchange);
  KeptMesh keptOf(const Mesh& mesh);
  void keep(KeptMesh kept);
  void reserveInstance();
  size_t keep(uint32_t mesh, uint16_t classId, uint32_t world);
  void move(std::span<const uint32_t> instances, std::span<const Transform> transforms);
  template <typename T>
  void moveAll(std::span<const uint32_t> instances, std::span<const T> values);

  SensorPlanner& planner_;
  Backend* backend_ = nullptr;
  Scene scene_;
  IndexPool materials_{"material"}, meshes_{"mesh"}, instances_{"instance"};
  std::vector<size_t> vertexCounts_;  // by mesh
  uint64_t placedTriangles_ = 0;
  ClassTable classes_;
  std::vector<Transform> transforms_;  // of the last setTransforms(); its memory is used again
  std::vector<uint8_t> inBuffer_;      // by instance: 1 if its transform comes from a buffer
  bool stale_ = false;
};

}  // namespace gnosphere

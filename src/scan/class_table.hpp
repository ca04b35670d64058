// SPDX-License-Identifier: Apache-2.0
// The semantic classes of surfaces: that of the material where it states one, else that of the instance.
#pragma once

#include <vector>

#include "base/room.hpp"
#include "common/records.h"
#include "gnosphere/scene.hpp"

namespace gnosphere {

/// Keeps the classes of a scene that changes. Costs nothing per triangle: a mesh has runs of triangles with one class.
class ClassTable {
 public:
  using Runs = std::vector<gpu::ClassRun>;
  /// The runs of a mesh. Its materials must not change their classes while the mesh is there.
  static Runs runsOf(const std::vector<MeshPart>& parts, const std::vector<Material>& materials);
  /// Make room, so that setting a mesh or an instance up to this index cannot throw.
  void reserveMesh(size_t mesh) { makeRoom(meshes_, mesh + 1); }
  void reserveInstance(size_t instance) { makeRoom(instances_, instance + 1); }
  void setMesh(size_t mesh, Runs runs);
  void setInstance(size_t instance, uint32_t mesh, uint16_t classId);

  /// Returns the class of a triangle of an instance's mesh; 0 for an instance that never was there.
  uint16_t classOf(uint32_t instance, uint32_t triangle) const;

  /// The table as kernels read it: entries by instance, which refer to the runs of all meshes.
  struct Packed {
    std::vector<gpu::InstanceClass> instances;
    std::vector<gpu::ClassRun> runs;
  };
  Packed packed() const;

 private:
  struct Placed {
    uint32_t mesh;
    uint16_t classId;
  };
  std::vector<Placed> instances_;
  std::vector<Runs> meshes_;  // by mesh; empty if no material of it states a class
};

}  // namespace gnosphere

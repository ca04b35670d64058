// SPDX-License-Identifier: Apache-2.0
// A scene as acceleration structures: one or more per mesh, and one over the instances (the top structure).
#pragma once

#include <span>
#include <vector>

#include "rivals/rival.hpp"
#include "rivals/vulkan_device.hpp"

namespace gnosphere::bench {

/// Destroys the structures that it holds.
struct StructureHandles {
  ~StructureHandles();
  VkDevice device;
  std::vector<VkAccelerationStructureKHR> all;
};

class RayStructure {
 public:
  /// Uploads the geometry and allocates the structures and their scratch, without building them. Instances are placed
  /// relative to `origin`, in single precision. Throws Error(outOfMemory) if the device lacks memory.
  RayStructure(RayDevice& device, const Scene& scene, const Vec3& origin, Motion motion);

  void move(std::span<const Moved> moved);
  void recordMeshes(VkCommandBuffer commands) const {
    recordMeshes(commands, VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR);
  }
  /// Updates the boxes after vertices have moved; only for Motion::everything, and after recordMeshes().
  void recordRefit(VkCommandBuffer commands) const {
    recordMeshes(commands, VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR);
  }
  /// Rebuilds the top structure, which is never refitted, because it has few leaves.
  void recordTop(VkCommandBuffer commands) const;

  VkAccelerationStructureKHR top() const { return top_; }
  /// Per entry of the top structure: the number of its first triangle within the mesh, and the scene's instance.
  VkDeviceAddress placements() const { return placements_.address(); }
  uint64_t bytes() const;

 private:
  // A run of a mesh's triangles: the whole mesh, unless its structure would exceed the largest allocation.
  struct Part {
    VkAccelerationStructureGeometryKHR geometry;
    uint32_t firstTriangle, triangleCount;
    VkAccelerationStructureKHR structure;
    uint64_t structureBytes, scratchBytes;
    uint64_t scratchOffset;
    VkDeviceAddress address;
  };
  // Parts that are built at once, each with its own scratch memory.
  struct Batch {
    size_t firstPart, partCount;
  };
  struct MeshParts {
    size_t first = 0, count = 0;
    Vec3 origin;
  };
  struct Entries {
    uint32_t mesh;
    size_t first;
  };

  void addMesh(const Mesh& mesh);
  bool fits(Part& part) const;
  void createParts();
  void createTop(const Scene& scene);
  void place(size_t instance, const Transform& transform);
  void recordMeshes(VkCommandBuffer commands, VkBuildAccelerationStructureModeKHR mode) const;
  VkAccelerationStructureKHR create(VkAccelerationStructureTypeKHR type, uint64_t bytes);
  VkAccelerationStructureBuildSizesInfoKHR sizesOf(VkAccelerationStructureTypeKHR type,
                                                   const VkAccelerationStructureGeometryKHR& geometry,
                                                   uint32_t count) const;
  VkAccelerationStructureBuildGeometryInfoKHR buildInfo(VkAccelerationStructureTypeKHR type,
                                                        const VkAccelerationStructureGeometryKHR& geometry) const;

  RayDevice& device_;
  Motion motion_;
  Vec3 origin_;
  Arena inputs_, structures_;
  StructureHandles handles_;
  std::vector<Part> parts_;
  std::vector<Batch> batches_;
  std::vector<MeshParts> meshes_;
  std::vector<Entries> instances_;
  uint32_t entryCount_ = 0;
  RayBuffer entries_, placements_, scratch_;
  uint64_t scratchBytes_ = 0;
  VkAccelerationStructureGeometryKHR topGeometry_ = {};
  VkAccelerationStructureKHR top_ = VK_NULL_HANDLE;
};

}  // namespace gnosphere::bench

// SPDX-License-Identifier: Apache-2.0
#include "rivals/vulkan_structure.hpp"

#include <algorithm>

namespace gnosphere::bench {
namespace {

constexpr VkAccelerationStructureTypeKHR kBottom = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR;
constexpr VkAccelerationStructureTypeKHR kTop = VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR;

/// Meshes are built in batches up to this much scratch memory: it fills a device but is little compared with its
/// memory.
constexpr uint64_t kScratchBytes = 256 << 20;

VkBuildAccelerationStructureFlagsKHR flagsOf(VkAccelerationStructureTypeKHR type, Motion motion) {
  if (motion == Motion::none || (motion == Motion::transforms && type == kBottom))
    return VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR;
  if (motion == Motion::everything && type == kBottom)
    return VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_BUILD_BIT_KHR |
           VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR;
  return VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_BUILD_BIT_KHR;
}

uint64_t alignUp(uint64_t value, uint64_t alignment) {
  return (value + alignment - 1) / alignment * alignment;
}

struct Placement {
  uint32_t firstTriangle, instance;
};

}  // namespace

RayStructure::RayStructure(RayDevice& device, const Scene& scene, const Vec3& origin, Motion motion)
    : device_(device),
      motion_(motion),
      origin_(origin),
      inputs_(device, "triangles"),
      structures_(device, "acceleration structures"),
      handles_{device.handle(), {}} {
  for (const Mesh& mesh : scene.meshes) addMesh(mesh);
  createParts();
  createTop(scene);
  // The address of a buffer may be less aligned than scratch memory must be.
  scratch_ = RayBuffer(device_, "scratch", scratchBytes_ + device_.scratchAlignment(), MemoryKind::device);
  device_.throwOnMessages();
}

StructureHandles::~StructureHandles() {
  for (VkAccelerationStructureKHR structure : all) vkDestroyAccelerationStructureKHR(device, structure, nullptr);
}

void RayStructure::addMesh(const Mesh& mesh) {
  const size_t firstPart = parts_.size();
  if (mesh.triangleCount() > 0) {
    const Slice vertices = inputs_.take(mesh.positions.size() * sizeof(float));
    const Slice indices = inputs_.take(mesh.indices.size() * sizeof(uint32_t));
    device_.write(vertices, mesh.positions.data(), vertices.bytes);
    device_.write(indices, mesh.indices.data(), indices.bytes);
    Part part = {};
    part.geometry = {VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR};
    part.geometry.geometryType = VK_GEOMETRY_TYPE_TRIANGLES_KHR;
    part.geometry.flags = VK_GEOMETRY_OPAQUE_BIT_KHR;
    VkAccelerationStructureGeometryTrianglesDataKHR& triangles = part.geometry.geometry.triangles;
    triangles = {VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_TRIANGLES_DATA_KHR};
    triangles.vertexFormat = VK_FORMAT_R32G32B32_SFLOAT;
    triangles.vertexData.deviceAddress = vertices.address();
    triangles.vertexStride = 3 * sizeof(float);
    triangles.maxVertex = static_cast<uint32_t>(mesh.vertexCount() - 1);
    triangles.indexType = VK_INDEX_TYPE_UINT32;
    const uint32_t triangleCount = static_cast<uint32_t>(mesh.triangleCount());
    part.triangleCount = triangleCount;
    while (!fits(part)) part.triangleCount = (part.triangleCount + 1) / 2;
    for (uint32_t first = 0; first < triangleCount; first += part.triangleCount) {
      Part& added = parts_.emplace_back(part);
      added.firstTriangle = first;
      added.triangleCount = std::min(part.triangleCount, triangleCount - first);
      added.geometry.geometry.triangles.indexData.deviceAddress = indices.address() + 12 * uint64_t{first};
    }
  }
  meshes_.push_back({firstPart, parts_.size() - firstPart, mesh.origin});
}

bool RayStructure::fits(Part& part) const {
  const VkAccelerationStructureBuildSizesInfoKHR sizes = sizesOf(kBottom, part.geometry, part.triangleCount);
  part.structureBytes = sizes.accelerationStructureSize;
  part.scratchBytes = std::max(sizes.buildScratchSize, sizes.updateScratchSize);
  // Half of the limit leaves room for alignment and for the other parts of a batch.
  return std::max(part.structureBytes, part.scratchBytes) <= device_.maxAllocationBytes() / 2 ||
         part.triangleCount == 1;
}

void RayStructure::createParts() {
  const uint64_t most = std::min(kScratchBytes, device_.maxAllocationBytes() / 2);
  uint64_t offset = 0;
  for (size_t i = 0; i < parts_.size(); ++i) {
    Part& part = parts_[i];
    part.structure = create(kBottom, part.structureBytes);
    VkAccelerationStructureDeviceAddressInfoKHR info = {
        VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_DEVICE_ADDRESS_INFO_KHR};
    info.accelerationStructure = part.structure;
    part.address = vkGetAccelerationStructureDeviceAddressKHR(device_.handle(), &info);
    const uint64_t bytes = alignUp(part.scratchBytes, device_.scratchAlignment());
    if (i == 0 || offset + bytes > most) {
      batches_.push_back({i, 0});
      offset = 0;
    }
    ++batches_.back().partCount;
    part.scratchOffset = offset;
    offset += bytes;
    scratchBytes_ = std::max(scratchBytes_, offset);
  }
}

void RayStructure::createTop(const Scene& scene) {
  std::vector<Placement> placements;
  for (uint32_t i = 0; i < scene.instances.size(); ++i) {
    const MeshParts& parts = meshes_[scene.instances[i].mesh];
    instances_.push_back({scene.instances[i].mesh, placements.size()});
    for (size_t p = 0; p < parts.count; ++p) placements.push_back({parts_[parts.first + p].firstTriangle, i});
  }
  entryCount_ = static_cast<uint32_t>(placements.size());
  entries_ =
      RayBuffer(device_, "instances", entryCount_ * sizeof(VkAccelerationStructureInstanceKHR), MemoryKind::upload);
  for (size_t i = 0; i < scene.instances.size(); ++i) place(i, scene.instances[i].transform);
  const uint64_t bytes = placements.size() * sizeof(Placement);
  placements_ = RayBuffer(device_, "placements", bytes, MemoryKind::device);
  device_.write({&placements_, 0, bytes}, placements.data(), bytes);
  topGeometry_ = {VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR};
  topGeometry_.geometryType = VK_GEOMETRY_TYPE_INSTANCES_KHR;
  topGeometry_.flags = VK_GEOMETRY_OPAQUE_BIT_KHR;
  topGeometry_.geometry.instances = {VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_INSTANCES_DATA_KHR};
  topGeometry_.geometry.instances.data.deviceAddress = entries_.address();
  const VkAccelerationStructureBuildSizesInfoKHR sizes = sizesOf(kTop, topGeometry_, entryCount_);
  top_ = create(kTop, sizes.accelerationStructureSize);
  scratchBytes_ = std::max(scratchBytes_, sizes.buildScratchSize);
}

void RayStructure::move(std::span<const Moved> moved) {
  for (const Moved& move : moved) place(move.instance, move.transform);
}

void RayStructure::place(size_t instance, const Transform& transform) {
  const MeshParts& parts = meshes_[instances_[instance].mesh];
  const Vec3 at = transform * parts.origin;  // the origin of the mesh's vertices
  const double translation[3] = {at.x - origin_.x, at.y - origin_.y, at.z - origin_.z};
  VkAccelerationStructureInstanceKHR entry = {};
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column)
      entry.transform.matrix[row][column] = static_cast<float>(transform.rows[4 * row + column]);
    entry.transform.matrix[row][3] = static_cast<float>(translation[row]);
  }
  entry.mask = 0xff;
  auto* entries = static_cast<VkAccelerationStructureInstanceKHR*>(entries_.mapped()) + instances_[instance].first;
  for (size_t p = 0; p < parts.count; ++p) {
    entry.accelerationStructureReference = parts_[parts.first + p].address;
    entries[p] = entry;
  }
}

void RayStructure::recordMeshes(VkCommandBuffer commands, VkBuildAccelerationStructureModeKHR mode) const {
  const VkDeviceAddress scratch = alignUp(scratch_.address(), device_.scratchAlignment());
  for (const Batch& batch : batches_) {
    std::vector<VkAccelerationStructureBuildGeometryInfoKHR> builds;
    std::vector<VkAccelerationStructureBuildRangeInfoKHR> ranges;
    std::vector<const VkAccelerationStructureBuildRangeInfoKHR*> rangePointers;
    ranges.reserve(batch.partCount);
    for (const Part& part : std::span(parts_).subspan(batch.firstPart, batch.partCount)) {
      VkAccelerationStructureBuildGeometryInfoKHR build = buildInfo(kBottom, part.geometry);
      build.mode = mode;
      build.srcAccelerationStructure =
          mode == VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR ? part.structure : VK_NULL_HANDLE;
      build.dstAccelerationStructure = part.structure;
      build.scratchData.deviceAddress = scratch + part.scratchOffset;
      builds.push_back(build);
      ranges.push_back({part.triangleCount, 0, 0, 0});
      rangePointers.push_back(&ranges.back());
    }
    vkCmdBuildAccelerationStructuresKHR(commands, static_cast<uint32_t>(builds.size()), builds.data(),
                                        rangePointers.data());
    barrier(commands);
  }
}

void RayStructure::recordTop(VkCommandBuffer commands) const {
  VkAccelerationStructureBuildGeometryInfoKHR build = buildInfo(kTop, topGeometry_);
  build.dstAccelerationStructure = top_;
  build.scratchData.deviceAddress = alignUp(scratch_.address(), device_.scratchAlignment());
  const VkAccelerationStructureBuildRangeInfoKHR range = {entryCount_, 0, 0, 0};
  const VkAccelerationStructureBuildRangeInfoKHR* ranges = &range;
  vkCmdBuildAccelerationStructuresKHR(commands, 1, &build, &ranges);
}

VkAccelerationStructureKHR RayStructure::create(VkAccelerationStructureTypeKHR type, uint64_t bytes) {
  const Slice slice = structures_.take(bytes);
  VkAccelerationStructureCreateInfoKHR info = {VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_CREATE_INFO_KHR};
  info.buffer = slice.buffer->handle();
  info.offset = slice.offset;
  info.size = bytes;
  info.type = type;
  VkAccelerationStructureKHR structure;
  VK(vkCreateAccelerationStructureKHR(device_.handle(), &info, nullptr, &structure));
  handles_.all.push_back(structure);
  return structure;
}

VkAccelerationStructureBuildSizesInfoKHR RayStructure::sizesOf(VkAccelerationStructureTypeKHR type,
                                                               const VkAccelerationStructureGeometryKHR& geometry,
                                                               uint32_t count) const {
  const VkAccelerationStructureBuildGeometryInfoKHR build = buildInfo(type, geometry);
  VkAccelerationStructureBuildSizesInfoKHR sizes = {VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_SIZES_INFO_KHR};
  vkGetAccelerationStructureBuildSizesKHR(device_.handle(), VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR, &build,
                                          &count, &sizes);
  return sizes;
}

VkAccelerationStructureBuildGeometryInfoKHR RayStructure::buildInfo(
    VkAccelerationStructureTypeKHR type, const VkAccelerationStructureGeometryKHR& geometry) const {
  VkAccelerationStructureBuildGeometryInfoKHR build = {
      VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_GEOMETRY_INFO_KHR};
  build.type = type;
  build.flags = flagsOf(type, motion_);
  build.mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR;
  build.geometryCount = 1;
  build.pGeometries = &geometry;
  return build;
}

uint64_t RayStructure::bytes() const {
  return inputs_.bytes() + structures_.bytes() + entries_.bytes() + placements_.bytes() + scratch_.bytes();
}

}  // namespace gnosphere::bench

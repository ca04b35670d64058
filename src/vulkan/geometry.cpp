// SPDX-License-Identifier: Apache-2.0
#include "vulkan/geometry.hpp"

namespace gnosphere::vulkan {

Geometry::Geometry(const Device& device, const Scene& scene, bool surfaces, bool holes)
    : device_(device), packed_(scene, device.maxBufferBytes()), instances_(device, surfaces) {
  Uploader uploader(device);
  for (size_t i = 0; i < packed_.count(); ++i) {
    const ChunkArrays arrays = packed_.arrays(i);
    GeometryChunk chunk;
    chunk.groups = uploader.upload<gpu::Group>("groups", arrays.groups);
    chunk.clusters = uploader.upload<gpu::Cluster>("clusters", arrays.clusters);
    chunk.positions = uploader.upload<float>("positions", arrays.positions);
    chunk.triangleCorners = uploader.upload<FlatTriangle>("triangleCorners", arrays.triangleCorners);
    if (surfaces) addSurfaces(uploader, packed_.surfaces(i, scene, holes), chunk);
    chunks_.push_back(std::move(chunk));
  }
  packed_.dropArrays();
  packed_.addTo(instances_, scene);
}

void Geometry::addSurfaces(Uploader& uploader, ChunkSurfaces surfaces, GeometryChunk& chunk) {
  if (const uint64_t bytes = surfaces.trianglePlaces.size() * sizeof(uint32_t); bytes > device_.maxBufferBytes())
    throw Error(ErrorCode::outOfMemory, "effects that look at surfaces need a table of " + std::to_string(bytes) +
                                            " bytes, the device allows " + std::to_string(device_.maxBufferBytes()) +
                                            "; split the scene's largest mesh");
  chunk.clusterMaterials = uploader.upload<uint32_t>("clusterMaterials", surfaces.clusterMaterials);
  chunk.meshPlaces = uploader.upload<uint32_t>("meshPlaces", surfaces.meshPlaces);
  chunk.trianglePlaces = uploader.upload<uint32_t>("trianglePlaces", surfaces.trianglePlaces);
  if (!surfaces.textureCoordinates.empty())
    chunk.textureCoordinates = uploader.upload<float>("textureCoordinates", surfaces.textureCoordinates);
  meshPlaces_.push_back(std::move(surfaces.meshPlaces));
}

void Geometry::setPositions(size_t mesh, std::span<const float> positions) {
  Uploader uploader(device_);
  packed_.setPositions(
      mesh, positions, instances_,
      [&](const ChunkPart& part, size_t count) {
        return uploader.read<FlatTriangle>(chunks_[part.chunk].triangleCorners, part.triangle, count);
      },
      [&](const ChunkPart& part, const ChunkArrays& arrays) {
        GeometryChunk& chunk = chunks_[part.chunk];
        uploader.write<gpu::Group>(arrays.groups, chunk.groups, part.group);
        uploader.write<gpu::Cluster>(arrays.clusters, chunk.clusters, part.cluster);
        uploader.write<float>(arrays.positions, chunk.positions, 3 * part.vertex);
        uploader.write<FlatTriangle>(arrays.triangleCorners, chunk.triangleCorners, part.triangle);
        if (meshPlaces_.empty()) return;
        const uint32_t first = meshPlaces_[part.chunk][mesh];
        auto places = uploader.read<uint32_t>(chunk.trianglePlaces, first, instances_.mesh(mesh).triangles);
        packed_.placeTriangles(part, arrays.triangleCorners, places);
        uploader.write<uint32_t>(places, chunk.trianglePlaces, first);
      });
}

uint64_t Geometry::bytes() const {
  uint64_t sum = 0;
  for (const GeometryChunk& chunk : chunks_)
    sum += chunk.groups.bytes() + chunk.clusters.bytes() + chunk.positions.bytes() + chunk.triangleCorners.bytes() +
           chunk.clusterMaterials.bytes() + chunk.meshPlaces.bytes() + chunk.trianglePlaces.bytes() +
           chunk.textureCoordinates.bytes();
  return sum;
}

}  // namespace gnosphere::vulkan

// SPDX-License-Identifier: Apache-2.0
// The device arrays of a scene: its meshes, and per scan its instances.
#pragma once

#include "geometry/packed_geometry.hpp"
#include "pipeline/machine.hpp"

namespace gnosphere {

/// Makes room for `bytes` bytes. Existing memory that is too small is replaced with some reserve, so that a growing
/// scene does not allocate with every scan. The old content is lost.
void makeRoom(Machine& machine, gpu::Array array, uint64_t bytes, MemoryKind kind,
              std::unique_ptr<DeviceMemory>& memory);
/// Makes room for `bytes` bytes of the kind `upload`, and writes the data to their start.
void load(Machine& machine, gpu::Array array, uint64_t bytes, std::span<const std::byte> data,
          std::unique_ptr<DeviceMemory>& memory);
/// Allocates memory and writes the data to it.
template <typename T>
std::unique_ptr<DeviceMemory> uploaded(Machine& machine, gpu::Array array, std::span<const T> data) {
  auto memory = machine.allocate(gpu::nameOf(array), data.size_bytes(), MemoryKind::device);
  memory->write(0, std::as_bytes(data));
  return memory;
}

/// The instances that one scan in flight places.
class PlacedArrays {
 public:
  const PlacedGroups& groups() const { return groups_; }
  /// The instances of several views, entry by entry.
  std::span<const InstanceTable::InView> inViews() const { return inViews_.entries; }
  void bind(BoundArrays& arrays) const;
  uint64_t bytes() const;

 private:
  friend class SceneArrays;
  PlacedGroups groups_;
  std::unique_ptr<DeviceMemory> instances_;  // gpu::Instance; only firstTriangle is valid for instances out of range
  std::unique_ptr<DeviceMemory> placed_;     // (instance, group) pairs of the instances in range
  std::unique_ptr<DeviceMemory> meshes_;     // mesh of each instance, if kernels ask for it
  std::unique_ptr<DeviceMemory> views_;      // view of each instance, if there are several views
  std::unique_ptr<DeviceMemory> numbers_;    // with several views: number of each instance in the scene, if kernels ask
  InstanceTable::InViews inViews_;
  std::unique_ptr<DeviceMemory> ownerRanges_;  // see TriangleNumbers::ownerRanges()
  // Of deformable meshes: gpu::Deformer per mesh, rows of the joints' maps, weights of the morph targets.
  std::unique_ptr<DeviceMemory> deformers_, jointRows_, morphWeights_;
  uint64_t deformation_ = 0;  // Deformables::version() when these three were written
  uint64_t numbering_ = 0;    // version of the TriangleNumbers that were written
};

class SceneArrays final : public SceneMemory {
 public:
  explicit SceneArrays(Machine& machine) : machine_(machine), geometry_(*this, instances_) {}

  InstanceTable& instances() { return instances_; }
  const InstanceTable& instances() const { return instances_; }
  /// While meshes are changed, no scan may be running.
  PackedGeometry& geometry() { return geometry_; }
  const PackedGeometry& geometry() const { return geometry_; }
  uint64_t bytes() const;
  void bind(BoundArrays& arrays) const;
  /// Writes the instance arrays for a scan of the selected instances within reach (metres).
  void place(const Pose& pose, double reach, const Selection& selection, PlacedArrays& to);
  /// The same for a submission of several views, which see all instances of their worlds within reach of their poses.
  /// `numbered` tells whether kernels ask for the instances' numbers in the scene.
  void place(std::span<const ViewPlace> views, double reach, std::span<const uint8_t> ignored, bool numbered,
             PlacedArrays& to);
  /// The most bytes that a view of the world takes in lists of instances, groups and clusters, and of the instances'
  /// motions if something moves.
  uint64_t bytesOfView(uint32_t world, bool moves) const;
  /// Returns whether the lists of visible groups and clusters, which all scans share, have room for everything placed.
  bool listsHold(const PlacedArrays& placed) const;
  /// Grows these lists; no scan may be running.
  void growLists(const PlacedArrays& placed);

  /// Whether the scene has deformable meshes.
  bool deformed() const { return geometry_.deformables().any(); }

  void reserve(gpu::Array array, uint64_t bytes) override;
  void prepareWrite(gpu::Array array, uint64_t place, uint64_t bytes) override;
  void write(gpu::Array array, uint64_t place, std::span<const std::byte> data) override;
  void read(gpu::Array array, uint64_t place, std::span<std::byte> data) const override;

 private:
  void placeDeformations(PlacedArrays& to);
  const std::unique_ptr<DeviceMemory>& of(gpu::Array array) const { return memory_[static_cast<size_t>(array)]; }
  std::unique_ptr<DeviceMemory>& of(gpu::Array array) { return memory_[static_cast<size_t>(array)]; }

  Machine& machine_;
  InstanceTable instances_;
  std::array<std::unique_ptr<DeviceMemory>, gpu::kArrayCount> memory_;
  PackedGeometry geometry_;
};

}  // namespace gnosphere

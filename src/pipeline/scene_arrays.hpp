// SPDX-License-Identifier: Apache-2.0
// The scene on a device: its meshes, and its instances as each scan sees them.
#pragma once

#include "geometry/packed_geometry.hpp"
#include "pipeline/machine.hpp"

namespace gnosphere {

/// Makes room for `bytes`, and some more where the memory was there already: a scene that grows does not allocate with
/// every scan. What the memory held is lost.
void makeRoom(Machine& machine, gpu::Array array, uint64_t bytes, MemoryKind kind,
              std::unique_ptr<DeviceMemory>& memory);
/// A new memory with the data.
template <typename T>
std::unique_ptr<DeviceMemory> uploaded(Machine& machine, gpu::Array array, std::span<const T> data) {
  auto memory = machine.allocate(gpu::nameOf(array), data.size_bytes(), MemoryKind::device);
  memory->write(0, std::as_bytes(data));
  return memory;
}

/// The instances as one scan in flight sees them.
class PlacedArrays {
 public:
  const PlacedGroups& groups() const { return groups_; }
  void bind(BoundArrays& arrays) const;
  uint64_t bytes() const;

 private:
  friend class SceneArrays;
  PlacedGroups groups_;
  std::unique_ptr<DeviceMemory> instances_;    // gpu::Instance; of those out of range only the first triangle counts
  std::unique_ptr<DeviceMemory> placed_;       // (instance, group) pairs of the instances in range
  std::unique_ptr<DeviceMemory> meshes_;       // of each instance, where surfaces are looked at
  std::unique_ptr<DeviceMemory> ownerRanges_;  // see InstanceTable::writeOwnerRanges()
  uint64_t numbering_ = 0;                     // of the placed triangles, see InstanceTable
};

class SceneArrays final : public SceneMemory {
 public:
  explicit SceneArrays(Machine& machine) : machine_(machine), geometry_(*this, instances_) {}

  InstanceTable& instances() { return instances_; }
  const InstanceTable& instances() const { return instances_; }
  /// The device must not be using the scene while meshes change.
  PackedGeometry& geometry() { return geometry_; }
  const PackedGeometry& geometry() const { return geometry_; }
  uint64_t bytes() const;
  void bind(BoundArrays& arrays) const;
  /// Writes what a scan of the selected instances within reach (metres) reads.
  void place(const Pose& pose, double reach, const Selection& selection, PlacedArrays& to);
  /// Whether the lists of what a scan sees have room for all that is placed. All scans use them in turn.
  bool listsHold(const PlacedArrays& placed) const;
  /// The device must not be using them.
  void growLists(const PlacedArrays& placed);

  void reserve(gpu::Array array, uint64_t bytes) override;
  void write(gpu::Array array, uint64_t place, std::span<const std::byte> data) override;
  void read(gpu::Array array, uint64_t place, std::span<std::byte> data) const override;

 private:
  const std::unique_ptr<DeviceMemory>& of(gpu::Array array) const { return memory_[static_cast<size_t>(array)]; }
  std::unique_ptr<DeviceMemory>& of(gpu::Array array) { return memory_[static_cast<size_t>(array)]; }

  Machine& machine_;
  InstanceTable instances_;
  std::array<std::unique_ptr<DeviceMemory>, gpu::kArrayCount> memory_;
  PackedGeometry geometry_;
};

}  // namespace gnosphere

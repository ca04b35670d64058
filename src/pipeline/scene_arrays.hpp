// SPDX-License-Identifier: Apache-2.0
// The device arrays of a scene: its meshes, and per scan its instances.
#pragma once

#include "geometry/packed_geometry.hpp"
#include "pipeline/array_table.hpp"

namespace gnosphere {

/// The instances that one scan in flight places.
class PlacedArrays {
 public:
  const PlacedGroups& groups() const { return groups_; }
  /// The instances of several views, entry by entry.
  std::span<const InstanceTable::InView> inViews() const { return inViews_.entries; }
  void bind(BoundArrays& arrays) const { arrays_.bind(arrays); }
  uint64_t bytes() const { return arrays_.bytes(); }

 private:
  friend class SceneArrays;
  PlacedGroups groups_;
  // `instances`, of which only firstTriangle is valid for instances out of range; `placed`, the (instance, group) pairs
  // of those in range; `ownerRanges`, see TriangleNumbers::ownerRanges(). If kernels ask for them, there are
  // `instanceMeshes`, and with several views `instanceNumbers`, which count in the scene. Several views have
  // `instanceViews`, deformable meshes `deformers`, `jointRows` and `morphWeights`.
  ArrayTable arrays_;
  InstanceTable::InViews inViews_;
  uint64_t deformation_ = 0;  // Deformables::version() when those of deformable meshes were written
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
  uint64_t bytes() const { return arrays_.bytes(); }
  void bind(BoundArrays& arrays) const { arrays_.bind(arrays); }
  /// Writes the instance arrays for a scan of the selected instances within reach (metres).
  void place(const Pose& pose, double reach, const Selection& selection, PlacedArrays& to);
  /// The same for a submission of several views, which see all instances of their worlds within reach of their poses.
  /// `numbered` tells whether kernels ask for the instances' numbers in the scene.
  void place(std::span<const ViewPlace> views, double reach, std::span<const uint8_t> ignoredBySensor, bool numbered,
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

  Machine& machine_;
  InstanceTable instances_;
  ArrayTable arrays_;
  PackedGeometry geometry_;
};

}  // namespace gnosphere

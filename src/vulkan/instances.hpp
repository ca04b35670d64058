// SPDX-License-Identifier: Apache-2.0
// The placed instances in memory that a Vulkan device reads.
#pragma once

#include "geometry/instance_table.hpp"
#include "vulkan/buffer.hpp"

namespace gnosphere::vulkan {

/// The instances as one scan sees them, in memory that the host writes.
struct PlacedInstances : PlacedGroups {
  Buffer instances;        ///< gpu::Instance each; of those out of range only the number of the first triangle counts
  Buffer placed;           ///< (instance, group) pairs of the instances in range, chunk by chunk, the still ones first
  Buffer meshes;           ///< of each instance, where surfaces are looked at
  Buffer ownerRanges;      ///< per kOwnerBlock placed triangles: the first and the last instance among them
  uint64_t numbering = 0;  ///< of the placed triangles, see InstanceTable

  uint64_t bytes() const { return instances.bytes() + placed.bytes() + meshes.bytes() + ownerRanges.bytes(); }
};

/// Where the device lists what it sees of one chunk; all scans use them in turn. They have room for everything in range
/// of the scans so far.
struct VisibleLists {
  Buffer groups, clusters;

  bool hold(const PlacedInstances& placed) const;
  /// The device must not be using them.
  void makeRoomFor(const PlacedInstances& placed, const Device& device);
  uint64_t bytes() const { return groups.bytes() + clusters.bytes(); }
};

class Instances : public InstanceTable {
 public:
  /// `surfaces`: PlacedInstances::meshes is wanted.
  Instances(const Device& device, bool surfaces) : device_(device), surfaces_(surfaces) {}

  /// Writes what a scan of the selected instances within reach (metres) reads.
  void place(const Pose& pose, double reach, const Selection& selection, PlacedInstances& to);

 private:
  const Device& device_;
  bool surfaces_;
};

}  // namespace gnosphere::vulkan

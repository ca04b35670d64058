// SPDX-License-Identifier: Apache-2.0
// Where the meshes are placed: what may move between two scans.
#pragma once

#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "gnosphere/scan.hpp"
#include "shared.h"
#include "vulkan/buffer.hpp"

namespace gnosphere::vulkan {

/// What placing a mesh needs to know of it.
struct MeshSummary {
  /// Groups first..first + count of a chunk, with so many clusters.
  struct Run {
    uint32_t chunk, first, count, clusters;
  };
  std::vector<Run> runs;
  Vec3 origin;
  glm::dvec3 low = {}, high = {};  ///< box of its triangles, relative to the origin
  uint32_t triangles = 0, nonFinite = 0, degenerate = 0;
};

/// Which instances a scan places: the moving ones, and the others if `still` says so.
struct Selection {
  std::span<const uint8_t> moving;  ///< by instance: 1 if it moves; empty: none
  bool still = true;
};

/// The instances as one scan sees them, in memory that the host writes.
struct PlacedInstances {
  /// What of `placed` belongs to a chunk: its first pair, how many, and the clusters in them.
  struct Chunk {
    uint32_t first, groups, clusters;
  };
  Buffer instances;    ///< gpu::Instance each; of those out of range only the number of the first triangle counts
  Buffer placed;       ///< (instance, group) pairs of the instances in range, chunk by chunk, the still ones first
  Buffer meshes;       ///< of each instance, where surfaces are looked at
  Buffer ownerRanges;  ///< per kOwnerBlock placed triangles: the first and the last instance among them
  std::vector<Chunk> still, moving;
  uint64_t numbering = 0;  ///< of the placed triangles, see Instances

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

/// Triangles are numbered instance by instance, so that a number tells its instance. A removed instance stays as one of
/// an empty mesh.
class Instances {
 public:
  /// `surfaces`: PlacedInstances::meshes is wanted.
  Instances(const Device& device, bool surfaces) : device_(device), surfaces_(surfaces) {}

  /// Meshes come before what places them.
  void addMesh(MeshSummary mesh);
  const MeshSummary& mesh(size_t mesh) const { return meshes_[mesh]; }
  /// After the mesh's positions have changed.
  void setMesh(size_t mesh, MeshSummary summary);
  /// Adds the next instance, or moves or replaces one that is there; kNoMesh removes it.
  void set(size_t index, uint32_t mesh, const Transform& transform);

  uint32_t count() const { return static_cast<uint32_t>(placements_.size()); }
  /// Triangles placed, and dropped while flattening.
  const Counters& counters() const { return counters_; }

  /// Goes up with every change of an instance or of a mesh's positions.
  uint64_t changes() const { return changes_; }
  /// changes() after the last change of the instance or its mesh, and of any triangle's number.
  uint64_t changedAt(size_t instance) const;
  uint64_t renumberedAt() const { return renumberedAt_; }
  /// Neither degenerate nor with a vertex that is not finite: of all instances, or of one.
  uint64_t usableTriangles() const { return counters_.triangles - counters_.nonFinite - counters_.degenerate; }
  uint64_t usableTriangles(size_t instance) const;

  /// Writes the transforms of the selected instances within reach (metres) to the sensor's frame, composed in double.
  void place(const Pose& pose, double reach, const Selection& selection, PlacedInstances& to);

 private:
  struct Placement {
    glm::dmat3 toWorld = {}, fromWorld = {};  ///< fromWorld is zero where the transform flattens the mesh
    glm::dvec3 position = {};                 ///< of the mesh's origin
    uint64_t changedAt = 0;
    uint32_t mesh = 0, firstTriangle = 0;
    bool mirrored = false;
    /// As gpu::Instance has it.
    uint32_t number() const { return firstTriangle | (mirrored ? 1u << 31 : 0u); }
  };
  struct Sphere {
    glm::dvec3 centre;
    double radius;
  };

  const MeshSummary& meshOf(const Placement& placement) const;
  void moveSpheres();
  Sphere sphereOf(const Placement& placement) const;
  void count(uint32_t mesh, int64_t instances);
  void number();
  void findVisible(const glm::dvec3& sensor, double reach, const Selection& selection);
  void reserve(PlacedInstances& to) const;
  uint32_t reserve(const std::vector<uint32_t>& visible, uint32_t first, std::vector<PlacedInstances::Chunk>& to) const;
  void writeNumbers(PlacedInstances& to) const;
  void writeMeshes(PlacedInstances& to) const;
  void writePairs(const std::vector<uint32_t>& visible, const std::vector<PlacedInstances::Chunk>& chunks,
                  uint32_t* pairs) const;

  const Device& device_;
  bool surfaces_;
  std::vector<MeshSummary> meshes_;
  std::vector<uint32_t> instanceCounts_;  // of each mesh
  std::vector<uint8_t> reshaped_;         // meshes whose instances' spheres are to be made anew
  std::vector<uint64_t> reshapedAt_;      // changes() after the last change of each mesh's positions
  std::vector<Placement> placements_;
  std::vector<Sphere> spheres_;                         // around each of them, in the world
  std::vector<uint32_t> visibleStill_, visibleMoving_;  // of the last scan
  Counters counters_;
  size_t chunkCount_ = 0;
  uint64_t changes_ = 0, renumberedAt_ = 0;
  uint32_t numberCount_ = 0;
  uint64_t numbering_ = 0;  // goes up when numbers change
  bool numbered_ = false, anyReshaped_ = false;
};

}  // namespace gnosphere::vulkan

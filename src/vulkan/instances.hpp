// SPDX-License-Identifier: Apache-2.0
// Where the meshes are placed: what may move between two scans.
#pragma once

#include <glm/glm.hpp>
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

/// The instances as one scan sees them, in memory that the host writes.
struct PlacedInstances {
  /// What of `placed` belongs to a chunk: its first pair, how many, and the clusters in them.
  struct Chunk {
    uint32_t first, groups, clusters;
  };
  Buffer instances;    ///< gpu::Instance each; of those out of range only the number of the first triangle counts
  Buffer placed;       ///< (instance, group) pairs of the instances in range, chunk by chunk
  Buffer ownerRanges;  ///< per kOwnerBlock placed triangles: the first and the last instance among them
  std::vector<Chunk> chunks;
  uint64_t numbering = 0;  ///< of the placed triangles, see Instances

  uint64_t bytes() const { return instances.bytes() + placed.bytes() + ownerRanges.bytes(); }
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
  explicit Instances(const Device& device) : device_(device) {}

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

  /// Writes the transforms of all instances within reach (metres) to the sensor's frame, composed in double.
  void place(const Pose& pose, double reach, PlacedInstances& to);

 private:
  struct Placement {
    glm::dmat3 toWorld = {}, fromWorld = {};  ///< fromWorld is zero where the transform flattens the mesh
    glm::dvec3 position = {};                 ///< of the mesh's origin
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
  void findVisible(const glm::dvec3& sensor, double reach);
  void reserve(PlacedInstances& to) const;
  void writeNumbers(PlacedInstances& to) const;
  void writePairs(PlacedInstances& to) const;

  const Device& device_;
  std::vector<MeshSummary> meshes_;
  std::vector<uint32_t> instanceCounts_;  // of each mesh
  std::vector<uint8_t> reshaped_;         // meshes whose instances' spheres are to be made anew
  std::vector<Placement> placements_;
  std::vector<Sphere> spheres_;    // around each of them, in the world
  std::vector<uint32_t> visible_;  // of the last scan
  Counters counters_;
  size_t chunkCount_ = 0;
  uint32_t numberCount_ = 0;
  uint64_t numbering_ = 0;  // goes up when numbers change
  bool numbered_ = false, anyReshaped_ = false;
};

}  // namespace gnosphere::vulkan

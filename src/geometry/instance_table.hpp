// SPDX-License-Identifier: Apache-2.0
// Where the meshes are placed: what may move between two scans.
#pragma once

#include <array>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "gnosphere/simulator.hpp"
#include "shared.h"

namespace gnosphere {

/// What placing a mesh needs to know of it.
struct MeshSummary {
  uint32_t firstGroup = 0, groups = 0;  ///< of clusters
  uint32_t clusters = 0;                ///< in those groups
  Vec3 origin;
  glm::dvec3 low = {}, high = {};  ///< box of its triangles, relative to the origin
  uint32_t triangles = 0, nonFinite = 0, degenerate = 0;
};

/// Which instances a scan places: the moving ones, and the others if `still` says so.
struct Selection {
  std::span<const uint8_t> moving;  ///< by instance: 1 if it moves; empty: none
  bool still = true;
};

/// What a scan places: the instances within reach, as groups of clusters.
struct PlacedGroups {
  /// A run of (instance, group) pairs: the first one, how many, and the clusters in them.
  struct Run {
    uint32_t first = 0, groups = 0, clusters = 0;
  };
  Run still, moving;  ///< the pairs of the still ones come first
};

/// Triangles are numbered instance by instance, so that a number tells its instance. A removed instance stays as one of
/// an empty mesh.
class InstanceTable {
 public:
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

  /// Chooses what a scan places: the selected instances within reach (metres). What is written below is of them.
  PlacedGroups choose(const Pose& pose, double reach, const Selection& selection);
  /// Their transforms to the sensor's frame, composed in double; `instances` has room for count().
  void writeTransforms(const Pose& pose, gpu::Instance* instances) const;
  /// (instance, group) pairs.
  void writePairs(uint32_t* pairs) const;
  /// Numbers of the triangles; the same for all scans with the same numbering().
  uint64_t numbering() const { return numbering_; }
  /// The first triangle of every instance, chosen or not.
  void writeNumbers(gpu::Instance* instances) const;
  /// Per kOwnerBlock placed triangles: the first and the last instance among them.
  size_t ownerRangeCount() const { return size_t{numberCount_} / gpu::kOwnerBlock + 1; }
  void writeOwnerRanges(uint32_t* ranges) const;
  /// Whose a placed triangle is: the instance that has the numbers first..first + triangles - 1.
  struct Owner {
    uint32_t first = 0, triangles = 0, instance = 0;
  };
  Owner ownerOf(uint32_t number) const;
  /// Of every instance: how it moves in the sensor's frame during `period` seconds to where `motions` says; those it
  /// does not name stand still. Returns how far any point goes, in metres.
  double writeMotions(const Pose& pose, std::span<const InstanceMotion> motions, double period,
                      gpu::InstanceMotion* to) const;
  /// The mesh of every instance; that of a removed one is the one after the last.
  void writeMeshes(uint32_t* meshes) const;

 private:
  struct Placement {
    glm::dmat3 toWorld = {}, fromWorld = {};  ///< fromWorld is zero where the transform flattens the mesh
    glm::dvec3 position = {};                 ///< of the mesh's origin
    uint64_t changedAt = 0;
    uint32_t mesh = 0;
    bool mirrored = false;
  };
  struct Sphere {
    glm::dvec3 centre;
    double radius;
  };

  /// Of its first triangle, as gpu::Instance has it.
  uint32_t numberOf(size_t instance) const {
    return firstTriangles_[instance] | (placements_[instance].mirrored ? 1u << 31 : 0u);
  }
  const MeshSummary& meshOf(const Placement& placement) const;
  void moveSpheres();
  Sphere sphereOf(const Placement& placement) const;
  void count(uint32_t mesh, int64_t instances);
  void number();
  void findOwnerRanges();
  void findVisible(const glm::dvec3& sensor, double reach, const Selection& selection);
  PlacedGroups::Run runOf(const std::vector<uint32_t>& visible, uint32_t first) const;

  std::vector<MeshSummary> meshes_;
  std::vector<uint32_t> instanceCounts_;  // of each mesh
  std::vector<uint8_t> reshaped_;         // meshes whose instances' spheres are to be made anew
  std::vector<uint64_t> reshapedAt_;      // changes() after the last change of each mesh's positions
  std::vector<Placement> placements_;
  std::vector<Sphere> spheres_;                         // around each of them, in the world
  std::vector<uint32_t> visibleStill_, visibleMoving_;  // of the last scan
  std::vector<uint32_t> firstTriangles_;                // of each of them
  std::vector<std::array<uint32_t, 2>> ownerRanges_;    // see writeOwnerRanges()
  Counters counters_;
  uint64_t changes_ = 0, renumberedAt_ = 0;
  uint32_t numberCount_ = 0;
  uint64_t numbering_ = 0;  // goes up when numbers change
  bool numbered_ = false, anyReshaped_ = false;
};

}  // namespace gnosphere

// SPDX-License-Identifier: Apache-2.0
// The instances of a scene: where the meshes are placed, and which of them a scan sees.
#pragma once

#include <array>
#include <glm/glm.hpp>
#include <map>
#include <span>
#include <unordered_map>
#include <vector>

#include "common/shared.h"
#include "geometry/transform_sources.hpp"
#include "geometry/triangle_numbers.hpp"
#include "gnosphere/simulator.hpp"

namespace gnosphere {

/// Properties of a mesh that its instances need.
struct MeshSummary {
  uint32_t firstGroup = 0, groups = 0;  ///< groups of clusters
  uint32_t clusters = 0;                ///< clusters in those groups
  Vec3 origin;
  glm::dvec3 low = {}, high = {};  ///< box of its triangles, relative to the origin
  uint32_t triangles = 0, nonFinite = 0, degenerate = 0;
};

/// The instances that a scan does not see.
struct IgnoredInstances {
  std::span<const uint8_t> ofSensor;  ///< by instance: 1 if it is ignored; instances beyond its end are not
  std::span<const uint32_t> ofShot;   ///< indices
};

/// Which instances a scan places: of those of its world and of world 0, the moving ones, and the still ones if `still`
/// is set, without the ignored ones.
struct Selection {
  std::span<const uint8_t> moving;  ///< by instance: 1 if it moves; empty: no instance moves
  bool still = true;
  IgnoredInstances ignored = {};
  uint32_t world = 0;
};

/// From where a view is seen, in which world, and the indices of instances that it does not see.
struct ViewPlace {
  Pose pose;
  uint32_t world = 0;
  std::span<const uint32_t> ignored = {};
};

/// Sums over the instances that a world and world 0 place.
struct WorldContent {
  uint64_t instances = 0, groups = 0, clusters = 0;
  uint64_t triangles = 0, nonFinite = 0, degenerate = 0;

  /// Number of triangles with area and finite corners.
  uint64_t usableTriangles() const { return triangles - nonFinite - degenerate; }
  void add(const MeshSummary& mesh);
  void add(const WorldContent& other);
};

/// The instances within reach that a scan places, as groups of clusters.
struct PlacedGroups {
  /// A run of (instance, group) pairs: the first one, how many, and the clusters in them.
  struct Run {
    uint32_t first = 0, groups = 0, clusters = 0;
  };
  Run still, moving;  ///< the pairs of the still instances come first
};

/// How instances move during a scan, by instance; others stand still.
using MovingInstances = std::map<uint32_t, gpu::InstanceMotion>;

/// A removed instance stays in the table with an empty mesh.
class InstanceTable {
 public:
  /// Makes room for so many more meshes, which addMesh() can then add without throwing.
  void reserveMeshes(size_t count);
  /// A mesh must be added before the instances that place it.
  void addMesh(MeshSummary mesh);
  const MeshSummary& mesh(size_t mesh) const { return meshes_[mesh]; }
  /// Updates a mesh after its positions have changed.
  void setMesh(size_t mesh, MeshSummary summary);
  /// Adds the next instance, or moves or replaces an existing one; kNoMesh removes it. If it throws std::bad_alloc,
  /// nothing changes.
  void set(size_t index, uint32_t mesh, const Transform& transform, uint32_t world);
  /// Gives existing instances new transforms. Of an instance that is listed twice the last transform counts.
  void move(std::span<const uint32_t> instances, std::span<const Transform> transforms);

  /// From now on the transforms of existing instances lie in a buffer of the caller, each until it is set or moved.
  /// Every scan places them, because only the device knows where they are.
  void setTransforms(const CallerTransforms& buffer);
  const TransformSources& transformSources() const { return transformSources_; }
  /// Writes what a device needs to compose these transforms with a pose: per buffer, and per instance.
  void writeTransformSources(const Pose& pose, gpu::TransformSource* sources, gpu::CallerBuffer* buffers,
                             gpu::TransformedInstance* instances) const;

  uint32_t count() const { return static_cast<uint32_t>(placements_.size()); }
  /// Content of the world that a scan can see.
  WorldContent contentOf(uint32_t world) const;
  /// The largest number of triangles that a scan of any world can see.
  uint64_t mostTriangles() const;
  /// Returns the instances that belong to a world, in ascending order. An instance of world 0 is in that list alone.
  std::span<const uint32_t> instancesOf(uint32_t world) const;

  /// Goes up with every change of an instance or of a mesh's positions.
  uint64_t changes() const { return changes_; }
  /// Value of changes() after the last change of the instance or its mesh, and after the last change of any triangle's
  /// number.
  uint64_t changedAt(size_t instance) const;
  uint64_t renumberedAt() const { return renumberedAt_; }
  /// Number of triangles with area and finite corners of one instance.
  uint64_t usableTriangles(size_t instance) const;

  /// Chooses what a scan places: the selected instances within reach (metres). The writers below write the chosen ones.
  PlacedGroups choose(const Pose& pose, double reach, const Selection& selection);
  /// Writes the transforms to the sensor's frame, composed in double, except for those of transformSources();
  /// `instances` has room for count().
  void writeTransforms(const Pose& pose, gpu::Instance* instances) const;
  /// Writes the (instance, group) pairs.
  void writePairs(uint32_t* pairs) const;

  /// An instance within reach of a view, and the first of its (instance, group) pairs.
  struct InView {
    uint32_t view, instance, pair;
  };
  /// The instances within reach of all views. Each view has two runs of entries: the instances of all worlds, and those
  /// of its own world. The triangle numbers ascend in each run.
  struct InViews {
    std::vector<InView> entries;
    std::vector<std::array<uint32_t, 2>> runs;  ///< per view and run: the first entry, the one after the last
  };
  /// Chooses, view by view, the instances of the view's world, all of them still ones, within reach (metres) of its
  /// pose, without those that the view or the sensor ignores (see IgnoredInstances::ofSensor). The writers below write
  /// an entry for each of them, so that an instance which several views see has several entries.
  PlacedGroups choose(std::span<const ViewPlace> views, double reach, std::span<const uint8_t> ignoredBySensor,
                      InViews& inViews);
  void writeViews(std::span<const ViewPlace> places, const InViews& inViews, gpu::Instance* instances, uint32_t* views,
                  uint32_t* pairs) const;
  void writeMeshes(const InViews& inViews, uint32_t* meshes) const;

  /// Returns the numbers of the triangles of all instances, as the last choose() made them.
  const TriangleNumbers& numbers() const { return numbers_; }
  /// Writes the first triangle number of every instance, chosen or not.
  void writeNumbers(gpu::Instance* instances) const;
  /// Finds how instances move in the sensor's frame during `period` seconds, to the transforms that `motions` gives. An
  /// instance that `motions` does not name stands still, unless its mesh is deformed during that time. For each
  /// deformed mesh, `changes` has the largest distance that the deformation moves a vertex in the mesh frame. Returns
  /// the largest distance that any point moves, in metres.
  double findMotions(const Pose& pose, std::span<const InstanceMotion> motions, const std::map<size_t, double>& changes,
                     double period, MovingInstances& to) const;
  /// Writes the mesh index of every instance; a removed instance gets the index after the last mesh.
  void writeMeshes(uint32_t* meshes) const;

 private:
  struct Placement {
    glm::dmat3 toWorld = {}, fromWorld = {};  ///< fromWorld is zero if there is no inverse
    glm::dvec3 position = {};                 ///< of the mesh's origin
    uint64_t changedAt = 0;
    uint32_t mesh = 0, world = 0;
    bool mirrored = false, flat = false;
  };
  struct World {
    std::vector<uint32_t> instances;  ///< in ascending order
    mutable WorldContent content;     ///< sums over them, if `summed` is set
    mutable bool summed = false;
  };
  struct Sphere {
    glm::dvec3 centre;
    double radius;
  };

  /// First triangle number of an instance in the form of gpu::Instance: bit 31 tells that it is mirrored.
  uint32_t numberOf(size_t instance) const {
    return numbers_.firstOf(instance) | (placements_[instance].mirrored ? 1u << 31 : 0u);
  }
  const MeshSummary& meshOf(const Placement& placement) const;
  bool put(size_t index, const Transform& transform, bool known, uint64_t change);
  void moveSpheres();
  Sphere sphereOf(size_t instance) const;
  const World* find(uint32_t world) const;
  /// Returns a world with room for one more instance. If it throws, no world has been added.
  World& worldWithRoom(uint32_t number);
  const WorldContent& sumOf(const World& world) const;
  bool isSeen(uint32_t instance, const glm::dvec3& sensor, double reach) const;
  class Ignoring;
  bool isIgnored(uint32_t instance, std::span<const uint8_t> ofSensor) const;
  void number();
  void findVisible(const glm::dvec3& sensor, double reach, const Selection& selection);
  PlacedGroups::Run runOf(const std::vector<uint32_t>& visible, uint32_t first) const;

  std::vector<MeshSummary> meshes_;
  std::unordered_map<uint32_t, World> worlds_;  // by number; those without instances are missing
  std::vector<uint8_t> reshaped_;               // by mesh: 1 if the spheres of its instances must be recomputed
  std::vector<uint64_t> reshapedAt_;            // by mesh: changes() after the last change of its positions
  std::vector<Placement> placements_;
  std::vector<Sphere> spheres_;                         // bounding sphere of each instance, in the world
  std::vector<uint32_t> visibleStill_, visibleMoving_;  // instances chosen for the last scan
  std::vector<uint8_t> ignored_;  // by instance: 1 while those of a shot that ignores it are chosen; may be shorter
  TriangleNumbers numbers_;
  TransformSources transformSources_;
  uint64_t changes_ = 0, renumberedAt_ = 0;
  bool numbered_ = false, anyReshaped_ = false;
};

}  // namespace gnosphere

// SPDX-License-Identifier: Apache-2.0
// The scene of a drive: what stands still, and the actors that move through it.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "drive/drive.hpp"
#include "gnosphere/animation.hpp"

namespace gnosphere::drive {

/// Returns the length, width and height of a model, which the size of an actor replaces: of the first state of the
/// actor's clip, because models of people often rest with their arms spread, and otherwise at rest. A model that is
/// flat or empty has a number that is not positive.
Vec3 fittedExtent(const Scene& model, const std::optional<Animation>& animation);
/// Whether all vertices of a model at rest are corners of a box along its axes.
bool isBox(const Scene& model);

class World {
 public:
  explicit World(const Drive& drive);

  /// The scene of the whole drive. Its instances never change: first those of the drive's scenes, in order, then those
  /// of the actors.
  const Scene& scene() const { return scene_; }

  /// The number of the object that an instance belongs to. An instance of a scene is an object of its own, and has its
  /// own number; all instances of an actor have the number of the actor's first. Numbers hold for the whole drive.
  uint32_t objectOf(size_t instance) const { return objects_[instance]; }
  uint32_t objectOfActor(size_t actor) const { return static_cast<uint32_t>(bodies_[actor].first); }
  /// The number of an actor in the upper half of SemanticKITTI's labels, from 1 on, because 0 is no actor. Numbers of
  /// objects begin at 0, and a scene may have more of them than 16 bits hold.
  static uint32_t labelOfActor(size_t actor) { return static_cast<uint32_t>(actor + 1); }
  /// The actor that an object is; none for an object of a scene.
  std::optional<size_t> actorOf(uint32_t object) const;

  /// The numbers of an actor's instances in scene().
  std::vector<uint32_t> instancesOf(size_t actor) const;

  /// The pose of an actor; none where it is gone.
  std::optional<Pose> poseOf(size_t actor, double time) const;
  /// The pose that an actor which is there at `begin` has at `end`. One that is gone after its trajectory goes on as it
  /// came to the end of that.
  Pose endOf(size_t actor, double begin, double end) const;
  /// Where an actor is at a time.
  struct Placement {
    Pose pose;
    Bounds bounds;  ///< in its own frame; they enclose its vertices as they are deformed
    Vec3 velocity;  ///< m/s in the world; a clip that repeats within 2 s, as steps do, adds nothing to it
    /// Whether it moves faster than 0.1 m/s.
    bool isMoving() const;
  };
  /// Returns the placement at `time` of an actor that moves within a scan from `begin` to `end`: the actor is on the
  /// straight way between its places at these two times, and has the mean velocity of this way. If `begin` is `end`,
  /// the actor stands during the scan, and has the velocity of its trajectory.
  Placement placementOf(size_t actor, double begin, double end, double time) const;

  /// The functions by which place() hands over the transform of each instance and the deformation of each mesh.
  struct Setter {
    std::function<void(size_t instance, const Transform&)> transform;
    std::function<void(size_t mesh, const Deformation&)> deformation;
  };
  /// Sets all instances of an actor at this pose, and its deformable meshes, as its animation has them at a time. An
  /// actor that is gone (no pose) lies out of every sensor's reach, so that all instances keep their numbers.
  void place(size_t actor, const std::optional<Pose>& pose, double time, const Setter& set) const;
  /// Whether an actor that is there at `from` moves until `to`.
  bool movesWithin(size_t actor, double from, double to) const;
  /// The error of an actor or a scene whose points go straight within a scan.
  struct Detour {
    double off = 0;        ///< m; how far points are off their true ways, at most
    double angle = 0;      ///< rad by which an actor turns
    bool ofParts = false;  ///< whether a clip moves parts of it, such as limbs, rotors and wheels
  };
  /// Returns the detour of an actor in a scan. The points are the corners of the boxes that enclose its rigid moving
  /// parts, and up to 256 vertices of each mesh that its clip deforms; without moving parts, the corners of its own
  /// box.
  Detour detourOfActor(size_t actor, double begin, double end) const;
  /// Returns the detour of a scene that has an animation.
  Detour detourOfScene(size_t scene, double begin, double end) const;
  /// Sets the animated instances and meshes of the drive's scenes.
  void placeScenes(double time, const Setter& set) const;

 private:
  /// Consecutive instances that come from one file.
  struct Body {
    const Scene* model = nullptr;
    size_t first = 0;
    std::vector<uint32_t> meshes;  // by mesh of the model: its number in the world
    std::optional<Animation> animation;
    Transform size;
    Bounds bounds;                                         // at rest; unused for scenes
    std::vector<std::pair<size_t, Bounds>> rigidParts;     // instances that the clip moves undeformed, their meshes
    std::vector<std::pair<size_t, Mesh>> softParts;        // instances that it deforms, some vertices of their meshes
    const std::vector<std::vector<bool>>* used = nullptr;  // by mesh of the model: the vertices of its triangles
    /// Whether the clip repeats within 2 s, as steps do. In the mean over its length it moves the body nowhere, because
    /// a loop goes back to its start, so that it adds nothing to the velocity.
    bool isGait() const;
  };
  SceneState stateOf(const Body& body, double time) const;
  /// The vertices of an animated body in its own frame at times, each computed once.
  class Shapes {
   public:
    Shapes(const World& world, const Body& body) : world_(world), body_(body) {}
    const std::vector<Vec3>& at(double time);

   private:
    const World& world_;
    const Body& body_;
    std::map<double, std::vector<Vec3>> shapes_;
  };
  /// Returns the mean velocity of an actor on its straight way between two times.
  Vec3 velocityOf(size_t actor, double from, double to, Shapes& shapes) const;
  void place(const Body& body, const Transform& place, double time, const Setter& set) const;
  /// Finds the parts of a body that its clip moves.
  static void findMovingParts(Body& body);
  /// Returns the times between two times, both excluded, at which a body may move otherwise than before: those of
  /// Trajectory::timesWithin(), and those of the keys of its moving parts, no more than about a thousand.
  std::vector<double> timesWithin(const Body& body, const Trajectory& trajectory, double from, double to) const;
  /// Returns the points of a body in the world whose ways detourOfActor() compares.
  std::vector<Vec3> pointsAt(const Body& body, const Trajectory& trajectory, double time) const;
  Detour detourOf(const Body& body, const Trajectory& trajectory, double begin, double end) const;

  const Drive& drive_;
  Scene scene_;
  std::vector<uint32_t> objects_;                     // by instance
  std::vector<std::vector<std::vector<bool>>> used_;  // by model and mesh: the vertices that triangles use
  std::vector<Body> scenes_;                          // the animated ones
  std::vector<Body> bodies_;                          // by actor
};

}  // namespace gnosphere::drive

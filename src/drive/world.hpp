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

class World {
 public:
  /// Throws Error(format) for a model that cannot have the size of its actor.
  explicit World(const Drive& drive);

  /// The scene of the whole drive. Its instances never change: first those of the drive's scenes, in order, then those
  /// of the actors.
  const Scene& scene() const { return scene_; }

  /// The number of the object that an instance belongs to. An instance of a scene is an object of its own, and has its
  /// own number; all instances of an actor have the number of the actor's first. Numbers hold for the whole drive.
  uint32_t objectOf(size_t instance) const { return objects_[instance]; }
  uint32_t objectOfActor(size_t actor) const { return static_cast<uint32_t>(bodies_[actor].first); }
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
    Vec3 velocity;  ///< m/s in the world
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
  /// Whether a clip moves parts of an actor without deforming them, as rotors and wheels.
  bool hasMovingParts(size_t actor) const { return !bodies_[actor].parts.empty(); }
  /// Returns the times between two times, both excluded, at which an actor may move otherwise than before: those of
  /// Trajectory::timesWithin(), and those of the keys of its moving parts, no more than about a thousand.
  std::vector<double> timesWithin(size_t actor, double from, double to) const;
  /// Returns, in the world, the corners of the boxes that enclose the moving parts of an actor, each along its own
  /// axes; those of one box around the actor if it has none.
  std::vector<Vec3> cornersAt(size_t actor, double time) const;
  /// Sets what is animated in the drive's scenes.
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
    std::vector<std::pair<size_t, Bounds>> parts;          // of actors: instances that move undeformed, their meshes
    const std::vector<std::vector<bool>>* used = nullptr;  // by mesh of the model: the vertices of its triangles
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

  const Drive& drive_;
  Scene scene_;
  std::vector<uint32_t> objects_;                     // by instance
  std::vector<std::vector<std::vector<bool>>> used_;  // by model and mesh: the vertices that triangles use
  std::vector<Body> scenes_;                          // those that are animated
  std::vector<Body> bodies_;                          // by actor
};

}  // namespace gnosphere::drive

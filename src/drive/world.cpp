// SPDX-License-Identifier: Apache-2.0
#include "drive/world.hpp"

#include <numeric>

#include "drive/pose_math.hpp"

namespace gnosphere::drive {
namespace {

constexpr double kMovingSpeed = 0.1;  ///< m/s
constexpr double kAround = 0.05;      ///< seconds before and after a time within which a speed is taken

/// Below the ground, farther than any sensor sees.
constexpr Transform kAway = {{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, -1e7}};

/// Adds the materials, images and meshes of `part`. Returns the number of its first mesh.
uint32_t addMeshes(Scene& scene, const Scene& part) {
  const auto materials = static_cast<uint32_t>(scene.materials.size()),
             images = static_cast<uint32_t>(scene.alphaImages.size()),
             meshes = static_cast<uint32_t>(scene.meshes.size());
  scene.alphaImages.insert(scene.alphaImages.end(), part.alphaImages.begin(), part.alphaImages.end());
  for (Material material : part.materials) {
    if (material.alphaImage != kNoImage) material.alphaImage += images;
    scene.materials.push_back(std::move(material));
  }
  for (Mesh mesh : part.meshes) {
    for (MeshPart& run : mesh.parts) run.material += materials;
    scene.meshes.push_back(std::move(mesh));
  }
  return meshes;
}

/// Returns the transform that gives a model the length, width and height of its actor.
Transform fitting(const Actor& actor, const Scene& model) {
  if (!actor.size) return {};
  const Bounds bounds = worldBounds(model);
  const Vec3 extent = bounds.max - bounds.min;
  if (bounds.empty() || !(extent.x > 0 && extent.y > 0 && extent.z > 0))
    throw Error(ErrorCode::format, "actor '" + actor.name + "': its model is flat, so it cannot be scaled to a size");
  return {{actor.size->x / extent.x, 0, 0, 0, 0, actor.size->y / extent.y, 0, 0, 0, 0, actor.size->z / extent.z, 0}};
}

std::vector<uint32_t> numbersFrom(uint32_t first, const Scene& part) {
  std::vector<uint32_t> numbers(part.meshes.size());
  std::iota(numbers.begin(), numbers.end(), first);
  return numbers;
}

/// The box around a model after `size`, in a state or at rest.
Bounds boundsAt(const Scene& model, const Transform& size, const SceneState* state) {
  Scene placed;
  for (size_t i = 0; i < model.meshes.size(); ++i) {
    const Mesh& mesh = model.meshes[i];
    Mesh shape;
    shape.origin = mesh.origin;
    shape.positions = deformedPositions(mesh, state ? state->deformations[i] : mesh.deformation);
    placed.meshes.push_back(std::move(shape));
  }
  placed.instances = model.instances;
  for (size_t i = 0; i < placed.instances.size(); ++i) {
    Transform& transform = placed.instances[i].transform;
    transform = size * (state ? state->transforms[i] : transform);
  }
  return worldBounds(placed);
}

}  // namespace

World::World(const Drive& drive) : drive_(drive) {
  for (size_t i = 0; i < drive.scenes.size(); ++i) {
    const Scene& part = drive.scenes[i];
    const uint32_t firstMesh = addMeshes(scene_, part);
    if (drive.sceneAnimations[i])
      scenes_.push_back({&part, objects_.size(), numbersFrom(firstMesh, part), drive.sceneAnimations[i], {}, {}});
    for (Instance instance : part.instances) {
      instance.mesh += firstMesh;
      objects_.push_back(static_cast<uint32_t>(objects_.size()));
      scene_.instances.push_back(std::move(instance));
    }
  }
  std::vector<uint32_t> firstMeshes;
  for (const Scene& model : drive.models) firstMeshes.push_back(addMeshes(scene_, model));
  for (const Actor& actor : drive.actors) {
    const Scene& model = drive.models[actor.model];
    Body body = {&model,          objects_.size(),       numbersFrom(firstMeshes[actor.model], model),
                 actor.animation, fitting(actor, model), {}};
    // Meshes that deform in a time of their own, that of the actor's animation, are copied.
    for (uint32_t& mesh : body.meshes) {
      if (!body.animation || !scene_.meshes[mesh].deformable()) continue;
      Mesh own = scene_.meshes[mesh];
      mesh = static_cast<uint32_t>(scene_.meshes.size());
      scene_.meshes.push_back(std::move(own));
    }
    for (const Instance& instance : model.instances) {
      objects_.push_back(static_cast<uint32_t>(body.first));
      scene_.instances.push_back({actor.name, body.meshes[instance.mesh], kAway, drive.classes[actor.category].id});
    }
    body.bounds = boundsAt(model, body.size, nullptr);
    bodies_.push_back(std::move(body));
  }
}

std::optional<size_t> World::actorOf(uint32_t object) const {
  for (size_t actor = 0; actor < bodies_.size(); ++actor)
    if (bodies_[actor].first == object) return actor;
  return {};
}

std::optional<Pose> World::poseOf(size_t actor, double time) const {
  const Actor& moving = drive_.actors[actor];
  if (moving.goneOutside && !moving.trajectory.covers(time)) return {};
  return moving.trajectory.at(time);
}

Vec3 World::velocityOf(size_t actor, double time) const {
  const Trajectory& trajectory = drive_.actors[actor].trajectory;
  return (1 / (2 * kAround)) * (trajectory.at(time + kAround).position - trajectory.at(time - kAround).position);
}

bool World::isMoving(size_t actor, double time) const {
  const Vec3 velocity = velocityOf(actor, time);
  return dot(velocity, velocity) > kMovingSpeed * kMovingSpeed;
}

SceneState World::stateOf(const Body& body, double time) const {
  const Animation& animation = *body.animation;
  return stateAt(*body.model, body.model->animation.clips[animation.clip],
                 animation.offset + animation.speed * (time - drive_.start), animation.end);
}

Bounds World::boundsOf(size_t actor, double time) const {
  const Body& body = bodies_[actor];
  if (!body.animation) return body.bounds;
  const SceneState state = stateOf(body, time);
  return boundsAt(*body.model, body.size, &state);
}

void World::place(size_t actor, const std::optional<Pose>& pose, double time, const Setter& set) const {
  const Body& body = bodies_[actor];
  if (pose) return place(body, transformOf(*pose), time, set);
  for (size_t i = 0; i < body.model->instances.size(); ++i) set.transform(body.first + i, kAway);
}

void World::placeScenes(double time, const Setter& set) const {
  for (const Body& body : scenes_) place(body, {}, time, set);
}

void World::place(const Body& body, const Transform& place, double time, const Setter& set) const {
  const std::vector<Instance>& instances = body.model->instances;
  if (!body.animation) {
    for (size_t i = 0; i < instances.size(); ++i)
      set.transform(body.first + i, place * (body.size * instances[i].transform));
    return;
  }
  const SceneState state = stateOf(body, time);
  for (size_t i = 0; i < instances.size(); ++i)
    set.transform(body.first + i, place * (body.size * state.transforms[i]));
  for (size_t i = 0; i < body.meshes.size(); ++i)
    if (body.model->meshes[i].deformable()) set.deformation(body.meshes[i], state.deformations[i]);
}

bool World::movesWithin(size_t actor, double from, double to) const {
  if (!poseOf(actor, from)) return false;
  const std::optional<Animation>& animation = drive_.actors[actor].animation;
  return (animation && animation->speed != 0) || drive_.actors[actor].trajectory.movesWithin(from, to);
}

}  // namespace gnosphere::drive

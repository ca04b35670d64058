// SPDX-License-Identifier: Apache-2.0
#include "drive/world.hpp"

#include <cmath>

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

}  // namespace

World::World(const Drive& drive) : drive_(drive) {
  for (const Scene& part : drive.scenes) {
    const uint32_t firstMesh = addMeshes(scene_, part);
    for (Instance instance : part.instances) {
      instance.mesh += firstMesh;
      objects_.push_back(static_cast<uint32_t>(objects_.size()));
      scene_.instances.push_back(std::move(instance));
    }
  }
  inActor_.resize(objects_.size());
  std::vector<uint32_t> firstMeshes;
  for (const Scene& model : drive.models) firstMeshes.push_back(addMeshes(scene_, model));
  for (const Actor& actor : drive.actors) {
    const Scene& model = drive.models[actor.model];
    const Transform size = fitting(actor, model);
    Body body = {objects_.size(), model.instances.size(), {}};
    Scene bare = model;
    for (Instance& instance : bare.instances) {
      instance.transform = size * instance.transform;
      objects_.push_back(static_cast<uint32_t>(body.first));
      inActor_.push_back(instance.transform);
      scene_.instances.push_back(
          {actor.name, firstMeshes[actor.model] + instance.mesh, kAway, drive.classes[actor.category].id});
    }
    body.bounds = worldBounds(bare);
    bodies_.push_back(body);
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

void World::place(size_t actor, const std::optional<Pose>& pose,
                  const std::function<void(size_t, const Transform&)>& set) const {
  const Body& body = bodies_[actor];
  const Transform place = pose ? transformOf(*pose) : kAway;
  for (size_t i = body.first; i < body.first + body.count; ++i) set(i, pose ? place * inActor_[i] : kAway);
}

bool World::movesWithin(size_t actor, double from, double to) const {
  return poseOf(actor, from) && drive_.actors[actor].trajectory.movesWithin(from, to);
}

}  // namespace gnosphere::drive

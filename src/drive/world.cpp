// SPDX-License-Identifier: Apache-2.0
#include "drive/world.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "base/vector.hpp"
#include "drive/median.hpp"
#include "drive/pose_math.hpp"
#include "effects/trajectory.hpp"
#include "scene/bounds.hpp"
#include "scene/join.hpp"
#include "scene/used_vertices.hpp"

namespace gnosphere::drive {
namespace {

constexpr double kMovingSpeed = 0.1;  ///< m/s

/// Below the ground, farther than any sensor sees.
constexpr Transform kAway = {{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, -1e7}};

std::vector<uint32_t> numbersFrom(uint32_t first, const Scene& part) {
  std::vector<uint32_t> numbers(part.meshes.size());
  std::iota(numbers.begin(), numbers.end(), first);
  return numbers;
}

/// The vertices that triangles of a model use, after `size`, in a state or at rest, in the order of its instances.
/// `used` tells which these are, by mesh.
std::vector<Vec3> verticesAt(const Scene& model, const std::vector<std::vector<bool>>& used, const Transform& size,
                             const SceneState* state) {
  std::vector<std::vector<float>> shapes;
  for (size_t i = 0; i < model.meshes.size(); ++i)
    shapes.push_back(deformedPositions(model.meshes[i], state ? state->deformations[i] : model.meshes[i].deformation));
  std::vector<Vec3> vertices;
  for (size_t i = 0; i < model.instances.size(); ++i) {
    const Instance& instance = model.instances[i];
    const Transform placed = size * (state ? state->transforms[i] : instance.transform);
    const Vec3& origin = model.meshes[instance.mesh].origin;
    const std::vector<float>& shape = shapes[instance.mesh];
    for (size_t v = 0; v + 2 < shape.size(); v += 3)
      if (used[instance.mesh][v / 3])
        vertices.push_back(placed * Vec3{origin.x + shape[v], origin.y + shape[v + 1], origin.z + shape[v + 2]});
  }
  return vertices;
}

Bounds boundsAround(const std::vector<Vec3>& vertices) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Bounds bounds = {{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
  for (const Vec3& v : vertices) {
    if (!isFinite(v)) continue;
    bounds.min = lowest(bounds.min, v);
    bounds.max = highest(bounds.max, v);
  }
  return bounds;
}

std::vector<std::vector<bool>> usedVerticesOf(const Scene& model) {
  std::vector<std::vector<bool>> used;
  for (const Mesh& mesh : model.meshes) used.push_back(usedVertices(mesh));
  return used;
}

Transform scaling(const Vec3& scale) {
  return {{scale.x, 0, 0, 0, 0, scale.y, 0, 0, 0, 0, scale.z, 0}};
}

Vec3 middleOf(const Bounds& bounds) {
  return 0.5 * (bounds.min + bounds.max);
}

/// The way of most of a body: in each direction the median way of its vertices. Limbs that swing do not count.
Vec3 wayOf(const std::vector<Vec3>& vertices, const Pose& start, const std::vector<Vec3>& later, const Pose& end) {
  std::vector<double> ways[3];
  for (size_t v = 0; v < vertices.size(); ++v) {
    const Vec3 way = end * later[v] - start * vertices[v];
    if (!isFinite(way)) continue;
    ways[0].push_back(way.x);
    ways[1].push_back(way.y);
    ways[2].push_back(way.z);
  }
  return {medianOf(ways[0]), medianOf(ways[1]), medianOf(ways[2])};
}

}  // namespace

Vec3 fittedExtent(const Scene& model, const std::optional<Animation>& animation) {
  const auto extentOf = [](const Bounds& bounds) { return bounds.max - bounds.min; };
  if (!animation) return extentOf(worldBounds(model));
  const SceneState first = stateAt(model, model.animation.clips[animation->clip], 0, ClipEnd::hold);
  return extentOf(boundsAround(verticesAt(model, usedVerticesOf(model), {}, &first)));
}

bool isBox(const Scene& model) {
  const std::vector<Vec3> vertices = verticesAt(model, usedVerticesOf(model), {}, nullptr);
  const Bounds bounds = boundsAround(vertices);
  const auto atEnd = [](double value, double low, double high) {
    return std::min(std::abs(value - low), std::abs(value - high)) <= 1e-3 * (high - low);
  };
  return std::ranges::all_of(vertices, [&](const Vec3& v) {
    return atEnd(v.x, bounds.min.x, bounds.max.x) && atEnd(v.y, bounds.min.y, bounds.max.y) &&
           atEnd(v.z, bounds.min.z, bounds.max.z);
  });
}

World::World(const Drive& drive) : drive_(drive) {
  for (size_t i = 0; i < drive.scenes.size(); ++i) {
    const Scene& part = drive.scenes[i];
    const uint32_t firstMesh = appendMeshes(scene_, part);
    if (drive.sceneAnimations[i]) {
      scenes_.push_back(
          {&part, objects_.size(), numbersFrom(firstMesh, part), drive.sceneAnimations[i], {}, {}, {}, {}, nullptr});
      findMovingParts(scenes_.back());
    }
    for (Instance instance : part.instances) {
      instance.mesh += firstMesh;
      objects_.push_back(static_cast<uint32_t>(objects_.size()));
      scene_.instances.push_back(std::move(instance));
    }
  }
  std::vector<uint32_t> firstMeshes;
  for (const Scene& model : drive.models) {
    firstMeshes.push_back(appendMeshes(scene_, model));
    used_.push_back(usedVerticesOf(model));
  }
  for (const Actor& actor : drive.actors) {
    const Scene& model = drive.models[actor.model];
    Body body = {&model,
                 objects_.size(),
                 numbersFrom(firstMeshes[actor.model], model),
                 actor.animation,
                 scaling(actor.scale),
                 {},
                 {},
                 {},
                 &used_[actor.model]};
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
    body.bounds = boundsAround(verticesAt(model, *body.used, body.size, nullptr));
    findMovingParts(body);
    bodies_.push_back(std::move(body));
  }
}

std::optional<size_t> World::actorOf(uint32_t object) const {
  const auto found = std::ranges::lower_bound(bodies_, size_t{object}, {}, &Body::first);
  if (found == bodies_.end() || found->first != object) return {};
  return static_cast<size_t>(found - bodies_.begin());
}

std::vector<uint32_t> World::instancesOf(size_t actor) const {
  std::vector<uint32_t> instances(bodies_[actor].model->instances.size());
  std::iota(instances.begin(), instances.end(), objectOfActor(actor));
  return instances;
}

std::optional<Pose> World::poseOf(size_t actor, double time) const {
  const Actor& moving = drive_.actors[actor];
  if (moving.goneOutside && !moving.trajectory.covers(time)) return {};
  return moving.trajectory.at(time);
}

Pose World::endOf(size_t actor, double begin, double end) const {
  const Actor& moving = drive_.actors[actor];
  const Trajectory& trajectory = moving.trajectory;
  Pose pose = trajectory.at(end);
  const double last = trajectory.end(),
               from = std::max(trajectory.begin(), std::min(begin, last - Trajectory::kAround));
  if (!moving.goneOutside || !(end > last) || !(from < last)) return pose;
  pose.position = pose.position + (end - last) / (last - from) * (pose.position - trajectory.at(from).position);
  return pose;
}

const std::vector<Vec3>& World::Shapes::at(double time) {
  const auto [entry, isNew] = shapes_.try_emplace(time);
  if (!isNew) return entry->second;
  const SceneState state = world_.stateOf(body_, time);
  return entry->second = verticesAt(*body_.model, *body_.used, body_.size, &state);
}

bool World::Body::isGait() const {
  constexpr double kLongest = 2;  // s
  return animation && animation->end == ClipEnd::loop &&
         model->animation.clips[animation->clip].duration <= kLongest * std::abs(animation->speed);
}

Vec3 World::velocityOf(size_t actor, double from, double to, Shapes& shapes) const {
  const Body& body = bodies_[actor];
  const Pose start = drive_.actors[actor].trajectory.at(from), end = endOf(actor, from, to);
  Vec3 way;
  if (body.animation) {
    const std::vector<Vec3>&first = shapes.at(from), &last = body.isGait() ? first : shapes.at(to);
    way = wayOf(first, start, last, end);
  } else {
    const Vec3 middle = middleOf(body.bounds);
    way = end * middle - start * middle;
  }
  return {way.x / (to - from), way.y / (to - from), way.z / (to - from)};
}

bool World::Placement::isMoving() const {
  return dot(velocity, velocity) > kMovingSpeed * kMovingSpeed;
}

World::Placement World::placementOf(size_t actor, double begin, double end, double time) const {
  const Trajectory& trajectory = drive_.actors[actor].trajectory;
  const Body& body = bodies_[actor];
  Shapes shapes(*this, body);
  if (begin == end) {
    const auto [from, to] = trajectory.around(time);
    return {trajectory.at(time), body.animation ? boundsAround(shapes.at(time)) : body.bounds,
            velocityOf(actor, from, to, shapes)};
  }
  const Pose start = trajectory.at(begin), stop = endOf(actor, begin, end);
  const Pose pose = poseAt({{{begin, start}, {end, stop}}}, {}, time);
  const Vec3 velocity = velocityOf(actor, begin, end, shapes);
  if (!body.animation) return {pose, body.bounds, velocity};
  const std::vector<Vec3>&first = shapes.at(begin), &last = shapes.at(end);
  const double share = (time - begin) / (end - begin);
  const Pose toActor = inverse(pose);
  std::vector<Vec3> vertices(first.size());
  for (size_t v = 0; v < vertices.size(); ++v)
    vertices[v] = toActor * ((1 - share) * (start * first[v]) + share * (stop * last[v]));
  return {pose, boundsAround(vertices), velocity};
}

SceneState World::stateOf(const Body& body, double time) const {
  const Animation& animation = *body.animation;
  return stateAt(*body.model, body.model->animation.clips[animation.clip],
                 animation.offset + animation.speed * (time - drive_.start), animation.end);
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
  const Trajectory& trajectory = drive_.actors[actor].trajectory;
  const bool goesOn = lengthOf(endOf(actor, from, to).position - trajectory.at(to).position) > 0;
  return (animation && animation->speed != 0) || goesOn || trajectory.movesWithin(from, to);
}

}  // namespace gnosphere::drive

// SPDX-License-Identifier: Apache-2.0
// How far the straight ways of points within a scan lead from where actors and scenes truly are.
#include <algorithm>
#include <cmath>
#include <set>
#include <utility>
#include <vector>

#include "base/vector.hpp"
#include "drive/pose_math.hpp"
#include "drive/world.hpp"
#include "scene/bounds.hpp"
#include "scene/used_vertices.hpp"

namespace gnosphere::drive {
namespace {

/// Returns by node whether a clip moves it, or its morph weights.
std::vector<bool> movedNodes(const SceneAnimation& animation, const Clip& clip) {
  std::vector<bool> moved(animation.nodes.size());
  for (const Track& track : clip.tracks) moved[track.node] = true;
  for (size_t i = 0; i < moved.size(); ++i)
    if (const uint32_t parent = animation.nodes[i].parent; parent != kNoNode && moved[parent]) moved[i] = true;
  return moved;
}

/// Returns a mesh without triangles that deforms as another one: with 256 of the vertices of its triangles, evenly
/// spread over their list, or with all if there are fewer.
Mesh sampleOf(const Mesh& mesh) {
  constexpr size_t kMost = 256;
  const std::vector<bool> used = usedVertices(mesh);
  std::vector<size_t> vertices;
  for (size_t v = 0; v < used.size(); ++v)
    if (used[v]) vertices.push_back(v);
  Mesh sample;
  sample.origin = mesh.origin;
  sample.jointCount = mesh.jointCount;
  sample.influences = mesh.influences;
  sample.morphTargets.resize(mesh.morphTargets.size());
  const size_t count = std::min(kMost, vertices.size());
  for (size_t i = 0; i < count; ++i) {
    const size_t v = vertices[i * vertices.size() / count];
    const auto append = [&](auto& to, const auto& from, size_t width) {
      for (size_t k = 0; k < width; ++k) to.push_back(from[v * width + k]);
    };
    append(sample.positions, mesh.positions, 3);
    append(sample.joints, mesh.joints, mesh.influences);
    append(sample.jointWeights, mesh.jointWeights, mesh.influences);
    for (size_t target = 0; target < mesh.morphTargets.size(); ++target)
      append(sample.morphTargets[target], mesh.morphTargets[target], 3);
  }
  return sample;
}

}  // namespace

void World::findMovingParts(Body& body) {
  if (!body.animation || body.animation->speed == 0) return;
  const Scene& model = *body.model;
  const std::vector<bool> moved = movedNodes(model.animation, model.animation.clips[body.animation->clip]);
  for (const AnimatedInstance& part : model.animation.instances) {
    const bool jointsMove = part.skin != kNoSkin && std::ranges::any_of(model.animation.skins[part.skin].joints,
                                                                        [&](uint32_t joint) { return moved[joint]; });
    const Mesh& mesh = model.meshes[model.instances[part.instance].mesh];
    if (mesh.indices.empty() || !(moved[part.node] || jointsMove)) continue;
    if (mesh.deformable())
      body.softParts.emplace_back(part.instance, sampleOf(mesh));
    else
      body.rigidParts.emplace_back(part.instance, meshBounds(mesh));
  }
}

std::vector<double> World::timesWithin(const Body& body, const Trajectory& trajectory, double from, double to) const {
  constexpr size_t kMost = 1000;
  std::vector<double> times = trajectory.timesWithin(from, to);
  if (body.rigidParts.empty() && body.softParts.empty()) return times;
  const Animation& animation = *body.animation;
  const Clip& clip = body.model->animation.clips[animation.clip];
  const auto clipTime = [&](double time) { return animation.offset + animation.speed * (time - drive_.start); };
  const double low = std::min(clipTime(from), clipTime(to)), high = std::max(clipTime(from), clipTime(to));
  const bool repeats = animation.end == ClipEnd::loop && clip.duration > 0;
  std::set<double> keys;
  for (const Track& track : clip.tracks) keys.insert(track.times.begin(), track.times.end());
  const double first = repeats ? std::floor(low / clip.duration) : 0;
  // The number of laps is bounded, too: among numbers beyond 2^53 the next lap may be the same one.
  for (size_t lap = 0; lap < kMost && times.size() < kMost; ++lap) {
    const double begin = (first + static_cast<double>(lap)) * clip.duration;
    if (begin > high) break;
    for (const double key : keys)
      if (begin + key > low && begin + key < high)
        times.push_back(drive_.start + (begin + key - animation.offset) / animation.speed);
    if (!repeats) break;
  }
  std::ranges::sort(times);
  return times;
}

std::vector<Vec3> World::pointsAt(const Body& body, const Trajectory& trajectory, double time) const {
  const Transform place = transformOf(trajectory.at(time));
  std::vector<Vec3> points;
  const auto addCorners = [&](const Transform& transform, const Bounds& box) {
    for (int i = 0; i < 8; ++i)
      points.push_back(transform * Vec3{i & 1 ? box.max.x : box.min.x, i & 2 ? box.max.y : box.min.y,
                                        i & 4 ? box.max.z : box.min.z});
  };
  if (body.rigidParts.empty() && body.softParts.empty()) {
    addCorners(place, body.bounds);
    return points;
  }
  const SceneState state = stateOf(body, time);
  const auto transformAt = [&](size_t instance) { return place * (body.size * state.transforms[instance]); };
  for (const auto& [instance, box] : body.rigidParts) addCorners(transformAt(instance), box);
  for (const auto& [instance, mesh] : body.softParts) {
    const Transform transform = transformAt(instance);
    const std::vector<float> shape = deformedPositions(mesh, state.deformations[body.model->instances[instance].mesh]);
    for (size_t v = 0; v < shape.size(); v += 3)
      points.push_back(transform * (mesh.origin + Vec3{shape[v], shape[v + 1], shape[v + 2]}));
  }
  return points;
}

World::Detour World::detourOf(const Body& body, const Trajectory& trajectory, double begin, double end) const {
  constexpr double kFar = 0.1;  // rad: a lesser turn leads even the ends of an actor of 20 m less than 2 cm off
  constexpr int kPieces = 2;    // of a scan, at least
  Detour detour;
  detour.ofParts = !body.rigidParts.empty() || !body.softParts.empty();
  if (!(end > begin)) return detour;
  std::vector<double> times = timesWithin(body, trajectory, begin, end);
  for (int i = 0; i <= kPieces; ++i) times.push_back(begin + (end - begin) * i / kPieces);
  std::ranges::sort(times);
  for (size_t i = 1; i < times.size(); ++i)
    detour.angle += angleBetween(trajectory.at(times[i - 1]).orientation, trajectory.at(times[i]).orientation);
  if (detour.angle < kFar && !detour.ofParts) return detour;
  const std::vector<Vec3> first = pointsAt(body, trajectory, times.front()),
                          last = pointsAt(body, trajectory, times.back());
  const auto include = [&](double time) {
    const double share = (time - begin) / (end - begin);
    const std::vector<Vec3> points = pointsAt(body, trajectory, time);
    for (size_t i = 0; i < points.size(); ++i)
      detour.off = std::max(detour.off, lengthOf(points[i] - ((1 - share) * first[i] + share * last[i])));
  };
  for (size_t i = 1; i < times.size(); ++i) {
    include(0.5 * (times[i - 1] + times[i]));  // stamps may be as far apart as half turns
    include(times[i]);
  }
  return detour;
}

World::Detour World::detourOfActor(size_t actor, double begin, double end) const {
  const Actor& moving = drive_.actors[actor];
  // Behind the trajectory of an actor that is then gone there is no way that its points could be off.
  return detourOf(bodies_[actor], moving.trajectory, begin,
                  moving.goneOutside ? std::min(end, moving.trajectory.end()) : end);
}

World::Detour World::detourOfScene(size_t scene, double begin, double end) const {
  return detourOf(*std::ranges::find(scenes_, &drive_.scenes[scene], &Body::model), Trajectory(), begin, end);
}

}  // namespace gnosphere::drive

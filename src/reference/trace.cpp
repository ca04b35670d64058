// SPDX-License-Identifier: Apache-2.0
#include "reference/trace.hpp"

#include <tuple>

namespace gnosphere::reference {

namespace {

/// Corners in the frame of a line at the time when it is fired.
std::array<Vec3, 3> seenFrom(const Line& line, const Triangle& triangle) {
  return {line.frame.toSensor(triangle.corners[0]), line.frame.toSensor(triangle.corners[1]),
          line.frame.toSensor(triangle.corners[2])};
}

bool isPane(const View& view, const Triangle& triangle) {
  return !view.panes.empty() && view.panes[materialOf(view.scene, triangle)] != 0;
}

}  // namespace

CornerError errorOf(const View& view, const Line& line, uint32_t instance) {
  CornerError error = view.errors[instance];
  error.absolute += kCornerError * line.reach;
  return error;
}

View viewOf(const Scene& scene, const Bvh& tree, const std::vector<PlacedMesh>& places, const Sensor& sensor,
            const Pose& pose, Counters& counters) {
  View view = {scene, tree, sensor};
  for (const PlacedMesh& place : places) {
    const CornerError error = {kCornerError * place.condition, absoluteError(place, pose.position)};
    view.errors.push_back(error);
    view.spread = std::max(view.spread, error.relative);
    view.floor = std::max(view.floor, error.absolute);
  }
  const Box bounds = tree.bounds();
  if (tree.triangles().empty()) return view;
  const Vec3 low = bounds.min - pose.position, high = bounds.max - pose.position;
  // The distance bounds every coordinate in any orientation; within half the limit no triangle need be checked.
  if (lengthOf({std::max(-low.x, high.x), std::max(-low.y, high.y), std::max(-low.z, high.z)}) < 0.5 * kFarthest)
    return view;
  const SensorFrame frame(pose);
  view.dropped.resize(tree.triangles().size());
  for (size_t i = 0; i < view.dropped.size(); ++i)
    for (const Vec3& corner : tree.triangles()[i].corners)
      if (!within(frame.toSensor(corner), kFarthest)) view.dropped[i] = 1;
  for (uint8_t dropped : view.dropped) counters.nonFinite += dropped;
  return view;
}

Hit nearest(const View& view, const Line& line, double behind) {
  // Bounds the rounding in double of the ray, of the corners' transformation and of the range.
  constexpr double kRounding = 0x1p-46;
  const Ray ray(line.frame.position, line.frame.directionToWorld(line.direction), kRounding, 0);
  const auto rank = [&](uint32_t i, double range) {
    const Triangle& triangle = view.tree.triangles()[i];
    return std::tuple(range, triangle.instance, triangle.index);
  };
  Hit best;
  view.tree.walk(ray, line.window.most, [&](uint32_t i, double limit) {
    if (view.isDropped(i)) return limit;
    const Triangle triangle = view.tree.sweeps().at(view.tree.triangles()[i], line.time);
    const auto [a, b, c] = seenFrom(line, triangle);
    const Pierce hit = pierce(line.direction, a, b, c);
    if (!hit.inside || (triangle.front != 0 && (hit.facing > 0) != (triangle.front > 0))) return limit;
    if (!(hit.range > 0) || hit.range < line.window.least || hit.range > line.window.most) return limit;
    if (best.triangle != kNobody && rank(best.triangle, best.range) < rank(i, hit.range)) return limit;
    if (hit.range <= behind * (1 + kOneSurface) && isPane(view, triangle)) return limit;
    if (view.cutOuts && isHole(view.scene, triangle, hit.weights)) return limit;
    best = {i, hit.range, hit.weights};
    return hit.range;
  });
  return best;
}

bool inDoubt(const View& view, const Line& line, std::span<const Hit> hits, bool goesOn, double& tolerance) {
  const Across across(line.direction);
  const auto look = [&](const Triangle& triangle) {
    const auto [a, b, c] = seenFrom(line, triangle);
    CornerError error = errorOf(view, line, triangle.instance);
    error.relative += line.astray;
    return doubtOf(across, {a, b, c}, triangle.front, error, line.window);
  };
  double farthest = line.window.most, before = 0;
  bool doubt = false;
  for (const Hit& hit : hits) {
    const Triangle triangle = view.tree.sweeps().at(view.tree.triangles()[hit.triangle], line.time);
    const Doubt owner = look(triangle);
    tolerance = std::max({hit.range - owner.nearest, owner.farthest - hit.range, kUnitRoundoff * hit.range, tolerance});
    doubt = doubt || !owner.certain || (view.cutOuts && isHoleInDoubt(view.scene, triangle, hit.weights));
    // Two hits in a row may change places, or two panes become one.
    doubt = doubt || owner.nearest <= before * (1 + kOneSurface);
    before = owner.farthest;
    if (!goesOn && &hit == &hits.back()) farthest = std::min(farthest, owner.farthest);
  }
  if (doubt) return true;
  // Widened by twice the errors of a corner, across the beam and along it.
  const Ray thin(line.frame.position, line.frame.directionToWorld(line.direction), 0, 0);
  const auto fat = [&](const CornerError& error) {
    Ray ray = thin;
    ray.spread = 2 * (error.relative + kDirectionError + line.astray);
    ray.floor = 2 * error.absolute;
    return ray;
  };
  const auto isHit = [&](uint32_t i) {
    return std::any_of(hits.begin(), hits.end(), [=](const Hit& hit) { return hit.triangle == i; });
  };
  const auto isOpen = [&](const Triangle& triangle) {
    const auto [a, b, c] = seenFrom(line, triangle);
    const Pierce hit = pierce(line.direction, a, b, c);
    return hit.inside && isHole(view.scene, triangle, hit.weights) && !isHoleInDoubt(view.scene, triangle, hit.weights);
  };
  view.tree.walk(fat({view.spread, view.floor + kCornerError * line.reach}), farthest, [&](uint32_t i, double limit) {
    if (isHit(i) || view.isDropped(i)) return limit;
    const Triangle triangle = view.tree.sweeps().at(view.tree.triangles()[i], line.time);
    // The triangle's own box is tested, too, so that the answer does not depend on the other triangles of the leaf.
    if (fat(errorOf(view, line, triangle.instance)).enter(boxOf(triangle)) > limit) return limit;
    if (view.cutOuts && isOpen(triangle)) return limit;
    const Doubt other = look(triangle);
    doubt = other.possible && other.nearest <= farthest;
    return doubt ? -1.0 : limit;
  });
  return doubt;
}

}  // namespace gnosphere::reference

// SPDX-License-Identifier: Apache-2.0
#include "pipeline/submissions.hpp"

#include <algorithm>

#include "base/threads.hpp"
#include "base/transform.hpp"

namespace gnosphere {
namespace {

constexpr uint64_t kMotionsPerRun = 4;  // the tables of one take 0.15 to 0.26 ms
// A list of 3,000 beams that start far apart took 0.6 of the time with 64 views per submission instead of all of
// them, because what few views read stays in the CPU's caches.
constexpr size_t kMostViewsOfShot = 64;

// Returns the groups of beams of shots whose tables are in a set.
std::vector<View> viewsOf(std::span<const Shot> shots, const SensorArrays& sensor, size_t set) {
  std::vector<View> views;
  for (size_t shot = 0; shot < shots.size(); ++shot)
    for (const BeamGroup& group : sensor.groups(shots[shot].frame))
      if (group.set == set) views.push_back({shot, &group});
  return views;
}

// Returns how many views of one shot a submission has at most.
size_t mostViewsOf(const Shot& shot, const SensorArrays& sensor, const PartLimits& limits) {
  const uint64_t bytes = limits.scene.bytesOfView(shot.world, moves(sensor.sensorPlan(), shot));
  const uint64_t room = limits.listBytes / std::max<uint64_t>(bytes, 1);
  return std::min<size_t>({limits.views, kMostViewsOfShot, sensor.mostViews(), std::max<uint64_t>(room, 1)});
}

// Returns the number of shots, from the first one on, that are submitted together. A sensor that stands still is
// scanned shot by shot, because then it can reuse its hits.
size_t shotsFrom(std::span<const Shot> shots, const SensorArrays& sensor, const PartLimits& limits) {
  const size_t most = std::min<size_t>(limits.views, sensor.mostViews());
  if (sensor.sets() > 1) return 1;
  const SensorPlan& plan = sensor.sensorPlan();
  const bool moving = moves(plan, shots[0]);
  const auto bytesOf = [&](const Shot& shot) { return limits.scene.bytesOfView(shot.world, moving); };
  const auto standsStill = [&](const Shot& shot, const Shot& before) {
    return sensor.keepsStill() && !moving && shot.world == before.world && samePose(shot.pose, before.pose) &&
           shot.ignoredInstances == before.ignoredInstances;
  };
  const auto deforms = [&](const Shot& shot) { return !shot.meshMotions.empty() && plan.has(gpu::kObjectMotion); };
  // A subgroup may work on several views, so the sensor must move in all views of a submission or in none.
  const auto alike = [&](const Shot& shot) {
    return shot.sensor == shots[0].sensor && !deforms(shot) && moves(plan, shot) == moving &&
           (!moving || shot.motion.stamps.empty() == shots[0].motion.stamps.empty());
  };
  if (deforms(shots[0]) || most == 1) return 1;
  size_t count = 0, views = 0;
  uint64_t bytes = 0;
  while (count < shots.size() &&
         (count == 0 || (alike(shots[count]) && !standsStill(shots[count], shots[count - 1])))) {
    const size_t ofShot = sensor.groups(shots[count].frame).size();
    views += ofShot;
    bytes += ofShot * bytesOf(shots[count]);
    if (count > 0 && (views > most || bytes > limits.listBytes)) break;
    ++count;
  }
  return count;
}

}  // namespace

std::vector<Part> partsOf(std::span<const Shot> shots, std::span<SensorArrays* const> sensors,
                          const PartLimits& limits) {
  std::vector<Part> parts;
  for (size_t i = 0; i < shots.size();) {
    const SensorArrays& sensor = *sensors[shots[i].sensor];
    const std::span<const Shot> together = shots.subspan(i, shotsFrom(shots.subspan(i), sensor, limits));
    const size_t most = together.size() > 1 ? kAnyViews : mostViewsOf(together[0], sensor, limits);
    const size_t before = parts.size();
    for (size_t set = 0; set < sensor.sets(); ++set) {
      const std::vector<View> views = viewsOf(together, sensor, set);
      for (size_t first = 0; first < views.size(); first += most) {
        const auto run = std::span(views).subspan(first, std::min(most, views.size() - first));
        parts.push_back({together, i, {run.begin(), run.end()}, false, false});
      }
    }
    parts[before].first = parts.back().last = true;
    i += together.size();
  }
  return parts;
}

std::span<const Shot> shotsOfViews(const Part& part, std::vector<Shot>& copies) {
  if (part.views.size() == part.shots.size()) return part.shots;
  copies.clear();
  for (const View& view : part.views) copies.push_back(part.shots[view.shot]);
  return copies;
}

std::vector<ShotMotion> motionsOf(const SensorPlan& plan, std::span<const View> views, std::span<const Shot> shots,
                                  const SceneArrays& scene) {
  const auto of = [&](size_t view) {
    return motionOf(plan, views[view].group->lasers, shots[view], scene.instances(), scene.geometry().deformables());
  };
  const auto hasSameTable = [&](const View& view) { return view.group == views[0].group; };
  std::vector<ShotMotion> motions;
  std::optional<ShotMotion> first = of(0);
  if (!first) return motions;
  motions.resize(first->moves || !std::all_of(views.begin(), views.end(), hasSameTable) ? shots.size() : 1);
  motions[0] = std::move(*first);
  inRuns(motions.size() - 1, kMotionsPerRun, threadCount(), [&](uint64_t begin, uint64_t end) {
    for (uint64_t i = begin + 1; i <= end; ++i) motions[i] = *of(i);
  });
  return motions;
}

InstanceEntries placeViews(SceneArrays& scene, const SensorArrays& sensor, std::span<const Shot> shots,
                           ShotMotions motions, Selection selection, PlacedArrays& to) {
  const double reach = sensor.reach() + reachOf(motions);
  if (shots.size() == 1) {
    selection.ignored = {sensor.sensorPlan().ignored, shots[0].ignoredInstances};
    selection.world = shots[0].world;
    scene.place(seenFrom(shots, 0, motions), reach, selection, to);
    return {scene.instances().count()};
  }
  std::vector<ViewPlace> places;
  for (size_t view = 0; view < shots.size(); ++view)
    places.push_back({seenFrom(shots, view, motions), shots[view].world, shots[view].ignoredInstances});
  scene.place(places, reach, sensor.sensorPlan().ignored, sensor.keepsRecords(), to);
  return {scene.instances().count(), to.inViews()};
}

}  // namespace gnosphere

// SPDX-License-Identifier: Apache-2.0
#include "effects/arrays.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <utility>

#include "base/limits.hpp"

namespace gnosphere {
namespace {

// A module may have more entries than the footprint has sub-rays; the surplus entries get weight 0.
std::vector<gpu::vec4> subRayLines(const SensorPlan& plan) {
  std::vector<gpu::vec4> lines;
  for (const SubRay& ray : plan.subRays)
    lines.push_back({ray.u, ray.v, ray.weight, std::sqrt(1 + ray.u * ray.u + ray.v * ray.v)});
  lines.resize(limits::kSubRays.most, {0, 0, 0, 1});
  return lines;
}

// True if the beams in one column of the grid, or in one cell of the list, may fire at different times.
bool firesApart(const SensorPlan& plan) {
  return plan.listed || (plan.rows && plan.rows->staggered());
}

// Returns how the instance of each entry moves; nothing if no instance moves.
std::vector<gpu::InstanceMotion> motionsOf(ShotMotions motions, const InstanceEntries& entries) {
  std::vector<gpu::InstanceMotion> all;
  if (std::ranges::all_of(motions, [](const ShotMotion& motion) { return motion.instances.empty(); })) return all;
  if (entries.inViews.empty()) {
    all.resize(entries.count);
    for (const auto& [instance, moving] : motions[0].instances) all[instance] = moving;
    return all;
  }
  all.resize(entries.inViews.size());
  for (size_t i = 0; i < all.size(); ++i) {
    const MovingInstances& instances = motions[entries.inViews[i].view].instances;
    const auto found = instances.find(entries.inViews[i].instance);
    if (found != instances.end()) all[i] = found->second;
  }
  return all;
}

// Returns the boxes of dust of all shots, equally many for each. A shot with fewer boxes than others is given boxes
// that weaken no light and scatter none.
std::vector<gpu::VolumeBox> dustOf(const SensorPlan& plan, std::span<const Shot> shots, ShotMotions motions) {
  size_t most = 0;
  for (const Shot& shot : shots) most = std::max(most, effectsOf(plan, shot).volumes.boxes.size());
  std::vector<gpu::VolumeBox> boxes;
  for (size_t i = 0; i < shots.size(); ++i) {
    const std::vector<gpu::VolumeBox> own = volumeBoxes(effectsOf(plan, shots[i]), seenFrom(shots, i, motions));
    boxes.insert(boxes.end(), own.begin(), own.end());
    boxes.resize((i + 1) * most);
  }
  return boxes;
}

}  // namespace

std::vector<ArrayContent> beamArrays(const SensorPlan& plan, uint64_t beams) {
  std::vector<ArrayContent> arrays;
  const auto addRoom = [&](gpu::Array array, uint64_t bytesPerBeam) {
    arrays.push_back({array, beams * bytesPerBeam, {}});
  };
  if (plan.footprint() || plan.panes()) {
    addRoom(gpu::Array::hardBeams, sizeof(uint32_t) * (plan.footprint() ? gpu::kEffortClasses : 1));
    addRoom(gpu::Array::echoCounts, sizeof(uint32_t));
    const uint64_t most = plan.footprint() ? gpu::keptEchoes(plan.returns) : gpu::kMaxLayers;
    addRoom(gpu::Array::echoes, most * sizeof(gpu::vec4));
    addRoom(gpu::Array::echoOwners, most * 2 * sizeof(uint32_t));
    if (plan.asks(gpu::kFieldSurface)) addRoom(gpu::Array::echoSurfaces, most * sizeof(gpu::SurfaceRecord));
  }
  if (plan.moves() && firesApart(plan)) addRoom(gpu::Array::beamFrames, sizeof(gpu::BeamFrame));
  if (plan.has(gpu::kStrays)) addRoom(gpu::Array::strays, sizeof(gpu::vec2));
  return arrays;
}

std::vector<ArrayContent> lastingTables(const SensorPlan& plan) {
  std::vector<ArrayContent> arrays;
  if (plan.footprint()) arrays.push_back(arrayOf(gpu::Array::subRays, subRayLines(plan)));
  if (plan.looksAtOptics()) arrays.push_back(arrayOf(gpu::Array::optics, plan.optics));
  if (plan.has(gpu::kCutOuts)) {
    arrays.push_back(arrayOf(gpu::Array::alphaImages, plan.textures->images));
    arrays.push_back(arrayOf(gpu::Array::texels, plan.textures->texels));
  }
  if (!plan.deadBeams.empty()) arrays.push_back(arrayOf(gpu::Array::deadBeams, plan.deadBeams));
  return arrays;
}

std::vector<ArrayContent> projectedArrays(const SensorPlan& plan, uint64_t count) {
  std::vector<ArrayContent> arrays;
  if (plan.has(gpu::kFootprintEffects))
    arrays.push_back({gpu::Array::projectedMaterials, count * sizeof(uint32_t), {}});
  if (plan.has(gpu::kCutOuts)) arrays.push_back({gpu::Array::projectedTexture, count * 2 * sizeof(gpu::vec4), {}});
  if (plan.motion() && firesApart(plan))
    arrays.push_back({gpu::Array::projectedTimes, count * 2 * sizeof(uint32_t), {}});
  if (plan.has(gpu::kObjectMotion)) arrays.push_back({gpu::Array::projectedMotions, count * 3 * sizeof(gpu::vec4), {}});
  return arrays;
}

std::vector<ArrayContent> shotArrays(const SensorPlan& plan, std::span<const Shot> shots, ShotMotions motions,
                                     const InstanceEntries& entries) {
  std::vector<ArrayContent> arrays;
  std::vector<gpu::VolumeBox> boxes;
  if (plan.has(gpu::kVolumes)) {
    boxes = dustOf(plan, shots, motions);
    arrays.push_back(arrayOf(gpu::Array::volumes, boxes));
  }
  if (plan.signals()) {
    std::vector<gpu::EffectParameters> all;
    for (const Shot& shot : shots) {
      gpu::EffectParameters parameters = plan.parameters;
      if (shot.weather) parameters = effectParameters(effectsOf(plan, shot), plan.sensor, plan.bits);
      parameters.sensor = plan.parameters.sensor;
      parameters.frame = keyOfFrame(shot.frame);
      parameters.volumeCount = static_cast<uint32_t>(boxes.size() / shots.size());
      all.push_back(parameters);
    }
    arrays.push_back(arrayOf(gpu::Array::parameters, all));
  }
  if (motions.empty()) return arrays;
  const std::vector<gpu::InstanceMotion> instances = motionsOf(motions, entries);
  ArrayContent columns = {gpu::Array::columnMotions, 0, {}};  // the largest: 147 kB of a head with 1,025 columns
  std::vector<gpu::MotionBounds> bounds;
  for (const ShotMotion& motion : motions) {
    const auto bytes = std::as_bytes(std::span(motion.tables.columns));
    columns.content.insert(columns.content.end(), bytes.begin(), bytes.end());
    bounds.push_back(motion.tables.bounds);
    bounds.back().instances = !instances.empty();  // the same for all views, since a subgroup may work on several
  }
  columns.bytes = columns.content.size();
  arrays.push_back(std::move(columns));
  arrays.push_back(arrayOf(gpu::Array::motion, bounds));
  arrays.push_back(arrayOf(gpu::Array::instanceMotions, instances));
  const ShotMotion& first = motions[0];  // meshes are not deformed during several shots
  if (!first.end.jointRows.empty()) arrays.push_back(arrayOf(gpu::Array::endJointRows, first.end.jointRows));
  if (!first.end.morphWeights.empty()) arrays.push_back(arrayOf(gpu::Array::endMorphWeights, first.end.morphWeights));
  return arrays;
}

}  // namespace gnosphere

// SPDX-License-Identifier: Apache-2.0
#include "effects/arrays.hpp"

#include <cmath>

#include "base/limits.hpp"

namespace gnosphere {
namespace {

template <typename T>
EffectsArray table(gpu::Array array, const std::vector<T>& content) {
  const auto bytes = std::as_bytes(std::span(content));
  return {array, bytes.size(), {bytes.begin(), bytes.end()}};
}

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

// Returns the parts of several motions one after the other.
template <typename T, typename Of>
EffectsArray joined(gpu::Array array, ShotMotions motions, const Of& of) {
  std::vector<T> all;
  for (const ShotMotion& motion : motions) {
    const std::span<const T> part = of(motion);
    all.insert(all.end(), part.begin(), part.end());
  }
  return table(array, all);
}

}  // namespace

std::vector<EffectsArray> beamArrays(const SensorPlan& plan, uint64_t beams) {
  std::vector<EffectsArray> arrays;
  const auto addRoom = [&](gpu::Array array, uint64_t bytesPerBeam) {
    arrays.push_back({array, beams * bytesPerBeam, {}});
  };
  if (plan.footprint() || plan.panes()) {
    addRoom(gpu::Array::hardBeams, sizeof(uint32_t) * (plan.footprint() ? gpu::kEffortClasses : 1));
    addRoom(gpu::Array::echoCounts, sizeof(uint32_t));
    const uint64_t most = plan.footprint() ? gpu::kMaxEchoes : gpu::kMaxLayers;
    addRoom(gpu::Array::echoes, most * sizeof(gpu::vec4));
    addRoom(gpu::Array::echoOwners, most * 2 * sizeof(uint32_t));
    if (plan.asks(gpu::kFieldSurface)) addRoom(gpu::Array::echoSurfaces, most * sizeof(gpu::SurfaceRecord));
  }
  if (plan.moves() && firesApart(plan)) addRoom(gpu::Array::beamFrames, sizeof(gpu::BeamFrame));
  if (plan.has(gpu::kStrays)) addRoom(gpu::Array::strays, sizeof(gpu::vec2));
  return arrays;
}

std::vector<EffectsArray> lastingTables(const SensorPlan& plan) {
  std::vector<EffectsArray> arrays;
  if (plan.footprint()) arrays.push_back(table(gpu::Array::subRays, subRayLines(plan)));
  if (plan.looksAtOptics()) arrays.push_back(table(gpu::Array::optics, plan.optics));
  if (plan.has(gpu::kCutOuts)) {
    arrays.push_back(table(gpu::Array::alphaImages, plan.textures->images));
    arrays.push_back(table(gpu::Array::texels, plan.textures->texels));
  }
  if (!plan.deadBeams.empty()) arrays.push_back(table(gpu::Array::deadBeams, plan.deadBeams));
  return arrays;
}

std::vector<EffectsArray> projectedArrays(const SensorPlan& plan, uint64_t count) {
  std::vector<EffectsArray> arrays;
  if (plan.has(gpu::kFootprintEffects))
    arrays.push_back({gpu::Array::projectedMaterials, count * sizeof(uint32_t), {}});
  if (plan.has(gpu::kCutOuts)) arrays.push_back({gpu::Array::projectedTexture, count * 2 * sizeof(gpu::vec4), {}});
  if (plan.motion() && firesApart(plan))
    arrays.push_back({gpu::Array::projectedTimes, count * 2 * sizeof(uint32_t), {}});
  if (plan.has(gpu::kObjectMotion)) arrays.push_back({gpu::Array::projectedMotions, count * 3 * sizeof(gpu::vec4), {}});
  return arrays;
}

std::vector<EffectsArray> shotArrays(const SensorPlan& plan, std::span<const Shot> shots, ShotMotions motions) {
  std::vector<EffectsArray> arrays;
  if (plan.signals()) {
    std::vector<gpu::EffectParameters> all;
    for (const Shot& shot : shots) {
      gpu::EffectParameters parameters = plan.parameters;
      if (shot.weather) parameters = effectParameters(effectsOf(plan, shot), plan.sensor, plan.bits);
      parameters.sensor = plan.parameters.sensor;
      parameters.frame = static_cast<uint32_t>(shot.frame);
      all.push_back(parameters);
    }
    arrays.push_back(table(gpu::Array::parameters, all));
  }
  if (plan.has(gpu::kVolumes)) {
    std::vector<gpu::VolumeBox> all;
    for (size_t i = 0; i < shots.size(); ++i)
      for (const gpu::VolumeBox& box : volumeBoxes(effectsOf(plan, shots[i]), seenFrom(shots, i, motions)))
        all.push_back(box);
    arrays.push_back(table(gpu::Array::volumes, all));
  }
  if (motions.empty()) return arrays;
  arrays.push_back(joined<gpu::ColumnMotion>(
      gpu::Array::columnMotions, motions, [](const ShotMotion& motion) { return std::span(motion.tables.columns); }));
  arrays.push_back(joined<gpu::MotionBounds>(
      gpu::Array::motion, motions, [](const ShotMotion& motion) { return std::span(&motion.tables.bounds, 1); }));
  const ShotMotion& first = motions[0];  // instances do not move during several shots
  arrays.push_back(table(gpu::Array::instanceMotions, first.instances));
  if (!first.end.jointRows.empty()) arrays.push_back(table(gpu::Array::endJointRows, first.end.jointRows));
  if (!first.end.morphWeights.empty()) arrays.push_back(table(gpu::Array::endMorphWeights, first.end.morphWeights));
  return arrays;
}

}  // namespace gnosphere

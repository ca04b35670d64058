// SPDX-License-Identifier: Apache-2.0
#include "effects/arrays.hpp"

#include <cmath>

namespace gnosphere {
namespace {

// Of any module of the footprint.
constexpr size_t kMostSubRays = 61;

template <typename T>
EffectsArray table(uint32_t binding, const char* name, const std::vector<T>& content) {
  const auto bytes = std::as_bytes(std::span(content));
  return {binding, name, bytes.size(), {bytes.begin(), bytes.end()}};
}

std::vector<gpu::vec4> rowOrigins(const SensorPlan& plan, std::span<const gpu::Row> rows, uint64_t firstBeam) {
  std::vector<gpu::vec4> origins;
  for (const gpu::Row& row : rows) {
    const size_t channel = firstBeam / plan.sensor.columns + static_cast<size_t>(row.angles.w);
    const Vec3& origin = plan.sensor.channels[channel].origin;
    origins.push_back({static_cast<float>(origin.x), static_cast<float>(origin.y), static_cast<float>(origin.z), 0});
  }
  return origins;
}

// Entries that a module has and the footprint has not carry no energy.
std::vector<gpu::vec4> subRayLines(const SensorPlan& plan) {
  std::vector<gpu::vec4> lines;
  for (const SubRay& ray : plan.subRays)
    lines.push_back({ray.u, ray.v, ray.weight, std::sqrt(1 + ray.u * ray.u + ray.v * ray.v)});
  lines.resize(kMostSubRays, {0, 0, 0, 1});
  return lines;
}

}  // namespace

std::vector<EffectsArray> lastingArrays(const SensorPlan& plan, std::span<const gpu::Row> rows, uint64_t firstBeam) {
  std::vector<EffectsArray> arrays;
  const auto addRoom = [&](uint32_t binding, const char* name, uint64_t bytesPerBeam) {
    arrays.push_back({binding, name, rows.size() * plan.sensor.columns * bytesPerBeam, {}});
  };
  if (plan.motion()) arrays.push_back(table(gpu::kBindRowOrigins, "rowOrigins", rowOrigins(plan, rows, firstBeam)));
  if (plan.footprint()) {
    arrays.push_back(table(gpu::kBindSubRays, "subRays", subRayLines(plan)));
    addRoom(gpu::kBindHardBeams, "hardBeams", sizeof(uint32_t));
    addRoom(gpu::kBindEchoCounts, "echoCounts", sizeof(uint32_t));
    addRoom(gpu::kBindEchoes, "echoes", gpu::kMaxEchoes * sizeof(gpu::vec4));
    addRoom(gpu::kBindEchoOwners, "echoOwners", gpu::kMaxEchoes * 2 * sizeof(uint32_t));
    if (plan.asks(gpu::kFieldSurface))
      addRoom(gpu::kBindEchoSurfaces, "echoSurfaces", gpu::kMaxEchoes * sizeof(gpu::vec4));
  }
  if (plan.looksAtSurfaces()) arrays.push_back(table(gpu::kBindOptics, "optics", plan.materials->optics));
  if (plan.has(gpu::kCutOuts)) {
    arrays.push_back(table(gpu::kBindAlphaImages, "alphaImages", plan.materials->images));
    arrays.push_back(table(gpu::kBindTexels, "texels", plan.materials->texels));
  }
  if (!plan.deadBeams.empty()) arrays.push_back(table(gpu::kBindDeadBeams, "deadBeams", plan.deadBeams));
  // Surfaces that are looked at but not asked for stay on the device.
  if (plan.surfaces() && !plan.footprint() && !plan.asks(gpu::kFieldSurface))
    addRoom(gpu::kBindSurfaces, "surfaces", plan.returns * sizeof(gpu::vec4));
  return arrays;
}

std::vector<EffectsArray> projectedArrays(const SensorPlan& plan, uint64_t count) {
  std::vector<EffectsArray> arrays;
  if (plan.footprint())
    arrays.push_back({gpu::kBindProjectedMaterials, "projectedMaterials", count * sizeof(uint32_t), {}});
  if (plan.has(gpu::kCutOuts))
    arrays.push_back({gpu::kBindProjectedTexture, "projectedTexture", count * 2 * sizeof(gpu::vec4), {}});
  if (plan.has(gpu::kObjectMotion))
    arrays.push_back({gpu::kBindProjectedMotions, "projectedMotions", count * 3 * sizeof(gpu::vec4), {}});
  return arrays;
}

std::vector<EffectsArray> shotArrays(const SensorPlan& plan, uint64_t firstBeam, const Shot& shot,
                                     const ShotMotion* motion) {
  std::vector<EffectsArray> arrays;
  if (plan.signals()) {
    gpu::EffectParameters parameters = plan.parameters;
    parameters.firstBeam = static_cast<uint32_t>(firstBeam);
    parameters.frame = static_cast<uint32_t>(shot.frame);
    arrays.push_back(table(gpu::kBindParameters, "parameters", std::vector{parameters}));
  }
  if (plan.has(gpu::kVolumes))
    arrays.push_back(
        table(gpu::kBindVolumes, "volumes", volumeBoxes(plan.effects, motion ? motion->tables.middle : shot.pose)));
  if (motion) {
    arrays.push_back(table(gpu::kBindColumnMotions, "columnMotions", motion->tables.columns));
    arrays.push_back(table(gpu::kBindMotionBounds, "motionBounds", std::vector{motion->tables.bounds}));
    arrays.push_back(table(gpu::kBindInstanceMotions, "instanceMotions", motion->instances));
  }
  return arrays;
}

}  // namespace gnosphere

// SPDX-License-Identifier: Apache-2.0
#include "effects/arrays.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "effects/noise.h"

namespace gnosphere {
namespace {

// Of any module of the footprint.
constexpr size_t kMostSubRays = 61;

// Texels of all images, one after the other, and where each lies.
struct PackedImages {
  std::vector<std::array<uint32_t, 4>> images;  // width, height, first byte, how it wraps: u | v << 8
  std::vector<uint8_t> texels;
};

PackedImages packed(const std::vector<AlphaImage>& images) {
  PackedImages result;
  for (const AlphaImage& image : images) {
    const auto wraps = static_cast<uint32_t>(image.wrapU) | static_cast<uint32_t>(image.wrapV) << 8;
    result.images.push_back({image.width, image.height, static_cast<uint32_t>(result.texels.size()), wraps});
    result.texels.insert(result.texels.end(), image.alpha.begin(), image.alpha.end());
  }
  result.texels.resize((result.texels.size() + 3) / 4 * 4);
  return result;
}

template <typename T>
EffectsArray table(uint32_t binding, const char* name, const std::vector<T>& content) {
  const auto bytes = std::as_bytes(std::span(content));
  return {binding, name, bytes.size(), {bytes.begin(), bytes.end()}};
}

}  // namespace

std::vector<Output> outputsOf(const PlannedEffects& planned, bool words) {
  if (words) return {{gpu::kBindWords, 2 * sizeof(uint32_t)}};
  const uint32_t four = planned.returns * sizeof(gpu::vec4), two = planned.returns * 2 * sizeof(uint32_t);
  std::vector<Output> outputs = {{gpu::kBindPoints, four}, {gpu::kBindOwners, two}};
  if (planned.asks(gpu::kFieldSignal)) outputs.push_back({gpu::kBindSignals, four});
  if (planned.asks(gpu::kFieldSurface)) outputs.push_back({gpu::kBindSurfaces, four});
  if (planned.speeds()) outputs.push_back({gpu::kBindMotions, four});
  if (planned.asks(gpu::kFieldBarycentrics)) outputs.push_back({gpu::kBindBarycentrics, two});
  return outputs;
}

uint64_t bytesPerBeam(const PlannedEffects& planned) {
  uint64_t most = sizeof(uint64_t);  // a word
  for (const Output& output : outputsOf(planned)) most = std::max<uint64_t>(most, output.bytesPerBeam);
  if (planned.footprint()) most = std::max<uint64_t>(most, gpu::kMaxEchoes * sizeof(gpu::vec4));
  return most;
}

EffectsArrays::EffectsArrays(const EffectsSetup& setup, std::span<const gpu::Row> rows, const Sensor& part,
                             uint64_t firstBeam)
    : setup_(setup),
      parameters_(effectParameters(setup.effects, setup.sensor, setup.planned.bits)),
      subRays_(subRays(setup.effects, setup.sensor, setup.planned.bits)),
      beams_(part.beamCount()) {
  parameters_.sensor = setup.sensorIndex;
  parameters_.firstBeam = static_cast<uint32_t>(firstBeam);
  parameters_.returnsPerBeam = setup.planned.returns;
  for (const gpu::Row& row : rows) {
    const Vec3& origin = part.channels[static_cast<size_t>(row.angles.w)].origin;
    rowOrigins_.push_back(
        {static_cast<float>(origin.x), static_cast<float>(origin.y), static_cast<float>(origin.z), 0});
  }
}

float EffectsArrays::footprint() const {
  const PlannedEffects& planned = setup_.planned;
  if (!planned.footprint()) return 0;
  double most = 0;
  for (const SubRay& ray : subRays_) most = std::max(most, std::hypot(double{ray.u}, double{ray.v}));
  const Effects::AngleNoise& noise = setup_.effects.angleNoise;
  if (planned.has(gpu::kStrays)) most += gpu::kAngleCutOff * std::hypot(noise.azimuth, noise.elevation);
  return static_cast<float>(most * 1.0001);
}

std::vector<EffectsArray> EffectsArrays::lasting() const {
  const PlannedEffects& planned = setup_.planned;
  std::vector<EffectsArray> arrays;
  const auto addRoom = [&](uint32_t binding, const char* name, uint64_t bytesPerBeam) {
    arrays.push_back({binding, name, beams_ * bytesPerBeam, {}});
  };
  if (planned.motion()) arrays.push_back(table(gpu::kBindRowOrigins, "rowOrigins", rowOrigins_));
  if (planned.footprint()) {
    std::vector<gpu::vec4> lines;
    for (const SubRay& ray : subRays_)
      lines.push_back({ray.u, ray.v, ray.weight, std::sqrt(1 + ray.u * ray.u + ray.v * ray.v)});
    lines.resize(kMostSubRays, {0, 0, 0, 1});  // those that a module has and the footprint has not
    arrays.push_back(table(gpu::kBindSubRays, "subRays", lines));
    addRoom(gpu::kBindHardBeams, "hardBeams", sizeof(uint32_t));
    addRoom(gpu::kBindEchoCounts, "echoCounts", sizeof(uint32_t));
    addRoom(gpu::kBindEchoes, "echoes", gpu::kMaxEchoes * sizeof(gpu::vec4));
    addRoom(gpu::kBindEchoOwners, "echoOwners", gpu::kMaxEchoes * 2 * sizeof(uint32_t));
    if (planned.asks(gpu::kFieldSurface))
      addRoom(gpu::kBindEchoSurfaces, "echoSurfaces", gpu::kMaxEchoes * sizeof(gpu::vec4));
  }
  if (planned.footprint() || planned.surfaces()) arrays.push_back(table(gpu::kBindOptics, "optics", setup_.optics));
  if (planned.has(gpu::kCutOuts)) {
    const PackedImages images = packed(setup_.alphaImages);
    arrays.push_back(table(gpu::kBindAlphaImages, "alphaImages", images.images));
    arrays.push_back(table(gpu::kBindTexels, "texels", images.texels));
  }
  if (const auto dead = deadBeamBits(setup_.effects, setup_.sensor); planned.has(gpu::kDropOut) && !dead.empty())
    arrays.push_back(table(gpu::kBindDeadBeams, "deadBeams", dead));
  // What is looked at but not asked for stays on the device.
  if (planned.surfaces() && !planned.footprint() && !planned.asks(gpu::kFieldSurface))
    addRoom(gpu::kBindSurfaces, "surfaces", planned.returns * sizeof(gpu::vec4));
  return arrays;
}

std::vector<EffectsArray> EffectsArrays::outputs() const {
  std::vector<EffectsArray> arrays;
  for (const Output& output : outputsOf(setup_.planned))
    if (output.binding >= gpu::kWorkBindingCount)
      arrays.push_back({output.binding, "results", beams_ * output.bytesPerBeam, {}});
  return arrays;
}

std::vector<EffectsArray> EffectsArrays::projected(uint64_t count) const {
  const PlannedEffects& planned = setup_.planned;
  std::vector<EffectsArray> arrays;
  if (planned.footprint())
    arrays.push_back({gpu::kBindProjectedMaterials, "projectedMaterials", count * sizeof(uint32_t), {}});
  if (planned.has(gpu::kCutOuts))
    arrays.push_back({gpu::kBindProjectedTexture, "projectedTexture", count * 2 * sizeof(gpu::vec4), {}});
  if (planned.has(gpu::kObjectMotion))
    arrays.push_back({gpu::kBindProjectedMotions, "projectedMotions", count * 3 * sizeof(gpu::vec4), {}});
  return arrays;
}

std::vector<EffectsArray> EffectsArrays::ofShot(const Shot& shot, const ShotMotion* motion) const {
  std::vector<EffectsArray> arrays;
  if (setup_.planned.signals()) {
    gpu::EffectParameters parameters = parameters_;
    parameters.frame = static_cast<uint32_t>(shot.frame);
    arrays.push_back(table(gpu::kBindParameters, "parameters", std::vector{parameters}));
  }
  if (setup_.planned.has(gpu::kVolumes))
    arrays.push_back(table(gpu::kBindVolumes, "volumes", volumeBoxes(setup_.effects, shot.pose)));
  if (motion) {
    arrays.push_back(table(gpu::kBindColumnMotions, "columnMotions", motion->tables.columns));
    arrays.push_back(table(gpu::kBindMotionBounds, "motionBounds", std::vector{motion->tables.bounds}));
    arrays.push_back(table(gpu::kBindInstanceMotions, "instanceMotions", motion->instances));
  }
  return arrays;
}

}  // namespace gnosphere

// SPDX-License-Identifier: Apache-2.0
#include "effects/sensor_plan.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "effects/decide.hpp"
#include "effects/noise.h"

namespace gnosphere {
namespace {

uint32_t bitOf(Field field) {
  switch (field) {
    case Field::intensity:
    case Field::trueRange:
    case Field::width:
    case Field::label:
    case Field::cause: return gpu::kFieldSignal;
    case Field::normal:
    case Field::incidence:
    case Field::material: return gpu::kFieldSurface;
    case Field::velocity:
    case Field::radialSpeed: return gpu::kFieldMotion;
    case Field::barycentrics: return gpu::kFieldBarycentrics;
    default: return 0;
  }
}

float footprintRadiusOf(const SensorPlan& plan) {
  if (!plan.footprint()) return 0;
  double most = 0;
  for (const SubRay& ray : plan.subRays) most = std::max(most, std::hypot(double{ray.u}, double{ray.v}));
  const Effects::AngleNoise& noise = plan.effects.angleNoise;
  if (plan.has(gpu::kStrays)) most += gpu::kAngleCutOff * std::hypot(noise.azimuth, noise.elevation);
  return static_cast<float>(most * 1.0001);
}

SensorPlan planSensor(const Scene& scene, const Sensor& sensor, uint32_t index, const SimulatorOptions& options) {
  const Effects& effects = options.effects;
  SensorPlan plan;
  plan.sensor = sensor;
  plan.effects = effects;
  plan.decisions = decide(effects, sensor, scene, options.fields, options.materials);
  leaveOutUnsupported(options, plan.decisions);
  plan.bits = bitsOf(plan.decisions);
  if (plan.has(gpu::kAngleNoise) && effects.angleNoise.at == Effects::AngleNoise::At::beam) plan.bits |= gpu::kStrays;
  for (const Field field : options.fields) plan.fields |= bitOf(field);
  plan.origins = std::any_of(sensor.channels.begin(), sensor.channels.end(), [](const Channel& channel) {
    return channel.origin.x != 0 || channel.origin.y != 0 || channel.origin.z != 0;
  });
  plan.looksAtMaterials = plan.has(gpu::kIntensity) && effects.intensity.model == Effects::Intensity::Model::physical;
  plan.parameters = effectParameters(effects, sensor, plan.bits);
  plan.parameters.sensor = index;
  plan.returns = plan.parameters.returnsPerBeam;
  plan.subRays = subRays(effects, sensor, plan.bits);
  if (plan.has(gpu::kDropOut)) plan.deadBeams = deadBeamBits(effects, sensor);
  plan.footprintRadius = footprintRadiusOf(plan);
  return plan;
}

void addOptics(const Scene& scene, const SimulatorOptions& options, MaterialArrays& arrays) {
  for (const Optics& optics : opticsOf(scene, options.materials, options.effects.intensity.wavelength)) {
    const Material& material = scene.materials[arrays.optics.size()];
    const bool mask = material.alphaMode == AlphaMode::mask;
    gpu::Optics4 packed = {};
    packed.reflection = {optics.reflectance, optics.gloss, optics.roughness, optics.retro};
    packed.passage = {optics.transmission, mask ? material.alphaCutoff : 0, material.baseColor[3]};
    packed.alphaImage = mask ? material.alphaImage : gpu::kNone;
    arrays.optics.push_back(packed);
  }
}

void addTexels(const Scene& scene, MaterialArrays& arrays) {
  for (const AlphaImage& image : scene.alphaImages) {
    const auto wraps = static_cast<uint32_t>(image.wrapU) | static_cast<uint32_t>(image.wrapV) << 8;
    arrays.images.push_back({image.width, image.height, static_cast<uint32_t>(arrays.texels.size()), wraps});
    arrays.texels.insert(arrays.texels.end(), image.alpha.begin(), image.alpha.end());
  }
  arrays.texels.resize((arrays.texels.size() + 3) / 4 * 4);
}

}  // namespace

std::vector<SensorPlan> planSensors(const Scene& scene, const std::vector<Sensor>& sensors,
                                    const SimulatorOptions& options) {
  std::vector<SensorPlan> plans;
  for (const Sensor& sensor : sensors)
    plans.push_back(planSensor(scene, sensor, static_cast<uint32_t>(plans.size()), options));
  if (options.device == "reference") return plans;
  const auto arrays = std::make_shared<MaterialArrays>();
  addOptics(scene, options, *arrays);
  if (anyOf(plans, &SensorPlan::holes)) addTexels(scene, *arrays);
  for (SensorPlan& plan : plans) plan.materials = arrays;
  return plans;
}

bool anyOf(const std::vector<SensorPlan>& plans, bool (SensorPlan::*has)() const) {
  return std::any_of(plans.begin(), plans.end(), [&](const SensorPlan& plan) { return (plan.*has)(); });
}

void resizeArrays(const SensorPlan& plan, Scan& scan, bool cleared) {
  constexpr float kMiss = std::numeric_limits<float>::quiet_NaN();
  const size_t beams = plan.sensor.beamCount(), count = beams * plan.returns;
  const auto resize = [&](auto& array, bool asked, size_t size, auto nothing) {
    if (cleared) array.clear();
    array.resize(asked ? size : 0, nothing);
  };
  scan.returns = plan.returns;
  resize(scan.points, true, 3 * count, kMiss);
  resize(scan.ranges, true, count, kMiss);
  resize(scan.triangles, true, count, kNoTriangle);
  resize(scan.instances, true, count, kNoTriangle);
  const bool signal = plan.asks(gpu::kFieldSignal), surface = plan.asks(gpu::kFieldSurface);
  for (auto* array : {&scan.intensities, &scan.trueRanges, &scan.widths}) resize(*array, signal, count, kMiss);
  resize(scan.labels, signal, count, uint8_t{0});
  resize(scan.causes, signal, beams, uint8_t{0});
  resize(scan.normals, surface, 3 * count, kMiss);
  resize(scan.incidences, surface, count, kMiss);
  resize(scan.materials, surface, count, kNoTriangle);
  resize(scan.velocities, plan.speeds(), 3 * count, 0.0f);
  resize(scan.radialSpeeds, plan.speeds(), count, kMiss);
  resize(scan.barycentrics, plan.asks(gpu::kFieldBarycentrics), 2 * count, kMiss);
}

}  // namespace gnosphere

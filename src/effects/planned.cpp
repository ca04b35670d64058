// SPDX-License-Identifier: Apache-2.0
#include "effects/planned.hpp"

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

uint32_t returnsOf(const Effects::Returns& returns, const Sensor& sensor) {
  using Mode = Effects::Returns::Mode;
  switch (returns.mode) {
    case Mode::first:
    case Mode::second:
    case Mode::last:
    case Mode::strongest:
    case Mode::secondStrongest: return 1;
    case Mode::all: return returns.count > 0 ? returns.count : std::max(1u, sensor.maxReturns);
    default: return 2;
  }
}

}  // namespace

PlannedEffects planEffects(const SimulatorOptions& options, const Sensor& sensor, const Scene& scene) {
  PlannedEffects planned;
  planned.decisions = decide(options.effects, sensor, scene, options.fields, options.materials);
  // Not yet on any device but the reference.
  constexpr uint32_t kComing = gpu::kCutOuts | gpu::kSensorMotion | gpu::kObjectMotion;
  for (size_t i = 0; i < planned.decisions.size(); ++i)
    if (planned.decisions[i].in && (1u << i & kComing) != 0 && options.device != "reference") {
      planned.decisions[i].in = false;
      planned.decisions[i].reason = "not simulated yet";
    }
  planned.bits = bitsOf(planned.decisions);
  for (Field field : options.fields) planned.fields |= bitOf(field);
  if (planned.has(gpu::kReturns)) planned.returns = returnsOf(options.effects.returns, sensor);
  if (planned.has(gpu::kAngleNoise) && options.effects.angleNoise.at == Effects::AngleNoise::At::beam)
    planned.bits |= gpu::kStrays;
  if (planned.has(gpu::kDivergence)) planned.subRays = options.effects.divergence.subRays;
  planned.looksAtMaterials =
      planned.has(gpu::kIntensity) && options.effects.intensity.model == Effects::Intensity::Model::physical;
  return planned;
}

}  // namespace gnosphere

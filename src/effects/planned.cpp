// SPDX-License-Identifier: Apache-2.0
#include "effects/planned.hpp"

#include <algorithm>

#include "gnosphere/error.hpp"

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

// Takes an effect out that the stages cannot show; one that was asked for is refused.
void leaveOut(Plan::Decision& decision, const std::string& reason) {
  if (!decision.in) return;
  if (decision.request == Use::on) throw Error(ErrorCode::invalidArgument, decision.effect + " is on, but " + reason);
  decision.in = false;
  decision.reason = reason;
}

void leaveOut(const SimulatorOptions& options, std::vector<Plan::Decision>& decisions) {
  if (options.device == "reference") return;
  const Exactness parts = options.exactness.value_or(exactnessOf(options.accuracy));
  const Exactness standard = exactnessOf(Accuracy::standard);
  const bool watertight = parts.inside == standard.inside && parts.bounds == standard.bounds;
  const bool bounded = parts.bounds == standard.bounds;
  for (size_t i = 0; i < decisions.size(); ++i) {
    const uint32_t bit = 1u << i;
    if ((bit & (gpu::kSensorMotion | gpu::kObjectMotion)) != 0 && !watertight)
      leaveOut(decisions[i], "motion within a scan needs accuracy standard");
    if ((bit & gpu::kFootprintEffects) != 0 && !bounded)
      leaveOut(decisions[i], "accuracy paper knows lines only; use draft, standard or exact");
  }
}

}  // namespace

PlannedEffects planEffects(const SimulatorOptions& options, const Sensor& sensor, const Scene& scene) {
  PlannedEffects planned;
  planned.decisions = decide(options.effects, sensor, scene, options.fields, options.materials);
  leaveOut(options, planned.decisions);
  planned.bits = bitsOf(planned.decisions);
  for (Field field : options.fields) planned.fields |= bitOf(field);
  if (planned.has(gpu::kReturns)) planned.returns = returnsOf(options.effects.returns, sensor);
  if (planned.has(gpu::kAngleNoise) && options.effects.angleNoise.at == Effects::AngleNoise::At::beam)
    planned.bits |= gpu::kStrays;
  if (planned.has(gpu::kDivergence)) planned.subRays = options.effects.divergence.subRays;
  for (const Channel& channel : sensor.channels)
    if (channel.origin.x != 0 || channel.origin.y != 0 || channel.origin.z != 0) planned.origins = true;
  planned.looksAtMaterials =
      planned.has(gpu::kIntensity) && options.effects.intensity.model == Effects::Intensity::Model::physical;
  return planned;
}

}  // namespace gnosphere

// SPDX-License-Identifier: Apache-2.0
#include "simulator_warnings.hpp"

#include "base/limits.hpp"
#include "base/transform.hpp"
#include "effects/material_table.hpp"

namespace gnosphere {
namespace {

/// Returns what the speeds lack that a sensor measures, if one of its effects is left out.
std::string lackOfSpeeds(const SensorPlan& plan, const std::string& effect) {
  if (effect != "object-motion" || !plan.speeds()) return "";
  return ", so radial_speed and velocity have no speeds of what moves in the scene";
}

}  // namespace

void SimulatorWarnings::tellScene(const Scene& scene) const {
  if (!options_.warn) return;
  tellUnusedRows(scene);
  tellShears(scene);
}

// A scene without materials is filled later.
void SimulatorWarnings::tellUnusedRows(const Scene& scene) const {
  if (scene.materials.empty() || options_.materials.rows.empty()) return;
  for (const std::string& warning : warningsOf(options_.materials, scene)) options_.warn(warning);
}

void SimulatorWarnings::tellShears(const Scene& scene) const {
  std::string first;
  size_t more = 0;
  for (size_t i = 0; i < scene.instances.size(); ++i) {
    const Instance& instance = scene.instances[i];
    if (limits::kCondition.holds(conditionOf(instance.transform))) continue;
    if (first.empty())
      first = "instance " + std::to_string(i) + (instance.name.empty() ? "" : " '" + instance.name + "'");
    else
      ++more;
  }
  if (first.empty()) return;
  options_.warn(first + (more > 0 ? " and " + std::to_string(more) + " more are" : " is") +
                " sheared so strongly that the error bounds of the accuracies do not hold; see docs/limits.md");
}

void SimulatorWarnings::tellPlan(const SensorPlan& plan) const {
  if (!options_.warn) return;
  const std::string name = "sensor '" + plan.sensor.name + "'";
  if (plan.sensor.beamCount() == 0) options_.warn(name + " has no channels, so its scans have no beams");
  for (const Plan::Decision& decision : plan.decisions)
    if (decision.leftOut)
      options_.warn(name + ": " + decision.effect + " is left out: " + decision.reason +
                    lackOfSpeeds(plan, decision.effect));
  if (!plan.looksAtMaterials || !plan.has(gpu::kDetection | gpu::kMediumEffects)) return;
  const std::string guess = warningOf(options_.materials, plan.effects.intensity.wavelength);
  if (!guess.empty()) options_.warn(name + ": " + guess);
}

void SimulatorWarnings::tellLeftOut(const Shot& shot, const SensorPlan& plan) {
  if (!options_.warn) return;
  const bool sensor = !shot.motion.stamps.empty() && !plan.speeds() && !plan.has(gpu::kSensorMotion);
  const bool objects = (!shot.instanceMotions.empty() || !shot.meshMotions.empty()) && !plan.has(gpu::kObjectMotion);
  if (!sensor && !objects) return;
  for (const Plan::Decision& decision : plan.decisions) {
    const bool brought =
        (decision.effect == "sensor-motion" && sensor) || (decision.effect == "object-motion" && objects);
    if (!brought || decision.leftOut || decision.request == EffectUse::off) continue;
    if (!told_.emplace(shot.sensor, decision.effect).second) continue;
    options_.warn("sensor '" + plan.sensor.name + "': " + decision.effect +
                  " is left out, although a shot brings it: " + decision.reason + lackOfSpeeds(plan, decision.effect));
  }
}

void SimulatorWarnings::tellLostEchoes(size_t sensor, const SensorPlan& plan, const Counters& counters) {
  constexpr uint64_t kFew = 100;  // beams per lost echo; in streets some beams meet glass of several cars
  if (!options_.warn || !plan.has(gpu::kTransmission) || counters.lostEchoes * kFew < counters.beams) return;
  if (counters.lostEchoes == 0 || !told_.emplace(sensor, "transmission").second) return;
  options_.warn("sensor '" + plan.sensor.name + "': " + std::to_string(counters.lostEchoes) + " echoes of " +
                std::to_string(counters.beams) + " beams are lost, because a beam sees at most " +
                std::to_string(gpu::kMaxLayers) + " surfaces behind each other" +
                (plan.footprint() ? " and keeps " + std::to_string(gpu::keptEchoes(plan.returns)) + " echoes" : "") +
                "; a pane of glass with two faces is two surfaces, so model it as one");
}

void SimulatorWarnings::forget(size_t sensor) {
  std::erase_if(told_, [&](const auto& told) { return told.first == sensor; });
}

}  // namespace gnosphere

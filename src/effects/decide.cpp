// SPDX-License-Identifier: Apache-2.0
#include "effects/decide.hpp"

#include "base/limits.hpp"
#include "common/effects/bits.h"
#include "effects/effect_table.hpp"

namespace gnosphere {
namespace {

/// Replaces "the sensor" by the sensor's name, for a message without context.
std::string named(const std::string& why, const Sensor& sensor) {
  constexpr std::string_view kSensor = "the sensor";
  if (why.compare(0, kSensor.size(), kSensor) != 0) return why;
  return "sensor '" + sensor.name + "'" + why.substr(kSensor.size());
}

[[noreturn]] void refuseRequest(const std::string& what) {
  throw Error(ErrorCode::invalidArgument, what);
}

void decideBy(const Answer& answer, const Sensor& sensor, bool lenient, Plan::Decision& decision) {
  if (answer.wrong && !lenient)
    refuseRequest(decision.effect + ": " + named(answer.why, sensor) + "; " + answer.wayOut);
  if (decision.request == EffectUse::on) {
    if (!answer.shows && !answer.wayOut.empty() && !lenient) {
      refuseRequest(decision.effect + " is on, but " + named(answer.why, sensor) + "; " + answer.wayOut +
                    ", or leave it to auto");
    }
    decision.reason = answer.shows ? "asked for: " + answer.why : "asked for";
  } else {
    decision.reason = answer.why;
  }
  decision.in = decision.request == EffectUse::on || answer.shows;
}

/// Returns the names of the planned effects that need intensity.
std::vector<std::string> needIntensity(const Effects& effects, const std::vector<Plan::Decision>& decisions) {
  std::vector<std::string> names;
  for (size_t i = 0; i < decisions.size(); ++i)
    if (decisions[i].in && effectTable()[i].needsIntensity(effects)) names.push_back(decisions[i].effect);
  return names;
}

/// Effects of the medium apply the threshold of detection, because without one weaker light has no consequence.
void decideThreshold(const Question& q, std::vector<Plan::Decision>& decisions) {
  std::string medium;
  size_t detection = 0;
  for (size_t i = 0; i < decisions.size(); ++i) {
    const uint32_t bit = effectTable()[i].bit;
    if (bit == gpu::kDetection) detection = i;
    if (decisions[i].in && (bit & gpu::kMediumEffects) != 0 && medium.empty()) medium = decisions[i].effect;
  }
  Plan::Decision& decision = decisions[detection];
  if (medium.empty() || decision.in) return;
  if (decision.request == EffectUse::off) {
    decision.reason += ", but " + medium + " applies its threshold";
    return;
  }
  Effects on = q.effects;
  on.detection.use = EffectUse::on;
  const Answer answer = effectTable()[detection].applies(
      {on, q.sensor, q.scene, q.fields, q.materials, q.ignoredInstances, q.variableWeather});
  decision.in = answer.shows;
  decision.reason = "needed by " + medium + ": " + answer.why;
}

/// Throws if the reflectance of detection is set without a range, and the range that the sensor states is one at 10 %.
void checkReflectance(const Question& q) {
  const Effects::Detection& detection = q.effects.detection;
  const bool set = detection.reflectance != Effects::Detection().reflectance;
  if (set && detection.range == 0 && q.sensor.rangeAt10Percent > 0)
    refuseRequest("detection.reflectance is given without detection.range, but the range that sensor '" +
                  q.sensor.name + "' states is one at 10 %; give detection.range, too");
}

Answer appliesIntensity(const Question& q, const std::vector<std::string>& needIt) {
  if (q.asksFor(Field::intensity)) return {true, "the field intensity asks for it"};
  if (needIt.empty()) return {false, "nothing asks for it"};
  std::string who;
  for (const std::string& name : needIt) who += (who.empty() ? "" : ", ") + name;
  return {true, "needed by " + who};
}

/// Throws if the request turns off an effect that a field or another effect needs.
void checkOff(const Question& q, const std::vector<std::string>& needIntensity) {
  if (q.effects.radialSpeed.use == EffectUse::off && q.asksFor(Field::radialSpeed)) {
    refuseRequest("radial-speed is off, but the field radial_speed is asked for; set radial-speed to auto");
  }
  if (q.effects.intensity.use != EffectUse::off) return;
  if (q.asksFor(Field::intensity))
    refuseRequest("intensity is off, but the field intensity is asked for; set intensity to auto");
  if (!needIntensity.empty()) {
    refuseRequest("intensity is off, but " + needIntensity.front() + " needs it; set intensity to auto");
  }
}

void leaveOut(Plan::Decision& decision, const std::string& reason) {
  if (!decision.in) return;
  if (decision.request == EffectUse::on) refuseRequest(decision.effect + " is on, but " + reason);
  decision.in = false;
  decision.leftOut = true;
  decision.reason = reason;
}

}  // namespace

std::vector<Plan::Decision> decide(const SensorRequest& request, const Scene& scene, const MaterialTable& materials,
                                   bool lenient) {
  const Effects& effects = request.effects;
  validate(effects);
  const Question question = {
      effects, request.sensor, scene, request.fields, materials, request.ignoredInstances, request.variableWeather};
  Effects asked = effects;
  std::vector<Plan::Decision> decisions;
  for (const EffectInfo& info : effectTable()) {
    Plan::Decision& decision = decisions.emplace_back();
    decision.effect = info.name;
    decision.request = info.use(asked);
    if (decision.request == EffectUse::off) {
      decision.reason = "off in the request";
    } else if (effects.intensity.use == EffectUse::off && decision.request == EffectUse::automatic &&
               info.needsIntensity(effects)) {
      decision.reason = "intensity, which it needs, is off in the request";
      Question fixed = question;  // a place for the weather of shots calls for nothing
      fixed.variableWeather = false;
      decision.leftOut = info.applies && info.applies(fixed).shows;
    } else if (info.applies) {
      decideBy(info.applies(question), request.sensor, lenient, decision);
    }
  }
  if (!lenient) checkReflectance(question);
  decideThreshold(question, decisions);
  const std::vector<std::string> needIt = needIntensity(effects, decisions);
  for (size_t i = 0; i < decisions.size(); ++i) {
    if (effectTable()[i].applies || decisions[i].request == EffectUse::off) continue;
    const bool on = decisions[i].request == EffectUse::on;
    decideBy(on ? Answer{false, ""} : appliesIntensity(question, needIt), request.sensor, lenient, decisions[i]);
  }
  checkOff(question, needIt);
  return decisions;
}

AccuracyParts accuracyPartsOf(const SimulatorOptions& options) {
  return options.accuracyParts.value_or(accuracyPartsOf(options.accuracy));
}

void leaveOutUnsupported(const SimulatorOptions& options, const Effects& effects,
                         std::vector<Plan::Decision>& decisions) {
  if (options.device.kind == DeviceChoice::Kind::reference) return;
  const AccuracyParts parts = accuracyPartsOf(options);
  const AccuracyParts standard = accuracyPartsOf(Accuracy::standard);
  const bool bounded = parts.bounds == standard.bounds, watertight = bounded && parts.inside == standard.inside;
  const bool strays = effects.angleNoise.at == Effects::AngleNoise::At::beam;
  const uint32_t footprints = gpu::kFootprintEffects | (strays ? gpu::kAngleNoise : 0);
  for (size_t i = 0; i < decisions.size(); ++i) {
    const uint32_t bit = effectTable()[i].bit;
    if ((bit & (gpu::kSensorMotion | gpu::kObjectMotion)) != 0 && !watertight)
      leaveOut(decisions[i], "motion within a scan needs accuracy standard");
    if ((bit & footprints) != 0 && !bounded)
      leaveOut(decisions[i], "accuracy paper knows lines only; use draft, standard or exact");
  }
}

void checkSubRays(const SimulatorOptions& options, const Effects& effects) {
  const uint32_t asked = effects.divergence.subRays;
  if (options.device.kind == DeviceChoice::Kind::reference || asked <= limits::kSubRays.most) return;
  refuseRequest("divergence.sub_rays is " + std::to_string(asked) + ", but a device takes at most " +
                std::to_string(limits::kSubRays.most) + "; only the reference takes more");
}

uint32_t bitsOf(const std::vector<Plan::Decision>& decisions) {
  uint32_t bits = 0;
  for (size_t i = 0; i < decisions.size(); ++i) bits |= decisions[i].in ? effectTable()[i].bit : 0;
  return bits;
}

}  // namespace gnosphere

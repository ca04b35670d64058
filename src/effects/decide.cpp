// SPDX-License-Identifier: Apache-2.0
#include "effects/decide.hpp"

#include <algorithm>
#include <array>
#include <cstdio>

#include "effects/bits.h"
#include "effects/request_table.hpp"
#include "gnosphere/error.hpp"

namespace gnosphere {
namespace {

struct Question {
  const Effects& effects;
  const Sensor& sensor;
  const Scene& scene;
  const std::vector<Field>& fields;
  const MaterialTable& table;

  bool asksFor(Field field) const { return std::find(fields.begin(), fields.end(), field) != fields.end(); }
};

/// Whether an effect can be shown: by what, or what is missing and how it would be given.
struct Answer {
  bool shows;
  std::string why;
  std::string wayOut = {};
};

std::string format(const char* format, double a, double b = 0) {
  char buffer[96];
  std::snprintf(buffer, sizeof(buffer), format, a, b);
  return buffer;
}

std::string plural(size_t count, const char* noun, const char* nouns) {
  return std::to_string(count) + " " + (count == 1 ? noun : nouns);
}

/// Of each material, whether a placed instance shows it.
std::vector<bool> usedMaterials(const Scene& scene) {
  std::vector<bool> used(scene.materials.size());
  for (const Instance& instance : scene.instances) {
    for (const MeshPart& part : scene.meshes[instance.mesh].parts) {
      if (part.triangleCount > 0) used[part.material] = true;
    }
  }
  return used;
}

/// "2 of 14 materials transmit light", of those that are seen.
template <class Has>
Answer countMaterials(const Scene& scene, Has has, const char* does, const char* none, const char* wayOut) {
  const std::vector<bool> used = usedMaterials(scene);
  size_t seen = 0, count = 0;
  for (size_t i = 0; i < used.size(); ++i) {
    seen += used[i];
    count += used[i] && has(i);
  }
  if (count == 0) return {false, none, wayOut};
  return {true, std::to_string(count) + " of " + plural(seen, "material ", "materials ") + does};
}

Answer detection(const Question& q) {
  const auto& detection = q.effects.detection;
  const double range = detection.range > 0 ? detection.range : q.sensor.rangeMax;
  if (!(range > 0)) return {false, "the sensor sees no further than 0 m", "give detection.range"};
  return {true, format("as strong as %.3g %% at %.6g m", 100 * detection.reflectance, range)};
}

Answer dropOut(const Question& q) {
  const auto& dropOut = q.effects.dropOut;
  const size_t beams = q.sensor.beamCount();
  for (uint32_t beam : dropOut.deadBeams) {
    if (beam < beams) continue;
    return {false, "the sensor has no beam " + std::to_string(beam) + ", it has " + std::to_string(beams),
            "give drop-out.dead_beams from 0 to " + std::to_string(beams - 1)};
  }
  if (dropOut.generalRate == 0 && dropOut.zeroIntensityRate == 0 && dropOut.deadBeams.empty()) {
    return {false, "no rate and no dead beam is given",
            "give drop-out.general_rate, drop-out.zero_intensity_rate or drop-out.dead_beams"};
  }
  std::string why;
  const auto add = [&](const std::string& text) { why += (why.empty() ? "" : ", ") + text; };
  if (dropOut.generalRate > 0) add(format("%.3g %% at random", 100 * dropOut.generalRate));
  if (dropOut.zeroIntensityRate > 0) {
    add(format("%.3g %% at intensity 0, none above %.3g", 100 * dropOut.zeroIntensityRate, dropOut.intensityLimit));
  }
  if (!dropOut.deadBeams.empty()) add(plural(dropOut.deadBeams.size(), "dead beam", "dead beams"));
  return {true, why};
}

Answer rangeNoise(const Question& q) {
  const auto& noise = q.effects.rangeNoise;
  if (noise.bias == 0 && noise.sigma == 0 && noise.sigmaPerMetre == 0 && noise.step == 0) {
    return {false, "its bias, sigma and step are 0", "give range-noise.sigma"};
  }
  std::string why = format("sigma %.3g m", noise.sigma);
  if (noise.sigmaPerMetre != 0) why += format(" + %.3g m per m", noise.sigmaPerMetre);
  if (noise.bias != 0) why += format(", bias %.3g m", noise.bias);
  if (noise.step != 0) why += format(", steps of %.3g m", noise.step);
  return {true, why};
}

Answer angleNoise(const Question& q) {
  const auto& noise = q.effects.angleNoise;
  if (noise.azimuth == 0 && noise.elevation == 0) {
    return {false, "its sigmas are 0", "give angle-noise.azimuth or angle-noise.elevation"};
  }
  return {true, format("sigma %.3g x %.3g mrad", 1e3 * noise.azimuth, 1e3 * noise.elevation)};
}

Answer intensityNoise(const Question& q) {
  const double sigma = q.effects.intensityNoise.sigma;
  if (sigma == 0) return {false, "its sigma is 0", "give intensity-noise.sigma"};
  return {true, format("sigma %.3g", sigma)};
}

Answer divergence(const Question& q) {
  const auto& d = q.effects.divergence;
  const bool asked = d.horizontal > 0 || d.vertical > 0;
  const double horizontal = asked ? d.horizontal : q.sensor.divergenceHorizontal;
  const double vertical = asked ? d.vertical : q.sensor.divergenceVertical;
  if (!(horizontal > 0 || vertical > 0)) {
    return {false, "the sensor states no divergence", "give divergence.horizontal and divergence.vertical"};
  }
  return {true, (asked ? "the request states " : "the sensor states ") +
                    format("%.3g x %.3g mrad", 1e3 * horizontal, 1e3 * vertical) + ", " +
                    plural(d.subRays, "sub-ray", "sub-rays")};
}

Answer returns(const Question& q) {
  const uint32_t asked = q.effects.returns.count, most = asked > 0 ? asked : q.sensor.maxReturns;
  if (most == 1) return {false, "the sensor reports one return per beam"};
  return {true, (asked > 0 ? "the request takes up to " : "the sensor reports up to ") +
                    plural(most, "return", "returns") + " per beam"};
}

Answer transmission(const Question& q) {
  const std::vector<Optics> optics = opticsOf(q.scene, q.table, q.effects.intensity.wavelength);
  return countMaterials(
      q.scene, [&](size_t i) { return optics[i].transmission > 0; }, "let light through",
      "no material that is seen lets light through", "give a material transmission");
}

/// A texel of the mask is below the cutoff, or the whole material is.
bool hasHoles(const Scene& scene, const Material& material) {
  if (material.alphaMode != AlphaMode::mask) return false;
  float least = material.baseColor[3];
  if (material.alphaImage != kNoImage) {
    const auto& alpha = scene.alphaImages[material.alphaImage].alpha;
    if (!alpha.empty()) least *= static_cast<float>(*std::min_element(alpha.begin(), alpha.end())) / 255;
  }
  return least < material.alphaCutoff;
}

Answer cutOuts(const Question& q) {
  return countMaterials(
      q.scene, [&](size_t i) { return hasHoles(q.scene, q.scene.materials[i]); }, "have holes",
      "no material that is seen has holes", "give a material alphaMode MASK and a texture with alpha");
}

Answer motion(const Question& q) {
  if (!(q.sensor.rotationPeriod > 0)) {
    return {false, "the sensor fires all beams at once", "give the sensor a rotation period"};
  }
  return {true, format("the sensor takes %.6g s for a turn", q.sensor.rotationPeriod)};
}

Answer fog(const Question& q) {
  const double visibility = q.effects.fog.visibility;
  if (visibility == 0) return {false, "no visibility is given", "give fog.visibility"};
  return {true, format("visibility %.6g m", visibility)};
}

Answer rain(const Question& q) {
  const double rate = q.effects.rain.rate;
  if (rate == 0) return {false, "no rate is given", "give rain.rate"};
  return {true, format("%.6g mm/h", rate)};
}

Answer snow(const Question& q) {
  const double rate = q.effects.snow.rate;
  if (rate == 0) return {false, "no rate is given", "give snow.rate"};
  return {true, format("%.6g mm/h, melted", rate)};
}

Answer volumes(const Question& q) {
  const auto& boxes = q.effects.volumes.boxes;
  if (boxes.empty()) return {false, "no box is given", "give volumes.boxes"};
  return {true, plural(boxes.size(), "box", "boxes")};
}

Answer radialSpeed(const Question& q) {
  if (!q.asksFor(Field::radialSpeed)) return {false, "no field asks for it"};
  return {true, "the field radial_speed asks for it"};
}

// In the order of effectNames(); intensity is judged last, by who needs it.
using Judge = Answer (*)(const Question&);
constexpr std::array<Judge, gpu::kEffectCount> kJudges = {
    nullptr, detection, dropOut, rangeNoise, angleNoise, intensityNoise, divergence, returns,    transmission,
    cutOuts, motion,    motion,  fog,        rain,       snow,           volumes,    radialSpeed};

// What can be shown in any case, so that `on` needs nothing else: one return per beam can be chosen, and a speed of 0
// is a speed.
constexpr uint32_t kAlwaysShown = gpu::kIntensity | gpu::kReturns | gpu::kRadialSpeed;

// Each weighs echoes by their energy.
constexpr uint32_t kNeedIntensity = gpu::kDetection | gpu::kIntensityNoise | gpu::kDivergence | gpu::kReturns |
                                    gpu::kTransmission | gpu::kMediumEffects;

bool needsIntensity(const Question& q, size_t effect) {
  if (1u << effect == gpu::kDropOut) return q.effects.dropOut.zeroIntensityRate > 0;
  return (kNeedIntensity >> effect & 1) != 0;
}

/// "the sensor" by its name, for a message that stands alone.
std::string named(const std::string& why, const Sensor& sensor) {
  constexpr std::string_view kSensor = "the sensor";
  if (why.compare(0, kSensor.size(), kSensor) != 0) return why;
  return "sensor '" + sensor.name + "'" + why.substr(kSensor.size());
}

[[noreturn]] void refuse(const std::string& what) {
  throw Error(ErrorCode::invalidArgument, what);
}

void decideBy(const Answer& answer, const Sensor& sensor, bool alwaysShown, Plan::Decision& decision) {
  if (decision.request == Use::on) {
    if (!answer.shows && !alwaysShown) {
      refuse(decision.effect + " is on, but " + named(answer.why, sensor) + "; " + answer.wayOut +
             ", or leave it to auto");
    }
    decision.reason = answer.shows ? "asked for: " + answer.why : "asked for";
  } else {
    decision.reason = answer.why;
  }
  decision.in = decision.request == Use::on || answer.shows;
}

/// Intensity: in where something needs it, and something that needs it must not be in without.
Answer intensity(const Question& q, const std::vector<Plan::Decision>& decisions) {
  if (q.asksFor(Field::intensity)) return {true, "the field intensity asks for it"};
  std::string who;
  for (size_t i = 1; i < decisions.size(); ++i) {
    if (decisions[i].in && needsIntensity(q, i)) who += (who.empty() ? "" : ", ") + decisions[i].effect;
  }
  if (who.empty()) return {false, "nothing asks for it"};
  return {true, "needed by " + who};
}

/// What was asked for and is off.
void checkOff(const Question& q, const std::vector<Plan::Decision>& decisions) {
  if (q.effects.radialSpeed.use == Use::off && q.asksFor(Field::radialSpeed)) {
    refuse("radial-speed is off, but the field radial_speed is asked for; leave radial-speed to auto");
  }
  if (q.effects.intensity.use != Use::off) return;
  if (q.asksFor(Field::intensity)) refuse("intensity is off, but the field intensity is asked for; leave it to auto");
  for (size_t i = 1; i < decisions.size(); ++i) {
    if (decisions[i].in && needsIntensity(q, i)) {
      refuse("intensity is off, but " + decisions[i].effect + " needs it; leave intensity to auto");
    }
  }
}

}  // namespace

std::vector<Plan::Decision> decide(const Effects& effects, const Sensor& sensor, const Scene& scene,
                                   const std::vector<Field>& fields, const MaterialTable& table) {
  validate(effects);
  const Question question = {effects, sensor, scene, fields, table};
  Effects asked = effects, defaults;
  std::vector<Plan::Decision> decisions;
  for (const EffectInfo& info : effectTable()) {
    const size_t i = decisions.size();
    Plan::Decision& decision = decisions.emplace_back();
    decision.effect = info.name;
    decision.request = info.use(asked);
    if (decision.request == Use::off) {
      decision.reason = info.use(defaults) == Use::off ? "not asked for" : "off in the request";
    } else if (i > 0 && effects.intensity.use == Use::off && decision.request == Use::automatic &&
               needsIntensity(question, i)) {
      decision.reason = "intensity, which it needs, is off in the request";
    } else if (i > 0) {
      decideBy(kJudges[i](question), sensor, (kAlwaysShown >> i & 1) != 0, decision);
    }
  }
  if (effects.intensity.use == Use::automatic) decideBy(intensity(question, decisions), sensor, true, decisions[0]);
  if (effects.intensity.use == Use::on) decideBy({false, ""}, sensor, true, decisions[0]);
  checkOff(question, decisions);
  return decisions;
}

uint32_t bitsOf(const std::vector<Plan::Decision>& decisions) {
  uint32_t bits = 0;
  for (size_t i = 0; i < decisions.size(); ++i) bits |= decisions[i].in ? 1u << i : 0u;
  return bits;
}

}  // namespace gnosphere

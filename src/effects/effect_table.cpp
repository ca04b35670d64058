// SPDX-License-Identifier: Apache-2.0
#include "effects/effect_table.hpp"

#include <algorithm>
#include <cstdio>
#include <set>
#include <string>

#include "base/decimal_point.hpp"
#include "base/lasting.hpp"
#include "base/limits.hpp"
#include "base/text.hpp"
#include "common/effects/bits.h"
#include "effects/formula_inputs.hpp"
#include "sensor/beams.hpp"

namespace gnosphere {
namespace {

std::string format(const char* format, double a, double b = 0) {
  const DecimalPoint point;
  char buffer[96];
  std::snprintf(buffer, sizeof(buffer), format, a, b);
  return buffer;
}

std::string plural(size_t count, const char* noun, const char* nouns) {
  return std::to_string(count) + " " + (count == 1 ? noun : nouns);
}

/// Returns for each material whether an instance that the sensor sees uses it.
std::vector<bool> seenMaterials(const Question& q) {
  std::vector<bool> seen(q.scene.materials.size()), ignored(q.scene.instances.size());
  for (const uint32_t instance : q.ignoredInstances)
    if (instance < ignored.size()) ignored[instance] = true;
  for (size_t i = 0; i < ignored.size(); ++i) {
    const uint32_t mesh = q.scene.instances[i].mesh;
    if (mesh == kNoMesh || ignored[i]) continue;
    for (const MeshPart& part : q.scene.meshes[mesh].parts) {
      if (part.triangleCount > 0) seen[part.material] = true;
    }
  }
  return seen;
}

/// Counts the seen materials with a property and returns text such as "2 of 14 materials transmit light".
template <class Has>
Answer countMaterials(const Question& q, Has has, const char* does, const char* none, const char* wayOut) {
  const std::vector<bool> seen = seenMaterials(q);
  size_t all = 0, count = 0;
  for (size_t i = 0; i < seen.size(); ++i) {
    all += seen[i];
    count += seen[i] && has(i);
  }
  if (count == 0) return {false, none, wayOut};
  return {true, std::to_string(count) + " of " + plural(all, "material ", "materials ") + does};
}

/// Tells how many of the seen materials have no reflectance in the material table at the wavelength; `shows` if none.
Answer countGuessed(const Question& q) {
  const bool far = q.effects.intensity.wavelength == 1550;
  std::set<std::string> measured;
  for (const MaterialTable::Row& row : q.materials.rows)
    if ((far ? row.reflectance1550 : row.reflectance905) >= 0) measured.insert(lower(row.name));
  const std::vector<bool> seen = seenMaterials(q);
  size_t all = 0, guessed = 0;
  for (size_t i = 0; i < seen.size(); ++i) {
    all += seen[i];
    guessed += seen[i] && !measured.contains(lower(q.scene.materials[i].name));
  }
  return {all > 0 && guessed == 0, std::to_string(guessed) + " of " + plural(all, "material", "materials")};
}

Answer appliesDetection(const Question& q) {
  const auto& detection = q.effects.detection;
  const auto [reflectance, range, stated] = weakestTarget(detection, q.sensor);
  const std::string target = format("%.3g %% at %.6g m", 100 * reflectance, range);
  const std::string threshold = "as strong as " + target + (stated ? ", as the sensor states" : "");
  if (detection.use == EffectUse::automatic && detection.range == 0) {
    if (!stated) return {false, "no range is given"};
    const Answer guessed = countGuessed(q);
    if (guessed.shows) return {true, threshold + ", and the reflectances of all materials are measured"};
    return {false, "the sensor states " + target + ", but the reflectances of " + guessed.why +
                       " are not measured; if on, colours stand for them"};
  }
  if (!(range > 0)) return {false, "the sensor sees no further than 0 m", "give detection.range"};
  return {true, threshold};
}

bool hasNoDropOut(const Effects& effects) {
  const auto& dropOut = effects.dropOut;
  return dropOut.generalRate == 0 && dropOut.zeroIntensityRate == 0 && dropOut.deadBeams.empty();
}

Answer appliesDropOut(const Question& q) {
  const auto& dropOut = q.effects.dropOut;
  const size_t beams = q.sensor.beamCount();
  if (beams == 0 && !dropOut.deadBeams.empty())
    return {false, "the sensor has no beams", "give no drop-out.dead_beams", true};
  for (uint32_t beam : dropOut.deadBeams) {
    if (beam < beams) continue;
    return {false, "the sensor has no beam " + std::to_string(beam) + ", it has " + std::to_string(beams),
            "give drop-out.dead_beams from 0 to " + std::to_string(beams - 1), true};
  }
  if (hasNoDropOut(q.effects)) {
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

bool hasNoRangeNoise(const Effects& effects) {
  const auto& noise = effects.rangeNoise;
  return noise.bias == 0 && noise.sigma == 0 && noise.sigmaPerMetre == 0 && noise.sigmaPerSquareMetre == 0 &&
         noise.sigmaAtThreshold == 0 && noise.step == 0;
}

Answer appliesRangeNoise(const Question& q) {
  const auto& noise = q.effects.rangeNoise;
  if (hasNoRangeNoise(q.effects)) return {false, "no bias, sigma or step is given", "give range-noise.sigma"};
  std::string why = format("sigma %.3g m", noise.sigma);
  if (noise.sigmaPerMetre != 0) why += format(" + %.3g m per m", noise.sigmaPerMetre);
  if (noise.sigmaPerSquareMetre != 0) why += format(" + %.3g m per m^2", noise.sigmaPerSquareMetre);
  if (noise.sigmaAtThreshold != 0) why += format(", %.3g m at the threshold of detection", noise.sigmaAtThreshold);
  if (noise.bias != 0) why += format(", bias %.3g m", noise.bias);
  if (noise.step != 0) why += format(", steps of %.3g m", noise.step);
  return {true, why};
}

bool hasNoAngleNoise(const Effects& effects) {
  return effects.angleNoise.azimuth == 0 && effects.angleNoise.elevation == 0;
}

Answer appliesAngleNoise(const Question& q) {
  const auto& noise = q.effects.angleNoise;
  if (hasNoAngleNoise(q.effects)) {
    return {false, "no standard deviation is given", "give angle-noise.azimuth or angle-noise.elevation"};
  }
  return {true, format("sigma %.3g x %.3g mrad", 1e3 * noise.azimuth, 1e3 * noise.elevation)};
}

bool hasNoIntensityNoise(const Effects& effects) {
  return effects.intensityNoise.sigma == 0;
}

Answer appliesIntensityNoise(const Question& q) {
  const double sigma = q.effects.intensityNoise.sigma;
  if (hasNoIntensityNoise(q.effects)) return {false, "no sigma is given", "give intensity-noise.sigma"};
  return {true, format("sigma %.3g", sigma)};
}

Answer appliesDivergence(const Question& q) {
  const auto& d = q.effects.divergence;
  const bool asked = d.horizontal > 0 || d.vertical > 0;
  const double horizontal = horizontalSpread(q.effects, q.sensor), vertical = verticalSpread(q.effects, q.sensor);
  if (!(horizontal > 0 || vertical > 0)) {
    return {false, "the sensor states no divergence", "give divergence.horizontal and divergence.vertical"};
  }
  std::string why = (asked ? "the request states " : "the sensor states ") +
                    format("%.3g x %.3g mrad", 1e3 * horizontal, 1e3 * vertical) + ", " +
                    plural(d.subRays, "sub-ray", "sub-rays");
  // The figure is that of docs/effects/divergence.md.
  if (d.subRays == Effects::Divergence().subRays)
    why += ", the default: with 7, twice as many beams have a wrong number of returns";
  return {true, why};
}

Answer appliesReturns(const Question& q) {
  const uint32_t asked = q.effects.returns.count, most = asked > 0 ? asked : q.sensor.maxReturns;
  if (q.effects.returns.mode != Effects::Returns().mode) return {true, "the request chooses among the echoes"};
  const std::string who = asked > 0 ? "the request takes " : "the sensor reports ";
  if (most == 1) return {false, who + "one return per beam"};
  return {true, who + "up to " + plural(most, "return", "returns") + " per beam"};
}

Answer appliesTransmission(const Question& q) {
  const std::vector<Optics> optics = opticsOf(q.scene, q.materials, q.effects.intensity.wavelength);
  return countMaterials(
      q, [&](size_t i) { return optics[i].transmission > 0; }, "let light through",
      "no material that is seen lets light through", "give a material transmission");
}

/// Returns whether a texel of the mask, or the alpha of the whole material, is below the cutoff.
bool hasHoles(const Scene& scene, const Material& material) {
  if (material.alphaMode != AlphaMode::mask) return false;
  float least = material.baseColor[3];
  if (material.alphaImage != kNoImage) {
    const auto& alpha = scene.alphaImages[material.alphaImage].alpha;
    if (!alpha.empty()) least *= static_cast<float>(*std::min_element(alpha.begin(), alpha.end())) / 255;
  }
  return least < material.alphaCutoff;
}

Answer appliesCutOuts(const Question& q) {
  return countMaterials(
      q, [&](size_t i) { return hasHoles(q.scene, q.scene.materials[i]); }, "have holes",
      "no material that is seen has holes", "give a material alphaMode MASK and a texture with alpha");
}

Answer appliesMotion(const Question& q) {
  if (!firesInTurn(q.sensor))
    return {false, "the sensor fires all beams at once",
            q.sensor.isGrid() ? "give the sensor a rotation period" : "give its beams times"};
  if (!q.sensor.isGrid()) return {true, "the beams fire at times of their own"};
  const double period = q.sensor.rotationPeriod;
  if (period == 0) return {true, "the channels fire at times of their own"};
  return {true, "the sensor sweeps its columns in " +
                    (period < 0.9995 ? format("%.3g ms", 1e3 * period) : format("%.6g s", period))};
}

/// Answers for an effect of the medium to which the request gives no value.
Answer withoutWeather(const Question& q, Answer otherwise) {
  return q.variableWeather ? Answer{true, "shots bring their own weather"} : otherwise;
}

bool hasNoFog(const Effects& effects) {
  return effects.fog.visibility == 0;
}
bool hasNoRain(const Effects& effects) {
  return effects.rain.rate == 0;
}
bool hasNoSnow(const Effects& effects) {
  return effects.snow.rate == 0;
}
bool hasNoVolumes(const Effects& effects) {
  return effects.volumes.boxes.empty();
}

Answer appliesFog(const Question& q) {
  const double visibility = q.effects.fog.visibility;
  if (hasNoFog(q.effects)) return withoutWeather(q, {false, "no visibility is given", "give fog.visibility"});
  return {true, format("visibility %.6g m", visibility)};
}

Answer appliesRain(const Question& q) {
  const double rate = q.effects.rain.rate;
  if (hasNoRain(q.effects)) return withoutWeather(q, {false, "no rate is given", "give rain.rate"});
  return {true, format("%.6g mm/h", rate)};
}

Answer appliesSnow(const Question& q) {
  const double rate = q.effects.snow.rate;
  if (hasNoSnow(q.effects)) return withoutWeather(q, {false, "no rate is given", "give snow.rate"});
  return {true, format("%.6g mm/h, melted", rate)};
}

Answer appliesVolumes(const Question& q) {
  const auto& boxes = q.effects.volumes.boxes;
  if (hasNoVolumes(q.effects)) return withoutWeather(q, {false, "no box is given", "give volumes.boxes"});
  return {true, plural(boxes.size(), "box", "boxes")};
}

Answer appliesRadialSpeed(const Question& q) {
  if (!q.asksFor(Field::radialSpeed)) return {false, "no field asks for it"};
  const double sigma = q.effects.radialSpeed.sigma;
  return {true, "the field radial_speed asks for it" + (sigma > 0 ? format(", sigma %.3g m/s", sigma) : "")};
}

bool always(const Effects&) {
  return true;
}
bool never(const Effects&) {
  return false;
}
bool dropsByIntensity(const Effects& effects) {
  return effects.dropOut.zeroIntensityRate > 0;
}
bool errsByPower(const Effects& effects) {
  return effects.rangeNoise.sigmaAtThreshold > 0;
}

template <auto kGroup>
EffectInfo effect(const char* name, uint32_t bit, Applies applies, bool (*needsIntensity)(const Effects&),
                  const char* doc, std::vector<Parameter<Effects>> parameters = {},
                  bool (*isZero)(const Effects&) = nullptr) {
  const auto use = [](Effects& effects) -> EffectUse& { return (effects.*kGroup).use; };
  return {name, bit, use, applies, needsIntensity, doc, std::move(parameters), isZero};
}

// The limits are wide: they are meant to detect wrong units, not unusual values.
std::vector<EffectInfo> makeTable() {
  using namespace rows;
  using E = Effects;
  return {
      effect<&E::intensity>(
          "intensity", gpu::kIntensity, nullptr, never,
          "Strength of a return from reflectance, incidence and range. Automatic: on if a field or another effect "
          "needs it.",
          {choice<&E::intensity, &E::Intensity::model>(
               "model",
               {{"physical", "Reflectance * lobe(incidence) / range^2 * exp(-2 extinction range)."},
                {"carla", "Exp(-attenuation * range), independent of the surface."}},
               "What the strength of a return depends on."),
           choice<&E::intensity, &E::Intensity::scale>(
               "scale",
               {{"raw", "Received power, relative as above."},
                {"unit",
                 "0..1: reflectance of the Lambertian target square to the beam that would return as much power from "
                 "the same range, cut off at 1."},
                {"byte",
                 "0..255, calibrated reflectivity: 0..100 for diffuse per cent, 101..255 logarithmic for "
                 "retro-reflectors."}},
               "In which values the strength is reported."),
           number<&E::intensity, &E::Intensity::wavelength>(
               "wavelength", "nm", 905, 1550,
               "Selects the column of a material table, and the extinction of fog and snow.", true),
           number<&E::intensity, &E::Intensity::attenuation>("attenuation", "1/m", 0, 10,
                                                             "Only for the model `carla`.")}),
      effect<&E::detection>(
          "detection", gpu::kDetection, appliesDetection, always,
          "A return is detected only if it is as strong as that of a Lambertian target of `reflectance`, facing it at "
          "`range`. Automatic: on if a range is given, with weather, or if the sensor has a range at 10 % and a table "
          "all reflectances.",
          {number<&E::detection, &E::Detection::reflectance>("reflectance", "", 0.001, 1,
                                                             "Of the weakest target that is detected, 0..1."),
           number<&E::detection, &E::Detection::range>("range", "m", 0, 1e6,
                                                       "Distance of that target; 0 means 10 % at the range that the "
                                                       "sensor states for it, or else at its largest range."),
           number<&E::detection, &E::Detection::softness>(
               "softness", "", 0, 10,
               "Relative width of the probability curve (logistic in ln power); 0 for a sharp threshold.")}),
      effect<&E::dropOut>(
          "drop-out", gpu::kDropOut, appliesDropOut, dropsByIntensity,
          "Returns that are lost at random, as with CARLA's dropoff_* parameters, and dead beams. Automatic: on if a "
          "rate or a dead beam is given.",
          {number<&E::dropOut, &E::DropOut::generalRate>("general_rate", "", 0, 1,
                                                         "Probability that a beam is lost with all its returns, 0..1."),
           number<&E::dropOut, &E::DropOut::intensityLimit>(
               "intensity_limit", "", 0.001, 1, "Unit intensity above which the rate at intensity 0 has no effect."),
           number<&E::dropOut, &E::DropOut::zeroIntensityRate>(
               "zero_intensity_rate", "", 0, 1, "Probability at intensity 0, 0..1; falls linearly to 0 at the limit."),
           indices<&E::dropOut, &E::DropOut::deadBeams>(
               "dead_beams", "beam", "Indices of beams that never return anything: channel * columns + column.")},
          hasNoDropOut),
      effect<&E::rangeNoise>(
          "range-noise", gpu::kRangeNoise, appliesRangeNoise, errsByPower,
          "Errors of the range: bias, Gaussian noise and quantisation. Automatic: on if a bias, a sigma or a step is "
          "given.",
          {number<&E::rangeNoise, &E::RangeNoise::bias>("bias", "m", -100, 100, "Added to every range."),
           number<&E::rangeNoise, &E::RangeNoise::sigma>("sigma", "m", 0, 100, "Standard deviation."),
           number<&E::rangeNoise, &E::RangeNoise::sigmaPerMetre>("sigma_per_metre", "", 0, 1,
                                                                 "Times the range, added to sigma."),
           number<&E::rangeNoise, &E::RangeNoise::step>(
               "step", "m", 0, 100, "Ranges are rounded to multiples of it; 0 for no quantisation."),
           number<&E::rangeNoise, &E::RangeNoise::sigmaPerSquareMetre>(
               "sigma_per_square_metre", "1/m", 0, 1, "Times the square of the range, added to sigma."),
           number<&E::rangeNoise, &E::RangeNoise::sigmaAtThreshold>(
               "sigma_at_threshold", "m", 0, 100,
               "Standard deviation of an error of its own at detection's threshold, which falls with the power of the "
               "echo.")},
          hasNoRangeNoise),
      effect<&E::angleNoise>("angle-noise", gpu::kAngleNoise, appliesAngleNoise, never,
                             "Gaussian errors of the beam directions. Automatic: on if a standard deviation is given.",
                             {number<&E::angleNoise, &E::AngleNoise::azimuth>(
                                  "azimuth", "rad", 0, 0.1, "Standard deviation; cut off at 4 sigma."),
                              number<&E::angleNoise, &E::AngleNoise::elevation>(
                                  "elevation", "rad", 0, 0.1, "Standard deviation; cut off at 4 sigma."),
                              choice<&E::angleNoise, &E::AngleNoise::at>(
                                  "at",
                                  {{"beam", "The beam deviates, but its point is reported in the nominal direction."},
                                   {"point",
                                    "The beam has the nominal direction, but its point is reported in the deviating "
                                    "one."}},
                                  "What deviates.")},
                             hasNoAngleNoise),
      effect<&E::intensityNoise>("intensity-noise", gpu::kIntensityNoise, appliesIntensityNoise, always,
                                 "Gaussian noise of the intensity. Automatic: on if a sigma is given.",
                                 {number<&E::intensityNoise, &E::IntensityNoise::sigma>(
                                     "sigma", "", 0, 1, "Standard deviation, on the scale of unit intensity.")},
                                 hasNoIntensityNoise),
      effect<&E::divergence>("divergence", gpu::kDivergence, appliesDivergence, always,
                             "A footprint, sampled by sub-rays that share the candidate triangles of their beam.",
                             {count<&E::divergence, &E::Divergence::subRays>(
                                  "sub_rays", "", 1, 1261,
                                  "Lines per beam; devices take at most 61; numbers 1 + 6 + 12 + ... lie on rings."),
                              choice<&E::divergence, &E::Divergence::profile>("profile", {{"uniform"}, {"gaussian"}},
                                                                              "Energy over the footprint."),
                              number<&E::divergence, &E::Divergence::horizontal>(
                                  "horizontal", "rad", 0, 0.1, "Full angle (to 1/e^2 if gaussian); 0: the sensor's.",
                                  false, limits::kWiderBeam),
                              number<&E::divergence, &E::Divergence::vertical>(
                                  "vertical", "rad", 0, 0.1, "Full angle (to 1/e^2 if gaussian); 0: the sensor's.",
                                  false, limits::kWiderBeam),
                              choice<&E::divergence, &E::Divergence::shape>("shape", {{"ellipse"}, {"rectangle"}},
                                                                            "In which the sub-rays lie.")}),
      effect<&E::returns>(
          "returns", gpu::kReturns, appliesReturns, always,
          "Which echoes of a beam are returned. Automatic: on if the sensor reports more than one, or a mode is given. "
          "The separation and the pulse width shape echoes whether it is on or off.",
          {choice<&E::returns, &E::Returns::mode>(
               "mode",
               {{"first"},
                {"second"},
                {"last"},
                {"strongest"},
                {"second-strongest"},
                {"first-second"},
                {"first-last"},
                {"first-strongest"},
                {"last-strongest"},
                {"strongest-second-strongest"},
                {"all", "Up to `count` echoes in order of range."},
                {"dual", "The last and the strongest; if these are one echo, the second strongest as well."}},
               "Which echoes are returned."),
           count<&E::returns, &E::Returns::count>(
               "count", "", 0, 15, "Only for the mode `all`: largest number of returns; 0 means the sensor's."),
           number<&E::returns, &E::Returns::separation>(
               "separation", "m", 0, 100,
               "Surfaces no farther than this behind the first one of an echo are part of it."),
           number<&E::returns, &E::Returns::pulseWidth>("pulse_width", "s", 1e-12, 1e-6,
                                                        "Full width at half maximum.")}),
      effect<&E::transmission>(
          "transmission", gpu::kTransmission, appliesTransmission, always,
          "Light that passes through glass: materials with alpha mode BLEND or KHR_materials_transmission."),
      effect<&E::cutOuts>("cut-outs", gpu::kCutOuts, appliesCutOuts, never,
                          "Holes in surfaces: materials with alpha mode MASK."),
      effect<&E::sensorMotion>(
          "sensor-motion", gpu::kSensorMotion, appliesMotion, never,
          "The sensor moves during the scan as the motion of the shot says. Automatic: on if the sensor states a "
          "rotation period, or if its channels or the beams of a list have times.",
          {flag<&E::sensorMotion, &E::SensorMotion::deskew>(
              "deskew",
              "If true, points are reported in the frame of the shot's pose, otherwise in that of their column.")}),
      effect<&E::objectMotion>("object-motion", gpu::kObjectMotion, appliesMotion, never,
                               "Instances and meshes move during the scan as their motions in the shot say."),
      effect<&E::fog>(
          "fog", gpu::kFog, appliesFog, always,
          "Fog: its droplets weaken returns and give some of their own. Automatic: on if a visibility is given.",
          {number<&E::fog, &E::Fog::visibility>(
              "visibility", "m", 0, 1e6, "Meteorological optical range (5 % contrast, Koschmieder); 0 for no fog.")},
          hasNoFog),
      effect<&E::rain>("rain", gpu::kRain, appliesRain, always,
                       "Rain: its drops weaken returns and give some of their own. Automatic: on if a rate is given.",
                       {number<&E::rain, &E::Rain::rate>("rate", "mm/h", 0, 500, "0 for no rain.")}, hasNoRain),
      effect<&E::snow>("snow", gpu::kSnow, appliesSnow, always,
                       "Snow: its flakes weaken returns and give some of their own. Automatic: on if a rate is given.",
                       {number<&E::snow, &E::Snow::rate>("rate", "mm/h", 0, 100, "Of melted water; 0 for no snow.")},
                       hasNoSnow),
      effect<&E::volumes>(
          "volumes", gpu::kVolumes, appliesVolumes, always,
          "Boxes of dust or spray, which weakens returns and gives some of its own. Automatic: on if there are boxes.",
          {boxes<&E::volumes, &E::Volumes::boxes>("boxes", "In the world frame.")}, hasNoVolumes),
      effect<&E::radialSpeed>(
          "radial-speed", gpu::kRadialSpeed, appliesRadialSpeed, never,
          "Radial speed of the surface as an FMCW sensor measures it, in m/s along the beam, positive if the surface "
          "moves away. Automatic: on if the field radial_speed is requested.",
          {number<&E::radialSpeed, &E::RadialSpeed::sigma>(
              "sigma", "m/s", 0, 100, "Standard deviation of the Gaussian error of each return.")}),
  };
}

}  // namespace

const std::vector<EffectInfo>& effectTable() {
  static const auto& table = lasting(makeTable());
  return table;
}

const std::vector<std::string>& effectNames() {
  static const auto& names = lasting([] {
    std::vector<std::string> all;
    for (const EffectInfo& info : effectTable()) all.push_back(info.name);
    return all;
  }());
  return names;
}

Effects Effects::none() {
  Effects effects;
  for (const EffectInfo& info : effectTable()) info.use(effects) = EffectUse::off;
  return effects;
}

const Parameter<Effects>& seedParameter() {
  static const auto& seed = lasting<Parameter<Effects>>(
      rows::count<&Effects::seed>("seed", "", 0, UINT64_MAX,
                                  "Every random number is keyed by (seed, sensor, frame, beam, sub-ray or echo, "
                                  "effect): one effect never changes the draws of another, and the same seed gives "
                                  "the same draws on every device."));
  return seed;
}

}  // namespace gnosphere

// SPDX-License-Identifier: Apache-2.0
#include "effects/formula_inputs.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/quaternion.hpp"
#include "base/units.hpp"
#include "effects/particles.hpp"

namespace gnosphere {
namespace {

constexpr double kLightSpeed = 299792458;  // m/s
/// Full beam angle in radians for rain and snow if neither request nor sensor states one: VLP-16 (manual 63-9243).
constexpr double kUsualSpread = 3e-3;

// Converts a public enum to the device's number; both have the same values.
template <typename Enum>
constexpr bool same(Enum value, uint32_t number) {
  return uint32_t(value) == number;
}
static_assert(same(Effects::Intensity::Model::carla, gpu::kModelCarla) &&
              same(Effects::Intensity::Scale::raw, gpu::kScaleRaw) &&
              same(Effects::Intensity::Scale::byte, gpu::kScaleByte) &&
              same(Effects::AngleNoise::At::point, gpu::kAngleAtPoint) &&
              same(Effects::Returns::Mode::strongest, gpu::kModeStrongest) &&
              same(Effects::Returns::Mode::all, gpu::kModeAll) && same(Effects::Returns::Mode::dual, gpu::kModeDual) &&
              same(Cause::returned, gpu::kCauseReturned) && same(Cause::dead, gpu::kCauseDead) &&
              same(Cause::tooNear, gpu::kCauseTooNear) && same(Cause::notChosen, gpu::kCauseNotChosen) &&
              same(Label::scatter, gpu::kLabelScatter));

uint32_t returnsPerBeam(const Effects::Returns& returns, const Sensor& sensor) {
  using Mode = Effects::Returns::Mode;
  if (returns.mode == Mode::all) return returns.count > 0 ? returns.count : std::max(sensor.maxReturns, 1u);
  return returns.mode >= Mode::firstSecond ? 2 : 1;
}

void fillMedium(const Effects& effects, const Sensor& sensor, uint32_t planned, gpu::EffectParameters& p) {
  const double fog = planned & gpu::kFog ? fogExtinction(effects.fog.visibility, effects.intensity.wavelength) : 0;
  const double rain = planned & gpu::kRain ? rainExtinction(effects.rain.rate) : 0;
  const double snow = planned & gpu::kSnow ? snowExtinction(effects.snow.rate, effects.intensity.wavelength) : 0;
  p.extinction = float(fog + rain + snow);
  p.fogExtinction = float(fog);
  p.fogScatter = float(scatterOf(fog, kFogLidarRatio, p.pulseWidth));
  p.volumeCount = planned & gpu::kVolumes ? uint32_t(effects.volumes.boxes.size()) : 0;
  if ((planned & (gpu::kRain | gpu::kSnow)) == 0) return;
  const RangeWindow window = widestWindow(sensor);
  if (planned & gpu::kRain) p.rain = particlesOf(p, rainDrops(effects.rain.rate), window);
  if (planned & gpu::kSnow) p.snow = particlesOf(p, snowFlakes(effects.snow.rate), window);
}

}  // namespace

double horizontalSpread(const Effects& effects, const Sensor& sensor) {
  return effects.divergence.horizontal > 0 ? effects.divergence.horizontal : sensor.divergenceHorizontal;
}

double verticalSpread(const Effects& effects, const Sensor& sensor) {
  return effects.divergence.vertical > 0 ? effects.divergence.vertical : sensor.divergenceVertical;
}

gpu::EffectParameters effectParameters(const Effects& effects, const Sensor& sensor, uint32_t planned) {
  gpu::EffectParameters p = {};
  p.seedLow = uint32_t(effects.seed);
  p.seedHigh = uint32_t(effects.seed >> 32);
  p.returnsMode = uint32_t(effects.returns.mode);
  p.returnsPerBeam = planned & gpu::kReturns ? returnsPerBeam(effects.returns, sensor) : 1;
  p.separation = float(effects.returns.separation);
  p.pulseWidth = float(effects.returns.pulseWidth * kLightSpeed / 2);
  p.rangeMin = float(sensor.rangeMin);
  p.hidesNear = sensor.nearHits == NearHits::hide;
  p.rangeMax = float(sensor.rangeMax);

  p.intensityModel = uint32_t(effects.intensity.model);
  p.intensityScale = uint32_t(effects.intensity.scale);
  p.attenuation = float(effects.intensity.attenuation);

  const WeakestTarget weakest = weakestTarget(effects.detection, sensor);
  p.threshold = float(std::max(weakest.reflectance / (weakest.range * weakest.range), 1e-30));
  p.softness = float(effects.detection.softness);

  const Effects::DropOut& dropOut = effects.dropOut;
  p.deadBeams = planned & gpu::kDropOut ? uint32_t(dropOut.deadBeams.size()) : 0;
  p.dropRate = float(dropOut.generalRate);
  p.dropLimit = float(dropOut.intensityLimit);
  p.dropAtZero = dropOut.intensityLimit > 0 ? float(dropOut.zeroIntensityRate) : 0;
  p.dropSlope = dropOut.intensityLimit > 0 ? float(dropOut.zeroIntensityRate / dropOut.intensityLimit) : 0;

  p.rangeBias = float(effects.rangeNoise.bias);
  p.rangeSigma = float(effects.rangeNoise.sigma);
  p.rangeSigmaPerMetre = float(effects.rangeNoise.sigmaPerMetre);
  p.rangeSigmaPerSquareMetre = float(effects.rangeNoise.sigmaPerSquareMetre);
  p.rangeSigmaAtThreshold = float(effects.rangeNoise.sigmaAtThreshold);
  p.rangeStep = float(effects.rangeNoise.step);
  p.angleNoiseAt = uint32_t(effects.angleNoise.at);
  p.azimuthSigma = float(effects.angleNoise.azimuth);
  p.elevationSigma = float(effects.angleNoise.elevation);
  p.intensitySigma = float(effects.intensityNoise.sigma);
  p.speedSigma = float(effects.radialSpeed.sigma);

  const double horizontal = horizontalSpread(effects, sensor), vertical = verticalSpread(effects, sensor);
  if ((planned & gpu::kDivergence) != 0 && effects.divergence.subRays > 1) {
    // Sub-rays stand for equal areas. A rectangle is larger than the ellipse within it.
    const bool rectangle = effects.divergence.shape == Effects::Divergence::Shape::rectangle;
    const double perRay = std::sqrt((rectangle ? 4 / std::numbers::pi : 1) / double(effects.divergence.subRays));
    p.cellHorizontal = float(std::tan(horizontal / 2) * perRay);
    p.cellVertical = float(std::tan(vertical / 2) * perRay);
  }
  p.spreadHorizontal = float(horizontal > 0 || vertical > 0 ? horizontal : kUsualSpread);
  p.spreadVertical = float(horizontal > 0 || vertical > 0 ? vertical : kUsualSpread);
  fillMedium(effects, sensor, planned, p);
  return p;
}

WeakestTarget weakestTarget(const Effects::Detection& detection, const Sensor& sensor) {
  if (detection.range > 0) return {detection.reflectance, detection.range, false};
  if (sensor.rangeAt10Percent > 0) return {0.1, sensor.rangeAt10Percent, true};
  return {detection.reflectance, sensor.rangeMax > 0 ? sensor.rangeMax : widestWindow(sensor).most, false};
}

uint32_t keyOfFrame(uint64_t frame) {
  // Every bit of the high half changes about half of the key's bits (the finaliser of MurmurHash3); 0 changes none.
  uint32_t high = uint32_t(frame >> 32);
  high = (high ^ high >> 16) * 0x85ebca6b;
  high = (high ^ high >> 13) * 0xc2b2ae35;
  return uint32_t(frame) ^ high ^ high >> 16;
}

std::vector<SubRay> subRays(const Effects& effects, const Sensor& sensor, uint32_t planned) {
  if (!(planned & gpu::kDivergence)) return {SubRay{}};
  const uint32_t count = std::max(effects.divergence.subRays, 1u);
  const bool gaussian = effects.divergence.profile == Effects::Divergence::Profile::gaussian;
  struct Place {
    double left, up, weight;  // within the unit disc, or the square around it
  };
  std::vector<Place> places;
  const auto addAt = [&](double left, double up) {
    places.push_back({left, up, gaussian ? std::exp(-2 * (left * left + up * up)) : 1.0});
  };
  const auto add = [&](double radius, double angle) { addAt(radius * std::cos(angle), radius * std::sin(angle)); };
  // Every sub-ray stands for an equal area of the disc and lies in the middle of it. Sub-rays form rings of 6, 12, 18,
  // ... around a central one. Each ring is turned so that an edge, above all a level or an upright one, meets them one
  // after the other: the share of the light beside it is then 2.4 to 3.2 times as exact as with rings that begin on the
  // level axis.
  add(0, 0);
  for (uint32_t ring = 1; places.size() + 6 * ring <= count; ++ring) {
    const double radius = std::sqrt((double(places.size()) + 3.0 * ring) / count);
    for (uint32_t i = 0; i < 6 * ring; ++i)
      add(radius, (3 + 38.0 * ring) * kDegree + 2 * std::numbers::pi * i / (6 * ring));
  }
  // If the count does not fill the rings, they lie on Vogel's spiral (1979), and in a rectangle on a Fibonacci lattice,
  // in which no two are beside or above each other. Both are moved so that the middle of their light is on the axis.
  const bool rectangle = effects.divergence.shape == Effects::Divergence::Shape::rectangle;
  if (rectangle || places.size() != count) {
    places.clear();
    const double golden = std::numbers::pi * (3 - std::sqrt(5.0));
    for (uint32_t i = 0; i < count; ++i)
      if (rectangle)
        addAt(2 * (i + 0.5) / count - 1, 2 * std::fmod(0.5 + i / std::numbers::phi, 1) - 1);
      else
        add(std::sqrt((i + 0.5) / count), golden * i);
    Place middle = {0, 0, 0};
    for (const auto& [left, up, weight] : places)
      middle = {middle.left + weight * left, middle.up + weight * up, middle.weight + weight};
    for (Place& place : places) {
      place.left -= middle.left / middle.weight;
      place.up -= middle.up / middle.weight;
    }
  }

  const double tanHorizontal = std::tan(horizontalSpread(effects, sensor) / 2);
  const double tanVertical = std::tan(verticalSpread(effects, sensor) / 2);
  double sum = 0;
  for (const Place& place : places) sum += place.weight;
  std::vector<SubRay> rays;
  for (const auto& [left, up, weight] : places)
    rays.push_back({float(tanHorizontal * left), float(tanVertical * up), float(weight / sum)});
  return rays;
}

std::vector<gpu::VolumeBox> volumeBoxes(const Effects& effects, const Pose& pose) {
  const Quaternion q = withUsableLength(pose.orientation);
  // Rows of the rotation from the sensor to the world frame. The factor 2 / |q|^2 normalises the quaternion.
  const double s = 2 / (q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
  const Vec3 turn[3] = {{1 - s * (q.y * q.y + q.z * q.z), s * (q.x * q.y - q.w * q.z), s * (q.x * q.z + q.w * q.y)},
                        {s * (q.x * q.y + q.w * q.z), 1 - s * (q.x * q.x + q.z * q.z), s * (q.y * q.z - q.w * q.x)},
                        {s * (q.x * q.z - q.w * q.y), s * (q.y * q.z + q.w * q.x), 1 - s * (q.x * q.x + q.y * q.y)}};
  const auto row = [](const Vec3& axis, double place, double low, double high) {
    const double scale = 2 / std::max(high - low, 1e-6);
    return gpu::vec4{float(axis.x * scale), float(axis.y * scale), float(axis.z * scale),
                     float((place - (low + high) / 2) * scale)};
  };
  const double pulse = effects.returns.pulseWidth * kLightSpeed / 2;
  std::vector<gpu::VolumeBox> boxes;
  for (const Effects::Volume& volume : effects.volumes.boxes) {
    gpu::VolumeBox box = {};
    box.row0 = row(turn[0], pose.position.x, volume.min.x, volume.max.x);
    box.row1 = row(turn[1], pose.position.y, volume.min.y, volume.max.y);
    box.row2 = row(turn[2], pose.position.z, volume.min.z, volume.max.z);
    box.extinction = float(volume.extinction);
    box.scatter = float(scatterOf(volume.extinction, kDustLidarRatio, pulse));
    boxes.push_back(box);
  }
  return boxes;
}

std::vector<uint32_t> deadBeamBits(const Effects& effects, const Sensor& sensor) {
  std::vector<uint32_t> bits;
  for (const uint32_t beam : effects.dropOut.deadBeams) {
    bits.resize((sensor.beamCount() + 31) / 32);
    bits[beam / 32] |= 1u << beam % 32;
  }
  return bits;
}

}  // namespace gnosphere

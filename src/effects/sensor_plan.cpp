// SPDX-License-Identifier: Apache-2.0
#include "effects/sensor_plan.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <initializer_list>
#include <limits>

#include "base/units.hpp"
#include "base/vector.hpp"
#include "common/effects/noise.h"
#include "effects/decide.hpp"
#include "gnosphere/error.hpp"
#include "scan/columns.hpp"
#include "sensor/beams.hpp"

namespace gnosphere {
namespace {

uint32_t bitOf(Field field) {
  switch (field) {
    case Field::intensity: return gpu::kFieldIntensity;
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

// Several sub-rays need a footprint; a single one is the axis. Holes and deviations are part of the inside test of the
// standard accuracy, and panes are found with it; the other inside tests know neither.
bool needsFootprint(const SimulatorOptions& options, const SensorPlan& plan) {
  if (plan.subRays.size() > 1) return true;
  const AccuracyParts parts = accuracyPartsOf(options);
  const AccuracyParts standard = accuracyPartsOf(Accuracy::standard);
  return plan.has(gpu::kFootprintEffects) && (parts.inside != standard.inside || parts.range != standard.range);
}

// Light that deviates by the tangents u and v to the left and up, from an axis of elevation E, is in azimuth
// atan(u / (cos E - v sin E)) away. In elevation it is atan(v) away, less at most u^2 tan(E) / 2 for small angles.
// Where angles are not small beside the distance from a pole, both are bounded by the angle between light and axis.
AngularSpread spreadOf(const SensorPlan& plan) {
  const Effects::AngleNoise& noise = plan.effects.angleNoise;
  const bool strays = plan.has(gpu::kStrays);
  const double azimuth = strays ? gpu::kAngleCutOff * noise.azimuth : 0;
  const double elevation = strays ? gpu::kAngleCutOff * noise.elevation : 0;
  double angle = 0, across = 0, up = 0;
  for (const SubRay& ray : plan.subRays) {
    angle = std::max(angle, lengthOf(double{ray.u}, double{ray.v}));
    across = std::max(across, std::abs(double{ray.u}));
    up = std::max(up, std::abs(double{ray.v}));
  }
  angle += lengthOf(azimuth, elevation);
  across += azimuth;
  up += elevation;
  const double steepest = angle > 0 ? steepestTangent(plan.sensor) : 0;
  if (up * steepest > 0.04 || across * lengthOf(1, steepest) > 0.25)
    across = up = angle;
  else
    up += across * across * steepest;
  const auto rounded = [](double value) { return static_cast<float>(value * 1.0001); };
  return {rounded(angle), rounded(across), rounded(up)};
}

// Lasers that fire between two columns are moved along a straight line between the poses of these. Over this time a
// head that turns by 2 rad/s misses the true path of a point 100 m away by less than 5e-6 m, which is less than the
// spacing of ranges there (7.6e-6 m), but the error grows with the square. If all columns fire at once, there are no
// two poses. For a list of beams the poses are tabulated at shorter intervals.
bool needsPosesOfList(const SensorPlan& plan) {
  constexpr double kMostStep = 300e-6;
  const double period = plan.sensor.rotationPeriod;
  return plan.moves() && hasTimeOffsets(plan.sensor) && (period == 0 || period > kMostStep * plan.sensor.columns);
}

std::vector<gpu::Optics4> opticsArray(const Scene& scene, const MaterialTable& table, double wavelength) {
  std::vector<gpu::Optics4> result;
  for (const Optics& optics : opticsOf(scene, table, wavelength)) {
    const Material& material = scene.materials[result.size()];
    const bool mask = material.alphaMode == AlphaMode::mask;
    gpu::Optics4 packed = {};
    packed.reflection = {optics.reflectance, optics.gloss, optics.roughness, optics.retro};
    packed.passage = {optics.transmission, mask ? material.alphaCutoff : 0, material.baseColor[3]};
    packed.alphaImage = mask ? material.alphaImage : gpu::kNone;
    result.push_back(packed);
  }
  return result;
}

// The kernels take wraps by their numbers.
static_assert(static_cast<uint32_t>(AlphaImage::Wrap::repeat) == gpu::kWrapRepeat);
static_assert(static_cast<uint32_t>(AlphaImage::Wrap::mirror) == gpu::kWrapMirror);
static_assert(static_cast<uint32_t>(AlphaImage::Wrap::clamp) == gpu::kWrapClamp);

std::shared_ptr<const TextureArrays> textureArrays(const Scene& scene) {
  const auto arrays = std::make_shared<TextureArrays>();
  for (const AlphaImage& image : scene.alphaImages) {
    const auto wraps = static_cast<uint32_t>(image.wrapU) | static_cast<uint32_t>(image.wrapV) << 8;
    arrays->images.push_back({image.width, image.height, static_cast<uint32_t>(arrays->texels.size()), wraps});
    arrays->texels.insert(arrays->texels.end(), image.alpha.begin(), image.alpha.end());
  }
  arrays->texels.resize((arrays->texels.size() + 3) / 4 * 4);
  return arrays;
}

void checkPaper(const Sensor& sensor) {
  const std::string cause = causeAgainstPaper(sensor);
  if (!cause.empty())
    throw Error(ErrorCode::invalidArgument, "sensor '" + sensor.name + "' " + cause +
                                                ", which the accuracy 'paper' does not know; choose another accuracy");
}

}  // namespace

double steepestTangent(const Sensor& sensor) {
  double steepest = 0;
  for (const Channel& channel : sensor.channels)
    steepest = std::max(steepest, std::abs(std::tan(kDegree * channel.elevationDeg)));
  for (const BeamList& list : sensor.patterns)
    for (const Vec3& direction : list.directions)
      steepest = std::max(steepest, std::abs(direction.z) / std::max(lengthOf(direction.x, direction.y), 1e-9));
  return steepest;
}

bool SensorPlan::onlyLines() const {
  uint32_t lines = gpu::kCutOuts | gpu::kDivergence | gpu::kIntensity | gpu::kSensorMotion | gpu::kObjectMotion;
  if (has(gpu::kStrays)) lines |= gpu::kStrays | gpu::kAngleNoise;
  if (panes()) lines |= gpu::kTransmission;
  if (layout.empty()) lines |= gpu::kReturns;  // records take further returns from points
  return (bits & ~lines) == 0 && fields == 0;
}

std::shared_ptr<const SensorPlan> SensorPlanner::plan(const Scene& scene, const SensorRequest& request, size_t index,
                                                      bool changed) {
  const Effects& effects = request.effects;
  const Sensor& sensor = request.sensor;
  const auto made = std::make_shared<SensorPlan>();
  SensorPlan& plan = *made;
  plan.sensor = sensor;
  plan.effects = effects;
  plan.decisions = decide(request, scene, options_.materials, changed);
  leaveOutUnsupported(options_, effects, plan.decisions);
  plan.bits = bitsOf(plan.decisions);
  if (plan.has(gpu::kDivergence)) checkSubRays(options_, effects);
  if (plan.has(gpu::kAngleNoise) && effects.angleNoise.at == Effects::AngleNoise::At::beam) plan.bits |= gpu::kStrays;
  if (plan.has(gpu::kRadialSpeed) && effects.radialSpeed.sigma > 0) plan.bits |= gpu::kSpeedNoise;
  for (const Field field : request.fields) plan.fields |= bitOf(field);
  plan.layout = request.layout;
  for (const uint32_t instance : request.ignoredInstances) {
    plan.ignored.resize(std::max<size_t>(plan.ignored.size(), size_t{instance} + 1));
    plan.ignored[instance] = 1;
  }
  plan.origins = hasOrigins(sensor);
  plan.listed = needsBeamList(sensor) || (plan.motion() && hasTimeOffsets(sensor));
  if (accuracyPartsOf(options_).bounds == AccuracyParts::Bounds::paper) checkPaper(sensor);
  if ((plan.listed || hasAzimuthOffsets(sensor)) && !needsPosesOfList(plan)) plan.rows = rowGridOf(sensor);
  plan.listed = !plan.rows && (plan.listed || hasAzimuthOffsets(sensor));
  plan.looksAtMaterials = plan.has(gpu::kIntensity) && effects.intensity.model == Effects::Intensity::Model::physical;
  plan.parameters = effectParameters(effects, sensor, plan.bits);
  plan.parameters.sensor = static_cast<uint32_t>(index);
  plan.returns = plan.parameters.returnsPerBeam;
  plan.subRays = subRays(effects, sensor, plan.bits);
  if (needsFootprint(options_, plan)) plan.bits |= gpu::kFootprint;
  if (plan.has(gpu::kDropOut)) plan.deadBeams = deadBeamBits(effects, sensor);
  plan.spread = spreadOf(plan);
  if (options_.device.kind == DeviceChoice::Kind::reference) return made;
  if (plan.looksAtOptics()) plan.optics = opticsArray(scene, options_.materials, effects.intensity.wavelength);
  if (!plan.holes()) return made;
  if (!textures_) textures_ = textureArrays(scene);
  plan.textures = textures_;
  return made;
}

bool sameButOptics(const SensorPlan& before, const SensorPlan& after) {
  return before.bits == after.bits && before.textures == after.textures &&
         before.optics.size() == after.optics.size() && before.ignored == after.ignored;
}

bool sameArrays(const SensorPlan& before, const SensorPlan& after) {
  return sameButOptics(before, after) &&
         (before.optics.empty() ||
          std::memcmp(before.optics.data(), after.optics.data(), after.optics.size() * sizeof(gpu::Optics4)) == 0);
}

Effects effectsOf(const SensorPlan& plan, const Shot& shot) {
  Effects effects = plan.effects;
  if (!shot.weather) return effects;
  effects.fog.visibility = shot.weather->visibility;
  effects.rain.rate = shot.weather->rainRate;
  effects.snow.rate = shot.weather->snowRate;
  effects.volumes.boxes = shot.weather->volumes;
  return effects;
}

bool instancesMove(const SensorPlan& plan, const Shot& shot) {
  return (!shot.instanceMotions.empty() || !shot.meshMotions.empty()) && plan.has(gpu::kObjectMotion) &&
         durationOf(plan.sensor, shot.frame) > 0;
}

void checkWeather(const SensorPlan& plan, const Weather& weather, const std::string& which) {
  const auto need = [&](bool brings, uint32_t bit, const char* effect) {
    if (brings && !plan.has(bit))
      throw Error(ErrorCode::invalidArgument, (which.empty() ? "the shot" : which + "it") + " brings " + effect +
                                                  ", which is not planned for sensor '" + plan.sensor.name +
                                                  "'; set variable_weather in the sensor's request, and do not turn " +
                                                  effect + " off");
  };
  need(weather.visibility > 0, gpu::kFog, "fog");
  need(weather.rainRate > 0, gpu::kRain, "rain");
  need(weather.snowRate > 0, gpu::kSnow, "snow");
  need(!weather.volumes.empty(), gpu::kVolumes, "volumes");
  Shot shot;
  shot.weather = weather;
  try {
    validate(effectsOf(plan, shot));
  } catch (const Error& error) {
    throw Error(error.code(), which + error.what());
  }
}

void resizeArrays(const SensorPlan& plan, Scan& scan, bool cleared) {
  constexpr float kMiss = std::numeric_limits<float>::quiet_NaN();
  const size_t count = plan.sensor.beamCount() * plan.returns;
  const auto resize = [&](auto& array, size_t size, auto nothing) {
    if (cleared) array.clear();
    array.resize(size, nothing);
  };
  scan.returns = plan.returns;
  resize(scan.points, 3 * count, kMiss);
  resize(scan.ranges, count, kMiss);
  resize(scan.triangles, count, kNoTriangle);
  resize(scan.instances, count, kNoTriangle);
  ScanColumns columns(scan);
  const auto make = [&](std::initializer_list<Field> fields, bool wanted, auto nothing) {
    for (const Field field : fields) cleared ? columns.fill(field, nothing, wanted) : columns.make(field, wanted);
  };
  const bool signal = plan.asks(gpu::kFieldSignal), surface = plan.asks(gpu::kFieldSurface);
  make({Field::intensity}, plan.asks(gpu::kFieldIntensity), kMiss);
  make({Field::trueRange, Field::width}, signal, kMiss);
  make({Field::label, Field::cause}, signal, uint8_t{0});
  make({Field::normal, Field::incidence}, surface, kMiss);
  make({Field::material}, surface, kNoTriangle);
  make({Field::velocity}, plan.speeds(), 0.0f);
  make({Field::radialSpeed}, plan.speeds(), kMiss);
  make({Field::barycentrics}, plan.asks(gpu::kFieldBarycentrics), kMiss);
}

}  // namespace gnosphere

// SPDX-License-Identifier: Apache-2.0
// A scene in which every effect is visible, and requests and shots for it.
#pragma once

#include "effects/effect_table.hpp"
#include "effects/scan_support.hpp"

namespace gnosphere::test {

/// A sensor with few beams, whose lasers are away from the sensor's origin.
inline Sensor smallSensor() {
  Sensor sensor = gridSensor(90, 8, -18, 9, 60);
  sensor.name = "small";
  sensor.rangeMin = 0.5;
  sensor.rotationPeriod = kPeriod;
  sensor.divergenceHorizontal = 3e-3;
  sensor.divergenceVertical = 1.5e-3;
  sensor.maxReturns = 3;
  for (size_t j = 0; j < sensor.channels.size(); ++j) {
    sensor.channels[j].origin = {0.05, 0.02 * static_cast<double>(j % 3), 0.01 * static_cast<double>(j)};
    sensor.channels[j].azimuthOffsetDeg = 0.7 * static_cast<double>(j % 4);
  }
  return sensor;
}

/// A room with a pane of glass, a grating with holes and a moving box.
inline Scene showroom() {
  Scene scene;
  scene.materials = {lambertian(0.4f, "plaster"), lambertian(0.1f, "glass"), lambertian(0.5f, "grating"),
                     lambertian(0.7f, "car")};
  scene.materials[1].transmission = 0.8f;
  scene.materials[2].alphaMode = AlphaMode::mask;
  scene.materials[2].alphaImage = 0;
  scene.alphaImages = {{4, 4, {255, 0, 255, 0, 0, 255, 255, 0, 255, 0, 0, 255, 255, 255, 0, 255}}};
  MeshBuilder walls, box;
  walls.box({-22, -17, -2}, {25, 19, 9}, 3);
  box.box({-1, -1, -1}, {1, 1, 1}, 2);
  const auto add = [&](Mesh mesh, const Transform& place) {
    scene.instances.push_back({"", static_cast<uint32_t>(scene.meshes.size()), place});
    scene.meshes.push_back(std::move(mesh));
  };
  add(walls.take(0), {});
  add(plate(7, 4, 1), {});
  Mesh grating = plate(0, 3, 2);
  grating.uvs = {0, 0, 2, 0, 2, 2, 0, 2};
  Transform aside;
  aside.rows = {0, -1, 0, 0.5, 1, 0, 0, 6, 0, 0, 1, 0.5};
  add(grating, aside);
  add(box.take(3), translation(-6, 1, 0));
  return scene;
}

/// Requests all effects with parameters for which they are visible.
inline Effects loud() {
  Effects effects;
  effects.seed = 42;
  effects.detection.reflectance = 0.6;
  effects.detection.range = 25;
  effects.detection.softness = 0.2;
  effects.dropOut = {EffectUse::off, 0.1, 0.6, 0.3, {3, 77, 400}};
  effects.rangeNoise = {EffectUse::off, 0.05, 0.02, 1e-3, 0, 1e-4, 0.1};
  effects.angleNoise.azimuth = effects.angleNoise.elevation = 2e-3;
  effects.intensityNoise.sigma = 0.05;
  effects.divergence.subRays = 7;
  effects.fog.visibility = 120;
  effects.rain.rate = 30;
  effects.snow.rate = 4;
  effects.volumes.boxes = {{{2, -6, -1}, {5, 8, 2}, 0.15}, {{-12, -3, -2}, {-3, 6, 4}, 0.05}};
  return effects;
}

/// Requests two effects, by their numbers in effectTable().
inline TestOptions pairOptions(size_t first, size_t second) {
  TestOptions options = optionsOn("vulkan");
  options.effects = loud();
  for (const EffectInfo& effect : effectTable()) effect.use(options.effects) = EffectUse::off;
  options.effects.intensity.use = EffectUse::automatic;
  for (const size_t i : {first, second}) effectTable()[i].use(options.effects) = EffectUse::on;
  options.effects.angleNoise.at = (first + second) % 2 ? Effects::AngleNoise::At::point : Effects::AngleNoise::At::beam;
  options.effects.sensorMotion.deskew = second % 2 == 1;
  options.fields = {Field::intensity, Field::trueRange, Field::width,   Field::label,
                    Field::cause,     Field::normal,    Field::material};
  if (options.effects.radialSpeed.use == EffectUse::on) options.fields.push_back(Field::radialSpeed);
  return options;
}

/// The sensor and the box move, or stand.
inline Shot shotOf(bool moving) {
  Shot shot;
  shot.frame = 3;
  shot.pose = {{0.3, -0.2, 0.1}, {0.02, -0.03, 0.3, 0.95}};
  if (!moving) return shot;
  Pose end = shot.pose;
  end.position = {1.9, 0.3, 0.2};
  end.orientation = {0.04, -0.02, 0.42, 0.9};
  shot.motion.stamps = {{0, shot.pose}, {kPeriod, end}};
  shot.instanceMotions = {{3, translation(-6.5, 2.5, 0.2)}};
  return shot;
}

/// Requires that device and reference agree, in a scene in which two effects are visible. Returns the share of beams
/// with a return, in the scan that has fewer of them.
inline double requireEffects(const Sensor& sensor, size_t first, size_t second) {
  static const Scene scene = showroom();
  TestOptions options = pairOptions(first, second);
  Simulator device = makeSimulator(scene, sensor, options);
  options.device = DeviceChoice::Kind::reference;
  Simulator reference = makeSimulator(scene, sensor, options);
  double least = 1;
  for (const bool moving : {false, true}) {
    Scan expected, found;
    reference.scanInto(shotOf(moving), expected);
    device.scanInto(shotOf(moving), found);
    const Differences result = differences(expected, found, {0, 1e-3, 2e-3});
    INFO(sensor.name << ", " << effectNames()[first] << " and " << effectNames()[second]
                     << (moving ? ", moving: " : ", standing: ") << result.text());
    CHECK(result.all() == 0);
    CHECK(result.ties <= result.beams / 20);
    least = std::min(least, static_cast<double>(found.counters.hits) / static_cast<double>(result.beams));
  }
  return least;
}

}  // namespace gnosphere::test

// SPDX-License-Identifier: Apache-2.0
// Every pair of effects, without and with motion: the device against the reference, in a scene in which all are
// visible.
#include "effects/effect_table.hpp"
#include "effects/scan_support.hpp"

namespace gnosphere::test {
namespace {

constexpr double kPeriod = 0.1;

/// A sensor with few beams, whose lasers are away from the sensor's origin.
Sensor smallSensor() {
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
Scene showroom() {
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
Effects loud() {
  Effects effects;
  effects.seed = 42;
  effects.detection.reflectance = 0.6;
  effects.detection.range = 25;
  effects.detection.softness = 0.2;
  effects.dropOut = {EffectUse::off, 0.1, 0.6, 0.3, {3, 77, 400}};
  effects.rangeNoise = {EffectUse::off, 0.05, 0.02, 1e-3, 0};
  effects.angleNoise.azimuth = effects.angleNoise.elevation = 2e-3;
  effects.intensityNoise.sigma = 0.05;
  effects.divergence.subRays = 7;
  effects.fog.visibility = 120;
  effects.rain.rate = 30;
  effects.snow.rate = 4;
  effects.volumes.boxes = {{{2, -6, -1}, {5, 8, 2}, 0.15}, {{-12, -3, -2}, {-3, 6, 4}, 0.05}};
  return effects;
}

TestOptions optionsOf(size_t first, size_t second) {
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

Shot shotOf(bool moving) {
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

void compare(size_t first, size_t second) {
  static const Scene scene = showroom();
  static const Sensor sensor = smallSensor();
  TestOptions options = optionsOf(first, second);
  Simulator device = makeSimulator(scene, sensor, options);
  options.device = DeviceChoice::Kind::reference;
  Simulator reference = makeSimulator(scene, sensor, options);
  for (const bool moving : {false, true}) {
    Scan expected, found;
    reference.scanInto(shotOf(moving), expected);
    device.scanInto(shotOf(moving), found);
    const Differences result = differences(expected, found, {0, 1e-3, 2e-3});
    INFO(effectNames()[first] << " and " << effectNames()[second] << (moving ? ", moving: " : ", standing: ")
                              << result.all() << " differences, " << result.ties << " ties of " << result.beams
                              << ", first: " << result.first);
    CHECK(result.all() == 0);
    CHECK(result.ties <= result.beams / 20);
  }
}

}  // namespace

TEST_CASE("every effect changes the scan of the scene for the pairs") {
  const Scene scene = showroom();
  TestOptions options = optionsOf(0, 0);
  options.device = DeviceChoice::Kind::reference;
  const auto scanWith = [&](size_t effect) {
    options.effects = optionsOf(0, effect).effects;
    options.fields = {Field::intensity, Field::label};
    if (effectNames()[effect] == "radial-speed") options.fields.push_back(Field::radialSpeed);
    Scan scan;
    makeSimulator(scene, smallSensor(), options).scanInto(shotOf(true), scan);
    return scan;
  };
  const Scan bare = scanWith(0);
  for (size_t effect = 1; effect < effectNames().size(); ++effect) {
    INFO(effectNames()[effect]);
    CHECK(!sameFields(bare, scanWith(effect)));
  }
}

TEST_CASE("every pair of effects equals the reference, without and with motion", "[combinations]") {
  const size_t count = effectNames().size();
  REQUIRE(count == 17);
  // Nine pairs hold every effect.
  if (!everyCombination()) {
    for (size_t first = 0; first <= count / 2; ++first) compare(first, (first + 9) % count);
    return;
  }
  for (size_t first = 0; first < count; ++first)
    for (size_t second = 0; second <= first; ++second) compare(first, second);
}

}  // namespace gnosphere::test

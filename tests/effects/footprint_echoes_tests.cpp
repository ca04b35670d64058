// SPDX-License-Identifier: Apache-2.0
// Echoes of footprints on several surfaces: foliage, panes, legs and walls, the ground.
#include <cmath>
#include <numbers>

#include "base/vector.hpp"
#include "effects/scan_support.hpp"

namespace gnosphere::test {
namespace {

constexpr double kSoil = 30, kHalf = 1.5;  // metres

/// Leaves of 6 cm, 0.2 to 2.5 m before a wall of soil 30 m ahead. Seen along x, 1.1 of their area lies before 1 of
/// soil.
Scene canopy() {
  Random uniform(5);
  MeshBuilder builder;
  constexpr double kLeaf = 0.06;
  for (int leaf = 0; leaf < int(1.1 * 4 * kHalf * kHalf / (kLeaf * kLeaf)); ++leaf) {
    const double c = uniform(), s = std::sqrt(1 - c * c), a = std::numbers::pi * uniform();
    const Vec3 normal = {c, s * std::cos(a), s * std::sin(a)}, aside = {0, -std::sin(a), std::cos(a)};
    const Vec3 u = kLeaf * aside, v = kLeaf * cross(normal, aside);
    const double x = kSoil - 1.35 + 1.15 * uniform(), y = kHalf * uniform();
    builder.quad({x, y, kHalf * uniform()}, u, v);
  }
  Scene scene;
  scene.materials = {lambertian(0.5f), lambertian(0.5f)};
  scene.materials[0].doubleSided = true;
  scene.meshes = {builder.take(), plate(kSoil, 2 * kHalf, 1)};
  scene.instances = {{"leaves", 0, {}}, {"soil", 1, {}}};
  return scene;
}

}  // namespace

// A leaf every few centimetres must not make one echo of the canopy and the soil. Of a waveform of the same light, a
// pulse of 0.6 m, the last peak lies within 0.1 m of the soil for 98 % of such beams.
TEST_CASE("the last echo below leaves is that of the soil, however many sub-rays there are") {
  const std::string device = ON_EVERY_DEVICE;
  const uint32_t subRays = device == "reference" ? GENERATE(7, 61, 331) : GENERATE(7, 19, 61);
  const double separation = GENERATE(0.4, 0.6);
  TestOptions options = optionsOn(device);
  options.effects = Effects::none();
  options.effects.intensity.use = EffectUse::on;
  options.effects.divergence = {EffectUse::on, subRays, Effects::Divergence::Profile::gaussian, 0.005, 0.005};
  options.effects.returns = {EffectUse::on, Effects::Returns::Mode::last};
  options.effects.returns.separation = separation;
  const Sensor sensor = gridSensor(720, 12, -1.6, 1.6, 120);
  const Scan scan = scanOn(canopy(), sensor, Pose(), options);
  size_t beams = 0, soil = 0;
  double bias = 0;
  for (size_t channel = 0; channel < 12; ++channel)
    for (size_t turn = 0; turn < 7; ++turn) {
      const size_t beam = ahead(sensor, channel) + turn - 3;
      const double elevation = sensor.channels[channel].elevationDeg * std::numbers::pi / 180;
      REQUIRE(scan.hit(beam));
      const double azimuth = std::atan2(scan.points[3 * beam + 1], scan.points[3 * beam]);
      const double above = kSoil / (std::cos(elevation) * std::cos(azimuth)) - scan.ranges[beam];
      ++beams;
      soil += std::abs(above) < 0.1 ? 1 : 0;
      bias += above;
    }
  CAPTURE(device, subRays, separation, bias / double(beams), soil, beams);
  CHECK(double(soil) / double(beams) > 0.9);
}

// The light that passes both panes goes one layer further than the rest, whose last hits are metres long on the ground.
TEST_CASE("two panes before the ground at a grazing angle are two echoes") {
  const std::string device = ON_EVERY_DEVICE;
  const uint32_t subRays = GENERATE(7, 19);
  MeshBuilder builder;
  builder.quad({6, 1, -1}, {0, -1.008, 0}, {0, 0, 2});
  builder.quad({7.4, 0.008, -1}, {0, -1, 0}, {0, 0, 2});
  Scene scene;
  MeshBuilder ground;
  ground.quad({0, -20, -1.2}, {200, 0, 0}, {0, 40, 0});
  scene.meshes = {builder.take(), ground.take(1)};
  scene.instances = {{"panes", 0, {}}, {"ground", 1, {}}};
  scene.materials = {lambertian(0.5f, "glass"), lambertian(0.5f)};
  scene.materials[0].transmission = 0.8f;
  scene.materials[0].doubleSided = true;
  TestOptions options = optionsOn(device);
  options.effects = Effects::none();
  options.effects.intensity.use = options.effects.transmission.use = EffectUse::on;
  options.effects.divergence = {EffectUse::on, subRays, Effects::Divergence::Profile::gaussian, 0.006, 0.006};
  options.effects.returns.use = EffectUse::on;
  options.effects.returns.count = 3;
  const Sensor sensor = gridSensor(3600, 1, -0.5, -0.5, 300);
  const Scan scan = scanOn(scene, sensor, Pose(), options);
  const size_t first = 3 * ahead(sensor);
  CAPTURE(device, subRays);
  CHECK(std::abs(scan.ranges[first] - 6) < 0.01);
  CHECK(std::abs(scan.ranges[first + 1] - 7.4) < 0.01);
  CHECK(scan.ranges[first + 2] > 90);
}

// A thin strip of floor joins a table leg and the wall behind it: hits in a row, none of them far from the next. In a
// waveform of the same light, of pulses as long as the separation, the leg and the wall are two peaks.
TEST_CASE("a leg and a wall on one floor are two echoes") {
  const std::string device = ON_EVERY_DEVICE;
  const uint32_t subRays = GENERATE(19, 61);
  const double angle = 5.625 * std::numbers::pi / 180;  // one of 8 x 8 zones of 45 degrees
  MeshBuilder builder;
  builder.quad({1, 0.01, -0.1}, {0, -0.02, 0}, {0, 0, 2});
  builder.quad({2.5, 3, -0.1}, {0, -6, 0}, {0, 0, 4});
  builder.quad({-1, -3, -0.1}, {5, 0, 0}, {0, 6, 0});
  Scene scene = sceneOf(builder.take());
  scene.materials[0] = lambertian(0.9f);
  TestOptions options = optionsOn(device);
  options.effects = Effects::none();
  options.effects.intensity.use = EffectUse::on;
  options.effects.divergence = {EffectUse::on, subRays, Effects::Divergence::Profile::uniform, angle, angle};
  options.effects.returns = {EffectUse::on, Effects::Returns::Mode::all, 3};
  options.fields = {Field::intensity};
  const Sensor sensor = gridSensor(720, 1, -2.8125, -2.8125, 50);
  const Scan scan = scanOn(scene, sensor, Pose(), options);
  const size_t first = 3 * ahead(sensor);
  CAPTURE(device, subRays, scan.ranges[first], scan.ranges[first + 1], scan.ranges[first + 2]);
  CHECK(std::abs(scan.ranges[first] - 1) < 0.05);
  CHECK(std::abs(scan.ranges[first + 1] - 2.5) < 0.1);
  CHECK(std::isnan(scan.ranges[first + 2]));
}

TEST_CASE("the ground is one echo, however long it is, on two triangles and behind an edge") {
  const std::string device = ON_EVERY_DEVICE;
  const uint32_t subRays = GENERATE(7, 19, 61);
  const auto profile = GENERATE(Effects::Divergence::Profile::uniform, Effects::Divergence::Profile::gaussian);
  const auto [height, separation] =
      device == "reference" ? GENERATE(table<double, double>({{0.3, 0.1}, {0.3, 0.4}, {1.8, 0.1}, {1.8, 0.4}}))
                            : GENERATE(table<double, double>({{0.3, 0.4}, {1.8, 0.1}}));
  MeshBuilder builder;
  for (int strip = 0; strip < 300; ++strip)  // a strip of a metre each
    builder.quad({-1.0 + strip, -150, -height}, {1, 0, 0}, {0, 300, 0});
  Scene scene = sceneOf(builder.take());
  scene.materials[0] = lambertian(0.5f);
  TestOptions options = optionsOn(device);
  options.effects = Effects::none();
  options.effects.intensity.use = EffectUse::on;
  options.effects.divergence = {EffectUse::on, subRays, profile, 0.006, 0.006};
  options.effects.returns = {EffectUse::on, Effects::Returns::Mode::all, 3};
  options.effects.returns.separation = separation;
  const Sensor sensor = gridSensor(90, 24, -25, -1, 150);
  const Scan scan = scanOn(scene, sensor, Pose(), options);
  size_t beams = 0, more = 0;
  for (size_t channel = 0; channel < 24; ++channel)
    for (size_t turn = 0; turn < 20; ++turn) {
      const size_t beam = 3 * (channel * 90 + 35 + turn);
      if (!scan.returned(beam)) continue;
      ++beams;
      more += scan.returned(beam + 1);
    }
  CAPTURE(device, subRays, height, separation);
  CHECK(beams > 300);
  CHECK(more == 0);
}

}  // namespace gnosphere::test

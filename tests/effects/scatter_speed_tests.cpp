// SPDX-License-Identifier: Apache-2.0
// Radial speeds of light that comes back from fog, drops, flakes and dust.
#include <catch2/generators/catch_generators.hpp>

#include "effects/scan_support.hpp"

namespace gnosphere::test {

TEST_CASE("fog and drops are at rest: their radial speed is that of the sensor") {
  const std::string device = GENERATE(Catch::Generators::as<std::string>{}, "reference", "vulkan");
  constexpr double kSpeed = 20, kPeriod = 0.1;
  TestOptions options = optionsOn(device);
  options.effects = Effects::none();
  options.effects.intensity.use = EffectUse::automatic;
  options.effects.radialSpeed.use = options.effects.sensorMotion.use = EffectUse::on;
  options.effects.fog = {EffectUse::on, 30};
  options.effects.rain.use = EffectUse::on;
  options.effects.rain.rate = 20;
  options.fields = {Field::radialSpeed, Field::velocity, Field::label};
  Sensor sensor = gridSensor(720, 8, -20, 20, 60);
  sensor.rotationPeriod = kPeriod;
  Shot shot;
  shot.motion.stamps = {{0, {}}, {kPeriod, {{kSpeed * kPeriod, 0, 0}, {}}}};
  const Scan scan = scanOn(sceneOf(plate(40, 30)), sensor, shot, options);
  size_t scattered = 0;
  for (size_t i = 0; i < scan.beamCount(); ++i) {
    const float speed = scan.column<float>(Field::radialSpeed)[i];
    const auto label = static_cast<Label>(scan.column<uint8_t>(Field::label)[i]);
    if (label == Label::none) CHECK(std::isnan(speed));
    if (label != Label::scatter) continue;
    ++scattered;
    CHECK(std::abs(speed + kSpeed * scan.points[3 * i] / scan.ranges[i]) < 1e-3);
    CHECK(scan.column<float>(Field::velocity)[i] == 0);
  }
  CHECK(scattered > 500);
}

}  // namespace gnosphere::test

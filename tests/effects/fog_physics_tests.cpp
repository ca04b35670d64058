// SPDX-License-Identifier: Apache-2.0
// Whole scans in fog and dust compared with closed formulas of physics, on the device and on the reference.
#include <catch2/catch_approx.hpp>
#include <cmath>

#include "effects/plates.hpp"

namespace gnosphere::test {

using Catch::Approx;

TEST_CASE("fog hides a wall beyond the range that Koschmieder's law gives") {
  const std::string device = ON_EVERY_DEVICE;
  const double share = GENERATE(0.99, 1.01);
  const double visibility = 100, extinction = std::log(20.0) / visibility, threshold = 0.1 / (150.0 * 150.0);
  double near = 1, far = 150;
  for (int i = 0; i < 60; ++i) {
    const double range = (near + far) / 2;
    (0.5 / (range * range) * std::exp(-2 * extinction * range) > threshold ? near : far) = range;
  }
  Setup setup(device, platesOf({{share * near, 10, 0.5f - float(kGloss)}}), sector(fan(36000, 9, 0.2, 150), 22));
  setup.effects.fog = {EffectUse::on, visibility};
  setup.effects.detection = {EffectUse::on, 0.1, 150, 0};
  setup.fields = {Field::cause, Field::label};
  const Scan scan = setup.scan();
  size_t solid = 0, attenuated = 0, scatter = 0;
  for (size_t channel = 0; channel < 9; ++channel)
    for (size_t k = 0; k < 21; ++k) {
      const size_t beam = ahead(setup.sensor, channel) + k - 10;
      solid += scan.column<uint8_t>(Field::label)[beam] == uint8_t(Label::solid);
      scatter += scan.column<uint8_t>(Field::label)[beam] == uint8_t(Label::scatter);
      attenuated += scan.column<uint8_t>(Field::cause)[beam] == uint8_t(Cause::attenuated);
    }
  CHECK(solid + attenuated + scatter == 9 * 21);
  if (share < 1) CHECK(attenuated == 0);
  if (share > 1) CHECK(solid == 0);
  CHECK((share < 1 ? solid : attenuated) > 9 * 21 / 4);
}

TEST_CASE("fog and dust scatter back as much light whatever stands behind, and in slices as in one box") {
  const std::string device = ON_EVERY_DEVICE;
  const Sensor sensor = sector(fan(3600, 40, 0.2, 100), 102);
  const auto scanOf = [&](double wall, double visibility, const std::vector<Effects::Volume>& boxes) {
    Setup setup(device, platesOf({{wall, 60, 0.5f}}), sensor);
    setup.effects.fog = {visibility > 0 ? EffectUse::on : EffectUse::off, visibility};
    setup.effects.volumes = {boxes.empty() ? EffectUse::off : EffectUse::on, boxes};
    setup.effects.detection = {EffectUse::on, 0.001, 100000, 0};  // any light is enough
    setup.effects.returns.use = EffectUse::on;
    setup.effects.returns.mode = Effects::Returns::Mode::first;
    setup.fields = {Field::label};
    return setup.scan();
  };
  const auto scattered = [&](const Scan& scan, size_t beam, double before) {
    return scan.column<uint8_t>(Field::label)[beam] == uint8_t(Label::scatter) && scan.ranges[beam] < before;
  };
  constexpr size_t kBeams = 40 * 101;
  const auto countOf = [&](const auto& isCounted) {
    size_t count = 0;
    for (size_t channel = 0; channel < 40; ++channel)
      for (size_t k = 0; k < 101; ++k) count += isCounted(ahead(sensor, channel) + k - 50);
    return static_cast<double>(count);
  };
  const auto isNear = [](double count, double share) {
    return std::abs(count - kBeams * share) < 4 * std::sqrt(kBeams * share * (1 - share));
  };
  const double visibility = 200, extinction = std::log(20.0) / visibility, least = sensor.rangeMin;
  const Scan near = scanOf(20, visibility, {}), far = scanOf(90, visibility, {});
  size_t different = 0;
  const double fog = countOf([&](size_t beam) {
    different += scattered(near, beam, 19) != scattered(far, beam, 19);
    return scattered(near, beam, 19);
  });
  CHECK(different == 0);
  CHECK(isNear(fog, 1 - std::exp(-2 * extinction * (19 - least))));

  std::vector<Effects::Volume> slices;
  for (int i = 0; i < 10; ++i) slices.push_back({{5.0 + i, -30, -30}, {6.0 + i, 30, 30}, 0.02});
  for (const std::vector<Effects::Volume>& boxes : {{{{5, -30, -30}, {15, 30, 30}, 0.02}}, slices}) {
    const Scan dust = scanOf(50, 0, boxes);
    CHECK(isNear(countOf([&](size_t beam) { return scattered(dust, beam, 40); }), 1 - std::exp(-2 * 0.02 * 10)));
  }
}

// The random draws of a beam are the same with and without what stands before the fog.
TEST_CASE("behind glass or an edge fog scatters back what light they leave") {
  const std::string device = ON_EVERY_DEVICE;
  const bool glass = GENERATE(true, false);
  const uint32_t subRays = GENERATE(1, 7);
  if (!glass && subRays == 1) return;
  CAPTURE(glass, subRays);
  Scene open = platesOf({{60, 60, 0.5f}}), covered = open;
  covered.materials.push_back(lambertian(0.5f));
  covered.materials[1].transmission = glass ? 0.2f : 0.0f;
  MeshBuilder builder;
  builder.quad({5, 10, -10}, {0, glass ? -20.0 : -9.99, 0}, {0, 0, 20});
  covered.meshes.push_back(builder.take());
  covered.meshes[1].parts[0].material = 1;
  covered.instances.push_back({"", 1, {}});
  const Sensor sensor = sector(fan(3600, 200, 0.2, 100), 2);
  const auto scanOf = [&](const Scene& scene) {
    Setup setup(device, scene, sensor);
    setup.effects.fog = {EffectUse::on, 200};
    setup.effects.detection = {EffectUse::on, 0.001, 100000, 0};
    setup.effects.returns.use = EffectUse::on;
    setup.effects.transmission.use = EffectUse::automatic;
    setup.effects.returns.count = 5;
    setup.effects.intensity.scale = Effects::Intensity::Scale::raw;
    if (subRays > 1)
      setup.effects.divergence = {EffectUse::on, subRays, Effects::Divergence::Profile::uniform, 0.01, 0.01};
    setup.fields = {Field::intensity, Field::label};
    return setup.scan();
  };
  const Scan all = scanOf(open), part = scanOf(covered);
  const auto fogOf = [&](const Scan& scan, size_t beam) -> size_t {
    for (size_t i = scan.returns * beam; i < scan.returns * (beam + 1); ++i)
      if (scan.column<uint8_t>(Field::label)[i] == uint8_t(Label::scatter)) return i;
    return scan.ranges.size();
  };
  // The plate stops the two sub-rays that lie farthest to the left of the axis; there are seven.
  size_t compared = 0;
  for (size_t channel = 0; channel < 200; ++channel) {
    const size_t beam = ahead(sensor, channel), before = fogOf(all, beam), behind = fogOf(part, beam);
    if (behind == part.ranges.size() || part.ranges[behind] < 5.5) continue;
    ++compared;
    REQUIRE(before < all.ranges.size());
    CHECK(part.ranges[behind] == Approx(all.ranges[before]).epsilon(1e-5));
    const double share =
        part.column<float>(Field::intensity)[behind] / double(all.column<float>(Field::intensity)[before]);
    CHECK(share == Approx(glass ? 0.04 : 5 / 7.0).epsilon(1e-4));
  }
  CHECK(compared > 100);
}

TEST_CASE("fog goes on behind glass and beside an edge with nothing behind them") {
  const std::string device = ON_EVERY_DEVICE;
  const bool glass = GENERATE(true, false), hides = GENERATE(false, true);
  const uint32_t subRays = GENERATE(1, 7);
  if (!glass && subRays == 1) return;
  CAPTURE(glass, subRays, hides);
  const double before = hides ? 0.3 : 5;
  MeshBuilder builder;
  builder.quad({before, 10, -10}, {0, glass ? -20.0 : -10 + 0.002 * before, 0}, {0, 0, 20});
  Scene scene;
  scene.materials = {lambertian(0.5f)};
  scene.materials[0].transmission = glass ? 0.8f : 0.0f;
  scene.meshes = {builder.take()};
  scene.instances = {{"", 0, {}}};
  Setup setup(device, scene, sector(fan(36, 2000, 0.01, 100), 2));
  setup.sensor.rangeMin = 0.5;
  setup.sensor.nearHits = hides ? NearHits::hide : NearHits::seeThrough;
  setup.effects.fog = {EffectUse::on, 200};
  setup.effects.detection = {EffectUse::on, 0.001, 100000, 0};
  setup.effects.returns.use = EffectUse::on;
  setup.effects.returns.count = 5;
  setup.effects.transmission.use = EffectUse::automatic;
  if (subRays > 1)
    setup.effects.divergence = {EffectUse::on, subRays, Effects::Divergence::Profile::uniform, 0.01, 0.01};
  setup.fields = {Field::label};
  const Scan scan = setup.scan();
  size_t behind = 0;
  for (size_t channel = 0; channel < 2000; ++channel)
    for (size_t i = 0; i < scan.returns; ++i) {
      const size_t entry = ahead(setup.sensor, channel) * scan.returns + i;
      behind += scan.column<uint8_t>(Field::label)[entry] == uint8_t(Label::scatter) && scan.ranges[entry] > before;
    }
  const double extinction = std::log(20.0) / 200, first = std::max(before, 0.5) - 0.5;
  // The medium's echo belongs to that of the plate if it is closer to it than the separation.
  const double merged = hides ? first : first + setup.effects.returns.separation;
  const double share = std::exp(-2 * extinction * merged) - std::exp(-2 * extinction * (100 - 0.5));
  CHECK(std::abs(double(behind) - 2000 * share) < 4 * std::sqrt(2000 * share * (1 - share)));
}

TEST_CASE("fog hides no near wall from beams that have a range of their own alone") {
  const std::string device = ON_EVERY_DEVICE;
  Sensor sensor = fan(360, 4, 0.2, 0);
  for (Channel& channel : sensor.channels) channel.rangeMax = 100;
  Setup setup(device, platesOf({{20, 10, 0.5f}}), sensor);
  setup.effects.fog = {EffectUse::on, 200};
  const Scan scan = setup.scan();
  for (size_t channel = 0; channel < 4; ++channel) CHECK(scan.hit(ahead(sensor, channel)));
}

}  // namespace gnosphere::test

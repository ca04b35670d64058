// SPDX-License-Identifier: Apache-2.0
// Whole scans with effects but fog compared with closed formulas of physics, on the device and on the reference.
#include <algorithm>
#include <catch2/catch_approx.hpp>
#include <cmath>
#include <limits>

#include "effects/plates.hpp"

namespace gnosphere::test {
namespace {

using Catch::Approx;

struct Moments {
  size_t count = 0;
  double mean = 0, deviation = 0;
};

Moments momentsOf(const std::vector<double>& values) {
  Moments result = {values.size(), 0, 0};
  for (double value : values) result.mean += value / static_cast<double>(values.size());
  for (double value : values)
    result.deviation += (value - result.mean) * (value - result.mean) / static_cast<double>(values.size());
  result.deviation = std::sqrt(result.deviation);
  return result;
}

/// Checks that values have a normal variable's mean and deviation, within `sigmas` of the estimates' own errors.
void requireNormal(const Moments& found, double mean, double deviation) {
  const double root = std::sqrt(static_cast<double>(found.count));
  REQUIRE(found.count > 1000);
  CHECK(std::abs(found.mean - mean) < 4 * deviation / root);
  CHECK(std::abs(found.deviation - deviation) < 4 * deviation / (std::sqrt(2.0) * root));
}

/// A room around the sensor, within the range of all beams.
Scene greyRoom(float reflectance) {
  MeshBuilder builder;
  builder.box({-20, -20, -20}, {20, 20, 20});
  Scene scene = sceneOf(builder.take());
  scene.materials[0] = lambertian(reflectance);
  return scene;
}

Sensor everywhere(uint32_t columns = 200) {
  return gridSensor(columns, 20, -40, 40, 100);
}

}  // namespace

TEST_CASE("a Lambertian plate's power falls with the cosine of its tilt and the square of its range") {
  const std::string device = ON_EVERY_DEVICE;
  const double tilt = GENERATE(0.0, 0.7, 1.3);
  Scene scene = platesOf({{0, 4, 0.5f}});
  scene.instances[0].transform = translation(15, 0, 0) * rotationZ(tilt);
  Setup setup(device, scene, fan(3600, 3, 2, 50));
  setup.fields = {Field::intensity, Field::incidence};
  setup.effects.intensity.scale = Effects::Intensity::Scale::raw;
  const Scan scan = setup.scan();
  size_t hits = 0;
  for (size_t i = 0; i < scan.beamCount(); ++i) {
    if (!scan.hit(i)) continue;
    ++hits;
    const Vec3 d = setup.sensor.direction(i);
    const double cosine = std::abs(std::cos(tilt) * d.x + std::sin(tilt) * d.y);
    const double range = 15 * std::cos(tilt) / cosine;
    CHECK(scan.ranges[i] == Approx(range).epsilon(1e-5));
    CHECK(scan.column<float>(Field::incidence)[i] == Approx(std::acos(cosine)).margin(1e-3));
    CHECK(scan.column<float>(Field::intensity)[i] == Approx((0.5 * cosine + kGloss) / (range * range)).epsilon(1e-4));
  }
  CHECK(hits > 100);
}

TEST_CASE("the wavelength chooses the reflectance in a material table, and the extinction of fog") {
  const std::string device = ON_EVERY_DEVICE;
  const double wavelength = GENERATE(905.0, 1550.0);
  Setup setup(device, platesOf({{50, 20, 0.3f}}), sector(fan(3600, 9, 0.2, 150), 22));
  setup.effects.intensity.wavelength = wavelength;
  setup.effects.fog = {EffectUse::on, 2000};
  TestOptions options = setup.options();
  options.materials.rows = {{"dull", 0.2f, 0.6f}};
  const Scan scan = scanOn(setup.scene, setup.sensor, Pose{}, options);
  // Kim's law: 2 km are in its third section, 0.16 V + 0.34.
  const double extinction = std::log(20.0) / 2000 * std::pow(wavelength / 550, -(0.16 * 2 + 0.34));
  const double reflectance = wavelength == 905 ? 0.2 : 0.6;
  for (size_t i = 0; i < scan.beamCount(); ++i) {
    REQUIRE(scan.hit(i));  // the wall is stronger than any echo of so thin a fog
    const double cosine = setup.sensor.direction(i).x, range = 50 / cosine;
    CHECK(scan.column<float>(Field::intensity)[i] ==
          Approx(reflectance * cosine * std::exp(-2 * extinction * range)).epsilon(1e-4));
  }
}

TEST_CASE("a target of 10 % reflectance is just detected at the stated range") {
  const std::string device = ON_EVERY_DEVICE;
  const double distance = GENERATE(99.9, 100.1);
  Setup setup(device, platesOf({{distance, 10, 0.1f - float(kGloss)}}), fan(3600, 1, 0, 200));
  setup.effects.detection = {EffectUse::on, 0.1, 100, 0};
  setup.fields = {Field::cause};
  const Scan scan = setup.scan();
  const size_t beam = ahead(setup.sensor);
  CHECK(scan.hit(beam) == (distance < 100));
  CHECK(scan.column<uint8_t>(Field::cause)[beam] == uint8_t(distance < 100 ? Cause::returned : Cause::weak));
  CHECK(scan.column<uint8_t>(Field::cause)[0] == uint8_t(Cause::noSurface));
}

TEST_CASE("a head whose data sheet states a range at 10 % detects such a target up to there") {
  const std::string device = ON_EVERY_DEVICE;
  const double distance = GENERATE(39.9, 40.1);
  Sensor sensor = fan(3600, 1, 0, 200);
  sensor.rangeAt10Percent = 40;
  Setup setup(device, platesOf({{distance, 10, 0.1f - float(kGloss)}}), sensor);
  setup.effects.detection.use = EffectUse::on;
  CHECK(setup.scan().hit(ahead(sensor)) == (distance < 40));
  setup.effects.detection.range = 50;  // a range of the request counts instead
  CHECK(setup.scan().hit(ahead(sensor)));
}

TEST_CASE("an edge splits a footprint in two, and each part gets the energy of its area") {
  const std::string device = ON_EVERY_DEVICE;
  // The left edge of the near plate is at half the radius of the footprint: a segment of the disc passes it.
  const double tangent = std::tan(0.01 / 2), edge = 10 * tangent / 2;
  MeshBuilder builder;
  builder.quad({10, edge, -5}, {0, -5, 0}, {0, 0, 10});
  builder.quad({12, 5, -5}, {0, -10, 0}, {0, 0, 10});
  Scene scene = sceneOf(builder.take());
  scene.materials[0] = lambertian(0.5f);
  Setup setup(device, scene, fan(3600, 1, 0, 50));
  setup.effects.divergence = {EffectUse::on, 19, Effects::Divergence::Profile::uniform, 0.01, 0.01};
  setup.effects.returns.use = EffectUse::on;
  setup.effects.returns.count = 2;
  setup.fields = {Field::intensity, Field::width};
  const Scan scan = setup.scan();
  REQUIRE(scan.returns == 2);
  const size_t first = 2 * ahead(setup.sensor), second = first + 1;
  CHECK(scan.ranges[first] == Approx(10).margin(2e-3));
  CHECK(scan.ranges[second] == Approx(12).margin(2e-3));
  const double behind = std::acos(0.5) / std::numbers::pi - 0.5 * std::sqrt(0.75) / std::numbers::pi;
  const double all = 0.5 + kGloss;
  CHECK(scan.column<float>(Field::intensity)[first] == Approx((1 - behind) * all).margin(0.025));
  CHECK(scan.column<float>(Field::intensity)[second] == Approx(behind * all).margin(0.025));
  CHECK(scan.column<float>(Field::intensity)[first] + scan.column<float>(Field::intensity)[second] ==
        Approx(all).epsilon(1e-3));
  CHECK(scan.column<float>(Field::width)[first] == Approx(5e-9 * 299792458 / 2).epsilon(1e-3));
}

TEST_CASE("a slanted plate makes an echo longer") {
  const std::string device = ON_EVERY_DEVICE;
  Scene scene = platesOf({{0, 30, 0.5f}});
  scene.instances[0].transform = translation(20, 0, 0) * rotationZ(1.4);
  Setup setup(device, scene, fan(3600, 1, 0, 60));
  setup.effects.divergence = {EffectUse::on, 19, Effects::Divergence::Profile::uniform, 0.02, 0};
  setup.effects.returns.separation = 5;
  setup.effects.returns.pulseWidth = 1e-9;
  setup.fields = {Field::intensity, Field::width};
  const Scan scan = setup.scan();
  // A sub-ray t to the left hits the plate at 20 / (1 + tan(tilt) t); the deviation of t over a disc is half its
  // radius.
  const double deviation = 20 * std::tan(1.4) * std::tan(0.01) / 2, pulse = 1e-9 * 299792458 / 2;
  const double width = std::sqrt(pulse * pulse + std::pow(2 * std::sqrt(2 * std::log(2.0)) * deviation, 2));
  CHECK(scan.ranges[ahead(setup.sensor)] == Approx(20).margin(0.1));
  CHECK(scan.column<float>(Field::width)[ahead(setup.sensor)] == Approx(width).epsilon(0.03));
}

TEST_CASE("an axis of the divergence that the request leaves open is that of the sensor") {
  const std::string device = ON_EVERY_DEVICE;
  Scene scene = platesOf({{0, 30, 0.5f}});
  scene.instances[0].transform = translation(20, 0, 0) * rotationZ(1.2);
  Sensor sensor = fan(3600, 1, 0, 60);
  sensor.divergenceHorizontal = 0.02;
  sensor.divergenceVertical = 0.004;
  Setup setup(device, scene, sensor);
  setup.fields = {Field::width};
  setup.effects.divergence.use = EffectUse::on;
  const Scan stated = setup.scan();
  setup.effects.divergence.vertical = 0.004;  // the horizontal one counts on a plate that is turned about z
  const Scan asked = setup.scan();
  CHECK(std::ranges::equal(asked.column<float>(Field::width), stated.column<float>(Field::width),
                           [](float a, float b) { return a == b || (std::isnan(a) && std::isnan(b)); }));
  CHECK(stated.column<float>(Field::width)[ahead(sensor)] > 0.5);
}

// The footprint is up to 7 m long on the ground, with sub-rays farther apart than the separation of echoes. Small
// triangles share a footprint, large ones hold it.
TEST_CASE("the ground at a grazing angle is one echo on the ground, whatever its triangles are") {
  const std::string device = ON_EVERY_DEVICE;
  const double size = GENERATE(200, 3.1);
  const uint32_t subRays = GENERATE(7, 19);
  CAPTURE(size, subRays);
  MeshBuilder builder;
  for (double x = 0; x < 100; x += size)
    for (double y = -15; y < 15; y += size) builder.quad({x, y, -1.8}, {size, 0, 0}, {0, size, 0});
  Scene scene = sceneOf(builder.take());
  scene.materials[0] = lambertian(0.5f);
  Sensor sensor = gridSensor(360, 4, -4, -1.8, 200);
  Setup setup(device, scene, sensor);
  setup.effects.divergence = {EffectUse::on, subRays, Effects::Divergence::Profile::gaussian, 0.00534, 0.00534};
  setup.effects.returns.use = EffectUse::on;
  setup.effects.returns.count = 3;
  const Scan scan = setup.scan();
  for (size_t channel = 0; channel < 4; ++channel)
    for (size_t turn = 0; turn < 9; ++turn) {
      const size_t beam = ahead(sensor, channel) + turn - 4;
      CHECK(scan.hit(3 * beam));
      CHECK(!scan.hit(3 * beam + 1));
      const double elevation = sensor.channels[channel].elevationDeg * std::numbers::pi / 180;
      CHECK(scan.ranges[3 * beam] * std::sin(-elevation) == Approx(1.8).margin(0.02));
    }
}

// The edge of a post and the ground beyond it stay two echoes, though the ground is long.
TEST_CASE("a post before the ground is an echo of its own") {
  const std::string device = ON_EVERY_DEVICE;
  MeshBuilder builder;
  builder.quad({20, 0.02, -1.8}, {0, -2, 0}, {0, 0, 3});
  builder.quad({0, -20, -1.8}, {100, 0, 0}, {0, 40, 0});
  Setup setup(device, sceneOf(builder.take()), gridSensor(3600, 1, -2.5, -2.5, 200));
  setup.effects.divergence = {EffectUse::on, 19, Effects::Divergence::Profile::gaussian, 0.006, 0.006};
  setup.effects.returns.use = EffectUse::on;
  setup.effects.returns.count = 3;
  const Scan scan = setup.scan();
  const size_t first = 3 * ahead(setup.sensor);
  CHECK(scan.ranges[first] == Approx(20).margin(0.05));
  CHECK(scan.ranges[first + 1] == Approx(1.8 / std::sin(2.5 * std::numbers::pi / 180)).epsilon(0.03));
  CHECK(!scan.hit(first + 2));
}

TEST_CASE("a pane of glass and the wall behind it share a beam") {
  const std::string device = ON_EVERY_DEVICE;
  Scene scene = platesOf({{8, 5, 0.5f}, {14, 8, 0.6f}});
  scene.materials[0].transmission = 0.8f;
  Setup setup(device, scene, fan(3600, 1, 0, 50));
  setup.effects.transmission.use = setup.effects.returns.use = EffectUse::on;
  setup.effects.returns.count = 3;
  setup.fields = {Field::intensity, Field::material};
  const Scan scan = setup.scan();
  REQUIRE(scan.returns == 3);
  const size_t first = 3 * ahead(setup.sensor);
  CHECK(scan.ranges[first] == Approx(8).epsilon(1e-5));
  CHECK(scan.ranges[first + 1] == Approx(14).epsilon(1e-5));
  CHECK(!scan.hit(first + 2));
  CHECK(scan.column<float>(Field::intensity)[first] == Approx(0.5 * 0.2 + kGloss).epsilon(1e-4));
  CHECK(scan.column<float>(Field::intensity)[first + 1] == Approx(0.8 * 0.8 * (0.6 + kGloss)).epsilon(1e-4));
  CHECK(scan.column<uint32_t>(Field::material)[first] == 0);
  CHECK(scan.column<uint32_t>(Field::material)[first + 1] == 1);
}

// The pane and the wall have one place, or the wall is 5e-7 of the range behind. Of equal ranges the lower instance is
// first.
TEST_CASE("a wall ends light, however close to the pane before it") {
  const std::string device = ON_EVERY_DEVICE;
  const double gap = GENERATE(0.0, 4e-6);
  const bool paneFirst = gap > 0 || GENERATE(true, false);
  const bool footprint = GENERATE(false, true);
  CAPTURE(gap, paneFirst, footprint);
  const Plate pane = {8, 5, 0.5f}, near = {8 + gap, 5, 0.6f}, far = {14, 8, 0.7f};
  Scene scene = platesOf({paneFirst ? pane : near, paneFirst ? near : pane, far});
  scene.materials[paneFirst ? 0 : 1].transmission = 0.8f;
  Setup setup(device, scene, fan(3600, 1, 0, 50));
  setup.effects.transmission.use = setup.effects.returns.use = EffectUse::on;
  setup.effects.returns.count = 3;
  if (footprint) setup.effects.divergence = {EffectUse::on, 7, Effects::Divergence::Profile::gaussian, 1e-4, 1e-4};
  for (const Binning binning : {Binning::automatic, Binning::lists}) {
    TestOptions options = setup.options();
    options.tuning.binning = binning;
    const Scan scan = scanOn(scene, setup.sensor, Pose{}, options);
    const size_t first = 3 * ahead(setup.sensor);
    CHECK(scan.ranges[first] == Approx(8).epsilon(1e-5));
    CHECK(!scan.hit(first + 1));
    const double wall = 0.6 + kGloss, both = 0.5 * 0.2 + kGloss + 0.8 * 0.8 * wall;
    CHECK(scan.column<float>(Field::intensity)[first] == Approx(paneFirst ? both : wall).epsilon(1e-4));
    if (device == "reference") break;
  }
}

TEST_CASE("beams pass exactly the holes of a texture") {
  const std::string device = ON_EVERY_DEVICE;
  using Wrap = AlphaImage::Wrap;
  const Wrap wrap = GENERATE(Wrap::repeat, Wrap::mirror, Wrap::clamp);
  // The image is a row or a column of four pixels along y, mapped twice over the plate: alpha is 0, 100, 180 and 255 of
  // 255. The other axis wraps in another way.
  const bool column = GENERATE(false, true);
  const Wrap across = wrap == Wrap::repeat ? Wrap::clamp : Wrap::repeat;
  Scene scene = platesOf({{10, 4, 0.5f}, {20, 20, 0.5f}});
  if (column)
    scene.alphaImages.push_back({1, 4, {0, 100, 180, 255}, across, wrap});
  else
    scene.alphaImages.push_back({4, 1, {0, 100, 180, 255}, wrap, across});
  scene.materials[0].alphaMode = AlphaMode::mask;
  scene.materials[0].alphaImage = 0;
  scene.materials[0].baseColor[3] = 0.8f;
  scene.materials[0].alphaCutoff = 0.5f;
  scene.meshes[0].uvs = {0, 0, 0, 1, 2, 0, 2, 1};              // u runs from the left, y = 4, to y = -4
  if (column) scene.meshes[0].uvs = {0, 0, 1, 0, 0, 2, 1, 2};  // and here v
  Setup setup(device, scene, fan(3600, 3, 5, 50));
  setup.effects.cutOuts.use = EffectUse::on;
  const Scan scan = setup.scan();
  size_t onPlate = 0, through = 0, ties = 0;
  for (size_t i = 0; i < scan.beamCount(); ++i) {
    const Vec3 d = setup.sensor.direction(i);
    const double y = 10 * d.y / d.x, z = 10 * d.z / d.x, u = (4 - y) / 4;
    if (d.x <= 0 || std::abs(y) > 3.99 || std::abs(z) > 3.99) continue;
    double place = u > 1 ? u - 1 : u;
    if (wrap == Wrap::mirror && u > 1) place = 2 - u;
    if (wrap == Wrap::clamp && u > 1) place = 1;
    if (std::abs(place - 0.5) < 1e-4 || std::abs(u - 1) < 1e-4) continue;  // at the edge of a hole
    const bool hole = place < 0.5;  // 0.8 * 180 / 255 is above the cut-off, 0.8 * 100 / 255 is below
    ++onPlate;
    through += hole;
    CHECK(scan.instances[i] == (hole ? 1 : 0));
    if (device == "reference") ties += scan.column<uint8_t>(Field::tie)[i];
  }
  CHECK(ties < onPlate / 50);  // within holes and between them the reference has no doubt
  CHECK(onPlate > 500);
  CHECK(through > 100);
}

TEST_CASE("a texel whose alpha is the cut-off is solid, and the one below is a hole, at each of the 255 alphas") {
  const std::string device = ON_EVERY_DEVICE;
  // Each beam meets a plate of its own, which has the alpha of a single texel. Two plates have one cut-off.
  const Sensor sensor = fan(510, 1, 0, 50);
  REQUIRE(sensor.beamCount() == 510);
  Scene scene;
  scene.alphaImages.push_back({256, 1, std::vector<uint8_t>(256)});
  for (size_t i = 0; i < 256; ++i) scene.alphaImages[0].alpha[i] = static_cast<uint8_t>(i);
  for (uint32_t beam = 0; beam < 510; ++beam) {
    const uint32_t cutoff = 1 + beam / 2, texel = cutoff - beam % 2;
    Material material = lambertian(0.5f);
    material.alphaMode = AlphaMode::mask;
    material.alphaImage = 0;
    material.alphaCutoff = static_cast<float>(cutoff / 255.0);
    scene.materials.push_back(material);
    Mesh mesh = plate(10, 0.05, beam);
    for (size_t v = 0; v < mesh.vertexCount(); ++v)
      mesh.uvs.insert(mesh.uvs.end(), {(static_cast<float>(texel) + 0.5f) / 256, 0.5f});
    scene.meshes.push_back(std::move(mesh));
    const Vec3 d = sensor.direction(beam);
    scene.instances.push_back({"", beam, rotationZ(std::atan2(d.y, d.x))});
  }
  Setup setup(device, scene, sensor);
  setup.effects.cutOuts.use = EffectUse::on;
  const Scan scan = setup.scan();
  for (uint32_t beam = 0; beam < 510; ++beam) {
    CAPTURE(beam);
    CHECK(scan.hit(beam) == (beam % 2 == 0));
  }
}

TEST_CASE("texture coordinates that are not finite cut no holes") {
  const std::string device = ON_EVERY_DEVICE;
  using Wrap = AlphaImage::Wrap;
  const Wrap wrap = GENERATE(Wrap::repeat, Wrap::mirror, Wrap::clamp);
  const float odd = GENERATE(std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity());
  Scene scene = platesOf({{10, 4, 0.5f}, {20, 20, 0.5f}});
  scene.alphaImages.push_back({2, 2, {0, 0, 0, 0}, wrap, wrap});  // nothing but a hole
  scene.materials[0].alphaMode = AlphaMode::mask;
  scene.materials[0].alphaImage = 0;
  scene.materials[0].alphaCutoff = 0.5f;
  const bool isFinite = GENERATE(true, false);
  CAPTURE(int(wrap), odd, isFinite);
  scene.meshes[0].uvs = isFinite ? std::vector<float>{0, 0, 0, 1, 2, 0, 2, 1} : std::vector<float>(8, odd);
  Setup setup(device, scene, fan(3600, 3, 5, 50));
  setup.effects.cutOuts.use = EffectUse::on;
  const Scan scan = setup.scan();
  size_t onPlate = 0;
  for (size_t i = 0; i < scan.beamCount(); ++i) {
    const Vec3 d = setup.sensor.direction(i);
    if (d.x <= 0 || std::abs(d.y / d.x) > 0.399 || std::abs(d.z / d.x) > 0.399) continue;
    ++onPlate;
    CHECK(scan.instances[i] == (isFinite ? 1 : 0));
  }
  CHECK(onPlate > 500);
}

TEST_CASE("errors of range and intensity are normal, with the requested moments") {
  const std::string device = ON_EVERY_DEVICE;
  Setup setup(device, greyRoom(0.5f), everywhere());
  setup.fields = {Field::intensity, Field::trueRange, Field::incidence};
  setup.effects.rangeNoise = {EffectUse::on, 0.05, 0.02, 0, 0};
  setup.effects.intensityNoise = {EffectUse::on, 0.03};
  const Scan scan = setup.scan();
  std::vector<double> ranges, intensities;
  for (size_t i = 0; i < scan.beamCount(); ++i) {
    REQUIRE(scan.hit(i));
    ranges.push_back(double{scan.ranges[i]} - scan.column<float>(Field::trueRange)[i]);
    if (const double unit = 0.5 * std::cos(double{scan.column<float>(Field::incidence)[i]}) + kGloss;
        unit > 0.2)  // far from 0
      intensities.push_back(scan.column<float>(Field::intensity)[i] - unit);
  }
  requireNormal(momentsOf(ranges), 0.05, 0.02);
  requireNormal(momentsOf(intensities), 0, 0.03);
}

TEST_CASE("weak echoes have larger errors of the range, inverse to their power") {
  const std::string device = ON_EVERY_DEVICE;
  Setup setup(device, greyRoom(0.5f), everywhere());
  setup.fields = {Field::intensity, Field::trueRange};
  setup.effects.detection = {EffectUse::off, 0.1, 20};
  setup.effects.rangeNoise = {.use = EffectUse::on, .sigma = 0.005, .sigmaAtThreshold = 0.4};
  const Scan scan = setup.scan();
  std::vector<double> errors;
  for (size_t i = 0; i < scan.beamCount(); ++i) {
    REQUIRE(scan.hit(i));
    const double range = scan.column<float>(Field::trueRange)[i];
    const double power = scan.column<float>(Field::intensity)[i] / (range * range);
    const double weak = 0.4 * std::min(0.1 / (20.0 * 20.0) / power, 1.0);
    if (range > 4 * 0.4) errors.push_back((scan.ranges[i] - range) / std::hypot(0.005, weak));  // none is cut off at 0
  }
  requireNormal(momentsOf(errors), 0, 1);
}

TEST_CASE("quantised ranges are multiples of the step") {
  const std::string device = ON_EVERY_DEVICE;
  Setup setup(device, greyRoom(0.5f), everywhere(60));
  setup.effects.rangeNoise = {EffectUse::on, 0, 0, 0, 0.25};
  for (float range : setup.scan().ranges) CHECK(std::remainder(range, 0.25f) == 0);
}

TEST_CASE("angular errors have the requested deviations, at the point and at the beam") {
  const std::string device = ON_EVERY_DEVICE;
  Setup setup(device, greyRoom(0.5f), everywhere());
  setup.effects.angleNoise = {EffectUse::on, 2e-3, 1e-3, Effects::AngleNoise::At::point};
  const Scan scan = setup.scan();
  std::vector<double> azimuths, elevations;
  for (size_t i = 0; i < scan.beamCount(); ++i) {
    const Vec3 d = setup.sensor.direction(i);
    const float* p = &scan.points[3 * i];
    azimuths.push_back(std::remainder(std::atan2(p[1], p[0]) - std::atan2(d.y, d.x), 2 * std::numbers::pi));
    elevations.push_back(std::atan2(p[2], std::hypot(p[0], p[1])) - std::asin(d.z));
  }
  requireNormal(momentsOf(azimuths), 0, 2e-3);
  requireNormal(momentsOf(elevations), 0, 1e-3);

  // Beams with an azimuth error hit a wall at 20 / cos(azimuth + error).
  setup.scene = platesOf({{20, 20, 0.5f}});
  setup.sensor = fan(4000, 1, 0, 60);
  setup.effects.angleNoise = {EffectUse::on, 2e-3, 0, Effects::AngleNoise::At::beam};
  const Scan strays = setup.scan();
  std::vector<double> errors;
  for (size_t i = 0; i < strays.beamCount(); ++i) {
    const Vec3 d = setup.sensor.direction(i);
    const double azimuth = std::atan2(d.y, d.x);
    if (!strays.hit(i) || std::abs(azimuth) < 0.1) continue;  // near normal incidence
    const float* p = &strays.points[3 * i];
    CHECK(p[1] == Approx(strays.ranges[i] * d.y).margin(1e-4));
    errors.push_back((std::acos(20.0 / strays.ranges[i]) - std::abs(azimuth)) * (azimuth < 0 ? -1 : 1));
  }
  const Moments moments = momentsOf(errors);
  CHECK(moments.count > 500);
  CHECK(std::abs(moments.mean) < 4 * 2e-3 / std::sqrt(double(moments.count)));
  CHECK(moments.deviation == Approx(2e-3).epsilon(0.12));
}

TEST_CASE("beams are lost at the requested rates, and every beam has one cause") {
  const std::string device = ON_EVERY_DEVICE;
  Setup setup(device, greyRoom(0.29f), everywhere());
  setup.effects.dropOut = {EffectUse::on, 0.3, 0.8, 0, {5, 77}};
  setup.fields = {Field::cause};
  const Scan scan = setup.scan();
  const auto& causes = scan.counters.causes;
  const double beams = double(scan.beamCount());
  CHECK(std::abs(double(causes[size_t(Cause::droppedOut)]) - 0.3 * beams) < 4 * std::sqrt(0.21 * beams));
  CHECK(causes[size_t(Cause::dead)] == 2);
  CHECK(scan.column<uint8_t>(Field::cause)[77] == uint8_t(Cause::dead));
  CHECK(causes[size_t(Cause::returned)] == scan.counters.hits);
  uint64_t sum = 0;
  for (uint64_t count : causes) sum += count;
  CHECK(sum == scan.beamCount());

  setup.effects.dropOut = {EffectUse::on, 0, 1, 0.8, {}};
  const Scan weak = setup.scan();
  // A return of unit intensity u is lost with probability 0.8 (1 - u).
  double expected = 0;
  for (size_t i = 0; i < weak.beamCount(); ++i) {
    const Vec3 d = setup.sensor.direction(i);
    expected += 0.8 * (1 - 0.29 * std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)}) - kGloss);
  }
  CHECK(std::abs(double(weak.counters.causes[size_t(Cause::droppedOut)]) - expected) < 4 * std::sqrt(0.24 * beams));
}

TEST_CASE("a surface nearer than the least range blocks a beam in all that effects do, and is its cause") {
  Setup setup("vulkan", platesOf({{0.5, 0.2, 0.5f}, {20, 20, 0.5f}}), fan(500, 9, 40, 60));
  setup.sensor.rangeMin = 1;
  setup.sensor.nearHits = NearHits::hide;
  setup.sensor.divergenceHorizontal = setup.sensor.divergenceVertical = 3e-3;
  setup.fields = {Field::intensity, Field::cause};
  const Effects plain = setup.effects;
  Effects fog = plain, dropOut = plain, noise = plain, footprints = plain;
  fog.fog = {EffectUse::on, 20};  // without the plate most beams would return fog
  dropOut.dropOut = {EffectUse::on, 0.3};
  noise.rangeNoise.use = EffectUse::on;
  noise.rangeNoise.bias = 0.7;
  footprints.divergence.use = EffectUse::on;
  for (const Effects& effects : {plain, fog, dropOut, noise, footprints}) {
    setup.effects = effects;
    INFO(toJson(effects));
    setup.device = "reference";
    const Scan expected = setup.scan();
    setup.device = "vulkan";
    const Scan scan = setup.scan();
    const Differences found = differences(expected, scan);
    INFO(found.first);
    CHECK(found.all() == 0);
    CHECK(found.ties < 20);
    CHECK(scan.counters.causes == expected.counters.causes);
    const auto causes = scan.column<uint8_t>(Field::cause);
    size_t blocked = 0, wrong = 0;
    for (size_t beam = 0; beam < scan.beamCount(); ++beam) {
      const Vec3 d = setup.sensor.direction(beam);
      const double aside = std::max(std::abs(d.y), std::abs(d.z)) / d.x;
      const bool meets = d.x > 0 && aside < 0.4 - 0.005, misses = d.x <= 0 || aside > 0.4 + 0.005;
      const auto cause = static_cast<Cause>(causes[beam]);
      blocked += cause == Cause::tooNear;
      if (meets) wrong += scan.hit(beam) || (cause != Cause::tooNear && cause != Cause::droppedOut);
      if (misses) wrong += cause == Cause::tooNear;
    }
    CHECK(blocked > 100);
    CHECK(wrong == 0);
    CHECK(blocked == scan.counters.causes[static_cast<size_t>(Cause::tooNear)]);
  }
}

}  // namespace gnosphere::test

// SPDX-License-Identifier: Apache-2.0
// The places of sub-rays in a footprint.
#include <algorithm>
#include <catch2/catch_approx.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <cmath>
#include <numbers>

#include "effects/scan_support.hpp"

namespace gnosphere::test {
namespace {

TestOptions footprintsOf(const std::string& device, uint32_t subRays, double angle) {
  TestOptions options = optionsOn(device);
  options.effects = Effects::none();
  options.effects.intensity = {EffectUse::on, Effects::Intensity::Model::physical, Effects::Intensity::Scale::raw};
  options.effects.divergence = {EffectUse::on, subRays, Effects::Divergence::Profile::gaussian, angle, angle};
  options.fields = {Field::intensity};
  return options;
}

/// The share of a Gaussian footprint, cut off at 1/e^2, that lies left of a line at `offset`, in units of its radius.
double shareBeside(double offset) {
  constexpr int kSteps = 2000;
  double left = 0, all = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double x = -1 + 2 * (i + 0.5) / kSteps;
    // The integral over y of exp(-2 (x^2 + y^2)) up to the edge of the disc.
    const double strip = std::exp(-2 * x * x) * std::erf(std::sqrt(2 * (1 - x * x)));
    all += strip;
    if (x < offset) left += strip;
  }
  return left / all;
}

}  // namespace

TEST_CASE("a beam on a slope has the range of its axis, however many sub-rays it has") {
  const std::string device = GENERATE(Catch::Generators::as<std::string>{}, "reference", "vulkan");
  const bool upright = GENERATE(false, true);
  MeshBuilder builder;
  // A wall through (50, 0, 0), tilted by 60 degrees about the level or the upright axis.
  const double slope = std::sqrt(3.0);
  if (upright)
    builder.quad({50 + 20 * slope, 20, -20}, {-40 * slope, -40, 0}, {0, 0, 40});
  else
    builder.quad({50 - 20 * slope, 20, -20}, {0, -40, 0}, {40 * slope, 0, 40});
  Scene scene = sceneOf(builder.take());
  scene.materials[0] = lambertian(0.5f);
  scene.materials[0].doubleSided = true;
  for (const uint32_t subRays : {2u, 3u, 4u, 7u, 10u, 18u, 19u, 60u, 61u}) {
    CAPTURE(device, upright, subRays);
    const Sensor sensor = fan(3600, 1, 0, 120);
    const Scan scan = scanOn(scene, sensor, Pose{}, footprintsOf(device, subRays, 0.00534));
    CHECK(std::abs(scan.ranges[ahead(sensor)] - 50) < 2e-3);
  }
}

// A board covers one side of the footprint up to an edge, which is put at many places. The share of the light that the
// board returns must be that of the whole beam.
TEST_CASE("level and upright edges divide the light of a footprint as the whole beam would") {
  const std::string device = GENERATE(Catch::Generators::as<std::string>{}, "reference", "vulkan");
  const bool upright = GENERATE(false, true);
  const auto [subRays, most] = GENERATE(table<uint32_t, double>({{7, 0.09}, {19, 0.032}, {37, 0.02}, {61, 0.016}}));
  constexpr double kDistance = 20, kHalfAngle = 0.01;
  const double radius = kDistance * std::tan(kHalfAngle);
  double square = 0;
  constexpr int kPlaces = 41;
  for (int place = 0; place < kPlaces; ++place) {
    const double offset = -1 + 2.0 * place / (kPlaces - 1), edge = offset * radius;
    MeshBuilder builder;
    if (upright)
      builder.quad({kDistance, edge, -1}, {0, -1, 0}, {0, 0, 2});
    else
      builder.quad({kDistance, 1, -1}, {0, -2, 0}, {0, 0, 1 + edge});
    Scene scene = sceneOf(builder.take());
    scene.materials[0] = lambertian(0.5f);
    const Sensor sensor = fan(3600, 1, 0, 60);
    const Scan scan = scanOn(scene, sensor, Pose{}, footprintsOf(device, subRays, 2 * kHalfAngle));
    const float power = scan.column<float>(Field::intensity)[ahead(sensor)];
    const double all = (0.5 + 0.01) / (kDistance * kDistance);
    const double error = (scan.hit(ahead(sensor)) ? power / all : 0) - shareBeside(offset);
    square += error * error;
  }
  CAPTURE(device, upright, subRays);
  CHECK(std::sqrt(square / kPlaces) < most);
}

// Light that comes back from nearer ground is stronger, by the square of the range: the mean of a footprint that is
// long on the ground lies nearer than its axis.
TEST_CASE("a footprint on the ground has the range and the power of all light that comes back from it") {
  const std::string device = GENERATE(Catch::Generators::as<std::string>{}, "reference", "vulkan");
  // Height of the sensor and full angle of the beam in metres and radians, elevation in degrees.
  const auto [height, angle, elevation] =
      GENERATE(table<double, double, double>({{0.05, 0.098, -4}, {1.8, 0.00534, -2}, {1.8, 0.00534, -0.5}}));
  MeshBuilder builder;
  builder.quad({-10, -400, -height}, {1010, 0, 0}, {0, 800, 0});
  Scene scene = sceneOf(builder.take());
  scene.materials[0] = lambertian(0.5f);
  TestOptions options = footprintsOf(device, 61, angle);
  options.effects.divergence.profile = Effects::Divergence::Profile::uniform;
  options.effects.returns.separation = 100;
  options.materials.rows = {{"dull", 0.5f}};
  const Sensor sensor = gridSensor(3600, 1, elevation, elevation, 1000);
  const Scan scan = scanOn(scene, sensor, Pose(), options);

  const double el = elevation * std::numbers::pi / 180, radius = std::tan(angle / 2);
  constexpr int kLines = 801;
  double power = 0, moment = 0, lines = 0;
  for (int i = 0; i < kLines; ++i)
    for (int j = 0; j < kLines; ++j) {
      const double u = -1 + (2 * i + 1.0) / kLines, v = -1 + (2 * j + 1.0) / kLines;
      if (u * u + v * v > 1) continue;
      ++lines;
      const double length = std::sqrt(1 + radius * radius * (u * u + v * v)),
                   down = -(std::sin(el) + radius * v * std::cos(el)) / length;  // the cosine of the incidence, too
      if (!(down > 0)) continue;
      const double range = height / down;
      if (range > 1000) continue;
      const double own = 0.5 * down / (range * range);
      power += own;
      moment += own * range;
    }
  const size_t beam = ahead(sensor);
  CAPTURE(device, height, angle, elevation, scan.ranges[beam], moment / power);
  CHECK(scan.ranges[beam] == Catch::Approx(moment / power).epsilon(0.01));
  CHECK(scan.column<float>(Field::intensity)[beam] == Catch::Approx(power / lines).epsilon(0.02));
}

TEST_CASE("the light of a rectangular footprint reaches its corners, and edges divide it as a whole rectangle") {
  const std::string device = GENERATE(Catch::Generators::as<std::string>{}, "reference", "vulkan");
  constexpr double kDistance = 20, kHalfAngle = 0.01;
  const double half = kDistance * std::tan(kHalfAngle);
  const Sensor sensor = fan(3600, 1, 0, 60);
  const auto powerOf = [&](Mesh mesh, uint32_t subRays, Effects::Divergence::Shape shape) {
    Scene scene = sceneOf(std::move(mesh));
    scene.materials[0] = lambertian(0.5f);
    TestOptions options = footprintsOf(device, subRays, 2 * kHalfAngle);
    options.effects.divergence.profile = Effects::Divergence::Profile::uniform;
    options.effects.divergence.shape = shape;
    options.materials.rows = {{"dull", 0.5f}};
    const Scan scan = scanOn(scene, sensor, Pose{}, options);
    const float power = scan.column<float>(Field::intensity)[ahead(sensor)];
    return scan.hit(ahead(sensor)) ? power * kDistance * kDistance / 0.5 : 0.0;
  };
  // A board from 0.75 to 1 of the half angles, to the left and up.
  MeshBuilder board;
  board.quad({kDistance, half, 0.75 * half}, {0, -0.25 * half, 0}, {0, 0, 0.25 * half});
  const Mesh corner = board.take();
  CHECK(powerOf(corner, 61, Effects::Divergence::Shape::ellipse) == 0);
  CHECK(powerOf(corner, 61, Effects::Divergence::Shape::rectangle) == Catch::Approx(1.0 / 64).margin(0.011));
  const bool upright = GENERATE(false, true);
  for (const uint32_t subRays : {7u, 19u, 61u}) {
    double square = 0;
    constexpr int kPlaces = 21;
    for (int place = 0; place < kPlaces; ++place) {
      const double offset = -1 + 2.0 * place / (kPlaces - 1), edge = offset * half;
      MeshBuilder builder;
      if (upright)
        builder.quad({kDistance, edge, -1}, {0, -1, 0}, {0, 0, 2});
      else
        builder.quad({kDistance, 1, -1}, {0, -2, 0}, {0, 0, 1 + edge});
      const double error = powerOf(builder.take(), subRays, Effects::Divergence::Shape::rectangle) - (1 + offset) / 2;
      square += error * error;
    }
    CAPTURE(device, upright, subRays);
    CHECK(std::sqrt(square / kPlaces) < 0.6 / subRays);
  }
}

}  // namespace gnosphere::test

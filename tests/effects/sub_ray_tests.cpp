// SPDX-License-Identifier: Apache-2.0
// The places of sub-rays in a footprint.
#include <algorithm>
#include <catch2/catch_approx.hpp>
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

constexpr double kDistance = 20, kHalfAngle = 0.01;  // of boards, and of the footprints that meet them

/// A head whose beams are so far apart that each meets a board of its own.
Sensor apart() {
  return fan(60, 1, 0, 60);
}

/// A board of half a metre around the axis, but its left edge, if `upright`, or else its upper one is at `edge`.
Mesh boardUpTo(bool upright, double edge) {
  MeshBuilder builder;
  if (upright)
    builder.quad({kDistance, edge, -0.5}, {0, -0.5 - edge, 0}, {0, 0, 1});
  else
    builder.quad({kDistance, 0.5, -0.5}, {0, -1, 0}, {0, 0, 0.5 + edge});
  return builder.take();
}

/// Returns the power of the light that comes back from each of the boards, each in front of another beam of apart(), as
/// a share of that from a diffuse surface of reflectance 1 there.
std::vector<double> powersOf(const std::vector<Mesh>& boards, const TestOptions& options) {
  const Sensor sensor = apart();
  Scene scene;
  scene.materials = {lambertian(0.5f)};
  for (uint32_t i = 0; i < boards.size(); ++i) {
    const Vec3 d = sensor.direction(i);
    scene.meshes.push_back(boards[i]);
    scene.instances.push_back({"", i, rotationZ(std::atan2(d.y, d.x))});
  }
  const Scan scan = scanOn(scene, sensor, Pose{}, options);
  std::vector<double> powers;
  for (size_t i = 0; i < boards.size(); ++i)
    powers.push_back(scan.hit(i) ? scan.column<float>(Field::intensity)[i] * kDistance * kDistance : 0.0);
  return powers;
}

/// Offsets from -1 to 1.
std::vector<double> offsets(int count) {
  std::vector<double> all;
  for (int i = 0; i < count; ++i) all.push_back(-1 + 2.0 * i / (count - 1));
  return all;
}

}  // namespace

TEST_CASE("a beam on a slope has the range of its axis, however many sub-rays it has") {
  const std::string device = ON_EVERY_DEVICE;
  // Walls through (50, 0, 0) and (-50, 0, 0), tilted by 60 degrees about the upright and the level axis.
  const double slope = std::sqrt(3.0);
  MeshBuilder builder;
  builder.quad({50 + 20 * slope, 20, -20}, {-40 * slope, -40, 0}, {0, 0, 40});
  builder.quad({-50 - 20 * slope, -20, -20}, {0, 40, 0}, {40 * slope, 0, 40});
  Scene scene = sceneOf(builder.take());
  scene.materials[0] = lambertian(0.5f);
  scene.materials[0].doubleSided = true;
  const Sensor sensor = fan(36, 1, 0, 120);
  for (const uint32_t subRays : {2u, 3u, 4u, 7u, 10u, 18u, 19u, 60u, 61u}) {
    CAPTURE(device, subRays);
    const Scan scan = scanOn(scene, sensor, Pose{}, footprintsOf(device, subRays, 0.00534));
    CHECK(std::abs(scan.ranges[ahead(sensor)] - 50) < 2e-3);
    CHECK(std::abs(scan.ranges[0] - 50) < 2e-3);  // the first beam looks back
  }
}

// A board covers one side of the footprint up to an edge, which is put at many places. The share of the light that the
// board returns must be that of the whole beam.
TEST_CASE("level and upright edges divide the light of a footprint as the whole beam would") {
  const std::string device = ON_EVERY_DEVICE;
  const bool upright = GENERATE(false, true);
  const auto [subRays, most] = GENERATE(table<uint32_t, double>({{7, 0.09}, {19, 0.032}, {37, 0.02}, {61, 0.016}}));
  std::vector<Mesh> boards;
  for (const double offset : offsets(41))
    boards.push_back(boardUpTo(upright, offset * kDistance * std::tan(kHalfAngle)));
  const std::vector<double> powers = powersOf(boards, footprintsOf(device, subRays, 2 * kHalfAngle));
  double square = 0;
  for (size_t i = 0; i < powers.size(); ++i)
    square += std::pow(powers[i] / (0.5 + 0.01) - shareBeside(offsets(41)[i]), 2);
  CAPTURE(device, upright, subRays);
  CHECK(std::sqrt(square / 41) < most);
}

// Light that comes back from nearer ground is stronger, by the square of the range: the mean of a footprint that is
// long on the ground lies nearer than its axis.
TEST_CASE("a footprint on the ground has the range and the power of all light that comes back from it") {
  const std::string device = ON_EVERY_DEVICE;
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
  const Sensor sensor = gridSensor(36, 1, elevation, elevation, 1000);
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
  const std::string device = ON_EVERY_DEVICE;
  const double half = kDistance * std::tan(kHalfAngle);
  const auto sharesOf = [&](const std::vector<Mesh>& boards, uint32_t subRays, Effects::Divergence::Shape shape) {
    TestOptions options = footprintsOf(device, subRays, 2 * kHalfAngle);
    options.effects.divergence.profile = Effects::Divergence::Profile::uniform;
    options.effects.divergence.shape = shape;
    options.materials.rows = {{"dull", 0.5f}};
    std::vector<double> powers = powersOf(boards, options);
    for (double& power : powers) power /= 0.5;
    return powers;
  };
  // A board from 0.75 to 1 of the half angles, to the left and up.
  MeshBuilder board;
  board.quad({kDistance, half, 0.75 * half}, {0, -0.25 * half, 0}, {0, 0, 0.25 * half});
  const std::vector<Mesh> corner = {board.take()};
  CHECK(sharesOf(corner, 61, Effects::Divergence::Shape::ellipse)[0] == 0);
  CHECK(sharesOf(corner, 61, Effects::Divergence::Shape::rectangle)[0] == Catch::Approx(1.0 / 64).margin(0.011));
  for (const bool upright : {false, true}) {
    std::vector<Mesh> boards;
    for (const double offset : offsets(21)) boards.push_back(boardUpTo(upright, offset * half));
    for (const uint32_t subRays : {7u, 19u, 61u}) {
      const std::vector<double> shares = sharesOf(boards, subRays, Effects::Divergence::Shape::rectangle);
      double square = 0;
      for (size_t i = 0; i < shares.size(); ++i) square += std::pow(shares[i] - (1 + offsets(21)[i]) / 2, 2);
      CAPTURE(device, upright, subRays);
      CHECK(std::sqrt(square / 21) < 0.6 / subRays);
    }
  }
}

}  // namespace gnosphere::test

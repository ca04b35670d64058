// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <catch2/catch_approx.hpp>
#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <numbers>

#include "common/effects/doppler.h"
#include "common/effects/noise.h"
#include "effects/formula_inputs.hpp"

using namespace gnosphere;
using Catch::Approx;

namespace {

constexpr int kNoiseDraws = 1000000;

Sensor sensorWith(double horizontal, double vertical) {
  Sensor sensor;
  sensor.rangeMax = 100;
  sensor.divergenceHorizontal = horizontal;
  sensor.divergenceVertical = vertical;
  return sensor;
}

}  // namespace

TEST_CASE("range noise has the requested bias and sigma, and sigma grows with the range and its square") {
  Effects effects;
  effects.rangeNoise.bias = 0.05;
  effects.rangeNoise.sigma = 0.02;
  effects.rangeNoise.sigmaPerMetre = 0.001;
  effects.rangeNoise.sigmaPerSquareMetre = 1e-4;
  const gpu::EffectParameters p = effectParameters(effects, sensorWith(0, 0), gpu::kRangeNoise);
  for (const float range : {5.0f, 50.0f}) {
    double sum = 0, squares = 0;
    for (uint32_t beam = 0; beam < kNoiseDraws; ++beam) {
      const float normal = gpu::gaussians(gpu::draw(p, beam, 0, gpu::kRangeNoise)).x;
      const double error = gpu::noisyRange(p, range, 1, normal) - range;
      sum += error;
      squares += (error - 0.05) * (error - 0.05);
    }
    const double sigma = 0.02 + 0.001 * range + 1e-4 * range * range;
    CHECK(std::abs(sum / kNoiseDraws - 0.05) < 5 * sigma / std::sqrt(kNoiseDraws));
    CHECK(std::sqrt(squares / kNoiseDraws) == Approx(sigma).epsilon(5 / std::sqrt(2.0 * kNoiseDraws)));
  }
}

TEST_CASE(
    "the error of weak echoes is inverse to their power, adds in squares, and does not grow below the threshold") {
  Effects effects;
  effects.rangeNoise.sigma = 0.01;
  effects.rangeNoise.sigmaAtThreshold = 0.2;
  effects.detection.reflectance = 0.1;
  effects.detection.range = 50;
  const gpu::EffectParameters p = effectParameters(effects, sensorWith(0, 0), gpu::kRangeNoise);
  const double threshold = 0.1 / (50.0 * 50.0);
  // The error of a normal deviate of 1 is sigma.
  const auto sigma = [&](double power) { return double(gpu::noisyRange(p, 40, float(power), 1)) - 40; };
  for (const double times : {1.0, 2.0, 10.0, 1e3, 1e6})
    CHECK(sigma(times * threshold) == Approx(std::sqrt(0.01 * 0.01 + std::pow(0.2 / times, 2))).margin(5e-6));
  for (const double times : {0.5, 1e-3, 0.0}) CHECK(sigma(times * threshold) == sigma(threshold));
}

TEST_CASE("quantised ranges are multiples of the step, and none is negative") {
  gpu::EffectParameters p = {};
  p.rangeStep = 0.004f;
  for (float range = 0.1f; range < 100; range *= 1.1f) {
    const double steps = gpu::noisyRange(p, range, 1, 0) / 0.004;
    CHECK(std::abs(steps - std::round(steps)) < 1e-6 * steps);
    CHECK(std::abs(gpu::noisyRange(p, range, 1, 0) - range) < 0.00201);
  }
  p.rangeBias = -10;
  CHECK(gpu::noisyRange(p, 5, 1, 0) == 0);
}

TEST_CASE("angular errors have the requested sigma and are at most 4 sigma") {
  Effects effects;
  effects.angleNoise.azimuth = 0.01;
  effects.angleNoise.elevation = 0.002;
  const gpu::EffectParameters p = effectParameters(effects, sensorWith(0, 0), gpu::kAngleNoise);
  double squares[2] = {}, product = 0;
  float widest = 0, highest = 0;
  for (uint32_t beam = 0; beam < kNoiseDraws; ++beam) {
    const gpu::vec2 error = gpu::angleError(p, beam);
    squares[0] += error.x * error.x;
    squares[1] += error.y * error.y;
    product += error.x * error.y;
    widest = std::max(widest, std::abs(error.x));
    highest = std::max(highest, std::abs(error.y));
  }
  CHECK(std::sqrt(squares[0] / kNoiseDraws) == Approx(0.01).epsilon(0.005));
  CHECK(std::sqrt(squares[1] / kNoiseDraws) == Approx(0.002).epsilon(0.005));
  CHECK(std::abs(product / kNoiseDraws) < 5 * 0.01 * 0.002 / std::sqrt(kNoiseDraws));
  CHECK(widest <= 0.04f);
  CHECK(highest <= 0.008f);
  CHECK(widest > 0.035f);  // some of a million draws would be larger and are clamped
  CHECK(highest > 0.007f);
}

TEST_CASE("a beam with angular errors is turned by its angles and stays a unit vector, also at the poles") {
  for (double elevation = -90; elevation <= 90; elevation += 7.5)
    for (double azimuth = -180; azimuth < 180; azimuth += 15) {
      const double e = elevation * std::numbers::pi / 180, a = azimuth * std::numbers::pi / 180;
      const gpu::vec3 direction = {float(std::cos(e) * std::cos(a)), float(std::cos(e) * std::sin(a)),
                                   float(std::sin(e))};
      const gpu::vec3 got = gpu::astray(direction, {0.03f, -0.02f});
      CHECK(std::abs(std::hypot(got.x, got.y, got.z) - 1) < 1e-6);
      if (std::abs(elevation) > 89) continue;
      CHECK(std::abs(got.x - std::cos(e - 0.02) * std::cos(a + 0.03)) < 1e-6);
      CHECK(std::abs(got.y - std::cos(e - 0.02) * std::sin(a + 0.03)) < 1e-6);
      CHECK(std::abs(got.z - std::sin(e - 0.02)) < 1e-6);
    }
}

TEST_CASE("intensity noise has the requested sigma, and no intensity becomes negative") {
  gpu::EffectParameters p = {};
  p.intensitySigma = 0.05f;
  double squares = 0;
  for (uint32_t beam = 0; beam < kNoiseDraws; ++beam) {
    const double error =
        gpu::noisyIntensity(p, 0.5f, gpu::gaussians(gpu::draw(p, beam, 0, gpu::kIntensityNoise)).x) - 0.5;
    squares += error * error;
  }
  CHECK(std::sqrt(squares / kNoiseDraws) == Approx(0.05).epsilon(0.005));
  CHECK(gpu::noisyIntensity(p, 0.1f, -3) == 0);
}

TEST_CASE("the radial speed is positive if the distance grows, whether sensor or target moves") {
  CHECK(gpu::radialSpeed({1, 0, 0}, {3, 5, 7}, {0, 0, 0}) == 3);
  CHECK(gpu::radialSpeed({1, 0, 0}, {0, 0, 0}, {3, 5, 7}) == -3);
  CHECK(gpu::radialSpeed({0, 0.6f, 0.8f}, {9, 10, 0}, {0, 0, 5}) == Approx(2));
}

TEST_CASE("sub-rays fill the footprint evenly: their weights sum to 1 and their mean is the beam") {
  using Profile = Effects::Divergence::Profile;
  using Shape = Effects::Divergence::Shape;
  // Second moment of a disc: 1/4; within the 1/e^2 radius of a Gaussian beam: (1 - 3 e^-2) / (1 - e^-2) / 4. Of a line
  // from -1 to 1: 1/3; with the weights of a Gaussian beam, by parts.
  const double e2 = std::exp(-2.0), line = std::sqrt(std::numbers::pi / 8) * std::erf(std::sqrt(2.0));
  struct Case {
    Shape shape;
    Profile profile;
    double moment;
  };
  for (const Case& one : {Case{Shape::ellipse, Profile::uniform, 0.25},
                          {Shape::ellipse, Profile::gaussian, (1 - 3 * e2) / (1 - e2) / 4},
                          {Shape::rectangle, Profile::uniform, 1 / 3.0},
                          {Shape::rectangle, Profile::gaussian, (1 - e2 / line) / 4}})
    for (uint32_t count = 1; count <= 61; ++count) {
      INFO(int(one.shape) << ", " << int(one.profile) << ", " << count << " sub-rays");
      Effects effects;
      effects.divergence.subRays = count;
      effects.divergence.profile = one.profile;
      effects.divergence.shape = one.shape;
      const auto rays = subRays(effects, sensorWith(3e-3, 1.5e-3), gpu::kDivergence);
      REQUIRE(rays.size() == count);
      double weight = 0, u = 0, v = 0, uu = 0, vv = 0;
      for (const SubRay& ray : rays) {
        const double x = ray.u / std::tan(1.5e-3), y = ray.v / std::tan(0.75e-3);
        if (one.shape == Shape::ellipse) CHECK(x * x + y * y <= 1);
        CHECK(std::max(std::abs(x), std::abs(y)) < 1.002);  // 20 of a rectangle are moved beyond its edge by 0.2 %
        weight += ray.weight;
        u += ray.weight * x;
        v += ray.weight * y;
        uu += ray.weight * x * x;
        vv += ray.weight * y * y;
      }
      CHECK(weight == Approx(1).epsilon(1e-6));
      CHECK(std::abs(u) < 1e-6);
      CHECK(std::abs(v) < 1e-6);
      if (count < 19) continue;
      CHECK(uu == Approx(one.moment).epsilon(0.07));
      CHECK(vv == Approx(one.moment).epsilon(0.07));
    }
}

TEST_CASE("without divergence there is one sub-ray along the beam") {
  const auto rays = subRays({}, sensorWith(3e-3, 3e-3), 0);
  REQUIRE(rays.size() == 1);
  CHECK(rays[0].u == 0);
  CHECK(rays[0].v == 0);
  CHECK(rays[0].weight == 1);
}

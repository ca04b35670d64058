// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <catch2/catch_approx.hpp>
#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <numbers>

#include "common/effects/detection.h"
#include "common/effects/incidence.h"
#include "common/effects/intensity.h"
#include "common/effects/random.h"
#include "common/effects/vector.h"
#include "effects/formula_inputs.hpp"

using namespace gnosphere;
using Catch::Approx;

namespace {

gpu::Optics4 optics(float reflectance, float gloss = 0, float roughness = 1, float retro = 0) {
  return {{reflectance, gloss, roughness, retro}, {0, 0, 0}, gpu::kNone};
}

Sensor sensorTo(double rangeMax) {
  Sensor sensor;
  sensor.rangeMax = rangeMax;
  return sensor;
}

/// Share of the incident light that the lobe reflects in a direction, in double: GGX with Smith shadowing, without
/// Fresnel. For every direction it is positive and at most 1.
double lobeTowards(double alpha, double cosineIn, double cosineOut, double azimuth) {
  const double sineIn = std::sqrt(1 - cosineIn * cosineIn), sineOut = std::sqrt(1 - cosineOut * cosineOut);
  const double x = sineIn + sineOut * std::cos(azimuth), y = sineOut * std::sin(azimuth), z = cosineIn + cosineOut;
  const double square = alpha * alpha, halfway = z * z / (x * x + y * y + z * z);
  const double t = halfway * (square - 1) + 1;
  const double distribution = square / (std::numbers::pi * t * t);
  const auto lambda = [&](double cosine) {
    return (-1 + std::sqrt(1 + square * (1 - cosine * cosine) / (cosine * cosine))) / 2;
  };
  return distribution / (1 + lambda(cosineIn) + lambda(cosineOut)) / (4 * cosineIn * cosineOut);
}

}  // namespace

TEST_CASE("a tilted Lambertian plate returns reflectance * cosine / range^2, within 1e-6") {
  for (const double reflectance : {0.05, 0.1, 0.5, 1.0})
    for (double degrees = 0; degrees < 89.5; degrees += 1)
      for (double range = 0.3; range < 300; range *= 1.5) {
        const double cosine = std::cos(degrees * std::numbers::pi / 180);
        const float energy = gpu::reflected(optics(float(reflectance)), float(cosine));
        const double expected = reflectance * cosine / (range * range);
        REQUIRE(gpu::received(energy, float(range), 0) == Approx(expected).epsilon(1e-6));
        // The back is equally bright.
        REQUIRE(gpu::reflected(optics(float(reflectance)), float(-cosine)) == energy);
      }
}

TEST_CASE("a Lambertian surface of reflectance 1 at normal incidence and 1 m returns 1") {
  CHECK(gpu::received(gpu::reflected(optics(1), 1), 1, 0) == Approx(1).epsilon(1e-6));
}

TEST_CASE("angles of incidence are right to 1e-6, also where their cosines are all 1") {
  for (const double angle : {0.0, 1e-6, 1e-4, 3e-4, 1e-3, 0.1, 0.44, 0.46, 0.8, 1.2, 1.57})
    for (const double turn : {0.0, 0.7, 2.0}) {
      const double length = 37.5, s = std::sin(angle), c = std::cos(angle);
      const glm::vec3 along(length * c, length * s * std::cos(turn), length * s * std::sin(turn));
      INFO(angle);
      CHECK(gpu::incidenceOf({-1, 0, 0}, along, float(length)) == Approx(angle).margin(1e-6));
    }
}

TEST_CASE("normals are unit vectors towards the sensor, also those of triangles without area") {
  for (const float size : {1e-14f, 1.0f, 1e18f})
    for (const glm::vec3& normal : {glm::vec3(0, 0, size), glm::vec3(0, 0, -size)}) {
      const glm::vec3 unit = gpu::unitTowardsOrigin(normal, {3, 4, 12});
      CHECK((unit.x == 0 && unit.y == 0 && unit.z == Approx(-1).epsilon(1e-6)));
    }
  const glm::vec3 facing = gpu::unitTowardsOrigin({0, 0, 0}, {3, 4, 12});
  CHECK(facing.x == Approx(-3 / 13.0).epsilon(1e-6));
  CHECK(facing.y == Approx(-4 / 13.0).epsilon(1e-6));
  CHECK(facing.z == Approx(-12 / 13.0).epsilon(1e-6));
}

TEST_CASE("the glossy lobe is GGX in the direction of the light source, brightest at normal incidence") {
  for (const double roughness : {0.3, 0.5, 0.8, 1.0}) {
    const double alpha = std::max(roughness * roughness, double(gpu::kLeastGloss));
    for (double degrees = 0; degrees <= 85; degrees += 5) {
      const double cosine = std::cos(degrees * std::numbers::pi / 180);
      const double expected = std::numbers::pi * cosine * lobeTowards(alpha, cosine, cosine, 0);
      const float got = gpu::glossyLobe(float(cosine), float(roughness));
      CHECK(got == Approx(expected).epsilon(1e-4));
      CHECK(got <= gpu::glossyLobe(1, float(roughness)) * 1.00001f);
    }
    // The lobe must not reflect more light than arrives.
    double sent = 0;
    const int steps = 400;
    for (int i = 0; i < steps; ++i)
      for (int j = 0; j < steps; ++j) {
        const double cosine = (i + 0.5) / steps;
        sent += cosine * lobeTowards(alpha, 0.8, cosine, 2 * std::numbers::pi * (j + 0.5) / steps);
      }
    sent *= 2 * std::numbers::pi / (double(steps) * steps);
    CHECK(sent < 1.01);
    CHECK(sent > 0.3);
  }
  CHECK(std::isfinite(gpu::glossyLobe(0, 0)));
}

TEST_CASE("a retro-reflector is brighter than a Lambertian surface by its gain") {
  CHECK(gpu::reflected(optics(0, 0, 1, 300), 0.5f) == Approx(300 * gpu::reflected(optics(1), 0.5f)));
}

TEST_CASE("the scales of intensity have the documented values") {
  gpu::EffectParameters p = {};
  p.intensityScale = gpu::kScaleRaw;
  CHECK(gpu::scaled(p, 0.2f, 10) == Approx(0.002));
  p.intensityScale = gpu::kScaleUnit;
  CHECK(gpu::scaled(p, 0.2f, 10) == 0.2f);
  CHECK(gpu::scaled(p, 7, 10) == 1);
  p.intensityScale = gpu::kScaleByte;
  CHECK(gpu::scaled(p, 0, 10) == 0);
  CHECK(gpu::scaled(p, 0.1f, 10) == 10);
  CHECK(gpu::scaled(p, 1, 10) == 100);
  CHECK(gpu::scaled(p, 10, 10) == std::round(100 + 155.0 / 3));
  CHECK(gpu::scaled(p, 1000, 10) == 255);
  CHECK(gpu::scaled(p, 1e6f, 10) == 255);
}

TEST_CASE("CARLA's intensity is exp(-attenuation * range) for every surface") {
  Effects effects;
  effects.intensity.model = Effects::Intensity::Model::carla;
  const gpu::EffectParameters p = effectParameters(effects, sensorTo(100), gpu::kIntensity);
  for (const float range : {1.0f, 10.0f, 50.0f})
    for (const float energy : {0.01f, 1.0f})
      CHECK(gpu::unitIntensity(p, energy, range, 0) == Approx(std::exp(-0.004 * range)).epsilon(1e-6));
}

TEST_CASE("a target of 10 % at the sensor's range is just detected; one of 9.9 % or farther away is not") {
  for (const double rangeMax : {30.0, 100.0, 120.0, 173.0, 200.0}) {
    const gpu::EffectParameters p = effectParameters({}, sensorTo(rangeMax), gpu::kDetection);
    const auto seen = [&](float reflectance, double range) {
      return gpu::detected(p, gpu::received(gpu::reflected(optics(reflectance), 1), float(range), 0), 0.5f);
    };
    CHECK(seen(0.1f, rangeMax));
    CHECK_FALSE(seen(0.099f, rangeMax));
    CHECK_FALSE(seen(0.1f, rangeMax * 1.001));
    CHECK(seen(0.4f, rangeMax * 1.999));
    CHECK_FALSE(seen(0.0f, 1));
  }
}

TEST_CASE("a soft threshold is a logistic curve in ln power: half of the targets at the threshold are detected") {
  Effects effects;
  effects.detection.softness = 0.3;
  const gpu::EffectParameters p = effectParameters(effects, sensorTo(100), gpu::kDetection);
  for (double logPower = -3; logPower <= 3; logPower += 0.25) {
    const float power = float(p.threshold * std::exp(logPower));
    const double expected = 1 / (1 + std::exp(-logPower / 0.3));
    CHECK(gpu::detectionProbability(power, p.threshold, p.softness) == Approx(expected).epsilon(1e-4));
    int seen = 0;
    const int draws = 100000;
    for (uint32_t beam = 0; beam < draws; ++beam)
      seen += gpu::detected(p, power, gpu::uniform01(gpu::draw(p, beam, 0, gpu::kDetection).x));
    CHECK(std::abs(seen - expected * draws) < 5 * std::sqrt(draws * expected * (1 - expected)) + 1);
  }
}

TEST_CASE("drop-out falls linearly from its rate at intensity 0 to none at the limit") {
  Effects effects;
  effects.dropOut.generalRate = 0.45;
  effects.dropOut.intensityLimit = 0.8;
  effects.dropOut.zeroIntensityRate = 0.4;
  const gpu::EffectParameters p = effectParameters(effects, sensorTo(100), gpu::kDropOut);
  const int draws = 200000;
  for (const double unit : {0.0, 0.2, 0.4, 0.6, 0.79, 0.81, 1.0}) {
    int lost = 0, beams = 0;
    for (uint32_t beam = 0; beam < draws; ++beam) {
      lost += gpu::returnDropped(p, float(unit), gpu::uniform01(gpu::draw(p, beam, 1, gpu::kDropOut).x));
      beams += gpu::beamDropped(p, gpu::uniform01(gpu::draw(p, beam, 0, gpu::kDropOut).x));
    }
    const double expected = unit < 0.8 ? 0.4 * (1 - unit / 0.8) : 0;
    CHECK(std::abs(lost - expected * draws) <= 5 * std::sqrt(draws * expected * (1 - expected)));
    CHECK(std::abs(beams - 0.45 * draws) < 5 * std::sqrt(draws * 0.45 * 0.55));
  }
}

// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <catch2/catch_approx.hpp>
#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <iterator>
#include <vector>

#include "effects/beam_signal.hpp"
#include "effects/formula_inputs.hpp"

using namespace gnosphere;
using Catch::Approx;
using Mode = Effects::Returns::Mode;

namespace {

Sensor sensorOf(uint32_t maxReturns = 1) {
  Sensor sensor;
  sensor.columns = 1000;
  sensor.channels = {{0, 0}};
  sensor.rangeMin = 0.5;
  sensor.rangeMax = 100;
  sensor.maxReturns = maxReturns;
  return sensor;
}

struct Beam {
  uint32_t cause = 0, count = 0;
  std::vector<gpu::Return> returns;
};

/// An echo of a Lambertian target of this reflectance.
gpu::Echo echoAt(float range, float reflectance, uint32_t index) {
  return {range, reflectance, 0.5f, 1, index};
}

/// The last of the echoes is that of an opaque surface.
Beam run(const Effects& effects, uint32_t planned, std::vector<gpu::Echo> echoes, uint32_t beam = 0,
         const Sensor& sensor = sensorOf()) {
  if (!echoes.empty()) echoes.back().light = 0;
  const gpu::EffectParameters p = effectParameters(effects, sensor, planned);
  const std::vector<uint32_t> dead = deadBeamBits(effects, sensor);
  const std::vector<gpu::VolumeBox> volumes = volumeBoxes(effects, {});
  Beam result;
  result.returns.resize(p.returnsPerBeam);
  gpu::BeamSignal signal;
  signal.EFFECTS = planned;
  signal.echoes = echoes;
  signal.returns = result.returns;
  signal.volumes = volumes;
  signal.deadBeams = dead;
  result.cause = signal.signalsOf(p, beam, {1, 0, 0}, uint32_t(echoes.size()), result.count);
  return result;
}

}  // namespace

TEST_CASE("every mode returns the echoes of its name, in order of range") {
  // The order of strength is 2, 0, 3, 1.
  const std::vector<gpu::Echo> echoes = {echoAt(10, 0.2f, 7), echoAt(20, 0.1f, 8), echoAt(30, 5, 9), echoAt(40, 1, 10)};
  struct Row {
    Mode mode;
    std::vector<uint32_t> indices;
  };
  const Row rows[] = {{Mode::first, {7}},
                      {Mode::second, {8}},
                      {Mode::last, {10}},
                      {Mode::strongest, {9}},
                      {Mode::secondStrongest, {7}},
                      {Mode::firstSecond, {7, 8}},
                      {Mode::firstLast, {7, 10}},
                      {Mode::firstStrongest, {7, 9}},
                      {Mode::lastStrongest, {9, 10}},
                      {Mode::strongestSecondStrongest, {7, 9}},
                      {Mode::all, {7, 8, 9}},
                      {Mode::dual, {9, 10}}};
  for (const Row& row : rows) {
    Effects effects;
    effects.returns.mode = row.mode;
    const Beam beam = run(effects, gpu::kReturns | gpu::kIntensity, echoes, 0, sensorOf(3));
    INFO("mode " << int(row.mode));
    CHECK(beam.cause == gpu::kCauseReturned);
    REQUIRE(beam.count == row.indices.size());
    REQUIRE(beam.returns.size() == row.indices.size());
    for (uint32_t j = 0; j < beam.count; ++j) {
      CHECK(beam.returns[j].echo == row.indices[j]);
      CHECK(beam.returns[j].range == echoes[row.indices[j] - 7].range);
      CHECK(beam.returns[j].number == j + 1);
      CHECK(beam.returns[j].count == beam.count);
      CHECK(beam.returns[j].label == gpu::kLabelSolid);
    }
  }
}

// Velodyne, VLP-16 user manual 63-9243: "If the strongest return is also the last return, then the second-strongest
// return is provided."
TEST_CASE("dual returns are the last and the strongest, or the second strongest if these are one") {
  Effects effects;
  effects.returns.mode = Mode::dual;
  const auto indices = [&](std::vector<float> strengths) {
    std::vector<gpu::Echo> echoes;
    for (const float strength : strengths)
      echoes.push_back(echoAt(10 * float(echoes.size() + 1), strength, uint32_t(echoes.size())));
    const Beam beam = run(effects, gpu::kReturns | gpu::kIntensity, echoes, 0, sensorOf(2));
    std::vector<uint32_t> found;
    for (uint32_t j = 0; j < beam.count; ++j) found.push_back(beam.returns[j].echo);
    return found;
  };
  using Found = std::vector<uint32_t>;
  CHECK(indices({0.1f, 0.9f, 9}) == Found{1, 2});  // powers fall with the square of the range
  CHECK(indices({0.1f, 0.2f, 9}) == Found{0, 2});
  CHECK(indices({0.1f, 2, 9}) == Found{1, 2});
  CHECK(indices({0.9f, 0.1f, 0.1f}) == Found{0, 2});
  CHECK(indices({0.9f}) == Found{0});
}

TEST_CASE("a single echo is returned once in every mode of two returns, and the other return is empty") {
  for (const Mode mode :
       {Mode::firstLast, Mode::lastStrongest, Mode::strongestSecondStrongest, Mode::all, Mode::dual}) {
    Effects effects;
    effects.returns.mode = mode;
    const Beam beam = run(effects, gpu::kReturns, {echoAt(10, 0.2f, 0)}, 0, sensorOf(2));
    REQUIRE(beam.returns.size() == 2);
    CHECK(beam.count == 1);
    CHECK(beam.returns[0].echo == 0);
    CHECK(std::isnan(beam.returns[1].range));
    CHECK(beam.returns[1].echo == gpu::kNone);
    CHECK(beam.returns[1].label == gpu::kLabelNone);
    CHECK(beam.returns[1].number == 0);
  }
  Effects effects;
  effects.returns.mode = Mode::second;
  CHECK(run(effects, gpu::kReturns, {echoAt(10, 0.2f, 0)}).count == 0);
}

TEST_CASE("a beam whose mode names an echo that it does not have has the cause not chosen") {
  Effects effects;
  for (const Mode mode : {Mode::second, Mode::secondStrongest}) {
    effects.returns.mode = mode;
    const uint32_t planned = gpu::kReturns | gpu::kDetection;
    const gpu::Echo weak = echoAt(90, 0.001f, 1);
    CHECK(run(effects, planned, {echoAt(10, 0.5f, 0)}).cause == gpu::kCauseNotChosen);
    CHECK(run(effects, planned, {echoAt(10, 0.5f, 0), weak}).cause == gpu::kCauseNotChosen);
    CHECK(run(effects, planned, {echoAt(10, 0.5f, 0), echoAt(20, 0.5f, 1)}).cause == gpu::kCauseReturned);
    CHECK(run(effects, planned, {weak}).cause == gpu::kCauseWeak);
    CHECK(run(effects, planned, {}).cause == gpu::kCauseNoSurface);
  }
}

TEST_CASE("of two equally strong echoes the nearer is returned; without `returns` the strongest is returned") {
  CHECK(run({}, gpu::kDivergence, {echoAt(10, 1, 0), echoAt(20, 4, 1)}).returns[0].echo == 0);
  CHECK(run({}, gpu::kDivergence, {echoAt(10, 1, 0), echoAt(20, 4.1f, 1)}).returns[0].echo == 1);
}

TEST_CASE("every cause occurs as documented") {
  Effects effects;
  effects.dropOut.deadBeams = {3, 40};
  const std::vector<gpu::Echo> good = {echoAt(50, 0.5f, 0)}, weak = {echoAt(90, 0.05f, 0)};
  const uint32_t planned = gpu::kDetection | gpu::kDropOut;
  CHECK(run(effects, planned, good).cause == gpu::kCauseReturned);
  CHECK(run(effects, planned, {}).cause == gpu::kCauseNoSurface);
  CHECK(run(effects, planned, weak).cause == gpu::kCauseWeak);
  CHECK(run(effects, planned, good, 3).cause == gpu::kCauseDead);
  CHECK(run(effects, planned, good, 40).cause == gpu::kCauseDead);
  CHECK(run(effects, planned, {}, 3).cause == gpu::kCauseDead);
  CHECK(run(effects, gpu::kDetection, good, 3).cause == gpu::kCauseReturned);

  effects.dropOut.generalRate = 1;
  CHECK(run(effects, planned, good).cause == gpu::kCauseDroppedOut);
  CHECK(run(effects, planned, {}).cause == gpu::kCauseNoSurface);
  CHECK(run(effects, planned | gpu::kFog, {}).cause == gpu::kCauseDroppedOut);
  effects.dropOut.generalRate = 0;
  effects.dropOut.zeroIntensityRate = 1;
  CHECK(run(effects, planned, {echoAt(50, 0.0f, 0)}).cause == gpu::kCauseWeak);
  CHECK(run(effects, gpu::kDropOut, {echoAt(50, 0.0f, 0)}).cause == gpu::kCauseDroppedOut);
  CHECK(run(effects, gpu::kDropOut, {echoAt(50, 1.0f, 0)}).cause == gpu::kCauseReturned);

  Effects fog;
  fog.fog.visibility = 20;
  int attenuated = 0, weakInFog = 0;
  for (uint32_t beam = 0; beam < 100; ++beam) {
    const Beam seen = run(fog, gpu::kFog, good, beam), unseen = run(fog, gpu::kFog, weak, beam);
    attenuated += seen.cause == gpu::kCauseAttenuated;
    weakInFog += unseen.cause == gpu::kCauseWeak;
    // Only the fog itself is visible.
    if (seen.cause == gpu::kCauseReturned) CHECK(seen.returns[0].label == gpu::kLabelScatter);
    // The fog is the cause also if the beam has met a surface before that is too weak without it.
    CHECK(run(fog, gpu::kFog, {echoAt(40, 0.01f, 0), echoAt(50, 0.5f, 1)}, beam).cause == seen.cause);
  }
  CHECK(attenuated > 0);
  CHECK(weakInFog > 0);
}

TEST_CASE("an echo of the medium is returned as its own return, in order of range before the surface") {
  Effects effects;
  effects.fog.visibility = 60;
  effects.returns.mode = Mode::all;
  effects.returns.count = 3;
  int scattered = 0;
  for (uint32_t i = 0; i < 1000; ++i) {
    const Beam beam =
        run(effects, gpu::kFog | gpu::kReturns | gpu::kIntensity, {echoAt(2, 0.01f, 0), echoAt(12, 0.9f, 1)}, i);
    float before = 0;
    uint32_t solids = 0;
    for (uint32_t j = 0; j < beam.count; ++j) {
      const gpu::Return& value = beam.returns[j];
      CHECK(value.range >= before);
      before = value.range;
      if (value.label == gpu::kLabelSolid) {
        ++solids;
        continue;
      }
      ++scattered;
      CHECK(value.label == gpu::kLabelScatter);
      CHECK(value.echo == gpu::kNone);
      CHECK(value.range < 12 - effects.returns.separation);
      CHECK(value.range >= 0.5);
    }
    CHECK(solids == 2);
  }
  CHECK(scattered > 100);
}

TEST_CASE("an echo of the medium close to any surface is part of the echo of that surface") {
  Effects effects;
  effects.fog.visibility = 30;
  effects.returns.mode = Mode::all;
  effects.returns.count = 3;
  effects.returns.separation = 0.7;
  int scattered = 0;
  for (uint32_t i = 0; i < 3000; ++i) {
    const Beam beam =
        run(effects, gpu::kFog | gpu::kReturns | gpu::kIntensity, {echoAt(4, 0.1f, 0), echoAt(9, 0.9f, 1)}, i);
    REQUIRE(beam.count >= 2);
    for (uint32_t j = 0; j < beam.count; ++j) scattered += beam.returns[j].label == gpu::kLabelScatter;
    for (uint32_t j = 1; j < beam.count; ++j) CHECK(beam.returns[j].range - beam.returns[j - 1].range > 0.7f);
  }
  CHECK(scattered > 300);
}

// The surface is not detected by itself, so no echo of it can hide that of the fog.
TEST_CASE("an echo of the medium close to a surface that returns nothing counts alone") {
  Effects effects;
  effects.fog.visibility = 200;
  effects.detection = {EffectUse::on, 0.001, 100000, 0};  // any light is enough
  const double share = 1 - std::exp(-2 * std::log(20.0) / 200 * (60 - 0.5));
  for (const double separation : {0.0, 10.0, 100.0}) {
    effects.returns.separation = separation;
    int black = 0, grey = 0;
    for (uint32_t i = 0; i < 5000; ++i) {
      const auto scatters = [&](float reflectance) {
        const Beam beam = run(effects, gpu::kFog | gpu::kDetection, {echoAt(60, reflectance, 0)}, i);
        return beam.count > 0 && beam.returns[0].label == gpu::kLabelScatter;
      };
      black += scatters(0);
      grey += scatters(0.5f);
    }
    CAPTURE(separation);
    CHECK(std::abs(black - 5000 * share) < 4 * std::sqrt(5000 * share * (1 - share)));
    if (separation == 100) CHECK(grey == 0);
  }
}

TEST_CASE("a beam that hits no surface may return an echo of the fog") {
  Effects effects;
  effects.fog.visibility = 30;
  int seen = 0;
  for (uint32_t i = 0; i < 1000; ++i) {
    const Beam beam = run(effects, gpu::kFog, {}, i);
    CHECK(beam.cause == (beam.count > 0 ? gpu::kCauseReturned : gpu::kCauseNoSurface));
    seen += beam.count > 0;
  }
  CHECK(seen > 100);
}

TEST_CASE("noise changes the range and keeps the true range") {
  Effects effects;
  effects.rangeNoise.sigma = 0.1;
  int moved = 0;
  for (uint32_t i = 0; i < 100; ++i) {
    const Beam beam = run(effects, gpu::kRangeNoise, {echoAt(10, 0.5f, 0)}, i);
    CHECK(beam.returns[0].trueRange == 10);
    moved += beam.returns[0].range != 10;
  }
  CHECK(moved > 95);
}

TEST_CASE("the formulas draw the same random numbers for an effect, whether others are on or off") {
  Effects effects;
  effects.rangeNoise.sigma = 0.1;
  effects.intensityNoise.sigma = 0.05;
  effects.dropOut.generalRate = 0.3;
  effects.detection.softness = 0.5;
  effects.fog.visibility = 1000;
  effects.rain.rate = 5;
  effects.returns.mode = Mode::last;
  const std::vector<gpu::Echo> echoes = {echoAt(20, 0.3f, 0), echoAt(60, 0.9f, 1)};
  const uint32_t noise = gpu::kRangeNoise | gpu::kIntensityNoise | gpu::kIntensity | gpu::kReturns;
  const uint32_t others[] = {gpu::kDropOut, gpu::kDetection, gpu::kFog, gpu::kRain, gpu::kAngleNoise};
  int compared[std::size(others)] = {};
  for (uint32_t i = 0; i < 2000; ++i) {
    const Beam plain = run(effects, noise, echoes, i);
    for (size_t k = 0; k < std::size(others); ++k) {
      const uint32_t other = others[k];
      const Beam beam = run(effects, noise | other, echoes, i);
      if (beam.count == 0 || beam.returns[0].echo != plain.returns[0].echo) continue;
      ++compared[k];
      CHECK(beam.returns[0].range == plain.returns[0].range);
      if ((other & gpu::kMediumEffects) == 0) CHECK(beam.returns[0].intensity == plain.returns[0].intensity);
    }
    CHECK(run(effects, gpu::kDropOut, echoes, i).cause == run(effects, gpu::kDropOut | noise, echoes, i).cause);
  }
  for (const int beams : compared) CHECK(beams > 500);
}

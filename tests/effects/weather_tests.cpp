// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <catch2/catch_approx.hpp>
#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <numbers>
#include <vector>

#include "effects/beam_signal.hpp"
#include "effects/formula_inputs.hpp"
#include "effects/particles.hpp"

using namespace gnosphere;
using Catch::Approx;

namespace {

constexpr uint32_t kBeams = 200000;

Sensor sensorUpTo(double rangeMax) {
  Sensor sensor;
  sensor.rangeMin = 0.5;
  sensor.rangeMax = rangeMax;
  return sensor;
}

/// Integrates over first..last in many steps.
template <typename Call>
double integral(double first, double last, Call&& call) {
  const int steps = 20000;
  double sum = 0;
  for (int i = 0; i < steps; ++i) sum += call(first + (last - first) * (i + 0.5) / steps);
  return sum * (last - first) / steps;
}

/// Expected number of detected drops at a rain rate up to a range, integrated over range and drop size.
double dropsSeen(const gpu::EffectParameters& p, const DropSizes& sizes, double range) {
  return integral(p.rangeMin, range, [&](double r) {
    const double across = gpu::kApertureDiameter + p.spreadHorizontal * r;
    const double focus = std::min(1.0, r * r / (gpu::kFocusRange * gpu::kFocusRange));
    const double clear = sizes.reflectance * focus / (r * r) * std::exp(-2 * p.extinction * r);
    const double least = across * std::sqrt(p.threshold / clear);
    if (least > across) return 0.0;
    return std::numbers::pi / 4 * across * across * sizes.intercept / sizes.slope * std::exp(-sizes.slope * least);
  });
}

/// The echo of the first drop or flake of a beam.
gpu::Echo firstParticle(const gpu::EffectParameters& p, const gpu::Particles& particles, float far, uint32_t beam,
                        uint32_t effect) {
  const glm::uvec4 words = gpu::draw(p, beam, 0, effect);
  return gpu::particleEcho(p, particles, gpu::countUpToNext(gpu::countBefore(p, particles), words), far, words);
}

}  // namespace

TEST_CASE("contrast falls to 5 % at the visibility") {
  for (const double visibility : {10.0, 50.0, 200.0, 10000.0})
    CHECK(std::exp(-fogExtinction(visibility, 550) * visibility) == Approx(0.05));
  CHECK(fogExtinction(0, 905) == 0);
  // Extinction relative to that at 550 nm, by hand from the exponents 0, 0.25, 0.66, 1.3 and 1.6.
  const auto ratio = [](double visibility, double wavelength) {
    return fogExtinction(visibility, wavelength) / fogExtinction(visibility, 550);
  };
  CHECK(ratio(400, 1550) == 1);
  CHECK(ratio(750, 905) == Approx(0.88293).epsilon(1e-4));
  CHECK(ratio(2000, 905) == Approx(0.71987).epsilon(1e-4));
  CHECK(ratio(2000, 1550) == Approx(0.50469).epsilon(1e-4));
  CHECK(ratio(20e3, 1550) == Approx(0.26004).epsilon(1e-4));
  CHECK(ratio(60e3, 905) == Approx(0.45076).epsilon(1e-4));
}

TEST_CASE("rain and snow attenuate as ITU-R P.1814 states, in dB per km") {
  const auto decibels = [](double extinction) { return extinction * 1000 * 10 / std::numbers::ln10; };
  CHECK(decibels(rainExtinction(1)) == Approx(1.076));
  CHECK(decibels(rainExtinction(25)) == Approx(9.30).epsilon(0.001));
  CHECK(decibels(snowExtinction(1, 1550)) == Approx(5.5799).epsilon(1e-4));
  CHECK(decibels(snowExtinction(2, 905)) == Approx(14.433).epsilon(1e-3));
  // The drops of Marshall and Palmer, which extinguish twice their area, agree within the spread of such laws.
  for (const double rate : {2.0, 10.0, 50.0}) {
    const DropSizes drops = rainDrops(rate);
    const double area = 2 * std::numbers::pi / 4 * drops.intercept * 2 / std::pow(drops.slope, 3);
    CHECK(area / rainExtinction(rate) > 0.7);
    CHECK(area / rainExtinction(rate) < 2);
  }
}

TEST_CASE("the power of a surface in fog falls by exp(-2 extinction range)") {
  Effects effects;
  effects.fog.visibility = 100;
  const gpu::EffectParameters p = effectParameters(effects, sensorUpTo(200), gpu::kFog);
  gpu::BeamSignal beam;
  beam.EFFECTS = gpu::kFog;
  for (const float range : {1.0f, 30.0f, 100.0f}) {
    const double expected = 0.3 / (range * range) * std::exp(-2 * -std::log(0.05) / 100 * range);
    CHECK(gpu::received(0.3f, range, beam.depthOf(p, {1, 0, 0}, range)) == Approx(expected).epsilon(1e-5));
  }
}

TEST_CASE("echoes of fog have depths distributed as exp(-2 extinction depth), and the lidar equation's power") {
  Effects effects;
  effects.fog.visibility = 80;
  const gpu::EffectParameters p = effectParameters(effects, sensorUpTo(150), gpu::kFog);
  const double extinction = -std::log(0.05) / 80;
  const double backScatter = std::numbers::pi * extinction / 18.8 * 5e-9 * 299792458 / 2;
  const float near = 0.5f, far = 40;
  const int bins = 20;
  std::vector<double> counts(bins, 0.0), strengths(bins, 0.0), squares(bins, 0.0);
  for (uint32_t beam = 0; beam < kBeams; ++beam) {
    const auto echoBefore = [&](float end) {
      return gpu::scatterEcho(p, p.fogExtinction, p.fogScatter, near, end, gpu::draw(p, beam, 0, gpu::kFog),
                              gpu::draw(p, beam, 1, gpu::kFog));
    };
    const gpu::Echo echo = echoBefore(far), sooner = echoBefore(far / 2);
    // The end of the fog does not change an echo before it.
    CHECK(sooner.range == (echo.range < far / 2 ? echo.range : gpu::kNever));
    if (echo.range == gpu::kNever) continue;
    REQUIRE(echo.range >= near);
    REQUIRE(echo.range < far);
    const auto bin = size_t(std::min((echo.range - near) / (far - near) * bins, bins - 1.0f));
    const double focus = std::min(1.0, echo.range * echo.range / 25.0);
    counts[bin] += 1;
    strengths[bin] += echo.energy / (backScatter * focus);
    squares[bin] += std::pow(echo.energy / (backScatter * focus) - 1, 2);
  }
  const auto share = [&](double range) { return 1 - std::exp(-2 * extinction * (range - near)); };
  for (int i = 0; i < bins; ++i) {
    const double width = (far - near) / bins;
    const double expected = kBeams * (share(near + width * (i + 1)) - share(near + width * i));
    CHECK(std::abs(counts[i] - expected) < 5 * std::sqrt(expected));
    CHECK(strengths[i] / counts[i] == Approx(1).margin(5 * 0.5 / std::sqrt(counts[i])));
    CHECK(squares[i] / counts[i] == Approx(0.25).epsilon(0.3));
  }
}

TEST_CASE("the medium takes the wavelength and the length of the pulse from the request") {
  Effects effects;
  effects.intensity.wavelength = 1550;
  effects.returns.pulseWidth = 8e-9;
  effects.fog.visibility = 2000;
  effects.snow.rate = 1;
  effects.volumes.boxes = {{{0, -1, -1}, {1, 1, 1}, 0.2}};
  const double fog = -std::log(0.05) / 2000 * std::pow(1550.0 / 550, -0.66);
  const double snow = 5.5799 * std::numbers::ln10 / 10 / 1000, pulse = 8e-9 * 299792458 / 2;
  const gpu::EffectParameters p = effectParameters(effects, sensorTo(150), gpu::kFog | gpu::kSnow);
  CHECK(p.fogExtinction == Approx(fog).epsilon(1e-6));
  CHECK(p.extinction == Approx(fog + snow).epsilon(1e-4));
  CHECK(p.fogScatter == Approx(std::numbers::pi * fog / 18.8 * pulse).epsilon(1e-6));
  CHECK(volumeBoxes(effects, {})[0].scatter == Approx(std::numbers::pi * 0.2 / 55 * pulse).epsilon(1e-6));
}

TEST_CASE("fog without an extent or an extinction returns no echo") {
  const gpu::EffectParameters p = {};
  const glm::uvec4 words = gpu::draw(p, 0, 0, gpu::kFog);
  CHECK(gpu::scatterEcho(p, 0.01f, 0.01f, 5, 5, words, words).range == gpu::kNever);
  CHECK(gpu::scatterEcho(p, 0, 0.01f, 1, 5, words, words).range == gpu::kNever);
}

TEST_CASE("rain and snow are Poisson processes: the first echo is distributed by the expected number") {
  struct Weather {
    double rain, snow;
  };
  for (const Weather& weather : {Weather{20, 0}, Weather{0, 1.5}}) {
    Effects effects;
    effects.rain.rate = weather.rain;
    effects.snow.rate = weather.snow;
    const bool raining = weather.rain > 0;
    const uint32_t planned = raining ? gpu::kRain : gpu::kSnow;
    const gpu::EffectParameters p = effectParameters(effects, sensorUpTo(120), planned);
    const gpu::Particles& particles = raining ? p.rain : p.snow;
    const DropSizes sizes = raining ? rainDrops(weather.rain) : snowFlakes(weather.snow);
    std::vector<float> ranges;
    int weak = 0;
    for (uint32_t beam = 0; beam < kBeams; ++beam) {
      const gpu::Echo echo = firstParticle(p, particles, 120, beam, planned);
      if (echo.range == gpu::kNever) continue;
      ranges.push_back(echo.range);
      weak += !gpu::detected(p, gpu::received(echo.energy, echo.range, p.extinction * echo.range), 0);
    }
    CHECK(weak <= int(ranges.size() / 1000));
    CHECK(ranges.size() > kBeams / 100);
    std::sort(ranges.begin(), ranges.end());
    // Between two entries of the table the distribution is interpolated: the density is right within a fifth where
    // echoes are not rare.
    double before = 0, seenBefore = 0;
    for (uint32_t i = 1; i <= gpu::kParticleRanges; ++i)
      for (int part = 1; part <= 4; ++part) {
        const float start = gpu::rangeOf(particles, i - 1), end = gpu::rangeOf(particles, i);
        const float range = start + (end - start) * float(part) / 4;
        const double expected = kBeams * (1 - std::exp(-dropsSeen(p, sizes, range)));
        const auto seen = double(std::lower_bound(ranges.begin(), ranges.end(), range) - ranges.begin());
        INFO((raining ? "rain" : "snow") << " up to " << range << " m");
        CHECK(std::abs(seen - expected) < 5 * std::sqrt(expected) + (part == 4 ? 0.002 : 0.02) * expected);
        const double here = expected - before, slack = 5 * std::sqrt(here) + 0.2 * here;
        if (here > kBeams / 1000) CHECK(std::abs(seen - seenBefore - here) < slack);
        before = expected;
        seenBefore = seen;
      }
  }
}

TEST_CASE("a beam whose own window begins later sees the first drop from there on") {
  Effects effects;
  effects.snow.rate = 5;
  Sensor sensor = sensorUpTo(120);
  sensor.columns = 1;
  sensor.channels.resize(2);
  sensor.channels[1].rangeMin = 9;
  gpu::EffectParameters p = effectParameters(effects, sensor, gpu::kSnow);
  CHECK(p.snow.firstRange == 0.5f);
  p.rangeMin = 9;  // as of the second channel
  std::vector<float> ranges;
  for (uint32_t beam = 0; beam < kBeams; ++beam) {
    const gpu::Echo echo = firstParticle(p, p.snow, 120, beam, gpu::kSnow);
    if (echo.range < gpu::kNever) ranges.push_back(echo.range);
  }
  REQUIRE(ranges.size() > kBeams / 100);
  std::sort(ranges.begin(), ranges.end());
  CHECK(ranges.front() >= 9);
  for (uint32_t i = 1; i <= gpu::kParticleRanges; ++i) {
    const float range = gpu::rangeOf(p.snow, i);
    if (range < 9) continue;
    const double expected = kBeams * (1 - std::exp(-dropsSeen(p, snowFlakes(5), range)));
    const auto seen = double(std::upper_bound(ranges.begin(), ranges.end(), range) - ranges.begin());
    INFO("up to " << range << " m");
    // The expected number up to 9 m is interpolated.
    CHECK(std::abs(seen - expected) < 5 * std::sqrt(expected) + 0.005 * expected);
  }
}

TEST_CASE("sizes of detected drops and flakes exceed the least detectable size by an exponential distribution") {
  Effects effects;
  effects.snow.rate = 1;
  const gpu::EffectParameters p = effectParameters(effects, sensorUpTo(120), gpu::kSnow);
  double sum = 0;
  int count = 0;
  for (uint32_t beam = 0; beam < kBeams; ++beam) {
    const gpu::Echo echo = firstParticle(p, p.snow, 10, beam, gpu::kSnow);
    if (echo.range == gpu::kNever) continue;
    const double focus = std::min(1.0, echo.range * echo.range / 25.0);
    const double across = gpu::kApertureDiameter + 3e-3 * echo.range;
    const double least =
        across * echo.range * std::exp(p.extinction * echo.range) * std::sqrt(p.threshold / (0.6 * focus));
    sum += across * std::sqrt(echo.energy / (0.6 * focus)) - least;
    ++count;
  }
  REQUIRE(count > 10000);
  CHECK(sum / count == Approx(1 / snowFlakes(1).slope).epsilon(0.03));
}

// A pane that leaves a share of the light raises the least power by its inverse.
TEST_CASE("behind a pane or in dust the first drop or flake counts that is strong enough there") {
  struct Case {
    uint32_t effect;
    double rate, detectionRange, light;
    bool dust;
  };
  for (const Case& one : {Case{gpu::kSnow, 1, 100, 0.25, false}, Case{gpu::kSnow, 5, 100, 0.25, false},
                          Case{gpu::kRain, 25, 100, 0.25, false}, Case{gpu::kRain, 100, 200, 0.5, false},
                          Case{gpu::kSnow, 1, 100, 0.25, true}}) {
    CAPTURE(one.effect, one.rate, one.light, one.dust);
    Effects effects;
    (one.effect == gpu::kSnow ? effects.snow.rate : effects.rain.rate) = one.rate;
    effects.detection = {EffectUse::on, 0.1, one.detectionRange, 0};
    // The dust ends before the beam's least range, so it weakens all that follows, and scatters nothing back itself.
    if (one.dust) effects.volumes.boxes = {{{0, -1, -1}, {0.4, 1, 1}, -std::log(one.light) / 2 / 0.4}};
    const uint32_t planned = gpu::kDetection | one.effect | (one.dust ? gpu::kVolumes : 0);
    const gpu::EffectParameters p = effectParameters(effects, sensorUpTo(120), planned);
    gpu::EffectParameters dim = p;
    dim.threshold = float(p.threshold / one.light);
    const DropSizes sizes = one.effect == gpu::kSnow ? snowFlakes(one.rate) : rainDrops(one.rate);
    const gpu::Echo pane = {0.45f, 0, 0, float(one.light), 0};
    const std::vector<gpu::VolumeBox> boxes = volumeBoxes(effects, {});
    gpu::Return found = {};
    gpu::BeamSignal beam;
    beam.EFFECTS = planned;
    beam.returns = {&found, 1};
    beam.volumes = boxes;
    if (!one.dust) beam.echoes = {&pane, 1};
    constexpr uint32_t kSome = 50000;
    std::vector<float> ranges;
    for (uint32_t i = 0; i < kSome; ++i) {
      uint32_t count = 0;
      beam.signalsOf(p, i, {1, 0, 0}, uint32_t(beam.echoes.size()), count);
      if (count > 0) ranges.push_back(found.range);
    }
    std::sort(ranges.begin(), ranges.end());
    for (const double range : {3.0, 8.0, 20.0, 119.0}) {
      const double share = 1 - std::exp(-dropsSeen(dim, sizes, range));
      const double seen = double(std::lower_bound(ranges.begin(), ranges.end(), float(range)) - ranges.begin()) / kSome;
      INFO("up to " << range << " m");
      CHECK(std::abs(seen - share) < 5 * std::sqrt(share * (1 - share) / kSome) + 0.01 * share + 1e-4);
    }
  }
}

TEST_CASE("soft detection neither adds drops and flakes nor loses any") {
  Effects effects;
  effects.rain.rate = 50;
  effects.snow.rate = 1;
  const auto beamsWithEcho = [&](double softness) {
    effects.detection.softness = softness;
    const gpu::EffectParameters p =
        effectParameters(effects, sensorUpTo(120), gpu::kRain | gpu::kSnow | gpu::kDetection);
    std::vector<uint32_t> beams;
    for (uint32_t i = 0; i < 2000; ++i) {
      gpu::Return found = {};
      uint32_t count = 0;
      gpu::BeamSignal beam;
      beam.EFFECTS = gpu::kRain | gpu::kSnow | gpu::kDetection;
      beam.returns = {&found, 1};
      beam.signalsOf(p, i, {1, 0, 0}, 0, count);
      if (count > 0) beams.push_back(i);
    }
    return beams;
  };
  const std::vector<uint32_t> sharp = beamsWithEcho(0);
  CHECK(sharp.size() > 500);
  CHECK(beamsWithEcho(0.5) == sharp);
  CHECK(beamsWithEcho(3) == sharp);
}

TEST_CASE("most beams pass the rain, and fewer at higher rates") {
  const auto seen = [](double rate) {
    Effects effects;
    effects.rain.rate = rate;
    return 1 - std::exp(-double(effectParameters(effects, sensorUpTo(100), gpu::kRain).rain.countsFar.w));
  };
  CHECK(seen(1) > 1e-5);
  CHECK(seen(10) > 2 * seen(1));
  CHECK(seen(10) < 0.2);
}

TEST_CASE("dust attenuates light along its path in the box, for any sensor position and orientation") {
  Effects effects;
  effects.volumes.boxes = {{{10, -2, -1}, {16, 2, 3}, 0.2}};
  const double half = std::sqrt(0.5);
  // The second sensor is behind the box and looks back at it; the third is inside.
  struct Place {
    Pose pose;
    double first, last;
  };
  const Place places[] = {{{{0, 0, 0}, {0, 0, 0, 1}}, 10, 16},
                          {{{20, 0, 0}, {0, 0, 1, 0}}, 4, 10},
                          {{{12, 1, 1}, {0, 0, 0, 1}}, 0, 4},
                          {{{13, 12, 0}, {0, 0, -half, half}}, 10, 14}};
  const gpu::EffectParameters p = effectParameters(effects, sensorUpTo(100), gpu::kVolumes);
  for (const Place& place : places) {
    const std::vector<gpu::VolumeBox> boxes = volumeBoxes(effects, place.pose);
    gpu::BeamSignal beam;
    beam.EFFECTS = gpu::kVolumes;
    beam.volumes = boxes;
    CHECK(beam.depthOf(p, {1, 0, 0}, 50) == Approx(0.2 * (place.last - place.first)).epsilon(1e-5));
    CHECK(beam.depthOf(p, {1, 0, 0}, float(place.first + 1)) == Approx(0.2).epsilon(1e-5));
    CHECK(beam.depthOf(p, {-1, 0, 0}, 0.5f) == Approx(place.first > 0 ? 0 : 0.1).margin(1e-5));
    CHECK(beam.depthOf(p, {0, 0, 1}, 50) == Approx(place.first > 0 ? 0 : 0.4).margin(1e-5));
    int echoes = 0;
    for (uint32_t i = 0; i < 1000; ++i) {
      bool ofParticle = true;
      const gpu::Echo echo = beam.mediumEcho(p, i, {1, 0, 0}, 50, 0, ofParticle);
      CHECK(!ofParticle);
      if (echo.range == gpu::kNever) continue;
      ++echoes;
      CHECK(echo.range >= place.first - 1e-4);
      CHECK(echo.range <= place.last + 1e-4);
    }
    const double share = 1 - std::exp(-2 * 0.2 * (place.last - place.first));
    CHECK(std::abs(echoes - 1000 * share) < 4 * std::sqrt(1000 * share * (1 - share)));
  }
}

// SPDX-License-Identifier: Apache-2.0
#include "reference/medium.hpp"

#include "sensor/beams.hpp"

namespace gnosphere::reference {

namespace {

constexpr double kLightSpeed = 299792458;  // m/s
/// Back-scatter is extinction / lidar ratio (sr). Water droplets at 905 nm: O'Connor et al., J. Atmos. Oceanic Technol.
/// 21 (2004). Mineral dust at 532 nm: Mueller et al., J. Geophys. Res. 112 (2007).
constexpr double kFogLidarRatio = 18.8, kDustLidarRatio = 55;
/// At a range nearer than this, the receiver gets only (range / kFocus)^2 of what the medium scatters back.
constexpr double kFocus = 5;           // m
constexpr double kAperture = 0.01;     // m, diameter of the beam where it leaves the sensor
constexpr double kUsualSpread = 3e-3;  // rad, if neither the request nor the sensor states a divergence
/// Relative error of a position and of a direction, as for corners: see doubt.hpp.
constexpr double kPlaceError = kCornerError;

/// Converts dB/km to 1/m: 10 / ln 10 decibels are one optical depth.
double perMetre(double decibelsPerKilometre) {
  return decibelsPerKilometre / (10 / std::numbers::ln10) / 1000;
}

Bounded focus(const Bounded& range) {
  const Bounded share = range / Bounded(kFocus);
  return min(share * share, 1);
}

}  // namespace

Bounded received(const Bounded& energy, const Bounded& range, const Bounded& depth) {
  return energy / max(range * range, given(1e-8)) * exp(Bounded(-2) * depth);
}

double thresholdOf(const Effects& effects, const Sensor& sensor) {
  const Effects::Detection& detection = effects.detection;
  const bool stated = !(detection.range > 0) && sensor.rangeAt10Percent > 0;
  const double farthest = sensor.rangeMax > 0 ? sensor.rangeMax : widestWindow(sensor).most;
  const double range = stated ? sensor.rangeAt10Percent : detection.range > 0 ? detection.range : farthest;
  return std::max((stated ? 0.1 : detection.reflectance) / (range * range), 1e-30);
}

std::array<double, 2> fullAnglesOf(const SensorPlan& plan) {
  const Effects::Divergence& asked = plan.effects.divergence;
  return {asked.horizontal > 0 ? asked.horizontal : plan.sensor.divergenceHorizontal,
          asked.vertical > 0 ? asked.vertical : plan.sensor.divergenceVertical};
}

double pulseLength(const Effects& effects) {
  return effects.returns.pulseWidth * kLightSpeed / 2;
}

Medium::Medium(const SensorPlan& plan, const Shot& shot)
    : plan_(plan), threshold_(thresholdOf(plan.effects, plan.sensor)), pulse_(pulseLength(plan.effects)) {
  const Effects& effects = plan.effects;
  const auto [horizontal, vertical] = fullAnglesOf(plan);
  horizontal_ = horizontal;
  vertical_ = vertical;
  if (!(horizontal_ > 0 || vertical_ > 0)) horizontal_ = vertical_ = kUsualSpread;
  for (const SensorMotion::Stamp& stamp : shot.motion.stamps)
    travel_ = std::max(travel_, 2 * lengthOf(stamp.pose.position - shot.motion.stamps.front().pose.position));

  // Contrast falls to 5 % at the visibility: Koschmieder (1924), WMO-No. 8. At other wavelengths than 550 nm: Kim,
  // McArthur and Korevaar (2001). Rain and dry snow: ITU-R P.1814 (2007).
  const double kilometres = effects.fog.visibility / 1000, wavelength = effects.intensity.wavelength;
  const double kim = kilometres < 0.5  ? 0
                     : kilometres < 1  ? kilometres - 0.5
                     : kilometres < 6  ? 0.16 * kilometres + 0.34
                     : kilometres < 50 ? 1.3
                                       : 1.6;
  const double rain = effects.rain.rate, snow = effects.snow.rate;
  if (plan.has(gpu::kFog) && effects.fog.visibility > 0)
    still_ = fog_ = std::log(20) / effects.fog.visibility / std::pow(wavelength / 550, kim);
  const bool rains = plan.has(gpu::kRain) && rain > 0, snows = plan.has(gpu::kSnow) && snow > 0;
  if (rains) still_ += perMetre(1.076 * std::pow(rain, 0.67));
  if (snows) still_ += perMetre((0.0000542 * wavelength + 5.4958776) * std::pow(snow, 1.38));
  // Drops: Marshall and Palmer (1948), 8000 /m^3/mm and 4.1 R^-0.21 /mm; by geometric optics a water drop reflects
  // 0.024 of what a disc does. Flakes: Sekhon and Srivastava (1970), by melted diameter; a flake is 2.154 times as
  // wide, and as a sphere of snow that reflects 0.9 it gives 2/3 of a disc's echo.
  if (rains) rain_ = {8e6, 4100 * std::pow(rain, -0.21), 0.024, {}, {}, 0};
  if (snows) snow_ = {2.5e6 * std::pow(snow, -0.94) / 2.154, 2290 * std::pow(snow, -0.45) / 2.154, 0.6, {}, {}, 0};
  if (rains) tabulate(rain_);
  if (snows) tabulate(snow_);
}

Bounded Medium::beamArea(const Bounded& range) const {
  return (given(kAperture) + given(horizontal_) * range) * (given(kAperture) + given(vertical_) * range);
}

/// Particles per metre of the beam whose echo is detected. The echo of a particle is (diameter / beam)^2 times that of
/// a disc of the same reflectance that fills the beam.
Bounded Medium::density(const Particles& particles, double range) const {
  const Bounded r = range, area = beamArea(r);
  // Least area of a detected particle, as a share of the beam's.
  const Bounded share =
      given(threshold_) * r * r * exp(Bounded(2) * given(still_) * r) / (given(particles.reflectance) * focus(r));
  if (!(share.value < 1)) return 0;
  const Bounded diameter = sqrt(share * area);
  return given(particles.intercept / particles.slope) * exp(-given(particles.slope) * diameter) *
         Bounded(std::numbers::pi / 4) * area;
}

/// Integrates in 4096 steps of equal ratio. The table ends where only a ten thousandth of the sum remains.
void Medium::tabulate(Particles& particles) const {
  constexpr size_t kSteps = 4096;
  const RangeWindow window = widestWindow(plan_.sensor);
  const double first = std::max(window.least, 0.01), ratio = std::max(window.most / first, 1.0);
  const auto rangeAt = [&](double step) { return first * std::pow(ratio, step / kSteps); };
  std::vector<double> sums(kSteps + 1), errors(kSteps + 1);
  for (size_t i = 0; i < kSteps; ++i) {
    const Bounded here = density(particles, rangeAt(static_cast<double>(i) + 0.5));
    const double step = rangeAt(static_cast<double>(i) + 1) - rangeAt(static_cast<double>(i));
    sums[i + 1] = sums[i] + here.value * step;
    errors[i + 1] = errors[i] + here.error * step;
  }
  const double all = sums.back();
  particles.countError = errors.back() + kUnitRoundoff * all;
  if (!(ratio > 1) || !(all > 0)) return;
  const auto tableTo = [&](size_t end) {
    Counts counts = {first, rangeAt(static_cast<double>(end)), {}, {}};
    counts.density[0] = density(particles, first).value;
    for (size_t entry = 1; entry <= Counts::kSize; ++entry) {
      counts.density[entry] = density(particles, counts.rangeOf(entry)).value;
      const double step =
          std::clamp(std::log(counts.rangeOf(entry) / first) / std::log(ratio) * kSteps, 0.0, double{kSteps});
      const size_t below = std::min(static_cast<size_t>(step), kSteps - 1);
      counts.upTo[entry] = sums[below] + (sums[below + 1] - sums[below]) * (step - static_cast<double>(below));
    }
    return counts;
  };
  const auto endWith = [&](double sign) {
    for (size_t i = 0; i < kSteps; ++i) {
      const double error = errors.back() - errors[i] + 1e-4 * errors.back();
      if (all - sums[i] <= 1e-4 * all + sign * error) return i;
    }
    return kSteps;
  };
  particles.counts = tableTo(endWith(1));
  particles.others = tableTo(endWith(-1));
}

double Medium::Counts::rangeOf(size_t entry) const {
  const double share = static_cast<double>(entry) / kSize;
  return first + (last - first) * share * share;
}

double Medium::Counts::rangeWith(double count) const {
  size_t entry = 1;
  while (entry < kSize && upTo[entry] <= count) ++entry;
  const auto [before, between, atStart, atEnd] = partOf(entry);
  const double share = std::clamp((count - before) / between, 0.0, 1.0);
  // Solves countUpTo() for the range: square * x^2 + linear * x = share.
  const double bend = share * (atStart + atEnd - 2), square = 1 - atStart + bend, linear = atStart - bend;
  const double root = std::sqrt(std::max(linear * linear + 4 * square * share, 0.0));
  const double x = std::min(2 * share / std::max(linear + root, 1e-30), 1.0);
  return rangeOf(entry - 1) + (rangeOf(entry) - rangeOf(entry - 1)) * x;
}

double Medium::Counts::countUpTo(double range) const {
  if (range <= first) return 0;
  size_t entry = 1;
  while (entry < kSize && rangeOf(entry) < range) ++entry;
  const auto [before, between, atStart, atEnd] = partOf(entry);
  const double start = rangeOf(entry - 1);
  const double x = std::min((range - start) / std::max(rangeOf(entry) - start, 1e-30), 1.0), y = 1 - x;
  return before + between * (x * x + atStart * x * y) / (1 + (atStart + atEnd - 2) * x * y);
}

Medium::Counts::Part Medium::Counts::partOf(size_t entry) const {
  const double between = std::max(upTo[entry] - upTo[entry - 1], 1e-30);
  const double mean = between / (rangeOf(entry) - rangeOf(entry - 1));
  return {upTo[entry - 1], between, density[entry - 1] / mean, density[entry] / mean};
}

/// Returns the part of a line inside a box, up to `far`.
Medium::Span Medium::within(const Effects::Volume& box, const Line& line, const Bounded& far, bool& doubt) const {
  const Vec3 from = line.frame.position, direction = line.frame.directionToWorld(line.direction);
  Span span = {0, far};
  const auto clip = [&](double at, double speed, double low, double high) {
    const double half = std::max((high - low) / 2, 5e-7), place = at - (low + high) / 2;
    const double offset = kPlaceError * (std::abs(place) + half + travel_);
    if (std::abs(speed) <= 2 * kPlaceError) {  // parallel to these faces: between them or outside the box
      doubt = doubt || (std::abs(std::abs(place) - half) <= offset + 3 * kPlaceError * far.value);
      if (std::abs(place) > half) span.far = 0;
      return;
    }
    const auto crossing = [&](double side) {
      const double range = (side * half - place) / speed;
      const double error = (offset + std::abs(range) * kPlaceError) / (std::abs(speed) - kPlaceError);
      return rounded(range, error, kFunctionError);
    };
    const Bounded one = crossing(-1), other = crossing(1);
    span.near = max(span.near, min(one, other));
    span.far = min(span.far, max(one, other));
  };
  clip(from.x, direction.x, box.min.x, box.max.x);
  clip(from.y, direction.y, box.min.y, box.max.y);
  clip(from.z, direction.z, box.min.z, box.max.z);
  return span;
}

Bounded Medium::depthTo(const Line& line, const Bounded& range) const {
  Bounded depth = given(still_) * range;
  if (!plan_.has(gpu::kVolumes)) return depth;
  for (const Effects::Volume& box : plan_.effects.volumes.boxes) {
    bool grazes = false;
    const Span span = within(box, line, range, grazes);
    depth = depth + given(box.extinction) * max(span.far - span.near, 0);
    if (grazes) depth.error += box.extinction * range.value;
  }
  return depth;
}

/// Single scattering: the scattering depth of returning light is distributed as exp(-2 extinction depth), and there is
/// no echo if it is behind the medium. Its energy is pi * back-scatter * pulse length at 1 m, varied by a gamma
/// distribution of shape 4 and mean 1.
std::optional<Echo> Medium::scatter(double extinction, double lidarRatio, const Bounded& near, const Bounded& far,
                                    const std::array<uint32_t, 4>& words, const std::array<uint32_t, 4>& more,
                                    bool& doubt) const {
  if (!(extinction > 0) || !less(near, far, doubt)) return {};
  const Bounded twice = Bounded(2) * given(extinction);
  Echo echo;
  echo.range = near + -log(Bounded(1 - (words[0] >> 8) * 0x1p-24)) / twice;
  if (!less(echo.range, far, doubt)) return {};
  const Bounded product = Bounded(Draws::aboveZero(more[0])) * Bounded(Draws::aboveZero(more[1]));
  const Bounded other = Bounded(Draws::aboveZero(more[2])) * Bounded(Draws::aboveZero(more[3]));
  const Bounded unevenness = Bounded(-0.25) * (log(product) + log(other));
  echo.energy = given(std::numbers::pi * extinction / lidarRatio * pulse_) * unevenness * focus(echo.range);
  echo.width = pulse_;
  return echo;
}

/// Particles are a Poisson process along the beam, so the expected number up to the first one, and from one to the
/// next, is exponentially distributed, and so is the excess of their diameters over the least detectable one.
std::optional<Echo> Medium::particle(const Particles& particles, Bounded beyond, const Bounded& nearest,
                                     const Bounded& far, uint32_t size, bool& doubt) const {
  beyond.error += particles.countError;
  const auto countOf = [&](const Counts& counts) {
    const Bounded before = increasing([&](double range) { return counts.countUpTo(range); }, nearest);
    return beyond + rounded(before.value, before.error, 4 * kFunctionError);
  };
  if (!less(countOf(particles.counts), particles.counts.upTo.back(), doubt)) return {};
  const auto rangeOf = [&](const Counts& counts) {
    return max(increasing([&](double c) { return counts.rangeWith(c); }, countOf(counts)), nearest);
  };
  Echo echo;
  echo.ofParticle = true;
  echo.range = rangeOf(particles.counts);
  const Bounded other = rangeOf(particles.others);
  echo.range =
      rounded(echo.range.value, std::max(echo.range.error, std::abs(other.value - echo.range.value) + other.error),
              2 * kFunctionError);
  if (!less(echo.range, far, doubt)) return {};
  const Bounded strength = given(particles.reflectance) * focus(echo.range);
  const Bounded least =
      echo.range * exp(given(still_) * echo.range) * sqrt(given(threshold_) / max(strength, given(1e-30)));
  const Bounded larger = -log(Draws::aboveZero(size)) / given(particles.slope);
  const Bounded diameter = min(least + larger / sqrt(beamArea(echo.range)), 1);  // as a share of the beam's diameter
  echo.energy = strength * diameter * diameter;
  echo.width = pulse_;
  return echo;
}

/// Returns the share of the beam's light that goes on behind all surfaces up to a range.
Bounded Medium::lightBehind(const std::vector<Echo>& surfaces, const Bounded& range, bool& doubt) const {
  size_t passed = 0;
  while (passed < surfaces.size() && !less(range, surfaces[passed].range, doubt)) ++passed;
  return passed > 0 ? surfaces[passed - 1].light : Bounded(1);
}

std::optional<Echo> Medium::strongest(const Draws& draws, size_t beam, const Line& line, const Bounded& nearest,
                                      const Bounded& far, const std::vector<Echo>& surfaces, bool& doubt) const {
  std::optional<Echo> best;
  Bounded most = 0;
  const auto consider = [&](std::optional<Echo> echo) {
    if (!echo) return;
    echo->energy = echo->energy * lightBehind(surfaces, echo->range, doubt);
    const Bounded power = received(echo->energy, echo->range, depthTo(line, echo->range));
    if (!less(most, power, doubt)) return;
    best = echo;
    most = power;
  };
  if (plan_.has(gpu::kFog))
    consider(scatter(fog_, kFogLidarRatio, nearest, far, draws.words(beam, 0, gpu::kFog),
                     draws.words(beam, 1, gpu::kFog), doubt));
  // The densities are those of particles that are detected in clear air. If surfaces or dust leave less light, further
  // particles are drawn until one is detected, but no more than a few.
  constexpr uint32_t kMostParticles = 16;
  const bool mayBeWeak = plan_.has(gpu::kVolumes) || plan_.has(gpu::kFootprintEffects);
  const auto isDetected = [&](const Echo& echo) {
    const Bounded energy = echo.energy * lightBehind(surfaces, echo.range, doubt);
    const Bounded power = received(energy, echo.range, depthTo(line, echo.range));
    return power.value > 1e-37 && !less(power, given(threshold_) * Bounded(0.999999), doubt);
  };
  const auto firstOf = [&](const Particles& particles, uint32_t effect) -> std::optional<Echo> {
    Bounded number = 0;
    for (uint32_t k = 0; k < (mayBeWeak ? kMostParticles : 1); ++k) {
      const std::array<uint32_t, 4> words = draws.words(beam, k, effect);
      const Bounded step = -log(Draws::aboveZero(words[0]));
      number = k == 0 ? step : number + step;
      const std::optional<Echo> echo = particle(particles, number, nearest, far, words[1], doubt);
      if (!echo || !mayBeWeak || isDetected(*echo)) return echo;
    }
    return {};
  };
  if (plan_.has(gpu::kRain)) consider(firstOf(rain_, gpu::kRain));
  if (plan_.has(gpu::kSnow)) consider(firstOf(snow_, gpu::kSnow));
  if (plan_.has(gpu::kVolumes))
    for (uint32_t i = 0; i < plan_.effects.volumes.boxes.size(); ++i) {
      const Effects::Volume& box = plan_.effects.volumes.boxes[i];
      const Span span = within(box, line, far, doubt);
      consider(scatter(box.extinction, kDustLidarRatio, max(span.near, nearest), span.far,
                       draws.words(beam, 2 * i, gpu::kVolumes), draws.words(beam, 2 * i + 1, gpu::kVolumes), doubt));
    }
  return best;
}

}  // namespace gnosphere::reference

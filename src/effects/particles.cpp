// SPDX-License-Identifier: Apache-2.0
#include "effects/particles.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "base/snow.hpp"
#include "common/effects/weather.h"

namespace gnosphere {
namespace {

/// Converts dB/km to 1/m: an optical depth of 1 is 10 / ln 10 dB.
double perMetre(double decibelsPerKilometre) {
  return decibelsPerKilometre * std::numbers::ln10 / 10 / 1000;
}

/// Back-scatter of a rain drop relative to a Lambertian disc, by geometric optics with n = 1.33. The front of the drop
/// reflects 2 % as a sphere does. Near the axis its back reflects 2 % too and is seen through the front, 3.9 times as
/// large. The sum is 0.0200 / 4 + 0.0200 * 0.98^2 / (2 - 4 / 1.33)^2 = 0.024. The sum does not hold for the smaller
/// droplets of fog, whose glory scatters more light back.
constexpr double kDropReflectance = 0.024;
/// Ratio of a flake's diameter to that of the drop to which it melts, for snow with a tenth of the density of water.
constexpr double kFlakeWidening = 2.154;

constexpr double kPerCubicMetreAndMillimetre = 1e3;  // 1/m^4
constexpr double kPerMillimetre = 1e3;               // 1/m

}  // namespace

double fogExtinction(double visibility, double wavelength) {
  if (!(visibility > 0)) return 0;
  // The droplets of fog are larger than the wavelength, those of haze are not.
  constexpr double kVisible = 550;  // nm
  const double kilometres = visibility / 1000;
  double exponent = 1.6;
  if (kilometres < 0.5)
    exponent = 0;
  else if (kilometres < 1)
    exponent = kilometres - 0.5;
  else if (kilometres < 6)
    exponent = 0.16 * kilometres + 0.34;
  else if (kilometres < 50)
    exponent = 1.3;
  return -std::log(0.05) / visibility * std::pow(wavelength / kVisible, -exponent);
}

double rainExtinction(double rate) {
  return rate > 0 ? perMetre(1.076 * std::pow(rate, 0.67)) : 0;
}

double snowExtinction(double rate, double wavelength) {
  return rate > 0 ? perMetre((0.0000542 * wavelength + 5.4958776) * std::pow(rate, 1.38)) : 0;
}

double scatterOf(double extinction, double lidarRatio, double pulseWidth) {
  return std::numbers::pi * extinction / lidarRatio * pulseWidth;
}

DropSizes rainDrops(double rate) {
  if (!(rate > 0)) return {};
  return {8000 * kPerCubicMetreAndMillimetre, 4.1 * std::pow(rate, -0.21) * kPerMillimetre, kDropReflectance};
}

DropSizes snowFlakes(double rate) {
  if (!(rate > 0)) return {};
  return {2500 * std::pow(rate, -0.94) * kPerCubicMetreAndMillimetre / kFlakeWidening,
          2.29 * std::pow(rate, -0.45) * kPerMillimetre / kFlakeWidening, kFlakeReflectance};
}

double particleDensity(const gpu::EffectParameters& p, const DropSizes& sizes, double range) {
  if (!(sizes.intercept > 0)) return 0;
  const double horizontal = gpu::kApertureDiameter + p.spreadHorizontal * range;
  const double vertical = gpu::kApertureDiameter + p.spreadVertical * range;
  const double focus = std::min(1.0, std::pow(range / gpu::kFocusRange, 2));
  // The smallest detectable share of the beam's area, and the diameter of a particle that covers it.
  const double area = p.threshold * range * range * std::exp(2 * p.extinction * range) / (sizes.reflectance * focus);
  if (!(area < 1)) return 0;
  const double diameter = std::sqrt(area * horizontal * vertical);
  const double perVolume = sizes.intercept / sizes.slope * std::exp(-sizes.slope * diameter);
  return perVolume * std::numbers::pi / 4 * horizontal * vertical;
}

gpu::Particles particlesOf(const gpu::EffectParameters& p, const DropSizes& sizes, const RangeWindow& window) {
  gpu::Particles particles = {};
  particles.firstRange = std::max(float(window.least), 0.01f);
  particles.lastRange = std::max(float(window.most), particles.firstRange);
  particles.excess = float(1 / std::max(sizes.slope, 1.0));
  particles.reflectance = float(std::max(sizes.reflectance, 1e-6));
  particles.least = float(std::sqrt(double{p.threshold} / particles.reflectance));

  // The sum uses steps of equal ratio, because near particles contribute most.
  constexpr int kSteps = 4096;
  const double first = particles.firstRange;
  const double ratio = particles.lastRange / first;
  const auto rangeAt = [&](double step) { return first * std::pow(ratio, step / kSteps); };
  std::vector<double> sums(kSteps + 1, 0.0);
  for (int i = 0; i < kSteps; ++i)
    sums[size_t(i) + 1] = sums[size_t(i)] + particleDensity(p, sizes, rangeAt(i + 0.5)) * (rangeAt(i + 1) - rangeAt(i));
  // The table ends where 99.99 % of the particles are included; entries beyond would be wasted.
  const auto end = std::lower_bound(sums.begin(), sums.end(), sums.back() * 0.9999);
  particles.lastRange = float(rangeAt(double(end - sums.begin())));
  const auto sumTo = [&](double range) {
    const double step = std::clamp(std::log(range / first) / std::log(ratio) * kSteps, 0.0, double(kSteps));
    const auto below = std::min(size_t(step), size_t{kSteps - 1});
    return sums[below] + (sums[below + 1] - sums[below]) * (step - double(below));
  };
  if (!(ratio > 1) || !(sums.back() > 0)) return particles;
  const auto tableOf = [&](const auto& entry, gpu::vec4& near, gpu::vec4& far) {
    near = {entry(1), entry(2), entry(3), entry(4)};
    far = {entry(5), entry(6), entry(7), entry(8)};
  };
  const auto countAt = [&](uint32_t i) { return sumTo(gpu::rangeOf(particles, i)); };
  // The density at a range, relative to the mean density of a part of the table.
  const auto relative = [&](uint32_t part, double range) {
    const double metres = double{gpu::rangeOf(particles, part)} - gpu::rangeOf(particles, part - 1);
    return float(particleDensity(p, sizes, range) * metres / std::max(countAt(part) - countAt(part - 1), 1e-30));
  };
  tableOf([&](uint32_t i) { return float(countAt(i)); }, particles.countsNear, particles.countsFar);
  tableOf([&](uint32_t i) { return relative(i, gpu::rangeOf(particles, i - 1)); }, particles.startsNear,
          particles.startsFar);
  tableOf([&](uint32_t i) { return relative(i, gpu::rangeOf(particles, i)); }, particles.endsNear, particles.endsFar);
  return particles;
}

}  // namespace gnosphere

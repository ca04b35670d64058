// SPDX-License-Identifier: Apache-2.0
// Livox publishes no figures of the optics in the Mid-360, but a table of its directions (scan_mode/mid360.npy of
// MuJoCo-LiDAR, MIT). Its Fourier transform has lines only at sums of multiples of two frequencies: of a fast turn,
// which sweeps the azimuth, and of a slow swing between the lowest and the highest elevation. The sums below
// have the strongest lines.
#include "sensor/catalogue_mid360.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <iterator>
#include <numbers>
#include <vector>

#include "base/units.hpp"
#include "base/vector.hpp"

namespace gnosphere {
namespace {

constexpr double kTurnsPerSecond = 2189.0 / 12, kSwingsPerSecond = 10;
constexpr double kScanSeconds = 0.1;  // seconds
constexpr int kScans = 40, kLasers = 4;
constexpr double kBeamsPerSecond = 200000;

/// A term of a component of the directions: amplitude * offset^power * exp(2 pi i (turns * fast + swings * slow)),
/// where fast and slow are the cycles since the start. The four lasers stand side by side at the offsets -3, -1, 1
/// and 3. A direction is that of the sum.
struct Line {
  int power, turns, swings;
  std::complex<double> amplitude;
};

/// The real part of the sum is forward, the imaginary part to the left.
const Line kForwardAndLeft[] = {
    {0, -1, 0, {-0.0096999, -0.842024}},  {0, -1, -1, {0.0006178, 0.294999}},   {0, -1, 1, {-0.0026764, -0.146031}},
    {0, -1, -3, {4.5e-05, 0.021469}},     {0, -1, 3, {-0.0001772, -0.0082511}}, {0, -1, -2, {-2.55e-05, 0.0031749}},
    {0, -1, 2, {9.81e-05, 0.0031735}},    {0, -1, -5, {2e-06, 0.000891}},       {0, -1, 4, {1.62e-05, 0.0005107}},
    {0, -1, -4, {-4.6e-06, 0.000511}},    {1, -2, 0, {-0.0002457, -0.0106642}}, {1, 0, 0, {-6.1e-06, 0.004393}},
    {1, -2, 1, {-0.0001433, -0.0043426}}, {1, 0, -1, {4.32e-05, -0.0043448}},   {1, 0, -2, {3.93e-05, -0.0019596}},
    {1, -2, 3, {-1.5e-05, -0.0004177}},   {1, 0, -3, {5.5e-06, -0.000418}},     {1, -2, 2, {1.46e-05, 0.0003347}},
    {1, 0, -4, {6.1e-06, -0.0003109}},    {2, -1, 0, {2.3e-06, 0.0002}},        {2, -1, -1, {1e-07, 8e-05}},
    {2, 1, -2, {-1.4e-06, 4.6e-05}},      {2, -3, 2, {2.5e-06, 4.59e-05}},
};

/// The real part of the sum is up.
const Line kUp[] = {
    {0, 0, 0, {0.334117, 0}},          {0, 0, 1, {0.373914, -0.0043726}},   {0, 0, 3, {0.031552, -0.0002533}},
    {0, 0, 5, {0.001113, -8.9e-06}},   {1, 1, 0, {-0.0141441, -0.0001555}}, {1, 1, -2, {-0.0022599, -7.1e-05}},
    {1, 1, -1, {0.0006329, 1.36e-05}}, {1, 1, -4, {-0.0003428, -1.04e-05}},
};

/// The powers -kMost to kMost of exp(2 pi i cycles).
struct Powers {
  static constexpr int kMost = 5;
  std::complex<double> of[2 * kMost + 1];

  explicit Powers(double cycles) {
    for (int k = -kMost; k <= kMost; ++k)
      of[k + kMost] = std::polar(1.0, 2 * std::numbers::pi * std::fmod(k * cycles, 1.0));
  }
  const std::complex<double>& operator[](int power) const { return of[power + kMost]; }
};

/// Returns the lines of a laser, whose amplitudes have the power of its offset as a factor.
template <size_t kCount>
std::array<Line, kCount> linesAt(double offset, const Line (&lines)[kCount]) {
  std::array<Line, kCount> own;
  std::ranges::copy(lines, own.begin());
  for (Line& line : own) line.amplitude = std::pow(offset, line.power) * line.amplitude;
  return own;
}

template <size_t kCount>
std::complex<double> sumOf(const std::array<Line, kCount>& lines, const Powers& fast, const Powers& slow) {
  std::complex<double> sum = 0;
  for (const Line& line : lines) sum += line.amplitude * fast[line.turns] * slow[line.swings];
  return sum;
}

/// The lines of a laser.
struct LaserLines {
  explicit LaserLines(double offset) : forwardAndLeft(linesAt(offset, kForwardAndLeft)), up(linesAt(offset, kUp)) {}
  std::array<Line, std::size(kForwardAndLeft)> forwardAndLeft;
  std::array<Line, std::size(kUp)> up;
};

}  // namespace

CatalogueHead mid360Head() {
  return {
      "Mid-360",
      "Livox Mid-360",
      {"10Hz"},
      "Livox's specifications of the Mid-360: 360 degrees, -7 to 52 degrees, 200,000 points per second, 0.1 m, 40 m at "
      "10 % and 70 m at 80 %; scan_mode/mid360.npy of MuJoCo-LiDAR, of Livox's simulation plug-in: directions",
      "The 31 strongest lines of the table's Fourier transform: its 800,000 directions are met within 0.11 degrees, "
      "and within 0.026 on average (RMS). The four lasers fire together. Divergence: not stated there. 40 scans, after "
      "which the pattern starts anew.",
      40};
}

Sensor mid360Sensor() {
  Sensor sensor;
  sensor.rangeMin = 0.1;
  sensor.rangeMax = 70;
  sensor.rangeAt10Percent = 40;
  sensor.scanPeriod = kScanSeconds;
  const auto shots = static_cast<int>(std::lround(kScanSeconds * kBeamsPerSecond / kLasers));
  std::vector<LaserLines> lasers;
  for (int laser = 0; laser < kLasers; ++laser) lasers.emplace_back(2 * laser - (kLasers - 1));
  for (int frame = 0; frame < kScans; ++frame) {
    BeamList& list = sensor.patterns.emplace_back();
    for (int shot = 0; shot < shots; ++shot) {
      const double seconds = kScanSeconds * (frame + double(shot) / shots);
      const Powers fast(kTurnsPerSecond * seconds), slow(kSwingsPerSecond * seconds);
      for (uint16_t laser = 0; laser < kLasers; ++laser) {
        const std::complex<double> across = sumOf(lasers[laser].forwardAndLeft, fast, slow);
        const Vec3 sum = {across.real(), across.imag(), sumOf(lasers[laser].up, fast, slow).real()};
        list.directions.push_back((1 / lengthOf(sum)) * sum);
        list.times.push_back(kScanSeconds * shot / shots);
        list.rings.push_back(laser);
      }
    }
  }
  return sensor;
}

}  // namespace gnosphere

// SPDX-License-Identifier: Apache-2.0
#include "output/pattern_picture.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "base/decimal_point.hpp"
#include "base/units.hpp"
#include "base/vector.hpp"
#include "output/canvas.hpp"

namespace gnosphere {
namespace {

constexpr Colour kLine = {0.16f, 0.18f, 0.22f};
constexpr int kWidth = 1600, kLeft = 90, kRight = 30, kTop = 60, kBottom = 60;

/// An axis of degrees on pixels.
struct Axis {
  double low = 0, high = 0;
  int start = 0, length = 0;  ///< `length` is negative if larger angles are up or to the left

  float at(double degrees) const { return static_cast<float>(start + length * (degrees - low) / (high - low)); }
  double step() const {
    for (const double step : {0.5, 1.0, 2.0, 5.0, 10.0, 15.0, 30.0})
      if ((high - low) / step <= 13) return step;
    return 60;
  }
};

struct Dot {
  float azimuth, elevation;  // degrees
  double time;
};

std::vector<Dot> dotsOf(const Sensor& sensor) {
  const BeamList beams = beamsOf(sensor);
  std::vector<bool> masked(beams.size());
  for (const uint32_t beam : sensor.maskedBeams) masked[beam] = true;
  std::vector<Dot> dots;
  for (size_t beam = 0; beam < beams.size(); ++beam) {
    if (masked[beam]) continue;
    const Vec3& d = beams.directions[beam];
    dots.push_back({static_cast<float>(kRadian * std::atan2(d.y, d.x)),
                    static_cast<float>(kRadian * std::atan2(d.z, lengthOf(d.x, d.y))),
                    beams.times.empty() ? 0 : beams.times[beam]});
  }
  return dots;
}

/// The angles that are drawn: those of the dots, a little more, and at least 2 degrees.
template <typename Get>
Axis axisOf(const std::vector<Dot>& dots, Get get, double limit) {
  Axis axis{0, 0};
  if (!dots.empty()) axis = {get(dots[0]), get(dots[0])};
  for (const Dot& dot : dots) {
    axis.low = std::min<double>(axis.low, get(dot));
    axis.high = std::max<double>(axis.high, get(dot));
  }
  const double more = std::max(0.03 * (axis.high - axis.low), 1.0);
  axis.low = std::max(-limit, axis.low - more);
  axis.high = std::min(limit, axis.high + more);
  return axis;
}

std::string degreesText(double degrees) {
  const DecimalPoint point;
  char text[32];
  std::snprintf(text, sizeof(text), "%g", degrees);
  return text;
}

}  // namespace

void writePatternPicture(const Sensor& sensor, const std::filesystem::path& file) {
  const std::vector<Dot> dots = dotsOf(sensor);
  Axis across = axisOf(
      dots, [](const Dot& dot) { return dot.azimuth; }, 180);
  Axis up = axisOf(
      dots, [](const Dot& dot) { return dot.elevation; }, 90);
  const int width = kWidth - kLeft - kRight;
  const double scale = width / (across.high - across.low);
  const int height = static_cast<int>(std::clamp(scale * (up.high - up.low), 300.0, 1000.0));
  across.start = kLeft + width;  // azimuths grow to the left, as they do in what the sensor sees
  across.length = -width;
  up.start = kTop + height;
  up.length = -height;

  Canvas canvas(kWidth, kTop + height + kBottom, kBackground);
  for (double a = std::ceil(across.low / across.step()) * across.step(); a <= across.high; a += across.step()) {
    canvas.fill(static_cast<int>(across.at(a)), kTop, 1, height, kLine);
    const std::string text = degreesText(a);
    canvas.text(static_cast<int>(across.at(a)) - Canvas::textWidth(text) / 2, kTop + height + 10, text, kText);
  }
  for (double e = std::ceil(up.low / up.step()) * up.step(); e <= up.high; e += up.step()) {
    canvas.fill(kLeft, static_cast<int>(up.at(e)), width, 1, kLine);
    const std::string text = degreesText(e);
    canvas.text(kLeft - 10 - Canvas::textWidth(text), static_cast<int>(up.at(e)) - 7, text, kText);
  }
  double last = 0;
  for (const Dot& dot : dots) last = std::max(last, dot.time);
  const float radius = dots.size() < 3000 ? 2.5f : dots.size() < 60000 ? 1.2f : 0.7f;
  for (const Dot& dot : dots)
    canvas.circle(across.at(dot.azimuth), up.at(dot.elevation), radius,
                  turbo(last > 0 ? 0.05f + 0.9f * static_cast<float>(dot.time / last) : 0.5f), 1);
  char title[200];
  std::snprintf(title, sizeof(title), "%.80s: %zu beams%s", sensor.name.c_str(), dots.size(),
                last > 0 ? ", blue fires first, red last" : "");
  canvas.text(kLeft, 20, title, kText);
  canvas.text(kLeft, kTop + height + 34, "azimuth (degrees, to the left) and elevation (degrees)", kText);
  canvas.writePng(file);
}

}  // namespace gnosphere

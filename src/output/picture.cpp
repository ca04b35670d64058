// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

#include "base/decimal_point.hpp"
#include "output/canvas.hpp"
#include "output/rows.hpp"

namespace gnosphere {
namespace {

constexpr Colour kMiss = {0.075f, 0.086f, 0.110f};
constexpr Colour kFaint = {0.45f, 0.49f, 0.56f};
constexpr int kMargin = 24;
constexpr int kTitle = 56;  ///< the strip of text above each picture

/// Returns the value below which `share` of the values lie, and reorders `values`.
float quantile(std::vector<float>& values, double share) {
  if (values.empty()) return 0;
  const auto nth = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), nth, values.end());
  return *nth;
}

std::string metres(float value) {
  const DecimalPoint point;
  char text[32];
  std::snprintf(text, sizeof(text), std::abs(value) < 9.95f ? "%.1f m" : "%.0f m", static_cast<double>(value));
  return text;
}

/// How columns and channels map to pixels: those of large grids are grouped, those of small ones are stretched.
struct RangeImage {
  uint32_t columnsPerPixel = 1, channelsPerPixel = 1;
  int columns = 0, channels = 0;  ///< groups
  int pixelsPerChannel = 1;
  int width = 0, height = 0;

  explicit RangeImage(const Scan& scan) {
    constexpr uint32_t kWidest = 2000, kHighest = 800;
    constexpr int kNarrowest = 1400, kLowest = 300;
    columnsPerPixel = std::max(1u, (scan.columns + kWidest - 1) / kWidest);
    channelsPerPixel = std::max(1u, (scan.channels + kHighest - 1) / kHighest);
    columns = static_cast<int>((scan.columns + columnsPerPixel - 1) / columnsPerPixel);
    channels = static_cast<int>((scan.channels + channelsPerPixel - 1) / channelsPerPixel);
    pixelsPerChannel = std::clamp(kLowest / std::max(channels, 1), 1, 40);
    width = std::max(columns, kNarrowest);
    height = std::max(channels * pixelsPerChannel, 1);
  }

  /// Number of pixels to the left of a column, counted from the left.
  int leftOf(int column) const { return static_cast<int>(int64_t{column} * width / columns); }
};

/// The nearest range of each pixel, so that a thin pole stays visible when columns are grouped; infinite without a hit.
std::vector<float> nearestRanges(const Scan& scan, const RangeImage& image) {
  std::vector<float> nearest(static_cast<size_t>(image.columns) * static_cast<size_t>(image.channels),
                             std::numeric_limits<float>::infinity());
  for (size_t beam = 0; beam < scan.beamCount(); ++beam) {
    const float range = scan.ranges[beam];
    if (!std::isfinite(range) || range <= 0) continue;
    const size_t place = beam % scan.columns, row = beam / scan.columns;
    const size_t column = (scan.firstColumnOnLeft ? scan.columns - 1 - place : place) / image.columnsPerPixel;
    const size_t channel = (scan.firstRowOnTop ? scan.channels - 1 - row : row) / image.channelsPerPixel;
    float& pixel = nearest[channel * static_cast<size_t>(image.columns) + column];
    pixel = std::min(pixel, range);
  }
  return nearest;
}

/// The part of the colour map that a scale uses. The ends of Turbo are too dark for our background.
struct Shades {
  float low, high;
  Colour at(float t) const { return turbo(low + (high - low) * t); }
};
constexpr Shades kRangeShades = {0.95f, 0.08f};  // near points get warm colours
constexpr Shades kHeightShades = {0.1f, 0.88f};

/// Draws a colour bar with its two ends labelled, right-aligned at `right`.
void drawScale(Canvas& canvas, int right, int top, const std::string& low, const std::string& high,
               const Shades& shades) {
  constexpr int kBar = 220, kGap = 10;
  const int bar = right - Canvas::textWidth(high) - kGap - kBar;
  canvas.text(right - Canvas::textWidth(high), top, high, kFaint);
  canvas.text(bar - kGap - Canvas::textWidth(low), top, low, kFaint);
  for (int i = 0; i < kBar; ++i) canvas.fill(bar + i, top + 1, 1, 13, shades.at(static_cast<float>(i) / (kBar - 1)));
}

/// Ranges of the pixels; infinite if no beam hit.
struct Ranges {
  int columns, channels;
  std::vector<float> nearest;
  /// The columns wrap around, the channels do not.
  float at(int column, int channel) const {
    const size_t wrapped = static_cast<size_t>((column + columns) % columns);
    return nearest[static_cast<size_t>(channel) * static_cast<size_t>(columns) + wrapped];
  }
};

/// Brightness of a pixel, 0..1: dark if a neighbour is much nearer, so that objects stand out from their background
/// (after eye-dome lighting, Boucheny 2009). Ground recedes steadily from channel to channel, so upwards only the
/// recession in excess of the one below counts.
float edgeLight(const Ranges& ranges, int column, int channel) {
  const float own = std::log(ranges.at(column, channel));
  const auto behind = [&](int i, int j) {
    const float other = ranges.at(i, j);
    return std::isfinite(other) ? std::max(own - std::log(other), 0.0f) : 0.0f;
  };
  float depth = std::max(behind(column - 1, channel), behind(column + 1, channel));
  if (channel >= 2 && std::isfinite(ranges.at(column, channel - 1)) && std::isfinite(ranges.at(column, channel - 2))) {
    const float recession = std::log(ranges.at(column, channel - 1) / ranges.at(column, channel - 2));
    depth = std::max(depth, behind(column, channel - 1) - 2 * std::max(recession, 0.02f));
  }
  return 0.35f + 0.65f * std::exp(-8 * std::max(depth - 0.02f, 0.0f));
}

/// Draws the panorama that the sensor sees: forward is in the middle, the sensor's left at the left, the lowest channel
/// at the bottom. Columns of `ranges` run counter-clockwise seen from above, so they are drawn from right to left.
void drawRangeImage(Canvas& canvas, const Scan& scan, const RangeImage& image, int left, int top) {
  canvas.fill(left, top, image.width, image.height, kMiss);
  std::vector<float> hits;
  for (float range : scan.ranges) {
    if (std::isfinite(range) && range > 0) hits.push_back(range);
  }
  if (hits.empty()) return;
  const float near = std::max(quantile(hits, 0.005), 0.05f);
  const float far = std::max(quantile(hits, 0.995), near * 1.5f);

  const Ranges ranges = {image.columns, image.channels, nearestRanges(scan, image)};
  for (int j = 0; j < image.channels; ++j) {
    for (int i = 0; i < image.columns; ++i) {
      const float range = ranges.at(i, j);
      if (!std::isfinite(range)) continue;
      // The scale is logarithmic: it shows the shape of near objects and still orders far ones.
      const float t = std::log(std::max(range, near) / near) / std::log(far / near);
      const int first = image.leftOf(image.columns - 1 - i), end = image.leftOf(image.columns - i);
      canvas.fill(left + first, top + (image.channels - 1 - j) * image.pixelsPerChannel, end - first,
                  image.pixelsPerChannel, kRangeShades.at(std::min(t, 1.0f)) * edgeLight(ranges, i, j));
    }
  }
  drawScale(canvas, left + image.width, top - 26, metres(near), metres(far), kRangeShades);
}

/// Geometry of the bird's-eye view: x (forward) is up, y to the left, `radius` metres lie between the middle and the
/// edge.
struct BirdsEye {
  int side = 0;
  float radius = 1;
  float low = 0, high = 1;  ///< heights at the ends of the colours
  float pixelsPerMetre() const { return static_cast<float>(side) / (2 * radius); }
};

/// Calls use(point) for the point of every beam that has one.
template <class Use>
void eachPoint(const Scan& scan, const Use& use) {
  for (size_t beam = 0; beam < scan.beamCount(); ++beam) {
    const float* p = &scan.points[3 * beam];
    if (std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2])) use(p);
  }
}

BirdsEye fitBirdsEye(const Scan& scan, int side) {
  BirdsEye view;
  view.side = side;
  std::vector<float> distances, heights;
  eachPoint(scan, [&](const float* p) {
    distances.push_back(std::hypot(p[0], p[1]));
    heights.push_back(p[2]);
  });
  if (distances.empty()) return view;
  view.radius = std::max(quantile(distances, 0.99) * 1.08f, 0.5f);
  view.low = quantile(heights, 0.01);
  view.high = std::max(quantile(heights, 0.99), view.low + 0.5f);
  return view;
}

void drawRings(Canvas& canvas, const BirdsEye& view, int left, int top) {
  float step = 0.1f;
  for (const float candidate : {0.2f, 0.5f, 1.0f, 2.0f, 5.0f, 10.0f, 20.0f, 50.0f, 100.0f, 200.0f, 1000.0f}) {
    if (view.radius > 3 * candidate) step = candidate;
  }
  const float middle = static_cast<float>(view.side) / 2;
  const float x = static_cast<float>(left) + middle, y = static_cast<float>(top) + middle;
  for (int ring = 1; ring <= 8 && static_cast<float>(ring) * step < view.radius; ++ring) {
    const float radius = static_cast<float>(ring) * step;
    const float pixels = radius * view.pixelsPerMetre();
    canvas.circle(x, y, pixels, kFaint, 0.35f);
    canvas.text(static_cast<int>(x + pixels * 0.7071f) + 6, static_cast<int>(y - pixels * 0.7071f) - 14, metres(radius),
                kFaint * 0.8f);
  }
}

/// For each pixel of the bird's-eye view: how many soft dots cover it, and the height of the highest, which hides the
/// others.
struct Splats {
  std::vector<float> weight;
  std::vector<float> height;
};

/// Sparse clouds get larger dots, so that they are still visible.
float dotRadius(size_t hits, int side) {
  const double pixelsPerHit = static_cast<double>(side) * side / static_cast<double>(std::max<size_t>(hits, 1));
  return static_cast<float>(std::clamp(0.15 * std::sqrt(pixelsPerHit), 0.62, 1.1));
}

Splats splat(const Scan& scan, const BirdsEye& view, float radius) {
  const auto side = static_cast<size_t>(view.side);
  Splats dots{std::vector<float>(side * side, 0.0f), std::vector<float>(side * side, view.low)};
  eachPoint(scan, [&](const float* p) {
    const float x = (view.radius - p[1]) * view.pixelsPerMetre();
    const float y = (view.radius - p[0]) * view.pixelsPerMetre();
    if (!(x >= 2 && y >= 2 && x < static_cast<float>(side) - 3 && y < static_cast<float>(side) - 3)) return;
    const int column = static_cast<int>(x), row = static_cast<int>(y);
    for (int j = row - 2; j <= row + 2; ++j) {
      for (int i = column - 2; i <= column + 2; ++i) {
        const float dx = static_cast<float>(i) + 0.5f - x, dy = static_cast<float>(j) + 0.5f - y;
        const float weight = std::exp(-(dx * dx + dy * dy) / (2 * radius * radius));
        if (weight < 0.02f) continue;
        const size_t at = static_cast<size_t>(j) * side + static_cast<size_t>(i);
        dots.weight[at] += weight;
        if (weight > 0.1f) dots.height[at] = std::max(dots.height[at], p[2]);
      }
    }
  });
  return dots;
}

/// Draws the sensor: a dot with a line that points forward.
void drawSensor(Canvas& canvas, int x, int y) {
  for (int radius = 0; radius <= 4; ++radius) {
    canvas.circle(static_cast<float>(x), static_cast<float>(y), static_cast<float>(radius), {1, 1, 1}, 1);
  }
  canvas.fill(x - 1, y - 16, 3, 14, {1, 1, 1});
}

void drawBirdsEye(Canvas& canvas, const Scan& scan, size_t hits, int left, int top, int side) {
  const BirdsEye view = fitBirdsEye(scan, side);
  drawRings(canvas, view, left, top);
  const Splats dots = splat(scan, view, dotRadius(hits, side));
  for (int j = 0; j < side; ++j) {
    for (int i = 0; i < side; ++i) {
      const size_t at = static_cast<size_t>(j) * static_cast<size_t>(side) + static_cast<size_t>(i);
      const float weight = dots.weight[at];
      if (weight <= 0) continue;
      const float t = std::clamp((dots.height[at] - view.low) / (view.high - view.low), 0.0f, 1.0f);
      const float crowd = std::min(std::log1p(weight) / std::log(9.0f), 1.0f);
      canvas.blend(left + i, top + j, kHeightShades.at(t) * (0.72f + 0.28f * crowd), 1 - std::exp(-2.2f * weight));
    }
  }
  drawSensor(canvas, left + side / 2, top + side / 2);
  drawScale(canvas, left + side, top - 26, metres(view.low), metres(view.high), kHeightShades);
}

/// Keeps the first return of every beam, which is all that the picture shows.
Scan firstReturns(const Scan& scan) {
  Scan first;
  first.sensor = scan.sensor;
  first.columns = scan.columns;
  first.channels = scan.channels;
  first.firstRowOnTop = scan.firstRowOnTop;
  first.firstColumnOnLeft = scan.firstColumnOnLeft;
  for (size_t entry = 0; entry < scan.ranges.size(); entry += scan.returns) {
    first.ranges.push_back(scan.ranges[entry]);
    first.points.insert(first.points.end(), &scan.points[3 * entry], &scan.points[3 * entry] + 3);
  }
  return first;
}

}  // namespace

void writePicture(const Scan& scan, const std::filesystem::path& file) {
  checkFields(scan, {Field::x});
  if (scan.returns > 1) return writePicture(firstReturns(scan), file);
  const RangeImage image(scan);
  const int side = image.width;
  const int birdsEyeTop = kTitle + image.height + kTitle;
  Canvas canvas(image.width + 2 * kMargin, birdsEyeTop + side + kMargin, kBackground);

  size_t hits = 0;
  for (float range : scan.ranges) hits += std::isfinite(range);
  const DecimalPoint point;
  char share[96];
  std::snprintf(share, sizeof(share), "%u channels x %u columns, %.1f %% hits", scan.channels, scan.columns,
                scan.ranges.empty() ? 0.0 : 100.0 * static_cast<double>(hits) / static_cast<double>(scan.beamCount()));
  const std::string name = scan.sensor.empty() ? "Scan" : scan.sensor.substr(0, 40);
  canvas.text(kMargin, kTitle - 26, name, kText);
  canvas.text(kMargin + Canvas::textWidth(name) + 24, kTitle - 26, share, kFaint);
  drawRangeImage(canvas, scan, image, kMargin, kTitle);
  canvas.text(kMargin, birdsEyeTop - 26, "From above", kText);
  canvas.text(kMargin + Canvas::textWidth("From above") + 24, birdsEyeTop - 26, "forward is up; colour is height",
              kFaint);
  drawBirdsEye(canvas, scan, hits, kMargin, birdsEyeTop, side);
  canvas.writePng(file);
}

}  // namespace gnosphere

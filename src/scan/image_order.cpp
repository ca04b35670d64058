// SPDX-License-Identifier: Apache-2.0
#include "scan/image_order.hpp"

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "base/vector.hpp"
#include "sensor/beams.hpp"

namespace gnosphere {
namespace {

/// The covariance of rows and heights, times their number. Both means are taken off, so that rows which meet something
/// more often than others do not turn its sign.
class Rise {
 public:
  void add(double row, double height) {
    ++count_;
    rows_ += row;
    heights_ += height;
    products_ += row * height;
  }
  double value() const { return count_ > 0 ? products_ - rows_ * heights_ / count_ : 0; }

 private:
  double count_ = 0, rows_ = 0, heights_ = 0, products_ = 0;
};

/// `directionOf(beam)` returns a unit vector, or NaN for a beam whose direction is not known.
template <class DirectionOf>
ImageOrder orderOf(size_t columns, size_t channels, const DirectionOf& directionOf) {
  Rise rise;
  int64_t left = 0, right = 0;
  for (size_t row = 0; row < channels; ++row) {
    Vec3 before = {NAN, NAN, NAN};
    for (size_t column = 0; column < columns; ++column) {
      const Vec3 here = directionOf(row * columns + column);
      if (std::isfinite(here.z)) rise.add(static_cast<double>(row), here.z);
      const double cross = before.x * here.y - before.y * here.x;
      left += cross > 0;
      right += cross < 0;
      before = here;
    }
  }
  return {rise.value() < 0, right > 2 * left};
}

}  // namespace

ImageOrder imageOrderOf(const Sensor& sensor) {
  if (!sensor.isGrid())
    return orderOf(sensor.width(), sensor.height(), [&](size_t beam) { return directionOf(sensor, beam); });
  // All columns have the same elevations, and turn the same way.
  Rise rise;
  for (size_t channel = 0; channel < sensor.channels.size(); ++channel)
    rise.add(static_cast<double>(channel), directionOf(sensor, channel * sensor.columns).z);
  return {rise.value() < 0, sensor.azimuthSpanDeg < 0};
}

ImageOrder imageOrderOf(const Scan& scan) {
  if (scan.points.empty()) return {};
  return orderOf(scan.columns, scan.channels, [&](size_t beam) {
    const float* p = &scan.points[3 * beam * scan.returns];
    const Vec3 point = {p[0], p[1], p[2]};
    return 1 / lengthOf(point) * point;
  });
}

}  // namespace gnosphere

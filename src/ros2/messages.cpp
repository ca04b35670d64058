// SPDX-License-Identifier: Apache-2.0
// Scans as messages, and what messages must fulfil.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <span>

#include "base/units.hpp"
#include "gnosphere/error.hpp"
#include "gnosphere/output.hpp"
#include "ros2/check.hpp"
#include "scan/fields.hpp"
#include "sensor/beams.hpp"

namespace gnosphere::ros2 {
namespace {

constexpr uint64_t kMostBytes = 0x7fffffff;  // of a message's data

[[noreturn]] void refuse(const std::string& why) {
  throw Error(ErrorCode::invalidArgument, why);
}

void checkText(const std::string& text, const char* what) {
  if (text.find('\0') != std::string::npos) refuse(std::string(what) + " contains a zero");
}

void checkStamp(int64_t nanoseconds, const char* what) {
  constexpr int64_t kMost = int64_t{1} << 31, kSecond = 1'000'000'000;
  if (nanoseconds < -kMost * kSecond || nanoseconds >= kMost * kSecond)
    refuse(std::string(what) + " is " + std::to_string(nanoseconds) + " ns, and ROS has 32 bits for seconds");
}

size_t bytesOf(PointField::Type type) {
  constexpr size_t kBytes[] = {0, 1, 1, 2, 2, 4, 4, 4, 8};
  const auto number = static_cast<size_t>(type);
  return number < std::size(kBytes) ? kBytes[number] : 0;
}

PointField::Type typeOf(ValueType type) {
  switch (type) {
    case ValueType::f64: return PointField::Type::f64;
    case ValueType::u8: return PointField::Type::u8;
    case ValueType::u16: return PointField::Type::u16;
    case ValueType::u32: return PointField::Type::u32;
    case ValueType::f32: break;
  }
  return PointField::Type::f32;
}

struct Checker {
  void operator()(const PointCloud2& cloud) const {
    checkStamp(cloud.stamp, "PointCloud2::stamp");
    checkText(cloud.frame, "PointCloud2::frame");
    for (const PointField& field : cloud.fields) {
      checkText(field.name, "PointField::name");
      const uint64_t bytes = bytesOf(field.type);
      if (bytes == 0) refuse("PointField::type of " + field.name + " is no type of ROS");
      if (field.offset + bytes * field.count > cloud.pointStep)
        refuse("the field " + field.name + " ends beyond PointCloud2::pointStep, which is " +
               std::to_string(cloud.pointStep));
    }
    const uint64_t points = uint64_t{cloud.height} * cloud.width;
    if (cloud.data.size() > kMostBytes) refuse("PointCloud2::data has more than 2 GB");
    if (points > kMostBytes || points * cloud.pointStep != cloud.data.size())
      refuse("PointCloud2::data has " + std::to_string(cloud.data.size()) +
             " bytes, but height * width * pointStep is " + std::to_string(cloud.height) + " * " +
             std::to_string(cloud.width) + " * " + std::to_string(cloud.pointStep));
  }
  void operator()(const LaserScan& scan) const {
    checkStamp(scan.stamp, "LaserScan::stamp");
    checkText(scan.frame, "LaserScan::frame");
    if (!scan.intensities.empty() && scan.intensities.size() != scan.ranges.size())
      refuse("LaserScan::intensities has " + std::to_string(scan.intensities.size()) + " values, but there are " +
             std::to_string(scan.ranges.size()) + " ranges");
    if (scan.ranges.size() > kMostBytes / 8) refuse("LaserScan::ranges has too many values");
  }
  void operator()(const Transforms& transforms) const {
    for (const StampedTransform& transform : transforms) {
      checkStamp(transform.stamp, "StampedTransform::stamp");
      checkText(transform.parent, "StampedTransform::parent");
      checkText(transform.child, "StampedTransform::child");
    }
  }
  void operator()(const Clock& clock) const { checkStamp(clock.time, "Clock::time"); }
  void operator()(const LivoxCustom& custom) const {
    checkStamp(custom.stamp, "LivoxCustom::stamp");
    if (custom.stamp < 0) refuse("LivoxCustom::stamp is before 1970, and its timebase has no sign");
    checkText(custom.frame, "LivoxCustom::frame");
    if (custom.points.size() > kMostBytes / sizeof(LivoxPoint)) refuse("LivoxCustom::points has too many points");
  }
  void operator()(const Imu& imu) const {
    checkStamp(imu.stamp, "Imu::stamp");
    checkText(imu.frame, "Imu::frame");
  }
  void operator()(const Odometry& odometry) const {
    checkStamp(odometry.stamp, "Odometry::stamp");
    checkText(odometry.frame, "Odometry::frame");
    checkText(odometry.childFrame, "Odometry::childFrame");
  }
};

/// A row of the organised cloud of a sensor, whose beams are evenly spaced in azimuth.
struct Row {
  size_t first;
  uint32_t columns;
  double begin, step;  ///< azimuths, rad
  double timeStep;     ///< s

  Row(const Sensor& sensor, uint32_t channel) : first(size_t{channel} * sensor.width()), columns(sensor.width()) {
    if (sensor.isGrid()) {
      begin = (sensor.azimuthStartDeg + sensor.channels[channel].azimuthOffsetDeg) * kDegree;
      step = sensor.azimuthSpanDeg * kDegree / sensor.columns;
      timeStep = sensor.rotationPeriod / sensor.columns;
      return;
    }
    begin = azimuthOf(sensor, first);
    step = columns > 1 ? std::remainder(azimuthOf(sensor, first + 1) - begin, 2 * std::numbers::pi) : 0;
    timeStep = columns > 1 ? (timeOf(sensor, first + columns - 1) - timeOf(sensor, first)) / (columns - 1) : 0;
  }

  /// Whether the azimuths of a list are where begin and step put them, within less than a turn.
  bool isEven(const Sensor& sensor) const {
    constexpr double kTolerance = 1e-4;  // rad, as single precision of directions and decimals of files allow
    if (std::abs(step) * (columns - 1) >= 2 * std::numbers::pi) return false;
    for (uint32_t i = 0; i < columns; ++i) {
      const double azimuth = azimuthOf(sensor, first + i), wanted = begin + step * i;
      if (std::abs(std::remainder(azimuth - wanted, 2 * std::numbers::pi)) > kTolerance) return false;
    }
    return true;
  }
};

/// Returns the row of a channel, or none unless a LaserScan can have its beams.
std::optional<Row> rowOf(const Sensor& sensor, uint32_t channel) {
  constexpr double kSteepest = 1.57;  // rad; beams straight up or down have no azimuth
  if (channel >= sensor.height() || sensor.patterns.size() > 1) return {};
  const Row row(sensor, channel);
  if (row.columns == 0 || std::abs(elevationOf(sensor, row.first)) > kSteepest) return {};
  return sensor.isGrid() || row.isEven(sensor) ? std::optional(row) : std::nullopt;
}

}  // namespace

void check(const Message& message) {
  std::visit(Checker(), message);
}

PointCloud2 cloudOf(const Scan& scan, const std::vector<Field>& fields, const std::string& frame, int64_t stamp) {
  PointCloud2 cloud;
  cloud.stamp = stamp;
  cloud.frame = frame;
  RecordLayout layout = layoutOf(fields);
  layout.compact = true;
  for (const ColumnInfo& column : columnsOf(fields)) {
    cloud.fields.push_back({column.name, cloud.pointStep, typeOf(column.type), 1});
    cloud.pointStep += static_cast<uint32_t>(sizeOf(column.type));
  }
  const auto missed = std::count_if(scan.ranges.begin(), scan.ranges.end(), [](float range) { return range != range; });
  cloud.data.resize((scan.ranges.size() - static_cast<size_t>(missed)) * layout.stride);
  cloud.width = static_cast<uint32_t>(pack(scan, layout, std::as_writable_bytes(std::span(cloud.data))));
  return cloud;
}

bool hasLaserScan(const Sensor& sensor, uint32_t channel) {
  return rowOf(sensor, channel).has_value();
}

LaserScan laserScanOf(const Sensor& sensor, const Scan& scan, uint32_t channel, const std::string& frame,
                      int64_t stamp) {
  if (!scan.sensor.empty() && scan.sensor != sensor.name)
    refuse("the scan is of the sensor " + scan.sensor + ", and not of " + sensor.name +
           ", whose LaserScan was asked for");
  if (channel >= sensor.height() || scan.columns != sensor.width() || scan.channels != sensor.height())
    refuse("the scan has no channel " + std::to_string(channel) + " of the sensor " + sensor.name);
  const std::optional<Row> row = rowOf(sensor, channel);
  if (!row)
    refuse(
        "the channel " + std::to_string(channel) + " of the sensor " + sensor.name +
        " makes no LaserScan, which needs a row of a grid, or a list with one pattern whose beams are evenly spaced in "
        "azimuth; none may point straight up or down");
  const RangeWindow window = rangeWindowOf(sensor, row->first);
  LaserScan laser;
  laser.stamp = stamp;
  laser.frame = frame;
  laser.angleMin = static_cast<float>(row->begin);
  laser.angleMax = static_cast<float>(row->begin + row->step * (row->columns - 1));
  laser.angleIncrement = static_cast<float>(row->step);
  laser.timeIncrement = static_cast<float>(row->timeStep);
  laser.scanTime = static_cast<float>(sensor.scanPeriod > 0 ? sensor.scanPeriod : durationOf(sensor, 0));
  laser.rangeMin = static_cast<float>(window.least);
  laser.rangeMax = static_cast<float>(window.most);
  const std::vector<bool> silent = silentBeams(sensor);
  const bool intense = scan.has(Field::intensity), explained = scan.has(Field::cause);
  for (size_t beam = row->first; beam < row->first + row->columns; ++beam) {
    const size_t entry = beam * scan.returns;
    const bool returned = scan.returned(entry);
    const auto cause = static_cast<Cause>(explained ? scan.column<uint8_t>(Field::cause)[entry] : 0);
    const bool lost = cause == Cause::dead || cause == Cause::droppedOut || cause == Cause::notChosen;
    const bool invalid = silent[beam] || lost;
    float range = std::numeric_limits<float>::infinity();
    if (returned)
      range = scan.ranges[entry];
    else if (invalid)
      range = std::numeric_limits<float>::quiet_NaN();
    else if (cause == Cause::tooNear)
      range = -range;
    laser.ranges.push_back(range);
    if (intense) laser.intensities.push_back(returned ? scan.column<float>(Field::intensity)[entry] : 0);
  }
  return laser;
}

}  // namespace gnosphere::ros2

// SPDX-License-Identifier: Apache-2.0
// Scans in the point layouts of drivers. Each layout is a table of fields, and each field has a function of a return.
#include "ros2/driver_cloud.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <numbers>
#include <span>
#include <type_traits>

#include "base/units.hpp"
#include "base/vector.hpp"
#include "gnosphere/effects.hpp"
#include "gnosphere/error.hpp"
#include "gnosphere/output.hpp"
#include "scan/fields.hpp"
#include "sensor/beams.hpp"

namespace gnosphere::ros2 {
namespace {

constexpr int64_t kPerSecond = 1'000'000'000;

struct Return {
  float x, y, z, range, intensity, time;
  uint16_t ring;
  uint8_t number, count;
  float otherRange, otherIntensity;  ///< those of the beam's other return if it has two
};

/// A return, and what its fields depend on beside it.
struct Point {
  const Return* value;
  const Effects& effects;
  int64_t stamp;   ///< ns, of the cloud
  bool clockwise;  ///< whether azimuths grow clockwise, as the head turns
  bool single;     ///< whether the scan has at most one return of a beam
  bool hasIntensities;
  /// Returns the nanoseconds after the stamp.
  double offset() const { return std::round(double{value->time} * kPerSecond); }
  int64_t time() const { return stamp + static_cast<int64_t>(offset()); }
};

double x(const Point& point) {
  return point.value->x;
}
double y(const Point& point) {
  return point.value->y;
}
double z(const Point& point) {
  return point.value->z;
}
double millimetres(const Point& point) {
  return double{point.value->range} * kMilliPerUnit;
}
double ring(const Point& point) {
  return point.value->ring;
}
double zero(const Point&) {
  return 0;
}
double seconds(const Point& point) {
  return point.value->time;
}
double nanoseconds(const Point& point) {
  return point.offset();
}
double unixNanoseconds(const Point& point) {
  return static_cast<double>(point.time());
}
/// Seconds and their fraction apart, because a double has a step of 256 ns where nanoseconds since 1970 are.
double unixSeconds(const Point& point) {
  const int64_t time = point.time();
  return static_cast<double>(time / kPerSecond) + static_cast<double>(time % kPerSecond) * kNano;
}
/// Returns 100 for a diffuse white surface, more for retro-reflectors, at most 255.
double reflectivity(const Point& point) {
  const bool unit = point.effects.intensity.scale == Effects::Intensity::Scale::unit;
  return std::clamp(double{point.value->intensity} * (unit ? 100 : 1), 0.0, 255.0);
}
/// Returns less than 2 pi in single precision, too: a turn that rounds to more is 0.
double azimuth(const Point& point) {
  constexpr double kTurn = 2 * std::numbers::pi;
  const double angle = std::atan2(point.clockwise ? -y(point) : y(point), x(point));
  const float positive = static_cast<float>((angle < 0 ? kTurn : 0) + angle);
  return positive < kTurn ? positive : 0;
}
double elevation(const Point& point) {
  return std::atan2(z(point), lengthOf(x(point), y(point)));
}
/// Returns the distance from the head's origin, to which azimuth and elevation belong, too. The range counts from where
/// the beam begins.
double distance(const Point& point) {
  return lengthOf({x(point), y(point), z(point)});
}
/// Livox's tag has the number of the return in bits 4 and 5; bits of 0 are a point without doubt.
double livoxTag(const Point& point) {
  return std::min(point.value->number - 1, 3) << 4;
}
/// Whether the effect `returns` is off, so that a beam returns its strongest echo alone.
bool returnsStrongest(const Point& point) {
  const Effects::Returns& returns = point.effects.returns;
  return point.single &&
         (returns.use == EffectUse::off ||
          (returns.use == EffectUse::automatic && returns.mode == Effects::Returns::Mode::all && returns.count == 0));
}
/// Returns the received power, up to a factor: the intensity is the reflectance of a target at the range.
double powerOf(double intensity, double range, const Effects& effects) {
  const bool byte = effects.intensity.scale == Effects::Intensity::Scale::byte;
  const double unit = byte && intensity > 100 ? 100 * std::pow(1000, (intensity - 100) / 155) : intensity;
  return effects.intensity.scale == Effects::Intensity::Scale::raw ? intensity : unit / (range * range);
}
/// Whether a return is the stronger one of the two of its beam. Of two equally strong returns the nearer one counts.
bool isStronger(const Point& point) {
  const Return& value = *point.value;
  const double own = powerOf(value.intensity, value.range, point.effects);
  const double other = powerOf(value.otherIntensity, value.otherRange, point.effects);
  return own > other || (own == other && value.number == 1);
}
/// Autoware's ReturnType: 0 unless the effect `returns` tells which one is the strongest or the last.
double autowareReturn(const Point& point) {
  using Mode = Effects::Returns::Mode;
  enum Type { unknown, singleStrongest, singleLast, strongestFirst, strongestLast, weakFirst, weakLast, dualOnly };
  if (returnsStrongest(point)) return singleStrongest;
  const bool isFirst = point.value->number == 1;
  bool isStrongest = isFirst;
  switch (point.effects.returns.mode) {
    case Mode::strongest: return singleStrongest;
    case Mode::last: return singleLast;
    case Mode::lastStrongest: break;
    case Mode::firstStrongest: isStrongest = !isFirst; break;
    case Mode::dual:
    case Mode::strongestSecondStrongest:
      if (!point.hasIntensities) return unknown;
      isStrongest = isStronger(point);
      break;
    default: return unknown;
  }
  if (point.value->count < 2) return dualOnly;
  return isStrongest ? (isFirst ? strongestFirst : strongestLast) : (isFirst ? weakFirst : weakLast);
}

using Type = PointField::Type;

struct DriverField {
  const char* name;
  uint32_t offset;
  Type type;
  double (*valueOf)(const Point&);
};

// clang-format off
// velodyne_pointcloud 2 publishes these with timestamp_first_packet (PointXYZIRT).
constexpr DriverField kVelodyne[] = {
    {"x", 0, Type::f32, x}, {"y", 4, Type::f32, y}, {"z", 8, Type::f32, z},
    {"intensity", 12, Type::f32, reflectivity}, {"ring", 16, Type::u16, ring}, {"time", 18, Type::f32, seconds}};
// ouster-ros publishes these with the point_type "original" (ouster_ros::Point, whose size is a multiple of 16).
constexpr DriverField kOuster[] = {
    {"x", 0, Type::f32, x}, {"y", 4, Type::f32, y}, {"z", 8, Type::f32, z},
    {"intensity", 16, Type::f32, reflectivity}, {"t", 20, Type::u32, nanoseconds},
    {"reflectivity", 24, Type::u16, reflectivity}, {"ring", 26, Type::u16, ring}, {"ambient", 28, Type::u16, zero},
    {"range", 32, Type::u32, millimetres}};
// HesaiLidar_ROS_2.0 (PointXYZIRT) and rslidar_sdk (POINT_TYPE XYZIRT) publish these.
constexpr DriverField kHesai[] = {
    {"x", 0, Type::f32, x}, {"y", 4, Type::f32, y}, {"z", 8, Type::f32, z},
    {"intensity", 12, Type::f32, reflectivity}, {"ring", 16, Type::u16, ring},
    {"timestamp", 18, Type::f64, unixSeconds}};
// livox_ros_driver2 publishes these with xfer_format 0 (LivoxPointXyzrtlt).
constexpr DriverField kLivox[] = {
    {"x", 0, Type::f32, x}, {"y", 4, Type::f32, y}, {"z", 8, Type::f32, z},
    {"intensity", 12, Type::f32, reflectivity}, {"tag", 16, Type::u8, livoxTag}, {"line", 17, Type::u8, ring},
    {"timestamp", 18, Type::f64, unixNanoseconds}};
// livox_ros_driver2 publishes these with xfer_format 1 (CustomPoint). The offsets are those in a LivoxPoint.
constexpr DriverField kCustomFields[] = {
    {"offset_time", offsetof(LivoxPoint, offsetTime), Type::u32, nanoseconds},
    {"x", offsetof(LivoxPoint, x), Type::f32, x}, {"y", offsetof(LivoxPoint, y), Type::f32, y},
    {"z", offsetof(LivoxPoint, z), Type::f32, z},
    {"reflectivity", offsetof(LivoxPoint, reflectivity), Type::u8, reflectivity},
    {"tag", offsetof(LivoxPoint, tag), Type::u8, livoxTag}, {"line", offsetof(LivoxPoint, line), Type::u8, ring}};
// Nebula's drivers publish the PointXYZIRCAEDT of autoware_point_types.
constexpr DriverField kAutoware[] = {
    {"x", 0, Type::f32, x}, {"y", 4, Type::f32, y}, {"z", 8, Type::f32, z},
    {"intensity", 12, Type::u8, reflectivity}, {"return_type", 13, Type::u8, autowareReturn},
    {"channel", 14, Type::u16, ring}, {"azimuth", 16, Type::f32, azimuth}, {"elevation", 20, Type::f32, elevation},
    {"distance", 24, Type::f32, distance}, {"time_stamp", 28, Type::u32, nanoseconds}};
// clang-format on

struct DriverLayout {
  const char* name;  ///< in drive files
  std::span<const DriverField> fields;
  uint32_t step;
};
constexpr DriverLayout kCustom = {"livox", kCustomFields, sizeof(LivoxPoint)};
/// In the order of Driver.
constexpr DriverLayout kLayouts[] = {{"velodyne", kVelodyne, 22}, {"ouster", kOuster, 48}, {"hesai", kHesai, 26},
                                     {"robosense", kHesai, 26},   {"livox", kLivox, 26},   {"autoware", kAutoware, 32}};

std::vector<Return> returnsOf(const Scan& scan) {
  RecordLayout layout;
  layout.stride = sizeof(Return);
  layout.compact = true;
  layout.values = {{Field::x, 0, offsetof(Return, x), ValueType::f32},
                   {Field::y, 0, offsetof(Return, y), ValueType::f32},
                   {Field::z, 0, offsetof(Return, z), ValueType::f32},
                   {Field::range, 0, offsetof(Return, range), ValueType::f32},
                   {Field::time, 0, offsetof(Return, time), ValueType::f32},
                   {Field::ring, 0, offsetof(Return, ring), ValueType::u16},
                   {Field::returnNumber, 0, offsetof(Return, number), ValueType::u8},
                   {Field::returnCount, 0, offsetof(Return, count), ValueType::u8}};
  if (scan.has(Field::intensity))
    layout.values.push_back({Field::intensity, 0, offsetof(Return, intensity), ValueType::f32});
  std::vector<Return> returns(scan.ranges.size(), Return{});
  returns.resize(pack(scan, layout, std::as_writable_bytes(std::span(returns))));
  for (size_t i = 0; i + 1 < returns.size(); ++i) {
    Return &first = returns[i], &second = returns[i + 1];
    if (first.number != 1 || second.number != 2) continue;  // the returns of a beam follow each other
    first.otherRange = second.range, first.otherIntensity = second.intensity;
    second.otherRange = first.range, second.otherIntensity = first.intensity;
  }
  // NaN compares with nothing, so returns without a time come last.
  const auto isEarlier = [](const Return& a, const Return& b) {
    return a.time < b.time || (b.time != b.time && a.time == a.time);
  };
  std::stable_sort(returns.begin(), returns.end(), isEarlier);
  return returns;
}

template <typename T>
T as(double value) {
  if constexpr (std::is_floating_point_v<T>)
    return static_cast<T>(value);
  else  // a time before the stamp is 0, and so is NaN
    return static_cast<T>(std::min(std::max(0.0, std::round(value)), double{std::numeric_limits<T>::max()}));
}

template <typename T>
void fill(PointCloud2& cloud, const DriverField& field, std::span<const Return> returns, Point point) {
  uint8_t* to = cloud.data.data() + field.offset;
  for (const Return& value : returns) {
    point.value = &value;
    const T converted = as<T>(field.valueOf(point));
    std::memcpy(to, &converted, sizeof(converted));
    to += cloud.pointStep;
  }
}

/// Returns the most that an unsigned type holds.
double mostOf(Type type) {
  switch (type) {
    case Type::u8: return std::numeric_limits<uint8_t>::max();
    case Type::u16: return std::numeric_limits<uint16_t>::max();
    default: return std::numeric_limits<uint32_t>::max();
  }
}

/// Returns why a layout does not hold times up to `last` seconds and rings up to `lastRing`; empty if it does.
std::string mistakeOf(const DriverLayout& layout, double last, uint32_t lastRing) {
  for (const DriverField& field : layout.fields) {
    const std::string subject = std::string("the field '") + field.name + "' of the driver " + layout.name + " ";
    if (field.valueOf == nanoseconds && last * kPerSecond > mostOf(field.type))
      return subject + "has times up to 4.29 s, and the scan takes longer";
    if (field.valueOf == ring && lastRing > mostOf(field.type))
      return subject + "has numbers up to " + std::to_string(static_cast<uint32_t>(mostOf(field.type))) +
             ", and the scan has more channels";
  }
  return "";
}

PointCloud2 cloudOf(const Scan& scan, const DriverLayout& layout, const std::string& frame, int64_t stamp,
                    const Effects& effects) {
  const std::vector<Return> returns = returnsOf(scan);
  uint32_t lastRing = 0;
  for (const Return& value : returns) lastRing = std::max<uint32_t>(lastRing, value.ring);
  if (const std::string why = mistakeOf(layout, returns.empty() ? 0 : returns.back().time, lastRing); !why.empty())
    throw Error(ErrorCode::invalidArgument, why);
  PointCloud2 cloud;
  cloud.stamp = stamp;
  cloud.frame = frame;
  cloud.width = static_cast<uint32_t>(returns.size());
  cloud.pointStep = layout.step;
  cloud.data.resize(returns.size() * layout.step);
  // Later columns of a head that turns fire later.
  const Point point = {nullptr, effects, stamp, scan.firstColumnOnLeft, scan.returns == 1, scan.has(Field::intensity)};
  for (const DriverField& field : layout.fields) {
    cloud.fields.push_back({field.name, field.offset, field.type, 1});
    switch (field.type) {
      case Type::u8: fill<uint8_t>(cloud, field, returns, point); break;
      case Type::u16: fill<uint16_t>(cloud, field, returns, point); break;
      case Type::u32: fill<uint32_t>(cloud, field, returns, point); break;
      case Type::f64: fill<double>(cloud, field, returns, point); break;
      default: fill<float>(cloud, field, returns, point); break;
    }
  }
  return cloud;
}

}  // namespace

std::optional<Driver> driverNamed(std::string_view name) {
  for (size_t i = 0; i < std::size(kLayouts); ++i)
    if (name == kLayouts[i].name) return static_cast<Driver>(i);
  return std::nullopt;
}

uint32_t lastRingOf(const Sensor& sensor) {
  uint32_t last = static_cast<uint32_t>(std::max<size_t>(sensor.channels.size(), 1)) - 1;
  for (const BeamList& list : sensor.patterns)
    for (const uint16_t ring : list.rings) last = std::max<uint32_t>(last, ring);
  return last;
}

std::string mistakeOfDriver(const Sensor& sensor, std::optional<Driver> driver) {
  double last = lastTimeOf(sensor);
  for (size_t channel = 0; channel < sensor.channels.size() && sensor.columns > 0; ++channel)
    last = std::max(last, timeOf(sensor, (channel + 1) * sensor.columns - 1));  // of the last column
  return mistakeOf(driver ? kLayouts[static_cast<size_t>(*driver)] : kCustom, last, lastRingOf(sensor));
}

PointCloud2 driverCloudOf(const Scan& scan, Driver driver, const std::string& frame, int64_t stamp,
                          const Effects& effects) {
  if (static_cast<size_t>(driver) >= std::size(kLayouts))
    throw Error(ErrorCode::invalidArgument,
                "driverCloudOf: there is no driver " + std::to_string(static_cast<int>(driver)));
  return cloudOf(scan, kLayouts[static_cast<size_t>(driver)], frame, stamp, effects);
}

LivoxCustom livoxCustomOf(const Scan& scan, const std::string& frame, int64_t stamp, const Effects& effects) {
  static_assert(std::is_standard_layout_v<LivoxPoint> && std::is_trivially_copyable_v<LivoxPoint>);
  const PointCloud2 cloud = cloudOf(scan, kCustom, frame, stamp, effects);
  LivoxCustom custom;
  custom.stamp = stamp;
  custom.frame = frame;
  custom.points.resize(cloud.width);
  if (cloud.width > 0) std::memcpy(custom.points.data(), cloud.data.data(), cloud.data.size());
  return custom;
}

}  // namespace gnosphere::ros2

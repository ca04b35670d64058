// SPDX-License-Identifier: Apache-2.0
#include "drive/ros.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "base/json_text.hpp"
#include "drive/formats/format.hpp"
#include "drive/pose_math.hpp"
#include "drive/schedule.hpp"

namespace gnosphere::drive {

namespace {

/// Returns the times of the numbers `first` to `next` - 1 at a rate, or of those from `first` on until all scans have
/// ended in the `last` frame.
std::vector<double> timesOf(const Drive& drive, uint64_t frame, bool last, uint64_t first, uint64_t next, double rate) {
  const double end = last ? endOfScans(drive, frame) : 0;
  std::vector<double> times;
  for (uint64_t i = first; last ? times.empty() || times.back() < end : i < next; ++i)
    times.push_back(drive.start + static_cast<double>(i) / rate);
  return times;
}

}  // namespace

std::vector<Field> usualCloudFields(const Drive& drive, std::span<const size_t> sensors) {
  std::vector<Field> fields = parseFields(formatNamed("mcap").fields);
  const bool lists = std::ranges::any_of(sensors, [&](size_t index) {
    const RigSensor& sensor = drive.sensors[index];
    return !sensor.sensor.isGrid() && !sensor.driver && !sensor.livoxCustom;
  });
  if (lists) fields.push_back(Field::beam);
  return fields;
}

std::vector<Field> liveFieldsOf(const Drive& drive, size_t sensor) {
  const auto found = std::ranges::find_if(drive.outputs, [&](const Output& output) {
    return output.format == "mcap" && std::ranges::find(output.sensors, sensor) != output.sensors.end();
  });
  return found != drive.outputs.end() ? found->fields : usualCloudFields(drive, {&sensor, 1});
}

ros2::MessageType cloudTypeOf(const RigSensor& sensor) {
  return sensor.livoxCustom ? ros2::MessageType::livoxCustom : ros2::MessageType::pointCloud2;
}

ros2::Message cloudMessage(const Drive& drive, const RecordedScan& recorded, std::vector<Field> fields) {
  const RigSensor& sensor = drive.sensors[recorded.planned.sensor];
  const int64_t stamp = unixNanoseconds(drive, recorded.planned.time);
  if (sensor.livoxCustom) return ros2::livoxCustomOf(recorded.scan, sensor.name, stamp, sensor.effects);
  if (sensor.driver) return ros2::driverCloudOf(recorded.scan, *sensor.driver, sensor.name, stamp, sensor.effects);
  if (!recorded.scan.has(Field::intensity)) std::erase(fields, Field::intensity);
  ros2::PointCloud2 cloud = ros2::cloudOf(recorded.scan, fields, sensor.name, stamp);
  for (const ros2::PointField& field : cloud.fields)
    if (field.name == "intensity")
      scaleFloat(std::as_writable_bytes(std::span(cloud.data)), cloud.pointStep, field.offset,
                 intensityFactor(sensor, 1));
  return cloud;
}

bool isFlat(const Sensor& sensor) {
  return sensor.height() == 1 && ros2::hasLaserScan(sensor);
}

ros2::LaserScan laserMessage(const Drive& drive, const RecordedScan& recorded) {
  const RigSensor& sensor = drive.sensors[recorded.planned.sensor];
  ros2::LaserScan message =
      ros2::laserScanOf(sensor.sensor, recorded.scan, 0, sensor.name, unixNanoseconds(drive, recorded.planned.time));
  const float factor = intensityFactor(sensor, 1);
  for (float& intensity : message.intensities) intensity *= factor;
  message.scanTime = static_cast<float>(1 / sensor.rate);
  return message;
}

ros2::Transforms vehicleMessage(const Drive& drive, double time) {
  return {{unixNanoseconds(drive, time), drive.worldFrame, drive.vehicleFrame, drive.ego.at(time)}};
}

ros2::Odometry odometryMessage(const Drive& drive, double time) {
  const Trajectory::Rates rates = drive.ego.ratesAt(time);
  ros2::Odometry odometry;
  odometry.stamp = unixNanoseconds(drive, time);
  odometry.frame = drive.worldFrame;
  odometry.childFrame = drive.vehicleFrame;
  odometry.pose = drive.ego.at(time);
  odometry.linearVelocity = inverse(odometry.pose).orientation * rates.velocity;
  odometry.angularVelocity = rates.turnRate;
  return odometry;
}

uint64_t firstMeasurement(const Drive& drive, uint64_t frame) {
  return static_cast<uint64_t>(std::ceil(static_cast<double>(frame) / drive.rate * drive.imu->rate - 1e-6));
}

std::vector<double> imuTimes(const Drive& drive, uint64_t frame, bool last) {
  return timesOf(drive, frame, last, firstMeasurement(drive, frame), firstMeasurement(drive, frame + 1),
                 drive.imu->rate);
}

ros2::Imu imuMessage(const Drive& drive, double time) {
  const InertialUnit& unit = *drive.imu;
  const Pose pose = drive.ego.at(time) * unit.mount;
  const Trajectory::Rates rates = drive.ego.ratesAt(time, unit.mount, 1 / unit.rate);
  ros2::Imu imu;
  imu.stamp = unixNanoseconds(drive, time);
  imu.frame = unit.name;
  imu.orientation = pose.orientation;
  imu.angularVelocity = rates.turnRate;
  imu.linearAcceleration = inverse(pose).orientation * (rates.acceleration + Vec3{0, 0, kGravity});
  return imu;
}

std::string topicOf(std::string name, const std::string& what) {
  std::replace(name.begin(), name.end(), '-', '_');
  return "/" + name + what;
}

ros2::Transforms mountsOf(const Drive& drive, std::span<const size_t> sensors) {
  ros2::Transforms mounts;
  const int64_t stamp = unixNanoseconds(drive, drive.start);
  for (const size_t index : sensors)
    mounts.push_back({stamp, drive.vehicleFrame, drive.sensors[index].name, drive.sensors[index].mount});
  if (drive.imu) mounts.push_back({stamp, drive.vehicleFrame, drive.imu->name, drive.imu->mount});
  return mounts;
}

std::string mistakeOfNames(const Drive& drive, std::span<const size_t> sensors) {
  std::set<std::string> topics;
  std::vector<std::pair<std::string, std::string>> named;
  for (const size_t index : sensors) named.emplace_back("sensor", drive.sensors[index].name);
  if (drive.imu) named.emplace_back("imu", drive.imu->name);
  for (const auto& [kind, name] : named) {
    const std::string subject = "the " + kind + " '" + name + "' ";
    if (std::isdigit(static_cast<unsigned char>(name[0])))
      return subject + "begins with a digit, which topics of ROS 2 must not";
    if (name == drive.worldFrame || name == drive.vehicleFrame)
      return subject + "has the name of the frame of the " + (name == drive.worldFrame ? "world" : "vehicle");
    if (!topics.insert(topicOf(name, "")).second)
      return subject + "has the topic of another one, because topics of ROS 2 have _ for -";
  }
  return "";
}

std::string mistakeOfTimes(const Drive& drive) {
  const double first = drive.epoch + drive.start, last = first + drive.duration;
  if (first > -2147483648.0 && last < 2147483647.0) return "";
  return "epoch and start lead to times from " + jsonText(nlohmann::json(first)) + " s to " +
         jsonText(nlohmann::json(last)) + " s, and ROS 2 has 32 bits for seconds";
}

uint64_t posesPerFrame(const Drive& drive) {
  constexpr double kPerSecond = 100, kMostPerSecond = 1000, kPerFrame = 10;
  constexpr double kEnough = 0.99;  // of the rate of the stamps, whose times a file rounds
  const double spacing = drive.ego.spacing();
  const double ofStamps = spacing > 0 ? std::min(kEnough / spacing, kMostPerSecond) : 0;
  return static_cast<uint64_t>(std::max(kPerFrame, std::ceil(std::max(kPerSecond, ofStamps) / drive.rate - 1e-6)));
}

std::vector<double> poseTimes(const Drive& drive, uint64_t frame, bool last) {
  const uint64_t count = posesPerFrame(drive);
  return timesOf(drive, frame, last, frame * count, (frame + 1) * count, drive.rate * static_cast<double>(count));
}

}  // namespace gnosphere::drive

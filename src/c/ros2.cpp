// SPDX-License-Identifier: Apache-2.0
// The C interface to messages of ROS 2.
#include <gnosphere_ros2.h>

#include <array>
#include <gnosphere/ros2.hpp>
#include <tuple>

#include "c/handles.hpp"

namespace gnosphere::c {

GNO_HELD(gno_ros2_publisher, ros2::Publisher, "publisher")

namespace {

GNO_SAME_ENUM(ros2::MessageType, {GNO_ROS2_POINT_CLOUD2, pointCloud2}, {GNO_ROS2_LASER_SCAN, laserScan},
              {GNO_ROS2_TRANSFORMS, transforms}, {GNO_ROS2_CLOCK, clock}, {GNO_ROS2_IMU, imu},
              {GNO_ROS2_LIVOX_CUSTOM, livoxCustom}, {GNO_ROS2_ODOMETRY, odometry});
GNO_SAME_ENUM(ros2::Qos::Reliability, {GNO_ROS2_RELIABLE, reliable}, {GNO_ROS2_BEST_EFFORT, bestEffort});
GNO_SAME_ENUM(ros2::Qos::Durability, {GNO_ROS2_VOLATILE, volatileData}, {GNO_ROS2_TRANSIENT_LOCAL, transientLocal});
GNO_SAME_ENUM(ros2::Driver, {GNO_ROS2_VELODYNE, velodyne}, {GNO_ROS2_OUSTER, ouster}, {GNO_ROS2_HESAI, hesai},
              {GNO_ROS2_ROBOSENSE, robosense}, {GNO_ROS2_LIVOX, livox}, {GNO_ROS2_AUTOWARE, autoware});

/// A publisher has a lock of its own, so that publishing does not wait for flushing.
class Publishing {
 public:
  explicit Publishing(gno_ros2_publisher handle) : object_(find(handle)) {}
  ros2::Publisher* operator->() { return &object_->value; }

 private:
  Shared<gno_ros2_publisher> object_;
};

ros2::PublisherOptions publisherOptionsOf(const gno_ros2_options* options) {
  ros2::PublisherOptions result;
  if (!options) return result;
  const gno_ros2_options& from = sized(options, GNO_TYPE(gno_ros2_options));
  result.qos.reliability =
      enumOf(from.reliability, ros2::Qos::Reliability::bestEffort, "gno_ros2_options::reliability");
  result.qos.durability =
      enumOf(from.durability, ros2::Qos::Durability::transientLocal, "gno_ros2_options::durability");
  result.qos.depth = from.depth;
  if (from.domain < -1) refuse("gno_ros2_options::domain is " + std::to_string(from.domain) + "; it is -1 or 0 to 232");
  if (from.localhost_only < -1 || from.localhost_only > 1)
    refuse("gno_ros2_options::localhost_only is " + std::to_string(from.localhost_only) + "; it is -1, 0 or 1");
  if (from.domain >= 0) result.domain = static_cast<uint32_t>(from.domain);
  if (from.localhost_only >= 0) result.localhostOnly = from.localhost_only != 0;
  return result;
}

ros2::PointCloud2 cloudFrom(const gno_ros2_cloud* cloud) {
  const gno_ros2_cloud& from = sized(cloud, GNO_TYPE(gno_ros2_cloud));
  ros2::PointCloud2 result;
  result.stamp = from.stamp;
  result.frame = orEmpty(from.frame);
  result.height = from.height;
  result.width = from.width;
  for (const gno_ros2_field& field : array(from.fields, from.field_count, "gno_ros2_cloud::fields"))
    result.fields.push_back(
        {orEmpty(field.name), field.offset, static_cast<ros2::PointField::Type>(field.type), field.count});
  result.pointStep = from.point_step;
  const auto data = array(static_cast<const uint8_t*>(from.data), from.bytes, "gno_ros2_cloud::data");
  result.data.assign(data.begin(), data.end());
  result.dense = from.dense != 0;
  return result;
}

ros2::LaserScan laserFrom(const gno_ros2_laser* laser) {
  const gno_ros2_laser& from = sized(laser, GNO_TYPE(gno_ros2_laser));
  ros2::LaserScan result;
  result.stamp = from.stamp;
  result.frame = orEmpty(from.frame);
  result.angleMin = from.angle_min;
  result.angleMax = from.angle_max;
  result.angleIncrement = from.angle_increment;
  result.timeIncrement = from.time_increment;
  result.scanTime = from.scan_time;
  result.rangeMin = from.range_min;
  result.rangeMax = from.range_max;
  const auto ranges = array(from.ranges, from.range_count, "gno_ros2_laser::ranges");
  result.ranges.assign(ranges.begin(), ranges.end());
  if (from.intensities) result.intensities.assign(from.intensities, from.intensities + from.range_count);
  return result;
}

ros2::Imu imuFrom(const gno_ros2_imu* imu) {
  const gno_ros2_imu& from = sized(imu, GNO_TYPE(gno_ros2_imu));
  const auto& [q, w, a] = std::tie(from.orientation, from.angular_velocity, from.linear_acceleration);
  ros2::Imu result;
  result.stamp = from.stamp;
  result.frame = orEmpty(from.frame);
  result.orientation = {q[0], q[1], q[2], q[3]};
  result.angularVelocity = {w[0], w[1], w[2]};
  result.linearAcceleration = {a[0], a[1], a[2]};
  result.orientationCovariance = std::to_array(from.orientation_covariance);
  result.angularVelocityCovariance = std::to_array(from.angular_velocity_covariance);
  result.linearAccelerationCovariance = std::to_array(from.linear_acceleration_covariance);
  return result;
}

ros2::Odometry odometryFrom(const gno_ros2_odometry* odometry) {
  const gno_ros2_odometry& from = sized(odometry, GNO_TYPE(gno_ros2_odometry));
  const auto& [v, w] = std::tie(from.linear_velocity, from.angular_velocity);
  ros2::Odometry result;
  result.stamp = from.stamp;
  result.frame = orEmpty(from.frame);
  result.childFrame = orEmpty(from.child_frame);
  result.pose = poseOf(from.pose);
  result.poseCovariance = std::to_array(from.pose_covariance);
  result.linearVelocity = {v[0], v[1], v[2]};
  result.angularVelocity = {w[0], w[1], w[2]};
  result.twistCovariance = std::to_array(from.twist_covariance);
  return result;
}

Effects effectsOrAutomatic(gno_effects effects) {
  return effects ? *Locked(effects) : Effects();
}

}  // namespace
}  // namespace gnosphere::c

using namespace gnosphere;
using namespace gnosphere::c;

extern "C" {

const char* gno_ros2_unavailable(void) {
  try {
    static const auto& why = *new std::string(ros2::unavailable());  // also for threads that outlive static objects
    return why.c_str();
  } catch (...) {  // the next call tries again
    return "there is not enough memory";
  }
}

gno_status gno_ros2_publisher_create(gno_ros2_type type, const char* topic, const gno_ros2_options* options,
                                     gno_ros2_publisher* publisher) {
  return giveHandle(publisher, "publisher", [&] {
    return make<gno_ros2_publisher>(ros2::Publisher(enumOf(type, ros2::MessageType::odometry, "gno_ros2_type"),
                                                    &the(topic, "topic"), publisherOptionsOf(options)));
  });
}
gno_status gno_ros2_publisher_destroy(gno_ros2_publisher publisher) {
  return guard([&] { destroy(publisher); });
}

gno_status gno_ros2_publish_cloud(gno_ros2_publisher publisher, const gno_ros2_cloud* cloud) {
  return guard([&] { Publishing(publisher)->publish(cloudFrom(cloud)); });
}
gno_status gno_ros2_publish_laser(gno_ros2_publisher publisher, const gno_ros2_laser* laser) {
  return guard([&] { Publishing(publisher)->publish(laserFrom(laser)); });
}
gno_status gno_ros2_publish_transforms(gno_ros2_publisher publisher, const gno_ros2_transform* transforms,
                                       size_t count) {
  return guard([&] {
    ros2::Transforms list;
    for (const gno_ros2_transform& from : array(transforms, count, "transforms"))
      list.push_back({from.stamp, orEmpty(from.parent), orEmpty(from.child), poseOf(from.pose)});
    Publishing(publisher)->publish(std::move(list));
  });
}
gno_status gno_ros2_publish_clock(gno_ros2_publisher publisher, int64_t nanoseconds) {
  return guard([&] { Publishing(publisher)->publish(ros2::Clock{nanoseconds}); });
}
gno_status gno_ros2_publish_imu(gno_ros2_publisher publisher, const gno_ros2_imu* imu) {
  return guard([&] { Publishing(publisher)->publish(imuFrom(imu)); });
}
gno_status gno_ros2_publish_odometry(gno_ros2_publisher publisher, const gno_ros2_odometry* odometry) {
  return guard([&] { Publishing(publisher)->publish(odometryFrom(odometry)); });
}
gno_status gno_ros2_publish_scan(gno_ros2_publisher publisher, gno_scan scan, const gno_field* fields,
                                 size_t field_count, const char* frame, int64_t stamp) {
  return guard([&] {
    Publishing to(publisher);
    to->publish(ros2::cloudOf(*Locked(scan), fieldsOf(fields, field_count), orEmpty(frame), stamp));
  });
}
gno_status gno_ros2_publish_driver_scan(gno_ros2_publisher publisher, gno_scan scan, gno_ros2_driver driver,
                                        const char* frame, int64_t stamp, gno_effects effects) {
  return guard([&] {
    Publishing to(publisher);
    to->publish(ros2::driverCloudOf(*Locked(scan), enumOf(driver, ros2::Driver::autoware, "gno_ros2_driver"),
                                    orEmpty(frame), stamp, effectsOrAutomatic(effects)));
  });
}
gno_status gno_ros2_publish_livox_custom(gno_ros2_publisher publisher, gno_scan scan, const char* frame, int64_t stamp,
                                         gno_effects effects) {
  return guard([&] {
    Publishing to(publisher);
    to->publish(ros2::livoxCustomOf(*Locked(scan), orEmpty(frame), stamp, effectsOrAutomatic(effects)));
  });
}
gno_status gno_ros2_publish_channel(gno_ros2_publisher publisher, gno_sensor sensor, gno_scan scan, uint32_t channel,
                                    const char* frame, int64_t stamp) {
  return guard([&] {
    Publishing to(publisher);
    const Sensor of = Locked(sensor)->sensor;
    to->publish(ros2::laserScanOf(of, *Locked(scan), channel, orEmpty(frame), stamp));
  });
}

gno_status gno_ros2_publisher_flush(gno_ros2_publisher publisher, double seconds, int32_t* done) {
  return guard([&] { the(done, "done") = Publishing(publisher)->flush(seconds); });
}
gno_status gno_ros2_publisher_counts(gno_ros2_publisher publisher, gno_ros2_counts* counts) {
  return guard([&] {
    const Out to(counts, GNO_TYPE(gno_ros2_counts));
    const ros2::PublisherCounts from = Publishing(publisher)->counts();
    to->published = from.published;
    to->sent = from.sent;
    to->dropped = from.dropped;
    to->waiting = from.waiting;
    to->subscribers = from.subscribers;
  });
}

}  // extern "C"

// SPDX-License-Identifier: Apache-2.0
// Publishes messages that nodes of ROS 2 receive, without ROS: docs/ros2.md. Publishing needs libgnosphere_ros2, which
// is opened when the first publisher is made.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "gnosphere/effects.hpp"
#include "gnosphere/scan.hpp"

namespace gnosphere::ros2 {

/// A field of a PointCloud2. The enumerators of Type have the numbers that ROS gives them.
struct PointField {
  enum class Type : uint8_t { i8 = 1, u8, i16, u16, i32, u32, f32, f64 };
  std::string name;
  uint32_t offset = 0;  ///< bytes from the start of the point
  Type type = Type::f32;
  uint32_t count = 1;
};

/// A message of type sensor_msgs/PointCloud2.
struct PointCloud2 {
  int64_t stamp = 0;  ///< nanoseconds since 1970, or since the start of a simulated clock
  std::string frame;
  uint32_t height = 1, width = 0;
  std::vector<PointField> fields;
  uint32_t pointStep = 0;     ///< bytes of a point
  std::vector<uint8_t> data;  ///< height * width points, little-endian
  bool dense = true;          ///< whether every point is a number
};

/// A message of type sensor_msgs/LaserScan.
struct LaserScan {
  int64_t stamp = 0;  ///< of the first ray, nanoseconds
  std::string frame;
  float angleMin = 0, angleMax = 0, angleIncrement = 0;  ///< rad, counter-clockwise from the x axis
  float timeIncrement = 0, scanTime = 0;                 ///< s between rays, and between scans
  float rangeMin = 0, rangeMax = 0;                      ///< m
  std::vector<float> ranges;                             ///< m; +inf where nothing is hit, NaN where a beam is dead
  std::vector<float> intensities;                        ///< one per range, or none
};

/// geometry_msgs/TransformStamped: the pose of a frame in its parent.
struct StampedTransform {
  int64_t stamp = 0;  ///< nanoseconds
  std::string parent, child;
  Pose pose;
};
using Transforms = std::vector<StampedTransform>;  ///< tf2_msgs/TFMessage

/// A message of type rosgraph_msgs/Clock.
struct Clock {
  int64_t time = 0;  ///< nanoseconds
};

/// A message of type sensor_msgs/Imu. A covariance is a matrix of three rows; all zeros mean that it is unknown.
struct Imu {
  int64_t stamp = 0;  ///< nanoseconds
  std::string frame;
  Quaternion orientation;  ///< maps the frame of the unit to the world
  std::array<double, 9> orientationCovariance{};
  Vec3 angularVelocity;  ///< rad/s about the axes of the unit
  std::array<double, 9> angularVelocityCovariance{};
  Vec3 linearAcceleration;  ///< m/s^2 along the axes of the unit; upwards 9.8 at rest
  std::array<double, 9> linearAccelerationCovariance{};
};

/// A message of type nav_msgs/Odometry. A covariance is a matrix of six rows: x, y, z, and about these axes.
struct Odometry {
  int64_t stamp = 0;              ///< nanoseconds
  std::string frame, childFrame;  ///< in which the pose is, and whose pose it is
  Pose pose;
  std::array<double, 36> poseCovariance{};
  Vec3 linearVelocity;   ///< m/s along the axes of the child frame
  Vec3 angularVelocity;  ///< rad/s about the axes of the child frame
  std::array<double, 36> twistCovariance{};
};

/// A point of a LivoxCustom.
struct LivoxPoint {
  uint32_t offsetTime = 0;  ///< ns after LivoxCustom::stamp
  float x = 0, y = 0, z = 0;
  uint8_t reflectivity = 0;
  uint8_t tag = 0;   ///< the number of the return, from 0 on, in bits 4 and 5
  uint8_t line = 0;  ///< the channel
};

/// A message of type livox_ros_driver2/CustomMsg, whose timebase is the stamp.
struct LivoxCustom {
  int64_t stamp = 0;  ///< nanoseconds
  std::string frame;
  uint8_t lidarId = 0;
  std::vector<LivoxPoint> points;
};

/// A message that a publisher can send.
using Message = std::variant<PointCloud2, LaserScan, Transforms, Clock, Imu, LivoxCustom, Odometry>;
/// In the order of Message.
enum class MessageType { pointCloud2, laserScan, transforms, clock, imu, livoxCustom, odometry };

/// Quality of service (QoS) of a publisher. Messages beyond `depth` replace the oldest ones ("keep last").
struct Qos {
  enum class Reliability { reliable, bestEffort };
  enum class Durability { volatileData, transientLocal };  ///< transientLocal: who subscribes late gets the last ones
  Reliability reliability = Reliability::reliable;
  Durability durability = Durability::volatileData;
  uint32_t depth = 5;
};

/// Options of a publisher, beside its topic.
struct PublisherOptions {
  Qos qos;
  std::optional<uint32_t> domain;  ///< 0 to 232; by default the value of ROS_DOMAIN_ID, or 0
  /// Whether only subscribers on this machine are found, or also those on its networks and the peers of
  /// ROS_STATIC_PEERS. By default ROS_LOCALHOST_ONLY and ROS_AUTOMATIC_DISCOVERY_RANGE decide. All topics of a domain
  /// must have the same value.
  std::optional<bool> localhostOnly;
};

/// Numbers of messages of a publisher, by what has become of them.
struct PublisherCounts {
  uint64_t published = 0;    ///< messages that were given to publish()
  uint64_t sent = 0;         ///< published messages that went to the network
  uint64_t dropped = 0;      ///< published messages that newer ones replaced before, or that the network refused
  uint64_t waiting = 0;      ///< published messages that wait to be sent
  uint32_t subscribers = 0;  ///< now
};

/// Publishes the messages of one topic. A thread of its own sends them, so that publish() never waits for subscribers
/// or for the network. Any thread may call any function. A publisher that was moved to another variable cannot be
/// called any more: calls throw Error(invalidArgument).
class Publisher {
 public:
  /// `topic` is a name of ROS, such as "points" or "/front/points". Throws Error(invalidArgument) for a name that ROS
  /// does not allow and for other wrong arguments, and Error(device) that says what is missing if GnoSphere was built
  /// without Cyclone DDS, or if Cyclone DDS cannot publish.
  GNOSPHERE_API Publisher(MessageType type, const std::string& topic, const PublisherOptions& options = {});
  /// Messages that wait are dropped; flush() before it sends them.
  GNOSPHERE_API ~Publisher();
  GNOSPHERE_API Publisher(Publisher&&) noexcept;
  GNOSPHERE_API Publisher& operator=(Publisher&&) noexcept;

  /// Throws Error(invalidArgument) for a message of another type, and for one whose sizes contradict each other, whose
  /// texts contain a zero, or whose times or data are more than ROS can state.
  GNOSPHERE_API void publish(Message message);
  /// Waits until all messages have been given to the network. Returns false if that takes longer than so many seconds,
  /// of which a million count at most.
  GNOSPHERE_API bool flush(double seconds);
  GNOSPHERE_API PublisherCounts counts() const;

 private:
  class Queue;
  std::unique_ptr<Queue> queue_;
};

/// Returns why nothing can be published; an empty text if messages can be.
GNOSPHERE_API std::string unavailable();

/// Returns the returns of a scan as a cloud with these fields and without gaps. Its fields have the names of the
/// columns of cloud files. Throws Error(invalidArgument) for a field that the scan does not have.
GNOSPHERE_API PointCloud2 cloudOf(const Scan& scan, const std::vector<Field>& fields, const std::string& frame,
                                  int64_t stamp);

/// Drivers of ROS 2 by the makers of their sensors, whose point layouts nodes for localisation and mapping read.
enum class Driver {
  velodyne,   ///< velodyne_pointcloud: time in seconds
  ouster,     ///< ouster-ros, "original": t in nanoseconds, range in millimetres
  hesai,      ///< HesaiLidar_ROS_2.0: timestamp in seconds since 1970
  robosense,  ///< rslidar_sdk, XYZIRT: as hesai
  livox,      ///< livox_ros_driver2, xfer_format 0: timestamp in nanoseconds since 1970
  autoware,   ///< PointXYZIRCAEDT of Autoware: time_stamp in nanoseconds, azimuth in the sense in which the head turns
};
/// Returns the driver of this name, such as "ouster".
GNOSPHERE_API std::optional<Driver> driverNamed(std::string_view name);

/// Returns the returns of a scan as a driver publishes them, in the order of their times. The fields with their types
/// and offsets are those of the driver (docs/ros2.md), and times count from `stamp`, at which the scan begins.
/// Intensities are calibrated reflectivities: 100 for a diffuse white surface and at most 255; 0 if the scan has none.
/// `effects` are those of the scan: the scale of its intensities, and the mode of its returns. Throws
/// Error(invalidArgument) for a scan without Field::time, and for values that the driver's types do not hold.
GNOSPHERE_API PointCloud2 driverCloudOf(const Scan& scan, Driver driver, const std::string& frame, int64_t stamp,
                                        const Effects& effects = {});

/// Returns the returns of a scan as Livox's driver publishes them in a message of its own (xfer_format 1), which
/// FAST-LIO reads; otherwise as driverCloudOf() with Driver::livox.
GNOSPHERE_API LivoxCustom livoxCustomOf(const Scan& scan, const std::string& frame, int64_t stamp,
                                        const Effects& effects = {});

/// Whether laserScanOf() takes this channel of a sensor: a row of a grid, or a row of a list with one pattern whose
/// beams are evenly spaced in azimuth. Beams straight up or down have no azimuth.
GNOSPHERE_API bool hasLaserScan(const Sensor& sensor, uint32_t channel = 0);

/// Returns the first returns of one channel, from the first column to the last. A beam without a return is +inf, as REP
/// 117 wants it. A beam that the sensor masks is NaN. With Field::cause, -inf is a beam that a surface nearer than its
/// least range blocks (NearHits::hide), and NaN also one that is dead, whose return was lost at random, or whose echoes
/// Effects::Returns::mode does not choose. Throws Error(invalidArgument) for a channel that there is not, for a scan of
/// another sensor, and unless hasLaserScan().
GNOSPHERE_API LaserScan laserScanOf(const Sensor& sensor, const Scan& scan, uint32_t channel, const std::string& frame,
                                    int64_t stamp);

}  // namespace gnosphere::ros2

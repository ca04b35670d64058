// SPDX-License-Identifier: Apache-2.0
// The definitions are those of common_interfaces, geometry2, rcl_interfaces and livox_ros_driver2.
#include "drive/formats/ros2_messages.hpp"

#include <array>
#include <functional>
#include <initializer_list>
#include <tuple>
#include <variant>

#include "drive/formats/cdr.hpp"

namespace gnosphere::drive {
namespace {

constexpr const char* kLine = "================================================================================\n";
constexpr const char* kHeaderText = "MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n";
constexpr const char* kTimeText = "MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n";
constexpr const char* kVector = "MSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n";
constexpr const char* kQuaternion = "MSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n";

/// Joins a definition and those that it refers to.
std::string joined(std::initializer_list<const char*> definitions) {
  std::string text;
  for (const char* definition : definitions) text += (text.empty() ? "" : kLine) + std::string(definition);
  return text;
}

/// Appends messages of every type.
struct Appending {
  std::string& bytes;

  void operator()(const ros2::PointCloud2& cloud) const {
    CdrWriter cdr(bytes);
    cdr.header(cloud.stamp, cloud.frame);
    cdr.number(cloud.height).number(cloud.width).number(static_cast<uint32_t>(cloud.fields.size()));
    for (const ros2::PointField& field : cloud.fields)
      cdr.text(field.name).number(field.offset).number(static_cast<uint8_t>(field.type)).number(field.count);
    cdr.number(uint8_t{0}).number(cloud.pointStep).number(cloud.width * cloud.pointStep);
    cdr.blob([&](std::string& to) { to.append(reinterpret_cast<const char*>(cloud.data.data()), cloud.data.size()); });
    cdr.number(uint8_t{cloud.dense});
  }
  void operator()(const ros2::LaserScan& laser) const {
    CdrWriter cdr(bytes);
    cdr.header(laser.stamp, laser.frame);
    for (const float value : {laser.angleMin, laser.angleMax, laser.angleIncrement, laser.timeIncrement, laser.scanTime,
                              laser.rangeMin, laser.rangeMax})
      cdr.number(value);
    for (const std::vector<float>& list : {std::cref(laser.ranges), std::cref(laser.intensities)}) {
      cdr.number(static_cast<uint32_t>(list.size()));
      for (const float value : list) cdr.number(value);
    }
  }
  void operator()(const ros2::Transforms& transforms) const {
    CdrWriter cdr(bytes);
    cdr.number(static_cast<uint32_t>(transforms.size()));
    for (const ros2::StampedTransform& transform : transforms) {
      const auto& [p, q] = transform.pose;
      cdr.header(transform.stamp, transform.parent).text(transform.child);
      for (double value : {p.x, p.y, p.z, q.x, q.y, q.z, q.w}) cdr.number(value);
    }
  }
  void operator()(const ros2::Clock& clock) const { CdrWriter(bytes).time(clock.time); }
  void operator()(const ros2::Imu& imu) const {
    const auto& [q, w, a] = std::tie(imu.orientation, imu.angularVelocity, imu.linearAcceleration);
    CdrWriter cdr(bytes);
    cdr.header(imu.stamp, imu.frame);
    const auto numbers = [&](const auto& values) {
      for (const double value : values) cdr.number(value);
    };
    numbers(std::array{q.x, q.y, q.z, q.w});
    numbers(imu.orientationCovariance);
    numbers(std::array{w.x, w.y, w.z});
    numbers(imu.angularVelocityCovariance);
    numbers(std::array{a.x, a.y, a.z});
    numbers(imu.linearAccelerationCovariance);
  }
  void operator()(const ros2::Odometry& odometry) const {
    const auto& [p, q] = odometry.pose;
    const auto& [v, w] = std::tie(odometry.linearVelocity, odometry.angularVelocity);
    CdrWriter cdr(bytes);
    cdr.header(odometry.stamp, odometry.frame).text(odometry.childFrame);
    for (const double value : {p.x, p.y, p.z, q.x, q.y, q.z, q.w}) cdr.number(value);
    for (const double value : odometry.poseCovariance) cdr.number(value);
    for (const double value : {v.x, v.y, v.z, w.x, w.y, w.z}) cdr.number(value);
    for (const double value : odometry.twistCovariance) cdr.number(value);
  }
  void operator()(const ros2::LivoxCustom& custom) const {
    CdrWriter cdr(bytes);
    cdr.header(custom.stamp, custom.frame);
    cdr.number(static_cast<uint64_t>(custom.stamp)).number(static_cast<uint32_t>(custom.points.size()));
    cdr.number(custom.lidarId).number(uint8_t{0}).number(uint8_t{0}).number(uint8_t{0});
    cdr.number(static_cast<uint32_t>(custom.points.size()));
    for (const ros2::LivoxPoint& p : custom.points)
      cdr.number(p.offsetTime).number(p.x).number(p.y).number(p.z).number(p.reflectivity).number(p.tag).number(p.line);
  }
};

}  // namespace

std::vector<McapSchema> messageSchemas() {
  return {{"sensor_msgs/msg/PointCloud2",
           joined({"std_msgs/Header header\nuint32 height\nuint32 width\nsensor_msgs/PointField[] fields\n"
                   "bool is_bigendian\nuint32 point_step\nuint32 row_step\nuint8[] data\nbool is_dense\n",
                   "MSG: sensor_msgs/PointField\nuint8 INT8=1\nuint8 UINT8=2\nuint8 INT16=3\nuint8 UINT16=4\n"
                   "uint8 INT32=5\nuint8 UINT32=6\nuint8 FLOAT32=7\nuint8 FLOAT64=8\nstring name\nuint32 offset\n"
                   "uint8 datatype\nuint32 count\n",
                   kHeaderText, kTimeText})},
          {"sensor_msgs/msg/LaserScan",
           joined({"std_msgs/Header header\nfloat32 angle_min\nfloat32 angle_max\nfloat32 angle_increment\n"
                   "float32 time_increment\nfloat32 scan_time\nfloat32 range_min\nfloat32 range_max\n"
                   "float32[] ranges\nfloat32[] intensities\n",
                   kHeaderText, kTimeText})},
          {"tf2_msgs/msg/TFMessage",
           joined({"geometry_msgs/TransformStamped[] transforms\n",
                   "MSG: geometry_msgs/TransformStamped\nstd_msgs/Header header\nstring child_frame_id\n"
                   "geometry_msgs/Transform transform\n",
                   "MSG: geometry_msgs/Transform\ngeometry_msgs/Vector3 translation\n"
                   "geometry_msgs/Quaternion rotation\n",
                   kVector, kQuaternion, kHeaderText, kTimeText})},
          {"rosgraph_msgs/msg/Clock", joined({"builtin_interfaces/Time clock\n", kTimeText})},
          {"sensor_msgs/msg/Imu",
           joined({"std_msgs/Header header\ngeometry_msgs/Quaternion orientation\nfloat64[9] orientation_covariance\n"
                   "geometry_msgs/Vector3 angular_velocity\nfloat64[9] angular_velocity_covariance\n"
                   "geometry_msgs/Vector3 linear_acceleration\nfloat64[9] linear_acceleration_covariance\n",
                   kVector, kQuaternion, kHeaderText, kTimeText})},
          {"livox_ros_driver2/msg/CustomMsg",
           joined({"std_msgs/Header header\nuint64 timebase\nuint32 point_num\nuint8 lidar_id\nuint8[3] rsvd\n"
                   "livox_ros_driver2/CustomPoint[] points\n",
                   "MSG: livox_ros_driver2/CustomPoint\nuint32 offset_time\nfloat32 x\nfloat32 y\nfloat32 z\n"
                   "uint8 reflectivity\nuint8 tag\nuint8 line\n",
                   kHeaderText, kTimeText})},
          {"nav_msgs/msg/Odometry",
           joined({"std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/PoseWithCovariance pose\n"
                   "geometry_msgs/TwistWithCovariance twist\n",
                   "MSG: geometry_msgs/PoseWithCovariance\ngeometry_msgs/Pose pose\nfloat64[36] covariance\n",
                   "MSG: geometry_msgs/Pose\ngeometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n",
                   "MSG: geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z\n",
                   "MSG: geometry_msgs/TwistWithCovariance\ngeometry_msgs/Twist twist\nfloat64[36] covariance\n",
                   "MSG: geometry_msgs/Twist\ngeometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n", kVector,
                   kQuaternion, kHeaderText, kTimeText})}};
}

uint16_t schemaOf(ros2::MessageType type) {
  return static_cast<uint16_t>(static_cast<int>(type) + 1);
}

void appendMessage(std::string& bytes, const ros2::Message& message) {
  std::visit(Appending{bytes}, message);
}

}  // namespace gnosphere::drive

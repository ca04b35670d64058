// SPDX-License-Identifier: Apache-2.0
// libgnosphere_ros2: writers of Eclipse Cyclone DDS, with the types that idlc makes of messages.idl.
#include <dds/dds.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <mutex>
#include <thread>
#include <tuple>
#include <vector>

#include "base/nanoseconds.hpp"
#include "base/quaternion.hpp"
#include "base/threads.hpp"
#include "messages.h"
#include "ros2/wire.hpp"

namespace gnosphere::ros2 {
namespace {

struct Failure {
  std::string why;
};

dds_entity_t entityOf(dds_entity_t made, const char* what) {
  if (made < 0) throw Failure{std::string(what) + " cannot be made: " + dds_strretcode(-made)};
  return made;
}

/// Returns the configuration of a topic's domain, followed by CYCLONEDDS_URI, whose settings replace those before it.
std::string configuration(const std::string& discovery) {
  const char* const own = std::getenv("CYCLONEDDS_URI");
  const std::string chosen = own ? own : "";
  return discovery + (discovery.empty() || chosen.empty() ? "" : ",") + chosen;
}

// Cyclone DDS 0.10 starts six threads for a domain on the loopback interface, and one more thread for multicast.
constexpr int kThreadsOfDomain = 8;

/// Cyclone DDS ends the process if one of its threads cannot be started, so as many threads are tried before.
void needThreads() {
  std::mutex mutex;
  std::vector<std::jthread> threads;  // wait until all have been started, and end before the mutex does
  const std::lock_guard held(mutex);
  try {
    for (int i = 0; i < kThreadsOfDomain; ++i) threads.emplace_back([&mutex] { const std::lock_guard wait(mutex); });
  } catch (const std::system_error& error) {
    throw Failure{
        noMoreThreads("the " + std::to_string(kThreadsOfDomain) + " threads that Cyclone DDS may need", error)};
  }
}

/// A domain of this process, which all its topics share.
class Domain {
 public:
  Domain(uint32_t number, const std::string& discovery) : discovery_(discovery) {
    needThreads();
    const dds_entity_t made = dds_create_domain(number, configuration(discovery).c_str());
    if (made != DDS_RETCODE_PRECONDITION_NOT_MET)  // another part of the process has made it
      domain_ = entityOf(made, "the domain, which needs a network interface,");
    participant_ = dds_create_participant(number, nullptr, nullptr);
    if (participant_ < 0 && domain_ > 0) dds_delete(domain_);
    entityOf(participant_, "the participant");
  }
  ~Domain() { dds_delete(domain_ > 0 ? domain_ : participant_); }
  Domain(const Domain&) = delete;
  Domain& operator=(const Domain&) = delete;

  dds_entity_t participant() const { return participant_; }
  const std::string& discovery() const { return discovery_; }

 private:
  std::string discovery_;
  dds_entity_t domain_ = 0, participant_ = 0;
};

/// The use of a domain by a topic. Uses begin and end under one lock, so that no topic begins to use a domain that is
/// being deleted.
class DomainUse {
 public:
  DomainUse(uint32_t number, const std::string& discovery) {
    static auto* const domains = new std::map<uint32_t, std::weak_ptr<Domain>>;
    const std::lock_guard lock(mutex());
    std::weak_ptr<Domain>& known = (*domains)[number];
    std::shared_ptr<Domain> domain = known.lock();
    if (!domain) known = domain = std::make_shared<Domain>(number, discovery);
    if (domain->discovery() != discovery)
      throw Failure{"other topics of the domain " + std::to_string(number) +
                    " have another range of discovery or other peers (the option for this machine only, "
                    "ROS_LOCALHOST_ONLY, ROS_AUTOMATIC_DISCOVERY_RANGE, ROS_STATIC_PEERS)"};
    domain_ = std::move(domain);
  }
  ~DomainUse() {
    const std::lock_guard lock(mutex());
    domain_.reset();
  }
  DomainUse(const DomainUse&) = delete;
  DomainUse& operator=(const DomainUse&) = delete;

  dds_entity_t participant() const { return domain_->participant(); }

 private:
  static std::mutex& mutex() {
    static std::mutex theMutex;
    return theMutex;
  }

  std::shared_ptr<Domain> domain_;
};

const dds_topic_descriptor_t& descriptorOf(MessageType type) {
  switch (type) {
    case MessageType::laserScan: return sensor_msgs_msg_dds__LaserScan__desc;
    case MessageType::transforms: return tf2_msgs_msg_dds__TFMessage__desc;
    case MessageType::clock: return rosgraph_msgs_msg_dds__Clock__desc;
    case MessageType::imu: return sensor_msgs_msg_dds__Imu__desc;
    case MessageType::odometry: return nav_msgs_msg_dds__Odometry__desc;
    case MessageType::livoxCustom: return livox_ros_driver2_msg_dds__CustomMsg__desc;
    case MessageType::pointCloud2: break;
  }
  return sensor_msgs_msg_dds__PointCloud2__desc;
}

struct DeleteQos {
  void operator()(dds_qos_t* qos) const { dds_delete_qos(qos); }
};

std::unique_ptr<dds_qos_t, DeleteQos> qosOf(const Qos& from) {
  std::unique_ptr<dds_qos_t, DeleteQos> qos(dds_create_qos());
  const auto depth = static_cast<int32_t>(std::min<uint32_t>(from.depth, 0x7fffffff));
  const bool latched = from.durability == Qos::Durability::transientLocal;
  dds_qset_reliability(
      qos.get(),
      from.reliability == Qos::Reliability::reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT,
      DDS_MSECS(100));
  dds_qset_durability(qos.get(), latched ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, depth);
  if (latched)
    dds_qset_durability_service(qos.get(), 0, DDS_HISTORY_KEEP_LAST, depth, DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED,
                                DDS_LENGTH_UNLIMITED);
  dds_qset_writer_data_lifecycle(qos.get(), false);
  const dds_data_representation_id_t plain = DDS_DATA_REPRESENTATION_XCDR1;  // that of ROS
  dds_qset_data_representation(qos.get(), 1, &plain);
  return qos;
}

// Messages in the types that idlc generates, which point to data that they do not own.

builtin_interfaces_msg_dds__Time_ timeOf(int64_t nanoseconds) {
  const auto [seconds, rest] = splitNanoseconds(nanoseconds);
  return {static_cast<int32_t>(seconds), rest};
}

char* textOf(const std::string& text) {
  return const_cast<char*>(text.c_str());  // it is only read
}

std_msgs_msg_dds__Header_ headerOf(int64_t stamp, const std::string& frame) {
  return {timeOf(stamp), textOf(frame)};
}

template <class Sequence, class T>
Sequence sequenceOf(const std::vector<T>& values) {
  const auto count = static_cast<uint32_t>(values.size());
  return {count, count, const_cast<T*>(values.data()), false};
}

/// Returns the orientation of a pose, which may have any length, as ROS takes it: tf2 ignores a transform whose
/// quaternion is not of length 1.
geometry_msgs_msg_dds__Quaternion_ unitQuaternionOf(const Pose& pose) {
  const Quaternion q = normalized(unitOf(pose.orientation));
  return {q.x, q.y, q.z, q.w};
}

struct Writing {
  dds_entity_t writer;

  dds_return_t operator()(const PointCloud2& cloud) const {
    std::vector<sensor_msgs_msg_dds__PointField_> fields;
    for (const PointField& field : cloud.fields)
      fields.push_back({textOf(field.name), field.offset, static_cast<uint8_t>(field.type), field.count});
    sensor_msgs_msg_dds__PointCloud2_ message = {};
    message.header = headerOf(cloud.stamp, cloud.frame);
    message.height = cloud.height;
    message.width = cloud.width;
    message.fields = sequenceOf<dds_sequence_sensor_msgs_msg_dds__PointField_>(fields);
    message.point_step = cloud.pointStep;
    message.row_step = cloud.pointStep * cloud.width;
    message.data = sequenceOf<dds_sequence_octet>(cloud.data);
    message.is_dense = cloud.dense;
    return dds_write(writer, &message);
  }
  dds_return_t operator()(const LaserScan& scan) const {
    sensor_msgs_msg_dds__LaserScan_ message = {};
    message.header = headerOf(scan.stamp, scan.frame);
    message.angle_min = scan.angleMin;
    message.angle_max = scan.angleMax;
    message.angle_increment = scan.angleIncrement;
    message.time_increment = scan.timeIncrement;
    message.scan_time = scan.scanTime;
    message.range_min = scan.rangeMin;
    message.range_max = scan.rangeMax;
    message.ranges = sequenceOf<dds_sequence_float>(scan.ranges);
    message.intensities = sequenceOf<dds_sequence_float>(scan.intensities);
    return dds_write(writer, &message);
  }
  dds_return_t operator()(const Transforms& transforms) const {
    std::vector<geometry_msgs_msg_dds__TransformStamped_> list;
    for (const StampedTransform& from : transforms) {
      const Vec3& p = from.pose.position;
      list.push_back(
          {headerOf(from.stamp, from.parent), textOf(from.child), {{p.x, p.y, p.z}, unitQuaternionOf(from.pose)}});
    }
    const tf2_msgs_msg_dds__TFMessage_ message = {
        sequenceOf<dds_sequence_geometry_msgs_msg_dds__TransformStamped_>(list)};
    return dds_write(writer, &message);
  }
  dds_return_t operator()(const Clock& clock) const {
    const rosgraph_msgs_msg_dds__Clock_ message = {timeOf(clock.time)};
    return dds_write(writer, &message);
  }
  dds_return_t operator()(const LivoxCustom& custom) const {
    std::vector<livox_ros_driver2_msg_dds__CustomPoint_> points;
    points.reserve(custom.points.size());
    for (const LivoxPoint& p : custom.points)
      points.push_back({p.offsetTime, p.x, p.y, p.z, p.reflectivity, p.tag, p.line});
    livox_ros_driver2_msg_dds__CustomMsg_ message = {};
    message.header = headerOf(custom.stamp, custom.frame);
    message.timebase = static_cast<uint64_t>(custom.stamp);
    message.point_num = static_cast<uint32_t>(points.size());
    message.lidar_id = custom.lidarId;
    message.points = sequenceOf<dds_sequence_livox_ros_driver2_msg_dds__CustomPoint_>(points);
    return dds_write(writer, &message);
  }
  dds_return_t operator()(const Imu& imu) const {
    const auto& [q, w, a] = std::tie(imu.orientation, imu.angularVelocity, imu.linearAcceleration);
    sensor_msgs_msg_dds__Imu_ message = {};
    message.header = headerOf(imu.stamp, imu.frame);
    message.orientation = {q.x, q.y, q.z, q.w};
    message.angular_velocity = {w.x, w.y, w.z};
    message.linear_acceleration = {a.x, a.y, a.z};
    std::ranges::copy(imu.orientationCovariance, message.orientation_covariance);
    std::ranges::copy(imu.angularVelocityCovariance, message.angular_velocity_covariance);
    std::ranges::copy(imu.linearAccelerationCovariance, message.linear_acceleration_covariance);
    return dds_write(writer, &message);
  }
  dds_return_t operator()(const Odometry& odometry) const {
    const Vec3& p = odometry.pose.position;
    const auto& [v, w] = std::tie(odometry.linearVelocity, odometry.angularVelocity);
    nav_msgs_msg_dds__Odometry_ message = {};
    message.header = headerOf(odometry.stamp, odometry.frame);
    message.child_frame_id = textOf(odometry.childFrame);
    message.pose.pose = {{p.x, p.y, p.z}, unitQuaternionOf(odometry.pose)};
    message.twist.twist = {{v.x, v.y, v.z}, {w.x, w.y, w.z}};
    std::ranges::copy(odometry.poseCovariance, message.pose.covariance);
    std::ranges::copy(odometry.twistCovariance, message.twist.covariance);
    return dds_write(writer, &message);
  }
};

class CycloneWire : public Wire {
 public:
  explicit CycloneWire(const Topic& topic) : domain_(topic.domain, topic.discovery) {
    topic_ = entityOf(
        dds_create_topic(domain_.participant(), &descriptorOf(topic.type), topic.name.c_str(), nullptr, nullptr),
        "the topic");
    writer_ = dds_create_writer(domain_.participant(), topic_, qosOf(topic.qos).get(), nullptr);
    if (writer_ < 0) dds_delete(topic_);
    entityOf(writer_, "the writer");
  }
  // Cyclone DDS waits up to a second for subscribers to confirm what was written last.
  ~CycloneWire() override {
    dds_delete(writer_);
    dds_delete(topic_);
  }
  CycloneWire(const CycloneWire&) = delete;
  CycloneWire& operator=(const CycloneWire&) = delete;

  bool write(const Message& message) override { return std::visit(Writing{writer_}, message) == DDS_RETCODE_OK; }
  uint32_t subscribers() override {
    dds_publication_matched_status_t status = {};
    dds_get_publication_matched_status(writer_, &status);
    return status.current_count;
  }

 private:
  const DomainUse domain_;
  dds_entity_t topic_ = 0, writer_ = 0;
};

}  // namespace
}  // namespace gnosphere::ros2

using namespace gnosphere::ros2;

extern "C" __attribute__((visibility("default"))) Wire* gnosphere_ros2_open(const Topic& topic, std::string& error) {
  try {
    return new CycloneWire(topic);
  } catch (const Failure& failure) {
    error = failure.why;
  } catch (const std::exception& exception) {
    error = exception.what();
  }
  return nullptr;
}

extern "C" __attribute__((visibility("default"))) const char* gnosphere_ros2_version() {
  return GNOSPHERE_ROS2_VERSION;
}

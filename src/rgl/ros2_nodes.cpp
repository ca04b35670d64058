// SPDX-License-Identifier: Apache-2.0
// Nodes that publish their points as messages of ROS 2.
#include <rgl/api/extensions/ros2.h>

#include <algorithm>
#include <chrono>
#include <gnosphere/error.hpp>
#include <gnosphere/ros2.hpp>
#include <optional>

#include "rgl/node.hpp"
#include "rgl/scene.hpp"

namespace gnosphere::rgl {
namespace {

using Type = ros2::PointField::Type;

/// A field of RGL as it stands in a PointCloud2: fields of one type, side by side.
struct Names {
  Type type;
  std::vector<std::string> names;
};

Names namesOf(rgl_field_t field) {
  switch (field) {
    case RGL_FIELD_XYZ_VEC3_F32: return {Type::f32, {"x", "y", "z"}};
    case RGL_FIELD_INTENSITY_F32: return {Type::f32, {"intensity"}};
    case RGL_FIELD_INTENSITY_U8: return {Type::u8, {"intensity"}};
    case RGL_FIELD_IS_HIT_I32: return {Type::i32, {"is_hit"}};
    case RGL_FIELD_IS_GROUND_I32: return {Type::i32, {"is_ground"}};
    case RGL_FIELD_RAY_IDX_U32: return {Type::u32, {"ray_idx"}};
    case RGL_FIELD_ENTITY_ID_I32: return {Type::i32, {"entity_id"}};
    case RGL_FIELD_DISTANCE_F32: return {Type::f32, {"distance"}};
    case RGL_FIELD_AZIMUTH_F32: return {Type::f32, {"azimuth"}};
    case RGL_FIELD_ELEVATION_F32: return {Type::f32, {"elevation"}};
    case RGL_FIELD_RING_ID_U16: return {Type::u16, {level() <= 16 ? "ring" : "channel"}};
    case RGL_FIELD_RETURN_TYPE_U8: return {Type::u8, {"return_type"}};
    case RGL_FIELD_TIME_STAMP_F64: return {Type::f64, {"time_stamp"}};
    case RGL_FIELD_TIME_STAMP_U32: return {Type::u32, {"time_stamp"}};
    case RGL_FIELD_ABSOLUTE_VELOCITY_VEC3_F32: return {Type::f32, {"abs_vx", "abs_vy", "abs_vz"}};
    case RGL_FIELD_RELATIVE_VELOCITY_VEC3_F32: return {Type::f32, {"rel_vx", "rel_vy", "rel_vz"}};
    case RGL_FIELD_RADIAL_SPEED_F32: return {Type::f32, {"radial_speed"}};
    case RGL_FIELD_POWER_F32: return {Type::f32, {"power"}};
    case RGL_FIELD_RCS_F32: return {Type::f32, {"rcs"}};
    case RGL_FIELD_NOISE_F32: return {Type::f32, {"noise"}};
    case RGL_FIELD_SNR_F32: return {Type::f32, {"snr"}};
    case RGL_FIELD_NORMAL_VEC3_F32: return {Type::f32, {"nx", "ny", "nz"}};
    case RGL_FIELD_INCIDENT_ANGLE_F32: return {Type::f32, {"incident_angle"}};
    case RGL_FIELD_LASER_RETRO_F32: return {Type::f32, {"laser_retro"}};
    case RGL_FIELD_REFLECTIVITY_F32: return {Type::f32, {"reflectivity"}};
    case RGL_FIELD_RAY_POSE_MAT3x4_F32:
      return {Type::f32, {"m00", "m01", "m02", "m03", "m10", "m11", "m12", "m13", "m20", "m21", "m22", "m23"}};
    default: return {Type::u8, {}};  // padding
  }
}

/// The scene's time, or that of the clock.
int64_t stampNow() {
  if (scene().time) return static_cast<int64_t>(*scene().time);
  return std::chrono::nanoseconds(std::chrono::system_clock::now().time_since_epoch()).count();
}

/// A topic as the caller describes it.
struct Target {
  std::string topic, frame;
  ros2::Qos qos;
};

/// A node that hands its points on and publishes them.
class PublishNode : public PointsFilter {
 public:
  void set(ros2::MessageType type, const Target& target) {
    std::optional<ros2::Publisher> publisher;
    try {
      ros2::PublisherOptions options;
      options.qos = target.qos;
      publisher.emplace(type, target.topic, options);
    } catch (const Error& error) {
      throw Failure(error.code() == ErrorCode::invalidArgument ? RGL_INVALID_ARGUMENT : RGL_ROS2_ERROR, error.what());
    }
    publisher_ = std::move(publisher);
    frame_ = target.frame;
  }

 protected:
  std::optional<ros2::Publisher> publisher_;
  std::string frame_;
};

class PublishPointsNode : public PublishNode {
 public:
  static constexpr const char* kName = "Ros2PublishPointsNode";
  const char* name() const override { return kName; }
  void set(const Target& target) { PublishNode::set(ros2::MessageType::pointCloud2, target); }
  void validate() override {
    PointsFilter::validate();
    if (input_->format().empty())
      throw Failure(RGL_INVALID_PIPELINE,
                    std::string(kName) + " requires 'RGL_FIELD_DYNAMIC_FORMAT' field to be present");
  }
  void run() override {
    cloud_ = input_->cloud();
    ros2::PointCloud2 message;
    for (const rgl_field_t field : input_->format()) {
      const Names of = namesOf(field);
      const auto count = static_cast<uint32_t>(std::max<size_t>(of.names.size(), 1));
      const uint32_t size = static_cast<uint32_t>(sizeOf(field)) / count;
      for (uint32_t i = 0; i < of.names.size(); ++i)
        message.fields.push_back({of.names[i], message.pointStep + i * size, of.type, 1});
      message.pointStep += count * size;
    }
    message.stamp = stampNow();
    message.frame = frame_;
    message.width = static_cast<uint32_t>(cloud_.count);
    message.dense = input_->isDense();
    if (cloud_.count > 0) {
      const auto* rows = cloud_.values<uint8_t>(RGL_FIELD_DYNAMIC_FORMAT);
      message.data.assign(rows, rows + cloud_.columns.at(RGL_FIELD_DYNAMIC_FORMAT).bytes->size());
    }
    publisher_->publish(std::move(message));
  }
};

class PublishLaserScanNode : public PublishNode {
 public:
  static constexpr const char* kName = "Ros2PublishLaserScanNode";
  const char* name() const override { return kName; }
  void set(const Target& target) { PublishNode::set(ros2::MessageType::laserScan, target); }
  Fields required() const override {
    return {RGL_FIELD_AZIMUTH_F32, RGL_FIELD_DISTANCE_F32, RGL_FIELD_TIME_STAMP_F64, RGL_FIELD_INTENSITY_F32};
  }
  void run() override {
    cloud_ = input_->cloud();
    ros2::LaserScan message;
    message.stamp = stampNow();
    message.frame = frame_;
    if (const size_t count = cloud_.count; count > 0) {
      const auto* angles = cloud_.values<float>(RGL_FIELD_AZIMUTH_F32);
      const auto* ranges = cloud_.values<float>(RGL_FIELD_DISTANCE_F32);
      const auto* times = cloud_.values<double>(RGL_FIELD_TIME_STAMP_F64);
      const auto* intensities = cloud_.values<float>(RGL_FIELD_INTENSITY_F32);
      message.angleMin = *std::min_element(angles, angles + count);
      message.angleMax = *std::max_element(angles, angles + count);
      message.rangeMin = *std::min_element(ranges, ranges + count);
      message.rangeMax = *std::max_element(ranges, ranges + count);
      message.scanTime = static_cast<float>(times[count - 1] - times[0]);
      if (count > 1) {
        message.angleIncrement = angles[1] - angles[0];
        message.timeIncrement = static_cast<float>(times[1] - times[0]);
      }
      message.ranges.assign(ranges, ranges + count);
      message.intensities.assign(intensities, intensities + count);
    }
    publisher_->publish(std::move(message));
  }
};

/// Refuses what is no topic, and gives a depth to the policies that leave it open.
Target targetOf(const char* topic_name, const char* frame_id, int reliability, int durability, int history,
                int32_t qos_history_depth) {
  RGL_CHECK(topic_name != nullptr);
  RGL_CHECK(topic_name[0] != '\0');
  RGL_CHECK(frame_id != nullptr);
  RGL_CHECK(frame_id[0] != '\0');
  RGL_CHECK(qos_history_depth >= 0);
  const bool qosPoliciesKnown =
      reliability >= 0 && reliability <= 2 && durability >= 0 && durability <= 2 && history >= 0 && history <= 2;
  RGL_CHECK(qosPoliciesKnown);
  constexpr uint32_t kDepthOfAll = 100;  // no queue is endless
  Target target{topic_name, frame_id, {}};
  if (reliability == QOS_POLICY_RELIABILITY_BEST_EFFORT) target.qos.reliability = ros2::Qos::Reliability::bestEffort;
  if (durability == QOS_POLICY_DURABILITY_TRANSIENT_LOCAL)
    target.qos.durability = ros2::Qos::Durability::transientLocal;
  target.qos.depth =
      history == QOS_POLICY_HISTORY_KEEP_ALL ? kDepthOfAll : static_cast<uint32_t>(std::max(qos_history_depth, 1));
  return target;
}

constexpr int32_t kDefaultDepth = 10;

std::string textOf(const char* text) {
  return text ? text : "";
}

}  // namespace
}  // namespace gnosphere::rgl

using namespace gnosphere::rgl;

RGL_API rgl_status_t rgl_node_points_ros2_publish(rgl_node_t* node, const char* topic_name, const char* frame_id) {
  return call(__func__, taped(out(node), textOf(topic_name), textOf(frame_id)), [&] {
    RGL_CHECK(node != nullptr);
    const Target target = targetOf(topic_name, frame_id, 0, 0, 0, kDefaultDepth);
    createOrUpdate<PublishPointsNode>(node, Affects::node, [&](auto& made) { made.set(target); });
  });
}

RGL_API rgl_status_t rgl_node_points_ros2_publish_with_qos(
    rgl_node_t* node, const char* topic_name, const char* frame_id, rgl_qos_policy_reliability_t qos_reliability,
    rgl_qos_policy_durability_t qos_durability, rgl_qos_policy_history_t qos_history, int32_t qos_history_depth) {
  return call(__func__,
              taped(out(node), textOf(topic_name), textOf(frame_id), qos_reliability, qos_durability, qos_history,
                    qos_history_depth),
              [&] {
                RGL_CHECK(node != nullptr);
                const Target target =
                    targetOf(topic_name, frame_id, qos_reliability, qos_durability, qos_history, qos_history_depth);
                createOrUpdate<PublishPointsNode>(node, Affects::node, [&](auto& made) { made.set(target); });
              });
}

RGL_API rgl_status_t rgl_node_publish_ros2_laserscan(rgl_node_t* node, const char* topic_name, const char* frame_id) {
  return call(__func__, taped(out(node), textOf(topic_name), textOf(frame_id)), [&] {
    RGL_CHECK(node != nullptr);
    const Target target = targetOf(topic_name, frame_id, 0, 0, 0, kDefaultDepth);
    createOrUpdate<PublishLaserScanNode>(node, Affects::node, [&](auto& made) { made.set(target); });
  });
}

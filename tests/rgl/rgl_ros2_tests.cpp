// SPDX-License-Identifier: Apache-2.0
// RGL's nodes for ROS 2: what a subscriber gets, and which graphs and arguments are refused.
#include <rgl/api/extensions/ros2.h>
#include <rgl/api/extensions/tape.h>

#include "folder.hpp"
#include "rgl/plugin.hpp"
#include "ros2/listening.hpp"

using namespace gnosphere::test;

namespace {

/// Two points as a format node gives them: x, y, z, a gap, intensity, ring.
const std::vector<rgl_field_t> kFields = {RGL_FIELD_XYZ_VEC3_F32, RGL_FIELD_PADDING_32, RGL_FIELD_INTENSITY_F32,
                                          RGL_FIELD_RING_ID_U16};

struct __attribute__((packed)) Row {
  float x, y, z, gap, intensity;
  uint16_t ring;
};
const Row kRows[] = {{1, 2, 3, 0, 0.5f, 7}, {4, 5, 6, 0, 0.25f, 8}};

/// from_array -> format -> publish, which is made beforehand.
struct Graph {
  rgl_node_t points = nullptr, format = nullptr;

  explicit Graph(rgl_node_t publish) {
    const auto count = static_cast<int32_t>(kFields.size());
    OK(rgl_node_points_from_array(&points, kRows, 2, kFields.data(), count));
    OK(rgl_node_points_format(&format, kFields.data(), count));
    OK(rgl_graph_node_add_child(points, format));
    OK(rgl_graph_node_add_child(format, publish));
  }
};

rgl_status_t latched(rgl_node_t* node, const char* topic) {
  loopbackDomain();
  return rgl_node_points_ros2_publish_with_qos(node, topic, "lidar", QOS_POLICY_RELIABILITY_RELIABLE,
                                               QOS_POLICY_DURABILITY_TRANSIENT_LOCAL, QOS_POLICY_HISTORY_KEEP_LAST, 1);
}

std::string received(const char* topic) {
  Listener listener({.qos = "latched"}, {topic});
  const std::vector<std::string> lines = listener.lines();
  return lines.size() == 1 ? lines[0] : "";
}

/// Output of the listener for kRows, behind the frame.
std::string expected() {
  unsigned sum = 0;
  for (size_t i = 0; i < sizeof(kRows); ++i) sum = sum * 31 + reinterpret_cast<const uint8_t*>(kRows)[i];
  return "1x2 step 22 row 44 bytes 44 sum " + std::to_string(sum) +
         " big 0 dense 1 x:0:7:1 y:4:7:1 z:8:7:1 intensity:16:7:1 channel:20:4:1";
}

}  // namespace

TEST_CASE("RGL and ROS 2: the rows of a format node arrive with their layout") {
  int32_t available = -1;
  OK(rgl_get_extension_info(RGL_EXTENSION_ROS2, &available));
  REQUIRE(available == 1);
  rgl_node_t publish = nullptr;
  OK(latched(&publish, "rgl/points"));
  const Graph graph(publish);
  OK(rgl_scene_set_time(nullptr, 12'000'000'034));
  OK(rgl_graph_run(graph.points));
  CHECK(received("rt/rgl/points") == "rt/rgl/points 12.000000034 lidar " + expected());
  OK(latched(&publish, "rgl/other"));  // the node gets another topic
  OK(rgl_graph_run(graph.points));
  CHECK(received("rt/rgl/other").starts_with("rt/rgl/other 12.000000034 lidar 1x2 "));
  OK(rgl_cleanup());
}

TEST_CASE("RGL and ROS 2: a tape publishes again") {
  const Folder folder;
  const std::string path = (folder / "tape").string();
  OK(rgl_tape_record_begin(path.c_str()));
  rgl_node_t publish = nullptr;
  OK(latched(&publish, "rgl/tape"));
  OK(rgl_graph_run(Graph(publish).points));
  OK(rgl_tape_record_end());
  OK(rgl_cleanup());
  OK(rgl_tape_play(path.c_str()));
  const std::string line = received("rt/rgl/tape");
  CHECK(line.ends_with(expected()));
  CHECK(line.starts_with("rt/rgl/tape 1"));  // the time of the clock, as the scene has none
  OK(rgl_cleanup());
}

TEST_CASE("RGL and ROS 2: points that turn become a laser scan") {
  loopbackDomain();
  const std::vector<rgl_field_t> fields = {RGL_FIELD_AZIMUTH_F32, RGL_FIELD_DISTANCE_F32, RGL_FIELD_INTENSITY_F32,
                                           RGL_FIELD_TIME_STAMP_F64};
  const struct __attribute__((packed)) {
    float azimuth, distance, intensity;
    double time;
  } rows[] = {{0.5f, 3, 9, 1}, {0.75f, 2, 8, 1.25}, {1, 4, 7, 1.5}};
  rgl_node_t points = nullptr, publish = nullptr;
  OK(rgl_node_points_from_array(&points, rows, 3, fields.data(), 4));
  OK(rgl_node_publish_ros2_laserscan(&publish, "scan", "laser"));
  OK(rgl_graph_node_add_child(points, publish));
  OK(rgl_scene_set_time(nullptr, 5));
  Listener listener({.type = "laser"}, {"rt/scan"});
  for (int i = 0; i < 30; ++i) {  // until the listener is there
    OK(rgl_graph_run(points));
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  const std::vector<std::string> lines = listener.lines();
  REQUIRE(lines.size() == 1);
  CHECK(lines[0] == "rt/scan 0.000000005 laser 0.5 1 0.25 0.25 0.5 2 4 ranges 3 2 4 intensities 9 8 7");
  OK(rgl_cleanup());
}

TEST_CASE("RGL and ROS 2: wrong graphs, topics and policies are statuses with a sentence") {
  loopbackDomain();
  rgl_node_t publish = nullptr, points = nullptr;
  CHECK(failed(rgl_node_points_ros2_publish(nullptr, "a", "b"), RGL_INVALID_ARGUMENT, "node != nullptr"));
  CHECK(failed(rgl_node_points_ros2_publish(&publish, nullptr, "b"), RGL_INVALID_ARGUMENT, "topic_name != nullptr"));
  CHECK(failed(rgl_node_points_ros2_publish(&publish, "", "b"), RGL_INVALID_ARGUMENT, "topic_name[0] != '\\0'"));
  CHECK(failed(rgl_node_points_ros2_publish(&publish, "a", ""), RGL_INVALID_ARGUMENT, "frame_id[0] != '\\0'"));
  CHECK(failed(rgl_node_points_ros2_publish(&publish, "a b", "b"), RGL_INVALID_ARGUMENT, "no name of a topic"));
  const auto withQos = [&](int reliability, int32_t depth) {
    return rgl_node_points_ros2_publish_with_qos(
        &publish, "a", "b", static_cast<rgl_qos_policy_reliability_t>(reliability),
        QOS_POLICY_DURABILITY_SYSTEM_DEFAULT, QOS_POLICY_HISTORY_KEEP_ALL, depth);
  };
  CHECK(failed(withQos(0, -1), RGL_INVALID_ARGUMENT, "qos_history_depth >= 0"));
  CHECK(failed(withQos(3, 0), RGL_INVALID_ARGUMENT, "qosPoliciesKnown"));
  CHECK(publish == nullptr);
  OK(withQos(0, 0));
  OK(rgl_node_points_from_array(&points, kRows, 2, kFields.data(), static_cast<int32_t>(kFields.size())));
  OK(rgl_graph_node_add_child(points, publish));
  CHECK(failed(rgl_graph_run(points), RGL_INVALID_PIPELINE, "requires 'RGL_FIELD_DYNAMIC_FORMAT' field"));
  OK(rgl_cleanup());
}

// The test runs in a process that has an unusable library: see tests/CMakeLists.txt.
TEST_CASE("RGL and ROS 2: without Cyclone DDS a sentence names the package", "[.absent]") {
  int32_t available = -1;
  OK(rgl_get_extension_info(RGL_EXTENSION_ROS2, &available));
  CHECK(available == 0);
  rgl_node_t publish = nullptr;
  CHECK(failed(rgl_node_points_ros2_publish(&publish, "a", "b"), RGL_ROS2_ERROR, "cyclonedds-dev"));
}

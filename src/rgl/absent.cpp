// SPDX-License-Identifier: Apache-2.0
// Functions that are not implemented, and say so. Without them, programs that link them would not start.
#include <rgl/api/extensions/pcl.h>
#include <rgl/api/extensions/ros2.h>

#include "rgl/call.hpp"

using namespace gnosphere::rgl;

namespace {

rgl_status_t absent(const char* function, const char* instead) {
  return callUnrecorded([&] {
    throw Failure(RGL_NOT_IMPLEMENTED, std::string(function) + " is not implemented by GnoSphere: " + instead);
  });
}

constexpr const char* kRos = "of ROS 2, points and laser scans are published";
constexpr const char* kUdp = "the packets are those of a closed extension";
constexpr const char* kWeather = "the function is that of a closed extension; GnoSphere's own interface has weather";

}  // namespace

RGL_API rgl_status_t rgl_node_points_visualize(rgl_node_t*, const char*, int, int, bool) {
  return absent("rgl_node_points_visualize", "write a file with rgl_graph_write_pcd_file and open it with a viewer");
}
RGL_API rgl_status_t rgl_node_publish_ros2_radarscan(rgl_node_t*, const char*, const char*,
                                                     rgl_qos_policy_reliability_t, rgl_qos_policy_durability_t,
                                                     rgl_qos_policy_history_t, int32_t) {
  return absent("rgl_node_publish_ros2_radarscan", kRos);
}

// Their parameters are not public. A caller may pass more arguments than a C function takes.
RGL_API rgl_status_t rgl_node_publish_ros2_radartracks(rgl_node_t*) {
  return absent("rgl_node_publish_ros2_radartracks", kRos);
}
RGL_API rgl_status_t rgl_node_configure_agnocast(rgl_node_t) {
  return absent("rgl_node_configure_agnocast", kRos);
}
RGL_API rgl_status_t rgl_node_points_udp_publish(rgl_node_t*) {
  return absent("rgl_node_points_udp_publish", kUdp);
}
RGL_API rgl_status_t rgl_node_points_simulate_rain(rgl_node_t*) {
  return absent("rgl_node_points_simulate_rain", kWeather);
}
RGL_API rgl_status_t rgl_node_points_simulate_fog(rgl_node_t*) {
  return absent("rgl_node_points_simulate_fog", kWeather);
}
RGL_API rgl_status_t rgl_graph_node_set_active(rgl_node_t, bool) {
  return absent("rgl_graph_node_set_active", "remove the node from its graph with rgl_graph_node_remove_child");
}

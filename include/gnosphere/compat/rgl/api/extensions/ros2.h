// SPDX-License-Identifier: Apache-2.0
// RGL's ROS 2 nodes: docs/rgl.md. That of radar exists, so that programs which link it start, and answers
// RGL_NOT_IMPLEMENTED.
#pragma once

#include <rgl/api/core.h>

typedef enum {
  QOS_POLICY_RELIABILITY_SYSTEM_DEFAULT = 0,
  QOS_POLICY_RELIABILITY_RELIABLE = 1,
  QOS_POLICY_RELIABILITY_BEST_EFFORT = 2
} rgl_qos_policy_reliability_t;
typedef enum {
  QOS_POLICY_DURABILITY_SYSTEM_DEFAULT = 0,
  QOS_POLICY_DURABILITY_TRANSIENT_LOCAL = 1,
  QOS_POLICY_DURABILITY_VOLATILE = 2
} rgl_qos_policy_durability_t;
typedef enum {
  QOS_POLICY_HISTORY_SYSTEM_DEFAULT = 0,
  QOS_POLICY_HISTORY_KEEP_LAST = 1,
  QOS_POLICY_HISTORY_KEEP_ALL = 2
} rgl_qos_policy_history_t;

/// A PointCloud2 of the rows of the format node before it.
RGL_API rgl_status_t rgl_node_points_ros2_publish(rgl_node_t* node, const char* topic_name, const char* frame_id);
RGL_API rgl_status_t rgl_node_points_ros2_publish_with_qos(
    rgl_node_t* node, const char* topic_name, const char* frame_id, rgl_qos_policy_reliability_t qos_reliability,
    rgl_qos_policy_durability_t qos_durability, rgl_qos_policy_history_t qos_history, int32_t qos_history_depth);
/// A LaserScan of points that have azimuths, distances, times and intensities.
RGL_API rgl_status_t rgl_node_publish_ros2_laserscan(rgl_node_t* node, const char* topic_name, const char* frame_id);
RGL_API rgl_status_t rgl_node_publish_ros2_radarscan(rgl_node_t* node, const char* topic_name, const char* frame_id,
                                                     rgl_qos_policy_reliability_t qos_reliability,
                                                     rgl_qos_policy_durability_t qos_durability,
                                                     rgl_qos_policy_history_t qos_history, int32_t qos_history_depth);

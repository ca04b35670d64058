// SPDX-License-Identifier: Apache-2.0
// RGL's functions that stand on PCL there; here they need no other library. rgl_node_points_visualize, which opens a
// window, is not implemented.
#pragma once

#include <rgl/api/core.h>

/// Writes x, y, z as a binary PCD file.
RGL_API rgl_status_t rgl_graph_write_pcd_file(rgl_node_t node, const char* file_path);
/// One point per voxel: the centroid of its points.
RGL_API rgl_status_t rgl_node_points_downsample(rgl_node_t* node, float leaf_size_x, float leaf_size_y,
                                                float leaf_size_z);
/// Removes the points of the largest plane that is level, within ground_angle_threshold (rad).
RGL_API rgl_status_t rgl_node_points_remove_ground(rgl_node_t* node, rgl_axis_t sensor_up_axis,
                                                   float ground_angle_threshold, float ground_distance_threshold,
                                                   float ground_filter_distance);
#ifdef __cplusplus
RGL_API rgl_status_t rgl_node_points_visualize(rgl_node_t* node, const char* window_name, int window_width = 1280,
                                               int window_height = 1024, bool fullscreen = false);
#else
RGL_API rgl_status_t rgl_node_points_visualize(rgl_node_t* node, const char* window_name, int window_width,
                                               int window_height, bool fullscreen);
#endif

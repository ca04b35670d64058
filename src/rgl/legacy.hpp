// SPDX-License-Identifier: Apache-2.0
// Functions of earlier levels and of a closed extension that a tape may call; the present headers do not have them.
#pragma once

#include <rgl/api/core.h>

RGL_API rgl_status_t rgl_mesh_update_vertices(rgl_mesh_t mesh, const rgl_vec3f* vertices, int32_t vertex_count);
RGL_API rgl_status_t rgl_node_multi_return_switch(rgl_node_t* node, int32_t return_type);
/// The declaration is that of AWSIM. Levels below 0.18 have no arguments after the divergence.
RGL_API rgl_status_t rgl_node_points_simulate_snow(rgl_node_t* node, float min_range, float max_range, float rain_rate,
                                                   float mean_snowflake_diameter, float terminal_velocity,
                                                   float density, int32_t num_channels, float beam_divergence,
                                                   bool do_simulate_energy_loss, float snowflake_occupancy_threshold);

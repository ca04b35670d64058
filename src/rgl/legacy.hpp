// SPDX-License-Identifier: Apache-2.0
// Functions of earlier levels of the interface that a tape may call; the present header does not have them.
#pragma once

#include <rgl/api/core.h>

RGL_API rgl_status_t rgl_mesh_update_vertices(rgl_mesh_t mesh, const rgl_vec3f* vertices, int32_t vertex_count);
RGL_API rgl_status_t rgl_node_multi_return_switch(rgl_node_t* node, int32_t return_type);

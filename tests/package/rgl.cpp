// SPDX-License-Identifier: Apache-2.0
// One ray against a cube, as the first program with RGL's interface: it must link and run against an installation.
#include <rgl/api/core.h>

#include <cstdio>

int main() {
  const rgl_vec3f vertices[] = {{{-1, -1, 4}}, {{1, -1, 4}}, {{0, 1, 4}}};
  const rgl_vec3i triangle = {{0, 1, 2}};
  const rgl_mat3x4f ray = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
  rgl_mesh_t mesh = nullptr;
  rgl_entity_t entity = nullptr;
  rgl_node_t rays = nullptr, raytrace = nullptr;
  rgl_vec3f point = {};
  const bool good = rgl_mesh_create(&mesh, vertices, 3, &triangle, 1) == RGL_SUCCESS &&
                    rgl_entity_create(&entity, nullptr, mesh) == RGL_SUCCESS &&
                    rgl_node_rays_from_mat3x4f(&rays, &ray, 1) == RGL_SUCCESS &&
                    rgl_node_raytrace(&raytrace, nullptr) == RGL_SUCCESS &&
                    rgl_graph_node_add_child(rays, raytrace) == RGL_SUCCESS && rgl_graph_run(rays) == RGL_SUCCESS &&
                    rgl_graph_get_result_data(raytrace, RGL_FIELD_XYZ_VEC3_F32, &point) == RGL_SUCCESS;
  const char* message = nullptr;
  rgl_get_last_error_string(&message);
  std::printf("%s: z = %g\n", message, point.value[2]);
  return good && point.value[2] == 4 ? 0 : 1;
}

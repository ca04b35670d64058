// SPDX-License-Identifier: Apache-2.0
// RGL's interface as a plug-in of an engine calls it.
#pragma once

#include <rgl/api/core.h>

#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

namespace gnosphere::test {

/// The fields that most tests ask for.
inline const std::vector<rgl_field_t> kBasic = {RGL_FIELD_XYZ_VEC3_F32, RGL_FIELD_IS_HIT_I32, RGL_FIELD_DISTANCE_F32,
                                                RGL_FIELD_ENTITY_ID_I32};

#define OK(call)                                  \
  do {                                            \
    const rgl_status_t status = call;             \
    INFO(gnosphere::test::lastError());           \
    REQUIRE(status == rgl_status_t::RGL_SUCCESS); \
  } while (0)

inline std::string lastError() {
  const char* text = nullptr;
  rgl_get_last_error_string(&text);
  return text;
}

/// Whether a call failed with this status and a sentence that has the words.
inline bool failed(rgl_status_t status, rgl_status_t expected, const std::string& words) {
  INFO(status << ": " << lastError());
  CHECK(status == expected);
  CHECK(lastError().find(words) != std::string::npos);
  return status == expected && lastError().find(words) != std::string::npos;
}

/// Turns about z, then about y, and moves.
inline rgl_mat3x4f matrix(double x, double y, double z, double yaw = 0, double pitch = 0) {
  const auto f = [](double v) { return static_cast<float>(v); };
  const double c = std::cos(yaw), s = std::sin(yaw), d = std::cos(pitch), t = std::sin(pitch);
  return {{{f(c * d), f(-s), f(c * t), f(x)}, {f(s * d), f(c), f(s * t), f(y)}, {f(-t), 0, f(d), f(z)}}};
}

/// Rays over the whole turn, each looking along its own z axis.
inline std::vector<rgl_mat3x4f> raysAround(int rows, int columns) {
  std::vector<rgl_mat3x4f> rays;
  for (int i = 0; i < rows; ++i)
    for (int k = 0; k < columns; ++k)
      rays.push_back(
          matrix(0, 0, 0, 2 * std::numbers::pi * k / columns, std::numbers::pi * (0.25 + 0.5 * (i + 0.5) / rows)));
  return rays;
}

inline rgl_mesh_t squareMesh(float half = 1) {
  const rgl_vec3f vertices[] = {{{-half, -half, 0}}, {{half, -half, 0}}, {{half, half, 0}}, {{-half, half, 0}}};
  const rgl_vec3i triangles[] = {{{0, 1, 2}}, {{0, 2, 3}}};
  rgl_mesh_t mesh = nullptr;
  OK(rgl_mesh_create(&mesh, vertices, 4, triangles, 2));
  return mesh;
}

inline rgl_entity_t place(rgl_mesh_t mesh, const rgl_mat3x4f& transform) {
  rgl_entity_t entity = nullptr;
  OK(rgl_entity_create(&entity, nullptr, mesh));
  OK(rgl_entity_set_transform(entity, &transform));
  return entity;
}

/// rays -> transform -> raytrace -> yield.
struct Lidar {
  rgl_node_t rays = nullptr, pose = nullptr, raytrace = nullptr, yield = nullptr;

  Lidar(const std::vector<rgl_mat3x4f>& matrices, std::vector<rgl_field_t> fields) {
    OK(rgl_node_rays_from_mat3x4f(&rays, matrices.data(), static_cast<int32_t>(matrices.size())));
    move(matrix(0, 0, 0));
    OK(rgl_node_raytrace(&raytrace, nullptr));
    OK(rgl_node_points_yield(&yield, fields.data(), static_cast<int32_t>(fields.size())));
    OK(rgl_graph_node_add_child(rays, pose));
    OK(rgl_graph_node_add_child(pose, raytrace));
    OK(rgl_graph_node_add_child(raytrace, yield));
  }
  void move(const rgl_mat3x4f& transform) { OK(rgl_node_rays_transform(&pose, &transform)); }
  /// Puts a node of points behind the yield node.
  void append(rgl_node_t node) {
    OK(rgl_graph_node_add_child(yield, node));
    last = node;
  }
  void run() { OK(rgl_graph_run(rays)); }
  template <class T>
  std::vector<T> get(rgl_field_t field) const {
    int32_t count = 0, size = 0;
    const rgl_node_t node = last ? last : yield;
    OK(rgl_graph_get_result_size(node, field, &count, &size));
    REQUIRE(size == sizeof(T));
    std::vector<T> values(count);
    if (count > 0) OK(rgl_graph_get_result_data(node, field, values.data()));
    return values;
  }

  rgl_node_t last = nullptr;
};

}  // namespace gnosphere::test

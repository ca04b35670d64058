// SPDX-License-Identifier: Apache-2.0
// Nodes of points and of radar of libgnosphere_rgl, against closed forms.
#include <rgl/api/extensions/pcl.h>

#include <algorithm>
#include <catch2/catch_approx.hpp>
#include <cstdlib>
#include <string>

#include "folder.hpp"
#include "rgl/plugin.hpp"

using namespace gnosphere;
using namespace gnosphere::test;
using Catch::Approx;

TEST_CASE("RGL: noise has its mean and deviation, and is the same again with the same seed") {
  place(squareMesh(500), matrix(0, 0, 10));
  const auto draw = [](const char* seed) {
    seed ? setenv("GNOSPHERE_RGL_SEED", seed, 1) : unsetenv("GNOSPHERE_RGL_SEED");
    rgl_node_t noise = nullptr;
    OK(rgl_node_gaussian_noise_distance(&noise, 0.5f, 0.01f, 0.002f));
    Lidar lidar(std::vector<rgl_mat3x4f>(20'000, matrix(0, 0, 0)), kBasic);
    lidar.append(noise);
    lidar.run();
    auto result = lidar.get<float>(RGL_FIELD_DISTANCE_F32);
    OK(rgl_graph_destroy(noise));
    return result;
  };
  const auto first = draw("7");
  double mean = 0, square = 0;
  for (const float value : first) mean += value / 20'000.0;
  for (const float value : first) square += (value - mean) * (value - mean) / 20'000.0;
  CHECK(mean == Approx(10.5).margin(0.001));
  CHECK(std::sqrt(square) == Approx(0.01 + 0.002 * 10).epsilon(0.03));
  OK(rgl_cleanup());
  place(squareMesh(500), matrix(0, 0, 10));
  CHECK(draw("7") == first);
  CHECK(draw(nullptr) != first);
  OK(rgl_cleanup());
}

TEST_CASE("RGL: merges, ground and voxels") {
  const rgl_mesh_t mesh = squareMesh(20);
  place(mesh, matrix(0, 0, -2));
  place(mesh, matrix(6, 0, 0, 0, std::numbers::pi / 2));
  const auto rays = raysAround(20, 40);
  const std::vector<rgl_field_t> fields = {RGL_FIELD_XYZ_VEC3_F32, RGL_FIELD_IS_HIT_I32, RGL_FIELD_NORMAL_VEC3_F32};
  Lidar lidar(rays, fields), other(rays, fields);
  rgl_node_t hits = nullptr, ground = nullptr, kept = nullptr, merged = nullptr, all = nullptr;
  const rgl_vec3f up = {{0, 0, 1}};
  OK(rgl_node_points_compact_by_field(&hits, RGL_FIELD_IS_HIT_I32));
  OK(rgl_node_points_filter_ground(&ground, &up, 0.1f));
  OK(rgl_node_points_compact_by_field(&kept, RGL_FIELD_IS_GROUND_I32));
  OK(rgl_node_points_temporal_merge(&all, fields.data(), 1));
  OK(rgl_node_points_spatial_merge(&merged, fields.data(), 1));
  lidar.append(hits);
  OK(rgl_graph_node_add_child(hits, ground));
  OK(rgl_graph_node_add_child(ground, kept));
  OK(rgl_graph_node_add_child(kept, all));
  lidar.run();
  const size_t hitCount = lidar.get<rgl_vec3f>(RGL_FIELD_XYZ_VEC3_F32).size();
  lidar.last = kept;
  const auto points = lidar.get<rgl_vec3f>(RGL_FIELD_XYZ_VEC3_F32);
  CHECK((!points.empty() && points.size() < hitCount));
  for (const rgl_vec3f& point : points) CHECK(point.value[0] == Approx(6).epsilon(1e-5));  // the wall: not ground
  lidar.run();
  lidar.last = all;
  CHECK(lidar.get<rgl_vec3f>(RGL_FIELD_XYZ_VEC3_F32).size() == 2 * points.size());
  OK(rgl_graph_node_add_child(kept, merged));
  CHECK(failed(rgl_graph_run(lidar.rays), RGL_INVALID_PIPELINE, "IPointsNode"));
  OK(rgl_graph_node_add_child(other.yield, merged));
  lidar.run();
  lidar.last = merged;
  CHECK(lidar.get<rgl_vec3f>(RGL_FIELD_XYZ_VEC3_F32).size() == points.size() + rays.size());

  // Two points in one voxel, one in another; and the plane that most points lie on.
  OK(rgl_cleanup());
  const std::vector<rgl_vec3f> some = {{{0.1f, 0.1f, 0.1f}}, {{0.3f, 0.1f, 0.1f}}, {{-0.2f, 0.1f, 0.1f}}};
  rgl_node_t array = nullptr, voxels = nullptr;
  const rgl_field_t field = RGL_FIELD_XYZ_VEC3_F32;
  OK(rgl_node_points_from_array(&array, some.data(), 3, &field, 1));
  OK(rgl_node_points_downsample(&voxels, 1, 1, 1));
  OK(rgl_graph_node_add_child(array, voxels));
  OK(rgl_graph_run(array));
  rgl_vec3f two[2];
  OK(rgl_graph_get_result_data(voxels, field, two));
  CHECK(two[0].value[0] == Approx(-0.2));
  CHECK(two[1].value[0] == Approx(0.2));
  const Folder folder;
  OK(rgl_graph_write_pcd_file(voxels, (folder / "two.pcd").c_str()));
  const std::string file = bytesOf(folder / "two.pcd");
  CHECK(file.ends_with(std::string(reinterpret_cast<const char*>(two), sizeof two)));
  CHECK(file.find("POINTS 2\n") != std::string::npos);
  std::vector<rgl_vec3f> town;
  for (int i = 0; i < 400; ++i) {
    const float x = static_cast<float>(i % 20), y = static_cast<float>(i / 20);
    town.push_back({{x, y, 0.01f * static_cast<float>(i % 3)}});
    if (i % 10 == 0) town.push_back({{x, y, 3}});
  }
  rgl_node_t clean = nullptr;
  OK(rgl_node_points_from_array(&array, town.data(), static_cast<int32_t>(town.size()), &field, 1));
  OK(rgl_node_points_remove_ground(&clean, RGL_AXIS_Z, 0.1f, 0.1f, 0.1f));
  OK(rgl_graph_node_add_child(array, clean));
  OK(rgl_graph_run(array));
  int32_t left = 0;
  OK(rgl_graph_get_result_size(clean, field, &left, nullptr));
  CHECK(left == 40);
  OK(rgl_cleanup());
}

TEST_CASE("RGL: radar detections are clusters, and objects keep their ids") {
  place(squareMesh(), matrix(0, 0, 20));
  place(squareMesh(), matrix(9, 0, 40));
  std::vector<rgl_mat3x4f> rays;
  for (int i = -20; i <= 20; ++i)
    for (int k = -5; k <= 5; ++k) {
      const float a = 0.015f * static_cast<float>(i), e = 0.01f * static_cast<float>(k);
      const float ca = std::cos(a), sa = std::sin(a), ce = std::cos(e), se = std::sin(e);
      rays.push_back({{{ca, -sa * se, sa * ce, 0}, {0, ce, se, 0}, {-sa, -ca * se, ca * ce, 0}}});
    }
  OK(rgl_scene_set_time(nullptr, 1));
  OK(rgl_scene_set_time(nullptr, 1'000'000));
  Lidar lidar(rays, kBasic);
  rgl_node_t hits = nullptr, radar = nullptr, objects = nullptr, wanted = nullptr;
  const rgl_radar_scope_t scope = {0, 100, 2, 1, 0.05f};
  const rgl_field_t fields[] = {RGL_FIELD_RCS_F32, RGL_FIELD_SNR_F32, RGL_FIELD_POWER_F32, RGL_FIELD_NOISE_F32};
  OK(rgl_node_points_compact_by_field(&hits, RGL_FIELD_IS_HIT_I32));
  OK(rgl_node_points_radar_postprocess(&radar, &scope, 1, 0.015f, 0.01f, 79e9f, 31, 27, 60, 1));
  OK(rgl_node_points_yield(&wanted, fields, 4));
  OK(rgl_node_points_radar_track_objects(&objects, 2, 0.1f, 0.1f, 1, 5, 500, 0.01f));
  lidar.append(hits);
  OK(rgl_graph_node_add_child(hits, radar));
  OK(rgl_graph_node_add_child(radar, wanted));
  OK(rgl_graph_node_add_child(radar, objects));
  lidar.run();
  lidar.last = wanted;
  const auto power = lidar.get<float>(RGL_FIELD_POWER_F32), noise = lidar.get<float>(RGL_FIELD_NOISE_F32);
  const auto snr = lidar.get<float>(RGL_FIELD_SNR_F32), distance = lidar.get<float>(RGL_FIELD_DISTANCE_F32);
  REQUIRE(power.size() == 2);
  for (int i = 0; i < 2; ++i) CHECK(snr[i] == Approx(power[i] - noise[i]));
  CHECK(std::min(distance[0], distance[1]) == Approx(20).margin(0.5));
  lidar.last = objects;
  const auto first = lidar.get<int32_t>(RGL_FIELD_ENTITY_ID_I32);
  CHECK(first.size() == 2);
  OK(rgl_scene_set_time(nullptr, 101'000'000));
  lidar.run();
  CHECK(lidar.get<int32_t>(RGL_FIELD_ENTITY_ID_I32) == first);
  OK(rgl_cleanup());
}

// SPDX-License-Identifier: Apache-2.0
// Rays of libgnosphere_rgl: when they are sorted anew, which costs most of a frame, that results do not depend on it,
// and the nodes that mask and turn rays.
#include <algorithm>
#include <catch2/catch_approx.hpp>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <utility>

#include "folder.hpp"
#include "rgl/plugin.hpp"

using namespace gnosphere;
using namespace gnosphere::test;
using Catch::Approx;

namespace {

/// Counts how often rays are sorted anew, by the library's messages.
class SortedRays {
 public:
  SortedRays() { OK(rgl_configure_logging(RGL_LOG_LEVEL_DEBUG, (folder_ / "log").string().c_str(), false)); }
  ~SortedRays() { (void)rgl_configure_logging(RGL_LOG_LEVEL_OFF, nullptr, false); }
  /// Counts those since the last call.
  int count() {
    int all = 0;
    std::ifstream log(folder_ / "log");
    for (std::string line; std::getline(log, line);) all += line.find("sorted anew") != line.npos;
    return all - std::exchange(before_, all);
  }

 private:
  Folder folder_;
  int before_ = 0;
};

/// A place and a rotation that differ from frame to frame, as single precision rounds them, with a scale.
rgl_mat3x4f turned(int frame, float scale = 1) {
  const auto k = static_cast<float>(frame);
  const float cx = std::cos(0.01f * k), sx = std::sin(0.01f * k), cy = std::cos(0.02f * k), sy = std::sin(0.02f * k),
              cz = std::cos(0.3f + 0.013f * k), sz = std::sin(0.3f + 0.013f * k);
  rgl_mat3x4f matrix = {{{cy * cz, sx * sy * cz - cx * sz, sx * sz + cx * sy * cz, 0.01f * k},
                         {cy * sz, cx * cz + sx * sy * sz, cx * sy * sz - sx * cz, 0.25f},
                         {-sy, sx * cy, cx * cy, -0.5f}}};
  for (auto& row : matrix.value)
    for (int j = 0; j < 3; ++j) row[j] *= scale;
  return matrix;
}

/// The product of two maps in single precision, in the library's order of operations.
rgl_mat3x4f product(const rgl_mat3x4f& a, const rgl_mat3x4f& b) {
  rgl_mat3x4f c = {};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 4; ++j) {
      c.value[i][j] = a.value[i][0] * b.value[0][j] + a.value[i][1] * b.value[1][j] + a.value[i][2] * b.value[2][j];
      if (j == 3) c.value[i][j] += a.value[i][3];
    }
  return c;
}

}  // namespace

TEST_CASE("RGL: rays are not sorted anew when a sensor turns, or gets the values that it has") {
  SortedRays sorted;
  place(squareMesh(3), matrix(0, 0, 4));
  auto rays = raysAround(8, 20);
  const auto count = static_cast<int32_t>(rays.size());
  const rgl_vec2f limits = {{0.1f, 100}};
  std::vector<float> times(rays.size(), 10);
  const rgl_vec3f still = {{0, 0, 0}};
  rgl_vec3f ahead = {{0, 0, 5}};
  float divergence = 0.01f, deviation = 0;
  Lidar lidar(rays, kBasic);
  rgl_node_t range = nullptr, offsets = nullptr, noise = nullptr;
  const auto setAll = [&] {
    OK(rgl_node_rays_from_mat3x4f(&lidar.rays, rays.data(), count));
    OK(rgl_node_rays_set_range(&range, &limits, 1));
    OK(rgl_node_rays_set_time_offsets(&offsets, times.data(), count));
    OK(rgl_node_gaussian_noise_angular_ray(&noise, 0.1f, deviation, RGL_AXIS_Z));
    OK(rgl_node_raytrace_configure_velocity(lidar.raytrace, &ahead, &still));
    OK(rgl_node_raytrace_configure_distortion(lidar.raytrace, true));
    OK(rgl_node_raytrace_configure_beam_divergence(lidar.raytrace, divergence, divergence));
  };
  setAll();
  OK(rgl_graph_node_remove_child(lidar.rays, lidar.pose));
  for (const auto& [parent, child] : {std::pair{lidar.rays, range}, std::pair{range, offsets},
                                      std::pair{offsets, noise}, std::pair{noise, lidar.pose}})
    OK(rgl_graph_node_add_child(parent, child));
  const auto sortedIn = [&](int frames, float scale) {
    for (int frame = 0; frame < frames; ++frame) {
      setAll();
      lidar.move(turned(frame, scale));
      lidar.run();
    }
    return sorted.count();
  };
  for (const float scale : {1.0f, 1.00001f, 0.75f}) CHECK(sortedIn(40, scale) == 1);
  // Each value that matters changes what is sorted.
  const std::function<void()> changes[] = {[&] { rays[0] = matrix(0, 0, 0, 0.1); }, [&] { times[3] = 20; },
                                           [&] { ahead.value[2] = 6; }, [&] { divergence = 0.02f; }};
  for (const auto& change : changes) {
    change();
    CHECK(sortedIn(2, 0.75f) == 1);
  }
  deviation = 0.01f;
  CHECK(sortedIn(3, 0.75f) == 3);
  OK(rgl_cleanup());
}

TEST_CASE("RGL: a pose gives what the same rays in the world give, whether it scales, shears or mirrors") {
  rgl_mesh_t mesh = squareMesh(6);
  for (int k = 0; k < 6; ++k) place(mesh, matrix(k == 0 ? 9 : k == 1 ? -9 : 0, k == 2 ? 9 : 0, k == 3 ? 8 : -8, k, 1));
  auto rays = raysAround(12, 30);
  for (size_t i = 0; i < rays.size(); ++i)
    for (int k = 0; k < 3; ++k) rays[i].value[k][3] = 0.3f * static_cast<float>((i + 5 * k) % 7);
  rgl_mat3x4f sheared = turned(7), mirrored = turned(9);
  for (auto& row : sheared.value) row[1] += 0.25f * row[0];
  for (auto& row : mirrored.value) row[0] = -row[0];
  for (const rgl_mat3x4f& pose :
       {turned(3), turned(4, 1.00001f), turned(5, 2), turned(6, 0.1f), sheared, mirrored, turned(8)}) {
    std::vector<rgl_mat3x4f> inWorld;
    for (const rgl_mat3x4f& ray : rays) inWorld.push_back(product(pose, ray));
    Lidar moved(rays, kBasic), still(inWorld, kBasic);
    moved.move(pose);
    moved.run();
    still.run();
    const auto hits = still.get<int32_t>(RGL_FIELD_IS_HIT_I32);
    CHECK(std::count(hits.begin(), hits.end(), 1) > 50);
    CHECK(moved.get<int32_t>(RGL_FIELD_IS_HIT_I32) == hits);
    CHECK(moved.get<float>(RGL_FIELD_DISTANCE_F32) == still.get<float>(RGL_FIELD_DISTANCE_F32));
  }
  OK(rgl_cleanup());
}

TEST_CASE("RGL: masked rays hit nothing, and a mask has an entry for each ray") {
  place(squareMesh(), matrix(0, 0, 5));
  Lidar lidar({matrix(0, 0, 0), matrix(0.5, 0, 0), matrix(-0.5, 0, 0)}, kBasic);
  OK(rgl_node_raytrace_configure_non_hits(lidar.raytrace, 1, 7));
  int8_t mask[] = {1, 0, -1};
  OK(rgl_node_raytrace_configure_mask(lidar.raytrace, mask, 3));
  lidar.run();
  CHECK(lidar.get<float>(RGL_FIELD_DISTANCE_F32) == std::vector<float>{5, 7, 5});
  CHECK(lidar.get<int32_t>(RGL_FIELD_IS_HIT_I32) == std::vector<int32_t>{1, 0, 1});
  mask[1] = 1;
  OK(rgl_node_raytrace_configure_mask(lidar.raytrace, mask, 3));
  lidar.run();
  CHECK(lidar.get<int32_t>(RGL_FIELD_IS_HIT_I32) == std::vector<int32_t>{1, 1, 1});
  OK(rgl_node_raytrace_configure_mask(lidar.raytrace, mask, 2));
  CHECK(failed(rgl_graph_run(lidar.rays), RGL_INVALID_PIPELINE, "the mask has 2 entries for 3 rays"));
  CHECK(failed(rgl_node_raytrace_configure_mask(lidar.raytrace, nullptr, 3), RGL_INVALID_ARGUMENT, "rays_mask"));
  CHECK(failed(rgl_node_raytrace_configure_mask(lidar.raytrace, mask, 0), RGL_INVALID_ARGUMENT, "rays_count > 0"));
  OK(rgl_cleanup());
}

TEST_CASE("RGL: noise of angles turns the rays, or the points that they hit, about an axis of the sensor") {
  setenv("GNOSPHERE_RGL_SEED", "3", 1);
  constexpr int kRays = 5'000;
  constexpr float kMean = 0.2f, kDeviation = 0.01f;
  const double s = std::sin(kMean), c = std::cos(kMean);
  for (const bool ofPoints : {false, true}) {
    CAPTURE(ofPoints);
    place(squareMesh(500), matrix(0, 0, 10));
    Lidar lidar(std::vector<rgl_mat3x4f>(kRays, matrix(0, 0, 0)), kBasic);
    lidar.move(matrix(1, 2, 3, std::numbers::pi / 2));  // the sensor's x axis is y in the world
    rgl_node_t noise = nullptr;
    const auto set = [&](float deviation, rgl_axis_t axis) {
      OK(ofPoints ? rgl_node_gaussian_noise_angular_hitpoint(&noise, kMean, deviation, axis)
                  : rgl_node_gaussian_noise_angular_ray(&noise, kMean, deviation, axis));
    };
    set(0, RGL_AXIS_Y);
    if (ofPoints) {
      lidar.append(noise);
    } else {
      OK(rgl_graph_node_remove_child(lidar.rays, lidar.pose));
      OK(rgl_graph_node_add_child(lidar.rays, noise));
      OK(rgl_graph_node_add_child(noise, lidar.pose));
    }
    // The wall is 7 m before the sensor. A point that is turned keeps its distance; a ray goes on to the wall.
    const double away = ofPoints ? 7 : 7 / c;
    const auto check = [&](double x, double y, double z, double distance) {  // in the frame of the sensor
      lidar.run();
      const rgl_vec3f point = lidar.get<rgl_vec3f>(RGL_FIELD_XYZ_VEC3_F32).at(0);
      CHECK(point.value[0] == Approx(1 - y));
      CHECK(point.value[1] == Approx(2 + x));
      CHECK(point.value[2] == Approx(3 + z));
      CHECK(lidar.get<float>(RGL_FIELD_DISTANCE_F32).at(0) == Approx(distance));
    };
    check(away * s, 0, away * c, away);
    set(0, RGL_AXIS_X);
    check(0, -away * s, away * c, away);
    set(0, RGL_AXIS_Z);
    check(0, 0, 7, 7);
    set(kDeviation, RGL_AXIS_Y);
    lidar.run();
    double mean = 0, square = 0;
    std::vector<double> angles;
    for (const rgl_vec3f& point : lidar.get<rgl_vec3f>(RGL_FIELD_XYZ_VEC3_F32))
      angles.push_back(std::atan2(point.value[1] - 2, point.value[2] - 3));
    for (const double angle : angles) mean += angle / kRays;
    for (const double angle : angles) square += (angle - mean) * (angle - mean) / kRays;
    CHECK(mean == Approx(kMean).margin(4 * kDeviation / std::sqrt(kRays)));
    CHECK(std::sqrt(square) == Approx(kDeviation).epsilon(4 / std::sqrt(2.0 * kRays)));
    OK(rgl_cleanup());
  }
  rgl_node_t none = nullptr;
  for (const auto make : {rgl_node_gaussian_noise_angular_hitpoint, rgl_node_gaussian_noise_angular_ray}) {
    CHECK(failed(make(&none, 0, -1, RGL_AXIS_X), RGL_INVALID_ARGUMENT, "st_dev >= 0"));
    CHECK(failed(make(&none, 0, 1, static_cast<rgl_axis_t>(9)), RGL_INVALID_ARGUMENT, "rotation_axis"));
  }
  unsetenv("GNOSPHERE_RGL_SEED");
}

TEST_CASE("RGL: numbers of rings, ranges, time offsets and fields that do not suit the rays are errors of the graph") {
  place(squareMesh(), matrix(0, 0, 5));
  Lidar lidar({matrix(0, 0, 0), matrix(0.5, 0, 0), matrix(-0.5, 0, 0)}, kBasic);
  OK(rgl_node_raytrace_configure_distortion(lidar.raytrace, true));
  CHECK(failed(rgl_graph_run(lidar.rays), RGL_INVALID_PIPELINE, "requires time offsets of the rays"));
  OK(rgl_node_raytrace_configure_distortion(lidar.raytrace, false));
  rgl_node_t rings = nullptr, ranges = nullptr, offsets = nullptr;
  const int32_t ids[] = {4, 5};
  const rgl_vec2f limits[] = {{{0, 1}}, {{0, 2}}};
  const float times[] = {1, 2};
  OK(rgl_node_rays_set_ring_ids(&rings, ids, 2));
  OK(rgl_node_rays_set_range(&ranges, limits, 2));
  OK(rgl_node_rays_set_time_offsets(&offsets, times, 2));
  OK(rgl_graph_node_remove_child(lidar.rays, lidar.pose));
  for (const auto& [node, words] : {std::pair{rings, "ring ids doesn't match number of rays (2 and 3)"},
                                    std::pair{ranges, "ranges doesn't match number of rays (2 and 3)"},
                                    std::pair{offsets, "time offsets doesn't match number of rays (2 and 3)"}}) {
    OK(rgl_graph_node_add_child(lidar.rays, node));
    OK(rgl_graph_node_add_child(node, lidar.pose));
    CHECK(failed(rgl_graph_run(lidar.rays), RGL_INVALID_PIPELINE, words));
    OK(rgl_graph_node_remove_child(lidar.rays, node));
    CHECK(failed(rgl_graph_node_remove_child(lidar.rays, node), RGL_INVALID_PIPELINE, "but it was not found"));
    OK(rgl_graph_node_remove_child(node, lidar.pose));
  }
  // Rings repeat over the rays, and each ray may have a range of its own.
  const rgl_vec2f own[] = {{{0, 9}}, {{0, 4}}, {{6, 9}}};
  OK(rgl_node_rays_set_ring_ids(&rings, ids + 1, 1));
  OK(rgl_node_rays_set_range(&ranges, own, 3));
  OK(rgl_node_raytrace_configure_non_hits(lidar.raytrace, 1, 7));
  OK(rgl_graph_node_add_child(lidar.rays, rings));
  OK(rgl_graph_node_add_child(rings, ranges));
  OK(rgl_graph_node_add_child(ranges, lidar.pose));
  rgl_node_t yield = nullptr;
  const rgl_field_t ring = RGL_FIELD_RING_ID_U16, time = RGL_FIELD_TIME_STAMP_F64;
  OK(rgl_node_points_yield(&yield, &ring, 1));
  lidar.append(yield);
  lidar.run();
  CHECK(lidar.get<float>(RGL_FIELD_DISTANCE_F32) == std::vector<float>{5, 7, 1});
  CHECK(lidar.get<uint16_t>(ring) == std::vector<uint16_t>{5, 5, 5});
  OK(rgl_node_points_yield(&yield, &time, 1));
  CHECK(failed(rgl_graph_run(lidar.rays), RGL_INVALID_PIPELINE, "TIME_STAMP_F64 needs the scene's time"));
  OK(rgl_cleanup());
}

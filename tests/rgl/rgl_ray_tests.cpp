// SPDX-License-Identifier: Apache-2.0
// Rays of libgnosphere_rgl: when they are sorted anew, which costs most of a frame, and that results do not depend on
// it.
#include <algorithm>
#include <fstream>
#include <functional>
#include <utility>

#include "folder.hpp"
#include "rgl/plugin.hpp"

using namespace gnosphere;
using namespace gnosphere::test;

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

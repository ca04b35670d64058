// SPDX-License-Identifier: Apache-2.0
// libgnosphere_rgl as a plug-in uses it: against the C++ interface with the same rays, and against closed forms. Tests
// run on the device "reference" unless GNOSPHERE_RGL_DEVICE says another.
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch_approx.hpp>
#include <cstdlib>
#include <cstring>
#include <gnosphere/gnosphere.hpp>
#include <limits>

#include "rgl/plugin.hpp"

using namespace gnosphere;
using namespace gnosphere::test;
using Catch::Approx;

namespace {

[[maybe_unused]] const bool kPrepared = [] {
  setenv("GNOSPHERE_RGL_DEVICE", "reference", 0);
  return rgl_configure_logging(RGL_LOG_LEVEL_OFF, nullptr, false) == RGL_SUCCESS;
}();

/// The same rays and squares with the C++ interface.
class Expected {
 public:
  Expected() {
    SimulatorOptions options;
    options.device = deviceByName(std::getenv("GNOSPHERE_RGL_DEVICE"));
    options.faces = ReflectingFaces::both;
    gnosphere::Scene scene;
    scene.materials.resize(1);
    gnosphere::Mesh mesh;
    mesh.positions = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
    mesh.indices = {0, 1, 2, 0, 2, 3};
    mesh.parts = {{0, 2, 0}};
    scene.meshes = {mesh};
    simulator_ = std::make_unique<Simulator>(scene, std::vector<SensorRequest>(), options);
  }
  size_t add(const rgl_mat3x4f& transform) { return simulator_->addInstance(0, of(transform)); }
  Scan scan(const std::vector<rgl_mat3x4f>& rays, const rgl_mat3x4f& pose) {
    Sensor sensor;
    sensor.rangeMax = 1000;
    sensor.patterns.resize(1);
    for (const rgl_mat3x4f& ray : rays)
      sensor.patterns[0].directions.push_back({ray.value[0][2], ray.value[1][2], ray.value[2][2]});
    const size_t index = simulator_->addSensor({sensor, Effects::none()});
    const double yaw = std::atan2(pose.value[1][0], pose.value[0][0]);
    Shot shot;
    shot.sensor = index;
    shot.pose = {{pose.value[0][3], pose.value[1][3], pose.value[2][3]}, {0, 0, std::sin(yaw / 2), std::cos(yaw / 2)}};
    Scan scan;
    simulator_->scanInto(shot, scan);
    simulator_->removeSensor(index);
    return scan;
  }
  Simulator* operator->() { return simulator_.get(); }
  static Transform of(const rgl_mat3x4f& matrix) {
    Transform result;
    for (int i = 0; i < 12; ++i) result.rows[i] = matrix.value[i / 4][i % 4];
    return result;
  }

 private:
  std::unique_ptr<Simulator> simulator_;
};

/// Compares a run with a scan of the same rays: what is hit, which entity, and how far.
void compareWith(const Scan& scan, Lidar& lidar, const std::vector<int32_t>& ids) {
  const auto hits = lidar.get<int32_t>(RGL_FIELD_IS_HIT_I32), entities = lidar.get<int32_t>(RGL_FIELD_ENTITY_ID_I32);
  const auto distances = lidar.get<float>(RGL_FIELD_DISTANCE_F32);
  REQUIRE(hits.size() == scan.ranges.size());
  size_t count = 0;
  for (size_t i = 0; i < hits.size(); ++i) {
    INFO("ray " << i);
    REQUIRE(hits[i] == scan.hit(i));
    if (!scan.hit(i)) {
      REQUIRE(std::isinf(distances[i]));
      continue;
    }
    ++count;
    REQUIRE(entities[i] == ids[scan.instances[i]]);
    REQUIRE(distances[i] == Approx(scan.ranges[i]).epsilon(2e-6));
  }
  CHECK(count > 0);
}

}  // namespace

TEST_CASE("RGL: a plug-in's frames have the points of the C++ interface, whatever moves, comes and goes", "[device]") {
  const auto rays = raysAround(16, 90);
  Expected expected;
  const rgl_mesh_t mesh = squareMesh();
  const rgl_mat3x4f places[] = {matrix(4, 0, 0, 0, 1.5), matrix(0, 3, 0.5, 1, 1), matrix(0, 0, -1)};
  std::vector<rgl_entity_t> entities;
  std::vector<int32_t> ids = {11, 22, 33};
  for (int i = 0; i < 3; ++i) {
    entities.push_back(place(mesh, places[i]));
    OK(rgl_entity_set_id(entities[i], ids[i]));
    CHECK(expected.add(places[i]) == size_t(i));
  }
  OK(rgl_mesh_destroy(mesh));  // the entities keep it

  Lidar lidar(rays, kBasic);
  lidar.run();
  compareWith(expected.scan(rays, matrix(0, 0, 0)), lidar, ids);
  // The sensor moves, then an entity; then one goes, and another comes.
  const rgl_mat3x4f pose = matrix(0.5, -0.25, 0.25, 0.7), other = matrix(3, 1, 0, 0.2, 1.3);
  lidar.move(pose);
  OK(rgl_entity_set_transform(entities[0], &other));
  expected->setTransform(0, Expected::of(other));
  lidar.run();
  compareWith(expected.scan(rays, pose), lidar, ids);
  OK(rgl_entity_destroy(entities[1]));
  expected->removeInstance(1);
  lidar.run();
  compareWith(expected.scan(rays, pose), lidar, ids);
  const rgl_mesh_t second = squareMesh();
  OK(rgl_entity_set_id(place(second, places[1]), 44));
  expected.add(places[1]);
  ids[1] = 44;
  lidar.run();
  compareWith(expected.scan(rays, pose), lidar, ids);

  // Points are on their rays; compacted and packed, they are the same in order.
  const auto xyz = lidar.get<rgl_vec3f>(RGL_FIELD_XYZ_VEC3_F32);
  const auto distances = lidar.get<float>(RGL_FIELD_DISTANCE_F32);
  const auto hits = lidar.get<int32_t>(RGL_FIELD_IS_HIT_I32);
  rgl_node_t compact = nullptr, format = nullptr;
  const std::vector<rgl_field_t> fields = {RGL_FIELD_XYZ_VEC3_F32, RGL_FIELD_PADDING_8, RGL_FIELD_DISTANCE_F32};
  OK(rgl_node_points_compact_by_field(&compact, RGL_FIELD_IS_HIT_I32));
  OK(rgl_node_points_format(&format, fields.data(), 3));
  lidar.append(compact);
  OK(rgl_graph_node_add_child(compact, format));
  lidar.run();
  int32_t count = 0, size = 0;
  OK(rgl_graph_get_result_size(format, RGL_FIELD_DYNAMIC_FORMAT, &count, &size));
  REQUIRE(size == 17);
  std::vector<char> rows(count * size);
  OK(rgl_graph_get_result_data(format, RGL_FIELD_DYNAMIC_FORMAT, rows.data()));
  size_t row = 0;
  for (size_t i = 0; i < hits.size(); ++i) {
    if (!hits[i]) continue;
    REQUIRE(row < size_t(count));
    CHECK(std::memcmp(&rows[17 * row], &xyz[i], 12) == 0);
    CHECK(std::memcmp(&rows[17 * row + 13], &distances[i], 4) == 0);
    const double x = xyz[i].value[0] - 0.5, y = xyz[i].value[1] + 0.25, z = xyz[i].value[2] - 0.25;
    CHECK(std::sqrt(x * x + y * y + z * z) == Approx(distances[i]).epsilon(1e-5));
    ++row;
  }
  CHECK(row == size_t(count));
  OK(rgl_cleanup());
}

TEST_CASE("RGL: an entity that cannot be destroyed, because the process was forked, is there as before") {
  const rgl_entity_t entity = place(squareMesh(3), matrix(0, 0, 4));
  Lidar lidar({matrix(0, 0, 0)}, kBasic);
  lidar.run();
  const pid_t child = fork();
  if (child == 0) {
    alarm(100);
    const rgl_status_t first = rgl_entity_destroy(entity), second = rgl_entity_destroy(entity);
    _exit(first == RGL_SUCCESS || second != first);
  }
  int ended = -1;
  REQUIRE(waitpid(child, &ended, 0) == child);
  CHECK(ended == 0);
  OK(rgl_cleanup());
}

TEST_CASE("RGL: rays far apart, scaled, mirrored and without a direction") {
  std::vector<rgl_mat3x4f> rays = {matrix(0, 0, 0), matrix(5000, 0, 0), matrix(-3000, 7000, 0), matrix(0, 0, 0)};
  for (auto& row : rays[3].value) row[2] = 0;
  const rgl_mesh_t mesh = squareMesh(3);
  for (int i = 0; i < 3; ++i) place(mesh, matrix(rays[i].value[0][3], rays[i].value[1][3], 2 + i));
  Lidar lidar(rays, kBasic);
  lidar.run();
  CHECK(lidar.get<float>(RGL_FIELD_DISTANCE_F32) ==
        std::vector<float>{2, 3, 4, std::numeric_limits<float>::infinity()});
  // A sensor that is twice as large and mirrored: distances are those of the world, limits those of the sensor.
  const rgl_mat3x4f twice = {{{-2, 0, 0, 0}, {0, 2, 0, 0}, {0, 0, 2, 0}}};
  lidar.move(twice);
  lidar.run();
  CHECK(lidar.get<float>(RGL_FIELD_DISTANCE_F32)[0] == 2);
  rgl_node_t range = nullptr;
  const rgl_vec2f limits = {{0, 0.75f}};
  OK(rgl_node_rays_set_range(&range, &limits, 1));
  OK(rgl_graph_node_remove_child(lidar.rays, lidar.pose));
  OK(rgl_graph_node_add_child(lidar.rays, range));
  OK(rgl_graph_node_add_child(range, lidar.pose));
  lidar.run();
  CHECK(lidar.get<int32_t>(RGL_FIELD_IS_HIT_I32)[0] == 0);
  // A hit 2 m away is 1 m away in the units of the lidar, whether its axes have one scale or three.
  const rgl_vec2f farther = {{0, 1.25f}};
  OK(rgl_node_rays_set_range(&range, &farther, 1));
  for (const float scale : {2.f, 3.f}) {
    lidar.move({{{-scale, 0, 0, 0}, {0, 2, 0, 0}, {0, 0, 2, 0}}});
    lidar.run();
    CHECK(lidar.get<int32_t>(RGL_FIELD_IS_HIT_I32)[0] == 1);
    CHECK(lidar.get<float>(RGL_FIELD_DISTANCE_F32)[0] == 2);
  }
  OK(rgl_cleanup());
}

TEST_CASE("RGL: a node of rays that gets other rays scans with them") {
  place(squareMesh(), matrix(0, 0, 5));
  Lidar lidar({matrix(0, 0, 0)}, {RGL_FIELD_DISTANCE_F32});
  const float infinity = std::numeric_limits<float>::infinity();
  for (const auto& [x, distance] : {std::pair(0.f, 5.f), {3.f, infinity}, {0.5f, 5.f}}) {
    const rgl_mat3x4f ray = matrix(x, 0, 0);
    OK(rgl_node_rays_from_mat3x4f(&lidar.rays, &ray, 1));
    lidar.run();
    CHECK(lidar.get<float>(RGL_FIELD_DISTANCE_F32) == std::vector<float>{distance});
  }
  OK(rgl_cleanup());
}

TEST_CASE("RGL: near surfaces hide, and non-hits have the distances that are set") {
  const rgl_mesh_t mesh = squareMesh();
  place(mesh, matrix(0, 0, 2));
  place(mesh, matrix(0, 0, 5));
  Lidar lidar({matrix(0, 0, 0), matrix(9, 0, 0)}, kBasic);
  rgl_node_t range = nullptr;
  const rgl_vec2f limits = {{3, 10}};
  OK(rgl_node_rays_set_range(&range, &limits, 1));
  OK(rgl_graph_node_remove_child(lidar.rays, lidar.pose));
  OK(rgl_graph_node_add_child(lidar.rays, range));
  OK(rgl_graph_node_add_child(range, lidar.pose));
  OK(rgl_node_raytrace_configure_non_hits(lidar.raytrace, 1.5f, std::nanf("")));
  lidar.run();
  CHECK(lidar.get<int32_t>(RGL_FIELD_IS_HIT_I32) == std::vector<int32_t>{0, 0});
  CHECK(lidar.get<float>(RGL_FIELD_DISTANCE_F32)[0] == 1.5f);
  const auto xyz = lidar.get<rgl_vec3f>(RGL_FIELD_XYZ_VEC3_F32);
  CHECK(xyz[0].value[2] == 1.5f);
  CHECK(std::isnan(lidar.get<float>(RGL_FIELD_DISTANCE_F32)[1]));
  CHECK((xyz[1].value[0] == 0 && xyz[1].value[2] == 0));  // not a number becomes 0
  OK(rgl_cleanup());
}

TEST_CASE("RGL: surfaces give intensity by texture and angle, normals, retro and angles of the ray") {
  const rgl_mesh_t mesh = squareMesh();
  const rgl_vec2f uvs[] = {{{0, 0}}, {{1, 0}}, {{1, 1}}, {{0, 1}}};
  OK(rgl_mesh_set_texture_coords(mesh, uvs, 4));
  const uint8_t texels[] = {10, 20, 30, 40};  // row 0 is at v = 0
  rgl_texture_t texture = nullptr;
  OK(rgl_texture_create(&texture, texels, 2, 2));
  const rgl_entity_t entity = place(mesh, matrix(0, 0, 3, 0, std::numbers::pi / 3));
  OK(rgl_entity_set_intensity_texture(entity, texture));
  OK(rgl_entity_set_laser_retro(entity, -7.5f));
  OK(rgl_texture_destroy(texture));  // the entity keeps it
  Lidar lidar({matrix(0.2, 0.5, 0), matrix(-0.2, 0.5, 0), matrix(0.2, -0.5, 0), matrix(0, 0, 0, 0.3, 0.2)},
              {RGL_FIELD_INTENSITY_F32, RGL_FIELD_INTENSITY_U8, RGL_FIELD_NORMAL_VEC3_F32, RGL_FIELD_LASER_RETRO_F32,
               RGL_FIELD_INCIDENT_ANGLE_F32, RGL_FIELD_AZIMUTH_F32, RGL_FIELD_ELEVATION_F32, RGL_FIELD_REFLECTIVITY_F32,
               RGL_FIELD_DISTANCE_F32, RGL_FIELD_RAY_POSE_MAT3x4_F32, RGL_FIELD_POWER_F32});
  lidar.run();
  const auto intensity = lidar.get<float>(RGL_FIELD_INTENSITY_F32);
  const auto distance = lidar.get<float>(RGL_FIELD_DISTANCE_F32);
  CHECK(intensity[0] == Approx(40 * 0.5).epsilon(1e-5));
  CHECK(intensity[1] == Approx(30 * 0.5).epsilon(1e-5));
  CHECK(intensity[2] == Approx(20 * 0.5).epsilon(1e-5));
  CHECK(lidar.get<uint8_t>(RGL_FIELD_INTENSITY_U8)[0] == 20);
  CHECK(distance[0] == Approx(3 - 0.2 * std::sqrt(3)).epsilon(1e-5));
  CHECK(lidar.get<float>(RGL_FIELD_REFLECTIVITY_F32)[0] ==
        Approx(0.1 * intensity[0] * distance[0] * distance[0]).epsilon(1e-5));
  CHECK(lidar.get<float>(RGL_FIELD_INCIDENT_ANGLE_F32)[0] == Approx(std::numbers::pi / 3).epsilon(1e-6));
  const auto normal = lidar.get<rgl_vec3f>(RGL_FIELD_NORMAL_VEC3_F32)[0];
  CHECK(normal.value[0] == Approx(std::sqrt(0.75)).epsilon(1e-6));
  CHECK(normal.value[2] == Approx(0.5).epsilon(1e-6));
  CHECK(lidar.get<float>(RGL_FIELD_LASER_RETRO_F32)[0] == -7.5f);
  const rgl_mat3x4f ray = matrix(0, 0, 0, 0.3, 0.2);
  CHECK(lidar.get<float>(RGL_FIELD_ELEVATION_F32)[3] == Approx(std::asin(ray.value[1][2])));
  CHECK(lidar.get<float>(RGL_FIELD_AZIMUTH_F32)[3] == Approx(std::atan2(-ray.value[2][0], ray.value[2][2])));
  CHECK(std::memcmp(&lidar.get<rgl_mat3x4f>(RGL_FIELD_RAY_POSE_MAT3x4_F32)[3], &ray, sizeof ray) == 0);
  CHECK(lidar.get<float>(RGL_FIELD_POWER_F32) == std::vector<float>(4));
  OK(rgl_cleanup());
}

TEST_CASE("RGL: a surface without a texture has the default intensity, and a reflectivity by the factor that is set") {
  place(squareMesh(), matrix(0, 0, 3, 0, std::numbers::pi / 3));
  Lidar lidar({matrix(0, 0, 0)}, {RGL_FIELD_INTENSITY_F32, RGL_FIELD_REFLECTIVITY_F32});
  const auto check = [&](double intensity, double reflectivity) {
    lidar.run();
    CHECK(lidar.get<float>(RGL_FIELD_INTENSITY_F32)[0] == Approx(intensity).epsilon(1e-5));
    CHECK(lidar.get<float>(RGL_FIELD_REFLECTIVITY_F32)[0] == Approx(reflectivity).epsilon(1e-5));
  };
  check(0, 0);
  OK(rgl_node_raytrace_configure_default_intensity(lidar.raytrace, 80));
  check(80 * 0.5, 0.1 * 40 * 9);  // by the cosine of 60 degrees, at 3 m
  OK(rgl_node_raytrace_configure_reflectivity_alpha(lidar.raytrace, 0.25f));
  check(40, 0.25 * 40 * 9);
  CHECK(failed(rgl_node_raytrace_configure_default_intensity(lidar.raytrace, -1), RGL_INVALID_ARGUMENT,
               "default_intensity >= 0"));
  CHECK(failed(rgl_node_raytrace_configure_reflectivity_alpha(lidar.raytrace, -1), RGL_INVALID_ARGUMENT,
               "reflectivity_alpha >= 0"));
  check(40, 0.25 * 40 * 9);
  OK(rgl_cleanup());
}

TEST_CASE("RGL: the strongest return of a wide beam is that of its brightest sample, and no nearer or farther one") {
  const rgl_vec2f uvs[] = {{{0, 0}}, {{1, 0}}, {{1, 1}}, {{0, 1}}};
  const auto shaded = [&](float half, double z, uint8_t shade) {
    const rgl_mesh_t mesh = squareMesh(half);
    rgl_texture_t texture = nullptr;
    OK(rgl_mesh_set_texture_coords(mesh, uvs, 4));
    OK(rgl_texture_create(&texture, &shade, 1, 1));
    OK(rgl_entity_set_intensity_texture(place(mesh, matrix(0, 0, z)), texture));
  };
  shaded(0.3f, 5, 10);  // only the middle of the beam meets the small one
  shaded(30, 8, 200);
  Lidar lidar({matrix(0, 0, 0)}, {RGL_FIELD_DISTANCE_F32, RGL_FIELD_INTENSITY_F32});
  OK(rgl_node_raytrace_configure_beam_divergence(lidar.raytrace, 0.6f, 0.6f));
  const auto check = [&](rgl_return_mode_t mode, const std::vector<std::pair<double, double>>& returns) {
    OK(rgl_node_raytrace_configure_return_mode(lidar.raytrace, mode));
    lidar.run();
    OK(rgl_node_raytrace_configure_return_mode(lidar.raytrace, mode));  // which changes nothing
    const auto distances = lidar.get<float>(RGL_FIELD_DISTANCE_F32);
    const auto intensities = lidar.get<float>(RGL_FIELD_INTENSITY_F32);
    REQUIRE(distances.size() == returns.size());
    for (size_t k = 0; k < returns.size(); ++k) {
      CHECK(distances[k] == Approx(returns[k].first).epsilon(1e-4));
      CHECK(intensities[k] == Approx(returns[k].second).epsilon(1e-4));
    }
  };
  // The three ellipses of samples are 0.1, 0.2 and 0.3 rad from the middle.
  const auto wall = [](double angle) { return std::pair(8 / std::cos(angle), 200 * std::cos(angle)); };
  check(RGL_RETURN_FIRST, {{5, 10}});
  check(RGL_RETURN_LAST, {wall(0.3)});
  check(RGL_RETURN_STRONGEST, {wall(0.1)});
  check(RGL_RETURN_FIRST_STRONGEST, {{5, 10}, wall(0.1)});
  check(RGL_RETURN_LAST_STRONGEST, {wall(0.3), wall(0.1)});
  OK(rgl_node_raytrace_configure_return_mode(lidar.raytrace, RGL_RETURN_FIRST));
  CHECK(failed(rgl_graph_get_result_size(lidar.yield, RGL_FIELD_DISTANCE_F32, nullptr, nullptr), RGL_INVALID_PIPELINE,
               "hasn't been run"));
  check(RGL_RETURN_LAST_STRONGEST, {wall(0.3), wall(0.1)});
  CHECK(failed(rgl_node_raytrace_configure_return_mode(lidar.raytrace, RGL_RETURN_UNKNOWN), RGL_INVALID_ARGUMENT,
               "return_mode != RGL_RETURN_UNKNOWN"));
  rgl_node_t poses = nullptr;
  const rgl_field_t pose = RGL_FIELD_RAY_POSE_MAT3x4_F32;
  OK(rgl_node_points_yield(&poses, &pose, 1));
  lidar.append(poses);
  CHECK(failed(rgl_graph_run(lidar.rays), RGL_INVALID_PIPELINE, "one return per ray only"));
  OK(rgl_cleanup());
}

TEST_CASE("RGL: velocities follow from the scene's last two times") {
  const rgl_entity_t entity = place(squareMesh(), matrix(0, 0, 5));
  Lidar lidar({matrix(0, 0, 0)},
              {RGL_FIELD_ABSOLUTE_VELOCITY_VEC3_F32, RGL_FIELD_RELATIVE_VELOCITY_VEC3_F32, RGL_FIELD_RADIAL_SPEED_F32});
  const auto speed = [&] { return lidar.get<float>(RGL_FIELD_RADIAL_SPEED_F32)[0]; };
  lidar.run();
  CHECK(std::isnan(speed()));  // there is no time
  rgl_mat3x4f place = matrix(0, 0, 5);
  OK(rgl_scene_set_time(nullptr, 1'000'000'000));
  OK(rgl_entity_set_transform(entity, &place));
  OK(rgl_scene_set_time(nullptr, 1'500'000'000));
  place = matrix(0.25, 0, 6);
  OK(rgl_entity_set_transform(entity, &place));
  const rgl_vec3f ahead = {{0, 0, 0.5f}}, still = {{0, 0, 0}};
  OK(rgl_node_raytrace_configure_velocity(lidar.raytrace, &ahead, &still));
  lidar.run();
  CHECK(speed() == Approx(2 - 0.5));  // it goes away
  CHECK(lidar.get<rgl_vec3f>(RGL_FIELD_ABSOLUTE_VELOCITY_VEC3_F32)[0].value[0] == Approx(0.5));
  CHECK(lidar.get<rgl_vec3f>(RGL_FIELD_RELATIVE_VELOCITY_VEC3_F32)[0].value[2] == Approx(1.5));
  OK(rgl_scene_set_time(nullptr, 2'000'000'000));
  lidar.run();
  CHECK(speed() == Approx(-0.5));  // it has not been moved since
  // A sensor that turns from z to x sees what stands before it go to -x.
  const rgl_vec3f turning = {{0, 0.5f, 0}};
  OK(rgl_node_raytrace_configure_velocity(lidar.raytrace, &still, &turning));
  lidar.run();
  CHECK(lidar.get<rgl_vec3f>(RGL_FIELD_RELATIVE_VELOCITY_VEC3_F32)[0].value[0] == Approx(-0.5 * 6));
  OK(rgl_cleanup());
}

TEST_CASE("RGL: animated entities have vertices of their own, by the caller or by bones") {
  const rgl_mesh_t mesh = squareMesh();
  const rgl_entity_t moving = place(mesh, matrix(0, 0, 5));
  place(mesh, matrix(3, 0, 5));
  Lidar lidar({matrix(0.5, 0, 0), matrix(3.5, 0, 0)}, {RGL_FIELD_DISTANCE_F32, RGL_FIELD_RADIAL_SPEED_F32});
  const auto distances = [&] {
    lidar.run();
    return lidar.get<float>(RGL_FIELD_DISTANCE_F32);
  };
  rgl_vec3f vertices[] = {{{-1, -1, 0}}, {{1, -1, 0}}, {{1, 1, 0}}, {{-1, 1, 0}}};
  for (int k = 0; k < 3; ++k) {
    OK(rgl_scene_set_time(nullptr, 1'000'000'000ull * k));
    OK(rgl_entity_apply_external_animation(moving, vertices, 4));
    CHECK(distances() == std::vector<float>{5 + 0.5f * float(k), 5});  // the other entity of the mesh stays
    const auto speeds = lidar.get<float>(RGL_FIELD_RADIAL_SPEED_F32);
    if (k > 0) CHECK((speeds[0] == Approx(0.5).epsilon(0.01) && speeds[1] == 0));
    for (rgl_vec3f& vertex : vertices) vertex.value[2] += 0.5f;
  }
  // The vertices of an entity go where its axes lead.
  const rgl_mat3x4f turned = matrix(0, 0, 5, std::numbers::pi / 2);
  rgl_node_t absolute = nullptr;
  const rgl_field_t velocity = RGL_FIELD_ABSOLUTE_VELOCITY_VEC3_F32;
  OK(rgl_node_points_yield(&absolute, &velocity, 1));
  OK(rgl_graph_node_add_child(lidar.raytrace, absolute));
  for (int k = 3; k < 5; ++k) {
    OK(rgl_scene_set_time(nullptr, 1'000'000'000ull * k));
    OK(rgl_entity_set_transform(moving, &turned));
    OK(rgl_entity_apply_external_animation(moving, vertices, 4));
    lidar.run();
    for (rgl_vec3f& vertex : vertices) vertex.value[0] += 0.25f;
  }
  rgl_vec3f velocities[2];
  OK(rgl_graph_get_result_data(absolute, velocity, velocities));
  CHECK(velocities[0].value[0] == Approx(0).margin(1e-6));
  CHECK(velocities[0].value[1] == Approx(0.25));  // its x axis is y in the world
  OK(rgl_graph_node_remove_child(lidar.raytrace, absolute));
  // Bone 1 holds the vertices at x = 1, and lifts them by 2 m.
  rgl_bone_weights_t weights[4] = {};
  for (int v = 0; v < 4; ++v) weights[v].weights[0] = 1, weights[v].bone_indexes[0] = v == 1 || v == 2;
  const rgl_mat3x4f rest[] = {matrix(0, 0, 0), matrix(-1, 0, 0)}, pose[] = {matrix(0, 0, 4), matrix(1, 0, 6)};
  OK(rgl_mesh_set_bone_weights(mesh, weights, 4));
  OK(rgl_mesh_set_restposes(mesh, rest, 2));
  OK(rgl_entity_set_pose_world(moving, pose, 2));
  CHECK(distances()[0] == Approx(5.5));

  rgl_mat3x4f broken[] = {matrix(0, 0, 4), matrix(1, 0, 6)};
  broken[1].value[2][3] = std::nanf("");
  CHECK(rgl_entity_set_pose_world(moving, broken, 2) == RGL_INVALID_ARGUMENT);
  CHECK(rgl_mesh_set_restposes(mesh, broken, 2) == RGL_INVALID_ARGUMENT);
  CHECK(rgl_entity_set_transform(moving, &broken[1]) == RGL_INVALID_ARGUMENT);
  CHECK(distances()[0] == Approx(5.5));

  // Bones and vertices that do not suit the mesh are refused, and change nothing.
  CHECK(failed(rgl_entity_set_pose_world(moving, pose, 1), RGL_INVALID_ARGUMENT, "bones_count == restposes_count"));
  weights[3].bone_indexes[2] = 2;
  OK(rgl_mesh_set_bone_weights(mesh, weights, 4));
  CHECK(failed(rgl_entity_set_pose_world(moving, pose, 2), RGL_INVALID_ARGUMENT, "belongs to bone 2, but there are 2"));
  CHECK(
      failed(rgl_mesh_set_bone_weights(mesh, weights, 3), RGL_INVALID_ARGUMENT, "bone_weights_count == vertex_count"));
  CHECK(failed(rgl_entity_apply_external_animation(moving, vertices, 3), RGL_INVALID_ARGUMENT,
               "the mesh has 4, 3 were given"));
  const rgl_entity_t boneless = place(squareMesh(), matrix(9, 0, 5));
  CHECK(failed(rgl_entity_set_pose_world(boneless, pose, 2), RGL_INVALID_ARGUMENT, "no bone weights or no rest poses"));
  CHECK(distances()[0] == Approx(5.5));
  OK(rgl_cleanup());
}

/// Level 0.18; the header is of a later one.
extern "C" rgl_status_t rgl_node_multi_return_switch(rgl_node_t* node, int32_t return_type);

TEST_CASE("RGL: distortion moves each ray by its time, and a beam with a divergence has a first and a last return") {
  const rgl_entity_t small = place(squareMesh(), matrix(0, 0, 5));
  place(squareMesh(30), matrix(0, 0, 8));
  Lidar lidar({matrix(0, 0, 0), matrix(0, 0, 0)},
              {RGL_FIELD_DISTANCE_F32, RGL_FIELD_TIME_STAMP_U32, RGL_FIELD_RETURN_TYPE_U8, RGL_FIELD_RAY_IDX_U32});
  const auto distances = [&] { return lidar.get<float>(RGL_FIELD_DISTANCE_F32); };
  rgl_node_t offsets = nullptr;
  const float times[] = {0, 500};
  const rgl_vec3f velocity = {{4, 0, 0}}, still = {{0, 0, 0}};
  OK(rgl_node_rays_set_time_offsets(&offsets, times, 2));
  OK(rgl_graph_node_remove_child(lidar.rays, lidar.pose));
  OK(rgl_graph_node_add_child(lidar.rays, offsets));
  OK(rgl_graph_node_add_child(offsets, lidar.pose));
  OK(rgl_node_raytrace_configure_velocity(lidar.raytrace, &velocity, &still));
  lidar.run();
  CHECK(distances() == std::vector<float>{5, 5});
  CHECK(lidar.get<uint32_t>(RGL_FIELD_TIME_STAMP_U32) == std::vector<uint32_t>{0, 0});
  OK(rgl_node_raytrace_configure_distortion(lidar.raytrace, true));
  lidar.run();
  CHECK(distances() == std::vector<float>{5, 8});  // the second ray is 2 m beside the small square
  CHECK(lidar.get<uint32_t>(RGL_FIELD_TIME_STAMP_U32) == std::vector<uint32_t>{0, 500'000'000});
  rgl_node_t stamps = nullptr;
  const rgl_field_t seconds = RGL_FIELD_TIME_STAMP_F64;
  OK(rgl_node_points_yield(&stamps, &seconds, 1));
  OK(rgl_graph_node_add_child(lidar.raytrace, stamps));
  OK(rgl_scene_set_time(nullptr, 1));
  lidar.run();
  double inSeconds[2];
  OK(rgl_graph_get_result_data(stamps, seconds, inSeconds));
  CHECK((inSeconds[0] == 0 && inSeconds[1] == 0.5));
  OK(rgl_graph_node_remove_child(lidar.raytrace, stamps));
  // Times that 32 bits cannot hold become the least and the greatest that they can.
  const float outside[] = {-1, 5000};
  OK(rgl_node_rays_set_time_offsets(&offsets, outside, 2));
  lidar.run();
  CHECK(lidar.get<uint32_t>(RGL_FIELD_TIME_STAMP_U32) == std::vector<uint32_t>{0, 0xffffffff});
  OK(rgl_node_rays_set_time_offsets(&offsets, times, 2));

  OK(rgl_node_raytrace_configure_distortion(lidar.raytrace, false));
  OK(rgl_node_raytrace_configure_beam_divergence(lidar.raytrace, 0.6f, 0.6f));
  OK(rgl_node_raytrace_configure_return_mode(lidar.raytrace, RGL_RETURN_FIRST_LAST));
  lidar.run();
  const auto both = distances();
  REQUIRE(both.size() == 4);
  CHECK(both[0] == 5);
  CHECK(both[1] == Approx(8 / std::cos(0.3)).epsilon(1e-5));  // the outermost ellipse passes the small square
  CHECK(lidar.get<uint8_t>(RGL_FIELD_RETURN_TYPE_U8) ==
        std::vector<uint8_t>{RGL_RETURN_TYPE_FIRST, RGL_RETURN_TYPE_LAST, RGL_RETURN_TYPE_FIRST, RGL_RETURN_TYPE_LAST});
  CHECK(lidar.get<uint32_t>(RGL_FIELD_RAY_IDX_U32) == std::vector<uint32_t>{0, 0, 1, 1});

  // A beam that is wide upwards stays on the small square when that is moved aside, and one that is wide across passes.
  const rgl_mat3x4f beside = matrix(0.9, 0, 5);
  OK(rgl_entity_set_transform(small, &beside));
  OK(rgl_node_raytrace_configure_beam_divergence(lidar.raytrace, 0.02f, 0.3f));
  lidar.run();
  CHECK(distances()[1] > 5.05f);
  CHECK(distances()[1] < 5.06f);
  OK(rgl_node_raytrace_configure_beam_divergence(lidar.raytrace, 0.3f, 0.02f));
  lidar.run();
  CHECK(distances()[1] > 8);
  const rgl_mat3x4f before = matrix(0, 0, 5);
  OK(rgl_entity_set_transform(small, &before));
  OK(rgl_node_raytrace_configure_beam_divergence(lidar.raytrace, 0.6f, 0.6f));
  lidar.run();

  // Level 0.18 has a node for each of the returns instead of modes.
  OK(rgl_node_raytrace_configure_return_mode(lidar.raytrace, RGL_RETURN_FIRST));
  const std::vector<float> first = {both[0], both[2]}, last = {both[1], both[3]};
  for (const auto& [type, expected] : {std::pair{1, first}, {2, last}, {0, first}}) {
    rgl_node_t chosen = nullptr, yield = nullptr;
    const rgl_field_t field = RGL_FIELD_DISTANCE_F32;
    OK(rgl_node_multi_return_switch(&chosen, type));
    OK(rgl_node_points_yield(&yield, &field, 1));
    OK(rgl_graph_node_add_child(lidar.raytrace, chosen));
    OK(rgl_graph_node_add_child(chosen, yield));
    lidar.run();
    int32_t count = 0, size = 0;
    OK(rgl_graph_get_result_size(yield, field, &count, &size));
    REQUIRE(count == 2);
    std::vector<float> values(2);
    OK(rgl_graph_get_result_data(yield, field, values.data()));
    CHECK(values == expected);
    CHECK(distances() == first);                                       // those of the raytrace node itself
    OK(rgl_node_multi_return_switch(&chosen, 3 - std::max(type, 1)));  // the other one, in the same graph
    lidar.run();
    OK(rgl_graph_get_result_data(yield, field, values.data()));
    CHECK(values == (type == 2 ? first : last));
  }
  rgl_node_t behind = nullptr, wrong = nullptr;
  const rgl_field_t any = RGL_FIELD_DISTANCE_F32;
  OK(rgl_node_points_yield(&behind, &any, 1));
  OK(rgl_node_multi_return_switch(&wrong, 1));
  OK(rgl_graph_node_add_child(lidar.raytrace, behind));
  OK(rgl_graph_node_add_child(behind, wrong));
  CHECK(failed(rgl_graph_run(lidar.raytrace), RGL_INVALID_PIPELINE, "must be a RaytraceNode"));
  CHECK(failed(rgl_node_multi_return_switch(&wrong, 3), RGL_INVALID_ARGUMENT, "return_type"));
  OK(rgl_cleanup());
}

TEST_CASE("RGL: a sensor passes through the entities that it ignores") {
  const rgl_entity_t near = place(squareMesh(), matrix(0, 0, 2));
  place(squareMesh(), matrix(0, 0, 6));
  Lidar first({matrix(0, 0, 0)}, kBasic), second({matrix(0, 0, 0)}, kBasic);
  OK(rgl_node_raytrace_configure_id(second.raytrace, 5));
  OK(rgl_entity_set_ignored_by_sensor(near, 5));
  for (int i = 0; i < 2; ++i) {
    first.run();
    second.run();
    CHECK(first.get<float>(RGL_FIELD_DISTANCE_F32)[0] == 2);
    CHECK(second.get<float>(RGL_FIELD_DISTANCE_F32)[0] == 6);
  }
  OK(rgl_cleanup());
}

// SPDX-License-Identifier: Apache-2.0
// Nodes of points and of radar of libgnosphere_rgl, against closed forms.
#include <rgl/api/extensions/pcl.h>
#include <sys/resource.h>

#include <algorithm>
#include <catch2/catch_approx.hpp>
#include <csignal>
#include <cstdlib>
#include <limits>
#include <string>
#include <tuple>
#include <utility>

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
  OK(rgl_cleanup());
  place(squareMesh(500), matrix(0, 0, 10));
  CHECK(draw("4294967303") != first);  // 7 + 2^32
  CHECK(draw(nullptr) != first);
  OK(rgl_cleanup());
  // A seed that is no number is warned of, and a number is not.
  const Folder folder;
  const std::string log = (folder / "log").string();
  for (const auto& [seed, isNumber] :
       {std::pair("7", true), {"0x7", true}, {"7a", false}, {"", false}, {"-7", false}}) {
    OK(rgl_configure_logging(RGL_LOG_LEVEL_WARN, (log + seed).c_str(), false));
    setenv("GNOSPHERE_RGL_SEED", seed, 1);
    rgl_node_t noise = nullptr;
    OK(rgl_node_gaussian_noise_distance(&noise, 0.5f, 0.01f, 0.002f));
    OK(rgl_configure_logging(RGL_LOG_LEVEL_OFF, nullptr, false));
    CHECK((bytesOf(log + seed).find("GNOSPHERE_RGL_SEED is '") == std::string::npos) == isNumber);
  }
  unsetenv("GNOSPHERE_RGL_SEED");
  OK(rgl_cleanup());
}

/// Of a closed extension, as AWSIM declares it.
extern "C" rgl_status_t rgl_node_points_simulate_snow(rgl_node_t* node, float min_range, float max_range,
                                                      float rain_rate, float mean_snowflake_diameter,
                                                      float terminal_velocity, float density, int32_t num_channels,
                                                      float beam_divergence, bool do_simulate_energy_loss,
                                                      float snowflake_occupancy_threshold);

TEST_CASE("RGL: noise of distances goes along the beams of the sensor, also where the points have been moved") {
  place(squareMesh(), matrix(0, 0, 5));
  Lidar lidar({matrix(0, 0, 0)}, {RGL_FIELD_XYZ_VEC3_F32, RGL_FIELD_DISTANCE_F32});
  const rgl_mat3x4f aside = matrix(100, 0, 0);
  rgl_node_t moved = nullptr, noise = nullptr;
  OK(rgl_node_points_transform(&moved, &aside));
  OK(rgl_node_gaussian_noise_distance(&noise, 1, 0, 0));
  lidar.append(moved);
  OK(rgl_graph_node_add_child(moved, noise));
  lidar.last = noise;
  lidar.run();
  const rgl_vec3f point = lidar.get<rgl_vec3f>(RGL_FIELD_XYZ_VEC3_F32).at(0);
  CHECK(point.value[0] == Approx(100));
  CHECK(point.value[2] == Approx(6));
  CHECK(lidar.get<float>(RGL_FIELD_DISTANCE_F32).at(0) == Approx(6));
  OK(rgl_cleanup());
}

TEST_CASE("RGL: snow gives flakes before walls and in the sky, as many as its formula says, and takes light") {
  setenv("GNOSPHERE_RGL_SEED", "5", 1);
  rgl_mesh_t wall = squareMesh(5);
  const rgl_vec2f uvs[] = {{{0, 0}}, {{1, 0}}, {{1, 1}}, {{0, 1}}};
  const uint8_t white = 255;
  rgl_texture_t texture = nullptr;
  OK(rgl_mesh_set_texture_coords(wall, uvs, 4));
  OK(rgl_texture_create(&texture, &white, 1, 1));
  const rgl_entity_t entity = place(wall, matrix(0, 0, 10));
  OK(rgl_entity_set_intensity_texture(entity, texture));
  OK(rgl_entity_set_id(entity, 7));
  // Half of the rays meet the wall at 10 m, half look into the sky. The sensor stands beside the origin.
  constexpr int kRays = 20'000;
  std::vector<rgl_mat3x4f> rays(kRays / 2, matrix(0, 0, 0));
  rays.insert(rays.end(), kRays / 2, matrix(0, 0, 0, 0, std::numbers::pi));
  const std::vector<rgl_field_t> fields = {RGL_FIELD_XYZ_VEC3_F32, RGL_FIELD_IS_HIT_I32, RGL_FIELD_DISTANCE_F32,
                                           RGL_FIELD_INTENSITY_F32, RGL_FIELD_ENTITY_ID_I32};
  Lidar lidar(rays, fields);
  lidar.move(matrix(1, 2, 0));
  constexpr float kLeast = 0.5f, kMost = 100, kRate = 9, kDiameter = 0.0002f, kSpeed = 1.6f, kDensity = 0.07f,
                  kDivergence = 0.005f, kThreshold = 0.02f;
  rgl_node_t snow = nullptr;
  const auto set = [&](float rate, bool loss) {
    return rgl_node_points_simulate_snow(&snow, kLeast, kMost, rate, kDiameter, kSpeed, kDensity, 16, kDivergence, loss,
                                         kThreshold);
  };
  OK(set(kRate, true));
  lidar.append(snow);
  lidar.run();
  const auto distances = lidar.get<float>(RGL_FIELD_DISTANCE_F32),
             intensities = lidar.get<float>(RGL_FIELD_INTENSITY_F32);
  const auto points = lidar.get<rgl_vec3f>(RGL_FIELD_XYZ_VEC3_F32);
  const auto hits = lidar.get<int32_t>(RGL_FIELD_IS_HIT_I32), entities = lidar.get<int32_t>(RGL_FIELD_ENTITY_ID_I32);

  // 9 mm/h is 2.5e-6 of the volume per second; the integral of the flakes that a beam meets has a closed form.
  const double perVolume = 9 / 3.6e6 / (0.07 * 1.6) / (std::numbers::pi * 8e-12);
  const double k = std::sqrt(0.02) * 0.005 / 0.0002, c = perVolume * std::numbers::pi / 4 * 0.005 * 0.005;
  const auto upTo = [&](double r) { return -c * std::exp(-k * r) * (r * r / k + 2 * r / (k * k) + 2 / (k * k * k)); };
  const auto expected = [&](double end) { return 1 - std::exp(upTo(0.5) - upTo(end)); };
  const double loss = std::exp(-2 * perVolume * std::numbers::pi / 2 * 4e-8 * (10 - 0.5));
  for (const int half : {0, 1}) {
    int flakes = 0, near = 0;
    double nearest = 1e9;
    for (int i = half * kRays / 2; i < (half + 1) * kRays / 2; ++i) {
      const bool flake = hits[i] && entities[i] == RGL_DEFAULT_ENTITY_ID;
      flakes += flake;
      near += flake && distances[i] < 0.7f;
      if (hits[i]) nearest = std::min(nearest, double{distances[i]});
      const float side = half ? -1.0f : 1.0f;
      if (hits[i] && points[i].value[2] != Approx(side * distances[i])) FAIL("a point off its ray");
      if (hits[i] && !flake && (distances[i] != 10 || intensities[i] != Approx(255 * loss))) FAIL("a wall elsewhere");
      if (flake && !(intensities[i] > 0 && intensities[i] < 0.6 * 255)) FAIL("a flake too bright");
      if (!hits[i] && !(half == 1 && std::isinf(distances[i]))) FAIL("a lost wall");
    }
    const auto sameAs = [&](double share) {
      const double number = kRays / 2 * share;
      return Approx(number).margin(4 * std::sqrt(number));
    };
    CHECK(expected(10) > 0.1);
    CHECK(flakes == sameAs(expected(half ? 100 : 10)));
    CHECK(near == sameAs(expected(0.7)));
    CHECK(nearest >= 0.5);
  }
  CHECK(loss < 0.9);
  OK(set(kRate, false));
  lidar.run();
  const auto bright = lidar.get<float>(RGL_FIELD_INTENSITY_F32);
  CHECK(*std::max_element(bright.begin(), bright.end()) == 255);
  OK(set(0, true));
  lidar.run();
  CHECK(lidar.get<float>(RGL_FIELD_DISTANCE_F32)[0] == 10);
  CHECK(lidar.get<int32_t>(RGL_FIELD_IS_HIT_I32).back() == 0);

  CHECK(failed(set(-1, true), RGL_INVALID_ARGUMENT, "rain_rate >= 0"));
  CHECK(failed(rgl_node_points_simulate_snow(&snow, 0, 1, 1, 1, 1, 1, 0, 1, true, 0.5f), RGL_INVALID_ARGUMENT,
               "num_channels > 0"));
  CHECK(failed(rgl_node_points_simulate_snow(nullptr, 0, 1, 1, 1, 1, 1, 1, 1, true, 0.5f), RGL_INVALID_ARGUMENT,
               "node != nullptr"));
  unsetenv("GNOSPHERE_RGL_SEED");
  OK(rgl_cleanup());
}

TEST_CASE("RGL: snow is there whatever the greatest range is") {
  setenv("GNOSPHERE_RGL_SEED", "5", 1);
  place(squareMesh(), matrix(0, 0, -1));  // behind the sensor
  constexpr int kRays = 5'000;
  Lidar lidar(std::vector(kRays, matrix(0, 0, 0)),
              {RGL_FIELD_IS_HIT_I32, RGL_FIELD_DISTANCE_F32, RGL_FIELD_RAY_POSE_MAT3x4_F32});
  rgl_node_t snow = nullptr;
  // Distances of the flakes, in order.
  const auto flakes = [&](float most, float threshold) {
    OK(rgl_node_points_simulate_snow(&snow, 0, most, 20, 0.003f, 1.6f, 0.07f, 16, 0.003f, true, threshold));
    if (!lidar.last) lidar.append(snow);
    lidar.run();
    std::vector<float> distances = lidar.get<float>(RGL_FIELD_DISTANCE_F32);
    std::erase_if(distances, [](float distance) { return std::isinf(distance); });
    std::sort(distances.begin(), distances.end());
    return distances;
  };
  // A beam meets growth * r^2 * exp(-decay * r) flakes per metre, so 2 growth / decay^3 of them altogether.
  const double growth = 20 / 3.6e6 / (0.07 * 1.6) / (std::numbers::pi * 2.7e-8) * std::numbers::pi / 4 * 9e-6;
  const auto near = [](double number) { return Approx(number).margin(4 * std::sqrt(number)); };
  for (const float most : {100.0f, 1'000.0f, 1e6f, std::numeric_limits<float>::max()}) {
    INFO(most);
    const auto some = flakes(most, 0.2f);
    CHECK(some.size() == near(kRays * (1 - std::exp(-2 * growth / std::pow(0.2, 1.5)))));
    REQUIRE(some.size() > 100);
    CHECK(some[some.size() / 2] ==
          Approx(2.674 / std::sqrt(0.2)).epsilon(0.1));  // the median of r^2 * exp(-r) is 2.674
    // Without a threshold, a beam meets growth * r^3 / 3 flakes up to r; half of the beams have met one of log 2.
    const auto all = flakes(most, 0);
    REQUIRE(all.size() == kRays);
    CHECK(all[kRays / 2] == Approx(std::cbrt(3 * std::log(2) / growth)).epsilon(0.02));
    CHECK(all[kRays / 100] == Approx(std::cbrt(3 * -std::log(0.99) / growth)).epsilon(0.2));
  }
  unsetenv("GNOSPHERE_RGL_SEED");
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
  OK(rgl_graph_write_pcd_file(voxels, (folder / "two.pcd").string().c_str()));
  const std::string file = bytesOf(folder / "two.pcd");
  CHECK(file.ends_with(std::string(reinterpret_cast<const char*>(two), sizeof two)));
  CHECK(file.find("POINTS 2\n") != std::string::npos);
  // A file that cannot be written to its end leaves the former one as it is.
  rlimit whole;
  REQUIRE(getrlimit(RLIMIT_FSIZE, &whole) == 0);
  const rlimit tooSmall = {64, whole.rlim_max};
  const auto signalled = std::signal(SIGXFSZ, SIG_IGN);
  setrlimit(RLIMIT_FSIZE, &tooSmall);
  const rgl_status_t written = rgl_graph_write_pcd_file(voxels, (folder / "two.pcd").string().c_str());
  setrlimit(RLIMIT_FSIZE, &whole);
  std::signal(SIGXFSZ, signalled);
  CHECK(failed(written, RGL_INVALID_FILE_PATH, "two.pcd: cannot be written: File too large"));
  CHECK(bytesOf(folder / "two.pcd") == file);

  // The voxels may have another size along each axis.
  const std::vector<rgl_vec3f> row = {{{1, 1, 1}}, {{7, 3, 1}}, {{7, 1, 4}}};
  OK(rgl_node_points_from_array(&array, row.data(), 3, &field, 1));
  for (const auto& [x, y, z, voxelCount] :
       {std::tuple{10.f, 10.f, 10.f, 1}, {5.f, 10.f, 10.f, 2}, {10.f, 2.f, 10.f, 2}, {10.f, 10.f, 2.f, 2}}) {
    OK(rgl_node_points_downsample(&voxels, x, y, z));
    OK(rgl_graph_run(array));
    int32_t found = 0;
    OK(rgl_graph_get_result_size(voxels, field, &found, nullptr));
    CHECK(found == voxelCount);
  }
  OK(rgl_node_points_downsample(&voxels, 1, 1, 1));

  // Voxels so far away that no integer has their numbers.
  const std::vector<rgl_vec3f> far = {{{1e25f, 0, 0}}, {{2e25f, 0, 0}}, {{-1e25f, 0, 0}}};
  OK(rgl_node_points_from_array(&array, far.data(), 3, &field, 1));
  OK(rgl_graph_run(array));
  int32_t count = 0;
  OK(rgl_graph_get_result_size(voxels, field, &count, nullptr));
  REQUIRE(count == 3);
  rgl_vec3f three[3];
  OK(rgl_graph_get_result_data(voxels, field, three));
  for (int i = 0; i < 3; ++i) CHECK(three[i].value[0] == std::vector{-1e25f, 1e25f, 2e25f}[i]);

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
  OK(rgl_node_points_remove_ground(&clean, RGL_AXIS_Z, 0.1f, 0.1f, 3.5f));  // what is less than 3.5 m above goes, too
  OK(rgl_graph_run(array));
  OK(rgl_graph_get_result_size(clean, field, &left, nullptr));
  CHECK(left == 0);
  OK(rgl_cleanup());
}

TEST_CASE("RGL: the power of a radar's detection follows from the radar equation") {
  struct Row {
    rgl_vec3f xyz = {{0, 0, 1}};
    float distance, azimuth, elevation, speed = 0;
    rgl_mat3x4f pose = matrix(0, 0, 0);
    rgl_vec3f normal = {{0, 0, -1}};
  };
  const std::vector<Row> rows = {{.distance = 20, .azimuth = -0.3f, .elevation = 0},
                                 {.distance = 40, .azimuth = 0.3f, .elevation = 0.6f},
                                 {.distance = 101, .azimuth = 0, .elevation = 0}};  // no scope reaches it
  const rgl_field_t fields[] = {RGL_FIELD_XYZ_VEC3_F32,   RGL_FIELD_DISTANCE_F32,     RGL_FIELD_AZIMUTH_F32,
                                RGL_FIELD_ELEVATION_F32,  RGL_FIELD_RADIAL_SPEED_F32, RGL_FIELD_RAY_POSE_MAT3x4_F32,
                                RGL_FIELD_NORMAL_VEC3_F32};
  constexpr float kAzimuthStep = 0.015f, kElevationStep = 0.01f, kFrequency = 79e9f, kPower = 31, kGain = 27;
  const rgl_radar_scope_t scope = {0, 100, 2, 1, 0.05f};
  rgl_node_t array = nullptr, radar = nullptr;
  OK(rgl_node_points_from_array(&array, rows.data(), 3, fields, 7));
  OK(rgl_node_points_radar_postprocess(&radar, &scope, 1, kAzimuthStep, kElevationStep, kFrequency, kPower, kGain, 60,
                                       0));
  OK(rgl_graph_node_add_child(array, radar));
  OK(rgl_graph_run(array));
  int32_t count = 0;
  OK(rgl_graph_get_result_size(radar, RGL_FIELD_RCS_F32, &count, nullptr));
  REQUIRE(count == 2);
  float rcs[2], power[2];
  OK(rgl_graph_get_result_data(radar, RGL_FIELD_RCS_F32, rcs));
  OK(rgl_graph_get_result_data(radar, RGL_FIELD_POWER_F32, power));
  const double wavelength = 299792458 / double{kFrequency};
  for (size_t i = 0; i < 2; ++i) {
    const double d = rows[i].distance;
    // The cross section of a plate as large as the patch that one ray stands for.
    const double patch = d * kAzimuthStep * std::cos(rows[i].elevation) * d * kElevationStep;
    const double section = 4 * M_PI * std::pow(patch / wavelength, 2);
    CHECK(rcs[i] == Approx(10 * std::log10(section)).epsilon(1e-5));
    const double share = section * std::pow(wavelength, 2) / (std::pow(4 * M_PI, 3) * std::pow(d, 4));
    CHECK(power[i] == Approx(kPower + kGain + 10 * std::log10(share)).epsilon(1e-5));
  }
  OK(rgl_cleanup());
}

TEST_CASE("RGL: an object that is not measured goes on at its speed in m/s, until its time in ms is over") {
  struct Row {
    rgl_vec3f xyz;
    float distance, azimuth = 0, elevation = 0, speed = 0;
    int32_t entity = 1;
  };
  const rgl_field_t fields[] = {RGL_FIELD_XYZ_VEC3_F32,  RGL_FIELD_DISTANCE_F32,     RGL_FIELD_AZIMUTH_F32,
                                RGL_FIELD_ELEVATION_F32, RGL_FIELD_RADIAL_SPEED_F32, RGL_FIELD_ENTITY_ID_I32};
  rgl_node_t array = nullptr, objects = nullptr;
  // An object stands x metres away, or is not measured if x is 0. Another object always stands 100 m away.
  const auto places = [&](uint64_t milliseconds, float x) {
    std::vector<Row> rows = {{{{0, 100, 0}}, 100}};
    if (x > 0) rows.push_back({{{x, 0, 0}}, x});
    OK(rgl_scene_set_time(nullptr, 1'000'000 * milliseconds));
    OK(rgl_node_points_from_array(&array, rows.data(), static_cast<int32_t>(rows.size()), fields, 6));
    if (!objects) {
      OK(rgl_node_points_radar_track_objects(&objects, 2, 0.1f, 0.1f, 1, 5, 500, 0.01f));
      OK(rgl_graph_node_add_child(array, objects));
    }
    OK(rgl_graph_run(array));
    int32_t count = 0;
    OK(rgl_graph_get_result_size(objects, RGL_FIELD_XYZ_VEC3_F32, &count, nullptr));
    std::vector<rgl_vec3f> points(count);
    OK(rgl_graph_get_result_data(objects, RGL_FIELD_XYZ_VEC3_F32, points.data()));
    std::vector<float> moving;
    for (const rgl_vec3f& point : points)
      if (point.value[1] == 0) moving.push_back(point.value[0]);
    return moving;
  };
  CHECK(places(1000, 10) == std::vector<float>{10});
  CHECK(places(1100, 10.5f) == std::vector<float>{10.5f});
  const std::vector<float> predicted = places(1200, 0);
  REQUIRE(predicted.size() == 1);
  CHECK(predicted[0] == Approx(11));
  CHECK(places(1590, 0).size() == 1);
  CHECK(places(1610, 0).empty());
  // Detections within 2 m, 0.1, 0.1 and 1 m/s of another are one object, in their middle; each limit parts two.
  uint64_t milliseconds = 10'000;
  const auto objectsOf = [&](const std::vector<Row>& rows) {
    OK(rgl_scene_set_time(nullptr, 1'000'000 * (milliseconds += 1000)));  // so the objects of before are over
    OK(rgl_node_points_from_array(&array, rows.data(), static_cast<int32_t>(rows.size()), fields, 6));
    OK(rgl_graph_run(array));
    int32_t count = 0;
    OK(rgl_graph_get_result_size(objects, RGL_FIELD_XYZ_VEC3_F32, &count, nullptr));
    std::vector<rgl_vec3f> points(count);
    OK(rgl_graph_get_result_data(objects, RGL_FIELD_XYZ_VEC3_F32, points.data()));
    return points;
  };
  const Row one = {{{50, 0, 0}}, 50};
  const auto chain = objectsOf({one, {{{53, 0, 0}}, 53, 0.125f, 0, 1.25f}, {{{51, 0, 0}}, 51.5f, 0.05f, -0.05f, 0.5f}});
  REQUIRE(chain.size() == 1);
  CHECK(chain[0].value[0] == 51.5f);
  for (const Row& apart : {Row{{{53, 0, 0}}, 53}, Row{{{51, 9, 0}}, 50, 0.2f}, Row{{{51, 0, 9}}, 50, 0, -0.2f},
                           Row{{{51, 0, 1}}, 50, 0, 0, -1.5f}})
    CHECK(objectsOf({one, apart}).size() == 2);
  // Classes of objects are accepted, although no result has them.
  const int32_t entity = 1;
  rgl_radar_object_class_t kind = RGL_RADAR_CLASS_UNKNOWN;
  OK(rgl_node_points_radar_set_classes(objects, &entity, &kind, 1));
  CHECK(rgl_node_points_radar_set_classes(array, &entity, &kind, 1) != RGL_SUCCESS);
  kind = RGL_RADAR_CLASS_COUNT;
  CHECK(failed(rgl_node_points_radar_set_classes(objects, &entity, &kind, 1), RGL_INVALID_ARGUMENT, "object_classes"));
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
  OK(rgl_node_points_radar_postprocess(&radar, &scope, 1, 0.015f, 0.01f, 79e9f, 31, 27, 60, 0));
  lidar.run();
  CHECK(lidar.get<float>(RGL_FIELD_NOISE_F32) == std::vector<float>{60, 60});  // no deviation
  lidar.last = objects;
  const auto first = lidar.get<int32_t>(RGL_FIELD_ENTITY_ID_I32);
  CHECK(first.size() == 2);
  OK(rgl_scene_set_time(nullptr, 101'000'000));
  lidar.run();
  CHECK(lidar.get<int32_t>(RGL_FIELD_ENTITY_ID_I32) == first);
  // Beams without a hit are no detections.
  rgl_node_t ofAll = nullptr;
  OK(rgl_node_points_radar_postprocess(&ofAll, &scope, 1, 0.015f, 0.01f, 79e9f, 31, 27, 60, 0));
  OK(rgl_graph_node_add_child(lidar.yield, ofAll));
  CHECK(failed(rgl_graph_run(lidar.rays), RGL_INVALID_PIPELINE, "requires dense input; put a compact node before it"));
  OK(rgl_cleanup());
}

// SPDX-License-Identifier: Apache-2.0
// Duties of libgnosphere_rgl as a library to its caller: tapes, statuses with a sentence, threads, levels of the
// interface.
#include <dlfcn.h>
#include <fcntl.h>
#include <rgl/api/extensions/pcl.h>
#include <rgl/api/extensions/ros2.h>
#include <rgl/api/extensions/tape.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <clocale>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <locale>
#include <string>
#include <thread>
#include <utility>

#include "folder.hpp"
#include "rgl/plugin.hpp"

using namespace gnosphere;
using namespace gnosphere::test;

TEST_CASE("RGL: a tape makes the calls again") {
  const Folder folder;
  const std::string path = (folder / "tape").string(), pcd = (folder / "cloud.pcd").string();
  bool active = true;
  OK(rgl_tape_record_is_active(&active));
  CHECK(!active);
  CHECK(failed(rgl_tape_record_end(), RGL_TAPE_ERROR, "begun"));
  CHECK(failed(rgl_tape_record_begin((folder / "no/tape").c_str()), RGL_INVALID_FILE_PATH, "no/tape"));
  OK(rgl_tape_record_begin(path.c_str()));
  CHECK(failed(rgl_tape_record_begin(path.c_str()), RGL_TAPE_ERROR, "already"));
  CHECK(failed(rgl_tape_play(path.c_str()), RGL_TAPE_ERROR, "recorded"));
  {
    const rgl_entity_t entity = place(squareMesh(), matrix(0, 0, 3));
    OK(rgl_entity_set_laser_retro(entity, std::numeric_limits<float>::infinity()));
    Lidar lidar(raysAround(8, 20), kBasic);
    OK(rgl_node_raytrace_configure_distortion(lidar.raytrace, false));
    lidar.run();
    int32_t available = 0;
    OK(rgl_get_extension_info(RGL_EXTENSION_PCL, &available));
    OK(rgl_get_version_info(&available, &available, &available));
    (void)lidar.get<float>(RGL_FIELD_DISTANCE_F32);
    OK(rgl_graph_write_pcd_file(lidar.yield, pcd.c_str()));
  }
  OK(rgl_cleanup());
  OK(rgl_tape_record_end());
  const std::string calls = bytesOf(path + ".yaml"), info = calls.substr(calls.find("rgl_get_extension_info"));
  CHECK(info.substr(0, info.find('\n')).ends_with("a: [0, 1]}"));                   // the result, which RGL compares
  CHECK(info.substr(info.find('\n') + 1).starts_with("- rgl_get_version_info: "));  // beside that of the beginning
  // A result of another size is warned of: there are 160 rays.
  const auto warningsOf = [&](const std::string& told) {
    put(path + ".yaml", told);
    OK(rgl_configure_logging(RGL_LOG_LEVEL_WARN, (folder / "log").c_str(), false));
    const rgl_status_t played = rgl_tape_play(path.c_str());
    OK(rgl_configure_logging(RGL_LOG_LEVEL_OFF, nullptr, false));
    CHECK(played == RGL_SUCCESS);
    return bytesOf(folder / "log");
  };
  CHECK(warningsOf(calls).find("the tape had a result") == calls.npos);
  const size_t size = calls.find(", 160, 4]}", calls.find("rgl_graph_get_result_size"));
  REQUIRE(size != calls.npos);
  for (const auto& [other, words] : {std::pair(", 161, 4]}", "161 x 4"), {", 160, 8]}", "160 x 8"}}) {
    const std::string warnings = warningsOf(std::string(calls).replace(size, 10, other));
    CHECK(warnings.find("the tape had a result of " + std::string(words) + " bytes, now it has 160 x 4") !=
          warnings.npos);
  }
  std::ofstream(folder / "bad.yaml") << "- rgl_get_version_info: {t: 0, a: [0, 14, 0]}\n";
  std::ofstream(folder / "bad.bin") << "";
  CHECK(failed(rgl_tape_play((folder / "bad").c_str()), RGL_TAPE_ERROR, "0.16.3"));
  std::ofstream(folder / "bad.yaml") << "";
  CHECK(failed(rgl_tape_play((folder / "bad").c_str()), RGL_TAPE_ERROR, "Invalid Tape: Empty YAML file detected"));
  std::ofstream(folder / "bad.yaml") << "rgl_version: {major: 0, minor: 16, patch: 2}\n";
  CHECK(failed(rgl_tape_play((folder / "bad").c_str()), RGL_TAPE_ERROR, "Detected outdated format"));
  std::ofstream(folder / "bad.yaml") << "- rgl_mesh_create: {t: 0, a: [0]}\n";
  CHECK(failed(rgl_tape_play((folder / "bad").c_str()), RGL_TAPE_ERROR, "Missing version record in the Tape"));
  std::ofstream(folder / "bad.yaml") << "[1, 2";
  CHECK(failed(rgl_tape_play((folder / "bad").c_str()), RGL_TAPE_ERROR, "no recording"));
  CHECK(failed(rgl_tape_play((folder / "none").c_str()), RGL_INVALID_FILE_PATH, "none.yaml"));
}

TEST_CASE("RGL: a tape that is played makes the scene that was recorded") {
  const Folder folder;
  const std::string path = (folder / "tape").string();
  OK(rgl_tape_record_begin(path.c_str()));
  const rgl_entity_t entity = place(squareMesh(2), matrix(0, 0.5, 3));
  OK(rgl_entity_set_id(entity, 9));
  OK(rgl_entity_set_laser_retro(entity, -2.5f));
  OK(rgl_tape_record_end());
  OK(rgl_cleanup());
  const auto distanceOf = [&] {
    Lidar lidar({matrix(1.5, 2.25, 0)}, {RGL_FIELD_DISTANCE_F32, RGL_FIELD_ENTITY_ID_I32, RGL_FIELD_LASER_RETRO_F32});
    lidar.run();
    const float distance = lidar.get<float>(RGL_FIELD_DISTANCE_F32)[0];
    if (std::isinf(distance)) return distance;
    CHECK(lidar.get<int32_t>(RGL_FIELD_ENTITY_ID_I32)[0] == 9);
    CHECK(lidar.get<float>(RGL_FIELD_LASER_RETRO_F32)[0] == -2.5f);
    return distance;
  };
  CHECK(std::isinf(distanceOf()));
  OK(rgl_tape_play(path.c_str()));
  CHECK(distanceOf() == 3);
  OK(rgl_cleanup());
}

namespace {

/// Numbers as much of the world writes them: 1.234,5.
struct Commas : std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
  char do_thousands_sep() const override { return '.'; }
  std::string do_grouping() const override { return "\3"; }
};

/// The locale of the program while this lives: that of C++, and that of C if the machine has one with commas.
class CommaLocale {
 public:
  CommaLocale() : before_(std::locale::global(std::locale(std::locale(), new Commas))) {
    std::setlocale(LC_ALL, "de_DE.utf8");
  }
  ~CommaLocale() {
    std::locale::global(before_);
    std::setlocale(LC_ALL, "C");
  }

 private:
  std::locale before_;
};

}  // namespace

TEST_CASE("RGL: a tape is the same in every locale, and is played in every locale") {
  const Folder folder;
  const auto record = [&](const std::string& name) {
    OK(rgl_tape_record_begin((folder / name).c_str()));
    {
      const rgl_entity_t entity = place(squareMesh(), matrix(0, 0, 3));
      OK(rgl_entity_set_laser_retro(entity, 1.25f));
      OK(rgl_scene_set_time(nullptr, uint64_t{1} << 63));
      Lidar lidar(raysAround(8, 20), kBasic);
      lidar.run();
    }
    OK(rgl_cleanup());
    OK(rgl_tape_record_end());
  };
  record("usual");
  const CommaLocale commas;
  record("commas");
  const std::string tape = bytesOf(folder / "commas.yaml");
  CHECK(tape.find("1.25") != tape.npos);
  CHECK(tape.find("9223372036854775808") != tape.npos);
  for (const char* name : {"usual", "commas"}) OK(rgl_tape_play((folder / name).c_str()));
}

TEST_CASE("RGL: a tape whose arrays are cut short, or whose calls fail, is an error") {
  const Folder folder;
  const std::string path = (folder / "tape").string();
  const auto play = [&](const std::string& calls, size_t bytes) {
    std::ofstream(path + ".yaml") << "- rgl_get_version_info: {t: 0, a: [0, 20, 0]}\n" << calls;
    std::ofstream(path + ".bin") << std::string(bytes, '\0');
    return rgl_tape_play(path.c_str());
  };
  const auto tapeError = [](rgl_status_t status, const char* words) { return failed(status, RGL_TAPE_ERROR, words); };
  // 3 vertices are 36 bytes, and a triangle has 12; arrays begin at multiples of 16.
  OK(play("- rgl_mesh_create: {t: 0, a: [1, 0, 3, 48, 1]}\n", 60));
  CHECK(tapeError(play("- rgl_mesh_create: {t: 0, a: [1, 0, 3, 48, 1]}\n", 59), "longer than its binary file"));
  CHECK(tapeError(play("- rgl_mesh_create: {t: 0, a: [1, 0, 100000000, 48, 1]}\n", 64), "longer"));
  CHECK(tapeError(play("- rgl_mesh_create: {t: 0, a: [1, 8, 3, 48, 1]}\n", 64), "multiple of 16"));
  CHECK(tapeError(play("- rgl_node_rays_transform: {t: 0, a: [1, 0]}\n", 47), "longer"));
  OK(play("- rgl_node_rays_transform: {t: 0, a: [1, 0]}\n", 48));
  CHECK(tapeError(play("- rgl_texture_create: {t: 0, a: [1, 0, 8, 8]}\n", 63), "longer"));
  OK(play("- rgl_texture_create: {t: 0, a: [1, 0, 8, 8]}\n", 64));
  CHECK(tapeError(play("- rgl_node_points_from_array: {t: 0, a: [1, 0, 8, 16, 1000]}\n", 64), "longer"));
  CHECK(tapeError(play("- rgl_mesh_create\n", 0), "no call"));
  CHECK(tapeError(play("- rgl_cleanup: {t: 9000000000000000000, a: []}\n", 0), "30 days"));
  CHECK(failed(play("- rgl_mesh_destroy: {t: 0, a: [77]}\n- rgl_cleanup: {t: 0, a: []}\n", 0), RGL_INVALID_ARGUMENT,
               "the tape's call of rgl_mesh_destroy failed"));
  OK(rgl_cleanup());
}

TEST_CASE("RGL: a tape that is played writes no file that it names, and says so once") {
  const Folder folder;
  const std::string path = (folder / "tape").string(), log = (folder / "log").string();
  const fs::path victim = put(folder / "victim", "precious");
  const std::string place = "\"" + victim.string() + "\"";
  put(path + ".bin", "");
  put(path + ".yaml", "- rgl_get_version_info: {t: 0, a: [0, 20, 0]}\n- rgl_configure_logging: {t: 0, a: [0, " + place +
                          ", false]}\n- rgl_graph_write_pcd_file: {t: 0, a: [1, " + place +
                          "]}\n- rgl_configure_logging: {t: 0, a: [3, \"\", true]}\n");
  OK(rgl_configure_logging(RGL_LOG_LEVEL_WARN, log.c_str(), false));
  const rgl_status_t played = rgl_tape_play(path.c_str());
  const std::string why = lastError();
  OK(rgl_configure_logging(RGL_LOG_LEVEL_OFF, nullptr, false));
  INFO(why);
  CHECK(played == RGL_SUCCESS);
  CHECK(bytesOf(victim) == "precious");
  const std::string told = bytesOf(log), words = "the tape's call of rgl_configure_logging is left out";
  CHECK(told.find(words) != told.npos);
  CHECK(told.find(victim.string()) != told.npos);
  CHECK(told.find("left out") == told.rfind("left out"));
}

TEST_CASE("RGL: the log has the sentences of failures alone, and goes where it is wanted") {
  const Folder folder;
  const std::string file = (folder / "log").string(), output = (folder / "output").string();
  const auto logged = [&](bool standardOutput) {
    std::fflush(stdout);
    const int before = dup(STDOUT_FILENO), to = open(output.c_str(), O_CREAT | O_TRUNC | O_WRONLY, 0600);
    dup2(to, STDOUT_FILENO);
    rgl_configure_logging(RGL_LOG_LEVEL_ERROR, file.c_str(), standardOutput);
    rgl_cleanup();
    rgl_graph_run(nullptr);
    rgl_configure_logging(RGL_LOG_LEVEL_OFF, nullptr, false);
    std::fflush(stdout);
    dup2(before, STDOUT_FILENO);
    for (const int each : {before, to}) close(each);
    return std::pair(bytesOf(file), bytesOf(output));
  };
  const auto [inFile, besides] = logged(false);
  CHECK(inFile.starts_with("[RGL] [error] "));
  CHECK(std::count(inFile.begin(), inFile.end(), '\n') == 1);
  CHECK(besides.empty());
  CHECK(logged(true) == std::pair(inFile, inFile));
}

TEST_CASE("RGL: other threads make their calls while a tape is played") {
  const Folder folder;
  const std::string path = (folder / "tape").string();
  std::ofstream(path + ".yaml") << "- rgl_get_version_info: {t: 0, a: [0, 20, 0]}\n"
                                << "- rgl_cleanup: {t: 2000000000, a: []}\n";
  std::ofstream(path + ".bin") << "";
  rgl_status_t played = RGL_TAPE_ERROR;
  std::atomic<bool> ended = false;
  std::jthread player([&] {
    played = rgl_tape_play(path.c_str());
    ended = true;
  });
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  bool active = true;
  OK(rgl_tape_record_is_active(&active));
  CHECK_FALSE(ended);
  player.join();
  CHECK(played == RGL_SUCCESS);
}

TEST_CASE("RGL: wrong handles, arguments and graphs are statuses with a sentence") {
  rgl_mesh_t mesh = squareMesh();
  const rgl_vec3f vertex = {{0, 0, 0}};
  const rgl_vec3i triangle = {{0, 0, 5}};
  rgl_mesh_t bad = nullptr;
  CHECK(failed(rgl_mesh_create(&bad, &vertex, 1, &triangle, 1), RGL_INVALID_ARGUMENT, "the vertex 5"));
  OK(rgl_mesh_destroy(mesh));
  CHECK(failed(rgl_mesh_destroy(mesh), RGL_INVALID_API_OBJECT, "Object does not exist: Mesh 0x"));
  rgl_entity_t entity = nullptr;
  CHECK(failed(rgl_entity_create(&entity, nullptr, mesh), RGL_INVALID_API_OBJECT, "Mesh"));
  CHECK(failed(rgl_graph_run(reinterpret_cast<rgl_node_t>(mesh)), RGL_INVALID_API_OBJECT, "Node"));
  rgl_node_t raytrace = nullptr, yield = nullptr;
  const rgl_field_t field = RGL_FIELD_XYZ_VEC3_F32, unknown = static_cast<rgl_field_t>(777);
  OK(rgl_node_raytrace(&raytrace, nullptr));
  OK(rgl_node_points_yield(&yield, &field, 1));
  CHECK(failed(rgl_node_points_yield(&yield, &unknown, 1), RGL_INVALID_ARGUMENT, "777"));
  CHECK(failed(rgl_node_raytrace(&yield, nullptr), RGL_INVALID_API_OBJECT,
               "Node type mismatch: expected RaytraceNode, got YieldPointsNode"));
  OK(rgl_graph_node_add_child(raytrace, yield));
  CHECK(failed(rgl_graph_node_add_child(yield, raytrace), RGL_INVALID_PIPELINE, "circle"));
  CHECK(failed(rgl_graph_node_add_child(raytrace, raytrace), RGL_INVALID_ARGUMENT, "parent != child"));
  CHECK(failed(rgl_graph_run(yield), RGL_INVALID_PIPELINE, "looked for IRaysNode"));
  CHECK(failed(rgl_graph_get_result_size(yield, field, nullptr, nullptr), RGL_INVALID_PIPELINE, "hasn't been run"));
  int32_t priority = -1;
  OK(rgl_graph_node_set_priority(yield, 3));
  OK(rgl_graph_node_get_priority(raytrace, &priority));
  CHECK(priority == 3);
  CHECK(failed(rgl_graph_node_set_priority(raytrace, 2), RGL_INVALID_PIPELINE, "cannot set priority"));
  rgl_node_t rays = nullptr;
  const rgl_mat3x4f ray = matrix(0, 0, 0);
  OK(rgl_node_rays_from_mat3x4f(&rays, &ray, 1));
  OK(rgl_graph_node_add_child(rays, raytrace));
  OK(rgl_graph_node_get_priority(rays, &priority));
  CHECK(priority == 3);  // of the child that it has got
  bool alive = true;
  OK(rgl_graph_destroy(yield));
  OK(rgl_node_is_alive(raytrace, &alive));
  CHECK(!alive);
  rgl_node_t none = nullptr;
  CHECK(failed(
      rgl_node_publish_ros2_radarscan(&none, "topic", "frame", QOS_POLICY_RELIABILITY_SYSTEM_DEFAULT,
                                      QOS_POLICY_DURABILITY_SYSTEM_DEFAULT, QOS_POLICY_HISTORY_SYSTEM_DEFAULT, 1),
      RGL_NOT_IMPLEMENTED, "ros2"));
  int32_t available = -1;
  OK(rgl_get_extension_info(RGL_EXTENSION_UDP, &available));
  CHECK(available == 0);
  for (const rgl_extension_t extension : {RGL_EXTENSION_PCL, RGL_EXTENSION_WEATHER}) {
    OK(rgl_get_extension_info(extension, &available));
    CHECK(available == 1);
  }
  CHECK(failed(rgl_configure_logging(RGL_LOG_LEVEL_INFO, "/no/such/folder/log", false), RGL_LOGGING_ERROR, "/no/such"));
  OK(rgl_cleanup());  // a failure leaves the library usable
}

TEST_CASE("RGL: objects are alive until they are destroyed, whatever still uses them") {
  const auto check = [](auto isAlive, auto object, bool expected) {
    bool alive = !expected;
    OK(isAlive(object, &alive));
    CHECK(alive == expected);
  };
  const rgl_mesh_t mesh = squareMesh();
  const rgl_entity_t entity = place(mesh, matrix(0, 0, 3));
  const uint8_t texel = 1;
  rgl_texture_t texture = nullptr;
  OK(rgl_texture_create(&texture, &texel, 1, 1));
  OK(rgl_entity_set_intensity_texture(entity, texture));
  const Lidar lidar({matrix(0, 0, 0)}, kBasic);
  check(rgl_mesh_is_alive, mesh, true);
  check(rgl_texture_is_alive, texture, true);
  OK(rgl_mesh_destroy(mesh));
  OK(rgl_texture_destroy(texture));
  check(rgl_mesh_is_alive, mesh, false);
  check(rgl_texture_is_alive, texture, false);
  check(rgl_entity_is_alive, entity, true);
  check(rgl_node_is_alive, lidar.yield, true);
  check(rgl_node_is_alive, reinterpret_cast<rgl_node_t>(entity), false);
  check(rgl_entity_is_alive, rgl_entity_t{nullptr}, false);
  CHECK(failed(rgl_entity_is_alive(entity, nullptr), RGL_INVALID_ARGUMENT, "out_alive != nullptr"));
  OK(rgl_cleanup());
  check(rgl_entity_is_alive, entity, false);
  check(rgl_node_is_alive, lidar.yield, false);
}

/// Functions of earlier levels and of closed extensions, which the headers do not declare.
extern "C" {
rgl_status_t rgl_entity_set_pose(rgl_entity_t entity, const rgl_mat3x4f* transform);
rgl_status_t rgl_mesh_update_vertices(rgl_mesh_t mesh, const rgl_vec3f* vertices, int32_t vertex_count);
rgl_status_t rgl_node_raytrace_in_motion(rgl_node_t* node, rgl_scene_t scene, const rgl_vec3f* linear_velocity,
                                         const rgl_vec3f* angular_velocity, bool apply_distortion);
rgl_status_t rgl_node_raytrace_with_distortion(rgl_node_t* node, rgl_scene_t scene, const rgl_vec3f* linear_velocity,
                                               const rgl_vec3f* angular_velocity);
rgl_status_t rgl_graph_node_set_active(rgl_node_t node, bool active);
rgl_status_t rgl_node_configure_agnocast(rgl_node_t node);
rgl_status_t rgl_node_points_simulate_fog(rgl_node_t* node);
rgl_status_t rgl_node_points_simulate_rain(rgl_node_t* node);
rgl_status_t rgl_node_points_udp_publish(rgl_node_t* node);
rgl_status_t rgl_node_publish_ros2_radartracks(rgl_node_t* node);
}

TEST_CASE("RGL: functions of earlier levels do what their followers do") {
  const rgl_mesh_t mesh = squareMesh();
  const rgl_entity_t entity = place(mesh, matrix(0, 0, 9));
  const rgl_mat3x4f nearer = matrix(0, 0, 5);
  OK(rgl_entity_set_pose(entity, &nearer));
  Lidar lidar({matrix(0, 0, 0), matrix(0, 0, 0)}, kBasic);
  rgl_node_t offsets = nullptr;
  const float times[] = {0, 500};
  OK(rgl_node_rays_set_time_offsets(&offsets, times, 2));
  OK(rgl_graph_node_remove_child(lidar.rays, lidar.pose));
  OK(rgl_graph_node_add_child(lidar.rays, offsets));
  OK(rgl_graph_node_add_child(offsets, lidar.pose));
  const rgl_vec3f velocity = {{4, 0, 0}}, still = {{0, 0, 0}};  // the second ray is 2 m beside the square
  const float infinity = std::numeric_limits<float>::infinity();
  const auto check = [&](float second, float first = 5) {
    lidar.run();
    CHECK(lidar.get<float>(RGL_FIELD_DISTANCE_F32) == std::vector<float>{first, second});
  };
  check(5);
  OK(rgl_node_raytrace_with_distortion(&lidar.raytrace, nullptr, &velocity, &still));
  check(infinity);
  OK(rgl_node_raytrace_in_motion(&lidar.raytrace, nullptr, &velocity, &still, false));
  check(5);
  OK(rgl_node_raytrace_in_motion(&lidar.raytrace, nullptr, &velocity, &still, true));
  check(infinity);
  CHECK(failed(rgl_node_raytrace_in_motion(nullptr, nullptr, &velocity, &still, true), RGL_INVALID_ARGUMENT, "node"));
  // Other vertices are those of every entity of the mesh, also of later ones.
  const rgl_vec3f farther[] = {{{-1, -1, 1}}, {{1, -1, 1}}, {{1, 1, 1}}, {{-1, 1, 1}}};
  OK(rgl_mesh_update_vertices(mesh, farther, 4));
  check(infinity, 6);
  place(mesh, matrix(2, 0, 3));
  check(4, 6);
  CHECK(failed(rgl_mesh_update_vertices(mesh, farther, 3), RGL_INVALID_ARGUMENT, "vertex counts do not match"));
  OK(rgl_cleanup());
}

TEST_CASE("RGL: functions that are not implemented say so, and what to do instead") {
  const auto refused = [](rgl_status_t status, const std::string& name, const char* instead) {
    CHECK(failed(status, RGL_NOT_IMPLEMENTED, name + " is not implemented by GnoSphere: "));
    CHECK(lastError().find(instead) != std::string::npos);
  };
  rgl_node_t node = nullptr;
  refused(rgl_node_points_visualize(&node, "window", 10, 10, false), "rgl_node_points_visualize", "write_pcd_file");
  refused(rgl_graph_node_set_active(node, false), "rgl_graph_node_set_active", "rgl_graph_node_remove_child");
  refused(rgl_node_configure_agnocast(node), "rgl_node_configure_agnocast", "ROS 2");
  refused(rgl_node_points_simulate_fog(&node), "rgl_node_points_simulate_fog", "own interface has weather");
  refused(rgl_node_points_simulate_rain(&node), "rgl_node_points_simulate_rain", "own interface has weather");
  refused(rgl_node_points_udp_publish(&node), "rgl_node_points_udp_publish", "closed extension");
  refused(rgl_node_publish_ros2_radartracks(&node), "rgl_node_publish_ros2_radartracks", "laser scans are published");
  CHECK(node == nullptr);
}

TEST_CASE("RGL: a graph is walked once, however many ways lead through it") {
  // Each rung has two nodes between one merge and the next, so there are 2^40 ways from the first to the last.
  const std::vector<rgl_field_t> fields = {RGL_FIELD_XYZ_VEC3_F32};
  const rgl_mat3x4f to = matrix(0, 0, 0);
  rgl_node_t last = nullptr, first = nullptr;
  OK(rgl_node_points_spatial_merge(&first, fields.data(), 1));
  last = first;
  for (int rung = 0; rung < 40; ++rung) {
    rgl_node_t merge = nullptr;
    OK(rgl_node_points_spatial_merge(&merge, fields.data(), 1));
    for (int k = 0; k < 2; ++k) {
      rgl_node_t between = nullptr;
      OK(rgl_node_points_transform(&between, &to));
      OK(rgl_graph_node_add_child(last, between));
      OK(rgl_graph_node_add_child(between, merge));
    }
    last = merge;
  }
  CHECK(failed(rgl_graph_node_add_child(last, first), RGL_INVALID_PIPELINE, "circle"));
  OK(rgl_cleanup());
}

TEST_CASE("RGL: several threads run graphs of their own") {
  place(squareMesh(20), matrix(0, 0, 4));
  bool good[4] = {};
  std::vector<std::thread> threads;
  for (int k = 0; k < 4; ++k)
    threads.emplace_back([&good, k] {
      const rgl_mat3x4f ray = matrix(0, 0, k);
      const rgl_field_t field = RGL_FIELD_DISTANCE_F32;
      rgl_node_t rays = nullptr, raytrace = nullptr, yield = nullptr;
      bool fine = rgl_node_rays_from_mat3x4f(&rays, &ray, 1) == RGL_SUCCESS &&
                  rgl_node_raytrace(&raytrace, nullptr) == RGL_SUCCESS &&
                  rgl_node_points_yield(&yield, &field, 1) == RGL_SUCCESS &&
                  rgl_graph_node_add_child(rays, raytrace) == RGL_SUCCESS &&
                  rgl_graph_node_add_child(raytrace, yield) == RGL_SUCCESS;
      for (int i = 0; i < 5 && fine; ++i) {
        float distance = 0;
        fine = rgl_graph_run(rays) == RGL_SUCCESS &&
               rgl_graph_get_result_data(yield, field, &distance) == RGL_SUCCESS && distance == 4.0f - float(k);
      }
      good[k] = fine;
    });
  for (std::thread& thread : threads) thread.join();
  for (const bool each : good) CHECK(each);
  OK(rgl_cleanup());
}

TEST_CASE("RGL: the version that is told is the one that the caller wants, or that of the level") {
  const auto told = [](const char* wanted) {
    setenv("GNOSPHERE_RGL_VERSION", wanted, 1);
    std::vector<int32_t> numbers(3);
    OK(rgl_get_version_info(&numbers[0], &numbers[1], &numbers[2]));
    unsetenv("GNOSPHERE_RGL_VERSION");
    return numbers;
  };
  CHECK(told("1.2.3 ") == std::vector<int32_t>{1, 2, 3});
  for (const char* wrong : {"", "1.2", "1.2.3.4", "1..2", "1.2.x", "-1.2.3", "1.2.99999999999"})
    CHECK(told(wrong) == std::vector<int32_t>{0, 20, 0});
}

TEST_CASE("RGL: levels have their numbers of fields and their version", "[.level]") {
  const std::string level = std::getenv("GNOSPHERE_RGL_ABI");
  int32_t major = -1, minor = -1, patch = -1;
  OK(rgl_get_version_info(&major, &minor, &patch));
  CHECK("0." + std::to_string(minor) == level);
  // DISTANCE, RING_ID and IS_HIT at levels 0.16, 0.17 and 0.18.
  const int row = level == "0.16" ? 0 : level == "0.17" ? 1 : 2;
  const rgl_field_t fields[] = {static_cast<rgl_field_t>(std::vector{7, 7, 8}[row]),
                                static_cast<rgl_field_t>(std::vector{9, 10, 11}[row]),
                                static_cast<rgl_field_t>(std::vector{3, 3, 4}[row])};
  place(squareMesh(), matrix(0, 0, 3));
  Lidar lidar({matrix(0, 0, 0)}, {fields[0], fields[1], fields[2]});
  rgl_node_t rings = nullptr;
  const int32_t ids[] = {12};
  OK(rgl_node_rays_set_ring_ids(&rings, ids, 1));
  OK(rgl_graph_node_remove_child(lidar.rays, lidar.pose));
  OK(rgl_graph_node_add_child(lidar.rays, rings));
  OK(rgl_graph_node_add_child(rings, lidar.pose));
  lidar.run();
  CHECK(lidar.get<float>(fields[0])[0] == 3);
  CHECK(lidar.get<uint16_t>(fields[1])[0] == 12);
  CHECK(lidar.get<int32_t>(fields[2])[0] == 1);
  // Names of earlier levels are there, too.
  using Compact = rgl_status_t (*)(rgl_node_t*);
  const auto compact = reinterpret_cast<Compact>(dlsym(RTLD_DEFAULT, "rgl_node_points_compact"));
  REQUIRE(compact);
  rgl_node_t node = nullptr;
  OK(compact(&node));
  lidar.append(node);
  lidar.run();
  // A tape of this level is played at this level.
  const Folder folder;
  const std::string tape = (folder / "tape").string();
  OK(rgl_tape_record_begin(tape.c_str()));
  OK(rgl_cleanup());
  OK(rgl_tape_record_end());
  OK(rgl_tape_play(tape.c_str()));
}

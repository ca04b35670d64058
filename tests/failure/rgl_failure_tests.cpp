// SPDX-License-Identifier: Apache-2.0
// RGL's interface without memory: every call returns a status, and graphs, entities and tapes stay what they are.
#include <rgl/api/extensions/pcl.h>
#include <rgl/api/extensions/tape.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <limits>

#include "failure/injection.hpp"
#include "folder.hpp"
#include "rgl/legacy.hpp"
#include "rgl/plugin.hpp"
#include "rgl/scene.hpp"
#include "support.hpp"

namespace gnosphere::test {
namespace {

const std::vector<rgl_field_t> kFields = {RGL_FIELD_XYZ_VEC3_F32, RGL_FIELD_DISTANCE_F32, RGL_FIELD_ENTITY_ID_I32,
                                          RGL_FIELD_IS_HIT_I32, RGL_FIELD_NORMAL_VEC3_F32};

/// Throws what a status stands for. The message is empty if there was no memory for it.
void need(rgl_status_t status) {
  if (status == RGL_SUCCESS) return;
  if (status == RGL_INTERNAL_EXCEPTION || status == RGL_INITIALIZATION_ERROR) throw std::bad_alloc();
  throw std::runtime_error("status " + std::to_string(status) + ": " + lastError());
}

/// Two squares around a lidar, one of which is animated, and the points that the lidar must find again.
class RglSubject {
 public:
  RglSubject() : lidar_(raysAround(8, 20), kFields) {
    mesh = squareMesh(3);
    still = place(mesh, matrix(0, 0, 4));
    animated = place(mesh, matrix(5, 0, 0, 0, 1.5));
    OK(rgl_entity_apply_external_animation(animated, shape.data(), 4));
    // An entity of the floor is seen wherever it stands. Its mesh stays in the simulator as long as there is a handle.
    const std::array<rgl_vec3f, 4> corners = {{{{-9, -9, -3}}, {{9, -9, -3}}, {{9, 9, -3}}, {{-9, 9, -3}}}};
    const rgl_vec3i triangles[] = {{{0, 1, 2}}, {{0, 2, 3}}};
    OK(rgl_mesh_create(&floor, corners.data(), 4, triangles, 2));
    const rgl_entity_t entity = place(floor, matrix(0, 0, 0));
    const auto more = results();
    OK(rgl_entity_destroy(entity));
    expected_ = results();
    CHECK(!sameBytes(more, expected_));
  }
  ~RglSubject() { OK(rgl_cleanup()); }

  std::vector<std::array<float, 3>> results() {
    lidar_.run();
    std::vector<std::array<float, 3>> values;
    for (const rgl_field_t field : {RGL_FIELD_XYZ_VEC3_F32, RGL_FIELD_NORMAL_VEC3_F32})
      for (const auto& point : lidar_.get<std::array<float, 3>>(field)) values.push_back(point);
    const auto ids = lidar_.get<int32_t>(RGL_FIELD_ENTITY_ID_I32);
    for (const int32_t id : ids) values.push_back({static_cast<float>(id), 0, 0});
    return values;
  }
  void check() {
    CHECK(sameBytes(results(), expected_));
    Simulator& simulator = rgl::scene().simulator(RGL_SENSOR_ID_DEFAULT);
    if (clusters_ == 0) clusters_ = simulator.clusterCount();
    CHECK(simulator.clusterCount() == clusters_);  // nothing is left in the simulator
  }

  Lidar& lidar() { return lidar_; }
  const std::vector<std::array<float, 3>>& expected() const { return expected_; }
  rgl_mesh_t mesh = nullptr, floor = nullptr;
  rgl_entity_t still = nullptr, animated = nullptr;
  std::array<rgl_vec3f, 4> shape = {{{{-2, -2, 0}}, {{2, -2, 0.5f}}, {{2, 2, 0}}, {{-2, 2, 0.5f}}}};

 private:
  Lidar lidar_;
  std::vector<std::array<float, 3>> expected_;
  size_t clusters_ = 0;
};

/// Chooses the device of the library before its first run, and keeps it quiet.
void quiet() {
  needVulkan();
  setenv("GNOSPHERE_RGL_DEVICE", "auto", 0);
  OK(rgl_configure_logging(RGL_LOG_LEVEL_OFF, nullptr, false));
}

void each(const char* name, RglSubject& subject, const std::function<rgl_status_t()>& call,
          const std::function<void()>& undo) {
  failEach(std::string("RGL: ") + name, Fails::memory, {[&] { need(call()); }, undo, [&] { subject.check(); }});
}

}  // namespace

TEST_CASE("RGL: without memory the scene stays what it is", "[combinations]") {
  quiet();
  RglSubject subject;
  const rgl_vec3i triangles[] = {{{0, 1, 2}}, {{0, 2, 3}}};
  rgl_mesh_t mesh = nullptr;
  each(
      "mesh_create", subject, [&] { return rgl_mesh_create(&mesh, subject.shape.data(), 4, triangles, 2); },
      [&] { OK(rgl_mesh_destroy(mesh)); });
  rgl_entity_t entity = nullptr;
  each(
      "entity_create", subject, [&] { return rgl_entity_create(&entity, nullptr, subject.floor); },
      [&] {
        CHECK(!sameBytes(subject.results(), subject.expected()));
        OK(rgl_entity_destroy(entity));
      });
  rgl_texture_t texture = nullptr;
  const std::vector<uint8_t> texels(64, 7);
  each(
      "texture_create", subject, [&] { return rgl_texture_create(&texture, texels.data(), 8, 8); },
      [&] { OK(rgl_texture_destroy(texture)); });
  const std::vector<rgl_vec2f> coordinates(4);
  each("mesh_set_texture_coords", subject,
       [&] { return rgl_mesh_set_texture_coords(subject.mesh, coordinates.data(), 4); }, {});
  each(
      "entity_apply_external_animation", subject,
      [&] {
        auto moved = subject.shape;
        moved[0].value[2] = 1;
        return rgl_entity_apply_external_animation(subject.animated, moved.data(), 4);
      },
      [&] { OK(rgl_entity_apply_external_animation(subject.animated, subject.shape.data(), 4)); });
  each("entity_set_ignored_by_sensor", subject, [&] { return rgl_entity_set_ignored_by_sensor(subject.still, 7); }, {});
  // A run takes a new mesh, a new entity and one with a shape of its own to the simulator, and the next one removes
  // them.
  failEach("RGL: graph_run with new entities", Fails::memory,
           {[&] {
              need(rgl_mesh_create(&mesh, subject.shape.data(), 4, triangles, 2));
              rgl_entity_t first = nullptr, second = nullptr;
              need(rgl_entity_create(&first, nullptr, mesh));
              need(rgl_entity_create(&second, nullptr, mesh));
              need(rgl_entity_apply_external_animation(second, subject.shape.data(), 4));
              need(rgl_graph_run(subject.lidar().rays));
              need(rgl_entity_destroy(first));
              need(rgl_entity_destroy(second));
              need(rgl_mesh_destroy(mesh));
              need(rgl_graph_run(subject.lidar().rays));
            },
            {},
            [&] {
              // Whatever the call has made before it failed goes.
              std::vector<rgl_entity_t> entities;
              std::vector<rgl_mesh_t> meshes;
              rgl::scene().entities.each([&](rgl_entity_t each, const rgl::EntityObject&) {
                if (each != subject.still && each != subject.animated) entities.push_back(each);
              });
              for (const rgl_entity_t each : entities) OK(rgl_entity_destroy(each));
              rgl::scene().meshes.each([&](rgl_mesh_t each, const rgl::MeshObject&) {
                if (each != subject.mesh && each != subject.floor) meshes.push_back(each);
              });
              for (const rgl_mesh_t each : meshes) OK(rgl_mesh_destroy(each));
              subject.check();
            }});
}

TEST_CASE("RGL: without memory new vertices of a mesh reach all its entities or none") {
  quiet();
  RglSubject subject;
  const std::array<rgl_vec3f, 4> square = {{{{-3, -3, 0}}, {{3, -3, 0}}, {{3, 3, 0}}, {{-3, 3, 0}}}};
  auto moved = square;
  moved[2].value[2] = 2;
  const auto restore = [&] {
    OK(rgl_mesh_update_vertices(subject.mesh, square.data(), 4));
    OK(rgl_entity_apply_external_animation(subject.animated, subject.shape.data(), 4));
  };
  OK(rgl_mesh_update_vertices(subject.mesh, moved.data(), 4));
  const auto expected = subject.results();
  restore();
  each(
      "mesh_update_vertices", subject, [&] { return rgl_mesh_update_vertices(subject.mesh, moved.data(), 4); },
      [&] {
        CHECK(sameBytes(subject.results(), expected));
        restore();
      });
}

TEST_CASE("RGL: without memory graphs stay what they are", "[combinations]") {
  quiet();
  RglSubject subject;
  Lidar& lidar = subject.lidar();
  const std::vector<rgl_mat3x4f> rays = raysAround(8, 20), others = raysAround(5, 11);
  const auto count = [](const auto& values) { return static_cast<int32_t>(values.size()); };
  each(
      "node_rays_from_mat3x4f", subject,
      [&] { return rgl_node_rays_from_mat3x4f(&lidar.rays, others.data(), count(others)); },
      [&] { OK(rgl_node_rays_from_mat3x4f(&lidar.rays, rays.data(), count(rays))); });
  each(
      "node_points_yield", subject, [&] { return rgl_node_points_yield(&lidar.yield, kFields.data(), 1); },
      [&] { OK(rgl_node_points_yield(&lidar.yield, kFields.data(), count(kFields))); });
  rgl_node_t node = nullptr;
  each(
      "node_points_format, a new one", subject,
      [&] {
        node = nullptr;
        return rgl_node_points_format(&node, kFields.data(), count(kFields));
      },
      [&] { OK(rgl_graph_destroy(node)); });
  node = nullptr;
  OK(rgl_node_points_format(&node, kFields.data(), count(kFields)));
  each(
      "graph_node_add_child", subject, [&] { return rgl_graph_node_add_child(lidar.yield, node); },
      [&] { OK(rgl_graph_node_remove_child(lidar.yield, node)); });
  OK(rgl_graph_node_add_child(lidar.yield, node));
  each(
      "graph_node_remove_child", subject, [&] { return rgl_graph_node_remove_child(lidar.yield, node); },
      [&] { OK(rgl_graph_node_add_child(lidar.yield, node)); });
  each("graph_run", subject, [&] { return rgl_graph_run(lidar.rays); }, {});

  // Points of a caller, which a node keeps.
  const std::vector<float> points = {1, 2, 3, 4, 5, 6}, fewer = {7, 8, 9};
  const rgl_field_t xyz = RGL_FIELD_XYZ_VEC3_F32;
  rgl_node_t array = nullptr;
  OK(rgl_node_points_from_array(&array, points.data(), 2, &xyz, 1));
  failEach("RGL: node_points_from_array", Fails::memory,
           {[&] { need(rgl_node_points_from_array(&array, fewer.data(), 1, &xyz, 1)); },
            [&] { OK(rgl_node_points_from_array(&array, points.data(), 2, &xyz, 1)); },
            [&] {
              OK(rgl_graph_run(array));
              std::vector<float> result(6);
              OK(rgl_graph_get_result_data(array, xyz, result.data()));
              CHECK(result == points);
            }});
  OK(rgl_graph_destroy(array));
  each("cleanup", subject,
       [&] {
         // A second graph with a sensor of its own in the simulator goes.
         rgl_node_t from = nullptr, raytrace = nullptr;
         need(rgl_node_rays_from_mat3x4f(&from, others.data(), count(others)));
         const auto remove = [&] { rgl_graph_destroy(from); };
         try {
           need(rgl_node_raytrace(&raytrace, nullptr));
           need(rgl_graph_node_add_child(from, raytrace));
           need(rgl_graph_run(from));
         } catch (...) {
           if (raytrace) rgl_graph_destroy(raytrace);
           remove();
           throw;
         }
         return rgl_graph_destroy(from);
       },
       {});
}

TEST_CASE("RGL: without memory nodes that remember runs forget a run that fails", "[combinations]") {
  quiet();
  const rgl_field_t fields[] = {RGL_FIELD_XYZ_VEC3_F32, RGL_FIELD_ENTITY_ID_I32};
  std::vector<std::array<float, 4>> points = {{1, 2, 3, 0}, {4, 5, 6, 0}};
  rgl_node_t array = nullptr, merge = nullptr;
  OK(rgl_node_points_from_array(&array, points.data(), 2, fields, 2));
  OK(rgl_node_points_temporal_merge(&merge, fields, 2));
  OK(rgl_graph_node_add_child(array, merge));
  int32_t runs = 0;
  failEach("RGL: graph_run of a temporal merge", Fails::memory,
           {[&] {
              need(rgl_graph_run(array));
              ++runs;
            },
            {},
            [&] {
              OK(rgl_graph_run(array));
              ++runs;
              int32_t count = 0, size = 0;
              OK(rgl_graph_get_result_size(merge, fields[0], &count, &size));
              CHECK(count == 2 * runs);
              std::vector<std::array<float, 3>> result(count);
              OK(rgl_graph_get_result_data(merge, fields[0], result.data()));
              CHECK(std::all_of(result.begin(), result.end(), [&](const std::array<float, 3>& each) {
                return each[1] == each[0] + 1 && each[2] == each[0] + 2;
              }));
              OK(rgl_graph_get_result_size(merge, fields[1], &count, &size));
              CHECK(count == 2 * runs);
            }});
  OK(rgl_cleanup());
}

TEST_CASE("RGL: a tape for which there is no memory fails at its end, and its calls do not") {
  quiet();
  RglSubject subject;
  const Folder folder;
  const std::string path = (folder / "tape").string();
  failEach("RGL: tape_record_begin", Fails::memory,
           {[&] { need(rgl_tape_record_begin(path.c_str())); }, [] { (void)rgl_tape_record_end(); },
            [&] { subject.check(); }});
  failEach("RGL: a call on a tape", Fails::memory,
           {[&] {
              if (rgl_tape_record_begin(path.c_str()) != RGL_SUCCESS) throw std::bad_alloc();
              constexpr float kNone = std::numeric_limits<float>::infinity();
              const rgl_status_t set = rgl_node_raytrace_configure_non_hits(subject.lidar().raytrace, kNone, kNone);
              const rgl_status_t ended = rgl_tape_record_end();
              if (set != RGL_SUCCESS) throw std::runtime_error("the tape makes a call fail");
              if (ended != RGL_SUCCESS) throw std::bad_alloc();
            },
            {},
            [&] { subject.check(); }});
  OK(rgl_tape_record_begin(path.c_str()));
  const rgl_mesh_t mesh = squareMesh();
  OK(rgl_mesh_destroy(mesh));
  OK(rgl_tape_record_end());
  failEach("RGL: tape_play", Fails::memory,
           {[&] {
              const rgl_status_t status = rgl_tape_play(path.c_str());
              if (status != RGL_SUCCESS) throw std::bad_alloc();
            },
            {},
            [&] { subject.check(); }});
}

}  // namespace gnosphere::test

// SPDX-License-Identifier: Apache-2.0
// A floor and a wall as a program in C makes them, and a simulator of them.
#pragma once

#include <gnosphere.h>

#include <catch2/catch_test_macros.hpp>
#include <vector>

#include "c/wall.hpp"

namespace gnosphere::test {

/// The corners of a floor of two triangles.
inline const float kFloor[] = {-20, -20, 0, 20, -20, 0, 20, 20, 0, -20, 20, 0};

inline gno_mesh squareMesh() {
  gno_mesh mesh = gno_mesh_init();
  mesh.name = "square";
  mesh.positions = kFloor;
  mesh.vertex_count = 4;
  mesh.indices = kSquare;
  mesh.triangle_count = 2;
  return mesh;
}

inline gno_scene makeScene() {
  gno_scene scene = nullptr;
  REQUIRE(gno_scene_create(&scene) == GNO_OK);
  const gno_material material = gno_material_init();
  const gno_mesh mesh = squareMesh();
  gno_instance floor = gno_instance_init(), wall = gno_instance_init();
  floor.class_id = 7;
  wall.transform = {{0, 0, 1, 8, 0, 1, 0, 0, -1, 0, 0, 0}};
  uint32_t index = 9;
  REQUIRE(gno_scene_add_material(scene, &material, &index) == GNO_OK);
  CHECK(index == 0);
  REQUIRE(gno_scene_add_mesh(scene, &mesh, nullptr) == GNO_OK);
  REQUIRE(gno_scene_add_instance(scene, &floor, nullptr) == GNO_OK);
  REQUIRE(gno_scene_add_instance(scene, &wall, &index) == GNO_OK);
  CHECK(index == 1);
  return scene;
}

inline gno_simulator makeSimulator(gno_scene scene, const char* effects, const std::vector<gno_field>& fields) {
  gno_sensor sensor = nullptr;
  REQUIRE(gno_sensor_builtin("VLP-16", &sensor) == GNO_OK);
  return simulatorOf(scene, sensor, effects, fields);
}

}  // namespace gnosphere::test

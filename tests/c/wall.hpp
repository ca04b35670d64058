// SPDX-License-Identifier: Apache-2.0
// Scenes of the C interface with a square, and simulators of scenes.
#pragma once

#include <gnosphere.h>

#include <catch2/catch_test_macros.hpp>
#include <vector>

namespace gnosphere::test {

inline const float kWall[] = {5, -20, -20, 5, 20, -20, 5, 20, 20, 5, -20, 20};
inline const uint32_t kSquare[] = {0, 1, 2, 0, 2, 3};

/// Returns a scene with a square as its only mesh, and without instances.
inline gno_scene sceneWithSquare(const float* corners) {
  gno_scene scene = nullptr;
  REQUIRE(gno_scene_create(&scene) == GNO_OK);
  const gno_material material = gno_material_init();
  gno_mesh mesh = gno_mesh_init();
  mesh.positions = corners;
  mesh.vertex_count = 4;
  mesh.indices = kSquare;
  mesh.triangle_count = 2;
  REQUIRE(gno_scene_add_material(scene, &material, nullptr) == GNO_OK);
  REQUIRE(gno_scene_add_mesh(scene, &mesh, nullptr) == GNO_OK);
  return scene;
}

inline gno_scene sceneWithWall() {
  return sceneWithSquare(kWall);
}

inline gno_options onReference() {
  gno_options options = gno_options_init();
  options.device = "reference";
  return options;
}

/// Makes a simulator for a sensor, and destroys the handle of the sensor.
inline gno_simulator simulatorOf(gno_scene scene, gno_sensor sensor, const char* effects,
                                 const std::vector<gno_field>& fields = {},
                                 const gno_options& options = onReference()) {
  gno_effects ofRequest = nullptr;
  REQUIRE(gno_effects_preset(effects, &ofRequest) == GNO_OK);
  gno_request request = gno_request_init();
  request.sensor = sensor;
  request.effects = ofRequest;
  request.fields = fields.data();
  request.field_count = fields.size();
  gno_simulator simulator = nullptr;
  REQUIRE(gno_simulator_create(scene, &request, 1, &options, &simulator) == GNO_OK);
  CHECK(gno_sensor_destroy(sensor) == GNO_OK);
  CHECK(gno_effects_destroy(ofRequest) == GNO_OK);
  return simulator;
}

}  // namespace gnosphere::test

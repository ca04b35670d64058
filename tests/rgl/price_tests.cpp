// SPDX-License-Identifier: Apache-2.0
// Compares the cost of RGL's interface with that of ours for the same rays, for the sensors of the paper's figure 7, in
// turns: GNOSPHERE_RGL_DEVICE=auto rgl_tests "[.price]".
#include <cstdio>
#include <gnosphere/gnosphere.hpp>

#include "price.hpp"
#include "rgl/plugin.hpp"
#include "town/town.hpp"

using namespace gnosphere;
using namespace gnosphere::test;

namespace {

void addToRgl(const gnosphere::Scene& scene) {
  std::vector<rgl_mesh_t> meshes;
  for (const gnosphere::Mesh& mesh : scene.meshes) {
    std::vector<rgl_vec3f> vertices(mesh.vertexCount());
    for (size_t v = 0; v < vertices.size(); ++v)
      vertices[v] = {{mesh.positions[3 * v] + static_cast<float>(mesh.origin.x),
                      mesh.positions[3 * v + 1] + static_cast<float>(mesh.origin.y),
                      mesh.positions[3 * v + 2] + static_cast<float>(mesh.origin.z)}};
    std::vector<rgl_vec3i> triangles(mesh.triangleCount());
    for (size_t t = 0; t < triangles.size(); ++t)
      for (int k = 0; k < 3; ++k) triangles[t].value[k] = static_cast<int32_t>(mesh.indices[3 * t + k]);
    meshes.push_back(nullptr);
    OK(rgl_mesh_create(&meshes.back(), vertices.data(), static_cast<int32_t>(vertices.size()), triangles.data(),
                       static_cast<int32_t>(triangles.size())));
  }
  for (const Instance& instance : scene.instances) {
    rgl_mat3x4f transform;
    for (int i = 0; i < 12; ++i) transform.value[i / 4][i % 4] = static_cast<float>(instance.transform.rows[i]);
    place(meshes[instance.mesh], transform);
  }
}

}  // namespace

TEST_CASE("RGL: the price of the interface", "[.price]") {
  const gnosphere::Scene scene = makeTown({1'000'000, 1, {}});
  addToRgl(scene);
  SimulatorOptions options;
  options.faces = ReflectingFaces::both;
  Simulator simulator(scene, std::vector<SensorRequest>(), options);
  const auto drive = makeDrive();
  for (const Sensor& sensor : builtinSensors()) {
    const BeamList beams = beamsOf(sensor);
    std::vector<rgl_mat3x4f> rays;
    for (const Vec3& d : beams.directions) {
      const double flat = std::hypot(d.x, d.y), c = d.x / flat, s = d.y / flat;
      const auto f = [](double v) { return static_cast<float>(v); };
      rays.push_back({{{f(-s), f(-c * d.z), f(d.x), 0}, {f(c), f(-s * d.z), f(d.y), 0}, {0, f(flat), f(d.z), 0}}});
    }
    Sensor list;
    list.rangeMax = sensor.rangeMax;
    list.patterns = {beams};
    for (size_t i = 0; i < rays.size(); ++i)  // the rays as RGL has them: in single precision
      list.patterns[0].directions[i] = {rays[i].value[0][2], rays[i].value[1][2], rays[i].value[2][2]};
    list.patterns[0].origins.clear();
    list.patterns[0].rangeMin.clear();
    list.patterns[0].rangeMax.clear();
    const size_t grid = simulator.addSensor({sensor, Effects::none()});
    const size_t asList = simulator.addSensor({list, Effects::none()});
    Lidar lidar(rays, {RGL_FIELD_XYZ_VEC3_F32, RGL_FIELD_DISTANCE_F32, RGL_FIELD_IS_HIT_I32});
    rgl_node_t range = nullptr, compact = nullptr;
    const rgl_vec2f limits = {{0, static_cast<float>(sensor.rangeMax)}};
    OK(rgl_node_rays_set_range(&range, &limits, 1));
    OK(rgl_graph_node_remove_child(lidar.rays, lidar.pose));
    OK(rgl_graph_node_add_child(lidar.rays, range));
    OK(rgl_graph_node_add_child(range, lidar.pose));
    OK(rgl_node_points_compact_by_field(&compact, RGL_FIELD_IS_HIT_I32));
    lidar.append(compact);

    Times ours, ourList, theirs;
    Scan scan;
    for (size_t frame = 0; frame < 12; ++frame) {
      const Pose& pose = drive[10 * frame];
      const double yaw = 2 * std::atan2(pose.orientation.z, pose.orientation.w);
      Shot shot;
      shot.pose = pose;
      std::vector<rgl_vec3f> points;
      Times warm;
      Times* const to[3] = {frame < 2 ? &warm : &ours, frame < 2 ? &warm : &ourList, frame < 2 ? &warm : &theirs};
      shot.sensor = grid;
      to[0]->add([&] { simulator.scanInto(shot, scan); });
      shot.sensor = asList;
      to[1]->add([&] { simulator.scanInto(shot, scan); });
      to[2]->add([&] {
        lidar.move(matrix(pose.position.x, pose.position.y, pose.position.z, yaw));
        lidar.run();
        points = lidar.get<rgl_vec3f>(RGL_FIELD_XYZ_VEC3_F32);
      });
      if (frame == 2)
        std::printf("%s: %zu rays, %zu points, ours %zu\n", sensor.name.c_str(), rays.size(), points.size(),
                    size_t(scan.counters.hits));
    }
    ours.print("Simulator, the sensor");
    ourList.print("Simulator, the same rays");
    theirs.print("RGL's interface");
    simulator.removeSensor(grid);
    simulator.removeSensor(asList);
    OK(rgl_graph_destroy(lidar.rays));
  }
  OK(rgl_cleanup());
}

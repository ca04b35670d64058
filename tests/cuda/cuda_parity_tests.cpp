// SPDX-License-Identifier: Apache-2.0
// The CUDA backend gives the same clouds as Vulkan. Its kernels run on the host, one invocation after another, and on a
// CUDA device if there is one. The hard cases check this, too, see requireRight().
#include <catch2/generators/catch_generators.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <cstdlib>
#include <filesystem>
#include <limits>

#include "cuda/twin.hpp"
#include "effects/street.hpp"
#include "gnosphere/error.hpp"

using namespace gnosphere;
using namespace gnosphere::test;
using Catch::Matchers::ContainsSubstring;

namespace {

Sensor unevenSensor() {
  Sensor sensor = gridSensor(301, 24, -30, 20, 90);
  for (size_t j = 0; j < sensor.channels.size(); j += 2) sensor.channels[j].azimuthOffsetDeg = 1.7 * double(j) - 9;
  return sensor;
}

const Pose kPoses[] = {kPose, {{-20, 3, 2.5}, {}}};

/// Checks that clouds have the same counts, except those that depend on the order of lists.
void requireSameCounts(const Counters& a, const Counters& b) {
  CHECK(a.hits == b.hits);
  CHECK(a.misses == b.misses);
  CHECK(a.triangles == b.triangles);
  CHECK(a.nonFinite == b.nonFinite);
  CHECK(a.degenerate == b.degenerate);
  CHECK(a.candidates == b.candidates);
}

Scan truthOf(const Scene& scene, const Sensor& sensor, const Pose& pose, TestOptions options) {
  options.device = DeviceChoice::Kind::reference;
  return scanOf(scene, sensor, pose, options);
}

/// Checks that Vulkan and CUDA on the host give the same clouds of both sensors from both poses.
void requireParity(const Scene& scene, TestOptions options) {
  const std::vector<Sensor> sensors = {gridSensor(360, 24, -25, 15, 100), unevenSensor()};
  Simulator vulkan = makeSimulator(scene, sensors, options);
  CudaOnHost onHost(scene, sensors, options);
  for (size_t sensor = 0; sensor < sensors.size(); ++sensor)
    for (const Pose& pose : kPoses) {
      INFO("sensor " << sensor << ", pose " << pose.position.x);
      const Scan expected = vulkan.scan(pose, sensor), scan = onHost.scan(pose, sensor);
      CHECK(expected.counters.hits > 1000);
      if (options.accuracy == Accuracy::exact) REQUIRE(sameBytes(expected, scan));
      requireSame(truthOf(scene, sensors[sensor], pose, options), scan);
      if (options.accuracy == Accuracy::exact) requireSameCounts(expected.counters, scan.counters);
    }
}

}  // namespace

TEST_CASE("cuda: a town has Vulkan's bytes with every binning and every accuracy except paper") {
  needVulkan();
  TestOptions options = vulkanOptions();
  options.accuracy = GENERATE(Accuracy::standard, Accuracy::exact);
  options.tuning.binning = GENERATE(Binning::nearest, Binning::lists, Binning::slabs);
  requireParity(smallTown(), options);
}

TEST_CASE("cuda: a town in two shells with one-sided triangles has Vulkan's bytes") {
  needVulkan();
  TestOptions options = vulkanOptions();
  options.accuracy = Accuracy::exact;
  options.tuning.culling.occlusion = Culling::Occlusion::always;
  options.faces = GENERATE(ReflectingFaces::front, ReflectingFaces::both);
  requireParity(bake(smallTown()), options);
}

TEST_CASE("cuda: lists that are too small grow without losing hits") {
  needVulkan();
  Scene scene = sceneOf(soup(3, 40'000, 20, 6));
  TestOptions options = vulkanOptions();
  options.tuning.culling.occlusion = Culling::Occlusion::never;  // so that the lists hold all triangles
  options.accuracy = Accuracy::exact;
  options.tuning.binning = GENERATE(Binning::nearest, Binning::lists, Binning::slabs);
  const Sensor sensor = gridSensor(360, 24, -40, 40);
  const Scan scan = CudaOnHost(scene, {sensor}, options).scan({});
  CHECK(scan.counters.retries > 0);
  CHECK(sameBytes(scan, scanOf(scene, sensor, {}, options)));
}

TEST_CASE("cuda: after instances and positions have changed, a scan equals Vulkan's after the same changes") {
  needVulkan();
  Random random(5);
  Scene scene;
  scene.materials = {material(true), material(false)};
  scene.meshes = {ball(12, 20, 2), soup(4, 700, 6, 1.5)};
  scene.meshes[1].parts = {{0, 300, 0}, {300, 400, 1}};
  const auto somewhere = [&] {  // some of them out of range
    const double far = random() > 0.5 ? 3000 : 30;
    return translation(far * random(), far * random(), 5 * random()) * rotationZ(3 * random());
  };
  for (uint32_t i = 0; i < 12; ++i) scene.instances.push_back({"", i % 2, somewhere()});
  const Sensor sensor = gridSensor(360, 24, -40, 40, 60);
  TestOptions options = vulkanOptions();
  options.accuracy = Accuracy::exact;
  Simulator vulkan = makeSimulator(scene, sensor, options);
  CudaOnHost onHost(scene, {sensor}, options);
  const auto requireEqual = [&] { REQUIRE(sameBytes(vulkan.scan({}), onHost.scan({}))); };
  requireEqual();
  for (size_t i = 0; i < 12; i += 2) {
    const Transform moved = somewhere() * scaling(1, i % 4 ? 1 : -1, 0.7);
    vulkan.setTransform(i, moved);
    onHost.backend().setInstance(i, static_cast<uint32_t>(i % 2), moved);
  }
  requireEqual();
  vulkan.removeInstance(3);
  onHost.backend().setInstance(3, kNoMesh, {});
  requireEqual();
  for (int i = 0; i < 20; ++i) {
    const Transform added = somewhere();
    const size_t index = vulkan.addInstance(1, added);
    onHost.backend().setInstance(index, 1, added);
  }
  requireEqual();
  std::vector<float> positions = scene.meshes[1].positions;
  for (float& value : positions) value += static_cast<float>(0.3 * random());
  positions[7] = std::numeric_limits<float>::quiet_NaN();
  vulkan.setPositions(1, positions);
  onHost.backend().setPositions(1, positions);
  requireEqual();
}

TEST_CASE("cuda: sensors without beams and scenes without triangles are scanned") {
  Sensor blind = gridSensor(360, 24, -40, 40);
  blind.channels.clear();
  const Scene scene = sceneOf(ball(6, 8, 2)), empty;
  CHECK(CudaOnHost(scene, {blind}, {}).scan({}).ranges.empty());
  const Scan scan = CudaOnHost(empty, {gridSensor(36, 4, -40, 40)}, {}).scan({});
  CHECK(scan.counters.misses == 144);
}

TEST_CASE("cuda: a missing device is an error with one line that gives the reason") {
  const Scene scene = sceneOf(ball(6, 8, 2));
  const Sensor sensor = gridSensor(36, 4, -40, 40);
  TestOptions options;
  options.device = deviceByName("cuda:99");
  const std::string problem = cudaProblem();
  const char* line = problem == "CUDA is not built in" ? "device 'cuda:99': CUDA is not built in; configure the build"
                     : problem.empty()                 ? "device 'cuda:99': the last CUDA device here is cuda:"
                                                       : "device 'cuda:99': there is no CUDA device here (";
  CHECK_THROWS_WITH(makeSimulator(scene, sensor, options), ContainsSubstring(line));
}

TEST_CASE("cuda: a CUDA device gives Vulkan's bytes, and with fused products it differs only by rounding") {
  needCuda();
  const Sensor sensor = unevenSensor();
  TestOptions options = vulkanOptions();
  options.accuracy = Accuracy::exact;
  options.tuning.binning = GENERATE(Binning::nearest, Binning::lists, Binning::slabs);
  const Scan decided = CudaOnHost(smallTown(), {sensor}, options).scan(kPoses[0]);
  options.device = deviceByName("cuda:0");
  const Scan scan = scanOf(smallTown(), sensor, kPoses[0], options);
  CHECK(sameBytes(decided, scan));
  CHECK(scan.timings.gpuMs > 0);
  options.accuracy = Accuracy::standard;
  const Scan reference = truthOf(smallTown(), sensor, kPoses[0], options);
  requireSame(reference, scanOf(smallTown(), sensor, kPoses[0], options));
  options.device = deviceByName("cuda-fast:0");
  requireSame(reference, scanOf(smallTown(), sensor, kPoses[0], options));
}

// The test takes minutes with a folder of real scenes.
TEST_CASE("cuda: every scene of the folder GNOSPHERE_SCENES has Vulkan's bytes") {
  const char* folder = std::getenv("GNOSPHERE_SCENES");
  if (folder == nullptr) SKIP("GNOSPHERE_SCENES names no folder of scenes");
  needVulkan();
  TestOptions options = vulkanOptions();
  options.accuracy = Accuracy::exact;
  const Sensor sensor = gridSensor(360, 32, -40, 25, 200);
  size_t scenes = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    const std::string ending = entry.path().extension().string();
    if (ending != ".glb" && ending != ".gltf" && ending != ".obj" && ending != ".ply" && ending != ".stl") continue;
    Scene scene;
    try {
      scene = loadScene(entry.path());
    } catch (const Error&) {
      continue;
    }
    const Bounds bounds = worldBounds(scene);
    if (bounds.empty() || scene.placedTriangleCount() > 300'000) continue;
    INFO(entry.path().string());
    const auto middle = [](double low, double high) { return (low + high) / 2; };
    const Pose pose = {{middle(bounds.min.x, bounds.max.x), middle(bounds.min.y, bounds.max.y),
                        bounds.min.z + 0.3 * (bounds.max.z - bounds.min.z)},
                       {0.02, 0.01, 0.3, 0.95}};
    Simulator vulkan = makeSimulator(scene, sensor, options);
    CudaOnHost onHost(scene, {sensor}, options);
    CHECK(sameBytes(vulkan.scan(pose), onHost.scan(pose, 0)));
    ++scenes;
  }
  WARN(scenes << " scenes");
  CHECK(scenes > 0);
}

// SPDX-License-Identifier: Apache-2.0
// Meshes whose vertices follow joints and morph targets.
#include <algorithm>
#include <catch2/generators/catch_generators.hpp>
#include <catch2/matchers/catch_matchers_exception.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <limits>

#include "cuda/twin.hpp"
#include "deformable.hpp"
#include "geometry/deformables.hpp"
#include "lists/list_sensors.hpp"

using namespace gnosphere;
using namespace gnosphere::test;

namespace {

Sensor head() {
  return gridSensor(360, 24, -30, 30, 60);
}

Sensor turningHead() {
  Sensor sensor = head();
  sensor.rotationPeriod = 0.1;
  return sensor;
}

/// Channels from the highest to the lowest, each with a laser elsewhere: a beam's number is not its place by elevation.
Sensor steppedHead() {
  Sensor sensor = turningHead();
  std::reverse(sensor.channels.begin(), sensor.channels.end());
  for (size_t i = 0; i < sensor.channels.size(); ++i) sensor.channels[i].origin = {0.04 * double(i), 0, 0};
  return sensor;
}

/// Sees only parts of most clusters of limbs(): few rows, and a range that ends within them.
Sensor narrowHead() {
  return gridSensor(720, 6, -2, 2, 5.9);
}

/// Memory that forgets what is written.
struct NoMemory : SceneMemory {
  void prepareWrite(gpu::Array, uint64_t, uint64_t) override {}
  void reserve(gpu::Array, uint64_t) override {}
  void write(gpu::Array, uint64_t, std::span<const std::byte>) override {}
  void read(gpu::Array, uint64_t, std::span<std::byte>) const override {}
};

}  // namespace

TEST_CASE("deformed vertices lie where the formulas of glTF put them", "[deform]") {
  for (const uint32_t influences : {0u, 1u, 4u, 9u}) {
    Random random(17 + influences);
    const Mesh mesh = limb(random, 7, influences, influences == 4 ? 0 : 2, {1e4, -2e4, 30});
    for (int k = 0; k < 5; ++k) {
      const Deformation deformation = bend(random, mesh);
      const std::vector<float> positions = deformedPositions(mesh, deformation);
      const std::vector<Vec3> expected = expectedPositions(mesh, deformation);
      REQUIRE(positions.size() == 3 * expected.size());
      double worst = 0;
      for (size_t v = 0; v < expected.size(); ++v)
        worst = std::max({worst, std::abs(mesh.origin.x + positions[3 * v] - expected[v].x),
                          std::abs(mesh.origin.y + positions[3 * v + 1] - expected[v].y),
                          std::abs(mesh.origin.z + positions[3 * v + 2] - expected[v].z)});
      INFO(influences << " influences: " << worst << " m");
      REQUIRE(worst < 3e-6);  // the mesh is 4 m long
    }
    REQUIRE(deformedPositions(mesh, {}) == mesh.positions);
  }
}

TEST_CASE("deformed meshes are scanned where they are", "[deform][gpu]") {
  needVulkan();
  for (const Accuracy accuracy : {Accuracy::standard, Accuracy::exact}) {
    Random random(5);
    Scene scene = limbs(random, 6);
    TestOptions options = vulkanOptions(), reference;
    options.accuracy = reference.accuracy = accuracy;
    reference.device = DeviceChoice::Kind::reference;
    const std::vector<Sensor> heads = {head(), narrowHead()};
    Simulator device = makeSimulator(scene, heads, options), truth = makeSimulator(scene, heads, reference);
    for (int frame = 0; frame < 4; ++frame) {
      INFO("accuracy " << nameOf(accuracy) << ", frame " << frame);
      const Pose pose = {{0.3 * frame, 0.1, 0.2}, {}};
      const Scan scan = device.scan(pose), expected = truth.scan(pose);
      requireSame(expected, scan);
      REQUIRE(scan.counters.hits > 500);
      requireSame(truth.scan(pose, 1), device.scan(pose, 1));
      for (size_t mesh = 1; mesh < scene.meshes.size(); ++mesh) {
        if (frame == 2 && mesh == 3) continue;
        scene.meshes[mesh].deformation = frame == 1 && mesh == 4 ? Deformation() : bend(random, scene.meshes[mesh]);
        device.setDeformation(mesh, scene.meshes[mesh].deformation);
        truth.setDeformation(mesh, scene.meshes[mesh].deformation);
      }
    }
  }
}

TEST_CASE("every binning and the surface of each hit follow a deformation", "[deform][gpu]") {
  needVulkan();
  Random random(9);
  Scene scene = limbs(random, 4);
  std::vector<Deformation> next;
  for (size_t mesh = 1; mesh < scene.meshes.size(); ++mesh) next.push_back(bend(random, scene.meshes[mesh]));
  TestOptions options = vulkanOptions(), reference;
  options.fields = reference.fields = {Field::normal, Field::barycentrics};
  reference.device = DeviceChoice::Kind::reference;
  Simulator truth = makeSimulator(scene, head(), reference);
  for (size_t i = 0; i < next.size(); ++i) truth.setDeformation(i + 1, next[i]);
  const Scan expected = truth.scan({});
  for (const Binning binning : {Binning::lists, Binning::nearest, Binning::slabs}) {
    options.tuning.binning = binning;
    Simulator device = makeSimulator(scene, head(), options);
    device.scan({});
    for (size_t i = 0; i < next.size(); ++i) device.setDeformation(i + 1, next[i]);
    const Scan scan = device.scan({});
    requireSame(expected, scan);
    const auto ties = expected.column<uint8_t>(Field::tie);
    float worst = 0;
    for (uint32_t axis = 0; axis < 3; ++axis) {
      const auto normals = scan.column<float>(Field::normal, axis), right = expected.column<float>(Field::normal, axis);
      for (size_t beam = 0; beam < scan.beamCount(); ++beam)
        if (expected.hit(beam) && !ties[beam]) worst = std::max(worst, std::abs(normals[beam] - right[beam]));
    }
    REQUIRE(worst < 1e-3f);
  }
}

TEST_CASE("shots during which a mesh bends in another way have the bytes of single scans", "[deform][gpu]") {
  needVulkan();
  Random random(35);
  const Scene scene = limbs(random, 6);
  TestOptions options = vulkanOptions();
  options.effects.objectMotion.use = EffectUse::on;
  std::vector<Shot> shots(4);
  for (size_t i = 0; i < shots.size(); ++i) {
    shots[i].instanceMotions = {{2, translation(0, 0.2, 0) * scene.instances[2].transform}};
    if (i > 1) shots[i].meshMotions = {{1, bend(random, scene.meshes[1])}};
  }
  Simulator together = makeSimulator(scene, turningHead(), options);
  Simulator single = makeSimulator(scene, turningHead(), options);
  together.scanAll(shots, [&](size_t i, const Scan& scan) {
    INFO("shot " << i);
    Scan alone;
    single.scanInto(shots[i], alone);
    CHECK(alone.counters.hits > 0);
    CHECK(sameBytes(scan, alone));
  });
}

// At the start of the scan the plate is a speck out of range, which its own motion would hardly move. When the column
// ahead fires, the plate has half its size at the end, and has come half the way.
TEST_CASE("a mesh that bends into the range while its instance grows is seen where it is", "[deform][gpu]") {
  needVulkan();
  MeshBuilder plate;
  plate.quad({0, -0.5, -0.5}, {0, 1, 0}, {0, 0, 1});
  Scene scene = sceneOf(plate.take());
  for (size_t vertex = 0; vertex < scene.meshes[0].vertexCount(); ++vertex) {
    scene.meshes[0].morphTargets.resize(1);
    scene.meshes[0].morphTargets[0].insert(scene.meshes[0].morphTargets[0].end(), {-6, 0, 0});
  }
  const Transform place = translation(8, 0, 0);
  scene.instances[0].transform = place * scaling(0.01, 0.01, 0.01);
  TestOptions options = vulkanOptions();
  options.effects.objectMotion.use = EffectUse::on;
  Sensor sensor = gridSensor(360, 3, -1, 1, 6.5);
  sensor.rotationPeriod = 0.1;
  Shot shot;
  shot.instanceMotions = {{0, place}};
  shot.meshMotions = {{0, {{}, {1}}}};
  Scan scan;
  makeSimulator(scene, sensor, options).scanInto(shot, scan);
  CHECK(scan.counters.hits > 3);
  for (size_t beam = 0; beam < scan.beamCount(); ++beam) {
    const double share = static_cast<double>(beam % sensor.columns) / sensor.columns;
    if (scan.hit(beam)) CHECK(std::abs(scan.points[3 * beam] - (8 - 6 * share)) < 1e-3);
  }
}

TEST_CASE("a mesh that a deformation has reduced to a line is seen when it grows within the scan", "[deform][gpu]") {
  needVulkan();
  MeshBuilder plate;
  plate.quad({8, -0.5, -0.5}, {0, 1, 0}, {0, 0, 1});
  Scene scene = sceneOf(plate.take());
  Mesh& mesh = scene.meshes[0];
  mesh.morphTargets.resize(1);
  for (size_t vertex = 0; vertex < mesh.vertexCount(); ++vertex)
    mesh.morphTargets[0].insert(mesh.morphTargets[0].end(), {0, 0, -mesh.positions[3 * vertex + 2]});
  mesh.deformation = {{}, {1}};
  TestOptions options = vulkanOptions();
  options.effects.objectMotion.use = EffectUse::on;
  Sensor sensor = gridSensor(360, 3, -1, 1);
  sensor.rotationPeriod = 0.1;
  Simulator simulator = makeSimulator(scene, sensor, options);
  CHECK(simulator.scan({}).counters.hits == 0);
  Shot shot;
  shot.meshMotions = {{0, {{}, {0}}}};
  Scan scan;
  simulator.scanInto(shot, scan);
  CHECK(scan.counters.hits > 10);
}

TEST_CASE("vertices move on straight lines to the deformation at the end of a scan", "[deform][gpu]") {
  needVulkan();
  Random random(33);
  Scene scene = limbs(random, 6);
  scene.materials[0].doubleSided = false;
  TestOptions options = vulkanOptions(), reference;
  options.effects.objectMotion.use = EffectUse::on;
  options.effects.sensorMotion.use = EffectUse::on;
  options.fields = {Field::velocity, Field::normal};
  reference.effects = options.effects;
  reference.fields = options.fields;
  reference.device = DeviceChoice::Kind::reference;
  Sensor sensor = steppedHead();
  if (GENERATE(false, true)) {
    sensor = asList(sensor);
    for (size_t i = 0; i < sensor.beamCount(); ++i)  // from three places, of which each is a view
      sensor.patterns[0].origins[i].y += 0.8 * static_cast<double>(i % 3) - 0.8;
  }
  Simulator device = makeSimulator(scene, sensor, options), truth = makeSimulator(scene, sensor, reference);
  CudaOnHost onHost(scene, {sensor}, options);
  for (int turn = 0; turn < 3; ++turn) {
    INFO("turn " << turn);
    Shot shot;
    for (size_t mesh = 1; mesh < scene.meshes.size(); ++mesh)
      if (mesh != 3) shot.meshMotions.push_back({mesh, mesh == 5 ? Deformation() : bend(random, scene.meshes[mesh])});
    if (turn > 0)
      for (const size_t instance : {2u, 3u, 4u})
        shot.instanceMotions.push_back({instance, scene.instances[instance].transform * randomTurn(random, 0.05, 0.5)});
    if (turn > 1) shot.motion.stamps = {{0, {}}, {0.1, {{1, 0.5, 0}, {0, 0, 0.1, 1}}}};
    Scan scan, expected, twin;
    device.scanInto(shot, scan);
    truth.scanInto(shot, expected);
    requireSame(expected, scan);
    const auto ties = expected.column<uint8_t>(Field::tie);
    float worst = 0, fastest = 0;
    for (uint32_t axis = 0; axis < 3; ++axis) {
      const auto speeds = scan.column<float>(Field::velocity, axis),
                 right = expected.column<float>(Field::velocity, axis);
      for (size_t beam = 0; beam < scan.beamCount(); ++beam)
        if (expected.hit(beam) && !ties[beam]) {
          worst = std::max(worst, std::abs(speeds[beam] - right[beam]));
          fastest = std::max(fastest, std::abs(right[beam]));
        }
    }
    REQUIRE(fastest > 3);
    REQUIRE(worst < 2e-3f);
    if (!dividesExactly(device.device())) continue;
    onHost.scanInto(shot, twin);
    REQUIRE(sameBytes(scan, twin));
  }
}

TEST_CASE("a rolling shutter sees a deformed mesh where it is when the beam fires", "[deform][gpu]") {
  needVulkan();
  // A plate ahead of the sensor whose only joint brings it 2 m nearer during the turn, so that beam i finds it at
  // x = 6 - 20 t with t = i / columns * 0.1 s.
  MeshBuilder builder;
  builder.quad({6, -8, -8}, {0, 16, 0}, {0, 0, 16}, 8);
  Scene scene = sceneOf(builder.take());
  Mesh& mesh = scene.meshes[0];
  mesh.jointCount = mesh.influences = 1;
  mesh.joints.assign(mesh.vertexCount(), 0);
  mesh.jointWeights.assign(mesh.vertexCount(), 1);
  const Sensor sensor = turningHead();
  TestOptions options = vulkanOptions();
  options.effects.objectMotion.use = EffectUse::on;
  options.fields = {Field::time, Field::velocity};
  Simulator device = makeSimulator(scene, sensor, options);
  Shot shot;
  shot.meshMotions = {{0, {{translation(-20 * sensor.rotationPeriod, 0, 0)}, {}}}};
  Scan scan;
  device.scanInto(shot, scan);
  const auto times = scan.column<float>(Field::time), along = scan.column<float>(Field::velocity, 0);
  size_t hits = 0;
  for (size_t beam = 0; beam < scan.beamCount(); ++beam) {
    if (!scan.hit(beam)) continue;
    ++hits;
    REQUIRE(std::abs(scan.points[3 * beam] - (6 - 20 * times[beam])) < 1e-4);
    REQUIRE(std::abs(along[beam] + 20) < 1e-3);
  }
  REQUIRE(hits > 1000);
}

TEST_CASE("the speed of a narrow strip that deforms is that of the point that the beam meets", "[deform][gpu]") {
  needVulkan();
  constexpr double kSeconds = 0.1;
  for (const float width : {0.1f, 0.003f, 0.001f}) {
    // A strip of 10 m across the line of sight, 10 m ahead, that a morph target turns: x grows by y / 20 in 0.1 s.
    Mesh strip;
    strip.positions = {10, -5, 0, 10, 5, 0, 10, -5, width, 10, 5, width};
    strip.indices = {0, 1, 3, 0, 3, 2};
    strip.parts = {{0, 2, 0}};
    strip.morphTargets = {{-0.25f, 0, 0, 0.25f, 0, 0, -0.25f, 0, 0, 0.25f, 0, 0}};
    BeamList beams;
    Random random(3);
    for (int i = 0; i < 400; ++i) beams.directions.push_back(unit({10, 4.9 * random(), 0.4 * width}));
    beams.times.assign(400, 0);
    beams.times.back() = kSeconds;
    TestOptions options = vulkanOptions();
    options.effects.objectMotion.use = EffectUse::on;
    options.fields = {Field::velocity};
    Simulator device = makeSimulator(sceneOf(std::move(strip)), listSensor("aimed", beams), options);
    device.setDeformation(0, {{}, {0}});
    Shot shot;
    shot.meshMotions = {{0, {{}, {1}}}};
    Scan scan;
    device.scanInto(shot, scan);
    const auto along = scan.column<float>(Field::velocity);
    size_t hits = 0;
    double worst = 0;
    for (size_t beam = 0; beam + 1 < scan.beamCount(); ++beam) {
      if (!scan.hit(beam)) continue;
      ++hits;
      worst = std::max(worst, std::abs(along[beam] - 0.05 / kSeconds * scan.points[3 * beam + 1]));
    }
    INFO("width " << width << ": " << worst << " m/s");
    CHECK(hits > 390);
    CHECK(worst < 1e-5 + 5 * 0x1p-24 * 4 * 20 / width);
  }
}

TEST_CASE("deformable meshes come and go", "[deform][gpu]") {
  needVulkan();
  Random random(21);
  Scene scene = limbs(random, 3);
  const TestOptions options = vulkanOptions();
  const auto fresh = [&] { return makeSimulator(scene, head(), options).scan({}); };
  Scene rigid = scene;
  rigid.meshes.resize(1);
  rigid.instances.resize(1);
  Simulator device = makeSimulator(rigid, head(), options);
  device.scan({});
  for (size_t i = 1; i < scene.meshes.size(); ++i) {
    const size_t mesh = device.addMesh(scene.meshes[i]);
    device.addInstance(static_cast<uint32_t>(mesh), scene.instances[i].transform);
  }
  REQUIRE(sameBytes(device.scan({}), fresh()));
  device.removeInstance(2);
  device.removeMesh(2);
  scene.meshes[2] = limb(random, 9, 2, 0);
  scene.meshes[2].deformation = bend(random, scene.meshes[2]);
  device.addInstance(static_cast<uint32_t>(device.addMesh(scene.meshes[2])), scene.instances[2].transform);
  scene.meshes[3].deformation = bend(random, scene.meshes[3]);
  device.setDeformation(3, scene.meshes[3].deformation);
  REQUIRE(sameBytes(device.scan({}), fresh()));
}

TEST_CASE("a deformable mesh whose arrays do not fit is refused, and the scans go on", "[deform][gpu]") {
  needVulkan();
  Random random(31);
  Scene scene = limbs(random, 2);
  TestOptions options = vulkanOptions();
  options.tuning.maxBufferBytes = 1 << 20;
  Simulator device = makeSimulator(scene, head(), options);
  const Scan before = device.scan({});
  // The positions of this mesh fit into arrays of 1 MiB, and the offsets of its morph targets do not.
  const Mesh large = limb(random, 5, 4, 400);
  CHECK_THROWS_AS(device.addMesh(large), Error);
  REQUIRE(sameBytes(device.scan({}), before));

  const size_t free = device.addMesh(limb(random, 5, 4, 1));
  device.removeMesh(free);
  CHECK_THROWS_AS(device.addMesh(large), Error);
  REQUIRE(sameBytes(device.scan({}), before));

  scene.meshes.push_back(limb(random, 8, 4, 1));
  scene.meshes.back().deformation = bend(random, scene.meshes.back());
  scene.instances.push_back({"", 1, translation(0, 0, 9)});
  scene.instances.back().mesh = static_cast<uint32_t>(device.addMesh(scene.meshes.back()));
  REQUIRE(scene.instances.back().mesh == free);
  device.addInstance(static_cast<uint32_t>(free), scene.instances.back().transform);
  REQUIRE(sameBytes(device.scan({}), makeSimulator(scene, head(), options).scan({})));
}

TEST_CASE("CUDA's kernels deform meshes in the same bytes", "[deform][gpu]") {
  needVulkan();
  Random random(11);
  Scene scene = limbs(random, 5);
  TestOptions options = vulkanOptions();
  options.accuracy = Accuracy::exact;
  Simulator vulkan = makeSimulator(scene, head(), options);
  CudaOnHost onHost(scene, {head()}, options);
  for (size_t mesh = 1; mesh < scene.meshes.size(); ++mesh) {
    const Deformation deformation = bend(random, scene.meshes[mesh]);
    vulkan.setDeformation(mesh, deformation);
    onHost.backend().setDeformation(mesh, deformation);
  }
  REQUIRE(sameBytes(vulkan.scan({}), onHost.scan({})));
}

TEST_CASE("the boxes of groups enclose deformed vertices", "[deform]") {
  Random random(2);
  NoMemory memory;
  for (const uint32_t influences : {0u, 1u, 4u}) {
    const Mesh mesh = limb(random, 6, influences, influences == 4 ? 0 : 2);
    FlatMesh flat = flatten(mesh, {material(true)});
    Deformables deformables(memory);
    deformables.setMeshCount(1);
    deformables.add(0, mesh, flat, 0, 0);
    for (int k = 0; k < 20; ++k) {
      const Deformation deformation = bend(random, mesh);
      deformables.deform(0, deformation, flat);
      const std::vector<Vec3> vertices = expectedPositions(mesh, deformation);
      for (size_t g = 0; g < flat.groupCount(); ++g) {
        const FlatGroup& group = flat.groups[g];
        const size_t first = flat.clusters[group.firstCluster].firstVertex,
                     end = flat.clusters[group.firstCluster + group.clusterCount].firstVertex;
        for (size_t i = first; i < end; ++i) {
          const Vec3& p = vertices[flat.vertices[i]];
          const double values[] = {p.x, p.y, p.z};
          for (size_t axis = 0; axis < 3; ++axis) {
            REQUIRE(double{group.low[axis]} < values[axis]);
            REQUIRE(values[axis] < double{group.high[axis]});
          }
        }
        REQUIRE(group.high[0] - group.low[0] < 6);  // the limb is 4 m long
      }
    }
  }
}

TEST_CASE("a deformation that does not fit its mesh is refused", "[deform]") {
  using Catch::Matchers::ContainsSubstring;
  using Catch::Matchers::MessageMatches;
  Random random(3);
  Scene scene = limbs(random, 1);
  const Mesh good = scene.meshes[1];
  TestOptions options;
  options.device = DeviceChoice::Kind::reference;
  const auto refused = [&](const Scene& given, const char* words) {
    REQUIRE_THROWS_MATCHES(makeSimulator(given, head(), options), Error, MessageMatches(ContainsSubstring(words)));
  };
  const auto with = [&](auto change) {
    Scene changed = scene;
    change(changed.meshes[1]);
    return changed;
  };
  refused(with([](Mesh& mesh) { mesh.joints[5] = 99; }), "a vertex follows joint 99, the mesh has");
  refused(with([](Mesh& mesh) { mesh.jointWeights[0] += 0.5f; }), "sum to 1.5");
  refused(with([](Mesh& mesh) { mesh.jointWeights[0] = -1; }), "is negative or NaN");
  refused(with([](Mesh& mesh) { mesh.joints.pop_back(); }), "joints and weights, there are");
  refused(with([](Mesh& mesh) { mesh.influences = 0; }), "both must be 0 or both more");
  refused(with([](Mesh& mesh) { mesh.influences = 17; }), "17 influences per vertex; the limit is 16");
  refused(with([](Mesh& mesh) { mesh.morphTargets[0].pop_back(); }), "morph target 0 has");
  refused(with([](Mesh& mesh) { mesh.deformation.joints.resize(2); }), "its deformation has 2 joints");
  Simulator simulator = makeSimulator(scene, head(), options);
  Deformation deformation = bend(random, good);
  deformation.joints[1].rows[3] = std::numeric_limits<double>::infinity();
  REQUIRE_THROWS_MATCHES(simulator.setDeformation(1, deformation), Error,
                         MessageMatches(ContainsSubstring("mesh 1: the map of joint 1 is not finite")));
  REQUIRE_THROWS_MATCHES(simulator.setDeformation(0, {}), Error,
                         MessageMatches(ContainsSubstring("mesh 0 has neither joints nor morph targets")));
  REQUIRE_THROWS_MATCHES(simulator.setPositions(1, good.positions), Error,
                         MessageMatches(ContainsSubstring("its deformation moves it")));
}

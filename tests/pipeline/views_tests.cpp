// SPDX-License-Identifier: Apache-2.0
// Shots from different poses that are submitted together, as views, give the same results as single scans.
#include "deformable.hpp"
#include "support.hpp"

namespace gnosphere::test {
namespace {

// Shots from everywhere in a scene, some from out of its reach, so that views see different instances.
std::vector<Shot> shotsFromEverywhere(size_t count) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(-40, 40), turn(-3, 3);
  std::vector<Shot> shots(count);
  for (size_t i = 0; i < count; ++i) {
    const double yaw = turn(random);
    shots[i].pose = {{place(random), place(random), 0.1 * place(random)}, {0, 0, std::sin(yaw / 2), std::cos(yaw / 2)}};
    if (i % 7 == 3) shots[i].pose.position.x = 5000;
    shots[i].frame = i;
  }
  return shots;
}

// Many instances of a mesh, one of them mirrored.
Scene crowd(uint32_t trianglesPerMesh, uint32_t instances) {
  Scene scene = sceneOf(soup(3, trianglesPerMesh, 12, 3));
  std::mt19937 random(5);
  std::uniform_real_distribution<double> place(-60, 60);
  for (uint32_t i = 1; i < instances; ++i)
    scene.instances.push_back({"", 0, translation(place(random), place(random), place(random) / 10)});
  scene.instances[1].transform.rows[0] = -1;
  return scene;
}

// Scans the shots of a sensor together, and then one by one.
void checkViews(Simulator& simulator, std::span<const Shot> shots) {
  std::vector<Scan> together(shots.size());
  simulator.scanAll(shots, [&](size_t i, const Scan& scan) { together[i] = scan; });
  uint64_t different = 0, hits = 0, projected = 0;
  Counters sum;
  Scan alone;
  for (size_t i = 0; i < shots.size(); ++i) {
    simulator.scanInto(shots[i], alone);
    const Counters& counters = together[i].counters;
    different += !sameBytes(together[i], alone) || counters.hits != alone.counters.hits ||
                 counters.misses != alone.counters.misses;
    hits += counters.hits;
    projected += counters.projected;
    sum.culledByCluster += counters.culledByCluster;
    sum.triangles += counters.triangles;
  }
  CHECK(different == 0);
  CHECK(hits > 1000);
  // Every triangle of every view is counted once.
  CHECK(sum.culledByCluster <= sum.triangles);
  CHECK(projected > 0);
}

}  // namespace

TEST_CASE("views give the bytes of single scans, for every kind of grid, list and binning",
          "[second-driver][driver-combinations][combinations]") {
  needVulkan();
  const Scene scene = crowd(120, 40);
  Sensor offsets = gridSensor(90, 16, -30, 30);
  for (size_t j = 0; j < offsets.channels.size(); ++j) offsets.channels[j].azimuthOffsetDeg = 0.3 * double(j % 5);
  Sensor list = gridSensor(0, 0, 0, 0);
  list.patterns = {beamsOf(gridSensor(61, 13, -40, 35))};
  for (Vec3& d : list.patterns[0].directions) {  // no two beams lie in a row or column
    const double tilt = 0.01 * std::sin(50 * d.x + 31 * d.y), length = std::sqrt(1 + tilt * tilt + 2 * tilt * d.z);
    d = {d.x / length, d.y / length, (d.z + tilt) / length};
  }
  const Sensor grid = gridSensor(180, 16, -30, 30);
  std::vector<Shot> shots = shotsFromEverywhere(everyCombination() ? 24 : 12);
  const bool fewer = fewerCombinations(makeSimulator(scene, grid, vulkanOptions()).device());
  for (const Binning binning : {Binning::slabs, Binning::nearest})
    for (const Accuracy accuracy : {Accuracy::standard, Accuracy::exact}) {
      if (fewer && (binning == Binning::slabs) != (accuracy == Accuracy::standard)) continue;
      TestOptions options = vulkanOptions();
      options.tuning.binning = binning;
      options.accuracy = accuracy;
      std::vector<Sensor> sensors = {offsets};
      if (accuracy == Accuracy::standard) {
        sensors = {grid};
        if (!fewer) sensors.push_back(list);
        options.tuning.culling.occlusion = Culling::Occlusion::always;  // several shells
      }
      Simulator simulator = makeSimulator(scene, sensors, options);
      for (size_t sensor = 0; sensor < sensors.size(); ++sensor) {
        INFO(nameOf(accuracy) << ", sensor " << sensor << ", binning " << int(binning));
        for (Shot& shot : shots) shot.sensor = sensor;
        checkViews(simulator, shots);
      }
    }
}

TEST_CASE("views see deformed meshes, and instances that move between runs") {
  needVulkan();
  const std::vector<Shot> shots = shotsFromEverywhere(12);
  const Sensor sensor = gridSensor(120, 16, -30, 30);
  Scene scene = crowd(900, 30);
  Random random(2);
  scene.meshes.push_back(limb(random, 4, 2, 1));
  scene.instances.push_back({"", 1, translation(3, 2, 0)});
  const Deformation bent = bend(random, scene.meshes[1]);
  Simulator together = makeSimulator(scene, sensor, vulkanOptions());
  together.setDeformation(1, bent);
  for (int run = 0; run < 3; ++run) {
    const Transform moved = translation(run, 2, 0.5);
    together.setTransform(4, moved);
    Scene expected = scene;
    expected.instances[4].transform = moved;
    Simulator single = makeSimulator(expected, sensor, vulkanOptions());
    single.setDeformation(1, bent);
    // A single scan in between has numbers of instances of its own.
    CHECK(sameBytes(together.scan(shots[0].pose), single.scan(shots[0].pose)));
    uint64_t different = 0, unequal = 0;
    together.scanAll(shots, [&](size_t i, const Scan& scan) {
      different += !sameBytes(scan, single.scan(shots[i].pose));
      // Each view has its share of the counts, and each triangle has one fate.
      const Counters& c = scan.counters;
      unequal += c.triangles - c.nonFinite - c.degenerate - c.culledByCluster !=
                 c.culledByRange + c.culledByFace + c.culledBetweenBeams + c.culledHidden + c.projected;
    });
    CHECK(different == 0);
    CHECK(unequal == 0);
  }
}

TEST_CASE("no view counts more triangles than its world has, and each triangle has one fate") {
  needVulkan();
  Scene scene = crowd(300, 10);
  for (Instance& instance : scene.instances) instance.world = 1;
  scene.meshes.push_back(soup(8, 7, 12, 3));
  scene.instances.push_back({"", 1, {}});
  scene.instances.back().world = 2;
  TestOptions options = vulkanOptions();
  Simulator culling = makeSimulator(scene, gridSensor(180, 16, -30, 30), options);
  options.tuning.culling = {false, false, false, false, Culling::Occlusion::never};
  Simulator reading = makeSimulator(scene, gridSensor(180, 16, -30, 30), options);
  for (const uint32_t worlds : {1, 2}) {
    std::vector<Shot> shots = shotsFromEverywhere(13);
    for (size_t i = 0; i < shots.size(); ++i) shots[i].world = 1 + static_cast<uint32_t>(i) % worlds;
    for (Simulator* simulator : {&culling, &reading}) {
      INFO(worlds << " worlds" << (simulator == &reading ? ", all triangles are read" : ""));
      simulator->scanAll(shots, [&](size_t i, const Scan& scan) {
        INFO("shot " << i);
        const Counters& c = scan.counters;
        CHECK(c.triangles == (shots[i].world == 1 ? 3000 : 7));
        CHECK(c.culledByCluster <= c.triangles);
        CHECK(c.triangles == c.culledByCluster + c.culledByRange + c.culledByFace + c.culledBetweenBeams +
                                 c.culledHidden + c.projected);
      });
    }
  }
}

TEST_CASE("without memory for several views, shots are scanned one by one") {
  needVulkan();
  const Scene scene = crowd(900, 30);
  const Sensor sensor = gridSensor(180, 16, -30, 30);
  const std::vector<Shot> shots = shotsFromEverywhere(40);
  Simulator free = makeSimulator(scene, sensor, vulkanOptions());
  std::vector<Scan> expected;
  for (const Shot& shot : shots) expected.push_back(free.scan(shot.pose));
  for (const uint64_t limit : {256 * 1024, 400 * 1024, 700 * 1024}) {
    TestOptions options = vulkanOptions();
    options.tuning.maxBufferBytes = limit;
    Simulator capped = makeSimulator(scene, sensor, options);
    size_t received = 0, different = 0;
    capped.scanAll(shots, [&](size_t i, const Scan& scan) {
      CHECK(i == received++);
      different += !sameBytes(scan, expected[i]);
    });
    INFO(limit);
    CHECK(received == shots.size());
    CHECK(different == 0);
  }
}

}  // namespace gnosphere::test

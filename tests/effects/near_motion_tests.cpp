// SPDX-License-Identifier: Apache-2.0
// Things that move beside a sensor, or past it at almost no distance.
#include <ctime>

#include "effects/scan_support.hpp"
#include "lists/list_sensors.hpp"

namespace gnosphere::test {
namespace {

constexpr uint32_t kThing = 1;  // the instance that is near

/// Walls far away, and a thing of 800 triangles in the middle.
Scene nearScene() {
  MeshBuilder walls;
  walls.box({-20, -30, -15}, {20, 30, 15}, 4);
  Scene scene = sceneOf(walls.take());
  scene.meshes.push_back(ball(20, 20, 0.5));
  scene.instances.push_back({"thing", kThing, {}});
  return scene;
}

Sensor nearHead() {
  Sensor sensor = gridSensor(240, 9, -25, 20, 100);
  sensor.rotationPeriod = kPeriod;
  return sensor;
}

Sensor clockwise() {
  Sensor sensor = nearHead();
  sensor.name = "clockwise";
  sensor.azimuthSpanDeg = -360;
  return sensor;
}

/// Lasers with azimuth offsets, some of them more than a column, away from the sensor's origin.
Sensor uneven() {
  Sensor sensor = nearHead();
  sensor.name = "uneven";
  for (size_t j = 0; j < sensor.channels.size(); ++j) {
    sensor.channels[j].azimuthOffsetDeg = 1.3 * double(j % 5) - 2.9;
    sensor.channels[j].origin = {0.02, 0.01 * double(j % 3), 0.01};
  }
  return sensor;
}

/// The lasers of a column fire at different times.
Sensor staggered() {
  Sensor sensor = nearHead();
  sensor.name = "staggered";
  for (size_t j = 0; j < sensor.channels.size(); ++j) sensor.channels[j].timeOffset = 1e-4 * double(j % 4);
  return sensor;
}

Sensor prisms() {
  Sensor sensor = listSensor("prisms", rosette(2000, 0.6));
  sensor.rotationPeriod = kPeriod;
  return sensor;
}

/// A sensor that drives along x at `speed` and turns at `turn` rad/s, in 8 straight pieces.
SensorMotion driving(double speed, double turn) {
  SensorMotion motion;
  for (int i = 0; i <= 8; ++i) {
    const double time = kPeriod * i / 8, angle = turn * time;
    const Vec3 place = turn == 0 ? Vec3{speed * time, 0, 0}
                                 : Vec3{speed / turn * std::sin(angle), speed / turn * (1 - std::cos(angle)), 0};
    motion.stamps.push_back({time, {place, yaw(angle)}});
  }
  return motion;
}

/// Where the thing is at the start and at the end of a scan, and how the sensor moves.
struct Passage {
  const char* name;
  Transform start, end;
  SensorMotion motion;
};

/// The thing has a radius of 0.5 m, so its surface is as near as its centre is away, less half a metre.
std::vector<Passage> passages() {
  std::vector<Passage> all;
  for (const double azimuth : {0.4, 3.1}) {  // the second one is at the seam
    const double x = 0.9 * std::cos(azimuth), y = 0.9 * std::sin(azimuth);
    all.push_back({"beside the sensor", translation(x, y, 0), translation(x + 1.5, y, 0), driving(15, 0)});
    const SensorMotion turning = driving(15, 3);
    const Vec3 end = turning.stamps.back().pose.position;
    all.push_back({"beside a sensor that turns fast", translation(x, y, 0),
                   translation(end.x, end.y, 0) * rotationZ(3 * kPeriod) * translation(x, y, 0), turning});
  }
  all.push_back({"past a standing sensor, 5 mm", translation(-1.2, 0.505, 0), translation(1.2, 0.505, 0), {}});
  all.push_back({"against the rotation", translation(0.505, 1.5, 0), translation(0.505, -1.5, 0.2), {}});
  all.push_back({"with the rotation, turning", translation(-0.7, -2, 0), translation(-0.7, 2, 0) * rotationZ(1), {}});
  all.push_back(
      {"past the sensor, which drives", translation(3, -0.51, 0), translation(1.5, -0.51, 0), driving(15, 1)});
  all.push_back({"at rest, passed", translation(0.7, 0.52, 0), translation(0.7, 0.52, 0), driving(20, 0)});
  all.push_back({"through the sensor", translation(-1, 0.1, 0), translation(1, -0.1, 0), {}});
  all.push_back({"around the sensor", translation(0, 0, 0), translation(0.2, 0.1, 0) * rotationZ(0.5), driving(5, -2)});
  return all;
}

Shot shotOf(const Passage& passage, size_t sensor) {
  Shot shot;
  shot.sensor = sensor;
  shot.motion = passage.motion;
  shot.instanceMotions = {{kThing, passage.end}};
  return shot;
}

TestOptions moving(TestOptions options) {
  options.effects.sensorMotion.use = options.effects.objectMotion.use = EffectUse::on;
  return options;
}

/// The reference's scans, in the order of sensors and passages.
std::vector<Scan> expectedScans(const std::vector<Sensor>& sensors) {
  Simulator truth = makeSimulator(nearScene(), sensors, moving(optionsOn("reference")));
  std::vector<Scan> scans;
  for (size_t sensor = 0; sensor < sensors.size(); ++sensor)
    for (const Passage& passage : passages()) {
      truth.setTransform(kThing, passage.start);
      truth.scanInto(shotOf(passage, sensor), scans.emplace_back());
    }
  return scans;
}

double cpuOf(Simulator& simulator, const Shot& shot) {
  Scan scan;
  const std::clock_t start = std::clock();
  simulator.scanInto(shot, scan);
  return double(std::clock() - start);
}

}  // namespace

TEST_CASE("nothing is lost of what moves beside a sensor or past it", "[combinations]") {
  needVulkan();
  std::vector<Sensor> sensors = {nearHead(), clockwise(), uneven(), prisms()};
  if (everyCombination()) sensors.push_back(asList(nearHead()));
  const std::vector<Scan> expected = expectedScans(sensors);
  const size_t passageCount = passages().size();
  for (size_t i = 0; i < passageCount; ++i) {
    INFO(passages()[i].name);
    std::ptrdiff_t seen = 0;  // by all heads; a clockwise one turns away from some
    for (size_t k = i; k < expected.size(); k += passageCount)
      seen += std::ranges::count(expected[k].instances, kThing);
    CHECK(seen > 40);
  }
  std::vector<Binning> ways = {Binning::automatic};
  if (everyCombination()) ways = {Binning::nearest, Binning::lists, Binning::slabs};
  for (const Binning binning : ways) {
    TestOptions options = moving(vulkanOptions());
    options.tuning.binning = binning;
    Simulator device = makeSimulator(nearScene(), sensors, options);
    CudaOnHost onHost(nearScene(), sensors, options);
    auto truth = expected.begin();
    for (size_t sensor = 0; sensor < sensors.size(); ++sensor)
      for (const Passage& passage : passages()) {
        INFO("binning " << int(binning) << ", " << sensors[sensor].name << " " << sensor << ": " << passage.name);
        device.setTransform(kThing, passage.start);
        Scan scan, twin;
        device.scanInto(shotOf(passage, sensor), scan);
        // On the host, lists take seconds.
        if (dividesExactly(device.device()) && (sensors[sensor].isGrid() || everyCombination())) {
          onHost.backend().setInstance(kThing, kThing, passage.start);
          onHost.scanInto(shotOf(passage, sensor), twin);
          CHECK(firstBytes(scan, twin) == "none");
        }
        const Differences found = differences(*truth, scan, {1e-4});
        INFO(found.text());
        CHECK(found.all() == 0);
        CHECK(found.ties < found.beams / 20);
        ++truth;
      }
  }
}

// If a triangle surrounds the vertical axis of a sensor, beams in all columns may hit it. While the sensor moves, such
// a triangle is bounded for parts of the scan, and no part has all columns.
TEST_CASE("nothing is lost of large triangles around a moving sensor", "[combinations]") {
  needVulkan();
  std::vector<Sensor> sensors = {nearHead(), uneven(), staggered(), prisms()};
  for (Sensor& sensor : sensors)
    if (sensor.isGrid()) sensor.columns = 1200;
  MeshBuilder roof;
  roof.triangle({0, 6, 21}, {4, -8, 0.3}, {-7, -7.4, -0.1});
  std::vector<Scene> scenes = {sceneOf(roof.take())};
  for (uint32_t seed = 1; seed < (everyCombination() ? 40 : 3); ++seed)
    scenes.push_back(sceneOf(soup(seed, 1 + 2 * (seed % 3), 6, 14)));
  size_t hits = 0;
  for (uint32_t seed = 0; seed < scenes.size(); ++seed) {
    const Scene& scene = scenes[seed];
    Simulator truth = makeSimulator(scene, sensors, moving(optionsOn("reference")));
    Simulator device = makeSimulator(scene, sensors, moving(vulkanOptions()));
    Random random(seed);
    for (uint32_t pose = 0; pose < 8; ++pose) {
      const double speed = pose % 4 == 0 ? 0 : 5, turn = pose % 2;
      const double far = pose == 0 ? 0 : 3;
      const Transform place = translation(far * random(), far * random(), far * random());
      for (size_t sensor = 0; sensor < sensors.size(); ++sensor) {
        INFO("scene " << seed << ", pose " << pose << ", " << sensors[sensor].name);
        Shot shot;
        shot.sensor = sensor;
        shot.motion = driving(speed, turn);
        for (auto& stamp : shot.motion.stamps) stamp.pose.position = place * stamp.pose.position;
        shot.pose = shot.motion.stamps[0].pose;
        Scan expected, scan;
        truth.scanInto(shot, expected);
        device.scanInto(shot, scan);
        const Differences found = differences(expected, scan, {1e-4});
        INFO(found.text());
        CHECK(found.all() == 0);
        CHECK(found.ties < found.beams / 20);
        hits += expected.counters.hits;
      }
    }
  }
  CHECK(hits > 5'000);
}

// Without a bound of its own for each part of the scan, every triangle near the sensor's way is tried by all beams,
// which takes hundreds of times as long.
TEST_CASE("a thing that moves beside a sensor costs about as much as one far away") {
  needVulkan();
  Scene scene = nearScene();
  scene.meshes[kThing] = ball(50, 60, 0.5);
  Sensor sensor = nearHead();
  sensor.columns = 1200;
  Simulator simulator = makeSimulator(scene, sensor, moving(vulkanOptions()));
  const Passage away = {"", translation(0, 8, 0), translation(1.5, 8, 0), driving(15, 0)};
  const auto costOf = [&](const Passage& passage) {
    simulator.setTransform(kThing, passage.start);
    cpuOf(simulator, shotOf(passage, 0));  // the first scan may enlarge lists
    return std::min(cpuOf(simulator, shotOf(passage, 0)), cpuOf(simulator, shotOf(passage, 0)));
  };
  const double usual = costOf(away);
  CHECK(costOf({"", translation(0.2, 0.9, 0), translation(1.7, 0.9, 0), driving(15, 0)}) < 20 * usual);
  CHECK(costOf({"", translation(0.75, 0.8, 0), translation(0.75, 0.8, 0), driving(15, 0)}) < 20 * usual);
  CHECK(costOf({"", translation(1, 0.8, 0), translation(-0.5, 0.8, 0), {}}) < 20 * usual);
}

}  // namespace gnosphere::test

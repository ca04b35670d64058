// SPDX-License-Identifier: Apache-2.0
// Many scans in flight give the same results as single scans.
#include <catch2/matchers/catch_matchers.hpp>
#include <chrono>
#include <thread>

#include "effects/scan_support.hpp"
#include "pipeline/steps.hpp"

namespace gnosphere::test {
namespace {

Pose poseAt(double x, double y, double yaw) {
  return {{x, y, 0}, {0, 0, std::sin(yaw / 2), std::cos(yaw / 2)}};
}

// Four sensors: a plain one, one with azimuth offsets (other pipelines), one with a short range, one without beams.
std::vector<Sensor> mixedSensors() {
  std::vector<Sensor> sensors = {gridSensor(400, 33, -60, 60), gridSensor(300, 20, -30, 10),
                                 gridSensor(100, 7, -20, 20, 10), gridSensor(10, 0, 0, 0)};
  for (size_t j = 0; j < sensors[1].channels.size(); ++j) sensors[1].channels[j].azimuthOffsetDeg = 0.3 * double(j % 5);
  return sensors;
}

// Shots from out of range into the middle of the scene and out again, so that the lists must grow.
std::vector<Shot> driveThrough(size_t sensorCount, size_t count) {
  std::vector<Shot> shots;
  for (size_t i = 0; i < count; ++i) {
    const double x = i < 4 ? -1000 : 30 * std::cos(double(i));
    shots.push_back({poseAt(x, double(i), 0.7 * double(i)), (i * 5 + i / 3) % sensorCount});
  }
  return shots;
}

}  // namespace

TEST_CASE("scanAll gives the same bytes as scan, for every sensor and while lists grow", "[combinations]") {
  needVulkan();
  const Scene scene = sceneOf(soup(11, 1500, 40, 20));
  const std::vector<Sensor> sensors = mixedSensors();
  const std::vector<Shot> shots = driveThrough(sensors.size(), 13);
  for (Accuracy accuracy : {Accuracy::standard, Accuracy::exact}) {
    TestOptions options = vulkanOptions();
    options.accuracy = accuracy;
    options.tuning.culling.occlusion = Culling::Occlusion::never;  // shells depend on the scans before
    Simulator one = makeSimulator(scene, sensors, options);
    for (Binning binning : {Binning::nearest, Binning::lists, Binning::slabs}) {
      if (accuracy == Accuracy::exact && binning != Binning::lists && !everyCombination()) continue;
      options.tuning.binning = binning;
      Simulator all = makeSimulator(scene, sensors, options);
      size_t expected = 0;
      uint64_t retries = 0;
      all.scanAll(shots, [&](size_t i, const Scan& scan) {
        REQUIRE(i == expected++);
        const Scan alone = one.scan(shots[i].pose, shots[i].sensor);
        INFO("shot " << i << ", binning " << int(binning));
        CHECK(sameBytes(scan, alone));
        CHECK(scan.counters.hits == alone.counters.hits);
        // Several views are counted together.
        const auto sensorAt = [&](size_t shot) { return shot < shots.size() ? shots[shot].sensor : sensors.size(); };
        const bool oneView = sensorAt(i + 1) != sensorAt(i) && (i == 0 || sensorAt(i - 1) != sensorAt(i));
        if (oneView) CHECK(scan.counters.projected == alone.counters.projected);
        CHECK(scan.sensor == alone.sensor);
        CHECK(scan.columns == alone.columns);
        CHECK(scan.channels == alone.channels);
        CHECK(scan.pose.position.x == shots[i].pose.position.x);
        if (i < 4) CHECK(scan.counters.retries == 0);
        retries += scan.counters.retries;
      });
      CHECK(expected == shots.size());
      if (binning == Binning::lists) CHECK(retries > 0);
    }
  }
}

TEST_CASE("a scan in flight while the previous one enlarges the lists is repeated, too", "[second-driver]") {
  needVulkan();
  TestOptions options = vulkanOptions();
  options.tuning.binning = Binning::lists;
  options.tuning.maxBatchBytes = 1;  // every shot is a submission
  const Scene scene = sceneOf(soup(11, 1500, 40, 20));
  const std::vector<Shot> shots(2, {poseAt(0, 0, 0), 0});
  Simulator simulator = makeSimulator(scene, gridSensor(400, 33, -60, 60), options);
  std::vector<Scan> scans;
  simulator.scanAll(shots, [&](size_t, const Scan& scan) { scans.push_back(scan); });
  REQUIRE(scans.size() == 2);
  CHECK(scans[0].counters.retries > 0);
  CHECK(scans[1].counters.retries > 0);  // it was in flight when the lists were too small
  CHECK(scans[0].counters.hits > 0);
  CHECK(sameBytes(scans[0], scans[1]));
}

TEST_CASE("steps of more work than a submission may have are divided at their workgroups, and put into submissions") {
  const auto dispatch = [](uint64_t work, uint32_t groups, bool divisible) {
    Step step = {Step::Kind::dispatch, "bin"};
    step.work = work;
    step.workgroupsX = groups;
    step.pass.groups = divisible ? groups : 0;
    return step;
  };
  const auto text = [](const std::vector<Step>& steps) {
    std::string all;
    for (const Step& step : steps) {
      if (step.kind == Step::Kind::cut) all += "| ";
      if (step.kind == Step::Kind::fill) all += "fill ";
      if (step.kind != Step::Kind::dispatch) continue;
      const uint32_t first = step.pass.firstGroup;
      all += std::to_string(first) + "-" + std::to_string(first + step.workgroupsX) + " ";
    }
    return all;
  };
  const std::vector<Step> steps = {{Step::Kind::fill},      dispatch(40, 5, false), dispatch(40, 6, false),
                                   dispatch(30, 7, true),   dispatch(0, 1, false),  dispatch(900, 8, false),
                                   dispatch(250, 10, true), dispatch(1000, 3, true)};
  CHECK(text(inSubmissions(steps, 100)) == "fill 0-5 0-6 | 0-7 0-1 | 0-8 | 0-3 | 3-6 | 6-10 | 0-1 | 1-2 | 2-3 ");
  CHECK(text(inSubmissions(steps, 10'000)) == "fill 0-5 0-6 0-7 0-1 0-8 0-10 0-3 ");
}

TEST_CASE("scans in many submissions have the bytes of scans in one", "[combinations]") {
  needVulkan();
  Scene scene = sceneOf(soup(11, 1500, 40, 20));
  scene.materials.push_back(lambertian(0.3f, "pane"));
  scene.materials[1].transmission = 0.6f;
  scene.meshes.push_back(plate(4, 20, 1));
  scene.instances.push_back({"pane", 1, {}});
  std::vector<Sensor> sensors = {gridSensor(500, 33, -60, 60), gridSensor(350, 20, -30, 10)};
  sensors.push_back(sensors[1]);
  sensors[2].patterns = {beamsOf(sensors[1])};
  sensors[2].columns = 0;
  sensors[2].channels.clear();
  TestOptions options = vulkanOptions();
  size_t cuts = 0;
  options.trace = [&](const std::string& line) { cuts += line.find("the next submission") != std::string::npos; };
  std::vector<SensorRequest> requests;
  for (const Sensor& sensor : sensors) {
    requests.push_back({sensor, Effects::none()});
    requests.push_back({sensor, Effects::none(), stillFields()});
    for (const char* effect : {"intensity=on", "transmission=on", "returns.count=2", "returns.mode=all",
                               "angle-noise.azimuth=0.002", "angle-noise.at=beam", "rain.rate=20"})
      assign(requests.back().effects, effect);
    requests.push_back(requests.back());
    for (const char* effect : {"divergence.sub_rays=7", "divergence.horizontal=0.003", "divergence.vertical=0.0015"})
      assign(requests.back().effects, effect);
  }
  for (const Binning binning : {Binning::automatic, Binning::nearest, Binning::lists}) {
    if (binning == Binning::nearest && !everyCombination()) continue;
    // Without every combination, each sensor tries one of its three requests with lists, a different one per sensor,
    // and the two others without lists.
    std::vector<SensorRequest> tried;
    for (size_t i = 0; i < requests.size(); ++i)
      if ((i % 3 == i / 3) == (binning == Binning::lists) || everyCombination()) tried.push_back(requests[i]);
    const std::vector<Shot> shots = driveThrough(tried.size(), 2 * tried.size());
    options.tuning.binning = binning;
    options.tuning.maxSubmissionWork = 0;
    cuts = 0;
    std::vector<Scan> expected;
    Simulator(scene, tried, options).scanAll(shots, [&](size_t, const Scan& scan) { expected.push_back(scan); });
    CHECK(cuts == 0);
    options.tuning.maxSubmissionWork = 2500;
    Simulator(scene, tried, options).scanAll(shots, [&](size_t i, const Scan& scan) {
      INFO("shot " << i << ", binning " << int(binning));
      CHECK(firstBytes(expected[i], scan) == "none");
    });
    CHECK(cuts > 5 * shots.size());
  }
}

TEST_CASE("an exception of the callback ends the run, and the simulator stays usable") {
  needVulkan();
  const Scene scene = sceneOf(soup(3, 500, 20, 5));
  Simulator simulator = makeSimulator(scene, gridSensor(200, 16, -30, 30), vulkanOptions());
  const std::vector<Shot> shots = driveThrough(1, 9);
  size_t received = 0;
  const auto stopAtThird = [&](size_t, const Scan&) {
    if (++received == 3) throw std::runtime_error("enough");
  };
  CHECK_THROWS_WITH(simulator.scanAll(shots, stopAtThird), "enough");
  CHECK(received == 3);
  const Pose pose = poseAt(1, 2, 0.5);
  CHECK(sameBytes(simulator.scan(pose), scanOf(scene, gridSensor(200, 16, -30, 30), pose, vulkanOptions())));
}

TEST_CASE("a scan into existing arrays does not reallocate them") {
  needVulkan();
  for (const char* device : {"auto", "reference"}) {
    TestOptions options = vulkanOptions();
    options.device = deviceByName(device);
    Simulator simulator = makeSimulator(sceneOf(soup(3, 500, 20, 5)), gridSensor(200, 16, -30, 30), options);
    Scan scan = simulator.scan(poseAt(0, 0, 0));
    const float* points = scan.points.data();
    const float* ranges = scan.ranges.data();
    const uint32_t* triangles = scan.triangles.data();
    const uint32_t* instances = scan.instances.data();
    Shot shot;
    shot.pose = poseAt(5, 1, 2);
    simulator.scanInto(shot, scan);
    CHECK(scan.points.data() == points);
    CHECK(scan.ranges.data() == ranges);
    CHECK(scan.triangles.data() == triangles);
    CHECK(scan.instances.data() == instances);
    const Scan fresh = simulator.scan(poseAt(5, 1, 2));
    CHECK(sameBytes(scan, fresh));
    CHECK(scan.counters.hits == fresh.counters.hits);
    CHECK(scan.timings.stages.size() == fresh.timings.stages.size());
  }
}

TEST_CASE("the stages of a scan are timed on a CPU device only if they are asked for", "[second-driver]") {
  needVulkan();
  const Scene scene = sceneOf(soup(11, 1500, 40, 20));
  const SensorRequest request(gridSensor(200, 16, -30, 30), Effects::none());
  const std::vector<Shot> shots(3);
  Scan untimed;
  for (const bool asked : {false, true}) {
    SimulatorOptions options;
    options.tuning.stageTimes = asked;
    Simulator simulator(scene, request, options);
    const bool timed = asked || simulator.device().type != "cpu";
    const auto requireTimes = [&](const Timings& timings) {
      std::vector<std::string> names;
      for (const StageTime& stage : timings.stages) names.push_back(stage.name);
      CHECK(names == (timed ? std::vector<std::string>{"project", "bin", "resolve"} : std::vector<std::string>{}));
      CHECK((timings.gpuMs > 0) == timed);
      CHECK(timings.wallMs > 0);
    };
    const Scan scan = simulator.scan({});
    requireTimes(scan.timings);
    requireTimes(simulator.scanBatch(shots).timings);
    if (!asked)
      untimed = scan;
    else
      CHECK(sameBytes(scan, untimed));
  }
}

TEST_CASE("a traced scan is timed on every device") {
  needVulkan();
  size_t lines = 0;
  SimulatorOptions options;
  options.trace = [&](const std::string&) { ++lines; };
  Simulator simulator(sceneOf(soup(11, 1500, 40, 20)), SensorRequest(gridSensor(200, 16, -30, 30)), options);
  CHECK(simulator.scan({}).timings.gpuMs > 0);
  CHECK(lines > 0);
}

TEST_CASE("the time that a receiver takes is no part of the times of scans") {
  needVulkan();
  constexpr double kTakes = 300;  // ms, far longer than a scan of few beams
  TestOptions options = vulkanOptions();
  options.tuning.maxBatchBytes = 1;  // every shot is a submission, and the next one is in flight
  Simulator simulator(sceneOf(soup(3, 500, 20, 5)), SensorRequest(gridSensor(36, 4, -10, 10)), options);
  simulator.scan(poseAt(0, 0, 0));
  std::vector<Shot> shots;
  for (const double x : {0.1, 0.2, 0.3, 0.4}) shots.push_back({poseAt(x, 0, 0), 0});
  double least = kTakes;
  simulator.scanAll(shots, [&](size_t i, const Scan& scan) {
    if (i > 0) least = std::min(least, scan.timings.wallMs);
    std::this_thread::sleep_for(std::chrono::duration<double, std::milli>(kTakes));
  });
  CHECK(least < kTakes / 2);
}

TEST_CASE("the time that the device works on a scan counts although a receiver takes its time meanwhile") {
  needVulkan();
  TestOptions options = vulkanOptions();
  options.tuning.maxBatchBytes = 1;  // every shot is a submission, and the next one is in flight
  Simulator simulator(sceneOf(soup(3, 20000, 20, 5)), SensorRequest(gridSensor(1800, 64, -30, 30)), options);
  std::vector<Shot> shots;
  for (const double x : {0.1, 0.2, 0.3}) shots.push_back({poseAt(x, 0, 0), 0});
  double alone = 1e9, inFlight = 1e9;
  for (const Shot& shot : shots) alone = std::min(alone, simulator.scan(shot.pose).timings.wallMs);
  simulator.scanAll(shots, [&](size_t i, const Scan& scan) {
    if (i > 0) inFlight = std::min(inFlight, scan.timings.wallMs);
    std::this_thread::sleep_for(std::chrono::duration<double, std::milli>(4 * alone));
  });
  CAPTURE(alone, inFlight);
  CHECK(inFlight > alone / 3);
}

TEST_CASE("the second set of results is allocated by the first scanAll") {
  needVulkan();
  const Sensor sensor = gridSensor(200, 16, -30, 30);
  TestOptions options = vulkanOptions();
  options.tuning.keepStill = false;
  options.tuning.maxBatchBytes = 1;  // every shot is a submission
  Simulator simulator = makeSimulator(sceneOf(soup(3, 500, 20, 5)), sensor, options);
  const uint64_t before = simulator.memory().work;
  simulator.scan(poseAt(0, 0, 0));
  simulator.scan(poseAt(1, 0, 0));
  CHECK(simulator.memory().work == before);
  simulator.scanAll(std::vector<Shot>(3, {poseAt(1, 0, 0), 0}), [](size_t, const Scan&) {});
  const DeviceInfo& device = simulator.device();
  const bool unified = device.type == "cpu" || device.type == "integrated";
  CHECK(simulator.memory().work - before >= (unified ? 8 * sensor.beamCount() : 0));
  CHECK(simulator.memory().work - before < 25 * sensor.beamCount());
}

TEST_CASE("an invalid shot is refused before the first scan") {
  TestOptions options;
  options.device = DeviceChoice::Kind::reference;
  Simulator simulator = makeSimulator(sceneOf(soup(3, 5, 20, 5)), gridSensor(20, 4, -30, 30), options);
  std::vector<Shot> shots(3);
  const auto never = [](size_t, const Scan&) { FAIL("a scan was received"); };
  shots[2].sensor = 1;
  CHECK_THROWS_WITH(simulator.scanAll(shots, never), "shot 2: sensor 1 does not exist, there are 1");
  shots[2] = {};
  shots[1].pose.position.x = NAN;
  CHECK_THROWS_WITH(simulator.scanAll(shots, never), "shot 1: the pose has a value that is not finite");
  CHECK_THROWS_WITH(simulator.scanAll(shots, {}), "scanAll() needs a function that receives the scans");
  simulator.scanAll({}, never);
}

}  // namespace gnosphere::test

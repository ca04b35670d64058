// SPDX-License-Identifier: Apache-2.0
// Vulkan drivers without common code give the same bytes: for geometry, for each effect, and for all effects together.
#include <catch2/generators/catch_generators.hpp>

#include "effects/scan_support.hpp"
#include "lists/list_sensors.hpp"

namespace gnosphere::test {
namespace {

const Pose kPose = {{0.4, -0.3, 1.8}, {0.01, -0.02, 0.3, 0.95}};

/// A scene with ground, walls, a pane, a fence with holes, and glossy and retro-reflecting balls that hide one another.
Scene courtyard() {
  Scene scene;
  scene.materials = {lambertian(0.2f, "ground"), lambertian(0.7f, "wall"), lambertian(0.9f, "pane"),
                     lambertian(0.5f, "fence"), lambertian(0.6f, "paint")};
  scene.materials[2].transmission = 0.6f;
  scene.materials[3].alphaMode = AlphaMode::mask;
  scene.materials[3].alphaImage = 0;
  scene.materials[4].metallic = 0.8f;
  scene.materials[4].roughness = 0.3f;
  scene.materials[4].retro = 50;
  scene.alphaImages.push_back({3, 2, {0, 255, 90, 200, 0, 255}, AlphaImage::Wrap::mirror, AlphaImage::Wrap::repeat});
  MeshBuilder ground, walls;
  ground.quad({-60, -60, 0}, {120, 0, 0}, {0, 120, 0}, 9);
  walls.box({-31, -27, -1}, {33, 29, 9}, 4);
  scene.meshes = {ground.take(0), walls.take(1), plate(5, 2.5, 2), plate(6, 3, 3), ball(9, 14, 1)};
  scene.meshes[3].uvs = {-1.7f, 0, 0, 4.5f, 3.1f, 0, 2, 4};
  for (MeshPart& part : scene.meshes[4].parts) part.material = 4;
  scene.instances = {{"ground", 0, {}},
                     {"walls", 1, {}},
                     {"pane", 2, translation(0, 0, 2)},
                     {"fence", 3, rotationZ(1.6) * translation(0, 0, 2)}};
  Random uniform(8);
  for (int i = 0; i < 12; ++i)
    scene.instances.push_back({"ball", 4, translation(15 * uniform(), 15 * uniform(), 1.5 + uniform())});
  return scene;
}

/// A sensor whose columns no workgroup size divides; lasers have azimuth offsets and, if `places`, different origins.
Sensor unevenHead(bool places) {
  Sensor sensor = gridSensor(181, 12, -25, 15, 80);
  sensor.rotationPeriod = kPeriod;
  for (size_t j = 0; j < sensor.channels.size(); ++j) {
    if (j % 2 == 0) sensor.channels[j].azimuthOffsetDeg = 1.7 * double(j) - 9;
    if (places) sensor.channels[j].origin = {0.03, 0.02 * double(j % 3), -0.01};
  }
  return sensor;
}

/// Shots without motion, with the sensor moving at 20 m/s and 2 rad/s, with the pane and balls moving, and with both.
std::vector<Shot> shots() {
  Shot standing, driving;
  standing.pose = driving.pose = kPose;
  standing.frame = driving.frame = 3;
  driving.motion.stamps = {{0, kPose}, {kPeriod, {{2.4, -0.3, 1.8}, {0, 0, std::sin(0.3), std::cos(0.3)}}}};
  std::vector<Shot> result = {standing, driving, standing, driving};
  const Scene scene = courtyard();
  for (size_t i : {2, 3})
    for (size_t instance = 2; instance < 10; ++instance)
      result[i].instanceMotions.push_back(
          {instance, translation(-1.5, 0.5, 0) * scene.instances[instance].transform * rotationZ(0.2)});
  return result;
}

/// Every effect with parameters for which it is visible.
const std::vector<std::pair<std::string, std::vector<std::string>>> kEffects = {
    {"intensity", {"intensity.scale=byte"}},
    {"detection", {"detection.range=60", "detection.softness=0.2"}},
    {"drop-out", {"drop-out.general_rate=0.1", "drop-out.zero_intensity_rate=0.4", "drop-out.dead_beams=[3,700,701]"}},
    {"range-noise", {"range-noise.bias=0.01", "range-noise.sigma=0.02", "range-noise.step=0.004"}},
    {"angle-noise", {"angle-noise.azimuth=0.002", "angle-noise.elevation=0.001"}},
    {"intensity-noise", {"intensity-noise.sigma=0.05"}},
    {"divergence", {"divergence.sub_rays=7", "divergence.horizontal=0.003", "divergence.vertical=0.0015"}},
    {"returns", {"returns.mode=all", "returns.count=3"}},
    {"transmission", {"transmission=on"}},
    {"cut-outs", {"cut-outs=on"}},
    {"sensor-motion", {"sensor-motion.deskew=true"}},
    {"object-motion", {"object-motion=on"}},
    {"fog", {"fog.visibility=60"}},
    {"rain", {"rain.rate=20"}},
    {"snow", {"snow.rate=2"}},
    {"volumes", {}},  // parameters are set below
    {"radial-speed", {"radial-speed=on"}}};

bool isOfMotion(const std::string& name) {
  return name == "sensor-motion" || name == "object-motion" || name == "radial-speed";
}

/// Enables an effect by name, "all", or "all small", which are those without a footprint of several sub-rays.
void addEffects(Effects& effects, const std::string& which) {
  for (const auto& [name, assignments] : kEffects)
    if (which == name || which == "all" || (which == "all small" && name != "divergence"))
      for (const std::string& assignment : assignments) assign(effects, assignment);
  if (which != "volumes" && which.find("all") != 0) return;
  effects.volumes = {EffectUse::on, {{{3, -5, -1}, {12, 4, 5}, 0.05}}};
}

/// Returns the software devices of different drivers. Only these must round quotients and roots equally.
std::vector<DeviceInfo> softwareDevices() {
  std::vector<DeviceInfo> result;
  for (const DeviceInfo& device : listDevices())
    if (device.usable && device.type == "cpu") result.push_back(device);
  if (result.size() < 2) SKIP("there are not two drivers of software devices");
  return result;
}

/// Scans one shot or, `inMotion`, all shots with lasers at different origins, on every software device.
void requireSameBytes(const TestOptions& request, bool inMotion) {
  const std::vector<DeviceInfo> devices = softwareDevices();
  std::vector<Scan> expected;
  for (const DeviceInfo& device : devices) {
    TestOptions options = request;
    options.device = device;
    Simulator simulator = makeSimulator(courtyard(), unevenHead(inMotion), options);
    for (size_t i = 0; i < (inMotion ? shots().size() : 1); ++i) {
      INFO(device.name << ", shot " << i);
      Scan scan;
      simulator.scanInto(shots()[i], scan);
      if (&device == &devices[0]) {
        CHECK(scan.counters.hits > 800);
        expected.push_back(std::move(scan));
      } else {
        CHECK(firstBytes(expected[i], scan) == "none");
      }
    }
  }
}

std::vector<Field> allFields(bool speeds) {
  std::vector<Field> fields = effectFields();
  fields.push_back(Field::barycentrics);
  if (speeds) fields.push_back(Field::velocity);
  if (!speeds) std::erase(fields, Field::radialSpeed);
  return fields;
}

}  // namespace

TEST_CASE("drivers: standard and exact have the same bytes", "[second-driver]") {
  TestOptions options = vulkanOptions();
  options.accuracy = GENERATE(Accuracy::standard, Accuracy::exact);
  requireSameBytes(options, false);
}

TEST_CASE("drivers: all effects with small shaders have the same bytes together, at rest", "[second-driver]") {
  TestOptions options = vulkanOptions();
  addEffects(options.effects, "all small");
  // With an effect of motion in the plan, SwiftShader would compile each shader a second time.
  for (const char* name : {"sensor-motion", "object-motion", "radial-speed"})
    assign(options.effects, std::string(name) + "=off");
  options.fields = allFields(false);
  requireSameBytes(options, false);
}

TEST_CASE("drivers: lists of beams have the same bytes, in cells and in places of a grid", "[slow]") {
  const std::vector<DeviceInfo> devices = softwareDevices();
  std::vector<Sensor> sensors = listSensors();
  sensors.push_back(asList(unevenHead(false)));
  for (const Accuracy accuracy : {Accuracy::standard, Accuracy::exact}) {
    std::vector<Scan> expected;
    for (const DeviceInfo& device : devices) {
      TestOptions options = vulkanOptions();
      options.accuracy = accuracy;
      options.device = device;
      Simulator simulator = makeSimulator(courtyard(), sensors, options);
      for (size_t i = 0; i < sensors.size(); ++i) {
        INFO(device.name << ", " << sensors[i].name << ", " << nameOf(accuracy));
        Scan scan = simulator.scan(kPose, i);
        if (&device == &devices[0])
          expected.push_back(std::move(scan));
        else
          CHECK(firstBytes(expected[i], scan) == "none");
      }
    }
  }
}

// Lanes with a triangle each end the search for its box after different numbers of steps.
TEST_CASE("drivers: a list that moves over two large triangles has the same bytes", "[slow]") {
  Sensor sensor;
  sensor.name = "two beams";
  sensor.rangeMax = 80;
  sensor.patterns.push_back({{{1, 0, 0}, {0.8, 0, -0.6}}});
  sensor.patterns[0].times = {0, 0.05};
  MeshBuilder floor;
  floor.quad({-10, -10, 0}, {20, 0, 0}, {0, 20, 0}, 1);
  TestOptions options = vulkanOptions();
  options.effects.sensorMotion.use = EffectUse::on;
  Shot shot;
  shot.pose.position = {0, 0, 1.8};
  shot.motion.stamps = {{0, shot.pose}, {kPeriod, {{2, 0, 1.8}, {}}}};
  const Scene scene = sceneOf(floor.take());
  std::vector<Scan> scans;
  for (const DeviceInfo& device : softwareDevices()) {
    options.device = device;
    makeSimulator(scene, sensor, options).scanInto(shot, scans.emplace_back());
    CHECK(scans.back().counters.hits == 1);
    CHECK(firstBytes(scans.front(), scans.back()) == "none");
  }
}

TEST_CASE("drivers: all effects with small shaders have the same bytes together and in motion", "[slow]") {
  TestOptions options = vulkanOptions();
  addEffects(options.effects, "all small");
  options.fields = allFields(true);
  requireSameBytes(options, true);
}

TEST_CASE("drivers: each effect with small shaders has the same bytes alone", "[slow]") {
  std::vector<std::string> names;
  for (const auto& [name, assignments] : kEffects) names.push_back(name);
  REQUIRE(names == effectNames());
  for (const std::string& name : names) {
    if (name == "divergence") continue;
    INFO(name);
    TestOptions options = vulkanOptions();
    options.effects.intensity.use = EffectUse::automatic;  // several effects need it
    addEffects(options.effects, name);
    if (name == "intensity") options.fields = {Field::intensity};
    if (name == "radial-speed") options.fields = {Field::radialSpeed, Field::velocity};
    requireSameBytes(options, isOfMotion(name));
  }
}

// Footprints of as many sub-rays as real heads have by default, with panes, holes and beams with angle errors.
TEST_CASE("drivers: footprints have the same bytes", "[second-driver]") {
  TestOptions options = vulkanOptions();
  addEffects(options.effects, "all small");
  addEffects(options.effects, "divergence");
  options.effects.divergence.subRays = 19;
  for (const char* name : {"sensor-motion", "object-motion", "radial-speed"})
    assign(options.effects, std::string(name) + "=off");
  options.fields = allFields(false);
  requireSameBytes(options, false);
}

TEST_CASE("drivers: all effects together have the same bytes in motion", "[slow]") {
  TestOptions options = vulkanOptions();
  addEffects(options.effects, "all");
  options.fields = allFields(true);
  requireSameBytes(options, true);
}

}  // namespace gnosphere::test

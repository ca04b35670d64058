// SPDX-License-Identifier: Apache-2.0
// Effects from files of CARLA's attributes, and scans with them against CARLA's formulas.
#include <catch2/catch_test_macros.hpp>
#include <catch2/matchers/catch_matchers_exception.hpp>
#include <catch2/matchers/catch_matchers_floating_point.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <cmath>

#include "folder.hpp"
#include "gnosphere/gnosphere.hpp"

using namespace gnosphere;
using namespace gnosphere::test;
using Catch::Matchers::ContainsSubstring;
using Catch::Matchers::Message;
using Catch::Matchers::WithinAbs;

namespace {

/// Reads the effects of a file with this text.
Effects load(const std::string& text, const std::string& mode = {}) {
  const Folder folder;
  return loadEffects(put(folder / "objects.json", text), mode);
}

/// Reads the effects of a lidar with these attributes.
Effects of(const std::string& attributes, const std::string& type = "ray_cast") {
  return load(R"({"type": "sensor.lidar.)" + type + "\"" + (attributes.empty() ? "" : ", ") + attributes + "}");
}

void refusedLidar(const std::string& text, const std::string& why, const std::string& mode = {}) {
  INFO(text);
  try {
    load(text, mode);
    FAIL_CHECK("this is accepted");
  } catch (const Error& problem) {
    CHECK(problem.code() == ErrorCode::format);
    CHECK_THAT(problem.what(), ContainsSubstring("objects.json: " + why));
  }
}

const std::string kTwo = R"({"objects": [{"type": "vehicle.tesla.model3", "id": "ego", "sensors": [
  {"type": "sensor.camera.rgb", "id": "rgb"},
  {"type": "sensor.lidar.ray_cast", "id": "top", "noise_stddev": 0.02},
  {"type": "sensor.lidar.ray_cast", "id": "low", "noise_stddev": STDDEV}]}]})";

std::string two(const std::string& stddev) {
  return std::string(kTwo).replace(kTwo.find("STDDEV"), 6, stddev);
}

}  // namespace

TEST_CASE("attributes of a CARLA lidar set one parameter of an effect each") {
  Effects wanted = effectPreset("carla");
  wanted.seed = 0;
  CHECK(toJson(of("")) == toJson(wanted));
  CHECK(of(R"("atmosphere_attenuation_rate": 0.01)").intensity.attenuation == 0.01);
  CHECK(of(R"("dropoff_general_rate": 0)").dropOut.generalRate == 0);
  CHECK(of(R"("dropoff_intensity_limit": 0.5)").dropOut.intensityLimit == 0.5);
  CHECK(of(R"("dropoff_zero_intensity": 0.3)").dropOut.zeroIntensityRate == 0.3);
  CHECK(of(R"("noise_seed": 7)").seed == 7);
  CHECK(of("").rangeNoise.use == EffectUse::off);
  CHECK(of(R"("noise_stddev": 0.0)").rangeNoise.use == EffectUse::off);
  wanted.rangeNoise = {EffectUse::on, 0, 0.02, 0, 0};
  wanted.intensity.attenuation = 0.01;
  wanted.dropOut = {EffectUse::on, 0.1, 0.6, 0.2, {}};
  wanted.seed = 4;
  const std::string all = R"("noise_stddev": "0.02", "noise_seed": "4", "atmosphere_attenuation_rate": "0.01",
    "dropoff_general_rate": "0.1", "dropoff_intensity_limit": "0.6", "dropoff_zero_intensity": ".2", "range": "50")";
  CHECK(toJson(of(all)) == toJson(wanted));
  CHECK(toJson(of(all, "ray_cast_semantic")) == toJson(Effects::none()));
}

TEST_CASE("with a limit of zero CARLA loses no return by its intensity") {
  for (const char* limit : {"0", "0.0", "\"0.0\"", "-1"}) {
    const Effects effects = of(std::string(R"("dropoff_intensity_limit": )") + limit);
    CHECK(effects.dropOut.zeroIntensityRate == 0);
    CHECK(effects.dropOut.generalRate == 0.45);
  }
}

TEST_CASE("a CARLA lidar that loses nothing at random is scanned without drop-out") {
  for (const char* none : {R"("dropoff_zero_intensity": 0)", R"("dropoff_intensity_limit": 0)"}) {
    INFO(none);
    SensorRequest request;
    request.effects = of(R"("dropoff_general_rate": "0.0", )" + std::string(none));
    CHECK(request.effects.dropOut.use == EffectUse::off);
    request.sensor.columns = 90;
    request.sensor.channels = {{0}};
    request.sensor.rangeMax = 10;
    SimulatorOptions options;
    options.device = DeviceChoice::Kind::reference;
    CHECK(Simulator(Scene(), request, options).scan({}).counters.misses == 90);
  }
}

TEST_CASE("lidars of a CARLA file whose effects differ are chosen by their ids") {
  CHECK(load(two("0.02")).rangeNoise.sigma == 0.02);
  CHECK(load(two("0.03"), "top").rangeNoise.sigma == 0.02);
  CHECK(load(two("0.03"), "low").rangeNoise.sigma == 0.03);
  refusedLidar(two("0.03"), "the effects of the lidars top, low differ: choose one by its id");
  refusedLidar(two("0.03"), "has no lidar 'rear', but top, low", "rear");
  refusedLidar(R"({"type": "sensor.camera.rgb"})", "describes sensors of CARLA, but no 'sensor.lidar.ray_cast'");
  CHECK_THROWS_MATCHES(load(R"({"fog": {"visibility": 50}})", "top"), Error,
                       Catch::Matchers::MessageMatches(ContainsSubstring("a mode is the id of a CARLA lidar") &&
                                                       ContainsSubstring("'top'")));
}

TEST_CASE("wrong attributes of a CARLA lidar are refused by their own names") {
  const auto with = [](const std::string& attribute) {
    return R"({"type": "sensor.lidar.ray_cast", )" + attribute + "}";
  };
  refusedLidar(with(R"("dropoff_general_rate": 1.5)"), "'dropoff_general_rate' must be 0..1, is 1.5");
  refusedLidar(with(R"("dropoff_general_rate": "much")"), "'dropoff_general_rate' must be 0..1, is \"much\"");
  refusedLidar(with(R"("noise_stddev": [0.1])"), "'noise_stddev' must be 0..100 m, is [0.1]");
  refusedLidar(with(R"("noise_seed": -1)"), "'noise_seed' must be a whole number");
  refusedLidar(with(R"("dropoff_intensity_limit": 2)"), "'dropoff_intensity_limit' must be 0.001..1, is 2");
  refusedLidar(R"({"channels": 32, "points_per_second": 56000, "dropoff_general_rate": 0})",
               "has attributes of a CARLA lidar, but no \"type\": add \"type\": \"sensor.lidar.ray_cast\"");
}

TEST_CASE("a scan with the effects of a CARLA file has CARLA's intensities, losses and noise") {
  const std::string text = R"({"type": "sensor.lidar.ray_cast", "channels": 32, "points_per_second": 320000,
    "range": 200, "upper_fov": 10, "lower_fov": -10, "horizontal_fov": 60, "atmosphere_attenuation_rate": 0.006,
    "dropoff_general_rate": 0.3, "dropoff_intensity_limit": 0.7, "dropoff_zero_intensity": 0.5, "noise_stddev": 0.05})";
  const double attenuation = 0.006, distance = 120;
  Scene scene;
  scene.materials.emplace_back();
  Mesh wall;
  wall.positions = {120, -200, -200, 120, 200, -200, 120, 200, 200, 120, -200, 200};
  wall.indices = {0, 1, 2, 0, 2, 3};
  wall.parts = {{0, 2, 0}};
  scene.meshes = {wall};
  scene.instances.resize(1);
  SensorRequest request(readSensorFile(text, "c.json").sensor, load(text), {Field::intensity, Field::trueRange});
  SimulatorOptions options;
  options.device = DeviceChoice::Kind::reference;
  Simulator simulator(scene, request, options);
  const Scan scan = simulator.scan({});
  const auto intensities = scan.column<float>(Field::intensity), ranges = scan.column<float>(Field::trueRange);
  double kept = 0, wanted = 0, squares = 0;
  const BeamList beams = beamsOf(request.sensor);
  for (size_t i = 0; i < scan.ranges.size(); ++i) {
    const double intensity = std::exp(-attenuation * distance / beams.directions[i].x);
    wanted += 0.7 * (intensity > 0.7 ? 1 : 0.5 + 0.5 / 0.7 * intensity);
    if (!scan.returned(i)) continue;
    kept += 1;
    CHECK_THAT(intensities[i], WithinAbs(intensity, 1e-5));
    squares += std::pow(scan.ranges[i] - ranges[i], 2);
  }
  const auto count = static_cast<double>(scan.ranges.size());
  CHECK(count == 32000);
  CHECK_THAT(kept / count, WithinAbs(wanted / count, 0.015));
  CHECK_THAT(std::sqrt(squares / kept), WithinAbs(0.05, 0.002));
}

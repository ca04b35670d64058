// SPDX-License-Identifier: Apache-2.0
// Requests of effects: JSON, presets and assignments, and one-line errors.
#include <catch2/catch_test_macros.hpp>
#include <catch2/matchers/catch_matchers_exception.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/nearest_text.hpp"
#include "cpu_time.hpp"
#include "effects/effect_table.hpp"
#include "folder.hpp"
#include "gnosphere/effects.hpp"
#include "gnosphere/error.hpp"
#include "gnosphere/plan.hpp"

using namespace gnosphere;
using Catch::Matchers::ContainsSubstring;
using Catch::Matchers::Message;
using namespace gnosphere::test;

namespace {

Effects read(const std::string& json) {
  return effectsFromJson(json, "r.json");
}

/// Checks that the message names the file and states this reason.
void refused(const std::string& json, const std::string& why) {
  INFO(json);
  CHECK_THROWS_MATCHES(read(json), Error, Message("r.json: " + why));
}

void refusedAssignment(const std::string& assignment, const std::string& why) {
  INFO(assignment);
  Effects effects;
  CHECK_THROWS_MATCHES(assign(effects, assignment), Error, Message(why));
  CHECK(toJson(effects) == toJson(Effects()));
}

Effects everything() {
  Effects e;
  e.seed = 18446744073709551615u;
  e.intensity = {EffectUse::on, Effects::Intensity::Model::carla, Effects::Intensity::Scale::byte, 1550, 0.01};
  e.detection = {EffectUse::on, 0.2, 80, 0.1};
  e.dropOut = {EffectUse::on, 0.1, 0.2, 0.3, {0, 7, 4294967295u}};
  e.rangeNoise = {EffectUse::automatic, -0.01, 0.02, 1e-4, 0.004, 5e-5, 0.03};
  e.angleNoise = {EffectUse::on, 1e-4, 2e-4, Effects::AngleNoise::At::point};
  e.intensityNoise = {EffectUse::on, 0.05};
  e.divergence = {EffectUse::on, 37,     Effects::Divergence::Profile::uniform,
                  3e-3,          1.5e-3, Effects::Divergence::Shape::rectangle};
  e.returns = {EffectUse::on, Effects::Returns::Mode::strongestSecondStrongest, 2, 0.5, 6e-9};
  e.transmission.use = e.cutOuts.use = EffectUse::off;
  e.sensorMotion = {EffectUse::on, true};
  e.objectMotion.use = EffectUse::off;
  e.fog = {EffectUse::on, 200.1};
  e.rain = {EffectUse::off, 1.0 / 3};
  e.snow = {EffectUse::on, 2.5};
  e.volumes.use = EffectUse::on;
  e.volumes.boxes = {{{-1, -2, -3}, {1, 2, 3}, 0.1}, {{0, 0, 0}, {0.1, 0, 0}, 0}};
  e.radialSpeed = {EffectUse::on, 0.05};
  return e;
}

}  // namespace

TEST_CASE("a request in JSON states only differences from the defaults") {
  const Effects effects =
      read(R"({"seed": 7, "fog": {"use": "on", "visibility": 200}, "divergence": "off", "rain": {"rate": 5},
               "snow": {"use": "auto", "rate": 2}, "returns": {"mode": "first-last"}, "volumes": {"boxes":
               [{"min": [0, 1, 2], "max": [3, 4, 5], "extinction": 0.1}]}, "drop-out": {"dead_beams": [3, 1]}})");
  CHECK(effects.seed == 7);
  CHECK(effects.fog.use == EffectUse::on);
  CHECK(effects.fog.visibility == 200);
  CHECK(effects.divergence.use == EffectUse::off);
  CHECK(effects.rain.use == EffectUse::on);
  CHECK(effects.rain.rate == 5);
  CHECK(effects.snow.use == EffectUse::automatic);
  CHECK(effects.snow.rate == 2);
  CHECK(effects.returns.mode == Effects::Returns::Mode::firstLast);
  REQUIRE(effects.volumes.boxes.size() == 1);
  CHECK(effects.volumes.boxes[0].max.y == 4);
  CHECK(effects.volumes.boxes[0].extinction == 0.1);
  CHECK(effects.dropOut.deadBeams == std::vector<uint32_t>{3, 1});
  CHECK(effects.intensity.use == EffectUse::automatic);
  CHECK(toJson(read("{}")) == toJson(Effects()));
}

TEST_CASE("the JSON of a request reads back to the same request") {
  const std::string json = toJson(everything());
  CHECK(toJson(read(json)) == json);
  CHECK(read(json).seed == everything().seed);
  CHECK(read(json).rain.rate == everything().rain.rate);
  CHECK(read(json).rangeNoise.use == EffectUse::automatic);
  // Every parameter differs from its default, so that a missing one is detected.
  Effects all = everything(), defaults;
  const auto parsed = nlohmann::json::parse(json), plain = nlohmann::json::parse(toJson(defaults));
  for (const EffectInfo& info : effectTable())
    for (const Parameter<Effects>& parameter : info.parameters) {
      INFO(info.name << "." << parameter.name);
      CHECK(parsed.at(info.name).at(parameter.name) != plain.at(info.name).at(parameter.name));
    }
}

TEST_CASE("every preset is valid and reads back") {
  CHECK(effectPresets() == std::vector<std::string>{"clean", "auto", "carla", "hdl-64e", "os1-rain"});
  for (const std::string& name : effectPresets()) {
    INFO(name);
    const Effects effects = effectPreset(name);
    validate(effects);
    CHECK(toJson(read(toJson(effects))) == toJson(effects));
  }
  CHECK(toJson(effectPreset("clean")) == toJson(Effects::none()));
  CHECK(toJson(effectPreset("AUTO")) == toJson(Effects()));
  const Effects carla = effectPreset("carla");
  CHECK(carla.intensity.model == Effects::Intensity::Model::carla);
  CHECK(carla.dropOut.generalRate == 0.45);
  CHECK(carla.divergence.use == EffectUse::off);
  CHECK(effectPreset("hdl-64e").detection.range == 50);
  CHECK(effectPreset("os1-rain").rain.rate == 10);
}

TEST_CASE("a request is found by the name of a preset, or loaded from a file") {
  CHECK_THROWS_MATCHES(effectPreset("os1-fog"), Error,
                       Message("no preset of effects is called 'os1-fog'; known are clean, auto, carla, hdl-64e, "
                               "os1-rain"));
  const Folder folder;
  const fs::path file = put(folder / "request.json", R"({"fog": {"visibility": 50}})");
  CHECK(loadEffects(file).fog.visibility == 50);
  put(file, R"({"fig": {}})");
  CHECK_THROWS_MATCHES(loadEffects(file), Error,
                       Catch::Matchers::MessageMatches(ContainsSubstring(file.string() + ": no effect is called")));
}

TEST_CASE("unknown names are refused with the nearest known names") {
  refused(R"({"fogg": {}})", "no effect is called 'fogg'; the nearest are fog, rain, snow");
  refused(R"({"range_noise": {}})",
          "no effect is called 'range_noise'; the nearest are range-noise, angle-noise, intensity");
  refused(R"({"divergence": {"sub-rays": 7}})",
          "divergence has no 'sub-rays'; the nearest are sub_rays, shape, profile");
  refused(R"({"fog": {"rate": 7}})", "fog has no 'rate'; there is visibility");
  refused(R"({"cut-outs": {"texture": 7}})", "cut-outs has no 'texture', nor any other parameter");
}

TEST_CASE("values out of range are refused with the range and the unit") {
  refused(R"({"fog": {"visibility": -1}})", "fog.visibility must be 0..1000000 m, is -1");
  refused(R"({"rain": {"rate": 501}})", "rain.rate must be 0..500 mm/h, is 501");
  refused(R"({"divergence": {"sub_rays": 1262}})", "divergence.sub_rays must be a whole number, 1..1261, is 1262");
  refused(R"({"divergence": {"horizontal": 3}})",
          "divergence.horizontal must be 0..0.1 rad, is 3; a footprint is taken as flat, so a wider beam is a list of "
          "several: docs/limits.md");
  refused(R"({"divergence": {"vertical": -1}})", "divergence.vertical must be 0..0.1 rad, is -1");
  refused(R"({"returns": {"count": 16}})", "returns.count must be a whole number, 0..15, is 16");
  refused(R"({"intensity": {"wavelength": 1064}})", "intensity.wavelength must be 905 or 1550 nm, is 1064");
  refused(R"({"detection": {"reflectance": 0}})", "detection.reflectance must be 0.001..1, is 0");
  refused(R"({"volumes": {"boxes": [{"min": [0,0,0], "max": [1,1,-1], "extinction": 1}]}})",
          "volumes.boxes[0]: its min is beyond its max");
  refused(R"({"volumes": {"boxes": [{"min": [0,0,0], "max": [1,1,1], "extinction": 1001}]}})",
          "volumes.boxes[0].extinction must be 0..1000 1/m, is 1001");
}

TEST_CASE("numbers that formulas in single precision cannot divide by are refused for every parameter") {
  refused(R"({"range-noise": {"step": 1e-40}})", "range-noise.step must be 0 or at least 1e-20 in size, is 1e-40");
  refused(R"({"detection": {"softness": 1e-40}})", "detection.softness must be 0 or at least 1e-20 in size, is 1e-40");
  refused(R"({"range-noise": {"bias": -1e-310}})", "range-noise.bias must be 0 or at least 1e-20 in size, is -1e-310");
  refused(R"({"volumes": {"boxes": [{"min": [0,0,0], "max": [1,1,1], "extinction": 1e-40}]}})",
          "volumes.boxes[0].extinction must be 0 or at least 1e-20 in size, is 1e-40");
  CHECK(effectsFromJson(R"({"range-noise": {"step": 1e-20}, "detection": {"softness": 0}})", "text").rangeNoise.step ==
        1e-20);
}

TEST_CASE("values of a wrong type are refused with the right type") {
  refused("[]", "a request is a JSON object");
  refused(R"({"fog": 200})", "fog must be off, on or auto, is 200");
  refused(R"({"fog": "yes"})", "fog must be off, on or auto, is \"yes\"");
  refused(R"({"fog": {"use": true}})", "fog.use must be off, on or auto, is true");
  refused(R"({"fog": {"visibility": "200"}})", "fog.visibility must be 0..1000000 m, is \"200\"");
  refused(R"({"fog": {"visibility": null}})", "fog.visibility must be 0..1000000 m, is null");
  refused(R"({"seed": -1})", "seed must be a whole number, 0..18446744073709551615, is -1");
  refused(R"({"seed": 1.5})", "seed must be a whole number, 0..18446744073709551615, is 1.5");
  refused(R"({"divergence": {"sub_rays": 1.5}})", "divergence.sub_rays must be a whole number, 1..1261, is 1.5");
  refused(R"({"sensor-motion": {"deskew": 1}})", "sensor-motion.deskew must be true or false, is 1");
  refused(R"({"angle-noise": {"at": "points"}})", "angle-noise.at must be beam or point, is \"points\"");
  refused(R"({"drop-out": {"dead_beams": 3}})", "drop-out.dead_beams must be a list of beam indices, as [0, 3], is 3");
  refused(R"({"drop-out": {"dead_beams": [-3]}})",
          "drop-out.dead_beams must be a list of beam indices, as [0, 3], is -3");
  refused(R"({"volumes": {"boxes": {}}})",
          "volumes.boxes must be a list of {\"min\": [x, y, z], \"max\": [x, y, z], \"extinction\": 1/m}, is {}");
  refused(R"({"volumes": {"boxes": [3]}})",
          "volumes.boxes[0] must be {\"min\": [x, y, z], \"max\": [x, y, z], \"extinction\": 1/m}");
  refused(R"({"volumes": {"boxes": [{"min": [0,0]}]}})",
          "volumes.boxes[0]: 'min' must be [x, y, z], three numbers of metres");
  refused(R"({"volumes": {"boxes": [{"min": [0,0,0], "max": [1,1,"1"]}]}})",
          "volumes.boxes[0].max must be three numbers, is \"1\"");
  refused(R"({"volumes": {"boxes": [{"min": [0,0,0], "max": [1,1,1]}]}})", "volumes.boxes[0]: 'extinction' is missing");
  refused(R"({"volumes": {"boxes": [{"min": [0,0,0], "max": [1,1,1], "density": 1}]}})",
          "volumes.boxes[0]: unknown key 'density'; known are min, max, extinction");
}

TEST_CASE("duplicate keys and invalid JSON are refused") {
  refused(R"({"fog": "on", "fog": "off"})", "'fog' is there twice; keep one");
  refused(R"({"fog": {"visibility": 1, "visibility": 2}})", "'visibility' is there twice; keep one");
  CHECK_THROWS_MATCHES(
      read(R"({"fog": {"visibility": NaN}})"), Error,
      Catch::Matchers::MessageMatches(ContainsSubstring("r.json: is not JSON: parse error at line 1")));
  CHECK_THROWS_MATCHES(read(R"({"fog": {"visibility": 1e999}})"), Error,
                       Catch::Matchers::MessageMatches(ContainsSubstring("r.json: is not JSON: number overflow")));
  CHECK_THROWS_AS(read(""), Error);
  CHECK_THROWS_MATCHES(
      read(std::string("\xff\xfe{\0}\0", 6)), Error,
      Catch::Matchers::MessageMatches(ContainsSubstring("r.json: is text in UTF-16; save it as UTF-8")));
}

TEST_CASE("values set in C++ are checked like values read from JSON") {
  Effects effects;
  effects.fog.visibility = NAN;
  CHECK_THROWS_MATCHES(validate(effects), Error, Message("fog.visibility must be 0..1000000 m, is nan"));
  effects = {};
  effects.returns.mode = static_cast<Effects::Returns::Mode>(12);
  CHECK_THROWS_AS(validate(effects), Error);
  effects = {};
  effects.volumes.boxes.push_back({{0, 0, INFINITY}, {1, 1, INFINITY}, 1});
  CHECK_THROWS_MATCHES(validate(effects), Error, Message("volumes.boxes[0]: its corners must be finite"));
  effects = {};
  effects.snow.use = static_cast<EffectUse>(3);
  CHECK_THROWS_MATCHES(validate(effects), Error, Message("snow must be off, on or automatic"));
}

TEST_CASE("a value that asks for nothing leaves its effect to auto") {
  for (const char* assignment : {"fog.visibility=0", "rain.rate=0", "snow.rate=0", "volumes.boxes=[]",
                                 "drop-out.general_rate=0", "drop-out.dead_beams=[]", "range-noise.sigma=0",
                                 "range-noise.step=0", "angle-noise.elevation=0", "intensity-noise.sigma=0"}) {
    INFO(assignment);
    Effects effects = Effects::none();
    assign(effects, assignment);
    const std::string name(assignment, std::string_view(assignment).find('.'));
    for (const EffectInfo& info : effectTable())
      CHECK(info.use(effects) == (info.name == name ? EffectUse::automatic : EffectUse::off));
  }
  Effects effects = Effects::none();
  assign(effects, "range-noise.sigma_per_metre=0.001");
  assign(effects, "range-noise.sigma=0");
  CHECK(effects.rangeNoise.use == EffectUse::on);
  assign(effects, "detection.range=0");  // 10 % at the range that the sensor states
  CHECK(effects.detection.use == EffectUse::on);
  CHECK(read(R"({"rain": {"rate": 0}})").rain.use == EffectUse::automatic);
  CHECK(read(R"({"rain": {"rate": 0, "use": "on"}})").rain.use == EffectUse::on);
  CHECK(read(R"({"rain": {"rate": 1}})").rain.use == EffectUse::on);
}

TEST_CASE("an assignment sets a parameter and enables its effect, or sets a use") {
  Effects effects = Effects::none();
  assign(effects, "fog.visibility=2e2");
  CHECK(effects.fog.visibility == 200);
  CHECK(effects.fog.use == EffectUse::on);
  for (const auto& [text, value] : {std::pair{".5", 0.5}, {"1.", 1.0}, {"+2", 2.0}, {"1.e1", 10.0}, {"007.5", 7.5}}) {
    assign(effects, std::string("fog.visibility=") + text);
    CHECK(effects.fog.visibility == value);
  }
  CHECK_THROWS_WITH(assign(effects, "fog.visibility=.5m"),
                    ContainsSubstring("fog.visibility must be 0..1000000 m, is \".5m\""));
  assign(effects, "fog=auto");
  CHECK(effects.fog.use == EffectUse::automatic);
  assign(effects, "intensity.model=carla");
  CHECK(effects.intensity.model == Effects::Intensity::Model::carla);
  assign(effects, "drop-out.dead_beams=[1, 2]");
  CHECK(effects.dropOut.deadBeams == std::vector<uint32_t>{1, 2});
  assign(effects, "sensor-motion.deskew=true");
  CHECK(effects.sensorMotion.deskew);
  assign(effects, "seed=12");
  CHECK(effects.seed == 12);

  refusedAssignment("fog", "'fog' is not NAME=VALUE, as fog.visibility=200 or fog=off");
  refusedAssignment("fog=200", "fog must be off, on or auto, is 200");
  refusedAssignment("fog.visibility=far", "fog.visibility must be 0..1000000 m, is \"far\"");
  refusedAssignment("fog.visibility=nan", "fog.visibility must be 0..1000000 m, is \"nan\"");
  refusedAssignment("fog.visibility=", "fog.visibility must be 0..1000000 m, is \"\"");
  refusedAssignment("fog.visibility=-2", "fog.visibility must be 0..1000000 m, is -2");
  refusedAssignment("frog.visibility=2", "no effect is called 'frog'; the nearest are fog, snow, rain");
  refusedAssignment("fog.visiblity=2", "fog has no 'visiblity'; there is visibility");
  refusedAssignment("seed=x", "seed must be a whole number, 0..18446744073709551615, is \"x\"");
  refusedAssignment("fog.visibility=\"\xff\"", "fog.visibility must be 0..1000000 m, is \"\\\"\\ufffd\\\"\"");
}

TEST_CASE("a plan's totals are the sums of its parts, also in JSON") {
  Plan plan;
  plan.effects = {{"fog", EffectUse::on, true, "visibility 200 m"},
                  {"rain", EffectUse::automatic, false, "no rate is given"}};
  plan.fields = {"intensity"};
  plan.stages = {{"project", 2, {{"project_groups", {1, 2}}}}, {"effects", 3, {}}};
  plan.buffers = {{"hits", 8}, {"returns", 34}};
  plan.binning = "lists";
  plan.returns = 2;
  CHECK(plan.bytes() == 42);
  CHECK(plan.dispatches() == 5);
  CHECK(plan.has("fog"));
  CHECK_FALSE(plan.has("rain"));
  const auto json = nlohmann::json::parse(toJson(plan));
  CHECK(json.at("effects").at(1).at("request") == "auto");
  CHECK(json.at("effects").at(0).at("in") == true);
  CHECK(json.at("stages").at(0).at("pipelines").at(0).at("constants") == nlohmann::json({1, 2}));
  CHECK(json.at("bytes") == 42);
  CHECK(json.at("dispatches") == 5);
  CHECK(json.at("returns") == 2);
}

TEST_CASE("the nearest of many names are found in little time, and long names are not compared") {
  std::vector<std::string> names;
  for (int i = 0; i < 20000; ++i) names.push_back(std::to_string(i) + std::string(50, 'x'));
  const std::string name = std::string(50, 'x');
  std::string text;
  CHECK(cpuSeconds([&] { text = nearestText(name, names); }) < 2);
  CHECK(text == "the nearest are 0" + name + ", 1" + name + ", 2" + name);
  for (std::string& each : names) each += std::string(2000, 'y');
  names.push_back("x");
  CHECK(cpuSeconds([&] { text = nearestText(name, names); }) < 2);
  CHECK(text.starts_with("the nearest are x, "));
  CHECK(nearestText(std::string(1000, 'x'), {"a", "b"}) == "there are a, b");
}

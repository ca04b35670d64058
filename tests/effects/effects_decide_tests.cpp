// SPDX-License-Identifier: Apache-2.0
// Every effect planned, left out and refused, each with its reason.
#include <catch2/catch_test_macros.hpp>
#include <catch2/matchers/catch_matchers_exception.hpp>

#include "common/effects/bits.h"
#include "effects/decide.hpp"
#include "effects/effect_table.hpp"
#include "gnosphere/error.hpp"

using namespace gnosphere;

namespace {

/// Two triangles of two materials; a third material is on no triangle, a fourth on a mesh without instances.
Scene sampleScene() {
  Scene scene;
  scene.materials.resize(4);
  for (size_t i = 0; i < scene.materials.size(); ++i) scene.materials[i].name = "material " + std::to_string(i);
  Mesh mesh;
  mesh.positions = {1, 0, 0, 1, 1, 0, 1, 0, 1};
  mesh.indices = {0, 1, 2, 0, 2, 1};
  mesh.parts = {{0, 1, 0}, {1, 1, 1}, {2, 0, 2}};
  scene.meshes.push_back(mesh);
  mesh.parts = {{0, 2, 3}};
  scene.meshes.push_back(mesh);
  scene.instances.push_back({});
  return scene;
}

Sensor plainSensor() {
  Sensor sensor;
  sensor.name = "plain";
  sensor.columns = 10;
  sensor.channels = {{-1}, {1}};
  sensor.rangeMax = 100;
  return sensor;
}

/// Inputs of a decision, of which each test changes one.
struct Asked {
  Effects effects;
  Sensor sensor = plainSensor();
  Scene scene = sampleScene();
  std::vector<Field> fields;
  MaterialTable table;
  std::vector<uint32_t> ignoredInstances;
  bool variableWeather = false;

  std::vector<Plan::Decision> all() const {
    SensorRequest request = {sensor, effects, fields};
    request.ignoredInstances = ignoredInstances;
    request.variableWeather = variableWeather;
    return decide(request, scene, table);
  }
  Plan::Decision of(const std::string& effect) const {
    for (const Plan::Decision& decision : all())
      if (decision.effect == effect) return decision;
    FAIL("no decision on " << effect);
    return {};
  }
};

void checkIn(const Asked& asked, const std::string& effect, const std::string& reason) {
  const Plan::Decision decision = asked.of(effect);
  INFO(effect);
  CHECK(decision.in);
  CHECK(decision.reason == reason);
}

void checkOut(const Asked& asked, const std::string& effect, const std::string& reason) {
  const Plan::Decision decision = asked.of(effect);
  INFO(effect);
  CHECK_FALSE(decision.in);
  CHECK(decision.reason == reason);
}

void checkRefused(const Asked& asked, const std::string& message) {
  CHECK_THROWS_MATCHES(asked.all(), Error, Catch::Matchers::Message(message));
}

}  // namespace

TEST_CASE("the bits of effects are in the order of the names") {
  for (size_t i = 0; i < effectTable().size(); ++i) CHECK(effectTable()[i].bit == 1u << i);
  CHECK(gpu::kFootprint >> effectTable().size() > 0);
  Asked asked;
  asked.effects.fog.visibility = 200;
  asked.sensor.rotationPeriod = 0.1;
  CHECK(bitsOf(asked.all()) ==
        (gpu::kIntensity | gpu::kDetection | gpu::kSensorMotion | gpu::kObjectMotion | gpu::kFog));
  const auto decisions = asked.all();
  for (size_t i = 0; i < decisions.size(); ++i) CHECK(decisions[i].effect == effectNames()[i]);
}

TEST_CASE("a plain sensor in a plain scene is planned with geometry alone") {
  const Asked asked;
  CHECK(bitsOf(asked.all()) == 0);
  checkOut(asked, "intensity", "nothing asks for it");
  checkOut(asked, "detection", "no range is given");
  checkOut(asked, "drop-out", "no rate and no dead beam is given");
  checkOut(asked, "range-noise", "no bias, sigma or step is given");
  checkOut(asked, "angle-noise", "no standard deviation is given");
  checkOut(asked, "intensity-noise", "no sigma is given");
  checkOut(asked, "divergence", "the sensor states no divergence");
  checkOut(asked, "returns", "the sensor reports one return per beam");
  checkOut(asked, "transmission", "no material that is seen lets light through");
  checkOut(asked, "cut-outs", "no material that is seen has holes");
  checkOut(asked, "sensor-motion", "the sensor fires all beams at once");
  checkOut(asked, "object-motion", "the sensor fires all beams at once");
  checkOut(asked, "fog", "no visibility is given");
  checkOut(asked, "rain", "no rate is given");
  checkOut(asked, "snow", "no rate is given");
  checkOut(asked, "volumes", "no box is given");
  checkOut(asked, "radial-speed", "no field asks for it");
}

TEST_CASE("Effects::none() plans geometry alone") {
  Asked asked;
  asked.effects = Effects::none();
  asked.effects.fog.visibility = 200;
  asked.sensor.maxReturns = 3;
  asked.sensor.divergenceHorizontal = 3e-3;
  asked.scene.materials[0].transmission = 0.5f;
  CHECK(bitsOf(asked.all()) == 0);
  checkOut(asked, "divergence", "off in the request");
  checkOut(asked, "range-noise", "off in the request");
}

TEST_CASE("properties that the sensor states enable effects") {
  Asked asked;
  asked.sensor.divergenceHorizontal = 3e-3;
  asked.sensor.divergenceVertical = 1.5e-3;
  asked.sensor.maxReturns = 2;
  asked.sensor.rotationPeriod = 0.1;
  const std::string why = ", 19 sub-rays, the default: with 7, twice as many beams have a wrong number of returns";
  checkIn(asked, "divergence", "the sensor states 3 x 1.5 mrad" + why);
  checkIn(asked, "returns", "the sensor reports up to 2 returns per beam");
  checkIn(asked, "sensor-motion", "the sensor sweeps its columns in 100 ms");
  checkIn(asked, "object-motion", "the sensor sweeps its columns in 100 ms");
  asked.sensor.rotationPeriod = 0.0500617;
  checkIn(asked, "sensor-motion", "the sensor sweeps its columns in 50.1 ms");
  asked.sensor.rotationPeriod = 2400;
  checkIn(asked, "sensor-motion", "the sensor sweeps its columns in 2400 s");
  asked.sensor.rotationPeriod = 0;
  asked.sensor.channels[1].timeOffset = 1e-3;
  checkIn(asked, "object-motion", "the channels fire at times of their own");
  asked.sensor.rotationPeriod = 2400;
  checkIn(asked, "intensity", "needed by divergence, returns");

  asked.effects.returns.count = 3;  // replaces the number that the sensor states
  checkIn(asked, "returns", "the request takes up to 3 returns per beam");
  asked.effects.returns.count = 1;
  checkOut(asked, "returns", "the request takes one return per beam");
  asked.effects.divergence.vertical = 2e-3;
  asked.effects.divergence.use = EffectUse::on;
  checkIn(asked, "divergence", "asked for: the request states 3 x 2 mrad" + why);
  asked.effects.divergence.subRays = 7;
  checkIn(asked, "divergence", "asked for: the request states 3 x 2 mrad, 7 sub-rays");
}

TEST_CASE("materials that are visible enable transmission and cut-outs") {
  Asked asked;
  asked.scene.materials[2].transmission = 1;
  asked.scene.materials[3].transmission = 1;
  checkOut(asked, "transmission", "no material that is seen lets light through");
  asked.scene.materials[1].alphaMode = AlphaMode::blend;
  checkOut(asked, "transmission", "no material that is seen lets light through");
  asked.scene.materials[1].baseColor[3] = 0.5f;
  checkIn(asked, "transmission", "1 of 2 materials let light through");
  checkIn(asked, "intensity", "needed by transmission");
  asked.table.rows.push_back({"MATERIAL 0", -1, -1, -1, -1, 0.1f});
  checkIn(asked, "transmission", "2 of 2 materials let light through");
  asked.ignoredInstances = {0};
  checkOut(asked, "transmission", "no material that is seen lets light through");
  asked.ignoredInstances = {7};
  checkIn(asked, "transmission", "2 of 2 materials let light through");

  Material& mask = asked.scene.materials[0];
  mask.alphaMode = AlphaMode::mask;
  checkOut(asked, "cut-outs", "no material that is seen has holes");
  mask.alphaImage = 0;
  asked.scene.alphaImages.push_back({2, 1, {255, 200}});
  checkOut(asked, "cut-outs", "no material that is seen has holes");
  asked.scene.alphaImages[0].alpha[0] = 127;
  checkIn(asked, "cut-outs", "1 of 2 materials have holes");
  asked.scene.instances.clear();
  checkOut(asked, "cut-outs", "no material that is seen has holes");
}

TEST_CASE("parameters of the request enable effects") {
  Asked asked;
  Effects& effects = asked.effects;
  effects.fog.visibility = 200;
  effects.rain.rate = 5;
  effects.snow.rate = 2.5;
  effects.volumes.boxes.resize(2);
  effects.detection.use = effects.dropOut.use = effects.rangeNoise.use = effects.angleNoise.use =
      effects.intensityNoise.use = effects.radialSpeed.use = EffectUse::on;
  effects.dropOut.generalRate = 0.45;
  effects.dropOut.zeroIntensityRate = 0.4;
  effects.dropOut.intensityLimit = 0.8;
  effects.dropOut.deadBeams = {19};
  effects.rangeNoise.sigma = 0.02;
  effects.rangeNoise.sigmaPerMetre = 1e-4;
  effects.rangeNoise.bias = -0.01;
  effects.angleNoise.azimuth = 1e-4;
  effects.intensityNoise.sigma = 0.05;
  checkIn(asked, "fog", "visibility 200 m");
  checkIn(asked, "rain", "5 mm/h");
  checkIn(asked, "snow", "2.5 mm/h, melted");
  checkIn(asked, "volumes", "2 boxes");
  checkIn(asked, "detection", "asked for: as strong as 10 % at 100 m");
  checkIn(asked, "drop-out", "asked for: 45 % at random, 40 % at intensity 0, none above 0.8, 1 dead beam");
  checkIn(asked, "range-noise", "asked for: sigma 0.02 m + 0.0001 m per m, bias -0.01 m");
  checkIn(asked, "angle-noise", "asked for: sigma 0.1 x 0 mrad");
  checkIn(asked, "intensity-noise", "asked for: sigma 0.05");
  checkIn(asked, "radial-speed", "asked for");
  checkIn(asked, "intensity", "needed by detection, drop-out, intensity-noise, fog, rain, snow, volumes");
}

TEST_CASE("an effect that is left to auto is planned if the request gives it a value") {
  Asked asked;
  asked.effects.rangeNoise.step = 0.004;
  asked.effects.dropOut.generalRate = 0.1;
  checkIn(asked, "range-noise", "sigma 0 m, steps of 0.004 m");
  checkIn(asked, "drop-out", "10 % at random");
  asked.effects.rangeNoise = {.sigmaPerSquareMetre = 2e-4};
  checkIn(asked, "range-noise", "sigma 0 m + 0.0002 m per m^2");
  checkOut(asked, "intensity", "nothing asks for it");  // 10 % of all returns are lost, whatever their strength
  asked.effects.rangeNoise = {.sigmaAtThreshold = 0.05};
  checkIn(asked, "range-noise", "sigma 0 m, 0.05 m at the threshold of detection");
  checkIn(asked, "intensity", "needed by range-noise");
  asked.effects.rangeNoise = {};
  asked.effects.angleNoise.elevation = 1e-3;
  checkIn(asked, "angle-noise", "sigma 0 x 1 mrad");
  asked.effects.intensityNoise.sigma = 0.02;
  checkIn(asked, "intensity-noise", "sigma 0.02");
  asked.effects.detection.reflectance = 0.2;
  checkOut(asked, "detection", "no range is given");
  asked.sensor.rangeAt10Percent = 90;
  checkRefused(
      asked,
      "detection.reflectance is given without detection.range, but the range that sensor 'plain' states is one "
      "at 10 %; give detection.range, too");
  asked.effects.detection.reflectance = 0.1;
  checkOut(asked, "detection",
           "the sensor states 10 % at 90 m, but the reflectances of 2 of 2 materials are not measured; if on, colours "
           "stand for them");
  asked.table.rows = {{"MATERIAL 1", 0.3f}, {"material 2", 0.3f}};  // the second one is on no triangle
  checkOut(asked, "detection",
           "the sensor states 10 % at 90 m, but the reflectances of 1 of 2 materials are not measured; if on, colours "
           "stand for them");
  asked.table.rows.push_back({"material 0", 0.3f});
  checkIn(asked, "detection",
          "as strong as 10 % at 90 m, as the sensor states, and the reflectances of all materials are measured");
  asked.effects.intensity.wavelength = 1550;
  CHECK_FALSE(asked.of("detection").in);
  asked.effects.intensity.wavelength = 905;
  asked.effects.detection.range = 50;
  asked.effects.detection.reflectance = 0.2;
  checkIn(asked, "detection", "as strong as 20 % at 50 m");
  checkIn(asked, "intensity", "needed by detection, intensity-noise");
}

TEST_CASE("effects of the medium need the threshold of detection") {
  Asked asked;
  asked.sensor.rangeMax = 100;
  asked.effects.rain.rate = 1e-6;
  checkIn(asked, "detection", "needed by rain: as strong as 10 % at 100 m");
  asked.effects.fog.visibility = 1e6;
  asked.sensor.rangeAt10Percent = 90;
  checkIn(asked, "detection", "needed by fog: as strong as 10 % at 90 m, as the sensor states");
  asked.effects.detection.use = EffectUse::off;
  checkOut(asked, "detection", "off in the request, but fog applies its threshold");
}

TEST_CASE("a choice among the echoes is planned, however many returns the sensor reports") {
  Asked asked;
  asked.effects.returns.mode = Effects::Returns::Mode::last;
  checkIn(asked, "returns", "the request chooses among the echoes");
}

TEST_CASE("requested fields enable the effects that compute them") {
  Asked asked;
  asked.fields = {Field::intensity, Field::radialSpeed};
  checkIn(asked, "intensity", "the field intensity asks for it");
  checkIn(asked, "radial-speed", "the field radial_speed asks for it");
  asked.effects.radialSpeed.sigma = 0.05;
  checkIn(asked, "radial-speed", "the field radial_speed asks for it, sigma 0.05 m/s");
  asked.effects.radialSpeed.sigma = 0;
  asked.effects.intensity.use = asked.effects.radialSpeed.use = EffectUse::on;
  checkIn(asked, "intensity", "asked for");
  checkIn(asked, "radial-speed", "asked for: the field radial_speed asks for it");
}

TEST_CASE("an effect that is on but cannot be simulated is refused with advice") {
  const auto refused = [](EffectUse& (*use)(Effects&), const std::string& message) {
    Asked asked;
    use(asked.effects) = EffectUse::on;
    checkRefused(asked, message);
  };
  refused([](Effects& e) -> EffectUse& { return e.divergence.use; },
          "divergence is on, but sensor 'plain' states no divergence; give divergence.horizontal and "
          "divergence.vertical, or leave it to auto");
  refused([](Effects& e) -> EffectUse& { return e.transmission.use; },
          "transmission is on, but no material that is seen lets light through; give a material transmission, or "
          "leave it to auto");
  refused([](Effects& e) -> EffectUse& { return e.cutOuts.use; },
          "cut-outs is on, but no material that is seen has holes; give a material alphaMode MASK and a texture with "
          "alpha, or leave it to auto");
  refused([](Effects& e) -> EffectUse& { return e.sensorMotion.use; },
          "sensor-motion is on, but sensor 'plain' fires all beams at once; give the sensor a rotation period, or "
          "leave it to auto");
  refused([](Effects& e) -> EffectUse& { return e.objectMotion.use; },
          "object-motion is on, but sensor 'plain' fires all beams at once; give the sensor a rotation period, or "
          "leave it to auto");
  refused([](Effects& e) -> EffectUse& { return e.fog.use; },
          "fog is on, but no visibility is given; give fog.visibility, or leave it to auto");
  refused([](Effects& e) -> EffectUse& { return e.rain.use; },
          "rain is on, but no rate is given; give rain.rate, or leave it to auto");
  refused([](Effects& e) -> EffectUse& { return e.snow.use; },
          "snow is on, but no rate is given; give snow.rate, or leave it to auto");
  refused([](Effects& e) -> EffectUse& { return e.volumes.use; },
          "volumes is on, but no box is given; give volumes.boxes, or leave it to auto");
  refused([](Effects& e) -> EffectUse& { return e.rangeNoise.use; },
          "range-noise is on, but no bias, sigma or step is given; give range-noise.sigma, or leave it to auto");
  refused([](Effects& e) -> EffectUse& { return e.angleNoise.use; },
          "angle-noise is on, but no standard deviation is given; give angle-noise.azimuth or angle-noise.elevation, "
          "or leave it to auto");
  refused([](Effects& e) -> EffectUse& { return e.intensityNoise.use; },
          "intensity-noise is on, but no sigma is given; give intensity-noise.sigma, or leave it to auto");
  refused([](Effects& e) -> EffectUse& { return e.dropOut.use; },
          "drop-out is on, but no rate and no dead beam is given; give drop-out.general_rate, "
          "drop-out.zero_intensity_rate or drop-out.dead_beams, or leave it to auto");

  Asked asked;
  asked.effects.dropOut.deadBeams = {0, 20};
  for (const EffectUse use : {EffectUse::on, EffectUse::automatic}) {
    asked.effects.dropOut.use = use;
    checkRefused(asked, "drop-out: sensor 'plain' has no beam 20, it has 20; give drop-out.dead_beams from 0 to 19");
  }
  asked.sensor.channels.clear();
  checkRefused(asked, "drop-out: sensor 'plain' has no beams; give no drop-out.dead_beams");
}

TEST_CASE("an effect that is off but needed is refused, or disables the effects that need it") {
  Asked asked;
  asked.effects.intensity.use = EffectUse::off;
  asked.sensor.maxReturns = 2;
  checkOut(asked, "returns", "intensity, which it needs, is off in the request");
  checkOut(asked, "fog", "intensity, which it needs, is off in the request");
  CHECK(asked.of("returns").leftOut);
  CHECK_FALSE(asked.of("fog").leftOut);  // no visibility calls for it
  asked.effects.fog.visibility = 80;
  CHECK(asked.of("fog").leftOut);
  asked.effects.fog.visibility = 0;
  asked.variableWeather = true;
  CHECK_FALSE(asked.of("fog").leftOut);  // a place for the weather of shots calls for none, either
  asked.variableWeather = false;
  checkOut(asked, "intensity", "off in the request");
  asked.effects.returns.use = EffectUse::on;
  checkRefused(asked, "intensity is off, but returns needs it; set intensity to auto");
  asked.fields = {Field::intensity};
  checkRefused(asked, "intensity is off, but the field intensity is asked for; set intensity to auto");
  asked.effects.radialSpeed.use = EffectUse::off;
  asked.fields = {Field::radialSpeed};
  checkRefused(asked, "radial-speed is off, but the field radial_speed is asked for; set radial-speed to auto");
  asked.effects.fog.visibility = -1;
  checkRefused(asked, "fog.visibility must be 0..1000000 m, is -1");
}

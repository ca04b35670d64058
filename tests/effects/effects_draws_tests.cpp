// SPDX-License-Identifier: Apache-2.0
// Random numbers depend only on a seed, a sensor, a frame, a beam and an effect.
#include <bit>

#include "effects/beam_signal.hpp"
#include "effects/formula_inputs.hpp"
#include "effects/scan_support.hpp"
#include "effects/sensor_plan.hpp"
#include "effects/street.hpp"

namespace gnosphere::test {
namespace {

const Scene& town() {
  static const Scene scene = makeTown({.triangles = 5'000});
  return scene;
}

Sensor narrow() {
  Sensor sensor = builtinSensor("VLP-16");
  sensor.columns = 180;
  return sensor;
}

/// All effects that draw random numbers, with several returns.
Effects noisy() {
  Effects effects;
  effects.detection = {EffectUse::on, 0.1, 80, 0.2};
  effects.dropOut = {EffectUse::on, 0.1, 0.8, 0.4, {3, 700}};
  effects.rangeNoise = {EffectUse::on, 0.01, 0.02, 1e-4, 0};
  effects.angleNoise = {EffectUse::on, 1e-3, 1e-3, Effects::AngleNoise::At::point};
  effects.intensityNoise = {EffectUse::on, 0.05};
  effects.fog.visibility = 60;
  effects.rain.rate = 20;
  effects.snow.rate = 2;
  effects.volumes.boxes = {{{3, -5, -1}, {12, 4, 5}, 0.05}};
  effects.returns.count = 2;
  return effects;
}

TestOptions optionsFor(const std::string& device, const Effects& effects) {
  TestOptions options = optionsOn(device);
  options.effects = effects;
  options.fields = stillFields();
  return options;
}

std::vector<Scan> scansOf(Simulator& simulator, const std::vector<Shot>& shots) {
  std::vector<Scan> scans;
  simulator.scanAll(shots, [&](size_t, const Scan& scan) { scans.push_back(scan); });
  return scans;
}

}  // namespace

TEST_CASE("the same seed and frame give the same bytes, and different ones different bytes") {
  const std::string device = ON_EVERY_DEVICE;
  Simulator simulator = makeSimulator(town(), {narrow(), narrow()}, optionsFor(device, noisy()));
  const auto scans =
      scansOf(simulator, {standing(0), standing(1), standing(0), standing(0, 1), standing(uint64_t{1} << 32)});
  CHECK(scans[0].counters.hits > 500);
  CHECK(sameFields(scans[0], scans[2]));
  CHECK(!sameFields(scans[0], scans[1]));
  CHECK(!sameFields(scans[0], scans[3]));
  CHECK(!sameFields(scans[0], scans[4]));
  CHECK(sameFields(scans[0], simulator.scan(kPose)));
  Effects other = noisy();
  other.seed = 2;
  CHECK(!sameFields(scans[0], scanOf(town(), narrow(), kPose, optionsFor(device, other))));
}

TEST_CASE("two sensors draw numbers of their own, also in the weather of a shot") {
  const std::string device = ON_EVERY_DEVICE;
  Effects effects;
  effects.rangeNoise = {EffectUse::on, 0, 0.02, 0, 0};
  SensorRequest request(narrow(), effects);
  request.variableWeather = true;
  const TestOptions options = optionsFor(device, effects);
  Simulator simulator(town(), std::vector{request, request}, options);
  std::vector<Shot> shots(2, {kPose});
  shots[1].sensor = 1;
  for (Shot& shot : shots) shot.weather = Weather{2000, 0, 0, {}};
  const std::vector<Scan> scans = scansOf(simulator, shots);
  size_t both = 0, same = 0;
  for (size_t beam = 0; beam < scans[0].beamCount(); ++beam) {
    if (!scans[0].returned(beam) || !scans[1].returned(beam)) continue;
    ++both;
    same += scans[0].ranges[beam] == scans[1].ranges[beam];
  }
  CHECK(both > 100);
  CHECK(same < both / 100);
}

TEST_CASE("scans in flight keep their own random numbers") {
  needVulkan();
  Simulator simulator = makeSimulator(town(), narrow(), optionsFor("vulkan", noisy()));
  std::vector<Shot> shots;
  for (uint64_t frame = 0; frame < 5; ++frame) shots.push_back(standing(frame));
  const auto inFlight = scansOf(simulator, shots);
  for (size_t i = 0; i < shots.size(); ++i) CHECK(sameFields(scansOf(simulator, {shots[i]})[0], inFlight[i]));
}

TEST_CASE("switching an effect on or off does not change the random numbers of others") {
  const std::string device = ON_EVERY_DEVICE;
  Effects effects = Effects::none();
  effects.intensity.use = EffectUse::automatic;
  effects.rangeNoise = {EffectUse::on, 0, 0.02, 0, 0};
  effects.intensityNoise = {EffectUse::on, 0.05};
  const Scan plain = scanOf(town(), narrow(), kPose, optionsFor(device, effects));
  effects.dropOut = {EffectUse::on, 0.3, 0.8, 0.4, {}};
  effects.detection = {EffectUse::on, 0.1, 60, 0.2};
  effects.angleNoise = {EffectUse::on, 1e-3, 1e-3, Effects::AngleNoise::At::point};
  const Scan busy = scanOf(town(), narrow(), kPose, optionsFor(device, effects));
  size_t both = 0, lost = 0;
  for (size_t i = 0; i < plain.beamCount(); ++i) {
    lost += plain.hit(i) && !busy.hit(i);
    if (!plain.hit(i) || !busy.hit(i)) continue;
    ++both;
    CHECK(busy.ranges[i] == plain.ranges[i]);
    CHECK(busy.column<float>(Field::intensity)[i] == plain.column<float>(Field::intensity)[i]);
  }
  CHECK(both > 500);
  CHECK(lost > 200);
}

// The device and the host use the same source of the formulas. The host runs it on the device's hits.
TEST_CASE("the device and the host give the same bytes for the same hits and seed") {
  needVulkan();
  Effects effects = noisy();
  effects.transmission.use = effects.cutOuts.use = effects.divergence.use = EffectUse::off;
  effects.angleNoise = {};
  effects.volumes = {};
  effects.returns.use = EffectUse::off;
  effects.intensity = {EffectUse::on, Effects::Intensity::Model::carla, Effects::Intensity::Scale::unit};
  const TestOptions options = optionsFor("vulkan", effects);
  TestOptions bareOptions = optionsOn("vulkan");
  const Sensor sensor = narrow();
  const Scan bare = scanOf(town(), sensor, kPose, bareOptions), scan = scanOf(town(), sensor, kPose, options);
  const auto planned = SensorPlanner(options).plan(town(), {sensor, options.effects, options.fields}, 0, false);
  const SensorPlan& plan = *planned;
  const gpu::EffectParameters& parameters = plan.parameters;
  const auto bits = [](float value) { return std::bit_cast<uint32_t>(value); };
  for (uint32_t beam = 0; beam < bare.beamCount(); ++beam) {
    const gpu::Echo echo = {bare.ranges[beam], 1, parameters.pulseWidth, 1, 0};
    gpu::Return result = {};
    gpu::BeamSignal signal;
    signal.EFFECTS = plan.bits;
    signal.echoes = std::span(&echo, bare.hit(beam) ? 1 : 0);
    signal.returns = std::span(&result, 1);
    signal.deadBeams = plan.deadBeams;
    const Vec3 direction = sensor.direction(beam);
    uint32_t count = 0;
    const uint32_t cause = signal.signalsOf(parameters, beam, glm::vec3(direction.x, direction.y, direction.z),
                                            static_cast<uint32_t>(signal.echoes.size()), count);
    INFO("beam " << beam);
    REQUIRE(scan.column<uint8_t>(Field::cause)[beam] == cause);
    REQUIRE(scan.column<uint8_t>(Field::label)[beam] == result.label);
    REQUIRE(bits(scan.ranges[beam]) == bits(result.range));
    REQUIRE(bits(scan.column<float>(Field::trueRange)[beam]) == bits(result.trueRange));
    REQUIRE(bits(scan.column<float>(Field::intensity)[beam]) == bits(result.intensity));
    REQUIRE(bits(scan.column<float>(Field::width)[beam]) == bits(result.width));
  }
  CHECK(scan.counters.hits > 500);
}

}  // namespace gnosphere::test

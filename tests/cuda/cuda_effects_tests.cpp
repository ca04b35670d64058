// SPDX-License-Identifier: Apache-2.0
// Effects on the CUDA backend have the same bytes as on Vulkan. Every scan of tests/effects checks this, too (see
// scanOn()); these tests add the remaining cases.
#include <algorithm>
#include <catch2/generators/catch_generators.hpp>

#include "effects/scan_support.hpp"
#include "effects/street.hpp"

namespace gnosphere::test {
namespace {

using Profile = Effects::Divergence::Profile;
using Mode = Effects::Returns::Mode;

/// A town in which every other material is transparent, with a fence that has holes.
Scene glazedTown() {
  Scene scene = makeTown({.triangles = 20'000});
  for (size_t i = 0; i < scene.materials.size(); i += 2) scene.materials[i].transmission = 0.5f;
  addFence(scene, plate(6, 3), translation(0, 0, 2), 0.9f);
  return scene;
}

const Scene& town() {
  static const Scene scene = glazedTown();
  return scene;
}

/// A sensor whose columns no workgroup size divides, and whose lasers have azimuth offsets.
Sensor unevenSensor() {
  Sensor sensor = gridSensor(181, 12, -25, 15, 80);
  for (size_t j = 0; j < sensor.channels.size(); j += 2) sensor.channels[j].azimuthOffsetDeg = 1.7 * double(j) - 9;
  sensor.rotationPeriod = kPeriod;
  return sensor;
}

/// The same sensor with lasers at different origins.
Sensor unevenHead() {
  Sensor sensor = unevenSensor();
  for (size_t j = 0; j < sensor.channels.size(); ++j) sensor.channels[j].origin = {0.03, 0.02 * double(j % 3), -0.01};
  return sensor;
}

TestOptions asking(const Effects& effects) {
  TestOptions options = vulkanOptions();
  options.effects = effects;
  options.effects.intensity.use = options.effects.radialSpeed.use = EffectUse::automatic;
  options.fields = effectFields();
  options.fields.insert(options.fields.end(), {Field::barycentrics, Field::velocity});
  return options;
}

void requireSame(Twins& twins, const Shot& shot) {
  REQUIRE(twins.scan(shot).counters.hits > 300);
}

/// A shot in which the sensor moves ahead at 20 m/s and turns left at 2 rad/s.
Shot driving() {
  Shot shot = standing(3);
  shot.motion.stamps = {{0, kPose}, {kPeriod, {{3.3, 0.4, 1.8}, {0, 0, std::sin(0.3), std::cos(0.3)}}}};
  return shot;
}

/// Adds motion: the fence approaches and turns, and the town's first instance moves away.
Shot traffic(Shot shot) {
  shot.instanceMotions = {{town().instances.size() - 1, translation(-1.5, 0.5, 2) * rotationZ(0.2)},
                          {0, translation(0.5, 1, 0) * rotationZ(0.1) * town().instances[0].transform}};
  return shot;
}

}  // namespace

TEST_CASE("cuda effects: the largest number of sub-rays has Vulkan's bytes") {
  needVulkan();
  Effects effects = Effects::none();
  effects.divergence = {EffectUse::on, 61, Profile::gaussian, 9e-3, 4e-3};
  effects.returns = {EffectUse::on, Mode::strongestSecondStrongest};
  TestOptions options = asking(effects);
  options.fields = stillFields();
  Twins twins(town(), {unevenSensor()}, options);
  requireSame(twins, standing());
}

TEST_CASE("cuda effects: all together have Vulkan's bytes by seed, sensor and frame, with and without motion") {
  needVulkan();
  Effects e = Effects::none();
  e.seed = 5;
  e.detection = {EffectUse::on, 0.1, 80, 0};
  e.dropOut = {EffectUse::on, 0.1, 0.8, 0.4, {3, 700, 701}};
  e.rangeNoise = {EffectUse::on, 0.01, 0.02, 1e-4, 4e-3};
  e.intensityNoise = {EffectUse::on, 0.05};
  e.angleNoise = {EffectUse::on, 2e-3, 1e-3, Effects::AngleNoise::At::beam};
  e.divergence = {EffectUse::on, 5, Profile::uniform, 3e-3, 1.5e-3};
  e.returns = {EffectUse::on, Mode::lastStrongest};
  e.transmission.use = e.cutOuts.use = e.sensorMotion.use = e.objectMotion.use = EffectUse::on;
  e.sensorMotion.deskew = true;
  e.fog = {EffectUse::on, 100};
  e.rain = {EffectUse::on, 20};
  e.snow = {EffectUse::on, 2};
  e.volumes = {EffectUse::on, {{{3, -5, -1}, {12, 4, 5}, 0.05}}};
  Twins twins(town(), {unevenHead(), unevenHead()}, asking(e));
  for (const Shot& shot : {standing(), standing(1), standing(1, 1), driving(), traffic(standing()), traffic(driving())})
    requireSame(twins, shot);
}

TEST_CASE("cuda effects: surface fields of exact have Vulkan's bytes, also after changes of the scene") {
  needVulkan();
  TestOptions options = asking(Effects::none());
  options.accuracy = Accuracy::exact;
  Twins twins(town(), {unevenSensor()}, options);
  requireSame(twins, standing());
  const uint32_t mesh = town().instances[0].mesh;
  std::vector<float> positions = town().meshes[mesh].positions;
  for (size_t i = 0; i < positions.size(); ++i) positions[i] += 0.1f * static_cast<float>(i % 7);
  const Transform moved = translation(1, 2, 0.1) * town().instances[1].transform;
  twins.vulkan.setPositions(mesh, positions);
  twins.vulkan.setTransform(1, moved);
  twins.onHost.backend().setPositions(mesh, positions);
  twins.onHost.backend().setInstance(1, town().instances[1].mesh, moved);
  if (twins.cuda) {
    twins.cuda->setPositions(mesh, positions);
    twins.cuda->setTransform(1, moved);
  }
  requireSame(twins, standing());
}

TEST_CASE("cuda effects: a plan names Vulkan's steps and dispatches, and the arrays of CUDA") {
  needVulkan();
  Effects effects = Effects::none();
  effects.fog = {EffectUse::on, 60};
  if (GENERATE(false, true)) effects.divergence = {EffectUse::on, 7, Profile::gaussian, 3e-3, 1.5e-3};
  TestOptions options = asking(effects);
  options.tuning.binning = Binning::nearest;  // the only binning of CUDA
  const Sensor sensor = unevenSensor();
  const Plan expected = makeSimulator(town(), sensor, options).plan();
  const Plan plan = CudaOnHost(town(), {sensor}, options).backend().plan(0);
  CHECK(plan.binning == expected.binning);
  CHECK(plan.returns == expected.returns);
  CHECK(plan.effects.size() == expected.effects.size());
  REQUIRE(plan.stages.size() == expected.stages.size());
  const auto pipelines = [](const Plan::Stage& stage) {
    std::vector<std::pair<std::string, std::vector<uint32_t>>> result;
    for (const Plan::Pipeline& pipeline : stage.pipelines) result.emplace_back(pipeline.name, pipeline.constants);
    std::sort(result.begin(), result.end());
    return result;
  };
  for (size_t i = 0; i < plan.stages.size(); ++i) {
    CHECK(plan.stages[i].name == expected.stages[i].name);
    CHECK(plan.stages[i].dispatches == expected.stages[i].dispatches);
    CHECK(pipelines(plan.stages[i]) == pipelines(expected.stages[i]));
  }
  const auto bytesOf = [](const Plan& of, const std::string& name) {
    uint64_t sum = 0;
    for (const Plan::Buffer& buffer : of.buffers)
      if (buffer.name == name) sum += buffer.bytes;
    return sum;
  };
  for (const char* name : {"results", "subRays", "echoes", "projectedA", "rows", "tiles"}) {
    INFO(name);
    CHECK(bytesOf(plan, name) == bytesOf(expected, name));
  }
}

}  // namespace gnosphere::test

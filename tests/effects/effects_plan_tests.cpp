// SPDX-License-Identifier: Apache-2.0
// Effects that are not planned appear in no pipeline, constant, buffer or dispatch.
#include <catch2/catch_test_macros.hpp>
#include <catch2/matchers/catch_matchers.hpp>

#include "common/effects/bits.h"
#include "cuda/twin.hpp"
#include "effects/effect_table.hpp"
#include "pipeline/kernels.hpp"
#include "scan_support.hpp"

namespace gnosphere::test {

namespace {

bool operator==(const Plan::Pipeline& a, const Plan::Pipeline& b) {
  return a.name == b.name && a.constants == b.constants;
}

/// Whether two plans have the same steps, pipelines with their constants, buffers with their sizes, and dispatches.
bool sameWork(const Plan& a, const Plan& b) {
  const auto sameStage = [](const Plan::Stage& x, const Plan::Stage& y) {
    return x.name == y.name && x.dispatches == y.dispatches &&
           std::equal(x.pipelines.begin(), x.pipelines.end(), y.pipelines.begin(), y.pipelines.end(),
                      [](const auto& p, const auto& q) { return p == q; });
  };
  const auto sameBuffer = [](const Plan::Buffer& x, const Plan::Buffer& y) {
    return x.name == y.name && x.bytes == y.bytes;
  };
  return std::equal(a.stages.begin(), a.stages.end(), b.stages.begin(), b.stages.end(), sameStage) &&
         std::equal(a.buffers.begin(), a.buffers.end(), b.buffers.begin(), b.buffers.end(), sameBuffer) &&
         a.bytes() == b.bytes() && a.dispatches() == b.dispatches() && a.binning == b.binning && a.returns == b.returns;
}

/// A wall whose material may be transparent or have holes.
Scene wall(float transmission, AlphaMode mode) {
  Scene scene;
  Mesh mesh;
  mesh.positions = {10, -5, -5, 10, 5, -5, 10, 5, 5, 10, -5, 5};
  mesh.indices = {0, 1, 2, 0, 2, 3};
  mesh.uvs = {0, 0, 1, 0, 1, 1, 0, 1};
  mesh.parts = {{0, 2, 0}};
  scene.meshes = {mesh};
  scene.materials.emplace_back();
  scene.materials[0].transmission = transmission;
  scene.materials[0].alphaMode = mode;
  if (mode == AlphaMode::mask) {
    scene.alphaImages.push_back({2, 1, {0, 255}});
    scene.materials[0].alphaImage = 0;
  }
  scene.instances.resize(1);
  return scene;
}

/// A sensor that states all properties that effects may need.
Sensor able() {
  Sensor sensor = builtinSensor("VLP-16");
  sensor.columns = 360;
  sensor.divergenceHorizontal = 3e-3;
  sensor.divergenceVertical = 1.5e-3;
  sensor.maxReturns = 3;
  sensor.rotationPeriod = 0.1;
  return sensor;
}

/// A request with all effects.
Effects everything() {
  Effects effects;
  for (const char* assignment :
       {"intensity=on", "detection=on", "drop-out.general_rate=0.1", "range-noise.sigma=0.02",
        "angle-noise.azimuth=0.001", "angle-noise.at=point", "intensity-noise.sigma=0.01", "divergence.sub_rays=7",
        "returns=on", "transmission=on", "cut-outs=on", "sensor-motion=on", "object-motion=on", "fog.visibility=200",
        "rain.rate=5", "snow.rate=2", "radial-speed=on"})
    assign(effects, assignment);
  effects.volumes.use = EffectUse::on;
  effects.volumes.boxes = {{{1, -1, -1}, {2, 1, 1}, 0.1}};
  return effects;
}

Plan planOf(const Scene& scene, const Sensor& sensor, const Effects& effects) {
  TestOptions options = optionsOn("vulkan");
  options.effects = effects;
  return makeSimulator(scene, sensor, options).plan();
}

/// The plan of a device that has no pipelines to compile; its steps are those of every device.
Plan planOnHost(const Scene& scene, const Sensor& sensor, const Effects& effects) {
  TestOptions options;
  options.effects = effects;
  return CudaOnHost(scene, {sensor}, options).backend().plan(0);
}

Scene glassWithHoles() {
  Scene scene = wall(0.5f, AlphaMode::mask);
  scene.materials.push_back(scene.materials[0]);
  scene.materials[0].alphaMode = AlphaMode::opaque;
  scene.materials[0].alphaImage = kNoImage;
  scene.materials[1].transmission = 0;
  scene.meshes[0].parts = {{0, 1, 0}, {1, 1, 1}};
  return scene;
}

}  // namespace

TEST_CASE("an effect that is off changes no constant, and a scan of geometry alone is unchanged") {
  needVulkan();
  const Scene scene = glassWithHoles();
  const Plan bare = planOf(scene, able(), Effects::none()), bareOnHost = planOnHost(scene, able(), Effects::none());
  for (const Plan::Stage& stage : bare.stages) {
    CHECK(stage.name != "effects");
    for (const Plan::Pipeline& pipeline : stage.pipelines) {
      CHECK(optionsOf(pipeline.constants).EFFECTS == 0);
      CHECK(optionsOf(pipeline.constants).FIELDS == 0);
    }
  }
  // The host reads back only the packed word of each beam.
  CHECK(bare.stages.back().name == "resolve");
  CHECK(bare.stages.back().dispatches == 0);
  CHECK(bare.stages.back().pipelines.empty());
  // An effect that is off is not planned, whatever its parameters are.
  Effects off = everything();
  for (const EffectInfo& info : effectTable()) info.use(off) = EffectUse::off;
  CHECK(sameWork(planOnHost(scene, able(), off), bareOnHost));
}

TEST_CASE("an effect that the scene does not need costs as little as one that is off") {
  needVulkan();
  const Scene plain = wall(0, AlphaMode::opaque);
  const Sensor sensor = builtinSensor("VLP-16");
  CHECK(sameWork(planOf(plain, sensor, Effects{}), planOf(plain, sensor, Effects::none())));
}

TEST_CASE("removing an effect from all effects clears its bit in every pipeline") {
  needVulkan();
  const Scene scene = glassWithHoles();
  const Plan all = planOnHost(scene, able(), everything()), onDevice = planOf(scene, able(), everything());
  for (const Plan::Stage& stage : onDevice.stages)
    for (const Plan::Pipeline& pipeline : stage.pipelines)
      CHECK(optionsOf(pipeline.constants).EFFECTS == optionsOf(all.stages[0].pipelines[0].constants).EFFECTS);
  for (const Plan::Decision& decision : all.effects) {
    INFO(decision.effect << ": " << decision.reason);
    CHECK(decision.in);
  }
  for (size_t i = 0; i < effectNames().size(); ++i) {
    INFO(effectNames()[i]);
    if (effectNames()[i] == "intensity") continue;  // the other effects need it
    Effects effects = everything();
    assign(effects, effectNames()[i] + "=off");
    const Plan plan = planOnHost(scene, able(), effects);
    CHECK(!plan.has(effectNames()[i]));
    // Without sub-rays the surfaces of all beams are kept instead of lists; without transmission, chains and words.
    if (effectNames()[i] != "divergence" && effectNames()[i] != "transmission") CHECK(plan.bytes() <= all.bytes());
    for (const Plan::Stage& stage : plan.stages)
      for (const Plan::Pipeline& pipeline : stage.pipelines)
        CHECK((optionsOf(pipeline.constants).EFFECTS >> i & 1) == 0);
  }
}

TEST_CASE("auto plans the effects that the scene needs: glass, holes and neither give three sets of pipelines") {
  needVulkan();
  const Sensor sensor = builtinSensor("VLP-16");
  const Plan glass = planOf(wall(0.5f, AlphaMode::opaque), sensor, Effects{});
  const Plan holes = planOf(wall(0, AlphaMode::mask), sensor, Effects{});
  const Plan plain = planOf(wall(0, AlphaMode::opaque), sensor, Effects{});
  CHECK(glass.has("transmission"));
  CHECK(!glass.has("cut-outs"));
  CHECK(holes.has("cut-outs"));
  CHECK(!holes.has("transmission"));
  CHECK(!sameWork(glass, holes));
  CHECK(!sameWork(glass, plain));
  CHECK(!sameWork(holes, plain));
}

TEST_CASE("no head of the catalogue falls to lists, whatever the scene shows and moves") {
  std::vector<Sensor> heads = builtinSensors();
  for (const CatalogueHead& entry : sensorCatalogue()) heads.push_back(builtinSensor(entry.name));
  const Scene scene = glassWithHoles();
  size_t footprints = 0;
  for (const Sensor& head : heads)
    for (const EffectUse moving : {EffectUse::off, EffectUse::on}) {
      INFO(head.name << (moving == EffectUse::on ? ", moving" : ", at rest"));
      Effects effects;
      const bool moves = moving == EffectUse::on && head.rotationPeriod > 0;
      effects.objectMotion.use = effects.sensorMotion.use = moves ? EffectUse::on : EffectUse::off;
      const Plan plan = planOnHost(scene, head, effects);
      CHECK(plan.has("transmission"));
      CHECK(plan.has("cut-outs"));
      CHECK(plan.has("object-motion") == moves);
      CHECK(plan.binning != "lists");
      footprints += plan.has("divergence");
    }
  CHECK(footprints > heads.size() / 2);
}

TEST_CASE("lines answer for holes, angle errors and panes with standard accuracy") {
  needVulkan();
  const auto stagesOf = [](const Plan& plan) {
    std::string names;
    for (const Plan::Stage& stage : plan.stages) names += stage.name + (stage.dispatches > 0 ? " " : "(host) ");
    return names;
  };
  TestOptions options = optionsOn("vulkan");
  const Scene scene = wall(0, AlphaMode::mask);
  options.effects.cutOuts.use = EffectUse::on;
  const Plan holes = makeSimulator(scene, able(), options).plan();
  CHECK(holes.binning == makeSimulator(scene, able(), vulkanOptions()).plan().binning);
  CHECK(stagesOf(holes) == "project bin resolve(host) ");
  options.effects.angleNoise = {EffectUse::on, 1e-3, 1e-3, Effects::AngleNoise::At::beam};
  CHECK(stagesOf(makeSimulator(scene, able(), options).plan()) == "effects project bin resolve(host) ");
  options.effects.transmission.use = EffectUse::on;
  assign(options.effects, "divergence.sub_rays=1");
  options.effects.intensity.use = EffectUse::automatic;
  const Scene pane = glassWithHoles();
  CHECK(stagesOf(makeSimulator(pane, able(), options).plan()) == "effects project bin resolve(host) ");
  options.fields = {Field::intensity};
  CHECK(stagesOf(makeSimulator(pane, able(), options).plan()) == "effects project bin resolve(host) ");
  options.fields.clear();
  assign(options.effects, "divergence.sub_rays=2");
  CHECK(makeSimulator(pane, able(), options).plan().binning == "nearest");
  options.effects.divergence.use = EffectUse::off;
  options.effects.transmission.use = EffectUse::off;
  options.accuracy = Accuracy::exact;
  const Plan exact = makeSimulator(scene, able(), options).plan();
  CHECK(exact.binning == "nearest");
  CHECK(stagesOf(exact) == "effects project bin resolve(host) ");
  options.effects.cutOuts.use = EffectUse::off;
  options.accuracy = Accuracy::paper;
  CHECK_THROWS_WITH(makeSimulator(scene, able(), options),
                    "angle-noise is on, but accuracy paper knows lines only; use draft, standard or exact");
  options.effects.angleNoise.at = Effects::AngleNoise::At::point;
  CHECK(makeSimulator(scene, able(), options).plan().has("angle-noise"));
}

}  // namespace gnosphere::test

// SPDX-License-Identifier: Apache-2.0
// Heads with two returns per beam in front of panes. Only beams that meet a pane have a second return, so without
// fields the device computes the returns of these beams alone, and the others keep the words of their nearest hits.
// With fields it computes all returns, which must be the same.
#include "effects/scan_support.hpp"
#include "effects/street.hpp"
#include "lists/list_sensors.hpp"
#include "pipeline/kernels.hpp"

namespace gnosphere::test {
namespace {

/// A town in which every second material lets light pass.
const Scene& glassTown() {
  static const Scene scene = [] {
    Scene town = makeTown({.triangles = 20'000});
    for (size_t i = 0; i < town.materials.size(); i += 2) town.materials[i].transmission = 0.6f;
    return town;
  }();
  return scene;
}

/// A grid, a head whose lasers look beside each other and fire in turn, a sector of that head, and a list.
std::vector<Sensor> heads() {
  Sensor grid = builtinSensor("VLP-16");
  grid.columns = 180;
  grid.rotationPeriod = 0.1;
  Sensor spread = grid;
  spread.name = "spread";
  for (size_t i = 0; i < spread.channels.size(); ++i) {
    spread.channels[i].azimuthOffsetDeg = 2.3 * static_cast<double>(i % 3) - 2;
    spread.channels[i].timeOffset = 2e-6 * static_cast<double>(i);
    spread.channels[i].origin = {0.02, 0, 0.001 * static_cast<double>(i)};
  }
  Sensor sector = spread;
  sector.name = "sector";
  sector.columns = 60;
  sector.azimuthStartDeg = 150;
  sector.azimuthSpanDeg = 120;
  Sensor list = asList(grid);
  list.name = "list";
  BeamList& beams = list.patterns.at(0);
  for (size_t i = 0; i < beams.directions.size(); ++i) {
    if (i % 2 == 0)
      beams.directions[i] = unit({beams.directions[i].x, beams.directions[i].y, beams.directions[i].z + 1e-3});
    beams.times.at(i) = 3e-5 * static_cast<double>(i);
  }
  return {grid, spread, sector, list};
}

TestOptions twoReturns() {
  TestOptions options = optionsOn("vulkan");
  Effects& effects = options.effects;
  effects.transmission.use = effects.returns.use = EffectUse::on;
  effects.returns.count = 2;
  effects.intensity.use = effects.sensorMotion.use = effects.objectMotion.use = EffectUse::automatic;
  return options;
}

Shot shotOf(const Scene& scene, bool moves) {
  Shot shot;
  shot.pose = kPose;
  if (!moves) return shot;
  shot.motion.stamps = {{0, kPose}, {0.1, {{2.4, 0.7, 1.85}, {0.01, -0.02, 0.35, 0.93}}}};
  for (size_t i = 0; i < scene.instances.size(); i += 3)
    shot.instanceMotions.push_back({i, translation(0.4, -0.2, 0.02) * scene.instances[i].transform});
  return shot;
}

}  // namespace

TEST_CASE("two returns per beam are the same whether the device computes those of all beams or of those at panes",
          "[combinations]") {
  needVulkan();
  const Scene& scene = glassTown();
  const std::vector<Sensor> sensors = heads();
  for (size_t i = 0; i < sensors.size(); ++i)
    for (const bool moves : {false, true}) {
      const Sensor& head = sensors[i];
      TestOptions options = twoReturns();
      const Shot shot = shotOf(scene, moves);
      options.device = DeviceChoice::Kind::reference;
      const Scan reference = scanOn(scene, head, shot, options);
      for (const Binning binning : {Binning::slabs, Binning::nearest, Binning::lists}) {
        const bool even = i % 2 == 0;
        const bool tried = binning == Binning::lists     ? !even
                           : binning == Binning::nearest ? even && !moves
                                                         : even || !moves;
        if (!tried && !everyCombination()) continue;
        INFO(head.name << (moves ? ", moving" : ", at rest") << ", binning " << static_cast<int>(binning));
        options = twoReturns();
        options.tuning.binning = binning;
        const Scan scan = scanOn(scene, head, shot, options);
        options.fields = {Field::intensity};
        Scan all;
        makeSimulator(scene, head, options).scanInto(shot, all);
        size_t second = 0;
        for (size_t entry = 1; entry < scan.ranges.size(); entry += 2) second += scan.returned(entry) ? 1 : 0;
        CHECK(second > scan.beamCount() / 50);
        CHECK(scan.counters.hits == all.counters.hits);
        CHECK(scan.counters.causes == all.counters.causes);
        CHECK(scan.counters.lostEchoes == all.counters.lostEchoes);
        CHECK(std::ranges::equal(scan.triangles, all.triangles));
        CHECK(std::ranges::equal(scan.instances, all.instances));
        CHECK(std::memcmp(scan.ranges.data(), all.ranges.data(), 4 * scan.ranges.size()) == 0);
        CHECK(std::memcmp(scan.points.data(), all.points.data(), 4 * scan.points.size()) == 0);
        const Differences found = differences(reference, scan, {1e-4, 5e-4, 2e-3});
        INFO(found.text());
        CHECK(found.all() <= found.beams / 200);
      }
    }
}

TEST_CASE("three returns per beam of shots that are scanned together are those of single scans") {
  needVulkan();
  TestOptions options = twoReturns();
  options.effects.returns.count = 3;
  const Sensor head = heads()[0];
  std::vector<Shot> shots(3, shotOf(glassTown(), false));
  for (size_t i = 0; i < shots.size(); ++i) shots[i].pose.position.x += 0.4 * static_cast<double>(i);
  Simulator together = makeSimulator(glassTown(), head, options), single = makeSimulator(glassTown(), head, options);
  size_t seen = 0;
  together.scanAll(shots, [&](size_t i, const Scan& scan) {
    INFO("shot " << i);
    ++seen;
    const Scan alone = single.scan(shots[i].pose);
    size_t third = 0;
    for (size_t entry = 2; entry < alone.ranges.size(); entry += 3) third += alone.returned(entry) ? 1 : 0;
    CHECK(third > 0);
    CHECK(sameBytes(scan, alone));
  });
  CHECK(seen == shots.size());
}

TEST_CASE("the kernel of effects runs for the beams at panes alone if no field asks for more") {
  needVulkan();
  TestOptions options = twoReturns();
  const auto passes = [&] {
    std::vector<uint32_t> result;
    const Plan plan = makeSimulator(glassTown(), heads()[1], options).plan();
    for (const Plan::Stage& stage : plan.stages)
      for (const Plan::Pipeline& pipeline : stage.pipelines)
        if (pipeline.name == "effects") result.push_back(optionsOf(pipeline.constants).PASS);
    return result;
  };
  CHECK(passes() == std::vector<uint32_t>{gpu::kPassEffectsListed});
  options.fields = {Field::intensity};
  CHECK(passes() == std::vector<uint32_t>{gpu::kPassEffectsAll});
}

}  // namespace gnosphere::test

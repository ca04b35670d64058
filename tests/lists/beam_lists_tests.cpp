// SPDX-License-Identifier: Apache-2.0
// Sensors that are lists of beams: their scans equal the reference's, a grid given as a list has the grid's bytes, and
// no switch and no order of the beams changes a byte.
#include <numbers>

#include "base/vector.hpp"
#include "covered_town.hpp"
#include "effects/showroom.hpp"
#include "list_sensors.hpp"
#include "pipeline/beam_cells.hpp"
#include "pipeline/beam_places.hpp"
#include "pipeline/origin_groups.hpp"

namespace gnosphere::test {
namespace {

/// A list of beams with everything that a beam can have of its own.
Sensor variedList() {
  Random random(11);
  BeamList beams = rosette(900, 0.5);
  for (size_t i = 0; i < beams.size(); ++i) {
    if (i % 2 == 0) beams.directions[i] = anyDirection(random);
    beams.times[i] = 0.1 * std::abs(random());
    beams.origins.push_back({0.05 * random(), 0.05 * random(), 0.05 * random()});
    beams.rangeMin.push_back(i % 3 == 0 ? 0.5f : 4.0f);
    beams.rangeMax.push_back(i % 4 == 0 ? 15.0f : 60.0f);
    beams.rings.push_back(static_cast<uint16_t>(i % 6));
  }
  Sensor sensor = listSensor("varied", beams, 60);
  sensor.rangeMin = 0.5;
  sensor.rotationPeriod = kPeriod;
  sensor.divergenceHorizontal = 3e-3;
  sensor.divergenceVertical = 1.5e-3;
  sensor.maxReturns = 3;
  sensor.maskedBeams = {5, 17, 301};
  return sensor;
}

}  // namespace

TEST_CASE("ten list sensors equal the reference, with every way of binning and every accuracy", "[combinations]") {
  needVulkan();
  const Scene scene = coveredTown();
  const std::vector<Sensor> sensors = listSensors();
  // The simulators follow one another, because each takes over the compiled kernels of the one before.
  const auto scansWith = [&](const TestOptions& options, const auto& wanted) {
    Simulator simulator = makeSimulator(scene, sensors, options);
    std::vector<Scan> scans(sensors.size());
    for (size_t i = 0; i < sensors.size(); ++i)
      if (wanted(i)) scans[i] = simulator.scan(kPlace, i);
    return scans;
  };
  const auto all = [](size_t) { return true; };
  // Without every combination, some of the sensors have each of the slower ways.
  const auto even = [](size_t i) { return everyCombination() || i % 2 == 0; };
  const auto odd = [](size_t i) { return everyCombination() || i % 2 == 1; };
  const auto halfOfEven = [](size_t i) { return everyCombination() || i % 4 == 2; };
  const auto halfOfOdd = [](size_t i) { return everyCombination() || i % 4 == 1; };
  TestOptions options;
  options.device = DeviceChoice::Kind::reference;
  const std::vector<Scan> reference = scansWith(options, all);
  const std::vector<Scan> slabs = scansWith(optionsWith(Accuracy::standard, Binning::slabs), all);
  const std::vector<Scan> nearest = scansWith(optionsWith(Accuracy::standard, Binning::nearest), odd);
  const std::vector<Scan> lists = scansWith(optionsWith(Accuracy::standard, Binning::lists), even);
  const std::vector<Scan> exact = scansWith(optionsWith(Accuracy::exact), even);
  const std::vector<Scan> exactLists = scansWith(optionsWith(Accuracy::exact, Binning::lists), halfOfEven);
  const std::vector<Scan> draft = scansWith(optionsWith(Accuracy::draft), halfOfOdd);
  for (size_t i = 0; i < sensors.size(); ++i) {
    INFO(sensors[i].name);
    CHECK(slabs[i].counters.hits > 0);
    requireSame(reference[i], slabs[i]);
    if (even(i)) requireSame(reference[i], exact[i]);
    if (odd(i)) CHECK(sameBytes(slabs[i], nearest[i]));
    if (even(i)) CHECK(sameBytes(slabs[i], lists[i]));
    if (halfOfEven(i)) CHECK(sameBytes(exact[i], exactLists[i]));
    if (halfOfOdd(i))
      CHECK(static_cast<double>(draft[i].counters.hits) > 0.99 * static_cast<double>(reference[i].counters.hits));
  }
}

TEST_CASE("no switch of culling changes a byte of a list's scan", "[combinations]") {
  needVulkan();
  const Scene scene = coveredTown();
  const std::vector<Sensor> all = listSensors(), sensors = {all[0], all[5], all[7], all[9]};
  std::vector<Culling> switches(everyCombination() ? 8 : 4);
  switches[1].occlusion = Culling::Occlusion::always;
  switches[2] = {false, false, false, false, Culling::Occlusion::always};
  switches[3] = {false, false, false, false, Culling::Occlusion::never};
  if (switches.size() > 4) switches[4].range = switches[5].rows = switches[6].columns = switches[7].cones = false;
  std::vector<Scan> expected;
  for (size_t k = 0; k < switches.size(); ++k) {
    TestOptions options = optionsWith(Accuracy::standard);
    options.tuning.culling = switches[k];
    Simulator simulator = makeSimulator(scene, sensors, options);
    for (size_t i = 0; i < sensors.size(); ++i) {
      INFO(sensors[i].name << ", switch " << k);
      const Scan scan = simulator.scan(kPlace, i);
      if (k == 0) expected.push_back(scan);
      CHECK(sameBytes(expected[i], scan));
    }
  }
}

TEST_CASE("a grid given as a list has the grid's bytes") {
  needVulkan();
  const Scene scene = coveredTown();
  for (const Accuracy accuracy : {Accuracy::standard, Accuracy::exact}) {
    std::vector<Sensor> sensors;
    for (const char* name : {"VLP-16", "HDL-64E"}) {
      sensors.push_back(builtinSensor(name));
      sensors.push_back(asList(sensors.back()));
    }
    Simulator simulator = makeSimulator(scene, sensors, optionsWith(accuracy));
    for (size_t i = 0; i < sensors.size(); i += 2) {
      INFO(sensors[i].name << ", " << nameOf(accuracy));
      CHECK(sameBytes(simulator.scan(kPlace, i), simulator.scan(kPlace, i + 1)));
    }
  }
}

TEST_CASE("the order of the beams does not change their exact hits") {
  needVulkan();
  const Scene scene = coveredTown();
  const Sensor ordered = listSensors()[2];
  Sensor shuffled = ordered;
  std::vector<size_t> order(ordered.beamCount());
  for (size_t i = 0; i < order.size(); ++i) order[i] = i * 7919 % order.size();
  for (size_t i = 0; i < order.size(); ++i)
    shuffled.patterns[0].directions[i] = ordered.patterns[0].directions[order[i]];
  Simulator simulator = makeSimulator(scene, {ordered, shuffled}, optionsWith(Accuracy::exact));
  const Scan first = simulator.scan(kPlace, 0), second = simulator.scan(kPlace, 1);
  size_t different = 0;
  for (size_t i = 0; i < order.size(); ++i)
    different += std::memcmp(&first.points[3 * order[i]], &second.points[3 * i], 12) != 0 ||
                 first.triangles[order[i]] != second.triangles[i] || first.instances[order[i]] != second.instances[i];
  CHECK(different == 0);
}

TEST_CASE("effects and motion of a list equal the reference") {
  // Each round has two effects, so all 17 are tried.
  for (size_t first = 0; first <= effectNames().size() / 2; ++first)
    CHECK(requireEffects(variedList(), first, (first + 9) % effectNames().size()) > 0.2);
}

// Light that deviates sideways from a beam changes its elevation, too, and more so for a steep beam.
TEST_CASE("wide beams and angle errors of a list near the poles equal the reference") {
  needVulkan();
  MeshBuilder builder;
  builder.quad({-5, -5, 3}, {0, 10, 0}, {5.06, 0, 0});
  builder.quad({0.06, -5, 2.9}, {0, 10, 0}, {5, 0, 0});
  Scene scene = sceneOf(builder.take());
  scene.materials[0].doubleSided = true;
  Sensor grid{"steep", 180, {}, 0, 10};
  for (const double elevation : {90.0, 89.999, 89.9, 89.0, 87.0, 80.0}) grid.channels.push_back({elevation, 0});
  TestOptions wide = vulkanOptions(), astray = vulkanOptions();
  wide.effects.divergence = {EffectUse::on, 7, Effects::Divergence::Profile::gaussian, 0.1, 0.02};
  astray.effects.angleNoise = {EffectUse::on, 0.05, 0, Effects::AngleNoise::At::beam};
  for (TestOptions options : {wide, astray}) {
    options.effects.intensity.use = EffectUse::automatic;
    const Scan found = scanOf(scene, asList(grid), {}, options);
    options.device = DeviceChoice::Kind::reference;
    const Differences result = differences(scanOf(scene, asList(grid), {}, options), found, {0, 1e-3, 2e-3});
    INFO(result.all() << " differences, first: " << result.first);
    CHECK(result.all() == 0);
    CHECK(result.ties < result.beams / 10);
    CHECK(found.counters.hits > found.counters.beams - 10);
  }
}

TEST_CASE("heads far apart in one list have the hits of each head alone") {
  needVulkan();
  const Scene scene = coveredTown();
  const std::vector<Vec3> places = {{0, 0, 0}, {-4, 1.5, 0.5}, {18, 6, 3}};
  const BeamList head = rosette(700, 1.2);
  Sensor rig = listSensor("rig", headsAt(places, head));
  rig.maskedBeams = {4, 5, 6};
  const std::vector<OriginGroup> groups = originGroups(rig, 0);
  REQUIRE(groups.size() == places.size());
  for (const Accuracy accuracy : {Accuracy::standard, Accuracy::exact}) {
    INFO(nameOf(accuracy));
    Simulator simulator = makeSimulator(scene, {rig, listSensor("head", head)}, optionsWith(accuracy));
    const Pose level = {{1.3, 0.4, 1.8}, {}};
    const Scan scan = simulator.scan(level, 0);
    requireSame(referenceOf(scene, rig, level), scan);
    CHECK(scan.counters.hits + scan.counters.misses == rig.beamCount());
    for (size_t k = 0; k < places.size(); ++k) {
      const Vec3& at = places[k];
      const Scan alone =
          simulator.scan({{level.position.x + at.x, level.position.y + at.y, level.position.z + at.z}, {}}, 1);
      size_t different = 0, farther = 0;
      for (size_t i = 0; i < head.size(); ++i) {
        const size_t beam = i * places.size() + k;
        if (beam >= 4 && beam <= 6) continue;
        different += std::memcmp(&alone.ranges[i], &scan.ranges[beam], 4) != 0 ||
                     alone.triangles[i] != scan.triangles[beam] || alone.instances[i] != scan.instances[beam];
        const float* const p = &alone.points[3 * i];
        const float* const q = &scan.points[3 * beam];
        farther += std::hypot(p[0] + at.x - q[0], p[1] + at.y - q[1], p[2] + at.z - q[2]) > 1e-5;
      }
      CHECK(alone.counters.hits > 300);
      CHECK(scan.counters.triangles == places.size() * alone.counters.triangles);
      CHECK(different == 0);
      CHECK(farther == 0);
    }
  }
}

TEST_CASE("a list whose beams start at one point near the sensor's origin is seen from there, and needs no origins") {
  needVulkan();
  const Scene scene = coveredTown();
  const Vec3 at = {0.125, -0.0625, 0.25};
  const BeamList head = rosette(700, 1.2);
  const Sensor away = listSensor("away", headsAt({at}, head));
  const std::vector<OriginGroup> groups = originGroups(away, 0);
  REQUIRE(groups.size() == 1);
  CHECK(groups[0].lasers.centre.x == at.x);
  CHECK(groups[0].lasers.distance == 0);
  for (const Accuracy accuracy : {Accuracy::standard, Accuracy::exact}) {
    INFO(nameOf(accuracy));
    Simulator simulator = makeSimulator(scene, {away, listSensor("head", head)}, optionsWith(accuracy));
    const Scan scan = simulator.scan(Pose{{1.5, 0.5, 1.75}, {}}, 0);
    requireSame(referenceOf(scene, away, {{1.5, 0.5, 1.75}, {}}), scan);
    const Scan moved = simulator.scan(Pose{{1.5 + at.x, 0.5 + at.y, 1.75 + at.z}, {}}, 1);
    CHECK(moved.counters.hits > 300);
    CHECK(std::ranges::equal(scan.ranges, moved.ranges));
    CHECK(std::ranges::equal(scan.triangles, moved.triangles));
    CHECK(std::ranges::equal(scan.instances, moved.instances));
    const auto kernelsOf = [&](size_t sensor) {
      std::vector<std::pair<std::string, std::vector<uint32_t>>> kernels;
      const Plan plan = simulator.plan(sensor);
      for (const Plan::Stage& stage : plan.stages)
        for (const Plan::Pipeline& pipeline : stage.pipelines) kernels.emplace_back(pipeline.name, pipeline.constants);
      return kernels;
    };
    CHECK(kernelsOf(0) == kernelsOf(1));
  }
}

TEST_CASE("patterns with heads far apart and with one head alternate") {
  needVulkan();
  const BeamList head = rosette(300, 1.2);
  Sensor rig = listSensor("rig", headsAt({{0, 0, 0}, {-4, 1.5, 0.5}, {18, 6, 3}}, head));
  rig.patterns.push_back(headsAt({{0.1, 0, 0}, {0, 0.1, 0}, {0, 0, 0.1}}, head));
  TestOptions options = optionsWith(Accuracy::standard);
  Simulator device = makeSimulator(coveredTown(), rig, options);
  options.device = DeviceChoice::Kind::reference;
  Simulator reference = makeSimulator(coveredTown(), rig, options);
  Shot shot;
  shot.pose = {{1.3, 0.4, 1.8}, {}};
  for (; shot.frame < 4; ++shot.frame) {
    INFO("frame " << shot.frame);
    Scan expected, found;
    reference.scanInto(shot, expected);
    device.scanInto(shot, found);
    requireSame(expected, found);
  }
}

TEST_CASE("lasers are grouped by place, whatever the order of the beams") {
  Sensor sensor = listSensors()[8];
  std::vector<Vec3>& origins = sensor.patterns[0].origins;
  const auto groupsOf = [&] {
    std::vector<std::vector<double>> groups;
    size_t beams = 0;
    for (const OriginGroup& group : originGroups(sensor, 0)) {
      beams += group.beams.size();
      const Vec3& centre = group.lasers.centre;
      CHECK(group.lasers.distance <= 0.52);  // the reference relies on it
      groups.push_back({centre.x, centre.y, centre.z, static_cast<double>(group.beams.size())});
    }
    CHECK(beams == sensor.beamCount());
    return groups;
  };
  const std::vector<std::vector<double>> expected = groupsOf();
  CHECK(expected.size() > 150);
  std::reverse(origins.begin(), origins.end());
  CHECK(groupsOf() == expected);
  origins.assign(origins.size(), {0.1, -0.2, 0.1});
  CHECK(groupsOf() == std::vector<std::vector<double>>{{0.1, -0.2, 0.1, 250}});
  origins[7] = {0.1, -0.2, 0.15};
  CHECK(groupsOf() == std::vector<std::vector<double>>{{0, 0, 0, 250}});  // one head is seen from the sensor's origin
  origins.assign(origins.size(), {10, -0.2, 0.1});
  CHECK(groupsOf() == std::vector<std::vector<double>>{{10, -0.2, 0.1, 250}});
}

TEST_CASE("effects and motion of heads far apart equal the reference") {
  Sensor sensor = variedList();
  for (size_t i = 0; i < sensor.patterns[0].origins.size(); ++i) sensor.patterns[0].origins[i].x += 3.0 * double(i % 3);
  const auto of = [](const char* name) {
    const std::vector<std::string>& names = effectNames();
    return static_cast<size_t>(std::find(names.begin(), names.end(), name) - names.begin());
  };
  CHECK(requireEffects(sensor, of("sensor-motion"), of("transmission")) > 0.2);
  CHECK(requireEffects(sensor, of("object-motion"), of("divergence")) > 0.2);
}

TEST_CASE("CUDA's kernels give the bytes of Vulkan's for lists") {
  Scene scene = sceneOf(soup(9, 300, 20, 25));
  const std::vector<Sensor> sensors = listSensors();
  for (const Accuracy accuracy : {Accuracy::standard, Accuracy::exact}) {
    Twins twins(scene, sensors, optionsWith(accuracy));
    for (size_t i = 0; i < sensors.size(); ++i) {
      INFO(sensors[i].name << ", " << nameOf(accuracy));
      Shot shot;
      shot.pose = kPlace;
      shot.sensor = i;
      CHECK(twins.scan(shot).counters.hits > 0);
    }
  }
  const std::vector<std::string>& names = effectNames();
  const auto of = [&](const char* name) {
    return static_cast<size_t>(std::find(names.begin(), names.end(), name) - names.begin());
  };
  Twins moving(showroom(), {variedList()}, pairOptions(of("sensor-motion"), of("transmission")));
  CHECK(moving.scan(shotOf(true)).counters.hits > 0);
}

TEST_CASE("real heads equal the reference, standing and moving", "[combinations]") {
  needVulkan();
  std::vector<Sensor> heads;
  for (const CatalogueHead& head : sensorCatalogue())
    if (everyCombination() || head.name == "Puck" || head.name == "RS-Bpearl" || head.name == "TiM781")
      heads.push_back(builtinSensor(head.name));
  REQUIRE(heads.size() >= 3);
  const Scene scene = coveredTown();
  TestOptions options = optionsWith(Accuracy::standard);
  options.effects.sensorMotion.use = EffectUse::automatic;
  Simulator device = makeSimulator(scene, heads, options);
  options.device = DeviceChoice::Kind::reference;
  Simulator reference = makeSimulator(scene, heads, options);
  for (size_t i = 0; i < heads.size(); ++i)
    for (const bool moving : {false, true}) {
      INFO(heads[i].name << (moving ? ", moving" : ", standing"));
      Shot shot;
      shot.pose = kPlace;
      shot.sensor = i;
      // 20 m/s and 2 rad/s, from before the first beam to after the last.
      if (moving)
        shot.motion.stamps = {{-0.1, {{-0.7, 0.4, 1.8}, {0, 0, 0.2, 0.98}}},
                              {0.2, {{5.3, 0.4, 1.8}, {0, 0, 0.47, 0.88}}}};
      Scan expected, found;
      reference.scanInto(shot, expected);
      device.scanInto(shot, found);
      CHECK(found.counters.hits > 0);
      requireSame(expected, found);
    }
}

TEST_CASE("every spinning head has rows, and each beam lies behind its place as its row says") {
  constexpr double kTurn = 2 * std::numbers::pi;
  size_t grids = 0;
  for (const CatalogueHead& head : sensorCatalogue()) {
    const Sensor sensor = builtinSensor(head.name);
    if (!sensor.isGrid()) continue;
    INFO(head.name);
    ++grids;
    const std::optional<RowGrid> grid = rowGridOf(sensor);
    REQUIRE(grid);
    CHECK(grid->rows.size() == sensor.channels.size());
    std::vector<bool> taken(sensor.beamCount());
    double worst = 0;
    for (const RowGrid::Row& row : grid->rows)
      for (uint32_t i = 0; i < grid->taken; ++i) {
        const size_t beam = size_t{row.channel} * sensor.columns + grid->columnAt(i);
        taken[beam] = true;
        const double place = (azimuthOf(sensor, beam) / kTurn + 0.5) * grid->columns - grid->phase;
        const double behind = row.behind + grid->stretch * i / std::max(1u, grid->taken - 1);
        worst = std::max(worst, std::abs(std::remainder(place - (int64_t{i} + row.first) - behind, grid->columns)));
        CHECK_FALSE(behind > grid->beside + 1e-9);
        // The beam fires when the table of moments says so.
        const ScanTimes times = scanTimesOf(*grid, sensor);
        const double time = times.first + (i + row.lag + grid->before()) * times.step;
        worst = std::max(worst, std::abs(time - timeOf(sensor, beam)));
      }
    CHECK(worst < 1e-7);
    CHECK(std::count(taken.begin(), taken.end(), false) == 0);
  }
  CHECK(grids > 20);
}

TEST_CASE("lasers of a moving sensor see the scene at their own times") {
  Sensor offsets = smallSensor();
  offsets.name = "time offsets";
  for (size_t j = 0; j < offsets.channels.size(); ++j) offsets.channels[j].timeOffset = 0.004 * double(j) - 0.01;
  const auto motion = [](const char* name) {
    const std::vector<std::string>& names = effectNames();
    return static_cast<size_t>(std::find(names.begin(), names.end(), name) - names.begin());
  };
  CHECK(requireEffects(offsets, motion("sensor-motion"), motion("object-motion")) > 0.2);
}

TEST_CASE("a near surface hides what is behind it, or lets the beam pass") {
  Scene scene = sceneOf(plate(0.5, 0.2));
  scene.meshes.push_back(plate(10, 20));
  scene.instances.push_back({"", 1, {}});
  Sensor sensor = fan(90, 5, 10, 50);
  sensor.rangeMin = 1;
  for (const std::string device : {"reference", "vulkan"}) {
    INFO(device);
    TestOptions options = optionsOn(device);
    sensor.nearHits = NearHits::seeThrough;
    const float through = scanOf(scene, sensor, {}, options).ranges[ahead(sensor, 2)];
    sensor.nearHits = NearHits::hide;
    const Scan hidden = scanOf(scene, sensor, {}, options);
    CHECK(through == 10);
    CHECK(std::isnan(hidden.ranges[ahead(sensor, 2)]));
    CHECK(hidden.ranges[ahead(sensor, 2) + 11] > 10);  // beside the near plate
    TestOptions lists = options;
    lists.tuning.binning = Binning::lists;
    lists.effects = Effects::none();
    CHECK(std::isnan(scanOf(scene, sensor, {}, lists).ranges[ahead(sensor, 2)]));
    options.effects.intensity.use = options.effects.returns.use = EffectUse::on;
    options.fields = {Field::intensity};
    CHECK(std::isnan(scanOf(scene, sensor, {}, options).ranges[ahead(sensor, 2)]));
  }
}

TEST_CASE("beams behind the seam alone meet a triangle that lies across it") {
  needVulkan();
  const double pi = std::numbers::pi;
  Random random(6);
  BeamList beams;
  for (const double elevation : {-0.01, 0.0, 0.01}) {
    beams.directions.push_back(directionAt(0.03 - pi, elevation));
    for (int i = 0; i < 17; ++i) beams.directions.push_back(directionAt(1.5 * random(), elevation));
  }
  MeshBuilder pane;
  pane.triangle({-10, 1, -1}, {-10, -1, -1}, {-10, 0, 2});
  const Sensor sensor = listSensor("seam", beams);
  const Scene scene = sceneOf(pane.take());
  for (const Binning binning : {Binning::slabs, Binning::nearest, Binning::lists}) {
    TestOptions options = vulkanOptions();
    options.tuning.binning = binning;
    const Scan scan = scanOf(scene, sensor, {}, options);
    CHECK(scan.counters.hits == 3);
    for (const size_t beam : {0, 18, 36}) CHECK(std::abs(scan.points[3 * beam] + 10) < 1e-4);
  }
}

// A beam may lie before the column of its cell by a ten-thousandth of a column. So few beams have 64 columns, and those
// at azimuths of their own keep the list off a grid.
TEST_CASE("beams just before a column meet triangles that end between the two") {
  needVulkan();
  const double width = 2 * std::numbers::pi / 64;
  BeamList beams;
  MeshBuilder panes;
  for (const double elevation : {-0.2, 0.0, 0.3})
    for (int i = 0; i < 20; ++i) {
      const bool before = i < 16;
      const double column = i * 3 + 1 - 32, azimuth = width * (before ? column - 9.7e-5 : column + 0.1234 * (i - 15));
      beams.directions.push_back(directionAt(azimuth, elevation));
      const double from = azimuth - 0.01, to = before ? width * (column - 7e-5) : azimuth + 0.01;
      const Vec3 low = 10 * directionAt(from, elevation - 0.01), right = 10 * directionAt(from, elevation + 0.01),
                 up = 10 * directionAt(to, elevation - 0.01), last = 10 * directionAt(to, elevation + 0.01);
      panes.triangle(low, up, last);
      panes.triangle(low, last, right);
    }
  const Scene scene = sceneOf(panes.take());
  const Sensor sensor = listSensor("before columns", beams);
  for (const Binning binning : {Binning::slabs, Binning::nearest, Binning::lists}) {
    TestOptions options = vulkanOptions();
    options.tuning.binning = binning;
    CHECK(scanOf(scene, sensor, {}, options).counters.hits == beams.size());
  }
}

TEST_CASE("scan number n of a list fires pattern n, and columns tell its beams") {
  const Scene scene = coveredTown();
  Sensor sensor;
  sensor.name = "two patterns";
  sensor.rangeMax = 100;
  for (const double phase : {0.0, 0.5}) sensor.patterns.push_back(rosette(500, 0.4, phase));
  sensor.patterns[0].rings.assign(500, 3);
  for (const std::string device : {"reference", "vulkan"}) {
    INFO(device);
    TestOptions options = optionsOn(device);
    options.fields = {Field::azimuth, Field::ring, Field::time};
    Simulator simulator = makeSimulator(scene, sensor, options);
    for (const uint64_t frame : {0u, 1u, 2u, 7u}) {
      Sensor alone = sensor;
      alone.patterns = {sensor.patterns[frame % 2]};
      Shot shot;
      shot.pose = kPlace;
      shot.frame = frame;
      Scan scan;
      simulator.scanInto(shot, scan);
      CHECK(sameBytes(scan, scanOf(scene, alone, kPlace, options)));
      const Vec3& d = alone.patterns[0].directions[123];
      CHECK(scan.column<float>(Field::azimuth)[123] == static_cast<float>(std::atan2(d.y, d.x)));
      CHECK(scan.column<float>(Field::time)[123] == static_cast<float>(alone.patterns[0].times[123]));
      CHECK(scan.column<uint16_t>(Field::ring)[123] == (frame % 2 == 0 ? 3 : 0));
    }
  }
}

TEST_CASE("the accuracy paper refuses what is no even grid of a full turn, and names the cause") {
  const auto causeOf = [](const Sensor& sensor) -> std::string {
    try {
      scanOf(coveredTown(), sensor, {}, optionsWith(Accuracy::paper));
    } catch (const Error& error) {
      const std::string message = error.what(), start = "sensor '" + sensor.name + "' ";
      CHECK(message.starts_with(start));
      return message.substr(start.size(), message.find(", which the accuracy 'paper' does not know") - start.size());
    }
    return "";
  };
  const auto changed = [](auto change) {
    Sensor sensor = gridSensor(60, 5, -20, 20, 80);
    sensor.rangeMin = 0.5;
    change(sensor);
    return sensor;
  };
  CHECK(causeOf(listSensors()[0]) == "is a list of beams");
  CHECK(causeOf(changed([](Sensor& s) { s.azimuthStartDeg = 180, s.azimuthSpanDeg = -360; })) == "turns clockwise");
  CHECK(causeOf(changed([](Sensor& s) { s.azimuthSpanDeg = 90; })) == "covers a sector");
  CHECK(causeOf(changed([](Sensor& s) { s.azimuthStartDeg = 0; })) == "does not start at -180 degrees");
  CHECK(causeOf(changed([](Sensor& s) { s.maskedBeams = {7}; })) == "has masked beams");
  CHECK(causeOf(changed([](Sensor& s) { s.nearHits = NearHits::hide; })) == "hides near hits");
  CHECK(causeOf(changed([](Sensor& s) { s.channels[1].rangeMax = 9; })) ==
        "has channels with range windows of their own");
  // The steps are 10 degrees.
  CHECK(causeOf(changed([](Sensor& s) { s.channels[1].elevationDeg = -9.7; })) == "has elevations at uneven steps");
  CHECK(causeOf(changed([](Sensor& s) { s.channels[1].elevationDeg = -9.9; })) == "");
  CHECK(causeOf(changed([](Sensor& s) { std::swap(s.channels[1], s.channels[4]); })) == "");
  CHECK(causeOf(changed([](Sensor& s) { s.channels.resize(2), s.channels[1] = s.channels[0]; })) ==
        "has elevations at uneven steps");
  CHECK(causeOf(changed([](Sensor& s) { s.channels.resize(1); })) == "");
}

}  // namespace gnosphere::test

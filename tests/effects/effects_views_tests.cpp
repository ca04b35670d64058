// SPDX-License-Identifier: Apache-2.0
// Shots with effects that are submitted together, as views, give the same results as single scans.
#include <algorithm>
#include <catch2/generators/catch_generators.hpp>
#include <tuple>

#include "effects/showroom.hpp"

namespace gnosphere::test {
namespace {

constexpr uint32_t kWorlds = 3;
const std::vector<Binning> kNone, kCards = {Binning::nearest}, kLists = {Binning::lists},
                                  kBoth = {Binning::nearest, Binning::lists};

// The showroom, whose box and grating are in a world each, and a second box in every world.
Scene showrooms() {
  Scene scene = showroom();
  scene.instances[2].world = 2;
  scene.instances[3].world = 1;
  for (uint32_t world = 0; world < kWorlds; ++world) {
    Instance box = scene.instances[3];
    box.world = world;
    box.transform = translation(4.0 - world, -5.0 + world, 0.3);
    scene.instances.insert(scene.instances.begin() + world, box);
  }
  return scene;
}

std::vector<Shot> shotsInWorlds(size_t count) {
  std::vector<Shot> shots(count);
  for (size_t i = 0; i < count; ++i) {
    const double turn = 0.4 * static_cast<double>(i);
    shots[i].pose = {{1.5 * std::sin(turn), 0.2 * static_cast<double>(i), 0.1}, {0, 0, std::sin(turn), std::cos(turn)}};
    if (i == 2) shots[i].pose.position.x = 900;  // sees nothing
    shots[i].world = static_cast<uint32_t>(i % kWorlds);
    shots[i].frame = 3 * i;
  }
  return shots;
}

size_t numberOf(const std::string& name) {
  return static_cast<size_t>(std::find(effectNames().begin(), effectNames().end(), name) - effectNames().begin());
}

// Scans the shots together, in `most` submissions or fewer, then one by one, each in submissions of one view, and then
// together by CUDA's kernels on the host.
void checkTogether(const Sensor& sensor, std::span<const Shot> shots, TestOptions options, uint64_t most = 1) {
  static const Scene scene = showrooms();
  uint64_t submissions = 0;
  options.tuning.culling.occlusion = Culling::Occlusion::never;  // a submission has one such step if it has one shell
  options.trace = [&](const std::string& line) { submissions += line.find("project_groups") != line.npos; };
  Simulator simulator = makeSimulator(scene, sensor, options);
  std::vector<Scan> together(shots.size());
  simulator.scanAll(shots, [&](size_t i, const Scan& scan) { together[i] = scan; });
  submissions = 0;
  simulator.scanAll(shots, [](size_t, const Scan&) {});
  const uint64_t ofAll = submissions;
  uint64_t hits = 0;
  TestOptions oneByOne = options;
  oneByOne.tuning.maxBatchBytes = 1;
  Simulator single = makeSimulator(scene, sensor, oneByOne);
  for (size_t i = 0; i < shots.size(); ++i) {
    INFO("shot " << i);
    Scan alone;
    single.scanInto(shots[i], alone);
    CHECK(firstBytes(alone, together[i]) == "none");
    CHECK(together[i].counters.hits == alone.counters.hits);
    CHECK(together[i].counters.misses == alone.counters.misses);
    hits += alone.counters.hits;
  }
  if (dividesExactly(simulator.device())) {
    Scan scan;
    CudaOnHost(scene, {sensor}, options).backend().scanAll(shots, scan, [&](size_t i) {
      INFO("CUDA, shot " << i);
      CHECK(firstBytes(together[i], scan) == "none");
    });
  }
  CHECK(hits > 100);
  CHECK(ofAll > 0);
  CHECK(ofAll <= most);
}

// Lets the sensor move, in another way during each shot.
void move(std::vector<Shot>& shots) {
  for (size_t i = 0; i < shots.size(); ++i) {
    Pose end = shots[i].pose;
    end.position.x += 0.2 * static_cast<double>(i);
    end.position.y -= 0.3;
    end.orientation.z += 0.02 * static_cast<double>(i);
    shots[i].motion.stamps = {{0, shots[i].pose}, {kPeriod, end}};
  }
}

// Lets instances of the common world and of each shot's own world move, in another way during each shot; during one of
// them nothing but the sensor moves.
void moveInstances(std::vector<Shot>& shots) {
  const Scene scene = showrooms();
  for (size_t i = 0; i < shots.size(); ++i) {
    if (i == 4 && !shots[i].motion.stamps.empty()) continue;
    const double far = 0.1 + 0.15 * static_cast<double>(i);
    for (size_t instance = i % 2; instance < scene.instances.size(); instance += 2)
      if (scene.instances[instance].world == 0 || scene.instances[instance].world == shots[i].world)
        shots[i].instanceMotions.push_back(
            {instance, translation(-far, far / 2, 0.1 * far) * scene.instances[instance].transform * rotationZ(far)});
  }
}

// Checks with the settings of the device, with some other ways of binning, and in slow tests with all of them: as on
// graphics cards (`nearest`), and as on devices without 64-bit atomics (`lists`).
void checkInWays(const Sensor& sensor, std::span<const Shot> shots, const TestOptions& options,
                 std::vector<Binning> others, uint64_t most = 1) {
  checkTogether(sensor, shots, options, most);
  if (everyCombination()) others = kBoth;
  for (const Binning binning : others) {
    INFO("binning " << static_cast<int>(binning));
    TestOptions other = options;
    other.tuning.binning = binning;
    if (binning == Binning::nearest) other.tuning.subRays = SubRays::lanes;
    checkTogether(sensor, shots, other, most);
  }
}

}  // namespace

TEST_CASE("views with several effects have the bytes of single scans", "[combinations]") {
  needVulkan();
  const std::vector<Shot> shots = shotsInWorlds(7);
  std::vector<std::vector<std::string>> effects = {{"intensity", "cut-outs", "drop-out", "volumes"},
                                                   {"detection", "sensor-motion", "range-noise", "fog"},
                                                   {"object-motion", "radial-speed", "angle-noise", "snow"},
                                                   {"angle-noise", "rain", "returns", "transmission"},
                                                   {"divergence", "transmission", "cut-outs", "returns"}};
  if (everyCombination())
    effects.insert(effects.end(), {{"intensity", "cut-outs"},
                                   {"detection", "sensor-motion"},
                                   {"drop-out", "object-motion"},
                                   {"range-noise", "fog"},
                                   {"angle-noise", "snow"},
                                   {"angle-noise", "rain"},
                                   {"divergence", "cut-outs", "returns"},
                                   {"divergence", "transmission", "angle-noise"},
                                   {"divergence", "cut-outs"},
                                   {"divergence", "returns"},
                                   {"divergence", "transmission"},
                                   {"divergence", "angle-noise"},
                                   {"returns", "transmission"},
                                   {"volumes", "radial-speed"}});
  for (const std::vector<std::string>& together : effects) {
    INFO(together[0] << ", " << together[1]);
    TestOptions options = pairOptions(numberOf(together[0]), numberOf(together[1]));
    for (const std::string& effect : together) effectTable()[numberOf(effect)].use(options.effects) = EffectUse::on;
    if (together[1] == "radial-speed") options.fields.push_back(Field::radialSpeed);
    const bool panes = std::ranges::find(together, "transmission") != together.end();
    checkInWays(smallSensor(), shots, options, panes ? kCards : kNone);
  }
}

TEST_CASE("views of shots with different numbers of dust boxes have the bytes of single scans") {
  needVulkan();
  std::vector<Shot> shots = shotsInWorlds(7);
  for (size_t i = 0; i < shots.size(); ++i) {
    std::vector<Effects::Volume>& boxes = shots[i].weather.emplace().volumes;
    for (size_t k = 0; k < 2 * i % 3; ++k) {
      const double x = 2.0 + 3.0 * static_cast<double>(k);
      boxes.push_back({{x, -6, -2}, {x + 2, 8, 4}, 0.05 * static_cast<double>(i)});
    }
  }
  checkTogether(smallSensor(), shots, pairOptions(numberOf("volumes"), numberOf("returns")));
}

TEST_CASE("views of a sensor that moves have the bytes of single scans", "[combinations]") {
  needVulkan();
  std::vector<Shot> shots = shotsInWorlds(7);
  move(shots);
  Sensor list = gridSensor(0, 0, 0, 0);
  list.patterns = {beamsOf(gridSensor(61, 13, -40, 35))};
  list.rotationPeriod = kPeriod;
  for (size_t i = 0; i < list.patterns[0].directions.size(); ++i)
    list.patterns[0].times.push_back(kPeriod * static_cast<double>(i * 37 % 793) / 793);
  Sensor grid = gridSensor(90, 16, -30, 30);
  grid.rotationPeriod = kPeriod;
  const std::vector<std::tuple<std::string, Sensor, std::string>> cases = {{"grid", grid, "intensity"},
                                                                           {"head", smallSensor(), "returns"},
                                                                           {"head", smallSensor(), "divergence"},
                                                                           {"head", smallSensor(), "radial-speed"},
                                                                           {"list", list, "cut-outs"}};
  for (const auto& [name, sensor, effect] : cases) {
    if (effect == "returns" && !everyCombination()) continue;  // the next test has returns of a sensor that moves
    INFO(name << ", " << effect);
    TestOptions options = pairOptions(numberOf("sensor-motion"), numberOf(effect));
    checkInWays(sensor, shots, options, effect == "divergence" ? kCards : name == "list" ? kLists : kNone);
    if (effect != "intensity") continue;
    options.fields.clear();
    options.effects.intensity.use = EffectUse::off;
    checkInWays(sensor, shots, options, kNone);
  }
}

TEST_CASE("views in which instances move have the bytes of single scans", "[combinations]") {
  needVulkan();
  const bool driving = GENERATE(false, true);
  std::vector<Shot> shots = shotsInWorlds(7);
  for (Shot& shot : shots)
    if (!driving) shot.pose = shots[0].pose;  // a sensor that stands is no reason to scan shot by shot
  if (driving) move(shots);
  moveInstances(shots);
  Sensor grid = gridSensor(90, 16, -30, 30);
  grid.rotationPeriod = kPeriod;
  grid.divergenceHorizontal = grid.divergenceVertical = 2e-3;
  for (const char* effect : {"radial-speed", "returns", "divergence"}) {
    INFO(effect << (driving ? ", driving" : ", at rest"));
    TestOptions options = pairOptions(numberOf("object-motion"), numberOf(effect));
    if (driving) options.effects.sensorMotion.use = EffectUse::on;
    checkInWays(effect == std::string("returns") ? smallSensor() : grid, shots, options,
                effect == std::string("divergence") ? kCards : kNone);
    if (!driving) continue;
    std::vector<Shot> mixed = shots;
    for (const size_t i : {2, 3, 6}) mixed[i].motion.stamps.clear();
    checkTogether(grid, mixed, options, 4);
  }
}

// Shots in which nothing moves are submitted apart from the others.
TEST_CASE("shots that stand among shots that move have the bytes of single scans") {
  needVulkan();
  std::vector<Shot> shots = shotsInWorlds(7), moving = shots;
  move(moving);
  moveInstances(moving);
  for (const size_t i : {1, 2, 5}) shots[i] = moving[i];
  shots[3].instanceMotions = moving[3].instanceMotions;
  Sensor grid = gridSensor(90, 16, -30, 30);
  grid.rotationPeriod = kPeriod;
  checkTogether(grid, shots, pairOptions(numberOf("sensor-motion"), numberOf("object-motion")), 6);
}

// Views have numbers of instances of their own, in the arrays that a single scan uses, too.
TEST_CASE("a scan after views finds the same owners as before them") {
  needVulkan();
  const std::vector<Shot> shots = shotsInWorlds(7);
  Simulator simulator = makeSimulator(showrooms(), gridSensor(90, 16, -30, 30),
                                      pairOptions(numberOf("intensity"), numberOf("detection")));
  Scan before, after;
  for (Scan* scan : {&before, &after}) {
    simulator.scanInto(shots[1], *scan);
    simulator.scanAll(shots, [](size_t, const Scan&) {});
  }
  CHECK(before.counters.hits > 0);
  CHECK(firstBytes(before, after) == "none");
}

// A list of three patterns, whose beams have times and ranges of their own.
Sensor threePatterns() {
  Sensor list = gridSensor(0, 0, 0, 0);
  list.rotationPeriod = kPeriod;
  list.divergenceHorizontal = list.divergenceVertical = 2e-3;
  for (const double shift : {0.0, 3.0, -4.0}) {
    BeamList& pattern = list.patterns.emplace_back(beamsOf(gridSensor(61, 13, -40 + shift, 35 + shift)));
    for (size_t i = 0; i < pattern.size(); ++i) {
      pattern.times.push_back(kPeriod * static_cast<double>(i * 37 % 793) / 793);
      pattern.rangeMin.push_back(0.1f * static_cast<float>(i % 5));
      pattern.rangeMax.push_back(shift == 0 ? 60.0f : 50.0f + static_cast<float>(i % 7));
    }
  }
  list.maskedBeams = {7, 300, 301};
  return list;
}

// Moves the beams of all patterns but the last one to three places; the third one has few beams.
Sensor headsApart(Sensor list) {
  const Vec3 places[] = {{0, 0, 0.2}, {-2, 1, 0.5}, {1.5, -2, 0}};
  for (size_t k = 0; k + 1 < list.patterns.size(); ++k)
    for (size_t i = 0; i < list.patterns[k].size(); ++i)
      list.patterns[k].origins.push_back(places[i % 31 == 0 ? 2 : i % 2]);
  list.patterns.back().origins.resize(list.patterns.back().size(), places[1]);
  return list;
}

TEST_CASE("views of lists with several patterns, and of heads far apart, have the bytes of single scans",
          "[combinations]") {
  needVulkan();
  const bool apart = GENERATE(false, true);
  const Sensor list = apart ? headsApart(threePatterns()) : threePatterns();
  std::vector<Shot> shots = shotsInWorlds(7), moving = shots;
  move(moving);
  moveInstances(moving);
  // The place with few beams has tables of another size, so such a sensor is scanned shot by shot.
  const uint64_t most = apart ? 2 * shots.size() : 1;
  const auto check = [&](const char* effect, bool moves, bool always) {
    if (!always && !everyCombination()) return;
    INFO(effect << (apart ? ", apart" : "") << (moves ? ", moving" : ""));
    TestOptions options = pairOptions(numberOf("sensor-motion"), numberOf(effect));
    if (moves) options.effects.objectMotion.use = EffectUse::on;
    checkInWays(list, moves ? moving : shots, options, kNone, most);
  };
  check("returns", false, !apart);
  check("returns", true, false);
  check("transmission", false, false);
  check("transmission", true, apart);
  check("divergence", false, false);
  check("divergence", true, !apart);
  TestOptions bare = pairOptions(0, 0);
  bare.effects = Effects::none();
  bare.fields.clear();
  checkInWays(list, shots, bare, apart ? kCards : kLists, most);
}

}  // namespace gnosphere::test

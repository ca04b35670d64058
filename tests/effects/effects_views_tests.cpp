// SPDX-License-Identifier: Apache-2.0
// Shots with effects that are submitted together, as views, give the same results as single scans.
#include <algorithm>

#include "effects/showroom.hpp"

namespace gnosphere::test {
namespace {

constexpr uint32_t kWorlds = 3;

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

// Scans the shots together, and then one by one. Returns the number of submissions of the shots together.
uint64_t checkTogether(const Sensor& sensor, std::span<const Shot> shots, TestOptions options) {
  static const Scene scene = showrooms();
  uint64_t submissions = 0;
  options.trace = [&](const std::string& line) { submissions += line.find("project_groups") != line.npos; };
  Simulator simulator = makeSimulator(scene, sensor, options);
  std::vector<Scan> together(shots.size());
  simulator.scanAll(shots, [&](size_t i, const Scan& scan) { together[i] = scan; });
  submissions = 0;
  simulator.scanAll(shots, [](size_t, const Scan&) {});
  const uint64_t ofAll = submissions;
  uint64_t hits = 0;
  for (size_t i = 0; i < shots.size(); ++i) {
    INFO("shot " << i);
    Scan alone;
    simulator.scanInto(shots[i], alone);
    CHECK(firstBytes(alone, together[i]) == "none");
    CHECK(together[i].counters.hits == alone.counters.hits);
    CHECK(together[i].counters.misses == alone.counters.misses);
    hits += alone.counters.hits;
  }
  CHECK(hits > 100);
  return ofAll;
}

}  // namespace

TEST_CASE("views with pairs of effects have the bytes of single scans") {
  needVulkan();
  const std::vector<Shot> shots = shotsInWorlds(7);
  const std::vector<std::pair<std::string, std::string>> pairs = {
      {"intensity", "cut-outs"},     {"detection", "sensor-motion"}, {"drop-out", "object-motion"},
      {"range-noise", "fog"},        {"angle-noise", "snow"},        {"angle-noise", "rain"},
      {"divergence", "cut-outs"},    {"divergence", "returns"},      {"divergence", "transmission"},
      {"divergence", "angle-noise"}, {"returns", "transmission"},    {"volumes", "radial-speed"}};
  for (const auto& [first, second] : pairs) {
    INFO(first << " and " << second);
    const auto numberOf = [](const std::string& name) {
      return size_t(std::find(effectNames().begin(), effectNames().end(), name) - effectNames().begin());
    };
    const uint64_t submissions = checkTogether(smallSensor(), shots, optionsOf(numberOf(first), numberOf(second)));
    CHECK(submissions == 1);
  }
}

}  // namespace gnosphere::test

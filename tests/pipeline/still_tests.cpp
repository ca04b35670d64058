// SPDX-License-Identifier: Apache-2.0
// Reusing the still part of earlier scans changes no byte.
#include <algorithm>

#include "support.hpp"

namespace gnosphere::test {
namespace {

constexpr uint32_t kMeshes = 3;

Transform somewhere(Random& random) {
  return translation(25 * random(), 25 * random(), 4 * random()) * rotationZ(3 * random()) *
         scaling(random() > 0.7 ? -1 : 1, 1, 1 + random() / 2);
}

Scene startingScene(Random& random, uint32_t instances) {
  Scene scene;
  scene.materials = {material(false)};
  scene.meshes = {ball(10, 16, 2), soup(4, 500, 6, 1.5), soup(5, 3, 2, 1)};
  for (uint32_t i = 0; i < instances; ++i) scene.instances.push_back({"", i % kMeshes, somewhere(random)});
  // Copies make ties between instances before and after them in the numbering.
  for (uint32_t i = 0; i < 3; ++i) scene.instances.push_back(scene.instances[2 * i]);
  return scene;
}

std::vector<Sensor> sensors() {
  std::vector<Sensor> sensors = {gridSensor(360, 24, -40, 40, 60), gridSensor(240, 12, -20, 20, 40)};
  for (size_t j = 0; j < sensors[1].channels.size(); ++j) sensors[1].channels[j].azimuthOffsetDeg = 0.4 * double(j % 3);
  return sensors;
}

/// A simulator that reuses the still part and one that does not, with the same changes.
class Pair {
 public:
  Pair(const Scene& scene, TestOptions options, const std::vector<Sensor>& with = sensors())
      : scene_(scene), kept_(makeSimulator(scene, with, options)), there_(scene.instances.size(), true) {
    options.tuning.keepStill = false;
    whole_ = std::make_unique<Simulator>(makeSimulator(scene, with, options));
  }

  void move(size_t instance, const Transform& transform) {
    if (!there_[instance]) return;
    kept_.setTransform(instance, transform);
    whole_->setTransform(instance, transform);
  }
  void add(uint32_t mesh, const Transform& transform) {
    const size_t index = kept_.addInstance(mesh, transform);
    REQUIRE(whole_->addInstance(mesh, transform) == index);
    there_.resize(std::max(there_.size(), index + 1));
    there_[index] = true;
  }
  void remove(size_t instance) {
    if (!there_[instance]) return;
    kept_.removeInstance(instance);
    whole_->removeInstance(instance);
    there_[instance] = false;
  }
  void bend(size_t mesh, Random& random) {
    std::vector<float> positions = scene_.meshes[mesh].positions;
    for (float& value : positions) value += static_cast<float>(0.3 * random());
    if (random() > 0.5) positions[4] = NAN;
    kept_.setPositions(mesh, positions);
    whole_->setPositions(mesh, positions);
  }
  void change(Random& random) {
    const double kind = random();
    const size_t instance = random.bits() % there_.size();
    if (kind < 0.5)
      move(random.bits() % 4, somewhere(random));
    else if (kind < 0.6)
      move(instance, somewhere(random));
    else if (kind < 0.75)
      add(random.bits() % kMeshes, somewhere(random));
    else if (kind < 0.9)
      remove(instance);
    else
      bend(random.bits() % kMeshes, random);
  }

  /// Requires that every scan is the same in both; returns the counters of the one that reuses.
  std::vector<Counters> requireSame(std::span<const Shot> shots) {
    std::vector<Scan> expected;
    whole_->scanAll(shots, [&](size_t, const Scan& scan) { expected.push_back(scan); });
    std::vector<Counters> counters;
    kept_.scanAll(shots, [&](size_t i, const Scan& scan) {
      INFO("shot " << i);
      REQUIRE(sameBytes(scan, expected[i]));
      REQUIRE(expected[i].counters.reused == 0);
      const Counters& c = scan.counters;
      REQUIRE(c.hits == expected[i].counters.hits);
      REQUIRE(c.triangles == expected[i].counters.triangles);
      REQUIRE(c.triangles == c.nonFinite + c.degenerate + c.culledByCluster + c.reused + c.culledByRange +
                                 c.culledByFace + c.culledBetweenBeams + c.culledHidden + c.projected);
      counters.push_back(c);
    });
    return counters;
  }

  Simulator& kept() { return kept_; }

 private:
  Scene scene_;
  Simulator kept_;
  std::unique_ptr<Simulator> whole_;
  std::vector<bool> there_;
};

/// Random changes and scans: the sensor mostly stays, some rounds have no change, and some runs have many shots.
void standAndLook(const TestOptions& options, uint32_t seed, int rounds) {
  Random random(seed);
  Pair pair(startingScene(random, 24), options);
  const Pose poses[] = {{{1, 2, 0}, {}}, {{-3, 1, 1}, {}}, {{-3, 1, 1}, {0, 0, 0.6, 0.8}}};
  uint64_t reused = 0;
  Shot shot = {poses[0], 0};
  for (int round = 0; round < rounds; ++round) {
    INFO("seed " << seed << ", round " << round);
    if (random() > 0) pair.change(random);
    std::vector<Shot> shots;
    for (uint32_t count = 1 + random.bits() % 5; count > 0; --count) {
      if (random() > 0.7) shot = {poses[random.bits() % 3], random.bits() % 2};
      shots.push_back(shot);
    }
    for (const Counters& counters : pair.requireSame(shots)) reused += counters.reused > 0;
  }
  CHECK(reused > 0);
}

Shot at(double x) {
  return {{{x, 0, 0.5}, {}}, 0};
}

Pair townLike() {
  Random random(7);
  return Pair(startingScene(random, 60), vulkanOptions(), {sensors()[0]});
}

uint64_t read(const Counters& c) {
  return c.triangles - c.nonFinite - c.degenerate - c.culledByCluster - c.reused;
}

}  // namespace

TEST_CASE("a standing sensor that reuses the still image gives the same scans: standard") {
  needVulkan();
  TestOptions options = vulkanOptions();
  standAndLook(options, 1, 20);
  options.tuning.culling.occlusion = Culling::Occlusion::always;
  standAndLook(options, 3, 20);
}

TEST_CASE("a standing sensor that reuses the still image gives the same scans: exact") {
  needVulkan();
  TestOptions options = vulkanOptions();
  options.accuracy = Accuracy::exact;
  standAndLook(options, 4, 20);
}

TEST_CASE("where nothing moves, instances are not read from the third scan on") {
  needVulkan();
  Pair pair = townLike();
  const std::vector<Shot> shots(4, at(0));
  const std::vector<Counters> counters = pair.requireSame(shots);
  for (size_t i : {0, 1}) {
    CHECK(counters[i].reused == 0);
    CHECK(read(counters[i]) > 1000);
  }
  for (size_t i : {2, 3}) {
    CHECK(counters[i].reused == counters[i].triangles - counters[i].nonFinite - counters[i].degenerate);
    CHECK(counters[i].projected == 0);
    CHECK(counters[i].hits > 1000);
  }
}

TEST_CASE("a head with two returns reuses the still image where no surface lets light pass") {
  needVulkan();
  TestOptions options = vulkanOptions();
  Effects& effects = options.effects;
  effects.intensity.use = effects.sensorMotion.use = effects.objectMotion.use = EffectUse::automatic;
  effects.returns.use = EffectUse::on;
  effects.returns.count = 2;
  Random random(7);
  Pair pair(startingScene(random, 60), options, {sensors()[0]});
  const std::vector<Shot> shots(4, at(0));
  const std::vector<Counters> counters = pair.requireSame(shots);
  CHECK(counters[1].reused == 0);
  CHECK(counters[3].reused == counters[3].triangles - counters[3].nonFinite - counters[3].degenerate);
  CHECK(counters[3].hits == counters[0].hits);
  CHECK(counters[3].hits > 1000);
  pair.move(0, translation(3, 0, 0));
  pair.requireSame(shots);
}

TEST_CASE("only moving instances are read, and geometry hidden behind them reappears when they have gone") {
  needVulkan();
  Pair pair = townLike();
  const std::vector<Shot> shots(1, at(0));
  const auto step = [&](double x) {
    pair.move(0, translation(x, 0, 0));
    return pair.requireSame(shots)[0];
  };
  for (double x : {3.0, 3.1, 3.2}) CHECK(step(x).reused == 0);  // seen, found to move, image made
  for (double x : {3.3, 9.0, 900.0, 4.0}) {
    const Counters counters = step(x);
    CHECK(counters.reused > counters.triangles / 2);
    CHECK(read(counters) <= 288);  // the triangles of the ball
  }
  CHECK(step(4.0).reused > 0);  // moved to its current place
  pair.move(1, translation(5, 0, 0));
  CHECK(step(4).reused == 0);  // another instance moved
  CHECK(step(4).reused == 0);
  CHECK(step(4).reused > 0);
  pair.add(0, translation(6, 0, 0));
  CHECK(step(4).reused == 0);
  CHECK(step(4).reused == 0);
  CHECK(step(4).reused > 0);
}

// Squares of the vast ball's distances are infinite. Were it handed on from the last shell, the shell of what moves
// would read it a second time.
TEST_CASE("a mesh that reaches infinitely far is read once, also when moving instances have a shell of their own") {
  needVulkan();
  Scene scene = sceneOf(soup(9, 900, 12, 3));
  scene.meshes.push_back(ball(9, 14, 1));
  scene.instances.push_back({"vast", 1, scaling(1e25, 1e25, 1e25)});
  scene.instances.push_back({"moving", 1, translation(6, 0, 0)});
  TestOptions options = vulkanOptions();
  options.tuning.culling.occlusion = Culling::Occlusion::always;
  Simulator simulator = makeSimulator(scene, sensors()[0], options);
  std::vector<uint64_t> nonFinite;
  for (const double x : {6.0, 6.1, 6.2, 6.3}) {
    simulator.setTransform(2, translation(x, 0, 0));
    const Scan scan = simulator.scan(at(0).pose);
    if (scan.counters.reused == 0) nonFinite.push_back(scan.counters.nonFinite);
  }
  REQUIRE(nonFinite.size() == 3);
  CHECK(nonFinite[0] > 0);
  CHECK(nonFinite == std::vector<uint64_t>(3, nonFinite[0]));
}

TEST_CASE("the still image is dropped when the pose, vertices or numbers change") {
  needVulkan();
  Random random(8);
  Pair pair = townLike();
  const Shot turned = {{at(0).pose.position, {0, 0, 0.6, 0.8}}, 0};
  const std::vector<Shot> shots(3, at(0)), other(1, turned);
  const auto isUsed = [&] { return pair.requireSame(shots)[2].reused > 0; };
  CHECK(isUsed());
  CHECK(pair.requireSame(other)[0].reused == 0);
  CHECK(isUsed());
  pair.bend(2, random);
  CHECK(isUsed());
  for (uint32_t mesh : {1u, 2u, 0u}) {
    pair.remove(0);  // the first, so that all others get new numbers
    CHECK(isUsed());
    pair.add(mesh, somewhere(random));
    CHECK(isUsed());
  }
}

// The views fill the farthest-range table with the ranges of the wall right in front of them, and a scan that started
// from the still image would hide the moving ball behind these ranges.
TEST_CASE("the still image is dropped when several views are scanned together") {
  needVulkan();
  Scene scene;
  scene.materials = {material(true)};
  MeshBuilder wall;
  wall.quad({20, -30, -30}, {0, 60, 0}, {0, 0, 60}, 40);
  scene.meshes = {wall.take(), ball(10, 16, 1)};
  scene.instances = {{"wall", 0, {}}, {"ball", 1, translation(6, 0, 0)}};
  Pair pair(scene, vulkanOptions(), {sensors()[0]});
  const std::vector<Shot> still(1, at(0));
  const std::vector<Shot> together = {at(19.5), at(19.6), at(19.7), at(19.8)};
  uint64_t reused = 0;
  for (int round = 0; round < 4; ++round) {
    for (int step = 0; step < 4; ++step) {
      pair.move(1, translation(6, 0.1 * step, 0));
      reused += pair.requireSame(still)[0].reused;
    }
    pair.requireSame(together);
  }
  CHECK(reused > 0);
}

TEST_CASE("if most of the scene moves, everything is scanned at once") {
  needVulkan();
  Random random(3);
  Pair pair = townLike();
  const std::vector<Shot> shots(2, at(0));
  for (int round = 0; round < 4; ++round) {
    for (size_t i = 0; i < 50; ++i) pair.move(i, somewhere(random));
    for (const Counters& counters : pair.requireSame(shots)) CHECK(counters.reused == 0);
  }
}

TEST_CASE("an incomplete still image is not used") {
  needVulkan();
  // There are more large triangles than the lists first have room for. The second scan makes the still image before the
  // first is known to have overflowed.
  Pair pair(sceneOf(soup(11, 6000, 20, 30)), vulkanOptions(), {sensors()[0]});
  const std::vector<Counters> counters = pair.requireSame(std::vector<Shot>(5, at(1)));
  CHECK(counters[0].retries > 0);
  CHECK(counters[1].retries > 0);
  CHECK(counters[4].reused > 0);
}

TEST_CASE("an incomplete still image of an aborted run is not used") {
  needVulkan();
  Random random(5);
  Scene scene = sceneOf(soup(11, 6000, 20, 10));
  scene.meshes.push_back(soup(12, 7000, 20, 0.2));
  scene.instances.push_back({"", 1, {}});
  scene.instances[0].transform = translation(1000, 0, 0);
  TestOptions options = vulkanOptions();
  options.tuning.binning = Binning::nearest;  // its list of tiles has the least room at first
  Pair pair(scene, options);
  const std::vector<Shot> shots = {{{}, 1}, at(1)};
  pair.requireSame(shots);
  pair.move(0, translation(2000, 0, 0));
  pair.requireSame(shots);
  pair.move(0, {});
  CHECK_THROWS(pair.kept().scanAll(shots, [](size_t, const Scan&) { throw std::runtime_error("enough"); }));
  CHECK(pair.requireSame(std::span(shots).subspan(1))[0].retries == 1);
  CHECK(pair.requireSame(std::span(shots).subspan(1))[0].reused == 7000);
}

TEST_CASE("the still image takes eight bytes per beam once it is made") {
  needVulkan();
  Pair pair = townLike();
  const uint64_t beams = sensors()[0].beamCount();
  pair.kept().scan(at(0).pose);
  const uint64_t before = pair.kept().memory().work;
  pair.kept().scan(at(1).pose);
  CHECK(pair.kept().memory().work == before);
  pair.kept().scan(at(1).pose);
  CHECK(pair.kept().memory().work == before + 8 * beams);
}

}  // namespace gnosphere::test

// SPDX-License-Identifier: Apache-2.0
// A scene that was changed is scanned like a new scene with the same content.
#include <algorithm>
#include <array>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <set>

#include "base/vector.hpp"
#include "support.hpp"

namespace gnosphere::test {
namespace {

constexpr uint32_t kRemoved = 0xffffffffu;

/// The state that a simulator should have, and the equivalent scene.
class Model {
 public:
  explicit Model(Scene scene) : scene_(std::move(scene)) {}

  Scene& scene() { return scene_; }
  bool isThere(size_t instance) const { return scene_.instances[instance].mesh != kRemoved; }
  size_t count() const { return scene_.instances.size(); }

  /// Returns the scene without removed instances; `index[i]` is the number of its instance i in this model.
  Scene compact(std::vector<uint32_t>& index) const {
    Scene result;
    result.materials = scene_.materials;
    result.meshes = scene_.meshes;
    index.clear();
    for (uint32_t i = 0; i < count(); ++i) {
      if (!isThere(i)) continue;
      result.instances.push_back(scene_.instances[i]);
      index.push_back(i);
    }
    return result;
  }

 private:
  Scene scene_;
};

Transform placeAnywhere(Random& random) {
  const double far = random() > 0.8 ? 3000 : 30;
  Transform turned = translation(far * random(), far * random(), 5 * random()) * rotationZ(3 * random());
  if (random() > 0.6) turned = turned * scaling(random() > 0 ? 0.5 : -1.5, 1 + random() / 2, 1);
  if (random() > 0.95) turned = turned * scaling(1, 0, 1);
  return turned;
}

std::vector<float> bent(const Mesh& mesh, Random& random) {
  std::vector<float> positions = mesh.positions;
  for (float& value : positions) value += static_cast<float>(0.3 * random());
  const auto vertex = [&] { return 3 * (random.bits() % mesh.vertexCount()); };
  if (random() > 0) positions[vertex()] = std::numeric_limits<float>::quiet_NaN();
  if (random() > 0) positions[vertex() + 1] = -std::numeric_limits<float>::infinity();
  if (random() > 0) positions[vertex() + 2] = 2e9f;
  for (int k = 0; k < 5; ++k) std::copy_n(&positions[vertex()], 3, &positions[vertex()]);
  return positions;
}

Scene startingScene(Random& random) {
  Scene scene;
  scene.materials = {material(true), material(false)};
  scene.meshes = {ball(12, 20, 2), soup(4, 700, 6, 1.5), soup(5, 3, 1, 1)};
  scene.meshes[1].parts = {{0, 300, 0}, {300, 400, 1}};
  scene.meshes[0].origin = {1, -2, 0.5};
  // These triangles are unusable at first, and therefore in a cluster of their own.
  scene.meshes[2].positions[4] = std::numeric_limits<float>::quiet_NaN();
  std::fill_n(scene.meshes[2].positions.begin() + 9, 6, 1.0f);
  for (uint32_t i = 0; i < 12; ++i) scene.instances.push_back({"", i % 3, placeAnywhere(random)});
  return scene;
}

/// Makes one change, in the model and in the simulator.
void change(Model& model, Simulator& simulator, Random& random) {
  const size_t instance = random.bits() % model.count();
  const double kind = random();
  Scene& scene = model.scene();
  if (kind < 0 && model.isThere(instance)) {
    scene.instances[instance].transform = placeAnywhere(random);
    simulator.setTransform(instance, scene.instances[instance].transform);
  } else if (kind < 0.4) {
    const Instance added = {"", random.bits() % 3, placeAnywhere(random)};
    const size_t index = simulator.addInstance(added.mesh, added.transform);
    REQUIRE(index <= model.count());
    if (index == model.count()) scene.instances.emplace_back();
    scene.instances[index] = added;
  } else if (kind < 0.8 && model.isThere(instance)) {
    simulator.removeInstance(instance);
    scene.instances[instance].mesh = kRemoved;
  } else {
    const size_t mesh = random.bits() % scene.meshes.size();
    scene.meshes[mesh].positions = bent(scene.meshes[mesh], random);
    // Some invalid values become valid in the next change.
    for (float& value : scene.meshes[mesh].positions)
      if (!(std::abs(value) < 1e9f) && random() > 0.5) value = static_cast<float>(random());
    simulator.setPositions(mesh, scene.meshes[mesh].positions);
  }
}

void requireSameAsBuilt(const Scan& moved, const Model& model, const Sensor& sensor, const TestOptions& options) {
  std::vector<uint32_t> index;
  const Scene built = model.compact(index);
  Scan fresh = scanOf(built, sensor, moved.pose, options);
  for (uint32_t& instance : fresh.instances)
    if (instance != kNoTriangle) instance = index.at(instance);
  REQUIRE(sameBytes(moved, fresh));
  CHECK(moved.counters.hits > 0);
  CHECK(moved.counters.hits == fresh.counters.hits);
  CHECK(moved.counters.triangles == fresh.counters.triangles);
  CHECK(moved.counters.nonFinite == fresh.counters.nonFinite);
  CHECK(moved.counters.degenerate == fresh.counters.degenerate);
  // How many triangles are projected depends on the shells, whose ends depend on the scan before.
}

void moveAbout(const TestOptions& options, uint32_t seed, int rounds, uint32_t largeMesh = 0) {
  Random random(seed);
  Scene start = startingScene(random);
  if (largeMesh > 0) {
    start.meshes.push_back(soup(6, largeMesh, 30, 0.5));
    start.instances.push_back({"", 3, translation(2, 0, 0)});
  }
  Model model(std::move(start));
  const Sensor sensor = gridSensor(360, 24, -40, 40, 60);
  Simulator simulator = makeSimulator(model.scene(), sensor, options);
  for (int round = 0; round < rounds; ++round) {
    INFO("seed " << seed << ", round " << round);
    const int changes = round == 0 ? 0 : 1 << (2 * round);
    for (int i = 0; i < changes; ++i) change(model, simulator, random);
    const std::vector<Shot> shots = {{{{1, 2, 0}, {}}, 0}, {{{-3, 1, 1}, {}}, 0}, {{{0, 0, 0}, {}}, 0}};
    std::vector<Scan> scans;
    simulator.scanAll(shots, [&](size_t, const Scan& scan) { scans.push_back(scan); });
    requireSameAsBuilt(scans[static_cast<size_t>(round) % 3], model, sensor, options);
  }
}

}  // namespace

TEST_CASE("after any changes a scan equals that of a new simulator of the changed scene: standard") {
  needVulkan();
  TestOptions options = vulkanOptions();
  options.tuning.culling.occlusion = Culling::Occlusion::always;
  moveAbout(options, 1, 5);
}

TEST_CASE("after any changes a scan equals that of a new simulator of the changed scene: exact") {
  needVulkan();
  TestOptions options = vulkanOptions();
  options.accuracy = Accuracy::exact;
  options.tuning.binning = Binning::lists;
  moveAbout(options, 2, 4, 18'000);
}

TEST_CASE("after any changes a scan equals that of a new simulator of the changed scene: reference") {
  TestOptions options;
  options.device = DeviceChoice::Kind::reference;
  for (uint32_t seed : {3u, 4u}) moveAbout(options, seed, 4);
}

TEST_CASE("instances out of range change only counters") {
  needVulkan();
  Random random(9);
  Scene near = startingScene(random);
  for (Instance& instance : near.instances)
    instance.transform = translation(20 * random(), 20 * random(), 0) * rotationZ(random());
  Scene both = near;
  for (int i = 0; i < 30; ++i) both.instances.push_back({"", 1, translation(500 + 30 * i, 100 * random(), 0)});
  const Sensor sensor = gridSensor(360, 24, -40, 40, 60);
  TestOptions options = vulkanOptions();
  options.tuning.culling.occlusion = Culling::Occlusion::never;  // how much is hidden depends on the order of threads
  const Scan alone = scanOf(near, sensor, {}, options), crowd = scanOf(both, sensor, {}, options);
  CHECK(sameBytes(alone, crowd));
  CHECK(alone.counters.hits > 0);
  CHECK(crowd.counters.triangles == alone.counters.triangles + 30 * 700);
  CHECK(crowd.counters.culledByCluster == alone.counters.culledByCluster + 30 * 700);
}

TEST_CASE("an instance that extends into the range from beyond it is hit") {
  needVulkan();
  Scene scene = sceneOf(ball(12, 20, 2));
  scene.instances.clear();
  for (int i = 0; i < 24; ++i)
    scene.instances.push_back({"", 0,
                               rotationZ(0.26 * i) * translation(25 + 0.2 * i, 0, 0) * rotationZ(i) *
                                   scaling(1 + i / 6.0, i % 2 ? -1 : 0.3, 1)});
  const Sensor sensor = gridSensor(720, 30, -10, 10, 25);
  const Scan reference = referenceOf(scene, sensor, {});
  CHECK(reference.counters.hits > 500);
  requireSame(reference, scanOf(scene, sensor, {}, vulkanOptions()));
  Simulator simulator = makeSimulator(scene, sensor, vulkanOptions());
  for (size_t i = 0; i < 24; ++i) simulator.setTransform(i, scene.instances[(i + 7) % 24].transform);
  CHECK(sameBytes(simulator.scan({}).ranges, scanOf(scene, sensor, {}, vulkanOptions()).ranges));
}

TEST_CASE("after an aborted run and added instances, scans are right") {
  needVulkan();
  const Sensor sensor = gridSensor(360, 24, -40, 40, 25);
  Scene scene = sceneOf(ball(12, 20, 1));
  scene.instances[0].transform = translation(-6, 0, 0);
  Simulator simulator = makeSimulator(scene, sensor, vulkanOptions());
  const std::vector<Shot> shots(3);
  CHECK_THROWS_WITH(simulator.scanAll(shots, [](size_t, const Scan&) { throw std::runtime_error("enough"); }),
                    "enough");
  for (int i = 0; i < 40; ++i) {
    scene.instances.push_back({"", 0, translation(8, i, 0)});
    simulator.addInstance(0, scene.instances.back().transform);
  }
  scene.meshes[0] = ball(12, 20, 1.5);
  simulator.setPositions(0, scene.meshes[0].positions);
  const Scan scan = simulator.scan({});
  CHECK(sameBytes(scan, scanOf(scene, sensor, {}, vulkanOptions())));
  const std::set<uint32_t> seen(scan.instances.begin(), scan.instances.end());
  CHECK(seen.size() > 10);  // the first ball, many of those that were added, and no instance
}

TEST_CASE("vertices that move into range are hit", "[second-driver]") {
  needVulkan();
  const Sensor sensor = gridSensor(360, 24, -40, 40, 25);
  const Mesh near = ball(12, 20, 1, {10, 0, 0});
  Simulator simulator = makeSimulator(sceneOf(ball(12, 20, 1, {100, 0, 0})), sensor, vulkanOptions());
  CHECK(simulator.scan({}).counters.hits == 0);
  simulator.setPositions(0, near.positions);
  CHECK(simulator.scan({}).counters.hits > 0);
  CHECK(sameBytes(simulator.scan({}), scanOf(sceneOf(near), sensor, {}, vulkanOptions())));
}

TEST_CASE("hits have the normals of their triangles when others of the mesh lose their area, and have it again") {
  needVulkan();
  const Mesh mesh = ball(12, 20, 3, {8, 0, 0});
  std::vector<float> bent = mesh.positions;
  for (size_t corner = 0; corner < mesh.indices.size(); corner += 21)  // of each seventh triangle two corners meet
    std::copy_n(&bent[3 * size_t{mesh.indices[corner]}], 3, &bent[3 * size_t{mesh.indices[corner + 1]}]);
  Simulator simulator(sceneOf(mesh), {{gridSensor(360, 24, -25, 25), Effects::none(), {Field::normal}}},
                      vulkanOptions());
  for (const std::vector<float>& positions : {mesh.positions, bent, mesh.positions}) {
    simulator.setPositions(0, positions);
    const Scan scan = simulator.scan({});
    CHECK((scan.counters.degenerate >= mesh.indices.size() / 21) == (positions == bent));
    size_t wrong = 0, hits = 0;
    for (size_t beam = 0; beam < scan.ranges.size(); ++beam) {
      if (!scan.hit(beam)) continue;
      ++hits;
      std::array<Vec3, 3> corners;
      for (size_t k = 0; k < 3; ++k) {
        const float* p = &positions[3 * size_t{mesh.indices[3 * size_t{scan.triangles[beam]} + k]}];
        corners[k] = {p[0], p[1], p[2]};
      }
      const Vec3 area = cross(corners[1] - corners[0], corners[2] - corners[0]);
      const auto part = [&](uint32_t axis) { return double{scan.column<float>(Field::normal, axis)[beam]}; };
      wrong += !(std::abs(dot(area, {part(0), part(1), part(2)})) > (1 - 1e-5) * lengthOf(area));
    }
    CHECK(hits > 200);
    CHECK(wrong == 0);
  }
}

TEST_CASE("an invalid change is refused and has no effect") {
  using Catch::Matchers::ContainsSubstring;
  needVulkan();
  for (const char* device : {"auto", "reference"}) {
    TestOptions options = vulkanOptions();
    options.device = deviceByName(device);
    Scene scene = sceneOf(soup(3, 50, 10, 5));
    scene.instances.push_back({"", 0, translation(1, 0, 0)});
    Simulator simulator = makeSimulator(scene, gridSensor(100, 8, -30, 30), options);
    const Scan before = simulator.scan({});
    Transform bad;
    bad.rows[5] = NAN;
    CHECK_THROWS_WITH(simulator.setTransform(2, {}), "instance 2 does not exist, there are 2");
    CHECK_THROWS_WITH(simulator.setTransform(1, bad), "instance 1: its transform is not finite");
    CHECK_THROWS_WITH(simulator.addInstance(1, {}), "mesh 1 does not exist, there are 1");
    CHECK_THROWS_WITH(simulator.addInstance(0, bad), "instance 2: its transform is not finite");
    CHECK_THROWS_WITH(simulator.removeInstance(7), "instance 7 does not exist, there are 2");
    CHECK_THROWS_WITH(simulator.removeInstances(std::vector<uint32_t>{0, 7}),
                      "entry 1: instance 7 does not exist, there are 2");
    CHECK_THROWS_WITH(simulator.removeInstances(std::vector<uint32_t>{1, 0, 1}),
                      "entry 2: instance 1 stands in an entry before it, too; name it once");
    CHECK_THROWS_WITH(simulator.setPositions(1, {}), "mesh 1 does not exist, there are 1");
    const std::vector<float> few(3);
    CHECK_THROWS_WITH(simulator.setPositions(0, few), ContainsSubstring("150 vertices") && ContainsSubstring("; 3 "));
    CHECK(sameBytes(simulator.scan({}), before));
    simulator.removeInstance(0);
    CHECK_THROWS_WITH(simulator.setTransform(0, {}), "instance 0 has been removed");
    CHECK_THROWS_WITH(simulator.removeInstance(0), "instance 0 has been removed");
    CHECK_THROWS_WITH(simulator.removeInstances(std::vector<uint32_t>{1, 0}), "entry 1: instance 0 has been removed");
    CHECK(simulator.scan({}).counters.triangles == 50);
    CHECK(simulator.addInstance(0, {}) == 0);
    CHECK(sameBytes(simulator.scan({}), before));
    CHECK(simulator.addInstance(0, translation(0, 0, 1)) == 2);
  }
}

TEST_CASE("a scene takes as many triangles as there are numbers, and those of a removed instance are free again") {
  needVulkan();  // the reference would keep every triangle of every instance; a scan would take seconds to number them
  constexpr uint32_t kTriangles = 200'000, kMost = 0x7fffffff / kTriangles;
  Scene scene = sceneOf(soup(3, kTriangles, 10, 0.1));
  scene.instances.assign(kMost, {"", 0, translation(0, 0, 5000)});
  Simulator simulator = makeSimulator(scene, gridSensor(20, 4, -30, 30), vulkanOptions());
  Scene added = sceneOf(soup(3, kTriangles, 10, 0.1));
  const std::string refusal = "the scene would place 2147600000 triangles; the limit is 2147483647";
  for (const size_t removed : {0, 7}) {
    CHECK_THROWS_WITH(simulator.addInstance(0, {}), refusal);
    CHECK_THROWS_WITH(simulator.addScene(added), refusal);
    simulator.removeInstance(removed);
    // The first of two has room; it does not stay.
    CHECK_THROWS_WITH(simulator.addInstances(std::vector<Instance>(2)), refusal);
    CHECK(simulator.addInstance(0, translation(0, 0, 5000)) == removed);
  }
}

namespace {

// Instances of a ball in a row, somewhat turned.
Scene rowOfBalls(int count) {
  Scene scene = sceneOf(ball(12, 20, 1));
  scene.instances.clear();
  for (int i = 0; i < count; ++i)
    scene.instances.push_back({"", 0, rotationZ(0.7 * i) * translation(6 + 0.3 * i, 0, 0) * rotationZ(0.1 * i)});
  return scene;
}

// A turn about z by `angle` and then a shift, as the seven numbers of a pose; the quaternion has any length.
std::vector<double> poseNumbers(double angle, double x, double y, double z, double length) {
  return {x, y, z, 0, 0, length * std::sin(angle / 2), length * std::cos(angle / 2)};
}

void append(std::vector<double>& to, std::span<const double> values) {
  to.insert(to.end(), values.begin(), values.end());
}

}  // namespace

TEST_CASE("many transforms at once do what they do one by one") {
  needVulkan();
  const Scene scene = rowOfBalls(9);
  const Sensor sensor = gridSensor(360, 24, -20, 20, 40);
  for (const char* device : {"auto", "reference"}) {
    TestOptions options = vulkanOptions();
    options.device = deviceByName(device);
    Simulator single = makeSimulator(scene, sensor, options), bulk = makeSimulator(scene, sensor, options);
    const std::vector<uint32_t> instances = {4, 0, 8, 4};
    std::vector<double> rows, poses;
    for (size_t i = 0; i < instances.size(); ++i) {
      const double angle = 0.375 * static_cast<double>(i), x = 5 + static_cast<double>(i);
      const Transform transform = translation(x, 1, -0.5) * rotationZ(angle);
      single.setTransform(instances[i], transform);
      append(rows, transform.rows);
      append(poses, poseNumbers(angle, x, 1, -0.5, i == 0 ? 1 : 2.5));
    }
    const Scan before = bulk.scan({});
    bulk.setTransforms(instances, rows);
    const Scan wanted = single.scan({}), scan = bulk.scan({});
    CHECK(sameBytes(scan, wanted));
    CHECK_FALSE(sameBytes(scan.ranges, before.ranges));
    // In single precision, and from a quaternion, a transform is another one by its rounding.
    const std::vector<float> few(rows.begin(), rows.end()), fewPoses(poses.begin(), poses.end());
    const auto near = [&](const Scan& other) {
      size_t same = 0;
      for (size_t i = 0; i < wanted.ranges.size(); ++i)
        same += std::isnan(wanted.ranges[i]) ? std::isnan(other.ranges[i])
                                             : std::abs(wanted.ranges[i] - other.ranges[i]) < 1e-4f;
      return same + 10 > wanted.ranges.size();  // a beam at an outline may miss
    };
    const auto check = [&](const auto& values) {
      for (const uint32_t instance : instances) bulk.setTransform(instance, translation(0, 0, 500));
      REQUIRE_FALSE(near(bulk.scan({})));
      bulk.setTransforms(instances, values);
      CHECK(near(bulk.scan({})));
    };
    check(poses);
    check(rows);
    check(few);
    check(fewPoses);
    bulk.setTransforms({}, std::span<const float>());
    CHECK(near(bulk.scan({})));
  }
}

TEST_CASE("of many transforms one that is wrong is named and none is set") {
  using Catch::Matchers::ContainsSubstring;
  needVulkan();
  for (const char* device : {"auto", "reference"}) {
    TestOptions options = vulkanOptions();
    options.device = deviceByName(device);
    Simulator simulator = makeSimulator(rowOfBalls(5), gridSensor(360, 24, -20, 20, 40), options);
    simulator.removeInstance(3);
    const Scan before = simulator.scan({});
    std::vector<double> rows, poses;
    for (int i = 0; i < 3; ++i) {
      append(rows, translation(5, i, 0).rows);
      append(poses, poseNumbers(0, 5, i, 0, 1));
    }
    const auto refused = [&](std::vector<uint32_t> instances, const std::vector<double>& values, const char* why) {
      CHECK_THROWS_WITH(simulator.setTransforms(instances, values), ContainsSubstring(why));
      const std::vector<float> floats(values.begin(), values.end());
      CHECK_THROWS_WITH(simulator.setTransforms(instances, floats), ContainsSubstring(why));
      CHECK(sameBytes(simulator.scan({}), before));
    };
    refused({0, 1, 5}, rows, "entry 2: instance 5 does not exist, there are 5");
    refused({0, 3, 5}, poses, "entry 1: instance 3 has been removed");
    refused({0, 1}, rows, "12 or 7 numbers for each of 2 instances; 36 numbers");
    rows[24 + 7] = NAN;
    refused({0, 1, 2}, rows, "entry 2: the transform of instance 2 is not finite");
    poses[7 + 2] = INFINITY;
    refused({2, 1, 0}, poses, "entry 1: the transform of instance 1 is not finite, or its quaternion is zero");
    poses[7 + 2] = 0;
    poses[6] = 0;
    refused({2, 1, 0}, poses, "entry 0: the transform of instance 2 is not finite, or its quaternion is zero");
  }
}

TEST_CASE("threads that share many transforms move instances as single calls do") {
  using Catch::Matchers::ContainsSubstring;
  needVulkan();
  constexpr uint32_t kCount = 9000;  // more than two threads' worth
  Scene scene;
  scene.materials = {material(true)};
  MeshBuilder builder;
  builder.box({-0.2, -0.2, -0.2}, {0.2, 0.2, 0.2}, 1);
  scene.meshes = {builder.take()};
  scene.instances.assign(kCount, {"", 0, translation(0, 0, 500)});
  const Sensor sensor = gridSensor(360, 24, -20, 20, 60);
  Simulator single = makeSimulator(scene, sensor, vulkanOptions()),
            bulk = makeSimulator(scene, sensor, vulkanOptions());
  std::vector<uint32_t> instances(kCount);
  std::iota(instances.begin(), instances.end(), 0);
  const auto requireSame = [&](int round) {
    std::vector<double> rows;
    for (size_t i = 0; i < instances.size(); ++i) {
      const double angle = 0.7 * static_cast<double>(i), range = 3 + static_cast<double>((i * 7 + round) % 40);
      const Transform transform =
          translation(range * std::cos(angle), range * std::sin(angle), 0.2 * static_cast<double>(i % 19) - 2);
      single.setTransform(instances[i], transform);
      append(rows, transform.rows);
    }
    bulk.setTransforms(instances, rows);
    const Scan scan = bulk.scan({});
    REQUIRE(scan.counters.hits > scan.beamCount() / 4);
    REQUIRE(sameBytes(scan, single.scan({})));
    REQUIRE(bulk.scan({}).counters.reused == single.scan({}).counters.reused);
    return rows;
  };
  requireSame(0);
  requireSame(3);
  std::reverse(instances.begin(), instances.end());
  std::fill(instances.begin() + 4000, instances.begin() + 5000, 17);
  std::vector<double> rows = requireSame(11);
  const Scan scan = bulk.scan({});
  rows[12 * 8000 + 3] = NAN;
  rows[12 * 2500 + 7] = INFINITY;
  CHECK_THROWS_WITH(bulk.setTransforms(instances, rows),
                    ContainsSubstring("entry 2500: the transform of instance " + std::to_string(instances[2500])));
  CHECK(sameBytes(bulk.scan({}), scan));
}

TEST_CASE("a sensor does not see the instances that it ignores", "[second-driver]") {
  needVulkan();
  const Scene scene = rowOfBalls(12);
  SensorRequest all(gridSensor(360, 24, -20, 20, 40), Effects::none()), some = all;
  some.ignoredInstances = {7, 2, 2};
  for (const char* device : {"auto", "reference"}) {
    TestOptions options = vulkanOptions();
    options.device = deviceByName(device);
    Simulator ignoring(scene, std::vector{all, some}, options), without(scene, all, options);
    const Scan whole = without.scan({});
    without.removeInstance(2);
    without.removeInstance(7);
    Shot shot, other;
    shot.sensor = 1;
    const auto compare = [&] {
      Scan scan, wanted;
      ignoring.scanInto(shot, scan);
      without.scanInto(other, wanted);
      CHECK(sameBytes(scan.ranges, wanted.ranges));
      CHECK(sameBytes(scan.points, wanted.points));
      CHECK(sameBytes(scan.instances, wanted.instances));
      CHECK(sameBytes(scan.triangles, wanted.triangles));
      CHECK(scan.counters.hits == wanted.counters.hits);
    };
    compare();
    CHECK(sameBytes(ignoring.scan({}), whole));
    CHECK_FALSE(sameBytes(ignoring.scan({}, 1).ranges, whole.ranges));
    // From the same pose again, the hits on what stands still are kept.
    for (int i = 0; i < 4; ++i) {
      for (Simulator* simulator : {&ignoring, &without}) simulator->setTransform(5, translation(4, 0.2 * i, 0));
      ignoring.setTransform(2, translation(2, 0.1 * i, 0));
      compare();
    }
    CHECK(ignoring.scan({}).counters.hits > 0);
    some.ignoredInstances = {3, 12};
    CHECK_THROWS_WITH(ignoring.addSensor(some),
                      "sensor 'grid': it ignores an instance, but instance 12 does not exist, there are 12");
    some.ignoredInstances = {2, 7};
  }
}

TEST_CASE("a shot does not see the instances that it ignores, nor those that its sensor ignores", "[second-driver]") {
  needVulkan();
  const Scene scene = rowOfBalls(12);
  SensorRequest all(gridSensor(360, 24, -20, 20, 40), Effects::none()), some = all;
  some.ignoredInstances = {2};
  std::vector<Shot> shots(8);
  const std::vector<std::vector<uint32_t>> lists = {{7}, {7}, {7}, {}, {3, 7, 2, 3}, {}, {0}, {7}};
  for (size_t i = 0; i < shots.size(); ++i) shots[i].ignoredInstances = lists[i];
  shots[6].pose.position = {0, 0, 0.5};
  for (const char* device : {"auto", "reference"}) {
    TestOptions options = vulkanOptions();
    options.device = deviceByName(device);
    Simulator ignoring(scene, some, options);
    std::vector<Scan> expected;
    for (size_t i = 0; i < shots.size(); ++i) {
      Simulator without(scene, all, options);
      std::set<size_t> gone(lists[i].begin(), lists[i].end());
      gone.insert(2);
      for (const size_t instance : gone) without.removeInstance(instance);
      expected.push_back(without.scan(shots[i].pose));
    }
    CHECK_FALSE(sameBytes(expected[0].ranges, expected[3].ranges));
    const auto compare = [&](size_t i, const Scan& scan) {
      INFO(device << ", shot " << i);
      CHECK(sameBytes(scan.ranges, expected[i].ranges));
      CHECK(sameBytes(scan.instances, expected[i].instances));
    };
    // The first three shots keep the hits on what stands still and use them again; the next ones may not.
    Scan scan;
    for (size_t i = 0; i < shots.size(); ++i) {
      ignoring.scanInto(shots[i], scan);
      compare(i, scan);
    }
    ignoring.scanAll(shots, compare);
    const Batch batch = ignoring.scanBatch(shots);
    for (size_t i = 0; i < shots.size(); ++i)
      CHECK(std::memcmp(batch.ranges().data() + i * batch.beams, expected[i].ranges.data(), batch.beams * 4) == 0);
    shots[4].ignoredInstances.push_back(12);
    CHECK_THROWS_WITH(ignoring.scanBatch(shots),
                      "shot 4: it ignores an instance, but instance 12 does not exist, there are 12");
    shots[4].ignoredInstances.pop_back();
  }
}

TEST_CASE("an instance that gets the index of a removed one is seen by a sensor that ignored it", "[second-driver]") {
  needVulkan();
  Scene scene = rowOfBalls(12);
  for (uint32_t i = 0; i < 3; ++i) scene.instances.push_back({"", 0, translation(0, 0, 9.0 + i), 0, "", 1 + i % 2});
  SensorRequest all(gridSensor(360, 24, -20, 20, 40), Effects::none()), some = all;
  some.ignoredInstances = {2, 7, 13};
  for (const char* device : {"auto", "reference"}) {
    TestOptions options = vulkanOptions();
    options.device = deviceByName(device);
    Simulator ignoring(scene, std::vector{some, some}, options), without(scene, all, options);
    for (const size_t instance : {7, 13, 2}) without.removeInstance(instance);  // the last one is taken first
    std::vector<Shot> shots(3), others(3);
    for (uint32_t world = 0; world < 3; ++world) shots[world].world = others[world].world = world;
    for (Shot& shot : shots) shot.sensor = 1;
    const auto compare = [&] {
      const Batch batch = ignoring.scanBatch(shots, std::vector{Field::instance}),
                  wanted = without.scanBatch(others, std::vector{Field::instance});
      CHECK(std::ranges::equal(batch.instances(), wanted.instances()));
      CHECK(std::memcmp(batch.ranges().data(), wanted.ranges().data(), wanted.ranges().size_bytes()) == 0);
      for (size_t world = 0; world < 3; ++world) {
        Scan scan, other;
        ignoring.scanInto(shots[world], scan);
        without.scanInto(others[world], other);
        CHECK(sameBytes(scan.instances, other.instances));
        CHECK(sameBytes(scan.ranges, other.ranges));
      }
    };
    compare();
    ignoring.removeInstance(13);
    ignoring.removeInstances(std::vector<uint32_t>{2});
    compare();
    for (Simulator* simulator : {&ignoring, &without}) {
      CHECK(simulator->addInstance(0, scene.instances[2].transform) == 2);
      CHECK(simulator->addInstance(0, translation(0, -3, 0), 0, 2) == 13);
    }
    compare();
    Scan scan;
    ignoring.scanInto(shots[2], scan);
    CHECK(std::ranges::count(scan.instances, 2u) > 0);
    CHECK(std::ranges::count(scan.instances, 13u) > 0);
  }
}

TEST_CASE("a sensor that has ignored all instances of a mesh is planned for its materials when it sees another one") {
  needVulkan();
  Scene scene = rowOfBalls(3);
  scene.materials[0].transmission = 0.9f;
  SensorRequest request(gridSensor(360, 24, -20, 20, 40));
  request.ignoredInstances = {0, 1, 2};
  for (const bool many : {false, true}) {
    Simulator simulator(scene, request, vulkanOptions());
    CHECK_FALSE(simulator.plan().has("transmission"));
    CHECK(simulator.scan({}).counters.hits == 0);
    const Transform place = scene.instances[1].transform;
    if (many)
      simulator.addInstances(std::vector{Instance{"", 0, place}});
    else
      simulator.addInstance(0, place);
    CHECK(simulator.plan().has("transmission"));
    CHECK(simulator.scan({}).counters.hits > 0);
  }
}

TEST_CASE("an instance that moves during a scan is ignored as well") {
  needVulkan();
  const Scene scene = rowOfBalls(12);
  SensorRequest all(gridSensor(360, 24, -20, 20, 40), Effects::none()), some = all;
  all.sensor.rotationPeriod = some.sensor.rotationPeriod = 0.1;
  all.effects.objectMotion.use = some.effects.objectMotion.use = EffectUse::on;
  some.ignoredInstances = {2};
  for (const char* device : {"auto", "reference"}) {
    TestOptions options = vulkanOptions();
    options.device = deviceByName(device);
    Simulator ignoring(scene, some, options), without(scene, all, options);
    without.removeInstance(2);
    without.removeInstance(7);
    Shot shot;
    shot.instanceMotions = {{4, translation(0, 0, 0.5) * scene.instances[4].transform}};
    Scan scan, wanted;
    without.scanInto(shot, wanted);
    shot.instanceMotions.push_back({7, translation(0, 0, 0.3) * scene.instances[7].transform});
    shot.ignoredInstances = {7};
    ignoring.scanInto(shot, scan);
    CHECK(sameBytes(scan.instances, wanted.instances));
    CHECK(sameBytes(scan.triangles, wanted.triangles));
    CHECK(scan.counters.hits == wanted.counters.hits);
    CHECK(scan.counters.hits > 0);
  }
}

}  // namespace gnosphere::test

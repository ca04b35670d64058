// SPDX-License-Identifier: Apache-2.0
// The kernels give the same bytes with subgroups of any size and lanes in any order, reach every subgroup operation
// with all lanes, and access memory without races. Lanes are fibers on the host, see schedule.hpp.
#include <catch2/catch_get_random_seed.hpp>
#include <catch2/generators/catch_generators.hpp>

#include "deformable.hpp"
#include "effects/scan_support.hpp"
#include "geometry/transform_sources.hpp"
#include "geometry/vertex_sources.hpp"
#include "lanes/faults.hpp"
#include "lanes/footprint_machine.hpp"
#include "lanes/recording.hpp"
#include "lanes/schedule.hpp"
#include "town/town.hpp"

namespace gnosphere::cuda_lanes {
std::unique_ptr<Backend> makeBackend(const Scene& scene, const SensorPlans& sensors, const SimulatorOptions& options);
}

namespace gnosphere::test {
namespace {

using lanes::Fault;

const std::vector<uint32_t> kSizes = {4, 8, 16, 32, 64};
const Scene& town() {
  static const Scene scene = [] {
    Scene made = makeTown({.triangles = everyCombination() ? 4'000u : 1'000u});
    for (size_t i = 0; i < made.materials.size(); i += 2) made.materials[i].transmission = 0.5f;
    addFence(made, plate(6, 3), translation(0, 0, 2), 0.9f);
    return made;
  }();
  return scene;
}

/// A head whose lasers have azimuth offsets and origins, with a number of columns that no size of a subgroup divides.
Sensor head() {
  Sensor sensor = gridSensor(91, 8, -25, 15, 80);
  for (size_t j = 0; j < sensor.channels.size(); ++j) {
    sensor.channels[j].azimuthOffsetDeg = 1.7 * double(j % 3) - 2;
    sensor.channels[j].origin = {0.03, 0.02 * double(j % 3), -0.01};
  }
  sensor.rotationPeriod = kPeriod;
  return sensor;
}

/// A list of beams in no order, which fire one after another.
Sensor pattern() {
  BeamList beams;
  Random random(7);
  for (uint32_t i = 0; i < 700; ++i) {
    const double azimuth = 0.9 * random(), elevation = 0.4 * random();
    beams.directions.push_back(
        {std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth), std::sin(elevation)});
    beams.times.push_back(kPeriod * i / 700);
  }
  Sensor sensor;
  sensor.name = "pattern";
  sensor.patterns.push_back(beams);
  sensor.rangeMax = 80;
  return sensor;
}

TestOptions with(Accuracy accuracy, Binning binning) {
  TestOptions options;
  options.accuracy = accuracy;
  options.tuning.binning = binning;
  return options;
}

TestOptions asking(const Effects& effects) {
  TestOptions options;
  options.effects = effects;
  options.effects.intensity.use = EffectUse::automatic;
  options.fields = stillFields();
  return options;
}

Shot standing(uint64_t frame = 0) {
  Shot shot;
  shot.pose = {{1.3 + 0.1 * static_cast<double>(frame), 0.4, 1.8}, {0.01, -0.02, 0.3, 0.95}};
  shot.frame = frame;
  return shot;
}

/// A shot in which the sensor moves ahead and turns, and the town's first instance moves away.
Shot driving() {
  Shot shot = standing(3);
  shot.motion.stamps = {{0, shot.pose}, {kPeriod, {{3.3, 0.4, 1.8}, {0, 0, std::sin(0.3), std::cos(0.3)}}}};
  shot.instanceMotions = {{town().instances.size() - 1, translation(-1.5, 0.5, 2) * rotationZ(0.2)},
                          {0, translation(0.5, 1, 0) * rotationZ(0.1) * town().instances[0].transform}};
  return shot;
}

/// The orders of a test: how many seeds with each size of a subgroup.
struct Orders {
  uint64_t seeds = everyCombination() ? 4 : 1;
  std::vector<uint32_t> sizes = everyCombination() ? kSizes : std::vector<uint32_t>{8, 64};
};

/// Scans with subgroups of each size in a number of orders, and compares with one lane at a time. The slow tests begin
/// at another seed each time; it is that of Catch2, which `--rng-seed` sets.
void requireAnyOrder(const Scene& scene, const Sensor& sensor, const TestOptions& options,
                     const std::vector<Shot>& shots, const Orders& orders = {}, uint64_t leastHits = 30) {
  const uint64_t firstSeed = everyCombination() ? Catch::getSeed() : 1;
  CudaOnHost one(scene, {sensor}, options);
  CudaOnHost many(scene, {sensor}, options, cuda_lanes::makeBackend);
  std::vector<Scan> expected(shots.size());
  for (size_t i = 0; i < shots.size(); ++i) {
    one.scanInto(shots[i], expected[i]);
    CHECK(expected[i].counters.hits > leastHits);
  }
  for (uint64_t seed = firstSeed; seed < firstSeed + orders.seeds; ++seed)
    for (const uint32_t size : orders.sizes)
      for (size_t i = 0; i < shots.size(); ++i) {
        INFO("seed " << seed << ", subgroups of " << size << " lanes, frame " << shots[i].frame);
        lanes::setOrder({seed, size});
        Scan scan;
        many.scanInto(shots[i], scan);
        REQUIRE(firstBytes(expected[i], scan) == "none");
      }
}

/// Records scans of vertices and transforms in buffers of the caller in any order, and compares with the same values
/// from the host, one lane at a time.
void requireRecordsInAnyOrder(const Sensor& sensor, bool compact, bool words, const Orders& orders) {
  MeshBuilder walls;
  walls.box({-20, -20, -3}, {20, 20, 12}, 3);
  Scene scene = sceneOf(walls.take());
  scene.meshes.push_back(ball(9, 14, 1.5));
  scene.instances.push_back({"", 1, translation(6, 1, 0.5)});
  scene.instances.push_back({"", 1, translation(900, 0, 0)});
  const TestOptions options = with(Accuracy::standard, Binning::nearest);

  // The same from the host: the ball is larger, and its second instance is beside the sensor.
  Scene moved = scene;
  for (float& value : moved.meshes[1].positions) value *= 2;
  const std::vector<float> rows = {0.5f, -0.5f, 0, 5, 0.25f, 1, 0, -6, 0, 0, 1.5f, 0.5f};
  std::copy(rows.begin(), rows.end(), moved.instances[2].transform.rows.begin());
  CudaOnHost one(moved, {sensor}, options);
  const Scan expected = one.scan(standing().pose);
  REQUIRE(std::count(expected.instances.begin(), expected.instances.end(), 2) > 0);
  RecordLayout layout;
  layout.compact = compact;
  // Rows of whole words are written word by word, others byte by byte.
  const size_t first = words ? 0 : 3;
  layout.values = {{Field::x, 0, first},
                   {Field::z, 0, first + 4},
                   {Field::range, 0, first + 8},
                   {Field::instance, 0, first + 12, ValueType::u32}};
  layout.stride = words ? 20 : 21;
  std::vector<std::byte> packed(layout.stride * expected.ranges.size());
  packed.resize(layout.stride * pack(expected, layout, packed));

  SensorPlanner planner(options);
  SensorRequest request = {sensor, Effects::none()};
  request.layout = layout;
  const std::unique_ptr<Backend> backend = makeDeviceBackend(std::make_unique<RecordingMachine>(options), scene,
                                                             {planner.plan(scene, request, 0, false)}, options);
  const CallerBuffer vertices("vertices", moved.meshes[1].positions), transforms("transforms", rows);
  const CallerBuffer records("records", layout.bytesFor(expected.ranges.size()));
  const CallerBuffer header("header", sizeof(RecordHeader));
  const Shot shot = standing();
  const ClassTable classes;
  for (uint64_t seed = 1; seed <= orders.seeds; ++seed)
    for (const uint32_t size : orders.sizes) {
      INFO("seed " << seed << ", subgroups of " << size << " lanes, compact " << compact << ", words " << words);
      lanes::setOrder({seed, size});
      backend->setVertices(1, {vertices.address(), vertices.range().bytes, 12});
      CallerTransforms placed = {transforms.address(), transforms.range().bytes, 48};
      placed.firstInstance = 2;
      placed.instances = 1;
      backend->setTransforms(placed);
      std::memset(records.data(), 0, records.range().bytes);
      RecordHeader said;
      do {
        Recording recording;
        recording.commands = backend.get();  // anything but null
        recording.scans = {{&shot, records.range(), header.range()}};
        recording.classes = &classes;
        backend->record(recording);
        std::memcpy(&said, header.bytes().data(), sizeof said);
      } while (said.incomplete != 0);
      REQUIRE(said.rows * layout.stride == packed.size());
      REQUIRE(std::equal(packed.begin(), packed.end(), records.bytes().begin()));
    }
}

/// Triangles around the sensor, a pane and a fence.
Scene fewTriangles() {
  Scene scene = sceneOf(soup(9, 60, 12, 14));
  scene.materials.push_back(lambertian(0.4f, "glass"));
  scene.materials.back().transmission = 0.6f;
  scene.meshes.push_back(plate(5, 4, 1));
  scene.instances.push_back({"pane", 1, {}});
  addFence(scene, plate(6, 3), translation(0, 0, 1));
  return scene;
}

/// A shot in which the sensor moves ahead and turns.
Shot turning() {
  Shot moving = standing(3);
  moving.motion.stamps = {{0, moving.pose}, {kPeriod, {{3.3, 0.4, 1.8}, {0, 0, std::sin(0.3), std::cos(0.3)}}}};
  return moving;
}

Effects manyEffects() {
  Effects all = Effects::none();
  all.divergence = {EffectUse::on, 7, Effects::Divergence::Profile::gaussian, 9e-3, 4e-3};
  all.transmission.use = all.cutOuts.use = all.intensity.use = all.sensorMotion.use = EffectUse::on;
  all.returns = {EffectUse::on, Effects::Returns::Mode::strongestSecondStrongest};
  all.fog = {EffectUse::on, 100};
  return all;
}

/// Runs each kernel at least once, with a few small scans in a number of orders.
void requireEveryKernel(const Orders& orders) {
  Sensor sensor = head();
  sensor.columns = 17;
  sensor.channels.resize(4);
  Effects noisy = Effects::none();
  noisy.angleNoise = {EffectUse::on, 2e-3, 1e-3, Effects::AngleNoise::At::beam};
  noisy.transmission.use = noisy.cutOuts.use = EffectUse::on;
  const Scene scene = fewTriangles();
  const auto inOrders = [&](const Scene& of, const TestOptions& options, const std::vector<Shot>& shots) {
    requireAnyOrder(of, sensor, options, shots, orders, 15);
  };
  TestOptions shells = with(Accuracy::exact, Binning::nearest);
  shells.tuning.culling.occlusion = Culling::Occlusion::always;
  inOrders(scene, shells, {standing()});
  inOrders(scene, with(Accuracy::standard, Binning::slabs), {standing(1)});
  inOrders(scene, with(Accuracy::standard, Binning::lists), {standing()});
  Effects still = manyEffects();
  still.sensorMotion.use = EffectUse::off;
  inOrders(scene, asking(still), {standing()});
  // The lasers of a column fire apart, so that each beam has its own frame. Such a scan takes ten times as long, so
  // it runs in a tenth of the orders.
  sensor.channels[1].timeOffset = 2e-3;
  TestOptions moving = with(Accuracy::standard, Binning::nearest);
  moving.effects.sensorMotion.use = EffectUse::on;
  requireAnyOrder(scene, sensor, moving, {turning()}, {orders.seeds / 10 + 1, orders.sizes}, 15);
  sensor.channels[1].timeOffset = 0;
  inOrders(scene, asking(noisy), {standing()});
  requireRecordsInAnyOrder(gridSensor(17, 4, -25, 15, 80), true, false, orders);
  for (uint32_t kernel = 0; kernel <= static_cast<uint32_t>(Kernel::records); ++kernel) {
    INFO(nameOf(static_cast<Kernel>(kernel)));
    CHECK(lanes::hasRun(nameOf(static_cast<Kernel>(kernel))));
  }
}

}  // namespace

TEST_CASE("lanes: a kernel without a fault runs in any order, and each fault is found in every order") {
  const Fault fault =
      GENERATE(Fault::missingBarrier, Fault::missingSubgroupBarrier, Fault::plainWrite, Fault::plainRead,
               Fault::divergedCollective, Fault::differentBroadcast, Fault::absentLane, Fault::behindTheEnd);
  for (uint64_t seed = 1; seed <= 20; ++seed)
    for (const uint32_t size : kSizes) {
      INFO("fault " << int(fault) << ", seed " << seed << ", subgroups of " << size << " lanes");
      lanes::setOrder({seed, size});
      CHECK_NOTHROW(lanes::runKernelWith(Fault::none));
      CHECK_THROWS_AS(lanes::runKernelWith(fault), lanes::Finding);
    }
}

TEST_CASE("lanes: geometry alone has the same bytes in any order, with every binning and accuracy") {
  const auto accuracy = GENERATE(Accuracy::paper, Accuracy::draft, Accuracy::standard, Accuracy::exact);
  const auto binning = GENERATE(Binning::nearest, Binning::lists, Binning::slabs);
  if (accuracy == Accuracy::paper && binning != Binning::lists) return;
  TestOptions options = with(accuracy, binning);
  if (accuracy != Accuracy::paper) options.tuning.culling.occlusion = Culling::Occlusion::always;
  INFO("accuracy " << int(accuracy) << ", binning " << int(binning));
  Sensor sensor = gridSensor(91, 8, -25, 15, 80);
  requireAnyOrder(town(), sensor, options, {standing(), standing(1)});
}

TEST_CASE("lanes: a head and a pattern have the same bytes in any order, standing and moving") {
  const bool grid = GENERATE(true, false);
  const auto binning = GENERATE(Binning::nearest, Binning::slabs);
  INFO((grid ? "head" : "pattern") << ", binning " << int(binning));
  TestOptions options = with(Accuracy::standard, binning);
  options.effects.sensorMotion.use = options.effects.objectMotion.use = EffectUse::automatic;
  requireAnyOrder(town(), grid ? head() : pattern(), options, {standing(), driving()});
}

TEST_CASE("lanes: footprints, panes and holes have the same bytes in any order") {
  Effects effects = Effects::none();
  effects.divergence = {EffectUse::on, GENERATE(1u, 7u, 19u), Effects::Divergence::Profile::gaussian, 9e-3, 4e-3};
  effects.returns = {EffectUse::on, Effects::Returns::Mode::strongestSecondStrongest};
  effects.transmission.use = GENERATE(EffectUse::off, EffectUse::on);
  effects.cutOuts.use = EffectUse::on;
  requireAnyOrder(town(), head(), asking(effects), {standing(), standing(1)});
}

TEST_CASE("lanes: a beam ends where several triangles together stop its 61 sub-rays, in any order") {
  MeshBuilder wall;
  for (int i = 0; i < 12; ++i)
    for (int j = 0; j < 12; ++j) wall.quad({5, 0.6 - 0.1 * i, 0.1 * j - 0.6}, {0, -0.1, 0}, {0, 0, 0.1});
  const Scene scene = sceneOf(wall.take());
  BeamList beams;
  for (int i = -4; i <= 4; ++i)
    for (int j = -4; j <= 4; ++j) {
      const double y = 0.02 * i + 0.005, z = 0.02 * j + 0.003, length = std::sqrt(1 + y * y + z * z);
      beams.directions.push_back({1 / length, y / length, z / length});
    }
  Sensor sensor;
  sensor.patterns.push_back(beams);
  sensor.rangeMax = 80;
  Effects effects = Effects::none();
  effects.divergence = {EffectUse::on, 61, Effects::Divergence::Profile::gaussian, 20e-3, 20e-3};
  const TestOptions options = asking(effects);
  SensorPlanner planner(options);
  auto machine = std::make_unique<FootprintMachine>(options);
  const FootprintMachine& looking = *machine;
  const std::unique_ptr<Backend> backend = makeDeviceBackend(
      std::move(machine), scene, {planner.plan(scene, SensorRequest{sensor, options.effects}, 0, false)}, options);
  const Shot shot;
  for (uint64_t seed = 1; seed <= (everyCombination() ? 1000u : 50u); ++seed) {
    INFO("seed " << seed);
    lanes::setOrder({seed, 8});
    Scan scan;
    backend->scanAll({&shot, 1}, scan, [](size_t) {});
    CHECK(looking.covered > 30);
    CHECK(looking.endless == 0);
  }
}

TEST_CASE("lanes: panes, weather and noise have the same bytes in any order") {
  Effects e = Effects::none();
  e.detection = {EffectUse::on, 0.1, 80, 0};
  e.dropOut = {EffectUse::on, 0.1, 0.8, 0.4, {3, 70, 71}};
  e.rangeNoise = {EffectUse::on, 0.01, 0.02, 1e-4, 4e-3};
  e.angleNoise = {EffectUse::on, 2e-3, 1e-3, Effects::AngleNoise::At::beam};
  e.transmission.use = e.cutOuts.use = e.sensorMotion.use = e.objectMotion.use = EffectUse::on;
  e.fog = {EffectUse::on, 100};
  requireAnyOrder(town(), head(), asking(e), {standing(), driving()});
}

TEST_CASE("lanes: deformed meshes have the same bytes in any order") {
  Random random(3);
  const Scene scene = limbs(random, 3);
  TestOptions options = with(Accuracy::exact, Binning::nearest);
  requireAnyOrder(scene, gridSensor(91, 8, -40, 40, 80), options, {standing(), standing(1)});
}

TEST_CASE("lanes: vertices and transforms of the caller, and records, have the same bytes in any order") {
  const bool compact = GENERATE(false, true), words = GENERATE(false, true);
  requireRecordsInAnyOrder(gridSensor(91, 8, -25, 15, 80), compact, words, {everyCombination() ? 20u : 2u, kSizes});
}

TEST_CASE("lanes: a few triangles, some of them panes or with holes, have the same bytes in many orders") {
  const Scene scene = fewTriangles();
  Sensor sensor = head();
  sensor.columns = 31;
  sensor.channels.resize(4);
  Orders orders;
  orders.seeds = everyCombination() ? 100 : 2;
  SECTION("geometry") {
    const auto binning = GENERATE(Binning::nearest, Binning::lists, Binning::slabs);
    TestOptions options = with(GENERATE(Accuracy::standard, Accuracy::exact), binning);
    requireAnyOrder(scene, sensor, options, {standing(), standing(1)}, orders);
  }
  SECTION("effects") {
    requireAnyOrder(scene, sensor, asking(manyEffects()), {standing(), turning()}, orders);
  }
}

TEST_CASE("lanes: every kernel has the same bytes in two orders") {
  requireEveryKernel({1, {8, 64}});
}

TEST_CASE("lanes: every kernel has the same bytes in a thousand orders of 8, 32 and 64 lanes", "[.orders]") {
  requireEveryKernel({1000, {8, 32, 64}});
}

}  // namespace gnosphere::test

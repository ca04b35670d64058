// SPDX-License-Identifier: Apache-2.0
// Worlds, and batches of views: every view has the bytes of a single scan in a scene with only what its world has.
#include <algorithm>
#include <catch2/generators/catch_generators.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <map>
#include <set>

#include "support.hpp"

namespace gnosphere::test {
namespace {

// A common ground and, in each world, boxes of its own that overlap those of other worlds.
Scene worlds(uint32_t count, uint32_t each) {
  Scene scene = sceneOf(soup(3, 700, 12, 3));
  scene.meshes.push_back(soup(4, 40, 2, 1));
  std::mt19937 random(5);
  std::uniform_real_distribution<double> place(-20, 20);
  for (uint32_t k = 0; k < each; ++k)
    for (uint32_t world = 1; world <= count; ++world) {
      Instance instance;
      instance.mesh = 1;
      instance.transform = translation(place(random), place(random), place(random) / 10);
      instance.world = world;
      instance.classId = static_cast<uint16_t>(world);
      scene.instances.push_back(instance);
    }
  return scene;
}

// Shots of many worlds, some of them from the same pose, some from out of reach.
std::vector<Shot> shotsOf(uint32_t worlds, size_t count) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(-15, 15);
  std::vector<Shot> shots(count);
  for (size_t i = 0; i < count; ++i) {
    if (i % 3 != 0) shots[i].pose.position = {place(random), place(random), 0.1 * place(random)};
    if (i % 7 == 3) shots[i].pose.position.x = 5000;
    shots[i].world = static_cast<uint32_t>(i * 5 % (worlds + 2));  // some have no instances, one is world 0
    shots[i].frame = i;
  }
  return shots;
}

// Scans shots alone, in a scene without other worlds, and gives the instances their indices in the whole scene. The
// instances of a world come to that scene for its shots and leave it before those of another world.
class Alone {
 public:
  Alone(const Scene& scene, SensorRequest request, TestOptions options = vulkanOptions())
      : scene_(scene), simulator_(ground(), std::move(request), std::move(options)) {}

  Scan scan(Shot shot) {
    if (shot.world != world_) enter(shot.world);
    shot.world = 0;
    Scan scan;
    simulator_.scanInto(shot, scan);
    for (uint32_t& instance : scan.instances)
      if (instance != kNoTriangle) instance = indices_.at(instance);
    return scan;
  }

 private:
  // The instances that every world sees.
  Scene ground() {
    Scene seen = scene_;
    seen.instances.clear();
    for (uint32_t i = 0; i < scene_.instances.size(); ++i) {
      if (scene_.instances[i].world != 0) continue;
      indices_[static_cast<uint32_t>(seen.instances.size())] = i;
      seen.instances.push_back(scene_.instances[i]);
    }
    return seen;
  }

  void enter(uint32_t world) {
    for (const uint32_t instance : present_) {
      simulator_.removeInstance(instance);
      indices_.erase(instance);
    }
    std::vector<Instance> own;
    std::vector<uint32_t> places;
    for (uint32_t i = 0; world != 0 && i < scene_.instances.size(); ++i) {
      if (scene_.instances[i].world != world) continue;
      places.push_back(i);
      own.push_back(scene_.instances[i]);
      own.back().world = 0;
    }
    present_ = simulator_.addInstances(own);
    for (size_t k = 0; k < own.size(); ++k) indices_[present_[k]] = places[k];
    world_ = world;
  }

  const Scene& scene_;
  std::map<uint32_t, uint32_t> indices_;  // of the simulator's instances, in the whole scene
  Simulator simulator_;
  uint32_t world_ = 0;
  std::vector<uint32_t> present_;  // the instances of this world
};

template <typename T>
bool sameView(std::span<const T> all, const std::vector<T>& one, size_t view) {
  return std::memcmp(all.data() + view * one.size(), one.data(), one.size() * sizeof(T)) == 0;
}

// Whether a view of a batch with all its fields has the bytes of a scan.
bool sameView(const Batch& batch, size_t view, const Scan& scan) {
  bool same = sameView<float>(batch.ranges(), scan.ranges, view) &&
              sameView<float>(batch.points(), scan.points, view) &&
              sameView<uint32_t>(batch.triangles(), scan.triangles, view) &&
              sameView<uint32_t>(batch.instances(), scan.instances, view);
  const auto column = [&]<typename T>(Field field) {
    if (!batch.has(field)) return;
    const ColumnView<T> all = batch.column<T>(field), one = scan.column<T>(field);
    for (size_t i = 0; i < one.size(); ++i)
      same = same && std::memcmp(&all[view * one.size() + i], &one[i], sizeof(T)) == 0;
  };
  column.operator()<float>(Field::intensity);
  column.operator()<uint16_t>(Field::classId);
  column.operator()<uint8_t>(Field::returnNumber);
  return same;
}

// The blocks of docs/batches.md. tests/docs/check_page compares the blocks with the page.

/// The ranges that a head sees from many poses, in one array: beam b of view v is entry v * beams + b.
void rangesFrom(Simulator& simulator, const std::vector<Pose>& poses, Batch& batch) {
  std::vector<Shot> shots(poses.size());
  for (size_t i = 0; i < poses.size(); ++i) {
    shots[i].pose = poses[i];
    shots[i].world = static_cast<uint32_t>(i + 1);
  }
  const Field fields[] = {Field::range};
  simulator.scanBatchInto(shots, batch, fields);  // the batch keeps its memory
}

/// Steps a simulation while the device scans the step before.
void train(Simulator& simulator, const std::function<std::vector<Shot>()>& step,
           const std::function<void(const StreamedBatch&)>& learn) {
  BatchStream stream(simulator, {.views = 4096});  // two batches in flight
  uint64_t before = stream.submit(step());
  for (int i = 0; i < 1000; ++i) {
    const uint64_t next = stream.submit(step());  // what moves after this moves for the next batch
    learn(stream.wait(before));                   // valid until the batch after the next is submitted
    before = next;
  }
}

}  // namespace

TEST_CASE("a scan of a world is that of a scene without the other worlds' instances", "[second-driver]") {
  const Scene scene = worlds(5, 3);
  const Sensor sensor = gridSensor(120, 16, -30, 30);
  const bool reference = GENERATE(false, true);
  if (!reference) needVulkan();
  TestOptions options = vulkanOptions();
  if (reference) options.device = DeviceChoice::Kind::reference;
  Simulator simulator(scene, sensor, options);
  Alone single(scene, sensor, options);
  size_t different = 0, own = 0;
  for (const Shot& shot : shotsOf(5, 12)) {
    Scan scan;
    simulator.scanInto(shot, scan);
    const Scan expected = single.scan(shot);
    own += std::ranges::count_if(scan.instances, [](uint32_t each) { return each != 0 && each != kNoTriangle; });
    different += !sameBytes(scan, expected);
    CHECK(scan.counters.triangles == expected.counters.triangles);
    CHECK(scan.counters.hits == expected.counters.hits);
  }
  CHECK(different == 0);
  CHECK(own > 100);
}

TEST_CASE("a sensor that stands still sees the world of each shot") {
  needVulkan();
  Scene scene = worlds(3, 2);
  const Sensor sensor = gridSensor(120, 16, -30, 30);
  Simulator simulator(scene, sensor, vulkanOptions());
  Alone single(scene, sensor);
  Shot shot;
  for (const uint32_t world : {1, 1, 1, 2, 2, 2, 2, 1, 3, 3}) {
    shot.world = world;
    Scan scan;
    simulator.scanInto(shot, scan);
    CHECK(sameBytes(scan, single.scan(shot)));
  }
}

TEST_CASE("instances come to worlds, move in them and leave them") {
  needVulkan();
  Scene scene = worlds(2, 2);
  const Sensor sensor = gridSensor(120, 16, -30, 30);
  Simulator simulator(scene, sensor, vulkanOptions());
  std::set<uint32_t> seen;  // instances that the scans of any world have met since the last change
  const auto check = [&] {
    seen.clear();
    Alone single(scene, sensor);
    for (uint32_t world = 0; world < 5; ++world) {
      Shot shot;
      shot.world = world;
      Scan scan;
      simulator.scanInto(shot, scan);
      CHECK(sameBytes(scan, single.scan(shot)));
      seen.insert(scan.instances.begin(), scan.instances.end());
    }
  };
  std::vector<Instance> more(2);
  for (size_t i = 0; i < more.size(); ++i) {
    more[i].mesh = 1;
    more[i].transform = translation(4.0 + double(i), 1, 0.2);
    more[i].world = static_cast<uint32_t>(4 - i);
  }
  const std::vector<uint32_t> added = simulator.addInstances(more);
  REQUIRE(added == std::vector<uint32_t>{5, 6});
  scene.instances.insert(scene.instances.end(), more.begin(), more.end());
  check();
  for (const uint32_t instance : {5, 6}) CHECK(seen.contains(instance));
  simulator.setTransform(5, translation(3, -2, 0));
  scene.instances[5].transform = translation(3, -2, 0);
  simulator.setTransform(0, translation(0, 0, -1));
  scene.instances[0].transform = translation(0, 0, -1);
  check();
  simulator.removeInstance(6);
  const size_t again = simulator.addInstance(1, translation(-4, 2, 0), 0, 1);
  REQUIRE(again == 6);
  scene.instances[6].transform = translation(-4, 2, 0);
  scene.instances[6].world = 1;
  check();
  for (const uint32_t instance : {5, 6}) CHECK(seen.contains(instance));
  const std::vector<uint32_t> gone = {6, 1, 3};
  simulator.removeInstances(gone);
  simulator.removeInstances({});
  for (const uint32_t instance : gone) scene.instances[instance].world = 99;  // no shot sees it
  check();
  std::vector<Instance> others(4, more[0]);
  for (size_t i = 0; i < others.size(); ++i) others[i].transform = translation(3, -double(i), 0);
  // The indices are given out in the order in which they were removed.
  CHECK(simulator.addInstances(others) == std::vector<uint32_t>{6, 1, 3, 7});
  scene.instances.emplace_back();
  for (size_t i = 0; i < others.size(); ++i) scene.instances[i < 3 ? gone[i] : 7] = others[i];
  check();
  for (const uint32_t instance : {1, 3, 6, 7}) CHECK(seen.contains(instance));

  more[1].mesh = 9;
  CHECK_THROWS_WITH(simulator.addInstances(more), Catch::Matchers::ContainsSubstring("entry 1: mesh 9 does not exist"));
  check();
}

TEST_CASE("a batch has, view by view, the bytes of single scans", "[second-driver]") {
  needVulkan();
  const Scene scene = worlds(6, 4);
  Sensor list = gridSensor(0, 0, 0, 0);
  list.patterns = {beamsOf(gridSensor(61, 13, -40, 35))};
  const std::vector<Shot> shots = shotsOf(6, 24);
  struct Case {
    const char* name;
    SensorRequest request;
  };
  std::vector<Case> cases = {{"grid", gridSensor(90, 16, -30, 30)}, {"list", list}};
  cases.push_back({"classes", {gridSensor(60, 8, -20, 20), Effects::none(), {Field::classId}}});
  Effects effects = Effects::none();
  effects.intensity.use = EffectUse::on;
  effects.rangeNoise.use = EffectUse::on;
  effects.rangeNoise.sigma = 0.02;
  cases.push_back({"effects", {gridSensor(60, 8, -20, 20), effects, {Field::intensity, Field::returnNumber}}});
  for (Case& each : cases) {
    INFO(each.name);
    if (each.request.fields.empty()) each.request.effects = Effects::none();
    Simulator simulator(scene, each.request, vulkanOptions());
    Batch batch;
    for (int run = 0; run < 2; ++run) simulator.scanBatchInto(shots, batch);
    REQUIRE(batch.views == shots.size());
    REQUIRE(batch.entries() == batch.views * batch.beams * batch.returns);
    size_t different = 0;
    Alone single(scene, each.request);
    Counters sum;
    for (size_t view = 0; view < shots.size(); ++view) {
      const Scan expected = single.scan(shots[view]);
      different += !sameView(batch, view, expected);
      sum += expected.counters;
    }
    CHECK(different == 0);
    CHECK(batch.counters.hits == sum.hits);
    CHECK(batch.counters.hits > 1000);
    CHECK(batch.counters.misses == sum.misses);
    CHECK(batch.counters.beams == sum.beams);
    CHECK(batch.counters.triangles == sum.triangles);
  }
}

TEST_CASE("heads with lasers beside their axis, and lists that look down only, are submitted together") {
  needVulkan();
  const Scene scene = worlds(4, 4);
  Sensor down = gridSensor(0, 0, 0, 0);
  down.patterns = {beamsOf(gridSensor(17, 11, -80, -35))};
  std::vector<Shot> shots = shotsOf(4, 9);
  for (Shot& shot : shots) shot.pose.orientation = {0.1, 0.2, 0.3, 0.92};
  for (const Sensor& sensor : {builtinSensor("Puck"), builtinSensor("OS0-32"), down}) {
    INFO(sensor.name);
    const SensorRequest request(sensor, Effects::none());
    uint64_t submissions = 0;
    TestOptions options = vulkanOptions();
    options.trace = [&](const std::string& line) { submissions += line.find("project_groups") != line.npos; };
    Simulator simulator(scene, request, options);
    Batch batch;
    simulator.scanBatchInto(shots, batch);
    submissions = 0;
    simulator.scanBatchInto(shots, batch);
    CHECK(submissions > 0);
    CHECK(submissions < shots.size());
    size_t different = 0;
    Alone single(scene, request);
    for (size_t view = 0; view < shots.size(); ++view) different += !sameView(batch, view, single.scan(shots[view]));
    CHECK(different == 0);
    CHECK(batch.counters.hits > 1000);
  }
}

TEST_CASE("a batch has only the fields that were asked for, in memory that it keeps") {
  needVulkan();
  const Scene scene = worlds(6, 4);
  const Sensor sensor = gridSensor(90, 16, -30, 30);
  Simulator simulator = makeSimulator(scene, sensor, vulkanOptions());
  const std::vector<Shot> shots = shotsOf(6, 24);
  const Batch all = simulator.scanBatch(shots);
  const Field ranges[] = {Field::range}, instances[] = {Field::instance};
  Batch batch;
  simulator.scanBatchInto(shots, batch, ranges);
  const float* memory = batch.ranges().data();
  CHECK(batch.points().empty());
  CHECK_FALSE(batch.has(Field::x));
  CHECK_FALSE(batch.has(Field::triangle));
  CHECK(std::memcmp(memory, all.ranges().data(), all.ranges().size_bytes()) == 0);
  simulator.scanBatchInto(shots, batch, instances);
  CHECK(batch.ranges().data() == memory);
  CHECK(std::memcmp(memory, all.ranges().data(), all.ranges().size_bytes()) == 0);
  CHECK(std::ranges::equal(batch.instances(), all.instances()));
  CHECK(batch.triangles().empty());
  simulator.scanBatchInto({}, batch);
  CHECK(batch.views == 0);
  CHECK(batch.ranges().empty());
}

TEST_CASE("a batch without views has the sensor and the fields that were asked for") {
  const auto device = GENERATE(DeviceChoice::Kind::reference, DeviceChoice::Kind::vulkan);
  if (device == DeviceChoice::Kind::vulkan) needVulkan();
  TestOptions options = vulkanOptions();
  options.device = device;
  Sensor small = gridSensor(9, 2, -10, 10);
  small.name = "small";
  const SensorRequest requests[] = {gridSensor(90, 16, -30, 30), {small, Effects::none(), {Field::normal}}};
  Simulator simulator(worlds(1, 1), {requests[0], requests[1]}, options);
  Batch batch;
  CHECK(batch.has(Field::range));
  CHECK_FALSE(batch.has(Field::x));
  CHECK_FALSE(batch.has(Field::triangle));
  simulator.scanBatchInto({}, batch, {}, {}, 1);
  CHECK(batch.sensor == "small");
  CHECK(batch.beams == 18);
  CHECK(batch.views == 0);
  for (const Field field : {Field::range, Field::z, Field::triangle, Field::instance, Field::normal})
    CHECK(batch.has(field));
  CHECK_FALSE(batch.has(Field::intensity));
  CHECK(batch.column<float>(Field::normal, 2).empty());
  const Field instances[] = {Field::instance};
  simulator.scanBatchInto({}, batch, instances);
  CHECK(batch.beams == 1440);
  CHECK(batch.has(Field::instance));
  for (const Field field : {Field::x, Field::y, Field::triangle, Field::normal}) CHECK_FALSE(batch.has(field));
  CHECK_THROWS_AS(batch.column<float>(Field::x), Error);
  CHECK_THROWS_AS(batch.column<float>(Field::normal), Error);
  simulator.removeSensor(0);
  CHECK_THROWS_AS(simulator.scanBatch({}), Error);
  CHECK_THROWS_AS(simulator.scanBatch({}, {}, 7), Error);
  batch = simulator.scanBatch({}, {}, 1);
  CHECK(batch.sensor == "small");
  const std::vector<Shot> shots = {Shot{.sensor = 1}};
  simulator.scanBatchInto(shots, batch, {}, {}, 7);  // shots have their own sensor
  CHECK(batch.views == 1);
  CHECK(batch.has(Field::normal));
}

TEST_CASE("a batch tells how many views are done, and an exception of the listener ends it") {
  const auto device = GENERATE(DeviceChoice::Kind::reference, DeviceChoice::Kind::vulkan);
  if (device == DeviceChoice::Kind::vulkan) needVulkan();
  const Scene scene = worlds(2, 1);
  SensorRequest request(gridSensor(90, 16, -30, 30), Effects::none(), {Field::normal});
  TestOptions options = vulkanOptions();
  options.device = device;
  options.tuning.maxBatchBytes = 1;  // a view per submission
  Simulator simulator(scene, request, options);
  const std::vector<Shot> shots = shotsOf(2, 6);
  const Field ranges[] = {Field::range};
  for (const std::span<const Field> fields : {std::span<const Field>(), std::span<const Field>(ranges)}) {
    const Batch expected = simulator.scanBatch(shots, fields);
    Batch batch;
    std::vector<size_t> done;
    const auto noted = [&](size_t views) { done.push_back(views); };
    simulator.scanBatchInto(shots, batch, fields, noted);
    CHECK(done == std::vector<size_t>{1, 2, 3, 4, 5, 6});
    done.clear();
    const auto stopped = [&](size_t views) {
      done.push_back(views);
      if (views == 3) throw std::runtime_error("enough");
    };
    CHECK_THROWS_WITH(simulator.scanBatchInto(shots, batch, fields, stopped), "enough");
    CHECK(done == std::vector<size_t>{1, 2, 3});
    CHECK(batch.views == 0);
    CHECK(batch.ranges().empty());
    simulator.scanBatchInto(shots, batch, fields);
    CHECK(std::ranges::equal(std::as_bytes(batch.ranges()), std::as_bytes(expected.ranges())));
  }
}

TEST_CASE("the examples of docs/batches.md do what they say") {
  needVulkan();
  const Scene scene = worlds(3, 4);
  const Sensor sensor = gridSensor(90, 16, -30, 30);
  const SensorRequest request{sensor, Effects::none(), {}};
  Alone alone(scene, request);
  Simulator simulator = makeSimulator(scene, sensor, vulkanOptions());
  const std::vector<Pose> poses = {{{1, 2, 0.5}, {}}, {{-3, 1, 0.5}, {}}, {{0, 0, 1}, {}}};
  Batch batch;
  rangesFrom(simulator, poses, batch);
  REQUIRE(batch.views == 3);
  CHECK_FALSE(batch.has(Field::x));
  std::vector<Shot> shots(3);
  for (uint32_t i = 0; i < 3; ++i) {
    shots[i].pose = poses[i];
    shots[i].world = i + 1;
    const Scan scan = alone.scan(shots[i]);
    const std::span<const float> view = batch.ranges().subspan(i * sensor.beamCount(), sensor.beamCount());
    CHECK(std::memcmp(view.data(), scan.ranges.data(), view.size_bytes()) == 0);
  }

  struct Enough {};
  TestOptions options = vulkanOptions();
  options.resultsOnDevice = true;
  Simulator onDevice = makeSimulator(scene, sensor, options);
  std::vector<uint64_t> numbers;
  uint64_t steps = 0;
  const auto step = [&] {
    for (Shot& shot : shots) shot.pose.position = {0.1 * double(steps), 0, 0.5};
    ++steps;
    return shots;
  };
  const auto learn = [&](const StreamedBatch& learnt) {
    CHECK(steps == learnt.number + 2);  // the next one is submitted
    CHECK((learnt.views == 3 && learnt.headers.size() == 3 && learnt.complete));
    Shot shot = shots[0];
    shot.pose.position.x = 0.1 * double(learnt.number);
    for (size_t i = 0; i < learnt.headers.size(); ++i) {
      shot.world = shots[i].world;
      CHECK(learnt.headers[i].hits == alone.scan(shot).counters.hits);
    }
    numbers.push_back(learnt.number);
    if (numbers.size() == 4) throw Enough();  // of a thousand
  };
  CHECK_THROWS_AS(train(onDevice, step, learn), Enough);
  CHECK(numbers == std::vector<uint64_t>{0, 1, 2, 3});
}

TEST_CASE("a batch is divided by its budget, and by memory that runs out") {
  needVulkan();
  const Scene scene = worlds(6, 4);
  const bool footprints = GENERATE(false, true);
  SensorRequest request(gridSensor(90, 16, -30, 30), Effects::none());
  if (footprints) {
    request.sensor.divergenceHorizontal = request.sensor.divergenceVertical = 3e-3;
    request.effects.divergence = {EffectUse::on, 7};
    request.effects.intensity.use = EffectUse::on;
  }
  const std::vector<Shot> shots = shotsOf(6, 40);
  const Batch expected = Simulator(scene, request, vulkanOptions()).scanBatch(shots);
  const auto check = [&](const TestOptions& options) {
    const Batch batch = Simulator(scene, request, options).scanBatch(shots);
    CHECK(std::memcmp(batch.ranges().data(), expected.ranges().data(), expected.ranges().size_bytes()) == 0);
    CHECK(std::ranges::equal(batch.instances(), expected.instances()));
    CHECK(batch.counters.hits == expected.counters.hits);
  };
  // In this scene a view takes 2 MB of memory with footprints, most of it in lists (1.2 MB on devices without 64-bit
  // atomics), and a few kB without footprints.
  uint64_t submissions = 0;
  TestOptions bounded = vulkanOptions();
  bounded.tuning.maxBatchBytes = 8 << 20;
  bounded.trace = [&](const std::string& line) { submissions += line.find("project_groups") != line.npos; };
  Simulator simulator(scene, request, bounded);
  simulator.scanBatch(shots);
  submissions = 0;
  simulator.scanBatch(shots);
  const uint64_t least = simulator.plan().binning == "lists" ? 5 : 8;
  CHECK((footprints ? submissions >= least : submissions == 1));
  for (const uint64_t budget : {1, 5'000, 20'000}) {
    TestOptions options = vulkanOptions();
    options.tuning.maxBatchBytes = budget;
    check(options);
  }
  for (const uint64_t limit : {256 * 1024, 400 * 1024}) {
    TestOptions options = vulkanOptions();
    options.tuning.maxBufferBytes = footprints ? 8 * limit : limit;
    check(options);
  }
}

TEST_CASE("the plan of a batch has the steps of one scan, whatever the number of views, and those that run") {
  needVulkan();
  const Scene scene = worlds(6, 9);
  const bool footprints = GENERATE(false, true);
  TestOptions options = vulkanOptions();
  std::vector<std::string> names;
  options.trace = [&](const std::string& line) {
    if (line.find(" workgroups") != line.npos) names.push_back(line);
  };
  SensorRequest request(gridSensor(90, 16, -30, 30), Effects::none());
  if (footprints) {
    request.sensor.divergenceHorizontal = request.sensor.divergenceVertical = 3e-3;
    request.effects.divergence = {EffectUse::on, 7};
    request.effects.intensity.use = EffectUse::on;
  }
  Simulator simulator(scene, request, options);
  const Plan one = simulator.plan();
  CHECK(one.views == 1);
  const auto bytesOf = [](const Plan& plan, const std::string& name) {
    for (const Plan::Buffer& buffer : plan.buffers)
      if (buffer.name == name) return buffer.bytes;
    return uint64_t{0};
  };
  for (const uint32_t views : {2u, 25u}) {
    const Plan many = simulator.plan(0, views);
    REQUIRE(many.views == views);
    CHECK(many.dispatches() == one.dispatches());
    CHECK(many.commands.dispatches == one.commands.dispatches);
    CHECK(many.commands.copies == one.commands.copies);
    CHECK(many.commands.fills <= one.commands.fills + 1);  // the causes of each view
    for (const char* array : {"words", "covers"}) {
      CHECK(bytesOf(many, array) >= views * bytesOf(one, array));
      CHECK(4 * bytesOf(many, array) <= 5 * views * bytesOf(one, array));  // a quarter in advance
    }
    CHECK(many.bytes() > one.bytes());
    const std::vector<Shot> shots = shotsOf(6, views);
    simulator.scanBatch(shots);  // the lists grow
    names.clear();
    simulator.scanBatch(shots);
    CHECK(names.size() == many.dispatches());
  }
  const Plan most = simulator.plan(0, 1'000'000);
  CHECK(most.views > 25);
  CHECK(most.views < 1'000'000);
  options.tuning.binning = Binning::lists;
  CHECK(Simulator(scene, request, options).plan(0, 25).views == 25);
  // Every device dispatches 65,535 rows of workgroups at once, and a view has one per channel.
  CHECK(Simulator(scene, {gridSensor(1, 64, -30, 30), Effects::none()}, options).plan(0, 4000).views == 65535 / 64);
}

TEST_CASE("the counters of a batch are the sums of those of its views") {
  needVulkan();
  SensorRequest request(gridSensor(90, 16, -30, 30), Effects::none());
  request.effects.intensity.use = EffectUse::on;
  request.sensor.maskedBeams = {5, 90, 91};
  const std::vector<Shot> shots = shotsOf(6, 7);
  const Scene scene = worlds(6, 4);
  const Batch batch = Simulator(scene, request, vulkanOptions()).scanBatch(shots);
  Simulator alone(scene, request, vulkanOptions());
  Counters sum;
  for (const Shot& shot : shots) {
    Scan scan;
    alone.scanInto(shot, scan);
    sum += scan.counters;
  }
  CHECK(batch.counters.causes[static_cast<size_t>(Cause::dead)] == 3 * shots.size());
  CHECK(batch.counters.causes == sum.causes);
  CHECK(batch.counters.hits == sum.hits);
  CHECK(batch.counters.misses == sum.misses);
  CHECK(batch.counters.retries == 0);
}

TEST_CASE("a batch tells how often its lists were too small") {
  needVulkan();
  Scene scene;
  scene.materials = {material(true)};
  MeshBuilder box;
  box.box({-20, -20, -3}, {20, 20, 12}, 6);
  scene.meshes = {box.take()};
  // Nearly all triangles are wider than a slab, which the first capacity of the tiles does not expect.
  for (int i = 0; i < 16; ++i) scene.instances.push_back({"", 0, scaling(1 + 0.01 * i, 1 + 0.01 * i, 1)});
  TestOptions options = vulkanOptions();
  options.tuning.binning = Binning::slabs;
  options.tuning.culling.occlusion = Culling::Occlusion::never;
  Simulator simulator(scene, {gridSensor(3600, 8, -10, 10), Effects::none()}, options);
  const std::vector<Shot> shots(3);
  CHECK(simulator.scanBatch(shots).counters.retries > 0);
  CHECK(simulator.scanBatch(shots).counters.retries == 0);
}

TEST_CASE("a batch that cannot be made says why, before anything runs") {
  needVulkan();
  const Scene scene = worlds(2, 2);
  Simulator simulator(scene, std::vector<SensorRequest>{gridSensor(90, 16, -30, 30), gridSensor(60, 8, -30, 30)},
                      vulkanOptions());
  std::vector<Shot> shots = shotsOf(2, 6);
  Batch batch = simulator.scanBatch(shots);
  const std::vector<float> before(batch.ranges().begin(), batch.ranges().end());
  const auto refuses = [&](const std::string& message, std::vector<Field> fields = {}) {
    CHECK_THROWS_WITH(simulator.scanBatchInto(shots, batch, fields), Catch::Matchers::ContainsSubstring(message));
    REQUIRE(batch.views == 6);
    CHECK(std::memcmp(before.data(), batch.ranges().data(), batch.ranges().size_bytes()) == 0);
  };
  shots[4].pose.position.y = std::nan("");
  refuses("shot 4: the pose has a value that is not finite");
  shots[4] = shots[3];
  shots[5].sensor = 1;
  refuses("shot 5 is one of sensor 1, the first one of sensor 0");
  shots[5].sensor = 7;
  refuses("shot 5: sensor 7 does not exist");
  shots[5].sensor = 0;
  refuses("the batch asks for field 'intensity', which sensor 0 does not report", {Field::intensity});
}

}  // namespace gnosphere::test

// SPDX-License-Identifier: Apache-2.0
// Batches whose results stay on the device, against batches of the same shots on the host.
#include <dlfcn.h>

#include <algorithm>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <deque>

#include "effects/sensor_plan.hpp"
#include "effects/showroom.hpp"
#include "pipeline/backend.hpp"
#include "pipeline/recording.hpp"
#include "scan/layout.hpp"
#include "support.hpp"

namespace gnosphere::test {
namespace {

using Catch::Matchers::ContainsSubstring;

constexpr uint32_t kWorlds = 6, kBoxes = 5;

// A common ground, and boxes of each world.
Scene worlds() {
  Scene scene = sceneOf(soup(3, 700, 12, 3));
  scene.meshes.push_back(soup(4, 40, 2, 1));
  for (uint32_t i = 0; i < kWorlds * kBoxes; ++i) {
    Instance instance;
    instance.mesh = 1;
    instance.world = 1 + i % kWorlds;
    instance.transform = translation(3.0 + i % 7, i % 5 - 2.0, 0.1 * i);
    scene.instances.push_back(instance);
  }
  return scene;
}

// Moves the boxes of all worlds.
void moveTo(Simulator& simulator, double offset) {
  std::vector<uint32_t> instances;
  std::vector<double> poses;
  for (uint32_t i = 0; i < kWorlds * kBoxes; ++i) {
    instances.push_back(1 + i);
    poses.insert(poses.end(), {3.0 + (i + offset) / 7, i % 5 - offset, 0.1 * i, 0, 0, 0, 1});
  }
  simulator.setTransforms(instances, std::span<const double>(poses));
}

std::vector<Shot> shotsFor(uint64_t batch, size_t count) {
  std::vector<Shot> shots(count);
  for (size_t i = 0; i < count; ++i) {
    shots[i].pose.position = {0.2 * static_cast<double>(i), 0.1 * static_cast<double>(batch), 0.3};
    shots[i].world = static_cast<uint32_t>(1 + (i + batch) % kWorlds);
    shots[i].frame = 100 * batch + i;
  }
  return shots;
}

SimulatorOptions onDevice(const SimulatorOptions& options) {
  SimulatorOptions result = options;
  result.resultsOnDevice = true;
  return result;
}

template <typename T>
void requireColumn(const Batch& expected, const StreamedBatch& streamed, const ResultPlaces& places,
                   const RecordLayout::Value& value) {
  INFO("field " << fieldInfo(value.field).name << ", component " << value.component);
  const ColumnView<T> column = expected.column<T>(value.field, value.component);
  REQUIRE(column.size() == streamed.views * places.rowsPerView);
  const size_t stride = value.stride;
  REQUIRE(stride > 0);
  size_t wrong = 0;
  for (size_t i = 0; i < column.size(); ++i) {
    const size_t view = i / places.rowsPerView, row = i % places.rowsPerView;
    const std::byte* at = streamed.records.data() + view * places.bytesPerView + value.offset + row * stride;
    wrong += std::memcmp(&column[i], at, sizeof(T)) != 0;
  }
  CHECK(wrong == 0);
}

// Requires that every column of a stream has the bytes of a batch on the host.
void requireSame(const Batch& expected, const StreamedBatch& streamed, const ResultPlaces& places,
                 const RecordLayout& layout) {
  REQUIRE(streamed.complete);
  REQUIRE(streamed.views == expected.views);
  REQUIRE(streamed.records.size() == streamed.views * places.bytesPerView);
  for (const RecordLayout::Value& value : layout.values) {
    switch (value.type) {
      case ValueType::u8: requireColumn<uint8_t>(expected, streamed, places, value); break;
      case ValueType::u16: requireColumn<uint16_t>(expected, streamed, places, value); break;
      case ValueType::u32: requireColumn<uint32_t>(expected, streamed, places, value); break;
      default: requireColumn<float>(expected, streamed, places, value);
    }
  }
  REQUIRE(streamed.headers.size() == streamed.views);
  for (const RecordHeader& header : streamed.headers) {
    CHECK(header.rows == places.rowsPerView);
    CHECK(header.wanted == places.rowsPerView);
  }
}

}  // namespace

TEST_CASE("batches in flight have the results of batches on the host, whatever changes after their submission",
          "[second-driver]") {
  needVulkan();
  const SensorRequest request = {gridSensor(60, 8, -30, 30),
                                 Effects::none(),
                                 {Field::y, Field::triangle, Field::instance, Field::classId, Field::ring}};
  const TestOptions options = vulkanOptions();
  Simulator host(worlds(), request, options), device(worlds(), request, onDevice(options));
  BatchStream stream(device, {40, 3, true});
  const ResultPlaces places = stream.places();
  CHECK(places.rowsPerView == 480);
  CHECK(places.bytesPerView % 16 == 0);
  std::deque<std::pair<uint64_t, Batch>> running;
  for (uint64_t number = 0; number < 8; ++number) {
    moveTo(device, 0.25 * static_cast<double>(number));
    moveTo(host, 0.25 * static_cast<double>(number));
    const std::vector<Shot> shots = shotsFor(number, number % 2 == 0 ? 40 : 7);
    CHECK(stream.submit(shots) == number);
    running.emplace_back(number, host.scanBatch(shots));
    if (running.size() < 3) continue;
    INFO("batch " << running.front().first);
    const StreamedBatch streamed = stream.wait(running.front().first);
    CHECK(streamed.headers[3].frame == 100 * streamed.number + 3);
    requireSame(running.front().second, streamed, places, stream.layout());
    running.pop_front();
  }
  CHECK_THROWS_WITH(stream.wait(4), ContainsSubstring("the results of batch 4 are gone"));
  CHECK_THROWS_WITH(stream.wait(8), ContainsSubstring("no batch 8"));
}

TEST_CASE("streamed batches of a head with all its effects, two returns and moving views are those of the host") {
  needVulkan();
  const Scene scene = showroom();
  SensorRequest request = {smallSensor(), loud()};
  request.fields = {Field::x, Field::intensity, Field::label, Field::returnNumber, Field::normal};
  TestOptions options = vulkanOptions();
  Simulator host(scene, request, options), device(scene, request, onDevice(options));
  BatchStream stream(device, {3, 2, true});
  CHECK(stream.places().rowsPerView == 3 * request.sensor.beamCount());
  std::vector<Shot> shots(3);
  for (size_t i = 0; i < shots.size(); ++i) {
    shots[i] = shotOf(true);
    shots[i].pose.position.y += 0.1 * static_cast<double>(i);
    shots[i].frame = i;
  }
  const uint64_t number = stream.submit(shots);
  requireSame(host.scanBatch(shots), stream.wait(number), stream.places(), stream.layout());
}

TEST_CASE("a stream takes turns among sensors, each with its own layout") {
  needVulkan();
  SensorRequest small = {gridSensor(16, 4, -10, 10), Effects::none()},
                large = {gridSensor(90, 8, -20, 20), Effects::none()};
  large.layout.values = {{Field::instance, 0, 0, ValueType::u32}, {Field::range, 0, 4, ValueType::f32}};
  large.layout.stride = 8;
  large.layout.compact = true;
  const TestOptions options = vulkanOptions();
  Simulator device(worlds(), {small, large}, onDevice(options));
  large.layout = {};
  Simulator host(worlds(), {small, large}, options);
  BatchStream stream(device, {5, 1, true});
  for (int turn = 0; turn < 3; ++turn) {
    std::vector<Shot> shots = shotsFor(static_cast<uint64_t>(turn), 5);
    requireSame(host.scanBatch(shots), stream.wait(stream.submit(shots)), stream.places(0), stream.layout(0));
    for (Shot& shot : shots) shot.sensor = 1;
    const StreamedBatch streamed = stream.wait(stream.submit(shots));
    REQUIRE(streamed.complete);
    size_t hits = 0;
    for (size_t view = 0; view < shots.size(); ++view) {
      Scan scan;
      host.scanInto(shots[view], scan);
      std::vector<std::byte> rows(8 * scan.ranges.size());
      rows.resize(8 * pack(scan, stream.layout(1), rows));
      CHECK(streamed.headers[view].rows == rows.size() / 8);
      CHECK(std::memcmp(streamed.records.data() + view * stream.places(1).bytesPerView, rows.data(), rows.size()) == 0);
      hits += rows.size();
    }
    CHECK(hits > 0);
  }
}

TEST_CASE("only the first recordings that are like no other may overflow the lists of a sensor") {
  needVulkan();
  const Scene scene = worlds();
  const SimulatorOptions options = onDevice(vulkanOptions());
  SensorPlanner planner(options);
  SensorPlans plans;
  for (const uint32_t columns : {40u, 50u, 60u}) {
    SensorRequest request = {gridSensor(columns, 8, -30, 30), Effects::none()};
    request.sensor.rotationPeriod = 0.1;
    request.effects.sensorMotion.use = EffectUse::on;
    request.layout = columnLayout({Field::range}, 8 * columns);
    plans.push_back(planner.plan(scene, request, plans.size(), false));
  }
  constexpr uint64_t kRecords = 4096, kBytesPerView = 2048, kBytes = kRecords + 64 * kBytesPerView;
  const std::unique_ptr<Backend> backend = makeVulkanBackend(scene, plans, options);
  const std::unique_ptr<ResultRing> ring = backend->makeRing(2, kBytes, kBytes);
  const ClassTable classes;
  uint64_t number = 0;
  const auto mayOverflow = [&](size_t sensor, size_t views, bool moves, bool thenSensor1 = false) {
    const size_t buffer = number++ % 2;
    ring->wait(buffer);
    std::vector<Shot> shots = shotsFor(0, views);
    for (Shot& shot : shots) {
      shot.sensor = sensor;
      if (moves) shot.motion.stamps = {{0, shot.pose}, {0.1, Pose{{1, 0, 0.3}, {}}}};
    }
    if (thenSensor1)
      for (Shot& shot : shotsFor(0, 20)) {
        shot.sensor = 1;
        shots.push_back(shot);
      }
    Recording recording;
    recording.ring = ring.get();
    recording.frame = buffer;
    recording.classes = &classes;
    for (size_t view = 0; view < shots.size(); ++view)
      recording.scans.push_back({&shots[view],
                                 {ring->address(buffer) + kRecords + view * kBytesPerView, kBytesPerView},
                                 {ring->address(buffer) + view * sizeof(RecordHeader), sizeof(RecordHeader)}});
    ring->begin(buffer);
    backend->record(recording);
    ring->submit(buffer, kBytes);
    return recording.mayOverflow;
  };
  // The outcome of a recording is known when its buffer is used again.
  for (const size_t sensor : {0, 1, 2}) CHECK(mayOverflow(sensor, 20, false));
  for (const size_t sensor : {0, 1, 2, 0, 1, 2}) CHECK_FALSE(mayOverflow(sensor, 20, false));
  CHECK_FALSE(mayOverflow(1, 7, false));
  // One of two sensors that are recorded together suffices.
  CHECK_FALSE(mayOverflow(0, 20, false, true));
  CHECK(mayOverflow(0, 22, false, true));
  for (int buffer = 0; buffer < 2; ++buffer) CHECK(mayOverflow(1, 21, false));
  CHECK_FALSE(mayOverflow(1, 21, false));
  for (int buffer = 0; buffer < 2; ++buffer) CHECK(mayOverflow(1, 5, true));
  CHECK_FALSE(mayOverflow(1, 5, true));
  CHECK_FALSE(mayOverflow(1, 21, false));
  CHECK(mayOverflow(1, 6, true));
  for (const size_t buffer : {0, 1}) ring->wait(buffer);
  backend->setSensor(2, plans[2]);
  for (int buffer = 0; buffer < 2; ++buffer) CHECK(mayOverflow(2, 20, false));
  CHECK_FALSE(mayOverflow(2, 20, false));
  for (const size_t buffer : {0, 1}) ring->wait(buffer);
}

TEST_CASE("CUDA sees in its own address space what the host gets, buffer after buffer") {
  needVulkan();
  const SensorRequest request = {gridSensor(60, 8, -30, 30), Effects::none()};
  Simulator simulator(worlds(), request, onDevice(vulkanOptions()));
  BatchStream stream(simulator, {20, 2, true});
  const ResultPlaces places = stream.places();
  CudaAddress there[2];
  try {
    for (size_t buffer = 0; buffer < 2; ++buffer) there[buffer] = stream.cudaAddress(buffer);
  } catch (const Error& error) {
    CHECK(error.code() == ErrorCode::device);
    SKIP(error.what());
  }
  void* const library = dlopen("libcuda.so.1", RTLD_NOW);
  const auto retain = reinterpret_cast<int (*)(void**, int)>(dlsym(library, "cuDevicePrimaryCtxRetain"));
  const auto release = reinterpret_cast<int (*)(int)>(dlsym(library, "cuDevicePrimaryCtxRelease_v2"));
  const auto push = reinterpret_cast<int (*)(void*)>(dlsym(library, "cuCtxPushCurrent_v2"));
  const auto pop = reinterpret_cast<int (*)(void**)>(dlsym(library, "cuCtxPopCurrent_v2"));
  const auto copy = reinterpret_cast<int (*)(void*, uint64_t, size_t)>(dlsym(library, "cuMemcpyDtoH_v2"));
  if (!copy) SKIP("this driver of CUDA is that of the tests");
  void* context = nullptr;
  REQUIRE(retain(&context, there[0].device) == 0);
  REQUIRE(push(context) == 0);
  for (uint64_t number = 0; number < 5; ++number) {
    const StreamedBatch batch = stream.wait(stream.submit(shotsFor(number, 20)));
    std::vector<std::byte> bytes(batch.records.size());
    REQUIRE(copy(bytes.data(), there[batch.buffer].address + places.records, bytes.size()) == 0);
    CHECK(std::ranges::equal(bytes, batch.records));
  }
  pop(&context);
  release(there[0].device);
}

TEST_CASE("a stream refuses what it cannot do, and goes on") {
  needVulkan();
  const SensorRequest request = {gridSensor(16, 4, -10, 10), Effects::none()};
  SimulatorOptions options = vulkanOptions();
  Simulator host(worlds(), request, options), device(worlds(), request, onDevice(options));
  CHECK_THROWS_WITH(BatchStream(host, {4}), ContainsSubstring("results_on_device"));
  CHECK_THROWS_WITH(BatchStream(device, {0}), ContainsSubstring("1 to 2147483647 views, not for 0"));
  CHECK_THROWS_WITH(BatchStream(device, {SIZE_MAX}), ContainsSubstring("1 to 2147483647 views"));
  CHECK_THROWS_WITH(BatchStream(device, {0x7fffffff}), ContainsSubstring("'results of batches' needs one buffer of"));
  CHECK_THROWS_WITH(BatchStream(device, {4, 17}), ContainsSubstring("1 to 16 batches in flight, not 17"));
  CHECK_THROWS_WITH(device.scan({}), ContainsSubstring("a BatchStream submits its scans"));
  for (const DeviceChoice::Kind kind : {DeviceChoice::Kind::reference, DeviceChoice::Kind::cuda}) {
    options.device.kind = kind;
    CHECK_THROWS_WITH(Simulator(worlds(), request, onDevice(options)),
                      ContainsSubstring("results_on_device is for a Vulkan device of the library's own"));
  }
  {
    const uint64_t before = device.memory().work;
    BatchStream stream(device, {4, 2, true});
    CHECK(device.memory().work >= before + 2 * stream.places().bytes);
    CHECK_THROWS_WITH(BatchStream(device, {4}), ContainsSubstring("has a BatchStream already"));
    CHECK_THROWS_WITH(stream.submit(shotsFor(0, 5)), ContainsSubstring("has 5 shots; the stream is made for 4"));
    std::vector<Shot> shots = shotsFor(0, 4);
    shots[2].pose.position.x = NAN;
    CHECK_THROWS_WITH(stream.submit(shots), ContainsSubstring("shot 2"));
    shots[2].pose.position.x = 0;
    shots[1].sensor = 1;
    CHECK_THROWS_WITH(stream.submit(shots), ContainsSubstring("shot 1"));
    std::vector<Shot> one = shotsFor(0, 1);
    one[0].instanceMotions = {{99, {}}};
    CHECK_THROWS_WITH(stream.submit(one), ContainsSubstring("shot 0: instance 99 does not exist"));
    CHECK_THROWS_WITH(stream.layout(1), ContainsSubstring("no sensor 1"));
    CHECK_THROWS_WITH(stream.exportMemory(2), ContainsSubstring("no result buffer 2"));
    device.addSensor({gridSensor(160, 8, -10, 10), Effects::none()});
    for (Shot& shot : shots) shot.sensor = 1;
    CHECK_THROWS_WITH(stream.submit(shots), ContainsSubstring("made before the sensor was added"));
    for (Shot& shot : shots) shot.sensor = 0;
    requireSame(host.scanBatch(shots), stream.wait(stream.submit(shots)), stream.places(), stream.layout());
    CHECK(stream.wait(stream.submit({})).views == 0);
    // A batch keeps its results, whatever becomes of its sensor and of the sensor's index.
    const Batch expected = host.scanBatch(shots);
    const uint64_t number = stream.submit(shots);
    const auto check = [&] {
      const StreamedBatch streamed = stream.wait(number);
      CHECK(streamed.sensor == 0);
      CHECK(streamed.places.rowsPerView == 64);
      CHECK(streamed.places.bytes == stream.places(1).bytes);
      REQUIRE(streamed.layout.values.size() == 1);
      requireSame(expected, streamed, streamed.places, streamed.layout);
    };
    device.removeSensor(0);
    check();
    CHECK_THROWS_WITH(stream.places(), ContainsSubstring("no sensor 0"));
    CHECK(device.addSensor({gridSensor(8, 2, -10, 10), Effects::none(), {Field::x}}) == 0);
    check();
    CHECK(stream.places().rowsPerView == 16);
    CHECK(stream.layout().values.size() == 4);  // the range and x, y, z
  }
  BatchStream another(device, {4, 2, true});  // has room for the larger sensor
  std::vector<Shot> shots = shotsFor(1, 4);
  for (Shot& shot : shots) shot.sensor = 1;
  CHECK(another.wait(another.submit(shots)).records.size() == 4 * another.places(1).bytesPerView);
}

namespace {

/// A simulator with one result buffer whose lists are too small for views in the middle of the scene.
struct Crowded {
  Crowded() : host(scene(), request(), options()), device(scene(), request(), onDevice(options())) {}
  static Scene scene() { return sceneOf(soup(11, 1500, 40, 20)); }
  static SensorRequest request() { return {gridSensor(200, 33, -60, 60), Effects::none()}; }
  static TestOptions options() {
    TestOptions options = vulkanOptions();
    options.tuning.binning = Binning::lists;
    return options;
  }
  static std::vector<Shot> shotsAt(double x, size_t count) {
    std::vector<Shot> shots(count);
    for (size_t i = 0; i < count; ++i) shots[i].pose.position = {x, 0, 0.1 * static_cast<double>(i)};
    return shots;
  }
  StreamedBatch scan(double x, size_t count) { return stream.wait(stream.submit(shotsAt(x, count))); }
  void requireComplete(double x, size_t count) {
    requireSame(host.scanBatch(shotsAt(x, count)), scan(x, count), stream.places(), stream.layout());
  }

  Simulator host, device;
  BatchStream stream{device, {6, 1, true}};
};

constexpr double kFarAway = 60;  // from there, few triangles are in range

}  // namespace

TEST_CASE("a stream tells once of motion that a sensor leaves out, as scans do") {
  needVulkan();
  std::string told;
  SimulatorOptions options = onDevice(vulkanOptions());
  options.warn = [&](const std::string& warning) { told += warning; };
  Simulator simulator(worlds(), SensorRequest(gridSensor(40, 5, -10, 10)), options);
  BatchStream stream(simulator, {.views = 1});
  Shot shot;
  shot.motion.stamps = {{0, {}}, {0.1, {{1, 0, 0}, {}}}};
  for (int i = 0; i < 2; ++i) stream.submit({&shot, 1});
  CHECK(told ==
        "sensor 'grid': sensor-motion is left out, although a shot brings it: the sensor fires all beams at once");
}

TEST_CASE("lists that are too small for the first batch of a buffer, or for more views, grow before it is handed out") {
  needVulkan();
  Crowded first;
  first.requireComplete(0, 6);
  Crowded more;
  more.requireComplete(kFarAway, 2);
  more.requireComplete(0, 6);
}

TEST_CASE("lists that become too small later are reported, and have grown for the next batch of the buffer") {
  needVulkan();
  Crowded crowded;
  crowded.requireComplete(kFarAway, 6);
  crowded.requireComplete(kFarAway, 6);
  REQUIRE_FALSE(crowded.scan(0, 6).complete);
  crowded.requireComplete(0, 6);
  crowded.requireComplete(0, 6);
}

}  // namespace gnosphere::test

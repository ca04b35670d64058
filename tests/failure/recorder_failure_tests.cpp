// SPDX-License-Identifier: Apache-2.0
// Recordings that fail late, for lack of memory of the host or of the device, or that the caller drops.
#include <gnosphere_vulkan.h>

#include <catch2/matchers/catch_matchers.hpp>

#include "c/wall.hpp"
#include "engine/recorded.hpp"
#include "failure/injection.hpp"

namespace gnosphere::test {
namespace {

/// A scene whose second mesh has two shapes in turn, so that every recording has something to upload.
class Recordings {
 public:
  Recordings()
      : scene_(boxes()),
        layout_(layoutOf({Field::x, Field::y, Field::z, Field::instance})),
        recorded_(app_, scene_, {gridSensor(90, 8, -20, 20), Effects::none(), {}}, options(), layout_),
        spare_(app_),
        records_(app_, layout_.bytesFor(90 * 8)),
        header_(app_, sizeof(RecordHeader)) {
    shapes_ = {scene_.meshes[1].positions, scene_.meshes[1].positions};
    for (float& value : shapes_[1]) value *= 2;
    for (size_t shape = 0; shape < 2; ++shape) {
      take(shape);
      expected_[shape] = recorded_.scan({});
    }
    CHECK(expected_[0] != expected_[1]);
  }
  static SimulatorOptions options() {
    SimulatorOptions options;
    options.cache = "off";
    return options;
  }

  void take(size_t shape) { recorded_.simulator().setPositions(1, shapes_[shape]); }
  /// Records shots, as frame in flight 1, into a command buffer that is never submitted.
  std::vector<vulkan::RecordedScan> record(size_t count = 1) {
    recorded_.frame(0).wait();
    recorded_.frame(1).wait();
    const VkCommandBuffer commands = spare_.begin();
    std::vector<vulkan::RecordedShot> shots(count, {{}, records_.range(), header_.range()});
    for (size_t i = 0; i < count; ++i) shots[i].shot.pose.position.x = 0.001 * static_cast<double>(i);
    return recorded_.recorder().record(commands, 1, shots);
  }
  /// Ends the command buffer of record(), with nothing in it that runs.
  void drop() { spare_.end(); }
  void check(size_t shape) { CHECK(recorded_.scan({}) == expected_[shape]); }
  vulkan::Recorder& recorder() { return recorded_.recorder(); }
  Simulator& simulator() { return recorded_.simulator(); }

 private:
  VulkanApp app_;
  Scene scene_;
  RecordLayout layout_;
  Recorded recorded_;
  VulkanApp::Frame spare_;
  VulkanApp::Buffer records_, header_;
  std::array<std::vector<float>, 2> shapes_;
  std::array<std::vector<std::byte>, 2> expected_;
};

/// Calls what needs memory of the device, of which there is none from the n-th call on. Returns whether it failed,
/// which must be for lack of memory.
bool failsFrom(long n, const std::function<void()>& call) {
  const Injection injection(Fails::device, n, Lasts::forGood);
  try {
    call();
    return false;
  } catch (const Error& error) {
    CHECK(error.code() == ErrorCode::outOfMemory);
    return true;
  }
}

/// Tries every n until nothing fails any more. Returns the number of failures.
long failures(const std::function<bool(long)>& fails) {
  long n = 1;
  while (fails(n)) ++n;
  return n - 1;
}

}  // namespace

TEST_CASE("a recording that is abandoned loses no upload, and only the last one can be") {
  needVulkan();
  Recordings recordings;
  recordings.take(0);
  recordings.record();
  recordings.drop();
  CHECK_THROWS_WITH(recordings.recorder().abandon(0),
                    "frame 0 cannot be abandoned before those recorded after it, "
                    "which build on its commands");
  recordings.recorder().abandon(1);
  CHECK_THROWS_WITH(recordings.recorder().abandon(1), "frame 1 has no recording that could be abandoned");
  recordings.check(0);
}

TEST_CASE("C: a recording that fails for lack of memory leaves it to the next one what became of the scans before") {
  needVulkan();
  const VulkanApp app;
  gno_vulkan_requirements enabled = gno_vulkan_requirements_init();
  gno_vulkan_adopted_device device = gno_vulkan_adopted_device_init();
  device.get_instance_proc_addr = app.adopted().getInstanceProcAddr;
  device.instance = app.adopted().instance;
  device.physical_device = app.adopted().physicalDevice;
  device.device = app.adopted().device;
  device.queue_family = app.adopted().queueFamily;
  device.enabled = &enabled;
  REQUIRE(gno_vulkan_get_requirements(device.get_instance_proc_addr, device.instance, device.physical_device,
                                      &enabled) == GNO_OK);
  gno_options options = gno_options_init();
  options.adopted = &device;
  options.cache = "off";
  const gno_layout_value range = {GNO_FIELD_RANGE, 0, 0, GNO_F32, 0};
  gno_layout layout = gno_layout_init();
  layout.values = &range;
  layout.value_count = 1;
  layout.stride = 4;
  gno_request request = gno_request_init();
  request.layout = &layout;
  REQUIRE(gno_sensor_from_json(toJson(gridSensor(24, 4, -20, 20)).c_str(), &request.sensor) == GNO_OK);
  REQUIRE(gno_effects_preset("clean", &request.effects) == GNO_OK);
  gno_scene scene = sceneWithWall();
  gno_simulator simulator = nullptr;
  gno_vulkan_recorder recorder = nullptr;
  REQUIRE(gno_simulator_create(scene, &request, 1, &options, &simulator) == GNO_OK);
  REQUIRE(gno_vulkan_recorder_create(simulator, 1, &recorder) == GNO_OK);
  {
    VulkanApp::Frame frame(app);
    const VulkanApp::Buffer records(app, 4 * 24 * 4), header(app, sizeof(gno_record_header));
    gno_shot shot = gno_shot_init();
    const gno_vulkan_recorded_shot recorded = {
        &shot, {records.range().address, records.range().bytes}, {header.range().address, header.range().bytes}};
    const gno_vulkan_recorded_scan* before = nullptr;
    size_t count = 0;
    uint64_t last = 0;
    for (long n = 0, failed = 0;; ++n) {
      INFO("allocation " << n);
      const VkCommandBuffer commands = frame.begin();
      ++shot.frame;
      const Injection injection(Fails::memory, n);
      const gno_status status = gno_vulkan_record(recorder, commands, 0, &recorded, 1, &before, &count);
      if (status != GNO_OK) {
        REQUIRE(status == GNO_OUT_OF_MEMORY);
        ++failed;
        frame.end();
        continue;
      }
      REQUIRE(count == (n == 0 ? 0 : 1));
      if (n > 0) CHECK(before[0].frame == last);
      last = shot.frame;
      frame.submit();
      if (n == 0 || injection.fired()) continue;
      CHECK(failed > 3);
      break;
    }
  }
  CHECK(gno_vulkan_recorder_destroy(recorder) == GNO_OK);
  CHECK(gno_simulator_destroy(simulator) == GNO_OK);
  CHECK(gno_scene_destroy(scene) == GNO_OK);
  CHECK(gno_sensor_destroy(request.sensor) == GNO_OK);
  CHECK(gno_effects_destroy(request.effects) == GNO_OK);
}

TEST_CASE("a recording that fails for lack of memory loses no upload", "[combinations]") {
  needVulkan();
  Recordings recordings;
  size_t shape = 0;
  const auto abandon = [&] { recordings.recorder().abandon(1); };
  const auto check = [&] {
    recordings.drop();
    recordings.check(shape);
    shape = 1 - shape;
    recordings.take(shape);
  };
  recordings.take(shape);
  failEach("vulkan: record", Fails::memory, {[&] { recordings.record(); }, abandon, check});
  CHECK(failures([&](long n) {
          // The upload of a larger mesh needs larger staging buffers.
          const size_t mesh = recordings.simulator().addMesh(soup(9, static_cast<uint32_t>(60'000 * n), 1, 0.1));
          const size_t instance =
              recordings.simulator().addInstance(static_cast<uint32_t>(mesh), translation(0, 0, 500));
          const bool failed = failsFrom(n, [&] { recordings.record(); });
          if (!failed) abandon();
          check();
          recordings.simulator().removeInstance(instance);
          recordings.simulator().removeMesh(mesh);
          return failed;
        }) > 0);
}

TEST_CASE("a recording that fails for lack of memory loses no result of the scans before it") {
  needVulkan();
  Recordings recordings;
  recordings.take(0);
  long n = 0;
  for (bool fired = true; fired;) {
    for (int frame = 0; frame < 2; ++frame) recordings.check(0);
    std::vector<vulkan::RecordedScan> results;
    {
      const Injection injection(Fails::memory, ++n);
      try {
        results = recordings.record(0);
      } catch (const std::exception&) {
      }
      fired = injection.fired();
    }
    recordings.drop();
    if (results.empty()) {
      results = recordings.record(0);
      recordings.drop();
    }
    CHECK(results.size() == 1);
    recordings.recorder().abandon(1);
  }
  CHECK(n > 1);
}

TEST_CASE("shots that have no room together are recorded view by view") {
  needVulkan();
  Recordings recordings;
  const auto check = [&] {
    recordings.drop();
    recordings.check(0);
  };
  recordings.take(0);
  size_t count = 2;  // more than before need more room
  {
    const Injection injection(Fails::device, 1);
    recordings.record(count);
    CHECK(injection.fired());
  }
  recordings.recorder().abandon(1);
  check();
  const Trial trial = {[&] { recordings.record(++count); }, [&] { recordings.recorder().abandon(1); }, check};
  failEach("vulkan: record views", Fails::device, trial);
  failEach("vulkan: record views", Fails::memory, trial);
}

TEST_CASE("without memory of the device no mesh and no sensor comes, and the next scan is as before") {
  needVulkan();
  Recordings recordings;
  Simulator& simulator = recordings.simulator();
  recordings.take(0);
  CHECK(failures([&](long n) {
          size_t mesh = 0;
          const bool failed = failsFrom(n, [&] { mesh = simulator.addMesh(soup(9, 200'000, 1, 0.1)); });
          recordings.check(0);
          if (!failed) simulator.removeMesh(mesh);
          return failed;
        }) > 0);
  CHECK(failures([&](long n) {
          SensorRequest request = {gridSensor(5000, 64, -20, 20), Effects::none(), {}};
          request.layout = layoutOf({Field::x});
          size_t sensor = 0;
          const bool failed = failsFrom(n, [&] { sensor = simulator.addSensor(request); });
          recordings.check(0);
          if (!failed) simulator.removeSensor(sensor);
          return failed;
        }) > 0);
}

}  // namespace gnosphere::test

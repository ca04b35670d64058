// SPDX-License-Identifier: Apache-2.0
// Several shots of a sensor in one recording, which are scanned together as views, against single scans.
#include <algorithm>
#include <catch2/generators/catch_generators.hpp>

#include "base/vector.hpp"
#include "engine/counted_calls.hpp"
#include "engine/record_layouts.hpp"
#include "engine/recorded.hpp"
#include "lists/list_sensors.hpp"
#include "pipeline/origin_groups.hpp"

namespace gnosphere::test {
namespace {

/// A simulator on the application's device whose records of all shots of a call lie in one buffer, one after the other.
class RecordedViews {
 public:
  RecordedViews(VulkanApp& app, const Scene& scene, SensorRequest request, const TestOptions& options,
                const RecordLayout& layout, size_t mostShots)
      : layout_(layout),
        bytesOfShot_((layout.bytesFor(request.sensor.beamCount() * 8) + 15) / 16 * 16),
        frame_(app),
        records_(app, bytesOfShot_ * mostShots),
        headers_(app, sizeof(RecordHeader) * mostShots) {
    SimulatorOptions adopted = options;
    adopted.device = app.choice();
    adopted.validation = false;
    request.layout = layout;
    simulator_.emplace(scene, request, adopted);
    recorder_.emplace(*simulator_, 1);
    for (const RecordLayout::Value& value : layout.values) request.fields.push_back(value.field);
    request.layout = {};
    TestOptions own = options;
    own.device = {DeviceChoice::Kind::vulkan, app.deviceName()};
    expected_.emplace(scene, request, own);
  }
  ~RecordedViews() { frame_.wait(); }

  vulkan::Recorder& recorder() { return *recorder_; }
  Simulator& expected() { return *expected_; }
  std::span<const RecordHeader> headers() const {
    return {reinterpret_cast<const RecordHeader*>(headers_.bytes().data()), headers_.bytes().size() / 32};
  }

  /// Records the shots and waits for them; returns what became of the scans before.
  std::vector<vulkan::RecordedScan> record(std::span<const Shot> shots) {
    std::vector<vulkan::RecordedShot> recorded;
    for (size_t i = 0; i < shots.size(); ++i)
      recorded.push_back({shots[i],
                          {records_.range().address + i * bytesOfShot_, bytesOfShot_},
                          {headers_.range().address + i * sizeof(RecordHeader), sizeof(RecordHeader)}});
    records_.clear();
    auto results = recorder_->record(frame_.begin(), 0, recorded);
    frame_.submit();
    frame_.wait();
    CHECK(records_.guarded());
    CHECK(headers_.guarded());
    return results;
  }

  /// Requires that the records of each shot have the bytes of its scan. Returns how many recordings it took.
  int requireSame(std::span<const Shot> shots) {
    const auto isComplete = [](const RecordHeader& header) { return header.incomplete == 0; };
    int count = 1;
    for (record(shots); !std::ranges::all_of(headers().first(shots.size()), isComplete); record(shots))
      REQUIRE(++count < 7);
    for (size_t i = 0; i < shots.size(); ++i) {
      Scan scan;
      expected_->scanInto(shots[i], scan);
      INFO("shot " << i);
      CHECK(headers()[i].frame == shots[i].frame);
      const std::span records = std::as_const(records_).bytes().subspan(i * bytesOfShot_, bytesOfShot_);
      requireRows(records.first(headers()[i].rows * layout_.stride), scan, layout_);
    }
    return count;
  }

 private:
  RecordLayout layout_;
  size_t bytesOfShot_;
  VulkanApp::Frame frame_;
  std::optional<Simulator> simulator_, expected_;
  std::optional<vulkan::Recorder> recorder_;
  VulkanApp::Buffer records_, headers_;
};

/// A room in which the first two things are everyone's, and the others are in two worlds.
Scene roomOfWorlds() {
  Scene scene = classifiedRoom();
  for (size_t i = 2; i < scene.instances.size(); ++i) scene.instances[i].world = static_cast<uint32_t>(1 + i % 2);
  return scene;
}

/// Shots from different places, in turns in three worlds, of which the last one has nothing of its own.
std::vector<Shot> shotsInTurn(size_t count, bool moving) {
  std::vector<Shot> shots;
  for (size_t i = 0; i < count; ++i) {
    shots.push_back(shotOf(moving));
    Shot& shot = shots.back();
    const Vec3 by = {0.11 * static_cast<double>(i % 5), -0.07 * static_cast<double>(i), 0.02 * static_cast<double>(i)};
    shot.pose.position = shot.pose.position + by;
    for (auto& stamp : shot.motion.stamps) stamp.pose.position = stamp.pose.position + by;
    shot.world = static_cast<uint32_t>(i % 3 + 1);
    shot.frame = 3 + i;
    std::erase_if(shot.instanceMotions, [&](const auto& motion) { return shot.world != 1 + motion.instance % 2; });
  }
  return shots;
}

void requireSame(const SensorRequest& request, const RecordLayout& layout, const std::vector<Shot>& shots) {
  needVulkan();
  const CommonApp common;
  RecordedViews views(common.app, roomOfWorlds(), request, vulkanOptions(), layout, shots.size());
  views.requireSame(shots);
  // Fewer shots, a single one, and shots at the places of others.
  views.requireSame(std::span(shots).first(2));
  views.requireSame(std::span(shots).last(1));
  const std::vector<Shot> turned(shots.rbegin(), shots.rend());
  views.requireSame(turned);
}

}  // namespace

TEST_CASE("shots of a grid that are recorded together have the bytes of single scans", "[second-driver]") {
  const bool compact = GENERATE(false, true);
  requireSame({gridSensor(90, 8, -18, 9, 15), Effects::none()}, oddLayout(kPlainFields, compact),
              shotsInTurn(7, false));
}

TEST_CASE("shots with all effects and in motion that are recorded together have the bytes of single scans") {
  const bool moving = GENERATE(false, true);
  requireSame({smallSensor(), loud()}, oddLayout(kAllFields, moving), shotsInTurn(5, moving));
}

TEST_CASE("shots of a list with patterns that are recorded together have the bytes of single scans",
          "[second-driver]") {
  Sensor list = listSensor("patterns", rosette(700, 0.9));
  list.patterns.push_back(rosette(700, 1.1, 300));
  list.patterns.push_back(rosette(700, 0.7, 900));
  list.maskedBeams = {4, 5, 6};
  requireSame({list, Effects::none()}, oddLayout(kPlainFields, true), shotsInTurn(7, false));
}

TEST_CASE("shots of heads far apart that are recorded together have the bytes of single scans", "[second-driver]") {
  const bool unequal = GENERATE(false, true);
  Sensor rig = listSensor("rig", headsAt({{0, 0, 0}, {-1.5, 1.5, 0.5}, {1, -0.9, -0.3}}, rosette(300, 1.2)));
  if (unequal)  // the beams of one place are so few that their tables have another size
    for (size_t i = 2; i < rig.patterns[0].origins.size(); i += 3)
      if (i > 60) rig.patterns[0].origins[i] = {0, 0, 0};
  REQUIRE(originGroups(rig, 0).size() == 3);
  requireSame({rig, Effects::none()}, oddLayout(kPlainFields, unequal), shotsInTurn(4, false));
}

TEST_CASE("recorded shots of a moving list with effects have the bytes of single scans") {
  Sensor list = listSensor("patterns", rosette(500, 0.9));
  list.patterns.push_back(rosette(500, 1.1, 300));
  list.rotationPeriod = 0.1;
  list.divergenceHorizontal = list.divergenceVertical = 2e-3;
  list.maxReturns = 2;
  requireSame({list, loud()}, oddLayout(kAllFields, true), shotsInTurn(4, true));
}

TEST_CASE(
    "shots that are recorded together have the dispatches of a single one, and allocate nothing once there is room") {
  needVulkan();
  VulkanApp app("", countingLookUp());
  const RecordLayout layout = layoutOf({Field::range});
  const std::vector<Shot> shots = shotsInTurn(64, false);
  RecordedViews views(app, roomOfWorlds(), {gridSensor(90, 8, -18, 9, 15), Effects::none()}, vulkanOptions(), layout,
                      shots.size());
  views.requireSame(shots);
  const auto countOf = [&](size_t count) {
    forgetCalls();
    views.record(std::span(shots).first(count));
    return callsOf(kDispatchCalls);
  };
  const int one = countOf(1);
  CHECK(one > 5);
  CHECK(countOf(2) == one);
  CHECK(countOf(64) == one);
  forgetCalls();
  std::vector<Shot> moved = shots;
  for (int round = 0; round < 10; ++round) {
    for (Shot& shot : moved) shot.pose.position.x += 0.01;
    views.record(moved);
  }
  CHECK(callsOf(kCostlyCalls) == 0);
}

TEST_CASE("shots that are recorded together see vertices and transforms in buffers of the caller") {
  needVulkan();
  const CommonApp common;
  Scene scene = boxes();
  scene.instances.push_back({"", 1, translation(-6, 0, 0)});
  const std::vector<Shot> shots = shotsInTurn(4, false);
  RecordedViews views(common.app, scene, {gridSensor(90, 8, -18, 9, 40), Effects::none()}, vulkanOptions(),
                      oddLayout(kPlainFields, true), shots.size());
  std::vector<float> larger = scene.meshes[1].positions;
  for (float& value : larger) value *= 1.5f;
  VulkanApp::Buffer vertices(common.app, 4 * larger.size());
  std::memcpy(vertices.bytes().data(), larger.data(), vertices.bytes().size());
  views.recorder().setVertices(1, {vertices.range().address, vertices.range().bytes});
  views.expected().setPositions(1, larger);
  views.requireSame(shots);

  const std::array<float, 12> rows = {1, 0, 0, -4, 0, 1, 0, 1.5f, 0, 0, 1, 0.5f};
  VulkanApp::Buffer transforms(common.app, sizeof rows);
  std::memcpy(transforms.bytes().data(), rows.data(), sizeof rows);
  views.recorder().setTransforms({transforms.range().address, sizeof rows, 48, {}, {}, 2, 1});
  views.expected().setTransform(2, translation(-4, 1.5, 0.5));
  views.requireSame(shots);
}

TEST_CASE("lists that are too small for recorded shots are reported for each, and grow") {
  needVulkan();
  const CommonApp common;
  TestOptions options = vulkanOptions();
  options.tuning.binning = Binning::slabs;
  Scene scene = boxes();
  for (int i = 1; i < 16; ++i) scene.instances.push_back({"", 0, scaling(1 + 0.01 * i, 1 + 0.01 * i, 1)});
  RecordLayout layout = layoutOf({Field::range, Field::instance});
  layout.compact = true;
  std::vector<Shot> shots(5);
  for (size_t i = 0; i < shots.size(); ++i) shots[i].pose.position.x = 0.1 * static_cast<double>(i);
  RecordedViews views(common.app, scene, {listSensor("rosette", rosette(3000, 1.5)), Effects::none()}, options, layout,
                      shots.size());
  CHECK(views.record(shots).empty());
  const auto isComplete = [](const RecordHeader& header) { return header.incomplete == 0; };
  REQUIRE(std::ranges::none_of(views.headers(), isComplete));
  const std::vector<vulkan::RecordedScan> results = views.record(shots);
  REQUIRE(results.size() == 5);
  for (size_t i = 0; i < results.size(); ++i) {
    CHECK(results[i].frame == shots[i].frame);
    CHECK_FALSE(results[i].complete);
  }
  views.requireSame(shots);
}

}  // namespace gnosphere::test

// SPDX-License-Identifier: Apache-2.0
// The same scans recorded by an application and made on a device of our own.
#pragma once

#include <memory>
#include <optional>

#include "engine/vulkan_app.hpp"

namespace gnosphere::test {

inline RecordLayout layoutWith(std::vector<Field> fields) {
  RecordLayout layout = layoutOf(fields);
  layout.compact = true;
  return layout;
}

/// A scene on the application's device, which records its scans, and the same scene on a device of our own.
class BothScans {
 public:
  BothScans(VulkanApp& app, const Scene& scene, const std::vector<Sensor>& sensors, const TestOptions& options)
      : app_(app), frame_(app) {
    TestOptions own = options;
    own.device = {DeviceChoice::Kind::vulkan, app.deviceName()};
    SimulatorOptions adopted = options;
    adopted.device = app.choice();
    adopted.validation = false;
    expected_.emplace(scene, std::vector<SensorRequest>(), own);
    recorded_.emplace(scene, std::vector<SensorRequest>(), adopted);
    recorder_.emplace(*recorded_, 1);
    for (const Sensor& sensor : sensors) add({sensor, options.effects}, layoutWith({Field::x, Field::triangle}));
  }
  ~BothScans() { frame_.wait(); }

  void add(SensorRequest request, const RecordLayout& layout) {
    request.layout = layout;
    recorded_->addSensor(request);
    request.layout = {};
    for (const RecordLayout::Value& value : layout.values) request.fields.push_back(value.field);
    expected_->addSensor(request);
    layouts_.push_back(layout);
    const size_t rows = request.sensor.beamCount() * 4;
    records_.push_back(std::make_unique<VulkanApp::Buffer>(app_, layout.bytesFor(rows)));
    headers_.push_back(std::make_unique<VulkanApp::Buffer>(app_, sizeof(RecordHeader)));
  }

  template <typename Change>
  void change(const Change& change) {
    for (Simulator* simulator : {&*expected_, &*recorded_}) change(*simulator);
  }
  Simulator& expected() { return *expected_; }
  Simulator& recorded() { return *recorded_; }
  vulkan::Recorder& recorder() { return *recorder_; }

  /// Requires that every sensor's recorded rows have the bytes of its scan. `before` records what comes first.
  void requireSame(Shot shot = {}, const std::function<void(VkCommandBuffer)>& before = {}) {
    std::vector<vulkan::RecordedShot> shots;
    for (size_t sensor = 0; sensor < layouts_.size(); ++sensor) {
      shot.sensor = sensor;
      shots.push_back({shot, records_[sensor]->range(), headers_[sensor]->range()});
    }
    bool incomplete = true;
    for (int attempt = 0; attempt < 6 && incomplete; ++attempt) {
      const VkCommandBuffer commands = frame_.begin();
      if (before) before(commands);
      recorder_->record(commands, 0, shots);
      frame_.submit();
      frame_.wait();
      incomplete = false;
      for (const auto& header : headers_) incomplete |= header->as<RecordHeader>()->incomplete != 0;
    }
    REQUIRE_FALSE(incomplete);
    for (size_t sensor = 0; sensor < layouts_.size(); ++sensor) {
      Scan scan;
      shot.sensor = sensor;
      expected_->scanInto(shot, scan);
      const RecordLayout& layout = layouts_[sensor];
      std::vector<std::byte> rows(layout.stride * scan.ranges.size());
      rows.resize(layout.stride * pack(scan, layout, rows));
      INFO("sensor " << sensor << ", " << rows.size() / layout.stride << " rows");
      REQUIRE(rows.size() > 0);
      const auto bytes = std::as_const(*records_[sensor]).bytes();
      const size_t found = layout.stride * headers_[sensor]->as<RecordHeader>()->rows;
      REQUIRE(found == rows.size());
      CHECK(std::memcmp(bytes.data(), rows.data(), found) == 0);
    }
  }

  /// Results of the scans recorded last, as the recorder tells them.
  std::vector<vulkan::RecordedScan> results() {
    auto results = recorder_->record(frame_.begin(), 0, {});
    frame_.submit();
    return results;
  }

 private:
  VulkanApp& app_;
  VulkanApp::Frame frame_;
  std::optional<Simulator> expected_, recorded_;
  std::optional<vulkan::Recorder> recorder_;
  std::vector<RecordLayout> layouts_;
  std::vector<std::unique_ptr<VulkanApp::Buffer>> records_, headers_;
};

}  // namespace gnosphere::test

// SPDX-License-Identifier: Apache-2.0
// Scans recorded by an application, and their results as the application finds them in its buffers.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "engine/vulkan_app.hpp"

namespace gnosphere::test {

/// A box around the sensor, and a smaller one in it, instance 1.
inline Scene boxes() {
  Scene scene;
  scene.materials = {material(true)};
  MeshBuilder outer, inner;
  outer.box({-20, -20, -3}, {20, 20, 12}, 6);
  inner.box({-1, -1, -1}, {1, 1, 1}, 3);
  scene.meshes = {outer.take(), inner.take()};
  scene.instances = {{"", 0, {}}, {"", 1, translation(6, 0, 0)}};
  return scene;
}

/// Returns the rows of a scan as pack() lays them out; bytes without a value are 0, as on the device.
inline std::vector<std::byte> rowsOf(const Scan& scan, const RecordLayout& layout) {
  std::vector<std::byte> bytes(layout.stride * scan.ranges.size());
  bytes.resize(layout.stride * pack(scan, layout, bytes));
  return bytes;
}

/// Requires that records are the rows of a scan.
inline void requireRows(std::span<const std::byte> records, const Scan& scan, const RecordLayout& layout) {
  const std::vector<std::byte> rows = rowsOf(scan, layout);
  INFO(rows.size() / layout.stride << " rows");
  REQUIRE(records.size() == rows.size());
  const auto at = std::ranges::mismatch(records, rows).in1 - records.begin();
  INFO("first difference in row " << at / static_cast<ptrdiff_t>(layout.stride) << ", byte "
                                  << at % static_cast<ptrdiff_t>(layout.stride));
  REQUIRE(at == static_cast<ptrdiff_t>(rows.size()));
}

/// A simulator on the application's device with one sensor, two frames in flight, and the buffers for their results.
class Recorded {
 public:
  /// The buffers have room for `rows` records; 0 for as many as a scan can have.
  Recorded(VulkanApp& app, const Scene& scene, SensorRequest request, const SimulatorOptions& options,
           const RecordLayout& layout, size_t rows = 0)
      : layout_(layout), frames_{VulkanApp::Frame(app), VulkanApp::Frame(app)} {
    request.layout = layout;
    SimulatorOptions adopted = options;
    adopted.device = app.choice();
    adopted.validation = false;
    simulator_.emplace(scene, request, adopted);
    recorder_.emplace(*simulator_, 2);
    if (rows == 0) rows = request.sensor.beamCount() * 8;
    for (auto& buffer : records_) buffer = std::make_unique<VulkanApp::Buffer>(app, layout.bytesFor(rows));
    for (auto& buffer : headers_) buffer = std::make_unique<VulkanApp::Buffer>(app, sizeof(RecordHeader));
  }
  ~Recorded() {
    for (VulkanApp::Frame& frame : frames_) frame.wait();
  }

  Simulator& simulator() { return *simulator_; }
  vulkan::Recorder& recorder() { return *recorder_; }
  VulkanApp::Frame& frame(size_t at) { return frames_[at]; }

  /// Records and submits without waiting; returns what became of the scan before in the same frame in flight.
  std::vector<vulkan::RecordedScan> submit(const Shot& shot) {
    const size_t at = next_++ % 2;
    const VkCommandBuffer commands = frames_[at].begin();
    const vulkan::RecordedShot recorded = {shot, records_[at]->range(), headers_[at]->range()};
    auto results = recorder_->record(commands, at, {&recorded, 1});
    frames_[at].submit();
    return results;
  }

  /// Scans until a scan is complete; returns its records.
  std::vector<std::byte> scan(const Shot& shot) {
    for (int attempt = 0; attempt < 6; ++attempt) {
      const size_t at = next_ % 2;
      records_[at]->clear();
      submit(shot);
      frames_[at].wait();
      header = *headers_[at]->as<RecordHeader>();
      CHECK(records_[at]->guarded());
      CHECK(headers_[at]->guarded());
      if (header.incomplete != 0) {
        ++incomplete;
        // The lists grow when the same frame in flight is recorded again.
        ++next_;
        continue;
      }
      const auto bytes = records_[at]->bytes();
      return {bytes.begin(), bytes.begin() + static_cast<ptrdiff_t>(layout_.stride * header.rows)};
    }
    FAIL("no scan was complete");
    return {};
  }

  /// The records of a frame in flight that has completed.
  const std::byte* bytes(size_t at) const { return records_[at]->bytes().data(); }
  const RecordHeader& headerOf(size_t at) const { return *headers_[at]->as<RecordHeader>(); }

  RecordHeader header;
  int incomplete = 0;

 private:
  RecordLayout layout_;
  std::array<VulkanApp::Frame, 2> frames_;
  std::optional<Simulator> simulator_;
  std::optional<vulkan::Recorder> recorder_;
  std::array<std::unique_ptr<VulkanApp::Buffer>, 2> records_, headers_;
  size_t next_ = 0;
};

}  // namespace gnosphere::test

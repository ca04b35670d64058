// SPDX-License-Identifier: Apache-2.0
// Scans on a Vulkan device: project, bin, resolve, in one submission each.
#include "backend.hpp"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <deque>

#include "vulkan/commands.hpp"
#include "vulkan/pipeline_cache.hpp"
#include "vulkan/sensor_state.hpp"

namespace gnosphere {
namespace vulkan {
namespace {

constexpr const char* kStages[] = {"project", "bin", "resolve"};
using Clock = std::chrono::steady_clock;
constexpr uint32_t kStamps = std::size(kStages) + 1;

class VulkanBackend final : public Backend {
 public:
  VulkanBackend(const Scene& scene, const std::vector<Sensor>& sensors, const SimulatorOptions& options)
      : device_(options.device, options.validation, options.maxBufferBytes),
        cache_(device_, options.cache),
        geometry_(device_, scene),
        layout_(device_, cache_.handle(),
                static_cast<uint32_t>(kFramesInFlight * sensors.size() + geometry_.chunks().size())) {
    for (const GeometryChunk& chunk : geometry_.chunks()) {
      const Buffer* buffers[] = {&chunk.placed, &chunk.clusters, &chunk.positions, &chunk.triangleCorners};
      chunkSets_.push_back(layout_.makeSet(1));
      layout_.updateSet(chunkSets_.back(), buffers);
    }
    way_ = chooseWay(options, device_.capabilities().int64Atomics);
    sensors_.reserve(sensors.size());
    for (const Sensor& sensor : sensors)
      sensors_.emplace_back(device_, layout_, geometry_, sensor, options, way_, sensors_);
    cache_.save();
    slotOf(0);
    device_.throwOnMessages();
  }

  // The next scan is handed to the device before the host waits for this one.
  void scanAll(std::span<const Shot> shots, Scan& result, const std::function<void(size_t)>& receive) override {
    if (!shots.empty()) submit(shots, 0);
    for (size_t i = 0; i < shots.size(); ++i) {
      if (i + 1 < shots.size()) submit(shots, i + 1);
      finish(shots, i, result);
      device_.throwOnMessages();
      receive(i);
    }
  }

  const DeviceInfo& device() const override { return device_.capabilities().info; }
  size_t clusterCount() const override { return geometry_.clusterCount(); }
  MemoryUse memory() const override {
    MemoryUse use;
    use.scene = geometry_.bytes();
    for (const Slot& slot : slots_) use.scene += slot.instances.bytes();
    for (const SensorState& state : sensors_) state.addTo(use);
    return use;
  }

 private:
  // What the frames in flight have of their own whatever the sensor.
  struct Slot {
    Slot(const Device& device, const Layout& layout, const Geometry& geometry)
        : commands(device, layout, kStamps),
          instances(device, "instances", geometry.instanceCount() * sizeof(gpu::Instance), Memory::upload) {}
    Commands commands;
    Buffer instances;
    Clock::time_point start;
  };

  // Of scan i of a run; those beyond the first are made when first used.
  Slot& slotOf(size_t i) {
    while (slots_.size() <= i % kFramesInFlight) slots_.emplace_back(device_, layout_, geometry_);
    return slots_[i % kFramesInFlight];
  }

  void submit(std::span<const Shot> shots, size_t i) {
    Slot& slot = slotOf(i);
    slot.start = Clock::now();
    run(slot, sensors_[shots[i].sensor], shots[i].pose, i % kFramesInFlight);
  }

  // Records the stages in order and submits them once.
  void run(Slot& slot, SensorState& state, const Pose& pose, size_t index) {
    if (state.frame().beams == 0) return;
    Commands& commands = slot.commands;
    commands.wait();
    geometry_.placeInstances(pose, static_cast<gpu::Instance*>(slot.instances.mapped()));
    slot.instances.flush();
    const FrameInFlight& frame = state.prepare(index, geometry_, slot.instances);
    commands.begin();
    commands.bindSet(0, frame.set);
    clear(commands, state);
    commands.stamp(0);
    project(commands, state);
    commands.stamp(1);
    bin(commands, state);
    commands.stamp(2);
    resolve(commands, state);
    commands.stamp(3);
    readBack(commands, state, frame);
    commands.submit();
  }

  // Waits for scan i, runs it again for as long as its lists were too small, and reads it. The scan after it may have
  // been cut short as well: that is seen when its turn comes, by the room it had when it was submitted.
  void finish(std::span<const Shot> shots, size_t i, Scan& result) {
    Slot& slot = slotOf(i);
    SensorState& state = sensors_[shots[i].sensor];
    clearResult(state, result);
    if (const size_t index = i % kFramesInFlight; state.frame().beams > 0) {
      slot.commands.wait();
      while (state.cutShort(state.inFlight(index))) {
        for (Slot& other : slots_) other.commands.wait();
        state.growLists(state.inFlight(index));
        run(slot, state, shots[i].pose, index);
        slot.commands.wait();
        ++result.counters.retries;
      }
      slot.commands.readTimings(kStages, result.timings);
      readResults(state, state.inFlight(index), result);
    }
    result.timings.wallMs = std::chrono::duration<double, std::milli>(Clock::now() - slot.start).count();
  }

  void clear(Commands& commands, const SensorState& state) const {
    commands.fill(state.buffer(gpu::kBindCounters), 0, VK_WHOLE_SIZE, 0);
    if (way_ == gpu::kWayLists)
      commands.fill(state.buffer(gpu::kBindListEnds), 0, VK_WHOLE_SIZE, 0);
    else
      commands.fill(state.buffer(gpu::kBindWords), 0, VK_WHOLE_SIZE, gpu::kNone);
    commands.barrier();
  }

  void project(Commands& commands, const SensorState& state) const {
    for (size_t i = 0; i < chunkSets_.size(); ++i) {
      if (i > 0) {
        commands.fill(state.buffer(gpu::kBindCounters), offsetof(gpu::Counters, visible), 4, 0);
        commands.barrier();
      }
      commands.bindSet(1, chunkSets_[i]);
      const gpu::Chunk chunk = {geometry_.chunks()[i].placedCount, 0, 0, 0};
      commands.push(chunk);
      commands.dispatch(state.kernels().projectClusters, std::min(groupCount(), (chunk.placedCount + 63) / 64));
      commands.dispatch(state.kernels().projectTriangles, std::min(groupCount(), chunk.placedCount));
    }
  }

  void bin(Commands& commands, const SensorState& state) const {
    const Kernels& kernels = state.kernels();
    const uint32_t blocks = state.frame().beams / gpu::kScanBlock + 1;
    commands.dispatch(kernels.bin[0], groupCount());
    for (size_t pass = 0; pass < kernels.scan.size(); ++pass)
      commands.dispatch(kernels.scan[pass], pass == gpu::kScanBlocks ? 1 : std::min(groupCount(), blocks));
    if (kernels.bin.size() > 1) commands.dispatch(kernels.bin[1], groupCount());
  }

  void resolve(Commands& commands, const SensorState& state) const {
    const uint32_t groups = (state.frame().columns + gpu::kResolveColumns - 1) / gpu::kResolveColumns;
    commands.dispatch(state.kernels().resolve, groups, state.frame().rows);
  }

  void readBack(Commands& commands, const SensorState& state, const FrameInFlight& frame) const {
    if (!state.readsInPlace())
      for (size_t i = 0; i < std::size(kOutputs); ++i)
        commands.copy(state.buffer(kOutputs[i].binding), frame.results[i]);
    commands.copy(state.buffer(gpu::kBindCounters), frame.results.back());
    commands.barrier();
  }

  // A fixed number of workgroups loops over however many items there are: legal on every device, and no dispatch
  // needs to know a count that only the device has. On a software device neighbouring workgroups share a thread, so
  // the loop's stride also spreads uneven work over the threads.
  uint32_t groupCount() const { return device_.capabilities().cpu ? 256 : 4096; }

  // What does not come from the device. readResults() overwrites the other arrays.
  void clearResult(const SensorState& state, Scan& scan) const {
    scan.tolerances.clear();
    scan.ties.clear();
    scan.timings.stages.clear();
    scan.timings.gpuMs = 0;
    scan.counters = {};
    scan.counters.beams = state.frame().beams;
    scan.counters.triangles = geometry_.dropped().triangles;
    scan.counters.nonFinite = geometry_.dropped().nonFinite;
    scan.counters.degenerate = geometry_.dropped().degenerate;
  }

  template <typename T>
  static const T* mapped(const Buffer& buffer) {
    buffer.invalidate();
    return static_cast<const T*>(buffer.mapped());
  }

  void readResults(const SensorState& state, const FrameInFlight& frame, Scan& scan) const {
    const uint64_t beams = state.frame().beams;
    const auto* points = mapped<gpu::vec4>(frame.results[0]);
    const auto* owners = mapped<std::array<uint32_t, 2>>(frame.results[1]);
    scan.points.resize(3 * beams);
    scan.ranges.resize(beams);
    scan.triangles.resize(beams);
    scan.instances.resize(beams);
    for (uint64_t i = 0; i < beams; ++i) {
      scan.points[3 * i] = points[i].x;
      scan.points[3 * i + 1] = points[i].y;
      scan.points[3 * i + 2] = points[i].z;
      scan.ranges[i] = points[i].w;
      scan.triangles[i] = owners[i][0];
      scan.instances[i] = owners[i][1];
    }
    const gpu::Counters& device = frame.counters();
    Counters& result = scan.counters;
    result.hits = device.hits;
    result.misses = beams - device.hits;
    result.nonFinite += device.nonFinite;
    result.culledByCluster = device.culledByCluster;
    result.culledByRange = device.culledByRange;
    result.culledByFace = device.culledByFace;
    result.culledBetweenBeams = device.culledBetweenBeams;
    result.projected = uint64_t{device.projectedSmall} + device.projectedLarge;
    result.candidates = device.candidates;
    result.integerSides = device.integerSides;
    result.integerRanges = device.integerRanges;
  }

  Device device_;
  PipelineCache cache_;
  Geometry geometry_;
  Layout layout_;
  uint32_t way_ = gpu::kWayNearest;
  std::vector<VkDescriptorSet> chunkSets_;
  std::vector<SensorState> sensors_;
  std::deque<Slot> slots_;  // last: they wait for the device before what it uses goes
};

}  // namespace
}  // namespace vulkan

std::unique_ptr<Backend> makeVulkanBackend(const Scene& scene, const std::vector<Sensor>& sensors,
                                           const SimulatorOptions& options) {
  return std::make_unique<vulkan::VulkanBackend>(scene, sensors, options);
}

}  // namespace gnosphere

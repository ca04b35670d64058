// SPDX-License-Identifier: Apache-2.0
// One scan on a Vulkan device: project, bin, resolve, in one submission.
#include "backend.hpp"

#include <algorithm>
#include <chrono>
#include <cstddef>

#include "vulkan/commands.hpp"
#include "vulkan/sensor_state.hpp"

namespace gnosphere {
namespace vulkan {
namespace {

constexpr const char* kStages[] = {"project", "bin", "resolve"};
constexpr uint32_t kStamps = std::size(kStages) + 1;

class VulkanBackend final : public Backend {
 public:
  VulkanBackend(const Scene& scene, const std::vector<Sensor>& sensors, const SimulatorOptions& options)
      : device_(options.device, options.validation, options.maxBufferBytes),
        geometry_(device_, scene),
        layout_(device_, static_cast<uint32_t>(sensors.size() + geometry_.chunks().size() + 1)),
        commands_(device_, layout_, kStamps) {
    for (const GeometryChunk& chunk : geometry_.chunks()) {
      const Buffer* buffers[] = {&chunk.placed, &chunk.clusters, &chunk.positions, &chunk.corners, &chunk.triangleIds};
      chunkSets_.push_back(layout_.makeSet(1, buffers));
    }
    way_ = chooseWay(options, device_.capabilities().int64Atomics);
    sensors_.reserve(sensors.size());
    for (const Sensor& sensor : sensors)
      sensors_.emplace_back(device_, layout_, geometry_, sensor, options, way_, sensors_);
    device_.throwOnMessages();
  }

  Scan scan(size_t sensor, const Pose& pose) override {
    const auto start = std::chrono::steady_clock::now();
    SensorState& state = sensors_[sensor];
    Scan scan;
    if (state.frame().beams > 0) {
      run(state, pose);
      while (state.growLists()) {
        ++scan.counters.retries;
        run(state, pose);
      }
      commands_.readTimings(kStages, scan.timings);
    }
    readResults(state, scan);
    scan.timings.wallMs = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    device_.throwOnMessages();
    return scan;
  }

  const DeviceInfo& device() const override { return device_.capabilities().info; }
  size_t clusterCount() const override { return geometry_.clusterCount(); }
  MemoryUse memory() const override {
    MemoryUse use;
    use.scene = geometry_.bytes();
    for (const SensorState& state : sensors_) state.addTo(use);
    return use;
  }

 private:
  // Records the stages in order, submits them once and waits.
  void run(SensorState& state, const Pose& pose) {
    state.writeFrame(geometry_, pose);
    commands_.begin();
    commands_.bindSet(0, state.set());
    clear(commands_, state);
    commands_.stamp(0);
    project(commands_, state);
    commands_.stamp(1);
    bin(commands_, state);
    commands_.stamp(2);
    resolve(commands_, state);
    commands_.stamp(3);
    readBack(commands_, state);
    commands_.submit();
    commands_.wait();
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

  void readBack(Commands& commands, const SensorState& state) const {
    if (state.readback().empty()) return;
    for (size_t i = 0; i <= std::size(kOutputs); ++i) {
      const Buffer& from = state.buffer(i < std::size(kOutputs) ? kOutputs[i].binding : gpu::kBindCounters);
      commands.copy(from, state.readback()[i]);
    }
    commands.barrier();
  }

  // A fixed number of workgroups loops over however many items there are: legal on every device, and no dispatch
  // needs to know a count that only the device has. On a software device neighbouring workgroups share a thread, so
  // the loop's stride also spreads uneven work over the threads.
  uint32_t groupCount() const { return device_.capabilities().cpu ? 256 : 4096; }

  void readResults(const SensorState& state, Scan& scan) const {
    const uint64_t beams = state.frame().beams;
    const auto read = [&]<typename T>(size_t output, std::vector<T>& to, uint64_t count) {
      const Buffer& buffer = state.hostSide(output);
      buffer.invalidate();
      const T* data = static_cast<const T*>(buffer.mapped());
      to.assign(data, data + count);
    };
    read(0, scan.points, 3 * beams);
    read(1, scan.ranges, beams);
    read(2, scan.triangles, beams);
    read(3, scan.instances, beams);
    Counters& result = scan.counters;
    result.beams = beams;
    result.triangles = geometry_.dropped().triangles;
    result.nonFinite = geometry_.dropped().nonFinite;
    result.degenerate = geometry_.dropped().degenerate;
    if (beams == 0) return;
    const gpu::Counters& device = state.counters();
    result.hits = device.hits;
    result.misses = beams - device.hits;
    result.nonFinite += device.nonFinite;
    result.culledByCluster = device.culledByCluster;
    result.culledByRange = device.culledByRange;
    result.culledByFace = device.culledByFace;
    result.culledBetweenBeams = device.culledBetweenBeams;
    result.projected = device.projected;
    result.candidates = device.candidates;
    result.integerSides = device.integerSides;
    result.integerRanges = device.integerRanges;
  }

  Device device_;
  Geometry geometry_;
  Layout layout_;
  uint32_t way_ = gpu::kWayNearest;
  std::vector<VkDescriptorSet> chunkSets_;
  std::vector<SensorState> sensors_;
  Commands commands_;
};

}  // namespace
}  // namespace vulkan

std::unique_ptr<Backend> makeVulkanBackend(const Scene& scene, const std::vector<Sensor>& sensors,
                                           const SimulatorOptions& options) {
  return std::make_unique<vulkan::VulkanBackend>(scene, sensors, options);
}

}  // namespace gnosphere

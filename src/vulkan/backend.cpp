// SPDX-License-Identifier: Apache-2.0
// One scan on a Vulkan device: project, bin, resolve, in one submission.
#include "backend.hpp"

#include <algorithm>
#include <chrono>
#include <cstddef>

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
        layout_(device_, static_cast<uint32_t>(sensors.size() + geometry_.chunks().size() + 1)) {
    for (const GeometryChunk& chunk : geometry_.chunks()) {
      const Buffer* buffers[] = {&chunk.placed, &chunk.clusters, &chunk.positions, &chunk.corners, &chunk.triangleIds};
      chunkSets_.push_back(layout_.makeSet(1, buffers));
    }
    way_ = chooseWay(options, device_.capabilities().int64Atomics);
    sensors_.reserve(sensors.size());
    for (const Sensor& sensor : sensors)
      sensors_.emplace_back(device_, layout_, geometry_, sensor, options, way_, sensors_);
    makeCommands();
    device_.throwOnMessages();
  }

  ~VulkanBackend() override {
    vkDestroyFence(device_.handle(), fence_, nullptr);
    vkDestroyQueryPool(device_.handle(), queries_, nullptr);
    vkDestroyCommandPool(device_.handle(), pool_, nullptr);
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
      readTimings(scan.timings);
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
  void makeCommands() {
    VkCommandPoolCreateInfo pool = {VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
    pool.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
    pool.queueFamilyIndex = device_.capabilities().queueFamily;
    VK(vkCreateCommandPool(device_.handle(), &pool, nullptr, &pool_));
    VkCommandBufferAllocateInfo allocate = {VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
    allocate.commandPool = pool_;
    allocate.commandBufferCount = 1;
    VK(vkAllocateCommandBuffers(device_.handle(), &allocate, &commands_));
    VkQueryPoolCreateInfo queries = {VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO};
    queries.queryType = VK_QUERY_TYPE_TIMESTAMP;
    queries.queryCount = kStamps;
    VK(vkCreateQueryPool(device_.handle(), &queries, nullptr, &queries_));
    const VkFenceCreateInfo fence = {VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    VK(vkCreateFence(device_.handle(), &fence, nullptr, &fence_));
  }

  // Records the stages in order, submits them once and waits.
  void run(SensorState& state, const Pose& pose) {
    state.writeFrame(geometry_, pose);
    VkCommandBufferBeginInfo begin = {VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
    VK(vkBeginCommandBuffer(commands_, &begin));
    vkCmdResetQueryPool(commands_, queries_, 0, kStamps);
    const VkDescriptorSet set = state.set();
    vkCmdBindDescriptorSets(commands_, VK_PIPELINE_BIND_POINT_COMPUTE, layout_.handle(), 0, 1, &set, 0, nullptr);
    clear(state);
    stamp(0);
    project(state);
    stamp(1);
    bin(state);
    stamp(2);
    resolve(state);
    stamp(3);
    readBack(state);
    VK(vkEndCommandBuffer(commands_));
    VkSubmitInfo submit = {VK_STRUCTURE_TYPE_SUBMIT_INFO};
    submit.commandBufferCount = 1;
    submit.pCommandBuffers = &commands_;
    VK(vkQueueSubmit(device_.queue(), 1, &submit, fence_));
    VK(vkWaitForFences(device_.handle(), 1, &fence_, VK_TRUE, UINT64_MAX));
    VK(vkResetFences(device_.handle(), 1, &fence_));
  }

  void clear(const SensorState& state) {
    fill(state.buffer(gpu::kBindCounters), 0, VK_WHOLE_SIZE, 0);
    if (way_ == gpu::kWayLists)
      fill(state.buffer(gpu::kBindListEnds), 0, VK_WHOLE_SIZE, 0);
    else
      fill(state.buffer(gpu::kBindWords), 0, VK_WHOLE_SIZE, gpu::kNone);
    barrier();
  }

  void project(const SensorState& state) {
    for (size_t i = 0; i < chunkSets_.size(); ++i) {
      if (i > 0) {
        fill(state.buffer(gpu::kBindCounters), offsetof(gpu::Counters, visible), 4, 0);
        barrier();
      }
      vkCmdBindDescriptorSets(commands_, VK_PIPELINE_BIND_POINT_COMPUTE, layout_.handle(), 1, 1, &chunkSets_[i], 0,
                              nullptr);
      const gpu::Chunk chunk = {geometry_.chunks()[i].placedCount, 0, 0, 0};
      vkCmdPushConstants(commands_, layout_.handle(), VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof chunk, &chunk);
      dispatch(state.kernels().projectClusters, std::min(groupCount(), (chunk.placedCount + 63) / 64));
      dispatch(state.kernels().projectTriangles, std::min(groupCount(), chunk.placedCount));
    }
  }

  void bin(const SensorState& state) {
    const Kernels& kernels = state.kernels();
    const uint32_t blocks = state.frame().beams / gpu::kScanBlock + 1;
    dispatch(kernels.bin[0], groupCount());
    for (size_t pass = 0; pass < kernels.scan.size(); ++pass)
      dispatch(kernels.scan[pass], pass == gpu::kScanBlocks ? 1 : std::min(groupCount(), blocks));
    if (kernels.bin.size() > 1) dispatch(kernels.bin[1], groupCount());
  }

  void resolve(const SensorState& state) {
    const uint32_t groups = (state.frame().columns + gpu::kResolveColumns - 1) / gpu::kResolveColumns;
    dispatch(state.kernels().resolve, groups, state.frame().rows);
  }

  void readBack(const SensorState& state) {
    if (state.readback().empty()) return;
    for (size_t i = 0; i <= std::size(kOutputs); ++i) {
      const Buffer& from = state.buffer(i < std::size(kOutputs) ? kOutputs[i].binding : gpu::kBindCounters);
      const VkBufferCopy region = {0, 0, std::min(from.bytes(), state.readback()[i].bytes())};
      vkCmdCopyBuffer(commands_, from.handle(), state.readback()[i].handle(), 1, &region);
    }
    barrier();
  }

  // A fixed number of workgroups loops over however many items there are: legal on every device, and no dispatch
  // needs to know a count that only the device has. On a software device neighbouring workgroups share a thread, so
  // the loop's stride also spreads uneven work over the threads.
  uint32_t groupCount() const { return device_.capabilities().cpu ? 256 : 4096; }

  void dispatch(const Kernel& kernel, uint32_t groupsX, uint32_t groupsY = 1) {
    if (groupsX == 0 || groupsY == 0) return;
    vkCmdBindPipeline(commands_, VK_PIPELINE_BIND_POINT_COMPUTE, kernel.handle());
    vkCmdDispatch(commands_, groupsX, groupsY, 1);
    barrier();
  }

  void fill(const Buffer& buffer, VkDeviceSize offset, VkDeviceSize size, uint32_t value) {
    vkCmdFillBuffer(commands_, buffer.handle(), offset, size, value);
  }

  // One global barrier stands between any two steps: about ten per scan, and no step overlaps the next anyway.
  void barrier() {
    constexpr VkPipelineStageFlags kDevice = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT;
    VkMemoryBarrier memory = {VK_STRUCTURE_TYPE_MEMORY_BARRIER};
    memory.srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_WRITE_BIT;
    memory.dstAccessMask = VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_READ_BIT |
                           VK_ACCESS_TRANSFER_WRITE_BIT | VK_ACCESS_HOST_READ_BIT;
    vkCmdPipelineBarrier(commands_, kDevice, kDevice | VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &memory, 0, nullptr, 0,
                         nullptr);
  }

  void stamp(uint32_t query) {
    if (device_.capabilities().timestamps)
      vkCmdWriteTimestamp(commands_, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, queries_, query);
  }

  void readTimings(Timings& timings) {
    if (!device_.capabilities().timestamps) return;
    uint64_t ticks[kStamps];
    VK(vkGetQueryPoolResults(device_.handle(), queries_, 0, kStamps, sizeof ticks, ticks, sizeof ticks[0],
                             VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT));
    const auto ms = [&](uint64_t from, uint64_t to) {
      return static_cast<double>(to - from) * device_.capabilities().timestampMs;
    };
    for (size_t i = 0; i < std::size(kStages); ++i) timings.stages.push_back({kStages[i], ms(ticks[i], ticks[i + 1])});
    timings.gpuMs = ms(ticks[0], ticks[kStamps - 1]);
  }

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
  VkCommandPool pool_ = VK_NULL_HANDLE;
  VkCommandBuffer commands_ = VK_NULL_HANDLE;
  VkQueryPool queries_ = VK_NULL_HANDLE;
  VkFence fence_ = VK_NULL_HANDLE;
};

}  // namespace
}  // namespace vulkan

std::unique_ptr<Backend> makeVulkanBackend(const Scene& scene, const std::vector<Sensor>& sensors,
                                           const SimulatorOptions& options) {
  return std::make_unique<vulkan::VulkanBackend>(scene, sensors, options);
}

}  // namespace gnosphere

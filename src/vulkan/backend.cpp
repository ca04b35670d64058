// SPDX-License-Identifier: Apache-2.0
// One scan on a Vulkan device: project, bin, resolve, in one submission.
#include "backend.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstring>
#include <memory>
#include <span>

#include "beam_tables.hpp"
#include "bin.spv.h"
#include "bin_float64.spv.h"
#include "bin_int64.spv.h"
#include "bin_int64_float64.spv.h"
#include "project_clusters.spv.h"
#include "project_triangles.spv.h"
#include "resolve.spv.h"
#include "resolve_float64.spv.h"
#include "scan.spv.h"
#include "vulkan/geometry.hpp"
#include "vulkan/kernel.hpp"

namespace gnosphere {
namespace vulkan {
namespace {

uint32_t chooseWay(const SimulatorOptions& options, const Exactness& parts, bool int64Atomics) {
  switch (options.binning) {
    case Binning::lists: return gpu::kWayLists;
    case Binning::nearest32: return gpu::kWayNearest32;
    case Binning::automatic:
      if (parts.bounds == Exactness::Bounds::paper) return gpu::kWayLists;  // candidates per beam, as the paper has it
      [[fallthrough]];
    case Binning::nearest: break;
  }
  return int64Atomics ? gpu::kWayNearest : gpu::kWayNearest32;
}

Options kernelOptions(const SimulatorOptions& options, bool azimuthOffsets) {
  const Exactness parts = options.exactness.value_or(exactnessOf(options.accuracy));
  Options result;
  // The enumerations of the public API and of shared.h count alike.
  result.bounds = static_cast<uint32_t>(parts.bounds);
  result.cull = static_cast<uint32_t>(parts.cull);
  result.inside = static_cast<uint32_t>(parts.inside);
  result.range = static_cast<uint32_t>(parts.range);
  result.azimuthOffsets = azimuthOffsets;
  result.faces = options.faces == Faces::front  ? gpu::kFacesFront
                 : options.faces == Faces::both ? gpu::kFacesBoth
                                                : gpu::kFacesMaterial;
  return result;
}

// The pipelines of one sensor; only those that its way of binning dispatches.
struct Kernels {
  using Words = std::span<const uint32_t>;
  // `float64` chooses the modules whose exact tests filter in double precision.
  Kernels(const Device& device, const Layout& layout, const Options& options, uint32_t way, bool float64)
      : projectClusters(device, layout, project_clusters, options),
        projectTriangles(device, layout, project_triangles, options),
        resolve(device, layout, float64 ? Words(resolve_float64) : Words(::resolve), options, way) {
    const Words plain = float64 ? Words(bin_float64) : Words(::bin);
    if (way == gpu::kWayNearest) {
      bin.emplace_back(device, layout, float64 ? Words(bin_int64_float64) : Words(bin_int64), options,
                       gpu::kPassNearest);
    } else if (way == gpu::kWayNearest32) {
      bin.emplace_back(device, layout, plain, options, gpu::kPassRange);
      bin.emplace_back(device, layout, plain, options, gpu::kPassOwner);
    } else {
      bin.emplace_back(device, layout, plain, options, gpu::kPassCount);
      bin.emplace_back(device, layout, plain, options, gpu::kPassFill);
      for (uint32_t pass : {gpu::kScanReduce, gpu::kScanBlocks, gpu::kScanApply})
        scan.emplace_back(device, layout, ::scan, options, pass);
    }
  }
  Kernel projectClusters;
  Kernel projectTriangles;
  std::vector<Kernel> bin;
  std::vector<Kernel> scan;
  Kernel resolve;
};

// The arrays of set 0, in binding order, and how many of each the lists have room for.
struct Work {
  std::array<Buffer, gpu::kWorkBindingCount> buffers;
  uint32_t projectedCapacity = 0, tileCapacity = 0, candidateCapacity = 0;

  uint64_t bytes(uint32_t first, uint32_t last) const {
    uint64_t sum = 0;
    for (uint32_t i = first; i <= last; ++i) sum += buffers[i].bytes();
    return sum;
  }
  std::array<const Buffer*, gpu::kWorkBindingCount> pointers() const {
    std::array<const Buffer*, gpu::kWorkBindingCount> result;
    for (size_t i = 0; i < result.size(); ++i) result[i] = &buffers[i];
    return result;
  }
};

// What is read back, with the size per beam.
struct Output {
  uint32_t binding;
  uint32_t bytesPerBeam;
};
constexpr Output kOutputs[] = {{gpu::kBindPoints, 12}, {gpu::kBindRanges, 4}, {gpu::kBindTriangles, 4}, {gpu::kBindOwners, 4}};

struct SensorState {
  BeamTables tables;
  Work work;
  std::unique_ptr<Kernels> kernels;
  VkDescriptorSet set = VK_NULL_HANDLE;
  std::vector<Buffer> readback;  // of kOutputs, then the counters; empty where device memory is the host's
};

class VulkanBackend final : public Backend {
 public:
  VulkanBackend(const Scene& scene, const std::vector<Sensor>& sensors, const SimulatorOptions& options)
      : device_(options.device, options.validation, options.maxBufferBytes),
        geometry_(device_, scene),
        layout_(device_, static_cast<uint32_t>(sensors.size() + geometry_.chunks().size() + 1)),
        way_(chooseWay(options, options.exactness.value_or(exactnessOf(options.accuracy)), device_.capabilities().int64Atomics)) {
    for (const GeometryChunk& chunk : geometry_.chunks()) {
      const Buffer* buffers[] = {&chunk.placed, &chunk.clusters, &chunk.positions, &chunk.corners, &chunk.triangleIds};
      chunkSets_.push_back(layout_.makeSet(1, buffers));
      maxPlaced_ = std::max(maxPlaced_, chunk.placedCount);
    }
    for (const Sensor& sensor : sensors) sensors_.push_back(makeSensor(sensor, options));
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
    if (state.tables.frame.beams > 0) {
      writeFrame(state, pose);
      submit(state);
      while (growLists(state)) {
        ++scan.counters.retries;
        writeFrame(state, pose);
        submit(state);
      }
      readTimings(scan.timings);
    }
    readResults(state, scan);
    scan.timings.wallMs =
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    device_.throwOnMessages();
    return scan;
  }

  const DeviceInfo& device() const override { return device_.capabilities().info; }
  size_t clusterCount() const override { return geometry_.clusterCount(); }
  MemoryUse memory() const override {
    MemoryUse use;
    use.scene = geometry_.bytes();
    for (const SensorState& state : sensors_) {
      use.scene += state.work.bytes(gpu::kBindInstances, gpu::kBindInstances);
      use.sensor += state.work.bytes(gpu::kBindRows, gpu::kBindColumns);
      use.work += state.work.bytes(gpu::kBindFrame, gpu::kBindCounters) +
                  state.work.bytes(gpu::kBindVisible, gpu::kBindOwners);
    }
    return use;
  }

 private:
  SensorState makeSensor(const Sensor& sensor, const SimulatorOptions& options) {
    SensorState state;
    state.tables = makeBeamTables(sensor);
    const Options kernel = kernelOptions(options, state.tables.azimuthOffsets);
    const bool float64 = kernel.inside == gpu::kInsideExact && options.float64 && device_.capabilities().float64;
    state.kernels = std::make_unique<Kernels>(device_, layout_, kernel, way_, float64);
    auto& buffers = state.work.buffers;
    const auto make = [&](uint32_t binding, const char* name, uint64_t bytes, Memory memory = Memory::device) {
      buffers[binding] = Buffer(device_, name, bytes, memory);
    };
    Uploader uploader(device_);
    buffers[gpu::kBindRows] = uploader.upload<gpu::Row>("rows", state.tables.rows);
    buffers[gpu::kBindRowLookup] = uploader.upload<uint32_t>("rowLookup", state.tables.rowLookup);
    buffers[gpu::kBindColumns] = uploader.upload<float>("columns", state.tables.columns);
    const uint64_t beams = state.tables.frame.beams;
    const bool lists = way_ == gpu::kWayLists;
    make(gpu::kBindFrame, "frame", sizeof(gpu::Frame), Memory::upload);
    make(gpu::kBindInstances, "instances", geometry_.instanceCount() * sizeof(gpu::Instance), Memory::upload);
    make(gpu::kBindCounters, "counters", sizeof(gpu::Counters));
    make(gpu::kBindVisible, "visible", uint64_t{maxPlaced_} * 8);
    make(gpu::kBindWords, "words", lists ? 0 : beams * 8);
    make(gpu::kBindListEnds, "listEnds", lists ? beams * 4 : 0);
    make(gpu::kBindBlockSums, "blockSums", lists ? (beams / gpu::kScanBlock + 1) * 4 : 0);
    for (const Output& output : kOutputs) make(output.binding, "results", beams * output.bytesPerBeam);
    // First guesses; growLists() makes room for what a scan turns out to need.
    const uint64_t placed = geometry_.dropped().triangles;
    growProjected(state.work, std::min<uint64_t>(placed, 1 << 18));
    growTiles(state.work, 1 << 12);
    growCandidates(state.work, lists ? beams * 2 : 0);
    state.set = layout_.makeSet(0, state.work.pointers());
    if (!device_.unifiedMemory()) {
      for (const Output& output : kOutputs)
        state.readback.emplace_back(device_, "read-back", beams * output.bytesPerBeam, Memory::readback);
      state.readback.emplace_back(device_, "read-back", sizeof(gpu::Counters), Memory::readback);
    }
    return state;
  }

  void growProjected(Work& work, uint64_t count) {
    work.projectedCapacity = static_cast<uint32_t>(count);
    work.buffers[gpu::kBindProjectedA] = Buffer(device_, "projectedA", count * 12, Memory::device);
    work.buffers[gpu::kBindProjectedB] = Buffer(device_, "projectedB", count * 12, Memory::device);
    work.buffers[gpu::kBindProjectedC] = Buffer(device_, "projectedC", count * 12, Memory::device);
    work.buffers[gpu::kBindProjectedBoxes] = Buffer(device_, "projectedBoxes", count * sizeof(gpu::Box), Memory::device);
    work.buffers[gpu::kBindProjectedIds] = Buffer(device_, "projectedIds", count * 4, Memory::device);
  }
  void growTiles(Work& work, uint64_t count) {
    work.tileCapacity = static_cast<uint32_t>(count);
    work.buffers[gpu::kBindTiles] = Buffer(device_, "tiles", count * sizeof(gpu::Tile), Memory::device);
  }
  void growCandidates(Work& work, uint64_t count) {
    work.candidateCapacity = static_cast<uint32_t>(count);
    work.buffers[gpu::kBindCandidates] = Buffer(device_, "candidates", count * 4, Memory::device);
  }

  // True if a list was too small for the scan just run: it now has room, and the scan must run again.
  bool growLists(SensorState& state) {
    const gpu::Counters& needed = counters(state);
    Work& work = state.work;
    const auto room = [](uint32_t count) { return count + uint64_t{count} / 4; };
    const bool projected = needed.projected > work.projectedCapacity;
    const bool tiles = needed.tiles > work.tileCapacity;
    const bool candidates = way_ == gpu::kWayLists && needed.candidates > work.candidateCapacity;
    // A scan cut short has counted too few of what follows; the next run will tell.
    const uint32_t projectedCount = needed.projected, tileCount = needed.tiles, candidateCount = needed.candidates;
    if (projected) growProjected(work, room(projectedCount));
    if (tiles) growTiles(work, room(tileCount));
    if (candidates) growCandidates(work, room(candidateCount));
    if (projected || tiles || candidates) layout_.updateSet(state.set, work.pointers());
    return projected || tiles || candidates;
  }

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
    queries.queryCount = static_cast<uint32_t>(std::size(kStages)) + 1;
    VK(vkCreateQueryPool(device_.handle(), &queries, nullptr, &queries_));
    const VkFenceCreateInfo fence = {VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    VK(vkCreateFence(device_.handle(), &fence, nullptr, &fence_));
  }

  void writeFrame(SensorState& state, const Pose& pose) {
    gpu::Frame frame = state.tables.frame;
    frame.instanceCount = geometry_.instanceCount();
    frame.projectedCapacity = state.work.projectedCapacity;
    frame.tileCapacity = state.work.tileCapacity;
    frame.candidateCapacity = state.work.candidateCapacity;
    const Buffer& frameBuffer = state.work.buffers[gpu::kBindFrame];
    const Buffer& instances = state.work.buffers[gpu::kBindInstances];
    std::memcpy(frameBuffer.mapped(), &frame, sizeof frame);
    geometry_.placeInstances(pose, static_cast<gpu::Instance*>(instances.mapped()));
    frameBuffer.flush();
    instances.flush();
  }

  // Records and runs the stages in order, and waits.
  void submit(SensorState& state) {
    VkCommandBufferBeginInfo begin = {VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
    VK(vkBeginCommandBuffer(commands_, &begin));
    vkCmdResetQueryPool(commands_, queries_, 0, static_cast<uint32_t>(std::size(kStages)) + 1);
    vkCmdBindDescriptorSets(commands_, VK_PIPELINE_BIND_POINT_COMPUTE, layout_.handle(), 0, 1, &state.set, 0, nullptr);
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
    const auto& buffers = state.work.buffers;
    vkCmdFillBuffer(commands_, buffers[gpu::kBindCounters].handle(), 0, VK_WHOLE_SIZE, 0);
    if (way_ == gpu::kWayLists)
      vkCmdFillBuffer(commands_, buffers[gpu::kBindListEnds].handle(), 0, VK_WHOLE_SIZE, 0);
    else
      vkCmdFillBuffer(commands_, buffers[gpu::kBindWords].handle(), 0, VK_WHOLE_SIZE, gpu::kNone);
    barrier();
  }

  void project(const SensorState& state) {
    for (size_t i = 0; i < chunkSets_.size(); ++i) {
      if (i > 0) {
        vkCmdFillBuffer(commands_, state.work.buffers[gpu::kBindCounters].handle(), offsetof(gpu::Counters, visible), 4, 0);
        barrier();
      }
      vkCmdBindDescriptorSets(commands_, VK_PIPELINE_BIND_POINT_COMPUTE, layout_.handle(), 1, 1, &chunkSets_[i], 0,
                              nullptr);
      const gpu::Chunk chunk = {geometry_.chunks()[i].placedCount, 0, 0, 0};
      vkCmdPushConstants(commands_, layout_.handle(), VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof chunk, &chunk);
      dispatch(state.kernels->projectClusters, std::min(groupCount(), (chunk.placedCount + 63) / 64));
      dispatch(state.kernels->projectTriangles, std::min(groupCount(), chunk.placedCount));
    }
  }

  void bin(const SensorState& state) {
    const uint32_t blocks = state.tables.frame.beams / gpu::kScanBlock + 1;
    dispatch(state.kernels->bin[0], groupCount());
    for (size_t pass = 0; pass < state.kernels->scan.size(); ++pass)
      dispatch(state.kernels->scan[pass], pass == gpu::kScanBlocks ? 1 : std::min(groupCount(), blocks));
    if (state.kernels->bin.size() > 1) dispatch(state.kernels->bin[1], groupCount());
  }

  void resolve(const SensorState& state) {
    // Sixteen beams per invocation keep the number of atomics on the hit counter small.
    dispatch(state.kernels->resolve, (state.tables.frame.columns + 1023) / 1024, state.tables.frame.rows);
  }

  void readBack(const SensorState& state) {
    if (state.readback.empty()) return;
    const auto copy = [&](const Buffer& from, const Buffer& to) {
      const VkBufferCopy region = {0, 0, std::min(from.bytes(), to.bytes())};
      vkCmdCopyBuffer(commands_, from.handle(), to.handle(), 1, &region);
    };
    for (size_t i = 0; i < std::size(kOutputs); ++i)
      copy(state.work.buffers[kOutputs[i].binding], state.readback[i]);
    copy(state.work.buffers[gpu::kBindCounters], state.readback.back());
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

  // One global barrier stands between any two steps: about ten per scan, and no step overlaps the next anyway.
  void barrier() {
    constexpr VkPipelineStageFlags kDevice = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT;
    VkMemoryBarrier memory = {VK_STRUCTURE_TYPE_MEMORY_BARRIER};
    memory.srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_WRITE_BIT;
    memory.dstAccessMask = VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_READ_BIT |
                           VK_ACCESS_TRANSFER_WRITE_BIT | VK_ACCESS_HOST_READ_BIT;
    vkCmdPipelineBarrier(commands_, kDevice, kDevice | VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &memory, 0, nullptr, 0, nullptr);
  }

  void stamp(uint32_t query) {
    if (device_.capabilities().timestamps)
      vkCmdWriteTimestamp(commands_, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, queries_, query);
  }

  void readTimings(Timings& timings) {
    if (!device_.capabilities().timestamps) return;
    uint64_t ticks[std::size(kStages) + 1];
    VK(vkGetQueryPoolResults(device_.handle(), queries_, 0, static_cast<uint32_t>(std::size(ticks)), sizeof ticks, ticks,
                             sizeof ticks[0], VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT));
    for (size_t i = 0; i < std::size(kStages); ++i)
      timings.stages.push_back(
          {kStages[i], static_cast<double>(ticks[i + 1] - ticks[i]) * device_.capabilities().timestampMs});
    timings.gpuMs = static_cast<double>(ticks[std::size(kStages)] - ticks[0]) * device_.capabilities().timestampMs;
  }

  // Where a result can be read by the host.
  const Buffer& hostSide(const SensorState& state, size_t output) const {
    if (!state.readback.empty()) return state.readback[output];
    return state.work.buffers[output < std::size(kOutputs) ? kOutputs[output].binding : gpu::kBindCounters];
  }

  const gpu::Counters& counters(const SensorState& state) const {
    const Buffer& buffer = hostSide(state, std::size(kOutputs));
    buffer.invalidate();
    return *static_cast<const gpu::Counters*>(buffer.mapped());
  }

  void readResults(const SensorState& state, Scan& scan) const {
    const uint64_t beams = state.tables.frame.beams;
    const auto read = [&]<typename T>(size_t output, std::vector<T>& to, uint64_t count) {
      const Buffer& buffer = hostSide(state, output);
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
    const gpu::Counters& device = counters(state);
    result.hits = device.hits;
    result.misses = beams - device.hits;
    result.nonFinite += device.nonFinite;
    result.culledByCluster = device.culledByCluster;
    result.culledByRange = device.culledByRange;
    result.culledByFace = device.culledByFace;
    result.culledBetweenBeams = device.culledBetweenBeams;
    result.projected = device.projected;
    result.candidates = device.candidates;
  }

  static constexpr const char* kStages[] = {"project", "bin", "resolve"};

  Device device_;
  Geometry geometry_;
  Layout layout_;
  uint32_t way_;
  uint32_t maxPlaced_ = 0;
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

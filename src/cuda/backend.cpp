// SPDX-License-Identifier: Apache-2.0
// Scans on a CUDA device: the Vulkan backend's stages in the same order, one scan after another.
#include "backend.hpp"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <limits>

#include "chunks.hpp"
#include "cuda/sensor_arrays.hpp"
#include "effects/planned.hpp"
#include "gnosphere/error.hpp"
#include "scan_options.hpp"

namespace gnosphere::cuda {
namespace {

using Clock = std::chrono::steady_clock;

constexpr float kInfinity = std::numeric_limits<float>::infinity();

// A chunk of the scene on the device, and where it lists what it sees of it.
struct ChunkOnDevice {
  explicit ChunkOnDevice(const ChunkArrays& arrays)
      : groups("groups", arrays.groups),
        clusters("clusters", arrays.clusters),
        positions("positions", arrays.positions),
        triangleCorners("triangleCorners", arrays.triangleCorners) {}
  uint64_t bytes() const { return groups.bytes() + clusters.bytes() + positions.bytes() + triangleCorners.bytes(); }

  Array<gpu::Group> groups;
  Array<gpu::Cluster> clusters;
  Array<float> positions;
  Array<FlatTriangle> triangleCorners;
};

// Effects that are left to choose are left out; those asked for are not there yet.
PlannedEffects geometryAlone(const SimulatorOptions& options, const Sensor& sensor, const Scene& scene) {
  PlannedEffects planned = planEffects(options, sensor, scene);
  if (planned.fields != 0)
    throw Error(ErrorCode::invalidArgument, "CUDA has no fields beyond points, ranges and owners; use a Vulkan device");
  for (Plan::Decision& decision : planned.decisions) {
    if (!decision.in) continue;
    if (decision.request == Use::on)
      throw Error(ErrorCode::invalidArgument,
                  decision.effect + " is on, and CUDA has no effects; use a Vulkan device or --effects clean");
    decision.in = false;
    decision.reason = "CUDA has no effects";
  }
  planned.returns = 1;
  return planned;
}

class CudaBackend final : public Backend {
 public:
  CudaBackend(const Scene& scene, const std::vector<Sensor>& sensors, const SimulatorOptions& options)
      : device_(chosen(options.device)),
        chunks_(scene, options.maxBufferBytes > 0 ? options.maxBufferBytes : device_.info.maxBufferBytes),
        way_(chooseWay(options, true)) {
    for (size_t i = 0; i < chunks_.count(); ++i) onDevice_.emplace_back(chunks_.arrays(i));
    chunks_.dropArrays();
    chunks_.addTo(instances_, scene);
    for (const Sensor& sensor : sensors) {
      planned_.push_back(geometryAlone(options, sensor, scene));
      sensors_.emplace_back(sensor, options, way_, instances_.counters().triangles);
    }
    const Exactness parts = partsOf(options);
    job_.options.BOUNDS = static_cast<uint32_t>(parts.bounds);
    job_.options.CULL = static_cast<uint32_t>(parts.cull);
    job_.options.INSIDE = static_cast<uint32_t>(parts.inside);
    job_.options.RANGE = static_cast<uint32_t>(parts.range);
    job_.options.FACES = static_cast<uint32_t>(options.faces);
    job_.options.CULLING = cullingBits(options);
    job_.options.LAYERS = job_.options.RETURNS = 1;
  }

  void scanAll(std::span<const Shot> shots, Scan& result, const std::function<void(size_t)>& receive) override {
    for (size_t i = 0; i < shots.size(); ++i) {
      use(device_);
      scan(shots[i], result);
      receive(i);
    }
  }

  void setInstance(size_t index, uint32_t mesh, const Transform& transform) override {
    instances_.set(index, mesh, transform);
  }

  void setPositions(size_t mesh, std::span<const float> positions) override {
    use(device_);
    chunks_.setPositions(
        mesh, positions, instances_,
        [&](const ChunkPart& part, size_t count) {
          return onDevice_[part.chunk].triangleCorners.read(part.triangle, count);
        },
        [&](const ChunkPart& part, const ChunkArrays& arrays) {
          ChunkOnDevice& chunk = onDevice_[part.chunk];
          chunk.groups.write(arrays.groups, part.group);
          chunk.clusters.write(arrays.clusters, part.cluster);
          chunk.positions.write(arrays.positions, 3 * part.vertex);
          chunk.triangleCorners.write(arrays.triangleCorners, part.triangle);
        });
  }

  Plan plan(size_t sensor) const override {
    Plan plan;
    plan.effects = planned_[sensor].decisions;
    plan.returns = planned_[sensor].returns;
    return plan;
  }
  const DeviceInfo& device() const override { return device_.info; }
  size_t clusterCount() const override { return chunks_.clusterCount(); }
  MemoryUse memory() const override {
    MemoryUse use;
    for (const ChunkOnDevice& chunk : onDevice_) use.scene += chunk.bytes();
    use.scene += instancesOnDevice_.bytes() + placedOnDevice_.bytes() + ownerRanges_.bytes() + visibleGroups_.bytes() +
                 visible_.bytes();
    for (const SensorArrays& sensor : sensors_) sensor.addTo(use);
    return use;
  }

 private:
  static Device chosen(const std::string& name) {
    Device device = chooseDevice(name);
    use(device);
    return device;
  }

  void scan(const Shot& shot, Scan& result) {
    const Clock::time_point start = Clock::now();
    SensorArrays& sensor = sensors_[shot.sensor];
    gpu::Counters counters = {};
    result.timings = {};
    result.counters = {};
    if (sensor.frame().beams > 0) {
      place(shot.pose, sensor.reach());
      run(sensor);
      for (counters = sensor.counters(); sensor.grow(counters); counters = sensor.counters()) {
        run(sensor);
        ++result.counters.retries;
      }
      stopwatch_.read(result.timings);
    }
    readArrays(sensor, result);
    count(sensor, counters, result.counters);
    result.timings.wallMs = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
  }

  // Grows an array to what it is to hold, and some more.
  template <typename T>
  static void makeRoom(const char* name, uint64_t count, Array<T>& array) {
    if (array.count() < count) array = Array<T>(name, array.count() > 0 ? count + count / 4 : count);
  }

  void place(const Pose& pose, double reach) {
    instances_.choose(pose, reach, {}, placed_);
    instancesOnHost_.resize(instances_.count());
    pairs_.resize(2 * size_t{placed_.pairs});
    if (numbering_ != instances_.numbering()) {
      instances_.writeNumbers(instancesOnHost_.data());
      ownerRangesOnHost_.resize(2 * instances_.ownerRangeCount());
      instances_.writeOwnerRanges(ownerRangesOnHost_.data());
      makeRoom("ownerRanges", ownerRangesOnHost_.size(), ownerRanges_);
      ownerRanges_.write(ownerRangesOnHost_);
      numbering_ = instances_.numbering();
    }
    instances_.writeTransforms(pose, instancesOnHost_.data());
    instances_.writePairs(placed_, pairs_.data());
    makeRoom("instances", instancesOnHost_.size(), instancesOnDevice_);
    makeRoom("placed", pairs_.size(), placedOnDevice_);
    instancesOnDevice_.write(instancesOnHost_);
    placedOnDevice_.write(pairs_);
    for (const PlacedGroups::Chunk& chunk : placed_.still) {
      makeRoom("visibleGroups", chunk.groups, visibleGroups_);
      makeRoom("visible", chunk.clusters, visible_);
    }
  }

  // The stages in order. In two shells: what is near first, since it hides much of what is far.
  void run(SensorArrays& sensor) {
    sensor.prepare(instances_.count(), job_);
    job_.options.AZIMUTH_OFFSETS = sensor.azimuthOffsets();
    job_.arrays[0][gpu::kBindInstances] = instancesOnDevice_.data();
    job_.arrays[0][gpu::kBindPlaced] = placedOnDevice_.data();
    job_.arrays[0][gpu::kBindOwnerRanges] = ownerRanges_.data();
    job_.arrays[0][gpu::kBindVisibleGroups] = visibleGroups_.data();
    job_.arrays[0][gpu::kBindVisible] = visible_.data();
    stopwatch_.start();
    const float border = sensor.shellBorder();
    const gpu::Frame& frame = sensor.frame();
    if (border > 0) {
      project({0, 0, 0, border, 0});
      bin(frame, false);
      launch(Kernel::project_occluders, 0, (frame.columns + gpu::kCoarseColumns - 1) / gpu::kCoarseColumns,
             (frame.rows + gpu::kCoarseRows - 1) / gpu::kCoarseRows);
    }
    project({0, 0, border, kInfinity, border > 0});
    bin(frame, true);
    launch(Kernel::resolve, way_, (frame.columns + gpu::kResolveColumns - 1) / gpu::kResolveColumns, frame.rows);
    stopwatch_.finished("resolve");
  }

  void launch(Kernel kernel, uint32_t pass, uint32_t groupsX, uint32_t groupsY = 1) {
    job_.options.PASS = pass;
    device_.launch(kernel, job_, groupsX, groupsY);
  }

  void project(gpu::Pass pass) {
    for (size_t i = 0; i < onDevice_.size(); ++i) {
      auto* counters = static_cast<std::byte*>(job_.arrays[0][gpu::kBindCounters]);
      fill(counters + offsetof(gpu::Counters, visibleGroups), 0, 8);
      const ChunkOnDevice& onDevice = onDevice_[i];
      job_.arrays[1][gpu::kBindGroups] = onDevice.groups.data();
      job_.arrays[1][gpu::kBindClusters] = onDevice.clusters.data();
      job_.arrays[1][gpu::kBindPositions] = onDevice.positions.data();
      job_.arrays[1][gpu::kBindTriangleCorners] = onDevice.triangleCorners.data();
      const PlacedGroups::Chunk& chunk = placed_.still[i];
      pass.placedFirst = chunk.first;
      pass.placedCount = chunk.groups;
      job_.pass = pass;
      launch(Kernel::project_groups, 0, std::min(device_.groups, (chunk.groups + 63) / 64));
      launch(Kernel::project_clusters, 0, std::min(device_.groups, chunk.groups));
      launch(Kernel::project_triangles, 0, std::min(device_.groups, chunk.clusters));
    }
    stopwatch_.finished("project");
  }

  void bin(const gpu::Frame& frame, bool lastShell) {
    if (way_ == gpu::kWayNearest) {
      launch(Kernel::bin, gpu::kPassNearest, device_.groups);
    } else if (way_ == gpu::kWayNearest32) {
      launch(Kernel::bin, gpu::kPassRange, device_.groups);
      if (lastShell) launch(Kernel::bin, gpu::kPassOwner, device_.groups);
    } else {
      const uint32_t blocks = std::min(device_.groups, frame.beams / gpu::kScanBlock + 1);
      launch(Kernel::bin, gpu::kPassCount, device_.groups);
      launch(Kernel::scan, gpu::kScanReduce, blocks);
      launch(Kernel::scan, gpu::kScanBlocks, 1);
      launch(Kernel::scan, gpu::kScanApply, blocks);
      launch(Kernel::bin, gpu::kPassFill, device_.groups);
    }
    stopwatch_.finished("bin");
  }

  static void readArrays(const SensorArrays& sensor, Scan& scan) {
    const std::vector<gpu::vec4> points = sensor.points();
    const std::vector<Pair> owners = sensor.owners();
    scan.returns = 1;
    scan.points.resize(3 * points.size());
    scan.ranges.resize(points.size());
    scan.triangles.resize(points.size());
    scan.instances.resize(points.size());
    scan.tolerances.clear();
    scan.ties.clear();
    for (size_t i = 0; i < points.size(); ++i) {
      scan.points[3 * i] = points[i].x;
      scan.points[3 * i + 1] = points[i].y;
      scan.points[3 * i + 2] = points[i].z;
      scan.ranges[i] = points[i].w;
      scan.triangles[i] = owners[i][0];
      scan.instances[i] = owners[i][1];
    }
  }

  void count(const SensorArrays& sensor, const gpu::Counters& device, Counters& result) const {
    const Counters& placed = instances_.counters();
    result.beams = sensor.frame().beams;
    result.hits = device.hits;
    result.misses = result.beams - device.hits;
    result.triangles = placed.triangles;
    result.nonFinite = placed.nonFinite + device.nonFinite;
    result.degenerate = placed.degenerate;
    if (result.beams > 0) result.culledByCluster = instances_.usableTriangles() - device.triangles;
    result.culledByRange = device.culledByRange;
    result.culledByFace = device.culledByFace;
    result.culledBetweenBeams = device.culledBetweenBeams;
    result.projected = uint64_t{device.projectedSmall} + device.projectedLarge;
    result.candidates = device.candidates;
    result.integerSides = device.integerSides;
    result.integerRanges = device.integerRanges;
  }

  Device device_;
  Chunks chunks_;
  uint32_t way_;
  InstanceTable instances_;
  std::vector<ChunkOnDevice> onDevice_;
  std::vector<SensorArrays> sensors_;
  std::vector<PlannedEffects> planned_;  // of each sensor
  Stopwatch stopwatch_;
  Job job_ = {};
  // Of the last scan: what was placed, on the host and on the device.
  PlacedGroups placed_;
  uint64_t numbering_ = 0;
  std::vector<gpu::Instance> instancesOnHost_;
  std::vector<uint32_t> pairs_, ownerRangesOnHost_;
  Array<gpu::Instance> instancesOnDevice_;
  Array<uint32_t> placedOnDevice_, ownerRanges_;
  // What the kernels list of one chunk at a time.
  Array<Pair> visibleGroups_, visible_;
};

}  // namespace

std::unique_ptr<Backend> makeBackend(const Scene& scene, const std::vector<Sensor>& sensors,
                                     const SimulatorOptions& options) {
  return std::make_unique<CudaBackend>(scene, sensors, options);
}

}  // namespace gnosphere::cuda

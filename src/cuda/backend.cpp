// SPDX-License-Identifier: Apache-2.0
// Scans on a CUDA device: the Vulkan backend's stages in the same order, one scan after another.
#include "pipeline/backend.hpp"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <limits>

#include "cuda/sensor_arrays.hpp"
#include "geometry/chunks.hpp"
#include "pipeline/scan_options.hpp"

namespace gnosphere::cuda {
namespace {

using Clock = std::chrono::steady_clock;

constexpr float kInfinity = std::numeric_limits<float>::infinity();

// A chunk of the scene on the device: set 1, empty where nothing is planned for it.
using SceneArrays = std::array<Array, gpu::kSceneBindingCountEffects>;

struct Step {
  Kernel kernel;
  uint32_t pass = 0;
  bool everyShell = true;  // of stage bin: else in the last one only
};

Step projectTriangles(uint32_t binning) {
  return {Kernel::project_triangles, binning == gpu::kBinningSlabs ? gpu::kPassSlabs : 0};
}

std::vector<Step> binSteps(uint32_t binning) {
  if (binning == gpu::kBinningNearest) return {{Kernel::bin, gpu::kPassNearest}};
  if (binning == gpu::kBinningSlabs) return {{Kernel::bin, gpu::kPassSlabs}};
  if (binning == gpu::kBinningNearest32) return {{Kernel::bin, gpu::kPassRange}, {Kernel::bin, gpu::kPassOwner, false}};
  return {{Kernel::bin, gpu::kPassCount},
          {Kernel::prefix_sum, gpu::kPrefixReduce},
          {Kernel::prefix_sum, gpu::kPrefixBlocks},
          {Kernel::prefix_sum, gpu::kPrefixApply},
          {Kernel::bin, gpu::kPassFill}};
}

// Of stage effects; effects_surfaces is for each chunk of the scene.
std::vector<Step> effectsSteps(const SensorPlan& plan) {
  std::vector<Step> steps;
  if (plan.footprint()) steps = {{Kernel::effects_footprint, 0}, {Kernel::effects_footprint, 1}};
  if (plan.surfaces() && !plan.footprint()) steps.push_back({Kernel::effects_surfaces});
  if (plan.signals() || plan.speeds()) steps.push_back({Kernel::effects});
  return steps;
}

// On the device; a footprint's hits are found by stage effects, and words are resolved by the host.
bool resolves(const SensorArrays& sensor) {
  return !sensor.plan().footprint() && !sensor.leavesWords();
}

class CudaBackend final : public Backend {
 public:
  CudaBackend(const Scene& scene, const std::vector<Sensor>& sensors, const SimulatorOptions& options)
      : device_(chosen(options.device)),
        plans_(planSensors(scene, sensors, options)),
        chunks_(scene, options.maxBufferBytes > 0 ? options.maxBufferBytes : device_.info.maxBufferBytes) {
    upload(scene, anyOf(plans_, &SensorPlan::looksAtSurfaces), anyOf(plans_, &SensorPlan::holes));
    chunks_.addTo(instances_, scene);
    for (const SensorPlan& plan : plans_) sensors_.emplace_back(plan, options, instances_.counters().triangles);
    const Exactness parts = exactnessOf(options);
    job_.options.BOUNDS = static_cast<uint32_t>(parts.bounds);
    job_.options.CULL = static_cast<uint32_t>(parts.cull);
    job_.options.INSIDE = static_cast<uint32_t>(parts.inside);
    job_.options.RANGE = static_cast<uint32_t>(parts.range);
    job_.options.FACES = static_cast<uint32_t>(options.faces);
    job_.options.CULLING = cullingBits(options);
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
          return onDevice_[part.chunk][gpu::kBindTriangleCorners].read<FlatTriangle>(part.triangle, count);
        },
        [&](const ChunkPart& part, const ChunkArrays& arrays) {
          SceneArrays& chunk = onDevice_[part.chunk];
          chunk[gpu::kBindGroups].write<gpu::Group>(arrays.groups, part.group);
          chunk[gpu::kBindClusters].write<gpu::Cluster>(arrays.clusters, part.cluster);
          chunk[gpu::kBindPositions].write<float>(arrays.positions, 3 * part.vertex);
          chunk[gpu::kBindTriangleCorners].write<FlatTriangle>(arrays.triangleCorners, part.triangle);
          if (meshPlaces_.empty()) return;
          const uint32_t first = meshPlaces_[part.chunk][mesh];
          auto places = chunk[gpu::kBindTrianglePlaces].read<uint32_t>(first, instances_.mesh(mesh).triangles);
          chunks_.placeTriangles(part, arrays.triangleCorners, places);
          chunk[gpu::kBindTrianglePlaces].write<uint32_t>(places, first);
        });
  }

  Plan plan(size_t index) const override {
    const SensorArrays& sensor = sensors_[index];
    Plan plan;
    plan.effects = sensor.plan().decisions;
    plan.returns = sensor.plan().returns;
    plan.binning = nameOfBinning(sensor.binning());
    Options options = job_.options;
    sensor.addTo(options);
    const auto add = [&](const char* stage, uint32_t dispatches, const Step& step) {
      if (plan.stages.empty() || plan.stages.back().name != stage) plan.stages.push_back({stage, 0, {}});
      plan.stages.back().dispatches += dispatches;
      options.PASS = step.pass;
      plan.stages.back().pipelines.push_back({nameOf(step.kernel), constantsOf(options)});
    };
    const auto shells = static_cast<uint32_t>(sensor.shellEnds().size());
    const auto chunks = static_cast<uint32_t>(onDevice_.size());
    add("project", shells * chunks, {Kernel::project_groups});
    add("project", shells * chunks, {Kernel::project_clusters});
    add("project", shells - 1, {Kernel::project_occluders});
    add("project", shells * chunks, projectTriangles(sensor.binning()));
    for (const Step& step : binSteps(sensor.binning())) add("bin", step.everyShell ? shells : 1, step);
    if (sensor.leavesWords()) plan.stages.push_back({"resolve", 0, {}});
    if (resolves(sensor)) add("resolve", 1, {Kernel::resolve, sensor.binning()});
    for (const Step& step : effectsSteps(sensor.plan()))
      add("effects", step.kernel == Kernel::effects_surfaces ? chunks : 1, step);
    sensor.list(plan.buffers);
    return plan;
  }

  const DeviceInfo& device() const override { return device_.info; }
  size_t clusterCount() const override { return chunks_.clusterCount(); }
  MemoryUse memory() const override {
    MemoryUse use;
    for (const SceneArrays& chunk : onDevice_)
      for (const Array& array : chunk) use.scene += array.bytes();
    for (const Array* array : {&placedInstances_, &placedPairs_, &ownerRanges_, &meshes_, &visibleGroups_, &visible_})
      use.scene += array->bytes();
    for (const SensorArrays& sensor : sensors_) sensor.addTo(use);
    return use;
  }

 private:
  static Device chosen(const std::string& name) {
    Device device = chooseDevice(name);
    use(device);
    return device;
  }

  // `surfaces`: with the tables that lead from a triangle's owner to the triangle. `holes`: with those of textures.
  void upload(const Scene& scene, bool surfaces, bool holes) {
    for (size_t i = 0; i < chunks_.count(); ++i) {
      const ChunkArrays arrays = chunks_.arrays(i);
      SceneArrays& chunk = onDevice_.emplace_back();
      chunk[gpu::kBindGroups] = Array("groups", arrays.groups);
      chunk[gpu::kBindClusters] = Array("clusters", arrays.clusters);
      chunk[gpu::kBindPositions] = Array("positions", arrays.positions);
      chunk[gpu::kBindTriangleCorners] = Array("triangleCorners", arrays.triangleCorners);
      if (!surfaces) continue;
      ChunkSurfaces tables = chunks_.surfaces(i, scene, holes);
      chunk[gpu::kBindClusterMaterials] = Array("clusterMaterials", tables.clusterMaterials);
      chunk[gpu::kBindMeshPlaces] = Array("meshPlaces", tables.meshPlaces);
      chunk[gpu::kBindTrianglePlaces] = Array("trianglePlaces", tables.trianglePlaces);
      chunk[gpu::kBindTextureCoordinates] = Array("textureCoordinates", tables.textureCoordinates);
      meshPlaces_.push_back(std::move(tables.meshPlaces));
    }
    chunks_.dropArrays();
  }

  void scan(const Shot& shot, Scan& result) {
    const Clock::time_point start = Clock::now();
    SensorArrays& sensor = sensors_[shot.sensor];
    clearResult(sensor.plan(), 1, instances_, result);
    if (sensor.frame().beams > 0) {
      const std::optional<ShotMotion> motion = motionOf(sensor.plan(), shot, instances_);
      place(motion ? motion->tables.middle : shot.pose, sensor.reach() + reachOf(motion));
      run(sensor, shot, motion);
      while (sensor.grow(sensor.counters())) {
        run(sensor, shot, motion);
        ++result.counters.retries;
      }
      stopwatch_.read(result.timings);
      readResults(sensor.plan(), sensor.results(), instances_, shot, 0, result);
    }
    result.timings.wallMs = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
  }

  // Room for what an array is to hold, and some more.
  template <typename T>
  static void makeRoom(const char* name, uint64_t count, Array& array) {
    if (array.bytes() < count * sizeof(T))
      array = Array(name, (array.bytes() > 0 ? count + count / 4 : count) * sizeof(T));
  }

  template <typename T>
  static void replace(const char* name, const std::vector<T>& values, Array& array) {
    makeRoom<T>(name, values.size(), array);
    array.write<T>(values);
  }

  void place(const Pose& pose, double reach) {
    instances_.choose(pose, reach, {}, placed_);
    instancesOnHost_.resize(instances_.count());
    if (numbering_ != instances_.numbering()) {
      instances_.writeNumbers(instancesOnHost_.data());
      std::vector<uint32_t> ranges(2 * instances_.ownerRangeCount()), meshes(instances_.count());
      instances_.writeOwnerRanges(ranges.data());
      replace("ownerRanges", ranges, ownerRanges_);
      if (!meshPlaces_.empty()) {
        instances_.writeMeshes(meshes.data());
        replace("instanceMeshes", meshes, meshes_);
      }
      numbering_ = instances_.numbering();
    }
    pairs_.resize(2 * size_t{placed_.pairs});
    instances_.writeTransforms(pose, instancesOnHost_.data());
    instances_.writePairs(placed_, pairs_.data());
    replace("instances", instancesOnHost_, placedInstances_);
    replace("placed", pairs_, placedPairs_);
    for (const PlacedGroups::Chunk& chunk : placed_.still) {
      makeRoom<gpu::vec2>("visibleGroups", chunk.groups, visibleGroups_);
      makeRoom<gpu::vec2>("visible", chunk.clusters, visible_);
    }
  }

  // The stages in order, shell by shell: what is near first, since it hides much of what is far.
  void run(SensorArrays& sensor, const Shot& shot, const std::optional<ShotMotion>& motion) {
    sensor.prepare(shot, motion ? &*motion : nullptr, instances_.count(), job_);
    job_.arrays[0][gpu::kBindInstances] = placedInstances_.data();
    job_.arrays[0][gpu::kBindPlaced] = placedPairs_.data();
    job_.arrays[0][gpu::kBindOwnerRanges] = ownerRanges_.data();
    job_.arrays[0][gpu::kBindInstanceMeshes] = meshes_.data();
    job_.arrays[0][gpu::kBindVisibleGroups] = visibleGroups_.data();
    job_.arrays[0][gpu::kBindVisible] = visible_.data();
    stopwatch_.start();
    float begin = 0;
    for (const float end : sensor.shellEnds()) {
      const bool last = end == kInfinity;
      project({0, 0, begin, end, begin > 0}, sensor.binning());
      bin(sensor, last);
      if (!last) launch({Kernel::project_occluders}, device_.groups);
      begin = end;
    }
    if (resolves(sensor)) {
      launchOnBeams({Kernel::resolve, sensor.binning()}, sensor.frame());
      stopwatch_.finished("resolve");
    }
    effects(sensor);
  }

  void launch(const Step& step, uint32_t groupsX, uint32_t groupsY = 1) {
    job_.options.PASS = step.pass;
    device_.launch(step.kernel, job_, groupsX, groupsY);
  }

  void launchOnBeams(const Step& step, const gpu::Frame& frame) {
    launch(step, (frame.columns + gpu::kResolveColumns - 1) / gpu::kResolveColumns, frame.rows);
  }

  void bindChunk(size_t i) {
    for (uint32_t binding = 0; binding < gpu::kSceneBindingCountEffects; ++binding)
      job_.arrays[1][binding] = onDevice_[i][binding].data();
  }

  void project(gpu::Pass pass, uint32_t binning) {
    for (size_t i = 0; i < onDevice_.size(); ++i) {
      auto* counters = static_cast<std::byte*>(job_.arrays[0][gpu::kBindCounters]);
      fill(counters + offsetof(gpu::Counters, visibleGroups), 0, i > 0 ? kPerChunkBytes : kPerShellBytes);
      bindChunk(i);
      const PlacedGroups::Chunk& chunk = placed_.still[i];
      pass.placedFirst = chunk.first;
      pass.placedCount = chunk.groups;
      job_.pass = pass;
      launch({Kernel::project_groups}, std::min(device_.groups, (chunk.groups + 63) / 64));
      launch({Kernel::project_clusters}, std::min(device_.groups, chunk.groups));
      launch(projectTriangles(binning), std::min(device_.groups, chunk.clusters));
    }
    stopwatch_.finished("project");
  }

  void bin(const SensorArrays& sensor, bool lastShell) {
    const uint32_t blocks = std::min(device_.groups, sensor.frame().beams / gpu::kPrefixBlock + 1);
    for (const Step& step : binSteps(sensor.binning())) {
      if (!lastShell && !step.everyShell) continue;
      launch(step, step.kernel == Kernel::bin ? device_.groups : step.pass == gpu::kPrefixBlocks ? 1 : blocks);
    }
    stopwatch_.finished("bin");
  }

  void effects(const SensorArrays& sensor) {
    const std::vector<Step> steps = effectsSteps(sensor.plan());
    for (const Step& step : steps) {
      if (step.kernel == Kernel::effects_footprint) {
        launch(step, std::min(device_.groups, sensor.frame().beams / 64 + 1));
      } else if (step.kernel == Kernel::effects) {
        launchOnBeams(step, sensor.frame());
      } else {
        for (size_t i = 0; i < onDevice_.size(); ++i) {
          bindChunk(i);
          launchOnBeams(step, sensor.frame());
        }
      }
    }
    if (!steps.empty()) stopwatch_.finished("effects");
  }

  Device device_;
  const std::vector<SensorPlan> plans_;  // of every sensor
  Chunks chunks_;
  InstanceTable instances_;
  std::vector<SceneArrays> onDevice_;
  std::vector<std::vector<uint32_t>> meshPlaces_;  // as each chunk has them, where surfaces are looked at
  std::vector<SensorArrays> sensors_;
  Stopwatch stopwatch_;
  Job job_ = {};
  // Of the last scan: what was placed, on the host and on the device.
  PlacedGroups placed_;
  uint64_t numbering_ = 0;
  std::vector<gpu::Instance> instancesOnHost_;
  std::vector<uint32_t> pairs_;
  Array placedInstances_, placedPairs_, ownerRanges_, meshes_;
  // What the kernels list of one chunk at a time.
  Array visibleGroups_, visible_;
};

}  // namespace

std::unique_ptr<Backend> makeBackend(const Scene& scene, const std::vector<Sensor>& sensors,
                                     const SimulatorOptions& options) {
  return std::make_unique<CudaBackend>(scene, sensors, options);
}

}  // namespace gnosphere::cuda

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "gnosphere/batch.hpp"
#include "gnosphere/effects.hpp"
#include "gnosphere/export.hpp"
#include "gnosphere/layout.hpp"
#include "gnosphere/plan.hpp"
#include "gnosphere/scan.hpp"
#include "gnosphere/scene.hpp"
#include "gnosphere/sensor.hpp"

namespace gnosphere {

namespace vulkan {
struct AdoptedDevice;
class Recorder;
}  // namespace vulkan
class BatchStream;
class ResultRing;
struct Recording;
struct SensorPlan;
struct CallerVertices;
struct CallerTransforms;

/// The accuracy setting: named choices of its parts.
enum class Accuracy {
  paper,     ///< section 3 of the paper to the letter: vertex boxes, first-vertex range cull, plain edge normals
  draft,     ///< exact bounds, but the paper's inside test and range in single precision: beams may slip through at
             ///< corners
  standard,  ///< exact bounds, watertight edges, ranges within the depth interval of the triangle's corners
  exact,     ///< exact predicates, one owner per layer, correctly rounded ranges: the same bytes on every device
};

/// The name of an accuracy setting: "paper", "draft", "standard", "exact".
GNOSPHERE_API const char* nameOf(Accuracy accuracy);

/// The parts of an accuracy setting. Change one part at a time to see what it costs and which errors it avoids.
struct AccuracyParts {
  /// Which beams a triangle is tested against.
  enum class Bounds {
    paper,    ///< the floor of the corners' angles, computed with GLSL's asin and atan
    corners,  ///< the corners' angles, widened for rounding: misses beams where an edge bulges beyond them and at the
              ///< poles
    exact,    ///< every beam that can meet the triangle
  };
  /// Which point of a triangle must be in range.
  enum class Cull { firstCorner, nearestPoint };
  /// How the inside test decides whether a beam hits a triangle.
  enum class Inside {
    plain,       ///< signs of the edge normals a x b, equation 2 of the paper
    watertight,  ///< no beam slips between triangles that share an edge or a corner
    exact,       ///< exact signs; a beam on a shared edge hits exactly one triangle
  };
  /// How the range of a hit is computed.
  enum class Range {
    plane,        ///< equation 4 of the paper
    edgeWeights,  ///< a convex combination of the depths of the corners
    exact,        ///< the exact quotient, correctly rounded; only with the exact inside test
  };
  Bounds bounds = Bounds::exact;
  Cull cull = Cull::nearestPoint;
  Inside inside = Inside::watertight;
  Range range = Range::edgeWeights;
};

/// Returns the parts of a named setting.
GNOSPHERE_API AccuracyParts accuracyPartsOf(Accuracy accuracy);

/// Which faces of a triangle reflect.
enum class ReflectingFaces {
  material,  ///< both faces of double-sided materials, the front of others; only glTF files have others
  front,
  both,
};

/// How the hits of each beam are collected. Every choice gives the same cloud.
enum class Binning {
  automatic,  ///< slabs on a CPU; nearest on other devices and for footprints; lists with the bounds of the paper
  nearest,    ///< one 64-bit atomic minimum per hit; replaced by lists on devices without that instruction
  lists,      ///< a list of candidates per beam: count, prefix sum, fill
  slabs,  ///< one subgroup owns a slab of columns, so the minimum needs no atomics; replaced by lists as `nearest` is
};

/// Which triangles are skipped early. The switches affect only the time; the cloud is the same.
struct Culling {
  bool range = true;    ///< triangles out of range are skipped before they are projected
  bool rows = true;     ///< triangles between two rows of beams, or above or below the field of view, are skipped
  bool columns = true;  ///< triangles between two columns of beams are skipped
  bool cones = true;    ///< clusters of one-sided triangles that all face away are skipped
  /// Triangles behind hits nearer to the sensor are skipped. The test reads the word of every beam, so by default it is
  /// used if the scene has enough triangles to make that worthwhile.
  enum class Occlusion { automatic, always, never };
  Occlusion occlusion = Occlusion::automatic;
};

/// How the footprints that lie on several triangles are computed. Every choice gives the same cloud.
enum class SubRays {
  automatic,  ///< lanes on a graphics card, one on a CPU
  /// The lanes of a subgroup share the sub-rays of a beam. If a lane would have more than two, and with CUDA, the
  /// choice is `one`.
  lanes,
  one,  ///< one invocation has all sub-rays of a beam
};

/// How a scan is computed. The choices affect only time and memory; the cloud is the same.
struct Tuning {
  Binning binning = Binning::automatic;
  Culling culling;
  SubRays subRays = SubRays::automatic;
  /// If true, a sensor that scans repeatedly from one pose keeps the hits on instances that have not moved (8 bytes per
  /// beam, from its second scan from that pose). Keeping hits has no effect with lists of hits or the paper's bounds.
  bool keepStill = true;
  bool float64 = true;  ///< if false, double precision is not used even if the device has it
  /// If true, the device's own time and that of each stage are measured on a CPU device, too. Other devices always
  /// measure them: it costs them nothing. Mesa's CPU driver stops its threads at every timestamp, which takes about
  /// 1 ms of a scan, as long as a scan of few beams itself.
  bool stageTimes = false;
  /// Most bytes that scans which are submitted together take on the device in lists of instances and clusters; at least
  /// one scan is submitted. 0 means 256 MB on a CPU and 1 GB on other devices.
  uint64_t maxBatchBytes = 0;
  /// Most triangles and lines of light, roughly counted, that one submission looks at on a Vulkan device of the
  /// library's own; a scan of more is several submissions, so that a desktop draws between them and its driver does not
  /// take the device for stuck. 0 means no limit on a CPU and 67,108,864 on other devices.
  uint64_t maxSubmissionWork = 0;
  /// Upper limit in bytes for any one buffer on a Vulkan device; 0 means the limit of the device. If an array needs
  /// more, the call that needs it fails for want of memory; the simulator stays usable.
  uint64_t maxBufferBytes = 0;
};

/// A device of this machine, and whether it can be used.
struct DeviceInfo {
  std::string name;
  std::string type;             ///< "discrete", "integrated", "virtual", "cpu", "other", "cuda" or "reference"
  std::string driver;           ///< name and version of the driver
  std::string apiVersion;       ///< Vulkan version; empty for the reference
  uint64_t maxBufferBytes = 0;  ///< largest size of one buffer
  uint32_t subgroupSize = 0;
  bool usable = false;
  std::string reason;  ///< why the device is not usable; empty if it is
  /// Identifies the card; Vulkan and CUDA report the same value. All zeros if the driver reports none.
  std::array<uint8_t, 16> uuid = {};
};

/// Lists every Vulkan device of this machine, then every CUDA device if CUDA is built in, and the reference last. A
/// machine without Vulkan is no error: `vulkanProblem`, if given, then says why no Vulkan device is listed.
GNOSPHERE_API std::vector<DeviceInfo> listDevices(std::string* vulkanProblem = nullptr);

/// Which device a simulator runs on; by default the best Vulkan device of the machine.
struct DeviceChoice {
  enum class Kind {
    vulkan,
    cuda,       ///< only if CUDA is built in: the arithmetic of the shaders, so the clouds have the same bytes
    cudaFast,   ///< as `cuda`, but CUDA's compiler may fuse and reorder operations, so bytes may differ
    reference,  ///< every beam in double precision on the CPU; the other devices are compared with it
  };
  Kind kind = Kind::vulkan;
  /// The number of a Vulkan device in listDevices() or a part of its name, or the number of a CUDA device. If empty,
  /// the best device is used, and with "gpu" the best Vulkan device that is no CPU.
  std::string name;
  /// DeviceInfo::uuid of the device, in which case `name` is ignored; all zeros for any device.
  std::array<uint8_t, 16> uuid = {};
  /// The caller's own device, see vulkan::adopt(), in which case `name` and `uuid` are ignored.
  std::shared_ptr<const vulkan::AdoptedDevice> adopted;

  DeviceChoice() = default;
  DeviceChoice(Kind ofKind, std::string named = {}) : kind(ofKind), name(std::move(named)) {}
  /// Chooses the given device, if the machine still has it.
  GNOSPHERE_API DeviceChoice(const DeviceInfo& device);
};

/// Parses the choice of a device on a command line: "auto", "gpu" for a Vulkan device that is no CPU, a number in
/// listDevices(), a part of the name of a Vulkan device or a number in it, "reference", "cuda:N" or "cuda-fast:N".
GNOSPHERE_API DeviceChoice deviceByName(const std::string& text);
/// The text that deviceByName() makes this choice of.
GNOSPHERE_API std::string nameOf(const DeviceChoice& choice);

/// How a simulator computes, and on which device.
struct SimulatorOptions {
  DeviceChoice device;
  Accuracy accuracy = Accuracy::standard;
  std::optional<AccuracyParts> accuracyParts;  ///< if given, replaces `accuracy`
  ReflectingFaces faces = ReflectingFaces::material;
  MaterialTable materials;  ///< reflectances by name; they override the scene's materials
  /// Folder in which compiled kernels are kept. If empty, it is "gnosphere" in $XDG_CACHE_HOME or ~/.cache, and on
  /// Windows in %LOCALAPPDATA%; if "off", kernels are not kept.
  std::string cache;
  /// Receives a sentence about a problem that is no error, for example that compiled kernels cannot be kept. The
  /// function is called on the thread that calls the simulator. The library itself prints nothing.
  std::function<void(const std::string& message)> warn;
  /// Receives the steps of every scan on a Vulkan device, a line for each, with its size and the time until it was
  /// done. Each step is then timed by itself, so scans take a little longer. Batches of a BatchStream have no lines.
  std::function<void(const std::string& line)> trace;
  bool validation = false;  ///< turns the Vulkan validation layer on; its messages are errors of the device
  /// The simulator compiles the pipelines of its sensors' scans and cannot scan. Its plan has what the driver's
  /// compiler says of each pipeline. No device memory is needed and nothing is submitted, so a driver that only
  /// compiles is enough. Only for Vulkan devices of the library's own.
  bool compileOnly = false;
  /// Results stay on the device: a stream of batches submits the scans, and no other call scans. Only for Vulkan
  /// devices of the library's own.
  bool resultsOnDevice = false;
  Tuning tuning;
};

/// A sensor, the effects that its scans simulate, and the fields that its scans hold.
struct SensorRequest {
  Sensor sensor;
  Effects effects;  ///< by default those that the scene and the sensor call for; Effects::none() is geometry alone
  /// The fields that scans hold beyond points, ranges, triangles and instances; read them with Scan::column(). With
  /// SimulatorOptions::resultsOnDevice, the fields that batches hold beyond ranges.
  std::vector<Field> fields;
  /// If true, shots may bring their own weather: fog, rain, snow and volumes are planned even if `effects` gives them
  /// no value, unless they are off.
  bool variableWeather = false;
  /// Results that stay on a device lie like this: in the caller's buffers on a device of the caller (see
  /// vulkan::adopt()), and with SimulatorOptions::resultsOnDevice in those of a BatchStream, which has columns of
  /// ranges and `fields` if the layout is empty. Its fields need not be repeated in `fields`. Without any of the two
  /// the layout must be empty.
  RecordLayout layout;
  /// Indices of instances that the sensor does not see, for example the body of the robot that carries it: its scans
  /// are those of a scene without them. If an instance is removed, its index leaves the list, so that another one that
  /// gets it is seen.
  std::vector<uint32_t> ignoredInstances;

  SensorRequest() = default;
  SensorRequest(Sensor scanner, Effects simulated = {}, std::vector<Field> reported = {})
      : sensor(std::move(scanner)), effects(std::move(simulated)), fields(std::move(reported)) {}
};

/// Bytes of device memory by purpose. Arrays keep their greatest size until the simulator ends, also after what was in
/// them is removed.
struct MemoryUse {
  uint64_t scene = 0;   ///< meshes, instances, and lists whose size follows theirs
  uint64_t sensor = 0;  ///< tables of the beams
  uint64_t work = 0;    ///< results, and the intermediate arrays and lists of the stages
};

/// How the sensor moves during a scan: poses at times after its start. Between stamps the position is interpolated
/// linearly and the orientation by slerp; before the first and after the last stamp the pose is constant, and speeds
/// are those of the nearest interval.
struct SensorMotion {
  struct Stamp {
    double time = 0;  ///< seconds after the start of the scan, ascending
    Pose pose;
  };
  /// If empty, the sensor stands still. Several stamps, all before the first or after the last beam, are refused.
  std::vector<Stamp> stamps;
};

/// How an instance moves during a scan: from its own transform at the start to `end`, Sensor::rotationPeriod later, or
/// for a sensor without a rotation period at the time of the last beam. Vertices move along straight lines at constant
/// speed; if no beam fires after the start, they stand still. A shot has at most one for each instance.
struct InstanceMotion {
  size_t instance = 0;
  Transform end;
};

/// How a deformable mesh moves during a scan: from its deformation at the start to `end`, as InstanceMotion does.
/// Vertices move along straight lines at constant speed, those of every instance of the mesh. A shot has at most one
/// for each mesh.
struct MeshMotion {
  size_t mesh = 0;
  Deformation end;
};

/// One scan of a run.
struct Shot {
  Pose pose;  ///< of the sensor if `motion` is empty; with `deskew`, points are reported in the frame of this pose
  size_t sensor = 0;
  uint64_t frame = 0;  ///< frame number: part of the key of the random numbers, and of a list the number of the pattern
  uint32_t world = 0;  ///< the shot sees the instances of this world and those of world 0, as if there were no others
  SensorMotion motion;  ///< ignored, with a scan from `pose`, where Effects::SensorMotion is not planned: see the plan
  std::vector<InstanceMotion> instanceMotions;
  std::vector<MeshMotion> meshMotions;
  /// If given, replaces the fog, rain, snow and volumes of the sensor's Effects.
  std::optional<Weather> weather;
  /// Indices of instances that the shot does not see, beside those of SensorRequest::ignoredInstances: of many robots
  /// in one world that share a sensor, the body of the one that carries it. Effects are planned as if it saw them.
  std::vector<uint32_t> ignoredInstances;
};

/// The indices of what Simulator::addScene() has added, each list in the order of the scene's.
struct AddedScene {
  std::vector<uint32_t> materials, meshes, instances;
};

/// A scene and sensors on a device. Materials, meshes, instances and sensors can be added and removed between scans.
/// Only changes are uploaded, and the plans of the sensors are adapted to the scene. Indices are stable; the index of a
/// removed object is given to the next one added.
///
/// A call that throws Error(invalidArgument) or Error(outOfMemory) leaves the simulator as it was. So does one that
/// throws std::bad_alloc, for want of host memory: any call may, wherever Error(outOfMemory) is named. A simulator
/// that was moved to another variable cannot be called any more: calls throw Error(invalidArgument).
///
/// One thread at a time may use a simulator: while a call is at work, calls by other threads throw
/// Error(invalidArgument), and so do calls by the functions that it calls, such as `receive` and `warn`, except to
/// const functions. Several simulators may be used by several threads at once. Simulators that one thread makes on one
/// device share its queue and the kernels that are compiled for it.
class GNOSPHERE_API Simulator {
 public:
  /// Uploads the scene and compiles the stages; on a CPU the first scan that needs a stage compiles it. Throws
  /// Error(invalidArgument) for an invalid argument, Error(device) that gives the reason per device if no device is
  /// suitable, Error(outOfMemory).
  Simulator(const Scene& scene, const std::vector<SensorRequest>& sensors, const SimulatorOptions& options = {});
  Simulator(const Scene& scene, const SensorRequest& sensor, const SimulatorOptions& options = {});
  ~Simulator();
  Simulator(Simulator&&) noexcept;
  Simulator& operator=(Simulator&&) noexcept;

  /// Makes one scan from the fixed pose `pose`. Its frame number is 0, so every call has the same random numbers, and a
  /// sensor of several patterns uses the first one; scanInto() takes a Shot with another frame. Throws
  /// Error(invalidArgument) for a pose that is not finite or an unknown sensor, Error(device) or Error(outOfMemory) if
  /// the device fails.
  Scan scan(const Pose& pose, size_t sensor = 0);
  /// Makes one scan of a shot, with motion, weather and frame number, into an existing Scan, whose arrays are reused.
  /// No device memory is allocated once the device's lists have their size; of host memory each call takes and gives
  /// back what describes the shot, such as a table of the columns' motion. Throws as scan() does, and
  /// Error(invalidArgument) for weather that is not planned (see SensorRequest::variableWeather). If the device fails
  /// or memory runs out, the result is empty.
  void scanInto(const Shot& shot, Scan& result);
  /// Makes many scans, each with the same result as scanInto(), pipelined: while the host receives one scan, the device
  /// works on the next. `receive` gets the index into `shots` and the scan, in order and on the calling thread. The
  /// scan is overwritten after `receive` returns; its wallMs includes the wait for the scan before it, but not the time
  /// that `receive` took meanwhile. Shots of one sensor that follow each other are submitted together, unless meshes
  /// are deformed during a scan, or the sensor stands still and can reuse its hits. Their times are then equal shares,
  /// and their counters of triangles are shares by the triangles of their worlds. Throws as scanInto() does; all shots
  /// are checked before the first scan. An exception of `receive` ends the run and is passed on.
  void scanAll(std::span<const Shot> shots, const std::function<void(size_t shot, const Scan& scan)>& receive);

  /// Makes the scans of many shots of one sensor, each with the same result as scanInto(), and collects them in arrays
  /// with the view (the index into `shots`) as their first dimension. `fields` are those that the batch has beside the
  /// ranges; without any it has all that a Scan of the sensor has. The arrays of `result` are reused. The shots are
  /// submitted together as those of scanAll() are, in as many submissions as keep the work arrays and the lists of one
  /// within Tuning::maxBatchBytes. `progress`, if given, gets the number of views that are done after each of them, on
  /// the calling thread; its exception ends the batch and is passed on. Throws as scanAll() does, and
  /// Error(invalidArgument) that names the first shot of another sensor, or a field that the sensor does not report.
  /// Without shots the batch is one of `sensorOfNone`, which counts in this case alone.
  void scanBatchInto(std::span<const Shot> shots, Batch& result, std::span<const Field> fields = {},
                     const std::function<void(size_t views)>& progress = {}, size_t sensorOfNone = 0);
  Batch scanBatch(std::span<const Shot> shots, std::span<const Field> fields = {}, size_t sensorOfNone = 0);

  /// Each of the following changes takes effect with the next scan. Each throws Error(invalidArgument) that names an
  /// index that does not exist or was removed, or a value that is not valid.

  /// Adds a sensor and returns its index.
  size_t addSensor(const SensorRequest& request);
  /// Removes a sensor; the next one that is added gets its index.
  void removeSensor(size_t sensor);

  /// Adds a material and returns its index. `image` is the alpha channel of its texture, for AlphaMode::mask; the
  /// material's own `alphaImage` is ignored.
  size_t addMaterial(const Material& material, const AlphaImage* image = nullptr);
  /// Replaces a material, also of meshes in use, whose triangles stay where they are; `image` as in addMaterial(). Of a
  /// material that a mesh uses `doubleSided` and `classId` must stay as they are, and whether it has an image.
  void setMaterial(size_t index, const Material& material, const AlphaImage* image = nullptr);
  /// Removes a material; no mesh may use it.
  void removeMaterial(size_t material);

  /// Adds a mesh and returns its index. Its parts refer to materials by index.
  size_t addMesh(const Mesh& mesh);
  /// Removes a mesh; no instance may place it. Meshes that are added later reuse its memory, see MemoryUse.
  void removeMesh(size_t mesh);
  /// Moves the vertices of a mesh: 3 values per vertex, in metres relative to Mesh::origin, for as many vertices as the
  /// mesh has. Its triangles do not change. The mesh must not be deformable. Within a scan its shape stands still.
  void setPositions(size_t mesh, std::span<const float> positions);
  /// Moves the joints and morph targets of a deformable mesh, whose vertices then are at deformedPositions(). An empty
  /// deformation puts them back to Mesh::positions.
  void setDeformation(size_t mesh, const Deformation& deformation);

  /// Adds an instance and returns its index, which Scan::instances uses.
  size_t addInstance(uint32_t mesh, const Transform& transform, uint16_t classId = 0, uint32_t world = 0);
  /// Adds many instances and returns their indices, in order. Instance::name and Instance::className are ignored.
  std::vector<uint32_t> addInstances(std::span<const Instance> instances);
  /// Adds the materials, meshes and instances of a scene, for example of a vehicle with several parts, moved by
  /// `transform`. To move it again, set the transforms of its instances to the new one times those that `scene` states.
  /// If memory runs out, and runs out again while what was added is taken back, materials and meshes without instances
  /// stay.
  AddedScene addScene(const Scene& scene, const Transform& transform = {});
  /// Removes an instance; the next one that is added gets its index.
  void removeInstance(size_t instance);
  /// Removes many instances; the next ones that are added get their indices, in this order. Everything is checked
  /// before anything changes: the error names the first entry of `instances` that does not exist, or that an entry
  /// before it names, too.
  void removeInstances(std::span<const uint32_t> instances);
  /// Moves an instance: `transform` maps the mesh frame to the world frame, in metres.
  void setTransform(size_t instance, const Transform& transform);
  /// Moves many instances, as setTransform() does one after another. `values` holds 12 numbers per instance, the rows
  /// of its Transform, or 7: the position x, y, z (metres) of the mesh frame in the world frame, and its orientation as
  /// a quaternion x, y, z, w of any length but zero. Everything is checked before anything changes: the error names the
  /// first entry of `instances` that does not exist, or whose values are not finite. Of equal indices the last counts.
  void setTransforms(std::span<const uint32_t> instances, std::span<const double> values);
  void setTransforms(std::span<const uint32_t> instances, std::span<const float> values);

  /// Describes what the next scan of the sensor computes, and why; with `views`, what so many scans do that are made
  /// together in one submission, as those of batches are. The simulator stays as it is.
  Plan plan(size_t sensor = 0, size_t views = 1) const;
  const DeviceInfo& device() const;  ///< the device that scans
  MemoryUse memory() const;          ///< bytes of the arrays that there are now
  size_t clusterCount() const;       ///< number of clusters of all meshes; 0 on the reference

 private:
  friend class vulkan::Recorder;
  friend class BatchStream;
  class Impl;
  const std::vector<std::shared_ptr<const SensorPlan>>& plans() const;
  std::shared_ptr<ResultRing> makeRing(size_t buffers, uint64_t bytes, uint64_t hostBytes);
  std::shared_ptr<const void> lendToRecorder();
  void record(Recording& recording);
  void abandon(size_t frame);
  void setVertices(size_t mesh, const CallerVertices& buffer);
  void setTransforms(const CallerTransforms& buffer);
  std::unique_ptr<Impl> impl_;
};

}  // namespace gnosphere

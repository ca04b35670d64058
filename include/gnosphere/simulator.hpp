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

#include "gnosphere/effects.hpp"
#include "gnosphere/export.hpp"
#include "gnosphere/plan.hpp"
#include "gnosphere/scan.hpp"
#include "gnosphere/scene.hpp"
#include "gnosphere/sensor.hpp"

namespace gnosphere {

/// The accuracy dial.
enum class Accuracy {
  paper,     ///< section 3 of the paper to the letter: vertex boxes, first-vertex range cull, plain edge normals
  draft,     ///< exact bounds, but the paper's inside test and range: single precision, gaps at corners
  standard,  ///< exact bounds, watertight edges, range within the triangle's own depth interval
  exact,     ///< decided by exact predicates, one owner per layer, range correctly rounded: equal bytes everywhere
};

/// "paper", "draft", "standard", "exact".
GNOSPHERE_API const char* nameOf(Accuracy accuracy);

/// What a setting of the dial is made of. Turn one part at a time to see what it costs and what it saves.
struct AccuracyParts {
  /// Which beams a triangle is tried on.
  enum class Bounds {
    paper,    ///< floor of the corners' angles, by GLSL's own asin and atan
    corners,  ///< the corners' angles, widened for rounding: loses what an edge's bulge and the poles add
    exact,    ///< every beam that can meet the triangle
  };
  /// How a triangle is culled by range.
  enum class Cull { firstCorner, nearestPoint };
  /// How a beam is told to be inside a triangle.
  enum class Inside {
    plain,       ///< edge normals a x b, equation 2 of the paper
    watertight,  ///< no beam slips between triangles that share an edge or a corner
    exact,       ///< exact signs; a beam on an edge has one owner
  };
  /// How the range of a hit is computed.
  enum class Range {
    plane,        ///< equation 4 of the paper
    edgeWeights,  ///< a convex combination of the corners' depths
    exact,        ///< the real quotient, correctly rounded; only with Inside::exact
  };
  Bounds bounds = Bounds::exact;
  Cull cull = Cull::nearestPoint;
  Inside inside = Inside::watertight;
  Range range = Range::edgeWeights;
};

/// The parts of a named setting.
GNOSPHERE_API AccuracyParts accuracyPartsOf(Accuracy accuracy);

/// Which faces of a triangle reflect.
enum class ReflectingFaces {
  material,  ///< Material::doubleSided decides
  front,
  both,
};

/// How triangles meet beams. Every way gives the same cloud.
enum class Binning {
  automatic,  ///< where only the first return matters slabs on a CPU, nearest elsewhere; lists for the rest
  nearest,    ///< one 64-bit atomic minimum per hit; falls back to lists where the device has none
  lists,      ///< per beam a list of candidates: count, scan, fill
  slabs,      ///< a minimum without atomics, slab of columns by slab; falls back to lists as nearest does
};

/// What is skipped before a triangle is read. Every switch costs or saves time only: the cloud is the same.
struct Culling {
  bool range = true;    ///< out of range
  bool rows = true;     ///< between two rows of beams, above or below the field of view
  bool columns = true;  ///< between two columns of beams
  bool cones = true;    ///< clusters of one-sided triangles that all show their back
  /// Behind what was met nearer to the sensor. It costs a look at every beam; automatic asks whether that pays.
  enum class Occlusion { automatic, always, never };
  Occlusion occlusion = Occlusion::automatic;
};

/// How a scan is computed. Every choice gives the same cloud, in another time or with other memory.
struct Tuning {
  Binning binning = Binning::automatic;
  Culling culling;
  /// A sensor that scans again from the same pose keeps what the instances gave that have not moved since: 8 bytes per
  /// beam, from its second scan from there on. Neither with Binning::lists nor with the paper's bounds.
  bool keepStill = true;
  bool float64 = true;  ///< off: as on a device without double precision
  /// Cap on any one buffer of a Vulkan device, below what it allows; 0: what it allows. An array that needs more is
  /// Error(outOfMemory), from the call that needs it; the simulator stays usable after it.
  uint64_t maxBufferBytes = 0;
};

struct DeviceInfo {
  std::string name;
  std::string type;             ///< discrete, integrated, virtual, cpu, other, cuda, reference
  std::string driver;           ///< name and version
  std::string apiVersion;       ///< Vulkan version; empty for the reference
  uint64_t maxBufferBytes = 0;  ///< of one buffer, at most
  uint32_t subgroupSize = 0;
  bool usable = false;
  std::string reason;  ///< why not, where it is not usable
  /// Identifies the card, the same by Vulkan and by CUDA; zeros where the driver tells none.
  std::array<uint8_t, 16> uuid = {};
};

/// Every Vulkan device of this machine, then every CUDA device where CUDA is built in, and the reference last. Never
/// throws for lack of Vulkan: the list then holds the reference alone, and `vulkanProblem` says why.
GNOSPHERE_API std::vector<DeviceInfo> listDevices(std::string* vulkanProblem = nullptr);

/// Which device a simulator runs on; by default the best Vulkan device there is.
struct DeviceChoice {
  enum class Kind {
    vulkan,
    cuda,       ///< where CUDA is built in: with the arithmetic of the shaders, so with their bytes
    cudaFast,   ///< with what CUDA's compiler makes of it
    reference,  ///< every beam in double on the CPU: the truth that the others are judged by
  };
  Kind kind = Kind::vulkan;
  /// A Vulkan device by its number in listDevices() or by a part of its name, or a CUDA device by its number. Empty:
  /// the best one.
  std::string name;
  /// Of DeviceInfo. Zeros: any; else it decides, and `name` is not looked at.
  std::array<uint8_t, 16> uuid = {};

  DeviceChoice() = default;
  DeviceChoice(Kind ofKind, std::string named = {}) : kind(ofKind), name(std::move(named)) {}
  /// That device, if the machine still has it.
  GNOSPHERE_API DeviceChoice(const DeviceInfo& device);
};

/// A choice as a command line names it: "auto", the number or a part of the name of a Vulkan device, "reference",
/// "cuda:N" or "cuda-fast:N".
GNOSPHERE_API DeviceChoice deviceByName(const std::string& text);
/// The text that deviceByName() makes this choice of.
GNOSPHERE_API std::string nameOf(const DeviceChoice& choice);

struct SimulatorOptions {
  DeviceChoice device;
  Accuracy accuracy = Accuracy::standard;
  std::optional<AccuracyParts> accuracyParts;  ///< the parts one by one, instead of `accuracy`
  ReflectingFaces faces = ReflectingFaces::material;
  MaterialTable materials;  ///< reflectances by name, over what the scene says
  /// Folder where compiled pipelines are kept; empty: gnosphere in $XDG_CACHE_HOME or ~/.cache; "off": nowhere.
  std::string cache;
  /// Gets a sentence about what goes wrong without stopping anything: compiled pipelines that cannot be kept. It is
  /// called on the thread that calls the simulator. The library itself prints nothing.
  std::function<void(const std::string& message)> warn;
  bool validation = false;  ///< Vulkan validation layer on; its messages are thrown as Error(device)
  Tuning tuning;
};

/// A sensor, what its scans simulate and what they hold.
struct SensorRequest {
  Sensor sensor;
  Effects effects;  ///< by default whatever the scene and the sensor call for; Effects::none(): geometry alone
  /// What a scan holds beyond points, ranges and owners: the columns of Scan::column().
  std::vector<Field> fields;
  /// Shots bring their own weather: fog, rain, snow and volumes are in the plan, unless they are off, even if `effects`
  /// states none.
  bool variableWeather = false;

  SensorRequest() = default;
  SensorRequest(Sensor scanner, Effects simulated = {}, std::vector<Field> reported = {})
      : sensor(std::move(scanner)), effects(std::move(simulated)), fields(std::move(reported)) {}
};

/// Bytes on the device, by what they hold.
struct MemoryUse {
  uint64_t scene = 0;   ///< meshes, instances, and lists whose size follows theirs
  uint64_t sensor = 0;  ///< tables of the beams
  uint64_t work = 0;    ///< words, results and lists of the stages
};

/// How the sensor moves during a scan: poses at times after its start, interpolated (linear and slerp) and held before
/// the first and after the last.
struct SensorMotion {
  struct Stamp {
    double time = 0;  ///< seconds after the start of the scan, ascending
    Pose pose;
  };
  std::vector<Stamp> stamps;  ///< none: it stands still
};

/// Where an instance is when the scan ends, rotationPeriod after it starts from its own transform; corners move in
/// straight lines between.
struct InstanceMotion {
  size_t instance = 0;
  Transform end;
};

/// One scan of a run.
struct Shot {
  Pose pose;  ///< of the whole scan, or what points are reported from where the sensor moves and `deskew` is set
  size_t sensor = 0;
  uint64_t frame = 0;  ///< keys the random numbers
  SensorMotion motion;
  std::vector<InstanceMotion> instanceMotions;
  /// Instead of the fog, rain, snow and volumes of the sensor's Effects.
  std::optional<Weather> weather;
};

/// A scene and sensors on a device. Materials, meshes, instances and sensors come and go between scans; only what is
/// new is uploaded, and what is planned for a sensor follows the scene. Indices stay as they are: that of something
/// removed is given to the next one added.
///
/// A call that throws Error(invalidArgument) or Error(outOfMemory) leaves the simulator as it was. One thread at a time
/// may use a simulator; several simulators may be used by several threads at once.
class GNOSPHERE_API Simulator {
 public:
  /// Uploads the scene and compiles the stages. Throws Error(device) if no device fits, with the reason per device.
  Simulator(const Scene& scene, const std::vector<SensorRequest>& sensors, const SimulatorOptions& options = {});
  Simulator(const Scene& scene, const SensorRequest& sensor, const SimulatorOptions& options = {});
  ~Simulator();
  Simulator(Simulator&&) noexcept;
  Simulator& operator=(Simulator&&) noexcept;

  /// One scan of a sensor that stands at `pose`. Throws Error(invalidArgument) for a pose that is not finite,
  /// Error(device) or Error(outOfMemory) if the device fails.
  Scan scan(const Pose& pose, size_t sensor = 0);
  /// One scan of a shot, which says more than where the sensor stands, into a Scan whose arrays are used again: nothing
  /// is allocated once they have their size. Throws as scan() does, and Error(invalidArgument) for weather that the
  /// sensor's plan has no place for.
  void scanInto(const Shot& shot, Scan& result);
  /// Many scans, each the same as scan() gives, pipelined: while the host receives one, the device works on the next.
  /// `receive` gets the index into `shots` and the scan, in order and on this thread; the scan is overwritten after it
  /// returns, and wallMs includes the wait behind the scan before. Throws as scan() does, for a bad shot before the
  /// first scan; what `receive` throws ends the run. `receive` must not call this simulator.
  void scanAll(std::span<const Shot> shots, const std::function<void(size_t shot, const Scan& scan)>& receive);

  /// Each of the following counts from the next scan on, and throws Error(invalidArgument) that names an index that
  /// does not exist or was removed, or a value that does not fit.

  /// Returns its index.
  size_t addSensor(const SensorRequest& request);
  void removeSensor(size_t sensor);

  /// `image`: the alpha of its texture, for AlphaMode::mask; the material's own `alphaImage` is not looked at.
  size_t addMaterial(const Material& material, const AlphaImage* image = nullptr);
  /// No mesh may use it.
  void removeMaterial(size_t material);

  /// Its parts name materials by their index.
  size_t addMesh(const Mesh& mesh);
  /// No instance may place it.
  void removeMesh(size_t mesh);
  /// New places for the vertices of a mesh, as many as it has: metres, relative to its origin. The triangles stay.
  void setPositions(size_t mesh, std::span<const float> positions);

  /// Its index is that of Scan::instances, too.
  size_t addInstance(uint32_t mesh, const Transform& transform, uint16_t classId = 0);
  void removeInstance(size_t instance);
  void setTransform(size_t instance, const Transform& transform);

  /// What a scan of the sensor is made of, and why.
  Plan plan(size_t sensor = 0) const;
  const DeviceInfo& device() const;
  MemoryUse memory() const;
  size_t clusterCount() const;  ///< of all meshes; 0 on the reference

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace gnosphere

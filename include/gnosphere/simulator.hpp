// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
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

/// What a setting of the dial is made of. Turn one part at a time to see what it costs and what it saves.
struct Exactness {
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
GNOSPHERE_API Exactness exactnessOf(Accuracy accuracy);

/// Which faces of a triangle reflect.
enum class Faces {
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
  /// A sensor that scans again from the same pose keeps what the instances gave that have not moved since: 8 bytes per
  /// beam, from its second scan from there on. Neither with Binning::lists nor with the paper's bounds.
  bool still = true;
};

struct SimulatorOptions {
  /// auto, an index or part of a name of a Vulkan device of listDevices(), "reference", or, where CUDA is built in,
  /// "cuda:N": the CUDA device N with the shaders' arithmetic, or "cuda-fast:N" with what its compiler makes of it.
  std::string device = "auto";
  Accuracy accuracy = Accuracy::standard;
  std::optional<Exactness> exactness;  ///< the parts one by one, instead of `accuracy`
  Faces faces = Faces::material;
  Binning binning = Binning::automatic;
  Culling culling;
  bool validation = false;  ///< Vulkan validation layer on; its messages are thrown as Error(device)
  /// Cap on any one buffer of a Vulkan device, below what it allows; 0: what it allows. An array that needs more is
  /// Error(outOfMemory), from the constructor or from the scan that needs it; the simulator stays usable after it.
  uint64_t maxBufferBytes = 0;
  /// Folder where compiled pipelines are kept; empty: gnosphere in $XDG_CACHE_HOME or ~/.cache; "off": nowhere. Where
  /// it cannot be read or written they are compiled each time.
  std::string cache;
  /// What is simulated beside geometry: nothing, unless asked for. Effects{} is whatever the scene calls for.
  Effects effects = Effects::none();
  MaterialTable materials;  ///< reflectances by name, over what the scene says
  /// What a scan holds beyond points, ranges and owners. Of no effect: x y z range ring beam triangle instance tie
  /// tolerance time azimuth elevation return numbers and classId, which need nothing from the device.
  std::vector<Field> fields;
  bool float64 = true;  ///< off: as on a device without double precision; the answer is the same
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
  /// Of the card, the same by Vulkan and by CUDA; zeros where the driver tells none.
  std::array<uint8_t, 16> uuid = {};
};

/// Every Vulkan device of this machine, then every CUDA device where CUDA is built in, and the reference last. Never
/// throws for lack of Vulkan: the list then holds the reference alone, and `vulkanProblem` says why.
GNOSPHERE_API std::vector<DeviceInfo> listDevices(std::string* vulkanProblem = nullptr);

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
};

class Backend;

/// A scene and sensors on a device. Not thread-safe; use one per thread.
class GNOSPHERE_API Simulator {
 public:
  /// Uploads the scene and compiles the stages. Throws Error(device) if no device fits, with the reason per device.
  Simulator(const Scene& scene, const std::vector<Sensor>& sensors, const SimulatorOptions& options = {});
  Simulator(const Scene& scene, const Sensor& sensor, const SimulatorOptions& options = {});
  ~Simulator();
  Simulator(Simulator&&) noexcept;
  Simulator& operator=(Simulator&&) noexcept;

  /// One scan of one sensor from a pose. Throws Error(invalidArgument) for a pose that is not finite, Error(device) or
  /// Error(outOfMemory) if the device fails.
  Scan scan(const Pose& pose, size_t sensor = 0);
  /// The same into a Scan that is there: its arrays are used again, so nothing is allocated once they have their size.
  void scan(const Pose& pose, size_t sensor, Scan& result);
  /// The same of a shot, which says more than where the sensor stands.
  void scan(const Shot& shot, Scan& result);
  /// Many scans, each the same as scan() gives, pipelined: while the host receives one, the device works on the next.
  /// `receive` gets the index into `shots` and the scan, in order and on this thread; the scan is overwritten after it
  /// returns, and wallMs includes the wait behind the scan before. Throws as scan() does, for a bad shot before the
  /// first scan; what `receive` throws ends the run. `receive` must not call this simulator.
  void scanAll(std::span<const Shot> shots, const std::function<void(size_t shot, const Scan& scan)>& receive);

  /// Moving scenes: from the next scan on, and nothing is built anew. Each throws Error(invalidArgument) for an
  /// instance or mesh that does not exist, a transform that is not finite, or more triangles than a scene may place.
  void setTransform(size_t instance, const Transform& transform);
  /// The instance's index, in Scan::instances too: that of one removed before, or the next.
  size_t addInstance(uint32_t mesh, const Transform& transform, uint16_t classId = 0);
  void removeInstance(size_t instance);
  /// New places for the vertices of a mesh, as many as it has: metres, relative to its origin. The triangles stay.
  void setPositions(size_t mesh, std::span<const float> positions);

  /// What a scan of the sensor is made of.
  Plan plan(size_t sensor = 0) const;
  const DeviceInfo& device() const;
  MemoryUse memory() const;
  size_t clusterCount() const;  ///< of the flattened scene; 0 on the reference

 private:
  void run(std::span<const Shot> shots, Scan& result, const std::function<void(size_t)>& receive);

  void checkInstance(size_t instance) const;
  void setClass(size_t instance, uint16_t classId);

  struct MeshSize {
    size_t vertices, triangles;
  };
  std::vector<std::shared_ptr<const Sensor>> sensors_;
  std::shared_ptr<std::vector<uint16_t>> classes_;  // by instance; scans share it
  std::vector<MeshSize> meshes_;
  std::vector<uint32_t> instanceMeshes_;  // kNoMesh where it was removed
  std::vector<size_t> removed_;
  uint64_t placedTriangles_ = 0;
  std::unique_ptr<Backend> backend_;
};

}  // namespace gnosphere

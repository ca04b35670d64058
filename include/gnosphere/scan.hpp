// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <string>
#include <type_traits>
#include <vector>

#include "gnosphere/export.hpp"
#include "gnosphere/scene.hpp"
#include "gnosphere/sensor.hpp"

namespace gnosphere {

/// Position (metres) and orientation of the sensor in the world: maps the sensor frame to the world frame.
struct Pose {
  Vec3 position;
  Quaternion orientation;
};

/// The index of no triangle and of no instance.
inline constexpr uint32_t kNoTriangle = 0xffffffffu;

/// The fields that a scan or a cloud file may hold per return. A scan always has x, y, z, range, triangle and instance;
/// the device "reference" adds tie and tolerance. A scan has the other fields if SensorRequest::fields names them.
enum class Field {
  x,             ///< f32 m, sensor frame
  y,             ///< f32 m
  z,             ///< f32 m
  range,         ///< f32 m along the beam
  ring,          ///< u16, the beam's channel
  beam,          ///< u32, channel * columns + column
  triangle,      ///< u32, index within the instance's mesh, kNoTriangle for none
  instance,      ///< u32, index into Scene::instances, kNoTriangle for none
  tie,           ///< u8, 1 if a rounding error could change the owner or the hit of the beam, otherwise 0
  tolerance,     ///< f32 m, the range error that single precision may show on this beam
  intensity,     ///< f32, in the units of Effects::Intensity::scale
  trueRange,     ///< f32 m, range without noise of what returned: a surface, or with the label scatter a particle
  cause,         ///< u8, see Cause
  label,         ///< u8, see Label
  returnNumber,  ///< u8, 1 for the first return of its beam, 0 for an entry without a return
  returnCount,   ///< u8, number of returns of the beam
  width,         ///< f32 m, width of the echo: full width at half maximum (s) times c / 2
  normal,        ///< 3 f32 normal_x normal_y normal_z, unit vector in the sensor frame, pointing towards the sensor
  incidence,     ///< f32 rad, angle between the nominal beam and the normal; 0 for a surface square to the beam
  material,      ///< u32, index into Scene::materials
  barycentrics,  ///< 2 f32 u v, weights of the triangle's second and third corner; on a device NaN with a footprint,
                 ///< and for beams that meet a pane: their echoes are sums over several places
  classId,       ///< u16, the surface's Material::classId, else Instance::classId, when the scan was made; 0 for none
  velocity,      ///< 3 f32 velocity_x velocity_y velocity_z, m/s: the surface relative to the world, in sensor axes
  radialSpeed,   ///< f32 m/s along the beam, positive if the surface moves away from the sensor
  time,          ///< f32 s after the start of the scan
  azimuth,       ///< f32 rad, azimuth of the beam, counter-clockwise from the x axis
  elevation,     ///< f32 rad, elevation of the beam above the horizon
};
inline constexpr size_t kFieldCount = static_cast<size_t>(Field::elevation) + 1;

/// The type of a number in memory, in the byte order of the machine.
enum class ValueType : uint8_t { f32, f64, u8, u16, u32 };

/// Name, type and number of components of a field.
struct FieldInfo {
  const char* name;     ///< name used by parseFields() and on the command line
  ValueType type;       ///< type of the field's columns
  uint32_t components;  ///< 3 for a vector, 2 for barycentrics, otherwise 1
};

/// Returns name, type and number of components of a field.
GNOSPHERE_API FieldInfo fieldInfo(Field field);

/// Returns the ValueType of the C++ type of a column.
template <typename T>
constexpr ValueType valueTypeOf() {
  constexpr bool f32 = std::is_same_v<T, float>, u32 = std::is_same_v<T, uint32_t>, u16 = std::is_same_v<T, uint16_t>;
  static_assert(f32 || u32 || u16 || std::is_same_v<T, uint8_t>,
                "the values of a column are float, uint32_t, uint16_t or uint8_t");
  return f32 ? ValueType::f32 : u32 ? ValueType::u32 : u16 ? ValueType::u16 : ValueType::u8;
}

/// The values of one component of a field, one per entry of the scan. The view becomes invalid when the scan is
/// destroyed or when the next scan is written into it.
template <typename T>
class ColumnView {
 public:
  class Iterator {
   public:
    using value_type = T;
    using difference_type = std::ptrdiff_t;
    Iterator() = default;
    Iterator(const ColumnView& view, size_t index) : view_(view), index_(index) {}
    const T& operator*() const { return view_[index_]; }
    Iterator& operator++() {
      ++index_;
      return *this;
    }
    Iterator operator++(int) { return {view_, index_++}; }
    bool operator==(const Iterator& other) const { return index_ == other.index_; }

   private:
    ColumnView view_;
    size_t index_ = 0;
  };

  ColumnView() = default;
  ColumnView(const T* data, size_t size, size_t stride) : data_(data), size_(size), stride_(stride) {}
  const T* data() const { return data_; }
  size_t size() const { return size_; }
  size_t stride() const {
    return stride_;
  }  ///< values from one entry to the next: the number of components, which lie side by side
  bool empty() const { return size_ == 0; }
  const T& operator[](size_t entry) const { return data_[entry * stride_]; }
  Iterator begin() const { return {*this, 0}; }
  Iterator end() const { return {*this, size_}; }

 private:
  const T* data_ = nullptr;
  size_t size_ = 0, stride_ = 1;
};

/// Why a beam has a return or none. Every beam has exactly one cause, so the counts add up to the number of beams.
enum class Cause : uint8_t {
  returned,    ///< the beam has at least one return
  noSurface,   ///< there is no surface in range
  weak,        ///< all echoes are below the detection threshold
  attenuated,  ///< below the threshold, but without fog, rain, snow and dust an echo would have been above it
  droppedOut,  ///< the return was lost at random (Effects::DropOut)
  dead,        ///< the beam is one of Effects::DropOut::deadBeams or Sensor::maskedBeams
  tooNear,     ///< a surface nearer than the least range blocks the beam (NearHits::hide)
  notChosen,   ///< its echoes are detected, but Effects::Returns::mode names none that there is, such as a second one
};
inline constexpr size_t kCauseCount = 8;

/// The origin of a return.
enum class Label : uint8_t {
  none,     ///< no return
  solid,    ///< a surface
  scatter,  ///< particles of the medium: fog, rain, snow or dust
};

/// Counts of what happened to the scene's triangles and to the sensor's beams. Whatever is dropped is counted here.
/// Beams of a list that start far apart are projected from several places; the counts of triangles are then sums over
/// these places. The counts of culled and projected triangles depend on the scan before and, on CPU devices, on the
/// threads' timing; clouds do not. A triangle in motion may be projected several times, for parts of the scan.
struct Counters {
  uint64_t beams = 0;            ///< of the sensor
  uint64_t hits = 0;             ///< beams with at least one return
  uint64_t misses = 0;           ///< beams - hits
  uint64_t triangles = 0;        ///< triangles placed in the scene, summed over instances
  uint64_t nonFinite = 0;        ///< dropped because a vertex is NaN, infinite or beyond 1e9 m
  uint64_t degenerate = 0;       ///< dropped because two corners are the same point
  uint64_t culledByCluster = 0;  ///< in a cluster that is out of range, between the beams or hidden
  uint64_t reused = 0;         ///< not computed again: of instances that have not moved since a scan from the same pose
  uint64_t culledByRange = 0;  ///< the nearest point is beyond rangeMax
  uint64_t culledByFace = 0;   ///< back faces of one-sided materials
  uint64_t culledBetweenBeams = 0;  ///< no beam lies within the triangle's angular bounds
  uint64_t culledHidden = 0;        ///< behind the hits that all beams within the triangle's bounds already have
  uint64_t projected = 0;           ///< triangles that went on to binning
  uint64_t candidates = 0;          ///< (beam, triangle) pairs listed: with Binning::lists, footprints or panes
  uint64_t integerSides = 0;        ///< exact inside tests that needed integer arithmetic
  uint64_t integerRanges = 0;       ///< exact ranges that needed integer arithmetic
  uint64_t lostEchoes = 0;          ///< echoes of beams that met more echoes, or more panes in a row, than are kept
  uint64_t retries = 0;             ///< runs repeated because a list had to grow
  std::array<uint64_t, kCauseCount> causes = {};  ///< beams by Cause; all zero if no effect can lose a beam

  GNOSPHERE_API Counters& operator+=(const Counters& other);
};

/// The time of one stage of a scan.
struct StageTime {
  std::string name;  ///< "project", "bin", "resolve", "effects" or "records"
  double ms = 0;
};

/// Times that one scan took. `gpuMs` and `stages` come from device timestamps; without these, and on a CPU device
/// unless Tuning::stageTimes asks for them, they are zero and empty. The stage "resolve" runs on the host if only
/// geometry is planned; its time is not part of `gpuMs`.
struct Timings {
  /// From the submission until the results can be read on the host, without the time in which the library had kernels
  /// compiled. Drivers of CPUs still compile when a kernel first runs. The time that the receiver of scanAll() takes
  /// meanwhile does not count, except for the time in which the device works on the scan, by its timestamps.
  double wallMs = 0;
  double gpuMs = 0;
  std::vector<StageTime> stages;

  /// Adds time to a stage; the stage is appended if it is not there yet.
  GNOSPHERE_API void add(const std::string& stage, double ms);
};

/// The result of a scan. Every array and column has `returns` entries per beam: entry beam * returns + k is the beam's
/// k-th return in order of range (k from 0), where beam = channel * columns + column. In an entry without a return
/// `points` and `ranges` are NaN, and `triangles` and `instances` are kNoTriangle.
struct Scan {
  std::string sensor;
  uint32_t columns = 0;
  uint32_t channels = 0;
  uint32_t returns = 1;  ///< entries per beam
  Pose pose;
  /// True if the sensor moved during the scan, and points, normals and velocities are in the frames of their columns:
  /// they are not deskewed.
  bool skewed = false;
  /// False for a cloud of a file that does not state the sensor's pose, of which only PCD does: `pose` is the identity.
  bool poseKnown = true;
  /// False for a list of beams in one row, which may be those of any grid, and for a cloud of a file that states one
  /// row or no grid: `columns` and `channels` are those that its rows suggest.
  bool gridKnown = true;
  /// Whether the first row (channel 0) is on top, and the first column on the left, in an image of what the sensor
  /// sees. The directions of all beams decide, whatever they hit. For a cloud of a file, which does not state all its
  /// beams, the points decide.
  bool firstRowOnTop = false, firstColumnOnLeft = false;

  std::vector<float> points;        ///< x, y, z per entry, in metres in the sensor frame
  std::vector<float> ranges;        ///< metres along the beam
  std::vector<uint32_t> triangles;  ///< index within the instance's mesh
  std::vector<uint32_t> instances;  ///< index into Scene::instances

  Counters counters;
  Timings timings;

  /// Returns the values of one component of a field. T is the field's type: float, uint32_t, uint16_t or uint8_t, see
  /// FieldInfo::type. An entry without a value has NaN in floats other than velocities, kNoTriangle in indices, and 0
  /// in velocities and other integers. Throws Error(invalidArgument) if the scan does not have the field, if T is not
  /// the field's type, or if the field does not have the component.
  template <typename T>
  ColumnView<T> column(Field field, uint32_t component = 0) const {
    const RawColumn raw = find(field, component, valueTypeOf<T>());
    return {static_cast<const T*>(raw.data), ranges.size(), raw.stride};
  }
  /// Returns whether column() has the field, also if the scan has no entries. A scan may have more fields than were
  /// requested, and a new one has the fields that every scan has.
  GNOSPHERE_API bool has(Field field) const;

  size_t beamCount() const { return returns == 0 ? 0 : ranges.size() / returns; }
  /// Returns whether the entry is a return from a surface.
  bool hit(size_t entry) const { return triangles[entry] != kNoTriangle; }
  /// Returns whether the entry is a return, from a surface or from the medium: its range is not NaN, of which the bits
  /// tell, since a caller may be compiled with -ffast-math, for which there is no NaN.
  bool returned(size_t entry) const { return std::bit_cast<uint32_t>(ranges[entry]) << 1 <= 0xff000000; }

 private:
  friend class ScanColumns;
  struct RawColumn {
    const void* data;
    size_t stride;
  };
  GNOSPHERE_API RawColumn find(Field field, uint32_t component, ValueType type) const;

  // By field: the values of fields without a public array; empty if the scan does not have the field.
  std::array<std::vector<std::byte>, kFieldCount> columns_;
};

/// Returns the scan with its points, normals and velocities in the world frame, to which Scan::pose maps them; the pose
/// becomes the identity. Coordinates stay in single precision: 1 mm apart at 8 km from the world's origin. Throws
/// Error(invalidArgument) if the scan has no points, if it is skewed, which Effects::SensorMotion::deskew avoids, or if
/// its pose is not known.
GNOSPHERE_API Scan inWorld(Scan scan);

}  // namespace gnosphere

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <type_traits>
#include <vector>

#include "gnosphere/export.hpp"
#include "gnosphere/scene.hpp"
#include "gnosphere/sensor.hpp"

namespace gnosphere {

/// Where the sensor stands: sensor frame -> world.
struct Pose {
  Vec3 position;
  Quaternion orientation;
};

inline constexpr uint32_t kNoTriangle = 0xffffffffu;

/// What a scan or a cloud file holds per return. A scan always has x, y, z, range, triangle and instance; the device
/// "reference" adds tie and tolerance. A scan has the other fields where SimulatorOptions::fields names them.
enum class Field {
  x,             ///< f32 m, sensor frame
  y,             ///< f32 m
  z,             ///< f32 m
  range,         ///< f32 m along the beam
  ring,          ///< u16, the beam's channel
  beam,          ///< u32, channel * columns + column
  triangle,      ///< u32, index within the instance's mesh, kNoTriangle for none
  instance,      ///< u32, index into Scene::instances, kNoTriangle for none
  tie,           ///< u8, 1 where a rounding error could change the owner or the hit of the beam
  tolerance,     ///< f32 m, the range error that single precision may show on this beam
  intensity,     ///< f32, on the scale of Effects::Intensity
  trueRange,     ///< f32 m: where the surface is, whatever noise and medium made of it
  cause,         ///< u8, see Cause
  label,         ///< u8, see Label
  returnNumber,  ///< u8, 1 for the first of its beam, 0 where nothing came back
  returnCount,   ///< u8, how many came back of its beam
  width,         ///< f32 m: how deep the echo is, full width at half maximum times c / 2
  normal,        ///< 3 f32 normal_x normal_y normal_z: unit, sensor frame, towards the sensor
  incidence,     ///< f32 rad, 0 for square to the beam
  material,      ///< u32, index into Scene::materials
  barycentrics,  ///< 2 f32 u v: of the triangle's second and third corner
  classId,       ///< u16, the instance's class when the scan was made, 0 for none
  velocity,      ///< 3 f32 velocity_x velocity_y velocity_z: m/s of the surface in the world, in the sensor's axes
  radialSpeed,   ///< f32 m/s, positive going away from the sensor
  time,          ///< f32 s after the start of the scan
  azimuth,       ///< f32 rad of the beam, counter-clockwise from x
  elevation,     ///< f32 rad of the beam above the horizon
};
inline constexpr size_t kFieldCount = static_cast<size_t>(Field::elevation) + 1;

/// How a number lies in memory, in the byte order of the machine.
enum class ValueType : uint8_t { f32, f64, u8, u16, u32 };

struct FieldInfo {
  const char* name;     ///< as parseFields() and the command line know it
  ValueType type;       ///< of a column of the field
  uint32_t components;  ///< 3 for a vector, 2 for barycentrics, otherwise 1
};

FieldInfo fieldInfo(Field field);

/// The ValueType of a C++ type that a column may have.
template <typename T>
constexpr ValueType valueTypeOf() {
  constexpr bool f32 = std::is_same_v<T, float>, u32 = std::is_same_v<T, uint32_t>, u16 = std::is_same_v<T, uint16_t>;
  static_assert(f32 || u32 || u16 || std::is_same_v<T, uint8_t>,
                "the values of a column are float, uint32_t, uint16_t or uint8_t");
  return f32 ? ValueType::f32 : u32 ? ValueType::u32 : u16 ? ValueType::u16 : ValueType::u8;
}

/// The values of one component of a field, one per return. A view: it ends with the scan, and with the next scan into
/// it.
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
  size_t stride() const { return stride_; }  ///< from value to value, in values: the components lie side by side
  bool empty() const { return size_ == 0; }
  const T& operator[](size_t entry) const { return data_[entry * stride_]; }
  Iterator begin() const { return {*this, 0}; }
  Iterator end() const { return {*this, size_}; }

 private:
  const T* data_ = nullptr;
  size_t size_ = 0, stride_ = 1;
};

/// What became of a beam. Every beam has one, so the counts add up to the number of beams.
enum class Cause : uint8_t {
  returned,    ///< it has at least one return
  noSurface,   ///< nothing in range
  weak,        ///< below the detection threshold
  attenuated,  ///< above it, had there been no fog, rain, snow or dust
  droppedOut,  ///< lost at random
  dead,        ///< of Effects::DropOut::deadBeams
};
inline constexpr size_t kCauseCount = 6;

/// What a return comes from.
enum class Label : uint8_t {
  none,     ///< no return
  solid,    ///< a surface
  scatter,  ///< the medium
};

/// What happened to the scene's triangles and the sensor's beams. Nothing is dropped without a count here.
struct Counters {
  uint64_t beams = 0;
  uint64_t hits = 0;
  uint64_t misses = 0;              ///< beams - hits
  uint64_t triangles = 0;           ///< placed in the scene
  uint64_t nonFinite = 0;           ///< dropped: a vertex is NaN, infinite or beyond 1e9 m
  uint64_t degenerate = 0;          ///< dropped: two corners are the same point
  uint64_t culledByCluster = 0;     ///< in a cluster out of range or between the beams
  uint64_t reused = 0;              ///< of instances that have not moved since a scan from the same pose
  uint64_t culledByRange = 0;       ///< nearest point beyond rangeMax
  uint64_t culledByFace = 0;        ///< back faces of one-sided materials
  uint64_t culledBetweenBeams = 0;  ///< no beam within the triangle's angular bounds
  uint64_t culledHidden = 0;        ///< behind what all beams within its bounds have met
  uint64_t projected = 0;           ///< went on to binning
  uint64_t candidates = 0;          ///< (beam, triangle) pairs whose inside test passed, of lists
  uint64_t integerSides = 0;        ///< of `exact`: inside tests that floating point could not decide
  uint64_t integerRanges = 0;       ///< of `exact`: ranges that it could not round
  uint64_t lostEchoes = 0;  ///< of beams that met more echoes, or more panes one behind the other, than are kept
  uint64_t retries = 0;     ///< runs repeated because a list had to grow
  std::array<uint64_t, kCauseCount> causes = {};  ///< beams by Cause; all zero where no effect can lose a beam
};

struct StageTime {
  std::string name;  ///< project, bin, resolve, effects
  double ms = 0;
};

/// Times of one scan. `gpuMs` and `stages` are device timestamps, and empty where the device has none; but `resolve`
/// runs on the host where nothing but geometry is planned.
struct Timings {
  double wallMs = 0;  ///< submit to results readable on the host
  double gpuMs = 0;
  std::vector<StageTime> stages;

  /// More time of a stage.
  GNOSPHERE_API void add(const std::string& stage, double ms);
};

/// What came back, one entry per return in every array and column: entry beam * returns + k is the beam's k-th return
/// in order of range, where beam = channel * columns + column. Where nothing came back `points` and `ranges` are NaN,
/// and `triangles` and `instances` kNoTriangle.
struct Scan {
  std::string sensor;
  uint32_t columns = 0;
  uint32_t channels = 0;
  uint32_t returns = 1;  ///< entries per beam
  Pose pose;

  std::vector<float> points;        ///< x, y, z per entry: metres, sensor frame
  std::vector<float> ranges;        ///< metres along the beam
  std::vector<uint32_t> triangles;  ///< index within the instance's mesh
  std::vector<uint32_t> instances;  ///< index into Scene::instances

  Counters counters;
  Timings timings;

  /// The values of a field; T is float, uint32_t, uint16_t or uint8_t, as fieldInfo() says. Where an entry has no value
  /// they are NaN, kNoTriangle in indices, and 0 in velocities and other integers. Throws Error(invalidArgument) for a
  /// field that the scan does not have, for another type than the field's, and for a component that it does not have.
  template <typename T>
  ColumnView<T> column(Field field, uint32_t component = 0) const {
    const RawColumn raw = find(field, component, valueTypeOf<T>());
    return {static_cast<const T*>(raw.data), ranges.size(), raw.stride};
  }
  /// Whether column() gives the field. A scan may have fields beside those that were asked for.
  bool has(Field field) const;

  size_t beamCount() const { return ranges.size() / returns; }
  /// A surface came back.
  bool hit(size_t entry) const { return triangles[entry] != kNoTriangle; }
  /// Something came back: a surface or the medium.
  bool returned(size_t entry) const { return ranges[entry] == ranges[entry]; }

 private:
  friend class ScanColumns;
  struct RawColumn {
    const void* data;
    size_t stride;
  };
  RawColumn find(Field field, uint32_t component, ValueType type) const;

  // By field, the values of what has no public array; empty where the scan does not have the field.
  std::array<std::vector<std::byte>, kFieldCount> columns_;
};

}  // namespace gnosphere

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
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

/// What a scan or a cloud file holds per return. The first line is always there; tie and tolerance come from the
/// reference alone; of the others a scan computes and stores those that SimulatorOptions::fields names.
enum class Field {
  x,
  y,
  z,
  range,
  ring,
  beam,
  triangle,
  instance,
  tie,
  tolerance,
  intensity,     ///< f32, on the scale of Effects::Intensity
  trueRange,     ///< f32 m: where the surface is, whatever noise and medium made of it
  cause,         ///< u8, see Cause
  label,         ///< u8, see Label
  returnNumber,  ///< u8, 1 for the first of its beam
  returnCount,   ///< u8, of its beam
  width,         ///< f32 m: how deep the echo is, full width at half maximum times c / 2
  normal,        ///< 3 f32 normal_x normal_y normal_z: unit, sensor frame, towards the sensor
  incidence,     ///< f32 rad, 0 for square to the beam
  material,      ///< u32, index into Scene::materials
  barycentrics,  ///< 2 f32 u v: of the triangle's second and third corner
  classId,       ///< u16, of Instance::classId
  velocity,      ///< 3 f32 velocity_x velocity_y velocity_z: m/s of the surface in the world, in the sensor's axes
  radialSpeed,   ///< f32 m/s, positive going away from the sensor
  time,          ///< f32 s after the start of the scan
  azimuth,       ///< f32 rad of the beam, counter-clockwise from x
  elevation,     ///< f32 rad of the beam above the horizon
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

/// What came back, one entry per return in every array (beam = channel * columns + column). A miss is NaN in `points`
/// and `ranges` and kNoTriangle in `triangles` and `instances`.
struct Scan {
  std::string sensor;
  uint32_t columns = 0;
  uint32_t channels = 0;
  Pose pose;

  std::vector<float> points;        ///< x, y, z per beam: metres, sensor frame
  std::vector<float> ranges;        ///< metres along the beam
  std::vector<uint32_t> triangles;  ///< index within the instance's mesh
  std::vector<uint32_t> instances;  ///< index into Scene::instances

  /// Only from the reference: 1 where a rounding error could change the owner or hit/miss of the beam.
  std::vector<uint8_t> ties;
  /// Only from the reference: the range error that single precision may show on this beam, in metres.
  std::vector<float> tolerances;

  /// Returns per beam: entry beam * returns + k of every array is the beam's k-th, in order of range.
  uint32_t returns = 1;

  /// Only if their fields were asked for, one entry (or three: x, y, z; or two: u, v) per return; NaN or 0 for none.
  std::vector<float> intensities, trueRanges, widths, normals, incidences, barycentrics, velocities, radialSpeeds;
  std::vector<uint32_t> materials;  ///< index into Scene::materials, kNoTriangle for none
  std::vector<uint8_t> labels;      ///< Label
  std::vector<uint8_t> causes;      ///< Cause, per beam

  /// What directions, times and classes follow from when a cloud is written; null where the scan comes from a file.
  std::shared_ptr<const Sensor> model;
  std::shared_ptr<const std::vector<uint16_t>> classes;  ///< by instance; 0 beyond its end

  Counters counters;
  Timings timings;

  size_t beamCount() const { return ranges.size() / returns; }
  /// A surface came back.
  bool hit(size_t entry) const { return triangles[entry] != kNoTriangle; }
  /// Something came back: a surface or the medium.
  bool returned(size_t entry) const { return ranges[entry] == ranges[entry]; }
};

}  // namespace gnosphere

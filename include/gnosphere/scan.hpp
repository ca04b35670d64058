// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "gnosphere/scene.hpp"

namespace gnosphere {

/// Where the sensor stands: sensor frame -> world.
struct Pose {
  Vec3 position;
  Quaternion orientation;
};

inline constexpr uint32_t kNoTriangle = 0xffffffffu;

/// What happened to the scene's triangles and the sensor's beams. Nothing is dropped without a count here. A sensor
/// with more beams than one device buffer holds is scanned in parts, and each part goes through all triangles: their
/// counts are of all parts together.
struct Counters {
  uint64_t beams = 0;
  uint64_t hits = 0;
  uint64_t misses = 0;              ///< beams - hits
  uint64_t triangles = 0;           ///< placed in the scene, once per part
  uint64_t nonFinite = 0;           ///< dropped: a vertex is NaN, infinite or beyond 1e9 m
  uint64_t degenerate = 0;          ///< dropped: two corners are the same point
  uint64_t culledByCluster = 0;     ///< in a cluster out of range or between the beams
  uint64_t reused = 0;              ///< of instances that have not moved since a scan from the same pose
  uint64_t culledByRange = 0;       ///< nearest point beyond rangeMax
  uint64_t culledByFace = 0;        ///< back faces of one-sided materials
  uint64_t culledBetweenBeams = 0;  ///< no beam within the triangle's angular bounds
  uint64_t projected = 0;           ///< went on to binning
  uint64_t candidates = 0;          ///< (beam, triangle) pairs whose inside test passed; only counted by the list way
  uint64_t integerSides = 0;        ///< of `exact`: inside tests that floating point could not decide
  uint64_t integerRanges = 0;       ///< of `exact`: ranges that it could not round
  uint64_t retries = 0;             ///< runs repeated because a list had to grow
};

struct StageTime {
  std::string name;  ///< project, bin, resolve
  double ms = 0;
};

/// Times of one scan. `gpuMs` and `stages` are device timestamps; they are empty where the device has none.
struct Timings {
  double wallMs = 0;  ///< submit to results readable on the host
  double gpuMs = 0;
  std::vector<StageTime> stages;
};

/// What came back, one entry per beam in every array (beam = channel * columns + column). A miss is NaN in `points`
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

  Counters counters;
  Timings timings;

  size_t beamCount() const { return ranges.size(); }
  bool hit(size_t beam) const { return triangles[beam] != kNoTriangle; }
};

}  // namespace gnosphere

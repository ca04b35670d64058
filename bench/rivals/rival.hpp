// SPDX-License-Identifier: Apache-2.0
// The common interface of the rivals: a structure to build, update and trace.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "gnosphere/scan.hpp"
#include "gnosphere/scene.hpp"
#include "gnosphere/sensor.hpp"

namespace gnosphere::bench {

/// The new transform of an instance.
struct Moved {
  size_t instance = 0;
  Transform transform;
};

/// One entry per beam, as in Scan: a miss is NaN in `points` and `ranges`, kNoTriangle in `triangles` and `instances`.
struct Hits {
  std::vector<float> points;  ///< x, y, z in metres from the sensor, along any axes; every contender delivers a cloud
  std::vector<float> ranges;  ///< metres
  std::vector<uint32_t> triangles, instances;

  void resize(size_t beams) {
    points.resize(3 * beams);
    ranges.resize(beams);
    triangles.resize(beams);
    instances.resize(beams);
  }
};

/// A method to find the nearest hit of every beam: both faces of a triangle reflect, within the sensor's range. Times
/// are milliseconds of wall time of the whole call; `deviceMs` is measured by the device's own clock.
class Rival {
 public:
  virtual ~Rival() = default;
  virtual std::string name() const = 0;
  /// Builds the whole structure from scratch, from the scene given to the constructor.
  virtual double build() = 0;
  /// Updates the structure after instances have moved, in the way that its Motion selects. The time to move vertices
  /// that are stored in the scene's frame is not counted.
  virtual double update(std::span<const Moved> moved) = 0;
  /// Finds the nearest hit of every beam. Data that depends only on the beams (directions) is prepared before the clock
  /// starts.
  virtual double trace(const Sensor& sensor, const Pose& pose, Hits& hits) = 0;
  /// Device time of the last of these calls; 0 if there is none.
  virtual double deviceMs() const { return 0; }
  /// Memory of the structure and its inputs, on the device or on the host if that is the device; 0: not known.
  virtual uint64_t memoryBytes() const { return 0; }
};

/// The kind of motion for which a structure is made.
enum class Motion {
  none,        ///< none: fastest to trace, however long it takes to build
  transforms,  ///< instances move: the tree above the meshes is updated, meshes are kept
  everything,  ///< any vertex may move: fastest to build, from scratch each time
};

}  // namespace gnosphere::bench

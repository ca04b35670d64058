// SPDX-License-Identifier: Apache-2.0
// What every rival offers, so that the cases can treat them alike: a structure to build, to keep and to trace.
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

/// An instance at its new place.
struct Moved {
  size_t instance = 0;
  Transform transform;
};

/// One entry per beam, as in Scan: a miss is NaN in `points` and `ranges`, kNoTriangle in `triangles` and `instances`.
struct Hits {
  std::vector<float> points;  ///< x, y, z: metres from the sensor, in any axes; everybody delivers a cloud
  std::vector<float> ranges;  ///< metres
  std::vector<uint32_t> triangles, instances;

  void resize(size_t beams) {
    points.resize(3 * beams);
    ranges.resize(beams);
    triangles.resize(beams);
    instances.resize(beams);
  }
};

/// A way to answer what every beam meets: both faces of a triangle reflect, within the sensor's range. Times are
/// milliseconds of wall time, from the call to its end; `deviceMs` is the same on the device's own clock.
class Rival {
 public:
  virtual ~Rival() = default;
  virtual std::string name() const = 0;
  /// The whole structure from the scene, from scratch. The scene was given to the constructor.
  virtual double build() = 0;
  /// What has to be done after instances have moved, as the structure was made for it (Motion): moving the vertices
  /// themselves is not counted where they are held in the scene's frame.
  virtual double update(std::span<const Moved> moved) = 0;
  /// The nearest hit of every beam. What depends on the beams alone (directions) is prepared before the clock starts.
  virtual double trace(const Sensor& sensor, const Pose& pose, Hits& hits) = 0;
  /// Of the last of the calls above; 0 where the device has no clock or there is none.
  virtual double deviceMs() const { return 0; }
  /// Device memory, or the host's where that is the device, that the structure and its inputs occupy; 0: not known.
  virtual uint64_t memoryBytes() const { return 0; }
};

/// What a structure is made for.
enum class Motion {
  none,        ///< the fastest to trace, however long it takes to build
  transforms,  ///< instances move: what is above them is renewed, meshes are kept
  everything,  ///< any vertex may move: the fastest to build, from scratch each time
};

}  // namespace gnosphere::bench

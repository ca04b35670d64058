// SPDX-License-Identifier: Apache-2.0
// Which triangle each ray meets first: the rays as lists of beams of the simulator.
#pragma once

#include <functional>
#include <gnosphere/simulator.hpp>
#include <vector>

#include "rgl/math.hpp"

namespace gnosphere::rgl {

struct Ray {
  Vec origin, direction;
};

/// The hit of a ray; both are kNoTriangle if the ray meets nothing.
struct Hit {
  uint32_t instance = kNoTriangle, triangle = kNoTriangle;
};

/// The rays of one raytrace node. Rays stay in the simulator as long as they do not change: a pose that changes costs
/// nothing.
class Tracer {
 public:
  /// Data on which the beams in the simulator depend.
  struct Key {
    uint64_t rays = 0, offsets = 0, settings = 0;
    float range = 0;
    float scale = 0;  ///< of rays that are traced in the sensor's frame
    Mat transform;    ///< of rays that are not
    bool operator==(const Key&) const = default;
  };

  Tracer() = default;
  ~Tracer();
  Tracer(const Tracer&) = delete;
  Tracer& operator=(const Tracer&) = delete;

  /// Finds the hit of each ray. rays() gives them in the sensor's frame, and is called only if the key has changed;
  /// `range` is the greatest distance that matters.
  const std::vector<Hit>& trace(const Key& key, const Mat& transform, int32_t sensorId,
                                const std::function<std::vector<Ray>()>& rays);

 private:
  /// Rays with origins near each other, as a sensor of the simulator.
  struct Part {
    Vec centre;                    ///< in the sensor's frame
    std::vector<uint32_t> rays;    ///< indices
    std::vector<uint32_t> beamOf;  ///< by place in `rays`: equal rays in a row share a beam
    size_t sensor = 0;             ///< in the simulator
  };

  void build(Simulator& simulator, const Key& key, const std::vector<Ray>& rays);
  void addSensor(Simulator& simulator, Part& part, const std::vector<Ray>& rays, float range);
  void removeSensors();

  Key key_;
  bool built_ = false;
  size_t rayCount_ = 0;
  std::vector<Part> parts_;
  std::vector<Hit> hits_;
  Scan scan_;
};

}  // namespace gnosphere::rgl

// SPDX-License-Identifier: Apache-2.0
// The node that asks what the rays hit, and computes the fields of the points.
#pragma once

#include <limits>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "rgl/hit_surface.hpp"
#include "rgl/node.hpp"
#include "rgl/tracer.hpp"

namespace gnosphere::rgl {

/// Returns how many returns per ray a mode asks for.
inline int returnCount(rgl_return_mode_t mode) {
  return mode >> RGL_RETURN_MODE_BIT_SHIFT;
}

/// One sample of a beam: where it hits, or on which side of the range it hits nothing.
struct Sample {
  bool hit = false, near = false;
  double distance = 0;
  uint32_t index = 0;  ///< of the traced ray
  float intensity = 0;
};

class RaytraceNode : public PointsNode {
 public:
  static constexpr const char* kName = "RaytraceNode";
  const char* name() const override { return kName; }

  Vec linearVelocity, angularVelocity;
  bool distortion = false;
  float nearNonHit = std::numeric_limits<float>::infinity(), farNonHit = std::numeric_limits<float>::infinity();
  std::vector<int8_t> mask;
  float divergenceHorizontal = 0, divergenceVertical = 0;
  float defaultIntensity = 0, reflectivityAlpha = 0.1f;
  rgl_return_mode_t returnMode = RGL_RETURN_FIRST;
  int32_t sensorId = RGL_SENSOR_ID_DEFAULT;
  uint64_t settingsVersion = 0;  ///< another number when the traced rays are others for the same input

  void validate() override;
  void run() override;
  bool has(rgl_field_t field) const override { return fields_.contains(field); }
  /// The points of the last run with another return mode, for which a ReturnChooser behind this node asks.
  const Cloud& returnsOf(rgl_return_mode_t mode) const { return mode == returnMode ? cloud_ : chosen_.at(mode); }
  /// Takes parameters from a call without a node to create; there are none.
  void set() {}

 private:
  // One run, as the functions below need it.
  struct Run {
    const Rays& rays;
    std::vector<rgl_vec2f> samples;
    const std::vector<Hit>* hits = nullptr;
    Mat toSensor;
    std::optional<double> timeStep;
    float scale = 0;  ///< that the traced rays have from the pose; 0 if they are traced in the world
  };
  /// The columns that are wanted; null pointers for the others.
  struct Columns {
    Vec* xyz;
    float *intensity, *distance, *azimuth, *elevation, *radialSpeed, *incident, *retro, *reflectivity;
    uint8_t *intensity8, *type;
    int32_t *hit, *entity;
    uint32_t *ray, *time32;
    uint16_t* ring;
    double* time;
    Vec *velocity, *relative, *normal;
    Mat* pose;
    bool surfaces;  ///< whether a column needs more of the surface than its distance
  };

  float keptScale(const Mat& transform);
  float rangeOf(const Run& run) const;
  Mat motionAt(const Rays& rays, size_t ray) const;
  std::vector<Ray> tracedRays(const Run& run) const;
  Ray sensorRay(const Run& run, size_t ray, size_t sample) const;
  Columns makeColumns();
  Cloud cloudOf(const Run& run, rgl_return_mode_t mode);
  void computeRay(const Run& run, size_t ray, rgl_return_mode_t mode, const Columns& to,
                  std::vector<Sample>& samples) const;
  Sample judge(const Run& run, size_t ray, size_t sample, HitSurface& surface) const;
  HitSurface surfaceOf(const Hit& hit) const;
  float intensityOf(const HitSurface& surface, const Ray& world, double distance) const;
  void writePoint(const Run& run, size_t ray, size_t point, rgl_return_type_t type, const Sample& sample,
                  const Columns& to) const;
  void writeVelocities(const Run& run, size_t point, const HitSurface& surface, const Vec& at, const Columns& to) const;
  Ray worldRay(const Run& run, size_t ray, size_t sample) const;

  RaysNode* input_ = nullptr;
  std::set<rgl_field_t> fields_;
  Tracer tracer_;
  float scale_ = 1;                            ///< of the pose
  std::map<rgl_return_mode_t, Cloud> chosen_;  ///< beside those of returnMode
};

/// A node right behind a raytrace node that gives its points with a return mode of its own.
class ReturnChooser : public PointsFilter {
 public:
  /// `own` is the mode of the raytrace node.
  virtual rgl_return_mode_t mode(rgl_return_mode_t own) const = 0;
  void validate() override {
    PointsFilter::validate();
    raytrace_ = dynamic_cast<const RaytraceNode*>(input_);
    if (!raytrace_) throw Failure(RGL_INVALID_PIPELINE, std::string(name()) + ": its input must be a RaytraceNode");
  }
  void run() override { cloud_ = raytrace_->returnsOf(mode(raytrace_->returnMode)); }

 private:
  const RaytraceNode* raytrace_ = nullptr;
};

}  // namespace gnosphere::rgl

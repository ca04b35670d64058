// SPDX-License-Identifier: Apache-2.0
// Nodes that add noise to points.
#include "rgl/node.hpp"

namespace gnosphere::rgl {
namespace {

/// Changes each point in the frame of the sensor, and its distance, if there is one, with it.
class NoiseNode : public PointsFilter {
 public:
  Fields required() const override { return {RGL_FIELD_XYZ_VEC3_F32}; }

 protected:
  /// Moves a point of the sensor's frame; `distance` is its own, and becomes the new one.
  virtual Vec change(const Vec& point, float& distance, float normal) const = 0;

  void run() override {
    cloud_ = input_->cloud();
    const Mat toSensor = inverse(cloud_.sensor);
    const Vec* from = input_->cloud().values<Vec>(RGL_FIELD_XYZ_VEC3_F32);
    Vec* points = cloud_.write<Vec>(RGL_FIELD_XYZ_VEC3_F32);
    float* distances = cloud_.has(RGL_FIELD_DISTANCE_F32) ? cloud_.write<float>(RGL_FIELD_DISTANCE_F32) : nullptr;
    std::normal_distribution<float> normal;
    for (size_t i = 0; i < cloud_.count; ++i) {
      const Vec point = toSensor * from[i];
      float distance = length(point);
      points[i] = cloud_.sensor * change(point, distance, normal(random_));
      if (distances) distances[i] = distance;
    }
  }

 private:
  std::mt19937_64 random_ = randomSource();
};

class AngularHitpointNoiseNode : public NoiseNode {
 public:
  static constexpr const char* kName = "GaussianNoiseAngularHitpointNode";
  const char* name() const override { return kName; }
  void set(float mean, float deviation, rgl_axis_t axis) {
    mean_ = mean;
    deviation_ = deviation;
    axis_ = axis;
  }

 protected:
  Vec change(const Vec& point, float& distance, float normal) const override {
    const Vec turned = rotation(axis_, mean_ + normal * deviation_) * point;
    distance = length(turned);
    return turned;
  }

 private:
  float mean_ = 0, deviation_ = 0;
  rgl_axis_t axis_ = RGL_AXIS_X;
};

class DistanceNoiseNode : public NoiseNode {
 public:
  static constexpr const char* kName = "GaussianNoiseDistanceNode";
  const char* name() const override { return kName; }
  void set(float mean, float base, float rise) {
    mean_ = mean;
    base_ = base;
    rise_ = rise;
  }
  Fields required() const override { return {RGL_FIELD_XYZ_VEC3_F32, RGL_FIELD_DISTANCE_F32}; }

 protected:
  Vec change(const Vec& point, float& distance, float normal) const override {
    const float error = mean_ + normal * (distance * rise_ + base_);
    const Vec moved = point + unit(point) * error;
    distance += error;
    return moved;
  }

 private:
  float mean_ = 0, base_ = 0, rise_ = 0;
};

}  // namespace
}  // namespace gnosphere::rgl

using namespace gnosphere::rgl;

RGL_API rgl_status_t rgl_node_gaussian_noise_angular_hitpoint(rgl_node_t* node, float mean, float st_dev,
                                                              rgl_axis_t rotation_axis) {
  return call(__func__, taped(out(node), mean, st_dev, rotation_axis), [&] {
    RGL_CHECK(node != nullptr);
    RGL_CHECK(st_dev >= 0);
    RGL_CHECK((rotation_axis == RGL_AXIS_X) || (rotation_axis == RGL_AXIS_Y) || (rotation_axis == RGL_AXIS_Z));
    createOrUpdate<AngularHitpointNoiseNode>(node, Affects::node,
                                             [&](auto& made) { made.set(mean, st_dev, rotation_axis); });
  });
}

RGL_API rgl_status_t rgl_node_gaussian_noise_distance(rgl_node_t* node, float mean, float st_dev_base,
                                                      float st_dev_rise_per_meter) {
  return call(__func__, taped(out(node), mean, st_dev_base, st_dev_rise_per_meter), [&] {
    RGL_CHECK(node != nullptr);
    RGL_CHECK(st_dev_base >= 0);
    RGL_CHECK(st_dev_rise_per_meter >= 0);
    createOrUpdate<DistanceNoiseNode>(node, Affects::node,
                                      [&](auto& made) { made.set(mean, st_dev_base, st_dev_rise_per_meter); });
  });
}

// SPDX-License-Identifier: Apache-2.0
// Nodes that make and change rays.
#include <algorithm>
#include <cmath>

#include "rgl/node.hpp"

namespace gnosphere::rgl {
namespace {

using Matrices = std::vector<Mat>;

[[noreturn]] void refuseCount(const RaysNode& node, const char* what, size_t count) {
  throw Failure(RGL_INVALID_PIPELINE, std::string(node.name()) + ": number of " + what +
                                          " doesn't match number of rays (" + std::to_string(count) + " and " +
                                          std::to_string(node.rayCount()) + ")");
}

class FromMatricesNode : public RaysNode {
 public:
  static constexpr const char* kName = "FromMat3x4fRaysNode";
  const char* name() const override { return kName; }
  void set(const rgl_mat3x4f* rays, int32_t count) {
    auto matrices = std::make_shared<Matrices>(count);
    std::transform(rays, rays + count, matrices->begin(), matOf);
    const uint64_t version = rays_.base && *rays_.base == *matrices ? rays_.baseVersion : nextVersion();
    rays_ = {};
    rays_.base = rays_.world = matrices;
    rays_.baseVersion = version;
  }
  void validate() override {}
  void run() override {}
  size_t rayCount() const override { return rays_.count(); }
};

class RingsNode : public RaysFilter {
 public:
  static constexpr const char* kName = "SetRingIdsRaysNode";
  const char* name() const override { return kName; }
  void set(const int32_t* ids, int32_t count) { rings_ = std::make_shared<std::vector<int32_t>>(ids, ids + count); }
  void validate() override {
    RaysFilter::validate();
    if (rayCount() % rings_->size() != 0) refuseCount(*this, "ring ids", rings_->size());
  }
  void run() override {
    rays_ = input_->rays();
    rays_.rings = rings_;
  }

 private:
  std::shared_ptr<const std::vector<int32_t>> rings_;
};

class RangeNode : public RaysFilter {
 public:
  static constexpr const char* kName = "SetRangeRaysNode";
  const char* name() const override { return kName; }
  void set(const rgl_vec2f* ranges, int32_t count) {
    ranges_ = std::make_shared<std::vector<rgl_vec2f>>(ranges, ranges + count);
  }
  void validate() override {
    RaysFilter::validate();
    if (ranges_->size() != 1 && ranges_->size() != rayCount()) refuseCount(*this, "ranges", ranges_->size());
  }
  void run() override {
    rays_ = input_->rays();
    rays_.ranges = ranges_;
  }

 private:
  std::shared_ptr<const std::vector<rgl_vec2f>> ranges_;
};

class OffsetsNode : public RaysFilter {
 public:
  static constexpr const char* kName = "SetTimeOffsetsRaysNode";
  const char* name() const override { return kName; }
  void set(const float* offsets, int32_t count) {
    auto given = std::make_shared<std::vector<float>>(offsets, offsets + count);
    if (!offsets_ || *offsets_ != *given) version_ = nextVersion();
    offsets_ = std::move(given);
  }
  void validate() override {
    RaysFilter::validate();
    if (offsets_->size() != rayCount()) refuseCount(*this, "time offsets", offsets_->size());
  }
  void run() override {
    rays_ = input_->rays();
    rays_.offsets = offsets_;
    rays_.offsetsVersion = version_;
  }

 private:
  std::shared_ptr<const std::vector<float>> offsets_;
  uint64_t version_ = 0;
};

class TransformRaysNode : public RaysFilter {
 public:
  static constexpr const char* kName = "TransformRaysNode";
  const char* name() const override { return kName; }
  void set(const Mat& transform) { transform_ = transform; }
  void run() override {
    rays_ = input_->rays();
    auto world = std::make_shared<Matrices>(rays_.count());
    std::transform(rays_.world->begin(), rays_.world->end(), world->begin(),
                   [&](const Mat& ray) { return transform_ * ray; });
    rays_.world = world;
    rays_.transform = transform_ * rays_.transform;
  }

 private:
  Mat transform_;
};

/// Turns each ray about an axis of the sensor.
class AngularRayNoiseNode : public RaysFilter {
 public:
  static constexpr const char* kName = "GaussianNoiseAngularRaysNode";
  const char* name() const override { return kName; }
  void set(float mean, float deviation, rgl_axis_t axis) {
    mean_ = mean;
    deviation_ = deviation;
    axis_ = axis;
  }
  void run() override {
    const std::shared_ptr<const Matrices> former = rays_.base;
    rays_ = input_->rays();
    auto base = std::make_shared<Matrices>(rays_.count());
    auto world = std::make_shared<Matrices>(rays_.count());
    std::normal_distribution<float> normal;
    for (size_t i = 0; i < rays_.count(); ++i) {
      (*base)[i] = rotation(axis_, mean_ + normal(random_) * deviation_) * (*rays_.base)[i];
      (*world)[i] = rays_.transform * (*base)[i];
    }
    if (!former || *former != *base) version_ = nextVersion();
    rays_.base = base;
    rays_.world = world;
    rays_.baseVersion = version_;
  }

 private:
  float mean_ = 0, deviation_ = 0;
  rgl_axis_t axis_ = RGL_AXIS_X;
  uint64_t version_ = 0;
  std::mt19937_64 random_ = randomSource();
};

}  // namespace
}  // namespace gnosphere::rgl

using namespace gnosphere::rgl;

RGL_API rgl_status_t rgl_node_rays_from_mat3x4f(rgl_node_t* node, const rgl_mat3x4f* rays, int32_t ray_count) {
  return call(__func__, taped(out(node), arrayOf(rays, ray_count), ray_count), [&] {
    RGL_CHECK(node != nullptr);
    RGL_CHECK(rays != nullptr);
    RGL_CHECK(ray_count > 0);
    createOrUpdate<FromMatricesNode>(node, Affects::graph, [&](auto& made) { made.set(rays, ray_count); });
  });
}

RGL_API rgl_status_t rgl_node_rays_set_ring_ids(rgl_node_t* node, const int32_t* ring_ids, int32_t ring_ids_count) {
  return call(__func__, taped(out(node), arrayOf(ring_ids, ring_ids_count), ring_ids_count), [&] {
    RGL_CHECK(node != nullptr);
    RGL_CHECK(ring_ids != nullptr);
    RGL_CHECK(ring_ids_count > 0);
    createOrUpdate<RingsNode>(node, Affects::node, [&](auto& made) { made.set(ring_ids, ring_ids_count); });
  });
}

RGL_API rgl_status_t rgl_node_rays_set_range(rgl_node_t* node, const rgl_vec2f* ranges, int32_t ranges_count) {
  return call(__func__, taped(out(node), arrayOf(ranges, ranges_count), ranges_count), [&] {
    RGL_CHECK(node != nullptr);
    RGL_CHECK(ranges != nullptr);
    RGL_CHECK(ranges_count > 0);
    for (int32_t i = 0; i < ranges_count; ++i) {
      RGL_CHECK(!std::isnan(ranges[i].value[0]) && !std::isnan(ranges[i].value[1]));
      RGL_CHECK(ranges[i].value[0] >= 0.0f);
      RGL_CHECK(ranges[i].value[1] >= ranges[i].value[0]);
    }
    createOrUpdate<RangeNode>(node, Affects::node, [&](auto& made) { made.set(ranges, ranges_count); });
  });
}

RGL_API rgl_status_t rgl_node_rays_set_time_offsets(rgl_node_t* node, const float* offsets, int32_t offsets_count) {
  return call(__func__, taped(out(node), arrayOf(offsets, offsets_count), offsets_count), [&] {
    RGL_CHECK(node != nullptr);
    RGL_CHECK(offsets != nullptr);
    RGL_CHECK(offsets_count > 0);
    createOrUpdate<OffsetsNode>(node, Affects::node, [&](auto& made) { made.set(offsets, offsets_count); });
  });
}

RGL_API rgl_status_t rgl_node_rays_transform(rgl_node_t* node, const rgl_mat3x4f* transform) {
  return call(__func__, taped(out(node), arrayOf(transform, 1)), [&] {
    RGL_CHECK(node != nullptr);
    RGL_CHECK(transform != nullptr);
    RGL_CHECK(isFinite(*transform));
    createOrUpdate<TransformRaysNode>(node, Affects::node, [&](auto& made) { made.set(matOf(*transform)); });
  });
}

RGL_API rgl_status_t rgl_node_gaussian_noise_angular_ray(rgl_node_t* node, float mean, float st_dev,
                                                         rgl_axis_t rotation_axis) {
  return call(__func__, taped(out(node), mean, st_dev, rotation_axis), [&] {
    RGL_CHECK(node != nullptr);
    RGL_CHECK(st_dev >= 0);
    RGL_CHECK((rotation_axis == RGL_AXIS_X) || (rotation_axis == RGL_AXIS_Y) || (rotation_axis == RGL_AXIS_Z));
    createOrUpdate<AngularRayNoiseNode>(node, Affects::node,
                                        [&](auto& made) { made.set(mean, st_dev, rotation_axis); });
  });
}

// SPDX-License-Identifier: Apache-2.0
// Traces the rays of a node: rays of samples, their hits, and the sample that each return stands for.
#include "rgl/raytrace_node.hpp"

#include <algorithm>

#include "base/threads.hpp"
#include "rgl/scene.hpp"

namespace gnosphere::rgl {
namespace {

/// Offsets of the rays that sample a beam, as shares of its half angles: the centre, and three ellipses.
std::vector<rgl_vec2f> beamSamples(bool spread) {
  std::vector<rgl_vec2f> samples = {{{0, 0}}};
  constexpr int kLayers = 3, kVertices = 19;
  for (int layer = 0; spread && layer < kLayers; ++layer)
    for (int k = 0; k < kVertices; ++k) {
      const float share = 1 - static_cast<float>(layer) / kLayers;
      const float angle = 2 * static_cast<float>(M_PI) * static_cast<float>(k) / kVertices;
      samples.push_back({{share * std::cos(angle), share * std::sin(angle)}});
    }
  return samples;
}

rgl_return_type_t returnType(rgl_return_mode_t mode, int k) {
  return static_cast<rgl_return_type_t>((mode >> (k * RGL_RETURN_TYPE_BIT_SHIFT)) & 0xff);
}

/// The samples of a beam that RGL's return types stand for. A later sample becomes the second one only when it beats
/// the first, as there.
struct Picked {
  const Sample *first = nullptr, *second = nullptr, *last = nullptr, *strongest = nullptr, *secondStrongest = nullptr;

  void add(const Sample& sample) {
    if (!first) {
      first = second = last = strongest = secondStrongest = &sample;
      return;
    }
    if (sample.distance < first->distance) second = first, first = &sample;
    if (sample.distance > last->distance) last = &sample;
    if (sample.intensity > strongest->intensity) secondStrongest = strongest, strongest = &sample;
  }
  const Sample* of(rgl_return_type_t type) const {
    switch (type) {
      case RGL_RETURN_TYPE_SECOND: return second;
      case RGL_RETURN_TYPE_LAST: return last;
      case RGL_RETURN_TYPE_STRONGEST: return strongest;
      case RGL_RETURN_TYPE_SECOND_STRONGEST: return secondStrongest;
      default: return first;
    }
  }
};

// The fields that the nodes behind a node require.
void collectRequired(GraphNode& node, std::set<rgl_field_t>& fields) {
  for (const GraphNode* each : reached(node, {&GraphNode::outputs})) {
    const auto* points = each == &node ? nullptr : dynamic_cast<const PointsNode*>(each);
    if (!points) continue;
    for (const rgl_field_t field : points->required())
      if (!isPadding(field)) fields.insert(field);
  }
}

}  // namespace

void RaytraceNode::validate() {
  input_ = &raysInput(*this);
  fields_ = {RGL_FIELD_XYZ_VEC3_F32};
  collectRequired(*this, fields_);
  const auto refuse = [](const std::string& why) {
    throw Failure(RGL_INVALID_PIPELINE, std::string(kName) + ": " + why);
  };
  if (fields_.contains(RGL_FIELD_TIME_STAMP_F64) && !scene().time)
    refuse("TIME_STAMP_F64 needs the scene's time; set it with rgl_scene_set_time");
  if (!mask.empty() && mask.size() != input_->rayCount())
    refuse("the mask has " + std::to_string(mask.size()) + " entries for " + std::to_string(input_->rayCount()) +
           " rays");
  if (fields_.contains(RGL_FIELD_RAY_POSE_MAT3x4_F32) && returnCount(returnMode) > 1)
    refuse("RAY_POSE_MAT3x4_F32 is there for one return per ray only");
}

Mat RaytraceNode::motionAt(const Rays& rays, size_t ray) const {
  const float seconds = (*rays.offsets)[ray] * 1e-3f;
  Mat motion = rotation(angularVelocity * seconds);
  const Vec way = linearVelocity * seconds;
  motion.m[0][3] = way.x, motion.m[1][3] = way.y, motion.m[2][3] = way.z;
  return motion;
}

// A ray of the input, moved and turned as the sample is, in the frame of the sensor.
Ray RaytraceNode::sensorRay(const Run& run, size_t ray, size_t sample) const {
  Mat matrix = (*run.rays.base)[ray];
  if (distortion) matrix = motionAt(run.rays, ray) * matrix;
  if (sample > 0) {
    const auto [h, v] = run.samples[sample].value;
    matrix = matrix * (rotation({v * divergenceVertical / 2, 0, 0}) * rotation({0, h * divergenceHorizontal / 2, 0}));
  }
  return {matrix.translation(), {matrix.m[0][2], matrix.m[1][2], matrix.m[2][2]}};
}

Ray RaytraceNode::worldRay(const Run& run, size_t ray, size_t sample) const {
  if (sample == 0 && !distortion) {
    const Mat& matrix = (*run.rays.world)[ray];
    return {matrix.translation(), {matrix.m[0][2], matrix.m[1][2], matrix.m[2][2]}};
  }
  const Ray local = sensorRay(run, ray, sample);
  return {run.rays.transform * local.origin, run.rays.transform.turn(local.direction)};
}

std::vector<Ray> RaytraceNode::tracedRays(const Run& run) const {
  std::vector<Ray> result(run.rays.count() * run.samples.size());
  for (size_t i = 0; i < result.size(); ++i) {
    const size_t ray = i / run.samples.size(), sample = i % run.samples.size();
    result[i] = run.scale == 0 ? worldRay(run, ray, sample) : sensorRay(run, ray, sample);
    if (run.scale != 0) result[i].origin = result[i].origin * run.scale;
  }
  return result;
}

// The scale of the rays that are traced in the sensor's frame; 0 if the pose is no rotation with a scale. The last
// scale is kept while that of the pose differs only by rounding, which changes with each rotation.
float RaytraceNode::keptScale(const Mat& transform) {
  constexpr double kRounding = 1e-6;
  const double scale = scaleOf(transform);
  if (std::abs(scale - 1) <= kRounding)
    scale_ = 1;
  else if (!(std::abs(scale - scale_) <= kRounding * scale))
    scale_ = static_cast<float>(scale);
  return scale_;
}

// The greatest distance in the world at which a ray may hit. Rays that are traced in the sensor's frame are measured
// there, because their lengths in the world differ with each rotation by rounding.
float RaytraceNode::rangeOf(const Run& run) const {
  constexpr float kNoLimit = std::numeric_limits<float>::max();
  const Rays& rays = run.rays;
  if (!rays.ranges) return kNoLimit;
  const std::vector<Mat>& matrices = run.scale == 0 ? *rays.world : *rays.base;
  float range = 0;
  for (size_t i = 0; i < rays.count(); ++i) {
    const float length = rgl::length({matrices[i].m[0][2], matrices[i].m[1][2], matrices[i].m[2][2]});
    range = std::max(range, (*rays.ranges)[rays.ranges->size() == 1 ? 0 : i].value[1] * length);
  }
  if (run.scale != 0) range *= run.scale;
  return std::isfinite(range) ? range * 1.001f + 1e-3f : kNoLimit;
}

void RaytraceNode::run() {
  const Rays& rays = input_->rays();
  if (distortion && !rays.offsets)
    throw Failure(RGL_INVALID_PIPELINE, std::string(kName) + ": velocity distortion requires time offsets of the rays");
  Run run{rays,
          beamSamples(divergenceHorizontal > 0),
          nullptr,
          inverse(rays.transform),
          scene().timeStep(),
          keptScale(rays.transform)};
  const bool inWorld = run.scale == 0;
  const Tracer::Key key{rays.baseVersion, distortion ? rays.offsetsVersion : 0, settingsVersion, rangeOf(run),
                        run.scale,        inWorld ? rays.transform : Mat()};
  const Mat pose = inWorld ? Mat() : withoutScale(rays.transform, run.scale);
  run.hits = &tracer_.trace(key, pose, sensorId, [&] { return tracedRays(run); });

  chosen_.clear();
  for (const GraphNode* output : outputs)
    if (const auto* chooser = dynamic_cast<const ReturnChooser*>(output))
      if (const rgl_return_mode_t mode = chooser->mode(returnMode); mode != returnMode && !chosen_.contains(mode))
        chosen_[mode] = cloudOf(run, mode);
  cloud_ = cloudOf(run, returnMode);
}

Cloud RaytraceNode::cloudOf(const Run& run, rgl_return_mode_t mode) {
  cloud_ = {};
  cloud_.count = run.rays.count() * returnCount(mode);
  cloud_.sensor = run.rays.transform;
  const Columns to = makeColumns();
  inRuns(run.rays.count(), 4096, threadCount(), [&](uint64_t first, uint64_t end) {
    std::vector<Sample> samples(run.samples.size());
    for (uint64_t ray = first; ray < end; ++ray) computeRay(run, ray, mode, to, samples);
  });
  return cloud_;
}

HitSurface RaytraceNode::surfaceOf(const Hit& hit) const {
  HitSurface surface{&scene().entityOf(hit.instance), hit.triangle, {}};
  const std::vector<Vec>& shape = surface.entity->shape();
  for (int k = 0; k < 3; ++k)
    surface.corners[k] = surface.entity->transform.now * shape[surface.entity->mesh->triangles[hit.triangle][k]];
  return surface;
}

// The distance is that of the actual ray to the plane of the triangle, in double.
Sample RaytraceNode::judge(const Run& run, size_t ray, size_t sample, HitSurface& surface) const {
  const auto index = static_cast<uint32_t>(ray * run.samples.size() + sample);
  Sample result;
  result.index = index;
  if (run.hits->empty() || (!mask.empty() && mask[ray] == 0)) return result;
  const Hit& hit = (*run.hits)[index];
  if (hit.triangle == kNoTriangle) return result;
  surface = surfaceOf(hit);
  const Ray world = worldRay(run, ray, sample);
  const Vec3 n = surface.areaNormal();
  const Vec& a = surface.corners[0];
  const double along = n.x * world.direction.x + n.y * world.direction.y + n.z * world.direction.z;
  const double away = n.x * (double{a.x} - world.origin.x) + n.y * (double{a.y} - world.origin.y) +
                      n.z * (double{a.z} - world.origin.z);
  if (!(std::abs(along) > 0)) return result;  // seen edge-on, or a triangle without a plane
  const double t = std::max(0.0, away / along);
  const double norm =
      std::sqrt(double{world.direction.x} * world.direction.x + double{world.direction.y} * world.direction.y +
                double{world.direction.z} * world.direction.z);
  float least = 0, most = std::numeric_limits<float>::max();
  if (run.rays.ranges) {
    const rgl_vec2f& range = (*run.rays.ranges)[run.rays.ranges->size() == 1 ? 0 : ray];
    least = range.value[0], most = range.value[1];
  }
  result.near = t < least;
  result.hit = !result.near && t <= most;
  result.distance = t * norm;
  return result;
}

void RaytraceNode::computeRay(const Run& run, size_t ray, rgl_return_mode_t mode, const Columns& to,
                              std::vector<Sample>& samples) const {
  const bool byStrength = samples.size() > 1;
  Picked picked;
  for (size_t k = 0; k < samples.size(); ++k) {
    HitSurface surface;
    samples[k] = judge(run, ray, k, surface);
    if (!samples[k].hit) continue;
    if (byStrength) samples[k].intensity = intensityOf(surface, worldRay(run, ray, k), samples[k].distance);
    picked.add(samples[k]);
  }
  const int returns = returnCount(mode);
  for (int k = 0; k < returns; ++k) {
    const rgl_return_type_t type = returnType(mode, k);
    writePoint(run, ray, ray * returns + k, type, picked.first ? *picked.of(type) : samples[0], to);
  }
}

}  // namespace gnosphere::rgl

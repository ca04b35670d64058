// SPDX-License-Identifier: Apache-2.0
// The node that asks what the rays hit, and computes the fields of the points.
#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <set>

#include "base/threads.hpp"
#include "rgl/node.hpp"
#include "rgl/scene.hpp"
#include "rgl/tracer.hpp"

namespace gnosphere::rgl {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

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

int returnCount(rgl_return_mode_t mode) {
  return mode >> RGL_RETURN_MODE_BIT_SHIFT;
}
rgl_return_type_t returnType(rgl_return_mode_t mode, int k) {
  return static_cast<rgl_return_type_t>((mode >> (k * RGL_RETURN_TYPE_BIT_SHIFT)) & 0xff);
}

/// One sample of a beam: where it hits, or on which side of the range it hits nothing.
struct Sample {
  bool hit = false, near = false;
  double distance = 0;
  uint32_t index = 0;  ///< of the traced ray
  float intensity = 0;
};

/// A triangle that was hit, in the world.
struct Surface {
  const EntityObject* entity = nullptr;
  uint32_t triangle = 0;
  Vec corners[3];

  /// Normal to the triangle by the right-hand rule, as long as twice its area; in double, for distances and angles.
  Vec3 areaNormal() const {
    const auto& [a, b, c] = corners;
    const Vec3 u{double{b.x} - a.x, double{b.y} - a.y, double{b.z} - a.z};
    const Vec3 v{double{c.x} - a.x, double{c.y} - a.y, double{c.z} - a.z};
    return {u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x};
  }
  Vec3 normal() const {
    const Vec3 n = areaNormal();
    const double norm = std::sqrt(n.x * n.x + n.y * n.y + n.z * n.z);
    return {n.x / norm, n.y / norm, n.z / norm};
  }
  /// Cosine of the angle between the normal and a direction, never negative.
  double incidence(const Vec& direction) const {
    const Vec3 n = normal();
    return std::abs(n.x * direction.x + n.y * direction.y + n.z * direction.z);
  }
};

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

  Mat motionAt(const Rays& rays, size_t ray) const;
  std::vector<Ray> tracedRays(const Run& run) const;
  Ray sensorRay(const Run& run, size_t ray, size_t sample) const;
  Columns makeColumns();
  void computeRay(const Run& run, size_t ray, const Columns& to, std::vector<Sample>& samples) const;
  Sample judge(const Run& run, size_t ray, size_t sample, Surface& surface) const;
  Surface surfaceOf(const Hit& hit) const;
  float intensityOf(const Surface& surface, const Ray& world, double distance) const;
  void writePoint(const Run& run, size_t ray, size_t point, rgl_return_type_t type, const Sample& sample,
                  const Columns& to) const;
  void writeVelocities(const Run& run, size_t point, const Surface& surface, const Vec& at, const Columns& to) const;
  Ray worldRay(const Run& run, size_t ray, size_t sample) const;

  RaysNode* input_ = nullptr;
  std::set<rgl_field_t> fields_;
  Tracer tracer_;
};

void collectRequired(const GraphNode& node, std::set<rgl_field_t>& fields) {
  for (const GraphNode* output : node.outputs) {
    if (const auto* points = dynamic_cast<const PointsNode*>(output))
      for (const rgl_field_t field : points->required())
        if (!isPadding(field)) fields.insert(field);
    collectRequired(*output, fields);
  }
}

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
  const bool inWorld = !isRigid(run.rays.transform);
  std::vector<Ray> result(run.rays.count() * run.samples.size());
  for (size_t i = 0; i < result.size(); ++i) {
    const size_t ray = i / run.samples.size(), sample = i % run.samples.size();
    result[i] = inWorld ? worldRay(run, ray, sample) : sensorRay(run, ray, sample);
  }
  return result;
}

RaytraceNode::Columns RaytraceNode::makeColumns() {
  for (const rgl_field_t field :  // those of other nodes are there, too, and zero
       {RGL_FIELD_IS_GROUND_I32, RGL_FIELD_POWER_F32, RGL_FIELD_RCS_F32, RGL_FIELD_NOISE_F32, RGL_FIELD_SNR_F32})
    if (fields_.contains(field)) cloud_.write<float>(field);
  const auto column = [&](auto*& to, rgl_field_t field) {
    using T = std::remove_reference_t<decltype(*to)>;
    to = fields_.contains(field) ? cloud_.write<T>(field) : nullptr;
  };
  Columns to{};
  column(to.xyz, RGL_FIELD_XYZ_VEC3_F32);
  column(to.intensity, RGL_FIELD_INTENSITY_F32);
  column(to.intensity8, RGL_FIELD_INTENSITY_U8);
  column(to.hit, RGL_FIELD_IS_HIT_I32);
  column(to.ray, RGL_FIELD_RAY_IDX_U32);
  column(to.entity, RGL_FIELD_ENTITY_ID_I32);
  column(to.distance, RGL_FIELD_DISTANCE_F32);
  column(to.azimuth, RGL_FIELD_AZIMUTH_F32);
  column(to.elevation, RGL_FIELD_ELEVATION_F32);
  column(to.ring, RGL_FIELD_RING_ID_U16);
  column(to.type, RGL_FIELD_RETURN_TYPE_U8);
  column(to.time, RGL_FIELD_TIME_STAMP_F64);
  column(to.time32, RGL_FIELD_TIME_STAMP_U32);
  column(to.velocity, RGL_FIELD_ABSOLUTE_VELOCITY_VEC3_F32);
  column(to.relative, RGL_FIELD_RELATIVE_VELOCITY_VEC3_F32);
  column(to.radialSpeed, RGL_FIELD_RADIAL_SPEED_F32);
  column(to.normal, RGL_FIELD_NORMAL_VEC3_F32);
  column(to.incident, RGL_FIELD_INCIDENT_ANGLE_F32);
  column(to.pose, RGL_FIELD_RAY_POSE_MAT3x4_F32);
  column(to.retro, RGL_FIELD_LASER_RETRO_F32);
  column(to.reflectivity, RGL_FIELD_REFLECTIVITY_F32);
  to.surfaces = to.normal || to.incident || to.intensity || to.intensity8 || to.reflectivity || to.velocity ||
                to.relative || to.radialSpeed;
  return to;
}

void RaytraceNode::run() {
  const Rays& rays = input_->rays();
  if (distortion && !rays.offsets)
    throw Failure(RGL_INVALID_PIPELINE, std::string(kName) + ": velocity distortion requires time offsets of the rays");
  Run run{rays, beamSamples(divergenceHorizontal > 0), nullptr, inverse(rays.transform), scene().timeStep()};

  float range = 0;
  if (!rays.ranges) range = std::numeric_limits<float>::max();
  for (size_t i = 0; rays.ranges && i < rays.count(); ++i) {
    const Mat& matrix = (*rays.world)[i];
    const float reach = (*rays.ranges)[rays.ranges->size() == 1 ? 0 : i].value[1] *
                        length({matrix.m[0][2], matrix.m[1][2], matrix.m[2][2]});
    range = std::max(range, reach);
  }
  Tracer::Key key{rays.baseVersion,
                  distortion ? rays.offsetsVersion : 0,
                  settingsVersion,
                  std::isfinite(range) ? range * 1.001f + 1e-3f : std::numeric_limits<float>::max(),
                  {}};
  const bool rigid = isRigid(rays.transform);
  if (!rigid) key.transform = rays.transform;
  run.hits = &tracer_.trace(key, rigid ? rays.transform : Mat(), sensorId, [&] { return tracedRays(run); });

  cloud_ = {};
  cloud_.count = rays.count() * returnCount(returnMode);
  cloud_.sensor = rays.transform;
  const Columns to = makeColumns();
  inRuns(rays.count(), 4096, threadCount(), [&](uint64_t first, uint64_t end) {
    std::vector<Sample> samples(run.samples.size());
    for (uint64_t ray = first; ray < end; ++ray) computeRay(run, ray, to, samples);
  });
}

Surface RaytraceNode::surfaceOf(const Hit& hit) const {
  Surface surface{&scene().entityOf(hit.instance), hit.triangle, {}};
  const std::vector<Vec>& shape = surface.entity->shape();
  for (int k = 0; k < 3; ++k)
    surface.corners[k] = surface.entity->transform.now * shape[surface.entity->mesh->triangles[hit.triangle][k]];
  return surface;
}

// The distance is that of the actual ray to the plane of the triangle, in double.
Sample RaytraceNode::judge(const Run& run, size_t ray, size_t sample, Surface& surface) const {
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

/// The weights of a triangle's corners at a point of its plane.
std::array<float, 3> weightsAt(const Surface& surface, const Vec& at) {
  const auto& [a, b, c] = surface.corners;
  const Vec n = cross(b - a, c - a), w = at - a;
  const double square = double{n.x} * n.x + double{n.y} * n.y + double{n.z} * n.z;
  if (square == 0) return {1, 0, 0};
  const auto second = static_cast<float>(dot(n, cross(w, c - a)) / square);
  const auto third = static_cast<float>(dot(n, cross(b - a, w)) / square);
  return {1 - second - third, second, third};
}

float RaytraceNode::intensityOf(const Surface& surface, const Ray& world, double distance) const {
  float value = defaultIntensity;
  const EntityObject& entity = *surface.entity;
  if (entity.texture && !entity.mesh->uvs.empty()) {
    const Vec at = world.origin + unit(world.direction) * static_cast<float>(distance);
    const std::array<float, 3> weights = weightsAt(surface, at);
    const auto& triangle = entity.mesh->triangles[surface.triangle];
    const auto coordinate = [&](int axis, int32_t size) {
      float uv = 0;
      for (int k = 0; k < 3; ++k) uv += weights[k] * entity.mesh->uvs[triangle[k]].value[axis];
      return std::clamp(static_cast<int32_t>((uv - std::floor(uv)) * static_cast<float>(size)), 0, size - 1);
    };
    const TextureObject& texture = *entity.texture;
    value = texture.texels[size_t(coordinate(1, texture.height)) * texture.width + coordinate(0, texture.width)];
  }
  return value * static_cast<float>(surface.incidence(world.direction));
}

void RaytraceNode::computeRay(const Run& run, size_t ray, const Columns& to, std::vector<Sample>& samples) const {
  const bool byStrength = samples.size() > 1;
  Picked picked;
  for (size_t k = 0; k < samples.size(); ++k) {
    Surface surface;
    samples[k] = judge(run, ray, k, surface);
    if (!samples[k].hit) continue;
    if (byStrength) samples[k].intensity = intensityOf(surface, worldRay(run, ray, k), samples[k].distance);
    picked.add(samples[k]);
  }
  const int returns = returnCount(returnMode);
  for (int k = 0; k < returns; ++k) {
    const rgl_return_type_t type = returnType(returnMode, k);
    writePoint(run, ray, ray * returns + k, type, picked.first ? *picked.of(type) : samples[0], to);
  }
}

void RaytraceNode::writePoint(const Run& run, size_t ray, size_t point, rgl_return_type_t type, const Sample& sample,
                              const Columns& to) const {
  const Mat& nominal = (*run.rays.world)[ray];
  const Mat& base = (*run.rays.base)[ray];
  const float distance = sample.hit ? static_cast<float>(sample.distance) : sample.near ? nearNonHit : farNonHit;
  const Vec way = unit({nominal.m[0][2], nominal.m[1][2], nominal.m[2][2]}) * distance;
  Vec at = nominal.translation() + way;
  for (float* value : {&at.x, &at.y, &at.z})
    if (std::isnan(*value)) *value = 0;
  if (to.xyz) to.xyz[point] = at;
  if (to.hit) to.hit[point] = sample.hit;
  if (to.ray) to.ray[point] = static_cast<uint32_t>(ray);
  if (to.distance) to.distance[point] = distance;
  if (to.azimuth) to.azimuth[point] = std::abs(base.m[2][1]) < 1 ? std::atan2(-base.m[2][0], base.m[2][2]) : 0.0f;
  if (to.elevation) to.elevation[point] = std::asin(std::clamp(base.m[1][2], -1.0f, 1.0f));
  if (to.ring)
    to.ring[point] = run.rays.rings ? static_cast<uint16_t>((*run.rays.rings)[ray % run.rays.rings->size()]) : 0;
  if (to.type) to.type[point] = type;
  const float offset = distortion ? (*run.rays.offsets)[ray] : 0;
  if (to.time) to.time[point] = double{offset} * 1e-3;
  if (to.time32) to.time32[point] = static_cast<uint32_t>(double{offset} * 1e6);
  if (to.pose) to.pose[point] = nominal;

  const Vec none{kNaN, kNaN, kNaN};
  if (!sample.hit) {
    if (to.velocity) to.velocity[point] = none;
    if (to.relative) to.relative[point] = none;
    if (to.normal) to.normal[point] = none;
    if (to.incident) to.incident[point] = kNaN;
    return;  // everything else is zero
  }
  const Hit& hit = (*run.hits)[sample.index];
  if (to.entity) to.entity[point] = scene().entityOf(hit.instance).id;
  if (to.retro) to.retro[point] = scene().entityOf(hit.instance).retro;
  if (!to.surfaces) return;
  const Surface surface = surfaceOf(hit);
  const Ray world = worldRay(run, ray, sample.index % run.samples.size());
  if (to.normal) {
    const Vec3 n = surface.normal();
    to.normal[point] = {static_cast<float>(n.x), static_cast<float>(n.y), static_cast<float>(n.z)};
  }
  if (to.incident)
    to.incident[point] = static_cast<float>(std::acos(std::min(1.0, surface.incidence(world.direction))));
  if (to.intensity || to.intensity8 || to.reflectivity) {
    const float intensity = intensityOf(surface, world, sample.distance);
    if (to.intensity) to.intensity[point] = intensity;
    if (to.intensity8) to.intensity8[point] = static_cast<uint8_t>(std::min(255.0f, std::round(intensity)));
    if (to.reflectivity) to.reflectivity[point] = reflectivityAlpha * intensity * distance * distance;
  }
  if (to.velocity || to.relative || to.radialSpeed) writeVelocities(run, point, surface, at, to);
}

void RaytraceNode::writeVelocities(const Run& run, size_t point, const Surface& surface, const Vec& at,
                                   const Columns& to) const {
  Vec velocity{kNaN, kNaN, kNaN}, relative = velocity;
  float radial = kNaN;
  if (run.timeStep) {
    const EntityObject& entity = *surface.entity;
    const auto fresh = [&](const auto& history) {
      return history.time && history.timeBefore && history.time == scene().time &&
             history.timeBefore == scene().timeBefore;
    };
    const std::array<float, 3> weights = weightsAt(surface, at);
    const auto& triangle = entity.mesh->triangles[surface.triangle];
    // The way of the point that was hit, as a point of its triangle.
    Vec local, bent, way;
    for (int k = 0; k < 3; ++k) {
      local = local + entity.shape()[triangle[k]] * weights[k];
      if (fresh(entity.vertices))
        bent = bent + (entity.vertices.now[triangle[k]] - entity.vertices.before[triangle[k]]) * weights[k];
    }
    if (fresh(entity.transform)) {
      Mat change = entity.transform.now;
      for (int i = 0; i < 12; ++i) change.m[i / 4][i % 4] -= entity.transform.before.m[i / 4][i % 4];
      way = change * local;
    }
    way = way + entity.transform.now.turn(bent);
    velocity = way * static_cast<float>(1 / *run.timeStep);
    const Vec seen = run.toSensor * at;
    relative = run.toSensor.turn(velocity) - linearVelocity - cross(angularVelocity, seen);
    radial = dot(unit(seen), relative);
  }
  if (to.velocity) to.velocity[point] = velocity;
  if (to.relative) to.relative[point] = relative;
  if (to.radialSpeed) to.radialSpeed[point] = radial;
}

/// Runs a function that changes settings of a raytrace node.
template <class Set, class... Arguments>
rgl_status_t configure(const char* name, rgl_node_t node, Set set, const Arguments&... arguments) {
  return call(
      name,
      [&] {
        RGL_CHECK(node != nullptr);
        set(nodeAs<RaytraceNode>(node));
      },
      node, arguments...);
}

Vec vecOf(const rgl_vec3f& from) {
  return {from.value[0], from.value[1], from.value[2]};
}

}  // namespace
}  // namespace gnosphere::rgl

using namespace gnosphere::rgl;

RGL_API rgl_status_t rgl_node_raytrace(rgl_node_t* node, rgl_scene_t scene) {
  return call(
      "rgl_node_raytrace",
      [&] {
        RGL_CHECK(node != nullptr);
        RGL_CHECK(scene == nullptr);
        createOrUpdate<RaytraceNode>(node, Affects::node, [](auto& made) { made.set(); });
      },
      out(node), scene);
}

RGL_API rgl_status_t rgl_node_raytrace_configure_velocity(rgl_node_t node, const rgl_vec3f* linear_velocity,
                                                          const rgl_vec3f* angular_velocity) {
  return configure(
      "rgl_node_raytrace_configure_velocity", node,
      [&](RaytraceNode& raytrace) {
        RGL_CHECK(linear_velocity != nullptr);
        RGL_CHECK(angular_velocity != nullptr);
        raytrace.linearVelocity = vecOf(*linear_velocity);
        raytrace.angularVelocity = vecOf(*angular_velocity);
        if (raytrace.distortion) raytrace.settingsVersion = nextVersion();
      },
      arrayOf(linear_velocity, 1), arrayOf(angular_velocity, 1));
}

RGL_API rgl_status_t rgl_node_raytrace_configure_distortion(rgl_node_t node, bool enable) {
  return configure(
      "rgl_node_raytrace_configure_distortion", node,
      [&](RaytraceNode& raytrace) {
        if (raytrace.distortion != enable) raytrace.settingsVersion = nextVersion();
        raytrace.distortion = enable;
      },
      enable);
}

RGL_API rgl_status_t rgl_node_raytrace_configure_non_hits(rgl_node_t node, float nearDistance, float farDistance) {
  return configure(
      "rgl_node_raytrace_configure_non_hits", node,
      [&](RaytraceNode& raytrace) {
        raytrace.nearNonHit = nearDistance;
        raytrace.farNonHit = farDistance;
      },
      nearDistance, farDistance);
}

RGL_API rgl_status_t rgl_node_raytrace_configure_mask(rgl_node_t node, const int8_t* rays_mask, int32_t rays_count) {
  return configure(
      "rgl_node_raytrace_configure_mask", node,
      [&](RaytraceNode& raytrace) {
        RGL_CHECK(rays_mask != nullptr);
        RGL_CHECK(rays_count > 0);
        raytrace.mask.assign(rays_mask, rays_mask + rays_count);
      },
      arrayOf(rays_mask, rays_count), rays_count);
}

RGL_API rgl_status_t rgl_node_raytrace_configure_beam_divergence(rgl_node_t node, float horizontal_beam_divergence,
                                                                 float vertical_beam_divergence) {
  return configure(
      "rgl_node_raytrace_configure_beam_divergence", node,
      [&](RaytraceNode& raytrace) {
        RGL_CHECK((horizontal_beam_divergence > 0.0f && vertical_beam_divergence > 0.0f) ||
                  (horizontal_beam_divergence == 0.0f && vertical_beam_divergence == 0.0f));
        raytrace.divergenceHorizontal = horizontal_beam_divergence;
        raytrace.divergenceVertical = vertical_beam_divergence;
        raytrace.settingsVersion = nextVersion();
      },
      horizontal_beam_divergence, vertical_beam_divergence);
}

RGL_API rgl_status_t rgl_node_raytrace_configure_default_intensity(rgl_node_t node, float default_intensity) {
  return configure(
      "rgl_node_raytrace_configure_default_intensity", node,
      [&](RaytraceNode& raytrace) {
        RGL_CHECK(default_intensity >= 0.0f);
        raytrace.defaultIntensity = default_intensity;
      },
      default_intensity);
}

RGL_API rgl_status_t rgl_node_raytrace_configure_return_mode(rgl_node_t node, rgl_return_mode_t return_mode) {
  return configure(
      "rgl_node_raytrace_configure_return_mode", node,
      [&](RaytraceNode& raytrace) {
        RGL_CHECK(return_mode != RGL_RETURN_UNKNOWN);
        const int returns = returnCount(return_mode);
        RGL_CHECK(returns == 1 || returns == 2);
        if (raytrace.returnMode != return_mode) outdate(raytrace);
        raytrace.returnMode = return_mode;
      },
      return_mode);
}

RGL_API rgl_status_t rgl_node_raytrace_configure_reflectivity_alpha(rgl_node_t node, float reflectivity_alpha) {
  return configure(
      "rgl_node_raytrace_configure_reflectivity_alpha", node,
      [&](RaytraceNode& raytrace) {
        RGL_CHECK(reflectivity_alpha >= 0.0f);
        raytrace.reflectivityAlpha = reflectivity_alpha;
      },
      reflectivity_alpha);
}

RGL_API rgl_status_t rgl_node_raytrace_configure_id(rgl_node_t node, int32_t sensor_id) {
  return configure(
      "rgl_node_raytrace_configure_id", node, [&](RaytraceNode& raytrace) { raytrace.sensorId = sensor_id; },
      sensor_id);
}

// SPDX-License-Identifier: Apache-2.0
// The fields of the points that a raytrace node gives.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "rgl/raytrace_node.hpp"
#include "rgl/scene.hpp"

namespace gnosphere::rgl {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

}  // namespace

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

float RaytraceNode::intensityOf(const HitSurface& surface, const Ray& world, double distance) const {
  float value = defaultIntensity;
  const EntityObject& entity = *surface.entity;
  if (entity.texture && !entity.mesh->uvs.empty()) {
    const Vec at = world.origin + unit(world.direction) * static_cast<float>(distance);
    const std::array<float, 3> weights = weightsAt(surface, at);
    const auto& triangle = entity.mesh->triangles[surface.triangle];
    const auto coordinate = [&](int axis, int32_t size) {
      float uv = 0;
      for (int k = 0; k < 3; ++k) uv += weights[k] * entity.mesh->uvs[triangle[k]].value[axis];
      const float part = std::max(0.0f, uv - std::floor(uv));  // 0 if a coordinate is not finite
      return static_cast<int32_t>(std::min(static_cast<int64_t>(part * static_cast<float>(size)), int64_t{size} - 1));
    };
    const TextureObject& texture = *entity.texture;
    value = texture.texels[size_t(coordinate(1, texture.height)) * texture.width + coordinate(0, texture.width)];
  }
  return value * static_cast<float>(surface.incidence(world.direction));
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
  if (to.time32) to.time32[point] = static_cast<uint32_t>(std::min(4294967295.0, std::max(0.0, double{offset} * 1e6)));
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
  const HitSurface surface = surfaceOf(hit);
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

void RaytraceNode::writeVelocities(const Run& run, size_t point, const HitSurface& surface, const Vec& at,
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

}  // namespace gnosphere::rgl

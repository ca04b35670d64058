// SPDX-License-Identifier: Apache-2.0
// The functions that create a raytrace node and change its settings.
#include "rgl/raytrace_node.hpp"

namespace gnosphere::rgl {
namespace {

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

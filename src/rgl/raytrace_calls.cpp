// SPDX-License-Identifier: Apache-2.0
// The functions that create a raytrace node and change its settings.
#include "rgl/raytrace_node.hpp"

namespace gnosphere::rgl {
namespace {

/// Runs a function that changes settings of a raytrace node.
template <class... Arguments, class Set>
rgl_status_t configure(const char* name, rgl_node_t node, const Taped<Arguments...>& arguments, Set set) {
  return call(name, std::tuple_cat(taped(node), arguments), [&] {
    RGL_CHECK(node != nullptr);
    set(nodeAs<RaytraceNode>(node));
  });
}

Vec vecOf(const rgl_vec3f& from) {
  return {from.value[0], from.value[1], from.value[2]};
}

}  // namespace
}  // namespace gnosphere::rgl

using namespace gnosphere::rgl;

RGL_API rgl_status_t rgl_node_raytrace(rgl_node_t* node, rgl_scene_t scene) {
  return call(__func__, taped(out(node), scene), [&] {
    RGL_CHECK(node != nullptr);
    RGL_CHECK(scene == nullptr);
    createOrUpdate<RaytraceNode>(node, Affects::node, [](auto& made) { made.set(); });
  });
}

RGL_API rgl_status_t rgl_node_raytrace_configure_velocity(rgl_node_t node, const rgl_vec3f* linear_velocity,
                                                          const rgl_vec3f* angular_velocity) {
  return configure(__func__, node, taped(arrayOf(linear_velocity, 1), arrayOf(angular_velocity, 1)),
                   [&](RaytraceNode& raytrace) {
                     RGL_CHECK(linear_velocity != nullptr);
                     RGL_CHECK(angular_velocity != nullptr);
                     const Vec linear = vecOf(*linear_velocity), angular = vecOf(*angular_velocity);
                     const bool same = linear == raytrace.linearVelocity && angular == raytrace.angularVelocity;
                     if (raytrace.distortion && !same) raytrace.settingsVersion = nextVersion();
                     raytrace.linearVelocity = linear;
                     raytrace.angularVelocity = angular;
                   });
}

RGL_API rgl_status_t rgl_node_raytrace_configure_distortion(rgl_node_t node, bool enable) {
  return configure(__func__, node, taped(enable), [&](RaytraceNode& raytrace) {
    if (raytrace.distortion != enable) raytrace.settingsVersion = nextVersion();
    raytrace.distortion = enable;
  });
}

RGL_API rgl_status_t rgl_node_raytrace_configure_non_hits(rgl_node_t node, float nearDistance, float farDistance) {
  return configure(__func__, node, taped(nearDistance, farDistance), [&](RaytraceNode& raytrace) {
    raytrace.nearNonHit = nearDistance;
    raytrace.farNonHit = farDistance;
  });
}

RGL_API rgl_status_t rgl_node_raytrace_configure_mask(rgl_node_t node, const int8_t* rays_mask, int32_t rays_count) {
  return configure(__func__, node, taped(arrayOf(rays_mask, rays_count), rays_count), [&](RaytraceNode& raytrace) {
    RGL_CHECK(rays_mask != nullptr);
    RGL_CHECK(rays_count > 0);
    raytrace.mask.assign(rays_mask, rays_mask + rays_count);
  });
}

RGL_API rgl_status_t rgl_node_raytrace_configure_beam_divergence(rgl_node_t node, float horizontal_beam_divergence,
                                                                 float vertical_beam_divergence) {
  return configure(__func__, node, taped(horizontal_beam_divergence, vertical_beam_divergence),
                   [&](RaytraceNode& raytrace) {
                     RGL_CHECK((horizontal_beam_divergence > 0.0f && vertical_beam_divergence > 0.0f) ||
                               (horizontal_beam_divergence == 0.0f && vertical_beam_divergence == 0.0f));
                     const bool same = horizontal_beam_divergence == raytrace.divergenceHorizontal &&
                                       vertical_beam_divergence == raytrace.divergenceVertical;
                     if (!same) raytrace.settingsVersion = nextVersion();
                     raytrace.divergenceHorizontal = horizontal_beam_divergence;
                     raytrace.divergenceVertical = vertical_beam_divergence;
                   });
}

RGL_API rgl_status_t rgl_node_raytrace_configure_default_intensity(rgl_node_t node, float default_intensity) {
  return configure(__func__, node, taped(default_intensity), [&](RaytraceNode& raytrace) {
    RGL_CHECK(default_intensity >= 0.0f);
    raytrace.defaultIntensity = default_intensity;
  });
}

RGL_API rgl_status_t rgl_node_raytrace_configure_return_mode(rgl_node_t node, rgl_return_mode_t return_mode) {
  return configure(__func__, node, taped(return_mode), [&](RaytraceNode& raytrace) {
    RGL_CHECK(return_mode != RGL_RETURN_UNKNOWN);
    const int returns = returnCount(return_mode);
    RGL_CHECK(returns == 1 || returns == 2);
    if (raytrace.returnMode != return_mode) outdate(raytrace);
    raytrace.returnMode = return_mode;
  });
}

RGL_API rgl_status_t rgl_node_raytrace_configure_reflectivity_alpha(rgl_node_t node, float reflectivity_alpha) {
  return configure(__func__, node, taped(reflectivity_alpha), [&](RaytraceNode& raytrace) {
    RGL_CHECK(reflectivity_alpha >= 0.0f);
    raytrace.reflectivityAlpha = reflectivity_alpha;
  });
}

RGL_API rgl_status_t rgl_node_raytrace_configure_id(rgl_node_t node, int32_t sensor_id) {
  return configure(__func__, node, taped(sensor_id), [&](RaytraceNode& raytrace) { raytrace.sensorId = sensor_id; });
}

// SPDX-License-Identifier: Apache-2.0
// Functions under the names that they had at earlier levels of the interface.
#include "rgl/legacy.hpp"

#include "rgl/fields.hpp"
#include "rgl/raytrace_node.hpp"
#include "rgl/scene.hpp"

using namespace gnosphere::rgl;

namespace {

/// Level 0.18: the first or the last returns of a raytrace node, beside its own.
class ReturnSwitchNode : public ReturnChooser {
 public:
  static constexpr const char* kName = "MultiReturnSwitchNode";
  const char* name() const override { return kName; }
  void set(int32_t type) { type_ = type; }
  rgl_return_mode_t mode(rgl_return_mode_t own) const override {
    return type_ == kFirst ? RGL_RETURN_FIRST : type_ == kLast ? RGL_RETURN_LAST : own;
  }

  // Values of rgl_return_type_t as level 0.18 numbers them.
  static constexpr int32_t kNotDivergent = 0, kFirst = 1, kLast = 2;

 private:
  int32_t type_ = kFirst;
};

}  // namespace

/// RGL 0.18 has this function.
RGL_API rgl_status_t rgl_node_multi_return_switch(rgl_node_t* node, int32_t return_type) {
  return call(__func__, taped(out(node), return_type), [&] {
    RGL_CHECK(node != nullptr);
    RGL_CHECK(return_type >= ReturnSwitchNode::kNotDivergent && return_type <= ReturnSwitchNode::kLast);
    createOrUpdate<ReturnSwitchNode>(node, Affects::graph, [&](auto& made) { made.set(return_type); });
  });
}

/// RGL had this function until 0.18.
RGL_API rgl_status_t rgl_entity_set_pose(rgl_entity_t entity, const rgl_mat3x4f* transform) {
  return rgl_entity_set_transform(entity, transform);
}

/// RGL had this function until 0.17.
RGL_API rgl_status_t rgl_node_points_compact(rgl_node_t* node) {
  return rgl_node_points_compact_by_field(node, static_cast<rgl_field_t>(level() <= 17 ? 3 : RGL_FIELD_IS_HIT_I32));
}

/// Until 0.18: new vertices for every entity of a mesh.
RGL_API rgl_status_t rgl_mesh_update_vertices(rgl_mesh_t mesh, const rgl_vec3f* vertices, int32_t vertex_count) {
  return call(__func__, taped(mesh, arrayOf(vertices, vertex_count), vertex_count), [&] {
    RGL_CHECK(mesh != nullptr);
    RGL_CHECK(vertices != nullptr);
    RGL_CHECK(vertex_count > 0);
    const std::shared_ptr<MeshObject> of = scene().meshes.at(mesh);
    if (of->vertices.size() != static_cast<size_t>(vertex_count))
      throw Failure(RGL_INVALID_ARGUMENT, "Invalid argument: vertex counts do not match");
    std::vector<Vec> shape(vertex_count);
    for (int32_t i = 0; i < vertex_count; ++i)
      shape[i] = {vertices[i].value[0], vertices[i].value[1], vertices[i].value[2]};
    // If memory runs out, no entity has moved yet.
    std::vector<std::pair<EntityObject*, std::vector<Vec>>> entities;
    scene().entities.each([&](rgl_entity_t, EntityObject& entity) {
      if (entity.mesh != of) return;
      entity.keepShape();
      entities.emplace_back(&entity, shape);
    });
    for (auto& [entity, own] : entities) entity->deform(std::move(own), scene().time);
    of->vertices = std::move(shape);
    scene().forget(*of);
  });
}

/// The development version that some bindings are made for.
RGL_API rgl_status_t rgl_node_raytrace_in_motion(rgl_node_t* node, rgl_scene_t scene, const rgl_vec3f* linear_velocity,
                                                 const rgl_vec3f* angular_velocity, bool apply_distortion) {
  rgl_status_t status = rgl_node_raytrace(node, scene);
  if (status == RGL_SUCCESS) status = rgl_node_raytrace_configure_velocity(*node, linear_velocity, angular_velocity);
  if (status == RGL_SUCCESS) status = rgl_node_raytrace_configure_distortion(*node, apply_distortion);
  return status;
}

/// This function is part of RGL 0.15 and 0.16 alone.
RGL_API rgl_status_t rgl_node_raytrace_with_distortion(rgl_node_t* node, rgl_scene_t scene,
                                                       const rgl_vec3f* linear_velocity,
                                                       const rgl_vec3f* angular_velocity) {
  return rgl_node_raytrace_in_motion(node, scene, linear_velocity, angular_velocity, true);
}

// SPDX-License-Identifier: Apache-2.0
// Meshes, textures, entities and the scene's time: the functions of the interface.
#include <algorithm>

#include "rgl/scene.hpp"

using namespace gnosphere::rgl;

namespace {

std::vector<Vec> vectorsOf(const rgl_vec3f* from, int32_t count) {
  std::vector<Vec> result(count);
  for (int32_t i = 0; i < count; ++i) result[i] = {from[i].value[0], from[i].value[1], from[i].value[2]};
  return result;
}

void checkIndices(const rgl_vec3i* indices, int32_t count, int32_t vertices) {
  for (int32_t i = 0; i < count; ++i)
    for (const int32_t index : indices[i].value)
      if (index < 0 || index >= vertices)
        throw Failure(RGL_INVALID_ARGUMENT, "triangle " + std::to_string(i) + " has the vertex " +
                                                std::to_string(index) + ", but there are " + std::to_string(vertices));
}

void move(EntityObject& entity, const Mat& transform) {
  entity.transform.change(transform, scene().time);
  entity.moved = true;
}

/// Each vertex, moved by the bones that it belongs to.
std::vector<Vec> skinned(const MeshObject& mesh, const rgl_mat3x4f* pose, int32_t count) {
  std::vector<Mat> bones(count);
  for (int32_t i = 0; i < count; ++i) bones[i] = matOf(pose[i]) * mesh.restPoses[i];
  std::vector<Vec> result(mesh.vertices.size());
  for (size_t v = 0; v < result.size(); ++v)
    for (int k = 0; k < 4; ++k) {
      const float weight = mesh.weights[v].weights[k];
      if (weight != 0) result[v] = result[v] + (bones[mesh.weights[v].bone_indexes[k]] * mesh.vertices[v]) * weight;
    }
  return result;
}

void checkBones(const MeshObject& mesh, int32_t bones) {
  for (const rgl_bone_weights_t& weights : mesh.weights)
    for (const int32_t index : weights.bone_indexes)
      if (index < 0 || index >= bones)
        throw Failure(RGL_INVALID_ARGUMENT,
                      "a vertex belongs to bone " + std::to_string(index) + ", but there are " + std::to_string(bones));
}

template <class Handle, class AllObjects>
rgl_status_t isAlive(const char* name, const AllObjects& objects, Handle handle, bool* out_alive) {
  return call(name, taped(handle, false), [&] {
    RGL_CHECK(out_alive != nullptr);
    *out_alive = objects.has(handle);
  });
}

}  // namespace

RGL_API rgl_status_t rgl_mesh_create(rgl_mesh_t* out_mesh, const rgl_vec3f* vertices, int32_t vertex_count,
                                     const rgl_vec3i* indices, int32_t index_count) {
  return call(
      __func__,
      taped(out(out_mesh), arrayOf(vertices, vertex_count), vertex_count, arrayOf(indices, index_count), index_count),
      [&] {
        RGL_CHECK(out_mesh != nullptr);
        RGL_CHECK(vertices != nullptr);
        RGL_CHECK(vertex_count > 0);
        RGL_CHECK(indices != nullptr);
        RGL_CHECK(index_count > 0);
        checkIndices(indices, index_count, vertex_count);
        auto mesh = std::make_shared<MeshObject>();
        mesh->vertices = vectorsOf(vertices, vertex_count);
        mesh->triangles.resize(index_count);
        for (int32_t i = 0; i < index_count; ++i) std::copy_n(indices[i].value, 3, mesh->triangles[i].begin());
        *out_mesh = scene().meshes.add(std::move(mesh));
      });
}

RGL_API rgl_status_t rgl_mesh_set_texture_coords(rgl_mesh_t mesh, const rgl_vec2f* uvs, int32_t uv_count) {
  return call(__func__, taped(mesh, arrayOf(uvs, uv_count), uv_count), [&] {
    RGL_CHECK(mesh != nullptr);
    RGL_CHECK(uvs != nullptr);
    RGL_CHECK(uv_count > 0);
    MeshObject& to = *scene().meshes.at(mesh);
    const auto vertex_count = static_cast<int32_t>(to.vertices.size());
    RGL_CHECK(uv_count == vertex_count);
    to.uvs.assign(uvs, uvs + uv_count);
  });
}

RGL_API rgl_status_t rgl_mesh_set_bone_weights(rgl_mesh_t mesh, const rgl_bone_weights_t* bone_weights,
                                               int32_t bone_weights_count) {
  return call(__func__, taped(mesh, arrayOf(bone_weights, bone_weights_count), bone_weights_count), [&] {
    RGL_CHECK(mesh != nullptr);
    RGL_CHECK(bone_weights != nullptr);
    RGL_CHECK(bone_weights_count > 0);
    MeshObject& to = *scene().meshes.at(mesh);
    const auto vertex_count = static_cast<int32_t>(to.vertices.size());
    RGL_CHECK(bone_weights_count == vertex_count);
    to.weights.assign(bone_weights, bone_weights + bone_weights_count);
  });
}

RGL_API rgl_status_t rgl_mesh_set_restposes(rgl_mesh_t mesh, const rgl_mat3x4f* restposes, int32_t bones_count) {
  return call(__func__, taped(mesh, arrayOf(restposes, bones_count), bones_count), [&] {
    RGL_CHECK(mesh != nullptr);
    RGL_CHECK(restposes != nullptr);
    RGL_CHECK(bones_count > 0);
    RGL_CHECK(std::all_of(restposes, restposes + bones_count, isFinite));
    MeshObject& to = *scene().meshes.at(mesh);
    to.restPoses.resize(bones_count);
    std::transform(restposes, restposes + bones_count, to.restPoses.begin(), matOf);
  });
}

RGL_API rgl_status_t rgl_mesh_destroy(rgl_mesh_t mesh) {
  return call(__func__, taped(mesh), [&] {
    RGL_CHECK(mesh != nullptr);
    scene().meshes.remove(mesh);
  });
}

RGL_API rgl_status_t rgl_mesh_is_alive(rgl_mesh_t mesh, bool* out_alive) {
  return isAlive("rgl_mesh_is_alive", scene().meshes, mesh, out_alive);
}

RGL_API rgl_status_t rgl_entity_create(rgl_entity_t* out_entity, rgl_scene_t scene, rgl_mesh_t mesh) {
  return call(__func__, taped(out(out_entity), scene, mesh), [&] {
    RGL_CHECK(out_entity != nullptr);
    RGL_CHECK(mesh != nullptr);
    RGL_CHECK(scene == nullptr);
    SceneState& all = gnosphere::rgl::scene();
    auto entity = std::make_shared<EntityObject>();
    entity->mesh = all.meshes.at(mesh);
    *out_entity = all.place(std::move(entity));
  });
}

RGL_API rgl_status_t rgl_entity_destroy(rgl_entity_t entity) {
  return call(__func__, taped(entity), [&] {
    RGL_CHECK(entity != nullptr);
    scene().remove(std::shared_ptr(scene().entities.at(entity)));  // if it throws, the entity is there as before
    scene().entities.remove(entity);
  });
}

RGL_API rgl_status_t rgl_entity_set_transform(rgl_entity_t entity, const rgl_mat3x4f* transform) {
  return call(__func__, taped(entity, arrayOf(transform, 1)), [&] {
    RGL_CHECK(entity != nullptr);
    RGL_CHECK(transform != nullptr);
    EntityObject& to = *scene().entities.at(entity);
    RGL_CHECK(isFinite(*transform));
    move(to, matOf(*transform));
  });
}

RGL_API rgl_status_t rgl_entity_set_pose_world(rgl_entity_t entity, const rgl_mat3x4f* pose, int32_t bones_count) {
  return call(__func__, taped(entity, arrayOf(pose, bones_count), bones_count), [&] {
    RGL_CHECK(entity != nullptr);
    RGL_CHECK(pose != nullptr);
    RGL_CHECK(bones_count > 0);
    RGL_CHECK(std::all_of(pose, pose + bones_count, isFinite));
    EntityObject& to = *scene().entities.at(entity);
    const MeshObject& mesh = *to.mesh;
    if (mesh.weights.empty() || mesh.restPoses.empty())
      throw Failure(RGL_INVALID_ARGUMENT, "the entity's mesh has no bone weights or no rest poses");
    const auto restposes_count = static_cast<int32_t>(mesh.restPoses.size());
    RGL_CHECK(bones_count == restposes_count);
    checkBones(mesh, bones_count);
    to.deform(skinned(mesh, pose, bones_count), scene().time);
    move(to, Mat());
  });
}

RGL_API rgl_status_t rgl_entity_set_id(rgl_entity_t entity, int32_t id) {
  return call(__func__, taped(entity, id), [&] {
    RGL_CHECK(entity != nullptr);
    RGL_CHECK(id != RGL_ENTITY_INVALID_ID);
    RGL_CHECK(id <= RGL_DEFAULT_ENTITY_ID);
    scene().entities.at(entity)->id = id;
  });
}

RGL_API rgl_status_t rgl_entity_set_intensity_texture(rgl_entity_t entity, rgl_texture_t texture) {
  return call(__func__, taped(entity, texture), [&] {
    RGL_CHECK(entity != nullptr);
    RGL_CHECK(texture != nullptr);
    scene().entities.at(entity)->texture = scene().textures.at(texture);
  });
}

RGL_API rgl_status_t rgl_entity_set_laser_retro(rgl_entity_t entity, float retro) {
  return call(__func__, taped(entity, retro), [&] {
    RGL_CHECK(entity != nullptr);
    scene().entities.at(entity)->retro = retro;
  });
}

RGL_API rgl_status_t rgl_entity_apply_external_animation(rgl_entity_t entity, const rgl_vec3f* vertices,
                                                         int32_t vertex_count) {
  return call(__func__, taped(entity, arrayOf(vertices, vertex_count), vertex_count), [&] {
    RGL_CHECK(entity != nullptr);
    RGL_CHECK(vertices != nullptr);
    RGL_CHECK(vertex_count > 0);
    EntityObject& to = *scene().entities.at(entity);
    if (to.mesh->vertices.size() != static_cast<size_t>(vertex_count))
      throw Failure(RGL_INVALID_ARGUMENT, "Invalid argument: vertex counts do not match: the mesh has " +
                                              std::to_string(to.mesh->vertices.size()) + ", " +
                                              std::to_string(vertex_count) + " were given");
    to.deform(vectorsOf(vertices, vertex_count), scene().time);
  });
}

RGL_API rgl_status_t rgl_entity_is_alive(rgl_entity_t entity, bool* out_alive) {
  return isAlive("rgl_entity_is_alive", scene().entities, entity, out_alive);
}

RGL_API rgl_status_t rgl_entity_set_ignored_by_sensor(rgl_entity_t entity, int32_t sensor_id) {
  return call(__func__, taped(entity, sensor_id), [&] {
    RGL_CHECK(entity != nullptr);
    std::vector<int32_t>& sensors = scene().entities.at(entity)->ignoredBy;
    if (std::find(sensors.begin(), sensors.end(), sensor_id) == sensors.end()) sensors.push_back(sensor_id);
  });
}

RGL_API rgl_status_t rgl_texture_create(rgl_texture_t* out_texture, const void* texels, int32_t width, int32_t height) {
  return call(
      __func__,
      taped(out(out_texture), arrayOf(static_cast<const uint8_t*>(texels), int64_t{width} * height), width, height),
      [&] {
        RGL_CHECK(out_texture != nullptr);
        RGL_CHECK(texels != nullptr);
        RGL_CHECK(width > 0);
        RGL_CHECK(height > 0);
        auto texture = std::make_shared<TextureObject>();
        const auto* bytes = static_cast<const uint8_t*>(texels);
        texture->texels.assign(bytes, bytes + size_t(width) * height);
        texture->width = width;
        texture->height = height;
        *out_texture = scene().textures.add(std::move(texture));
      });
}

RGL_API rgl_status_t rgl_texture_destroy(rgl_texture_t texture) {
  return call(__func__, taped(texture), [&] {
    RGL_CHECK(texture != nullptr);
    scene().textures.remove(texture);
  });
}

RGL_API rgl_status_t rgl_texture_is_alive(rgl_texture_t texture, bool* out_alive) {
  return isAlive("rgl_texture_is_alive", scene().textures, texture, out_alive);
}

RGL_API rgl_status_t rgl_scene_set_time(rgl_scene_t scene, uint64_t nanoseconds) {
  return call(__func__, taped(scene, nanoseconds), [&] {
    RGL_CHECK(scene == nullptr);
    SceneState& to = gnosphere::rgl::scene();
    to.timeBefore = to.time;
    to.time = nanoseconds;
  });
}

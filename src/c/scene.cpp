// SPDX-License-Identifier: Apache-2.0
// gno_scene and gno_material_table: scenes from files and from arrays.
#include <algorithm>

#include "c/handles.hpp"

namespace gnosphere::c {

GNO_SAME_ENUM(AlphaImage::Wrap, {GNO_WRAP_REPEAT, repeat}, {GNO_WRAP_MIRROR, mirror}, {GNO_WRAP_CLAMP, clamp});
GNO_SAME_ENUM(AlphaMode, {GNO_ALPHA_OPAQUE, opaque}, {GNO_ALPHA_MASK, mask}, {GNO_ALPHA_BLEND, blend});
GNO_SAME_ENUM(UpAxis, {GNO_UP_FORMAT_DEFAULT, formatDefault}, {GNO_UP_Y, y}, {GNO_UP_Z, z});

AlphaImage alphaImageOf(const gno_alpha_image* image) {
  const gno_alpha_image& from = sized(image, GNO_TYPE(gno_alpha_image));
  const auto texels = array(from.alpha, size_t{from.width} * from.height, "gno_alpha_image::alpha");
  AlphaImage result;
  result.width = from.width;
  result.height = from.height;
  result.alpha.assign(texels.begin(), texels.end());
  result.wrapU = enumOf(from.wrap_u, AlphaImage::Wrap::clamp, "gno_alpha_image::wrap_u");
  result.wrapV = enumOf(from.wrap_v, AlphaImage::Wrap::clamp, "gno_alpha_image::wrap_v");
  return result;
}

Material materialOf(const gno_material* material) {
  const gno_material& from = sized(material, GNO_TYPE(gno_material));
  Material result;
  result.name = orEmpty(from.name);
  std::copy_n(from.base_color, 4, result.baseColor.begin());
  result.metallic = from.metallic;
  result.roughness = from.roughness;
  result.transmission = from.transmission;
  result.alphaMode = enumOf(from.alpha_mode, AlphaMode::blend, "gno_material::alpha_mode");
  result.alphaCutoff = from.alpha_cutoff;
  result.alphaImage = from.alpha_image;
  result.retro = from.retro;
  result.doubleSided = from.double_sided != 0;
  result.classId = from.class_id;
  result.className = orEmpty(from.class_name);
  return result;
}

Mesh meshOf(const gno_mesh* mesh) {
  const gno_mesh& from = sized(mesh, GNO_TYPE(gno_mesh));
  const auto positions = array(from.positions, from.vertex_count, 3, "gno_mesh::positions");
  const auto indices = array(from.indices, from.triangle_count, 3, "gno_mesh::indices");
  if (from.triangle_count > UINT32_MAX)
    refuse("gno_mesh::triangle_count is " + std::to_string(from.triangle_count) + "; a mesh has at most " +
           std::to_string(UINT32_MAX));
  Mesh result;
  result.name = orEmpty(from.name);
  result.origin = vec3(from.origin);
  result.positions.assign(positions.begin(), positions.end());
  result.indices.assign(indices.begin(), indices.end());
  const auto uvs = array(from.uvs, from.uvs ? from.vertex_count : 0, 2, "gno_mesh::uvs");
  result.uvs.assign(uvs.begin(), uvs.end());
  for (const gno_mesh_part& part : array(from.parts, from.part_count, "gno_mesh::parts"))
    result.parts.push_back({part.first_triangle, part.triangle_count, part.material});
  if (from.part_count == 0) result.parts = {{0, static_cast<uint32_t>(from.triangle_count), 0}};
  const auto joints = array(from.joints, from.vertex_count, from.influences, "gno_mesh::joints");
  const auto weights = array(from.joint_weights, from.vertex_count, from.influences, "gno_mesh::joint_weights");
  result.jointCount = from.joint_count;
  result.influences = from.influences;
  result.joints.assign(joints.begin(), joints.end());
  result.jointWeights.assign(weights.begin(), weights.end());
  for (const float* target : array(from.morph_targets, from.morph_target_count, "gno_mesh::morph_targets")) {
    const auto offsets = array(target, from.vertex_count, 3, "a target of gno_mesh::morph_targets");
    result.morphTargets.emplace_back(offsets.begin(), offsets.end());
  }
  result.deformation = deformationOf(from.deformation);
  return result;
}

Deformation deformationOf(const gno_deformation& deformation) {
  Deformation result;
  for (const gno_transform& joint : array(deformation.joints, deformation.joint_count, "gno_deformation::joints"))
    result.joints.push_back(transformOf(joint));
  const auto weights =
      array(deformation.morph_weights, deformation.morph_weight_count, "gno_deformation::morph_weights");
  result.morphWeights.assign(weights.begin(), weights.end());
  return result;
}

gno_deformation deformationOf(const Deformation& deformation) {
  return {transformsOf(deformation.joints), deformation.joints.size(), orNull(deformation.morphWeights),
          deformation.morphWeights.size()};
}

Instance instanceOf(const gno_instance* instance) {
  const gno_instance& from = sized(instance, GNO_TYPE(gno_instance));
  return {orEmpty(from.name),       from.mesh, transformOf(from.transform), from.class_id,
          orEmpty(from.class_name), from.world};
}

const Scene& valid(SceneObject& scene) {
  if (!scene.valid) validate(scene);
  scene.valid = true;
  return scene;
}

}  // namespace gnosphere::c

using namespace gnosphere;
using namespace gnosphere::c;

extern "C" {

gno_status gno_scene_create(gno_scene* scene) {
  return giveHandle(scene, "scene", [&] { return make<gno_scene>({}); });
}

gno_status gno_scene_load(const char* file, const gno_load_options* options, gno_scene* scene) {
  return giveHandle(scene, "scene", [&] {
    LoadOptions wanted;
    if (options) {
      const gno_load_options& from = sized(options, GNO_TYPE(gno_load_options));
      wanted.up = enumOf(from.up, UpAxis::z, "gno_load_options::up");
      wanted.scale = from.scale;
    }
    return make<gno_scene>(loadScene(fileOf(file), wanted));
  });
}

gno_status gno_scene_destroy(gno_scene scene) {
  return guard([&] { destroy(scene); });
}

gno_status gno_scene_add_alpha_image(gno_scene scene, const gno_alpha_image* image, uint32_t* index) {
  return addTo(scene, &Scene::alphaImages, alphaImageOf, image, index);
}

gno_status gno_scene_add_material(gno_scene scene, const gno_material* material, uint32_t* index) {
  return addTo(scene, &Scene::materials, materialOf, material, index);
}

gno_status gno_scene_add_mesh(gno_scene scene, const gno_mesh* mesh, uint32_t* index) {
  return addTo(scene, &Scene::meshes, meshOf, mesh, index);
}

gno_status gno_scene_add_instance(gno_scene scene, const gno_instance* instance, uint32_t* index) {
  return addTo(scene, &Scene::instances, instanceOf, instance, index);
}

gno_status gno_scene_join(gno_scene scene, gno_scene other, const gno_transform* transform, uint32_t* first_instance) {
  return guard([&] {
    const Transform placed = transform ? transformOf(*transform) : Transform();
    const Scene from = *Locked(other);  // a copy, so that no call holds two scenes at once
    Changing to(scene);
    const size_t first = to->instances.size();
    static_cast<Scene&>(*to) = joined(*to, from, placed);
    to->valid = false;
    if (first_instance) *first_instance = static_cast<uint32_t>(first);
  });
}

gno_status gno_scene_get_counts(gno_scene scene, gno_scene_counts* counts) {
  return guard([&] {
    Locked from(scene);
    const Out to(counts, GNO_TYPE(gno_scene_counts));
    to->materials = from->materials.size();
    to->alpha_images = from->alphaImages.size();
    to->meshes = from->meshes.size();
    to->instances = from->instances.size();
    to->unread_images = from->unreadImages;
    to->unique_triangles = from->uniqueTriangleCount();
    to->placed_triangles = from->placedTriangleCount();
    to->nodes = from->animation.nodes.size();
    to->skins = from->animation.skins.size();
    to->clips = from->animation.clips.size();
    to->animated_instances = from->animation.instances.size();
  });
}

gno_status gno_scene_get_alpha_image(gno_scene scene, size_t index, gno_alpha_image* image) {
  return guard([&] {
    Locked locked(scene);
    const AlphaImage& from = at(locked->alphaImages, index, "alpha image");
    const Out to(image, GNO_TYPE(gno_alpha_image));
    to->width = from.width;
    to->height = from.height;
    to->alpha = from.alpha.data();
    to->wrap_u = static_cast<gno_wrap>(from.wrapU);
    to->wrap_v = static_cast<gno_wrap>(from.wrapV);
  });
}

gno_status gno_scene_get_material(gno_scene scene, size_t index, gno_material* material) {
  return guard([&] {
    Locked locked(scene);
    const Material& from = at(locked->materials, index, "material");
    const Out to(material, GNO_TYPE(gno_material));
    to->name = from.name.c_str();
    std::copy_n(from.baseColor.begin(), 4, to->base_color);
    to->metallic = from.metallic;
    to->roughness = from.roughness;
    to->transmission = from.transmission;
    to->alpha_mode = static_cast<gno_alpha_mode>(from.alphaMode);
    to->alpha_cutoff = from.alphaCutoff;
    to->alpha_image = from.alphaImage;
    to->retro = from.retro;
    to->double_sided = from.doubleSided;
    to->class_id = from.classId;
    to->class_name = from.className.c_str();
  });
}

gno_status gno_scene_get_mesh(gno_scene scene, size_t index, gno_mesh* mesh) {
  return guard([&] {
    static_assert(sizeof(gno_mesh_part) == sizeof(MeshPart));
    Locked locked(scene);
    const Mesh& from = at(locked->meshes, index, "mesh");
    const Out to(mesh, GNO_TYPE(gno_mesh));
    to->name = from.name.c_str();
    set(to->origin, from.origin);
    to->positions = from.positions.data();
    to->vertex_count = from.vertexCount();
    to->indices = from.indices.data();
    to->triangle_count = from.triangleCount();
    to->uvs = orNull(from.uvs);
    to->parts = reinterpret_cast<const gno_mesh_part*>(from.parts.data());
    to->part_count = from.parts.size();
    to->joint_count = from.jointCount;
    to->influences = from.influences;
    to->joints = orNull(from.joints);
    to->joint_weights = orNull(from.jointWeights);
    thread_local std::vector<const float*> targets;
    targets.clear();
    for (const std::vector<float>& target : from.morphTargets) targets.push_back(target.data());
    to->morph_targets = orNull(targets);
    to->morph_target_count = targets.size();
    to->deformation = deformationOf(from.deformation);
  });
}

gno_status gno_scene_get_instance(gno_scene scene, size_t index, gno_instance* instance) {
  return guard([&] {
    Locked locked(scene);
    const Instance& from = at(locked->instances, index, "instance");
    const Out to(instance, GNO_TYPE(gno_instance));
    to->name = from.name.c_str();
    to->mesh = from.mesh;
    to->class_id = from.classId;
    to->class_name = from.className.c_str();
    to->world = from.world;
    std::copy_n(from.transform.rows.begin(), 12, to->transform.rows);
  });
}

gno_status gno_scene_get_bounds(gno_scene scene, double min[3], double max[3]) {
  return guard([&] {
    the(min, "min"), the(max, "max");
    Locked from(scene);
    const Bounds bounds = worldBounds(valid(*from));
    set(min, bounds.min);
    set(max, bounds.max);
  });
}

gno_status gno_scene_validate(gno_scene scene) {
  return guard([&] {
    Locked from(scene);
    valid(*from);
  });
}

gno_status gno_scene_write_glb(gno_scene scene, const char* file) {
  return guard([&] { writeGlb(*Locked(scene), fileOf(file)); });
}

gno_status gno_scene_get_optics(gno_scene scene, gno_material_table table, double wavelength, gno_optics* optics,
                                size_t capacity, size_t* count) {
  return guard([&] {
    MaterialTable rows;
    if (table) rows = *Locked(table);
    Locked from(scene);
    const std::vector<Optics> all = opticsOf(valid(*from), rows, wavelength);
    const auto to = array(optics, capacity, "optics");
    for (size_t i = 0; i < std::min(all.size(), to.size()); ++i)
      to[i] = {all[i].reflectance, all[i].gloss, all[i].roughness, all[i].retro, all[i].transmission};
    the(count, "count") = all.size();
  });
}

gno_status gno_scene_get_deformed_positions(gno_scene scene, size_t mesh, const gno_deformation* deformation,
                                            float* positions, size_t vertex_count) {
  return guard([&] {
    Locked locked(scene);
    const Mesh& from = at(valid(*locked).meshes, mesh, "mesh");
    const Deformation wanted = deformation ? deformationOf(*deformation) : from.deformation;
    const auto to = array(positions, vertex_count, 3, "positions");
    if (vertex_count != from.vertexCount())
      refuse("mesh " + std::to_string(mesh) + " has " + std::to_string(from.vertexCount()) + " vertices, not " +
             std::to_string(vertex_count));
    std::ranges::copy(deformedPositions(from, wanted), to.begin());
  });
}

gno_status gno_scene_get_left_out(gno_scene scene, const char** lines) {
  return guard([&] {
    thread_local std::string text;
    text.clear();
    for (const std::string& line : Locked(scene)->leftOut) text += line + '\n';
    the(lines, "lines") = text.c_str();
  });
}

gno_status gno_material_table_load(const char* file, gno_material_table* table) {
  return giveHandle(table, "table",
                    [&] { return make<gno_material_table>(file ? loadMaterialTable(fileOf(file)) : MaterialTable()); });
}

gno_status gno_material_table_add(gno_material_table table, const char* name, float reflectance905,
                                  float reflectance1550, float roughness, float retro, float transmission) {
  return guard([&] {
    Locked(table)->rows.push_back(
        {&the(name, "name"), reflectance905, reflectance1550, roughness, retro, transmission});
  });
}

gno_status gno_material_table_destroy(gno_material_table table) {
  return guard([&] { destroy(table); });
}

}  // extern "C"

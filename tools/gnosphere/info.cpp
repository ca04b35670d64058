// SPDX-License-Identifier: Apache-2.0
// gnosphere info: tells what a scene holds, and what its file says that is left out.
#include <algorithm>
#include <cstdio>
#include <memory>

#include "base/json_text.hpp"
#include "commands.hpp"
#include "console.hpp"
#include "geometry/dropped_triangles.hpp"
#include "json.hpp"
#include "scanning.hpp"
#include "scene/bounds.hpp"

namespace gnosphere::cli {
namespace {

struct InfoOptions : ScanningOptions {
  bool json = false;
};

std::string nameOf(const Mesh& mesh, size_t index) {
  return mesh.name.empty() ? "mesh " + std::to_string(index) : mesh.name;
}

/// The number of nodes that a clip moves.
size_t movedNodes(const Clip& clip) {
  std::vector<uint32_t> nodes;
  for (const Track& track : clip.tracks) nodes.push_back(track.node);
  std::sort(nodes.begin(), nodes.end());
  return static_cast<size_t>(std::unique(nodes.begin(), nodes.end()) - nodes.begin());
}

/// The class of an instance or a material: its number, or else its name; null for none.
template <typename Item>
Json classOf(const Item& item) {
  if (item.classId != 0) return item.classId;
  return item.className.empty() ? Json() : Json(item.className);
}

Json boundsJson(const Bounds& bounds) {
  return bounds.empty() ? Json() : Json({{"min", listOf(bounds.min)}, {"max", listOf(bounds.max)}});
}

Json materialJson(const Material& material) {
  constexpr const char* kAlphaModes[] = {"opaque", "mask", "blend"};  // in the order of AlphaMode
  return {{"name", material.name},
          {"class", classOf(material)},
          {"base_color", material.baseColor},
          {"metallic", material.metallic},
          {"roughness", material.roughness},
          {"transmission", material.transmission},
          {"alpha_mode", kAlphaModes[static_cast<size_t>(material.alphaMode)]},
          {"alpha_cutoff", material.alphaCutoff},
          {"double_sided", material.doubleSided},
          {"retro", material.retro}};
}

Json infoJson(const InfoOptions& options, const Scene& scene, const DroppedTriangles& dropped) {
  Json json = {{"scene", options.scene},
               {"triangles", scene.placedTriangleCount()},
               {"unique_triangles", scene.uniqueTriangleCount()},
               {"non_finite", dropped.nonFinite},
               {"degenerate", dropped.degenerate},
               {"meshes", scene.meshes.size()},
               {"instances", scene.instances.size()},
               {"materials", scene.materials.size()}};
  json["bounds"] = boundsJson(worldBounds(scene));
  json["mesh_list"] = Json::array();
  for (size_t i = 0; i < scene.meshes.size(); ++i)
    json["mesh_list"].push_back({{"name", nameOf(scene.meshes[i], i)},
                                 {"vertices", scene.meshes[i].vertexCount()},
                                 {"triangles", scene.meshes[i].triangleCount()}});
  json["deformable_meshes"] = Json::array();
  for (size_t i = 0; i < scene.meshes.size(); ++i) {
    const Mesh& mesh = scene.meshes[i];
    if (!mesh.deformable()) continue;
    json["deformable_meshes"].push_back({{"name", nameOf(mesh, i)},
                                         {"vertices", mesh.vertexCount()},
                                         {"joints", mesh.jointCount},
                                         {"joints_per_vertex", mesh.influences},
                                         {"morph_targets", mesh.morphTargets.size()}});
  }
  json["instance_list"] = Json::array();
  const std::vector<Bounds> boxes = instanceBounds(scene);
  for (size_t i = 0; i < scene.instances.size(); ++i) {
    const Instance& instance = scene.instances[i];
    json["instance_list"].push_back({{"name", instance.name},
                                     {"class", classOf(instance)},
                                     {"mesh", nameOf(scene.meshes[instance.mesh], instance.mesh)},
                                     {"bounds", boundsJson(boxes[i])}});
  }
  json["material_list"] = Json::array();
  for (const Material& material : scene.materials) json["material_list"].push_back(materialJson(material));
  json["animations"] = Json::array();
  for (const Clip& clip : scene.animation.clips)
    json["animations"].push_back({{"name", clip.name}, {"duration", clip.duration}, {"nodes", movedNodes(clip)}});
  json["left_out"] = scene.leftOut;
  return json;
}

void print(const InfoOptions& options, const Scene& scene, const DroppedTriangles& dropped) {
  say("scene", options.scene + ": " + counted(scene.placedTriangleCount(), "triangle", "triangles") + " of " +
                   counted(scene.meshes.size(), "mesh", "meshes") + " in " +
                   counted(scene.instances.size(), "instance", "instances") + ", " +
                   counted(scene.materials.size(), "material", "materials"));
  const Bounds bounds = worldBounds(scene);
  if (!bounds.empty())
    say("bounds", formatted("%.3f %.3f %.3f to %.3f %.3f %.3f m", bounds.min.x, bounds.min.y, bounds.min.z,
                            bounds.max.x, bounds.max.y, bounds.max.z));
  if (dropped.degenerate > 0)
    say("degenerate", counted(dropped.degenerate, "triangle", "triangles") + " with equal corners");
  for (const std::string& line : scene.leftOut) say("left out", line);
  std::vector<TableRow> meshes = {{"deformable mesh", "vertices", "joints", "per vertex", "morph targets"}};
  for (size_t i = 0; i < scene.meshes.size(); ++i) {
    const Mesh& mesh = scene.meshes[i];
    if (mesh.deformable())
      meshes.push_back({nameOf(mesh, i), grouped(mesh.vertexCount()), grouped(mesh.jointCount),
                        grouped(mesh.influences), grouped(mesh.morphTargets.size())});
  }
  std::vector<TableRow> clips = {{"animation", "number", "seconds", "nodes"}};
  for (const Clip& clip : scene.animation.clips)
    clips.push_back(
        {clip.name, std::to_string(clips.size() - 1), formatted("%.3f", clip.duration), grouped(movedNodes(clip))});
  for (const auto& table : {meshes, clips}) {
    if (table.size() == 1) continue;
    std::printf("\n");
    printTable(table);
  }
}

int runInfo(const InfoOptions& options) {
  checkScanning(options);
  const Scene scene = loadSceneAtRest(options);
  const DroppedTriangles dropped = droppedTriangles(scene);
  if (dropped.nonFinite > 0) complain("warning: " + droppedText(dropped.nonFinite, options.scene));
  if (scene.placedTriangleCount() == 0)
    complain("warning: " + options.scene + " has no triangle, so every beam misses");
  if (options.json)
    std::printf("%s", dump(infoJson(options, scene, dropped)).c_str());
  else
    print(options, scene, dropped);
  return 0;
}

}  // namespace

Action addInfo(CLI::App& app) {
  const auto options = std::make_shared<InfoOptions>();
  addSceneOptions(app, *options);
  app.add_flag("--json", options->json, "Print JSON");
  app.footer("Example: gnosphere info person.glb");
  return [options] { return runInfo(*options); };
}

}  // namespace gnosphere::cli

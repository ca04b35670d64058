// SPDX-License-Identifier: Apache-2.0
// gnosphere info: tells what a scene holds, and what its file says that is left out.
#include <algorithm>
#include <memory>

#include "base/json_text.hpp"
#include "commands.hpp"
#include "console.hpp"
#include "json.hpp"
#include "scanning.hpp"

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

Json infoJson(const InfoOptions& options, const Scene& scene) {
  const Bounds bounds = worldBounds(scene);
  Json json = {{"scene", options.scene},
               {"triangles", scene.placedTriangleCount()},
               {"unique_triangles", scene.uniqueTriangleCount()},
               {"meshes", scene.meshes.size()},
               {"instances", scene.instances.size()},
               {"materials", scene.materials.size()}};
  json["bounds"] = bounds.empty() ? Json() : Json({{"min", listOf(bounds.min)}, {"max", listOf(bounds.max)}});
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
  for (const Instance& instance : scene.instances)
    json["instance_list"].push_back({{"name", instance.name},
                                     {"class", classOf(instance)},
                                     {"mesh", nameOf(scene.meshes[instance.mesh], instance.mesh)}});
  json["material_list"] = Json::array();
  for (const Material& material : scene.materials)
    json["material_list"].push_back({{"name", material.name}, {"class", classOf(material)}});
  json["animations"] = Json::array();
  for (const Clip& clip : scene.animation.clips)
    json["animations"].push_back({{"name", clip.name}, {"duration", clip.duration}, {"nodes", movedNodes(clip)}});
  json["left_out"] = scene.leftOut;
  return json;
}

void print(const InfoOptions& options, const Scene& scene) {
  say("scene", options.scene + ": " + counted(scene.placedTriangleCount(), "triangle", "triangles") + " of " +
                   counted(scene.meshes.size(), "mesh", "meshes") + " in " +
                   counted(scene.instances.size(), "instance", "instances") + ", " +
                   counted(scene.materials.size(), "material", "materials"));
  const Bounds bounds = worldBounds(scene);
  if (!bounds.empty())
    say("bounds", formatted("%.3f %.3f %.3f to %.3f %.3f %.3f m", bounds.min.x, bounds.min.y, bounds.min.z,
                            bounds.max.x, bounds.max.y, bounds.max.z));
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
  if (options.json)
    std::printf("%s", dump(infoJson(options, scene)).c_str());
  else
    print(options, scene);
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

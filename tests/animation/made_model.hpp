// SPDX-License-Identifier: Apache-2.0
// Small animated glTF files, made by the tests, and where their vertices are.
#pragma once

#include <array>
#include <vector>

#include "gnosphere/animation.hpp"
#include "scene/scene_text.hpp"

namespace gnosphere::test {

/// A file with the triangle (0,0,0) (1,0,0) (0,1,0) at node 0, and one animation without channels.
inline GltfFileMaker animatedFile() {
  GltfFileMaker file = triangleFile();
  file.json["animations"] = {{{"name", "clip"}, {"channels", Json::array()}, {"samplers", Json::array()}}};
  return file;
}

/// Adds a channel to the animation. The values are per key; those of weights are scalars.
template <typename T>
void addChannel(GltfFileMaker& file, int node, const char* path, const char* interpolation, const Floats& times,
                const std::vector<T>& values, const Json& accessor = Json::object()) {
  const bool isRotation = path == std::string("rotation"), isScalar = path == std::string("weights");
  Json& animation = file.json["animations"][0];
  const int input = file.accessor(times, "SCALAR");
  const int output = file.accessor(values, isScalar ? "SCALAR" : isRotation ? "VEC4" : "VEC3", accessor);
  animation["samplers"].push_back({{"input", input}, {"output", output}, {"interpolation", interpolation}});
  animation["channels"].push_back(
      {{"sampler", animation["samplers"].size() - 1}, {"target", {{"node", node}, {"path", path}}}});
}

/// A skinned strip: node 0 places vertices (0,0,0) (0,1,0) (1,0,0) (1,1,0) (2,0,0) (2,1,0) that follow joint 0 at the
/// origin (node 1), both joints by halves, and joint 1 at (1,0,0) (node 2, child of node 1). Node 0 is far away, which
/// must not matter.
inline GltfFileMaker skinnedFile() {
  GltfFileMaker file;
  const int positions = file.accessor(Floats{0, 0, 0, 0, 1, 0, 1, 0, 0, 1, 1, 0, 2, 0, 0, 2, 1, 0}, "VEC3");
  const int joints = file.accessor(std::vector<uint8_t>{0, 9, 9, 9, 0, 0, 0, 0, 0, 1, 0, 0,  //
                                                        1, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0},
                                   "VEC4");
  // Stored with sums other than 1, and with a joint 9 that has no weight.
  const int weights = file.accessor(
      Floats{1, 0, 0, 0, 2, 0, 0, 0, 0.5f, 0.5f, 0, 0, 0.25f, 0.25f, 0, 0, 1, 0, 0, 0, 0, 3, 0, 0}, "VEC4");
  const int indices = file.accessor(std::vector<uint16_t>{0, 2, 1, 1, 2, 3, 2, 4, 3, 3, 4, 5}, "SCALAR");
  file.mesh(
      {{"attributes", {{"POSITION", positions}, {"JOINTS_0", joints}, {"WEIGHTS_0", weights}}}, {"indices", indices}});
  // The two matrices are column-major: the identity, and one that translates by -1 along x.
  const int binds = file.accessor(
      Floats{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -1, 0, 0, 1}, "MAT4");
  file.json["skins"] = {{{"joints", {1, 2}}, {"inverseBindMatrices", binds}}};
  file.node({{"name", "strip"}, {"mesh", 0}, {"skin", 0}, {"translation", {100, 200, 300}}});
  file.node({{"name", "hip"}, {"children", {2}}});
  file.node({{"name", "knee"}, {"translation", {1, 0, 0}}});
  file.json["animations"] = {{{"name", "clip"}, {"channels", Json::array()}, {"samplers", Json::array()}}};
  return file;
}

using Points = std::vector<std::array<double, 3>>;

/// The vertices of an instance in the world.
inline Points vertices(const Scene& scene, const SceneState& state, size_t instance = 0) {
  const uint32_t number = scene.instances.at(instance).mesh;
  const Mesh& mesh = scene.meshes.at(number);
  const Floats p = deformedPositions(mesh, state.deformations.at(number));
  Points points;
  for (size_t v = 0; v < mesh.vertexCount(); ++v)
    points.push_back(at(state.transforms.at(instance), mesh.origin.x + p[3 * v], mesh.origin.y + p[3 * v + 1],
                        mesh.origin.z + p[3 * v + 2]));
  return points;
}

/// The vertices at a time of the first clip.
inline Points vertices(const Scene& scene, double time, ClipEnd end = ClipEnd::loop, size_t instance = 0) {
  return vertices(scene, stateAt(scene, scene.animation.clips.at(0), time, end), instance);
}

}  // namespace gnosphere::test

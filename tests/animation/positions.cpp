// SPDX-License-Identifier: Apache-2.0
// animated_positions FILE CLIP TIME...: prints the corners of all triangles of the scene at times of a clip (by its
// number; -1: at rest), as the simulator gets them. Per time, per instance: the number of corners as 64-bit integer,
// then x, y, z of each in the world as doubles. check_models compares them with its own reading of the file.
#include <cstdio>
#include <cstdlib>

#include "gnosphere/gnosphere.hpp"

using namespace gnosphere;

namespace {

void print(const Scene& scene, const SceneState& state) {
  for (size_t i = 0; i < scene.instances.size(); ++i) {
    const uint32_t number = scene.instances[i].mesh;
    const Mesh& mesh = scene.meshes[number];
    const std::vector<float> positions = deformedPositions(mesh, state.deformations[number]);
    const uint64_t count = mesh.indices.size();
    std::fwrite(&count, sizeof count, 1, stdout);
    for (const size_t v : mesh.indices) {
      const Vec3 p = state.transforms[i] * Vec3{mesh.origin.x + positions[3 * v], mesh.origin.y + positions[3 * v + 1],
                                                mesh.origin.z + positions[3 * v + 2]};
      std::fwrite(&p, sizeof p, 1, stdout);
    }
  }
}

/// The state as loaded, without any call of stateAt().
SceneState loadedState(const Scene& scene) {
  SceneState state;
  for (const Instance& instance : scene.instances) state.transforms.push_back(instance.transform);
  for (const Mesh& mesh : scene.meshes) state.deformations.push_back(mesh.deformation);
  return state;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 4) return std::fprintf(stderr, "usage: animated_positions FILE CLIP TIME...\n"), 2;
  try {
    const Scene scene = loadScene(argv[1]);
    validate(scene);
    const int clip = std::atoi(argv[2]);
    for (int i = 3; i < argc; ++i)
      print(scene, clip < 0 ? loadedState(scene)
                            : stateAt(scene, scene.animation.clips.at(static_cast<size_t>(clip)), std::atof(argv[i])));
  } catch (const std::exception& error) {
    return std::fprintf(stderr, "%s\n", error.what()), 1;
  }
  return 0;
}

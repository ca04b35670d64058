// SPDX-License-Identifier: Apache-2.0
#include "animation/panels.hpp"

#include <cmath>

#include "animation/made_model.hpp"

namespace gnosphere::test {

std::string panels() {
  GltfFileMaker file;
  file.json["materials"] = {{{"doubleSided", true}}};
  const int positions = file.accessor(Floats{0, 1, 0, 0, 4, 0, 0, 1, 3, 0, 4, 3}, "VEC3");
  const int offsets = file.accessor(Floats{1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0}, "VEC3");
  const int indices = file.accessor(std::vector<uint16_t>{0, 1, 2, 2, 1, 3}, "SCALAR");
  Json primitive = {{"attributes", {{"POSITION", positions}}}, {"indices", indices}, {"material", 0}};
  file.mesh(primitive);
  primitive["targets"] = {{{"POSITION", offsets}}};
  file.mesh(primitive);
  file.node({{"name", "soft"}, {"mesh", 1}});
  file.node({{"name", "rigid"}, {"mesh", 0}, {"translation", {0, -5, 0}}});
  file.json["animations"] = {{{"name", "push"}, {"channels", Json::array()}, {"samplers", Json::array()}}};
  addChannel(file, 0, "weights", "LINEAR", {0, 1}, Floats{0, 1});
  addChannel(file, 1, "translation", "LINEAR", {0, 1}, Floats{0, -5, 0, 1, -5, 0});
  return file.text();
}

std::string rotor(bool skinned) {
  GltfFileMaker file;
  file.json["materials"] = {{{"doubleSided", true}}};
  const int positions = file.accessor(Floats{-0.2f, 0, 0, 0.2f, 0, 0, 0, 0, 0.02f}, "VEC3");
  const int indices = file.accessor(std::vector<uint16_t>{0, 1, 2}, "SCALAR");
  Json primitive = {{"attributes", {{"POSITION", positions}}}, {"indices", indices}, {"material", 0}};
  if (skinned) {
    primitive["attributes"]["JOINTS_0"] = file.accessor(std::vector<uint8_t>(12), "VEC4");
    primitive["attributes"]["WEIGHTS_0"] = file.accessor(Floats{1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4");
    file.json["skins"] = {{{"joints", {0}}}};
  }
  file.mesh(primitive);
  file.node(skinned ? Json{{"name", "hub"}} : Json{{"name", "rotor"}, {"mesh", 0}});
  if (skinned) file.node({{"name", "rotor"}, {"mesh", 0}, {"skin", 0}});
  file.json["animations"] = {{{"name", "spin"}, {"channels", Json::array()}, {"samplers", Json::array()}}};
  const float half = std::sqrt(0.5f);
  addChannel(file, 0, "rotation", "LINEAR", {0, 0.0025f, 0.005f, 0.0075f, 0.01f},  // a hundred turns a second
             Floats{0, 0, 0, 1, 0, half, 0, half, 0, 1, 0, 0, 0, half, 0, -half, 0, 0, 0, -1});
  return file.text();
}

std::string movedCube(const char* path, const std::vector<float>& times, const std::vector<float>& values) {
  GltfFileMaker file;
  Floats corners;
  for (int i = 0; i < 8; ++i)
    corners.insert(corners.end(), {i & 1 ? 0.5f : -0.5f, i & 2 ? 0.5f : -0.5f, i & 4 ? 0.5f : -0.5f});
  const int positions = file.accessor(corners, "VEC3");
  const int indices = file.accessor(std::vector<uint16_t>{0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                                          2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5},
                                    "SCALAR");
  file.mesh({{"attributes", {{"POSITION", positions}}}, {"indices", indices}});
  file.node({{"name", "cube"}, {"mesh", 0}});
  file.json["animations"] = {{{"name", "move"}, {"channels", Json::array()}, {"samplers", Json::array()}}};
  addChannel(file, 0, path, "LINEAR", times, values);
  return file.text();
}

}  // namespace gnosphere::test

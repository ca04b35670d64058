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

std::string rotor() {
  GltfFileMaker file;
  file.json["materials"] = {{{"doubleSided", true}}};
  const int positions = file.accessor(Floats{-0.2f, 0, 0, 0.2f, 0, 0, 0, 0, 0.02f}, "VEC3");
  const int indices = file.accessor(std::vector<uint16_t>{0, 1, 2}, "SCALAR");
  file.mesh({{"attributes", {{"POSITION", positions}}}, {"indices", indices}, {"material", 0}});
  file.node({{"name", "rotor"}, {"mesh", 0}});
  file.json["animations"] = {{{"name", "spin"}, {"channels", Json::array()}, {"samplers", Json::array()}}};
  const float half = std::sqrt(0.5f);
  addChannel(file, 0, "rotation", "LINEAR", {0, 0.0025f, 0.005f, 0.0075f, 0.01f},  // a hundred turns a second
             Floats{0, 0, 0, 1, 0, half, 0, half, 0, 1, 0, 0, 0, half, 0, -half, 0, 0, 0, -1});
  return file.text();
}

}  // namespace gnosphere::test

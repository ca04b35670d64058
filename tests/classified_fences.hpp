// SPDX-License-Identifier: Apache-2.0
// A scene whose materials and instances state classes, and the class that each of its points must have.
#pragma once

#include <algorithm>
#include <array>
#include <map>

#include "support.hpp"

namespace gnosphere::test {

// The classes that the materials state, and the material of each board: 1 m wide, along y from -6 m on.
inline constexpr std::array<uint16_t, 3> kStated = {5, 0, 65535};
inline constexpr std::array<uint32_t, 12> kBoards = {0, 1, 1, 2, 0, 0, 1, 2, 2, 0, 1, 0};

/// Two fences of such boards, one above the other, 5 m ahead (classes 9 and none); 5 m behind one more, whose boards
/// are in the reverse order (class 11), above a wall of a mesh without stated classes (class 7).
inline Scene classifiedFences() {
  Scene scene;
  for (const uint16_t classId : kStated) scene.materials.emplace_back().classId = classId;
  const auto fence = [](const auto& boards) {
    MeshBuilder builder;
    for (size_t i = 0; i < boards.size(); ++i) builder.quad({0, double(i) - 6, 0}, {0, 1, 0}, {0, 0, 3});
    Mesh mesh = builder.take();
    mesh.parts.clear();
    for (uint32_t i = 0; i < boards.size(); ++i) mesh.parts.push_back({2 * i, 2, boards[i]});
    return mesh;
  };
  MeshBuilder wall;
  wall.quad({0, -6, 0}, {0, 12, 0}, {0, 0, 3});
  scene.meshes = {fence(kBoards), wall.take(1), fence(std::array<uint32_t, 12>{0, 1, 0, 2, 2, 1, 0, 0, 2, 1, 1, 0})};
  scene.instances = {{"", 0, translation(5, 0, 0), 9},
                     {"", 0, translation(5, 0, -3)},
                     {"", 2, translation(-5, 0, 0), 11},
                     {"", 1, translation(-5, 0, -3), 7}};
  return scene;
}

/// Many beams onto all of it.
inline Sensor fenceSensor() {
  return gridSensor(720, 8, -20, 20);
}

/// Checks the class of one point of the fences and counts it; points on the edges of the boards are left out.
inline void checkClass(double x, double y, double z, uint16_t found, std::map<int, int>& counts) {
  const double board = std::floor(y + 6);
  if (std::min({y + 6 - board, board + 1 - (y + 6), std::abs(z)}) < 1e-3) return;
  const auto number = static_cast<size_t>(board);
  const uint16_t stated = x < 0 && z < 0 ? 0 : kStated[kBoards.at(x < 0 ? 11 - number : number)];
  const int instance = x < 0 ? (z < 0 ? 7 : 11) : z < 0 ? 0 : 9;
  INFO(x << ' ' << y << ' ' << z);
  CHECK(found == (stated != 0 ? stated : instance));
  ++counts[found];
}

/// Checks that every class occurs among the points.
inline void checkCounts(const std::map<int, int>& counts) {
  CHECK(counts.size() == 6);
  for (const auto& [classId, count] : counts) {
    INFO("class " << classId);
    CHECK(count > 30);
  }
}

}  // namespace gnosphere::test

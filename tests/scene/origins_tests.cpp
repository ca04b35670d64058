// SPDX-License-Identifier: Apache-2.0
// Files far from their origin: where each corner is, against the decimal numbers of the file in double.
#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>

#include "scene/coarse_positions.hpp"
#include "scene_text.hpp"

namespace gnosphere::test {
namespace {

using Corners = std::vector<std::array<double, 3>>;

const Corners kWall = {{499995.017, 5500010.123, 0},
                       {500005.017, 5500010.123, 0},
                       {500005.017, 5500010.123, 6.001},
                       {499995.017, 5500010.123, 6.001}};

std::string verticesOf(const Corners& corners, const char* word = "v ") {
  std::ostringstream text;
  text << std::setprecision(17);
  for (const auto& corner : corners) text << word << corner[0] << ' ' << corner[1] << ' ' << corner[2] << '\n';
  return text.str();
}

/// How far any corner of a scene's instance is from the place that the file states, in the file's units.
double worstOf(const Scene& scene, size_t instance, const Corners& stated, const LoadOptions& options = kAsStored) {
  const Instance& placed = scene.instances.at(instance);
  const Mesh& mesh = scene.meshes.at(placed.mesh);
  double worst = 0;
  for (const uint32_t vertex : mesh.indices) {
    const float* p = &mesh.positions[3 * vertex];
    const auto place = at(placed.transform, mesh.origin.x + p[0], mesh.origin.y + p[1], mesh.origin.z + p[2]);
    double nearest = 1e9;
    for (const auto& corner : stated) {
      double off = 0;
      for (size_t c = 0; c < 3; ++c) off = std::max(off, std::abs(place[c] / options.scale - corner[c]));
      nearest = std::min(nearest, off);
    }
    worst = std::max(worst, nearest);
  }
  return worst;
}

std::string plyOf(const Corners& corners, const std::string& type, const std::string& faces) {
  std::string text = "ply\nformat ascii 1.0\nelement vertex " + std::to_string(corners.size()) + '\n';
  for (const char axis : {'x', 'y', 'z'}) text += "property " + type + ' ' + axis + '\n';
  text += "element face " + std::to_string(std::count(faces.begin(), faces.end(), '\n'));
  return text + "\nproperty list uchar int vertex_indices\nend_header\n" + verticesOf(corners, "") + faces;
}

/// The warning about the positions of a file of this name and content; empty if there is none.
std::string warningOf(const std::string& name, const std::string& content, double scale = 1) {
  const Folder folder;
  const auto file = put(folder / name, content);
  return coarsePositions(file, loadScene(file, {UpAxis::z, scale}));
}

}  // namespace

TEST_CASE("a vertex that no face uses moves no georeferenced wall") {
  Corners corners = kWall;
  corners.push_back({0, 0, 0});
  const std::string wall = verticesOf(corners) + "f 1 2 3 4\n", ply = plyOf(corners, "double", "4 0 1 2 3\n");
  CHECK(worstOf(loadText("a.obj", wall), 0, kWall) < 1e-6);
  CHECK(worstOf(loadText("a.ply", ply), 0, kWall) < 1e-6);
  CHECK(warningOf("a.obj", wall) == "");
  CHECK(warningOf("a.ply", ply) == "");
}

TEST_CASE("a coordinate that is no place moves no georeferenced wall") {
  for (const char* far : {"nan", "inf", "1e13"}) {
    Scene scene = loadText("a.obj", verticesOf(kWall) + "v " + far + " 0 0\nf 1 2 3 4\nf 1 2 5\n");
    scene.meshes.at(0).indices.resize(6);
    CHECK(worstOf(scene, 0, kWall) < 1e-5);
  }
}

TEST_CASE("OBJ objects that are far apart have origins of their own, and neighbours the same ones") {
  const std::string marker = "o marker\nv 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nf 1 2 3\n";
  Corners next = kWall;
  for (auto& corner : next) corner[0] += 10;
  const std::string walls = "o wall\n" + verticesOf(kWall) + "f 4 5 6 7\no next\n" + verticesOf(next) + "f 8 9 10 11\n";
  for (const double scale : {1.0, 0.3048}) {
    const LoadOptions options = {UpAxis::z, scale};
    const Scene scene = loadText("a.obj", marker + walls, options);
    REQUIRE(scene.instances.size() == 3);
    CHECK(worstOf(scene, 0, {{0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0}}, options) < 1e-4);
    CHECK(worstOf(scene, 1, kWall, options) < 1e-4);
    CHECK(worstOf(scene, 2, next, options) < 1e-4);
    CHECK(scene.meshes[1].origin.x == scene.meshes[2].origin.x);
    CHECK(scene.meshes[1].origin.y == scene.meshes[2].origin.y);
  }
  CHECK(warningOf("a.obj", marker + walls) == "");
}

TEST_CASE("OBJ objects within millimetres have the origin of the file, in the length of its unit") {
  const std::string text =
      "o a\nv -20000.1 0 0\nv -20001.1 0 0\nv -20000.1 1 0\nf 1 2 3\no b\nv 20000.1 0 0\nv 20001.1 0 0\nv 20000.1 1 0\n"
      "f 4 5 6\n";
  const auto origin = [&](double scale, size_t mesh) {
    return loadText("a.obj", text, {UpAxis::z, scale}).meshes.at(mesh).origin.x;
  };
  CHECK(origin(1, 0) == -20480);
  CHECK(origin(1, 1) == 20480);
  CHECK(origin(0.001, 0) == 0);
  CHECK(origin(0.001, 1) == 0);
}

TEST_CASE("a mesh that is so wide that its positions have steps is warned of, in every format") {
  const std::string advice =
      " m from its origin; split it into objects of an OBJ file, of which each gets an origin of its own";
  Corners corners = kWall;
  corners.insert(corners.end(), {{0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0}});
  const std::string doubles =
      "a mesh is so wide that its positions are in single precision, which has steps of 0.25 m at 2750005" + advice;
  CHECK(warningOf("a.obj", verticesOf(corners) + "f 1 2 3 4\nf 5 6 7\n") == doubles);
  CHECK(warningOf("a.ply", plyOf(corners, "double", "4 0 1 2 3\n3 4 5 6\n")) == doubles);
  const std::string floats =
      "a mesh is so wide that its positions are in single precision, which has steps of 0.5 m at 5500010" + advice;
  CHECK(warningOf("a.ply", plyOf(corners, "float", "4 0 1 2 3\n3 4 5 6\n")) == floats);
  std::string stl = "solid\n";
  for (const size_t first : {0, 4})
    stl += "facet normal 0 0 1\nouter loop\n" + verticesOf({&corners[first], &corners[first] + 3}, "vertex ") +
           "endloop\nendfacet\n";
  CHECK(warningOf("a.stl", stl + "endsolid\n") == floats);
  CHECK_THAT(warningOf("a.obj", verticesOf(corners) + "f 1 2 3 4\nf 5 6 7\n", 0.01),
             ContainsSubstring("steps of 0.0025 m at 27500 m"));
  CHECK(warningOf("a.obj", verticesOf(corners) + "f 1 2 3 4\nf 5 6 7\n", 0.001) == "");
  // Words of a header may be apart, and its lines may end with carriage returns.
  std::string spaced = plyOf(corners, "double", "4 0 1 2 3\n3 4 5 6\n"), returned = spaced;
  spaced.replace(spaced.find("property double x"), 17, "property  double\t x");
  CHECK(warningOf("a.ply", spaced) == doubles);
  std::ranges::replace(returned, '\n', '\r');
  CHECK(warningOf("a.ply", returned) == doubles);
  // Floats hold these doubles exactly, so nothing is lost.
  CHECK(warningOf("a.obj", "v 0 0 0\nv 40000.5 0 0\nv 0 40000.25 0\nf 1 2 3\n") == "");
}

}  // namespace gnosphere::test

// SPDX-License-Identifier: Apache-2.0
// Readers of OBJ, PLY and STL.
#include <algorithm>
#include <bit>
#include <catch2/catch_approx.hpp>
#include <cctype>
#include <cmath>
#include <limits>
#include <sstream>

#include "base/utf8.hpp"
#include "cpu_time.hpp"
#include "gnosphere/effects.hpp"
#include "scene_text.hpp"

using namespace gnosphere;
using namespace gnosphere::test;
using Catch::Approx;

namespace {

const char* const kSquareObj = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

/// The only material of a library.
Material materialOf(const std::string& lines) {
  const Folder folder;
  put(folder / "m.mtl", "newmtl a\n" + lines);
  return loadScene(put(folder / "a.obj", "mtllib m.mtl\n" + std::string(kSquareObj) + "usemtl a\nf 1 2 3\n"))
      .materials.at(0);
}

/// Area in the x y plane. Without signs, triangles outside the outline increase the sum.
double area(const Mesh& mesh, bool withSign = false) {
  double sum = 0;
  for (size_t t = 0; t < mesh.indices.size(); t += 3) {
    const auto x = [&](size_t k) { return mesh.positions[3 * mesh.indices[t + k]]; };
    const auto y = [&](size_t k) { return mesh.positions[3 * mesh.indices[t + k] + 1]; };
    const double twice = (x(1) - x(0)) * (y(2) - y(0)) - (y(1) - y(0)) * (x(2) - x(0));
    sum += 0.5 * (withSign ? twice : std::abs(twice));
  }
  return sum;
}

std::string plyHeader(const std::string& format, const std::string& type, const std::string& index, size_t vertices = 4,
                      size_t faces = 1) {
  return "ply\nformat " + format + " 1.0\ncomment made by hand\nelement vertex " + std::to_string(vertices) +
         "\nproperty " + type + " x\nproperty " + type + " y\nproperty " + type + " z\nelement face " +
         std::to_string(faces) + "\nproperty list uchar " + index + " vertex_indices\nend_header\n";
}

template <typename T>
std::string swapped(T value) {
  std::string bytes = bytesOf(std::vector<T>{value});
  std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

std::string stlTriangle(const Floats& corners) {
  return bytesOf(Floats{0, 0, 1}) + bytesOf(corners) + std::string(2, '\0');
}

}  // namespace

TEST_CASE("OBJ faces are read with normals, texture coordinates and negative indices, double-sided and z-up") {
  const Scene scene =
      loadText("a.obj", std::string(kSquareObj) + "vn 0 0 1\nvt 0 0\nf 1/1/1 2//1 3/1\nf -4 -2 -1\n", {});
  CHECK(scene.meshes.at(0).indices == Indices{0, 1, 2, 0, 2, 3});
  CHECK(scene.meshes.at(0).positions == Floats{0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0});
  CHECK(scene.materials.at(0).doubleSided);
  CHECK(at(scene.instances.at(0).transform, 1, 2, 3) == std::array<double, 3>{1, 2, 3});
  validate(scene);
}

TEST_CASE("OBJ can be y-up and in millimetres") {
  const Scene scene = loadText("a.OBJ", std::string(kSquareObj) + "f 1 2 3\n", {UpAxis::y, 0.001});
  const auto p = at(scene.instances.at(0).transform, 1000, 2000, 3000);
  CHECK(p[0] == Approx(1));
  CHECK(p[1] == Approx(-3));
  CHECK(p[2] == Approx(2));
}

TEST_CASE("triangulation keeps the area of polygons, also of concave ones") {
  const Scene quad = loadText("a.obj", std::string(kSquareObj) + "f 1 2 3 4\n");
  CHECK(quad.meshes.at(0).indices == Indices{0, 1, 2, 0, 2, 3});
  const Scene dart = loadText("a.obj", "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 3 1 0\nv 0 4 0\nf 1 2 3 4 5\n");
  CHECK(dart.uniqueTriangleCount() == 3);
  CHECK(area(dart.meshes.at(0)) == Approx(10));
  const Scene turned = loadText("a.obj", "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 3 1 0\nv 0 4 0\nf 5 4 3 2 1\n");
  CHECK(area(turned.meshes.at(0)) == Approx(10));
  CHECK(area(turned.meshes.at(0), true) == Approx(-10));  // clockwise polygons stay clockwise
  const Scene comb = loadText("a.obj",
                              "v 0 0 0\nv 7 0 0\nv 7 5 0\nv 6 1 0\nv 5 5 0\nv 4 1 0\nv 3 5 0\nv 2 1 0\nv 1 5 0\n"
                              "f 1 2 3 4 5 6 7 8 9\n");
  CHECK(comb.uniqueTriangleCount() == 7);
  CHECK(area(comb.meshes.at(0)) == Approx(area(comb.meshes.at(0), true)));
  CHECK(area(comb.meshes.at(0)) == Approx(20.5));
  std::ostringstream vertices, face;
  for (int i = 0; i < 400; ++i) {  // more corners than fit a byte
    vertices << "v " << std::cos(i * 0.015707963) << " " << std::sin(i * 0.015707963) << " 0\n";
    face << " " << i + 1;
  }
  CHECK(loadText("a.obj", vertices.str() + "f" + face.str() + "\n").uniqueTriangleCount() == 398);
}

TEST_CASE("concave polygons of many thousand corners are cut along their outline, in little time") {
  constexpr int kCorners = 20000;
  const auto radius = [](int i) { return 100 + 0.01 * (i * 7919 % 101) + 20 * (i % 2); };
  std::ostringstream vertices, rows, face, list;
  vertices << std::fixed;
  double twice = 0;  // by the sum of the triangles to the centre
  for (int i = 0; i < kCorners; ++i) {
    const double angle = 2 * 3.14159265358979 * i / kCorners;
    rows << radius(i) * std::cos(angle) << ' ' << radius(i) * std::sin(angle) << " 0\n";
    vertices << "v " << radius(i) * std::cos(angle) << ' ' << radius(i) * std::sin(angle) << " 0\n";
    face << ' ' << i + 1;
    list << ' ' << i;
    twice += radius(i) * radius((i + 1) % kCorners) * std::sin(2 * 3.14159265358979 / kCorners);
  }
  Scene obj, ply;
  CHECK(cpuSeconds([&] { obj = loadText("a.obj", vertices.str() + "f" + face.str() + "\n"); }) < 5);
  std::string header = plyHeader("ascii", "double", "int", kCorners);
  header.replace(header.find("list uchar"), 10, "list int");
  ply = loadText("a.ply", header + rows.str() + std::to_string(kCorners) + list.str() + "\n");
  for (const Scene& scene : {obj, ply}) {
    CHECK(scene.leftOut.empty());
    CHECK(scene.uniqueTriangleCount() == kCorners - 2);
    CHECK(area(scene.meshes.at(0)) == Approx(twice / 2).epsilon(1e-4));
    CHECK(area(scene.meshes.at(0), true) == Approx(twice / 2).epsilon(1e-4));
  }
}

TEST_CASE("faces that cross themselves are told as left out") {
  const std::vector<std::string> told = {
      "2 outlines of faces that cross themselves or take too long to cut; a fan of triangles stands for each"};
  const std::string corners = "0 0 0\n1 1 1\n1 0 1\n0 1 0\n0 5 0\n";
  CHECK(loadText("a.ply", plyHeader("ascii", "float", "int", 5, 3) + corners + "4 0 1 2 3\n4 0 2 1 3\n5 0 1 2 3 4\n")
            .leftOut == told);
  // Its two triangles cancel each other, so it has no normal, and lies across the axis that is taken first.
  CHECK(loadText("a.obj", "v 0 0 0\nv 1 1 0\nv 1 0 0\nv 0 1 0\nf 1 2 3 4\n").leftOut ==
        std::vector<std::string>{"1" + told[0].substr(1)});
  std::ostringstream vertices, face;
  for (int i = 0; i < 5000; ++i) {
    vertices << "v " << i * 7919 % 5003 << ' ' << i * 104729 % 5009 << " 0\n";
    face << ' ' << i + 1;
  }
  CHECK(cpuSeconds([&] {
          CHECK(loadText("a.obj", vertices.str() + "f" + face.str() + "\n").leftOut ==
                std::vector<std::string>{"1" + told[0].substr(1)});
        }) < 2);
}

TEST_CASE("OBJ materials come from the library beside the file, and parts are runs of one material") {
  const Folder folder;
  put(folder / "m.mtl",
      "newmtl red\nKd 1 0.5 0\nPr 0.25\nPm 0.75\nTf 1 1 1\nillum 2\n\nnewmtl glass\nd 0.25\nTf 0.5 0.5 0.5\nillum 4\n");
  const Scene scene = loadScene(
      put(folder / "a.obj",
          std::string("mtllib m.mtl\n") + kSquareObj +
              "f 1 2 3\nusemtl glass \nf 2 3 4\nusemtl red\nf 1 2 4\nusemtl glass\nf 1 3 4\nusemtl lost\nf 1 2 3\n"));
  REQUIRE(scene.materials.size() == 4);
  CHECK(scene.materials[0].name == "red");
  CHECK(scene.materials[0].baseColor == std::array<float, 4>{1, 0.5f, 0, 1});
  CHECK(scene.materials[0].roughness == 0.25f);
  CHECK(scene.materials[0].metallic == 0.75f);
  CHECK(scene.materials[0].transmission == 0);  // Tf is ignored for materials that are not glass
  CHECK(scene.materials[0].alphaMode == AlphaMode::opaque);
  CHECK(scene.materials[1].name == "glass");
  CHECK(scene.materials[1].alphaMode == AlphaMode::opaque);
  CHECK(scene.materials[1].baseColor[3] == 1);
  CHECK(scene.materials[1].transmission == 0.5f);
  CHECK(scene.materials[2].name == "lost");
  CHECK(scene.materials[3].name.empty());
  const Mesh& mesh = scene.meshes.at(0);
  CHECK(mesh.indices == Indices{0, 1, 3, 1, 2, 3, 0, 2, 3, 0, 1, 2, 0, 1, 2});
  REQUIRE(mesh.parts.size() == 4);
  CHECK(mesh.parts[1].firstTriangle == 1);
  CHECK(mesh.parts[1].triangleCount == 2);
  CHECK(mesh.parts[1].material == 1);
  validate(scene);
}

TEST_CASE(
    "OBJ: several libraries in a line, names with spaces, a mark of UTF-8, one value for a colour, Latin-1 names") {
  const Folder folder;
  put(folder / "a.mtl", "\xEF\xBB\xBFnewmtl first\nKd 0.3\n");
  put(folder / "b.mtl", "newmtl second\nKd 0.1 0.2 0.3\nd -halo 0.4\n");
  put(folder / "my scene.mtl", "newmtl gr\xFCn\nKd 0 1 0\n");
  const Scene scene =
      loadScene(put(folder / "a.obj", "mtllib a.mtl b.mtl\nmtllib my scene.mtl\n" + std::string(kSquareObj) +
                                          "usemtl first\nf 1 2 3\nusemtl second\nf 1 3 4\n"
                                          "usemtl gr\xFCn\nf 2 3 4\nusemtl none\nf 2 3 1\n"));
  REQUIRE(scene.materials.size() == 4);
  CHECK(scene.materials[0].baseColor == std::array<float, 4>{0.3f, 0.3f, 0.3f, 1});
  CHECK(scene.materials[1].baseColor == std::array<float, 4>{0.1f, 0.2f, 0.3f, 0.4f});
  CHECK(scene.materials[2].name == "gr\xC3\xBCn");
  CHECK(scene.materials[2].baseColor[1] == 1);
  CHECK(scene.leftOut == std::vector<std::string>{"the properties of material 'none', which no library defines"});
  const Scene several =
      loadScene(put(folder / "c.obj", "mtllib a.mtl\n" + std::string(kSquareObj) +
                                          "usemtl x\nf 1 2 3\nusemtl y\nf 1 2 3\nusemtl z\nf 1 2 3\n"));
  CHECK(several.leftOut ==
        std::vector<std::string>{"the properties of material 'x' and 2 more, which no library defines"});
  const Scene some =
      loadScene(put(folder / "b.obj", "mtllib a.mtl gone.mtl\n" + std::string(kSquareObj) + "f 1 2 3\n"));
  CHECK(some.leftOut == std::vector<std::string>{"the materials of 'gone.mtl', which cannot be read"});
}

TEST_CASE("messages are in UTF-8, whatever bytes a file has") {
  CHECK_THAT(loadFailure("l.obj", "v 0 0 \xFC\n"), ContainsSubstring("has '?' where a coordinate"));
  std::string accents = "a";
  for (int i = 0; i < 40; ++i) accents += "\xC3\xA9";
  const std::string message = loadFailure("u.obj", "v 0 0 " + accents + "\n");
  CHECK(toUtf8(message) == message);
  CHECK_THAT(message, ContainsSubstring("\xC3\xA9…'"));
  CHECK(toUtf8("\xC0\xAF\xED\xA0\x80\xF4\x90\x80\x80") != "\xC0\xAF\xED\xA0\x80\xF4\x90\x80\x80");
  CHECK(toUtf8("\xE2\x82\xAC \xF0\x9F\x98\x80 \xE9") == "\xE2\x82\xAC \xF0\x9F\x98\x80 \xC3\xA9");
}

TEST_CASE("an MTL material is glass in the illumination models 4, 6, 7 and 9, and rough by its Blinn-Phong exponent") {
  const Folder folder;
  std::string library, uses = "mtllib m.mtl\n";
  uses += kSquareObj;
  for (int model = 0; model <= 10; ++model) {
    const std::string name = "m" + std::to_string(model);
    library += "newmtl " + name + "\nTf 0.5 0.5 0.5\nNs 6\nillum " + std::to_string(model) + "\n";
    uses += "usemtl " + name + "\nf 1 2 3\n";
  }
  put(folder / "m.mtl", library);
  const Scene scene = loadScene(put(folder / "a.obj", uses));
  REQUIRE(scene.materials.size() == 11);
  for (size_t model = 0; model <= 10; ++model) {
    INFO("illum " << model);
    const bool isGlass = model == 4 || model == 6 || model == 7 || model == 9;
    CHECK(scene.materials[model].transmission == (isGlass ? 0.5f : 0));
    CHECK(scene.materials[model].roughness == 0.5f);  // the root of 2 / (6 + 2)
  }
}

TEST_CASE("a dissolve of MTL lets through what it leaves, once, unless a filter of glass says it") {
  for (const std::string stated : {"d 0.25\n", "Tr 0.75\n"})
    for (int model = 0; model <= 10; ++model) {
      CAPTURE(stated, model);
      const Optics optics = opticsOf(materialOf("Kd 0.8 0.8 0.8\n" + stated + "illum " + std::to_string(model) + "\n"));
      CHECK(optics.transmission == 0.75f);
      CHECK(optics.reflectance == 0.8f * 0.25f);
    }
  for (const int model : {4, 6, 7, 9}) {
    CAPTURE(model);
    const std::string glass = "Kd 0.8 0.8 0.8\nTf 0.25 0.5 0.75\nillum " + std::to_string(model) + "\n";
    for (const std::string dissolve : {"", "d 1\n", "d 0.5\n"}) {
      const Optics optics = opticsOf(materialOf(glass + dissolve));
      CHECK(optics.transmission == 0.5f);
      CHECK(optics.reflectance == 0.8f * 0.5f);
    }
  }
  CHECK(opticsOf(materialOf("Tf 0.25 0.5 0.75\nd 0.75\nillum 2\n")).transmission == 0.25f);
}

TEST_CASE("an MTL material may be as smooth as a mirror") {
  CHECK(materialOf("Ns 6\nPr 0\n").roughness == 0);
  CHECK(materialOf("Pr 0.01\nNs 6\n").roughness == 0.01f);
  CHECK(materialOf("Ns 6\n").roughness == 0.5f);
  CHECK(materialOf("Pr 0\n\nnewmtl b\nNs 6\n").roughness == 0);
  CHECK(materialOf("").roughness == static_cast<float>(std::sqrt(2 / 3.0)));
}

TEST_CASE("the first of the materials of a name counts, and a library may have none or be named twice") {
  const Folder folder;
  put(folder / "none.mtl", "# nothing\nKd 1 0 0\n");
  put(folder / "a.mtl", "newmtl red\nKd 1 0 0\nmap_Kd red.png\nnewmtl red\nKd 0 1 0\n");
  const Scene scene = loadScene(put(
      folder / "a.obj", "mtllib none.mtl a.mtl\nmtllib ./a.mtl\n" + std::string(kSquareObj) + "usemtl red\nf 1 2 3\n"));
  REQUIRE(scene.materials.size() == 1);
  CHECK(scene.materials[0].baseColor == std::array<float, 4>{1, 0, 0, 1});
  REQUIRE(scene.leftOut.size() == 1);
  CHECK(scene.leftOut[0].starts_with("1 "));  // a texture
}

TEST_CASE("lines and points of OBJ are told as left out") {
  const Scene scene = loadText("a.obj", std::string(kSquareObj) + "l 1 2 3\n l 1 2\np 4\nf 1 2 3\n#l 1 2\n");
  CHECK(scene.uniqueTriangleCount() == 1);
  CHECK(scene.leftOut == std::vector<std::string>{"3 sets of lines or points, which have no area"});
}

TEST_CASE("textures of MTL and colours of the vertices of OBJ are told as left out") {
  const Folder folder;
  put(folder / "m.mtl", "newmtl brick\nmap_Kd -clamp on brick.png\nnewmtl fence\nmap_Kd fence.png\nmap_d fence.png\n");
  const std::string square(kSquareObj), faces = "usemtl brick\nf 1 2 3\nusemtl fence\nf 1 3 4\n";
  const std::vector<std::string> told = {"1 materials' alpha of textures; only glTF's alpha mode MASK makes holes",
                                         "2 materials' colours of textures; the base colours alone count"};
  CHECK(loadScene(put(folder / "a.obj", "mtllib m.mtl\n" + square + faces)).leftOut == told);
  CHECK(loadText("a.obj", "v 0 0 0 1 0 0\nv 1 0 0 1 0 0\nv 0 1 0 1 0 0\nf 1 2 3\n").leftOut ==
        std::vector<std::string>{"1 sets of vertex colours"});
  CHECK(loadText("a.obj", "v 0 0 0 1\nv 1 0 0 1\nv 0 1 0 1\nf 1 2 3\n").leftOut.empty());  // weights
}

TEST_CASE("without its material library an OBJ keeps the material names") {
  const Scene scene = loadText("a.obj", std::string("mtllib gone.mtl\nusemtl brick\n") + kSquareObj + "f 1 2 3\n");
  REQUIRE(scene.materials.size() == 1);
  CHECK(scene.materials[0].name == "brick");
}

TEST_CASE("georeferenced coordinates keep their millimetres by an origin") {
  const Scene scene = loadText("a.obj",
                               "v 843216.123 5206123.456 170.25\nv 843218.123 5206123.456 170.25\n"
                               "v 843216.123 5206125.456 170.25\nf 1 2 3\n");
  const Mesh& mesh = scene.meshes.at(0);
  CHECK(mesh.origin.x == 843217);
  CHECK(mesh.origin.y == 5206124);
  CHECK(mesh.origin.z == 170);
  CHECK(std::abs(mesh.origin.y + mesh.positions[1] - 5206123.456) < 1e-7);
  // The origin is 0 if floats represent every coordinate exactly.
  CHECK(loadText("a.obj", "v 1000000 0.5 0\nv 1000001 0 0\nv 0 0 1\nf 1 2 3\n").meshes.at(0).origin.x == 0);
}

TEST_CASE("each OBJ object is an instance with its name, and objects that touch have the same positions") {
  const Scene scene = loadText(
      "a.obj",
      "v 450000.1 0 0\nv 450001.1 0 0\nv 450001.1 1 0\nv 450000.1 1 0\nv 450002.1 0.3 0\n"
      "o tree\nusemtl bark\nf 1 2 3\no empty\no house\nf 2 5 3\no tree\nusemtl leaf\nf 1 3 4\nusemtl bark\nf 1 2 4\n");
  REQUIRE(scene.instances.size() == 3);
  REQUIRE(scene.meshes.size() == 3);
  CHECK(scene.instances[0].name == "tree");
  CHECK(scene.instances[1].name == "house");
  CHECK(scene.instances[2].name == "tree");  // an object of its own
  CHECK(scene.meshes[0].triangleCount() == 1);
  CHECK(scene.meshes[2].triangleCount() == 2);
  CHECK(scene.meshes[2].parts.size() == 2);
  CHECK(scene.meshes[1].triangleCount() == 1);
  CHECK(scene.meshes[1].vertexCount() == 3);
  CHECK(scene.meshes[0].origin.x == scene.meshes[1].origin.x);
  // Vertices 2 and 3 are of both.
  const auto corner = [&](size_t mesh, size_t i) {
    return &scene.meshes[mesh].positions[3 * scene.meshes[mesh].indices[i]];
  };
  CHECK(std::equal(corner(0, 1), corner(0, 1) + 3, corner(1, 0)));
  CHECK(std::equal(corner(0, 2), corner(0, 2) + 3, corner(1, 2)));
  const Scene one = loadText("a.obj", std::string(kSquareObj) + "o square\nf 1 2 3\n");
  REQUIRE(one.instances.size() == 1);
  CHECK(one.instances[0].name == "square");
}

TEST_CASE("OBJ lines may go on after a backslash") {
  for (const std::string end : {"\\\n", "\\\r\n"}) {
    const Scene scene = loadText("a.obj", std::string(kSquareObj) + "f 1 2" + end + "3 4\nv 1" + end + "2 3\n");
    CHECK(scene.meshes[0].triangleCount() == 2);
    CHECK(scene.meshes[0].vertexCount() == 5);
  }
  const Scene scene =
      loadText("a.obj", "# C:\\models\\\n" + std::string(kSquareObj) + "f 1 2 3\n # more \\\no b\nf 1 3 4\n");
  CHECK(scene.instances.size() == 2);
}

TEST_CASE("OBJ comments may follow vertices and faces") {
  for (const std::string end : {"\n", "\r\n", "\r"}) {
    const Scene scene =
        loadText("a.obj", "v 0 0 0 # three words more" + end + "v 1 0 0" + end + "v 1 1 0#" + end + "v 0 1 0" + end +
                              "# f 1 2 3" + end + "o part #7" + end + "f 1 2 3 # 4" + end + " f 1 3 4 #4");
    REQUIRE(scene.meshes.size() == 1);
    CHECK(scene.meshes[0].indices == Indices{0, 1, 2, 0, 2, 3});
    CHECK(scene.instances[0].name == "part #7");
    CHECK(scene.leftOut.empty());
  }
  CHECK(loadText("a.obj", std::string(kSquareObj) + "f 1 2 \\\n3 # f\n").uniqueTriangleCount() == 1);
  CHECK(materialOf("Kd 0.5 # 0 0\n").baseColor == std::array<float, 4>{0.5f, 0.5f, 0.5f, 1});
}

TEST_CASE("OBJ files with many backslashes, libraries, or objects and materials take no time that grows by squares") {
  std::string slashes = std::string(kSquareObj) + "f 1 2 3\n# ", libraries = kSquareObj, objects = kSquareObj;
  for (int i = 0; i < 200000; ++i) slashes += "\\ ";
  slashes += std::string(200000, '#');
  for (int i = 0; i < 70000; ++i) libraries += "mtllib m" + std::to_string(i) + '\n';
  for (int i = 0; i < 60000; ++i) objects += "o " + std::to_string(i) + "\nusemtl " + std::to_string(i) + "\nf 1 2 3\n";
  CHECK(cpuSeconds([&] { loadText("a.obj", slashes + "\\\nf 1 3 4\n"); }) < 2);
  CHECK(cpuSeconds([&] { loadText("a.obj", libraries + "f 1 2 3\n"); }) < 2);
  CHECK(cpuSeconds([&] { loadText("a.obj", objects); }) < 2);
}

TEST_CASE("OBJ keeps nan and infinity") {
  const Mesh mesh = loadText("a.obj", "v nan 0 0\nv -inf 0 0\nv 1e30 0 0\nv 1e999 0.1 0\nf 1 2 3\n").meshes.at(0);
  CHECK(std::isnan(mesh.positions[0]));
  CHECK(mesh.positions[3] == -std::numeric_limits<float>::infinity());
  CHECK(mesh.positions[6] == 1e30f);
  CHECK(mesh.positions[9] == std::numeric_limits<float>::infinity());
}

TEST_CASE("invalid OBJ is an error, and one without faces is a scene without triangles") {
  CHECK_THAT(loadFailure("a.obj", ""), ContainsSubstring("a.obj': the file is empty"));
  CHECK_THAT(loadFailure("a.obj", std::string("\xFF\xFEv\0 \0", 6)),
             ContainsSubstring("is text in UTF-16; save it as UTF-8"));
  CHECK_THAT(loadFailure("a.gltf", std::string("\xFF\xFE{\0}\0", 6)),
             ContainsSubstring("a.gltf': is text in UTF-16; save it as UTF-8"));
  CHECK_THAT(loadFailure("a.obj", std::string("v 0 0 0\0\n", 9)), ContainsSubstring("it holds binary data"));
  CHECK_THAT(loadFailure("a.obj", "v 0 0\n"), ContainsSubstring("vertex 1 of the OBJ file has ''"));
  CHECK_THAT(loadFailure("a.obj", "v 0 0 x\n"), ContainsSubstring("vertex 1 of the OBJ file has 'x'"));
  CHECK_THAT(loadFailure("a.obj", "v 0 0 0\nf 1 1 2\n"),
             ContainsSubstring("face 1 of the OBJ file: index 2 is out of range, there are 1 vertices"));
  CHECK_THAT(loadFailure("a.obj", "v 0 0 0\nf 0 1 1\n"), ContainsSubstring("index 0 is out of range"));
  CHECK_THAT(loadFailure("a.obj", "v 0 0 0\nf -2 1 1\n"), ContainsSubstring("index -2 is out of range"));
  CHECK(loadText("a.obj", "v 0 0 0\nl 1 1\n# nothing\n").uniqueTriangleCount() == 0);
}

TEST_CASE("PLY is read as text and as binary of either byte order, with any types") {
  const Floats square = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
  const Indices cut = {0, 1, 2, 0, 2, 3};
  const Scene text =
      loadText("a.ply", plyHeader("ascii", "float", "int") + "0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n", {});
  CHECK(text.meshes.at(0).positions == square);
  CHECK(text.meshes.at(0).indices == cut);
  CHECK(text.materials.at(0).doubleSided);
  CHECK(at(text.instances.at(0).transform, 1, 2, 3) == std::array<double, 3>{1, 2, 3});

  const std::string corners16 = bytesOf(std::vector<uint16_t>{0, 1, 2, 3});
  const Scene little =
      loadText("a.ply", plyHeader("binary_little_endian", "float", "ushort") + bytesOf(square) + "\4" + corners16);
  CHECK(little.meshes.at(0).positions == square);
  CHECK(little.meshes.at(0).indices == cut);

  std::string body;
  for (float value : square) body += swapped(static_cast<double>(value));
  body += "\4";
  for (uint32_t corner : {0u, 1u, 2u, 3u}) body += swapped(corner);
  const Scene big = loadText("a.ply", plyHeader("binary_big_endian", "double", "uint") + body);
  CHECK(big.meshes.at(0).positions == square);
  CHECK(big.meshes.at(0).indices == cut);
  body.clear();
  for (float value : square) body += swapped(static_cast<int16_t>(value));
  body += "\4";
  for (const int corner : {0, 1, 2, 3}) body += swapped(static_cast<uint16_t>(corner));
  const Scene shorts = loadText("a.ply", plyHeader("binary_big_endian", "short", "ushort") + body);
  CHECK(shorts.meshes.at(0).positions == square);
  CHECK(shorts.meshes.at(0).indices == cut);

  const Scene integers = loadText("a.ply", plyHeader("ascii", "int", "uchar", 3) + "0 0 0\n5 0 0\n0 7 0\n3 0 1 2\n");
  CHECK(integers.meshes.at(0).positions == Floats{0, 0, 0, 5, 0, 0, 0, 7, 0});
}

TEST_CASE("PLY skips unknown properties and elements, in any order") {
  const Scene scene = loadText("a.ply",
                               "ply\r\nformat ascii 1.0\r\nobj_info x\r\nelement face 1\r\nproperty uchar "
                               "red\r\nproperty list uchar int vertex_index\r\n"
                               "element extra 2\r\nproperty list uchar float junk\r\nelement vertex 3\r\nproperty "
                               "float nx\r\nproperty float x\r\n"
                               "property float y\r\nproperty float z\r\nend_header\r\n7 3 0 1 2\r\n2 5 6\r\n0\r\n9 0 0 "
                               "0\r\n9 1 0 0\r\n9 0 nan 0 8 8\r\n");
  CHECK(scene.meshes.at(0).indices == Indices{0, 1, 2});
  CHECK(scene.meshes.at(0).positions[3] == 1);
  CHECK(std::isnan(scene.meshes.at(0).positions[7]));
}

TEST_CASE("colours of PLY are told as left out") {
  const std::string plain = plyHeader("ascii", "float", "int", 3), body = "0 0 0\n1 0 0\n1 1 0\n3 0 1 2\n";
  CHECK(loadText("a.ply", plain + body).leftOut.empty());
  std::string coloured = plain;
  coloured.insert(coloured.find("element face"), "property uchar red\n");
  const Scene scene = loadText("a.ply", coloured + "0 0 0 9\n1 0 0 9\n1 1 0 9\n3 0 1 2\n");
  CHECK(scene.uniqueTriangleCount() == 1);
  CHECK(scene.leftOut == std::vector<std::string>{"1 sets of vertex colours"});
  std::string faces = plain;
  faces.insert(faces.find("end_header"), "property uchar diffuse_red\n");
  CHECK(loadText("a.ply", faces + "0 0 0\n1 0 0\n1 1 0\n3 0 1 2 9\n").leftOut ==
        std::vector<std::string>{"1 sets of colours of faces"});
}

TEST_CASE("properties of the faces of PLY are told as left out") {
  std::string header = plyHeader("ascii", "float", "int", 3);
  header.insert(header.find("end_header"), "property int label\nproperty list uchar float texcoord\n");
  const Scene scene = loadText("a.ply", header + "0 0 0\n1 0 0\n1 1 0\n3 0 1 2 9 0\n");
  CHECK(scene.uniqueTriangleCount() == 1);
  CHECK(scene.leftOut ==
        std::vector<std::string>{"1 properties of faces: 'label'", "1 properties of faces: 'texcoord'"});
}

TEST_CASE("faces of two corners are no triangles, and elements of PLY may have no properties") {
  std::string header = plyHeader("ascii", "float", "int", 3, 3);
  header.insert(header.find("element vertex"), "element nothing 5\n");
  const Scene scene = loadText("a.ply", header + "0 0 0\n1 0 0\n1 1 0\n2 0 1\n3 0 1 2\n0\n");
  CHECK(scene.meshes.at(0).indices == Indices{0, 1, 2});
  validate(scene);
}

TEST_CASE("PLY of points is a scene without triangles") {
  const Scene scene = loadText("a.ply",
                               "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty "
                               "float z\nend_header\n1 2 3\n");
  CHECK(scene.uniqueTriangleCount() == 0);
  validate(scene);
}

TEST_CASE("invalid PLY is an error") {
  const std::string body = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
  CHECK_THAT(loadFailure("a.ply", "plx\n"), ContainsSubstring("its first line is not 'ply'"));
  CHECK_THAT(loadFailure("a.ply", "ply\nformat ascii 1.0\n"), ContainsSubstring("cut off in its header"));
  CHECK_THAT(loadFailure("a.ply", "ply\nend_header\n"), ContainsSubstring("names no format"));
  CHECK_THAT(loadFailure("a.ply", plyHeader("ascii", "real", "int")), ContainsSubstring("unknown type 'real'"));
  CHECK_THAT(loadFailure("a.ply", plyHeader("ascii", "float", "int", 4'000'000'000u) + body),
             ContainsSubstring("claims more items of 'vertex' than the file has bytes"));
  CHECK_THAT(loadFailure("a.ply", plyHeader("ascii", "float", "int") + body),
             ContainsSubstring("cut off in its faces"));
  CHECK_THAT(loadFailure("a.ply", plyHeader("ascii", "float", "int") + body + "4 0 1 2 4\n"),
             ContainsSubstring("face 0 of the PLY file: index 4 is out of range, there are 4 vertices"));
  CHECK_THAT(loadFailure("a.ply", plyHeader("ascii", "float", "int") + body + "4 0 1 2 -1\n"),
             ContainsSubstring("face 0 of the PLY file has a corner that is not a vertex index"));
  CHECK_THAT(loadFailure("a.ply", plyHeader("ascii", "float", "int") + body + "200 0 1 2\n"),
             ContainsSubstring("a list longer than the file"));
  CHECK_THAT(loadFailure("a.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n"),
             ContainsSubstring("have no y"));
  CHECK_THAT(loadFailure("a.ply", "ply\nformat ascii 1.0\nelement face 1\nproperty int label\nend_header\n1\n"),
             ContainsSubstring("the faces of the PLY file have no list vertex_indices"));
  CHECK_THAT(loadFailure("a.ply", plyHeader("ascii", "float", "int") + "0 0 0\n1 0 0\n"),
             ContainsSubstring("cut off in its vertices"));
  CHECK_THAT(loadFailure("a.ply", plyHeader("binary_little_endian", "float", "int") + std::string(47, '\0')),
             ContainsSubstring("cut off in its vertices"));
  CHECK_THAT(loadFailure("a.ply", plyHeader("ascii", "float", "int") + "0 0 0\n1 a 0\n"),
             ContainsSubstring("the PLY file has 'a' where its vertices need a number"));
  const auto header = [](const std::string& lines, const char* format = "ascii") {
    return loadFailure("a.ply", std::string("ply\nformat ") + format + " 1.0\n" + lines + "end_header\n1 2 3\n");
  };
  CHECK_THAT(header("", "utf8"), ContainsSubstring("the PLY format 'utf8' does not exist"));
  CHECK_THAT(header("element tristrips 1\nproperty list int int vertex_indices\n"),
             ContainsSubstring("it holds triangle strips; convert it to faces"));
  for (const char* count : {"x", "-1", "1.5", "nan"})
    CHECK_THAT(header(std::string("element vertex ") + count + "\n"),
               ContainsSubstring("the PLY header gives no valid count for element 'vertex'"));
  CHECK_THAT(header("property float x\n"), ContainsSubstring("a property before the first element"));
  CHECK_THAT(header("element face 1\nproperty list float int vertex_indices\n"),
             ContainsSubstring("a list whose count is no integer"));
}

TEST_CASE("PLY is read with a mark of UTF-8, and with lines that end with carriage returns") {
  const std::string properties =
      "element vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n"
      "property list uchar int vertex_indices\nend_header\n";
  const std::string text = "ply\nformat ascii 1.0\n" + properties + "0 0 0 9\n1 0 0 9\n0 1 0 9\n3 0 1 2 9\n";
  const Floats positions = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  CHECK(loadText("a.ply", "\xEF\xBB\xBF" + text).meshes.at(0).positions == positions);
  const auto withLineEnds = [](const std::string& from, const std::string& lineEnd) {
    std::string to;
    for (const char c : from) to += c == '\n' ? lineEnd : std::string(1, c);
    return to;
  };
  CHECK(loadText("a.ply", withLineEnds(text, "\r")).meshes.at(0).positions == positions);
  CHECK(loadText("a.ply", withLineEnds(text, "\r\n")).meshes.at(0).positions == positions);

  // A binary file whose header has carriage returns may have the byte of a line feed as the first byte of its data.
  std::string binary = withLineEnds("ply\nformat binary_little_endian 1.0\n" + properties, "\r");
  const Floats corners = {std::bit_cast<float>(0x3F00000Au), 0, 0, 1, 0, 0, 0, 1, 0};
  binary.append(reinterpret_cast<const char*>(corners.data()), corners.size() * sizeof(float));
  binary += '\3';
  for (const char corner : {'\0', '\1', '\2'}) binary.append({corner, 0, 0, 0});
  CHECK(loadText("a.ply", binary).meshes.at(0).positions == corners);
}

TEST_CASE("STL corners with the same bits become one vertex, in text and in binary") {
  const std::string text =
      "solid facet of vertex\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   vertex 1 0 0\n   vertex 0 1.5e0 "
      "0\n  endloop\n endfacet\n"
      "facet normal 0 0 1\nouter loop\nvertex 0 1.5 0\nvertex 1 0 0\nvertex 1 1 0\nendloop\nendfacet\nendsolid facet\n";
  const Floats positions = {0, 0, 0, 1, 0, 0, 0, 1.5f, 0, 1, 1, 0};
  const Scene scene = loadText("a.stl", text);
  CHECK(scene.meshes.at(0).positions == positions);
  CHECK(scene.meshes.at(0).indices == Indices{0, 1, 2, 2, 1, 3});
  // The header of a binary file may begin like a text file.
  std::string binary = "solid" + std::string(75, ' ') + bytesOf(Indices{2}) +
                       stlTriangle({0, 0, 0, 1, 0, 0, 0, 1.5f, 0}) + stlTriangle({0, 1.5f, 0, 1, 0, 0, 1, 1, 0});
  CHECK(loadText("a.stl", binary).meshes.at(0).positions == positions);
  CHECK(loadText("a.stl", binary).meshes.at(0).indices == Indices{0, 1, 2, 2, 1, 3});
  CHECK(loadText("a.stl", binary + "more").meshes.at(0).indices == Indices{0, 1, 2, 2, 1, 3});
}

TEST_CASE("text STL is read in capitals and with a mark of UTF-8") {
  const std::string text =
      "solid Part\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1.5e0 0\nendloop\nendfacet\n"
      "endsolid Part\n";
  const Floats positions = {0, 0, 0, 1, 0, 0, 0, 1.5f, 0};
  std::string capitals = text;
  for (char& c : capitals) c = static_cast<char>(std::toupper(c));
  for (const std::string& each : {capitals, "\xEF\xBB\xBF" + text, "\xEF\xBB\xBF" + capitals}) {
    INFO(each);
    CHECK(loadText("a.stl", each).meshes.at(0).positions == positions);
    CHECK_THAT(loadFailure("a.stl", each.substr(0, each.size() - 14)), ContainsSubstring("it has no endsolid"));
  }
}

TEST_CASE("the coordinates of text STL are single precision, as those of binary STL") {
  const auto facet = [](const char* corner) {
    return std::string("facet normal 0 0 1\nouter loop\nvertex ") + corner +
           "\nvertex 0 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
  };
  const Mesh mesh =
      loadText("a.stl", "solid\n" + facet("1000000.1 0 0") + facet("1000000.12 0 0") + "endsolid\n").meshes.at(0);
  CHECK(mesh.positions == Floats{1000000.125f, 0, 0, 0, 0, 0, 0, 1, 0});
  CHECK(mesh.indices == Indices{0, 1, 2, 0, 1, 2});
  CHECK(mesh.origin.x == 0);
}

TEST_CASE("each solid of a text STL is an instance with its name, and has an end") {
  const std::string facet =
                        "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n",
                    solid = "solid\n" + facet, end = "endsolid\n";
  const Scene scene =
      loadText("a.stl", "solid wall of solid 1\r\n" + facet + facet + "endsolid wall of solid 1\r\nsolid empty\n" +
                            end + "SOLID  roof \n" + facet + end + solid + end);
  REQUIRE(scene.instances.size() == 3);
  REQUIRE(scene.meshes.size() == 3);
  const std::vector<std::string> names = {"wall of solid 1", "roof", ""};
  for (size_t i = 0; i < 3; ++i) {
    CHECK(scene.instances[i].name == names[i]);
    CHECK(scene.instances[i].mesh == i);
    CHECK(scene.meshes[i].positions == Floats{0, 0, 0, 1, 0, 0, 0, 1, 0});
    CHECK(scene.meshes[i].triangleCount() == (i == 0 ? 2 : 1));
  }
  CHECK(loadText("a.stl", "solid\n" + end).instances.size() == 1);
  CHECK(loadText("a.stl", solid + end + facet).uniqueTriangleCount() == 2);
  CHECK_THAT(loadFailure("a.stl", solid + end + solid), ContainsSubstring("it has no endsolid"));
  const std::string cut = facet.substr(0, facet.find("vertex 0 1"));
  CHECK_THAT(loadFailure("a.stl", "solid\n" + cut + end + "solid\nvertex 0 1 0\nendfacet\n" + end),
             ContainsSubstring("facet 0 of the STL file has not 3 vertices"));
}

TEST_CASE("an STL corner that is nan is not merged with others") {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const Scene scene =
      loadText("a.stl", std::string(80, ' ') + bytesOf(Indices{2}) + stlTriangle({0, 0, 0, 1, 0, 0, 0, 1, 0}) +
                            stlTriangle({nan, 0, 0, 0, 0, 0, nan, 0, 0}));
  CHECK(scene.meshes.at(0).indices == Indices{0, 1, 2, 3, 0, 3});
  CHECK(std::isnan(scene.meshes.at(0).positions[9]));
}

TEST_CASE("invalid STL is an error") {
  const std::string binary = std::string(80, 'x') + bytesOf(Indices{2}) + stlTriangle({0, 0, 0, 1, 0, 0, 0, 1, 0});
  CHECK_THAT(loadFailure("a.stl", binary), ContainsSubstring("its header claims 2 triangles, it has room for 1"));
  CHECK_THAT(loadFailure("a.stl", "hello"),
             ContainsSubstring("it is not STL: it is too short and does not begin with 'solid'"));
  CHECK_THAT(loadFailure("a.stl", "solid\nvertex 1 2 3\nvertex 1 2 3\nvertex 1 2 3\nvertex 1 2 3\nendsolid\n"),
             ContainsSubstring("facet 0 of the STL file has more than 3 vertices"));
  CHECK_THAT(loadFailure("a.stl", "solid\nfacet\nvertex 1 2 3\n"), ContainsSubstring("it has no endsolid"));
  CHECK_THAT(loadFailure("a.stl", "solid\nvertex 1 2 z\n"), ContainsSubstring("triangle 0 of the STL file has 'z'"));
  CHECK_THAT(loadFailure("a.stl", "solid\nvertex 1 2 3\nendfacet\nendsolid\n"),
             ContainsSubstring("has not 3 vertices"));
}

// SPDX-License-Identifier: Apache-2.0
// Loading and writing scenes; each format has its own tests in scene/.
#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <random>
#include <utility>
#ifndef _WIN32
#include <sys/stat.h>
#endif

#include "bits.hpp"
#include "fuzz/readers.hpp"
#include "problem.hpp"
#include "scene/scene_text.hpp"

using namespace gnosphere;
using namespace gnosphere::test;

namespace {

/// A scene with two meshes, three instances, four parts, an origin, and numbers that are not exact in binary.
Scene sampleScene() {
  Scene scene;
  scene.materials = {{"red", {1, 0.1f, 0.2f, 1}, 0.3f, 0.7f, 0, AlphaMode::opaque},
                     {"glass", {1, 1, 1, 0.25f}, 0, 0.1f, 0.9f, AlphaMode::blend, 0.5f, kNoImage, 0, false},
                     {"leaf", {0, 1, 0, 1}, 0, 1, 0, AlphaMode::mask, 0.3f}};
  Mesh square;
  square.name = "square \"1\"";
  square.positions = {0, 0, 0, 1.1f, 0, 0, 0, 1.3f, 1e-20f, 1, 1, 1e30f};
  square.indices = {0, 1, 2, 2, 1, 3, 3, 1, 0};
  square.parts = {{0, 1, 2}, {1, 1, 0}, {2, 1, 1}};
  Mesh far = square;
  far.name = "far";
  far.origin = {843217, 5206124, 170};
  far.parts = {{0, 3, 1}};
  scene.meshes = {square, far};
  scene.instances = {{"b", 1, {}},
                     {"a", 0, {{0.1, 0.2, 0.3, 1e6 + 0.1, 0.4, 0.5, 0.6, -7.7, 0.7, 0.8, -0.9, 1.0 / 3}}},
                     {"c", 0, {{-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}}}};
  scene.materials[1].classId = scene.instances[1].classId = 65535;
  scene.materials[2].className = scene.instances[2].className = "road";
  scene.materials[0].retro = 300.1f;
  scene.materials[2].retro = Material::kMostRetro;
  return scene;
}

}  // namespace

TEST_CASE("loadScene reads back the output of writeGlb bit for bit") {
  const Scene scene = sampleScene();
  const Folder folder;
  writeGlb(scene, folder / "a.glb");
  CHECK(folder.fileCount() == 1);
  const Scene read = loadScene(folder / "a.glb");
  REQUIRE(read.meshes.size() == 2);
  for (size_t m = 0; m < 2; ++m) {
    CHECK(read.meshes[m].name == scene.meshes[m].name);
    CHECK(read.meshes[m].positions == scene.meshes[m].positions);
    CHECK(read.meshes[m].indices == scene.meshes[m].indices);
    REQUIRE(read.meshes[m].parts.size() == scene.meshes[m].parts.size());
    for (size_t p = 0; p < read.meshes[m].parts.size(); ++p) {
      CHECK(read.meshes[m].parts[p].firstTriangle == scene.meshes[m].parts[p].firstTriangle);
      CHECK(read.meshes[m].parts[p].triangleCount == scene.meshes[m].parts[p].triangleCount);
      CHECK(read.meshes[m].parts[p].material == scene.meshes[m].parts[p].material);
    }
  }
  REQUIRE(read.instances.size() == 3);
  for (size_t i = 0; i < 3; ++i) {
    CHECK(read.instances[i].name == scene.instances[i].name);
    CHECK(read.instances[i].mesh == scene.instances[i].mesh);
    CHECK(read.instances[i].classId == scene.instances[i].classId);
    CHECK(read.instances[i].className == scene.instances[i].className);
  }
  CHECK(read.instances[1].transform.rows == scene.instances[1].transform.rows);
  CHECK(read.instances[2].transform.rows == scene.instances[2].transform.rows);
  // The origin becomes part of the transform, which is double, too.
  CHECK(at(read.instances[0].transform, 0, 0, 0) == std::array<double, 3>{843217, 5206124, 170});
  REQUIRE(read.materials.size() == 3);
  for (size_t m = 0; m < 3; ++m) {
    const Material &a = read.materials[m], &b = scene.materials[m];
    CHECK(a.name == b.name);
    CHECK(a.baseColor == b.baseColor);
    CHECK(a.metallic == b.metallic);
    CHECK(a.roughness == b.roughness);
    CHECK(a.transmission == b.transmission);
    CHECK(a.alphaMode == b.alphaMode);
    CHECK(a.alphaCutoff == b.alphaCutoff);
    CHECK(a.doubleSided == b.doubleSided);
    CHECK(a.classId == b.classId);
    CHECK(a.className == b.className);
    CHECK(a.retro == b.retro);
  }
}

TEST_CASE("a written file states what glTF requires of it: bounds of positions, targets of views, extensions") {
  const Folder folder;
  const auto jsonOf = [&](const Scene& scene) {
    writeGlb(scene, folder / "a.glb");
    std::ifstream file(folder / "a.glb", std::ios::binary);
    std::string bytes(std::istreambuf_iterator<char>(file), {});
    return Json::parse(bytes.begin() + 20, bytes.begin() + 20 + at<uint32_t>(bytes, 12));
  };
  Scene scene = sampleScene();
  scene.meshes[1].positions[5] = std::nanf("");
  for (size_t i = 1; i < 12; i += 3) scene.meshes[1].positions[i] = std::numeric_limits<float>::infinity();
  scene.meshes[0].uvs = Floats(8);
  scene.alphaImages = {{1, 1, {7}}};
  scene.materials[2].alphaImage = 0;
  const Json json = jsonOf(scene);
  const auto boundsOf = [&](size_t mesh) {
    const Json& primitive = json["meshes"][mesh]["primitives"][0];
    const Json& positions = json["accessors"][primitive["attributes"]["POSITION"].get<size_t>()];
    return std::pair(positions["min"].get<Floats>(), positions["max"].get<Floats>());
  };
  CHECK(boundsOf(0) == std::pair(Floats{0, 0, 0}, Floats{1.1f, 1.3f, 1e30f}));
  CHECK(boundsOf(1) == std::pair(Floats{0, 0, 0}, Floats{1.1f, 0, 1e30f}));  // of the finite ones, and 0 without any
  size_t targets[3] = {};
  for (const Json& view : json["bufferViews"]) {
    const int target = view.value("target", -1);
    ++targets[target == 34962 ? 0 : target == 34963 ? 1 : 2];
    if (target == -1) CHECK(view == json["bufferViews"][json["images"][0]["bufferView"].get<size_t>()]);
  }
  CHECK((targets[0] == 3 && targets[1] == 2 && targets[2] == 1));  // attributes, indices, the image
  CHECK(json["extensionsUsed"] == Json{"KHR_materials_transmission"});
  scene.materials[1].transmission = 0;
  CHECK_FALSE(jsonOf(scene).contains("extensionsUsed"));
  scene.meshes[0].parts = {{0, 0, 1}, {0, 3, 0}};
  CHECK(jsonOf(scene)["meshes"][0]["primitives"].size() == 1);  // glTF has no primitive without triangles
  for (Material& material : scene.materials) material.transmission = 0.5f;
  CHECK(jsonOf(scene)["extensionsUsed"] == Json{"KHR_materials_transmission"});
}

TEST_CASE("the holes of cut-out materials are kept by writing and reading") {
  Scene scene = sampleScene();
  scene.alphaImages = {{3, 1, {0, 128, 255}, AlphaImage::Wrap::clamp, AlphaImage::Wrap::mirror},
                       {1, 2, {7, 9}, AlphaImage::Wrap::repeat, AlphaImage::Wrap::clamp}};
  scene.materials[2].alphaImage = 1;
  scene.materials.push_back(scene.materials[2]);
  scene.materials[3].alphaImage = 0;
  for (Mesh& mesh : scene.meshes)
    for (size_t v = 0; v < mesh.vertexCount(); ++v)
      mesh.uvs.insert(mesh.uvs.end(), {0.1f * static_cast<float>(v), 1 - 0.3f * static_cast<float>(v)});
  scene.meshes[0].parts = {{0, 2, 2}, {2, 1, 0}};
  scene.meshes[1].parts = {{0, 3, 3}};
  const Folder folder;
  writeGlb(scene, folder / "a.glb");
  const Scene read = loadScene(folder / "a.glb");
  CHECK(read.unreadImages == 0);
  CHECK(read.leftOut.empty());
  REQUIRE(read.alphaImages.size() == 2);
  REQUIRE(read.materials.size() == 4);
  for (size_t m : {2, 3}) {
    REQUIRE(read.materials[m].alphaImage != kNoImage);
    const AlphaImage& a = scene.alphaImages[scene.materials[m].alphaImage];
    const AlphaImage& b = read.alphaImages[read.materials[m].alphaImage];
    CHECK((b.width == a.width && b.height == a.height));
    CHECK(b.alpha == a.alpha);
    CHECK((b.wrapU == a.wrapU && b.wrapV == a.wrapV));
  }
  const auto corners = [](const Mesh& mesh, uint32_t triangles) {
    Floats all;
    for (size_t i = 0; i < 3 * size_t{triangles}; ++i)
      for (size_t axis = 0; axis < 2; ++axis) all.push_back(mesh.uvs.at(2 * size_t{mesh.indices[i]} + axis));
    return all;
  };
  CHECK(corners(read.meshes[0], 2) == corners(scene.meshes[0], 2));
  CHECK(corners(read.meshes[1], 3) == corners(scene.meshes[1], 3));
  // The part without holes and the one with holes have the vertices that each uses, however often it is written.
  CHECK(read.meshes[0].vertexCount() == 4 + 3);
  writeGlb(read, folder / "b.glb");
  CHECK(loadScene(folder / "b.glb").meshes[0].vertexCount() == 4 + 3);
  CHECK_THAT(problemOf([&] { writeGlb(scene, folder / "b.obj"); }), ContainsSubstring("scenes are written as .glb"));
  CHECK(!std::filesystem::exists(folder / "b.obj"));
  scene.alphaImages[0] = {16385, 1, std::vector<uint8_t>(16385)};
  CHECK_THAT(problemOf([&] { writeGlb(scene, folder / "wide.glb"); }),
             ContainsSubstring("an alpha image has 16385 x 1 pixels; the limit of files is 16384 per side"));
}

TEST_CASE("empty scenes and empty meshes are kept by writing and reading") {
  const Folder folder;
  writeGlb({}, folder / "a.glb");
  CHECK(loadScene(folder / "a.glb").instances.empty());
  Scene scene = sampleScene();
  scene.meshes.insert(scene.meshes.begin(), Mesh{});
  for (Instance& instance : scene.instances) ++instance.mesh;
  scene.instances.insert(scene.instances.begin(), Instance{});
  writeGlb(scene, folder / "a.glb");
  const Scene read = loadScene(folder / "a.glb");
  CHECK(read.leftOut.empty());
  CHECK(read.meshes.size() == 3);
  CHECK(read.instances.size() == 4);
  CHECK(read.placedTriangleCount() == scene.placedTriangleCount());
}

TEST_CASE("a failed writeGlb gives the reason and leaves no file") {
  const Folder folder;
  CHECK_THROWS_AS(writeGlb(sampleScene(), folder / "missing" / "a.glb"), Error);
  fs::create_directory(folder / "taken.glb");
  CHECK_THAT(problemOf([&] { writeGlb(sampleScene(), folder / "taken.glb"); }, ErrorCode::file),
             ContainsSubstring("taken.glb"));
  CHECK(folder.fileCount() == 1);  // the folder
  Scene far = sampleScene();
  far.meshes[1].origin.x = far.instances[0].transform.rows[0] = 1e200;
  CHECK_THAT(problemOf([&] { writeGlb(far, folder / "far.glb"); }),
             ContainsSubstring("the origin of mesh 1 moves an instance of it beyond finite numbers"));
  Scene bad = sampleScene();
  bad.meshes[0].indices[0] = 99;
  CHECK_THROWS_AS(writeGlb(bad, folder / "bad.glb"), Error);
  CHECK(folder.fileCount() == 1);
}

TEST_CASE("an origin that is not finite and an instance of no mesh are errors that name them") {
  Scene scene = sampleScene();
  scene.meshes[1].origin.z = std::numeric_limits<double>::quiet_NaN();
  CHECK_THAT(problemOf([&] { validate(scene); }), ContainsSubstring("its origin is not finite"));
  scene = sampleScene();
  scene.instances[1].mesh = 7;
  CHECK_THAT(problemOf([&] { scene.placedTriangleCount(); }), ContainsSubstring("instance 1: mesh 7 does not exist"));
  CHECK_THAT(problemOf([&] { worldBounds(scene); }), ContainsSubstring("instance 1: mesh 7 does not exist"));
  scene.instances[1].mesh = kNoMesh;  // as that of an instance which was removed from a simulator
  CHECK(scene.placedTriangleCount() == 6);
  scene = sampleScene();
  scene.instances[2].transform.rows[7] = INFINITY;
  CHECK_THAT(problemOf([&] { validate(scene); }), ContainsSubstring("instance 2: its transform is not finite"));
}

TEST_CASE("meshes whose numbers do not fit each other are errors that name them") {
  const auto refused = [](const std::function<void(Mesh&)>& change, const std::string& why) {
    Scene scene = sampleScene();
    change(scene.meshes[1]);
    CHECK_THAT(problemOf([&] { validate(scene); }), ContainsSubstring("mesh 1 ('far'): " + why));
  };
  refused([](Mesh& m) { m.positions.pop_back(); }, "positions must come in threes");
  refused([](Mesh& m) { m.indices.pop_back(); }, "indices must come in threes");
  refused([](Mesh& m) { m.indices[4] = 4; }, "index 4 is out of range, the mesh has 4 vertices");
  refused([](Mesh& m) { m.uvs.resize(6); }, "4 vertices need two texture coordinates each or none, there are 6");
  refused([](Mesh& m) { m.parts[0].firstTriangle = 1; }, "its parts must follow each other without a gap");
  refused([](Mesh& m) { m.parts = {{0, 2, 1}, {1, 1, 0}}; }, "its parts must follow each other without a gap");
  refused([](Mesh& m) { m.parts[0].triangleCount = 2; }, "its parts cover 2 of 3 triangles");
  refused([](Mesh& m) { m.parts[0].triangleCount = 4; }, "its parts cover 4 of 3 triangles");
  refused([](Mesh& m) { m.parts.clear(); }, "its parts cover 0 of 3 triangles");
  refused([](Mesh& m) { m.parts[0].material = 3; }, "material 3 does not exist, the scene has 3");
  refused([](Mesh& m) { m.morphTargets = {Floats(11)}; }, "morph target 0 has 11 numbers, the positions have 12");
  const auto addJoints = [](Mesh& m) {
    m.jointCount = 2;
    m.influences = 1;
    m.joints.assign(4, 1);
    m.jointWeights.assign(4, 1);
    m.morphTargets = {Floats(12)};
    m.deformation = {std::vector<Transform>(2), {0}};
  };
  Scene scene = sampleScene();
  addJoints(scene.meshes[1]);
  validate(scene);
  const auto refusedWithJoints = [&](const std::function<void(Mesh&)>& change, const std::string& why) {
    refused([&](Mesh& m) { addJoints(m), change(m); }, why);
  };
  refusedWithJoints([](Mesh& m) { m.joints.pop_back(); },
                    "4 vertices with 1 influences each need 4 joints and weights, there are 3 and 4");
  refusedWithJoints([](Mesh& m) { m.joints[2] = 2; }, "a vertex follows joint 2, the mesh has 2");
  refusedWithJoints([](Mesh& m) { m.jointWeights[3] = 0.5f; }, "the joints' weights of vertex 3 sum to 0.5, not to 1");
  refusedWithJoints([](Mesh& m) { m.deformation.joints.pop_back(); },
                    "its deformation has 1 joints and 1 morph weights, the mesh has 2 and 1");
  refusedWithJoints([](Mesh& m) { m.deformation.morphWeights[0] = std::nanf(""); },
                    "the weight of morph target 0 is not finite");
}

TEST_CASE("vertices that no triangle uses are not within the bounds") {
  const Folder folder;
  put(folder / "a.ply",
      "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
      "0 0 1000000\n0 0 1\n50 0 2\n0 50 3\n-7 -7 -7\n3 1 2 3\n");
  Scene scene = loadScene(folder / "a.ply");
  const Bounds bounds = worldBounds(scene);
  CHECK(bounds.min.x == 0);
  CHECK(bounds.max.x == 50);
  CHECK(bounds.min.z == 1);
  CHECK(bounds.max.z == 3);
  scene.meshes[0].indices.clear();
  CHECK(worldBounds(scene).empty());
}

TEST_CASE("the bounds of a scene are those of all its vertices, though few instances are looked at") {
  std::mt19937 random(7);
  const auto draw = [&](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
  for (int round = 0; round < 200; ++round) {
    Scene scene;
    scene.meshes.resize(3);
    for (Mesh& mesh : scene.meshes) {
      mesh.origin = {draw(-9, 9), draw(-9, 9), draw(-9, 9)};
      for (int i = 0; i < 3 * 30; ++i) mesh.positions.push_back(float(draw(-1, 1)));
      for (int i = 0; i < 3 * 8; ++i) mesh.indices.push_back(uint32_t(random() % 30));
      if (random() % 3 == 0) mesh.positions[random() % 90] = std::numeric_limits<float>::infinity();
    }
    for (int i = 0; i < 60; ++i) {
      Transform transform;
      for (double& value : transform.rows) value = draw(-1, 1);
      for (int row = 0; row < 3; ++row) transform.rows[4 * row + 3] *= draw(0, 20);
      if (random() % 20 == 0) transform.rows[random() % 12] = 1e308 * draw(-9, 9);
      scene.instances.push_back({"", random() % 10 == 0 ? kNoMesh : uint32_t(random() % 3), transform});
    }

    Vec3 least{1e300, 1e300, 1e300}, greatest{-1e300, -1e300, -1e300};
    for (const Instance& instance : scene.instances) {
      if (instance.mesh == kNoMesh) continue;
      const Mesh& mesh = scene.meshes[instance.mesh];
      for (const uint32_t index : mesh.indices) {
        const float* p = &mesh.positions[3 * index];
        const Vec3 at = instance.transform * Vec3{mesh.origin.x + p[0], mesh.origin.y + p[1], mesh.origin.z + p[2]};
        if (!std::isfinite(at.x) || !std::isfinite(at.y) || !std::isfinite(at.z)) continue;
        least = {std::min(least.x, at.x), std::min(least.y, at.y), std::min(least.z, at.z)};
        greatest = {std::max(greatest.x, at.x), std::max(greatest.y, at.y), std::max(greatest.z, at.z)};
      }
    }
    const Bounds bounds = worldBounds(scene);
    for (const auto axis : {&Vec3::x, &Vec3::y, &Vec3::z}) {
      CHECK(bounds.min.*axis == least.*axis);
      CHECK(bounds.max.*axis == greatest.*axis);
    }
  }
}

TEST_CASE("an instance whose points all overflow hides no other from the bounds of a scene") {
  Scene scene;
  scene.meshes.resize(1);
  scene.meshes[0].positions = {1e8f, 1e8f, 0, 2e8f, 1e8f, 0, 1e8f, 2e8f, 1};
  scene.meshes[0].indices = {0, 1, 2};
  const Instance beyond{"", 0, {{1e301, -1e301, 0, 0, 1e301, -1e301, 0, 0, -1e301, 1e301, 1, 0}}}, plain{"", 0, {}};
  for (const std::vector<Instance>& instances :
       {std::vector{beyond, plain}, std::vector{plain, beyond}, std::vector{beyond, plain, beyond}}) {
    scene.instances = instances;
    const Bounds bounds = worldBounds(scene);
    CHECK((bounds.min.x == 1e8 && bounds.min.y == 1e8 && bounds.min.z == 0));
    CHECK((bounds.max.x == 2e8 && bounds.max.y == 2e8 && bounds.max.z == 1));
  }
}

TEST_CASE("missing files, folders and unknown endings are errors that name them") {
  const Folder folder;
  const auto failure = [&](const std::string& name, ErrorCode code) {
    return problemOf([&] { loadScene(folder / name); }, code);
  };
  CHECK_THAT(failure("gone.glb", ErrorCode::file), ContainsSubstring("gone.glb': No such file or directory"));
  fs::create_directory(folder / "folder.glb");
  CHECK_THAT(failure("folder.glb", ErrorCode::file), ContainsSubstring("it is a folder"));
  CHECK_THAT(failure("a.fbx", ErrorCode::invalidArgument),
             ContainsSubstring("unknown ending '.fbx' for a scene; known are .gltf, .glb, .obj, .ply and .stl"));
  put(folder / "a.obj", "v 0 0 0\n");
  for (const double scale : {0.0, -1.0, std::nan(""), double{INFINITY}})
    CHECK_THROWS_WITH(loadScene(folder / "a.obj", {UpAxis::z, scale}), "the scale must be a positive number");
#ifndef _WIN32
  REQUIRE(mkfifo((folder / "pipe.obj").c_str(), 0600) == 0);  // whose reading would never end
  CHECK_THAT(failure("pipe.obj", ErrorCode::file), ContainsSubstring("pipe.obj': it is not a regular file"));
#endif
  GltfFileMaker far = triangleFile();
  far.json["nodes"][0]["translation"] = {1e300, 0, 0};
  put(folder / "far.gltf", far.text());
  CHECK(loadScene(folder / "far.gltf").instances.size() == 1);
  CHECK_THAT(problemOf(
                 [&] {
                   loadScene(folder / "far.gltf", {UpAxis::z, 1e10});
                 },
                 ErrorCode::format),
             ContainsSubstring("far.gltf': instance 0 is out of bounds at this scale"));
}

TEST_CASE("buffers and libraries are found beside the file, whatever its name") {
  const Folder folder;
  GltfFileMaker file = triangleFile();
  file.text();
  file.json["buffers"][0]["uri"] = "B%C3%BC ffer%201.bin";
  put(folder / "Bü ffer 1.bin", file.bytes);
  CHECK(loadScene(put(folder / "❤.gltf", file.json.dump())).uniqueTriangleCount() == 1);
}

TEST_CASE(
    "the block of docs/scenes.md reads a file in centimetres") {  // tests/docs/check_page compares it with the page
  const Folder folder;
  put(folder / "scene.obj", "v -900 -200 -900\nv 900 -200 -900\nv 900 -200 800\nf 1 3 2\n");
  const fs::path before = fs::current_path();
  fs::current_path(folder.path());

  const gnosphere::Scene scene = gnosphere::loadScene("scene.obj", {gnosphere::UpAxis::y, 0.01});

  fs::current_path(before);
  const Bounds bounds = worldBounds(scene);
  CHECK((std::abs(bounds.min.x + 9) < 1e-5 && std::abs(bounds.max.x - 9) < 1e-5));
  CHECK((std::abs(bounds.min.y + 8) < 1e-5 && std::abs(bounds.max.y - 9) < 1e-5));
  CHECK((std::abs(bounds.min.z + 2) < 1e-5 && std::abs(bounds.max.z + 2) < 1e-5));
}

TEST_CASE("every scene of the folder GNOSPHERE_SCENES loads or gives an Error") {
  const char* folder = std::getenv("GNOSPHERE_SCENES");
  if (folder == nullptr) SKIP("GNOSPHERE_SCENES names no folder of scenes");
  size_t loaded = 0, refused = 0;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder)) {
    std::string ending = entry.path().extension().string();
    for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    if (ending != ".gltf" && ending != ".glb" && ending != ".obj" && ending != ".ply" && ending != ".stl") continue;
    try {
      const Scene scene = loadScene(entry.path());
      CHECK_NOTHROW(validate(scene));
      ++loaded;
    } catch (const Error& error) {
      CHECK_THAT(error.what(), ContainsSubstring(entry.path().filename().string()));
      WARN(error.what());
      ++refused;
    }
  }
  WARN(loaded << " loaded, " << refused << " refused");
  CHECK(loaded + refused > 0);
}

TEST_CASE("the fuzzer's corpus does not crash the readers") {
  size_t count = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(GNOSPHERE_FUZZ_CORPUS)) {
    std::ifstream stream(entry.path(), std::ios::binary);
    const std::vector<char> bytes{std::istreambuf_iterator<char>(stream), {}};
    INFO(entry.path());
    fuzzReaders({reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()});
    ++count;
  }
  CHECK(count > 20);
}

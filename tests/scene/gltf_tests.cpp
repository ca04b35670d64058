// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch_approx.hpp>
#include <cmath>
#include <limits>
#include <utility>

#include "cpu_time.hpp"
#include "scene_text.hpp"

using namespace gnosphere;
using namespace gnosphere::test;
using Catch::Approx;

TEST_CASE("an indexed triangle is read as it is stored") {
  const Scene scene = triangleFile().load();
  REQUIRE(scene.meshes.size() == 1);
  CHECK(scene.meshes[0].name == "tri");
  CHECK(scene.meshes[0].positions == Floats{0, 0, 0, 1, 0, 0, 0, 1, 0});
  CHECK(scene.meshes[0].indices == Indices{0, 1, 2});
  CHECK(scene.meshes[0].origin.x == 0);
  REQUIRE(scene.instances.size() == 1);
  CHECK(scene.instances[0].transform.rows == Transform{}.rows);
  validate(scene);
}

TEST_CASE("a GLB and glTF text give the same scene") {
  GltfFileMaker file = triangleFile();
  const Scene scene = loadText("made.glb", file.glb());
  CHECK(scene.meshes.at(0).positions == Floats{0, 0, 0, 1, 0, 0, 0, 1, 0});
  CHECK(scene.meshes.at(0).indices == Indices{0, 1, 2});
  // The content decides about the format, not the file ending.
  CHECK(loadText("made.gltf", file.glb()).meshes.size() == 1);
}

TEST_CASE("a buffer in the alphabet of base64 for addresses is that in the usual one") {
  GltfFileMaker file = triangleFile();
  const std::string digits = "++//+/+/";  // six bytes that no position uses
  file.bytes.resize(48);
  file.view("\xfb\xef\xff\xfb\xff\xbf");
  std::string text = file.text();
  const Floats positions = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  const size_t at = text.find(digits);
  REQUIRE(at != text.npos);
  CHECK(loadText("made.gltf", text).meshes.at(0).positions == positions);
  text.replace(at, digits.size(), "--__-_-_");
  CHECK(loadText("made.gltf", text).meshes.at(0).positions == positions);
}

TEST_CASE("glTF is rotated from y-up to z-up by default") {
  GltfFileMaker file = triangleFile();
  const Transform turned = file.load({}).instances.at(0).transform;
  CHECK(at(turned, 1, 2, 3) == std::array<double, 3>{1, -3, 2});
  CHECK(at(file.load({UpAxis::y, 1}).instances.at(0).transform, 1, 2, 3) == std::array<double, 3>{1, -3, 2});
  CHECK(at(file.load({UpAxis::z, 1}).instances.at(0).transform, 1, 2, 3) == std::array<double, 3>{1, 2, 3});
  CHECK(at(file.load({UpAxis::formatDefault, 0.01}).instances.at(0).transform, 100, 200, 300) ==
        std::array<double, 3>{1, -3, 2});
}

TEST_CASE("node transforms are composed in double from matrix and from TRS") {
  GltfFileMaker file = triangleFile();
  // A rotation by 90 degrees about z, a scale of 2 along x, then a translation; a child with a matrix that moves far
  // away.
  const double half = std::sqrt(0.5);
  file.json["nodes"] = {
      {{"children", {1}}, {"translation", {1, 2, 3}}, {"rotation", {0, 0, half, half}}, {"scale", {2, 1, 1}}},
      {{"mesh", 0}, {"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5206123.456, 0, 7, 1}}}};
  const Transform transform = file.load().instances.at(0).transform;
  const auto p = at(transform, 0, 0, 0);
  CHECK(p[0] == Approx(1).margin(1e-8));
  CHECK(p[1] == Approx(2 + 2 * 5206123.456).epsilon(1e-15));
  CHECK(p[2] == 10);
  const auto x = at(transform, 1, 0, 0);
  CHECK(x[1] - p[1] == Approx(2).margin(1e-8));
}

TEST_CASE("a mirrored node keeps its negative determinant") {
  GltfFileMaker file = triangleFile();
  file.json["nodes"][0]["scale"] = {-1, 1, 1};
  const Scene scene = file.load();
  CHECK(at(scene.instances.at(0).transform, 1, 2, 3) == std::array<double, 3>{-1, 2, 3});
  CHECK(scene.meshes.at(0).indices == Indices{0, 1, 2});
}

TEST_CASE("nodes that share a mesh become instances of one mesh, in tree order") {
  GltfFileMaker file = triangleFile();
  file.json["nodes"] = {
      {{"name", "a"}, {"mesh", 0}, {"children", {2}}}, {{"name", "b"}, {"mesh", 0}}, {{"name", "c"}, {"mesh", 0}}};
  file.json["scenes"] = {{{"nodes", {1, 0}}}};
  const Scene scene = file.load();
  CHECK(scene.meshes.size() == 1);
  REQUIRE(scene.instances.size() == 3);
  CHECK(scene.instances[0].name == "b");
  CHECK(scene.instances[1].name == "a");
  CHECK(scene.instances[2].name == "c");
}

TEST_CASE("the default scene is read, else the first, else every root") {
  GltfFileMaker file = triangleFile();
  file.json["nodes"] = {{{"name", "a"}, {"mesh", 0}}, {{"name", "b"}, {"mesh", 0}}};
  CHECK(file.load().instances.size() == 2);
  CHECK(file.load().leftOut.empty());
  file.json["scenes"] = {{{"nodes", {0}}}, {{"nodes", {1}}}};
  CHECK(file.load().instances.at(0).name == "a");
  CHECK(file.load().leftOut ==
        std::vector<std::string>{"1 nodes with a mesh that are not in the scene which the file shows"});
  file.json["scene"] = 1;
  CHECK(file.load().instances.at(0).name == "b");
  file.json["scene"] = 2;
  CHECK_THAT(file.failure(), ContainsSubstring("scene 2 does not exist"));
}

TEST_CASE("a chain of a hundred thousand nodes is read") {
  GltfFileMaker file = triangleFile();
  file.json["nodes"] = Json::array();
  for (int i = 1; i < 100'000; ++i) file.json["nodes"].push_back({{"children", {i}}, {"translation", {1, 0, 0}}});
  file.json["nodes"].push_back({{"mesh", 0}});
  CHECK(at(file.load().instances.at(0).transform, 0, 0, 0) == std::array<double, 3>{99'999, 0, 0});
}

TEST_CASE("strips and fans become triangles with glTF's winding") {
  GltfFileMaker file;
  const int positions = file.accessor(Floats{0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 2, 0}, "VEC3");
  file.mesh({{"attributes", {{"POSITION", positions}}}, {"mode", 5}});
  file.node({{"mesh", 0}});
  CHECK(file.load().meshes.at(0).indices == Indices{0, 1, 2, 1, 3, 2, 2, 3, 4});
  file.json["meshes"][0]["primitives"][0]["mode"] = 6;
  CHECK(file.load().meshes.at(0).indices == Indices{1, 2, 0, 2, 3, 0, 3, 4, 0});
  // The first is indexed, the second has too few corners for a triangle.
  file.json["meshes"][0]["primitives"][0]["indices"] = file.accessor(std::vector<uint8_t>{4, 3, 2, 1}, "SCALAR");
  CHECK(file.load().meshes.at(0).indices == Indices{3, 2, 4, 2, 1, 4});
  file.json["meshes"][0]["primitives"][0]["indices"] = file.accessor(std::vector<uint8_t>{4, 3}, "SCALAR");
  CHECK(file.load().meshes.at(0).indices.empty());
}

TEST_CASE("a primitive without positions has no surface") {
  GltfFileMaker file = triangleFile();
  Json& primitives = file.json["meshes"][0]["primitives"];
  primitives.push_back(primitives[0]);
  primitives[1]["attributes"] = {{"_NUMBER", 0}};
  const Scene scene = file.load();
  CHECK(scene.uniqueTriangleCount() == 1);
  validate(scene);
}

TEST_CASE("triangles without indices use their vertices in order, and points and lines are told as left out") {
  GltfFileMaker file;
  const int positions = file.accessor(kSquare, "VEC3");
  file.mesh({{"attributes", {{"POSITION", positions}}}});
  file.node({{"mesh", 0}});
  CHECK(file.load().meshes.at(0).indices == Indices{0, 1, 2});  // the fourth vertex begins an incomplete triangle
  for (int mode : {0, 1, 2, 3}) {
    file.json["meshes"][0]["primitives"][0]["mode"] = mode;
    const Scene scene = file.load();
    CHECK(scene.uniqueTriangleCount() == 0);
    CHECK(scene.leftOut == std::vector<std::string>{"1 sets of lines or points, which have no area"});
  }
}

TEST_CASE("indices of every width are read") {
  GltfFileMaker file = triangleFile();
  const auto set = [&](int accessor) { file.json["meshes"][0]["primitives"][0]["indices"] = accessor; };
  set(file.accessor(std::vector<uint8_t>{2, 1, 0}, "SCALAR"));
  CHECK(file.load().meshes.at(0).indices == Indices{2, 1, 0});
  set(file.accessor(Indices{1, 2, 0}, "SCALAR"));
  CHECK(file.load().meshes.at(0).indices == Indices{1, 2, 0});
}

TEST_CASE("quantised positions of every type are decoded as specified") {
  GltfFileMaker file = triangleFile();
  file.json["extensionsRequired"] = {"KHR_mesh_quantization"};
  const auto positions = [&](int accessor) {
    file.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = accessor;
    return file.load().meshes.at(0).positions;
  };
  const Json normalized = {{"normalized", true}};
  CHECK(positions(file.accessor(std::vector<int8_t>{127, -128, -127, 0, 0, 0, 0, 0, 0}, "VEC3", normalized)) ==
        Floats{1, -1, -1, 0, 0, 0, 0, 0, 0});
  CHECK(positions(file.accessor(std::vector<uint8_t>{255, 51, 0, 0, 0, 0, 0, 0, 0}, "VEC3", normalized)) ==
        Floats{1, 0.2f, 0, 0, 0, 0, 0, 0, 0});
  CHECK(positions(file.accessor(std::vector<int16_t>{32767, -32768, 0, 0, 0, 0, 0, 0, 0}, "VEC3", normalized)) ==
        Floats{1, -1, 0, 0, 0, 0, 0, 0, 0});
  CHECK(positions(file.accessor(std::vector<uint16_t>{65535, 13107, 0, 0, 0, 0, 0, 0, 0}, "VEC3", normalized)) ==
        Floats{1, 0.2f, 0, 0, 0, 0, 0, 0, 0});
  CHECK(positions(file.accessor(std::vector<int16_t>{-300, 20, 7, 0, 0, 0, 0, 0, 0}, "VEC3")) ==
        Floats{-300, 20, 7, 0, 0, 0, 0, 0, 0});
  CHECK(positions(file.accessor(Indices{70000, 0, 7, 0, 0, 0, 0, 0, 0}, "VEC3")) ==
        Floats{70000, 0, 7, 0, 0, 0, 0, 0, 0});
}

TEST_CASE("interleaved vertices are read with their byteStride and byteOffset") {
  GltfFileMaker file = triangleFile();
  const int position = file.accessor(Floats{9, 9, 9, 9, 1, 2, 3, 9, 4, 5, 6, 9, 7, 8, 9, 9}, "VEC3");
  file.json["accessors"][static_cast<size_t>(position)]["byteOffset"] = 16;
  file.json["accessors"][static_cast<size_t>(position)]["count"] = 3;
  file.json["bufferViews"].back()["byteStride"] = 16;
  file.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = position;
  CHECK(file.load().meshes.at(0).positions == Floats{1, 2, 3, 4, 5, 6, 7, 8, 9});
}

TEST_CASE("sparse accessors replace elements of their bufferView, or zeros") {
  GltfFileMaker file = triangleFile();
  const int which = file.view(bytesOf(std::vector<uint8_t>{1, 2})),
            values = file.view(bytesOf(Floats{5, 6, 7, 8, 9, 10}));
  const Json sparse = {{"count", 2},
                       {"indices", {{"bufferView", which}, {"componentType", 5121}}},
                       {"values", {{"bufferView", values}}}};
  file.json["accessors"][0]["sparse"] = sparse;
  CHECK(file.load().meshes.at(0).positions == Floats{0, 0, 0, 5, 6, 7, 8, 9, 10});
  file.json["accessors"][0] = {{"componentType", 5126}, {"type", "VEC3"}, {"count", 4}, {"sparse", sparse}};
  CHECK(file.load().meshes.at(0).positions == Floats{0, 0, 0, 5, 6, 7, 8, 9, 10, 0, 0, 0});
}

TEST_CASE("primitives become parts, and share the vertices of a shared accessor") {
  GltfFileMaker file = triangleFile();
  const int more = file.accessor(Floats{7, 7, 7, 8, 8, 8, 9, 9, 9}, "VEC3");
  const Json first = file.json["meshes"][0]["primitives"][0];
  file.json["materials"] = {{{"name", "red"}}, {{"name", "blue"}}};
  Json& primitives = file.json["meshes"][0]["primitives"];
  primitives[0]["material"] = 1;
  primitives.push_back({{"attributes", {{"POSITION", more}}}, {"material", 0}});
  primitives.push_back(first);
  const Scene scene = file.load();
  const Mesh& mesh = scene.meshes.at(0);
  CHECK(mesh.positions == Floats{0, 0, 0, 1, 0, 0, 0, 1, 0, 7, 7, 7, 8, 8, 8, 9, 9, 9});
  CHECK(mesh.indices == Indices{0, 1, 2, 3, 4, 5, 0, 1, 2});
  REQUIRE(mesh.parts.size() == 3);
  CHECK(mesh.parts[0].material == 1);
  CHECK(mesh.parts[1].material == 0);
  CHECK(mesh.parts[1].firstTriangle == 1);
  // The third primitive has no material, so it gets glTF's default, which is single-sided.
  REQUIRE(scene.materials.size() == 3);
  CHECK(mesh.parts[2].material == 2);
  CHECK_FALSE(scene.materials[2].doubleSided);
  CHECK(scene.materials[2].metallic == 1);
}

TEST_CASE("meshes that share an accessor copy only the vertices that they use") {
  GltfFileMaker file;
  const int positions = file.accessor(kSquare, "VEC3");
  const int a = file.accessor(std::vector<uint16_t>{3, 1, 2}, "SCALAR"),
            b = file.accessor(std::vector<uint16_t>{0, 1, 2}, "SCALAR");
  file.mesh({{"attributes", {{"POSITION", positions}}}, {"indices", a}});
  file.mesh({{"attributes", {{"POSITION", positions}}}, {"indices", b}});
  file.node({{"mesh", 0}});
  file.node({{"mesh", 1}});
  const Scene scene = file.load();
  CHECK(scene.meshes.at(0).positions == Floats{1, 0, 0, 0, 1, 0, 1, 1, 0});
  CHECK(scene.meshes.at(0).indices == Indices{2, 0, 1});
  CHECK(scene.meshes.at(1).positions == Floats{0, 0, 0, 1, 0, 0, 0, 1, 0});
}

TEST_CASE("many primitives that share the accessor of positions alone take no time that grows by squares") {
  constexpr size_t kCount = 20000;
  GltfFileMaker file;
  const int positions = file.accessor(Floats{0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3");
  Json primitives = Json::array();
  for (size_t i = 0; i < kCount; ++i) {
    const int offsets = file.push("accessors", {{"componentType", 5126}, {"count", 3}, {"type", "VEC3"}});
    primitives.push_back({{"attributes", {{"POSITION", positions}}}, {"targets", {{{"POSITION", offsets}}}}});
  }
  file.push("meshes", {{"primitives", std::move(primitives)}});
  file.node({{"mesh", 0}});
  const std::string text = file.text();
  Scene scene;
  CHECK(cpuSeconds([&] { scene = loadText("a.gltf", text); }) < 2);
  REQUIRE(scene.meshes.at(0).triangleCount() == kCount);
  CHECK(scene.meshes[0].vertexCount() == 3 * kCount);
  CHECK(scene.meshes[0].indices.back() == 3 * kCount - 1);
}

TEST_CASE("materials are read with their transmission, alpha and sides") {
  GltfFileMaker file = triangleFile();
  file.json["materials"] = Json::parse(R"([
    {"name": "glass", "doubleSided": true, "alphaMode": "MASK", "alphaCutoff": 0.25,
     "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.25, 1, 0.75], "metallicFactor": 0.5, "roughnessFactor": 0.125},
     "extensions": {"KHR_materials_transmission": {"transmissionFactor": 0.875}}},
    {"alphaMode": "BLEND", "pbrMetallicRoughness": {"baseColorTexture": {"index": 99}}}])");
  const Scene scene = file.load();
  const Material& glass = scene.materials.at(0);
  CHECK(glass.name == "glass");
  CHECK(glass.baseColor == std::array<float, 4>{0.5f, 0.25f, 1, 0.75f});
  CHECK(glass.metallic == 0.5f);
  CHECK(glass.roughness == 0.125f);
  CHECK(glass.transmission == 0.875f);
  CHECK(glass.alphaMode == AlphaMode::mask);
  CHECK(glass.alphaCutoff == 0.25f);
  CHECK(glass.doubleSided);
  const Material& plain = scene.materials.at(1);
  CHECK(plain.alphaMode == AlphaMode::blend);
  CHECK(plain.metallic == 1);
  CHECK(plain.roughness == 1);
  CHECK_FALSE(plain.doubleSided);
  CHECK(scene.leftOut ==
        std::vector<std::string>{"1 materials' alpha of textures; only glTF's alpha mode MASK makes holes",
                                 "1 materials' colours of textures; the base colours alone count"});
  file.json["materials"][1]["alphaMode"] = "OPAQUE";  // then the alpha of the texture has no meaning
  CHECK(file.load().leftOut ==
        std::vector<std::string>{"1 materials' colours of textures; the base colours alone count"});
}

TEST_CASE("materials with a texture of metalness are read as no metals, and counted") {
  GltfFileMaker file = triangleFile();
  file.json["materials"] = Json::parse(R"([
    {"pbrMetallicRoughness": {"metallicRoughnessTexture": {"index": 0}}},
    {"pbrMetallicRoughness": {"metallicRoughnessTexture": {"index": 0}, "metallicFactor": 0.5, "roughnessFactor": 0.25}},
    {"pbrMetallicRoughness": {"metallicFactor": 0.5}},
    {"pbrMetallicRoughness": {}}])");
  const Scene scene = file.load();
  std::vector<float> metallic, roughness;
  for (const Material& material : scene.materials) {
    metallic.push_back(material.metallic);
    roughness.push_back(material.roughness);
  }
  // The fifth is glTF's default material, which the triangle has.
  CHECK(metallic == Floats{0, 0, 0.5, 1, 1});
  CHECK(roughness == Floats{1, 0.25, 1, 1, 1});
  CHECK(scene.leftOut ==
        std::vector<std::string>{
            "2 materials' metalness and roughness of textures; metalness 0 and the roughness factor count instead"});
}

TEST_CASE("materials with a texture of transmission are read as opaque, and counted") {
  GltfFileMaker file = triangleFile();
  const char* const kGlass = R"([
    {"extensions": {"KHR_materials_transmission": {"transmissionFactor": 1, "transmissionTexture": {"index": 0}}}},
    {"extensions": {"KHR_materials_transmission": {"transmissionTexture": {"index": 0}}}},
    {"extensions": {"KHR_materials_transmission": {"transmissionFactor": 0.5}}}])";
  file.json["materials"] = Json::parse(kGlass);
  const Scene scene = file.load();
  CHECK(scene.materials.at(0).transmission == 0);
  CHECK(scene.materials.at(1).transmission == 0);
  CHECK(scene.materials.at(2).transmission == 0.5f);
  CHECK(scene.leftOut ==
        std::vector<std::string>{"1 materials' transmission of textures; transmission 0 counts instead"});
}

TEST_CASE("extensions of materials that change their intensity and are not read are told where they have an effect") {
  const auto toldOf = [](const char* name, const char* properties) {
    GltfFileMaker file = triangleFile();
    file.json["materials"] = Json::array({{{"extensions", {{name, Json::parse(properties)}}}}});
    const std::vector<std::string> told = file.load().leftOut;
    CHECK((told.empty() || told == std::vector<std::string>{std::string("1 materials' properties of ") + name}));
    return !told.empty();
  };
  const auto check = [&](const char* name, std::vector<const char*> without, std::vector<const char*> with) {
    for (const char* properties : without) {
      CAPTURE(name, properties);
      CHECK(!toldOf(name, properties));
    }
    for (const char* properties : with) {
      CAPTURE(name, properties);
      CHECK(toldOf(name, properties));
    }
  };
  check("KHR_materials_ior", {"{}", R"({"ior": 1.5})"}, {R"({"ior": 1.33})", R"({"ior": 2})"});
  check("KHR_materials_specular",
        {"{}", R"({"specularFactor": 1})", R"({"specularFactor": 1.0, "specularColorFactor": [1.0, 1, 1]})"},
        {R"({"specularFactor": 0})", R"({"specularColorFactor": [1, 0.5, 1]})", R"({"specularTexture": {"index": 0}})",
         R"({"specularColorTexture": {"index": 0}})"});
  check("KHR_materials_clearcoat", {"{}", R"({"clearcoatFactor": 0, "clearcoatRoughnessFactor": 0.5})"},
        {R"({"clearcoatFactor": 0.1})"});
  check("KHR_materials_sheen", {"{}", R"({"sheenColorFactor": [0, 0.0, 0], "sheenRoughnessFactor": 1})"},
        {R"({"sheenColorFactor": [0, 0.5, 0]})"});
  check("KHR_materials_iridescence", {"{}", R"({"iridescenceFactor": 0})"}, {R"({"iridescenceFactor": 1})"});
  check("KHR_materials_anisotropy", {"{}", R"({"anisotropyStrength": 0})"}, {R"({"anisotropyStrength": 0.6})"});
  check("KHR_materials_diffuse_transmission", {"{}", R"({"diffuseTransmissionFactor": 0})"},
        {R"({"diffuseTransmissionFactor": 0.25})"});
  // Light that becomes white on its way through a volume is not weakened, and without thickness there is no way.
  check("KHR_materials_volume",
        {"{}", R"({"thicknessFactor": 1})", R"({"thicknessFactor": 1, "attenuationDistance": 0.5})",
         R"({"thicknessFactor": 1, "attenuationDistance": 0.5, "attenuationColor": [1, 1.0, 1]})",
         R"({"thicknessFactor": 1, "attenuationColor": [0.5, 1, 1]})",
         R"({"attenuationDistance": 0.5, "attenuationColor": [0.5, 1, 1]})",
         R"({"thicknessFactor": 0, "attenuationDistance": 0.5, "attenuationColor": [0.5, 1, 1]})"},
        {R"({"thicknessFactor": 1, "attenuationDistance": 0.5, "attenuationColor": [0.5, 1, 1]})"});
  check("KHR_materials_unlit", {}, {"{}"});
  check("KHR_materials_pbrSpecularGlossiness", {}, {"{}"});
  check("KHR_materials_emissive_strength", {R"({"emissiveStrength": 5})"}, {});
  check("KHR_materials_dispersion", {R"({"dispersion": 0.1})"}, {});
}

TEST_CASE("extras of nodes, meshes and materials state classes") {
  GltfFileMaker file = triangleFile();
  Json& json = file.json;
  const auto classesOf = [](const auto& all) {
    std::vector<int> ids;
    for (const auto& each : all) ids.push_back(each.classId);
    return ids;
  };
  const auto namesOf = [](const auto& all) {
    std::vector<std::string> names;
    for (const auto& each : all) names.push_back(each.className);
    return names;
  };
  using Names = std::vector<std::string>;
  using Ids = std::vector<int>;
  json["materials"] = {{{"extras", {{"class", 5}}}}, {{"extras", {{"label", 6}}}}, {{"extras", {{"class", "wall"}}}}};
  json["meshes"][0]["primitives"][0]["material"] = 0;
  json["meshes"].push_back(json["meshes"][0]);
  json["meshes"][1]["extras"] = {{"class", 9}, {"label", 8}};
  json["nodes"] = {{{"mesh", 0}}, {{"mesh", 1}}};
  json["scenes"][0]["nodes"] = {0, 1};
  Scene scene = file.load();
  CHECK(classesOf(scene.instances) == Ids{0, 9});  // a material's class is not that of the instance
  CHECK(classesOf(scene.materials) == Ids{5, 6, 0});
  CHECK(namesOf(scene.materials) == Names{"", "", "wall"});
  // A node counts before its mesh, and for all nodes below it that state none.
  json["nodes"] = {{{"children", {1, 2}}, {"extras", {{"label", 3}}}},
                   {{"mesh", 1}},
                   {{"mesh", 1}, {"extras", {{"class", 65535}}}},
                   {{"mesh", 1}, {"extras", {{"class", "car"}, {"label", 4}}}}};
  json["scenes"][0]["nodes"] = {0, 3};
  scene = file.load();
  CHECK(classesOf(scene.instances) == Ids{3, 65535, 4});
  CHECK(namesOf(scene.instances) == Names{"", "", ""});
  // A class may have a name instead of a number.
  json["meshes"][1]["extras"] = {{"class", "house"}};
  json["nodes"] = {{{"children", {1}}, {"extras", {{"class", "car"}, {"label", "7"}}}},
                   {{"mesh", 1}},
                   {{"mesh", 1}},
                   {{"mesh", 1}, {"extras", {{"label", "tree"}}}},
                   {{"mesh", 1}, {"extras", {{"class", ""}}}}};
  json["scenes"][0]["nodes"] = {0, 2, 3, 4};
  scene = file.load();
  CHECK(namesOf(scene.instances) == Names{"car", "house", "tree", "house"});
  CHECK(classesOf(scene.instances) == Ids{0, 0, 0, 0});
  // A value that is not the number of a class is somebody else's.
  json["meshes"][1]["extras"] = {{"class", 5}};
  for (const Json& other : {Json(-1), Json(65536), Json(2.5), Json(""), Json::array({1}), Json(nullptr)}) {
    json["nodes"] = {{{"mesh", 1}, {"extras", {{"class", other}}}}};
    json["materials"][1]["extras"] = {{"label", other}};
    json["scenes"][0]["nodes"] = {0};
    scene = file.load();
    CHECK(classesOf(scene.instances) == Ids{5});
    CHECK(classesOf(scene.materials) == Ids{5, 0, 0});
  }
}

TEST_CASE(
    "hidden nodes place nothing, nor do those below; what is not read of vertices, materials and classes is told") {
  GltfFileMaker file = triangleFile();
  file.json["nodes"] = {
      {{"children", {1}}, {"extensions", {{"KHR_node_visibility", {{"visible", false}}}}}},
      {{"mesh", 0}, {"name", "below"}},
      {{"mesh", 0}, {"name", "shown"}, {"extensions", {{"KHR_node_visibility", {{"visible", true}}}}}},
      {{"mesh", 0},
       {"name", "hidden"},
       {"extras", {{"class", 70000}}},
       {"extensions", {{"KHR_node_visibility", {{"visible", false}}}}}}};
  file.json["scenes"] = {{{"nodes", {0, 2, 3}}}};
  file.json["extensionsRequired"] = {"KHR_node_visibility"};
  file.json["materials"] = {{{"extensions", {{"KHR_materials_pbrSpecularGlossiness", Json::object()}}}}};
  file.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = 0;
  const Scene scene = file.load();
  REQUIRE(scene.instances.size() == 1);
  CHECK(scene.instances[0].name == "shown");
  CHECK(scene.leftOut == std::vector<std::string>{"1 classes that are neither names nor whole numbers from 0 to 65535",
                                                  "1 materials' properties of KHR_materials_pbrSpecularGlossiness",
                                                  "1 sets of vertex colours"});
}

TEST_CASE("EXT_mesh_gpu_instancing places the mesh once per element") {
  GltfFileMaker file = triangleFile();
  const int translations = file.accessor(Floats{1, 0, 0, 0, 2, 0}, "VEC3");
  const int rotations = file.accessor(std::vector<int8_t>{0, 0, 0, 127, 0, 0, 90, 90}, "VEC4", {{"normalized", true}});
  const int scales = file.accessor(Floats{1, 1, 1, 3, 1, 1}, "VEC3");
  file.json["extensionsRequired"] = {"EXT_mesh_gpu_instancing"};
  file.json["nodes"][0]["translation"] = {0, 0, 10};
  file.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
      {"TRANSLATION", translations}, {"ROTATION", rotations}, {"SCALE", scales}};
  const Scene scene = file.load();
  CHECK(scene.meshes.size() == 1);
  REQUIRE(scene.instances.size() == 2);
  CHECK(at(scene.instances[0].transform, 1, 0, 0) == std::array<double, 3>{2, 0, 10});
  const auto turned = at(scene.instances[1].transform, 1, 0, 0);  // scaled by 3, rotated to y, moved by 2
  CHECK(turned[0] == Approx(0).margin(1e-12));
  CHECK(turned[1] == Approx(5));
  CHECK(turned[2] == 10);
  file.json["accessors"][static_cast<size_t>(scales)]["count"] = 1;
  CHECK_THAT(file.failure(), ContainsSubstring("node 0: SCALE has 1 instances, ROTATION has 2"));
}

TEST_CASE("EXT_mesh_gpu_instancing counts by attributes of the file's own, and places the mesh once without any") {
  GltfFileMaker file = triangleFile();
  const int features = file.accessor(std::vector<uint16_t>{7, 8, 9}, "SCALAR");
  Json& extension = file.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"];
  extension["attributes"] = {{"_FEATURE_ID_0", features}};
  Scene scene = file.load();
  CHECK(scene.instances.size() == 3);
  CHECK(scene.leftOut == std::vector<std::string>{"1 sets of numbers of instances: '_FEATURE_ID_0'"});
  extension["attributes"]["TRANSLATION"] = file.accessor(Floats{1, 0, 0, 0, 2, 0}, "VEC3");
  CHECK_THAT(file.failure(), ContainsSubstring("node 0: _FEATURE_ID_0 has 3 instances, TRANSLATION has 2") ||
                                 ContainsSubstring("node 0: TRANSLATION has 2 instances, _FEATURE_ID_0 has 3"));
  extension["attributes"] = Json::object();
  scene = file.load();
  REQUIRE(scene.instances.size() == 1);
  CHECK(at(scene.instances[0].transform, 1, 0, 0) == std::array<double, 3>{1, 0, 0});
  CHECK(scene.leftOut.empty());
}

TEST_CASE("extensions that are not read, and numbers of vertices, are told as left out") {
  GltfFileMaker file = triangleFile();
  file.json["extensions"]["CESIUM_RTC"]["center"] = {500000, 5500000, 0};
  file.json["extensionsUsed"] = {"EXT_mesh_features", "KHR_materials_unlit", "EXT_mesh_gpu_instancing", 5};
  file.json["meshes"][0]["primitives"][0]["attributes"]["_FEATURE_ID_0"] = 0;
  CHECK(file.load().leftOut ==
        std::vector<std::string>{"1 extensions of the file that are not read: 'CESIUM_RTC'",
                                 "1 extensions of the file that are not read: 'EXT_mesh_features'",
                                 "1 sets of numbers of vertices: '_FEATURE_ID_0'"});
}

TEST_CASE("nan, infinity and huge positions are kept") {
  const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
  GltfFileMaker file = triangleFile();
  file.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] =
      file.accessor(Floats{nan, 0, 0, infinity, 0, 0, 1e30f, 0, 0}, "VEC3");
  const Scene scene = file.load();
  CHECK(std::isnan(scene.meshes.at(0).positions[0]));
  CHECK(scene.meshes.at(0).positions[3] == infinity);
  CHECK(scene.meshes.at(0).positions[6] == 1e30f);
  CHECK(scene.uniqueTriangleCount() == 1);
}

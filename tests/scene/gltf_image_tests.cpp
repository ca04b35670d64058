// SPDX-License-Identifier: Apache-2.0
// The alpha of cut-out textures, and its mapping to a mesh.
#include <algorithm>
#include <catch2/generators/catch_generators.hpp>
#include <cmath>
#include <functional>
#include <locale>

#include "scene/readers.hpp"
#include "scene_text.hpp"

using namespace gnosphere;
using namespace gnosphere::test;

namespace {

/// 2 x 2 pixels, RGBA; alpha 0 255 128 64.
const std::string kHoles =
    "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAIAAAACCAYAAABytg0kAAAAFElEQVR42mPg"
    "5ORkAOL/IKIBiB0AEMoCLBE9eeoAAAAASUVORK5CYII=";
/// 1 x 1 pixel, RGB.
const std::string kSolid =
    "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR42mPg"
    "5OQEAAA6ABzT9UgiAAAAAElFTkSuQmCC";

/// A triangle with a material that has holes.
GltfFileMaker cutOut(const std::string& uri = kHoles) {
  GltfFileMaker file = triangleFile();
  Json& attributes = file.json["meshes"][0]["primitives"][0]["attributes"];
  attributes["TEXCOORD_0"] = file.accessor(Floats{0, 0, 1, 0, 0.25f, 2}, "VEC2");
  attributes["TEXCOORD_1"] = file.accessor(std::vector<uint8_t>{0, 0, 255, 0, 51, 255}, "VEC2", {{"normalized", true}});
  file.json["meshes"][0]["primitives"][0]["material"] = 0;
  file.json["materials"] = Json::parse(
      R"([{"name": "leaf", "alphaMode": "MASK", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}])");
  file.json["textures"] = Json::parse(R"([{"source": 0, "sampler": 0}])");
  file.json["samplers"] = Json::parse(R"([{"wrapS": 33071, "wrapT": 33648, "magFilter": 9728}])");
  file.json["images"] = {{{"uri", uri}, {"name", "leaf"}}};
  return file;
}

Json& textureOf(GltfFileMaker& file) {
  return file.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"];
}

std::vector<uint8_t> unpacked(const std::string& uri) {
  // Decodes only text that is valid base64.
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::vector<uint8_t> bytes;
  uint32_t bits = 0;
  int count = 0;
  for (char c : uri.substr(uri.find(',') + 1)) {
    if (c == '=') break;
    bits = bits << 6 | static_cast<uint32_t>(kDigits.find(c));
    if ((count += 6) >= 8) bytes.push_back(static_cast<uint8_t>(bits >> (count -= 8)));
  }
  return bytes;
}

std::string packed(const std::vector<uint8_t>& bytes) {
  return "data:image/png;base64," + base64(bytesOf(bytes));
}

}  // namespace

TEST_CASE("the alpha of a cut-out texture is read with its sampler and coordinates") {
  const Scene scene = cutOut().load();
  validate(scene);
  REQUIRE(scene.alphaImages.size() == 1);
  const AlphaImage& image = scene.alphaImages[0];
  CHECK(image.width == 2);
  CHECK(image.height == 2);
  CHECK(image.alpha == std::vector<uint8_t>{0, 255, 128, 64});
  CHECK(image.wrapU == AlphaImage::Wrap::clamp);
  CHECK(image.wrapV == AlphaImage::Wrap::mirror);
  CHECK(scene.materials[0].alphaImage == 0);
  CHECK(scene.meshes[0].uvs == Floats{0, 0, 1, 0, 0.25f, 2});
  CHECK(scene.unreadImages == 0);
}

TEST_CASE("colours of a cut-out texture are told as left out, unless all are white") {
  const std::string told = "1 materials' colours of textures; the base colours alone count";
  const auto toldOf = [&](const std::string& uri) {
    const std::vector<std::string> lines = cutOut(uri).load().leftOut;
    return std::count(lines.begin(), lines.end(), told) == 1;
  };
  CHECK(toldOf(kHoles));
  CHECK(toldOf(kSolid));
  CHECK(toldOf("missing.png"));
  CHECK(toldOf(packed({0xff, 0xd8, 0xff, 0xe0, 0, 1})));  // JPEG
  CHECK(cutOut(packed(pngOf({2, 2, {0, 255, 128, 64}}))).load().leftOut.empty());
  // Each material that has the image counts.
  GltfFileMaker twice = cutOut();
  twice.json["materials"].push_back(twice.json["materials"][0]);
  CHECK(twice.load().leftOut ==
        std::vector<std::string>{"2 materials' colours of textures; the base colours alone count"});
}

TEST_CASE("an image may be in a bufferView, and samplers may be omitted") {
  GltfFileMaker file = cutOut();
  const int view = file.view(bytesOf(unpacked(kHoles)));
  file.json["images"][0] = {{"bufferView", view}, {"mimeType", "image/png"}};
  file.json["textures"][0].erase("sampler");
  const Scene scene = file.load();
  REQUIRE(scene.alphaImages.size() == 1);
  CHECK(scene.alphaImages[0].alpha[1] == 255);
  CHECK(scene.alphaImages[0].wrapU == AlphaImage::Wrap::repeat);
}

TEST_CASE("materials share an image that is sampled in the same way") {
  GltfFileMaker file = cutOut();
  file.json["materials"].push_back(file.json["materials"][0]);
  file.json["materials"].push_back(file.json["materials"][0]);
  file.json["textures"].push_back({{"source", 0}});
  file.json["materials"][2]["pbrMetallicRoughness"]["baseColorTexture"]["index"] = 1;
  const Scene scene = file.load();
  CHECK(scene.alphaImages.size() == 2);
  CHECK(scene.materials[1].alphaImage == 0);
  CHECK(scene.materials[2].alphaImage == 1);
}

TEST_CASE("other sets of coordinates, quantisation and KHR_texture_transform are supported") {
  GltfFileMaker file = cutOut();
  textureOf(file)["texCoord"] = 1;
  CHECK(file.load().meshes[0].uvs == Floats{0, 0, 1, 0, 0.2f, 1});
  // The extension's example: the lower left quadrant of the image, rotated clockwise by 90 degrees.
  textureOf(file)["extensions"]["KHR_texture_transform"] = {
      {"offset", {0, 1}}, {"rotation", 1.57079632679}, {"scale", {0.5, 0.5}}, {"texCoord", 0}};
  const Floats uvs = file.load().meshes[0].uvs;
  const Floats expected = {0, 1, 0, 0.5f, 1, 0.875f};
  REQUIRE(uvs.size() == 6);
  for (size_t i = 0; i < 6; ++i) CHECK(std::abs(uvs[i] - expected[i]) < 1e-6f);
}

TEST_CASE("primitives that share positions but not texture coordinates get separate vertices") {
  GltfFileMaker file = cutOut();
  Json& primitives = file.json["meshes"][0]["primitives"];
  const bool sharedByMeshes = GENERATE(false, true);
  if (sharedByMeshes) {
    file.json["meshes"].push_back(file.json["meshes"][0]);
    file.node({{"mesh", 1}});
  }
  Json solid = primitives[0], moved = primitives[0];
  solid.erase("material");
  file.json["materials"].push_back(file.json["materials"][0]);
  file.json["materials"][1]["pbrMetallicRoughness"]["baseColorTexture"]["texCoord"] = 1;
  moved["material"] = 1;
  primitives.push_back(solid);
  primitives.push_back(moved);
  primitives.push_back(primitives[0]);
  const Scene scene = file.load();
  validate(scene);
  const Mesh& mesh = scene.meshes[0];
  CHECK(mesh.vertexCount() == 9);
  CHECK(mesh.indices == Indices{0, 1, 2, 3, 4, 5, 6, 7, 8, 0, 1, 2});
  CHECK(mesh.uvs == Floats{0, 0, 1, 0, 0.25f, 2, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0.2f, 1});
  for (size_t v = 3; v < 9; ++v)
    for (size_t c = 0; c < 3; ++c) CHECK(mesh.positions[3 * v + c] == mesh.positions[3 * (v % 3) + c]);
}

TEST_CASE("textures without holes are not read") {
  GltfFileMaker file = cutOut();
  SECTION("opaque") {
    file.json["materials"][0]["alphaMode"] = "OPAQUE";
  }
  SECTION("blended") {
    file.json["materials"][0]["alphaMode"] = "BLEND";
  }
  SECTION("without alpha") {
    file = cutOut(kSolid);
  }
  SECTION("JPEG") {
    file = cutOut(packed({0xff, 0xd8, 0xff, 0xe0, 0, 1}));
  }
  const Scene scene = file.load();
  validate(scene);
  CHECK(scene.alphaImages.empty());
  CHECK(scene.materials[0].alphaImage == kNoImage);
  CHECK(scene.meshes[0].uvs.empty());
  CHECK(scene.unreadImages == 0);
}

TEST_CASE("images that are missing or of another format are counted, and the material has no holes") {
  GltfFileMaker file = cutOut();
  SECTION("no such file") {
    file = cutOut("missing.png");
  }
  SECTION("KTX2") {
    file = cutOut(packed({0xab, 'K', 'T', 'X', ' ', '2', '0', 0xbb}));
  }
  SECTION("only an extension's source") {
    file.json["textures"][0] = {{"extensions", {{"KHR_texture_basisu", {{"source", 0}}}}}};
  }
  const Scene scene = file.load();
  validate(scene);
  CHECK(scene.unreadImages == 1);
  CHECK(scene.materials[0].alphaImage == kNoImage);
  CHECK(scene.meshes[0].uvs.empty());
}

TEST_CASE("a broken image is an error that names it") {
  std::vector<uint8_t> png = unpacked(kHoles);
  std::vector<uint8_t> huge = png, cut = png;
  huge[18] = 0x7f;  // the image's width
  cut.resize(45);
  CHECK_THAT(cutOut(packed(huge)).failure(), ContainsSubstring("material 0 'leaf': image 0 has 32514 x 2 pixels"));
  CHECK_THAT(cutOut(packed(cut)).failure(), ContainsSubstring("material 0 'leaf': image 0 is not a valid PNG file"));
  for (size_t length = 8; length < png.size() - 12; ++length) {
    INFO(length << " bytes");
    CHECK_THAT(cutOut(packed({png.begin(), png.begin() + static_cast<ptrdiff_t>(length)})).failure(),
               ContainsSubstring("not a valid PNG"));
  }
  CHECK_THAT(cutOut("data:image/png,abc").failure(), ContainsSubstring("image 0 has a data URI that is not base64"));
}

TEST_CASE("an image whose data unpack to far more than its pixels is refused before they are unpacked") {
  // A block of deflate with fixed codes: a literal, and then 40,000 copies of 258 bytes, which are 10 MB.
  std::vector<uint8_t> data = {0x78, 0x01};
  uint32_t bits = 0;
  int count = 0;
  const auto add = [&](uint32_t code, int length) {  // codes begin with their greatest bit
    for (int i = length - 1; i >= 0; --i) {
      bits |= (code >> i & 1) << count;
      if (++count < 8) continue;
      data.push_back(static_cast<uint8_t>(bits));
      bits = 0;
      count = 0;
    }
  };
  add(0b110, 3);  // the last block; its kind is 01, with the smallest bit first
  add(0b00110000, 8);
  for (int i = 0; i < 40000; ++i) add(0b1100010100000, 13);
  add(0, 7);
  data.insert(data.end(), 5,
              static_cast<uint8_t>(bits));  // the last bits, and in place of a checksum what nobody reads
  std::vector<uint8_t> png = unpacked(kSolid);
  png.resize(33);  // the signature and IHDR
  const auto chunk = [&](const char* name, const std::vector<uint8_t>& of) {
    for (int shift = 24; shift >= 0; shift -= 8) png.push_back(static_cast<uint8_t>(of.size() >> shift));
    png.insert(png.end(), name, name + 4);
    png.insert(png.end(), of.begin(), of.end());
    png.insert(png.end(), 4, 0);
  };
  chunk("IDAT", data);
  chunk("IEND", {});
  CHECK_THAT(cutOut(packed(png)).failure(),
             ContainsSubstring("its data unpack to far more bytes than its 1 x 1 pixels need"));
}

TEST_CASE("invalid texture indices are errors that name them") {
  GltfFileMaker file = cutOut();
  textureOf(file)["index"] = 1;
  CHECK_THAT(file.failure(), ContainsSubstring("material 0 'leaf': texture 1 does not exist"));
  file = cutOut();
  file.json["textures"][0]["source"] = 3;
  CHECK_THAT(file.failure(), ContainsSubstring("image 3 does not exist"));
  file = cutOut();
  file.json["textures"][0]["sampler"] = 3;
  CHECK_THAT(file.failure(), ContainsSubstring("sampler 3 does not exist"));
  file = cutOut();
  file.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = file.accessor(Floats{0, 0}, "VEC2");
  CHECK_THAT(file.failure(), ContainsSubstring("texture coordinates for 1 vertices, there are 3"));
  file = cutOut();
  file.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = 0;
  CHECK_THAT(file.failure(), ContainsSubstring("accessor 0 of texture coordinates is not VEC2"));
  file = cutOut();
  textureOf(file)["texCoord"] = 2;  // the set is missing, so all coordinates are 0 as on a GPU
  CHECK(file.load().meshes[0].uvs == Floats(6, 0));
}

TEST_CASE("validate refuses factors of a material outside 0..1, and NaN") {
  const Scene good = cutOut().load();
  const auto refused = [&](const std::function<void(Material&)>& change, const std::string& why) {
    Scene scene = good;
    scene.materials[0].name = "leaf";
    change(scene.materials[0]);
    CHECK_THROWS_WITH(validate(scene), "material 0 ('leaf'): its " + why);
  };
  refused([](Material& m) { m.metallic = 9; }, "metallic factor must be 0..1, is 9");
  refused([](Material& m) { m.roughness = -2; }, "roughness must be 0..1, is -2");
  refused([](Material& m) { m.transmission = 4; }, "transmission must be 0..1, is 4");
  refused([](Material& m) { m.baseColor[3] = std::nanf(""); }, "base colour must be 0..1, is nan");
  refused([](Material& m) { m.retro = 2e6f; }, "retro-reflection must be 0..1e+06, is 2e+06");
  refused([](Material& m) { m.retro = std::nanf(""); }, "retro-reflection must be 0..1e+06, is nan");
  struct Commas : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
  };
  const std::locale before = std::locale::global(std::locale(std::locale(), new Commas));
  refused([](Material& m) { m.metallic = 1.5f; }, "metallic factor must be 0..1, is 1.5");
  std::locale::global(before);
}

TEST_CASE("validate refuses invalid images and coordinates") {
  const Scene good = cutOut().load();
  Scene scene = good;
  scene.alphaImages[0].alpha.pop_back();
  CHECK_THROWS_WITH(validate(scene), ContainsSubstring("alpha image 0: 2 x 2 pixels need as many values"));
  scene.alphaImages[0] = {0, 2, {}};
  CHECK_THROWS_WITH(validate(scene), ContainsSubstring("alpha image 0: 0 x 2 pixels are none"));
  scene = good;
  scene.materials[0].alphaImage = 1;
  CHECK_THROWS_WITH(validate(scene), ContainsSubstring("material 0: alpha image 1 does not exist"));
  scene = good;
  scene.meshes[0].uvs.pop_back();
  CHECK_THROWS_WITH(validate(scene), ContainsSubstring("3 vertices need two texture coordinates"));
  scene.meshes[0].uvs.clear();
  CHECK_THROWS_WITH(validate(scene), ContainsSubstring("the mesh has no uvs for it"));
}

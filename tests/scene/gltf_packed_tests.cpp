// SPDX-License-Identifier: Apache-2.0
// Compressed glTF, compressed in the tests by the codecs' own encoders.
#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#include <meshoptimizer.h>

#include <array>
#include <catch2/generators/catch_generators.hpp>
#include <cmath>
#include <tuple>
#include <utility>

#include "scene/readers.hpp"
#include "scene_text.hpp"

using namespace gnosphere;
using namespace gnosphere::test;

namespace {

/// A wavy grid, so that the compression is not trivial.
void makeGrid(Floats& positions, Indices& indices) {
  constexpr uint32_t kSide = 5;
  for (uint32_t y = 0; y < kSide; ++y)
    for (uint32_t x = 0; x < kSide; ++x)
      for (uint32_t value : {x, y, x * y % 3}) positions.push_back(static_cast<float>(value));
  for (uint32_t y = 0; y + 1 < kSide; ++y)
    for (uint32_t x = 0; x + 1 < kSide; ++x) {
      const uint32_t a = y * kSide + x;
      for (uint32_t i : {a, a + 1, a + kSide, a + 1, a + kSide + 1, a + kSide}) indices.push_back(i);
    }
}

}  // namespace

TEST_CASE("EXT_meshopt_compression is decoded in every mode, with a fallback buffer that has no bytes") {
  Floats positions;
  Indices indices;
  makeGrid(positions, indices);
  const size_t vertices = positions.size() / 3;
  std::string packed(meshopt_encodeVertexBufferBound(vertices, 12), '\0');
  const auto data = [](std::string& text) { return reinterpret_cast<unsigned char*>(text.data()); };
  const bool exponential = GENERATE(false, true);
  if (exponential) {
    Indices filtered(positions.size());
#if MESHOPTIMIZER_VERSION > 180  // before, a vector always had one exponent
    meshopt_encodeFilterExp(filtered.data(), vertices, 12, 16, positions.data(), meshopt_EncodeExpSharedVector);
#else
    meshopt_encodeFilterExp(filtered.data(), vertices, 12, 16, positions.data());
#endif
    packed.resize(meshopt_encodeVertexBuffer(data(packed), packed.size(), filtered.data(), vertices, 12));
  } else {
    packed.resize(meshopt_encodeVertexBuffer(data(packed), packed.size(), positions.data(), vertices, 12));
  }
  const bool sequence = GENERATE(false, true);
  std::string order(meshopt_encodeIndexBufferBound(indices.size(), vertices) +
                        meshopt_encodeIndexSequenceBound(indices.size(), vertices),
                    '\0');
  order.resize(sequence ? meshopt_encodeIndexSequence(data(order), order.size(), indices.data(), indices.size())
                        : meshopt_encodeIndexBuffer(data(order), order.size(), indices.data(), indices.size()));

  GltfFileMaker file;
  const size_t start = file.bytes.size();
  file.bytes = packed;
  file.bytes.resize((packed.size() + 3) / 4 * 4);
  const size_t second = file.bytes.size();
  file.bytes += order;
  const auto addView = [&](size_t offset, size_t size, size_t stride, size_t count, const char* mode) {
    return file.push("bufferViews", {{"buffer", 1},
                                     {"byteLength", stride * count},
                                     {"extensions",
                                      {{"EXT_meshopt_compression",
                                        {{"buffer", 0},
                                         {"byteOffset", offset},
                                         {"byteLength", size},
                                         {"byteStride", stride},
                                         {"count", count},
                                         {"mode", mode}}}}}});
  };
  addView(start, packed.size(), 12, vertices, "ATTRIBUTES");
  addView(second, order.size(), 4, indices.size(), sequence ? "INDICES" : "TRIANGLES");
  if (exponential) file.json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"]["filter"] = "EXPONENTIAL";
  file.push("accessors", {{"bufferView", 0}, {"componentType", 5126}, {"type", "VEC3"}, {"count", vertices}});
  file.push("accessors", {{"bufferView", 1}, {"componentType", 5125}, {"type", "SCALAR"}, {"count", indices.size()}});
  file.mesh({{"attributes", {{"POSITION", 0}}}, {"indices", 1}});
  file.node({{"mesh", 0}});
  file.json["extensionsRequired"] = {"EXT_meshopt_compression"};
  file.text();
  file.json["buffers"].push_back(
      {{"byteLength", 4096}, {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}});
  const std::string text = file.json.dump();

  const Scene scene = loadText("made.gltf", text);
  CHECK(scene.meshes.at(0).positions == positions);
  // The triangle codec may rotate a triangle's corners.
  const Indices& read = scene.meshes.at(0).indices;
  REQUIRE(read.size() == indices.size());
  for (size_t t = 0; t < read.size(); t += 3) {
    bool same = false;
    for (size_t turn = 0; turn < 3; ++turn)
      same = same || (read[t] == indices[t + turn] && read[t + 1] == indices[t + (turn + 1) % 3] &&
                      read[t + 2] == indices[t + (turn + 2) % 3]);
    CHECK(same);
  }
  file.json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"]["byteLength"] = packed.size() / 2;
  CHECK_THAT(loadFailure("made.gltf", file.json.dump()),
             ContainsSubstring("bufferView 0 (meshopt): its data is invalid"));
}

// The decoders assert what the extension promises.
TEST_CASE("EXT_meshopt_compression of sizes, modes and filters that the extension does not have is an error") {
  const auto failure = [](size_t bytes, size_t count, size_t stride, const char* mode, const char* filter = "NONE") {
    GltfFileMaker file = triangleFile();
    Json& view = file.json["bufferViews"][0];
    view["byteLength"] = bytes;
    view["extensions"]["EXT_meshopt_compression"] = {{"buffer", 0},    {"byteLength", 36}, {"byteStride", stride},
                                                     {"count", count}, {"mode", mode},     {"filter", filter}};
    return file.failure();
  };
  const std::string who = "mesh 0 'tri', primitive 0: accessor 0, bufferView 0 (meshopt): ";
  CHECK_THAT(failure(40, 3, 12, "ATTRIBUTES"), ContainsSubstring(who + "count times byteStride is not its byteLength"));
  for (const auto& [count, stride, mode] :
       {std::tuple{3, 12, "FACES"}, std::tuple{3, 12, "TRIANGLES"}, std::tuple{4, 4, "TRIANGLES"},
        std::tuple{3, 1, "INDICES"}, std::tuple{3, 260, "ATTRIBUTES"}, std::tuple{3, 6, "ATTRIBUTES"}}) {
    const std::string text = "mode '" + std::string(mode) + "' with " + std::to_string(count) + " elements of " +
                             std::to_string(stride) + " bytes is not one of the extension's";
    CHECK_THAT(failure(static_cast<size_t>(count) * static_cast<size_t>(stride), static_cast<size_t>(count),
                       static_cast<size_t>(stride), mode),
               ContainsSubstring(who + text));
  }
  for (const auto& [stride, mode, filter] :
       {std::tuple{12, "ATTRIBUTES", "OCTAHEDRAL"}, std::tuple{4, "ATTRIBUTES", "QUATERNION"},
        std::tuple{12, "ATTRIBUTES", "SMOOTH"}, std::tuple{4, "TRIANGLES", "EXPONENTIAL"}})
    CHECK_THAT(failure(3 * static_cast<size_t>(stride), 3, static_cast<size_t>(stride), mode, filter),
               ContainsSubstring("filter '" + std::string(filter) + "' does not fit elements of " +
                                 std::to_string(stride) + " bytes"));
}

TEST_CASE("the rotations of instances may be packed as quaternions") {
  // The filter stores the three components other than the greatest, and which that is.
  const Floats turns = {0, 0, 0, 1, 0, 0, std::sqrt(0.5f), std::sqrt(0.5f), 0.6f, 0, 0, 0.8f};
  std::vector<int16_t> filtered(turns.size());
  meshopt_encodeFilterQuat(filtered.data(), 3, 8, 16, turns.data());
  std::string packed(meshopt_encodeVertexBufferBound(3, 8), '\0');
  packed.resize(meshopt_encodeVertexBuffer(reinterpret_cast<unsigned char*>(packed.data()), packed.size(),
                                           filtered.data(), 3, 8));
  GltfFileMaker file = triangleFile();
  const int view = file.view(packed);
  Json& json = file.json["bufferViews"][static_cast<size_t>(view)];
  json["extensions"]["EXT_meshopt_compression"] = {{"buffer", 0},
                                                   {"byteOffset", json["byteOffset"]},
                                                   {"byteLength", packed.size()},
                                                   {"byteStride", 8},
                                                   {"count", 3},
                                                   {"mode", "ATTRIBUTES"},
                                                   {"filter", "QUATERNION"}};
  json["byteLength"] = 24;
  json.erase("byteOffset");
  const int rotations =
      file.push("accessors",
                {{"bufferView", view}, {"componentType", 5122}, {"type", "VEC4"}, {"count", 3}, {"normalized", true}});
  file.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {{"ROTATION", rotations}};
  const Scene scene = file.load();
  REQUIRE(scene.instances.size() == 3);
  const std::array<double, 3> expected[] = {{1, 2, 3}, {-2, 1, 3}, {1, 2 * 0.28 - 3 * 0.96, 2 * 0.96 + 3 * 0.28}};
  for (size_t i = 0; i < 3; ++i) {
    const auto found = at(scene.instances[i].transform, 1, 2, 3);
    for (size_t axis = 0; axis < 3; ++axis) CHECK(std::abs(found[axis] - expected[i][axis]) < 1e-3);
  }
}

TEST_CASE("KHR_draco_mesh_compression is decoded without other accessors") {
  Floats positions;
  Indices indices;
  makeGrid(positions, indices);
  draco::TriangleSoupMeshBuilder builder;
  builder.Start(static_cast<int>(indices.size() / 3));
  const int attribute = builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  for (size_t t = 0; t < indices.size() / 3; ++t)
    builder.SetAttributeValuesForFace(attribute, draco::FaceIndex(static_cast<uint32_t>(t)),
                                      &positions[3 * indices[3 * t]], &positions[3 * indices[3 * t + 1]],
                                      &positions[3 * indices[3 * t + 2]]);
  // Vertices follow joint 1 by x / 4 and joint 0 by the rest.
  const int joints = builder.AddAttribute(draco::GeometryAttribute::GENERIC, 4, draco::DT_UINT8),
            weights = builder.AddAttribute(draco::GeometryAttribute::GENERIC, 4, draco::DT_FLOAT32);
  const int uvs = builder.AddAttribute(draco::GeometryAttribute::TEX_COORD, 2, draco::DT_FLOAT32);
  const uint8_t kJoints[4] = {0, 1, 0, 0};
  const auto uvOf = [](const float* position) { return std::array<float, 2>{position[0] / 4, position[1] / 8}; };
  for (size_t t = 0; t < indices.size() / 3; ++t) {
    float shares[3][4] = {};
    for (size_t k = 0; k < 3; ++k) {
      shares[k][1] = positions[3 * indices[3 * t + k]] / 4;
      shares[k][0] = 1 - shares[k][1];
    }
    const draco::FaceIndex face(static_cast<uint32_t>(t));
    builder.SetAttributeValuesForFace(joints, face, kJoints, kJoints, kJoints);
    builder.SetAttributeValuesForFace(weights, face, shares[0], shares[1], shares[2]);
    std::array<float, 2> corners[3];
    for (size_t k = 0; k < 3; ++k) corners[k] = uvOf(&positions[3 * indices[3 * t + k]]);
    builder.SetAttributeValuesForFace(uvs, face, corners[0].data(), corners[1].data(), corners[2].data());
  }
  const auto mesh = builder.Finalize();
  draco::Encoder encoder;
  encoder.SetEncodingMethod(draco::MESH_SEQUENTIAL_ENCODING);  // keeps the order and the bits
  draco::EncoderBuffer buffer;
  REQUIRE(encoder.EncodeMeshToBuffer(*mesh, &buffer).ok());

  GltfFileMaker file;
  const int view = file.view({buffer.data(), buffer.size()});
  file.push("accessors", {{"componentType", 5126}, {"type", "VEC3"}, {"count", 25}});
  file.push("accessors", {{"componentType", 5125}, {"type", "SCALAR"}, {"count", indices.size()}});
  file.mesh({{"attributes", {{"POSITION", 0}}}, {"indices", 1}});
  file.json["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"] = {
      {"bufferView", view}, {"attributes", {{"POSITION", mesh->attribute(attribute)->unique_id()}}}};
  file.node({{"mesh", 0}});
  file.json["extensionsRequired"] = {"KHR_draco_mesh_compression"};
  const Scene scene = file.load();
  const Mesh& read = scene.meshes.at(0);
  REQUIRE(read.indices.size() == indices.size());
  for (size_t i = 0; i < indices.size(); ++i)
    for (size_t c = 0; c < 3; ++c) CHECK(read.positions[3 * read.indices[i] + c] == positions[3 * indices[i] + c]);

  file.json["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"]["attributes"]["POSITION"] = 77;
  CHECK_THAT(file.failure(), ContainsSubstring("its Draco data has no positions under attribute 77"));
  file.json["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"]["attributes"]["POSITION"] =
      mesh->attribute(attribute)->unique_id();

  GltfFileMaker skinned = file;
  Json& primitive = skinned.json["meshes"][0]["primitives"][0];
  for (const auto& [name, extra] : {std::pair("JOINTS_0", joints), std::pair("WEIGHTS_0", weights)}) {
    primitive["attributes"][name] = 0;  // its accessor must not be read
    primitive["extensions"]["KHR_draco_mesh_compression"]["attributes"][name] = mesh->attribute(extra)->unique_id();
  }
  skinned.json["skins"] = {{{"joints", {1, 2}}}};
  skinned.json["nodes"][0]["skin"] = 0;
  skinned.node({{"name", "low"}});
  skinned.node({{"name", "high"}, {"translation", {0, 0, 8}}});
  const Mesh bent = skinned.load().meshes.at(0);
  const Floats deformed = deformedPositions(bent, bent.deformation);
  REQUIRE(bent.indices.size() == indices.size());
  for (size_t i = 0; i < indices.size(); ++i)
    CHECK(std::abs(deformed[3 * bent.indices[i] + 2] -
                   (positions[3 * indices[i] + 2] + 2 * positions[3 * indices[i]])) < 1e-5);

  const auto attributesOf = [](GltfFileMaker& maker) -> Json& {
    return maker.json["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"]["attributes"];
  };
  attributesOf(skinned).erase("WEIGHTS_0");
  CHECK_THAT(skinned.failure(), ContainsSubstring("its Draco data has no WEIGHTS_0"));
  attributesOf(skinned).erase("POSITION");
  CHECK_THAT(skinned.failure(), ContainsSubstring("its Draco data has no POSITION"));

  // Texture coordinates are in the Draco data, or else in an accessor of their own.
  GltfFileMaker cutOut = file;
  cutOut.json["materials"] =
      Json::parse(R"([{"alphaMode": "MASK", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}])");
  cutOut.json["textures"] = Json::parse(R"([{"source": 0}])");
  cutOut.json["images"] = {{{"uri", "data:image/png;base64," + base64(bytesOf(pngOf({1, 2, {0, 255}})))}}};
  const std::vector<float> plain(2 * read.vertexCount(), 0.25f);
  const int accessor = cutOut.accessor(plain, "VEC2");
  Json& leaf = cutOut.json["meshes"][0]["primitives"][0];
  leaf["material"] = 0;
  leaf["attributes"]["TEXCOORD_0"] = accessor;
  CHECK(cutOut.load().meshes.at(0).uvs == plain);
  attributesOf(cutOut)["TEXCOORD_0"] = mesh->attribute(uvs)->unique_id();
  const Mesh textured = cutOut.load().meshes.at(0);
  REQUIRE(textured.uvs.size() == 2 * textured.vertexCount());
  for (size_t vertex = 0; vertex < textured.vertexCount(); ++vertex)
    for (size_t c = 0; c < 2; ++c) CHECK(textured.uvs[2 * vertex + c] == uvOf(&textured.positions[3 * vertex])[c]);

  file.json["bufferViews"][0]["byteLength"] = buffer.size() / 2;
  CHECK_THAT(file.failure(), ContainsSubstring("mesh 0, primitive 0: its Draco data is invalid"));
}

// SPDX-License-Identifier: Apache-2.0
// Invalid glTF gives an Error that names the cause.
#include <cstring>
#include <memory>

#include "scene/readers.hpp"
#include "scene_text.hpp"

using namespace gnosphere;
using namespace gnosphere::test;

TEST_CASE("glTF that is empty, of another format or cut off is an error") {
  CHECK_THAT(loadFailure("a.gltf", ""), ContainsSubstring("a.gltf': the file is empty"));
  CHECK_THAT(loadFailure("a.gltf", "hello"), ContainsSubstring("it is neither glTF text nor GLB"));
  CHECK_THAT(loadFailure("a.gltf", "[]"), ContainsSubstring("has no asset.version"));
  CHECK_THAT(loadFailure("a.gltf", "{}"), ContainsSubstring("has no asset.version"));
  CHECK_THAT(loadFailure("a.gltf", R"({"asset": {"version": "1.0"}})"), ContainsSubstring("glTF version '\"1.0\"'"));
  std::string text = triangleFile().text();
  CHECK_THAT(loadFailure("a.gltf", text.substr(0, text.size() / 2)), ContainsSubstring("neither glTF text nor GLB"));
  GltfFileMaker file = triangleFile();
  const std::string glb = file.glb();
  CHECK_THAT(loadFailure("a.glb", glb.substr(0, 10)), ContainsSubstring("cut off in its header"));
  CHECK_THAT(loadFailure("a.glb", glb.substr(0, glb.size() - 8)),
             ContainsSubstring("cut off: its header says " + std::to_string(glb.size())));
  CHECK_THAT(loadFailure("a.gltf", std::string(100'000, '[')), ContainsSubstring("nests deeper than 64 levels"));
}

TEST_CASE("a GLB of another version, or whose chunks do not fit, is an error, and unknown chunks are skipped") {
  GltfFileMaker file = triangleFile();
  const std::string glb = file.glb();
  const auto edited = [&](size_t place, uint32_t word) {
    return std::string(glb).replace(place, 4, bytesOf(Indices{word}));
  };
  const auto failure = [&](size_t place, uint32_t word) { return loadFailure("a.glb", edited(place, word)); };
  CHECK_THAT(failure(4, 1), ContainsSubstring("it is GLB version 1; convert it to version 2"));
  CHECK_THAT(failure(4, 3), ContainsSubstring("it is GLB version 3"));
  CHECK_THAT(failure(12, 100'000), ContainsSubstring("cut off in a chunk of 100000 bytes"));
  CHECK_THAT(failure(16, 0x12345678), ContainsSubstring("the GLB file has no JSON chunk"));
  // An unknown chunk between the two that glTF has.
  uint32_t jsonBytes = 0;
  std::memcpy(&jsonBytes, &glb[12], 4);
  const std::string unknown = bytesOf(Indices{4, 0x12345678, 9});
  std::string longer = edited(8, static_cast<uint32_t>(glb.size() + unknown.size()));
  longer.insert(20 + jsonBytes, unknown);
  CHECK(loadText("a.glb", longer).meshes.at(0).indices == Indices{0, 1, 2});
  // Without its binary chunk a buffer has no bytes.
  const uint32_t binary = 20 + jsonBytes;
  CHECK_THAT(loadFailure("a.glb", edited(8, binary).substr(0, binary)), ContainsSubstring("buffer 0 has no uri"));
}

TEST_CASE("every prefix of a GLB ends in an Error") {
  GltfFileMaker file = triangleFile();
  const std::string glb = file.glb();
  for (size_t size = 0; size < glb.size(); size += 7) loadFailure("a.glb", glb.substr(0, size));
}

TEST_CASE("an index out of range is an error that names mesh, index and accessor") {
  GltfFileMaker file = triangleFile();
  const int indices = file.accessor(std::vector<uint16_t>{0, 1, 9}, "SCALAR");
  file.json["meshes"][0]["primitives"][0]["indices"] = indices;
  CHECK_THAT(file.failure(),
             ContainsSubstring("mesh 0 'tri', primitive 0: index 9 is out of range, accessor 0 has 3 vertices"));
}

TEST_CASE("an accessor that exceeds its bufferView is an error that names both") {
  GltfFileMaker file = triangleFile();
  file.json["accessors"][0]["count"] = 4;
  CHECK_THAT(file.failure(),
             ContainsSubstring("mesh 0 'tri', primitive 0: accessor 0: 4 elements of 12 bytes from byte "
                               "0 end past bufferView 0 of 36 bytes"));
  file.json["accessors"][0]["count"] = 3;
  file.json["accessors"][0]["byteOffset"] = 4'000'000'000u;
  CHECK_THAT(file.failure(), ContainsSubstring("end past bufferView 0"));
}

TEST_CASE("a bufferView that exceeds its buffer, and a buffer shorter than stated, are errors") {
  GltfFileMaker file = triangleFile();
  file.json["bufferViews"][0]["byteLength"] = 4000;
  CHECK_THAT(file.failure(), ContainsSubstring("bufferView 0: a bufferView ends past the 42 bytes of buffer 0"));
  file.json["bufferViews"][0]["byteLength"] = 36;
  file.text();
  file.json["buffers"][0]["byteLength"] = 5000;
  CHECK_THAT(loadFailure("a.gltf", file.json.dump()), ContainsSubstring("buffer 0 is cut off: it should have 5000"));
}

TEST_CASE("references to missing objects are errors") {
  const auto failure = [](const char* pointer, const Json& value) {
    GltfFileMaker file = triangleFile();
    file.json[Json::json_pointer(pointer)] = value;
    return file.failure();
  };
  CHECK_THAT(failure("/nodes/0/mesh", 5), ContainsSubstring("node 0: mesh 5 does not exist"));
  CHECK_THAT(failure("/nodes/0/children", {7}), ContainsSubstring("node 0: child 7 does not exist"));
  CHECK_THAT(failure("/scenes", {{{"nodes", {3}}}}), ContainsSubstring("scene 0: node 3 does not exist"));
  CHECK_THAT(failure("/accessors/0/bufferView", 8), ContainsSubstring("accessor 0: bufferView 8 does not exist"));
  CHECK_THAT(failure("/bufferViews/1/buffer", 2), ContainsSubstring("bufferView 1: buffer 2 does not exist"));
  const std::string primitive = "/meshes/0/primitives/0";
  CHECK_THAT(failure((primitive + "/indices").c_str(), 6),
             ContainsSubstring("mesh 0 'tri', primitive 0: accessor 6 does"));
  CHECK_THAT(failure((primitive + "/attributes/POSITION").c_str(), 6), ContainsSubstring("accessor 6 does not exist"));
  CHECK_THAT(failure((primitive + "/material").c_str(), 1), ContainsSubstring("material 1 does not exist"));
  CHECK_THAT(failure((primitive + "/mode").c_str(), 7), ContainsSubstring("mode 7 does not exist"));
}

TEST_CASE("properties of a wrong type or size are errors that name them") {
  const auto failure = [](const char* pointer, const Json& value) {
    GltfFileMaker file = triangleFile();
    file.json[Json::json_pointer(pointer)] = value;
    return file.failure();
  };
  CHECK_THAT(failure("/accessors/0/count", -3), ContainsSubstring("accessors[0]: count must be a whole number"));
  CHECK_THAT(failure("/accessors/0/count", 1e300), ContainsSubstring("accessors[0]: count must be a whole number"));
  CHECK_THAT(failure("/accessors/0/byteOffset", -4), ContainsSubstring("accessors[0]: byteOffset must be"));
  CHECK_THAT(failure("/accessors/0/type", "VEC9"), ContainsSubstring("VEC9"));
  CHECK_THAT(failure("/accessors/0/type", "VEC2"), ContainsSubstring("accessor 0 of positions is not VEC3"));
  CHECK_THAT(failure("/accessors/1/componentType", 5122),
             ContainsSubstring("accessor 1 of indices is not SCALAR of unsi"));
  CHECK_THAT(failure("/accessors/0/componentType", 5130),
             ContainsSubstring("accessor 0 has a type that geometry cannot"));
  CHECK_THAT(failure("/bufferViews/0/byteStride", 8),
             ContainsSubstring("byteStride of 8 is less than its elements of 12"));
  CHECK_THAT(failure("/bufferViews/0/byteLength", "x"), ContainsSubstring("bufferViews[0]: byteLength must be"));
  CHECK_THAT(failure("/nodes/0/mesh", "tri"), ContainsSubstring("nodes[0]: mesh must be a whole number"));
  CHECK_THAT(failure("/nodes/0/matrix", {1, 2}), ContainsSubstring("nodes[0]: matrix must be 16 numbers"));
  CHECK_THAT(failure("/nodes/0/translation", {1, 2, "3"}),
             ContainsSubstring("nodes[0]: translation must be 3 numbers"));
  CHECK_THAT(failure("/nodes/0/children", {1.5}), ContainsSubstring("nodes[0]: children must be"));
  CHECK_THAT(failure("/meshes/0/primitives/0/attributes", 7), ContainsSubstring("attributes must be an object"));
  CHECK_THAT(failure("/materials/0/doubleSided", "yes"),
             ContainsSubstring("materials[0]: doubleSided must be true or false"));
  CHECK_THAT(failure("/nodes/0", 3), ContainsSubstring("nodes[0] must be an object"));
  CHECK_THAT(failure("/meshes", 3), ContainsSubstring("the file: meshes must be an array"));
  CHECK_THAT(failure("/accessors/0", Json::object()), ContainsSubstring("accessors[0]: componentType is missing"));
}

TEST_CASE("integers may be written with a decimal point") {
  GltfFileMaker file = triangleFile();
  file.json["accessors"][0]["count"] = 3.0;
  CHECK(file.load().uniqueTriangleCount() == 1);
}

TEST_CASE("a node cycle, a node with two parents and a scene with a child node are errors") {
  GltfFileMaker file = triangleFile();
  file.json["nodes"] = {{{"children", {1}}, {"name", "loop"}}, {{"children", {0}}}};
  CHECK_THAT(file.failure(), ContainsSubstring("node 0 'loop' is its own ancestor"));
  file.json["nodes"] = {{{"children", {0}}}};
  CHECK_THAT(file.failure(), ContainsSubstring("is its own ancestor"));
  file.json["nodes"] = {{{"children", {2}}}, {{"children", {2}}}, {{"mesh", 0}}};
  CHECK_THAT(file.failure(), ContainsSubstring("node 2 is listed as a child twice, by nodes 0 and 1"));
  file.json["nodes"] = {{{"children", {1}}}, {{"mesh", 0}}};
  file.json["scenes"] = {{{"nodes", {0, 1}}}};
  CHECK_THAT(file.failure(), ContainsSubstring("node 1 is not a root, it is a child of node 0"));
  file.json["scenes"] = {{{"nodes", {0, 0}}}};
  CHECK_THAT(file.failure(), ContainsSubstring("scene 0: node 0 is listed twice"));
}

TEST_CASE("a transform that is not finite is an error") {
  GltfFileMaker file = triangleFile();
  file.json["nodes"] = {{{"children", {1}}, {"scale", {1e200, 1, 1}}}, {{"mesh", 0}, {"scale", {1e200, 1, 1}}}};
  CHECK_THAT(file.failure(), ContainsSubstring("node 1: its transform is not finite"));
}

TEST_CASE("an unsupported required extension is named, and one that changes only the appearance is accepted") {
  GltfFileMaker file = triangleFile();
  file.json["extensionsRequired"] = {"KHR_materials_unlit", "KHR_texture_basisu", "EXT_made_up"};
  CHECK_THAT(file.failure(), ContainsSubstring("it requires the extension 'EXT_made_up'"));
  file.json["extensionsRequired"] = {"KHR_materials_unlit", "KHR_texture_basisu"};
  CHECK(file.load().uniqueTriangleCount() == 1);
}

TEST_CASE("missing images and unused buffers are accepted, a missing buffer in use is an error") {
  GltfFileMaker file = triangleFile();
  file.json["images"] = {{{"uri", "nowhere.png"}}, 3, {{"bufferView", 99}}};
  file.json["textures"] = {{{"source", 0}}};
  file.text();
  file.json["buffers"].push_back({{"byteLength", 10}, {"uri", "nowhere.bin"}});
  CHECK(loadText("a.gltf", file.json.dump()).uniqueTriangleCount() == 1);
  file.json["buffers"][0]["uri"] = "no%20where.bin";
  const std::string message = loadFailure("a.gltf", file.json.dump(), ErrorCode::file);
  CHECK_THAT(message, ContainsSubstring("needs buffer 0"));
  CHECK_THAT(message, ContainsSubstring("no where.bin"));
  file.json["buffers"][0].erase("uri");
  CHECK_THAT(loadFailure("a.gltf", file.json.dump()), ContainsSubstring("buffer 0 has no uri"));
  file.json["buffers"][0]["uri"] = "data:application/octet-stream;base64,a*b";
  CHECK_THAT(loadFailure("a.gltf", file.json.dump()), ContainsSubstring("whose base64 is invalid"));
}

TEST_CASE("a file that several buffers and images name is read once, and counts once for what may be unpacked") {
  GltfFileMaker file = triangleFile();
  file.text();
  file.json["buffers"] = Json::array();
  size_t i = 0;
  for (const char* name : {"a.bin", "./a.bin", "b/../a.bin", "%61.bin"}) {
    file.json["buffers"].push_back({{"byteLength", file.bytes.size()}, {"uri", name}});
    file.json["bufferViews"].push_back(file.json["bufferViews"][0]);
    file.json["bufferViews"].back()["buffer"] = i++;
    file.json["accessors"].push_back(file.json["accessors"][0]);
    file.json["accessors"].back()["bufferView"] = file.json["bufferViews"].size() - 1;
    file.json["meshes"].push_back(file.json["meshes"][0]);
    file.json["meshes"].back()["primitives"][0]["attributes"]["POSITION"] = file.json["accessors"].size() - 1;
    file.json["nodes"].push_back({{"mesh", file.json["meshes"].size() - 1}});
    file.json["images"].push_back({{"uri", name}});
    file.json["textures"].push_back({{"source", i - 1}});
    file.json["materials"].push_back(
        {{"alphaMode", "MASK"}, {"pbrMetallicRoughness", {{"baseColorTexture", {{"index", i - 1}}}}}});
  }
  size_t reads = 0;
  Source source;
  source.name = "made";
  source.sibling = [&](const std::string&) {
    ++reads;
    FileBytes bytes;
    bytes.data = std::make_unique<uint8_t[]>(file.bytes.size());
    bytes.size = file.bytes.size();
    std::memcpy(bytes.data.get(), file.bytes.data(), bytes.size);
    return bytes;
  };
  const auto read = [&] {
    const std::string text = file.json.dump();
    return readGltf({reinterpret_cast<const uint8_t*>(text.data()), text.size()}, source);
  };
  const Scene scene = read();
  CHECK(scene.unreadImages == 4);  // they are no pictures
  CHECK(scene.meshes.size() == 5);
  CHECK(scene.meshes.back().positions == scene.meshes.front().positions);
  CHECK(reads == 1);
  file.json["accessors"].back() = {{"componentType", 5126}, {"type", "VEC3"}, {"count", 4'000'000'000u}};
  const size_t bytes = file.json.dump().size() + file.bytes.size();
  CHECK_THROWS_WITH(read(), ContainsSubstring("than a file of " + std::to_string(bytes) + " bytes may unpack to"));
}

TEST_CASE("sparse indices out of range are errors") {
  GltfFileMaker file = triangleFile();
  const int which = file.view(bytesOf(std::vector<uint8_t>{3})), values = file.view(bytesOf(Floats{5, 6, 7}));
  file.json["accessors"][0]["sparse"] = {{"count", 1},
                                         {"indices", {{"bufferView", which}, {"componentType", 5121}}},
                                         {"values", {{"bufferView", values}}}};
  CHECK_THAT(file.failure(), ContainsSubstring("accessor 0 (sparse): index 3 is out of range, there are 3"));
  file.json["accessors"][0]["sparse"]["count"] = 2;
  CHECK_THAT(file.failure(), ContainsSubstring("(sparse), indices: 2 elements of 1 bytes"));
  for (const int type : {5120, 5122, 5126}) {
    file.json["accessors"][0]["sparse"]["indices"]["componentType"] = type;
    CHECK_THAT(file.failure(), ContainsSubstring("(sparse): its indices are not unsigned integers"));
  }
}

TEST_CASE("a small file cannot allocate much more memory than its size") {
  GltfFileMaker file = triangleFile();
  file.json["accessors"][0] = {{"componentType", 5126}, {"type", "VEC3"}, {"count", 4'000'000'000u}};
  CHECK_THAT(file.failure(), ContainsSubstring("4000000000 elements are more than a file of"));
  file.json["accessors"][0]["count"] = 5'000'000'000u;
  CHECK_THAT(file.failure(), ContainsSubstring("accessor 0 has 5000000000 elements; the limit is 4294967295"));
}

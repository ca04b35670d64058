// SPDX-License-Identifier: Apache-2.0
// Scene files that are made by hand.
#pragma once

#include <array>
#include <catch2/catch_test_macros.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "folder.hpp"
#include "gnosphere/error.hpp"
#include "gnosphere/scene.hpp"

namespace gnosphere::test {

using Json = nlohmann::ordered_json;
using Floats = std::vector<float>;
using Indices = std::vector<uint32_t>;

/// Keeps the file's own axes, without rotation.
inline const LoadOptions kAsStored = {UpAxis::z, 1};

inline Scene loadText(const std::string& name, const std::string& content, const LoadOptions& options = kAsStored) {
  const Folder folder;
  return loadScene(put(folder / name, content), options);
}

/// Returns the message of the Error(code) that loading throws.
inline std::string loadFailure(const std::string& name, const std::string& content,
                               ErrorCode code = ErrorCode::format) {
  try {
    loadText(name, content);
  } catch (const Error& error) {
    CHECK(error.code() == code);
    return error.what();
  }
  FAIL("it loads");
  return {};
}

template <typename T>
std::string bytesOf(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

inline std::string base64(const std::string& bytes) {
  constexpr const char* kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t bits = 0;
    for (size_t k = 0; k < 3; ++k) bits = bits << 8 | (i + k < bytes.size() ? static_cast<uint8_t>(bytes[i + k]) : 0u);
    for (size_t k = 0; k < 4; ++k) text += i + k <= bytes.size() ? kDigits[bits >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

template <typename T>
constexpr int componentType() {
  if constexpr (std::is_same_v<T, int8_t>) return 5120;
  if constexpr (std::is_same_v<T, uint8_t>) return 5121;
  if constexpr (std::is_same_v<T, int16_t>) return 5122;
  if constexpr (std::is_same_v<T, uint16_t>) return 5123;
  if constexpr (std::is_same_v<T, uint32_t>) return 5125;
  if constexpr (std::is_same_v<T, float>) return 5126;
}

/// A glTF file under construction; tests may change `json` before they use it.
struct GltfFileMaker {
  Json json = {{"asset", {{"version", "2.0"}}}};
  std::string bytes;

  int push(const char* array, Json item) {
    json[array].push_back(std::move(item));
    return static_cast<int>(json[array].size()) - 1;
  }
  int view(const std::string& data) {
    bytes.resize((bytes.size() + 3) / 4 * 4);
    const size_t offset = bytes.size();
    bytes += data;
    return push("bufferViews", {{"buffer", 0}, {"byteOffset", offset}, {"byteLength", data.size()}});
  }
  template <typename T>
  int accessor(const std::vector<T>& values, const char* type, Json more = Json::object()) {
    const size_t components = type == std::string("SCALAR") ? 1
                              : type == std::string("MAT4") ? 16
                                                            : static_cast<size_t>(type[3] - '0');  // VEC2 ...
    more.update({{"bufferView", view(bytesOf(values))},
                 {"componentType", componentType<T>()},
                 {"count", values.size() / components},
                 {"type", type}});
    return push("accessors", std::move(more));
  }
  int mesh(Json primitive) { return push("meshes", {{"primitives", Json::array({std::move(primitive)})}}); }
  int node(Json item) { return push("nodes", std::move(item)); }

  std::string text() {
    if (!bytes.empty())
      json["buffers"] = {
          {{"byteLength", bytes.size()}, {"uri", "data:application/octet-stream;base64," + base64(bytes)}}};
    return json.dump();
  }
  std::string glb() {
    json["buffers"] = {{{"byteLength", bytes.size()}}};
    std::string head = json.dump(), body = bytes;
    head.resize((head.size() + 3) / 4 * 4, ' ');
    body.resize((body.size() + 3) / 4 * 4);
    const auto size = [](const std::string& chunk) { return static_cast<uint32_t>(chunk.size()); };
    return bytesOf(Indices{0x46546C67, 2, 28 + size(head) + size(body), size(head), 0x4E4F534A}) + head +
           bytesOf(Indices{size(body), 0x004E4942}) + body;
  }
  Scene load(const LoadOptions& options = kAsStored) { return loadText("made.gltf", text(), options); }
  std::string failure(ErrorCode code = ErrorCode::format) { return loadFailure("made.gltf", text(), code); }
};

/// The square (0,0,0) (1,0,0) (0,1,0) (1,1,0): two triangles as a strip.
inline const Floats kSquare = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0};

/// A file with one mesh of one indexed triangle, and one instance.
inline GltfFileMaker triangleFile() {
  GltfFileMaker file;
  const int positions = file.accessor(Floats{0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3");
  const int indices = file.accessor(std::vector<uint16_t>{0, 1, 2}, "SCALAR");
  file.mesh({{"attributes", {{"POSITION", positions}}}, {"indices", indices}});
  file.json["meshes"][0]["name"] = "tri";
  file.node({{"mesh", 0}});
  return file;
}

inline std::array<double, 3> at(const Transform& transform, double x, double y, double z) {
  const Vec3 p = transform * Vec3{x, y, z};
  return {p.x, p.y, p.z};
}

using Catch::Matchers::ContainsSubstring;

}  // namespace gnosphere::test

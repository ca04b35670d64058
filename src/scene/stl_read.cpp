// SPDX-License-Identifier: Apache-2.0
// Reads STL files into a Scene. A reader of our own: CGAL 5.5 merges corners by operator<, so that a nan corner
// silently becomes another one, and assimp rounds to float.
#include <algorithm>
#include <array>
#include <cstring>
#include <string>
#include <unordered_map>
#include <vector>

#include "base/number.hpp"
#include "base/text.hpp"
#include "scene/origins.hpp"
#include "scene/readers.hpp"

namespace gnosphere {
namespace {

constexpr size_t kStlHeader = 84, kStlTriangle = 50;

using Corner = std::array<double, 3>;

struct CornerBits {
  size_t operator()(const Corner& corner) const {
    uint64_t hash = 0;
    for (double value : corner) {
      uint64_t bits;
      std::memcpy(&bits, &value, sizeof bits);
      hash = (hash ^ bits ^ (hash >> 29)) * 0x9E3779B97F4A7C15u;
    }
    return static_cast<size_t>(hash ^ (hash >> 32));
  }
  bool operator()(const Corner& a, const Corner& b) const { return std::memcmp(&a, &b, sizeof a) == 0; }
};

/// A mesh built from corners. STL has no indices: corners with the same bits become one vertex.
class StlMesh {
 public:
  explicit StlMesh(size_t triangles) {
    indices_.reserve(3 * triangles);
    vertices_.reserve(triangles / 2 + 3);
  }
  void add(const Corner& corner) {
    const auto [found, isNew] = vertices_.emplace(corner, static_cast<uint32_t>(coordinates_.size() / 3));
    if (isNew) coordinates_.insert(coordinates_.end(), corner.begin(), corner.end());
    indices_.push_back(found->second);
  }
  bool isEmpty() const { return indices_.empty(); }
  Mesh finish() {
    vertices_.clear();
    Mesh mesh;
    mesh.indices = std::move(indices_);
    storePositions(mesh, coordinates_);
    return mesh;
  }

 private:
  std::vector<double> coordinates_;
  std::vector<uint32_t> indices_;
  std::unordered_map<Corner, uint32_t, CornerBits, CornerBits> vertices_;
};

Scene readBinaryStl(Bytes bytes, size_t triangles) {
  StlMesh mesh(triangles);
  for (size_t i = 0; i < triangles; ++i) {
    std::array<float, 9> corners;
    std::memcpy(corners.data(), bytes.data() + kStlHeader + i * kStlTriangle + 12, sizeof corners);  // after the normal
    for (size_t c = 0; c < 9; c += 3) mesh.add({corners[c], corners[c + 1], corners[c + 2]});
  }
  std::vector<Mesh> meshes;
  meshes.push_back(mesh.finish());
  return sceneOf(std::move(meshes));
}

/// Whether a word is this keyword, which some programs write in capitals.
bool is(std::string_view word, std::string_view keyword) {
  return std::equal(word.begin(), word.end(), keyword.begin(), keyword.end(),
                    [](char a, char b) { return (a >= 'A' && a <= 'Z' ? a - 'A' + 'a' : a) == b; });
}

Scene readTextStl(Bytes bytes, const Source& source) {
  std::string_view rest = textOf(bytes, source);
  StlMesh mesh(bytes.size() / 200);
  std::string name;
  std::vector<Mesh> solids;
  const auto finishSolid = [&] {
    solids.push_back(mesh.finish());
    solids.back().name = name;
    mesh = StlMesh(0);
  };
  size_t triangles = 0, corners = 0;
  const auto checkFacet = [&](size_t wanted) {
    if (corners != wanted) source.fail("facet " + std::to_string(triangles) + " of the STL file has not 3 vertices");
  };
  bool ended = false;
  for (std::string_view word = nextWord(rest); !word.empty(); word = nextWord(rest)) {
    if (is(word, "solid") || is(word, "endsolid")) {
      // A name follows, which may contain any word.
      const std::string_view stated = rest.substr(0, rest.find('\n'));
      rest.remove_prefix(stated.size());
      ended = is(word, "endsolid");
      checkFacet(0);
      if (!mesh.isEmpty()) finishSolid();
      if (!ended) name = toUtf8(trimmed(stated));
    } else if (is(word, "vertex")) {
      Corner corner;
      for (double& value : corner) {
        const std::string_view number = nextWord(rest);
        if (!parseNumber(number, value))
          source.fail("triangle " + std::to_string(triangles) + " of the STL file has " + inQuotes(number) +
                      " where a coordinate should be");
        value = static_cast<float>(value);  // STL coordinates are floats in both of its forms
      }
      if (++corners > 3)
        source.fail("facet " + std::to_string(triangles) + " of the STL file has more than 3 vertices");
      mesh.add(corner);
    } else if (is(word, "endfacet")) {
      checkFacet(3);
      corners = 0;
      ++triangles;
    }
  }
  if (corners != 0 || !ended) source.fail("the STL file is cut off: it has no endsolid");
  if (!mesh.isEmpty() || solids.empty()) finishSolid();  // there may be facets after the last endsolid
  return sceneOf(std::move(solids));
}

}  // namespace

Scene readStl(Bytes bytes, const Source& source) {
  // Some binary files begin with "solid", the first word of text files, so the file size decides. Where bytes follow
  // the last triangle, the header does: its count of triangles has a byte of 0.
  size_t triangles = 0;
  if (bytes.size() >= kStlHeader) {
    uint32_t count;
    std::memcpy(&count, bytes.data() + 80, sizeof count);
    triangles = count;
    if (bytes.size() == kStlHeader + triangles * kStlTriangle) return readBinaryStl(bytes, triangles);
  }
  std::string_view text = textOf(bytes, source);
  const bool isText = text.substr(0, kStlHeader).find('\0') == text.npos;
  if (isText && is(nextWord(text), "solid")) return readTextStl(bytes, source);
  if (bytes.size() < kStlHeader) source.fail("it is not STL: it is too short and does not begin with 'solid'");
  if ((bytes.size() - kStlHeader) / kStlTriangle < triangles)
    source.fail("the STL file is cut off or not STL: its header claims " + std::to_string(triangles) +
                " triangles, it has room for " + std::to_string((bytes.size() - kStlHeader) / kStlTriangle));
  return readBinaryStl(bytes, triangles);  // there may be bytes after the last triangle
}

}  // namespace gnosphere

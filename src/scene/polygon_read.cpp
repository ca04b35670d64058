// SPDX-License-Identifier: Apache-2.0
// Reads PLY and STL without a library. CGAL 5.5, the only packaged one besides assimp, fails on 16-bit face lists and
// on nan, aborts on integer coordinates, allocates whatever a hostile list asks for, and merges the corners of an STL
// by operator<, so that a nan corner silently becomes another one. assimp rounds to float.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <unordered_map>

#include "scene/number.hpp"
#include "scene/readers.hpp"

namespace gnosphere {
namespace {

std::string_view textOf(Bytes bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

Scene sceneOf(Mesh&& mesh) {
  Scene scene;
  scene.materials.emplace_back();
  mesh.parts = {{0, static_cast<uint32_t>(mesh.triangleCount()), 0}};
  scene.meshes.push_back(std::move(mesh));
  scene.instances.emplace_back();
  return scene;
}

// ---- PLY ----

enum class PlyType { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::float32;
  bool isList = false;
  PlyType countType = PlyType::uint8;
};

struct PlyElement {
  std::string name;
  size_t count = 0;
  std::vector<PlyProperty> properties;
};

constexpr std::array<size_t, 8> kPlySizes = {1, 1, 2, 2, 4, 4, 4, 8};

class PlyReader {
 public:
  PlyReader(Bytes bytes, const Source& source) : rest_(textOf(bytes)), source_(source) {}

  Scene read() {
    readHeader();
    for (const PlyElement& element : elements_) {
      if (element.name == "vertex" || element.name == "vertices")
        readVertices(element);
      else if (element.name == "face" || element.name == "faces")
        readFaces(element);
      else if (element.name == "tristrips")
        source_.fail("it holds triangle strips; convert it to faces");
      else
        skip(element);
    }
    return finish();
  }

 private:
  std::string_view nextLine() {
    const size_t end = rest_.find('\n');
    if (end == rest_.npos) source_.fail("the PLY file is cut off in its header");
    std::string_view line = rest_.substr(0, end);
    rest_.remove_prefix(end + 1);
    return line;
  }

  PlyType type(std::string_view word) const {
    static constexpr std::array<std::array<std::string_view, 2>, 8> kNames = {{{"char", "int8"},
                                                                               {"uchar", "uint8"},
                                                                               {"short", "int16"},
                                                                               {"ushort", "uint16"},
                                                                               {"int", "int32"},
                                                                               {"uint", "uint32"},
                                                                               {"float", "float32"},
                                                                               {"double", "float64"}}};
    for (size_t i = 0; i < kNames.size(); ++i)
      if (word == kNames[i][0] || word == kNames[i][1]) return static_cast<PlyType>(i);
    source_.fail("the PLY header names an unknown type " + inQuotes(word));
  }

  void readHeader() {
    std::string_view line = nextLine();
    if (nextWord(line) != "ply") source_.fail("it is not PLY: its first line is not 'ply'");
    bool formatKnown = false;
    for (;;) {
      line = nextLine();
      const std::string_view keyword = nextWord(line);
      if (keyword == "end_header") break;
      if (keyword == "format") {
        const std::string_view format = nextWord(line);
        if (format != "ascii" && format != "binary_little_endian" && format != "binary_big_endian")
          source_.fail("the PLY format " + inQuotes(format) + " does not exist");
        isText_ = format == "ascii";
        swapped_ = format == "binary_big_endian";
        formatKnown = true;
      } else if (keyword == "element") {
        PlyElement& element = elements_.emplace_back();
        element.name = nextWord(line);
        double count = -1;
        if (!parseNumber(nextWord(line), count) || !(count >= 0) || count != std::floor(count))
          source_.fail("the PLY header gives no valid count for element " + inQuotes(element.name));
        // Every item takes at least one byte (an empty list has its count), so the file cannot hold more.
        if (count > static_cast<double>(rest_.size()))
          source_.fail("the PLY header claims more items of " + inQuotes(element.name) + " than the file has bytes");
        element.count = static_cast<size_t>(count);
      } else if (keyword == "property") {
        if (elements_.empty()) source_.fail("the PLY header has a property before the first element");
        PlyProperty& property = elements_.back().properties.emplace_back();
        std::string_view word = nextWord(line);
        property.isList = word == "list";
        if (property.isList) {
          property.countType = type(nextWord(line));
          if (property.countType >= PlyType::float32)
            source_.fail("the PLY header has a list whose count is no integer");
          word = nextWord(line);
        }
        property.type = type(word);
        property.name = nextWord(line);
      }
    }
    if (!formatKnown) source_.fail("the PLY header names no format");
  }

  /// Skips to the next line of a text file: an item may have more values than the header states (VCGLIB's wedge
  /// colours).
  void endItem() {
    if (isText_) rest_.remove_prefix(std::min(rest_.find('\n'), rest_.size()));
  }

  double value(PlyType type, const char* what) {
    double value = 0;
    if (isText_) {
      const std::string_view word = nextWord(rest_);
      if (word.empty()) source_.fail(std::string("the PLY file is cut off in its ") + what);
      if (!parseNumber(word, value))
        source_.fail(std::string("the PLY file has ") + inQuotes(word) + " where its " + what + " need a number");
      // Text may have more digits than the declared type.
      return type == PlyType::float32 ? static_cast<float>(value) : value;
    }
    const size_t size = kPlySizes[static_cast<size_t>(type)];
    if (rest_.size() < size) source_.fail(std::string("the PLY file is cut off in its ") + what);
    std::array<char, 8> raw = {};
    std::memcpy(raw.data(), rest_.data(), size);
    rest_.remove_prefix(size);
    if (swapped_) std::reverse(raw.begin(), raw.begin() + static_cast<std::ptrdiff_t>(size));
    switch (type) {
      case PlyType::int8: return as<int8_t>(raw);
      case PlyType::uint8: return as<uint8_t>(raw);
      case PlyType::int16: return as<int16_t>(raw);
      case PlyType::uint16: return as<uint16_t>(raw);
      case PlyType::int32: return as<int32_t>(raw);
      case PlyType::uint32: return as<uint32_t>(raw);
      case PlyType::float32: return as<float>(raw);
      case PlyType::float64: return as<double>(raw);
    }
    return 0;
  }

  template <typename T>
  static double as(const std::array<char, 8>& raw) {
    T value;
    std::memcpy(&value, raw.data(), sizeof value);
    return value;
  }

  size_t listCount(const PlyProperty& property, const char* what) {
    const double count = value(property.countType, what);
    if (!(count >= 0) || count > static_cast<double>(rest_.size()))
      source_.fail(std::string("the PLY file has a list longer than the file in its ") + what);
    return static_cast<size_t>(count);
  }

  void skip(const PlyProperty& property, const char* what) {
    const size_t count = property.isList ? listCount(property, what) : 1;
    for (size_t i = 0; i < count; ++i) value(property.type, what);
  }

  void skip(const PlyElement& element) {
    if (element.properties.empty()) return;
    for (size_t i = 0; i < element.count; ++i) {
      for (const PlyProperty& property : element.properties) skip(property, "data");
      endItem();
    }
  }

  void readVertices(const PlyElement& element) {
    if (element.count > 0)
      for (const char* name : {"x", "y", "z"})
        if (std::none_of(element.properties.begin(), element.properties.end(),
                         [&](const PlyProperty& p) { return p.name == name && !p.isList; }))
          source_.fail(std::string("the vertices of the PLY file have no ") + name);
    coordinates_.reserve(3 * element.count);
    for (size_t i = 0; i < element.count; ++i) {
      std::array<double, 3> point = {};
      for (const PlyProperty& property : element.properties) {
        const size_t axis =
            property.name.size() == 1 && !property.isList ? static_cast<size_t>(property.name[0]) - 'x' : 3;
        if (axis < 3)
          point[axis] = value(property.type, "vertices");
        else
          skip(property, "vertices");
      }
      endItem();
      coordinates_.insert(coordinates_.end(), point.begin(), point.end());
    }
  }

  void readFaces(const PlyElement& element) {
    const auto isCorners = [](const PlyProperty& p) {
      return p.isList && (p.name == "vertex_indices" || p.name == "vertex_index");
    };
    if (element.count > 0 && std::none_of(element.properties.begin(), element.properties.end(), isCorners))
      source_.fail("the faces of the PLY file have no list vertex_indices");
    for (size_t i = 0; i < element.count; ++i) {
      for (const PlyProperty& property : element.properties) {
        if (isCorners(property))
          readCorners(property, i);
        else
          skip(property, "faces");
      }
      endItem();
    }
  }

  void readCorners(const PlyProperty& property, size_t face) {
    const size_t count = listCount(property, "faces");
    faceCorners_.push_back(static_cast<uint32_t>(count));
    for (size_t c = 0; c < count; ++c) {
      const double corner = value(property.type, "faces");
      if (!(corner >= 0) || corner > std::numeric_limits<uint32_t>::max() || corner != std::floor(corner))
        source_.fail("face " + std::to_string(face) + " of the PLY file has a corner that is not a vertex index");
      corners_.push_back(static_cast<uint32_t>(corner));
    }
  }

  /// Triangulates the faces last, because they may come before the vertices in the file.
  Scene finish() {
    const size_t vertexCount = coordinates_.size() / 3;
    Mesh mesh;
    mesh.indices.reserve(corners_.size());
    std::span<const uint32_t> rest(corners_);
    for (size_t face = 0; face < faceCorners_.size(); ++face) {
      const std::span<const uint32_t> corners = rest.first(faceCorners_[face]);
      rest = rest.subspan(faceCorners_[face]);
      for (uint32_t corner : corners)
        if (corner >= vertexCount)
          source_.fail("face " + std::to_string(face) + " of the PLY file: index " + std::to_string(corner) +
                       " is out of range, there are " + std::to_string(vertexCount) + " vertices");
      appendPolygon(mesh.indices, corners, coordinates_);
    }
    storePositions(mesh, coordinates_);
    return sceneOf(std::move(mesh));
  }

  std::string_view rest_;
  const Source& source_;
  std::vector<PlyElement> elements_;
  bool isText_ = true, swapped_ = false;
  std::vector<double> coordinates_;
  std::vector<uint32_t> faceCorners_, corners_;
};

// ---- STL ----

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
  Scene finish() {
    vertices_.clear();
    Mesh mesh;
    mesh.indices = std::move(indices_);
    storePositions(mesh, coordinates_);
    return sceneOf(std::move(mesh));
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
  return mesh.finish();
}

Scene readTextStl(Bytes bytes, const Source& source) {
  std::string_view rest = textOf(bytes);
  StlMesh mesh(bytes.size() / 200);
  size_t triangles = 0, corners = 0;
  bool ended = false;
  for (std::string_view word = nextWord(rest); !word.empty(); word = nextWord(rest)) {
    if (word == "solid" || word == "endsolid") {
      // A name follows, which may contain any word.
      rest.remove_prefix(std::min(rest.find('\n'), rest.size()));
      ended = word == "endsolid";
    } else if (word == "vertex") {
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
    } else if (word == "endfacet") {
      if (corners != 3) source.fail("facet " + std::to_string(triangles) + " of the STL file has not 3 vertices");
      corners = 0;
      ++triangles;
    }
  }
  if (corners != 0 || !ended) source.fail("the STL file is cut off: it has no endsolid");
  return mesh.finish();
}

}  // namespace

Scene readPly(Bytes bytes, const Source& source) {
  return PlyReader(bytes, source).read();
}

Scene readStl(Bytes bytes, const Source& source) {
  // Some binary files begin with "solid", the first word of text files, so the file size decides.
  size_t triangles = 0;
  if (bytes.size() >= kStlHeader) {
    uint32_t count;
    std::memcpy(&count, bytes.data() + 80, sizeof count);
    triangles = count;
    if (bytes.size() == kStlHeader + triangles * kStlTriangle) return readBinaryStl(bytes, triangles);
  }
  std::string_view text = textOf(bytes);
  if (nextWord(text) == "solid") return readTextStl(bytes, source);
  if (bytes.size() < kStlHeader) source.fail("it is not STL: it is too short and does not begin with 'solid'");
  if ((bytes.size() - kStlHeader) / kStlTriangle < triangles)
    source.fail("the STL file is cut off or not STL: its header claims " + std::to_string(triangles) +
                " triangles, it has room for " + std::to_string((bytes.size() - kStlHeader) / kStlTriangle));
  return readBinaryStl(bytes, triangles);  // there may be bytes after the last triangle
}

}  // namespace gnosphere

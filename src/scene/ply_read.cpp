// SPDX-License-Identifier: Apache-2.0
// Reads PLY files into a Scene. A reader of our own: CGAL 5.5, the only packaged one besides assimp, fails on 16-bit
// face lists and on nan, aborts on integer coordinates, and allocates whatever a hostile list asks for. assimp rounds
// to float.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "base/number.hpp"
#include "scene/origins.hpp"
#include "scene/readers.hpp"

namespace gnosphere {
namespace {

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
  PlyReader(Bytes bytes, const Source& source) : rest_(textOf(bytes, source)), source_(source) {
    const size_t end = std::min(rest_.find_first_of("\r\n"), rest_.size());
    if (rest_.substr(end, 1) == "\r" && rest_.substr(end, 2) != "\r\n") lineEnd_ = '\r';
  }

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
    const size_t end = rest_.find(lineEnd_);
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

  static bool isColour(const PlyProperty& property) {
    std::string_view name = property.name;
    for (const std::string_view prefix : {"diffuse_", "ambient_", "specular_"})
      if (name.starts_with(prefix)) name.remove_prefix(prefix.size());
    return name == "red" || name == "green" || name == "blue" || name == "alpha";
  }
  static bool areColoured(const PlyElement& element) { return std::ranges::any_of(element.properties, isColour); }

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
    if (isText_) rest_.remove_prefix(std::min(rest_.find(lineEnd_), rest_.size()));
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
    const char* at = rest_.data();
    rest_.remove_prefix(size);
    switch (type) {
      case PlyType::int8: return as<int8_t>(at);
      case PlyType::uint8: return as<uint8_t>(at);
      case PlyType::int16: return as<int16_t>(at);
      case PlyType::uint16: return as<uint16_t>(at);
      case PlyType::int32: return as<int32_t>(at);
      case PlyType::uint32: return as<uint32_t>(at);
      case PlyType::float32: return as<float>(at);
      case PlyType::float64: return as<double>(at);
    }
    return 0;
  }

  template <typename T>
  double as(const char* at) const {
    std::array<char, sizeof(T)> raw;
    std::memcpy(raw.data(), at, sizeof raw);
    if (swapped_) std::reverse(raw.begin(), raw.end());
    return std::bit_cast<T>(raw);
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
    if (areColoured(element)) leftOut_.add(kVertexColours);
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
    if (areColoured(element)) leftOut_.add("sets of colours of faces");
    for (const PlyProperty& property : element.properties)
      if (!isCorners(property) && !isColour(property)) leftOut_.add("properties of faces: " + inQuotes(property.name));
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
    std::vector<Mesh> meshes(1);
    Mesh& mesh = meshes[0];
    mesh.indices.reserve(corners_.size());
    std::span<const uint32_t> rest(corners_);
    for (size_t face = 0; face < faceCorners_.size(); ++face) {
      const std::span<const uint32_t> corners = rest.first(faceCorners_[face]);
      rest = rest.subspan(faceCorners_[face]);
      for (uint32_t corner : corners)
        if (corner >= vertexCount)
          source_.fail("face " + std::to_string(face) + " of the PLY file: index " + std::to_string(corner) +
                       " is out of range, there are " + std::to_string(vertexCount) + " vertices");
      if (!appendPolygon(mesh.indices, corners, coordinates_)) leftOut_.add(kCrossedFaces);
    }
    storePositions(mesh, coordinates_);
    Scene scene = sceneOf(std::move(meshes));
    scene.leftOut = leftOut_.lines();
    return scene;
  }

  std::string_view rest_;
  const Source& source_;
  LeftOut leftOut_;
  std::vector<PlyElement> elements_;
  char lineEnd_ = '\n';  ///< a carriage return in files whose first line ends with one alone
  bool isText_ = true, swapped_ = false;
  std::vector<double> coordinates_;
  std::vector<uint32_t> faceCorners_, corners_;
};

}  // namespace

Scene readPly(Bytes bytes, const Source& source) {
  return PlyReader(bytes, source).read();
}

}  // namespace gnosphere

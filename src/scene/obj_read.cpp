// SPDX-License-Identifier: Apache-2.0
#define TINYOBJLOADER_USE_DOUBLE
#include <tiny_obj_loader.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <istream>
#include <limits>
#include <map>
#include <set>
#include <span>
#include <streambuf>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "base/number.hpp"
#include "base/path.hpp"
#include "base/text.hpp"
#include "scene/origins.hpp"
#include "scene/readers.hpp"

namespace gnosphere {
namespace {

constexpr uint32_t kNoMaterial = std::numeric_limits<uint32_t>::max();

/// A stream buffer over existing bytes, without a copy.
class MemoryBuffer : public std::streambuf {
 public:
  explicit MemoryBuffer(std::string_view text) {
    char* begin = const_cast<char*>(text.data());  // only read from
    setg(begin, begin, begin + text.size());
  }
};

/// Takes the next line from the start of a text.
std::string_view takeLine(std::string_view& text) {
  const std::string_view line = text.substr(0, text.find_first_of("\r\n"));
  text.remove_prefix(std::min(line.size() + 1, text.size()));
  return line;
}

/// Reads every `v` line, by the rules by which tinyobjloader finds them. tinyobjloader's own numbers are not used: they
/// miss the nearest double by a few units in the last place, and nan and inf become 0. Three more numbers are a colour.
std::vector<double> readVertices(std::string_view text, const Source& source, bool& areColoured) {
  std::vector<double> coordinates;
  while (!text.empty()) {
    std::string_view line = takeLine(text);
    line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size()));
    if (line.size() < 2 || line[0] != 'v' || (line[1] != ' ' && line[1] != '\t')) continue;
    line.remove_prefix(2);
    for (int axis = 0; axis < 3; ++axis) {
      const std::string_view word = nextWord(line);
      double value = 0;
      if (!parseNumber(word, value))
        source.fail("vertex " + std::to_string(coordinates.size() / 3 + 1) + " of the OBJ file has " + inQuotes(word) +
                    " where a coordinate should be");
      coordinates.push_back(value);
    }
    nextWord(line);
    nextWord(line);
    areColoured |= !nextWord(line).empty();
  }
  return coordinates;
}

/// The content of the lines `mtllib`, `l` and `p` of an OBJ file.
struct OtherLines {
  std::vector<std::string> libraries;  ///< what the `mtllib` lines name, in order, each once
  uint64_t linesAndPoints = 0;         ///< lines `l` and `p`
};

OtherLines readOtherLines(std::string_view text) {
  OtherLines read;
  std::set<std::string> seen;
  while (!text.empty()) {
    std::string_view line = takeLine(text);
    const std::string_view key = nextWord(line);
    if (key == "l" || key == "p") ++read.linesAndPoints;
    if (key != "mtllib") continue;
    std::string names = toUtf8(trimmed(line));
    if (!names.empty() && seen.insert(names).second) read.libraries.push_back(std::move(names));
  }
  return read;
}

Material toMaterial(const tinyobj::material_t& from) {
  const auto unit = [](double value) { return static_cast<float>(value >= 0 ? std::min(value, 1.0) : 0); };
  Material material;
  material.name = toUtf8(trimmed(from.name));
  // Exporters write the filter Tf = 1 1 1 even for brick, so it counts only in the illumination models of glass. There
  // it says what passes, and the dissolve d, which some exporters derive from it, must not thin the light a second
  // time.
  const bool isGlass = from.illum == 4 || from.illum == 6 || from.illum == 7 || from.illum == 9;
  const double filter = (from.transmittance[0] + from.transmittance[1] + from.transmittance[2]) / 3;
  if (isGlass && filter > 0)
    material.transmission = unit(filter);
  else if (from.dissolve < 1)
    material.alphaMode = AlphaMode::blend;
  const float alpha = material.alphaMode == AlphaMode::blend ? unit(from.dissolve) : 1;
  material.baseColor = {unit(from.diffuse[0]), unit(from.diffuse[1]), unit(from.diffuse[2]), alpha};
  material.metallic = unit(from.metallic);
  // Without the PBR extension, roughness follows from the Blinn-Phong exponent n: about sqrt(2 / (n + 2)).
  material.roughness = unit(from.roughness >= 0 ? from.roughness : std::sqrt(2 / (std::max(from.shininess, 0.0) + 2)));
  return material;
}

/// Returns a material library in the words that tinyobjloader knows: with three values of each colour, which may state
/// one for all, and without the option of `d`. Each material begins with a roughness of -1, which remains if it states
/// none: tinyobjloader itself has 0 then, as for a mirror.
std::string withPlainWords(std::string_view text) {
  std::string result;
  while (!text.empty()) {
    const std::string_view line = takeLine(text);
    std::string_view rest = line;
    const std::string_view key = nextWord(rest), value = nextWord(rest), second = nextWord(rest);
    if ((key == "Kd" || key == "Tf") && !value.empty() && (second.empty() || second[0] == '#'))
      result.append(key).append(" ").append(value).append(" ").append(value).append(" ").append(value);
    else if (key == "d" && value == "-halo")
      result.append("d ").append(second);
    else
      result += line;
    result += '\n';
    if (key == "newmtl" && !value.empty()) result += "Pr -1\n";
  }
  return result;
}

/// The materials of the libraries beside the OBJ file. A material that no library defines, for example because the
/// library is missing, has only a name, and Scene::leftOut has a line about it.
class Libraries {
 public:
  Libraries(const Source& source, LeftOut& leftOut) : source_(source), leftOut_(leftOut) {}

  /// Reads what a `mtllib` line names: one library, whose name may have spaces, or else several.
  void add(const std::string& names) {
    isAny_ = true;
    if (addOne(names)) return;
    std::string_view rest = names;
    for (std::string_view name = nextWord(rest); !name.empty(); name = nextWord(rest))
      if (name == names || !addOne(std::string(name)))
        missing_.push_back("the materials of " + inQuotes(name) + ", which cannot be read");
  }

  /// Returns the material of a name; one that no library defines gets default properties.
  uint32_t find(const std::string& name) {
    const auto [found, isNew] = index_.emplace(name, static_cast<uint32_t>(materials_.size()));
    if (isNew) {
      materials_.emplace_back().name = name;
      if (undefined_++ == 0) firstUndefined_ = name;
    }
    return found->second;
  }

  std::vector<Material> take() { return std::move(materials_); }
  /// Returns a line for each library that is missing; if none is, a line for the materials that no library defines.
  std::vector<std::string> missing() {
    if (isAny_ && missing_.empty() && undefined_ > 0)
      missing_.push_back("the properties of material " + inQuotes(firstUndefined_) +
                         (undefined_ > 1 ? " and " + std::to_string(undefined_ - 1) + " more" : "") +
                         ", which no library defines");
    return std::move(missing_);
  }

 private:
  /// Returns false if the library cannot be read.
  bool addOne(const std::string& name) {
    std::filesystem::path key;
    FileBytes bytes;
    try {
      key = pathOf(name).lexically_normal();
      if (read_.contains(key)) return true;
      bytes = source_.sibling(name);
    } catch (const Error&) {
      return false;
    }
    const std::string text = withPlainWords(textOf(bytes, {source_.name + ": " + inQuotes(name), {}}));
    MemoryBuffer buffer(text);
    std::istream stream(&buffer);
    std::vector<tinyobj::material_t> materials;
    std::map<std::string, int> indices;
    std::string warnings, problems;
    tinyobj::LoadMtl(&indices, &materials, &stream, &warnings, &problems);
    for (const tinyobj::material_t& each : materials) {
      Material material = toMaterial(each);
      if (material.name.empty()) continue;  // the default material that tinyobjloader adds
      if (!index_.emplace(material.name, static_cast<uint32_t>(materials_.size())).second) continue;
      materials_.push_back(std::move(material));
      if (!each.diffuse_texname.empty()) leftOut_.add(kTextureColours);
      if (!each.alpha_texname.empty()) leftOut_.add(kTextureAlphas);
    }
    read_.insert(key);
    return true;
  }

  const Source& source_;
  LeftOut& leftOut_;
  std::vector<Material> materials_;
  std::vector<std::string> missing_;
  std::map<std::string, uint32_t> index_;
  std::set<std::filesystem::path> read_;  ///< libraries
  bool isAny_ = false;                    ///< whether the file names a library
  size_t undefined_ = 0;                  ///< materials that were looked for and that no library defines
  std::string firstUndefined_;
};

/// The faces as tinyobjloader's callbacks report them. Its other interface triangulates polygons itself, with 8-bit
/// corner counts, and drops those that it cannot triangulate.
struct Faces {
  struct Face {
    uint32_t cornerCount = 0;
    uint32_t name = kNoMaterial;  ///< index into `names`
    uint32_t object = 0;          ///< index into `objects`
  };

  /// Names in the order of their first use.
  struct Names {
    std::vector<std::string> all;
    std::map<std::string, uint32_t> index;

    uint32_t add(const std::string& text) {
      const auto [found, isNew] = index.emplace(toUtf8(trimmed(text)), static_cast<uint32_t>(all.size()));
      if (isNew) all.push_back(found->first);
      return found->second;
    }
  };

  const Source& source;
  size_t vertexCount = 0;
  std::vector<uint32_t> corners;
  std::vector<Face> faces;
  Names names;                       ///< of materials
  std::vector<std::string> objects;  ///< names of `o` lines; faces before the first one are of an object without a name
  uint32_t name = kNoMaterial;

  /// OBJ counts vertices from 1, or backwards with -1 as the latest vertex.
  void addFace(const tinyobj::index_t* indices, int count) {
    for (int i = 0; i < count; ++i) {
      const int64_t stated = indices[i].vertex_index;
      const int64_t index = stated < 0 ? static_cast<int64_t>(vertexCount) + stated : stated - 1;
      if (index < 0)
        source.fail("face " + std::to_string(faces.size() + 1) + " of the OBJ file: index " + std::to_string(stated) +
                    " is out of range");
      corners.push_back(static_cast<uint32_t>(index));
    }
    if (objects.empty()) objects.emplace_back();
    faces.push_back({static_cast<uint32_t>(count), name, static_cast<uint32_t>(objects.size() - 1)});
  }
};

Faces readFaces(std::string_view text, const Source& source) {
  Faces read{source};
  tinyobj::callback_t callbacks;
  callbacks.vertex_cb = [](void* faces, double, double, double, double) { ++static_cast<Faces*>(faces)->vertexCount; };
  callbacks.index_cb = [](void* faces, tinyobj::index_t* indices, int count) {
    static_cast<Faces*>(faces)->addFace(indices, count);
  };
  callbacks.usemtl_cb = [](void* user, const char* name, int) {
    Faces& faces = *static_cast<Faces*>(user);
    faces.name = faces.names.add(name);
  };
  callbacks.object_cb = [](void* user, const char* name) {
    static_cast<Faces*>(user)->objects.push_back(toUtf8(trimmed(name)));
  };
  MemoryBuffer buffer(text);
  std::istream stream(&buffer);
  std::string warnings, problems;
  if (!tinyobj::LoadObjWithCallback(stream, callbacks, &read, nullptr, &warnings, &problems))
    source.fail(problems.empty() ? "tinyobjloader refuses it" : toUtf8(trimmed(problems)));
  return read;
}

/// Sorts triangles by material, keeping the order of the file within each, so that every part is one run. `next` has a
/// 0 per material before and after: a table of its own per object would cost much where objects and materials are many.
void addParts(Mesh& mesh, const std::vector<uint32_t>& materials, std::vector<uint32_t>& next) {
  std::vector<uint32_t> used;
  for (uint32_t material : materials)
    if (next[material]++ == 0) used.push_back(material);
  std::sort(used.begin(), used.end());
  uint32_t first = 0;
  for (uint32_t material : used) {
    const uint32_t count = std::exchange(next[material], first);
    mesh.parts.push_back({first, count, material});
    first += count;
  }
  if (used.size() > 1) {
    std::vector<uint32_t> sorted(mesh.indices.size());
    for (size_t t = 0; t < materials.size(); ++t)
      std::copy_n(&mesh.indices[3 * t], 3, &sorted[3 * size_t{next[materials[t]]++}]);
    mesh.indices = std::move(sorted);
  }
  for (uint32_t material : used) next[material] = 0;
}

/// Joins each line that ends with a backslash with the next one, unless it is a comment.
void joinLines(std::string& text) {
  size_t from = 0, first = 0;  // the end of the text that was searched for lines; the first letter of the last line
  for (size_t at = text.find('\\'); at != text.npos; at = text.find('\\', at + 1)) {
    const size_t end = at + 1 + (text.compare(at + 1, 1, "\r") == 0 ? 1 : 0);
    const size_t newline = std::string_view(text).substr(from, at - from).rfind('\n');
    if (newline != text.npos) first = from + newline + 1;
    from = at;
    first = text.find_first_not_of(" \t", first);  // the backslash at the latest
    const bool isComment = text[first] == '#';
    if (!isComment && text.compare(end, 1, "\n") == 0) text.replace(at, end + 1 - at, end + 1 - at, ' ');
  }
}

/// Finds the next comment that follows the words of a vertex or a face. tinyobjloader takes the comment's words for
/// corners.
size_t findComment(std::string_view text, size_t from) {
  for (size_t at = text.find('#', from); at != text.npos; at = text.find('#', text.find_first_of("\r\n", at))) {
    const size_t line = text.find_last_of("\r\n", at) + 1;  // 0 in the first line
    std::string_view before = text.substr(line, at - line);
    const std::string_view key = nextWord(before);
    if (key == "v" || key == "f") return at;
  }
  return text.npos;
}

/// The triangles of an object, and their materials.
struct Object {
  std::string name;
  std::vector<uint32_t> indices, materials;
};

/// Returns the mesh of an object with the vertices that it uses, around this origin.
Mesh meshOf(const Object& object, std::span<const double> coordinates, const Vec3& origin) {
  Mesh mesh;
  mesh.origin = origin;
  std::unordered_map<uint32_t, uint32_t> numbers;
  for (const uint32_t vertex : object.indices) {
    const auto [found, isNew] = numbers.try_emplace(vertex, static_cast<uint32_t>(numbers.size()));
    if (isNew) appendPosition(mesh, coordinates, vertex);
    mesh.indices.push_back(found->second);
  }
  return mesh;
}

}  // namespace

Scene readObj(Bytes bytes, const Source& source) {
  std::string_view text = textOf(bytes, source);
  if (text.find('\0') != text.npos) source.fail("it is not OBJ: it holds binary data");
  std::string changed;
  if (text.find("\\\n") != text.npos || text.find("\\\r\n") != text.npos || findComment(text, 0) != text.npos) {
    changed = text;
    joinLines(changed);
    for (size_t at = findComment(changed, 0); at != changed.npos; at = findComment(changed, at))
      while (at < changed.size() && changed[at] != '\n' && changed[at] != '\r') changed[at++] = ' ';
    text = changed;
  }
  bool areColoured = false;
  const std::vector<double> coordinates = readVertices(text, source, areColoured);

  LeftOut leftOut;
  Libraries libraries(source, leftOut);
  const OtherLines others = readOtherLines(text);
  for (const std::string& names : others.libraries) libraries.add(names);
  const Faces gathered = readFaces(text, source);
  if (3 * gathered.vertexCount != coordinates.size()) source.fail("the OBJ file has invalid lines");
  std::vector<uint32_t> materialOfName;
  for (const std::string& name : gathered.names.all) materialOfName.push_back(libraries.find(name));
  Scene scene;
  scene.materials = libraries.take();
  if (others.linesAndPoints > 0) leftOut.add(kLinesAndPoints, others.linesAndPoints);
  if (areColoured) leftOut.add(kVertexColours);
  const auto unnamed = static_cast<uint32_t>(scene.materials.size());

  std::vector<Object> objects;
  for (const std::string& name : gathered.objects) objects.push_back({name, {}, {}});
  bool usesUnnamed = false;
  std::span<const uint32_t> rest(gathered.corners);
  for (size_t i = 0; i < gathered.faces.size(); ++i) {
    const Faces::Face& face = gathered.faces[i];
    const std::span<const uint32_t> corners = rest.first(face.cornerCount);
    rest = rest.subspan(face.cornerCount);
    for (uint32_t corner : corners)
      if (corner >= gathered.vertexCount)
        source.fail("face " + std::to_string(i + 1) + " of the OBJ file: index " + std::to_string(corner + 1) +
                    " is out of range, there are " + std::to_string(gathered.vertexCount) + " vertices");
    Object& object = objects[face.object];
    if (!appendPolygon(object.indices, corners, coordinates)) leftOut.add(kCrossedFaces);
    object.materials.resize(object.indices.size() / 3, face.name == kNoMaterial ? unnamed : materialOfName[face.name]);
    usesUnnamed |= face.name == kNoMaterial;
  }
  scene.leftOut = libraries.missing();
  for (std::string& line : leftOut.lines()) scene.leftOut.push_back(std::move(line));
  if (usesUnnamed) scene.materials.emplace_back();
  std::erase_if(objects, [](const Object& object) { return object.indices.empty(); });
  if (objects.empty()) objects.emplace_back();
  std::vector<CornerBox> boxes(objects.size());
  for (size_t i = 0; i < objects.size(); ++i) boxes[i].add(objects[i].indices, coordinates);
  const std::vector<Vec3> origins = originsOf(boxes, source.unit);
  std::vector<uint32_t> next(scene.materials.size(), 0);
  for (size_t i = 0; i < objects.size(); ++i) {
    Object& object = objects[i];
    Mesh mesh;
    if (objects.size() > 1) {
      mesh = meshOf(object, coordinates, origins[i]);
    } else {
      mesh.indices = std::move(object.indices);
      storePositions(mesh, coordinates);
    }
    addParts(mesh, object.materials, next);
    mesh.name = object.name;
    scene.instances.push_back({object.name, static_cast<uint32_t>(scene.meshes.size())});
    scene.meshes.push_back(std::move(mesh));
  }
  return scene;
}

}  // namespace gnosphere

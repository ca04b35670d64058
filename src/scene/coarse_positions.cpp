// SPDX-License-Identifier: Apache-2.0
#include "scene/coarse_positions.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <string>
#include <string_view>

#include "base/limits.hpp"
#include "base/number.hpp"
#include "base/single_precision.hpp"
#include "base/text.hpp"
#include "base/vector.hpp"
#include "scene/used_vertices.hpp"

namespace gnosphere {
namespace {

/// Whether a file states positions in single precision. OBJ has decimal numbers, and PLY both precisions.
bool isInSingle(const std::filesystem::path& file) {
  const std::string ending = lower(file.extension().string());
  if (ending != ".ply") return ending != ".obj";
  constexpr size_t kMostHeader = 65536;
  std::string header(kMostHeader, '\0');
  std::ifstream stream(file, std::ios::binary);
  stream.read(header.data(), static_cast<std::streamsize>(kMostHeader));
  header.resize(static_cast<size_t>(stream.gcount()));
  // The reader has read the file, so lines need no check; they may end with carriage returns alone.
  for (std::string_view rest = header; !rest.empty();) {
    const size_t end = std::min(rest.find_first_of("\r\n"), rest.size());
    std::string_view line = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    const std::string_view keyword = nextWord(line), type = nextWord(line);
    if (keyword == "end_header") break;
    if (keyword == "property" && (type == "double" || type == "float64") && nextWord(line) == "x") return false;
  }
  return true;
}

/// The largest factor by which a transform stretches an axis.
double stretchOf(const Transform& transform) {
  const auto& m = transform.rows;
  double most = 0;
  for (size_t c = 0; c < 3; ++c) most = std::max(most, lengthOf({m[c], m[4 + c], m[8 + c]}));
  return most;
}

/// The farthest coordinate of the surface of a mesh from the mesh's origin, and half of the longest side of the box
/// around the surface. Coordinates beyond the limit belong to no surface.
struct Reach {
  float farthest = 0, halfSide = 0;
};

Reach reachOf(const Mesh& mesh) {
  constexpr auto kMost = static_cast<float>(limits::kCoordinate.most);
  const std::vector<bool> used = usedVertices(mesh);
  Reach reach;
  for (size_t axis = 0; axis < 3; ++axis) {
    float low = kMost, high = -kMost;
    for (size_t i = axis; i < mesh.positions.size(); i += 3) {
      if (!used[i / 3] || !(std::abs(mesh.positions[i]) <= kMost)) continue;
      low = std::min(low, mesh.positions[i]);
      high = std::max(high, mesh.positions[i]);
    }
    if (low > high) continue;
    reach.farthest = std::max({reach.farthest, -low, high});
    reach.halfSide = std::max(reach.halfSide, (high - low) / 2);
  }
  return reach;
}

/// Whether a coordinate of the mesh, be it of a surface or not, is this far from the mesh's origin.
bool reaches(const Mesh& mesh, double distance) {
  return std::any_of(mesh.positions.begin(), mesh.positions.end(),
                     [&](float value) { return std::abs(value) >= distance; });
}

}  // namespace

std::string coarsePositions(const std::filesystem::path& file, const Scene& scene) {
  std::vector<double> stretches(scene.meshes.size());  // by mesh: the largest of its instances
  for (const Instance& instance : scene.instances)
    stretches[instance.mesh] = std::max(stretches[instance.mesh], stretchOf(instance.transform));
  const bool isSingle = isInSingle(file);
  double far = 0, step = 0;
  // Whether steps around an origin in the middle of the mesh would be less than four times as fine.
  bool isWide = false;
  for (size_t i = 0; i < scene.meshes.size(); ++i) {
    const Mesh& mesh = scene.meshes[i];
    // The reader of doubles leaves the origin at 0 if floats hold every coordinate exactly.
    if (!isSingle && lengthOf(mesh.origin) == 0) continue;
    if (!reaches(mesh, kCoarseFrom / stretches[i])) continue;
    const Reach reach = reachOf(mesh);
    if (stretches[i] * reach.farthest < std::max(kCoarseFrom, far)) continue;
    far = stretches[i] * reach.farthest;
    step = stretches[i] * stepAt(reach.farthest);
    isWide = reach.farthest < 4 * reach.halfSide;
  }
  if (step == 0) return "";
  if (isWide)
    return "a mesh is so wide that its positions are " + inSinglePrecision(step, far) +
           " from its origin; split it into objects of an OBJ file, of which each gets an origin of its own";
  return "its positions are " + inSinglePrecision(step, far) +
         "; give them in an OBJ file, in a PLY file of doubles, or in glTF near the origin of a node whose translation "
         "places them";
}

}  // namespace gnosphere

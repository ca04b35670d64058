// SPDX-License-Identifier: Apache-2.0
#include "scene/coarse_positions.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iomanip>
#include <limits>
#include <sstream>

#include "base/limits.hpp"
#include "base/text.hpp"
#include "scene/used_vertices.hpp"

namespace gnosphere {
namespace {

constexpr double kFar = 16384;  // metres; from here on neighbouring floats are 2 mm apart, or more

/// Whether a file states positions in single precision. OBJ has decimal numbers, and PLY both precisions.
bool isInSingle(const std::filesystem::path& file) {
  const std::string ending = lower(file.extension().string());
  if (ending != ".ply") return ending != ".obj";
  std::ifstream header(file, std::ios::binary);
  std::string line;
  while (std::getline(header, line) && !line.starts_with("end_header"))
    if (line.starts_with("property double x") || line.starts_with("property float64 x")) return false;
  return true;
}

/// The largest factor by which a transform stretches an axis.
double stretchOf(const Transform& transform) {
  const auto& m = transform.rows;
  double most = 0;
  for (size_t c = 0; c < 3; ++c) most = std::max(most, std::hypot(m[c], m[4 + c], m[8 + c]));
  return most;
}

/// The farthest coordinate of the mesh from its origin. Coordinates beyond the limit belong to no surface.
float farthestOf(const Mesh& mesh) {
  float farthest = 0;
  for (const float coordinate : mesh.positions)
    if (std::abs(coordinate) <= static_cast<float>(limits::kCoordinate.most))
      farthest = std::max(farthest, std::abs(coordinate));
  return farthest;
}

/// Returns the mesh with the vertices that its triangles use, and without any triangles.
Mesh surfaceOf(const Mesh& mesh) {
  const std::vector<bool> used = usedVertices(mesh);
  Mesh surface;
  for (size_t i = 0; i < mesh.positions.size(); ++i)
    if (used[i / 3]) surface.positions.push_back(mesh.positions[i]);
  return surface;
}

/// Half of the longest side of the box around the vertices.
float halfSideOf(const Mesh& mesh) {
  float half = 0;
  for (size_t axis = 0; axis < 3; ++axis) {
    float low = std::numeric_limits<float>::infinity(), high = -low;
    for (size_t i = axis; i < mesh.positions.size(); i += 3) {
      if (!(std::abs(mesh.positions[i]) <= static_cast<float>(limits::kCoordinate.most))) continue;
      low = std::min(low, mesh.positions[i]);
      high = std::max(high, mesh.positions[i]);
    }
    half = std::max(half, (high - low) / 2);
  }
  return half;
}

}  // namespace

std::string coarsePositions(const std::filesystem::path& file, const Scene& scene) {
  std::vector<double> stretches(scene.meshes.size());  // by mesh: the largest of its instances
  for (const Instance& instance : scene.instances)
    stretches[instance.mesh] = std::max(stretches[instance.mesh], stretchOf(instance.transform));
  double far = 0, step = 0;
  for (size_t i = 0; i < scene.meshes.size(); ++i) {
    // The test of all vertices is quick, and seldom leaves a mesh for the second one.
    if (stretches[i] * farthestOf(scene.meshes[i]) < kFar) continue;
    const Mesh surface = surfaceOf(scene.meshes[i]);
    const float farthest = farthestOf(surface);
    if (stretches[i] * farthest < std::max(kFar, far) || farthest < 4 * halfSideOf(surface)) continue;
    far = stretches[i] * farthest;
    step = stretches[i] * (std::nextafter(farthest, std::numeric_limits<float>::infinity()) - farthest);
  }
  if (step == 0 || !isInSingle(file)) return "";
  std::ostringstream text;
  text << "its positions are in single precision, which has steps of " << std::setprecision(3) << step << " m at "
       << std::setprecision(10) << std::round(far)
       << " m; give them in an OBJ file, in a PLY file of doubles, or in glTF near the origin of a node whose "
          "translation places them";
  return text.str();
}

}  // namespace gnosphere

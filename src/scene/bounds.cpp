// SPDX-License-Identifier: Apache-2.0
#include "scene/bounds.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <vector>

#include "base/vector.hpp"
#include "scene/used_vertices.hpp"
#include "scene/validate.hpp"

namespace gnosphere {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr Bounds kEmpty = {{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
constexpr double Vec3::*kAxes[] = {&Vec3::x, &Vec3::y, &Vec3::z};

/// The vertices of a mesh that its triangles use, deformed as the mesh is. The mesh must outlive the object.
class Surface {
 public:
  explicit Surface(const Mesh& mesh) : mesh_(mesh), used_(usedVertices(mesh)) {
    if (!mesh.deformation.empty()) deformed_ = deformedPositions(mesh, mesh.deformation);
  }

  /// Extends a box by the vertices that are finite under a transform.
  void addTo(Bounds& bounds, const Transform& transform) const {
    const std::vector<float>& positions = deformed_.empty() ? mesh_.positions : deformed_;
    for (size_t v = 0; v < used_.size(); ++v) {
      if (!used_[v]) continue;
      const float* position = &positions[3 * v];
      const Vec3 point = transform * (mesh_.origin + Vec3{position[0], position[1], position[2]});
      if (!isFinite(point)) continue;
      bounds.min = lowest(bounds.min, point);
      bounds.max = highest(bounds.max, point);
    }
  }

 private:
  const Mesh& mesh_;
  std::vector<bool> used_;
  std::vector<float> deformed_;
};

/// Sets the least and the greatest product of a row of a transform and a point of the box. Infinite terms may add up to
/// NaN; then the range is that of all numbers.
void setRange(const double* row, const Bounds& bounds, double& least, double& greatest) {
  least = greatest = 0;
  for (int k = 0; k < 3; ++k) {
    const double low = row[k] * (bounds.min.*kAxes[k]), high = row[k] * (bounds.max.*kAxes[k]);
    least += std::min(low, high);
    greatest += std::max(low, high);
  }
  least += row[3];
  greatest += row[3];
  if (std::isnan(least) || std::isnan(greatest)) {
    least = -kInfinity;
    greatest = kInfinity;
  }
}

}  // namespace

Bounds meshBounds(const Mesh& mesh) {
  Bounds bounds = kEmpty;
  Surface(mesh).addTo(bounds, {});
  return bounds;
}

std::vector<Bounds> instanceBounds(const Scene& scene) {
  std::vector<std::optional<Surface>> surfaces(scene.meshes.size());
  std::vector<Bounds> boxes(scene.instances.size(), kEmpty);
  for (size_t i = 0; i < scene.instances.size(); ++i) {
    const uint32_t mesh = scene.instances[i].mesh;
    if (mesh == kNoMesh) continue;
    if (!surfaces[mesh]) surfaces[mesh].emplace(meshOf(scene, i));
    surfaces[mesh]->addTo(boxes[i], scene.instances[i].transform);
  }
  return boxes;
}

Bounds operator*(const Transform& transform, const Bounds& bounds) {
  Bounds moved;
  for (int k = 0; k < 3; ++k) setRange(&transform.rows[4 * k], bounds, moved.min.*kAxes[k], moved.max.*kAxes[k]);
  return moved;
}

// A scene may have a million instances of a mesh of many vertices. Only an instance whose box reaches beyond the bounds
// found so far can extend them, so the vertices of few are looked at if the box that reaches furthest comes first.
Bounds worldBounds(const Scene& scene) {
  std::vector<std::optional<Surface>> surfaces(scene.meshes.size());
  std::vector<Bounds> boxesOfMeshes(scene.meshes.size(), kEmpty), boxes(scene.instances.size(), kEmpty);
  for (size_t i = 0; i < scene.instances.size(); ++i) {
    const uint32_t mesh = scene.instances[i].mesh;
    if (mesh == kNoMesh) continue;
    const Mesh& shape = meshOf(scene, i);
    if (!surfaces[mesh]) {
      surfaces[mesh].emplace(shape);
      surfaces[mesh]->addTo(boxesOfMeshes[mesh], {});
    }
    if (!boxesOfMeshes[mesh].empty()) boxes[i] = scene.instances[i].transform * boxesOfMeshes[mesh];
  }

  Bounds bounds = kEmpty;
  for (const auto axis : kAxes)
    for (const double side : {-1.0, 1.0}) {
      const auto reach = [&](const Bounds& box) { return side < 0 ? -(box.min.*axis) : box.max.*axis; };
      const auto nearer = [&](size_t a, size_t b) { return reach(boxes[a]) < reach(boxes[b]); };
      std::vector<size_t> heap(boxes.size());
      std::iota(heap.begin(), heap.end(), size_t{0});
      std::ranges::make_heap(heap, nearer);
      while (!heap.empty() && reach(boxes[heap.front()]) > reach(bounds)) {
        std::ranges::pop_heap(heap, nearer);
        const Instance& furthest = scene.instances[heap.back()];
        surfaces[furthest.mesh]->addTo(bounds, furthest.transform);
        boxes[heap.back()] = kEmpty;
        heap.pop_back();
      }
    }
  return bounds;
}

}  // namespace gnosphere

// SPDX-License-Identifier: Apache-2.0
#include "reference/surface.hpp"

#include <algorithm>
#include <cmath>

namespace gnosphere::reference {

namespace {

double wrapped(double value, AlphaImage::Wrap wrap) {
  if (wrap == AlphaImage::Wrap::clamp) return std::clamp(value, 0.0, 1.0);
  if (wrap == AlphaImage::Wrap::repeat) return value - std::floor(value);
  const double turn = value - 2 * std::floor(value / 2);  // 0..2: a period of the mirrored image, forward and back
  return turn > 1 ? 2 - turn : turn;
}

/// Alpha 0..1 of the pixel that contains the point; 1 if the coordinates are not finite, since they lie in no pixel.
/// Alpha is rounded as in shaders/holes.glsl, so that one at the cut-off, a float, is on the same side as on a device.
float alphaAt(const AlphaImage& image, double u, double v) {
  if (image.alpha.empty() || !std::isfinite(u) || !std::isfinite(v)) return 1;
  const auto pixel = [](double place, uint32_t count) {
    return std::min(static_cast<size_t>(place * count), size_t{count} - 1);
  };
  const size_t x = pixel(wrapped(u, image.wrapU), image.width), y = pixel(wrapped(v, image.wrapV), image.height);
  return static_cast<float>(image.alpha[y * image.width + x]) * (1.0f / 255.0f);
}

}  // namespace

uint32_t materialOf(const Scene& scene, const Triangle& triangle) {
  const auto& parts = scene.meshes[scene.instances[triangle.instance].mesh].parts;
  const auto starts = [](uint32_t index, const MeshPart& part) { return index < part.firstTriangle; };
  const auto next = std::upper_bound(parts.begin(), parts.end(), triangle.index, starts);
  return (next - 1)->material;
}

std::array<double, 2> barycentricsOf(const Triangle& triangle, const Weights& weights) {
  std::array<double, 3> sorted = {};
  for (size_t k = 0; k < 3; ++k) sorted[triangle.order[k]] = weights[k];
  return {sorted[1], sorted[2]};
}

Vec3 normalTowardsOrigin(const Vec3 (&corners)[3]) {
  const Vec3 normal = cross(corners[1] - corners[0], corners[2] - corners[0]);
  const double length = lengthOf(normal);
  if (!(length > 0)) return {};
  return (dot(normal, corners[0]) > 0 ? -1 / length : 1 / length) * normal;
}

bool isHole(const Scene& scene, const Triangle& triangle, const Weights& weights) {
  const Material& material = scene.materials[materialOf(scene, triangle)];
  if (material.alphaMode != AlphaMode::mask) return false;
  float alpha = material.baseColor[3];
  const Mesh& mesh = scene.meshes[scene.instances[triangle.instance].mesh];
  if (material.alphaImage != kNoImage && !mesh.uvs.empty()) {
    double u = 0, v = 0;
    for (size_t k = 0; k < 3; ++k) {
      const float* uv = &mesh.uvs[2 * size_t{mesh.indices[3 * size_t{triangle.index} + triangle.order[k]]}];
      u += weights[k] * uv[0];
      v += weights[k] * uv[1];
    }
    alpha *= alphaAt(scene.alphaImages[material.alphaImage], u, v);
  }
  return alpha < material.alphaCutoff;
}

bool isHoleInDoubt(const Scene& scene, const Triangle& triangle, const Weights& weights) {
  constexpr double kStep = 1e-4;
  const bool hole = isHole(scene, triangle, weights);
  for (size_t k = 0; k < 3; ++k)
    for (double step : {-kStep, kStep}) {
      Weights moved = weights;
      moved[k] += step;
      moved[(k + 1) % 3] -= step;
      if (isHole(scene, triangle, moved) != hole) return true;
    }
  return false;
}

}  // namespace gnosphere::reference

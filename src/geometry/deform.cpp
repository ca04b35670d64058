// SPDX-License-Identifier: Apache-2.0
#include "geometry/deform.hpp"

#include <algorithm>
#include <cmath>

#include "base/finite.hpp"
#include "common/deform.h"
#include "gnosphere/error.hpp"

namespace gnosphere {
namespace {

gpu::vec4 row(const JointMap& map, size_t number) {
  return {map[4 * number], map[4 * number + 1], map[4 * number + 2], map[4 * number + 3]};
}

}  // namespace

std::vector<JointMap> jointMapsOf(const Vec3& o, const Deformation& deformation) {
  std::vector<JointMap> maps;
  const double origin[3] = {o.x, o.y, o.z};
  for (const Transform& joint : deformation.joints) {
    JointMap& map = maps.emplace_back();
    for (size_t i = 0; i < 3; ++i) {
      const double* values = &joint.rows[4 * i];
      // M (origin + p) + t - origin = M p + (M origin + t - origin)
      const double shift =
          values[0] * origin[0] + values[1] * origin[1] + values[2] * origin[2] + values[3] - origin[i];
      for (size_t k = 0; k < 3; ++k) map[4 * i + k] = static_cast<float>(values[k]);
      map[4 * i + 3] = static_cast<float>(shift);
    }
  }
  return maps;
}

void influencesOf(const Mesh& mesh, size_t vertex, std::vector<Influence>& influences) {
  influences.clear();
  double sum = 0;
  for (size_t k = vertex * mesh.influences; k < (vertex + 1) * mesh.influences; ++k) {
    const uint32_t joint = mesh.joints[k];
    sum += mesh.jointWeights[k];
    const auto place = std::find_if(influences.begin(), influences.end(),
                                    [&](const Influence& other) { return other.joint >= joint; });
    if (place != influences.end() && place->joint == joint)
      place->weight += mesh.jointWeights[k];
    else if (mesh.jointWeights[k] > 0)
      influences.insert(place, {joint, mesh.jointWeights[k]});
  }
  if (influences.empty()) return;
  // The remainder of the sum that rounding leaves goes to the largest weight.
  double left = gpu::kWeightUnits;
  for (Influence& influence : influences) {
    influence.weight = static_cast<float>(std::round(influence.weight / sum * gpu::kWeightUnits));
    left -= influence.weight;
  }
  std::ranges::max_element(influences, {}, &Influence::weight)->weight += static_cast<float>(left);
  std::erase_if(influences, [](const Influence& influence) { return influence.weight == 0; });
  for (Influence& influence : influences) influence.weight /= gpu::kWeightUnits;
}

std::vector<float> deformedPositions(const Mesh& mesh, const Deformation& deformation) {
  if (deformation.empty()) return mesh.positions;
  if (deformation.joints.size() != mesh.jointCount || deformation.morphWeights.size() != mesh.morphTargets.size())
    throw Error(ErrorCode::invalidArgument, "the deformation has " + std::to_string(deformation.joints.size()) +
                                                " joints and " + std::to_string(deformation.morphWeights.size()) +
                                                " morph weights, the mesh has " + std::to_string(mesh.jointCount) +
                                                " and " + std::to_string(mesh.morphTargets.size()));
  if (std::ranges::any_of(deformation.joints, [](const Transform& joint) { return !allFinite(joint.rows); }) ||
      !allFinite(deformation.morphWeights))
    throw Error(ErrorCode::invalidArgument, "the deformation has a joint or a morph weight that is not finite");
  const std::vector<JointMap> maps = jointMapsOf(mesh.origin, deformation);
  std::vector<float> result;
  result.reserve(mesh.positions.size());
  std::vector<Influence> influences;
  for (size_t vertex = 0; vertex < mesh.vertexCount(); ++vertex) {
    gpu::vec3 position = vertexAt(mesh.positions, vertex);
    for (size_t i = 0; i < mesh.morphTargets.size(); ++i)
      position = gpu::withShare(position, vertexAt(mesh.morphTargets[i], vertex), deformation.morphWeights[i]);
    gpu::vec3 sum = {0, 0, 0};
    influencesOf(mesh, vertex, influences);
    for (const Influence& influence : influences) {
      const JointMap& map = maps[influence.joint];
      sum = gpu::withShare(sum, gpu::through(row(map, 0), row(map, 1), row(map, 2), position), influence.weight);
    }
    const gpu::vec3& end = mesh.influences > 0 ? sum : position;
    result.insert(result.end(), {end.x, end.y, end.z});
  }
  return result;
}

}  // namespace gnosphere

// SPDX-License-Identifier: Apache-2.0
#include "drive/standing.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "base/vector.hpp"
#include "drive/pose_math.hpp"

namespace gnosphere::drive {
namespace {

/// Returns a scene that has one mesh of another one, its materials and their images.
Scene modelOf(const Scene& scene, uint32_t mesh) {
  Scene model;
  model.meshes = {scene.meshes[mesh]};
  std::map<uint32_t, uint32_t> materials, images;  // from the numbers in the scene to those in the model
  for (MeshPart& part : model.meshes[0].parts) {
    const auto [number, isNew] = materials.try_emplace(part.material, static_cast<uint32_t>(materials.size()));
    if (isNew) {
      Material& material = model.materials.emplace_back(scene.materials[part.material]);
      if (material.alphaImage != kNoImage) {
        const auto [image, isFirst] = images.try_emplace(material.alphaImage, static_cast<uint32_t>(images.size()));
        if (isFirst) model.alphaImages.push_back(scene.alphaImages[material.alphaImage]);
        material.alphaImage = image->second;
      }
    }
    part.material = number->second;
  }
  model.instances = {{}};
  return model;
}

/// Returns the upright pose of an instance of a mesh with these bounds, see takeStanding().
Pose uprightPoseOf(const Transform& transform, const Bounds& bounds) {
  const auto& r = transform.rows;
  const Vec3 extent = bounds.max - bounds.min;
  const std::array<Vec3, 3> axes = {extent.x * Vec3{r[0], r[4], r[8]}, extent.y * Vec3{r[1], r[5], r[9]},
                                    extent.z * Vec3{r[2], r[6], r[10]}};
  const auto steepness = [](const Vec3& v) { return v.z * v.z / std::max(dot(v, v), 1e-30); };
  const size_t up = static_cast<size_t>(
      std::ranges::max_element(axes, {}, [&](const Vec3& axis) { return steepness(axis); }) - axes.begin());
  Vec3 along;
  for (size_t axis = 0; axis < 3; ++axis)
    if (axis != up && dot(axes[axis], axes[axis]) > dot(along, along)) along = axes[axis];
  return {{r[3], r[7], r[11]}, yawPitchRoll(std::atan2(along.y, along.x), 0, 0)};
}

}  // namespace

void takeStanding(Scene& scene, const std::function<std::optional<size_t>(const Instance&)>& category,
                  StandingActors& standing) {
  constexpr double kSteps = 1e9;  // of the numbers in the matrix of a model, so that equal cars share one
  struct Shape {
    Scene model;
    Bounds bounds;
  };
  std::map<uint32_t, Shape> shapes;                                      // by mesh
  std::map<std::pair<uint32_t, std::array<double, 12>>, size_t> models;  // by mesh and matrix
  std::vector<Instance> rest;
  for (Instance& instance : scene.instances) {
    const std::optional<size_t> chosen = category(instance);
    if (!chosen) {
      rest.push_back(std::move(instance));
      continue;
    }
    const auto [found, isFirst] = shapes.try_emplace(instance.mesh);
    Shape& shape = found->second;
    if (isFirst) {
      shape.model = modelOf(scene, instance.mesh);
      shape.bounds = worldBounds(shape.model);
    }
    const Pose pose = uprightPoseOf(instance.transform, shape.bounds);
    Transform inFrame = transformOf(inverse(pose)) * instance.transform;
    for (double& number : inFrame.rows) number = std::round(number * kSteps) / kSteps;
    const auto [shared, isNew] = models.try_emplace({instance.mesh, inFrame.rows}, standing.models.size());
    if (isNew) {
      Scene& model = standing.models.emplace_back(shape.model);
      model.instances[0].transform = inFrame;
    }
    Actor& actor = standing.actors.emplace_back();
    actor.name = instance.name;
    actor.model = shared->second;
    actor.category = *chosen;
    actor.trajectory = Trajectory({{0, pose}});
  }
  scene.instances = std::move(rest);
  scene.animation = {};
}

}  // namespace gnosphere::drive

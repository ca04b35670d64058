// SPDX-License-Identifier: Apache-2.0
// Matrices: of the camera, and of GnoSphere's transforms and poses.
#pragma once

#define GLM_FORCE_DEPTH_ZERO_TO_ONE
#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <gnosphere/scan.hpp>

namespace viewer {

inline glm::dvec3 vectorOf(const gnosphere::Vec3& v) {
  return {v.x, v.y, v.z};
}

inline glm::dmat4 matrixOf(const gnosphere::Transform& transform) {
  glm::dmat4 result(1);
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column)
      result[column][row] = transform.rows[static_cast<size_t>(4 * row + column)];
  return result;
}

inline glm::dmat4 matrixOf(const gnosphere::Pose& pose) {
  const gnosphere::Quaternion& q = pose.orientation;
  glm::dmat4 result(1);
  result[0] = {1 - 2 * (q.y * q.y + q.z * q.z), 2 * (q.x * q.y + q.z * q.w), 2 * (q.x * q.z - q.y * q.w), 0};
  result[1] = {2 * (q.x * q.y - q.z * q.w), 1 - 2 * (q.x * q.x + q.z * q.z), 2 * (q.y * q.z + q.x * q.w), 0};
  result[2] = {2 * (q.x * q.z + q.y * q.w), 2 * (q.y * q.z - q.x * q.w), 1 - 2 * (q.x * q.x + q.y * q.y), 0};
  result[3] = glm::dvec4(vectorOf(pose.position), 1);
  return result;
}

/// A camera on a sphere around a target.
struct Camera {
  static constexpr double kNear = 0.3, kFar = 3000;  // metres

  double azimuth = -3.1, elevation = 0.4;  ///< radians, from the target to the camera
  double distance = 24;                    ///< metres

  void orbit(double right, double up) {  // radians
    azimuth -= right;
    elevation = std::clamp(elevation + up, -1.5, 1.5);
  }
  void zoom(double steps) { distance = std::clamp(distance * std::pow(0.9, steps), 1.0, 1000.0); }

  glm::dmat4 toClip(const glm::dvec3& target, double aspect) const {
    const glm::dvec3 away(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                          std::sin(elevation));
    glm::dmat4 projection = glm::perspective(glm::radians(50.0), aspect, kNear, kFar);
    projection[1][1] = -projection[1][1];  // Vulkan's y axis points down
    return projection * glm::lookAt(target + distance * away, target, glm::dvec3(0, 0, 1));
  }
};

}  // namespace viewer

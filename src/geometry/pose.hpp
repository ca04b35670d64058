// SPDX-License-Identifier: Apache-2.0
// Rotations and positions of poses in the types of GLM.
#pragma once

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

#include "base/quaternion.hpp"
#include "gnosphere/scan.hpp"

namespace gnosphere {

/// The rotation from the frame of the pose to the world.
inline glm::dquat rotationOf(const Pose& pose) {
  const Quaternion q = withUsableLength(pose.orientation);
  return glm::normalize(glm::dquat(q.w, q.x, q.y, q.z));
}

inline glm::dvec3 positionOf(const Pose& pose) {
  return {pose.position.x, pose.position.y, pose.position.z};
}

}  // namespace gnosphere

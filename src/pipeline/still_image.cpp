// SPDX-License-Identifier: Apache-2.0
#include "pipeline/still_image.hpp"

#include "base/transform.hpp"

namespace gnosphere {

StillImage::Use StillImage::next(const Shot& shot, const InstanceTable& instances) {
  if (!on_) return Use::none;
  if (!pose_ || !samePose(shot.pose, *pose_) || shot.world != world_ || shot.ignoredInstances != ignored_) {
    pose_ = shot.pose;
    world_ = shot.world;
    ignored_ = shot.ignoredInstances;
    moving_.clear();
    seen_ = instances.changes();
    state_ = State::missing;
    return Use::none;
  }
  const bool renumbered = instances.renumberedAt() > seen_;
  const bool newlyMoving = findMoving(instances);
  // If most triangles move, one scan of everything is faster: it can hide more triangles than two separate scans.
  const bool pays = triangles_ > 0 && 2 * triangles_ >= instances.contentOf(world_).usableTriangles();
  if (renumbered || newlyMoving || !pays) {
    state_ = State::missing;
    return Use::none;
  }
  return state_ == State::made ? Use::use : Use::make;
}

// Updates the moving instances; returns whether any has begun to move.
bool StillImage::findMoving(const InstanceTable& instances) {
  if (moving_.size() == instances.count() && seen_ == instances.changes()) return false;
  moving_.resize(instances.count());
  bool found = false;
  triangles_ = 0;
  const auto look = [&](uint32_t world) {
    for (const uint32_t i : instances.instancesOf(world)) {
      if (moving_[i]) continue;
      moving_[i] = instances.changedAt(i) > seen_;
      found |= moving_[i] != 0;
      if (!moving_[i]) triangles_ += instances.usableTriangles(i);
    }
  };
  look(0);
  if (world_ != 0) look(world_);
  seen_ = instances.changes();
  return found;
}

Selection StillImage::selection(Use use) const {
  return use == Use::none ? Selection{} : Selection{moving_, use == Use::make};
}

void StillImage::begin(size_t slot) {
  slot_ = slot;
  state_ = State::inMaking;
}

void StillImage::end(bool succeeded) {
  state_ = succeeded ? State::made : State::missing;
}

}  // namespace gnosphere

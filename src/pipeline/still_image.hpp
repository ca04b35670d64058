// SPDX-License-Identifier: Apache-2.0
// What the things that do not move give a sensor that does not move: made once, then only what moves is scanned.
#pragma once

#include <optional>
#include <vector>

#include "geometry/instance_table.hpp"

namespace gnosphere {

/// When the words of a sensor's beams are kept as the still instances alone leave them. They belong to a pose and a set
/// of still instances; both must have been seen before they are kept, so that what is scanned once costs nothing. An
/// instance that has moved counts as moving for as long as the pose stays.
class StillImage {
 public:
  enum class Use {
    none,  ///< scan everything
    make,  ///< scan what is still and keep the words, then what moves
    use,   ///< begin with the words, then what moves
  };

  /// `on`: false where the words of one scan cannot be continued by another.
  explicit StillImage(bool on) : on_(on) {}

  /// What the next scan of the sensor does. Nothing may be in the making.
  Use next(const Pose& pose, const InstanceTable& instances);
  /// As next() has told.
  Selection selection(Use use) const;
  /// Usable triangles of the still instances.
  uint64_t triangles() const { return triangles_; }

  /// The scan that makes it has been submitted as frame in flight `frame`. Only its end tells whether it succeeded.
  void begin(size_t frame);
  bool inMaking() const { return state_ == State::inMaking; }
  size_t frame() const { return frame_; }
  void end(bool succeeded);

 private:
  enum class State { missing, inMaking, made };

  bool findMoving(const InstanceTable& instances);

  bool on_;
  State state_ = State::missing;
  size_t frame_ = 0;
  std::optional<Pose> pose_;     // of the last scan
  std::vector<uint8_t> moving_;  // by instance, since the first scan from there
  uint64_t seen_ = 0;            // of InstanceTable::changes()
  uint64_t triangles_ = 0;
};

}  // namespace gnosphere

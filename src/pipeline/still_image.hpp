// SPDX-License-Identifier: Apache-2.0
// Reuse of hits on still instances by a sensor that does not move: later scans compute only the moving instances.
#pragma once

#include <optional>
#include <vector>

#include "geometry/instance_table.hpp"

namespace gnosphere {

/// Decides when the hits on still instances (the words of the beams) are kept and reused. The hits are valid for one
/// pose, one world, one list of instances that shots ignore, and one set of still instances. The hits are kept only
/// when all of these occur in a second scan, so single scans cost nothing extra. An instance that has moved counts as
/// moving until the pose changes.
class StillImage {
 public:
  enum class Use {
    none,  ///< scan everything
    make,  ///< scan the still instances, keep the words, then scan the moving instances
    use,   ///< start from the kept words and scan only the moving instances
  };

  /// `on` is false if a scan cannot start from the words of another.
  explicit StillImage(bool on) : on_(on) {}

  /// Decides what the next scan of the sensor does. May not be called while inMaking().
  Use next(const Shot& shot, const InstanceTable& instances);
  /// Notes that the next scan must make the image anew. May not be called while the scan that makes the image runs.
  void forget() { state_ = State::missing; }
  /// Returns the instances that a scan places which next() has given `use`.
  Selection selection(Use use) const;
  /// Usable triangles of the still instances.
  uint64_t triangles() const { return triangles_; }

  /// Notes that the scan that makes the image runs in a slot. end() must report whether it succeeded.
  void begin(size_t slot);
  bool inMaking() const { return state_ == State::inMaking; }
  size_t slot() const { return slot_; }
  void end(bool succeeded);

 private:
  enum class State { missing, inMaking, made };

  bool findMoving(const InstanceTable& instances);

  bool on_;
  State state_ = State::missing;
  size_t slot_ = 0;
  std::optional<Pose> pose_;       // pose of the last scan
  std::vector<uint8_t> moving_;    // by instance: 1 if it has moved since the first scan from that pose
  uint64_t seen_ = 0;              // InstanceTable::changes() at the last scan
  uint32_t world_ = 0;             // of the last scan
  std::vector<uint32_t> ignored_;  // by the last shot
  uint64_t triangles_ = 0;
};

}  // namespace gnosphere

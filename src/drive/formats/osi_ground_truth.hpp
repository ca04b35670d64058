// SPDX-License-Identifier: Apache-2.0
// The message GroundTruth of ASAM OSI 3.7.0.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "drive/world.hpp"

namespace gnosphere::drive::osi {

/// Says where the vehicle and the actors of a drive are, in the frame of its world.
class GroundTruthMessages {
 public:
  /// Both must live as long as this object.
  GroundTruthMessages(const Drive& drive, const World& world);

  /// Returns the message of a time of the trajectories' clock.
  std::string messageAt(double time) const;

 private:
  /// Whether an actor is fixed to the vehicle, as the ego's trajectory has it, and around its origin.
  bool isBody(size_t actor) const;

  const Drive& drive_;
  const World& world_;
  std::optional<size_t> body_;  ///< the actor that is the vehicle's body
  uint64_t hostId_ = 0;
  std::vector<bool> stands_;  ///< by actor: whether it is no vehicle, person or animal, and stands all the drive
};

}  // namespace gnosphere::drive::osi

// SPDX-License-Identifier: Apache-2.0
// The table of rivals.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "rivals/rival.hpp"

namespace gnosphere::bench {

/// "all", "none" or names with commas between -> names. Throws Error(invalidArgument) that lists those there are.
std::vector<std::string> parseRivals(const std::string& text);

struct RivalSetting {
  const Scene& scene;  ///< has to outlive the rivals
  Vec3 origin;         ///< near the sensor
  Motion motion = Motion::none;
  std::string device;     ///< as SimulatorOptions::device
  bool software = false;  ///< the device is a CPU
  size_t beams = 0;       ///< of the sensor
};

struct Entrant {
  std::unique_ptr<Rival> rival;
  bool anew = false;  ///< it is to be built for every scan, instead of updated
};

/// Every way of these rivals that suits the motion. Those that cannot be had here are left out, and `notes` says why.
std::vector<Entrant> makeRivals(const std::vector<std::string>& names, const RivalSetting& setting,
                                std::vector<std::string>& notes);

}  // namespace gnosphere::bench

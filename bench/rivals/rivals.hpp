// SPDX-License-Identifier: Apache-2.0
// The table of rivals.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "contender.hpp"

namespace gnosphere::bench {

/// "all", "none" or names with commas between -> names. Throws Error(invalidArgument) that lists those there are.
std::vector<std::string> parseRivals(const std::string& text);

struct RivalSetting {
  const Scene& scene;  ///< has to outlive the rivals
  const SensorRequest& request;
  Vec3 origin;  ///< near the sensor
  Motion motion = Motion::none;
  SimulatorOptions options;  ///< of ours
  DeviceInfo device;         ///< that ours runs on
};

/// Every way of these rivals that suits the motion. Those that cannot be had here are left out, and `notes` says why.
std::vector<std::unique_ptr<Contender>> makeRivals(const std::vector<std::string>& names, const RivalSetting& setting,
                                                   std::vector<std::string>& notes);

}  // namespace gnosphere::bench

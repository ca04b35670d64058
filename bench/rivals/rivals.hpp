// SPDX-License-Identifier: Apache-2.0
// The list of rivals of GnoSphere.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "contender.hpp"

namespace gnosphere::bench {

/// Parses "all", "none" or names separated by commas. Throws Error(invalidArgument) that lists the known names.
std::vector<std::string> parseRivals(const std::string& text);

struct RivalSetting {
  const Scene& scene;  ///< must outlive the rivals
  const SensorRequest& request;
  Vec3 origin;  ///< near the sensor
  Motion motion = Motion::none;
  SimulatorOptions options;  ///< GnoSphere's options
  DeviceInfo device;         ///< the device that GnoSphere uses
};

/// Makes every variant of these rivals that suits the motion. `notes` gets the reasons for those that are not
/// available.
std::vector<std::unique_ptr<Contender>> makeRivals(const std::vector<std::string>& names, const RivalSetting& setting,
                                                   std::vector<std::string>& notes);

}  // namespace gnosphere::bench

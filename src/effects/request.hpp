// SPDX-License-Identifier: Apache-2.0
// Effects from JSON that has been parsed.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "gnosphere/effects.hpp"

namespace gnosphere {

/// Reads effects as effectsFromJson() does.
Effects effectsFrom(const nlohmann::json& root, const std::string& source);
/// Reads the effects of a CARLA lidar: the one whose id is `mode`, or if that is empty the one that all lidars of the
/// file have. Throws Error(format) if there is no such lidar, and if several have different effects.
Effects effectsOfCarla(const nlohmann::json& root, const std::string& source, const std::string& mode);

}  // namespace gnosphere

// SPDX-License-Identifier: Apache-2.0
// How requests and material tables are read: nothing is guessed, nothing is passed over.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace gnosphere {

/// Throws Error(format) for what is not JSON, and for a key that an object has twice: JSON leaves open which counts.
nlohmann::json parseStrict(std::string_view text, const std::string& source);

/// "the nearest are fog, snow, rain", or all of them where there are few.
std::string nearestText(const std::string& name, std::vector<std::string> names);

/// A value as it was written, cut where it is long.
std::string shown(const nlohmann::json& value);

}  // namespace gnosphere

// SPDX-License-Identifier: Apache-2.0
// Strict reading of JSON for requests and material tables.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "base/nearest_text.hpp"

namespace gnosphere {

/// Parses JSON. Throws Error(format) for invalid JSON and for duplicate keys, whose meaning JSON leaves open.
nlohmann::json parseStrict(std::string_view text, const std::string& source);

/// Returns the JSON text of a value, shortened if it is long.
std::string shown(const nlohmann::json& value);

}  // namespace gnosphere

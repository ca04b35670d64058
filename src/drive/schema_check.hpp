// SPDX-License-Identifier: Apache-2.0
// Checks JSON against a JSON schema, with messages for people who write the JSON by hand.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace gnosphere::drive {

/// Returns every mistake as "PATH: what was expected", with paths such as sensors[0].mount; none if the value is valid.
/// Of JSON schema 2020-12 it knows type, enum, properties, required, additionalProperties, items, minItems, maxItems,
/// minLength, minimum, exclusiveMinimum, maximum and $ref into $defs.
std::vector<std::string> mistakesOf(const nlohmann::json& value, const nlohmann::json& schema);

/// Returns the path of a member: "actors[0]" and "class" give "actors[0].class".
std::string memberPath(const std::string& path, const std::string& name);
std::string entryPath(const std::string& path, size_t index);
/// Returns the text between single quotes.
std::string inQuotes(const std::string& text);

}  // namespace gnosphere::drive

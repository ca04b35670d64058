// SPDX-License-Identifier: Apache-2.0
// JSON text to values and back. The library's parser and writer are compiled in the source of this header alone,
// because they take longer to compile than most sources that use them.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "gnosphere/scene.hpp"

namespace gnosphere {

/// The most lists and objects of a text that may lie within one another. Values are copied and written by recursion,
/// so a value with a million levels would overflow the stack. Real files nest about ten levels.
constexpr int kMaximumJsonDepth = 64;

struct JsonTooDeep : nlohmann::json::exception {
  JsonTooDeep();
};

/// Reads JSON, in the type nlohmann::json or nlohmann::ordered_json. Throws nlohmann::json::exception if the text is
/// not JSON, and JsonTooDeep if it nests deeper than kMaximumJsonDepth, or returns a discarded value for both.
template <typename Json = nlohmann::json>
Json parseJson(std::string_view text, bool throws = true);

/// Returns the part of a message of the library that people understand.
std::string readable(const nlohmann::json::exception& problem);

/// Parses a file as JSON. Throws Error(format) for invalid JSON, for JSON that nests too deep, and for
/// duplicate keys, whose meaning JSON leaves open.
nlohmann::json parseStrict(std::string_view bytes, const std::string& source);

/// Returns the text of a value, in one line or with `indent` spaces per level. Invalid UTF-8 in strings is replaced.
template <typename Json>
std::string jsonText(const Json& value, int indent = -1);

/// True if the value is this text. JSON's own == copies the text to compare it and is noexcept, so it ends the process
/// if there is no memory.
bool isText(const nlohmann::json& value, std::string_view text);

/// Returns a member that is text; an empty text if the object has no such member.
std::string textIn(const nlohmann::json& object, const std::string& key);

/// Returns the JSON text of a value, shortened if it is long.
std::string shown(const nlohmann::json& value);

/// Returns a vector as a list of three numbers.
inline nlohmann::ordered_json listOf(const Vec3& v) {
  return {v.x, v.y, v.z};
}

}  // namespace gnosphere

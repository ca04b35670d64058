// SPDX-License-Identifier: Apache-2.0
#include "base/json_text.hpp"

#include <set>
#include <vector>

#include "base/utf8.hpp"
#include "gnosphere/error.hpp"

namespace gnosphere {

using nlohmann::json;

namespace {

// Returns whether the lists and objects of a text nest deeper than kMaximumJsonDepth. A text that does not begin with a
// bracket, such as a file of another kind, has no such depth: the parser stops at the first value or sooner.
bool nestsTooDeep(std::string_view text) {
  const size_t first = text.find_first_not_of(" \t\r\n", text.starts_with("\xef\xbb\xbf") ? 3 : 0);
  if (first == text.npos || (text[first] != '{' && text[first] != '[')) return false;
  int depth = 0;
  bool inString = false;
  for (size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (inString) {
      if (c == '\\') ++i;
      if (c == '"') inString = false;
    } else if (c == '"') {
      inString = true;
    } else if (c == '{' || c == '[') {
      if (++depth > kMaximumJsonDepth) return true;
    } else if (c == '}' || c == ']') {
      --depth;
    }
  }
  return false;
}

}  // namespace

JsonTooDeep::JsonTooDeep()
    : exception(
          0, ("[json.exception.depth] it nests deeper than " + std::to_string(kMaximumJsonDepth) + " levels").c_str()) {
}

template <typename Json>
Json parseJson(std::string_view text, bool throws) {
  if (nestsTooDeep(text)) {
    if (throws) throw JsonTooDeep();
    return Json(Json::value_t::discarded);
  }
  return Json::parse(text, nullptr, throws);
}
template nlohmann::json parseJson(std::string_view, bool);
template nlohmann::ordered_json parseJson(std::string_view, bool);

std::string readable(const json::exception& problem) {
  // "[json.exception.parse_error.101] parse error at line 1, ...": the readable part begins after the bracket.
  const std::string what = problem.what();
  const size_t bracket = what.find("] ");
  return what.substr(bracket == what.npos ? 0 : bracket + 2);
}

json parseStrict(std::string_view bytes, const std::string& source) {
  const std::string_view text = textOfFile(bytes, source);
  std::vector<std::set<std::string>> keys;  // keys so far of each open object
  const auto refuseTwins = [&](int, json::parse_event_t event, json& parsed) {
    if (event == json::parse_event_t::object_start) keys.emplace_back();
    if (event == json::parse_event_t::object_end) keys.pop_back();
    if (event == json::parse_event_t::key && !keys.back().insert(parsed.get<std::string>()).second) {
      throw Error(ErrorCode::format, source + ": '" + parsed.get<std::string>() + "' is there twice; keep one");
    }
    return true;
  };
  try {
    if (nestsTooDeep(text)) throw JsonTooDeep();
    return json::parse(text, refuseTwins);
  } catch (const json::exception& problem) {
    throw Error(ErrorCode::format, source + ": is not JSON: " + readable(problem));
  }
}

template <typename Json>
std::string jsonText(const Json& value, int indent) {
  return value.dump(indent, ' ', false, Json::error_handler_t::replace);
}
template std::string jsonText(const nlohmann::json&, int);
template std::string jsonText(const nlohmann::ordered_json&, int);

bool isText(const json& value, std::string_view text) {
  return value.is_string() && value.get_ref<const std::string&>() == text;
}

std::string textIn(const json& object, const std::string& key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : "";
}

std::string shown(const json& value) {
  constexpr size_t kShown = 40;
  const std::string text = value.dump(-1, ' ', true, json::error_handler_t::replace);
  return text.size() > kShown ? text.substr(0, kShown) + "..." : text;
}

}  // namespace gnosphere

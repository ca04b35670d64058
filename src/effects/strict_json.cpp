// SPDX-License-Identifier: Apache-2.0
#include "effects/strict_json.hpp"

#include <algorithm>
#include <numeric>
#include <set>
#include <utility>

#include "gnosphere/error.hpp"

namespace gnosphere {
namespace {

using nlohmann::json;

/// Returns the number of insertions, removals and exchanges of a letter from `a` to `b` (Levenshtein 1966).
size_t editDistance(std::string_view a, std::string_view b) {
  std::vector<size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), size_t{0});
  for (size_t i = 0; i < a.size(); ++i) {
    size_t diagonal = std::exchange(row[0], i + 1);
    for (size_t j = 0; j < b.size(); ++j) {
      const size_t exchanged = diagonal + (a[i] != b[j]);
      diagonal = row[j + 1];
      row[j + 1] = std::min({row[j] + 1, diagonal + 1, exchanged});
    }
  }
  return row.back();
}

}  // namespace

json parseStrict(std::string_view text, const std::string& source) {
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
    return json::parse(text, refuseTwins);
  } catch (const json::exception& problem) {
    // "[json.exception.parse_error.101] parse error at line 1, ...": the readable part begins after the bracket.
    const std::string what = problem.what();
    const size_t bracket = what.find("] ");
    throw Error(ErrorCode::format, source + ": is not JSON: " + what.substr(bracket == what.npos ? 0 : bracket + 2));
  }
}

std::string nearestText(const std::string& name, std::vector<std::string> names) {
  std::stable_sort(names.begin(), names.end(), [&](const std::string& a, const std::string& b) {
    return editDistance(name, a) < editDistance(name, b);
  });
  constexpr size_t kShown = 3;
  std::string list;
  for (size_t i = 0; i < std::min(kShown, names.size()); ++i) list += (i ? ", " : "") + names[i];
  return (names.size() > kShown ? "the nearest are " : names.size() > 1 ? "there are " : "there is ") + list;
}

std::string shown(const json& value) {
  constexpr size_t kShown = 40;
  const std::string text = value.dump(-1, ' ', true, json::error_handler_t::replace);
  return text.size() > kShown ? text.substr(0, kShown) + "..." : text;
}

}  // namespace gnosphere

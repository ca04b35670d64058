// SPDX-License-Identifier: Apache-2.0
// Suggests the right names for a misspelt one.
#pragma once

#include <algorithm>
#include <numeric>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/text.hpp"

namespace gnosphere {

/// Returns the number of insertions, removals and exchanges of a letter from `a` to `b` (Levenshtein 1966).
inline size_t editDistance(std::string_view a, std::string_view b) {
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

/// Returns text such as "the nearest are fog, snow, rain", or lists all names if there are few, whatever their
/// capitals are.
inline std::string nearestText(const std::string& name, std::vector<std::string> names) {
  constexpr size_t kMostLetters = 64;  // longer names are not compared, because that takes the product of the lengths
  const std::string word = lower(name);
  std::vector<std::pair<size_t, std::string>> byDistance;
  for (std::string& each : names) {
    const bool isCompared = std::max(word.size(), each.size()) <= kMostLetters;
    const size_t distance = isCompared ? editDistance(word, lower(each)) : static_cast<size_t>(-1);
    byDistance.emplace_back(distance, std::move(each));
  }
  std::stable_sort(byDistance.begin(), byDistance.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  constexpr size_t kShown = 3;
  std::string list;
  for (size_t i = 0; i < std::min(kShown, names.size()); ++i) list += (i ? ", " : "") + byDistance[i].second;
  return (names.size() > kShown ? "the nearest are " : names.size() > 1 ? "there are " : "there is ") + list;
}

}  // namespace gnosphere

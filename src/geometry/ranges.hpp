// SPDX-License-Identifier: Apache-2.0
// Runs of entries within an array that several owners share.
#pragma once

#include <cstdint>
#include <iterator>
#include <map>

namespace gnosphere {

/// Allocates runs of entries. A run is taken from the first gap that is large enough, so an array whose owners come and
/// go does not grow without end.
class Ranges {
 public:
  /// Allocates a run of `count` entries and returns the first one.
  uint64_t take(uint64_t count) {
    if (count == 0) return 0;
    for (auto gap = gaps_.begin(); gap != gaps_.end(); ++gap) {
      if (gap->second < count) continue;
      const uint64_t first = gap->first, left = gap->second - count;
      gaps_.erase(gap);
      if (left > 0) gaps_[first + count] = left;
      return first;
    }
    const uint64_t first = end_;
    end_ += count;
    return first;
  }

  void giveBack(uint64_t first, uint64_t count) {
    if (count == 0) return;
    auto gap = gaps_.emplace(first, count).first;
    if (const auto next = std::next(gap); next != gaps_.end() && gap->first + gap->second == next->first) {
      gap->second += next->second;
      gaps_.erase(next);
    }
    if (gap != gaps_.begin())
      if (const auto before = std::prev(gap); before->first + before->second == gap->first) {
        before->second += gap->second;
        gaps_.erase(gap);
        gap = before;
      }
    if (gap->first + gap->second == end_) {
      end_ = gap->first;
      gaps_.erase(gap);
    }
  }

  /// Returns the last entry in use plus one.
  uint64_t end() const { return end_; }

 private:
  std::map<uint64_t, uint64_t> gaps_;  // from the first entry of a gap to its length; no two gaps touch
  uint64_t end_ = 0;
};

}  // namespace gnosphere

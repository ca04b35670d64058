// SPDX-License-Identifier: Apache-2.0
// Runs of entries within an array that several owners share.
#pragma once

#include <cstdint>
#include <iterator>
#include <map>
#include <utility>
#include <vector>

namespace gnosphere {

/// Allocates runs of an array's entries. A run is taken from the first gap that is large enough, so an array whose
/// owners come and go does not grow without end. Taking a run allocates the memory that giving it back needs, so that
/// whatever fails can be undone.
class Ranges {
 public:
  /// Allocates a run of `count` entries and returns the first one. Throws std::bad_alloc, and then has changed nothing.
  uint64_t take(uint64_t count) {
    if (count == 0) return 0;
    addSpare();
    for (auto gap = gaps_.begin(); gap != gaps_.end(); ++gap) {
      if (gap->second < count) continue;
      const uint64_t first = gap->first, left = gap->second - count;
      auto node = gaps_.extract(gap);
      if (left > 0) put(std::move(node), first + count, left);
      return first;
    }
    const uint64_t first = end_;
    end_ += count;
    return first;
  }

  void giveBack(uint64_t first, uint64_t count) noexcept {
    if (count == 0) return;
    auto gap = put(std::move(spares_.back()), first, count);
    spares_.pop_back();
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
  using Gaps = std::map<uint64_t, uint64_t>;  // from the first entry of a gap to its length; no two gaps touch

  Gaps::iterator put(Gaps::node_type node, uint64_t first, uint64_t count) noexcept {
    node.key() = first;
    node.mapped() = count;
    return gaps_.insert(std::move(node)).position;
  }
  void addSpare() {
    Gaps made;
    made.emplace(0, 0);
    spares_.push_back(made.extract(made.begin()));
  }

  Gaps gaps_;
  std::vector<Gaps::node_type> spares_;  // one per run that is taken
  uint64_t end_ = 0;
};

/// Runs that are being taken: they are given back unless keep() is called.
class TakenRuns {
 public:
  TakenRuns() = default;
  TakenRuns(const TakenRuns&) = delete;
  TakenRuns& operator=(const TakenRuns&) = delete;
  ~TakenRuns() {
    for (const Run& run : runs_) run.ranges->giveBack(run.first, run.count);
  }
  uint64_t take(Ranges& ranges, uint64_t count) {
    runs_.push_back({&ranges, 0, 0});
    runs_.back().first = ranges.take(count);
    runs_.back().count = count;
    return runs_.back().first;
  }
  void keep() noexcept { runs_.clear(); }

 private:
  struct Run {
    Ranges* ranges;
    uint64_t first, count;
  };
  std::vector<Run> runs_;
};

}  // namespace gnosphere

// SPDX-License-Identifier: Apache-2.0
// Runs of entries of an array whose owners come and go, against a list of which entries are taken.
#include <algorithm>
#include <catch2/catch_test_macros.hpp>
#include <cstdint>
#include <map>
#include <random>
#include <vector>

#include "geometry/ranges.hpp"

using gnosphere::Ranges;
using gnosphere::TakenRuns;

namespace {

/// Ranges, and for every entry whether it is taken.
struct Watched {
  Ranges ranges;
  std::vector<bool> taken;

  // The first place at which `count` entries are free, also behind all others.
  uint64_t firstFit(uint64_t count) const {
    uint64_t run = 0;
    for (uint64_t i = 0; i < taken.size(); ++i) {
      run = taken[i] ? 0 : run + 1;
      if (run == count) return i + 1 - count;
    }
    return taken.size() - run;
  }
  void mark(uint64_t first, uint64_t count, bool is) {
    taken.resize(std::max<uint64_t>(taken.size(), first + count));
    for (uint64_t i = first; i < first + count; ++i) {
      REQUIRE(taken[i] != is);
      taken[i] = is;
    }
    while (!taken.empty() && !taken.back()) taken.pop_back();
  }
};

}  // namespace

TEST_CASE("a run lies in the first gap with room for it, and gaps that touch are one") {
  std::mt19937 random(1);
  Watched watched;
  std::vector<std::pair<uint64_t, uint64_t>> runs;
  for (int turn = 0; turn < 20'000; ++turn) {
    const bool takes = runs.empty() || random() % 100 < (turn / 500 % 2 == 0 ? 60 : 35);
    if (takes) {
      const uint64_t count = 1 + random() % 9, wanted = watched.firstFit(count), first = watched.ranges.take(count);
      REQUIRE(first == wanted);
      watched.mark(first, count, true);
      runs.emplace_back(first, count);
    } else {
      std::swap(runs[random() % runs.size()], runs.back());
      const auto [first, count] = runs.back();
      runs.pop_back();
      watched.ranges.giveBack(first, count);
      watched.mark(first, count, false);
    }
    REQUIRE(watched.ranges.end() == watched.taken.size());
  }
  for (const auto& [first, count] : runs) watched.ranges.giveBack(first, count);
  CHECK(watched.ranges.end() == 0);
}

TEST_CASE("runs of no entries take nothing, and runs that are not kept are given back") {
  Ranges ranges;
  CHECK(ranges.take(0) == 0);
  ranges.giveBack(0, 0);
  CHECK(ranges.take(5) == 0);
  {
    TakenRuns taken;
    CHECK(taken.take(ranges, 3) == 5);
    CHECK(taken.take(ranges, 0) == 0);
    CHECK(taken.take(ranges, 4) == 8);
  }
  CHECK(ranges.end() == 5);
  {
    TakenRuns taken;
    CHECK(taken.take(ranges, 3) == 5);
    taken.keep();
  }
  CHECK(ranges.end() == 8);
}

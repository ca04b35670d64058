// SPDX-License-Identifier: Apache-2.0
// Numbers and names as the command line prints them, and the times at which a run tells how far it is.
#include <catch2/catch_test_macros.hpp>

#include "console.hpp"

using namespace gnosphere::cli;

TEST_CASE("counts have the word for one or for many") {
  CHECK(counted(1, "frame", "frames") == "1 frame");
  CHECK(counted(0, "frame", "frames") == "0 frames");
  CHECK(counted(1234, "frame", "frames") == "1,234 frames");
}

TEST_CASE("characters that control a terminal are shown as numbers, and all other text as it is") {
  CHECK(printable("plain, Stra\xc3\x9f"
                  "e, \xe2\x82\xac") ==
        "plain, Stra\xc3\x9f"
        "e, \xe2\x82\xac");
  CHECK(printable("a\x1b[2Jb\nc\x7f") == "a\\x1b[2Jb\\x0ac\\x7f");
  CHECK(printable("\xc2\x9b"
                  "31m\xc2\xa9") ==
        "\\x9b"
        "31m\xc2\xa9");
  CHECK(printable(std::string("a\0b", 3)) == "a\\x00b");
}

TEST_CASE("a long run without a terminal tells of tenths of its work, at most every ten seconds") {
  const auto linesOf = [](uint64_t total, double msPerStep) {
    ProgressLines lines(0);
    std::vector<uint64_t> at;
    for (uint64_t done = 1; done <= total; ++done)
      if (lines.isDue(done, total, msPerStep * static_cast<double>(done))) at.push_back(done);
    return at;
  };
  CHECK(linesOf(1000, 1).empty());                                                                   // 1 s
  CHECK(linesOf(1000, 1000) == std::vector<uint64_t>{100, 200, 300, 400, 500, 600, 700, 800, 900});  // 100 s a tenth
  CHECK(linesOf(1000, 50) == std::vector<uint64_t>{200, 400, 600, 800});                             // 5 s a tenth
  CHECK(linesOf(3, 60'000) == std::vector<uint64_t>{1, 2});
}

// SPDX-License-Identifier: Apache-2.0
// Numbers and names as the command line prints them, and the times at which a run tells how far it is.
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch_approx.hpp>
#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <numbers>

#include "base/file.hpp"
#include "base/quaternion.hpp"
#include "console.hpp"
#include "drive/pose_math.hpp"
#include "folder.hpp"
#include "pose_text.hpp"

using namespace gnosphere::cli;
using Catch::Approx;

namespace {

constexpr double kRight = std::numbers::pi / 2;

}  // namespace

TEST_CASE("counts have the word for one or for many") {
  CHECK(counted(1, "frame", "frames") == "1 frame");
  CHECK(counted(0, "frame", "frames") == "0 frames");
  CHECK(counted(1234, "frame", "frames") == "1,234 frames");
  CHECK(counted(1234567890, "frame", "frames") == "1,234,567,890 frames");
}

TEST_CASE("lengths have three digits in one form") {
  CHECK(metres(0) == "0");
  CHECK(metres(0.00062) == "6.20e-04");
  CHECK(metres(0.0019) == "1.90e-03");
  CHECK(metres(12.345) == "1.23e+01");
}

TEST_CASE("lines break at blanks, and those behind the first begin further right") {
  CHECK(wrapped("", 10) == "");
  CHECK(wrapped("one two three", 7) == "one two\nthree");
  CHECK(wrapped("one two three", 9, 2) == "one two\n  three");
  CHECK(wrapped("one two three", 8, 2) == "one\n  two\n  three");
  CHECK(wrapped("one indivisible word", 5) == "one\nindivisible\nword");
  CHECK(wrapped("one\ntwo three\n", 20) == "one\ntwo three\n");
}

TEST_CASE("lines and tables reach a file at once, also where the standard output is buffered in blocks") {
  const gnosphere::test::Folder folder;
  const std::filesystem::path file = folder.path() / "out";
  const pid_t child = fork();
  if (child == 0) {
    const bool isReady = std::freopen(file.c_str(), "w", stdout) && std::setvbuf(stdout, nullptr, _IOFBF, 4096) == 0;
    say("label", "text");
    printTable({{"a", "b"}}, 1);
    _exit(isReady ? 0 : 1);  // which leaves out what is still in the buffer
  }
  int status = 1;
  REQUIRE(waitpid(child, &status, 0) == child);
  CHECK(status == 0);
  CHECK(gnosphere::readWholeFile(file) == "label      text\na  b\n");
}

TEST_CASE("the angles of a pose are those of drive files") {
  const gnosphere::Pose pose = parsePose("1,2,3, roll=30,yaw=90,pitch=5");
  const gnosphere::Quaternion expected = gnosphere::drive::yawPitchRoll(kRight, kRight / 18, kRight / 3);
  CHECK(pose.position.z == 3);
  CHECK(pose.orientation.x == Approx(expected.x));
  CHECK(pose.orientation.y == Approx(expected.y));
  CHECK(pose.orientation.z == Approx(expected.z));
  CHECK(pose.orientation.w == Approx(expected.w));
  const gnosphere::Vec3 forward = parsePose("0,0,0,yaw=90,pitch=30").orientation * gnosphere::Vec3{1, 0, 0};
  CHECK(forward.y == Approx(std::sqrt(0.75)));  // to the left
  CHECK(forward.z == Approx(-0.5));             // and down
  CHECK(turnText(pose.orientation) == "turned by roll 30, pitch 5, yaw 90 degrees");
  CHECK(turnText({0, 0, 0, -1}) == "");
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

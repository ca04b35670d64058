// SPDX-License-Identifier: Apache-2.0
// gnosphere drive as a script would run it, also one that ends badly.
#include <signal.h>
#include <unistd.h>

#include <catch2/matchers/catch_matchers_string.hpp>
#include <system_error>

#include "drive_support.hpp"
#include "tools/cli_support.hpp"

using namespace gnosphere::test;
using Catch::Matchers::ContainsSubstring;
using Catch::Matchers::StartsWith;

namespace {

/// A workplace with a drive of 10 frames.
struct DrivePlace : Workplace {
  DrivePlace() {
    put("cube.obj", kCube);
    put("floor.obj", kFloor);
    Json json = quietDrive();
    json["outputs"] = {{{"format", "semantickitti"}}, {{"format", "boxes"}}, {{"format", "mcap"}}};
    put("drive.json", json.dump());
  }
  Result make(const std::string& arguments, const std::string& before = "") const {
    return run("drive drive.json --device reference " + arguments, before);
  }
  /// The difference of two output folders as diff tells it; empty if there is none.
  std::string difference(const std::string& a, const std::string& b) const {
    const Result result = run("-r -x lock " + a + " " + b, "", "/usr/bin/diff");
    return result.out + result.err;
  }
};

}  // namespace

TEST_CASE("gnosphere drive says what it will do, and what it did") {
  const DrivePlace place;
  const Result check = place.make("");
  CHECK(check.status == 0);
  CHECK(check.err.empty());
  CHECK_THAT(check.out, ContainsSubstring("small, 10 frames at 10 Hz, 1 s") &&
                            ContainsSubstring("2 actors\nmodels     cube 1 x 1 x 1 m\n") &&
                            ContainsSubstring("\noutput     semantickitti in semantickitti/, sensor top\n") &&
                            ContainsSubstring("\noutput     mcap in mcap/, sensors top, side\n"));
  const Result some = place.make("-o out_a --frames 2:5");
  CHECK_THAT(some.out, ContainsSubstring("3: 3 made, 0 complete before") &&
                           ContainsSubstring("\ndrive      not complete; 7 of 10 frames are missing, the first is 0; "
                                             "its tables are written with its last frame\n"));
  CHECK_THAT(place.make("-o out_a --frames 0:1").out,
             ContainsSubstring("; 6 of 10 frames are missing, the first is 1;"));
  CHECK_THAT(place.make("-o out_e --frames :9").out, ContainsSubstring("; 1 of 10 frames is missing, frame 9; "));
  uint64_t bytes = 0;
  for (const char* frame : {"2", "3", "4"}) {
    const Json entries = Json::parse(place.get(std::string("out_a/manifest/frames/00000") + frame + ".json"));
    for (const Json& file : entries["files"]) bytes += file["bytes"].get<uint64_t>();
  }
  CHECK_THAT(some.out, ContainsSubstring(" files of " + std::to_string((bytes + 500'000) / 1'000'000) + " MB\n"));
  const Result rest = place.make("-o out_a");
  CHECK(rest.err.empty());  // no progress in a pipe
  CHECK_THAT(rest.out, ContainsSubstring("10: 6 made, 4 complete before") && ContainsSubstring("drive      complete"));
}

TEST_CASE("a seed on the command line is that of a drive file that states it") {
  const DrivePlace place;
  Json json = Json::parse(place.get("drive.json"));
  json["sensors"][0]["effects"] = {{"range-noise", {{"sigma", 0.1}}}};
  json["sensors"][1]["effects"] = {{"seed", 9}};
  place.put("drive.json", json.dump());
  CHECK_THAT(place.make("").out, ContainsSubstring("\nseed       1; that of sensor side is 9\n"));
  CHECK_THAT(place.make("-o seven --seed 7").out, ContainsSubstring("\nseed       7; that of sensor side is 9\n"));
  json["seed"] = 7;
  place.put("drive.json", json.dump());
  CHECK(place.make("-o stated").status == 0);
  CHECK(place.difference("seven", "stated") == "");
  CHECK(place.make("-o other --seed 18446744073709551615").status == 0);
  const std::string points = "/semantickitti/sequences/00/velodyne/000000.bin";
  CHECK(place.get("other" + points) != place.get("seven" + points));
  CHECK_THAT(place.make("-o seven --seed 8").err, ContainsSubstring("holds frames of another drive"));
}

TEST_CASE("a name on the command line is that of a drive file that states it") {
  const DrivePlace place;
  Json json = Json::parse(place.get("drive.json"));
  json["outputs"] = {{{"format", "nuscenes"}, {"version", "v1.0-mini"}}};
  place.put("drive.json", json.dump());
  CHECK_THAT(place.make("-o named --name scene-0061").out, StartsWith("drive      scene-0061, 10 frames"));
  CHECK_THAT(place.get("named/nuscenes/v1.0-mini/scene.json"), ContainsSubstring("\"name\": \"scene-0061\""));
  CHECK_THAT(place.get("named/nuscenes/v1.0-mini/sample_data.json"),
             ContainsSubstring("\"samples/top/scene-0061__top__"));
  CHECK_THAT(place.get("named/manifest/drive_file.json"), ContainsSubstring("\"name\": \"scene-0061\""));
  json["name"] = "scene-0061";
  place.put("drive.json", json.dump());
  CHECK(place.make("-o stated").status == 0);
  CHECK(place.difference("named", "stated") == "");
  CHECK_THAT(place.make("-o named --name other").err, ContainsSubstring("holds frames of another drive"));
  const Result wrong = place.make("-o wrong --name ../escaped");
  CHECK(wrong.status == 2);
  CHECK_THAT(wrong.err, ContainsSubstring("--name: must have letters, digits, _ and - only, is \"../escaped\""));
}

TEST_CASE("a drive without any point is told, and so is a file that has been changed") {
  const DrivePlace place;
  Json json = Json::parse(place.get("drive.json"));
  json["ego"]["trajectory"] = {{"waypoints", {waypoint(0, 5000, 0, 0), waypoint(1, 5001, 0, 0)}}};
  json["weather"] = Json::array();  // drops of rain give points
  place.put("far.json", json.dump());
  const Result far = place.run("drive far.json --device reference -o far");
  CHECK(far.status == 0);
  CHECK(
      far.err ==
      "gnosphere: warning: no scan has a point; the scenes span x -20..20, y -20..20, z 0..0 m, 2 actors start within "
      "x 1..3, y -3..3, z 0.75..0.9 m, and sensor 'top' starts at 5000, 0, 1.8 and sees as far as 60 "
      "m\n");
  json = Json::parse(place.get("drive.json"));
  json["weather"] = Json::array();
  for (Json& sensor : json["sensors"]) sensor["effects"] = {{"drop-out", {{"general_rate", 1}}}};
  place.put("lost.json", json.dump());
  CHECK_THAT(place.run("drive lost.json --device reference -o lost").err,
             StartsWith("gnosphere: warning: no scan has a point; ") && ContainsSubstring(" beams dropped out, ") &&
                 ContainsSubstring(" met nothing in their ranges; they are "
                                   "lost at random, with the probabilities drop-out.general_rate"));
  json = Json::parse(place.get("far.json"));
  json["sensors"][1]["sensor"]["near_hits"] = "hide";
  place.put("hidden.json", json.dump());
  CHECK_THAT(place.run("drive hidden.json --device reference -o hidden").err,
             ContainsSubstring("starts at 5000, 0, 1.8 and sees as far as 60 m; surfaces nearer than the least range "
                               "of sensor 'side', 0.1 m, "
                               "hide what is behind them, because its near_hits is hide\n"));
  REQUIRE(place.make("-o out_c --frames :1").err.empty());
  REQUIRE(place.make("-o out_c").status == 0);
  place.put("out_c/classes.json", "{}");
  CHECK_THAT(place.make("-o out_c").out,
             ContainsSubstring("\nbroken     classes.json was not as it had been written, and is made again\n"));
}

TEST_CASE("a log of a drive has its first lines while the drive runs") {
  const DrivePlace place;
  Json json = Json::parse(place.get("drive.json"));
  json["ego"]["trajectory"]["waypoints"][1]["time"] = 100;  // seconds of work
  place.put("drive.json", json.dump());
  const std::string file = place / "drive.json", out = place / "out_d", log = place / "log";
  const pid_t child = fork();
  if (child == 0) {
    std::freopen(log.c_str(), "w", stdout);
    execl(GNOSPHERE_BINARY, "gnosphere", "drive", file.c_str(), "-o", out.c_str(), "--device", "reference", nullptr);
    _exit(127);
  }
  int status = 0;
  while (!fs::exists(place / "out_d/manifest/frames/000001.json") && waitpid(child, &status, WNOHANG) == 0) usleep(200);
  kill(child, SIGKILL);
  waitpid(child, &status, 0);
  CHECK(WIFSIGNALED(status));
  CHECK_THAT(place.get("log"), ContainsSubstring("small, 1,000 frames") && ContainsSubstring("output     mcap in") &&
                                   ContainsSubstring("\ndevice     reference\n"));
}

TEST_CASE("wrong calls of gnosphere drive are refused before anything is written") {
  const DrivePlace place;
  const auto refused = [&](const std::string& arguments, int status, const std::string& words) {
    INFO(arguments);
    const auto before = place.files();
    const Result result = place.make(arguments);
    CHECK(result.status == status);
    CHECK_THAT(result.err, ContainsSubstring(words));
    CHECK(std::count(result.err.begin(), result.err.end(), '\n') == 1);
    CHECK(place.files() == before);
  };
  refused("-o out_b --frames 5:5", 2, "--frames: '5:5' is not A:B");
  refused("-o out_b --frames 7", 2, "--frames: '7' is not A:B");
  refused("-o out_b --frames 10:", 2, "--frames: the drive has the frames 0 to 9");
  refused("-o out_b --seed -1", 2, "--seed");
  refused("-o out_b --shard 4/4", 2, "--shard: '4/4' is not I/N");
  refused("-o out_b --shard a/4", 2, "--shard: 'a/4' is not I/N");
  place.put("drive.json", "{\"scenes\": [}");
  refused("-o out_b", 1, "is not JSON");
  place.put("drive.json", "{\"scenes\": []}");
  refused("-o out_b", 1, "scenes: must have at least 1 entry, has 0; ego: is missing; sensors: is missing");
  place.put("wall", "");
  place.put("drive.json", quietDrive().dump());
  refused("-o wall/out", 1, "wall/out");
}

TEST_CASE("a drive that is killed five times and resumed has the same bytes") {
  const DrivePlace place;
  Json json = Json::parse(place.get("drive.json"));
  json["ego"]["trajectory"]["waypoints"][1]["time"] = 4;
  place.put("drive.json", json.dump());
  REQUIRE(place.make("-o whole").status == 0);
  const auto framesDone = [&] {
    std::error_code absent;
    return std::distance(fs::directory_iterator(place / "resumed/manifest/frames", absent), {});
  };
  int killed = 0;
  for (const long frames : {3, 8, 15, 22, 30}) {
    const std::string file = place / "drive.json", out = place / "resumed";
    const pid_t child = fork();
    if (child == 0) {
      std::freopen("/dev/null", "w", stdout);
      execl(GNOSPHERE_BINARY, "gnosphere", "drive", file.c_str(), "-o", out.c_str(), "--device", "reference", nullptr);
      _exit(127);
    }
    int status = 0;
    while (framesDone() < frames && waitpid(child, &status, WNOHANG) == 0) usleep(200);
    kill(child, SIGKILL);
    waitpid(child, &status, 0);
    killed += WIFSIGNALED(status) && framesDone() < 40;
  }
  CHECK(killed >= 3);  // on a busy machine a run may be done before it is killed
  REQUIRE(place.make("-o resumed").status == 0);
  CHECK(place.difference("whole", "resumed") == "");
}

TEST_CASE("where the disk is full complete frames stay, and the drive goes on when there is room") {
  const DrivePlace place;
  REQUIRE(place.make("-o whole").status == 0);
  // No file may be larger than 12 KiB. The shell ignores the signal, so that writing fails as on a full disk.
  const Result full = place.make("-o full", "trap '' XFSZ; ulimit -f 12; ");
  CHECK(full.status == 1);
  CHECK(std::count(full.err.begin(), full.err.end(), '\n') == 1);
  CHECK_THAT(full.err, ContainsSubstring("cannot be written: File too large"));
  for (const auto& entry : fs::recursive_directory_iterator(place / "full")) CHECK(entry.path().extension() != ".part");
  REQUIRE(place.make("-o full").status == 0);
  CHECK(place.difference("whole", "full") == "");
}

TEST_CASE("the town has an example drive") {
  const Workplace place;
  REQUIRE(place.run("town --triangles 3000 -o town.glb --drive example.json").status == 0);
  CHECK(place.files() == std::vector<std::string>{"example-car.glb", "example-person.glb", "example.json",
                                                  "example.tum", "floor.obj", "town.glb"});
  const Result check = place.run("drive example.json");
  CHECK(check.err.empty());
  CHECK_THAT(check.out, ContainsSubstring("town, 100 frames") && ContainsSubstring("11 actors") &&
                            ContainsSubstring("\nmade       nothing; -o FOLDER makes the data set\n"));
}

// SPDX-License-Identifier: Apache-2.0
// Tests of `gnosphere scan --trajectory` as a program.
#include <catch2/matchers/catch_matchers_floating_point.hpp>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <sstream>

#include "gnosphere/output.hpp"
#include "support.hpp"
#include "tools/cli_support.hpp"

using namespace gnosphere::test;
using Catch::Matchers::ContainsSubstring;
using Catch::Matchers::StartsWith;

namespace {

const std::string kThree = "# t x y z qx qy qz qw\n0 0 0 1.8 0 0 0 1\n1 2 0 1.8 0 0 1 0\n2 -1 3 2 0 0 0 1\n";

}  // namespace

TEST_CASE("a trajectory gives the same files as its poses one by one") {
  const Workplace place;
  place.put("t.tum", kThree);
  const Result result = place.run("scan floor.obj --trajectory t.tum -o a.csv --image i.png --stats s.json" + kQuick);
  CHECK(result.err == "");
  REQUIRE(result.status == 0);
  CHECK_THAT(result.out, ContainsSubstring("at 3 poses") && ContainsSubstring("a-000000.csv") &&
                             ContainsSubstring("a-000002.csv") && ContainsSubstring("scans a second"));
  CHECK(place.files() == std::vector<std::string>{"a-000000.csv", "a-000001.csv", "a-000002.csv", "floor.obj",
                                                  "i-000000.png", "i-000001.png", "i-000002.png", "s.json", "t.tum"});
  CHECK_THAT(result.out, ContainsSubstring("\ntriangles  6 placed in all scans together"));
  const char* poses[] = {"0,0,1.8", "2,0,1.8,0,0,1,0", "-1,3,2"};
  const auto stats = place.json("s.json");
  CHECK(stats.at("frame").at("runs") == 3);
  CHECK(stats.at("frame").at("total_ms") > 0);
  REQUIRE(stats.at("frames").size() == 3);
  for (int i = 0; i < 3; ++i) {
    INFO("pose " << i);
    REQUIRE(place.run("scan floor.obj -o b.csv --stats b.json --pose " + std::string(poses[i]) + kQuick).status == 0);
    CHECK(place.get("a-00000" + std::to_string(i) + ".csv") == place.get("b.csv"));
    const auto alone = place.json("b.json");
    const auto& frame = stats.at("frames").at(i);
    CHECK(frame.at("pose") == alone.at("pose"));
    CHECK(frame.at("counters") == alone.at("counters"));
    CHECK(frame.at("wall_ms") > 0);
  }
}

TEST_CASE("a sensor that fires all beams at once measures its speed between the poses of a trajectory") {
  const Workplace place;
  place.put("t.tum", "0 0 0 1.8 0 0 0 1\n0.5 1 0 1.8 0 0 0 1\n1 4 0 1.8 0 0 0 1\n");
  const Result result = place.run(
      "scan floor.obj --sensor VLP-16 --trajectory t.tum -o a.csv --fields x,y,z,radial_speed --effect "
      "detection=off --device reference");
  REQUIRE(result.status == 0);
  const double speeds[] = {2, 4, 6};  // m/s along x, between the poses before and after each pose
  for (int i = 0; i < 3; ++i) {
    std::istringstream lines(place.get("a-00000" + std::to_string(i) + ".csv"));
    std::string line;
    std::getline(lines, line);
    size_t points = 0;
    for (double x = 0, y = 0, z = 0, speed = 0; std::getline(lines, line);) {
      REQUIRE(std::sscanf(line.c_str(), "%lf,%lf,%lf,%lf", &x, &y, &z, &speed) == 4);
      if (std::isnan(x)) continue;  // a beam without a return
      ++points;
      CHECK_THAT(speed, Catch::Matchers::WithinAbs(-speeds[i] * x / std::hypot(x, y, z), 1e-3));
    }
    CHECK(points > 100);
  }
}

TEST_CASE("the times of scans leave out what is drawn of them") {
  needVulkan();
  const Workplace place;
  place.put("t.tum", kThree);
  REQUIRE(place.run("scan floor.obj --trajectory t.tum --image i.png --stats s.json --effects clean").status == 0);
  const auto frame = place.json("s.json").at("frame");
  CHECK(frame.at("wall_ms").at("median").get<double>() < frame.at("total_ms").get<double>() / 6);
}

TEST_CASE("a trajectory whose scans meet nothing is told, and why beams are lost") {
  const Workplace place;
  place.put("t.tum", "0 0 0 5000 0 0 0 1\n1 2 0 5000 0 0 0 1\n");
  const Result far = place.run("scan floor.obj --trajectory t.tum -o a.npy" + kQuick);
  REQUIRE(far.status == 0);
  CHECK_THAT(far.err, StartsWith("gnosphere: warning: no beam of any scan hits anything; floor.obj spans x -10..10") &&
                          ContainsSubstring(
                              "the sensor first at 0, 0, 5000 sees as far as 100 m; another --trajectory moves it"));
  place.put("t.tum", kThree);
  const Result near = place.run("scan floor.obj --trajectory t.tum -o b.npy --effect fog.visibility=20" + kQuick);
  CHECK(near.err == "");
  CHECK_THAT(near.out, ContainsSubstring("\nlost       ") && ContainsSubstring(" met nothing"));
}

TEST_CASE("a rotating sensor moves along the trajectory during a scan, and each scan draws new random numbers") {
  const Workplace place;
  place.put("t.tum", "0 0 0 1.8 0 0 0 1\n0.05 1 0 1.8 0 0 0 1\n0.1 2 0 1.8 0 0 0 1\n5 2 0 1.8 0 0 0 1\n");
  auto sensor = place.runJson("sensors VLP-16 --json");
  sensor["rotation_period"] = 0.1;
  place.put("spin.json", sensor.dump());
  const std::string quick = " --device reference --sensor spin.json";
  REQUIRE(place.run("scan floor.obj --trajectory t.tum -o a.csv" + quick).status == 0);
  REQUIRE(place.run("scan floor.obj --trajectory t.tum -o b.csv --effect sensor-motion=off" + quick).status == 0);
  CHECK(place.get("a-000000.csv") != place.get("b-000000.csv"));
  CHECK(place.get("a-000003.csv") == place.get("b-000003.csv"));  // nothing follows the last pose

  place.put("dense.tum", "0 0 0 1.8 0 0 0 1\n0.01 0 0 1.8 0 0 0 1\n0.02 0 0 1.8 0 0 0 1\n");
  CHECK_THAT(
      place.run("scan floor.obj --trajectory dense.tum -o d.csv" + quick).err,
      StartsWith(
          "gnosphere: warning: dense.tum has a pose every 0.01 s, and a turn of VLP-16 takes 0.1 s, so the scans "
          "overlap; gnosphere drive makes one scan per turn"));
  std::string nanoseconds;
  for (int i = 0; i < 10; ++i) nanoseconds += std::to_string(i) + "00000000 0 0 1.8 0 0 0 1\n";
  place.put("nano.tum", nanoseconds);
  CHECK(place.run("scan floor.obj --trajectory nano.tum -o n.csv" + quick).err ==
        "gnosphere: warning: nano.tum has a pose every 1e+08 s; times are in seconds, and these look like "
        "nanoseconds\n");
  // From half a turn on nothing is told of that. A triangle that is dropped from every scan is one triangle.
  place.put("half.tum", "0 0 0 1.8 0 0 0 1\n0.06 0 0 1.8 0 0 0 1\n0.12 0 0 1.8 0 0 0 1\n");
  place.put("hole.obj", place.get("floor.obj") + "v nan 0 0\nf 1 2 -1\n");
  CHECK(place.run("scan hole.obj --trajectory half.tum -o d.csv" + quick).err ==
        "gnosphere: warning: 1 triangle of hole.obj is dropped because a corner is NaN, infinite or beyond 1e9 m or "
        "units of the file\n");

  REQUIRE(
      place
          .run("scan floor.obj --trajectory t.tum -o n.csv --effect sensor-motion=off --effect range-noise.sigma=0.1" +
               quick)
          .status == 0);
  CHECK(place.get("n-000002.csv") != place.get("n-000003.csv"));  // the same pose but another frame

  place.put("back.tum", "1 0 0 1.8 0 0 0 1\n0.5 1 0 1.8 0 0 0 1\n");
  const Result result = place.run("scan floor.obj --trajectory back.tum -o c.csv" + quick);
  CHECK(result.status != 0);
  CHECK_THAT(result.err, ContainsSubstring("0.5 does not come after 1"));
}

TEST_CASE("a list whose beams fire one after the other moves along the trajectory during a scan") {
  const Workplace place;
  place.put("t.tum", "0 0 0 1.8 0 0 0 1\n0.1 2 0 1.8 0 0 0 1\n5 2 0 1.8 0 0 0 1\n");
  place.put("wall.obj", "v 10 -5 0\nv 10 5 0\nv 10 0 9\nf 1 2 3\n");
  // Two beams look forward, one at the start of a scan and one 50 ms later.
  place.put("list.json", R"({"name": "two", "range": {"min": 0, "max": 100},
                             "patterns": [{"directions": [[1, 0, 0], [1, 0, 0]], "times": [0, 0.05]}]})");
  REQUIRE(
      place.run("scan wall.obj --trajectory t.tum -o a.csv --fields x --device reference --sensor list.json").status ==
      0);
  std::istringstream rows(place.get("a-000000.csv"));
  std::string header, first, second;
  std::getline(rows, header);
  std::getline(rows, first);
  std::getline(rows, second);
  INFO(place.get("a-000000.csv"));
  CHECK_THAT(std::stod(first) - std::stod(second), Catch::Matchers::WithinAbs(1, 1e-5));  // at 20 m/s
}

TEST_CASE("scan --stats - with a trajectory prints only JSON") {
  const Workplace place;
  place.put("t.tum", kThree);
  const Result result = place.run("scan floor.obj --trajectory t.tum --stats -" + kQuick);
  REQUIRE(result.status == 0);
  CHECK(result.err == "");
  CHECK(nlohmann::json::parse(result.out).at("frames").size() == 3);
}

TEST_CASE("an invalid call with a trajectory is refused before anything is written") {
  checkRefused("scan floor.obj --pose 1,2,3 --trajectory t.tum", 2, "--trajectory");
  checkRefused("scan floor.obj --repeat 3 --trajectory t.tum", 2, "--trajectory");
  checkRefused("scan floor.obj --max-error 0.1 --trajectory t.tum", 2, "--trajectory");
  checkRefused("scan floor.obj --trajectory t.tum -o a.pcd", 1, "t.tum");
  const Workplace place;
  place.put("t.tum", kThree);
  const auto refused = [&](const std::string& arguments, int status, const std::string& words) {
    INFO(arguments);
    const auto before = place.files();
    const Result result = place.run("scan " + arguments + kQuick);
    CHECK(result.status == status);
    CHECK_THAT(result.err, StartsWith("gnosphere: ") && ContainsSubstring(words));
    CHECK(place.files() == before);
  };
  refused("floor.obj --trajectory t.tum -o none/a.pcd", 1, "none/a-000000.pcd");
  refused("floor.obj --trajectory t.tum -o a.pcd -o a.pcd", 2, "twice");
  place.put("a-000002.ply",
            "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\n"
            "property float z\nelement face 0\nproperty list uchar int vertex_indices\nend_header\n");
  refused("a-000002.ply --trajectory t.tum -o a.ply", 2, "is read, too, as a-000002.ply");
}

// SPDX-License-Identifier: Apache-2.0
// gnosphere town as a script would run it.
#include <algorithm>
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <cmath>
#include <cstdio>
#include <map>
#include <sstream>

#include "tools/cli_support.hpp"

using namespace gnosphere::test;
using Catch::Matchers::ContainsSubstring;

namespace {

const std::string kNetwork = " --xodr '" GNOSPHERE_TEST_DATA "/junction.xodr' ";

}  // namespace

TEST_CASE("a town is written and can be scanned") {
  const Workplace place;
  REQUIRE(place.run("town -o town.glb --triangles 20000 --seed 3").status == 0);
  const Result result = place.run("scan town.glb" + kQuick);
  CHECK(result.status == 0);
  CHECK(result.err == "");
}

TEST_CASE("a town along a network is written, baked and scanned from the poses of its drive") {
  const Workplace place;
  const Result town = place.run("town -o town.glb --triangles 30000 --bake --trajectory drive.tum" + kNetwork);
  REQUIRE(town.status == 0);
  CHECK(town.err.empty());
  CHECK_THAT(town.out, ContainsSubstring("drive.tum, 400 poses from"));
  std::istringstream lines(place.get("drive.tum"));
  std::string line;
  size_t poses = 0;
  double last = -1;
  while (std::getline(lines, line)) {
    if (line.starts_with('#')) continue;
    std::istringstream words(line);
    double t, x, y, z, qx, qy, qz, qw;
    REQUIRE(words >> t >> x >> y >> z >> qx >> qy >> qz >> qw);
    REQUIRE(t > last);
    REQUIRE(std::abs(qx * qx + qy * qy + qz * qz + qw * qw - 1) < 1e-6);
    last = t;
    ++poses;
  }
  CHECK(poses == 400);
  // The line is "drive  FILE, 400 poses from X,Y,Z on", with the pose as scan takes it.
  const size_t at = town.out.find("from ") + 5;
  const std::string pose = town.out.substr(at, town.out.find(" on", at) - at);
  const auto counters = place.runJson("scan town.glb --stats - --pose " + pose + kQuick).at("counters");
  CHECK(counters.at("hits") > 14400);  // half of the beams look at the road and at houses
}

TEST_CASE("gnosphere town warns of roads without room") {
  const Workplace place;
  const Result town = place.run("town -o town.glb --triangles 1000" + kNetwork);
  CHECK(town.status == 0);
  CHECK(town.err.starts_with("gnosphere: warning: 1000 triangles have room for "));
  CHECK(std::count(town.err.begin(), town.err.end(), '\n') == 1);
}

TEST_CASE("a town that cannot be made leaves no file") {
  checkRefused("town -o town.glb --xodr nowhere.xodr", 1, "nowhere.xodr: cannot be read: No such file");
  checkRefused("town -o town.glb --xodr floor.obj", 1, "invalid XML: No document element found");
  checkRefused("town -o town.glb --trajectory no/drive.tum", 1, "no/drive.tum: cannot be written");
  checkRefused("town -o town.glb --trajectory ./town.glb", 2, "./town.glb would be written twice");
  checkRefused("town -o a-car.glb --drive a.json", 2, "a-car.glb would be written twice");
  checkRefused("town -o town.glb --triangles 999", 2, "--triangles: 999 are too few for a town; the smallest has 1000");
}

TEST_CASE("a drive through a town needs a name of the town that JSON can have") {
  const Workplace place;
  const Result town = place.run("town -o 'a\xff.glb' --drive a.json --triangles 1000");
  CHECK(town.status == 2);
  CHECK_THAT(town.err, ContainsSubstring("JSON, which is UTF-8"));
  CHECK(place.files() == std::vector<std::string>{"floor.obj"});
}

TEST_CASE("the offset of a network's header is printed, and so are warnings of the file") {
  const Workplace place;
  const std::string road =
      "<road id='1' length='100' junction='-1'><link><successor elementType='road' elementId='7'/></link><planView>"
      "<geometry s='0' x='0' y='0' hdg='0' length='100'><line/></geometry></planView><lanes>"
      "<laneSection s='0'><center><lane id='0'/></center><right><lane id='-1' type='driving'>"
      "<width sOffset='0' a='3.5' b='0' c='0' d='0'/></lane></right></laneSection></lanes></road></OpenDRIVE>";
  place.put("moved.xodr", "<OpenDRIVE><header><offset x='649187.87' y='5318235.61' z='-0' hdg='0'/></header>" + road);
  place.put("plain.xodr", "<OpenDRIVE><header><offset x='0' y='0' z='0' hdg='0'/></header>" + road);
  const Result moved = place.run("town -o town.glb --triangles 5000 --xodr moved.xodr");
  CHECK_THAT(moved.out, ContainsSubstring("offset     x 649187.87, y 5318235.61, z 0 m, of the file's header"));
  CHECK_THAT(moved.err, ContainsSubstring("warning: road 1: it is linked to road 7, which the file lacks"));
  CHECK(place.run("town -o town.glb --triangles 5000 --xodr plain.xodr").out.find("offset") == std::string::npos);
}

TEST_CASE("the cars of a network's example drive keep to the middle of their lane in tight bends") {
  const Workplace place;
  place.put("circle.xodr",
            "<OpenDRIVE><header/><road id='1' length='340' junction='-1'><planView>"
            "<geometry s='0' x='0' y='0' hdg='0' length='340'><arc curvature='0.1'/></geometry></planView><lanes>"
            "<laneSection s='0'><center><lane id='0'/></center><right><lane id='-1' type='driving'>"
            "<width sOffset='0' a='3.5' b='0' c='0' d='0'/></lane></right></laneSection></lanes></road></OpenDRIVE>");
  REQUIRE(place.run("town -o town.glb --triangles 20000 --xodr circle.xodr --drive a.json").status == 0);
  std::istringstream lines(place.get("a.tum"));
  std::string line;
  size_t poses = 0;
  while (std::getline(lines, line)) {
    double t, x, y;
    if (std::sscanf(line.c_str(), "%lf %lf %lf", &t, &x, &y) != 3) continue;
    // The circle's middle is at (0, 10), and the lane, outside of it, is 3.5 m wide.
    REQUIRE(std::abs(std::sqrt(x * x + (y - 10) * (y - 10)) - 11.75) < 0.05);
    ++poses;
  }
  CHECK(poses == 400);
}

TEST_CASE("the example drive of a town labels carriageway, sidewalk, markings and grass by their materials") {
  const std::string roads = GENERATE(std::string(), kNetwork);
  const Workplace place;
  REQUIRE(place.run("town -o town.glb --triangles 100000 --drive a.json" + roads).status == 0);
  nlohmann::json json = place.json("a.json");
  json["sensors"] = nlohmann::json::array({json["sensors"][0]});
  json["sensors"][0]["effects"] = "clean";  // of geometry alone, which takes a tenth of the time
  json["outputs"] = nlohmann::json::array({json["outputs"][0]});
  place.put("a.json", json.dump());
  const Result drive = place.run("drive a.json -o made --frames 0:1 --device reference");
  CAPTURE(roads, drive.err);
  REQUIRE(drive.status == 0);
  const std::string bytes = place.get("made/semantickitti/sequences/00/labels/000000.label");
  std::map<int, size_t> points;  // by class
  for (size_t i = 0; i + 4 <= bytes.size(); i += 4)
    ++points[static_cast<uint8_t>(bytes[i]) + 256 * static_cast<uint8_t>(bytes[i + 1])];
  CHECK(points[40] > 5000);
  for (int ground : {48, 60, 72}) {
    CAPTURE(ground);
    CHECK(points[ground] > 100);
  }
}

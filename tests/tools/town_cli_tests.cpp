// SPDX-License-Identifier: Apache-2.0
// gnosphere town as a script would run it.
#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <sstream>

#include "tools/cli_support.hpp"

using namespace gnosphere::test;
using Catch::Matchers::ContainsSubstring;

namespace {

const std::string kNetwork = " --xodr '" GNOSPHERE_TEST_DATA "/junction.xodr' ";

}  // namespace

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
  const Result scan = place.run("scan town.glb --pose " + pose + kQuick);
  CHECK(scan.status == 0);
  CHECK_THAT(scan.out, ContainsSubstring("hits"));
}

TEST_CASE("a town that cannot be made leaves no file") {
  checkRefused("town -o town.glb --xodr nowhere.xodr", 1, "nowhere.xodr: cannot be read: No such file");
  checkRefused("town -o town.glb --xodr floor.obj", 1, "invalid XML: No document element found");
  checkRefused("town -o town.glb --trajectory no/drive.tum", 1, "no/drive.tum: cannot be written");
  checkRefused("town -o town.glb --trajectory town.glb", 2, "--trajectory");
  checkRefused("town -o town.glb --triangles 999", 2, "--triangles: 999 are too few for a town; the smallest has 1000");
  checkRefused("town -o town.glb --triangles 150000000 --bake", 2, "a .glb file ends at 4294967295; bake up to");
}

TEST_CASE("a drive through a town needs a name of the town that JSON can have") {
  const Workplace place;
  const Result town = place.run("town -o 'a\xff.glb' --drive a.json --triangles 1000");
  CHECK(town.status == 2);
  CHECK_THAT(town.err, ContainsSubstring("JSON, which is UTF-8"));
  CHECK(place.files() == std::vector<std::string>{"floor.obj"});
}

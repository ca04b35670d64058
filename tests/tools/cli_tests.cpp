// SPDX-License-Identifier: Apache-2.0
// The command line as people and scripts see it: exit status, one-line errors, no incomplete files.
#include <algorithm>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <sstream>
#include <string>

#include "gnosphere/output.hpp"
#include "tools/cli_support.hpp"

using Catch::Matchers::ContainsSubstring;
using Catch::Matchers::StartsWith;
using namespace gnosphere::test;

namespace {

std::set<std::string> optionsIn(const std::string& text) {
  static const std::regex kOption("--[a-z][a-z-]*");
  std::set<std::string> names;
  for (std::sregex_iterator match(text.begin(), text.end(), kOption), end; match != end; ++match)
    names.insert(match->str());
  return names;
}

/// The options that the list of a help text names, but for those in calls in backticks, and does not describe.
std::set<std::string> foreignOptionsIn(const std::string& help) {
  const size_t begin = help.find("\nOptions:\n");
  const std::string list = help.substr(begin, help.find("\n\n", begin) - begin);
  std::set<std::string> names = optionsIn(std::regex_replace(list, std::regex("`[^`]*`"), ""));
  std::istringstream lines(list);
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with("  -"))
      for (const std::string& own : optionsIn(line.substr(0, line.find(' ', 2)))) names.erase(own);
  return names;
}

}  // namespace

TEST_CASE("a wrong call ends with status 2 and lists the choices") {
  checkRefused("", 2, "scan, plan, accuracy, compare, devices, sensors, effects, options, info, town, drive or view");
  checkRefused("look", 2, "there is no command 'look'; the nearest are ");
  checkRefused("scna floor.obj", 2, "there is no command 'scna'; the nearest are scan, ");
  checkRefused("scan", 2, "SCENE");
  checkRefused("scan floor.obj --frob", 2, "there is no option '--frob'; the nearest are ");
  checkRefused("scan floor.obj --outptu a.pcd", 2, "there is no option '--outptu'; the nearest are --output, ");
  checkRefused("scan floor.obj roof.obj", 2, "there is no place for 'roof.obj'");
  checkRefused("scan floor.obj -- -1", 2, "there is no place for '-1'");
  checkRefused("scan floor.obj --pose 0 -1 1.8", 2,
               "there is no place for '-1'; commas join the values of one option, as 1,2,3");
  checkRefused("scan floor.obj -o a.csv --fields x y z", 2, "there is no place for 'y'; commas join the values");
  checkRefused("scan floor.obj --scale cm", 2,
               "gnosphere: --scale must be a number, is 'cm' (see gnosphere scan --help)");
  checkRefused(
      "scan floor.obj --sensor VLP-17", 2,
      "no built-in sensor is called 'VLP-17'; the nearest are VLP-16, VLP-32, VLP-32C; gnosphere sensors lists all; "
      "or give a file");
  checkRefused("scan floor.obj --sensor hdl64e:10Hz", 2,
               "no built-in sensor is called 'hdl64e:10Hz'; the nearest are HDL-64E");
  checkRefused("scan floor.obj -o a.las", 2, ".pcd, .ply, .bin (KITTI), .npy and .csv");
  checkRefused("scan floor.obj -o a.pcd -o a.las", 2, "a.las");
  checkRefused("scan floor.obj -o a.npy --ascii", 2, "--ascii changes .pcd and .ply files");
  checkRefused("scan floor.obj --frame world", 2, "there is no --output");
  checkRefused("scan floor.obj --frame lidar -o a.pcd", 2, "sensor,world");
  checkRefused(
      "scan floor.obj -o a.csv --fields x,y,rnge", 2,
      "no field is called 'rnge'; the nearest are range, ring, tie; docs/api.md and gnosphere scan --help list all");
  checkRefused("scan floor.obj -o a.csv --fields x,Doppler_velocity", 2,
               "no field is called 'doppler_velocity'; the speed along the beam is radial_speed; docs/api.md");
  checkRefused("scan floor.obj -o a.csv --fields x,normal_x", 2,
               "'normal_x' is a column of the field normal; ask for normal");
  checkRefused("scan floor.obj -o a.csv --fields u", 2, "'u' is a column of the field barycentrics");
  checkRefused("scan floor.obj --fields x,tie", 2, "--device reference");
  checkRefused("scan floor.obj --fields '' -o a.npy", 2, "''");
  checkRefused("scan floor.obj --fields x,y", 2, "--fields changes cloud files, and there is no --output");
  checkRefused("scan floor.obj --compact", 2, "--compact changes cloud files, and there is no --output");
  checkRefused("scan floor.obj --no-compact", 2, "--no-compact changes cloud files, and there is no --output");
  checkRefused("scan floor.obj --fields range -o k.bin", 2, "--fields: files of KITTI (.bin) always have x, y, z");
  checkRefused("scan floor.obj --sensor VLP-16:10Hz", 2,
               "the sensor VLP-16 is an ideal head of the paper and has no modes");
  checkRefused("scan floor.obj --image a.jpg", 2, ".png");
  checkRefused("scan floor.obj --pose 1,2", 2, "X,Y,Z");
  checkRefused("scan floor.obj --pose 1,2,nan", 2, "finite");
  checkRefused("scan floor.obj --pose 1,2,3,0,0,0,0", 2, "has a quaternion whose length is 0 and not 1");
  checkRefused("scan floor.obj --pose 1,2,3,0,0,40,9", 2, "has a quaternion whose length is 41 and not 1");
  checkRefused("scan floor.obj --pose 1,2,3,0,0,0.7,0.7", 2, "has a quaternion whose length is 0.99 and not 1; ");
  checkRefused("scan floor.obj --pose 1,2,3,jaw=9", 2, "'jaw=9' is no angle; there are yaw, roll, pitch, in degrees");
  checkRefused("scan floor.obj --pose 1,2,3,yaw=north", 2, "'yaw=north' is no finite number of degrees, as yaw=90 is");
  checkRefused("scan floor.obj --pose 1,2,3,yaw=1,yaw=2", 2, "yaw is given twice; keep one");
  checkRefused("scan floor.obj --pose 1,2,3,0,0,0,1,yaw=2", 2, "has a quaternion and angles; keep one of them");
  checkRefused("scan floor.obj --pose yaw=2", 2, "'yaw=2' is not X,Y,Z, then nothing or ");
  checkRefused("scan floor.obj --pose 1,2,3,", 2, "X,Y,Z");
  checkRefused("scan floor.obj --accuracy rough", 2, "paper");
  checkRefused("scan floor.obj --scale 0", 2, "--scale");
  checkRefused("scan floor.obj --repeat 0", 2, "--repeat");
  checkRefused("scan floor.obj -o a.pcd -o a.pcd", 2, "twice");
  checkRefused("scan floor.obj --stats floor.obj", 2, "is read, too");
  checkRefused("scan robot.urdf", 2, "robot.urdf': the Python package reads such files: python -m gnosphere.robotics");
  checkRefused("sensors VLP-17", 2, "the nearest are VLP-16");
  checkRefused("sensors --json", 2, "name a sensor or a file; --json, --beams and --image tell of one");
  checkRefused("sensors a.csv --rate 0", 2, "--rate: '0' is not a positive number");
  checkRefused("sensors a.csv --rate nan", 2, "--rate: 'nan' is not a positive number");
  checkRefused("sensors Puck --rate 20", 2, "--fire-times complete a sensor file, and 'Puck' is built in");
  checkRefused("town -o town.glb --triangles -5", 2, "--triangles");
  checkRefused("town -o town.glb --triangles 1e9", 2,
               "'1e9' is not a whole number up to 2147483647, written in digits alone");
  checkRefused("effects fog --mode 2", 2,
               "--mode chooses a lidar of a file of CARLA's attributes, and 'fog' is built in");
  checkRefused("effects os1-rain --mode 2", 2, "'os1-rain' is built in");
  checkRefused("effects fog.json --mode 2", 1, "fog.json: cannot be read");
  checkRefused("drive a.json --verify", 2, "--verify requires --output (see gnosphere drive --help)");
  checkRefused("view a.pcd -o a.html --distance 1", 2, "--distance requires B (see gnosphere view --help)");
  checkRefused("compare a.pcd", 2, "B");
  checkRefused("compare a.las b.las", 2, "a.las");
  checkRefused("town -o town.obj", 2, ".glb");
  checkRefused("town", 2, "--output");
}

TEST_CASE("scan, plan and accuracy take every option by --set; drives name the place for it") {
  checkRefused("scan floor.obj --set binning=lists", 2,
               "--set: no option is called 'binning'; there is tuning.binning");
  checkRefused("plan floor.obj --set accuracy=rough", 2, "--set: accuracy must be paper, ");
  checkRefused("accuracy floor.obj --set accuracy=exact", 2, "measures every accuracy");
  checkRefused("drive a.json --set faces=both", 2, "belongs into");
  const Workplace place;
  const std::string scan = "scan floor.obj --stats -" + kQuick;
  REQUIRE(place.run(scan + "--accuracy exact --faces both -o a.npy").status == 0);
  const Result set = place.run(scan + "--set accuracy=exact --set faces=both --set tuning.culling.rows=false -o b.npy");
  CHECK(set.err ==
        "gnosphere: warning: --device reference ignores accuracy, tuning.culling.rows; another --device heeds them\n");
  CHECK(place.run("plan floor.obj --device reference --set accuracy_parts.cull=nearest_point").err ==
        "gnosphere: warning: --device reference ignores accuracy_parts.cull; another --device heeds them\n");
  CHECK_THAT(set.out, ContainsSubstring("\"accuracy\": \"exact\""));
  CHECK(gnosphere::compare(gnosphere::readCloud(place / "a.npy"), gnosphere::readCloud(place / "b.npy")).same());
  // --set wins over the options that set the same, wherever it is.
  for (const char* both : {"--accuracy exact --faces both --set accuracy=draft --set faces=front",
                           "--set accuracy=draft --set faces=front --accuracy exact --faces both"}) {
    INFO(both);
    CHECK(nlohmann::json::parse(place.run(scan + both).out)["plan"]["accuracy"] == "draft");
  }
  const Result none = place.run("scan floor.obj --stats -" + kQuick + "--set ignored_instances=[0]");
  CHECK(nlohmann::json::parse(none.out)["counters"]["hits"] == 0);
  const Result list = place.run("options");
  CHECK(list.status == 0);
  CHECK_THAT(list.out, ContainsSubstring("tuning.binning, default auto") && ContainsSubstring("ignored_instances"));
}

TEST_CASE("work that fails ends with status 1 and leaves no incomplete file") {
  checkRefused("scan none.glb -o a.pcd --image a.png --stats a.json", 1, "none.glb");
  checkRefused("scan floor.obj -o no/such/folder/a.pcd", 1,
               "No such file or directory; there is no folder 'no/such/folder', so make it first");
  checkRefused("scan none.glb -o no/a.pcd", 1, "no/a.pcd");  // fails before the scene is loaded
  checkRefused("scan floor.obj -o /a.pcd/a.pcd", 1, "/a.pcd/a.pcd");
  checkRefused("scan floor.obj --sensor floor.obj -o a.pcd", 1, "floor.obj: is of no known family");
  checkRefused("compare a.pcd b.pcd", 2, "a.pcd: cannot be read: No such file or directory");
  checkRefused("town -o no/town.glb", 1,
               "no/town.glb: cannot be written: No such file or directory; there is no folder 'no', so make it first");
}

TEST_CASE("if the disk fills up, the old file stays and no partial file is left") {
  const Workplace place;
  place.put("a.pcd", "before");
  // A limit on file sizes simulates the full disk; its signal is ignored, so that writing fails.
  const Result result = place.run("scan floor.obj -o a.pcd" + kQuick, "trap '' XFSZ; ulimit -f 64;");
  CHECK(result.status == 1);
  CHECK_THAT(result.err, ContainsSubstring("a.pcd: cannot be written: File too large"));
  CHECK(place.get("a.pcd") == "before");
  CHECK(place.files() == std::vector<std::string>{"a.pcd", "floor.obj"});
}

TEST_CASE("help and version succeed, and every help text ends with an example and names its own options alone") {
  const Workplace place;
  CHECK_THAT(place.run("--help").out,
             ContainsSubstring("scan") && ContainsSubstring("town") && ContainsSubstring("2 for a wrong call; "));
  CHECK_THAT(place.run("devices --help").out, ContainsSubstring("`cuda-fast:N`"));
  CHECK_THAT(place.run("scan --help").out, ContainsSubstring("--pose") && ContainsSubstring("1.8 m"));
  for (const std::string command : {"", "scan", "plan", "accuracy", "compare", "devices", "sensors", "effects",
                                    "options", "info", "town", "drive", "view"}) {
    const std::string help = place.run(command + " --help").out;
    INFO(help);
    CHECK(longestLine(help) <= 80);
    const size_t example = help.find("\nExample: gnosphere ");
    REQUIRE(example != help.npos);
    CHECK(help.find_first_not_of('\n', help.find('\n', example + 1)) == help.npos);  // it is the last line
    CHECK(foreignOptionsIn(help) == std::set<std::string>());
  }
  CHECK(longestLine(place.run("options").out) <= 80);
  const Result version = place.run("--version");
  CHECK(version.status == 0);
  CHECK_THAT(version.out, StartsWith("gnosphere "));
}

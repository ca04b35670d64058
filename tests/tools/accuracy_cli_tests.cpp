// SPDX-License-Identifier: Apache-2.0
// Runs gnosphere accuracy and gnosphere scan --max-error as programs.
#include <nlohmann/json.hpp>

#include "bench/xml.hpp"
#include "gnosphere/output.hpp"
#include "support.hpp"
#include "tools/cli_support.hpp"

using Catch::Matchers::ContainsSubstring;
using Catch::Matchers::StartsWith;
using namespace gnosphere::test;

namespace {

const std::string kSmall = " --sensor s.json ";

/// A sensor of few beams that sees the floor, and a floor that is one quad of 400 m: `paper` loses beams on it.
void putSmall(const Workplace& place) {
  place.put("s.json", gnosphere::toJson(gridSensor(360, 8, -25, -4, 120)));
  place.put("wide.obj", "v -200 -190 -1.8\nv 200 -190 -1.8\nv 200 210 -1.8\nv -200 210 -1.8\nf 1 2 3\nf 1 3 4\n");
}

/// A label of a plot as it stands in the SVG.
std::string label(const std::string& name) {
  return std::string(">").append(name).append("<");
}

}  // namespace

TEST_CASE("accuracy refuses invalid calls") {
  checkRefused("accuracy", 2, "SCENE");
  checkRefused("accuracy floor.obj --device reference", 2, "another device");
  checkRefused("accuracy floor.obj --plot a.png", 2, ".svg");
  checkRefused("accuracy floor.obj --runs 0", 2, "--runs");
  checkRefused("accuracy floor.obj --poses 0", 2, "--poses");
  checkRefused("accuracy floor.obj --json floor.obj", 2, "is read, too, as floor.obj");
  checkRefused("accuracy floor.obj --pose 1,2,3 --trajectory t.tum", 2, "--trajectory");
  checkRefused("accuracy floor.obj --trajectory t.tum", 1, "t.tum");
  checkRefused("accuracy none.obj --json a.json", 1, "none.obj");
}

TEST_CASE("a malformed trajectory is refused with the number of the line") {
  const Workplace place;
  const auto refused = [&](const std::string& text, const std::string& words) {
    INFO(text);
    place.put("t.tum", text);
    const Result result = place.run("accuracy floor.obj --trajectory t.tum");
    CHECK(result.status == 1);
    CHECK_THAT(result.err, StartsWith("gnosphere: t.tum: ") && ContainsSubstring(words));
    CHECK(std::count(result.err.begin(), result.err.end(), '\n') == 1);
  };
  refused("# t x y z qx qy qz qw\n0 0 0 1 0 0 0 1\n1 0 0 1 0 0 1\n", "line 3");
  refused("0 0 0 1 0 0 0 nan\n", "line 1");
  refused("0 0 0 1 0 0 0 0\n", "line 1");
  refused("0,0,0,1,0,0,0,1\n", "line 1");
  refused("0 0 0 1 0 0 0 1\n\n0 0 0 1 0 0 0 1x\n", "line 3");
  refused("0 0 0 1 0 0 0 1e999\n", "line 1");
  refused("0 0 0 1 0 0 0 2\n", "length is not 1");
  refused("1 0 0 0 0 1 0 0 0 0 1 0\n", "KITTI");
  refused("# nothing\n", "no pose");
}

TEST_CASE("accuracy says so where most beams are ties, which its tables leave out") {
  needVulkan();
  const Workplace place;
  putSmall(place);
  place.put("huge.obj", "v -1e7 -1e7 -1.8\nv 1e7 -1e7 -1.8\nv 1e7 1e7 -1.8\nv -1e7 1e7 -1.8\nf 1 2 3 4\n");
  const std::string words = "so many that the tables leave much out";
  for (const bool huge : {true, false}) {
    const Result result = place.run(std::string("accuracy ") + (huge ? "huge.obj" : "wide.obj") +
                                    " --up z --pose 0.3,0.2,0 --poses 1 --runs 1" + kSmall);
    REQUIRE(result.status == 0);
    CHECK((result.out.find(words) != std::string::npos) == huge);
  }
}

TEST_CASE("accuracy prints a table, JSON with the names of --stats, and a plot of every setting") {
  needVulkan();
  const Workplace place;
  putSmall(place);
  place.put("t.tum", "# t x y z qx qy qz qw\r\n0 0 0 0 0 0 0 1\r\n\n 1.5\t1 2 0.1 0 0 1 0 7 7 7\n2 3 0 0 0 0 0 1\n");
  const Result result =
      place.run("accuracy wide.obj --trajectory t.tum --poses 2 --runs 2 --json a.json --plot a.svg" + kSmall);
  CHECK(result.err == "");
  REQUIRE(result.status == 0);
  for (const char* words :
       {"standard", "what each part of standard buys", "first-corner cull", "2.0 or more", "from 2 poses"})
    CHECK_THAT(result.out, ContainsSubstring(words));

  const auto json = place.json("a.json");
  CHECK_THAT(json.at("command").get<std::string>(), StartsWith("gnosphere accuracy wide.obj"));
  CHECK(json.at("device").contains("driver"));
  CHECK(json.at("poses").size() == 2);
  CHECK(json.at("settings").size() == 4);
  CHECK(json.at("parts").size() == 4);
  const auto& standard = json.at("settings").at(2);
  CHECK(standard.at("name") == "standard");
  CHECK(standard.at("error").at("missed") == 0);
  CHECK(standard.at("frame").at("runs") == 2);
  CHECK(standard.at("frame").at("wall_ms").contains("p90"));
  CHECK(json.at("settings").at(0).at("error").at("missed") > 0);

  const std::string svg = place.get("a.svg");
  CHECK(xmlProblem(svg) == "");
  for (const char* name : {"paper", "draft", "standard", "exact", "corner bounds", "range by plane"})
    CHECK_THAT(svg, ContainsSubstring(label(name)));
}

TEST_CASE("accuracy warns if no beam hits, as scan does") {
  needVulkan();
  const Workplace place;
  putSmall(place);
  const Result result = place.run("accuracy wide.obj --pose 5000,0,0 --poses 1 --runs 1" + kSmall);
  REQUIRE(result.status == 0);
  CHECK_THAT(result.err, StartsWith("gnosphere: warning: no beam that is compared hits anything; wide.obj spans x ") &&
                             ContainsSubstring("the sensor at 5000, 0, 0 sees as far as 120 m; --pose moves it"));
}

TEST_CASE("accuracy leaves paper out for sensors that the paper does not know, and says so") {
  needVulkan();
  const Workplace place;
  putSmall(place);
  const Result result = place.run("accuracy wide.obj --sensor Puck --sample 100 --poses 1 --runs 1 --json a.json");
  CHECK(result.err == "");
  REQUIRE(result.status == 0);
  CHECK_THAT(result.out, ContainsSubstring("left out: the sensor turns clockwise\n"));
  const auto json = place.json("a.json");
  REQUIRE(json.at("settings").size() == 3);
  CHECK(json.at("settings").at(0).at("name") == "draft");
  CHECK(json.at("settings").at(1).at("name") == "standard");
  CHECK_THAT(result.out, ContainsSubstring("ratio to standard"));
  CHECK(json.at("without_paper") == "the sensor turns clockwise");
}

TEST_CASE("accuracy --effects prints a table, JSON and a plot of footprints") {
  needVulkan();
  const Workplace place;
  putSmall(place);
  const Result result = place.run(
      "accuracy wide.obj --effects --effect divergence.horizontal=0.01 --sub-rays 1,7 --pose 0,0,0 --poses 1 --runs 2 "
      "--sample 300 --json a.json --plot a.svg" +
      kSmall);
  CHECK(result.err == "");
  REQUIRE(result.status == 0);
  for (const char* words : {"10 x 0 mrad", "300 beams, a sample, with 331 sub-rays", "clean"})
    CHECK_THAT(result.out, ContainsSubstring(words));
  const auto json = place.json("a.json");
  CHECK(json.at("reference_sub_rays") == 331);
  REQUIRE(json.at("rows").size() == 3);
  CHECK(json.at("rows").at(0).at("frame").at("ratio_to_clean") == 1);
  CHECK(json.at("rows").at(2).at("sub_rays") == 7);
  const auto error = [&](size_t row) {
    return json.at("rows").at(row).at("error").at("range_error_m").at("rms").get<double>();
  };
  CHECK(error(2) < error(1));
  CHECK(xmlProblem(place.get("a.svg")) == "");
  CHECK_THAT(place.get("a.svg"), ContainsSubstring(label("7")));
}

TEST_CASE("accuracy --effects refuses invalid calls") {
  checkRefused("accuracy floor.obj --effect fog.visibility=9", 2, "--effects");
  checkRefused("accuracy floor.obj --effects none.json", 2, "none.json");
  checkRefused("accuracy floor.obj --effects --sub-rays 62", 2, "--sub-rays");
  checkRefused("accuracy floor.obj --effects --device reference", 2, "another device");
  checkRefused("accuracy floor.obj --effects clean", 2, "divergence is off in the request; set it to auto or on");
}

TEST_CASE("an invalid --max-error, or one that contradicts other options, is refused") {
  checkRefused("scan floor.obj --max-error -0.1", 2, "--max-error");
  checkRefused("scan floor.obj --max-error nan -o a.pcd", 2, "--max-error");
  checkRefused("scan floor.obj --max-error inf", 2, "--max-error");
  checkRefused("scan floor.obj --max-error far", 2, "--max-error");
  checkRefused("scan floor.obj --max-error 1 --accuracy exact", 2, "--max-error");
  checkRefused("scan floor.obj --max-error 1 --device reference", 2, "--device");
}

TEST_CASE("scan --max-error chooses a setting within the limit and explains the choice") {
  needVulkan();
  const Workplace place;
  putSmall(place);
  const Result result = place.run("scan wide.obj --pose 0,0,0 --max-error 0.01 -o a.pcd --stats a.json" + kSmall);
  CHECK(result.err == "");
  REQUIRE(result.status == 0);
  CHECK_THAT(result.out, StartsWith("accuracy ") && ContainsSubstring("within 0.01 m") &&
                             ContainsSubstring("measured on all 2,880 beams"));
  const auto plan = place.json("a.json").at("plan");
  CHECK(plan.at("accuracy") != "paper");
  CHECK(plan.at("max_error").at("error_m") <= 0.01);
  CHECK(plan.at("max_error").at("settings").size() == 4);
  CHECK(place.get("a.pcd").size() > 1000);
}

TEST_CASE("a --max-error that no setting reaches ends with status 1, names the best setting and writes no cloud") {
  needVulkan();
  const Workplace place;
  putSmall(place);
  const Result result = place.run("scan wide.obj --pose 0,0,0 --max-error 1e-12 -o a.pcd --stats a.json" + kSmall);
  CHECK(result.status == 1);
  CHECK_THAT(result.err, StartsWith("gnosphere: no setting is within 1e-12 m") && ContainsSubstring("the best is") &&
                             ContainsSubstring(" a scan"));
  CHECK(std::count(result.err.begin(), result.err.end(), '\n') == 1);
  CHECK(result.out.empty());
  CHECK(place.files() == std::vector<std::string>{"floor.obj", "s.json", "wide.obj"});
}

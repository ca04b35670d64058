// SPDX-License-Identifier: Apache-2.0
// Runs every case of gnosphere-bench on tiny scenes.
#include <catch2/generators/catch_generators.hpp>
#include <nlohmann/json.hpp>

#include "bench/xml.hpp"
#include "support.hpp"
#include "tools/cli_support.hpp"

using namespace gnosphere::test;
using Catch::Matchers::ContainsSubstring;
using nlohmann::json;

namespace {

const std::string kBench = GNOSPHERE_BENCH_BINARY;
const std::string kTiny = " --triangles 20000 --runs 1 --frames 2 --sensor VLP-16 --rivals embree";

json casesOf(const Workplace& place, const std::string& call) {
  const Result result = place.run(call, "", kBench);
  INFO(call << ": " << result.err);
  REQUIRE(result.status == 0);
  const json results = place.json("r.json");
  for (const char* key : {"command", "version", "device", "rates", "cases"}) CHECK(results.contains(key));
  return results.at("cases");
}

}  // namespace

TEST_CASE("each case of gnosphere-bench gives a table, results and a plot") {
  needVulkan();
  const std::string name = GENERATE("table3", "table4", "figure5", "figure6-range", "figure6-towns", "figure7",
                                    "dynamic", "scaling-triangles");
  const Workplace place;
  const json cases = casesOf(place, name + kTiny + " --json r.json --plot p.svg");
  CHECK_THAT(place.get("out"), ContainsSubstring("## " + name) && ContainsSubstring(" standard |"));
  CHECK(xmlProblem(place.get("p.svg")) == "");
  REQUIRE(cases.size() == 1);
  for (const json& outcome : cases.at(name).at("outcomes")) {
    CHECK(outcome.at("memory").at("scene_bytes_per_unique_triangle") > 0);
    CHECK(outcome.at("floor").at("share") > 0);
    const json& ours = outcome.at("contenders").at(0);
    CHECK(ours.at("total_ms").at("median") > 0);
    CHECK(ours.at("error").at("missed") == 0);
    for (const json& contender : outcome.at("contenders"))
      CHECK((contender.at("name") == "paper" || contender.at("beams_unlike_ours") <= 2));
  }
}

TEST_CASE("table5 compares nearest neighbours as the paper does") {
  needVulkan();
  const Workplace place;
  const json contenders = casesOf(place, "table5" + kTiny + " --json r.json").at("table5").at("contenders");
  CHECK(contenders.at(0).at("missed") == 0);
  CHECK(contenders.at(0).at("nearest").at(0) > 1000);
  CHECK(contenders.at(1).at("name") == "paper");
}

TEST_CASE("the case real measures the scenes of a folder, and says which it leaves out") {
  needVulkan();
  const Workplace place;
  MeshBuilder floor, post;
  floor.quad({-20, -20, 0}, {40, 0, 0}, {0, 40, 0}, 10);
  post.box({4, 4, 0}, {5, 5, 3}, 8);
  gnosphere::Scene scene = sceneOf(floor.take(), false);
  scene.meshes.push_back(post.take());
  for (int i = 0; i < 3; ++i) scene.instances.push_back({"", 1, translation(-3 * i, 0, 0)});
  std::filesystem::create_directories(place / "scenes/deep");
  gnosphere::writeGlb(sceneOf(scene.meshes[0]), place / "scenes/flat.glb");
  gnosphere::writeGlb(scene, place / "scenes/posts.glb");
  scene.instances[1].transform = scaling(1, 1, 2);
  gnosphere::writeGlb(scene, place / "scenes/deep/tall.glb");
  for (gnosphere::Instance& instance : scene.instances)
    instance.transform = scaling(0.001, 0.001, 0.001) * instance.transform;
  gnosphere::writeGlb(scene, place / "scenes/model.glb");
  place.put("scenes/broken.ply", "ply");
  place.put("scenes/notes.txt", "no scene");
  const json real =
      casesOf(place,
              "real --scene scenes --least-triangles 1000 --runs 1 --frames 2 --sensor VLP-16 --rivals embree "
              "--json r.json --plot p.svg")
          .at("real");
  CHECK(xmlProblem(place.get("p.svg")) == "");
  REQUIRE(real.at("left_out").size() == 2);
  CHECK_THAT(real.at("left_out").at(0).get<std::string>(), ContainsSubstring("broken.ply"));
  CHECK(real.at("left_out").at(1) == "with fewer than 1,000 triangles, 1 in all: flat (200)");
  const std::vector<std::string> labels = {"deep/tall, VLP-16", "deep/tall, VLP-16, everything may move",
                                           "model, VLP-16",     "model, VLP-16, everything may move",
                                           "posts, VLP-16",     "posts, VLP-16, everything may move"};
  REQUIRE(real.at("outcomes").size() == labels.size());
  for (size_t i = 0; i < labels.size(); ++i) {
    const json& outcome = real.at("outcomes").at(i);
    CHECK(outcome.at("label") == labels[i]);
    CHECK(outcome.at("frames") == 2);
    CHECK(outcome.at("moving_instances") == (i % 2 ? 4 : 0));
    CHECK(outcome.at("contenders").at(0).at("error").at("missed") == 0);
    CHECK((outcome.at("contenders").at(1).at("name") == "only what is seen") == (i % 2 == 0));
    for (const json& contender : outcome.at("contenders")) {
      const json& ratios = contender.at("frame_ratios_to_ours");
      CHECK(contender.at("beams_unlike_ours") <= 2);
      CHECK(ratios.at("least") <= contender.at("ratio_to_ours"));
      CHECK(ratios.at("most") >= contender.at("ratio_to_ours"));
    }
  }
  // Objects move by little, however small the scene is.
  const double still = real.at("outcomes").at(2).at("hits"), moved = real.at("outcomes").at(3).at("hits");
  CHECK(std::abs(moved / still - 1) < 0.02);
  CHECK(real.at("scenes").at(2).at("name") == "posts");
  CHECK(real.at("scenes").at(2).at("poses").size() == 2);
  const json& floors = real.at("summary").at(0);
  CHECK(floors.at("name") == "only what is seen");
  CHECK(floors.at("scenes") == 3);
  CHECK(floors.at("least") <= floors.at("median"));
  CHECK_THAT(place.get("out"), ContainsSubstring("| deep/tall |") && ContainsSubstring("left out: with fewer than"));
}

TEST_CASE("the case heads measures heads beside their twins and Embree") {
  needVulkan();
  const Workplace place;
  const json heads = casesOf(place,
                             "heads --triangles 20000 --runs 1 --frames 1 --heads VLP-16,Avia --json r.json "
                             "--plot p.svg")
                         .at("heads");
  CHECK(xmlProblem(place.get("p.svg")) == "");
  REQUIRE(heads.at("rows").size() == 2);
  const json &grid = heads.at("rows").at(0), &list = heads.at("rows").at(1);
  CHECK(grid.at("head") == "VLP-16");
  CHECK(grid.at("ms").at("clean") > 0);
  CHECK(grid.at("ratios").contains("clean_to_twin"));
  CHECK_FALSE(list.at("ratios").contains("clean_to_twin"));
  CHECK(list.at("ms").at("default_moving") > 0);
  CHECK(heads.at("summary").at(0).at("rows") == 1);
  CHECK_THAT(place.get("out"), ContainsSubstring("| VLP-16 |") && ContainsSubstring("default / clean, moving"));
  CHECK(place.run("heads --heads none", "", kBench).status == 2);
}

TEST_CASE("the case batches measures views and worlds together, one by one and beside Embree") {
  needVulkan();
  const Workplace place;
  const json batches = casesOf(place,
                               "batches --triangles 20000 --runs 1 --frames 8 --json r.json "
                               "--plot p.svg")
                           .at("batches");
  CHECK(xmlProblem(place.get("p.svg")) == "");
  const json& rows = batches.at("rows");
  REQUIRE(rows.size() == 9);
  CHECK(rows.at(0).at("views") == 1);
  CHECK(rows.at(1).at("views") == 8);
  CHECK_FALSE(rows.at(1).contains("move_ms"));
  for (const size_t withoutEmbree : {2, 3, 4, 5, 8}) CHECK_FALSE(rows.at(withoutEmbree).contains("embree_ms"));
  CHECK(rows.at(3).at("scene") == "town, Mid-40");
  CHECK(rows.at(6).at("beams") == 187);
  CHECK(rows.at(7).at("scene") == "2 worlds, 16 x 300");
  CHECK(rows.at(8).at("scene") == "2 worlds, 16 x 300, moving");
  for (const json& row : rows) CHECK(row.at("batch_ms").at("median") > 0);
  for (const json& row : rows) CHECK(row.at("on_device_ms").at("median") > 0);
  for (const size_t moving : {6, 7, 8}) CHECK(rows.at(moving).at("move_ms").at("median") > 0);
  CHECK_THAT(place.get("out"), ContainsSubstring("| 8 worlds, height scan "));
}

TEST_CASE("the case stability measures and plots how errors grow") {
  needVulkan();
  const Workplace place;
  const json families =
      place.runJson("stability --family quad_size --ends --plot a.svg --json -", "", kBench).at("families");
  REQUIRE(families.at(0).at("hardness").size() == 2);
  const json& settings = families.at(0).at("settings");
  CHECK(settings.at(0).at("lost_share").at(1) == 1);
  CHECK(settings.at(0).at("error_max_m").at(1).is_null());
  CHECK(settings.at(2).at("lost_share").at(1) == 0);
  CHECK(xmlProblem(place.get("a.svg")) == "");
  for (const std::string name : {"paper", "draft", "standard", "exact", "Quad size"})
    CHECK_THAT(place.get("a.svg"), ContainsSubstring(">" + name + "<"));
}

// Both are slow, because they compile the pipelines of every effect.
TEST_CASE("the case correctness ends with status 1 where beams are wrong", "[.slow]") {
  needVulkan();
  const Workplace place;
  const std::string call = "correctness --triangles 20000 --frames 1 --sensor VLP-16 --json r.json";
  CHECK(place.run(call + " --set accuracy_parts.bounds=paper", "", kBench).status == 1);
  CHECK(place.json("r.json").at("cases").at("correctness").at("wrong") > 0);
}

TEST_CASE("the case effects times each effect, and checks that switched-off effects cost nothing", "[.slow]") {
  needVulkan();
  const Workplace place;
  const json effects =
      casesOf(place,
              "effects --triangles 20000 --runs 1 --sensor VLP-16 --rivals none --set tuning.stage_times=true "
              "--json r.json --plot p.svg")
          .at("effects");
  CHECK(xmlProblem(place.get("p.svg")) == "");
  CHECK(effects.at("off_requests") == 17);
  CHECK(effects.at("left_out").at(0) == "cut-outs: no material that is seen has holes");
  const json& rows = effects.at("rows");
  CHECK(rows.size() + effects.at("left_out").size() == 2 + 22 + 2);  // bare, off; each effect; all, many scans
  const json &bare = rows.at(0), &off = rows.at(1);
  CHECK(bare.at("times_bare").at("median") == 1);
  CHECK(off.at("bytes") == bare.at("bytes"));
  CHECK(off.at("dispatches") == bare.at("dispatches"));
  CHECK(off.at("stages_ms").contains("project"));
  CHECK(!off.at("stages_ms").contains("effects"));
  for (const json& row : rows) {
    INFO(row.at("name"));
    CHECK(row.at("total_ms").at("median") > 0);
    CHECK(place.get("p.svg").find(row.at("name").get<std::string>()) != std::string::npos);
    CHECK_THAT(place.get("out"), ContainsSubstring("| " + row.at("name").get<std::string>() + " "));
  }
  CHECK(rows.back().at("name") == "19 bare scans");
  CHECK(rows.back().at("dispatches") == 19 * bare.at("dispatches").get<int>());
}

TEST_CASE("gnosphere-bench takes a scene and a trajectory, and refuses invalid calls") {
  const Workplace place;
  const auto refused = [&](const std::string& call, int status, const std::string& words) {
    const Result result = place.run(call, "", kBench);
    INFO(call);
    CHECK(result.status == status);
    CHECK_THAT(result.err, ContainsSubstring(words));
    CHECK(std::count(result.err.begin(), result.err.end(), '\n') == 1);
  };
  refused("", 2, "no case is given (see gnosphere-bench --help)");
  refused("figur7", 2, "there is no case 'figur7'; the nearest are figure7, ");
  refused("real", 2, "--scene is required (see gnosphere-bench real --help)");
  refused("figure7 --rival none", 2, "there is no option '--rival'; the nearest are --rivals, ");
  refused("figure7 --plot a.png", 2, "--plot: a.png must end in .svg");
  refused("stability --plot a.png", 2, "--plot: a.png must end in .svg");
  refused("golden --renew no/a.inc", 1, "no/a.inc: cannot be written");
  for (const std::string call : {"", "figure7 ", "real ", "golden ", "all ", "stability "})
    CHECK(longestLine(place.run(call + "--help", "", kBench).out) <= 80);
  const std::string help = place.run("table3 --help", "", kBench).out;
  for (const std::string words : {"--frames UINT:UINT in [1 - 1000000]=60", "rayquery, raytracing and cuda"})
    CHECK_THAT(help, ContainsSubstring(words));
  CHECK(place.run("stability --family none", "", kBench).status == 2);
  CHECK(place.run("stability --plot no/a.svg", "", kBench).status == 1);
  CHECK(place.run("table3 --rivals optix", "", kBench).status == 2);
  CHECK(place.run("table3 --runs 0", "", kBench).status == 2);
  const Result full = place.run("-c \"'" + kBench + "' --help >/dev/full\"", "", "/bin/sh");
  CHECK(full.status == 1);
  CHECK_THAT(full.err, ContainsSubstring("the standard output is not complete"));
  CHECK(place.run("table3 --trajectory none.txt", "", kBench).status == 1);
  CHECK(place.run("table3 --json no/r.json", "", kBench).status == 1);
  CHECK(place.run("real", "", kBench).status == 2);
  CHECK(place.run("real --scene none", "", kBench).status == 1);
  const Result small = place.run("real --scene floor.obj", "", kBench);
  CHECK(small.status == 1);
  CHECK_THAT(small.err,
             ContainsSubstring("no scene was measured: with fewer than 50,000 triangles, 1 in all: floor (2)"));
  CHECK(place.files() == std::vector<std::string>{"floor.obj"});
  needVulkan();
  place.put("drive.txt", "0 0 0 1 0 0 0 1\n1 1 0 1 0 0 0 1\n2 2 0 1 0 0 0 1\n");
  const json outcome = casesOf(place,
                               "table3 --scene floor.obj --trajectory drive.txt --sensor VLP-16 --runs 1 "
                               "--frames 3 --rivals none --json r.json")
                           .at("table3")
                           .at("outcomes")
                           .at(0);
  CHECK(outcome.at("frames") == 3);
  CHECK(outcome.at("scene").at("triangles") == 2);
  CHECK(outcome.at("contenders").size() == 2);
  // The reference has one accuracy, so nothing there is the paper's method.
  const json alone = casesOf(
      place, "figure7 --scene floor.obj --device reference --sensor VLP-16 --runs 1 --rivals none --json r.json");
  CHECK(alone.at("figure7").at("outcomes").at(0).at("contenders").size() == 1);
}

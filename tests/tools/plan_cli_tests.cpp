// SPDX-License-Identifier: Apache-2.0
// gnosphere plan, and the options for effects.
#include <nlohmann/json.hpp>

#include "tools/cli_support.hpp"

using Catch::Matchers::ContainsSubstring;
using namespace gnosphere::test;

namespace {

/// Returns the decision on one effect from a plan in JSON.
nlohmann::json decision(const Workplace& place, const std::string& arguments, const std::string& effect) {
  const auto plan = place.runJson("plan floor.obj --json " + arguments);
  for (const auto& one : plan.at("effects"))
    if (one.at("effect") == effect) return one;
  FAIL("no decision on " << effect);
  return {};
}

}  // namespace

TEST_CASE("a plan lists planned and omitted effects with the reasons") {
  const Workplace place;
  const Result result = place.run("plan floor.obj --effect fog.visibility=200 --effect range-noise.sigma=0.02");
  CHECK(result.err == "");
  REQUIRE(result.status == 0);
  CHECK_THAT(result.out, ContainsSubstring("effects that are in\n  intensity        needed by detection, fog\n"));
  CHECK_THAT(result.out, ContainsSubstring("  range-noise      asked for: sigma 0.02 m\n"));
  CHECK_THAT(result.out, ContainsSubstring("  fog              asked for: visibility 200 m\n"));
  CHECK_THAT(result.out, ContainsSubstring("effects that are out, and cost nothing\n"));
  CHECK_THAT(result.out, ContainsSubstring("  transmission     no material that is seen lets light through\n"));
  CHECK_THAT(result.out, ContainsSubstring("\nstage     dispatches  pipelines\nproject "));
  CHECK_THAT(result.out, ContainsSubstring("\nbuffer "));
  CHECK(place.files() == std::vector<std::string>{"floor.obj"});
}

TEST_CASE("plan --json lists every effect") {
  const auto plan = Workplace().runJson("plan floor.obj --json");
  CHECK(plan.at("effects").size() == 17);
  CHECK(plan.at("dispatches") > 0);
  CHECK(plan.at("bytes") > 0);
  for (const char* key : {"fields", "returns", "stages", "dispatches", "buffers", "bytes"}) CHECK(plan.contains(key));
}

TEST_CASE("plan --pipelines compiles and prints what the driver says of each pipeline") {
  const Workplace place;
  const Result result = place.run("plan floor.obj --effects clean --pipelines");
  REQUIRE(result.status == 0);
  CHECK_THAT(result.out, ContainsSubstring("\nproject_triangles: ") && ContainsSubstring(" lanes, compiled in "));
  CHECK_THAT(result.out, ContainsSubstring("\ncommands  ") && ContainsSubstring(" barriers\n"));
  const auto plan = place.runJson("plan floor.obj --effects clean --pipelines --json --records x,y,z");
  bool records = false;
  for (const auto& stage : plan.at("stages"))
    for (const auto& pipeline : stage.at("pipelines")) {
      CHECK(pipeline.at("subgroup_size") >= 4);
      CHECK(pipeline.at("compile_ms") > 0);
      CHECK(pipeline.at("statistics").is_object());
      records = records || pipeline.at("name") == "records";
    }
  CHECK(records);
  // Without the flag nothing is said of the compiler.
  CHECK(!place.runJson("plan floor.obj --json").at("stages").at(0).at("pipelines").at(0).contains("compile_ms"));
  CHECK(place.run("plan floor.obj --pipelines --device reference").status != 0);
}

TEST_CASE("plan --views tells how many scans one submission makes, with as many steps as one scan") {
  const Workplace place;
  const auto one = place.runJson("plan floor.obj --sensor VLP-16 --effects clean --json");
  const auto many = place.runJson("plan floor.obj --sensor VLP-16 --effects clean --json --views 4");
  CHECK(one.at("views") == 1);
  CHECK(many.at("views") == 4);
  CHECK(many.at("dispatches") == one.at("dispatches"));
  CHECK(many.at("bytes") > one.at("bytes"));
  const Result result = place.run("plan floor.obj --sensor VLP-16 --effects clean --views 1000000");
  REQUIRE(result.status == 0);
  CHECK_THAT(result.out, ContainsSubstring(" of 1,000,000 in one submission\n"));
  const Result lists = place.run("plan floor.obj --set tuning.binning=lists --views 4");
  CHECK_THAT(lists.out, ContainsSubstring("1: scans of this sensor are made one by one\n"));
  CHECK_THAT(lists.out, ContainsSubstring("bin, prefix_sum x 3, bin\n"));
  CHECK(place.run("plan floor.obj --views 0").status == 2);
}

TEST_CASE("scan --trace prints each step with its size") {
  const Workplace place;
  const Result result = place.run("scan floor.obj --effects clean --trace -o cloud.pcd");
  REQUIRE(result.status == 0);
  CHECK_THAT(result.err,
             ContainsSubstring("fill counters") && ContainsSubstring("project: project_groups, 1 workgroups"));
}

TEST_CASE("plan --effects takes a preset or a file, and assignments override it in order") {
  const Workplace place;
  place.put("e.json", R"({"fog": {"visibility": 50}})");
  CHECK(decision(place, "--effects e.json", "fog").at("reason") == "asked for: visibility 50 m");
  CHECK(decision(place, "--effects e.json --effect fog.visibility=80", "fog").at("reason") ==
        "asked for: visibility 80 m");
  CHECK(decision(place, "--effects e.json --effect fog.visibility=80 --effect fog=off", "fog").at("in") == false);
  CHECK(decision(place, "--effects os1-rain", "rain").at("in") == true);
  CHECK(decision(place, "--effects clean", "divergence").at("reason") == "off in the request");
  CHECK(decision(place, "", "divergence").at("request") == "auto");
}

TEST_CASE("effects are listed, and a printed preset is a valid file for --effects") {
  const Workplace place;
  CHECK_THAT(place.run("effects").out,
             ContainsSubstring("presets: clean auto carla hdl-64e os1-rain\n") &&
                 ContainsSubstring("\nrange-noise (auto)\n") &&
                 ContainsSubstring("  visibility           0              0..1000000 m; 0 for no fog\n"));
  const Result printed = place.run("effects os1-rain");
  REQUIRE(printed.status == 0);
  place.put("e.json", printed.out);
  CHECK(place.run("effects e.json").out == printed.out);
  CHECK(place.run("plan floor.obj --effects e.json").out == place.run("plan floor.obj --effects os1-rain").out);
}

TEST_CASE("an effect is told with its parameters and its page") {
  const Workplace place;
  const Result fog = place.run("effects Fog");
  CHECK(fog.status == 0);
  CHECK(fog.out ==
        "fog (auto)\n"
        "  Fog: its droplets weaken returns and give some of their own. Automatic: on if\n"
        "  a visibility is given.\n"
        "\n"
        "  visibility, default 0\n"
        "    0..1000000 m\n"
        "    Meteorological optical range (5 % contrast, Koschmieder); 0 for no fog.\n"
        "\n"
        "The formula and its sources: docs/effects/fog.md\n");
  CHECK_THAT(place.run("effects returns").out, ContainsSubstring("      dual: The last and the strongest"));
  CHECK(place.run("effects frog").status == 2);
}

TEST_CASE("one file of CARLA's attributes is read as a sensor and as effects") {
  const Workplace place;
  place.put("c.json", R"([{"type": "sensor.lidar.ray_cast", "id": "top", "noise_stddev": "0.02"},
                          {"type": "sensor.lidar.ray_cast", "id": "low", "dropoff_general_rate": 0}])");
  CHECK_THAT(place.run("sensors c.json").out,
             ContainsSubstring("ignored") && ContainsSubstring("noise_stddev, which `--effects FILE` reads"));
  const auto refused = [&](const std::string& command, const std::string& words) {
    const Result result = place.run(command);
    CHECK(result.status == 1);
    CHECK_THAT(result.err, ContainsSubstring(words));
  };
  refused("plan floor.obj --effects c.json", "c.json: the effects of the lidars top, low differ");
  const Result low = place.run("effects c.json --mode low");
  REQUIRE(low.status == 0);
  CHECK_THAT(low.out, ContainsSubstring(R"("general_rate": 0,)"));
  refused("effects c.json --mode rear", "c.json: has no lidar 'rear', but top, low");
  checkRefused("effects --mode rear", 2, "--mode requires NAME");
  place.put("one.json", R"({"type": "sensor.lidar.ray_cast", "noise_stddev": 0.02})");
  CHECK(decision(place, "--sensor one.json --effects one.json", "range-noise").at("in") == true);
  CHECK(decision(place, "--sensor one.json --effects one.json", "drop-out").at("in") == true);
}

TEST_CASE("a table of materials is read, and rows without effect cause warnings") {
  const Workplace place;
  place.put("floor.obj", "mtllib floor.mtl\nv -9 -9 0\nv 9 -9 0\nv 9 9 0\nusemtl pane\nf 1 2 3\n");
  place.put("floor.mtl", "newmtl pane\nKd 1 1 1\n");
  place.put("m.json", R"({"materials": [{"name": "pane", "transmission": 0.5}]})");
  const std::string opaque = "no material that is seen lets light through";
  CHECK(decision(place, "", "transmission").at("reason") == opaque);
  CHECK(decision(place, "--materials m.json", "transmission").at("reason") != opaque);
  place.put("m.json", R"({"materials": [{"name": "wood"}, {"name": "snow", "retro": 0}]})");
  const Result result = place.run("plan floor.obj --materials m.json");
  CHECK(result.status == 0);
  CHECK(result.err ==
        "gnosphere: warning: the material table has 'wood', 'snow', but the scene has no material of that name\n"
        "gnosphere: warning: the material table gives no values for 'wood'\n");
}

TEST_CASE("invalid requests of effects are refused in one line") {
  for (const std::string command : {"plan floor.obj ", "scan floor.obj --device reference "}) {
    checkRefused(command + "--effects os1-fog", 2, "clean, auto, carla, hdl-64e, os1-rain");
    checkRefused(command + "--effect fogg=on", 2, "--effect: no effect is called 'fogg'; the nearest are fog");
    checkRefused(command + "--effect fog.visibility=-1", 2, "--effect: fog.visibility must be 0..1000000 m, is -1");
    checkRefused(command + "--effect fog", 2, "NAME=VALUE");
    checkRefused(command + "--seed -1", 2, "--seed");
    checkRefused(command + "--effects floor.obj", 1, "floor.obj: is not JSON");
    checkRefused(command + "--materials none.json", 1, "none.json: cannot be read");
  }
  checkRefused("plan floor.obj --effect fog=on", 2, "fog is on, but no visibility is given; give fog.visibility");
  checkRefused("plan floor.obj --effect divergence=on --sensor VLP-16", 2, "sensor 'VLP-16' states no divergence");
  checkRefused("plan floor.obj --fields x,brightness", 2, "no field is called 'brightness'; the nearest are ");
  checkRefused("effects os1-fog", 2, "clean, auto, carla");
  checkRefused("plan none.obj", 1, "none.obj");
}

TEST_CASE("a scan on a device tells of echoes that a beam does not keep, and what the time of a trajectory is") {
  const Workplace place;
  std::string panes = "mtllib glass.mtl\nusemtl glass\n";
  for (int pane = 0; pane < 12; ++pane) {
    const std::string x = "v " + std::to_string(3 + pane);
    panes += x + " -9 -9\n" + x + " 9 -9\n" + x + " 9 9\n" + x + " -9 9\nf -4 -3 -2 -1\n";
  }
  place.put("panes.obj", panes);
  place.put("glass.mtl", "newmtl glass\nKd 0.5 0.5 0.5\nd 0.2\nillum 4\nTf 0.9 0.9 0.9\n");
  place.put("poses.tum", "0 0 0 0 0 0 0 1\n1 0 1 0 0 0 0 1\n");
  const std::string scan = "scan panes.obj --up z --faces both --sensor Puck --effect detection=off ";
  const Result one = place.run(scan + "--pose 0,0,0");
  INFO(one.err << one.out);
  REQUIRE(one.status == 0);
  CHECK_THAT(one.out, ContainsSubstring(" echoes more than a beam keeps\n"));
  const Result both = place.run(scan + "--trajectory poses.tum");
  CHECK_THAT(
      both.out,
      ContainsSubstring(" echoes more than a beam keeps\n") &&
          ContainsSubstring(
              " at best; scans that are submitted together share their time, and the first may include compilation\n"));
}

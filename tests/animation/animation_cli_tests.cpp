// SPDX-License-Identifier: Apache-2.0
// gnosphere info, and scans of animated models.
#include <array>
#include <cmath>
#include <sstream>

#include "animation/made_model.hpp"
#include "tools/cli_support.hpp"

using namespace gnosphere::test;

namespace {

/// A wall at y = 5 that moves to y = 9 within two seconds, in y-up coordinates.
std::string movingWall() {
  GltfFileMaker file = animatedFile();
  file.json["nodes"][0].update({{"translation", {-20, -20, -5}}, {"scale", {60, 60, 1}}});
  addChannel(file, 0, "translation", "LINEAR", {0, 2}, Floats{-20, -20, -5, -20, -20, -9});
  return file.text();
}

/// The y coordinates in a CSV file whose second column they are.
std::vector<double> secondColumn(const std::string& csv) {
  std::istringstream lines(csv);
  std::string line;
  std::getline(lines, line);
  std::vector<double> values;
  while (std::getline(lines, line)) values.push_back(std::stod(line.substr(line.find(',') + 1)));
  return values;
}

}  // namespace

TEST_CASE("info tells what is deformable, the animations, and what is left out") {
  const Workplace place;
  GltfFileMaker file = skinnedFile();
  addChannel(file, 2, "rotation", "LINEAR", {0, 1.5f}, Floats{0, 0, 0, 1, 0, 0, 0, 1});
  addChannel(file, 2, "scale", "LINEAR", {0, 1}, Floats{1, 1, 1, 1, 1, 1});  // of the same node
  file.json["animations"][0]["channels"].push_back({{"sampler", 0}, {"target", {{"path", "rotation"}}}});
  place.put("strip.gltf", file.text());
  const nlohmann::json info = place.runJson("info strip.gltf --json");
  CHECK(info["triangles"] == 4);
  REQUIRE(info["deformable_meshes"].size() == 1);
  CHECK(info["deformable_meshes"][0]["joints"] == 2);
  CHECK(info["deformable_meshes"][0]["joints_per_vertex"] == 4);
  REQUIRE(info["animations"].size() == 1);
  CHECK(info["animations"][0]["name"] == "clip");
  CHECK(info["animations"][0]["duration"] == 1.5);
  CHECK(info["animations"][0]["nodes"] == 1);
  CHECK(info["left_out"] == nlohmann::json::array({"1 animation channels without a node"}));
  const Result text = place.run("info strip.gltf");
  CHECK(text.status == 0);
  for (const char* words : {"4 triangles of 1 mesh in 1 instance", "1 animation channels without a node", "clip"})
    CHECK_THAT(text.out, Catch::Matchers::ContainsSubstring(words));
  CHECK(place.run("info floor.obj").status == 0);
}

TEST_CASE("info --json lists the names and classes of instances and materials") {
  const Workplace place;
  GltfFileMaker file = triangleFile();
  file.json["materials"] = Json::parse(R"([{"name": "paint", "extras": {"class": 7}}, {"name": "glass"}])");
  file.json["meshes"][0]["primitives"][0]["material"] = 0;
  file.json["nodes"][0].update(Json::parse(R"({"name": "car 1", "extras": {"class": "car"}})"));
  file.node({{"mesh", 0}});
  place.put("cars.gltf", file.text());
  const nlohmann::json info = place.runJson("info cars.gltf --json");
  CHECK(info["instances"] == 2);
  const auto namesOf = [&](const char* list) {
    Json names = Json::array();
    for (const auto& item : info[list]) names.push_back({item["name"], item["class"]});
    return names;
  };
  CHECK(namesOf("instance_list") == Json::parse(R"([["car 1", "car"], ["", null]])"));
  for (const auto& instance : info["instance_list"]) CHECK(instance["mesh"] == "tri");
  CHECK(namesOf("material_list") == Json::parse(R"([["paint", 7], ["glass", null]])"));
}

TEST_CASE("info --json tells of every mesh, instance and material") {
  const Workplace place;
  GltfFileMaker file = triangleFile();
  file.json["materials"] =
      Json::parse(R"([{"name": "glass", "alphaMode": "MASK", "alphaCutoff": 0.25, "doubleSided": true,
      "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.25, 0.125, 0.75], "metallicFactor": 0.5, "roughnessFactor": 0.25},
      "extensions": {"KHR_materials_transmission": {"transmissionFactor": 0.75}}, "extras": {"retro": 3}}])");
  file.json["meshes"][0]["primitives"][0]["material"] = 0;
  file.node({{"mesh", 0}, {"translation", {10, 20, 30}}});
  place.put("two.gltf", file.text());
  const nlohmann::json info = place.runJson("info two.gltf --json");
  CHECK(info["mesh_list"] == Json::parse(R"([{"name": "tri", "vertices": 3, "triangles": 1}])"));
  REQUIRE(info["instance_list"].size() == 2);
  for (const char* side : {"min", "max"}) {
    const auto first = info["instance_list"][0]["bounds"][side], second = info["instance_list"][1]["bounds"][side];
    for (size_t axis = 0; axis < 3; ++axis)  // glTF's y is up
      CHECK(std::abs(second[axis].get<double>() - first[axis].get<double>() - std::array{10., -30., 20.}[axis]) < 1e-6);
    CHECK(info["bounds"][side] ==
          (std::string(side) == "min" ? Json{first[0], second[1], first[2]} : Json{second[0], first[1], second[2]}));
  }
  CHECK(info["material_list"][0] ==
        Json::parse(R"({"name": "glass", "class": null, "base_color": [0.5, 0.25, 0.125, 0.75],
      "metallic": 0.5, "roughness": 0.25, "transmission": 0.75, "alpha_mode": "mask", "alpha_cutoff": 0.25,
      "double_sided": true, "retro": 3.0})"));
  CHECK(info["non_finite"] == 0);
  CHECK(info["degenerate"] == 0);
}

TEST_CASE("info warns as scan does of a scene whose triangles are nowhere") {
  const Workplace place;
  const std::string corners = "v 5 -5 0\nv 5 5 0\nv 5 0 5\nv nan 0 0\n";
  place.put("odd.obj", corners + "f 1 2 3\nf 1 2 4\nf 1 1 3\nf 2 3 3\n");
  place.put("none.ply",
            "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
            "element face 0\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n");
  for (const char* scene : {"odd.obj", "none.ply"}) {
    INFO(scene);
    const Result scan = place.run(std::string("scan ") + scene + " --device reference --sensor VLP-16 --effects clean");
    const Result info = place.run(std::string("info ") + scene);
    CHECK_THAT(info.err,
               Catch::Matchers::ContainsSubstring(
                   "warning: " + std::string(scene == std::string("odd.obj") ? "1 triangle of " : "") + scene));
    CHECK(info.err == scan.err);
    CHECK(info.status == 0);
  }
  CHECK_THAT(place.run("info odd.obj").out,
             Catch::Matchers::ContainsSubstring("degenerate 2 triangles with equal corners\n"));
  const nlohmann::json info = place.runJson("info odd.obj --json");
  CHECK(info["non_finite"] == 1);
  CHECK(info["degenerate"] == 2);
}

TEST_CASE("scan shows a scene at a time of an animation") {
  const Workplace place;
  place.put("wall.gltf", movingWall());
  const std::string scan =
      "scan wall.gltf --pose 0,0,0 --sensor VLP-16 --faces both --device reference --effects clean "
      "--compact -o out.csv";
  const auto wallAt = [&](const std::string& more) {
    const Result result = place.run(scan + more);
    INFO(result.err);
    REQUIRE(result.status == 0);
    const std::vector<double> found = secondColumn(place.get("out.csv"));
    REQUIRE(found.size() > 100);
    for (const double y : found) CHECK(std::abs(y - found[0]) < 1e-5);
    return found[0];
  };
  CHECK(std::abs(wallAt("") - 5) < 1e-5);
  CHECK(std::abs(wallAt(" --animation clip --time 0.5") - 6) < 1e-5);
  CHECK(std::abs(wallAt(" --animation clip --time 2.5") - 6) < 1e-5);
  CHECK(std::abs(wallAt(" --animation clip") - 5) < 1e-5);
  const Result wrong = place.run("scan wall.gltf --animation clap -o no.csv");
  CHECK(wrong.status == 2);
  CHECK_THAT(wrong.err, Catch::Matchers::ContainsSubstring("no clip is called 'clap'; there is clip"));
  CHECK(place.run("scan wall.gltf --time 1 -o no.csv").status == 2);
  CHECK(place.run("scan wall.gltf --animation clip --time inf -o no.csv").status == 2);
  CHECK_FALSE(fs::exists(place / "no.csv"));
}

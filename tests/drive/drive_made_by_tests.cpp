// SPDX-License-Identifier: Apache-2.0
// The files of a data set that tell how it was made.
#include <array>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "base/hash.hpp"
#include "base/sha256.hpp"
#include "drive_support.hpp"
#include "support.hpp"

using namespace gnosphere;
using namespace gnosphere::test;
using Catch::Matchers::ContainsSubstring;

TEST_CASE("a data set says what has made it, once for all runs that are alike, and keeps the drive file") {
  const DriveFolder folder;
  Json json = smallDrive();
  json["simulator"] = {{"faces", "both"}};
  json["seed"] = 12;
  const drive::Drive drive = folder.read(json);
  const auto makers = [&](const std::string& out) {
    std::vector<Json> all;
    for (const auto& entry : fs::directory_iterator(folder / out / "manifest/made_by"))
      all.push_back(Json::parse(bytesOf(entry.path())));
    return all;
  };
  drive::RunOptions options = optionsFor(folder / "out");
  options.simulator.cache = "off";  // concerns the machine alone
  for (options.shard = 0, options.shardCount = 3; options.shard < 3; ++options.shard) drive::run(drive, options);
  const auto made = makers("out");
  REQUIRE(made.size() == 1);
  CHECK(made[0]["version"].get<std::string>().find('.') != std::string::npos);
  CHECK(made[0]["device"] == drive::run(drive, optionsFor(folder / "whole")).device);
  CHECK(made[0]["type"] == "reference");
  CHECK(made[0]["accuracy"] == "standard");
  CHECK(made[0]["options"] == Json{{"faces", "both"}});
  CHECK(made[0]["seed"] == 12);
  CHECK(made[0]["fingerprint"] == drive.fingerprint);
  CHECK(made[0]["drive_file"] == hashOf(folder.get("out/manifest/drive_file.json")));
  checkSameFiles(folder / "whole", folder / "out");

  put(folder / "copy.json", folder.get("out/manifest/drive_file.json"));
  CHECK(drive::readDrive(folder / "copy.json").fingerprint == drive.fingerprint);

  fs::remove(folder / "out/manifest/frames/000004.json");
  options.shardCount = 1;
  options.shard = 0;
  options.simulator.tuning.float64 = false;
  CHECK(drive::run(drive, options).kept == 9);
  CHECK(makers("out").size() == 2);
  CHECK(drive::run(drive, options).kept == 10);  // makes nothing, so it is no maker
}

TEST_CASE("a data set says which files it was made from, what its sensors simulate and what its drive file warns of") {
  const DriveFolder folder;
  Json json = smallDrive();
  json["duration"] = 0.1;
  // A model in a folder of its own with a buffer beside it, a sensor, effects, and files that are not read.
  const auto putText = [&](const std::string& name, const std::string& text) {
    fs::create_directories((folder / name).parent_path());
    put(folder / name, text);
  };
  const std::array<float, 9> corners = {0, 0, 0, 1, 0, 0, 0, 1, 1};
  putText("cars/some shape.bin", std::string(reinterpret_cast<const char*>(corners.data()), sizeof(corners)));
  putText("cars/car.gltf", R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
    "nodes": [{"mesh": 0}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
    "buffers": [{"uri": "some%20shape.bin", "byteLength": 36}], "bufferViews": [{"buffer": 0, "byteLength": 36}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0],
    "max": [1, 1, 1]}]})");
  putText("stone.mtl", "newmtl stone\nKd 0.5 0.5 0.5\n");
  putText("floor.obj", std::string("mtllib stone.mtl\nusemtl stone\n") + kFloor);
  putText("head.json", smallHead().dump());
  putText("noise.json", R"({"range-noise": {"sigma": 0.01}})");
  putText("Puck", "no sensor");
  putText("ego.tum", "0 -2 0 0 0 0 0 1\n1 2 0 0 0 0 0 1\n");
  json["models"]["car"] = {{"file", "cars/car.gltf"}};
  json["actors"][0]["model"] = "car";
  json["sensors"][0]["sensor"] = "head.json";
  json["sensors"][0]["effects"] = "noise.json";
  json["sensors"][1]["sensor"] = "Puck";
  json["sensors"][1]["effects"] = "clean";
  json["ego"]["trajectory"] = {{"file", "ego.tum"}};
  json.erase("name");
  folder.run(json);
  const auto madeBy = [&](const std::string& out) {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(folder / out / "manifest/made_by")) files.push_back(entry.path());
    REQUIRE(files.size() == 1);
    return Json::parse(bytesOf(files[0]));
  };
  const Json made = madeBy("out");
  std::map<std::string, Json> inputs;
  for (const Json& input : made["inputs"]) inputs[input["path"].get<std::string>()] = input;
  std::string names;
  for (const auto& [name, input] : inputs) {
    names += name + ", ";
    CHECK(input["bytes"] == folder.get(name).size());
    CHECK(input["sha256"] == sha256Text(folder.get(name)));
  }
  CHECK(names ==
        "cars/car.gltf, cars/some shape.bin, cube.obj, ego.tum, floor.obj, head.json, noise.json, stone.mtl, ");

  CHECK(made["warnings"] == Json(folder.read(json).warnings));
  CHECK(made["warnings"].size() > 0);
  REQUIRE(made["sensors"].size() == 2);
  CHECK(made["sensors"][1]["sensor"] == "side");
  const auto effect = [&](size_t sensor, const std::string& name) -> const Json& {
    const Json& effects = made["sensors"][sensor]["effects"];
    return *std::ranges::find_if(effects, [&](const Json& one) { return one["effect"] == name; });
  };
  CHECK(effect(0, "range-noise")["in"] == true);
  CHECK(effect(0, "sensor-motion")["in"] == true);
  CHECK(effect(0, "sensor-motion")["reason"] == "the sensor sweeps its columns in 100 ms");
  CHECK(effect(1, "range-noise")["in"] == false);

  // The file that is kept makes the same data set under any name.
  fs::rename(folder / "out/manifest/drive_file.json", folder / "again.json");
  drive::run(drive::readDrive(folder / "again.json"), optionsFor(folder / "again"));
  CHECK(bytesOf(folder / "again.json") == folder.get("again/manifest/drive_file.json"));
  fs::copy(folder / "again.json", folder / "out/manifest/drive_file.json");
  CHECK(Json::parse(folder.get("again/manifest/drive.json"))["drive"] == "drive");
  checkSameFiles(folder / "out", folder / "again");

  // A comment makes another file of the same triangles.
  put(folder / "cube.obj", std::string("# a comment\n") + kCube);
  folder.run(json, "comment");
  CHECK(madeBy("comment")["fingerprint"] == made["fingerprint"]);
  CHECK(madeBy("comment")["inputs"] != made["inputs"]);
}

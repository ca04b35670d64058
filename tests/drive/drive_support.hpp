// SPDX-License-Identifier: Apache-2.0
// A small drive for tests: a floor, a car that passes, a person who comes and goes, and two sensors.
#pragma once

#include <map>
#include <nlohmann/json.hpp>

#include "drive/formats/format.hpp"
#include "drive/run.hpp"
#include "folder.hpp"
#include "support.hpp"

namespace gnosphere::test {

using Json = nlohmann::ordered_json;

/// Lines of an .obj file of a unit cube around the origin.
inline const char* kCube =
    "v -0.5 -0.5 -0.5\nv 0.5 -0.5 -0.5\nv 0.5 0.5 -0.5\nv -0.5 0.5 -0.5\nv -0.5 -0.5 0.5\nv 0.5 -0.5 0.5\n"
    "v 0.5 0.5 0.5\nv -0.5 0.5 0.5\nf 1 3 2\nf 1 4 3\nf 5 6 7\nf 5 7 8\nf 1 2 6\nf 1 6 5\nf 2 3 7\nf 2 7 6\n"
    "f 3 4 8\nf 3 8 7\nf 4 1 5\nf 4 5 8\n";
inline const char* kFloor = "v -20 -20 0\nv 20 -20 0\nv 20 20 0\nv -20 20 0\nf 1 2 3\nf 1 3 4\n";

/// A head of 8 channels and 90 columns that turns ten times a second.
inline Json smallHead() {
  return {{"name", "small"},
          {"columns", 90},
          {"rotation_period", 0.1},
          {"range", {{"min", 0.1}, {"max", 60}}},
          {"elevation_deg", {-40, -30, -22, -16, -12, -8, -4, 0}}};
}

inline Json waypoint(double time, double x, double y, double z) {
  return {{"time", time}, {"position", {x, y, z}}};
}

/// A drive of 10 frames.
inline Json smallDrive() {
  return {{"name", "small"},
          {"classes",
           {{"ground", {{"id", 40}}},
            {"car", {{"id", 10}, {"moving_id", 252}}},
            {"person", {{"id", 30}, {"moving_id", 254}}}}},
          {"scenes", {{{"file", "floor.obj"}, {"class", "ground"}}}},
          {"models", {{"cube", {{"file", "cube.obj"}}}}},
          {"actors",
           {{{"name", "car-1"},
             {"model", "cube"},
             {"class", "car"},
             {"size", {4, 2, 1.5}},
             {"trajectory", {{"waypoints", {waypoint(0, 3, 3, 0.75), waypoint(1, 8, 3, 0.75)}}}}},
            {{"name", "person-1"},
             {"model", "cube"},
             {"class", "person"},
             {"size", {0.6, 0.8, 1.8}},
             {"trajectory", {{"waypoints", {waypoint(0.25, 1, -3, 0.9), waypoint(0.65, 1, -3, 0.9)}}}},
             {"outside", "gone"}}}},
          {"ego", {{"trajectory", {{"waypoints", {waypoint(0, -2, 0, 0), waypoint(1, 2, 0, 0)}}}}}},
          {"sensors",
           {{{"name", "top"},
             {"sensor", smallHead()},
             {"mount", {{"position", {0, 0, 1.8}}}},
             {"effects", {{"range-noise", {{"sigma", 0.01}}}}}},
            {{"name", "side"},
             {"sensor", smallHead()},
             {"rate", 5},
             {"offset", 0.05},
             {"mount", {{"position", {1, 0.5, 1}}, {"yaw_pitch_roll_deg", {90, 10, 0}}}},
             {"effects", "clean"}}}},
          {"weather", {{{"time", 0.5}}, {{"time", 0.5}, {"rain", 50}}}},
          {"outputs", {{{"format", "npy"}, {"fields", "x,y,z,range,time,class,instance"}}}}};
}

/// The small drive with nothing to warn of: all that moves and rains reaches both sensors.
inline Json quietDrive() {
  Json json = smallDrive();
  json["sensors"][1]["effects"] = "auto";
  return json;
}

/// A folder with the files that smallDrive() names.
class DriveFolder {
 public:
  DriveFolder() {
    put(folder_ / "cube.obj", kCube);
    put(folder_ / "floor.obj", kFloor);
  }
  fs::path operator/(const std::string& name) const { return folder_ / name; }
  drive::Drive read(const Json& json) const { return drive::readDrive(put(folder_ / "drive.json", json.dump())); }
  drive::RunReport run(const Json& json, const std::string& out = "out") const {
    drive::RunOptions options;
    options.out = folder_ / out;
    options.simulator.device = DeviceChoice::Kind::reference;
    return drive::run(read(json), options);
  }
  std::string get(const std::string& name) const { return bytesOf(folder_ / name); }

 private:
  Folder folder_;
};

/// All files below a folder with their bytes, except those that only say how a run went.
inline std::map<std::string, std::string> filesOf(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file() && entry.path().filename() != "lock")
      files[fs::relative(entry.path(), folder).generic_string()] = bytesOf(entry.path());
  return files;
}

inline void checkSameFiles(const fs::path& a, const fs::path& b) {
  const auto filesA = filesOf(a), filesB = filesOf(b);
  CHECK(filesA.size() == filesB.size());
  for (const auto& [name, bytes] : filesA) {
    INFO(name);
    const auto other = filesB.find(name);
    REQUIRE(other != filesB.end());
    CHECK(bytes == other->second);
  }
}

inline drive::RunOptions optionsFor(const fs::path& out) {
  drive::RunOptions options;
  options.out = out;
  options.simulator.device = DeviceChoice::Kind::reference;
  return options;
}

inline Json everyOutput() {
  Json outputs = Json::array();
  for (const drive::FormatInfo& format : drive::formats()) outputs.push_back({{"format", format.name}});
  outputs.push_back({{"format", "las"}, {"folder", "line"}, {"one_file", true}});
  return outputs;
}

/// The small drive in every format, run once for all tests.
inline const DriveFolder& made() {
  static const DriveFolder kFolder;
  static const bool kDone = [] {
    Json json = smallDrive();
    json["weather"] = Json::array();
    json["sensors"][0]["effects"] = "auto";
    json["outputs"] = everyOutput();
    json["epoch"] = 1700000000;
    return kFolder.run(json).finished;
  }();
  REQUIRE(kDone);
  return kFolder;
}

/// Writes pane.glb: glass 4 m ahead, from 9 m on the right to 9 m on the left.
inline void putPane(const DriveFolder& folder) {
  MeshBuilder quad;
  quad.quad({4, -9, -1}, {0, 18, 0}, {0, 0, 6});
  Scene pane = sceneOf(quad.take());
  pane.materials.resize(1);
  pane.materials[0].transmission = 0.5f;
  writeGlb(pane, folder / "pane.glb");
}

}  // namespace gnosphere::test

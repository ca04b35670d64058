// SPDX-License-Identifier: Apache-2.0
// Tests of drive files: what one may say, and what its mistakes get.
#include <algorithm>
#include <catch2/matchers/catch_matchers_floating_point.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>

#include "drive/ros.hpp"
#include "drive/schedule.hpp"
#include "drive/schema_check.hpp"
#include "drive_support.hpp"
#include "problem.hpp"

using namespace gnosphere;
using namespace gnosphere::test;
using Catch::Matchers::ContainsSubstring;
using Catch::Matchers::WithinAbs;
using namespace std::string_literals;

namespace {

/// Checks that this drive is refused with a line that has all these words.
void checkRefused(const Json& json, const std::vector<std::string>& words) {
  const DriveFolder folder;
  const std::string problem = problemOf([&] { folder.read(json); }, ErrorCode::format);
  CHECK(problem.find('\n') == std::string::npos);
  for (const std::string& word : words) CHECK_THAT(problem, ContainsSubstring(word));
}

Json changed(const std::string& pointer, const Json& value) {
  Json json = smallDrive();
  json[Json::json_pointer(pointer)] = value;
  return json;
}

}  // namespace

TEST_CASE("a drive has the options of the simulator that change clouds") {
  const DriveFolder folder;
  CHECK(folder.read(smallDrive()).simulator == std::vector<std::string>{"accuracy=standard"});
  Json json = changed("/simulator", {{"faces", "both"}, {"accuracy_parts", {{"inside", "plain"}}}});
  CHECK(folder.read(json).simulator ==
        std::vector<std::string>{"accuracy=standard", "accuracy_parts.inside=\"plain\"", "faces=\"both\""});
  json["simulator"]["accuracy"] = "exact";
  CHECK(folder.read(json).simulator[1] == "accuracy=\"exact\"");
  json["accuracy"] = "exact";
  checkRefused(json, {"simulator.accuracy: is there twice"});
  checkRefused(changed("/simulator", {{"tuning", 1}}), {"simulator.tuning: is an unknown word"});
  checkRefused(changed("/simulator", {{"faces", "back"}}), {"simulator.faces: 'back' is unknown"});
}

TEST_CASE("a mistake in a drive file is told with its path, what is expected and the nearest word") {
  checkRefused(changed("/actors/0/trajectry", 1),
               {"actors[0].trajectry: is an unknown word; the nearest are trajectory"});
  checkRefused(changed("/actors/1/outside", "gon"), {"actors[1].outside: 'gon' is unknown", "gone"});
  checkRefused(changed("/actors/0/class", "carr"), {"actors[0].class: 'carr' is unknown; there are car"});
  checkRefused(changed("/actors/0/model", "cub"), {"actors[0].model: 'cub' is unknown; there is cube"});
  checkRefused(changed("/actors/0/size", Json::array({1, 2})), {"actors[0].size: must have 3 entries, has 2"});
  checkRefused(changed("/actors/0/size/1", -1), {"actors[0].size[1]: must be above 0, is -1"});
  checkRefused(changed("/actors/1/name", "car-1"), {"actors[1].name: 'car-1' is there twice"});
  checkRefused(changed("/rate", "fast"), {"rate: must be a number, is \"fast\""});
  checkRefused(changed("/sensors/0/rate", 20), {"sensors[0].rate: is 20 scans a second, but the sensor takes 0.1"});
  checkRefused(changed("/sensors/0/sensor", "Puk"), {"sensors[0].sensor: ", "Puck", "or give a file"});
  checkRefused(changed("/sensors/1/name", "to p"), {"sensors[1].name: must have letters"});
  checkRefused(changed("/sensors/0/sensor/columns", 0), {"sensors[0].sensor: "});
  checkRefused(changed("/sensors/0/effects/fogg", "on"), {"sensors[0].effects: ", "no effect is called 'fogg'", "fog"});
  checkRefused(changed("/sensors/0/mount/orientation", Json::array({0, 0, 0, 2})),
               {"sensors[0].mount.orientation: must be a quaternion"});
  checkRefused(changed("/sensors/1/mount/orientation", Json::array({0, 0, 0, 1})),
               {"sensors[1].mount.yaw_pitch_roll_deg: is an alternative to orientation"});
  checkRefused(changed("/sensors/1/mount/yaw_deg", 90),
               {"sensors[1].mount.yaw_deg: is an alternative to yaw_pitch_roll_deg; keep one"});
  checkRefused(changed("/ego/trajectory", Json::object()), {"ego.trajectory: needs a file or waypoints"});
  checkRefused(changed("/ego/trajectory/file", "no.tum"), {"ego.trajectory: has a file and waypoints; keep one"});
  checkRefused(changed("/ego/trajectory", {{"file", "no.tum"}}), {"ego.trajectory.file: ", "no.tum: cannot be read"});
  checkRefused(changed("/ego/trajectory", {{"file", "no.tum"}, {"speed", 3}}),
               {"ego.trajectory.speed: is only for files of the format carla-route"});
  checkRefused(changed("/ego/trajectory/waypoints/1/time", 0), {"ego.trajectory: the time of pose 2 of 2"});
  checkRefused(changed("/scenes/0/file", "flor.obj"), {"scenes[0].file: ", "flor.obj"});
  checkRefused(changed("/scenes/0/instances", {{"*", "car2"}}), {"scenes[0].instances.*: 'car2' is unknown"});
  checkRefused(changed("/outputs/0/format", "kiti"), {"outputs[0].format: 'kiti' is unknown; the nearest are kitti"});
  checkRefused(changed("/outputs/0/folder", "../there"), {"outputs[0].folder: must be a folder in the output folder"});
  checkRefused(changed("/outputs/0/sensors", Json::array({"tip"})), {"outputs[0].sensors[0]: 'tip' is unknown", "top"});
  checkRefused(changed("/outputs/0/sensors", Json::array({"top", "side", "top"})),
               {"outputs[0].sensors[2]: 'top' is there twice"});
  checkRefused(changed("/outputs/0", {{"format", "kitti"}, {"sensors", {"top", "side"}}}),
               {"outputs[0].sensors: the format has one lidar; name one sensor"});
  checkRefused(changed("/scenes/0", {{"file", "floor.obj"}, {"boxes", {"car"}}, {"animation", {{"clip", "wave"}}}}),
               {"scenes[0].boxes: cannot be with an animation; make actors of what it moves"});
  checkRefused(changed("/sensors/0/name", ""), {"sensors[0].name: must not be empty"});
  checkRefused(changed("/accuracy", 2), {"accuracy: must be a word, is 2"});
  checkRefused(Json::array({1}), {"drive.json: the whole file: must be an object, is [1]"});
  checkRefused(changed("/outputs/0/fields", "x,why"), {"outputs[0].fields: ", "why"});
  checkRefused(changed("/outputs/1", {{"format", "npy"}}), {"outputs[1].folder: another output writes there, too"});
  checkRefused(changed("/outputs/1", {{"format", "las"}, {"keyframes", 2}}),
               {"outputs[1].keyframes: is only for nuscenes"});
  checkRefused(changed("/outputs/1", {{"format", "las"}, {"version", "v1.0-mini"}}),
               {"outputs[1].version: is only for nuscenes"});
  checkRefused(changed("/outputs/1", {{"format", "nuscenes"}, {"sequence", 2}}),
               {"outputs[1].sequence: is only for kitti, semantickitti and kitti-raw"});
  Json labelled = changed("/outputs/1", {{"format", "nuscenes"}, {"lidarseg", true}});
  CHECK(DriveFolder().read(labelled).outputs[1].lidarseg);
  labelled.erase("classes");
  labelled.erase("actors");
  labelled["scenes"] = {{{"file", "floor.obj"}}};
  checkRefused(labelled, {"outputs[1].lidarseg: labels have one byte, so the drive needs 1 to 255 classes, has 0"});
  for (const char* version : {"samples", "v1/../..", "mini", "v1.", "v"})
    checkRefused(changed("/outputs/1", {{"format", "nuscenes"}, {"version", version}}),
                 {"outputs[1].version: must be v and a number, such as v1.0-mini"});
  checkRefused(changed("/weather/1/time", 0.2), {"weather[1].time: comes before"});
  checkRefused(changed("/ego", {{"trajectory", {{"waypoints", {waypoint(0, 0, 0, 0)}}}}}), {"duration: is missing"});
}

TEST_CASE("names that are one on Windows and macOS, or that Windows keeps for devices, are refused on every system") {
  checkRefused(changed("/sensors/1/name", "TOP"),
               {"sensors[1].name: 'TOP' differs from 'top' by capital letters alone", "Windows and macOS"});
  for (const char* device : {"con", "NUL", "prn", "Aux", "com1", "LPT9"})
    checkRefused(changed("/sensors/1/name", device),
                 {"sensors[1].name: '" + std::string(device) + "' is the name of a device on Windows"});
  for (const char* name : {"com0", "com10", "console", "nul-1", "lpt"}) {
    INFO(name);
    CHECK(DriveFolder().read(changed("/sensors/1/name", name)).sensors.size() == 2);
  }
  Json two = changed("/outputs/1", {{"format", "npy"}, {"folder", "clouds/NPY"}});
  two["outputs"][0]["folder"] = "Clouds";
  checkRefused(two, {"outputs[1].folder: another output writes there, too, to 'Clouds'"});
  two["outputs"][1]["folder"] = "CLOUDS/";
  checkRefused(two, {"outputs[1].folder: another output writes there, too, to 'Clouds'"});
  for (const char* own : {"Manifest", "OBJECTS.json"})
    checkRefused(changed("/outputs/0/folder", own), {"outputs[0].folder: must be a folder in the output folder"});
  for (const char* device : {"Nul", "clouds/com1", "aux.d/clouds"})
    checkRefused(changed("/outputs/0/folder", device),
                 {"outputs[0].folder: '" + std::string(device) + "' has the name of a device on Windows"});
}

TEST_CASE("names that lead out of the folder, that Windows cannot hold or that are too long for files are refused") {
  for (const char* member : {"/name", "/sensors/0/name"}) {
    const std::string path = std::string(member) == "/name" ? "drive.json: name: " : "sensors[0].name: ";
    for (const char* name : {"../../escaped", "a/b", "a\\b", "a:b", "my drive", "stra\u00dfe", "."})
      checkRefused(changed(member, name), {path + "must have letters, digits, _ and - only, is "});
    checkRefused(changed(member, "nul"), {path + "'nul' is the name of a device on Windows"});
    checkRefused(changed(member, std::string(101, 'a')), {path + "has 101 characters"});
    CHECK(DriveFolder().read(changed(member, std::string(100, 'a'))).sensors.size() == 2);
  }
  for (const char* folder : {"a/../b", "b/..", "/b", "..", "a/./../../c"})
    checkRefused(changed("/outputs/0/folder", folder), {"outputs[0].folder: must be a folder in the output folder"});
  for (const char* folder : {"a:b", "C:b", "a\\..\\b", "clouds./b", "clouds /b", "what?", "a\nb"})
    checkRefused(changed("/outputs/0/folder", folder), {"outputs[0].folder: ", " cannot be a folder on Windows"});
  for (const char* folder : {"a/b/", "./a", "a..b", ".hidden", "a b", "stra\u00dfe"}) {
    INFO(folder);
    CHECK(DriveFolder().read(changed("/outputs/0/folder", folder)).outputs[0].folder == folder);
  }
}

TEST_CASE("a drive without a name has that of its file, as data sets can have it") {
  const DriveFolder folder;
  Json json = smallDrive();
  json.erase("name");
  for (const auto& [file, name] :
       std::map<std::string, std::string>{{"town-2.json", "town-2"},
                                          {"my drive (2).json", "my_drive_2_"},
                                          {"stra\u00dfe v1.2.json", "stra_e_v1_2"},
                                          {".json", "_json"},
                                          {"con.json", "con_"},
                                          {std::string(120, 'a') + ".json", std::string(100, 'a')},
                                          {"\xff.json", "_"}}) {
    INFO(file);
    const drive::Drive drive = drive::readDrive(put(folder / file, json.dump()));
    CHECK(drive.name == name);
    CHECK(drive::mistakeOfName(drive.name) == "");
    // The manifest's copy of the drive file is read as the same drive under any name of a file.
    CHECK(drive::readDrive(put(folder / "drive_file.json", drive.file)).fingerprint == drive.fingerprint);
  }
  CHECK(drive::readDrive(put(folder / "drive.json", json.dump()), {}, "other").name == "other");
  CHECK_THROWS_WITH(drive::readDrive(folder / "drive.json", {}, "../other"),
                    ContainsSubstring("drive.json: name: must have letters"));
}

TEST_CASE("a drive and its trajectories in UTF-16 are refused with what to do") {
  const DriveFolder folder;
  const std::string drive = "\xff\xfe{\0}\0"s, tum =
                                                   "\xfe\xff\0"
                                                   "0"s;
  const auto read = [&] { drive::readDrive(put(folder / "drive.json", drive)); };
  CHECK_THAT(problemOf(read, ErrorCode::format), ContainsSubstring("drive.json: is text in UTF-16; save it as UTF-8"));
  put(folder / "ego.tum", tum);
  CHECK_THROWS_WITH(drive::readTrajectory(folder / "ego.tum", "tum", {}),
                    ContainsSubstring("ego.tum: is text in UTF-16; save it as UTF-8"));
}

TEST_CASE("all mistakes are told at once") {
  Json json = smallDrive();
  json["rat"] = 3;
  json["actors"][0].erase("class");
  json["sensors"][0]["offset"] = -1;
  checkRefused(json,
               {"rat: is an unknown word", "actors[0].class: is missing", "sensors[0].offset: must be at least 0"});
  // The first eight are told, and the number of the others.
  json = smallDrive();
  for (const char* word : {"rat1", "rat2", "rat3", "rat4", "rat5", "rat6", "rat7", "rat8"}) json[word] = 3;
  const DriveFolder folder;
  CHECK_THROWS_WITH(folder.read(json),
                    ContainsSubstring("rat8: is an unknown word") && !ContainsSubstring(" more mis"));
  json["rat9"] = json["rat10"] = 3;
  CHECK_THROWS_WITH(folder.read(json), ContainsSubstring("; and 2 more mistakes"));
  json = smallDrive();
  json["actors"][0]["class"] = "cat";
  json["sensors"][1]["sensor"] = "none";
  json["scenes"][0]["file"] = "none.obj";
  checkRefused(json, {"actors[0].class: ", "sensors[1].sensor: ", "scenes[0].file: "});
  checkRefused(changed("/models/cube/file", "floor.obj"),
               {"actors[0].size: the model of 'car-1' is flat, so it cannot be scaled to a size", "actors[1].size: "});
}

TEST_CASE("a pose states its yaw alone") {
  const DriveFolder folder;
  put(folder / "figure.obj", "v 0 0 0\nv 0 -1 0\nv 0 -1 1\nf 1 2 3\n");
  Json json = smallDrive();
  json["actors"] = Json::array();
  json["models"] = {{"figure", {{"file", "figure.obj"}, {"pose", {{"yaw_deg", 90}}}}}};
  const Bounds bounds = worldBounds(folder.read(json).models[0]);
  CHECK_THAT(bounds.max.x, WithinAbs(1, 1e-12));
  CHECK_THAT(bounds.min.y, WithinAbs(0, 1e-12));
}

TEST_CASE("a pattern that matches no instance is told, and the longest that matches counts") {
  const DriveFolder folder;
  Json json = quietDrive();
  json["scenes"][0]["instances"] = {{"*", "car"}, {"flo*", "person"}, {"street *", "ground"}};
  put(folder / "floor.obj", "o floor\n" + std::string(kFloor));
  const drive::Drive drive = folder.read(json);
  REQUIRE(drive.scenes[0].instances.size() == 1);
  CHECK(drive.scenes[0].instances[0].name == "floor");
  CHECK(drive.scenes[0].instances[0].classId == 30);
  CHECK(drive.warnings == std::vector<std::string>{"scenes[0].instances: 'street *' matches no instance"});
}

TEST_CASE("classes that a scene's file states count before that of the whole scene, and behind patterns") {
  const DriveFolder folder;
  Scene scene;
  scene.materials.emplace_back();
  Mesh mesh;
  mesh.positions = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  mesh.indices = {0, 1, 2};
  mesh.parts = {{0, 1, 0}};
  scene.meshes = {mesh};
  scene.instances = {{"stated", 0, {}, 30},         {"unknown", 0, {}, 999},       {"none", 0, {}},
                     {"matched", 0, {}, 999},       {"named", 0, {}, 0, "person"}, {"misnamed", 0, {}, 0, "pers"},
                     {"match too", 0, {}, 0, "car"}};
  writeGlb(scene, folder / "classes.glb");
  Json json = quietDrive();
  json["scenes"][0] = {{"file", "classes.glb"}, {"class", "car"}, {"instances", {{"match*", "person"}}}};
  const drive::Drive drive = folder.read(json);
  std::vector<int> ids;
  for (const Instance& instance : drive.scenes[0].instances) ids.push_back(instance.classId);
  const int car = drive.scenes[0].instances[2].classId;
  CHECK(ids == std::vector<int>{30, 999, car, 30, 30, car, 30});
  CHECK((car != 0 && car != 30));
  REQUIRE(drive.warnings.size() == 1);
  CHECK_THAT(drive.warnings[0],
             ContainsSubstring("scenes[0].file: states the classes 'pers', 999, which classes does not name"));
}

TEST_CASE("classes of materials: by the longest pattern, else as the file states them, in scenes and models") {
  const DriveFolder folder;
  Scene scene;
  Mesh mesh;
  mesh.positions = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  mesh.indices = {0, 1, 2};
  mesh.parts = {{0, 1, 0}};
  scene.meshes = {mesh};
  scene.instances = {{"", 0, {}}};
  scene.materials.resize(6);
  const char* names[] = {"road", "road wet", "lawn", "named", "misnamed", "unknown"};
  for (size_t i = 0; i < 6; ++i) scene.materials[i].name = names[i];
  scene.materials[1].classId = 777;
  scene.materials[2].classId = 30;
  scene.materials[3].className = "person";
  scene.materials[4].className = "pers";
  scene.materials[5].classId = 999;
  writeGlb(scene, folder / "materials.glb");
  Json json = quietDrive();
  json["classes"]["none"] = {{"id", 0}};
  json["scenes"][0] = {{"file", "materials.glb"},
                       {"class", "ground"},
                       {"materials", {{"road*", "car"}, {"road w*", "person"}, {"kerb", "car"}}}};
  json["models"]["cube"] = {{"file", "materials.glb"}, {"materials", {{"*", "none"}, {"lawn", "ground"}}}};
  for (Json& actor : json["actors"]) actor.erase("size");  // a triangle has none
  const drive::Drive drive = folder.read(json);
  const auto idsOf = [](const Scene& of) {
    std::vector<int> ids;
    for (const Material& material : of.materials) ids.push_back(material.classId);
    return ids;
  };
  CHECK(idsOf(drive.scenes[0]) == std::vector<int>{10, 30, 30, 30, 0, 999});
  CHECK(idsOf(drive.models[0]) == std::vector<int>{0, 0, 40, 0, 0, 0});
  CHECK(drive.scenes[0].instances[0].classId == 40);
  REQUIRE(drive.warnings.size() == 2);
  CHECK_THAT(drive.warnings[0], ContainsSubstring("scenes[0].materials: 'kerb' matches no material"));
  CHECK_THAT(drive.warnings[1], ContainsSubstring("scenes[0].file: states the classes 'pers', 999, which"));
  json["models"]["cube"]["materials"]["lawn"] = "gras";
  checkRefused(json, {"models.cube.materials.lawn: ", "'gras' is unknown"});
}

TEST_CASE("every scan belongs to the frame that it starts in, whatever the rates") {
  const DriveFolder folder;
  Json json = smallDrive();
  json["rate"] = 10;
  json["duration"] = 3.05;
  json["sensors"][0]["rate"] = 10.0 / 3;
  json["sensors"][1]["rate"] = 7;
  const drive::Drive drive = folder.read(json);
  CHECK(drive.frameCount() == 31);
  std::vector<uint64_t> next(2);
  for (uint64_t frame = 0; frame < drive.frameCount(); ++frame)
    for (const drive::PlannedScan& scan : drive::scansOf(drive, frame)) {
      CHECK(scan.number == next[scan.sensor]++);
      const double after = scan.time - static_cast<double>(frame) / 10;
      CHECK((after > -1e-6 && after < 0.1));
    }
  CHECK(next[0] == 11);  // 0, 0.3 ... 3 s
  CHECK(next[1] == 21);  // 0.05 s and every seventh of a second, before 3.05 s
}

TEST_CASE("a sector is not scanned again before the rest of its turn is over") {
  const DriveFolder folder;
  Json json = smallDrive();
  Json& sensor = json["sensors"][0];
  sensor["sensor"] = "TiM781";  // in 50 ms, every 67 ms
  json["rate"] = 30;
  CHECK(folder.read(json).sensors[0].rate == 15);
  json["rate"] = 10;
  CHECK(folder.read(json).sensors[0].rate == 10);
  sensor["rate"] = 15;
  CHECK(folder.read(json).sensors[0].rate == 15);
  sensor["rate"] = 19;
  CHECK_THROWS_WITH(folder.read(json), ContainsSubstring("is 19 scans a second, but the sensor takes 0.0666666"));
}

TEST_CASE("a sensor that starts too many scans within a frame is refused, with both rates") {
  const DriveFolder folder;
  Json json = quietDrive();
  json["rate"] = 1e-6;
  json["sensors"][0]["rate"] = 10;
  json["outputs"] = {{{"format", "nuscenes"}}};
  CHECK(folder.read(json).frameCount() == 1);  // the drive is shorter than a frame
  json["duration"] = 1e4;
  CHECK_THROWS_WITH(folder.read(json),
                    ContainsSubstring("sensors[0].rate: is 10 scans a second, and the drive has 1e-06 frames a second, "
                                      "so a frame has more than 10000 scans"));
  json["rate"] = 1e-3;
  CHECK_NOTHROW(folder.read(json));
}

TEST_CASE("a list of beams is not fired again before its last beam, and what a sensor file leaves open is told") {
  const DriveFolder folder;
  Json json = quietDrive();
  Json& sensor = json["sensors"][0];
  sensor["sensor"] = {{"name", "list"},
                      {"range", {{"max", 60}}},
                      {"patterns", {{{"directions", {{1, 0, 0}, {0, 1, 0}}}, {"times", {0, 0.5}}}}}};
  for (const Json& rate : {Json(), Json(2.1)}) {
    if (!rate.is_null()) sensor["rate"] = rate;
    CHECK_THROWS_WITH(folder.read(json),
                      ContainsSubstring("sensors[0].rate: is " + (rate.is_null() ? "10" : rate.dump()) +
                                        " scans a second, but the last beam of a scan fires 0.5 s"));
  }
  sensor["rate"] = 2;
  CHECK(folder.read(json).warnings.empty());

  put(folder / "als.xml",
      "<document><scanner id='als' optics='conic' pulseFreqs_Hz='100' scanAngleMax_deg='20' scanFreqMax_Hz='10' "
      "rangeMax_m='900' maxNOR='1'/></document>");
  sensor["sensor"] = "als.xml";
  const std::vector<std::string> warnings = folder.read(json).warnings;
  REQUIRE(warnings.size() == 3);
  CHECK_THAT(warnings[0], ContainsSubstring("sensors[0].sensor: assumed: the mirror's largest frequency, 10 Hz"));
  CHECK_THAT(warnings[2], ContainsSubstring("a target of 10 % is seen up to the largest range"));

  put(folder / "two.yaml",
      "lasers:\n- {laser_id: 0, vert_correction: 0.1, focal_slope: 2}\n- {laser_id: 1, vert_correction: 0}\n");
  sensor["sensor"] = "two.yaml";
  sensor["rate"] = 10;
  CHECK(folder.read(json).warnings.back() == "sensors[0].sensor: ignored: focal_slope of the lasers");
}

TEST_CASE("no scan starts at the end of a drive or later, although its last frame lasts longer") {
  const DriveFolder folder;
  Json json = smallDrive();
  json["rate"] = 0.5;
  json["duration"] = 1;
  json["sensors"][0]["rate"] = 100;
  json["sensors"][0]["sensor"]["rotation_period"] = 0.01;
  const drive::Drive drive = folder.read(json);
  CHECK(drive.frameCount() == 1);
  const std::vector<drive::PlannedScan> scans = drive::scansOf(drive, 0);
  CHECK(std::ranges::count(scans, size_t{0}, &drive::PlannedScan::sensor) == 100);
  CHECK(scans.back().time < drive.start + 1);
}

TEST_CASE("the pose of the vehicle is told a hundred times a second, and to the end of the last scan") {
  const DriveFolder folder;
  for (const auto& [rate, count] : {std::pair{0.5, size_t{200}}, {10.0, size_t{10}}, {50.0, size_t{10}}}) {
    Json json = smallDrive();
    json["rate"] = rate;
    json["duration"] = 2 / rate;
    const drive::Drive drive = folder.read(json);
    CHECK(drive::poseTimes(drive, 0, false).size() == count);
    const std::vector<double> last = drive::poseTimes(drive, 1, true);
    CHECK(last.front() == drive.start + 1 / rate);
    double end = 0;
    for (uint64_t frame = 0; frame < 2; ++frame)
      for (const drive::PlannedScan& scan : drive::scansOf(drive, frame))
        end = std::max(end, scan.time + drive.sensors[scan.sensor].sensor.rotationPeriod);
    CHECK(last.back() >= end);
    CHECK(last.back() < std::max(end, drive.start + 2 / rate) + 0.011);
  }
  // A scan of an earlier frame that ends last, and a frame that is much longer than the drive.
  Json json = smallDrive();
  json["duration"] = 0.5;
  json["sensors"][0]["rate"] = 1;
  json["sensors"][0]["sensor"]["rotation_period"] = 1;
  drive::Drive drive = folder.read(json);
  CHECK_THAT(drive::poseTimes(drive, 4, true).back(), WithinAbs(drive.start + 1, 1e-9));
  json["rate"] = 0.001;
  json["duration"] = 1;
  json["sensors"][0]["rate"] = 10;
  json["sensors"][0]["sensor"]["rotation_period"] = 0.1;
  drive = folder.read(json);
  CHECK(drive.frameCount() == 1);
  CHECK(drive::poseTimes(drive, 0, true).back() < drive.start + 1.1);
}

TEST_CASE("the pose of the vehicle is told as often as its trajectory has stamps, up to a thousand times a second") {
  const DriveFolder folder;
  const double epoch = 1'700'000'000;  // at which doubles round times, and so their differences
  for (const auto& [stamps, told] : {std::pair{50.0, size_t{10}}, {400.0, size_t{40}}, {5000.0, size_t{100}}}) {
    INFO(stamps << " Hz");
    Json json = smallDrive(), waypoints = Json::array();
    for (int i = 0; i <= stamps; ++i) waypoints.push_back(waypoint(epoch + i / stamps, i / stamps, 0, 0));
    json["ego"]["trajectory"] = {{"waypoints", waypoints}};
    json["start"] = epoch;
    json["rate"] = 10;
    json["duration"] = 0.5;
    CHECK(drive::poseTimes(folder.read(json), 0, false).size() == told);
  }
}

TEST_CASE("a bag has names and times that ROS 2 knows") {
  Json json = smallDrive();
  json["outputs"] = {{{"format", "mcap"}}};
  const auto refused = [&](const std::string& name, const std::string& other, const std::string& words) {
    json["sensors"][0]["name"] = name;
    json["sensors"][1]["name"] = other;
    checkRefused(json, {"outputs[0].sensors: " + words});
  };
  refused("2nd", "b", "the sensor '2nd' begins with a digit");
  refused("map", "b", "the sensor 'map' has the name of the frame of the world");
  refused("a", "base_link", "the sensor 'base_link' has the name of the frame of the vehicle");
  refused("a-b", "a_b", "the sensor 'a_b' has the topic of another one");
  json["sensors"][1]["name"] = "b";
  json["epoch"] = 2208988800;
  checkRefused(json, {"outputs[0].format: epoch and start lead to times from 2208988800.0 s", "32 bits for seconds"});
  json["epoch"] = 0;
  json["start"] = -1;
  checkRefused(json, {"outputs[0].format: MCAP has no times before 1970; the drive begins at -1.0 s"});
  json["outputs"][0]["format"] = "npy";
  CHECK(DriveFolder().read(json).start == -1);
  json["epoch"] = 1e15;
  checkRefused(json, {"epoch: leads to times from "});
}

TEST_CASE("weather is linear between entries, and may jump") {
  const DriveFolder folder;
  Json json = smallDrive();
  json["weather"] = {{{"time", 0.2}, {"visibility", 100}},
                     {{"time", 0.4}, {"visibility", 50}, {"snow", 4}},
                     {{"time", 0.4}, {"rain", 10}}};
  json["start"] = 0;
  const drive::Drive drive = folder.read(json);
  const auto at = [&](double time) { return drive.weatherAt(time).value(); };
  CHECK(at(0).visibility == 100);
  CHECK_THAT(at(0.3).visibility, WithinAbs(1 / 0.015, 1e-9));
  CHECK_THAT(at(0.3).snowRate, WithinAbs(2, 1e-9));
  CHECK(at(0.39999).rainRate == 0);
  CHECK(at(0.4).rainRate == 10);
  CHECK(at(0.4).visibility == 0);
  CHECK(at(9).rainRate == 10);
  json.erase("weather");
  CHECK_FALSE(folder.read(json).weatherAt(0));
}

TEST_CASE("frames of ROS 2 have the names that the drive file states") {
  const DriveFolder folder;
  Json json = smallDrive();
  json["frames"] = {{"world", "odom"}, {"vehicle", "base_footprint"}};
  const drive::Drive drive = folder.read(json);
  const ros2::Transforms vehicle = drive::vehicleMessage(drive, 0);
  CHECK(vehicle[0].parent == "odom");
  CHECK(vehicle[0].child == "base_footprint");
  CHECK(drive::mountsOf(drive, std::vector<size_t>{0})[0].parent == "base_footprint");
  checkRefused(changed("/frames", {{"world", "a"}, {"vehicle", "a"}}),
               {"frames: the world and the vehicle need two names"});
  checkRefused(
      changed("/frames", {{"world", "/map"}, {"vehicle", "/base_link"}}),
      {"frames.world: is '/map'; tf2 refuses frames that begin with a slash", "frames.vehicle: is '/base_link'"});
  json["sensors"][0]["name"] = "odom";
  json["outputs"] = {{{"format", "mcap"}}};
  checkRefused(json, {"the sensor 'odom' has the name of the frame of the world"});
}

TEST_CASE("an inertial unit has a name of its own, which topics may have") {
  const DriveFolder folder;
  Json json = smallDrive();
  CHECK_FALSE(folder.read(json).imu);
  json["imu"] = Json::object();
  const drive::Drive drive = folder.read(json);
  CHECK(drive.imu->name == "imu");
  CHECK(drive.imu->rate == 200);
  checkRefused(changed("/imu", {{"name", "top"}}), {"imu.name: 'top' is there twice"});
  checkRefused(changed("/imu", {{"name", "a b"}}), {"imu.name", "letters, digits"});
  checkRefused(changed("/imu", {{"rate", 0}}), {"imu.rate"});
  json["imu"]["name"] = "1st";
  json["outputs"] = {{{"format", "mcap"}}};
  checkRefused(json, {"the imu '1st' begins with a digit"});
}

TEST_CASE("the effects of a sensor keep the seed that they or their file state, and else have that of the drive") {
  const DriveFolder folder;
  const auto seedWith = [&](const Json& effects) {
    Json json = smallDrive();
    json["seed"] = 5;
    json["sensors"][0]["effects"] = effects;
    return folder.read(json).sensors[0].effects.seed;
  };
  put(folder / "own.json", R"({"range-noise": {"sigma": 0.02}, "seed": 77})");
  put(folder / "one.json", R"({"range-noise": {"sigma": 0.02}, "seed": 1})");
  put(folder / "none.json", R"({"range-noise": {"sigma": 0.02}})");
  put(folder / "carla.json", R"({"type": "sensor.lidar.ray_cast", "noise_stddev": 0.02, "noise_seed": 3})");
  CHECK(seedWith("own.json") == 77);
  CHECK(seedWith("one.json") == 1);  // also where that is the usual seed
  CHECK(seedWith({{"seed", 78}}) == 78);
  for (const char* name : {"none.json", "carla.json", "os1-rain"}) CHECK(seedWith(name) == 5);
}

TEST_CASE("a sensor has the driver of ROS 2 that the drive file names") {
  const DriveFolder folder;
  Json json = smallDrive();
  CHECK_FALSE(folder.read(json).sensors[0].driver);
  for (const char* name : {"velodyne", "ouster", "hesai", "robosense", "livox", "autoware"}) {
    json["sensors"][0]["driver"] = name;
    const std::optional<ros2::Driver> driver = folder.read(json).sensors[0].driver;
    CHECK(driver);
    CHECK(driver == ros2::driverNamed(name));
  }
  json["sensors"][0]["driver"] = "livox-custom";
  CHECK(folder.read(json).sensors[0].livoxCustom);
  CHECK(drive::cloudTypeOf(folder.read(json).sensors[0]) == ros2::MessageType::livoxCustom);
  checkRefused(changed("/sensors/0/driver", "ousters"), {"sensors[0].driver: 'ousters' is unknown", "ouster"});
}

TEST_CASE("a sensor whose scans the types of its driver do not hold is refused before it scans") {
  Json slow = smallHead();
  slow["rotation_period"] = 4.4;  // the last of 90 columns fires after 4.351 s
  const auto with = [](const Json& sensor, const std::string& driver) {
    Json json = smallDrive();
    json["sensors"][0]["sensor"] = sensor;
    json["sensors"][0]["driver"] = driver;
    return json;
  };
  const DriveFolder folder;
  for (const auto& [driver, field] :
       {std::pair("ouster", "t"), {"autoware", "time_stamp"}, {"livox-custom", "offset_time"}})
    checkRefused(with(slow, driver), {"sensors[0].driver: the field '" + std::string(field) + "' of the driver ",
                                      " has times up to 4.29 s, and the scan takes longer"});
  for (const char* driver : {"velodyne", "hesai", "livox"}) CHECK_NOTHROW(folder.read(with(slow, driver)));
  slow["rotation_period"] = 4.34;  // after 4.2918 s
  CHECK_NOTHROW(folder.read(with(slow, "ouster")));

  const auto tall = [](size_t channels) {
    Json head = smallHead();
    head["columns"] = 1;
    head["elevation_deg"] = std::vector<double>(channels);
    return head;
  };
  for (const char* driver : {"livox", "livox-custom"}) {
    CHECK_NOTHROW(folder.read(with(tall(256), driver)));
    checkRefused(with(tall(257), driver), {"the field 'line' of the driver livox has numbers up to 255"});
  }
  CHECK_NOTHROW(folder.read(with(tall(257), "autoware")));
  checkRefused(with(tall(65537), "autoware"), {"the field 'channel' of the driver autoware has numbers up to 65535"});

  Json json = smallDrive();
  json["sensors"][0]["sensor"] = tall(65536);
  json["outputs"] = {{{"format", "npy"}}, {{"format", "mcap"}}, {{"format", "nuscenes"}}};
  CHECK_NOTHROW(folder.read(json));
  json["sensors"][0]["sensor"] = tall(65537);
  json["outputs"] = {{{"format", "npy"}}};
  checkRefused(json, {"outputs[0].fields: the field 'ring' is 16 bits wide, and 'top' has 65537 channels"});
  for (const auto& [format, member] : {std::pair("mcap", "fields"), std::pair("nuscenes", "sensors")}) {
    json["outputs"] = {{{"format", format}}};
    checkRefused(json, {"outputs[0]." + std::string(member) +
                        ": the field 'ring' is 16 bits wide, and 'top' has 65537 channels"});
  }
  json["outputs"] = {{{"format", "npy"}, {"fields", "x,y,z"}},
                     {{"format", "mcap"}, {"sensors", {"side"}}},
                     {{"format", "mcap"}, {"fields", "x,y,z,radial_speed"}, {"folder", "speeds"}}};
  CHECK_NOTHROW(folder.read(json));
}

// SPDX-License-Identifier: Apache-2.0
#include "town_drive.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/file.hpp"
#include "base/json_text.hpp"
#include "base/quaternion.hpp"
#include "console.hpp"
#include "drive/pose_math.hpp"
#include "drive/trajectory.hpp"
#include "town/prop.hpp"
#include "town/town.hpp"
#include "town/vehicle.hpp"

namespace gnosphere::cli {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr double kSensorHeight = 1.8;  ///< of the poses above the road

/// A class of SemanticKITTI, and the kinds of things in a town that belong to it. Ground is told by its materials: one
/// mesh of a road has asphalt, markings, kerbs, paving and grass.
struct TownClass {
  const char* name;
  int id, movingId;
  std::vector<const char*> things;
  std::vector<const char*> materials = {};
};
const std::vector<TownClass>& classes() {
  static const std::vector<TownClass> kClasses = {
      {"car", 10, 252, {"hatchback", "saloon", "estate"}},
      {"bicycle", 11, 11, {"bicycle"}},
      {"bus", 13, 257, {"bus"}},
      {"other-vehicle", 20, 259, {"van"}},
      {"person", 30, 254, {"person"}},
      {"road", 40, 40, {}, {"asphalt"}},
      {"sidewalk", 48, 48, {}, {"paving", "kerb stone"}},
      {"building", 50, 50, {"row house", "house", "shop house", "apartments", "office", "kiosk"}},
      {"fence", 51, 51, {"fence"}},
      {"lane-marking", 60, 60, {}, {"road paint"}},
      {"vegetation", 70, 70, {"broadleaf tree", "poplar", "conifer", "bush", "hedge"}},
      {"terrain", 72, 72, {}, {"grass"}},
      {"pole", 80, 80, {"street lamp", "traffic light", "bollard"}},
      {"traffic-sign", 81, 81, {"sign"}},
      {"other-object", 99, 99, {"bench", "litter bin", "hydrant", "bus stop"}}};
  return kClasses;
}

/// Patterns of the things that the town has, "KIND NUMBER" by name.
Json patternsFor(const Scene& town) {
  Json patterns = Json::object();
  for (const TownClass& category : classes())
    for (const std::string thing : category.things)
      for (const Instance& instance : town.instances)
        if (instance.name.starts_with(thing + " ")) {
          patterns[thing + " *"] = category.name;
          break;
        }
  return patterns;
}

/// The classes of the ground by its materials.
Json materialClasses() {
  Json materials = Json::object();
  for (const TownClass& category : classes())
    for (const char* material : category.materials) materials[material] = category.name;
  return materials;
}

/// The classes of vehicles and people that the patterns name: what stands in the town has boxes, as what moves has.
Json boxedClasses(const Json& patterns) {
  Json boxed = Json::array();
  for (const char* name : {"car", "bicycle", "bus", "other-vehicle", "person"})
    if (std::any_of(patterns.begin(), patterns.end(), [&](const Json& of) { return of == name; }))
      boxed.push_back(name);
  return boxed;
}

Json car(const char* name, const std::string& trajectory, double ahead) {
  return {{"name", name},
          {"model", "car"},
          {"class", "car"},
          {"trajectory", {{"file", trajectory}, {"begin", -ahead}, {"shift", {0, 0, -kSensorHeight}}}},
          {"outside", "gone"}};
}

/// A person who crosses the road where the vehicle is at this pose, and has crossed it a second before. Persons walk
/// upright, on inclined roads, too.
Json person(size_t number, const Pose& pose, double time) {
  constexpr double kWay = 5, kSpeed = 1.4;  // metres to each side, m/s
  const Quaternion& q = pose.orientation;
  const Vec3 left = q * Vec3{0, 1, 0};
  const double side = number % 2 == 0 ? kWay : -kWay, half = kWay / kSpeed;
  const Vec3 middle = pose.position - Vec3{0, 0, kSensorHeight};
  const auto stamp = [&](double at, double along) {
    return Json{{"time", at}, {"position", listOf(middle + along * left)}};
  };
  return {
      {"name", formatted("person-%zu", number)},
      {"model", "person"},
      {"class", "person"},
      {"trajectory", {{"waypoints", {stamp(time - 1 - half, side), stamp(time - 1 + half, -side)}}, {"pitch", false}}}};
}

void writeModel(const Mesh& mesh, const fs::path& file) {
  Scene scene;
  scene.materials = town::townMaterials();
  scene.meshes.push_back(mesh);
  scene.instances.push_back({mesh.name, 0, {}});
  writeGlb(scene, file);
}

fs::path beside(const fs::path& file, const char* ending) {
  return file.parent_path() / (file.stem() += ending);
}

}  // namespace

std::vector<fs::path> townDriveFiles(const fs::path& file) {
  return {file, beside(file, ".tum"), beside(file, "-car.glb"), beside(file, "-person.glb")};
}

std::vector<Pose> steered(std::vector<Pose> poses) {
  constexpr size_t kAround = 8;
  for (int pass = 0; pass < 2; ++pass) {
    const std::vector<Pose> sharp = poses;
    for (size_t i = 0; i < poses.size(); ++i) {
      const size_t around = std::min({kAround, i, poses.size() - 1 - i});
      Vec3 sum;
      for (size_t k = i - around; k <= i + around; ++k) sum = sum + sharp[k].position;
      poses[i].position = (1 / static_cast<double>(2 * around + 1)) * sum;
    }
  }
  std::vector<drive::Trajectory::Stamp> stamps;
  for (const Pose& pose : poses) stamps.push_back({kDriveInterval * static_cast<double>(stamps.size()), pose});
  const std::vector<double> yaws = drive::yawsAlong(stamps);
  for (size_t i = 0; i < poses.size(); ++i) poses[i].orientation = drive::yawPitchRoll(yaws[i], 0, 0);
  return poses;
}

void writeTum(const std::vector<Pose>& poses, const fs::path& file) {
  AtomicFile output(file);
  output.write("# t x y z qx qy qz qw\n");
  for (size_t i = 0; i < poses.size(); ++i) {
    const Vec3& p = poses[i].position;
    const Quaternion& q = poses[i].orientation;
    output.write(formatted("%.1f %.6f %.6f %.6f %.9f %.9f %.9f %.9f\n", kDriveInterval * static_cast<double>(i), p.x,
                           p.y, p.z, q.x, q.y, q.z, q.w));
  }
  output.commit();
}

void writeTownDrive(const Scene& town, const fs::path& townFile, const std::vector<Pose>& poses, const fs::path& file) {
  const std::vector<fs::path> files = townDriveFiles(file);
  const std::string trajectory = files[1].filename().string();
  Json numbers = Json::object(), actors = Json::array();
  for (const TownClass& category : classes())
    numbers[category.name] = {{"id", category.id}, {"moving_id", category.movingId}};
  actors.push_back(car("car-ahead", trajectory, 2));
  actors.push_back(car("car-far-ahead", trajectory, 4));
  actors.push_back(car("car-behind", trajectory, -2));
  for (size_t i = 0; 45 * i + 40 < poses.size(); ++i)
    actors.push_back(person(i, poses[45 * i + 40], kDriveInterval * static_cast<double>(45 * i + 40)));
  Json scene = {{"file", fs::relative(townFile, fs::absolute(file).parent_path()).generic_string()}};
  const Json patterns = patternsFor(town);
  if (!patterns.empty()) scene["instances"] = patterns;
  scene["materials"] = materialClasses();
  if (const Json boxed = boxedClasses(patterns); !boxed.empty()) scene["boxes"] = boxed;
  const Json drive = {
      {"name", "town"},
      {"duration", 10},
      {"classes", numbers},
      {"scenes", {scene}},
      {"models",
       {{"car", {{"file", files[2].filename().string()}}}, {"person", {{"file", files[3].filename().string()}}}}},
      {"actors", actors},
      {"ego", {{"trajectory", {{"file", trajectory}, {"shift", {0, 0, -kSensorHeight}}}}}},
      {"sensors",
       {{{"name", "top"}, {"sensor", "OS1-64:1024x10"}, {"mount", {{"position", {0, 0, kSensorHeight}}}}},
        {{"name", "front"},
         {"sensor", "Puck:10Hz"},
         {"mount", {{"position", {2.2, 0, 0.6}}, {"yaw_pitch_roll_deg", {0, 5, 0}}}}}}},
      {"weather", {{{"time", 8}}, {{"time", 9}, {"rain", 15}}}},
      {"outputs", {{{"format", "semantickitti"}}, {{"format", "boxes"}}, {{"format", "mcap"}}}}};
  AtomicFile out(file);
  out.write(jsonText(drive, 1) + "\n");
  writeTum(poses, files[1]);
  writeModel(town::vehicleMesh({town::VehicleKind::saloon, town::Surface::paintRed, true}), files[2]);
  writeModel(town::personMesh(0, true), files[3]);
  out.commit();
}

}  // namespace gnosphere::cli

// SPDX-License-Identifier: Apache-2.0
// Velodyne calibrations as the driver of ROS, velodyne_decoder and nebula keep them: a map with `lasers`, one map per
// laser in radians and metres.
#include <yaml-cpp/yaml.h>

#include <cmath>
#include <set>
#include <utility>

#include "sensor/files/source.hpp"

namespace gnosphere {
namespace {

const std::set<std::string> kIgnored = {"dist_correction", "dist_correction_x", "dist_correction_y", "focal_distance",
                                        "focal_slope",     "min_intensity",     "max_intensity"};

double numberAt(const SensorSource& source, const YAML::Node& laser, const char* key, bool required) {
  const YAML::Node value = laser[key];
  const std::string line = "line " + std::to_string((value ? value : laser).Mark().line + 1) + ": ";
  if (!value) {
    if (required) source.refuse(line + "'" + key + "' is missing in this laser");
    return 0;
  }
  if (!value.IsScalar()) source.refuse(line + "'" + key + "' is no number");
  return numberOf(source, value.Scalar(), line + "'" + key + "'");
}

void readLasers(SensorSource& source, const YAML::Node& root) {
  if (!root.IsMap() || !root["lasers"] || !root["lasers"].IsSequence())
    source.refuse("has no list 'lasers', as Velodyne calibrations have");
  const YAML::Node list = root["lasers"];
  std::vector<VelodyneLaser> lasers;
  std::vector<bool> seen(list.size());
  std::set<std::string> ignored;
  for (const YAML::Node& entry : list) {
    const std::string line = "line " + std::to_string(entry.Mark().line + 1) + ": ";
    if (!entry.IsMap()) source.refuse(line + "a laser is a map of its corrections");
    const double id = numberAt(source, entry, "laser_id", true);
    if (!(id >= 0 && id < static_cast<double>(seen.size())) || id != std::floor(id))
      source.refuse(line + "'laser_id' is " + entry["laser_id"].Scalar() + ", expected is 0 to " +
                    std::to_string(seen.size() - 1));
    if (seen[static_cast<size_t>(id)])
      source.refuse(line + "there are two lasers with the 'laser_id' " + entry["laser_id"].Scalar());
    seen[static_cast<size_t>(id)] = true;
    lasers.push_back({numberAt(source, entry, "rot_correction", false),
                      numberAt(source, entry, "vert_correction", true),
                      numberAt(source, entry, "vert_offset_correction", false),
                      numberAt(source, entry, "horiz_offset_correction", false)});
    for (const std::string& key : kIgnored)
      if (numberAt(source, entry, key.c_str(), false) != 0) ignored.insert(key);
  }
  if (root["num_lasers"]) {
    const double count = numberAt(source, root, "num_lasers", true);
    if (count != static_cast<double>(lasers.size()))
      source.refuse("'num_lasers' is " + root["num_lasers"].Scalar() + ", but 'lasers' lists " +
                    std::to_string(lasers.size()));
  }
  for (const std::string& key : ignored) source.ignore(key + " of the lasers");
  fromVelodyneLasers(source, std::move(lasers), numberAt(source, root, "distance_resolution", false));
}

}  // namespace

void readVelodyneYaml(SensorSource& source) {
  try {
    readLasers(source, YAML::Load(std::string(source.bytes)));
  } catch (const YAML::Exception& problem) {
    source.refuse(std::string("is not YAML: ") + problem.what());
  }
}

}  // namespace gnosphere

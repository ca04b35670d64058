// SPDX-License-Identifier: Apache-2.0
// Attributes of CARLA's lidars, as the ROS bridge lists them. CARLA's frame is left-handed, y to the right; its lidar
// turns clockwise seen from above, from half its field of view left of the front. Its lasers are numbered from the top.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>

#include "base/json_text.hpp"
#include "base/lasting.hpp"
#include "sensor/carla_lidars.hpp"
#include "sensor/files/source.hpp"

namespace gnosphere {
namespace {

using nlohmann::json;

/// An attribute, which may be written as a text; CARLA's own default if it is missing.
double attribute(SensorSource& source, const json& lidar, const std::string& key, double otherwise) {
  const auto found = lidar.find(key);
  if (found == lidar.end()) {
    source.assume("'" + key + "' " + shownNumber(otherwise) + ", CARLA's default");
    return otherwise;
  }
  if (found->is_string()) return numberOf(source, found->get<std::string>(), "'" + key + "'");
  return numberIn(source, lidar, key);
}

const json& choose(SensorSource& source, const std::vector<const json*>& lidars) {
  for (const json* lidar : lidars)
    if (!source.options.mode.empty() && textIn(*lidar, "id") == source.options.mode) return *lidar;
  const std::string ids = idsOf(lidars);
  if (!source.options.mode.empty()) source.refuse("has no lidar '" + source.options.mode + "', but " + ids);
  if (lidars.size() > 1) source.assume("the first of the lidars " + ids + "; `gnosphere sensors --mode` takes another");
  return *lidars[0];
}

/// Notes what the attributes of a lidar state beyond its beams: those that are effects, and what is ignored.
void noteOthers(SensorSource& source, const json& lidar) {
  static const auto& known =
      lasting(std::set<std::string>{"type", "id", "channels", "points_per_second", "range", "upper_fov", "lower_fov",
                                    "rotation_frequency", "horizontal_fov"});
  std::string read;
  for (const auto& [key, value] : lidar.items()) {
    const auto effect = std::ranges::find(kCarlaParameters, key, &CarlaParameter::attribute);
    const bool isZero = value == json(0.0);
    if (hasCarlaEffects(lidar) && effect != std::end(kCarlaParameters) && (!isZero || effect->zeroIsNews))
      read += (read.empty() ? "" : ", ") + key;
    else if (!known.contains(key) && !isZero)
      source.ignore(key);
  }
  if (!read.empty()) source.ignore(read + ", which `--effects FILE` reads");
}

}  // namespace

void readCarla(SensorSource& source, const json& root) {
  const std::vector<const json*> lidars = carlaLidars(root);
  if (lidars.empty()) source.refuse("describes sensors of CARLA, but no 'sensor.lidar.ray_cast'");
  const json& lidar = choose(source, lidars);
  const double channels = attribute(source, lidar, "channels", 32);
  const double frequency = attribute(source, lidar, "rotation_frequency", 10);
  const double points = attribute(source, lidar, "points_per_second", 56000);
  const double upper = attribute(source, lidar, "upper_fov", 10), lower = attribute(source, lidar, "lower_fov", -30);
  const double horizontal = lidar.contains("horizontal_fov") ? attribute(source, lidar, "horizontal_fov", 360) : 360;
  if (!(channels >= 1 && channels <= 65535) || channels != std::floor(channels))
    source.refuse("'channels' is " + shownNumber(channels) + ", expected is 1 to 65535");
  if (!(frequency > 0)) source.refuse("'rotation_frequency' is " + shownNumber(frequency) + ", expected is above 0");
  const double columns = std::round(points / frequency / channels);
  if (!(columns >= 1 && columns < 1e9))
    source.refuse("'points_per_second' gives " + shownNumber(columns) + " columns in a turn");
  if (!(horizontal > 0 && horizontal <= 360))
    source.refuse("'horizontal_fov' is " + shownNumber(horizontal) + ", expected is above 0, up to 360");

  Sensor& sensor = source.file.sensor;
  sensor.name = textIn(lidar, "id");
  sensor.columns = static_cast<uint32_t>(columns);
  sensor.rotationPeriod = 1 / frequency;
  sensor.azimuthStartDeg = horizontal / 2;
  sensor.azimuthSpanDeg = -horizontal;
  sensor.rangeMax = attribute(source, lidar, "range", 10);
  const double step = channels > 1 ? (upper - lower) / (channels - 1) : 0;
  for (double i = 0; i < channels; ++i) sensor.channels.push_back({upper - i * step});
  noteOthers(source, lidar);
}

}  // namespace gnosphere

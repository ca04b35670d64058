// SPDX-License-Identifier: Apache-2.0
#include "drive/ros.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "base/json_text.hpp"
#include "drive/schedule.hpp"

namespace gnosphere::drive {

std::string topicOf(const RigSensor& sensor, const std::string& what) {
  std::string name = sensor.name;
  std::replace(name.begin(), name.end(), '-', '_');
  return "/" + name + what;
}

std::string mistakeOfNames(const Drive& drive, std::span<const size_t> sensors) {
  std::set<std::string> topics;
  for (const size_t index : sensors) {
    const RigSensor& sensor = drive.sensors[index];
    const std::string named = "the sensor '" + sensor.name + "' ";
    if (std::isdigit(static_cast<unsigned char>(sensor.name[0])))
      return named + "begins with a digit, which topics of ROS 2 must not";
    if (sensor.name == "map" || sensor.name == "base_link")
      return named + "has the name of the frame of the " + (sensor.name == "map" ? "world" : "vehicle");
    if (!topics.insert(topicOf(sensor, "")).second)
      return named + "has the topic of another one, because topics of ROS 2 have _ for -";
  }
  return "";
}

std::string mistakeOfTimes(const Drive& drive) {
  const double first = drive.epoch + drive.start, last = first + drive.duration;
  if (first > -2147483648.0 && last < 2147483647.0) return "";
  return "epoch and start lead to times from " + jsonText(nlohmann::json(first)) + " s to " +
         jsonText(nlohmann::json(last)) + " s, and ROS 2 has 32 bits for seconds";
}

uint64_t posesPerFrame(const Drive& drive) {
  constexpr double kPerSecond = 100, kPerFrame = 10;
  return static_cast<uint64_t>(std::max(kPerFrame, std::ceil(kPerSecond / drive.rate - 1e-6)));
}

std::vector<double> poseTimes(const Drive& drive, uint64_t frame, bool last) {
  const uint64_t count = posesPerFrame(drive), first = frame * count;
  const double rate = drive.rate * static_cast<double>(count), end = last ? endOfScans(drive, frame) : 0;
  std::vector<double> times;
  for (uint64_t i = 0; last ? times.empty() || times.back() < end : i < count; ++i)
    times.push_back(drive.start + static_cast<double>(first + i) / rate);
  return times;
}

}  // namespace gnosphere::drive

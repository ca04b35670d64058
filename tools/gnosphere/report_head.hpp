// SPDX-License-Identifier: Apache-2.0
// The beginning of the outputs of `gnosphere accuracy`, with and without --effects.
#pragma once

#include <string>
#include <vector>

#include "console.hpp"
#include "json.hpp"

namespace gnosphere::cli {

/// All data of an output.
template <class Report>
struct Story {
  std::string sceneFile;
  const Scene& scene;
  const Sensor& sensor;
  const std::vector<Pose>& poses;
  const Report& report;

  std::string posesText() const { return counted(poses.size(), "pose", "poses"); }
};

/// Returns whether a row has times of the device, from its timestamps, beside those of the wall clock.
inline bool stamped(const RowTimes& row) {
  return row.gpuMs.median > 0;
}

/// Median and 10th to 90th percentile: 1.66 (0.83-1.90).
inline std::string ratioText(const Spread& ratio) {
  return formatted("%.2f (%.2f-%.2f)", ratio.median, ratio.p10, ratio.p90);
}

template <class Report>
void sayHead(const Story<Report>& story) {
  const DeviceInfo& device = story.report.device;
  say("scene", story.sceneFile + ": " + grouped(story.scene.placedTriangleCount()) + " triangles");
  say("device", device.name + ", " + device.type + (device.driver.empty() ? "" : ", " + device.driver));
  say("sensor", story.sensor.name + ", " + grouped(story.sensor.beamCount()) + " beams, from " + story.posesText());
}

template <class Report>
Json headJson(const Story<Report>& story) {
  Json json;
  json["command"] = commandLine();
  json["version"] = GNOSPHERE_VERSION;
  json["device"] = toJson(story.report.device);
  json["scene"] = {{"file", story.sceneFile}};
  json["scene"].update(sceneJson(story.scene));
  json["sensor"] = sensorJson(story.sensor);
  for (const Pose& pose : story.poses) json["poses"].push_back(toJson(pose));
  return json;
}

}  // namespace gnosphere::cli

// SPDX-License-Identifier: Apache-2.0
// Output of `gnosphere accuracy --effects`: a table for people, JSON for programs, and a plot.
#pragma once

#include <string>

#include "gnosphere/eval/sub_rays.hpp"
#include "gnosphere/gnosphere.hpp"

namespace gnosphere::cli {

/// All data of the report.
struct SubRaysStory {
  std::string sceneFile;
  const Scene& scene;
  const Sensor& sensor;
  const std::vector<Pose>& poses;
  const SubRayReport& report;
};

void printTables(const SubRaysStory& story);
std::string jsonOf(const SubRaysStory& story);
std::string svgOf(const SubRaysStory& story);

}  // namespace gnosphere::cli

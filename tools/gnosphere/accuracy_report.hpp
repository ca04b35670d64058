// SPDX-License-Identifier: Apache-2.0
// What gnosphere accuracy tells: tables for people, JSON for programs, a plot for both.
#pragma once

#include <string>

#include "gnosphere/gnosphere.hpp"

namespace gnosphere::cli {

/// Everything there is to tell.
struct AccuracyStory {
  std::string sceneFile;
  const Scene& scene;
  const Sensor& sensor;
  const std::vector<Pose>& poses;
  const AccuracyReport& report;
};

void printTables(const AccuracyStory& story);
std::string accuracyJson(const AccuracyStory& story);
std::string accuracySvg(const AccuracyStory& story);

}  // namespace gnosphere::cli

// SPDX-License-Identifier: Apache-2.0
// Output of `gnosphere accuracy`: tables for people, JSON for programs, and a plot.
#pragma once

#include <string>

#include "gnosphere/eval/accuracy.hpp"
#include "gnosphere/gnosphere.hpp"

namespace gnosphere::cli {

/// All data of the report.
struct AccuracyStory {
  std::string sceneFile;
  const Scene& scene;
  const Sensor& sensor;
  const std::vector<Pose>& poses;
  const AccuracyReport& report;
};

void printTables(const AccuracyStory& story);
std::string jsonOf(const AccuracyStory& story);
std::string svgOf(const AccuracyStory& story);

}  // namespace gnosphere::cli

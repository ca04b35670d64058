// SPDX-License-Identifier: Apache-2.0
// The clouds of a folder in the order of time: those of one sensor of a drive's output, or any cloud files.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "view/cloud.hpp"

namespace gnosphere::cli {

struct SeriesFrame {
  uint64_t number = 0;
  std::filesystem::path cloud;
  std::filesystem::path boxes;  ///< a file of the drive's format `boxes`; empty if there is none
};

struct Series {
  std::string name;                         ///< of the drive and its sensor, or of the folder
  std::vector<SeriesFrame> frames;          ///< in the order of their numbers
  std::map<std::string, ValueNames> names;  ///< of classes and instances, by the column that has their numbers
  std::vector<std::string> notes;           ///< what is not shown, and why
};

/// Finds the clouds of the output folder of gnosphere drive, or of a folder with cloud files, whose numbers are their
/// places in the order of their names. `sensor` is the name of a drive's sensor; empty: the first. Throws
/// Error(invalidArgument) that says what can be shown if there is nothing, and Error(format) for a damaged manifest.
Series findSeries(const std::filesystem::path& folder, const std::string& sensor);

}  // namespace gnosphere::cli

// SPDX-License-Identifier: Apache-2.0
// Clouds as gnosphere view shows them: points, and a column of values for each field of the file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "output/cloud_file.hpp"

namespace gnosphere::cli {

using ValueNames = std::map<uint32_t, std::string>;

struct ViewColumn {
  std::string name;
  bool isId = false;           ///< whether values are numbers of things, which have no order, as rings and instances do
  std::vector<double> values;  ///< one per point; NaN: the point has none
  ValueNames names;            ///< of ids; an id may have none
};

struct ViewCloud {
  std::vector<float> points;  ///< x, y, z from `origin`, in metres
  Origin origin = {};
  double floatStep = 0;  ///< CloudTable::floatStep() at the origin
  /// The number of the beam, times 2^32, and of the return of each point; nothing if the file does not tell the beams.
  std::optional<std::vector<uint64_t>> returns;
  std::vector<ViewColumn> columns;
  uint64_t misses = 0;  ///< rows of the file without a finite point, which are left out

  size_t size() const { return points.size() / 3; }
  const ViewColumn* find(const std::string& name) const;
};

/// Throws Error(file), or Error(format) if the file holds no JSON.
nlohmann::json readJson(const std::filesystem::path& file);

/// Reads the names of classes from classes.json, an object {"name": number}, in a folder; none without this file.
/// Throws Error(format) for anything else.
ValueNames classNames(const std::filesystem::path& folder);

/// Reads .pcd, .ply, .npy, .csv, .bin (KITTI: x y z intensity) and .pcd.bin (nuScenes: x y z intensity ring). A .bin
/// file with a file of SemanticKITTI's labels (../labels/NAME.label) has also the class and the instance of each point.
/// The classes have the names of classNames() of the file's folder.
/// Points are from `origin`, or from one near the first point. Throws Error(file), Error(format), or
/// Error(invalidArgument) for an ending that is not known.
ViewCloud readViewCloud(const std::filesystem::path& file, const std::optional<Origin>& origin = {});

/// Returns every n-th point, from the first on, without the numbers of returns.
ViewCloud everyNth(const ViewCloud& cloud, size_t n);

/// Whether both clouds tell the beams of their points.
bool comparesBeams(const ViewCloud& a, const ViewCloud& b);
/// Returns the points of both clouds, which have one origin, with three more columns: the cloud, the kind of
/// difference, and the distance to the point compared with. If both tell their beams, points of one beam (and one
/// return) are compared; otherwise each point is compared with the nearest one of the other cloud. Points further apart
/// than `distance` differ.
ViewCloud differenceOf(const ViewCloud& a, const ViewCloud& b, double distance);

}  // namespace gnosphere::cli

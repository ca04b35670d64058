// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "gnosphere/gnosphere.hpp"

namespace gnosphere::cli {

/// The files of an example drive: NAME.json, NAME.tum, NAME-car.glb and NAME-person.glb for NAME.json.
std::vector<std::filesystem::path> townDriveFiles(const std::filesystem::path& file);

/// Writes an example drive through a town: cars ahead of and behind the vehicle, people who cross the road, and rain
/// towards the end. `route` is that of makeDrive();
/// the vehicle steers through its corners.
void writeTownDrive(const Scene& town, const std::filesystem::path& townFile, const std::vector<Pose>& route,
                    const std::filesystem::path& file);

/// Writes poses as lines of time, position and orientation in the format of the TUM benchmarks.
void writeTum(const std::vector<Pose>& poses, const std::filesystem::path& file);

}  // namespace gnosphere::cli

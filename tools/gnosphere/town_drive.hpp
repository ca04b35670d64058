// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "gnosphere/gnosphere.hpp"

namespace gnosphere::cli {

/// The files of an example drive: NAME.json, NAME.tum, NAME-car.glb and NAME-person.glb for NAME.json.
std::vector<std::filesystem::path> townDriveFiles(const std::filesystem::path& file);

/// Returns the way of a vehicle that steers along the middle of the grid's streets: positions averaged over
/// 1.6 s twice, so that its corners become curves, and level orientations along the way.
std::vector<Pose> steered(std::vector<Pose> poses);

/// Writes an example drive through a town: cars ahead of and behind the vehicle, people who cross the road, and rain
/// towards the end. `poses` is the way of the vehicle and of these cars, 1.8 m above the road.
void writeTownDrive(const Scene& town, const std::filesystem::path& townFile, const std::vector<Pose>& poses,
                    const std::filesystem::path& file);

/// Writes poses as lines of time, position and orientation in the format of the TUM benchmarks.
void writeTum(const std::vector<Pose>& poses, const std::filesystem::path& file);

}  // namespace gnosphere::cli

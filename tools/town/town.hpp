// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "gnosphere/scan.hpp"
#include "gnosphere/scene.hpp"

namespace gnosphere {

inline constexpr uint64_t kSmallestTown = 1'000;  ///< triangles; the crossing at the origin alone has about 500

struct TownOptions {
  uint64_t triangles = 300'000;  ///< placed triangles to aim for, within about 10 %
  uint32_t seed = 1;
  std::filesystem::path xodr;  ///< an OpenDRIVE file; empty: a grid of streets
  /// Told in one line each what is doubtful in the file, and if the triangles do not suffice for all of its roads.
  std::function<void(const std::string&)> warn = {};
  /// Told the header's offset, if the file has one: the town is moved by it.
  std::function<void(const std::string&)> moved = {};
};

/// Makes a procedural town, z up: roads, kerbs, buildings, trees, poles, cars, people. On a grid of streets it has a
/// crossing at the origin, and its ground is at z = 0. Along the roads of an OpenDRIVE file it uses that file's
/// coordinates and has the file's roads first, from the place where makeDrive() begins outwards, then what stands on
/// and between them in the same order, and then a grid of streets around them. From a million triangles on, a larger
/// town has the same centre and more outskirts. The same options give the same bytes on every machine. Throws
/// Error(file) or Error(format) that names the file, the road and the mistake.
Scene makeTown(const TownOptions& options = {});

inline constexpr size_t kDrivePoses = 400;
inline constexpr double kDriveInterval = 0.1;  ///< seconds between two poses

/// A drive through that town: 400 poses, 10 a second at 8 m/s (slower if the roads are too short), 1.8 m above the
/// road, x forward and inclined as the road is. Without traffic, the drive follows the network's linked lanes, or the
/// middle of the grid's streets.
std::vector<Pose> makeDrive(const TownOptions& options = {});

/// Converts instances to unique geometry: meshes for squares of 64 m, each sorted by material, as engines export them.
/// Throws Error(invalidArgument) if that exceeds the size of a .glb file.
Scene bake(const Scene& scene);

}  // namespace gnosphere

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "gnosphere/scan.hpp"
#include "gnosphere/scene.hpp"

namespace gnosphere {

struct TownOptions {
  uint64_t triangles = 300'000;  ///< placed triangles to aim for, within about 10 %
  uint32_t seed = 1;
  std::filesystem::path xodr;  ///< an OpenDRIVE file; empty: a grid of streets
};

/// A procedural town, z up: roads, kerbs, buildings, trees, poles, cars, people. On a grid of streets it has a crossing
/// at the origin and its ground at z = 0. Along the roads of an OpenDRIVE file it stands in that file's frame, begins
/// where makeDrive() does, and once its roads are complete a grid of streets goes on around it. From a million
/// triangles on a larger town has the same neighbourhood and more outskirts. The same options give the same bytes on
/// every machine. Throws Error(file) or Error(format) that names the file, the road and what is wrong with it.
Scene makeTown(const TownOptions& options = {});

inline constexpr size_t kDrivePoses = 400;
inline constexpr double kDriveInterval = 0.1;  ///< seconds between two poses

/// A drive through that town: 400 poses, 10 a second at 8 m/s (slower where the roads end before), 1.8 m above the
/// road, x along it. On the network's lanes by their links; on the grid along the middle of its streets. No traffic in
/// the way.
std::vector<Pose> makeDrive(const TownOptions& options = {});

/// Every instance written out: meshes for squares of 64 m, each sorted by material, as engines export them. Throws
/// Error(invalidArgument) if that is more than a .glb file holds.
Scene bake(const Scene& scene);

}  // namespace gnosphere

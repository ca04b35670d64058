// SPDX-License-Identifier: Apache-2.0
// Clouds of `exact` whose bytes are the same on every device, and the hashes that they must have.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "gnosphere/gnosphere.hpp"

namespace gnosphere::bench {

/// Clouds that one simulator makes: one of each request.
struct GoldenGroup {
  std::vector<std::string> names;
  std::vector<SensorRequest> requests;
};

/// A town of 20,000 triangles with a fence that has holes.
Scene goldenScene();
/// The pose of all golden clouds.
Pose goldenPose();
std::vector<GoldenGroup> goldenGroups();

/// Returns the first 16 digits of the SHA-256 of the points, ranges and owners of a scan and of these of its fields.
std::string hashOf(const Scan& scan, const std::vector<Field>& fields);

struct GoldenCloud {
  std::string name, hash;
  std::string problem = {};  ///< why the device could not make the cloud
};

/// The committed table, which is bench/golden_hashes.inc.
std::span<const GoldenCloud> goldenTable();

/// Scans the golden clouds of these groups. Of the options the accuracy is replaced by `exact`.
std::vector<GoldenCloud> scanGolden(SimulatorOptions options, std::span<const GoldenGroup> groups);

/// Returns a sentence for each cloud that a table has not, or has with another hash, and for each that is missing.
std::vector<std::string> differencesOf(std::span<const GoldenCloud> clouds, std::span<const GoldenCloud> table);

}  // namespace gnosphere::bench

// SPDX-License-Identifier: Apache-2.0
// Why no beam hits anything.
#pragma once

#include <string>

#include "scanning.hpp"

namespace gnosphere::cli {

/// Warns that `nobody`, such as "no beam", hits anything: the scene may have no triangle, their faces may look away,
/// the sensor may be far from the scene, or the scene may have another unit than metres. A scan from the pose finds out
/// whether beams would hit if both faces of every triangle reflected. `trajectory` is the file of the poses, or empty.
void warnOfNoHits(const std::string& nobody, const ScanningOptions& options, const std::string& trajectory,
                  const Scene& scene, const SensorRequest& request, const SimulatorOptions& settings, const Pose& pose);

}  // namespace gnosphere::cli

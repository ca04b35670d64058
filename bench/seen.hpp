// SPDX-License-Identifier: Apache-2.0
// GnoSphere's own floor: how long its scans take of scenes that hold nothing but what is seen.
#pragma once

#include <memory>
#include <vector>

#include "contender.hpp"

namespace gnosphere::bench {

/// The triangles of the scene that own a hit of the scan, each where it was: one mesh per instance that has any.
/// Textures are not taken along.
Scene seenIn(const Scene& scene, const Scan& scan);

/// Name of such a contender.
inline constexpr const char* kSeen = "only what is seen";

/// GnoSphere in a scene of its own for each pose, which holds the triangles that it sees from there. Scans from other
/// poses are refused. The constructor throws Error(device) if the ranges in such a scene are not those in the whole
/// one.
std::unique_ptr<Contender> makeSeen(const Scene& scene, const SensorRequest& request, const SimulatorOptions& options,
                                    const std::vector<Pose>& poses);

}  // namespace gnosphere::bench

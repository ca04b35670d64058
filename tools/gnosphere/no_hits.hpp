// SPDX-License-Identifier: Apache-2.0
// Why no beam returns anything.
#pragma once

#include <string>
#include <vector>

#include "scanning.hpp"

namespace gnosphere::cli {

/// Beams that have no return for one and the same reason.
struct Loss {
  uint64_t beams = 0;
  std::string why;     ///< such as "too weak"
  std::string remedy;  ///< what makes them return something
};

/// Returns the beams that effects lose, by their causes; empty if effects lose none. Dead beams are among them only if
/// all beams are dead, and then they are called masked if the sensor masks all beams.
std::vector<Loss> lossesByEffects(const Counters& counters, bool allMasked);
/// Returns how many beams meet nothing, or nothing but surfaces nearer than the least range: beams without a return
/// that fire and that no effect loses.
uint64_t beamsWithoutSurface(const Counters& counters);
/// Returns text such as "20 of 90 beams too weak, 70 met nothing; REMEDY", with the remedy of the most frequent loss,
/// and with that of the beams that meet nothing if these are more. There must be a loss.
std::string lossText(std::vector<Loss> losses, const Loss& unmet, uint64_t beams);

/// Warns that `nobody`, such as "no beam", returns anything. Effects may have lost the beams, which the counters of the
/// scan tell. Otherwise the scene may have no triangle, its faces may look away, its surfaces may be nearer than the
/// least range, the sensor may be far from the scene, or the scene may have another unit than metres. Scans from the
/// pose find out about faces and near surfaces. `trajectory` is the file of the poses, or empty; with one the counters
/// are those of the scan from its first pose.
void warnOfNoHits(const std::string& nobody, const ScanningOptions& options, const std::string& trajectory,
                  const Scene& scene, const SensorRequest& request, const SimulatorOptions& settings, const Pose& pose,
                  const Counters& counters);

}  // namespace gnosphere::cli

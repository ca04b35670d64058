// SPDX-License-Identifier: Apache-2.0
// Runs GnoSphere and its rivals on the same scene from the same poses: compares their results first, then times them in
// turn.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "contender.hpp"
#include "floor.hpp"
#include "gnosphere/eval/accuracy.hpp"

namespace gnosphere::bench {

/// The input of one contest.
struct Setting {
  std::string label;  ///< label of its rows
  double x = 0;       ///< its x value on a plot
  const Scene& scene;
  Sensor sensor;
  std::vector<Shot> shots;          ///< one per frame, in order
  std::vector<size_t> moving = {};  ///< instances that have moved before each frame
  uint32_t runs = 1;
  bool refereed = true;  ///< whether GnoSphere is compared with the reference, which sees only geometry
  double step = 0.02;    ///< metres between two places of a moving instance
};
std::vector<Shot> shotsFrom(const std::vector<Pose>& poses);

/// How often a contender's result differs from GnoSphere's. Both compute in single precision, so a beam that grazes an
/// edge may differ: those that the reference marks as ties do not count, and a share of up to kAgreement of the beams
/// is accepted.
struct Agreement {
  uint64_t beams = 0;
  uint64_t hits = 0;    ///< one hits and the other misses
  uint64_t ranges = 0;  ///< both hit, with ranges more than 1 mm and 1/10,000 of the range apart
  /// The ranges agree, but the label differs, or the intensity by more than 1/1,000 of it and of full scale.
  uint64_t signals = 0;
  uint64_t differ() const { return hits + ranges + signals; }
  bool good() const;
};
inline constexpr double kAgreement = 1e-4;
/// `reference` is the reference's scan, if it is known.
Agreement agreementOf(const Scan& ours, const Scan& other, const Scan* reference = nullptr);

/// Results of one contender in a contest.
struct Standing {
  std::string name;
  size_t samples = 0;  ///< fewer than runs times frames if the contender took too long
  double buildMs = 0;
  Spread renewMs, scanMs, deviceMs, totalMs;  ///< over all frames and runs; the device's is 0 if it has no clock
  double meanMs = 0;
  double frameVariance = 0;       ///< variance of the frames' means over the runs, in ms^2
  double runVariance = 0;         ///< variance of the runs' means over the frames, in ms^2
  std::vector<StageTime> stages;  ///< medians
  double ratio = 1;               ///< median ratio of its total time to GnoSphere's in the same frame and run
  double leastFrameRatio = 1;     ///< of the frames' own median ratios, the least
  double mostFrameRatio = 1;      ///< and the greatest
  double deviceRatio = 0;         ///< median ratio of the device times; 0 if one has none
  uint64_t memoryBytes = 0;
  Agreement agreement;
  std::optional<Comparison> error;  ///< GnoSphere's from the first pose against the reference, if that was computed
};

struct Outcome {
  std::string label;
  double x = 0;
  Sensor sensor;
  size_t frames = 0, moving = 0, uniqueTriangles = 0, placedTriangles = 0, instances = 0, meshes = 0;
  uint32_t runs = 0;
  std::vector<Standing> standings;  ///< GnoSphere's first
  std::vector<std::string> notes;   ///< contenders that were left out, and why
  uint64_t hits = 0;                ///< in the last frame
  MemoryUse memory;
  Floor floor;  ///< mean over the frames
  double floorShare() const { return floor.ms / standings[0].totalMs.median; }
};

/// The list `contenders` begins with GnoSphere. Throws Error(device) that names a contender whose result is wrong,
/// before anything is timed.
Outcome hold(const Setting& setting, std::vector<std::unique_ptr<Contender>>& contenders, const Rates& rates);

}  // namespace gnosphere::bench

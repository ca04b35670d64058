// SPDX-License-Identifier: Apache-2.0
// Ours and its rivals over the same scene from the same poses: answers compared first, then timed in turn.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "contender.hpp"
#include "floor.hpp"

namespace gnosphere::bench {

/// What one contest is about.
struct Setting {
  std::string label;  ///< of its rows
  double x = 0;       ///< its place on a plot
  const Scene& scene;
  Sensor sensor;
  std::vector<Shot> shots;          ///< of the frames, in order
  std::vector<size_t> moving = {};  ///< instances that have moved before each frame
  uint32_t runs = 1;
  bool refereed = true;  ///< ours is held against the reference, which sees geometry alone
};
std::vector<Shot> shotsFrom(const std::vector<Pose>& poses);

/// How often a contender's answer is another than ours. Both compute in single precision, so a beam that grazes an edge
/// may go either way: up to kAgreement of the beams may.
struct Agreement {
  uint64_t beams = 0;
  uint64_t hits = 0;    ///< one hits and the other does not
  uint64_t ranges = 0;  ///< both hit, more than 1 mm and 1/10,000 of the range apart
  /// The range is the same, and what else both tell is not: the label, or the intensity by more than 1/1,000 of it and
  /// of full scale.
  uint64_t signals = 0;
  uint64_t differ() const { return hits + ranges + signals; }
  bool good() const;
};
inline constexpr double kAgreement = 1e-4;
Agreement agreementOf(const Scan& ours, const Scan& other);

/// A contender's figures.
struct Standing {
  std::string name;
  size_t samples = 0;  ///< a contender that takes too long does not take part in every frame and run
  double buildMs = 0;
  Spread renewMs, scanMs, deviceMs, totalMs;  ///< over all frames and runs; the device's is 0 if it has no clock
  double meanMs = 0;
  double frameVariance = 0;       ///< of the frames' means over the runs, in ms^2
  double runVariance = 0;         ///< of the runs' means over the frames, in ms^2
  std::vector<StageTime> stages;  ///< medians
  double ratio = 1;               ///< its total time to ours: the median of the ratios frame by frame, run by run
  double deviceRatio = 0;         ///< the same of device times; 0 where one has none
  uint64_t memoryBytes = 0;
  Agreement agreement;
  std::optional<Comparison> error;  ///< ours from the first pose, against the reference, if that was affordable
};

struct Outcome {
  std::string label;
  double x = 0;
  Sensor sensor;
  size_t frames = 0, moving = 0, uniqueTriangles = 0, placedTriangles = 0, instances = 0, meshes = 0;
  uint32_t runs = 0;
  std::vector<Standing> standings;  ///< ours first
  std::vector<std::string> notes;   ///< who was left out, and why
  uint64_t hits = 0;                ///< of the last frame
  MemoryUse memory;
  Floor floor;  ///< mean over the frames
  double floorShare() const { return floor.ms / standings[0].totalMs.median; }
};

/// `contenders`: ours first. Throws Error(device) that names the one whose answer is not right, before anything is
/// timed.
Outcome hold(const Setting& setting, std::vector<std::unique_ptr<Contender>>& contenders, const Rates& rates);

}  // namespace gnosphere::bench

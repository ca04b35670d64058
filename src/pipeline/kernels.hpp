// SPDX-License-Identifier: Apache-2.0
// The kernels of a scan and the options that specialise them.
#pragma once

#include <array>
#include <bit>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <vector>

#include "common/effects/bits.h"
#include "common/options.h"

namespace gnosphere {

/// The kernels in the order in which they run, with the names of the shaders. All but the first two belong
/// to a scan.
enum class Kernel : uint32_t {
  fit_clusters,
  place_instances,
  beam_frames,
  project_groups,
  project_clusters,
  project_triangles,
  bin,
  prefix_sum,
  resolve,
  effects_strays,
  effects_footprint,
  effects_panes,
  effects,
  records
};

inline constexpr size_t kKernelCount = static_cast<size_t>(Kernel::records) + 1;

inline const char* nameOf(Kernel kernel) {
  constexpr const char* kNames[] = {
      "fit_clusters", "place_instances", "beam_frames", "project_groups", "project_clusters",  "project_triangles",
      "bin",          "prefix_sum",      "resolve",     "effects_strays", "effects_footprint", "effects_panes",
      "effects",      "records"};
  static_assert(std::size(kNames) == kKernelCount, "every kernel has a name");
  return kNames[static_cast<uint32_t>(kernel)];
}

/// Specialisation constants with the names and in the order of shaders/options.glsl; AZIMUTH_OFFSETS, MOTION,
/// LISTED, MAPPED, ORIGINS, STAGGERED and VIEWS are 0 or 1.
struct Options {
  uint32_t BOUNDS = 0, CULL = 0, INSIDE = 0, RANGE = 0, AZIMUTH_OFFSETS = 0, FACES = 0, BINNING = 0, PASS = 0;
  uint32_t CULLING = 0, EFFECTS = 0, FIELDS = 0, LAYERS = 1, RETURNS = 1, MOTION = 0, LISTED = 0, MAPPED = 0;
  uint32_t RAYS = 1;
  uint32_t RECORDS = 0;
  uint32_t DEFORMED = 0;
  uint32_t ORIGINS = 0, STAGGERED = 0;
  uint32_t VIEWS = 0;
  uint32_t SPREAD_RAYS = 0;

  auto operator<=>(const Options&) const = default;
};

using OptionWords = std::array<uint32_t, sizeof(Options) / sizeof(uint32_t)>;
inline OptionWords wordsOf(const Options& options) {
  return std::bit_cast<OptionWords>(options);
}
/// Returns the options of a pipeline by its Plan::Pipeline::constants.
inline Options optionsOf(const std::vector<uint32_t>& constants) {
  OptionWords words = {};
  for (size_t i = 0; i < words.size(); ++i) words[i] = constants.at(i);
  return std::bit_cast<Options>(words);
}

/// Returns whether a scan computes a frame for each beam: BEAM_FRAMES of shaders/seen.glsl.
constexpr bool usesBeamFrames(const Options& options) {
  return options.MOTION != 0 && (options.STAGGERED != 0 || options.LISTED != 0) &&
         options.INSIDE == gpu::kInsideWatertight && options.RANGE == gpu::kRangeEdgeWeights;
}

/// Returns RAYS for a number of sub-rays. There are few sizes, so that footprints of all sizes share pipelines.
constexpr uint32_t placesFor(uint32_t subRays) {
  return subRays <= 1 ? 1 : subRays <= 7 ? 7 : subRays <= 19 ? 19 : 61;
}

/// A kernel as it is compiled.
struct Variant {
  Kernel kernel = Kernel::project_groups;
  Options options;
  bool float64 = false;  ///< true if exact tests use double precision before integers

  auto operator<=>(const Variant&) const = default;
};

}  // namespace gnosphere

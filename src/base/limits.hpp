// SPDX-License-Identifier: Apache-2.0
// The limits of the library: what is checked when a scene or a sensor is given, and what a device drops and counts.
// docs/limits.md has this table; a test compares.
#pragma once

#include <cstdint>
#include <string>

#include "gnosphere/error.hpp"

namespace gnosphere {

struct Limit {
  const char* what;  ///< with its unit, as it stands after a number
  uint64_t most;
  const char* beyond;  ///< what happens beyond it, and why there is a limit

  bool holds(double value) const { return value <= static_cast<double>(most); }  ///< false for NaN
  /// Throws Error(invalidArgument) "WHOSE VERB COUNT ...; the limit is ...", if that is too many.
  void check(uint64_t count, const std::string& whoseVerb) const {
    if (count > most)
      throw Error(ErrorCode::invalidArgument,
                  whoseVerb + " " + std::to_string(count) + " " + what + "; the limit is " + std::to_string(most));
  }
};

namespace limits {

inline constexpr uint64_t kMostNumber = 0x7fffffff;  // kernels have numbers of 31 bits

inline constexpr Limit kChannels = {"channels", 65535, "The sensor is refused: rows of beams have numbers of 16 bits."};
inline constexpr Limit kColumns = {
    "columns", 1 << 25,
    "The sensor is refused: directions are floats, and neighbouring columns might have the same one."};
inline constexpr Limit kBeams = {"beams of a sensor", kMostNumber, "The sensor is refused: beams have 31-bit numbers."};
inline constexpr Limit kReturns = {"returns per beam", 15, "The sensor, or the effect `returns`, is refused."};
inline constexpr Limit kOrigin = {"m from the sensor's origin to a channel's", 1,
                                  "The sensor is refused; a list of beams may have origins farther away."};
inline constexpr Limit kListedOrigin = {"m from the sensor's origin to that of a beam in a list", 1000,
                                        "The sensor is refused; heads farther apart are sensors of their own."};
inline constexpr Limit kSeconds = {"s of a rotation, or from the start of a scan to a beam", 10,
                                   "The sensor is refused."};
inline constexpr Limit kDivergence = {"mrad of divergence", 100,
                                      "The sensor is refused: a footprint is taken as flat."};
/// The end of a refusal of a divergence beyond the limit: the reason and the way out.
inline constexpr const char* kWiderBeam =
    "; a footprint is taken as flat, so a wider beam is a list of several: docs/limits.md";
inline constexpr Limit kTriangles = {"triangles", kMostNumber,
                                     "The scene, or the instance that is added, is refused: all placed triangles are "
                                     "numbered through, in 31 bits. Each instance counts."};
inline constexpr Limit kJoints = {"joints", 65536, "The mesh is refused: joints have numbers of 16 bits."};
inline constexpr Limit kInfluences = {"influences per vertex", 16,
                                      "The mesh is refused: the joints of a cluster have numbers of 11 bits."};
inline constexpr Limit kCoordinate = {
    "units of its file from the origin of its mesh to a vertex", 1'000'000'000,
    "The vertex's triangles are dropped, as those with NaN are; `Counters::nonFinite` counts them. The unit is the "
    "metre unless `--scale` states another one, so floats in millimetres end at 1,000 km: give them in metres, or as "
    "OBJ."};
inline constexpr Limit kPlaced = {
    "m from the sensor to a vertex, along an axis of the sensor", 1'000'000'000,
    "Its triangles are dropped; `Counters::nonFinite` counts them, unless what is out of range is left out before."};
inline constexpr Limit kCondition = {
    "for the condition `c` ([accuracy.md](accuracy.md#the-error-bound-of-standard)) of an instance's transform", 1000,
    "The instance is scanned, but the error bounds of `standard` and `exact` do not hold for it; "
    "`SimulatorOptions::warn` names those of a new simulator."};
inline constexpr Limit kSubRays = {"sub-rays per beam on a device", 61,
                                   "The request is refused; the reference takes up to 1,261."};
inline constexpr Limit kLayers = {"surfaces that a sub-ray passes or hits", 4,
                                  "What lies behind them is not seen; `Counters::lostEchoes` counts the echoes."};
inline constexpr Limit kEchoes = {
    "echoes per beam, 6 if it has at most 3 returns", 16,
    "The weakest ones between the nearest and the farthest are dropped; `Counters::lostEchoes` "
    "counts them."};
inline constexpr Limit kFrames = {"frames of a recorder, or batches of a stream, in flight", 16,
                                  "The recorder, or the stream, is refused."};
inline constexpr Limit kEntries = {
    "entries of an array on a device", kMostNumber,
    "The call that needs them throws Error(outOfMemory), which names the array; the simulator stays usable."};

inline constexpr const Limit* kAll[] = {&kChannels,     &kColumns,    &kBeams,      &kReturns,   &kOrigin,
                                        &kListedOrigin, &kSeconds,    &kDivergence, &kTriangles, &kJoints,
                                        &kInfluences,   &kCoordinate, &kPlaced,     &kCondition, &kSubRays,
                                        &kLayers,       &kEchoes,     &kFrames,     &kEntries};

}  // namespace limits
}  // namespace gnosphere

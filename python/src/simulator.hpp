// SPDX-License-Identifier: Apache-2.0
// A Simulator as Python holds it, and the shots of a batch as Python writes them.
#pragma once

#include <vector>

#include "arrays.hpp"
#include "options.hpp"
#include "whole.hpp"

namespace gnosphere::python {

/// A Simulator with the Python functions that it calls.
class SimulatorWithFunctions {
 public:
  SimulatorWithFunctions(const Scene& scene, const std::vector<SensorRequest>& sensors, const SimulatorOptions& options)
      : simulator_(scene, sensors, options), functions_(functionsOf(options)) {}

  /// The Python functions of the options with which it was made, which must belong to it alone; see ownFunctions().
  const std::vector<Warn>& functions() const { return functions_; }

  /// Calls work(simulator) without the GIL.
  template <typename Work>
  auto use(Work&& work) {
    const ReleasedGil released;
    return work(simulator_);
  }

 private:
  Simulator simulator_;
  std::vector<Warn> functions_;
};

/// Shots, or their poses: a sequence of either, or an array of shape (n, 7), (n, 4, 4) or (n, 3, 4).
using ShotsLike = SequenceOrArray<Shot, Pose>;
/// One number for all, or one for each.
using NumbersLike = std::variant<uint32_t, ArrayLike>;

/// A list of indices for each of several, as an array of shape (n, m) or a sequence of n arrays; none if it is empty.
using IndexListsLike = SequenceOrArray<ArrayLike>;

/// The arguments that complete poses to shots. Frame numbers count up from the first one.
struct PoseArguments {
  const Whole& sensor;
  const NumbersLike& worlds;
  const Whole& firstFrame;
  const IndexListsLike& ignoredInstances;
};

/// Completes poses; shots have their own sensors and so on. Throws Error(invalidArgument), or a TypeError, that begins
/// with `name`.
std::vector<Shot> shotsOf(const ShotsLike& given, const PoseArguments& arguments, const std::string& name);

}  // namespace gnosphere::python

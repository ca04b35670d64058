// SPDX-License-Identifier: Apache-2.0
// A Simulator as Python holds it, and the shots of a batch as Python writes them.
#pragma once

#include <atomic>
#include <vector>

#include "arrays.hpp"
#include "base/maker_process.hpp"
#include "options.hpp"
#include "whole.hpp"

namespace gnosphere::python {

/// A Simulator that refuses a second thread, calls from within its own calls while it is at work, and processes that
/// were forked since it was made, in which the threads of its driver are not.
class SimulatorOfOneThread {
 public:
  SimulatorOfOneThread(const Scene& scene, const std::vector<SensorRequest>& sensors, const SimulatorOptions& options)
      : simulator_(scene, sensors, options), functions_(functionsOf(options)) {}

  /// The Python functions of the options with which it was made, which must belong to it alone; see ownFunctions().
  const std::vector<Warn>& functions() const { return functions_; }

  /// Calls work(simulator) without the GIL.
  template <typename Work>
  auto use(Work&& work) {
    maker_.check();
    if (busy_.exchange(true))
      refuse(
          "the simulator is at work: one thread at a time may use it, and the function given to scan_all() may not; "
          "make a simulator for each thread");
    struct Release {
      std::atomic<bool>& busy;
      ~Release() { busy = false; }
    } const release{busy_};
    const ReleasedGil released;
    return work(simulator_);
  }

 private:
  const MakerProcess maker_;
  Simulator simulator_;
  std::vector<Warn> functions_;
  std::atomic<bool> busy_ = false;
};

/// Shots, or their poses: a sequence of either, or an array of shape (n, 7), (n, 4, 4) or (n, 3, 4).
using ShotsLike = SequenceOrArray<Shot, Pose>;
/// One number for all, or one for each.
using NumbersLike = std::variant<uint32_t, ArrayLike>;

/// Completes poses with a sensor, worlds and frame numbers that count up from `frame`; shots have their own. Throws
/// Error(invalidArgument), or a TypeError, that begins with `name`.
std::vector<Shot> shotsOf(const ShotsLike& given, const Whole& ofSensor, const NumbersLike& worlds,
                          const Whole& firstFrame, const std::string& name);

}  // namespace gnosphere::python

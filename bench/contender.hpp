// SPDX-License-Identifier: Apache-2.0
// A common interface for GnoSphere, the paper's method and the rivals, so that a contest treats them alike.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "gnosphere/gnosphere.hpp"
#include "rivals/rival.hpp"

namespace gnosphere::bench {

/// One scan of a contest: the instances that have moved since the previous scan, and the pose.
struct Task {
  const Shot& shot;
  std::span<const Moved> moved;
};

/// Times of a task in milliseconds. `deviceMs` is 0 if the device has no clock.
struct Sample {
  double renewMs = 0;  ///< time to apply the movements
  double scanMs = 0;   ///< time until the results are on the host
  double deviceMs = 0;
  std::vector<StageTime> stages;
  double totalMs() const { return renewMs + scanMs; }
};

class Contender {
 public:
  virtual ~Contender() = default;
  virtual std::string name() const = 0;
  /// Does the work needed once before the first task; returns milliseconds.
  virtual double build() = 0;
  virtual Sample run(const Task& task) = 0;
  /// Results of the last task. Only GnoSphere's have points and counters.
  virtual const Scan& answer() const = 0;
  virtual uint64_t memoryBytes() const = 0;
  /// Whether its results must agree with GnoSphere's and the reference.
  virtual bool judged() const { return true; }
};

/// Makes the contender GnoSphere itself. With `options.accuracy` = paper it is the paper's method, which is not judged.
/// By default the name is that of the accuracy.
std::unique_ptr<Contender> makeOurs(const Scene& scene, const SensorRequest& request, const SimulatorOptions& options,
                                    const std::string& name = "");
/// Returns the simulator of a contender made by makeOurs().
const Simulator& simulatorOf(const Contender& ours);

/// `anew`: it is built from scratch for every task that moves anything, instead of updated.
std::unique_ptr<Contender> makeGuest(std::unique_ptr<Rival> rival, const Sensor& sensor, bool anew = false);

}  // namespace gnosphere::bench

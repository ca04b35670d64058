// SPDX-License-Identifier: Apache-2.0
// Ours, the paper's way and the rivals behind one interface, so that a contest treats them alike.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "gnosphere/gnosphere.hpp"
#include "rivals/rival.hpp"

namespace gnosphere::bench {

/// One scan of a contest: what has moved since the one before, and from where to look.
struct Task {
  const Shot& shot;
  std::span<const Moved> moved;
};

/// What a task took, in milliseconds. `deviceMs` is 0 where the device has no clock.
struct Sample {
  double renewMs = 0;  ///< to take in what has moved
  double scanMs = 0;   ///< to have the results on the host
  double deviceMs = 0;
  std::vector<StageTime> stages;
  double totalMs() const { return renewMs + scanMs; }
};

class Contender {
 public:
  virtual ~Contender() = default;
  virtual std::string name() const = 0;
  /// What has to be done once, before the first task; milliseconds.
  virtual double build() = 0;
  virtual Sample run(const Task& task) = 0;
  /// Of the last task. Points and counters are there only if they are ours.
  virtual const Scan& answer() const = 0;
  virtual uint64_t memoryBytes() const = 0;
  /// Whether its answers have to agree with ours and the reference.
  virtual bool judged() const { return true; }
};

/// GnoSphere itself. `options.accuracy` of paper is the paper's way, which is not judged. Its name is that of the
/// accuracy unless it is given another.
std::unique_ptr<Contender> makeOurs(const Scene& scene, const SensorRequest& request, const SimulatorOptions& options,
                                    const std::string& name = "");
/// The device it runs on.
const Simulator& simulatorOf(const Contender& ours);

/// `anew`: for every task that moves anything it is built from scratch, instead of updated.
std::unique_ptr<Contender> makeGuest(std::unique_ptr<Rival> rival, const Sensor& sensor, bool anew = false);

}  // namespace gnosphere::bench

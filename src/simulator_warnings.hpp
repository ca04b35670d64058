// SPDX-License-Identifier: Apache-2.0
// The warnings that a simulator gives to SimulatorOptions::warn.
#pragma once

#include <set>
#include <string>
#include <utility>

#include "effects/sensor_plan.hpp"
#include "gnosphere/simulator.hpp"

namespace gnosphere {

class SimulatorWarnings {
 public:
  /// The options must live as long as this object.
  explicit SimulatorWarnings(const SimulatorOptions& options) : options_(options) {}

  /// Tells which rows of the material table have no effect, and which instances are sheared beyond what the error
  /// bounds of the accuracies allow.
  void tellScene(const Scene& scene) const;
  /// Tells of a new sensor that it has no beams, which effects are called for, but not with this accuracy or device, or
  /// not without an intensity, and that the detection of returns rests on colours, because the material table has the
  /// reflectances at the other wavelength alone.
  void tellPlan(const SensorPlan& plan) const;
  /// Tells once per sensor and effect that its scans leave out the motion that a shot brings, unless the request turned
  /// the effect off.
  void tellLeftOut(const Shot& shot, const SensorPlan& plan);
  /// Tells once per sensor that beams which pass panes lose many echoes, at least one per hundred beams, because they
  /// meet more surfaces than a beam sees.
  void tellLostEchoes(size_t sensor, const SensorPlan& plan, const Counters& counters);
  /// Another sensor may get the index of a removed one.
  void forget(size_t sensor);

 private:
  void tellUnusedRows(const Scene& scene) const;
  void tellShears(const Scene& scene) const;

  const SimulatorOptions& options_;
  std::set<std::pair<size_t, std::string>> told_;  // sensors, and effects of which each is told once
};

}  // namespace gnosphere

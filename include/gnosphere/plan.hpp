// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "gnosphere/effects.hpp"
#include "gnosphere/export.hpp"

namespace gnosphere {

/// Describes what a scan of one sensor computes, or several scans together, and why. An effect, field or buffer that is
/// not listed costs nothing.
struct Plan {
  struct Decision {
    std::string effect;  ///< one of effectNames()
    EffectUse request = EffectUse::automatic;
    bool in = false;     ///< true if scans simulate the effect
    std::string reason;  ///< for example "the sensor states 3.0 x 1.5 mrad"
    /// True if the effect is called for, but the accuracy or the device cannot simulate it, or the intensity that it
    /// needs is off.
    bool leftOut = false;
  };
  /// A number that the driver's compiler reports of a pipeline, with the name that the driver gives it.
  struct Statistic {
    std::string name;
    double value = 0;
  };
  struct Pipeline {
    std::string name;                 ///< name of the shader
    std::vector<uint32_t> constants;  ///< specialisation constants in the order of shaders/options.glsl
    /// The rest is known with SimulatorOptions::compileOnly. `statistics` is empty if the driver reports nothing.
    uint32_t subgroupSize = 0;  ///< lanes; 0 if it is not known
    double compileMs = 0;       ///< how long the driver took
    std::vector<Statistic> statistics = {};
  };
  struct Stage {
    std::string name;                 ///< project, bin, resolve, effects, records
    uint32_t dispatches = 0;          ///< largest number of dispatches in one submission
    std::vector<Pipeline> pipelines;  ///< empty if the host computes the stage
  };
  struct Buffer {
    std::string name;
    uint64_t bytes = 0;
  };

  /// Commands that the device executes for one submission: the largest number of each.
  struct Commands {
    uint32_t dispatches = 0, fills = 0, copies = 0, barriers = 0;
    uint32_t all() const { return dispatches + fills + copies + barriers; }
  };

  std::vector<Decision> effects;    ///< one per effect, in the order of effectNames()
  std::vector<std::string> fields;  ///< fields beyond point, range and owner (triangle and instance)
  std::vector<Stage> stages;
  std::vector<Buffer> buffers;  ///< buffers of this sensor on the device
  Commands commands;            ///< all 0 if the host makes the scans
  std::string binning;          ///< nearest, lists or slabs
  uint32_t returns = 1;         ///< returns per beam
  /// Number of scans that one submission makes together, each as a view of its own: as many as were asked for, or
  /// fewer if not so many fit, or 1 if scans of the sensor are made one by one.
  uint32_t views = 1;

  GNOSPHERE_API uint64_t bytes() const;       ///< sum over `buffers`
  GNOSPHERE_API uint32_t dispatches() const;  ///< sum over `stages`
  /// Whether scans simulate the effect, one of effectNames(); false for any other text.
  GNOSPHERE_API bool has(const std::string& effect) const;
};

/// Writes a plan as JSON: the members above, and the sums bytes() and dispatches().
GNOSPHERE_API std::string toJson(const Plan& plan);

}  // namespace gnosphere

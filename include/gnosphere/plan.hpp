// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "gnosphere/effects.hpp"
#include "gnosphere/export.hpp"

namespace gnosphere {

/// What a scan of one sensor is made of, and why. What is not in here costs nothing.
struct Plan {
  struct Decision {
    std::string effect;  ///< of effectNames()
    Use request = Use::automatic;
    bool in = false;
    std::string reason;  ///< "the sensor states 3.0 x 1.5 mrad"
  };
  struct Pipeline {
    std::string name;                 ///< of the shader
    std::vector<uint32_t> constants;  ///< its specialisation, in the order of shaders/options.glsl
  };
  struct Stage {
    std::string name;                 ///< project, bin, resolve, effects
    uint32_t dispatches = 0;          ///< of one scan of everything, at most
    std::vector<Pipeline> pipelines;  ///< none: the host does it
  };
  struct Buffer {
    std::string name;
    uint64_t bytes = 0;
  };

  std::vector<Decision> effects;    ///< every one, in the order of effectNames()
  std::vector<std::string> fields;  ///< beyond point, range and owner
  std::vector<Stage> stages;
  std::vector<Buffer> buffers;  ///< on the device, of this sensor
  std::string binning;          ///< nearest, lists or slabs
  uint32_t returns = 1;         ///< per beam

  GNOSPHERE_API uint64_t bytes() const;
  GNOSPHERE_API uint32_t dispatches() const;
  GNOSPHERE_API bool has(const std::string& effect) const;
};

/// JSON with the members above and their sums.
GNOSPHERE_API std::string toJson(const Plan& plan);

}  // namespace gnosphere

// SPDX-License-Identifier: Apache-2.0
// Evaluates the device's formulas for one beam on the host.
#pragma once

#include <span>

#include "common/effects/detection.h"
#include "common/effects/intensity.h"
#include "common/effects/noise.h"
#include "common/effects/returns.h"
#include "common/effects/weather.h"

namespace gnosphere::gpu {

/// Set the spans and call signalsOf(parameters, beam, direction, echoes.size(), count).
struct BeamSignal {
  uint EFFECTS = 0;                    ///< bits of effects/bits.h
  std::span<const Echo> echoes;        ///< of the beam, in order of range
  std::span<Return> returns;           ///< output: EffectParameters::returnsPerBeam of them
  std::span<const VolumeBox> volumes;  ///< of the scan
  std::span<const uint> deadBeams;     ///< bit mask: 32 beams per word

  Echo loadEcho(uint k) const { return echoes[k]; }
  void storeReturn(uint j, const Return& value) const { returns[j] = value; }
  VolumeBox loadVolume(uint i) const { return volumes[i]; }
  bool isDead(uint beam) const { return (deadBeams[beam / 32] >> beam % 32 & 1) != 0; }

  static constexpr uint MOST_ECHOES = kFewEchoes;
#define RETURNS uint(returns.size())
#include "common/effects/signal.h"
#undef RETURNS
};

}  // namespace gnosphere::gpu

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "gnosphere/scene.hpp"

namespace gnosphere {

struct TownOptions {
  uint64_t triangles = 300'000;  ///< placed triangles to aim for, within about 10 %
  uint32_t seed = 1;
};

/// A procedural town around the origin, z up, ground at z = 0, a street crossing at the origin: roads, kerbs,
/// buildings, trees, poles and cars. The same options give the same bytes on every machine.
Scene makeTown(const TownOptions& options = {});

}  // namespace gnosphere

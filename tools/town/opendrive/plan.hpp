// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "town/opendrive/drive.hpp"
#include "town/plan.hpp"

namespace gnosphere::town::opendrive {

/// The land that a network needs, a margin for houses and gardens included.
Area landOf(const Network& network);

/// Roads, junctions, the ground between them, and what stands along them. Things near the start of the drive come
/// first, and its lanes are free of traffic.
Plan planNetwork(const Network& network, const Area& land, const Drive& drive, uint32_t seed, const Detail& detail);

}  // namespace gnosphere::town::opendrive

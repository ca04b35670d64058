// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "town/opendrive/drive.hpp"
#include "town/plan.hpp"

namespace gnosphere::town::opendrive {

/// Returns the area that a network needs, with a margin for houses and gardens.
Area landOf(const Network& network);

/// Plans roads, junctions, the ground between them, and the objects beside them. Objects near the start of the drive
/// come first, and the lanes of the drive are free of traffic.
Plan planNetwork(const Network& network, const Area& land, const Drive& drive, uint32_t seed, const Detail& detail);

}  // namespace gnosphere::town::opendrive

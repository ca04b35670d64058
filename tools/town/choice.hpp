// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "town/plan.hpp"

namespace gnosphere::town {

// Random choices shared by the streets of the grid and the roads of a network.

/// The width in metres of a building of a row.
int anyRowWidth(Dice& dice);
Building anyRowBuilding(Dice& dice, int width, int depth, bool corner);
Building anyHouse(Dice& dice);
Surface anyWall(Dice& dice);
Tree anyTree(Dice& dice, const Detail& detail);
Vehicle anyCar(Dice& dice, bool fine);

}  // namespace gnosphere::town

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "town/building.hpp"

namespace gnosphere::town {

// Each function takes the upper edge of the walls (counter-clockwise from above) and closes the building above it.

void addFlatRoof(MeshBuilder& builder, const Building& building, const Loop& eaves);  ///< has a parapet
void addGableRoof(MeshBuilder& builder, const Building& building, const Loop& eaves);
void addHipRoof(MeshBuilder& builder, const Building& building, const Loop& eaves);

}  // namespace gnosphere::town

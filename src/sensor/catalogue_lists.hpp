// SPDX-License-Identifier: Apache-2.0
// Real heads whose beams lie on no grid.
#pragma once

#include <string>
#include <vector>

#include "gnosphere/sensor.hpp"

namespace gnosphere {

/// Returns what the catalogue says of these heads. Each head has one mode.
std::vector<CatalogueHead> listHeads();

/// Returns the sensor of the head with this name of listHeads(), without its name.
Sensor listHead(const std::string& name);

}  // namespace gnosphere

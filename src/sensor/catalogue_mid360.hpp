// SPDX-License-Identifier: Apache-2.0
// The built-in model of a head with four lasers and a pattern that does not repeat, the Livox Mid-360.
#pragma once

#include "gnosphere/sensor.hpp"

namespace gnosphere {

CatalogueHead mid360Head();
/// Returns its sensor, without its name.
Sensor mid360Sensor();

}  // namespace gnosphere

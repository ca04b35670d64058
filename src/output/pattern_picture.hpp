// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "gnosphere/sensor.hpp"

namespace gnosphere {

/// Draws the beams of a sensor that fire in its first scan, by azimuth and elevation, as a PNG picture. Colours tell
/// when they fire. Throws Error(file) if the picture cannot be written.
void writePatternPicture(const Sensor& sensor, const std::filesystem::path& file);

}  // namespace gnosphere

// SPDX-License-Identifier: Apache-2.0
// Direction and firing time of each beam of a sensor, in double precision, for files, plots and comparisons. Beams are
// numbered channel by channel.
#pragma once

#include "gnosphere/sensor.hpp"

namespace gnosphere {

/// Seconds between the start of the scan and the moment when the beam fires.
double timeOf(const Sensor& sensor, size_t beam);
/// Azimuth in radians from -pi to pi, counter-clockwise from x.
double azimuthOf(const Sensor& sensor, size_t beam);
/// Elevation in radians above the horizon.
double elevationOf(const Sensor& sensor, size_t beam);

}  // namespace gnosphere

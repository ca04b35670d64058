// SPDX-License-Identifier: Apache-2.0
// Where each beam of a sensor points and when it fires, in double precision: for files, plots and comparisons. Beams
// are numbered channel by channel.
#pragma once

#include "gnosphere/sensor.hpp"

namespace gnosphere {

/// Seconds after the start of the scan at which a beam of the sensor fires.
double timeOf(const Sensor& sensor, size_t beam);
/// Radians from -pi to pi, counter-clockwise from x.
double azimuthOf(const Sensor& sensor, size_t beam);
/// Radians above the horizon.
double elevationOf(const Sensor& sensor, size_t beam);

}  // namespace gnosphere

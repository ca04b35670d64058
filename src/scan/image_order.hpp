// SPDX-License-Identifier: Apache-2.0
// How the rows and columns of a scan lie in an image of what the sensor sees.
#pragma once

#include "gnosphere/scan.hpp"
#include "gnosphere/sensor.hpp"

namespace gnosphere {

/// The values of Scan::firstRowOnTop and Scan::firstColumnOnLeft.
struct ImageOrder {
  bool firstRowOnTop = false, firstColumnOnLeft = false;
};

/// Returns the order of a sensor's beams, of a list in its first pattern. The first row is on top if the beams of later
/// rows point lower, by the sign of the covariance of row and height; the first column is on the left if twice as
/// many beams point further right than those of the column before as point further left, as with a head that turns
/// clockwise.
ImageOrder imageOrderOf(const Sensor& sensor);
/// Returns the order of the first points of the scan's beams in the same way, as far as beams have points.
ImageOrder imageOrderOf(const Scan& scan);

}  // namespace gnosphere

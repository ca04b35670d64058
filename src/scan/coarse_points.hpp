// SPDX-License-Identifier: Apache-2.0
// Points far from the origin of the world, where single precision has steps.
#pragma once

#include <string>

#include "gnosphere/scan.hpp"

namespace gnosphere {

/// Returns a sentence about the steps of the points of a scan in the world frame, as "points in the world frame are in
/// single precision, which has steps of 0.5 m at 6000012 m". The text is empty if the steps are at most a millimetre.
std::string coarsePoints(const Scan& world);

}  // namespace gnosphere

// SPDX-License-Identifier: Apache-2.0
// Poses as the command line takes and shows them.
#pragma once

#include <string>

#include "gnosphere/scan.hpp"

namespace gnosphere::cli {

/// Reads X,Y,Z; then QX,QY,QZ,QW or words such as yaw=90 in degrees may follow. Throws Error(invalidArgument) that
/// names
/// --pose.
Pose parsePose(const std::string& text);

/// Returns text such as "turned by roll 180, pitch 0, yaw 0 degrees"; empty for an orientation that is no turn.
std::string turnText(const Quaternion& orientation);

}  // namespace gnosphere::cli

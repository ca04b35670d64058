// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "gnosphere/output.hpp"

namespace gnosphere {

/// Returns the bytes of the file that writeCloud() writes, for an ending such as "pcd"; throws as writeCloud() does.
std::string cloudBytes(const Scan& scan, const std::string& ending, const CloudOptions& options);

/// Returns the layout of KITTI's .bin files: x, y, z and intensity of each return as four floats. A scan without the
/// field leaves the intensity at 0.
RecordLayout kittiLayout(const Scan& scan);

}  // namespace gnosphere

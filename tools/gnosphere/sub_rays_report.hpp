// SPDX-License-Identifier: Apache-2.0
// Output of `gnosphere accuracy --effects`: a table for people, JSON for programs, and a plot.
#pragma once

#include <string>

#include "gnosphere/eval/sub_rays.hpp"
#include "report_head.hpp"

namespace gnosphere::cli {

using SubRaysStory = Story<SubRayReport>;

void printTables(const SubRaysStory& story);
std::string jsonOf(const SubRaysStory& story);
std::string svgOf(const SubRaysStory& story);

}  // namespace gnosphere::cli

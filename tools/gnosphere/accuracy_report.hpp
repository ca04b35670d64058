// SPDX-License-Identifier: Apache-2.0
// Output of `gnosphere accuracy`: tables for people, JSON for programs, and a plot.
#pragma once

#include <string>

#include "gnosphere/eval/accuracy.hpp"
#include "report_head.hpp"

namespace gnosphere::cli {

using AccuracyStory = Story<AccuracyReport>;

void printTables(const AccuracyStory& story);
std::string jsonOf(const AccuracyStory& story);
std::string svgOf(const AccuracyStory& story);

}  // namespace gnosphere::cli

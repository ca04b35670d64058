// SPDX-License-Identifier: Apache-2.0
// The table of cases.
#pragma once

#include "report.hpp"
#include "session.hpp"

namespace gnosphere::bench {

Report accuracy(Session& session);
Report table3(Session& session);
Report table4(Session& session);
Report table5(Session& session);
Report figure5(Session& session);
Report figure6Range(Session& session);
Report figure6Towns(Session& session);
Report figure7(Session& session);
Report dynamic(Session& session);
Report scalingTriangles(Session& session);
Report scalingRays(Session& session);
Report effects(Session& session);
Report correctness(Session& session);

struct Case {
  const char* name;
  const char* description;
  Defaults defaults;
  Report (*run)(Session&);
};

inline constexpr Case kCases[] = {
    {"accuracy", "What each accuracy costs and gets wrong", {1'000'000, 20, 4}, accuracy},
    {"table3", "A drive with the HDL-64E: mean and variances (the paper's Table 3)", {1'000'000, 5, 60}, table3},
    {"table4", "The two hypothetical sensors (its Table 4)", {1'000'000, 3, 6}, table4},
    {"table5", "How far points are from the reference's (its Table 5)", {1'000'000, 1, 4}, table5},
    {"figure5", "What the times are made of, all instances moving (its Figure 5)", {1'000'000, 10, 1}, figure5},
    {"figure6-range", "Over the sensor's range (its Figure 6a)", {1'000'000, 10, 1}, figure6Range},
    {"figure6-towns", "Over several towns (its Figure 6b)", {3'000'000, 5, 4}, figure6Towns},
    {"figure7", "The five sensors (its Figure 7)", {1'000'000, 10, 1}, figure7},
    {"dynamic", "Some or all instances move, or any vertex may", {1'000'000, 10, 1}, dynamic},
    {"scaling-triangles", "The town grows, the neighbourhood stays", {10'000'000, 10, 1}, scalingTriangles},
    {"scaling-rays", "From 28,800 to 25 million beams", {1'000'000, 5, 1}, scalingRays},
    {"effects", "What each effect costs beside a bare scan", {1'000'000, 7, 1}, effects},
    {"correctness", "Hard cases and a town against the reference, and fingerprints", {300'000, 1, 2}, correctness},
};

}  // namespace gnosphere::bench

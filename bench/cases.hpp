// SPDX-License-Identifier: Apache-2.0
// The list of cases of the bench.
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
Report beams(Session& session);
Report effects(Session& session);
Report correctness(Session& session);
Report real(Session& session);
Report heads(Session& session);
Report batches(Session& session);
Report golden(Session& session);

struct Case {
  const char* name;
  const char* description;
  Defaults defaults;
  Report (*run)(Session&);
};

inline constexpr Case kCases[] = {
    {"accuracy", "Time and errors of each accuracy", {1'000'000, 20, 4}, accuracy},
    {"table3", "A drive with the HDL-64E: mean and variances (the paper's Table 3)", {1'000'000, 5, 60}, table3},
    {"table4", "The two hypothetical sensors (its Table 4)", {1'000'000, 3, 6}, table4},
    {"table5", "Distances of points from the reference's (its Table 5)", {1'000'000, 1, 4}, table5},
    {"figure5", "Times of the steps, with all instances moving (its Figure 5)", {1'000'000, 10, 1}, figure5},
    {"figure6-range", "Time over the sensor's range (its Figure 6a)", {1'000'000, 10, 1}, figure6Range},
    {"figure6-towns", "Time over several towns (its Figure 6b)", {3'000'000, 5, 4}, figure6Towns},
    {"figure7", "The five sensors (its Figure 7)", {1'000'000, 10, 1}, figure7},
    {"dynamic", "Some or all instances move, or all vertices may", {1'000'000, 10, 1}, dynamic},
    {"scaling-triangles", "Towns of growing size with the same centre", {10'000'000, 10, 1}, scalingTriangles},
    {"scaling-rays", "From 28,800 to 25 million beams", {1'000'000, 5, 1}, scalingRays},
    {"beams", "Sectors, lists of beams, lasers away from the axis", {1'000'000, 7, 1}, beams},
    {"effects", "Time of each effect relative to a scan without effects", {1'000'000, 7, 1}, effects},
    {"heads", "Every head of the catalogue, clean and by default", {300'000, 3, 2}, heads},
    {"batches", "Many views (up to --frames) and worlds in one call", {300'000, 5, 4096}, batches},
    {"correctness", "Compare hard cases and a town with the reference; fingerprints", {300'000, 1, 2}, correctness},
};

/// The case `real` needs scene files, so it is not one of those that `all` runs.
inline constexpr Case kReal = {"real", "Scene files, from places where much detail is seen", {0, 5, 4}, real};

/// The case `golden` measures nothing, so `all` does not run it either.
inline constexpr Case kGolden = {"golden", "Compare clouds of `exact` with the committed hashes", {}, golden};

}  // namespace gnosphere::bench

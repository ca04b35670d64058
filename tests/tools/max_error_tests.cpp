// SPDX-License-Identifier: Apache-2.0
// The choice of scan --max-error, from measured errors and times.
#include <algorithm>
#include <catch2/catch_test_macros.hpp>
#include <vector>

#include "max_error.hpp"

using namespace gnosphere;
using namespace gnosphere::cli;

namespace {

/// A row with a largest error in metres, a number of beams lost at ties, and a time relative to that of `standard`.
AccuracyRow row(Accuracy accuracy, double error, uint64_t tieMissed, double ratio, double slowest = 0) {
  const AccuracySetting& setting = accuracySettings()[static_cast<size_t>(accuracy)];
  AccuracyRow made;
  made.name = setting.name;
  made.accuracyParts = setting.parts;
  made.error.hits = 1000;
  made.error.ties = 100;
  made.error.hitErrorMax = error;
  made.error.tieMissed = tieMissed;
  made.ratio = {ratio, ratio, ratio, std::max(ratio, slowest)};
  return made;
}

std::string chosen(std::vector<AccuracyRow> rows, double limit) {
  std::ranges::sort(rows, {}, [](const AccuracyRow& one) { return one.ratio.median; });
  const auto best = cheapestWithin(limit, rows);
  return best ? best->name : "none";
}

}  // namespace

TEST_CASE("--max-error takes a faster setting than standard only if that is clearly faster and has no gaps") {
  const AccuracyRow standard = row(Accuracy::standard, 2e-4, 5, 1), exact = row(Accuracy::exact, 1e-4, 7, 1.3);
  CHECK(chosen({standard, exact, row(Accuracy::draft, 1e-4, 5, 0.95)}, 1e-3) == "standard");
  CHECK(chosen({standard, exact, row(Accuracy::draft, 1e-4, 5, 0.5)}, 1e-3) == "draft");
  CHECK(chosen({standard, exact, row(Accuracy::draft, 1e-4, 5, 0.5, 0.95)}, 1e-3) == "standard");
  CHECK(chosen({standard, exact, row(Accuracy::draft, 1e-4, 6, 0.5)}, 1e-3) == "standard");
  CHECK(chosen({standard, row(Accuracy::exact, 1e-4, 7, 0.95)}, 1e-3) == "standard");
  CHECK(chosen({standard, exact, row(Accuracy::draft, 3e-4, 5, 0.5)}, 1.5e-4) == "exact");
  CHECK(chosen({standard, exact, row(Accuracy::draft, 3e-4, 5, 0.5)}, 1e-5) == "none");
}

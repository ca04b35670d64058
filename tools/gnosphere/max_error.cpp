// SPDX-License-Identifier: Apache-2.0
#include "max_error.hpp"

#include <algorithm>
#include <cmath>

#include "console.hpp"

namespace gnosphere::cli {
namespace {

/// Enough to find one wrong beam in some thousands; the reference traces as many in a fraction of a second.
constexpr uint64_t kSample = 20'000;
constexpr uint32_t kRuns = 7;
/// A setting is clearly faster if it is so by more than this in nearly all runs. Other times are taken as equal: they
/// may swap ranks, and the choice must not.
constexpr double kNoise = 0.1;

std::string errorOf(const AccuracyRow& row) {
  const Comparison& error = row.error;
  if (error.missed + error.falseHits == 0 && std::isinf(row.errorBound()))
    return "only ties at edges, which are not counted";
  if (error.missed + error.falseHits == 0) return formatted("%.3g m", error.hitErrorMax);
  return grouped(error.missed) + " beams missed and " + grouped(error.falseHits) + " false";
}

const AccuracyRow& standardOf(const std::vector<AccuracyRow>& rows) {
  const char* const standard = accuracySettings()[static_cast<size_t>(Accuracy::standard)].name;
  return *std::ranges::find(rows, standard, &AccuracyRow::name);
}

/// Beams lost in gaps between triangles. The reference marks beams at edges as ties, because a beam at a silhouette may
/// pass or hit; but with plain edges a beam may also slip through an edge that two triangles share. `standard` has no
/// gaps, so the ties that it loses are those at silhouettes.
uint64_t lostInGaps(const AccuracyRow& row, const AccuracyRow& standard) {
  if (row.accuracyParts.inside != AccuracyParts::Inside::plain) return 0;
  return row.error.tieMissed - std::min(row.error.tieMissed, standard.error.tieMissed);
}

/// A setting that loses fewer beams is better; among equals, the one with the smaller error.
bool better(const AccuracyRow& a, const AccuracyRow& b) {
  const auto key = [](const AccuracyRow& row) {
    return std::pair(row.error.missed + row.error.falseHits, row.error.hitErrorMax);
  };
  return key(a) < key(b);
}

std::string sampleOf(const AccuracyReport& report) {
  uint64_t ties = 0;
  for (const AccuracyRow& row : report.settings) ties = std::max(ties, row.error.ties);
  return (report.sampled ? "measured on a sample of " + grouped(report.beams) + " beams, others may be further off"
                         : "measured on all " + grouped(report.beams) + " beams") +
         (ties > 0 ? ", without " + counted(ties, "tie", "ties") + " at edges, where rounding decides" : "");
}

std::string explain(const AccuracyChoice& choice, const std::vector<AccuracyRow>& byTime) {
  std::string text;
  if (!choice.chosen) {
    const AccuracyRow& best = *std::min_element(byTime.begin(), byTime.end(), better);
    return formatted("no setting is within %g m from here; the best is %s: ", choice.limit, best.name.c_str()) +
           errorOf(best) +
           formatted(", at %s a scan, %.2f times standard; ", milliseconds(best.time().median).c_str(),
                     best.ratio.median) +
           sampleOf(choice.report);
  }
  text = choice.chosen->name + formatted(", the cheapest within %g m: off by at most ", choice.limit) +
         errorOf(*choice.chosen) + ", " + milliseconds(choice.chosen->time().median) + " a scan; ";
  const AccuracyRow& standard = standardOf(byTime);
  for (const AccuracyRow& row : byTime) {
    if (row.name == choice.chosen->name) break;
    const uint64_t gaps = lostInGaps(row, standard);
    text += row.name + " takes " + milliseconds(row.time().median) + " but ";
    if (row.errorBound() > choice.limit)
      text += "has " + errorOf(row) + "; ";
    else if (gaps > 0)
      text += "loses " + counted(gaps, "beam", "beams") + " in gaps between triangles; ";
    else
      text += "is not clearly faster; ";
  }
  return text + sampleOf(choice.report);
}

}  // namespace

std::optional<AccuracyRow> cheapestWithin(double limit, const std::vector<AccuracyRow>& byTime) {
  const AccuracyRow& standard = standardOf(byTime);
  const auto within = [&](const AccuracyRow& row) {
    return row.errorBound() <= limit && lostInGaps(row, standard) == 0;
  };
  const auto first = std::ranges::find_if(byTime, within);
  if (first == byTime.end()) return {};
  return within(standard) && first->ratio.p90 > 1 - kNoise ? standard : *first;
}

void checkMaxError(double limit) {
  if (!std::isfinite(limit) || limit < 0) {
    throw Error(ErrorCode::invalidArgument, "--max-error must be a finite number of metres, at least 0");
  }
}

AccuracyChoice chooseAccuracy(const Scene& scene, const Sensor& sensor, const Pose& pose,
                              const SimulatorOptions& options, double limit) {
  AccuracyOptions measure;
  measure.simulator = options;
  measure.runs = kRuns;
  measure.parts = measure.nearest = false;
  measure.sample = kSample;
  measure.progress = stepProgress();
  AccuracyChoice choice;
  choice.limit = limit;
  choice.report = measureAccuracy(scene, sensor, {pose}, measure);
  std::vector<AccuracyRow> byTime = choice.report.settings;
  std::stable_sort(byTime.begin(), byTime.end(),
                   [](const AccuracyRow& a, const AccuracyRow& b) { return a.time().median < b.time().median; });
  choice.chosen = cheapestWithin(limit, byTime);
  choice.why = explain(choice, byTime);
  return choice;
}

}  // namespace gnosphere::cli

// SPDX-License-Identifier: Apache-2.0
#include "gnosphere/eval/accuracy.hpp"

#include <algorithm>
#include <limits>

#include "eval/rank.hpp"
#include "eval/sample.hpp"
#include "eval/timing.hpp"
#include "gnosphere/error.hpp"
#include "gnosphere/options.hpp"
#include "output/comparison_sum.hpp"
#include "sensor/beams.hpp"

namespace gnosphere {
namespace {

struct NamedParts {
  const char* name;
  AccuracyParts accuracyParts;
};

/// The settings that can scan with the sensor.
std::vector<NamedParts> settingsFor(const Sensor& sensor) {
  std::vector<NamedParts> list;
  for (const AccuracySetting& setting : accuracySettings())
    if (setting.parts.bounds != AccuracyParts::Bounds::paper || causeAgainstPaper(sensor).empty())
      list.push_back({setting.name, setting.parts});
  return list;
}

/// Settings that differ from `standard` in one part each.
std::vector<NamedParts> parts() {
  std::vector<NamedParts> list(4, {"", accuracyPartsOf(Accuracy::standard)});
  list[0].name = "corner bounds";
  list[0].accuracyParts.bounds = AccuracyParts::Bounds::corners;
  list[1].name = "first-corner cull";
  list[1].accuracyParts.cull = AccuracyParts::Cull::firstCorner;
  list[2].name = "plain edges";
  list[2].accuracyParts.inside = AccuracyParts::Inside::plain;
  list[3].name = "range by plane";
  list[3].accuracyParts.range = AccuracyParts::Range::plane;
  return list;
}

/// One row of the table while it is measured.
struct Subject {
  AccuracyRow row;
  Simulator simulator;
  ComparisonSum sum;
};

class Measurement {
 public:
  Measurement(const Scene& scene, const Sensor& sensor, const std::vector<Pose>& poses, const AccuracyOptions& options)
      : poses_(poses),
        options_(options),
        simulator_(settingsOf(options.simulator)),
        sample_(sampleOf(sensor, options.sample, options.seed)),
        causeAgainstPaper_(causeAgainstPaper(sensor)) {
    std::vector<NamedParts> rows = settingsFor(sensor);
    settings_ = rows.size();
    const char* const standard = accuracySettings()[static_cast<size_t>(Accuracy::standard)].name;
    while (rows[standard_].name != standard) ++standard_;
    if (options.parts)
      for (const NamedParts& part : parts()) rows.push_back(part);
    subjects_.reserve(rows.size());
    for (const NamedParts& row : rows) {
      tell("set up", subjects_.size(), rows.size());
      SimulatorOptions settings = simulator_;
      settings.accuracyParts = row.accuracyParts;
      subjects_.push_back({{{}, row.name, row.accuracyParts},
                           Simulator(scene, {sensor, Effects::none()}, settings),
                           ComparisonSum(sample_.size() * poses.size(), 1e-3)});
    }
    compareAll(scene);
    const auto scan = [&](size_t row, size_t pose) { return subjects_[row].simulator.scan(poses[pose]).timings; };
    timings_ = timeInTurn(subjects_.size(), poses.size(), options.runs, options.progress, scan);
  }

  AccuracyReport report() {
    AccuracyReport report;
    report.device = subjects_[0].simulator.device();
    report.beams = sample_.size() * poses_.size();
    report.sampled = !sample_.beams.empty();
    report.runs = options_.runs;
    for (size_t i = 0; i < subjects_.size(); ++i) {
      finish(subjects_[i], timings_[i]);
      (i < settings_ ? report.settings : report.parts).push_back(subjects_[i].row);
    }
    if (!causeAgainstPaper_.empty()) report.withoutPaper = "the sensor " + causeAgainstPaper_;
    return report;
  }

 private:
  void tell(const char* step, uint64_t done, uint64_t total) const {
    if (options_.progress) options_.progress(step, done, total);
  }

  /// Compares every row with the reference. This also warms up: afterwards every list on the device is large enough for
  /// these poses.
  void compareAll(const Scene& scene) {
    SimulatorOptions settings = simulator_;
    settings.device = DeviceChoice::Kind::reference;
    settings.accuracyParts = accuracyPartsOf(Accuracy::standard);
    Simulator reference(scene, {sample_.sensor, Effects::none()}, settings);
    for (size_t p = 0; p < poses_.size(); ++p) {
      tell("compare pose", p + 1, poses_.size());
      const Scan truth = sample_.of(reference.scan(poses_[p]));
      for (Subject& subject : subjects_) {
        const Scan scan = sample_.of(subject.simulator.scan(poses_[p]));
        subject.sum.add(truth, scan);
        if (!options_.nearest || !sample_.beams.empty()) continue;
        const NearestHistogram nearest = nearestHistogram(truth, scan);
        for (size_t bin = 0; bin < nearest.size(); ++bin) subject.row.nearest[bin] += nearest[bin];
      }
    }
  }

  void finish(Subject& subject, const std::vector<Timings>& runs) const {
    AccuracyRow& row = subject.row;
    row.error = subject.sum.result();
    storeTimes(runs, timings_[standard_], row);
    for (const StageTime& stage : runs[0].stages) {
      std::vector<double> times;
      for (const Timings& timings : runs)
        for (const StageTime& time : timings.stages)
          if (time.name == stage.name) times.push_back(time.ms);
      row.stages.push_back({stage.name, spreadOf(times).median});
    }
  }

  const std::vector<Pose>& poses_;
  const AccuracyOptions& options_;
  SimulatorOptions simulator_;
  BeamSample sample_;
  std::string causeAgainstPaper_;              // empty if `paper` is among the settings
  std::vector<Subject> subjects_;              // the settings come first
  std::vector<std::vector<Timings>> timings_;  // by subject and run
  size_t settings_ = 0, standard_ = 0;         // number of settings, and the index of `standard`
};

}  // namespace

Spread spreadOf(std::vector<double> values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  const size_t half = values.size() / 2;
  const double median = values.size() % 2 ? values[half] : (values[half - 1] + values[half]) / 2;
  return {median, values.front(), rankOf(values, 0.1), rankOf(values, 0.9)};
}

double AccuracyRow::wrongShare() const {
  const uint64_t wrong = error.missed + error.falseHits + error.wrongRange;
  return error.beams ? static_cast<double>(wrong) / static_cast<double>(error.beams) : 0;
}

double AccuracyRow::errorBound() const {
  const bool tiesAlone = error.hitErrorMax == 0 && error.ties > 0 && error.ties >= error.hits;
  return error.missed + error.falseHits > 0 || tiesAlone ? std::numeric_limits<double>::infinity() : error.hitErrorMax;
}

AccuracyReport measureAccuracy(const Scene& scene, const Sensor& sensor, const std::vector<Pose>& poses,
                               const AccuracyOptions& options) {
  if (poses.empty()) throw Error(ErrorCode::invalidArgument, "accuracy is measured from at least one pose");
  if (options.runs == 0) throw Error(ErrorCode::invalidArgument, "times need at least one run");
  if (options.simulator.device.kind == DeviceChoice::Kind::reference) {
    throw Error(ErrorCode::invalidArgument,
                "the reference is what accuracy is measured against; choose another device");
  }
  validate(sensor);
  return Measurement(scene, sensor, poses, options).report();
}

}  // namespace gnosphere

// SPDX-License-Identifier: Apache-2.0
#include "gnosphere/eval/sub_rays.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "eval/rank.hpp"
#include "eval/sample.hpp"
#include "eval/timing.hpp"
#include "gnosphere/error.hpp"

namespace gnosphere {
namespace {

/// One return of a beam.
struct Echo {
  double range, intensity;
};

std::vector<Echo> echoesOf(const Scan& scan, const ColumnView<float>& intensities, size_t beam) {
  std::vector<Echo> echoes;
  for (size_t entry = beam * scan.returns; entry < (beam + 1) * scan.returns; ++entry)
    if (scan.returned(entry)) echoes.push_back({scan.ranges[entry], intensities[entry]});
  return echoes;
}

/// Collects the errors of one footprint, beam by beam.
class Errors {
 public:
  explicit Errors(double tolerance, const Effects::RangeNoise* noise) : tolerance_(tolerance), noise_(noise) {}

  void add(const Scan& truth, const Scan& scan) {
    const auto expected = truth.column<float>(Field::intensity), found = scan.column<float>(Field::intensity);
    for (size_t beam = 0; beam < truth.beamCount(); ++beam)
      addBeam(echoesOf(truth, expected, beam), echoesOf(scan, found, beam));
  }

  void store(SubRayRow& row) {
    row.beams = beams_;
    if (beams_ == 0) return;
    const double beams = static_cast<double>(beams_);
    row.wrongRange = static_cast<double>(wrongRange_) / beams;
    row.wrongReturns = static_cast<double>(wrongReturns_) / beams;
    row.wrong = static_cast<double>(wrong_) / beams;
    if (ranges_.empty()) return;
    std::sort(ranges_.begin(), ranges_.end());
    row.rangeErrorMax = ranges_.back();
    row.rangeError999 = rankOf(ranges_, 0.999);
    row.rangeErrorRms = std::sqrt(squares_ / static_cast<double>(returns_));
    if (intensities_.empty()) return;
    std::sort(intensities_.begin(), intensities_.end());
    row.intensityErrorMedian = rankOf(intensities_, 0.5);
    row.intensityError99 = rankOf(intensities_, 0.99);
  }

 private:
  void addBeam(const std::vector<Echo>& truth, const std::vector<Echo>& echoes) {
    if (truth.empty() && echoes.empty()) return;
    ++beams_;
    const bool wrongReturns = truth.size() != echoes.size();
    bool wrongRange = false;
    if (!truth.empty() && !echoes.empty()) {
      double farthest = 0;
      for (const Echo& echo : echoes) {
        const Echo& own = *std::min_element(truth.begin(), truth.end(), [&](const Echo& a, const Echo& b) {
          return std::abs(a.range - echo.range) < std::abs(b.range - echo.range);
        });
        const double error = std::abs(echo.range - own.range);
        farthest = std::max(farthest, error);
        squares_ += error * error;
        ++returns_;
        wrongRange |= error > allowedAt(own.range);
        if (own.intensity > 0) intensities_.push_back(std::abs(echo.intensity / own.intensity - 1));
      }
      ranges_.push_back(farthest);
    }
    wrongReturns_ += wrongReturns;
    wrongRange_ += wrongRange;
    wrong_ += wrongReturns || wrongRange;
  }

  double allowedAt(double range) const {
    if (!noise_) return tolerance_;
    const double sigma = noise_->sigma + noise_->sigmaPerMetre * range + noise_->sigmaPerSquareMetre * range * range;
    return std::max(tolerance_, sigma);
  }

  double tolerance_;
  const Effects::RangeNoise* noise_;  ///< null if it is not planned
  uint64_t beams_ = 0, returns_ = 0, wrongRange_ = 0, wrongReturns_ = 0, wrong_ = 0;
  double squares_ = 0;
  std::vector<double> ranges_, intensities_;  ///< the largest of each beam; of each return
};

SensorRequest withSubRays(SensorRequest request, uint32_t subRays) {
  request.effects.divergence.subRays = subRays;
  if (std::find(request.fields.begin(), request.fields.end(), Field::intensity) == request.fields.end())
    request.fields.push_back(Field::intensity);
  return request;
}

class SubRayMeasurement {
 public:
  SubRayMeasurement(const Scene& scene, const SensorRequest& request, const std::vector<Pose>& poses,
                    const SubRayOptions& options)
      : scene_(scene),
        request_(request),
        poses_(poses),
        options_(options),
        settings_(settingsOf(options.simulator)),
        sample_(sampleOf(request.sensor, options.sample, options.seed)) {
    report_.rows.resize(1 + options.counts.size());
    for (size_t i = 0; i < options.counts.size(); ++i) report_.rows[1 + i].subRays = options.counts[i];
    report_.beams = sample_.size() * poses.size();
    report_.sampled = !sample_.beams.empty();
    report_.runs = options.runs;
    report_.truth = options.truth;
    report_.tolerance = options.tolerance;
  }

  SubRayReport run() {
    if (request_.effects.divergence.use == EffectUse::off)
      throw Error(ErrorCode::invalidArgument,
                  "there are no sub-rays to measure: divergence is off in the request; set it to auto or on");
    std::vector<SensorRequest> requests = {{request_.sensor, Effects::none()}};
    for (const uint32_t count : options_.counts) requests.push_back(withSubRays(request_, count));
    for (const SensorRequest& request : requests) {
      tell("set up", simulators_.size(), requests.size());
      simulators_.emplace_back(scene_, request, settings_);
      if (simulators_.size() == 2) readPlan(simulators_[1].plan());
    }
    report_.device = simulators_[0].device();
    compareAll();
    timeAll();
    return report_;
  }

 private:
  void tell(const char* step, uint64_t done, uint64_t total) const {
    if (options_.progress) options_.progress(step, done, total);
  }

  void readPlan(const Plan& plan) {
    for (const Plan::Decision& decision : plan.effects) {
      if (decision.effect != "divergence") continue;
      if (!decision.in)
        throw Error(ErrorCode::invalidArgument,
                    "there are no sub-rays to measure: divergence is out, because " + decision.reason);
      report_.footprint = decision.reason.substr(0, decision.reason.find(','));
    }
  }

  /// Compares every count with the reference. This also warms up: afterwards every list on the device is large enough
  /// for these poses.
  void compareAll() {
    SimulatorOptions settings = settings_;
    settings.device = DeviceChoice::Kind::reference;
    SensorRequest many = withSubRays(request_, options_.truth);
    many.sensor = sample_.sensor;
    Simulator reference(scene_, many, settings);
    const bool noisy = simulators_[1].plan().has("range-noise");
    std::vector<Errors> errors(report_.rows.size(),
                               Errors(options_.tolerance, noisy ? &request_.effects.rangeNoise : nullptr));
    for (size_t p = 0; p < poses_.size(); ++p) {
      tell("compare pose", p + 1, poses_.size());
      const Scan truth = sample_.of(reference.scan(poses_[p]));
      simulators_[0].scan(poses_[p]);
      for (size_t row = 1; row < errors.size(); ++row)
        errors[row].add(truth, sample_.of(simulators_[row].scan(poses_[p])));
    }
    for (size_t row = 1; row < errors.size(); ++row) errors[row].store(report_.rows[row]);
  }

  void timeAll() {
    const auto scan = [&](size_t row, size_t pose) { return simulators_[row].scan(poses_[pose]).timings; };
    const auto runs = timeInTurn(simulators_.size(), poses_.size(), options_.runs, options_.progress, scan);
    for (size_t row = 0; row < runs.size(); ++row) storeTimes(runs[row], runs[0], report_.rows[row]);
  }

  const Scene& scene_;
  const SensorRequest& request_;
  const std::vector<Pose>& poses_;
  const SubRayOptions& options_;
  SimulatorOptions settings_;
  BeamSample sample_;
  std::vector<Simulator> simulators_;  ///< of the rows; each has the sensor's number 0, which keys random draws
  SubRayReport report_;
};

}  // namespace

SubRayReport measureSubRays(const Scene& scene, const SensorRequest& request, const std::vector<Pose>& poses,
                            const SubRayOptions& options) {
  const auto refuse = [](const char* why) { throw Error(ErrorCode::invalidArgument, why); };
  if (poses.empty()) refuse("footprints are measured from at least one pose");
  if (options.runs == 0) refuse("times need at least one run");
  if (options.counts.empty()) refuse("at least one number of sub-rays must be measured");
  if (options.simulator.device.kind == DeviceChoice::Kind::reference)
    refuse("the reference is what footprints are measured against; choose another device");
  validate(request.sensor);
  return SubRayMeasurement(scene, request, poses, options).run();
}

}  // namespace gnosphere

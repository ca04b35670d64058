// SPDX-License-Identifier: Apache-2.0
#include "contest.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "console.hpp"

namespace gnosphere::bench {
namespace {

/// Up to this many triangles and beams the reference is asked, too: it takes some seconds and gigabytes then.
constexpr uint64_t kReferenceTriangles = 2'000'000, kReferenceBeams = 1'000'000;

/// Forth and back along x by up to 0.1 m, every frame elsewhere than the one before.
Transform movedBy(const Transform& transform, size_t frame) {
  Transform moved = transform;
  if (CanMove<Simulator>) moved.rows[3] += 0.02 * (static_cast<double>(frame % 10) - 5);
  return moved;
}

/// Ours, the rivals, ours, ...: [contender][run][frame].
using Samples = std::vector<std::vector<std::vector<Sample>>>;

class Contest {
 public:
  Contest(const Setting& setting, std::vector<std::unique_ptr<Contender>>& contenders)
      : setting_(setting), contenders_(contenders) {}

  std::vector<Standing> check() {
    std::vector<Standing> standings;
    for (const auto& contender : contenders_) {
      Standing& standing = standings.emplace_back();
      standing.name = contender->name();
      standing.judged = contender->judged();
      standing.buildMs = contender->build();
      contender->run(taskOf(0));
      standing.agreement = agreementOf(contenders_[0]->answer(), contender->answer());
      if (standing.judged && !standing.agreement.good())
        refuse(standing.name, cli::grouped(standing.agreement.hits + standing.agreement.ranges) + " of " +
                                  cli::grouped(standing.agreement.beams) + " beams differ from " + standings[0].name);
      standing.memoryBytes = contender->memoryBytes();
    }
    standings[0].error = againstReference();
    return standings;
  }

  /// `counters`: ours, of every frame.
  Samples time(std::vector<Counters>& counters) {
    Samples samples(contenders_.size());
    for (auto& runs : samples) runs.resize(setting_.runs);
    const auto progress = cli::stepProgress();
    for (uint32_t run = 0; run < setting_.runs; ++run) {
      progress(setting_.label.c_str(), run + 1, setting_.runs);
      for (size_t frame = 0; frame < setting_.poses.size(); ++frame) {
        const Task task = taskOf(frame);
        for (size_t c = 0; c < contenders_.size(); ++c) samples[c][run].push_back(contenders_[c]->run(task));
        if (run == 0) counters.push_back(contenders_[0]->answer().counters);
      }
    }
    return samples;
  }

 private:
  Task taskOf(size_t frame) {
    moved_.clear();
    for (size_t instance : setting_.moving)
      moved_.push_back({instance, movedBy(setting_.scene.instances[instance].transform, frame)});
    return {setting_.poses[frame], moved_};
  }

  [[noreturn]] void refuse(const std::string& who, const std::string& why) const {
    throw Error(ErrorCode::device, setting_.label + ": the answer of " + who + " is not right: " + why);
  }

  std::optional<Comparison> againstReference() const {
    if (setting_.scene.placedTriangleCount() > kReferenceTriangles || setting_.sensor.beamCount() > kReferenceBeams)
      return {};
    Scene scene = setting_.scene;
    for (const Moved& move : moved_) scene.instances[move.instance].transform = move.transform;
    SimulatorOptions options;
    options.device = "reference";
    options.faces = Faces::both;
    const Comparison c =
        compare(Simulator(scene, setting_.sensor, options).scan(setting_.poses[0]), contenders_[0]->answer());
    if (contenders_[0]->judged() && c.missed + c.falseHits + c.wrongRange > 0)
      refuse(contenders_[0]->name(), cli::grouped(c.missed) + " beams missed, " + cli::grouped(c.falseHits) +
                                         " false hits and " + cli::grouped(c.wrongRange) +
                                         " wrong ranges against the reference");
    return c;
  }

  const Setting& setting_;
  std::vector<std::unique_ptr<Contender>>& contenders_;
  std::vector<Moved> moved_;
};

double meanOf(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double varianceOf(const std::vector<double>& values) {
  const double mean = meanOf(values);
  double sum = 0;
  for (double value : values) sum += (value - mean) * (value - mean);
  return values.size() > 1 ? sum / static_cast<double>(values.size() - 1) : 0;
}

using Runs = std::vector<std::vector<Sample>>;

template <class Get>
std::vector<double> flat(const Runs& runs, Get get) {
  std::vector<double> values;
  for (const auto& frames : runs)
    for (const Sample& sample : frames) values.push_back(get(sample));
  return values;
}

double total(const Sample& s) {
  return s.totalMs();
}
double device(const Sample& s) {
  return s.deviceMs;
}

template <class Get>
double medianRatio(const Runs& runs, const Runs& ours, Get get) {
  std::vector<double> above = flat(runs, get);
  const std::vector<double> below = flat(ours, get);
  for (size_t i = 0; i < above.size(); ++i) {
    if (!(above[i] > 0 && below[i] > 0)) return 0;
    above[i] /= below[i];
  }
  return spreadOf(above).median;
}

void summarise(const Runs& runs, const Runs& ours, Standing& standing) {
  const std::vector<double> totals = flat(runs, total);
  standing.totalMs = spreadOf(totals);
  standing.meanMs = meanOf(totals);
  standing.renewMs = spreadOf(flat(runs, [](const Sample& s) { return s.renewMs; }));
  standing.scanMs = spreadOf(flat(runs, [](const Sample& s) { return s.scanMs; }));
  standing.deviceMs = spreadOf(flat(runs, device));
  standing.ratio = medianRatio(runs, ours, total);
  standing.deviceRatio = medianRatio(runs, ours, device);
  for (size_t stage = 0; stage < runs[0][0].stages.size(); ++stage) {
    const auto time = [stage](const Sample& s) { return s.stages[stage].ms; };
    standing.stages.push_back({runs[0][0].stages[stage].name, spreadOf(flat(runs, time)).median});
  }
  std::vector<double> frameMeans(runs[0].size()), runMeans;
  for (const auto& frames : runs) {
    double sum = 0;
    for (size_t frame = 0; frame < frames.size(); ++frame) {
      frameMeans[frame] += frames[frame].totalMs() / static_cast<double>(runs.size());
      sum += frames[frame].totalMs();
    }
    runMeans.push_back(sum / static_cast<double>(frames.size()));
  }
  standing.frameVariance = varianceOf(frameMeans);
  standing.runVariance = varianceOf(runMeans);
}

Floor meanFloor(const std::vector<Counters>& frames, const Outcome& outcome, const Rates& rates) {
  Floor mean;
  const double share = 1 / static_cast<double>(frames.size());
  for (const Counters& counters : frames) {
    const Floor floor = floorOf(counters, outcome.memory, outcome.uniqueTriangles, rates);
    mean.bytes += share * floor.bytes;
    mean.operations += share * floor.operations;
    mean.ms += share * floor.ms;
  }
  return mean;
}

}  // namespace

bool Agreement::good() const {
  return static_cast<double>(hits + ranges) <= kAgreement * static_cast<double>(beams);
}

Agreement agreementOf(const Scan& ours, const Scan& other) {
  Agreement agreement;
  agreement.beams = ours.ranges.size();
  if (other.ranges.size() != ours.ranges.size()) {
    agreement.hits = agreement.beams;
    return agreement;
  }
  for (size_t beam = 0; beam < ours.ranges.size(); ++beam) {
    const double a = ours.ranges[beam], b = other.ranges[beam];
    if (std::isnan(a) || std::isnan(b))
      agreement.hits += std::isnan(a) != std::isnan(b);
    else
      agreement.ranges += !(std::abs(a - b) <= 1e-3 + 1e-4 * a);
  }
  return agreement;
}

Outcome hold(const Setting& setting, std::vector<std::unique_ptr<Contender>>& contenders, const Rates& rates) {
  Contest contest(setting, contenders);
  Outcome outcome;
  outcome.label = setting.label;
  outcome.x = setting.x;
  outcome.sensor = setting.sensor;
  outcome.frames = setting.poses.size();
  outcome.moving = setting.moving.size();
  outcome.placedTriangles = setting.scene.placedTriangleCount();
  outcome.uniqueTriangles = setting.scene.uniqueTriangleCount();
  outcome.instances = setting.scene.instances.size();
  outcome.meshes = setting.scene.meshes.size();
  outcome.runs = setting.runs;
  outcome.standings = contest.check();
  std::vector<Counters> counters;
  const Samples samples = contest.time(counters);
  for (size_t c = 0; c < samples.size(); ++c) summarise(samples[c], samples[0], outcome.standings[c]);
  outcome.memory = simulatorOf(*contenders[0]).memory();
  outcome.hits = counters.back().hits;
  outcome.floor = meanFloor(counters, outcome, rates);
  return outcome;
}

}  // namespace gnosphere::bench

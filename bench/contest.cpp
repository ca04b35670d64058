// SPDX-License-Identifier: Apache-2.0
#include "contest.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <numeric>
#include <thread>

#include "console.hpp"

namespace gnosphere::bench {
namespace {

/// Limits up to which the reference is computed, too; at the limits it takes some seconds and gigabytes.
constexpr uint64_t kReferenceTriangles = 5'000'000, kReferenceBeams = 1'000'000;

/// Moves back and forth along x by up to five steps, with a different place for every task.
Transform movedBy(const Transform& transform, double step, size_t task) {
  Transform moved = transform;
  moved.rows[3] += step * (static_cast<double>(task % 10) - 5);
  return moved;
}

/// A contender that takes longer than this in total stops, but not before kLeastSamples samples.
constexpr double kPatienceMs = 5000;
constexpr size_t kLeastSamples = 3;
constexpr std::chrono::milliseconds kPause(5);

/// Times of a contender, and GnoSphere's in the same frame of the same run.
struct Pair {
  uint32_t run = 0;
  size_t frame = 0;
  Sample sample, ours;
};
using Pairs = std::vector<Pair>;

class Contest {
 public:
  Contest(const Setting& setting, std::vector<std::unique_ptr<Contender>>& contenders)
      : setting_(setting), contenders_(contenders) {}

  /// Builds all contenders and compares their results. One that runs out of memory is left out, with a note.
  std::vector<Standing> check(std::vector<std::string>& notes) {
    std::vector<Standing> standings;
    const std::optional<Scan> reference = referenceScan();
    for (auto contender = contenders_.begin(); contender != contenders_.end();) {
      Standing standing;
      standing.name = (*contender)->name();
      try {
        standing.buildMs = (*contender)->build();
        (*contender)->run(taskOf(0, 0));
      } catch (const Error& error) {
        if (error.code() != ErrorCode::outOfMemory || contender == contenders_.begin()) throw;
        notes.push_back(setting_.label + ", " + standing.name + ": " + error.what());
        contender = contenders_.erase(contender);
        continue;
      }
      judge(**contender, reference, standing);
      standings.push_back(standing);
      ++contender;
    }
    if (reference) standings[0].error = against(*reference);
    return standings;
  }

  /// Times GnoSphere and the others in turn. `counters` are GnoSphere's, of every frame.
  std::vector<Pairs> time(std::vector<Counters>& counters) {
    std::vector<Pairs> pairs(contenders_.size());
    std::vector<double> spentMs(contenders_.size());
    const auto progress = cli::stepProgress();
    for (uint32_t run = 0; run < setting_.runs; ++run) {
      progress(setting_.label.c_str(), run + 1, setting_.runs);
      for (size_t frame = 0; frame < setting_.shots.size(); ++frame) {
        const Task task = taskOf(frame, 1 + run * setting_.shots.size() + frame);
        const Sample ours = runAlone(0, task);
        pairs[0].push_back({run, frame, ours, ours});
        if (run == 0) counters.push_back(contenders_[0]->answer().counters);
        for (size_t c = 1; c < contenders_.size(); ++c) {
          if (spentMs[c] > kPatienceMs && pairs[c].size() >= kLeastSamples) continue;
          const double start = cli::nowMs();
          pairs[c].push_back({run, frame, runAlone(c, task), ours});
          spentMs[c] += cli::nowMs() - start;
        }
      }
    }
    return pairs;
  }

 private:
  /// Runs a task after a pause, so that the threads of the previous contender sleep: those of TBB, which Embree uses,
  /// search for work for a while.
  Sample runAlone(size_t contender, const Task& task) {
    std::this_thread::sleep_for(kPause);
    return contenders_[contender]->run(task);
  }

  Task taskOf(size_t frame, size_t number) {
    moved_.clear();
    for (size_t instance : setting_.moving)
      moved_.push_back({instance, movedBy(setting_.scene.instances[instance].transform, setting_.step, number)});
    return {setting_.shots[frame], moved_};
  }

  void judge(const Contender& contender, const std::optional<Scan>& reference, Standing& standing) const {
    const Contender& ours = *contenders_[0];
    standing.agreement = agreementOf(ours.answer(), contender.answer(), reference ? &*reference : nullptr);
    standing.memoryBytes = contender.memoryBytes();
    if (contender.judged() && !standing.agreement.good())
      refuse(standing.name, cli::grouped(standing.agreement.differ()) + " of " +
                                cli::grouped(standing.agreement.beams) + " beams differ from " + ours.name());
  }

  [[noreturn]] void refuse(const std::string& who, const std::string& why) const {
    throw Error(ErrorCode::device, setting_.label + ": the result of " + who + " is wrong: " + why);
  }

  /// The reference's scan of the first task, unless it would take too long.
  std::optional<Scan> referenceScan() {
    if (!setting_.refereed) return {};
    if (setting_.scene.placedTriangleCount() > kReferenceTriangles || setting_.sensor.beamCount() > kReferenceBeams)
      return {};
    Scene scene = setting_.scene;
    for (const Moved& move : taskOf(0, 0).moved) scene.instances[move.instance].transform = move.transform;
    SimulatorOptions options;
    options.device = DeviceChoice::Kind::reference;
    options.faces = ReflectingFaces::material;
    return Simulator(scene, {setting_.sensor, Effects::none()}, options).scan(setting_.shots[0].pose);
  }

  Comparison against(const Scan& reference) const {
    const Comparison c = compare(reference, contenders_[0]->answer());
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

/// Whether two intensities agree; both may be absent.
bool near(double a, double b) {
  return std::isnan(a) || std::isnan(b) ? std::isnan(a) == std::isnan(b) : std::abs(a - b) <= 1e-3 + 1e-3 * a;
}

double meanOf(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double varianceOf(const std::vector<double>& values) {
  const double mean = meanOf(values);
  double sum = 0;
  for (double value : values) sum += (value - mean) * (value - mean);
  return values.size() > 1 ? sum / static_cast<double>(values.size() - 1) : 0;
}

template <class Get>
std::vector<double> valuesOf(const Pairs& pairs, Get get) {
  std::vector<double> values;
  for (const Pair& pair : pairs) values.push_back(get(pair.sample));
  return values;
}

double total(const Sample& s) {
  return s.totalMs();
}
double device(const Sample& s) {
  return s.deviceMs;
}

/// Median ratio of the contender's times to GnoSphere's; 0 if one of them has no such time.
template <class Get>
double medianRatio(const Pairs& pairs, Get get) {
  std::vector<double> ratios;
  for (const Pair& pair : pairs) {
    if (!(get(pair.sample) > 0 && get(pair.ours) > 0)) return 0;
    ratios.push_back(get(pair.sample) / get(pair.ours));
  }
  return spreadOf(ratios).median;
}

/// Median ratios of the contender's total times to GnoSphere's, frame by frame, in ascending order.
std::vector<double> frameRatios(const Pairs& pairs) {
  std::map<size_t, Pairs> frames;
  for (const Pair& pair : pairs) frames[pair.frame].push_back(pair);
  std::vector<double> ratios;
  for (const auto& [_, samples] : frames) ratios.push_back(medianRatio(samples, total));
  std::sort(ratios.begin(), ratios.end());
  return ratios;
}

/// Variance of the means of the samples that share a key.
template <class Key>
double varianceOfMeans(const Pairs& pairs, Key key) {
  std::map<size_t, std::vector<double>> groups;
  for (const Pair& pair : pairs) groups[key(pair)].push_back(pair.sample.totalMs());
  std::vector<double> means;
  for (const auto& [_, values] : groups) means.push_back(meanOf(values));
  return varianceOf(means);
}

void summarise(const Pairs& pairs, Standing& standing) {
  const std::vector<double> totals = valuesOf(pairs, total);
  standing.samples = pairs.size();
  standing.totalMs = spreadOf(totals);
  standing.meanMs = meanOf(totals);
  standing.renewMs = spreadOf(valuesOf(pairs, [](const Sample& s) { return s.renewMs; }));
  standing.scanMs = spreadOf(valuesOf(pairs, [](const Sample& s) { return s.scanMs; }));
  standing.deviceMs = spreadOf(valuesOf(pairs, device));
  standing.ratio = medianRatio(pairs, total);
  const std::vector<double> byFrame = frameRatios(pairs);
  standing.leastFrameRatio = byFrame.front();
  standing.mostFrameRatio = byFrame.back();
  standing.deviceRatio = medianRatio(pairs, device);
  standing.frameVariance = varianceOfMeans(pairs, [](const Pair& pair) { return pair.frame; });
  standing.runVariance = varianceOfMeans(pairs, [](const Pair& pair) { return size_t{pair.run}; });
  const std::vector<StageTime>& stages = pairs[0].sample.stages;
  for (size_t stage = 0; stage < stages.size(); ++stage) {
    const auto time = [stage](const Sample& s) { return s.stages[stage].ms; };
    standing.stages.push_back({stages[stage].name, spreadOf(valuesOf(pairs, time)).median});
  }
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
  return static_cast<double>(differ()) <= kAgreement * static_cast<double>(beams);
}

std::vector<Shot> shotsFrom(const std::vector<Pose>& poses) {
  std::vector<Shot> shots;
  for (const Pose& pose : poses) shots.push_back({pose});
  return shots;
}

Agreement agreementOf(const Scan& ours, const Scan& other, const Scan* reference) {
  Agreement agreement;
  agreement.beams = ours.ranges.size();
  if (other.ranges.size() != ours.ranges.size()) {
    agreement.hits = agreement.beams;
    return agreement;
  }
  const auto both = [&](Field field) { return ours.has(field) && other.has(field); };
  ColumnView<uint8_t> labels, otherLabels, ties;
  if (reference) ties = reference->column<uint8_t>(Field::tie);
  if (both(Field::label))
    labels = ours.column<uint8_t>(Field::label), otherLabels = other.column<uint8_t>(Field::label);
  ColumnView<float> intensities, otherIntensities;
  if (both(Field::intensity)) {
    intensities = ours.column<float>(Field::intensity);
    otherIntensities = other.column<float>(Field::intensity);
  }
  for (size_t beam = 0; beam < ours.ranges.size(); ++beam) {
    if (!ties.empty() && ties[beam]) continue;
    const double a = ours.ranges[beam], b = other.ranges[beam];
    if (std::isnan(a) != std::isnan(b))
      ++agreement.hits;
    else if (!std::isnan(a) && !(std::abs(a - b) <= 1e-3 + 1e-4 * a))
      ++agreement.ranges;
    else if (!labels.empty() && labels[beam] != otherLabels[beam])
      ++agreement.signals;
    else if (!intensities.empty() && !near(intensities[beam], otherIntensities[beam]))
      ++agreement.signals;
  }
  return agreement;
}

Outcome hold(const Setting& setting, std::vector<std::unique_ptr<Contender>>& contenders, const Rates& rates) {
  Contest contest(setting, contenders);
  Outcome outcome;
  outcome.label = setting.label;
  outcome.x = setting.x;
  outcome.sensor = setting.sensor;
  outcome.frames = setting.shots.size();
  outcome.moving = setting.moving.size();
  outcome.placedTriangles = setting.scene.placedTriangleCount();
  outcome.uniqueTriangles = setting.scene.uniqueTriangleCount();
  outcome.instances = setting.scene.instances.size();
  outcome.meshes = setting.scene.meshes.size();
  outcome.runs = setting.runs;
  outcome.standings = contest.check(outcome.notes);
  std::vector<Counters> counters;
  const std::vector<Pairs> pairs = contest.time(counters);
  for (size_t c = 0; c < pairs.size(); ++c) summarise(pairs[c], outcome.standings[c]);
  outcome.memory = simulatorOf(*contenders[0]).memory();
  outcome.hits = counters.back().hits;
  outcome.floor = meanFloor(counters, outcome, rates);
  return outcome;
}

}  // namespace gnosphere::bench

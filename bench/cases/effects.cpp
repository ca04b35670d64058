// SPDX-License-Identifier: Apache-2.0
// Measures the time of effects: every request in turn with a scan of geometry alone.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <map>
#include <string_view>

#include "cases.hpp"
#include "gnosphere/eval/accuracy.hpp"
#include "variants.hpp"

namespace gnosphere::bench {
namespace {

using cli::formatted;
using cli::Json;

constexpr const char* kManyScans = "19 bare scans";
/// One variant of each kind: signal, footprint, lists, motion, weather, and all at once.
constexpr std::string_view kBesideCuda[] = {"intensity",  "19 sub-rays", "transmission", "sensor motion, 15 m/s",
                                            "fog, 200 m", "all of them"};

/// A request that is measured, and the times of its scans.
struct Runner {
  std::string name, effect;  ///< of effectNames(), or empty
  Simulator simulator;
  std::vector<Shot> shots;  ///< one per pose
  uint32_t scans = 1;       ///< per timed round
  Scan scan = {};
  std::vector<double> totalMs = {}, deviceMs = {}, ratios = {};  ///< per round; ratios to the bare scan just before it
  std::map<std::string, std::vector<double>> stageMs = {};

  /// Scans once untimed first, because data that was not used for a while is no longer in the caches.
  double run(size_t round) {
    Shot& shot = shots[round % shots.size()];
    shot.frame = round;
    simulator.scanInto(shot, scan);
    double device = 0;
    std::map<std::string, double> stages;
    const double start = cli::nowMs();
    for (uint32_t i = 0; i < scans; ++i) {
      simulator.scanInto(shot, scan);
      device += scan.timings.gpuMs;
      for (const StageTime& stage : scan.timings.stages) stages[stage.name] += stage.ms;
    }
    totalMs.push_back(cli::nowMs() - start);
    deviceMs.push_back(device);
    for (const auto& [stage, ms] : stages) stageMs[stage].push_back(ms);
    return totalMs.back();
  }
};

/// Times all scans in turn. The first is the bare scan, which runs before each of the others, so that other load
/// affects both.
void race(std::vector<Runner>& runners, const char* what, uint32_t rounds) {
  const auto progress = cli::stepProgress();
  runners[0].ratios = {1};
  for (uint32_t round = 0; round < rounds; ++round) {
    progress(what, round + 1, rounds);
    for (size_t i = 1; i < runners.size(); ++i) {
      const double bare = runners[0].run(round);
      runners[i].ratios.push_back(runners[i].run(round) / bare);
    }
  }
}

template <typename T>
bool sameBytes(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}

[[noreturn]] void refuse(const std::string& who, const std::string& why) {
  throw Error(ErrorCode::device, who + ": " + why);
}

/// A plan without its reasons. Both simulators must have scanned before, because buffers grow with the scene in range.
Json made(const Simulator& simulator) {
  Json plan = Json::parse(toJson(simulator.plan()));
  plan.erase("effects");
  return plan;
}

/// Checks that the surfaces in `scan` have the same ranges as in the bare scan, bit by bit.
void checkSame(const std::string& who, const Scan& bare, const Scan& scan) {
  size_t solid = 0;
  const auto labels = scan.column<uint8_t>(Field::label);
  const auto trueRanges = scan.column<float>(Field::trueRange);
  for (size_t beam = 0; beam < labels.size(); ++beam) {
    if (labels[beam] != static_cast<uint8_t>(Label::solid)) continue;
    ++solid;
    if (std::bit_cast<uint32_t>(trueRanges[beam]) != std::bit_cast<uint32_t>(bare.ranges[beam]))
      refuse(who, formatted("beam %zu meets a surface at %.9g m, a bare scan at %.9g m", beam,
                            static_cast<double>(trueRanges[beam]), static_cast<double>(bare.ranges[beam])));
  }
  if (solid == 0) refuse(who, "no beam meets a surface");
}

/// Checks that nearest returns have the ranges of the bare scan, except for some beams that graze an edge.
void checkNear(const std::string& who, const Scan& bare, const Scan& scan) {
  Scan first;
  for (size_t entry = 0; entry < scan.ranges.size(); entry += scan.returns) first.ranges.push_back(scan.ranges[entry]);
  const Agreement agreement = agreementOf(bare, first);
  if (!agreement.good())
    refuse(who, cli::grouped(agreement.differ()) + " of " + cli::grouped(agreement.beams) +
                    " beams differ from a bare scan");
}

/// The measurement for one scene and one sensor.
class CostOfEffects {
 public:
  explicit CostOfEffects(Session& session)
      : session_(session),
        scene_(session.scene()),
        sensor_(session.sensors({"HDL-64E"})[0]),
        poses_(session.poses(scene_)) {
    sensor_.divergenceHorizontal = 0.003;
    sensor_.divergenceVertical = 0.0015;
    sensor_.rotationPeriod = 0.1;
    sensor_.maxReturns = 3;
    const Vec3 at = poses_[0].position;
    variants_ = variantsOf({at.x + 15, at.y, at.z});
  }

  const Scene& scene() const { return scene_; }
  const Sensor& sensor() const { return sensor_; }

  /// Measures every effect switched off but with parameters given. Plans and clouds must equal the bare scan's.
  std::vector<Runner> off() const {
    std::vector<Runner> runners;
    runners.push_back(bare("bare"));
    const Json plan = made(runners[0].simulator);
    const Scan answer = runners[0].scan;
    for (const std::string& effect : effectNames()) {
      Effects request = requestOf(effect);
      const std::vector<Shot> shots = shotsOf(request);  // includes motion if the request has it
      request.intensity.use = EffectUse::off;
      assign(request, effect + "=off");
      Runner off = {effect + " off", effect, simulator(request, {}), shots};
      off.simulator.scanInto(off.shots[0], off.scan);
      if (made(off.simulator) != plan) refuse(off.name, "its plan differs from a bare scan's");
      if (!sameBytes(off.scan.points, answer.points) || !sameBytes(off.scan.ranges, answer.ranges) ||
          !sameBytes(off.scan.triangles, answer.triangles) || !sameBytes(off.scan.instances, answer.instances))
        refuse(off.name, "its cloud differs from a bare scan's");
      runners.push_back(std::move(off));
    }
    return runners;
  }

  /// Measures every supported variant, and at last as many bare scans as one beam has sub-rays.
  std::vector<Runner> on() const {
    std::vector<Runner> runners;
    runners.push_back(bare("bare"));
    const Scan answer = runners[0].scan;
    for (const Variant& variant : variants_) {
      Runner on = {variant.name, variant.effect, simulator(variant.request, variant.fields), shotsOf(variant.request)};
      const Plan plan = on.simulator.plan();
      if (!variant.effect.empty() && !plan.has(variant.effect)) {
        session_.addNote(variant.name + ": " + reasonOf(plan, variant.effect));
        continue;
      }
      check(variant, on.shots[0], answer);
      runners.push_back(std::move(on));
    }
    runners.push_back(bare(kManyScans));
    runners.back().scans = 19;
    return runners;
  }

  /// Measures some variants by CUDA on the same card, if available.
  void besideCuda(std::vector<Outcome>& outcomes) const {
    for (const Variant& variant : variants_) {
      if (std::find(std::begin(kBesideCuda), std::end(kBesideCuda), variant.name) == std::end(kBesideCuda)) continue;
      try {
        session_.hold({variant.name, 0, scene_, sensor_},
                      Request{variant.request, variant.fields, shotsOf(variant.request)}, outcomes);
      } catch (const Error& error) {
        session_.addNote(variant.name + " by CUDA: " + error.what());
      }
    }
  }

 private:
  Simulator simulator(const Effects& effects, const std::vector<Field>& fields) const {
    return Simulator(scene_, {sensor_, effects, fields}, session_.simulatorOptions());
  }

  std::vector<Shot> shotsOf(const Effects& effects) const {
    std::vector<Shot> shots;
    for (const Pose& pose : poses_) {
      Shot shot;
      shot.pose = pose;
      if (effects.sensorMotion.use != EffectUse::off) shot.motion = drivenFrom(pose, sensor_.rotationPeriod);
      if (effects.objectMotion.use != EffectUse::off)
        shot.instanceMotions = drivenVehicles(scene_, sensor_.rotationPeriod);
      shots.push_back(shot);
    }
    return shots;
  }

  /// Returns the bare scan, which has scanned from the first pose.
  Runner bare(const char* name) const {
    Runner bare = {name, "", simulator(Effects::none(), {}), shotsOf(Effects::none())};
    bare.simulator.scanInto(bare.shots[0], bare.scan);
    return bare;
  }

  void check(const Variant& variant, const Shot& shot, const Scan& answer) const {
    if (variant.ranges == Ranges::other) return;
    std::vector<Field> fields = variant.fields;
    fields.insert(fields.end(), {Field::trueRange, Field::label});
    Scan scan;
    simulator(variant.request, fields).scanInto(shot, scan);
    (variant.ranges == Ranges::same ? checkSame : checkNear)(variant.name, answer, scan);
  }

  Effects requestOf(const std::string& effect) const {
    for (const Variant& variant : variants_)
      if (variant.effect == effect) return variant.request;
    refuse(effect, "no request of the bench uses it");
  }

  static std::string reasonOf(const Plan& plan, const std::string& effect) {
    for (const Plan::Decision& decision : plan.effects)
      if (decision.effect == effect) return decision.reason;
    return "";
  }

  Session& session_;
  Scene scene_;
  Sensor sensor_;
  std::vector<Pose> poses_;
  std::vector<Variant> variants_;
};

/// Summary of the rounds of one runner, or of several equal ones.
struct EffectRow {
  std::string name, effect;
  Spread totalMs, deviceMs, ratio;
  std::vector<StageTime> stages;  ///< medians
  uint64_t bytes = 0;
  uint32_t dispatches = 0;
};

EffectRow rowOf(const Runner& runner) {
  EffectRow row = {runner.name, runner.effect, spreadOf(runner.totalMs), spreadOf(runner.deviceMs),
                   spreadOf(runner.ratios)};
  for (const StageTime& stage : runner.scan.timings.stages)
    row.stages.push_back({stage.name, spreadOf(runner.stageMs.at(stage.name)).median});
  row.bytes = runner.simulator.plan().bytes();
  row.dispatches = runner.scans * runner.simulator.plan().dispatches();
  return row;
}

/// Combines all switched-off effects in one row.
EffectRow offRow(std::vector<Runner>& runners) {
  Runner& all = runners[1];
  all.name = "off";
  all.effect.clear();
  for (size_t i = 2; i < runners.size(); ++i) {
    all.totalMs.insert(all.totalMs.end(), runners[i].totalMs.begin(), runners[i].totalMs.end());
    all.deviceMs.insert(all.deviceMs.end(), runners[i].deviceMs.begin(), runners[i].deviceMs.end());
    all.ratios.insert(all.ratios.end(), runners[i].ratios.begin(), runners[i].ratios.end());
    for (auto& [stage, ms] : all.stageMs)
      ms.insert(ms.end(), runners[i].stageMs[stage].begin(), runners[i].stageMs[stage].end());
  }
  return rowOf(all);
}

Json effectJson(const EffectRow& row) {
  Json stages = Json::object();
  for (const StageTime& stage : row.stages) stages[stage.name] = rounded(stage.ms);
  return {{"name", row.name},
          {"effect", row.effect},
          {"total_ms", {{"median", rounded(row.totalMs.median)}, {"min", rounded(row.totalMs.min)}}},
          {"device_ms", row.deviceMs.median > 0 ? Json(rounded(row.deviceMs.median)) : Json()},
          {"stages_ms", stages},
          {"times_bare",
           {{"median", rounded(row.ratio.median)}, {"p10", rounded(row.ratio.p10)}, {"p90", rounded(row.ratio.p90)}}},
          {"bytes", row.bytes},
          {"dispatches", row.dispatches}};
}

std::vector<std::string> stageNames(const std::vector<EffectRow>& rows) {
  std::vector<std::string> names;
  for (const EffectRow& row : rows)
    for (const StageTime& stage : row.stages)
      if (std::find(names.begin(), names.end(), stage.name) == names.end()) names.push_back(stage.name);
  return names;
}

Table tableOf(const std::vector<EffectRow>& rows, const std::string& note) {
  Table table = {note, {{"scan", "ms", "times a bare scan", "p10 to p90"}}};
  const std::vector<std::string> stages = stageNames(rows);
  table.rows[0].insert(table.rows[0].end(), stages.begin(), stages.end());
  table.rows[0].insert(table.rows[0].end(), {"MB", "dispatches"});
  for (const EffectRow& row : rows) {
    cli::TableRow cells = {row.name, cli::bareMs(row.totalMs.median), formatted("%.2f", row.ratio.median),
                           formatted("%.2f to %.2f", row.ratio.p10, row.ratio.p90)};
    for (const std::string& name : stages) {
      const auto stage = std::find_if(row.stages.begin(), row.stages.end(),
                                      [&](const StageTime& other) { return other.name == name; });
      cells.push_back(stage == row.stages.end() ? "-" : cli::bareMs(stage->ms));
    }
    cells.insert(cells.end(),
                 {formatted("%.1f", static_cast<double>(row.bytes) / 1e6), std::to_string(row.dispatches)});
    table.rows.push_back(cells);
  }
  return table;
}

/// Returns the median ratio of `a` to `b` over the rounds.
double ratioOf(const std::vector<Runner>& runners, const std::string& a, const std::string& b) {
  const auto find = [&](const std::string& name) -> const Runner& {
    return *std::find_if(runners.begin(), runners.end(), [&](const Runner& runner) { return runner.name == name; });
  };
  std::vector<double> ratios;
  for (size_t round = 0; round < find(a).totalMs.size(); ++round)
    ratios.push_back(find(a).totalMs[round] / find(b).totalMs[round]);
  return spreadOf(ratios).median;
}

}  // namespace

Report effects(Session& session) {
  const uint32_t rounds = session.options().runs;
  const CostOfEffects cost(session);
  std::vector<Runner> off = cost.off();
  session.setDevice(off[0].simulator.device());
  race(off, "effects off", rounds);
  const EffectRow offs = offRow(off);
  off.clear();
  std::vector<Runner> on = cost.on();
  race(on, "effects on", rounds);
  std::vector<EffectRow> rows;
  for (const Runner& runner : on) rows.push_back(rowOf(runner));
  rows.insert(rows.begin() + 1, offs);

  const double share = ratioOf(on, "19 sub-rays", kManyScans);
  on.clear();
  Report report;
  cost.besideCuda(report.outcomes);
  report.more = {{"scene", cli::sceneJson(cost.scene())},
                 {"sensor", cli::sensorJson(cost.sensor())},
                 {"rounds", rounds},
                 {"off_requests", effectNames().size()},
                 {"sub_rays_to_scans", rounded(share)}};
  for (const EffectRow& row : rows) {
    report.more["rows"].push_back(effectJson(row));
    report.bars.bars.push_back({row.name, row.ratio.median, row.ratio.p10, row.ratio.p90});
  }
  report.bars.xLabel = "times a bare scan: median, 10th to 90th percentile";
  report.tables = {tableOf(
      rows,
      formatted("%zu effects were switched off one by one: plans and clouds equal a bare scan's. 19 sub-rays take "
                "%.2f of the time of 19 scans. Steps are in ms by the device's clock",
                effectNames().size(), share))};
  return report;
}

}  // namespace gnosphere::bench

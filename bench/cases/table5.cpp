// SPDX-License-Identifier: Apache-2.0
// Table 5 of the paper: the distance from each point to the nearest point of the reference. The distance says little
// about a beam's own error, which is therefore listed, too.
#include "cases.hpp"
#include "gnosphere/eval/accuracy.hpp"

namespace gnosphere::bench {
namespace {

/// Computes points from ranges if a contender returns none.
Scan withPoints(Scan scan, const Sensor& sensor) {
  if (!scan.points.empty()) return scan;
  scan.points.reserve(3 * scan.ranges.size());
  for (size_t beam = 0; beam < scan.ranges.size(); ++beam) {
    const Vec3 d = sensor.direction(beam);
    for (double along : {d.x, d.y, d.z}) scan.points.push_back(static_cast<float>(along * scan.ranges[beam]));
  }
  return scan;
}

struct Tally {
  std::string name;
  NearestHistogram nearest{};
  uint64_t missed = 0, falseHits = 0, wrongRange = 0;
};

std::vector<Tally> count(Session& session, const Scene& scene, const Sensor& sensor) {
  SimulatorOptions options;
  options.device = DeviceChoice::Kind::reference;
  options.faces = ReflectingFaces::both;
  Simulator reference(scene, {sensor, Effects::none()}, options);
  const auto contenders = session.contenders({sensor.name, 0, scene, sensor});
  const std::vector<Shot> shots = shotsFrom(session.poses(scene));
  std::vector<Tally> tallies;
  for (const auto& contender : contenders) {
    contender->build();
    tallies.push_back({contender->name()});
  }
  const auto progress = cli::stepProgress();
  for (size_t frame = 0; frame < shots.size(); ++frame) {
    progress("frame", frame + 1, shots.size());
    const Scan truth = reference.scan(shots[frame].pose);
    for (size_t c = 0; c < contenders.size(); ++c) {
      contenders[c]->run({shots[frame], {}});
      const Scan answer = withPoints(contenders[c]->answer(), sensor);
      const NearestHistogram nearest = nearestHistogram(truth, answer);
      for (size_t bin = 0; bin < nearest.size(); ++bin) tallies[c].nearest[bin] += nearest[bin];
      const Comparison comparison = compare(truth, answer);
      tallies[c].missed += comparison.missed;
      tallies[c].falseHits += comparison.falseHits;
      tallies[c].wrongRange += comparison.wrongRange;
      if (c == 0 && contenders[c]->judged() && comparison.missed + comparison.falseHits + comparison.wrongRange > 0)
        throw Error(ErrorCode::device,
                    "table5: the result differs from the reference in frame " + std::to_string(frame + 1));
    }
  }
  return tallies;
}

std::string binName(size_t bin) {
  const double from = bin ? kNearestBins[bin - 1] : 0;
  return bin < kNearestBins.size() ? cli::formatted("%.2f - %.2f", from, kNearestBins[bin])
                                   : cli::formatted("beyond %.2f", from);
}

}  // namespace

Report table5(Session& session) {
  const Scene scene = session.scene();
  const Sensor sensor = session.sensors({"HDL-64E"})[0];
  const std::vector<Tally> tallies = count(session, scene, sensor);
  Report report;
  Table table = {"Points by the distance to their nearest neighbour in the reference's cloud; beams: without ties", {}};
  table.rows = {{"m"}};
  for (const Tally& tally : tallies) table.rows[0].push_back(tally.name);
  for (size_t bin = 0; bin <= kNearestBins.size(); ++bin) {
    table.rows.push_back({binName(bin)});
    for (const Tally& tally : tallies) table.rows.back().push_back(cli::grouped(tally.nearest[bin]));
  }
  const auto add = [&](const char* what, uint64_t Tally::*value) {
    table.rows.push_back({what});
    for (const Tally& tally : tallies) table.rows.back().push_back(cli::grouped(tally.*value));
  };
  add("beams missed", &Tally::missed);
  add("beams falsely hit", &Tally::falseHits);
  add("beams at another range", &Tally::wrongRange);
  report.tables = {table};
  for (const Tally& tally : tallies)
    report.more["contenders"].push_back({{"name", tally.name},
                                         {"nearest", tally.nearest},
                                         {"missed", tally.missed},
                                         {"false_hits", tally.falseHits},
                                         {"wrong_range", tally.wrongRange}});
  return report;
}

}  // namespace gnosphere::bench

// SPDX-License-Identifier: Apache-2.0
// The heads of the catalogue as a user gets them: geometry alone beside the head's ideal twin, and with the effects
// that its data sheet calls for beside geometry alone, and both beside Embree with the same lines of light.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <sstream>
#include <thread>

#include "cases.hpp"
#include "eval/sample.hpp"
#include "poses.hpp"
#include "rivals/embree.hpp"
#include "sensor/beams.hpp"
#include "variants.hpp"

namespace gnosphere::bench {
namespace {

using cli::formatted;

/// Beams that are compared with the reference.
constexpr uint64_t kSample = 1'000;
/// Surfaces that our own sub-rays meet at most.
constexpr uint32_t kLayers = 4;
/// Share of the beams whose returns may lie outside the hits of Embree's sub-rays, because both compute in single
/// precision and a footprint has many lines that may graze an edge.
constexpr double kFootprintAgreement = 1e-3;
constexpr std::chrono::milliseconds kPause(5);  // as in a contest
/// NVIDIA's driver improves new kernels while they run: in its first second on an H100 a default scan of an OS1-64 took
/// three times as long as later, and as long as later in the next process.
constexpr double kWarmUpMs = 1500;

/// The measurements of one head. "Standing" means that the sensor stands still during each scan.
enum Column {
  kClean,
  kTwin,
  kDefault,
  kCleanMoving,
  kTwinMoving,
  kDefaultMoving,
  kDefaultRenewed,
  kLines,
  kSubRays,
  kSubRaysRenewed,
  kColumns
};
constexpr const char* kNames[kColumns] = {"clean",
                                          "twin",
                                          "default",
                                          "clean_moving",
                                          "twin_moving",
                                          "default_moving",
                                          "default_all_moves",
                                          "embree_lines",
                                          "embree_sub_rays",
                                          "embree_all_moves"};

/// The ratios that count, as value / beside.
struct Ratio {
  const char* name;
  const char* title;
  Column value, beside;
};
constexpr Ratio kRatios[] = {
    {"clean_to_twin", "clean / twin", kClean, kTwin},
    {"clean_to_twin_moving", "clean / twin, moving", kCleanMoving, kTwinMoving},
    {"default_to_clean", "default / clean", kDefault, kClean},
    {"default_to_clean_moving", "default / clean, moving", kDefaultMoving, kClean},
    {"speed_beside_embree_clean", "Embree / clean", kLines, kClean},
    {"speed_beside_embree", "Embree / default", kSubRays, kDefault},
    {"speed_beside_embree_all_moves", "Embree / default, all moves", kSubRaysRenewed, kDefaultRenewed},
};
constexpr size_t kMainRatio = 3;  ///< the one in the plot

struct HeadRow {
  std::string scene, head;
  uint64_t beams = 0, triangles = 0;
  size_t subRays = 0;
  std::array<std::vector<double>, kColumns> ms;  ///< by frame and run; empty if there is no such scan

  double median(Column column) const { return spreadOf(ms[column]).median; }
  /// Median of the ratios frame by frame and run by run; 0 if one of them is missing.
  double ratio(const Ratio& of) const {
    std::vector<double> ratios;
    for (size_t i = 0; i < std::min(ms[of.value].size(), ms[of.beside].size()); ++i)
      ratios.push_back(ms[of.value][i] / ms[of.beside][i]);
    return spreadOf(ratios).median;
  }
};

/// The same elevations, columns and ranges, without offsets, origins and firing times of lasers; nothing for a list.
std::optional<Sensor> twinOf(const Sensor& head) {
  if (!head.isGrid()) return {};
  Sensor twin = head;
  twin.name += ", ideal twin";
  const bool full = std::abs(head.azimuthSpanDeg) >= 360;
  twin.azimuthSpanDeg = full ? 360 : std::abs(head.azimuthSpanDeg);
  twin.azimuthStartDeg = full ? -180 : std::min(head.azimuthStartDeg, head.azimuthStartDeg + head.azimuthSpanDeg);
  twin.nearHits = NearHits::seeThrough;
  twin.maskedBeams.clear();
  for (Channel& channel : twin.channels) channel = {channel.elevationDeg};
  return twin;
}

/// Geometry alone of a sensor that may move during the scan.
Effects motionAlone() {
  Effects effects = Effects::none();
  effects.sensorMotion.use = EffectUse::automatic;
  return effects;
}

/// Counts our beams that have a return outside the hits of their lines, a return where no line hits, or no return where
/// a line hits.
uint64_t unlike(const Scan& ours, const Lines& lines, const LineHits& hits) {
  uint64_t count = 0;
  const size_t perBeam = size_t{lines.perBeam} * lines.layers;
  for (size_t beam = 0; beam < ours.beamCount(); ++beam) {
    double least = std::numeric_limits<double>::infinity(), most = -least;
    for (size_t i = beam * perBeam; i < (beam + 1) * perBeam; ++i) {
      if (std::isnan(hits.ranges[i])) continue;
      least = std::min<double>(least, hits.ranges[i]);
      most = std::max<double>(most, hits.ranges[i]);
    }
    bool returned = false, outside = false;
    for (size_t entry = beam * ours.returns; entry < (beam + 1) * ours.returns; ++entry) {
      if (!ours.returned(entry)) continue;
      returned = true;
      const double range = ours.ranges[entry], allowed = 1e-3 + 1e-4 * range;
      outside |= range < least - allowed || range > most + allowed;
    }
    count += outside || returned != (most >= least);
  }
  return count;
}

class HeadMeasurement {
 public:
  explicit HeadMeasurement(Session& session) : session_(session) {
    std::stringstream given(session.options().heads);
    for (std::string name; std::getline(given, name, ',');) heads_.push_back(builtinSensor(name));
    if (heads_.empty())
      for (const CatalogueHead& head : sensorCatalogue()) heads_.push_back(builtinSensor(head.name));
  }

  void run() {
    std::vector<std::string> files = session_.options().scenes;
    if (files.empty()) files.push_back("");
    for (const std::string& file : files) {
      Scene scene = file.empty() ? session_.scene() : loadScene(file);
      for (Material& material : scene.materials) material.doubleSided = true;  // rivals see both faces
      const std::vector<Pose> poses =
          file.empty() ? session_.poses(scene)
                       : detailedPoses(scene, session_.options().frames, 1, session_.simulatorOptions().device);
      if (poses.empty()) {
        session_.addNote(file + ": there is no place for a sensor");
        continue;
      }
      measure(file.empty() ? "town" : std::filesystem::path(file).stem().string(), scene, poses);
    }
  }

  Report report() const {
    Report report;
    report.wrong = wrong_;
    report.tables = {table(), summary()};
    for (const HeadRow& row : rows_) {
      report.more["rows"].push_back(jsonOf(row));
      if (const double ratio = row.ratio(kRatios[kMainRatio]); ratio > 0)
        report.bars.bars.push_back({row.head + (scenes_ > 1 ? ", " + row.scene : ""), ratio, 0, 0});
    }
    report.more["summary"] = summaryJson();
    report.bars.xLabel = "times a clean scan: the default effects, the sensor moves during the scan";
    return report;
  }

 private:
  struct Place {
    const std::string& name;
    const Scene& scene;
    const std::vector<Pose>& poses;
    std::vector<bool> panes;  ///< per material
    Simulator reference;
    std::unique_ptr<EmbreeRival> still, moving;
  };

  void measure(const std::string& name, const Scene& scene, const std::vector<Pose>& poses) {
    ++scenes_;
    SimulatorOptions referenceOptions;
    referenceOptions.device = DeviceChoice::Kind::reference;
    Place place = {name, scene, poses, {}, Simulator(scene, std::vector<SensorRequest>{}, referenceOptions), {}, {}};
    for (const Optics& optics : opticsOf(scene, {}, 905)) place.panes.push_back(optics.transmission > 0);
    if (haveEmbree() && session_.options().rivals != "none") {
      place.still = makeEmbree(scene, poses[0].position, EmbreeWay::flat);
      place.still->build();
      place.moving = makeEmbree(scene, poses[0].position, EmbreeWay::rebuilt);
      place.moving->build();
    } else {
      session_.addNote("Embree, which is not asked for or not installed");
    }
    const auto progress = cli::stepProgress();
    for (size_t i = 0; i < heads_.size(); ++i) {
      progress((name + ", " + heads_[i].name).c_str(), i + 1, heads_.size());
      try {
        rows_.push_back(rowOf(place, heads_[i]));
      } catch (const Error& error) {
        // A wrong answer or a lack of memory ends this head alone. The exit status is 1 in the end.
        session_.addNote(name + ", " + heads_[i].name + ": " + error.what());
        wrong_ |= error.code() == ErrorCode::device;
      }
    }
  }

  /// Each column has a sensor of its own, because one that begins or ceases to move gets new tables for its next scan.
  HeadRow rowOf(Place& place, const Sensor& head) {
    const std::optional<Sensor> twin = twinOf(head);
    const Sensor& other = twin ? *twin : head;
    const std::vector<SensorRequest> requests = {{head, Effects::none()}, {other, Effects::none()}, {head, Effects()},
                                                 {head, motionAlone()},   {other, motionAlone()},   {head, Effects()}};
    Simulator ours(place.scene, requests, session_.simulatorOptions());
    session_.setDevice(ours.device());
    HeadRow row = {place.name, head.name, head.beamCount(), place.scene.placedTriangleCount()};
    const bool footprints = ours.plan(2).has("divergence");
    const bool moves = firesInTurn(head);
    check(place, requests, ours, footprints, moves);
    warmUp(place, requests, ours, moves);
    for (uint32_t run = 0; run < session_.options().runs; ++run)
      for (size_t frame = 0; frame < place.poses.size(); ++frame)
        time(place, head, bool(twin), ours, footprints, moves, run * place.poses.size() + frame, row);
    return row;
  }

  /// Scans with each sensor once, because a first scan compiles kernels, and for longer on a graphics card.
  void warmUp(const Place& place, const std::vector<SensorRequest>& requests, Simulator& ours, bool moves) {
    const double end = cli::nowMs() + (ours.device().type == "cpu" ? 0 : kWarmUpMs);
    do {
      for (size_t sensor = 0; sensor < requests.size(); ++sensor)
        ours.scanInto(shotOf(place.poses[0], requests[sensor].sensor, sensor, moves && sensor > 2), scan_);
    } while (cli::nowMs() < end);
  }

  static Shot shotOf(const Pose& pose, const Sensor& head, size_t sensor, bool moves) {
    Shot shot;
    shot.pose = pose;
    shot.sensor = sensor;
    if (moves) shot.motion = drivenFrom(pose, durationOf(head, 0));
    return shot;
  }

  Lines linesOf(const Place& place, const Sensor& head, bool footprints, const Shot& shot) const {
    Lines lines = bench::linesOf(head, Effects(), footprints, shot, place.poses[0].position);
    lines.layers = footprints ? kLayers : 1;
    return lines;
  }

  /// Compares a sample with the reference, and all beams with Embree, from the first pose.
  void check(Place& place, const std::vector<SensorRequest>& requests, Simulator& ours, bool footprints, bool moves) {
    const Sensor& head = requests[0].sensor;
    for (const auto& [sensor, moving] : {std::pair(0, false), std::pair(2, false), std::pair(5, true)}) {
      if (moving && !moves) continue;
      const Shot shot = shotOf(place.poses[0], head, static_cast<size_t>(sensor), moving);
      Scan scan;
      ours.scanInto(shot, scan);
      judge(place, requests[static_cast<size_t>(sensor)], shot, scan);
      if (!place.still) continue;
      const Lines lines = linesOf(place, head, sensor != 0 && footprints, shot);
      if (sensor != 0 && !footprints) continue;
      LineHits hits;
      place.still->trace(lines, place.panes, hits);
      const uint64_t differ = unlike(scan, lines, hits);
      const double share = sensor != 0 ? kFootprintAgreement : kAgreement;
      if (static_cast<double>(differ) > share * static_cast<double>(head.beamCount()) + 1)
        refuse(formatted("%s of %s beams differ from Embree's lines", cli::grouped(differ).c_str(),
                         cli::grouped(head.beamCount()).c_str()));
    }
  }

  void judge(Place& place, const SensorRequest& request, const Shot& shot, const Scan& scan) const {
    const BeamSample sample = sampleOf(request.sensor, kSample, 1);
    Shot same = shot;
    same.sensor = place.reference.addSensor({sample.sensor, request.effects});
    Scan truth;
    place.reference.scanInto(same, truth);
    place.reference.removeSensor(same.sensor);
    const Comparison c = compare(sample.of(truth), sample.of(scan));
    if (c.missed + c.falseHits + c.wrongRange > 0)
      refuse(formatted("of %s returns %s are missed, %s false and %s at a wrong range against the reference",
                       cli::grouped(c.hits).c_str(), cli::grouped(c.missed).c_str(), cli::grouped(c.falseHits).c_str(),
                       cli::grouped(c.wrongRange).c_str()));
  }

  [[noreturn]] static void refuse(const std::string& why) { throw Error(ErrorCode::device, "wrong: " + why); }

  /// Times everything once, in turn, from one pose.
  void time(Place& place, const Sensor& head, bool twin, Simulator& ours, bool footprints, bool moves, size_t number,
            HeadRow& row) {
    const Pose& pose = place.poses[number % place.poses.size()];
    const auto scan = [&](Column column, size_t sensor, bool moving) {
      const Shot shot = shotOf(pose, head, sensor, moving);
      std::this_thread::sleep_for(kPause);
      const double start = cli::nowMs();
      ours.scanInto(shot, scan_);
      row.ms[column].push_back(cli::nowMs() - start);
    };
    scan(kClean, 0, false);
    if (twin) scan(kTwin, 1, false);
    scan(kDefault, 2, false);
    if (moves) scan(kCleanMoving, 3, true);
    if (moves && twin) scan(kTwinMoving, 4, true);
    scan(kDefaultMoving, 5, moves);
    const std::vector<Moved> moved = allMoved(place.scene, number);
    const double start = cli::nowMs();
    for (const Moved& move : moved) ours.setTransform(move.instance, move.transform);
    const double renewMs = cli::nowMs() - start;
    scan(kDefaultRenewed, 5, moves);
    row.ms[kDefaultRenewed].back() += renewMs;
    for (size_t i = 0; i < moved.size(); ++i) ours.setTransform(i, place.scene.instances[i].transform);
    ours.scanInto(shotOf(pose, head, 0, false), scan_);  // untimed: it takes the instances back
    const Lines still = linesOf(place, head, footprints, shotOf(pose, head, 2, false));
    row.subRays = still.perBeam;
    if (!place.still) return;
    const auto trace = [&](Column column, EmbreeRival& rival, const Lines& lines) {
      std::this_thread::sleep_for(kPause);
      row.ms[column].push_back(rival.trace(lines, place.panes, hits_));
    };
    trace(kLines, *place.still, linesOf(place, head, false, shotOf(pose, head, 0, false)));
    trace(kSubRays, *place.still, still);
    const double rebuildMs = place.moving->update(moved);
    trace(kSubRaysRenewed, *place.moving, linesOf(place, head, footprints, shotOf(pose, head, 5, moves)));
    row.ms[kSubRaysRenewed].back() += rebuildMs;
  }

  /// All instances a little aside, to another place each time.
  static std::vector<Moved> allMoved(const Scene& scene, size_t number) {
    std::vector<Moved> moved;
    for (size_t i = 0; i < scene.instances.size(); ++i) {
      moved.push_back({i, scene.instances[i].transform});
      moved.back().transform.rows[3] += 0.02 * (static_cast<double>(number % 10) - 5);
    }
    return moved;
  }

  Table table() const {
    Table table;
    table.rows = {{"scene", "head", "beams", "sub-rays", "clean ms", "default ms", "moving ms"}};
    for (const Ratio& ratio : kRatios) table.rows[0].emplace_back(ratio.title);
    for (const HeadRow& row : rows_) {
      cli::TableRow cells = {row.scene,
                             row.head,
                             cli::grouped(row.beams),
                             cli::grouped(row.subRays),
                             cli::bareMs(row.median(kClean)),
                             cli::bareMs(row.median(kDefault)),
                             cli::bareMs(row.median(kDefaultMoving))};
      for (const Ratio& ratio : kRatios) cells.push_back(orDash(row.ratio(ratio)));
      table.rows.push_back(cells);
    }
    table.note =
        "Medians of all poses and runs; ratios frame by frame. clean: geometry alone; default: what the head's data "
        "sheet calls for; moving: the sensor moves at 15 m/s during the scan; twin: the head without azimuth offsets, "
        "origins and firing times of its lasers; all moves: every instance has moved, and Embree's build counts. "
        "Embree traces the same lines: beams, or with default their sub-rays through panes, each from where its laser "
        "is. Left out of its time: making the lines, intensities, holes, merging hits to echoes, choosing returns, "
        "points and owners";
    return table;
  }

  static std::string orDash(double ratio) { return ratio > 0 ? formatted("%.2f", ratio) : "-"; }

  /// Median and worst of a ratio over all rows. For speeds the least is the worst.
  struct Overall {
    size_t rows = 0;
    double median = 0, worst = 0;
    std::string where;
  };
  Overall overallOf(const Ratio& ratio) const {
    const bool speed = std::string(ratio.name).starts_with("speed");
    Overall overall;
    std::vector<double> values;
    for (const HeadRow& row : rows_) {
      const double value = row.ratio(ratio);
      if (!(value > 0)) continue;
      if (values.empty() || (speed ? value < overall.worst : value > overall.worst))
        overall.worst = value, overall.where = row.head + (scenes_ > 1 ? ", " + row.scene : "");
      values.push_back(value);
    }
    overall.rows = values.size();
    overall.median = spreadOf(values).median;
    return overall;
  }

  Table summary() const {
    Table table = {"Over all rows", {{"ratio", "rows", "median", "worst", "where"}}};
    for (const Ratio& ratio : kRatios) {
      const Overall overall = overallOf(ratio);
      table.rows.push_back(
          {ratio.title, std::to_string(overall.rows), orDash(overall.median), orDash(overall.worst), overall.where});
    }
    return table;
  }

  cli::Json summaryJson() const {
    cli::Json json = cli::Json::array();
    for (const Ratio& ratio : kRatios) {
      const Overall overall = overallOf(ratio);
      json.push_back({{"name", ratio.name},
                      {"title", ratio.title},
                      {"rows", overall.rows},
                      {"median", rounded(overall.median)},
                      {"worst", rounded(overall.worst)},
                      {"where", overall.where}});
    }
    return json;
  }

  static cli::Json jsonOf(const HeadRow& row) {
    cli::Json ms = cli::Json::object(), ratios = cli::Json::object();
    for (size_t i = 0; i < kColumns; ++i)
      if (!row.ms[i].empty()) ms[kNames[i]] = rounded(row.median(static_cast<Column>(i)));
    for (const Ratio& ratio : kRatios)
      if (const double value = row.ratio(ratio); value > 0) ratios[ratio.name] = rounded(value);
    return {{"scene", row.scene}, {"triangles", row.triangles}, {"head", row.head},
            {"beams", row.beams}, {"sub_rays", row.subRays},    {"ms", ms},
            {"ratios", ratios}};
  }

  Session& session_;
  std::vector<Sensor> heads_;
  std::vector<HeadRow> rows_;
  size_t scenes_ = 0;
  Scan scan_;
  LineHits hits_;
  bool wrong_ = false;
};

}  // namespace

Report heads(Session& session) {
  HeadMeasurement measurement(session);
  measurement.run();
  return measurement.report();
}

}  // namespace gnosphere::bench

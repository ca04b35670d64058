// SPDX-License-Identifier: Apache-2.0
// Many views in one call, with their results on the host or on the device, beside scans one by one and Embree: a town
// from random poses, and worlds whose boxes move between two steps.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <optional>
#include <random>
#include <tuple>

#include "cases.hpp"
#include "gnosphere/batch.hpp"
#include "gnosphere/batch_stream.hpp"
#include "gnosphere/error.hpp"
#include "rivals/embree.hpp"
#include "variants.hpp"

namespace gnosphere::bench {
namespace {

using cli::formatted;

/// Shots of a batch that are scanned one by one, too.
constexpr size_t kSingles = 64;
/// Lines that Embree traces in one call: more than enough for all cores.
constexpr uint64_t kLinesAtOnce = 1 << 19;
constexpr size_t kBoxes = 25;  ///< per world
constexpr Field kRange[] = {Field::range};

/// A batch and its rivals; times are milliseconds of the whole batch, by run.
struct BatchRow {
  std::string what;
  size_t views = 0, beams = 0;
  std::vector<double> batch, streamed, moving, single, embree, renewing;
  uint64_t memoryBytes = 0;

  double perView(const std::vector<double>& ms) const { return spreadOf(ms).median / static_cast<double>(views); }
  double raysPerSecond(const std::vector<double>& ms, const std::vector<double>& before) const {
    const double sum = spreadOf(ms).median + spreadOf(before).median;
    return sum > 0 ? 1e3 * static_cast<double>(views * beams) / sum : 0;
  }
};

/// Rays to 17 x 11 points, 0.1 m apart, on a level 0.6 m below.
Sensor heightScan() {
  Sensor sensor;
  sensor.name = "height scan";
  sensor.rangeMax = 5;
  BeamList beams;
  beams.width = 17;
  beams.height = 11;
  for (int y = -5; y <= 5; ++y)
    for (int x = -8; x <= 8; ++x) {
      const Vec3 to = {0.1 * x, 0.1 * y, -0.6};
      const double length = std::hypot(to.x, to.y, to.z);
      beams.directions.push_back({to.x / length, to.y / length, to.z / length});
    }
  sensor.patterns = {beams};
  return sensor;
}

Sensor headOf(uint32_t columns, double rangeMax) {
  Sensor sensor;
  sensor.name = formatted("16 x %u", columns);
  sensor.columns = columns;
  sensor.rangeMax = rangeMax;
  for (int j = 0; j < 16; ++j) sensor.channels.push_back({-15.0 + 2 * j});
  return sensor;
}

Mesh meshOf(std::vector<float> positions, std::vector<uint32_t> indices) {
  Mesh mesh;
  mesh.positions = std::move(positions);
  mesh.indices = std::move(indices);
  mesh.parts = {{0, static_cast<uint32_t>(mesh.triangleCount()), 0}};
  return mesh;
}

/// A cube of 0.6 m.
Mesh box() {
  std::vector<float> corners;
  for (uint32_t k = 0; k < 8; ++k)
    for (uint32_t axis = 0; axis < 3; ++axis) corners.push_back((k >> axis & 1) != 0 ? 0.3f : -0.3f);
  return meshOf(corners, {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                          2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5});
}

/// 20 x 20 m of ground with bumps, in squares of half a metre.
Mesh ground(std::mt19937& random) {
  constexpr uint32_t kSide = 41;
  std::uniform_real_distribution<float> height(0, 0.05f);
  std::vector<float> positions;
  std::vector<uint32_t> indices;
  for (uint32_t y = 0; y < kSide; ++y)
    for (uint32_t x = 0; x < kSide; ++x) {
      positions.insert(positions.end(),
                       {0.5f * static_cast<float>(x) - 10, 0.5f * static_cast<float>(y) - 10, height(random)});
      const uint32_t at = y * kSide + x;
      if (x + 1 < kSide && y + 1 < kSide)
        indices.insert(indices.end(), {at, at + 1, at + kSide, at + 1, at + kSide + 1, at + kSide});
    }
  return meshOf(positions, indices);
}

Transform movedBy(double x, double y, double z) {
  Transform transform;
  transform.rows = {1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, z};
  return transform;
}

/// Our simulator, and another one of the same scene whose results stay on the device.
class Ours {
 public:
  Ours(const Scene& scene, const SensorRequest& request, const SimulatorOptions& options, size_t views)
      : host(scene, request, options) {
    if (options.device.kind != DeviceChoice::Kind::vulkan) return;
    SimulatorOptions onDevice = options;
    onDevice.resultsOnDevice = true;
    device.emplace(scene, request, onDevice);
    stream.emplace(*device, BatchStreamOptions{views});
  }

  /// Adds instances to both simulators, and returns their indices.
  std::vector<uint32_t> addInstances(std::span<const Instance> instances) {
    if (device) device->addInstances(instances);
    return host.addInstances(instances);
  }

  Simulator host;
  std::optional<Simulator> device;
  std::optional<BatchStream> stream;
};

class BatchMeasurement {
 public:
  explicit BatchMeasurement(Session& session) : session_(session) {}

  void run() {
    town();
    townWithEffects();
    const size_t most = session_.options().frames;
    worlds(heightScan(), most, false);
    worlds(headOf(300, 30), (most + 3) / 4, false);
    worlds(headOf(300, 30), (most + 3) / 4, true);
  }

  Report report() const {
    Report report;
    Table& table = report.tables.emplace_back();
    table.rows = {
        {"scene", "views", "batch ms/view", "on device", "one by one", "Embree", "ours, M rays/s", "Embree's", "MB"}};
    report.panel = {rows_[0].what, "views in one call", "ms per view, median", {}};
    report.panel.series = {{"together", cli::Marker::circle, "#009e73", "", 4, {}},
                           {"on the device", cli::Marker::square, "#cc79a7", "", 4, {}},
                           {"one by one", cli::Marker::cross, "#d55e00", "", 4, {}},
                           {"Embree", cli::Marker::triangle, "#0072b2", "", 4, {}}};
    for (const BatchRow& row : rows_) {
      const std::vector<double>* const columns[] = {&row.batch, &row.streamed, &row.single, &row.embree};
      cli::TableRow cells = {row.what, cli::grouped(row.views)};
      for (size_t i = 0; i < std::size(columns); ++i) {
        const double ms = row.perView(*columns[i]);
        cells.push_back(ms > 0 ? formatted("%.4f", ms) : "-");
        if (ms > 0 && row.what == rows_[0].what)
          report.panel.series[i].points.push_back({static_cast<double>(row.views), ms, 0, 0, ""});
      }
      cells.push_back(formatted("%.2f", row.raysPerSecond(row.batch, row.moving) / 1e6));
      cells.push_back(row.embree.empty() ? "-" : formatted("%.2f", row.raysPerSecond(row.embree, row.renewing) / 1e6));
      cells.push_back(formatted("%.1f", static_cast<double>(row.memoryBytes) / 1e6));
      table.rows.push_back(cells);
      report.more["rows"].push_back(jsonOf(row));
    }
    table.note =
        "Medians. Rays per second count the movement of all boxes and the renewal of Embree's trees, times per view do "
        "not. All give ranges alone, but scans one by one also points and owners. On device: the ranges stay there. "
        "MB: device memory of the scene, the "
        "sensor and their lists after the batch";
    return report;
  }

 private:
  void town() {
    const Scene scene = doubleSidedTown();
    const Sensor sensor = session_.options().sensor.empty() ? headOf(360, 100) : session_.sensors({})[0];
    Ours ours(scene, {sensor, Effects::none()}, session_.simulatorOptions(), session_.options().frames);
    session_.setDevice(ours.host.device());
    const std::unique_ptr<EmbreeRival> embree = embreeFor(scene, EmbreeWay::flat);
    std::mt19937 random(1);
    for (size_t views = 1; views <= session_.options().frames; views = views == 512    ? 1024
                                                                       : views == 1024 ? 4096
                                                                                       : 8 * views) {
      measureTown("town", ours, sensor, townShots(views, random), embree.get());
    }
  }

  /// The same head with noise and intensities, a head whose beams change from scan to scan, and a real head with its
  /// own effects, which stands and then moves.
  void townWithEffects() {
    const Scene scene = doubleSidedTown();
    const size_t views = std::min<size_t>(session_.options().frames, 1024);
    std::mt19937 random(1);
    const std::vector<Shot> shots = townShots(views, random);
    Effects noise = Effects::none();
    noise.intensity.use = noise.rangeNoise.use = EffectUse::on;
    noise.rangeNoise.sigma = 0.02;
    Sensor real = builtinSensor("Puck");
    real.columns = 360;
    const std::tuple<const char*, Sensor, Effects> cases[] = {
        {"town, noise and intensity", headOf(360, 100), noise},
        {"town, Mid-40", builtinSensor("Mid-40"), Effects::none()},
        {"town, Puck of 360 columns, default", real, Effects()}};
    for (const auto& [what, sensor, effects] : cases) {
      Ours ours(scene, {sensor, effects}, session_.simulatorOptions(), views);
      measureTown(what, ours, sensor, shots, nullptr);
      if (sensor.name != real.name) continue;
      std::vector<Shot> moving = shots;
      for (Shot& shot : moving) shot.motion = drivenFrom(shot.pose, sensor.rotationPeriod);
      measureTown(formatted("%s, moving", what), ours, sensor, moving, nullptr);
    }
  }

  Scene doubleSidedTown() const {
    Scene scene = session_.scene();
    for (Material& material : scene.materials) material.doubleSided = true;  // rivals see both faces
    return scene;
  }

  static std::vector<Shot> townShots(size_t views, std::mt19937& random) {
    std::uniform_real_distribution<double> along(-60, 60), across(-6, 6), turn(-3, 3);
    std::vector<Shot> shots(views);
    for (Shot& shot : shots) {
      const double yaw = turn(random);
      shot.frame = static_cast<uint64_t>(&shot - shots.data());
      shot.pose = {{along(random), across(random), 1.8}, {0, 0, std::sin(yaw / 2), std::cos(yaw / 2)}};
    }
    return shots;
  }

  void measureTown(const std::string& what, Ours& ours, const Sensor& sensor, const std::vector<Shot>& shots,
                   EmbreeRival* embree) {
    BatchRow row = {what, shots.size(), sensor.beamCount(), {}, {}, {}, {}, {}, {}};
    for (uint32_t run = 0; run <= session_.options().runs; ++run) step(run, ours, sensor, shots, shots, embree, row);
    rows_.push_back(row);
  }

  /// Each world has its own boxes on a common ground. Embree sees the worlds side by side, out of reach of each other.
  /// If the boxes move `during` the scans, each beam meets them where they are when it fires, and Embree is left out.
  void worlds(Sensor sensor, size_t count, bool during) {
    if (during) sensor.rotationPeriod = 0.1;
    std::mt19937 random(1);
    std::uniform_real_distribution<double> anywhere(-8, 8), near(-1, 1), walk(-0.1, 0.1);
    Scene scene, apart;
    scene.materials.emplace_back();
    scene.materials[0].doubleSided = true;
    scene.meshes = {ground(random), box()};
    apart.materials = scene.materials;
    apart.meshes = scene.meshes;
    scene.instances.push_back({"", 0, {}});
    const double spacing = sensor.rangeMax + 25, side = std::ceil(std::sqrt(static_cast<double>(count)));
    std::vector<double> places;
    std::vector<Instance> boxes;
    std::vector<Moved> moved;
    std::vector<Shot> shots(count), shotsApart(count);
    std::vector<Vec3> middles(count);
    for (size_t world = 0; world < count; ++world) {
      Vec3& middle = middles[world];
      middle = {spacing * (std::fmod(static_cast<double>(world), side) - side / 2),
                spacing * (std::floor(static_cast<double>(world) / side) - side / 2), 0};
      apart.instances.push_back({"", 0, movedBy(middle.x, middle.y, 0)});
      for (size_t k = 0; k < kBoxes; ++k) {
        const double x = anywhere(random), y = anywhere(random);
        boxes.push_back({"", 1, movedBy(x, y, 0.3), 0, "", static_cast<uint32_t>(world + 1)});
        places.insert(places.end(), {x, y, 0.3, 0, 0, 0, 1});
        moved.push_back({apart.instances.size(), movedBy(middle.x + x, middle.y + y, 0.3)});
        apart.instances.push_back({"", 1, moved.back().transform});
      }
      shots[world].pose.position = {near(random), near(random), 0.8};
      shots[world].world = static_cast<uint32_t>(world + 1);
      const Vec3& at = shots[world].pose.position;
      shotsApart[world].pose.position = {middle.x + at.x, middle.y + at.y, at.z};
    }
    Effects effects = Effects::none();
    if (during) effects.objectMotion.use = EffectUse::on;
    Ours ours(scene, {sensor, effects}, session_.simulatorOptions(), count);
    const std::vector<uint32_t> numbers = ours.addInstances(boxes);
    const std::unique_ptr<EmbreeRival> embree = during ? nullptr : embreeFor(apart, EmbreeWay::placed);
    const std::string what = formatted("%zu worlds, %s%s", count, sensor.name.c_str(), during ? ", moving" : "");
    BatchRow row = {what, count, sensor.beamCount(), {}, {}, {}, {}, {}, {}};
    for (uint32_t run = 0; run <= session_.options().runs; ++run) {
      for (size_t i = 0; i < moved.size(); ++i) {
        for (size_t axis = 0; axis < 2; ++axis) places[7 * i + axis] += walk(random);
        const Vec3& middle = middles[i / kBoxes];
        moved[i].transform = movedBy(middle.x + places[7 * i], middle.y + places[7 * i + 1], 0.3);
        if (!during) continue;
        std::vector<InstanceMotion>& motions = shots[i / kBoxes].instanceMotions;
        if (i % kBoxes == 0) motions.clear();
        motions.push_back({numbers[i], movedBy(places[7 * i] + walk(random), places[7 * i + 1] + walk(random), 0.3)});
      }
      const double start = cli::nowMs();
      ours.host.setTransforms(numbers, std::span<const double>(places));
      if (run > 0) row.moving.push_back(cli::nowMs() - start);
      if (ours.device) ours.device->setTransforms(numbers, std::span<const double>(places));
      if (embree) {
        const double ms = embree->update(moved);
        if (run > 0) row.renewing.push_back(ms);
      }
      step(run, ours, sensor, shots, shotsApart, embree.get(), row);
    }
    rows_.push_back(row);
  }

  std::unique_ptr<EmbreeRival> embreeFor(const Scene& scene, EmbreeWay way) {
    if (!haveEmbree() || session_.options().rivals == "none") {
      session_.addNote("Embree, which is not asked for or not installed");
      return nullptr;
    }
    noPanes_.assign(scene.materials.size(), false);
    auto embree = makeEmbree(scene, {}, way);
    embree->build();
    return embree;
  }

  /// Scans the shots together, the first of them one by one, and traces all with Embree. Run 0 compares the results;
  /// the others are timed.
  void step(uint32_t run, Ours& ours, const Sensor& sensor, const std::vector<Shot>& shots,
            const std::vector<Shot>& shotsOfEmbree, EmbreeRival* embree, BatchRow& row) {
    double start = cli::nowMs();
    ours.host.scanBatchInto(shots, batch_, kRange);
    const double batchMs = cli::nowMs() - start;
    const MemoryUse memory = ours.host.memory();
    row.memoryBytes = memory.scene + memory.sensor + memory.work;
    if (ours.stream) {
      start = cli::nowMs();
      const StreamedBatch streamed = ours.stream->wait(ours.stream->submit(shots));
      if (run > 0)
        row.streamed.push_back(cli::nowMs() - start);
      else
        requireSame(streamed);
    }
    const size_t singles = std::min(shots.size(), kSingles);
    double singleMs = 0;
    for (size_t i = 0; i < singles; ++i) {
      start = cli::nowMs();
      ours.host.scanInto(shots[i], scan_);
      singleMs += cli::nowMs() - start;
      const size_t entries = scan_.ranges.size();
      if (run == 0 && std::memcmp(scan_.ranges.data(), &batch_.ranges()[i * entries], 4 * entries) != 0)
        throw Error(ErrorCode::device, formatted("wrong: view %zu of a batch has other ranges than its scan", i));
    }
    if (run > 0) row.batch.push_back(batchMs);
    if (run > 0) row.single.push_back(singleMs * static_cast<double>(shots.size()) / static_cast<double>(singles));
    if (!embree) return;
    const size_t together = std::max<size_t>(1, kLinesAtOnce / row.beams);
    uint64_t differ = 0;
    double embreeMs = 0;
    for (size_t first = 0; first < shots.size(); first += together) {
      const size_t end = std::min(shots.size(), first + together);
      Lines lines;
      for (size_t i = first; i < end; ++i) {
        const Lines own = linesOf(sensor, Effects(), false, shotsOfEmbree[i], {});
        lines.packets.insert(lines.packets.end(), own.packets.begin(), own.packets.end());
      }
      lines.count = lines.packets.size() * kPacketLines;
      embreeMs += embree->trace(lines, noPanes_, hits_);
      const size_t stride = lines.count / (end - first);
      for (size_t i = first; run == 0 && i < end; ++i)
        differ += unlike(&batch_.ranges()[i * row.beams], &hits_.ranges[(i - first) * stride], row.beams);
    }
    if (static_cast<double>(differ) > kAgreement * static_cast<double>(row.views * row.beams) + 1)
      throw Error(ErrorCode::device,
                  formatted("wrong: %s of %s ranges differ from Embree's", cli::grouped(differ).c_str(),
                            cli::grouped(row.views * row.beams).c_str()));
    if (run > 0) row.embree.push_back(embreeMs);
  }

  /// Compares the returns of each view on the device with those on the host.
  void requireSame(const StreamedBatch& streamed) const {
    const size_t entries = batch_.entries() / batch_.views;
    for (size_t view = 0; view < streamed.views; ++view) {
      const std::span<const float> ranges = batch_.ranges().subspan(view * entries, entries);
      const auto hits = std::ranges::count_if(ranges, [](float range) { return !std::isnan(range); });
      if (!streamed.complete || streamed.headers[view].hits != static_cast<uint64_t>(hits))
        throw Error(ErrorCode::device, formatted("wrong: view %zu has %u returns on the device, %zu on the host%s",
                                                 view, streamed.headers[view].hits, static_cast<size_t>(hits),
                                                 streamed.complete ? "" : ", and a list was too small"));
    }
  }

  static uint64_t unlike(const float* ours, const float* theirs, size_t count) {
    uint64_t differ = 0;
    for (size_t i = 0; i < count; ++i)
      differ += std::isnan(ours[i]) != std::isnan(theirs[i]) || std::abs(ours[i] - theirs[i]) > 1e-3f + 1e-4f * ours[i];
    return differ;
  }

  static cli::Json jsonOf(const BatchRow& row) {
    const auto times = [](const std::vector<double>& ms) {
      const Spread spread = spreadOf(ms);
      return cli::Json{{"median", rounded(spread.median)}, {"min", rounded(spread.min)}, {"p90", rounded(spread.p90)}};
    };
    cli::Json json = {{"scene", row.what},
                      {"views", row.views},
                      {"beams", row.beams},
                      {"batch_ms_per_view", rounded(row.perView(row.batch))},
                      {"one_by_one_ms_per_view", rounded(row.perView(row.single))},
                      {"batch_ms", times(row.batch)},
                      {"one_by_one_ms", times(row.single)},
                      {"memory_bytes", row.memoryBytes}};
    if (!row.streamed.empty()) json["on_device_ms"] = times(row.streamed);
    if (!row.moving.empty()) json["move_ms"] = times(row.moving);
    if (!row.embree.empty()) json["embree_ms"] = times(row.embree);
    if (!row.renewing.empty()) json["embree_renew_ms"] = times(row.renewing);
    return json;
  }

  Session& session_;
  std::vector<BatchRow> rows_;
  Batch batch_;
  Scan scan_;
  LineHits hits_;
  std::vector<bool> noPanes_;  ///< by material
};

}  // namespace

Report batches(Session& session) {
  BatchMeasurement measurement(session);
  measurement.run();
  return measurement.report();
}

}  // namespace gnosphere::bench

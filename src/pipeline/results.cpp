// SPDX-License-Identifier: Apache-2.0
#include "pipeline/results.hpp"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <utility>

#include "base/clock.hpp"
#include "base/threads.hpp"
#include "common/effects/incidence.h"
#include "effects/trajectory.hpp"
#include "geometry/pose.hpp"
#include "pipeline/resolve_words.hpp"
#include "scan/columns.hpp"
#include "sensor/beams.hpp"

namespace gnosphere {
namespace {

// A triangle that was read has been culled for one of these reasons, or projected.
constexpr uint32_t gpu::Counters::*kFates[] = {&gpu::Counters::nonFinite,      &gpu::Counters::culledByRange,
                                               &gpu::Counters::culledByFace,   &gpu::Counters::culledBetweenBeams,
                                               &gpu::Counters::culledHidden,   &gpu::Counters::projectedSmall,
                                               &gpu::Counters::projectedLarge, &gpu::Counters::tried};

// Resolving fewer beams than this is not worth waking a thread: 4,000 take about 0.06 ms, and waking a thread 0.01 ms.
constexpr uint64_t kBeamsPerThread = 4'000;

// Calls work(first, end) for slices of 0..count - 1 on several threads. Each item stands for `beamsEach` beams.
template <typename Work>
void inSlices(Workers& workers, uint64_t count, uint64_t beamsEach, const Work& work) {
  const uint64_t threads = std::clamp<uint64_t>(count * beamsEach / kBeamsPerThread, 1, threadCount());
  const uint64_t slices = threads > 1 ? 8 * threads : 1;
  workers.inRuns(count, (count + slices - 1) / slices, threads, work);
}

// Adds the time since `start` as that of stage resolve, if the stages on the device are timed.
void addResolve(Clock::time_point start, Timings& timings) {
  if (!timings.stages.empty()) timings.add("resolve", millisecondsSince(start));
}

// Returns into how many runs resolveWords() can divide the beams of a table, and how many beams each has.
std::pair<uint64_t, uint64_t> runsOf(const BeamTables& tables) {
  if (tables.listed || tables.mapped) return {tables.numbers.size(), 1};
  return {tables.frame.rows, tables.frame.columns};
}

// Resolves the words of all rows on several threads; returns the number of hits.
uint64_t readWords(Workers& workers, const SensorPlan& plan, const DeviceResults& device,
                   const InstanceTable& instances, const ShotMotion* motion, Scan& scan) {
  const Clock::time_point start = Clock::now();
  const BeamTables& tables = *device.tables[0];
  const auto [count, each] = runsOf(tables);
  std::atomic<uint64_t> hits = 0;
  inSlices(workers, count, each, [&](uint64_t first, uint64_t end) {
    hits += resolveWords(plan, {device.words, device.laterWords}, tables, instances, motion,
                         static_cast<uint32_t>(first), static_cast<uint32_t>(end), placesOf(scan));
  });
  addResolve(start, scan.timings);
  return hits;
}

// The counters of a scan without effects that lose returns: a beam without a return met nothing.
gpu::Counters withHits(gpu::Counters counters, uint64_t hits, uint64_t beams, uint32_t masked) {
  counters.hits = counters.causes[gpu::kCauseReturned] = static_cast<uint32_t>(hits);
  counters.causes[gpu::kCauseDead] = masked;
  counters.causes[gpu::kCauseNoSurface] = static_cast<uint32_t>(beams - masked - hits);
  return counters;
}

void readCounters(const SensorPlan& plan, uint64_t beams, const gpu::Counters& device, uint64_t usableTriangles,
                  Counters& result) {
  const bool signals = plan.signals();
  const uint64_t hits = signals ? device.causes[0] : device.hits;
  result.hits += hits;
  result.misses += beams - hits;
  if (signals)
    for (size_t i = 0; i < kCauseCount; ++i) result.causes[i] += device.causes[i];
  result.nonFinite += device.nonFinite;
  result.culledByCluster += usableTriangles - device.triangles;
  result.culledByRange += device.culledByRange;
  result.culledByFace += device.culledByFace;
  result.culledBetweenBeams += device.culledBetweenBeams;
  result.culledHidden += device.culledHidden;
  result.projected += uint64_t{device.projectedSmall} + device.projectedLarge + device.tried;
  result.candidates += uint64_t{device.candidates} + device.ownLinks;
  result.lostEchoes += device.lostEchoes;
  result.integerSides += device.integerSides;
  result.integerRanges += device.integerRanges;
}

void readPoints(const DeviceResults& device, uint64_t first, uint64_t count, Scan& scan) {
  for (uint64_t entry = first; entry < first + count; ++entry) {
    const gpu::vec4& point = device.points[entry];
    std::copy_n(&point.x, 3, &scan.points[3 * entry]);
    scan.ranges[entry] = point.w;
    scan.triangles[entry] = device.owners[entry][0];
    const uint32_t instance = device.owners[entry][1];
    const bool inView = !device.inViews.empty() && instance != gpu::kNone;
    scan.instances[entry] = inView ? device.inViews[instance].instance : instance;
  }
}

// Returns how many beams have hit something. The first return of a beam is there if any is.
uint64_t hitsAmong(const Scan& scan, uint64_t firstBeam, uint64_t endBeam) {
  uint64_t hits = 0;
  for (uint64_t beam = firstBeam; beam < endBeam; ++beam) hits += scan.triangles[beam * scan.returns] != gpu::kNone;
  return hits;
}

void readSignals(const gpu::SignalRecord* signals, uint64_t first, uint64_t count, uint32_t returns, Scan& scan) {
  if (!signals) return;
  const ScanColumns columns(scan);
  float* const trueRanges = columns.data<float>(Field::trueRange) + first;
  float* const widths = columns.data<float>(Field::width) + first;
  uint8_t* const labels = columns.data<uint8_t>(Field::label) + first;
  uint8_t* const causes = columns.data<uint8_t>(Field::cause) + first;
  for (uint64_t i = 0; i < count; ++i) {
    const gpu::SignalRecord& signal = signals[i];
    trueRanges[i] = signal.trueRange;
    widths[i] = signal.width;
    labels[i] = static_cast<uint8_t>(signal.word & 0xff);
    // The cause of a beam is stored in its first return.
    causes[i] = i % returns == 0 ? static_cast<uint8_t>(signal.word >> 8 & 0xff) : causes[i - 1];
  }
}

// Computes angles of incidence, from the directions of beams in the frame in which points are reported. Usually that is
// the direction of the point, but not if lasers are beside the sensor's origin, if noise moves points off their beams
// or to the range 0, or with deskew.
class Incidence {
 public:
  Incidence(const SensorPlan& plan, const Shot& shot, const Scan& scan)
      : plan_(plan),
        shot_(shot),
        scan_(scan),
        turned_(plan.has(gpu::kSensorMotion) && plan.effects.sensorMotion.deskew && !shot.motion.stamps.empty()) {
    atPoint_ = !turned_ && plan.pointsTellDirections();
  }

  float of(uint64_t entry, const gpu::vec3& normal) const {
    if (!atPoint_) return gpu::incidenceOf(normal, directionOf(entry), 1);
    const float* point = &scan_.points[3 * entry];
    return gpu::incidenceOf(normal, {point[0], point[1], point[2]}, scan_.ranges[entry]);
  }

 private:
  gpu::vec3 directionOf(uint64_t entry) const {
    const uint64_t beam = entry / scan_.returns;
    const Vec3 d = gnosphere::directionOf(plan_.sensor, beam, shot_.frame);
    glm::dvec3 direction(d.x, d.y, d.z);
    if (turned_) {
      const double time = timeOf(plan_.sensor, beam, shot_.frame);
      direction =
          glm::conjugate(rotationOf(shot_.pose)) * (rotationOf(poseAt(shot_.motion, shot_.pose, time)) * direction);
    }
    return gpu::vec3(direction);
  }

  const SensorPlan& plan_;
  const Shot& shot_;
  const Scan& scan_;
  bool turned_, atPoint_;
};

void readSurfaces(const gpu::SurfaceRecord* surfaces, const Incidence& incidence, uint64_t first, uint64_t count,
                  Scan& scan) {
  const ScanColumns columns(scan);
  float* const normals = columns.data<float>(Field::normal) + 3 * first;
  float* const incidences = columns.data<float>(Field::incidence) + first;
  uint32_t* const materials = columns.data<uint32_t>(Field::material) + first;
  for (uint64_t i = 0; i < count; ++i) {
    const gpu::SurfaceRecord& surface = surfaces[i];
    const bool hit = scan.triangles[first + i] != kNoTriangle;
    const glm::vec3 normal = hit ? glm::vec3(surface.normal.x, surface.normal.y, surface.normal.z) : glm::vec3(NAN);
    std::copy_n(&normal.x, 3, normals + 3 * i);
    incidences[i] = hit ? incidence.of(first + i, normal) : NAN;
    materials[i] = hit ? surface.material : kNoTriangle;
  }
}

void readBarycentrics(const gpu::vec2* weights, uint64_t first, uint64_t count, Scan& scan) {
  if (!weights) return;
  float* const barycentrics = ScanColumns(scan).data<float>(Field::barycentrics) + 2 * first;
  for (uint64_t i = 0; i < count; ++i) {
    const bool hit = scan.triangles[first + i] != kNoTriangle;
    barycentrics[2 * i] = hit ? weights[i].x : NAN;
    barycentrics[2 * i + 1] = hit ? weights[i].y : NAN;
  }
}

void readMotions(const gpu::vec4* motions, uint64_t first, uint64_t count, Scan& scan) {
  if (!motions) return;
  const ScanColumns columns(scan);
  float* const velocities = columns.data<float>(Field::velocity) + 3 * first;
  float* const radialSpeeds = columns.data<float>(Field::radialSpeed) + first;
  for (uint64_t i = 0; i < count; ++i) {
    const gpu::vec4& motion = motions[i];
    std::copy_n(&motion.x, 3, velocities + 3 * i);
    radialSpeeds[i] = motion.w;
  }
}

}  // namespace

void clearResult(const SensorPlan& plan, const InstanceTable& instances, uint32_t world, Scan& scan) {
  resizeArrays(plan, scan);
  ScanColumns columns(scan);
  for (const Field field : {Field::tie, Field::tolerance}) columns.make(field, false);
  scan.timings.stages.clear();
  scan.timings.gpuMs = 0;
  scan.counters = {};
  scan.counters.beams = plan.sensor.beamCount();
  countPlaced(instances, world, scan.counters);
}

void countPlaced(const InstanceTable& instances, uint32_t world, Counters& counters) {
  const WorldContent placed = instances.contentOf(world);
  counters.triangles += placed.triangles;
  counters.nonFinite += placed.nonFinite;
  counters.degenerate += placed.degenerate;
}

gpu::Counters takeShare(gpu::Counters& counters, uint64_t triangles, uint64_t all) {
  if (triangles == all) return std::exchange(counters, {});
  using Counts = std::array<uint32_t, sizeof counters / sizeof(uint32_t)>;
  auto left = std::bit_cast<Counts>(counters), taken = left;
  for (uint32_t& word : taken) word = static_cast<uint32_t>(word * triangles / all);
  auto share = std::bit_cast<gpu::Counters>(taken);
  uint64_t fates = 0, wanted = share.triangles;
  for (const auto fate : kFates) fates += counters.*fate;
  if (fates == counters.triangles)  // as for the whole; with motion, some triangles may have several
    for (const auto fate : kFates) {
      const uint64_t part = fates > 0 ? counters.*fate * wanted / fates : 0;
      share.*fate = static_cast<uint32_t>(part);
      fates -= counters.*fate;
      wanted -= part;
    }
  taken = std::bit_cast<Counts>(share);
  for (size_t i = 0; i < left.size(); ++i) left[i] -= taken[i];
  counters = std::bit_cast<gpu::Counters>(left);
  return share;
}

void readResults(Workers& workers, const SensorPlan& plan, const DeviceResults& device, const InstanceTable& instances,
                 const Shot& shot, const ShotMotion* motion, Scan& scan) {
  const BeamTables& tables = *device.tables[0];
  const bool part = tables.listed && tables.numbers.size() < plan.sensor.beamCount();
  const uint64_t beams = part ? tables.numbers.size() : plan.sensor.beamCount();
  const bool computed = plan.computesReturns();
  std::atomic<uint64_t> hits = 0;
  if (device.words) hits = readWords(workers, plan, device, instances, motion, scan);
  const uint32_t returns = plan.returns;
  const auto read = [&](uint64_t beam, uint64_t beamEnd) {
    const uint64_t first = beam * returns, count = (beamEnd - beam) * returns;
    const auto from = [&](const auto* output) { return output ? output + first : nullptr; };
    if (device.points) readPoints(device, first, count, scan);
    if (device.points && !computed) hits += hitsAmong(scan, beam, beamEnd);
    if (device.intensities)
      std::copy_n(device.intensities + first, count, ScanColumns(scan).data<float>(Field::intensity) + first);
    readSignals(from(device.signals), first, count, returns, scan);
    if (device.surfaces) readSurfaces(from(device.surfaces), Incidence(plan, shot, scan), first, count, scan);
    readMotions(from(device.motions), first, count, scan);
    readBarycentrics(from(device.barycentrics), first, count, scan);
  };
  if (part)
    for (const uint32_t beam : tables.numbers) read(beam, beam + 1);
  else if (!device.words || computed)
    inSlices(workers, beams, 1, read);
  const gpu::Counters counters = computed ? device.counters : withHits(device.counters, hits, beams, tables.masked);
  readCounters(plan, beams, counters, instances.contentOf(shot.world).usableTriangles(), scan.counters);
}

void readHits(Workers& workers, const SensorPlan& plan, const DeviceResults& device, const InstanceTable& instances,
              std::span<const Shot> shots, ShotMotions motions, const Places& to, Scan& sum) {
  const Clock::time_point start = Clock::now();
  const uint64_t beams = plan.sensor.beamCount(), all = shots.size() * beams;
  std::atomic<uint64_t> hits = 0;
  const auto resolve = [&](uint64_t view, uint64_t first, uint64_t end) {
    const BeamTables& tables = *device.tables[view];
    hits += resolveWords(plan, {device.words + view * tables.frame.beams}, tables, instances, motionOf(motions, view),
                         static_cast<uint32_t>(first), static_cast<uint32_t>(end), to.from(view * beams));
  };
  if (shots.size() == 1) {
    const auto [count, each] = runsOf(*device.tables[0]);
    inSlices(workers, count, each, [&](uint64_t first, uint64_t end) { resolve(0, first, end); });
  } else {
    inSlices(workers, shots.size(), beams, [&](uint64_t first, uint64_t end) {
      for (uint64_t view = first; view < end; ++view) resolve(view, 0, runsOf(*device.tables[view]).first);
    });
  }
  addResolve(start, sum.timings);
  uint64_t usable = 0;
  for (const Shot& shot : shots) {
    usable += instances.contentOf(shot.world).usableTriangles();
    countPlaced(instances, shot.world, sum.counters);
  }
  sum.counters.beams += all;
  const auto masked = static_cast<uint32_t>(shots.size() * device.tables[0]->masked);
  readCounters(plan, all, withHits(device.counters, hits, all, masked), usable, sum.counters);
}

}  // namespace gnosphere

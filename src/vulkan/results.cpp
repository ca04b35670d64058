// SPDX-License-Identifier: Apache-2.0
#include "vulkan/results.hpp"

#include <algorithm>
#include <cmath>
#include <thread>

namespace gnosphere::vulkan {
namespace {

// A copy of fewer returns is not worth a thread.
constexpr uint64_t kReturnsPerThread = 500'000;

// work(first, end) for slices of 0..count, all at once.
template <typename Work>
void inSlices(uint64_t count, const Work& work) {
  const uint64_t threads =
      std::clamp<uint64_t>(count / kReturnsPerThread, 1, std::max(1u, std::thread::hardware_concurrency()));
  std::vector<std::jthread> others;
  for (uint64_t k = 1; k < threads; ++k) others.emplace_back(work, k * count / threads, (k + 1) * count / threads);
  work(0, count / threads);
}

// What the host reads of an output; null if there is no such output.
template <typename T>
const T* mapped(const SensorState& part, const FrameInFlight& frame, uint32_t binding) {
  for (size_t i = 0; i < part.outputs().size(); ++i) {
    if (part.outputs()[i].binding != binding) continue;
    frame.results[i].invalidate();
    return static_cast<const T*>(frame.results[i].mapped());
  }
  return nullptr;
}

void readCounters(const SensorState& part, const gpu::Counters& device, uint64_t usableTriangles, Counters& result) {
  const uint64_t beams = part.frame().beams;
  const bool judged = part.planned().signals();
  const uint64_t hits = judged ? device.causes[0] : device.hits;
  result.hits += hits;
  result.misses += beams - hits;
  if (judged)
    for (size_t i = 0; i < kCauseCount; ++i) result.causes[i] += device.causes[i];
  result.nonFinite += device.nonFinite;
  result.culledByCluster += usableTriangles - device.triangles;
  result.culledByRange += device.culledByRange;
  result.culledByFace += device.culledByFace;
  result.culledBetweenBeams += device.culledBetweenBeams;
  result.projected += uint64_t{device.projectedSmall} + device.projectedLarge;
  result.candidates += device.candidates;
  result.integerSides += device.integerSides;
  result.integerRanges += device.integerRanges;
}

void readSignals(const gpu::vec4* signals, uint64_t first, uint64_t count, uint32_t returns, Scan& scan) {
  if (!signals) return;
  for (uint64_t i = 0; i < count; ++i) {
    const gpu::vec4& signal = signals[i];
    const auto word = std::bit_cast<uint32_t>(signal.w);
    scan.intensities[first + i] = signal.x;
    scan.trueRanges[first + i] = signal.y;
    scan.widths[first + i] = signal.z;
    scan.labels[first + i] = static_cast<uint8_t>(word & 0xff);
    if (i % returns == 0) scan.causes[(first + i) / returns] = static_cast<uint8_t>(word >> 8 & 0xff);
  }
}

void readSurfaces(const gpu::vec4* surfaces, uint64_t first, uint64_t count, Scan& scan) {
  if (!surfaces) return;
  for (uint64_t i = 0; i < count; ++i) {
    const gpu::vec4& surface = surfaces[i];
    const bool hit = scan.triangles[first + i] != kNoTriangle;
    const float* point = &scan.points[3 * (first + i)];
    float* normal = &scan.normals[3 * (first + i)];
    normal[0] = hit ? surface.x : NAN;
    normal[1] = hit ? surface.y : NAN;
    normal[2] = hit ? surface.z : NAN;
    const float along = -(normal[0] * point[0] + normal[1] * point[1] + normal[2] * point[2]) / scan.ranges[first + i];
    scan.incidences[first + i] = std::acos(std::clamp(along, 0.0f, 1.0f));
    scan.materials[first + i] = hit ? std::bit_cast<uint32_t>(surface.w) : kNoTriangle;
  }
}

void readBarycentrics(const gpu::vec2* weights, uint64_t first, uint64_t count, Scan& scan) {
  if (!weights) return;
  for (uint64_t i = 0; i < count; ++i) {
    const bool hit = scan.triangles[first + i] != kNoTriangle;
    scan.barycentrics[2 * (first + i)] = hit ? weights[i].x : NAN;
    scan.barycentrics[2 * (first + i) + 1] = hit ? weights[i].y : NAN;
  }
}

void readMotions(const gpu::vec4* motions, uint64_t first, uint64_t count, Scan& scan) {
  if (!motions) return;
  for (uint64_t i = 0; i < count; ++i) {
    const gpu::vec4& motion = motions[i];
    std::copy_n(&motion.x, 3, &scan.velocities[3 * (first + i)]);
    scan.radialSpeeds[first + i] = motion.w;
  }
}

}  // namespace

void clearResult(std::span<const SensorState> parts, const Instances& instances, Scan& scan) {
  const PlannedEffects& planned = parts[0].planned();
  size_t beams = 0;
  for (const SensorState& part : parts) beams += part.frame().beams;
  const size_t count = beams * planned.returns;
  scan.returns = planned.returns;
  scan.points.resize(3 * count);
  scan.ranges.resize(count);
  scan.triangles.resize(count);
  scan.instances.resize(count);
  const auto wants = [&](bool asked, size_t size) { return asked ? size : 0; };
  const bool signal = planned.asks(gpu::kFieldSignal), surface = planned.asks(gpu::kFieldSurface);
  for (auto* array : {&scan.intensities, &scan.trueRanges, &scan.widths}) array->resize(wants(signal, count));
  scan.labels.resize(wants(signal, count));
  scan.causes.resize(wants(signal, beams));
  scan.normals.resize(wants(surface, 3 * count));
  scan.incidences.resize(wants(surface, count));
  scan.materials.resize(wants(surface, count));
  scan.velocities.resize(wants(planned.speeds(), 3 * count));
  scan.radialSpeeds.resize(wants(planned.speeds(), count));
  scan.barycentrics.resize(wants(planned.asks(gpu::kFieldBarycentrics), 2 * count));
  scan.tolerances.clear();
  scan.ties.clear();
  scan.timings.stages.clear();
  scan.timings.gpuMs = 0;
  scan.counters = {};
  scan.counters.beams = beams;
  const Counters& placed = instances.counters();
  scan.counters.triangles = parts.size() * placed.triangles;
  scan.counters.nonFinite = parts.size() * placed.nonFinite;
  scan.counters.degenerate = parts.size() * placed.degenerate;
}

void readResults(const SensorState& part, const FrameInFlight& frame, const Instances& instances, uint64_t firstBeam,
                 Scan& scan) {
  const uint32_t returns = part.planned().returns;
  const auto* points = mapped<gpu::vec4>(part, frame, gpu::kBindPoints);
  const auto* owners = mapped<std::array<uint32_t, 2>>(part, frame, gpu::kBindOwners);
  const auto* signals = mapped<gpu::vec4>(part, frame, gpu::kBindSignals);
  const auto* motions = mapped<gpu::vec4>(part, frame, gpu::kBindMotions);
  const auto* barycentrics = mapped<gpu::vec2>(part, frame, gpu::kBindBarycentrics);
  const gpu::vec4* surfaces = mapped<gpu::vec4>(part, frame, gpu::kBindSurfaces);
  inSlices(uint64_t{part.frame().beams}, [&](uint64_t beam, uint64_t beamEnd) {
    const uint64_t first = beam * returns, end = beamEnd * returns, to = firstBeam * returns;
    float* point = &scan.points[3 * (to + first)];
    for (uint64_t i = first; i < end; ++i) {
      *point++ = points[i].x;
      *point++ = points[i].y;
      *point++ = points[i].z;
      scan.ranges[to + i] = points[i].w;
      scan.triangles[to + i] = owners[i][0];
      scan.instances[to + i] = owners[i][1];
    }
    readSignals(signals ? signals + first : nullptr, to + first, end - first, returns, scan);
    readSurfaces(surfaces ? surfaces + first : nullptr, to + first, end - first, scan);
    readMotions(motions ? motions + first : nullptr, to + first, end - first, scan);
    readBarycentrics(barycentrics ? barycentrics + first : nullptr, to + first, end - first, scan);
  });
  readCounters(part, frame.counters(), instances.usableTriangles(), scan.counters);
}

}  // namespace gnosphere::vulkan

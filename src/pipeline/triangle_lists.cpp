// SPDX-License-Identifier: Apache-2.0
#include "pipeline/triangle_lists.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "base/limits.hpp"
#include "effects/arrays.hpp"
#include "gnosphere/error.hpp"

namespace gnosphere {
namespace {

using gpu::Array;

// Kernels hold indices in 32 bits, and the top bit is a sign when an array is addressed.
constexpr uint64_t kMostEntries = limits::kEntries.most;
constexpr uint64_t kTileBytes = 4 * sizeof(uint32_t);

// Triangles that a scan has projected, including those for which there was no room.
uint64_t projectedCount(const gpu::Counters& counters) {
  return uint64_t{counters.projectedSmall} + counters.projectedLarge;
}

// Returns `needed` entries plus an eighth in reserve, as far as the limit allows.
uint32_t grown(Array array, uint64_t needed, uint64_t limit, uint64_t most = kMostEntries) {
  if (needed > most)
    throw Error(ErrorCode::outOfMemory, "'" + std::string(gpu::nameOf(array)) + "' needs more than " +
                                            std::to_string(most) + " entries, which no kernel can address");
  return static_cast<uint32_t>(std::min(needed + needed / 8, std::max(needed, limit)));
}

uint32_t within(uint64_t count, uint64_t most) {
  return static_cast<uint32_t>(std::min(count, most));
}

}  // namespace

TriangleLists::TriangleLists(Machine& machine, const SensorPlan& plan, uint32_t binning, uint32_t beams,
                             uint64_t triangles)
    : machine_(machine),
      plan_(plan),
      binning_(binning),
      beams_(beams),
      first_(firstCapacities(binning, plan.panes(), plan.footprint(), beams, triangles)) {
  first_.projected = within(first_.projected, std::min(mostProjected(), limit(kTileBytes) / 2));
  first_.tiles = within(first_.tiles, limit(kTileBytes) - tilesBehind(first_));
  first_.candidates = within(first_.candidates, mostCandidates());
  resize(first_);
}

uint64_t TriangleLists::limit(uint64_t entryBytes) const {
  return std::min(kMostEntries, machine_.traits().info.maxBufferBytes / entryBytes);
}

uint64_t TriangleLists::mostProjected() const {
  uint64_t bytes = sizeof(gpu::vec4);
  for (const ArrayContent& array : projectedArrays(plan_, 1)) bytes = std::max(bytes, array.bytes);
  return limit(bytes);
}

// In a chain, a candidate has its range and a link to the next.
uint64_t TriangleLists::candidateBytes() const {
  return binning_ == gpu::kBinningLists ? 4 : 12;
}

// Kernels number the words of a chain, not its entries.
uint64_t TriangleLists::mostCandidates() const {
  return limit(sizeof(uint32_t)) / (candidateBytes() / sizeof(uint32_t));
}

// Number of tiles beyond Capacities::tiles: with slabs every projected triangle has one tile of its own.
uint64_t TriangleLists::tilesBehind(const Capacities& room) const {
  return binning_ == gpu::kBinningSlabs ? room.projected : 0;
}

uint64_t TriangleLists::bytesOf(const Capacities& room) const {
  uint64_t ofProjected = 2 * sizeof(gpu::TaggedCorner) + sizeof(gpu::vec4) + sizeof(gpu::vec2);
  for (const ArrayContent& array : projectedArrays(plan_, 1)) ofProjected += array.bytes;
  return room.projected * ofProjected + (tilesBehind(room) + room.tiles) * kTileBytes +
         room.candidates * candidateBytes();
}

// Reallocates the lists whose capacity changes. If memory runs out, all capacities stay zero, and the next scan makes
// the lists that it needs.
void TriangleLists::resize(const Capacities& room) {
  const Capacities had = std::exchange(capacities_, {});
  viewsThatFit_ = movingViewsThatFit_ = 0;
  const auto allocate = [&](Array array, uint64_t bytes) {
    arrays_.allocate(machine_, array, bytes, MemoryKind::device);
  };
  if (room.projected != had.projected) {
    const uint64_t count = room.projected;
    allocate(Array::projectedA, count * sizeof(gpu::TaggedCorner));
    allocate(Array::projectedB, count * sizeof(gpu::vec4));
    allocate(Array::projectedC, count * sizeof(gpu::TaggedCorner));
    allocate(Array::projectedColumns, count * sizeof(gpu::vec2));
    for (const ArrayContent& array : projectedArrays(plan_, count)) allocate(array.array, array.bytes);
  }
  if (const uint64_t tiles = tilesBehind(room) + room.tiles; tiles != tilesBehind(had) + had.tiles)
    allocate(Array::tiles, tiles * kTileBytes);
  if (room.candidates != had.candidates) allocate(Array::candidates, room.candidates * candidateBytes());
  capacities_ = room;
}

void TriangleLists::makeRoomForViews(uint32_t views) {
  Capacities room = capacities_;
  const uint64_t ofView =
      plan_.footprint() ? first_.projected : std::min(first_.projected, firstProjectedOfView(beams_));
  const uint64_t projected = std::min(ofView * views, mostProjected());
  room.projected = std::max(room.projected, static_cast<uint32_t>(projected));
  room.tiles = std::max(room.tiles, room.projected / 2);
  if (binning_ == gpu::kBinningLists)
    room.candidates = std::max(room.candidates, within(uint64_t{first_.candidates} * views, mostCandidates()));
  else if (plan_.footprint())
    room.candidates =
        std::max(room.candidates, within(leastWithFootprints(room.projected).candidates, mostCandidates()));
  resize(room);
}

void TriangleLists::numberViews() {
  if (capacities_.projected > 0)
    arrays_.makeRoom(machine_, Array::projectedViews, capacities_.projected * sizeof(uint32_t), MemoryKind::device);
}

bool TriangleLists::cutShort(const gpu::Counters& needed, const Capacities& had) {
  return projectedCount(needed) > had.projected || needed.tiles > had.tiles || needed.candidates > had.candidates;
}

// If one list was too small, the counts of later stages are too low; the next run finds out and grows those lists. The
// lists of footprints grow together, because another run takes long.
void TriangleLists::grow(gpu::Counters needed) {
  const uint64_t projected = projectedCount(needed);
  Capacities room = capacities_;
  if (plan_.footprint() && binning_ != gpu::kBinningLists && projected > room.projected) {
    const Capacities least = leastWithFootprints(projected);
    needed.tiles = std::max(needed.tiles, within(least.tiles, limit(kTileBytes) / 2));
    needed.candidates = std::max(needed.candidates, within(least.candidates, mostCandidates()));
  }
  if (projected > room.projected) room.projected = grown(Array::projectedA, projected, mostProjected());
  if (needed.tiles > room.tiles) room.tiles = grown(Array::tiles, needed.tiles, limit(kTileBytes));
  if (needed.candidates > room.candidates)
    room.candidates = grown(Array::candidates, needed.candidates, mostCandidates(),
                            kMostEntries * sizeof(uint32_t) / candidateBytes());
  // If the tiles do not fit together with the reserve, the lists get only what this scan needs.
  if (tilesBehind(room) + room.tiles > limit(kTileBytes)) {
    room.projected = static_cast<uint32_t>(projected);
    room.tiles = needed.tiles;
  }
  resize(room);
}

void TriangleLists::growAs(const TriangleLists& other) {
  if (other.binning_ != binning_) return;
  Capacities room = capacities_;
  room.projected = std::max(room.projected, within(other.capacities_.projected, mostProjected()));
  room.tiles = std::max(room.tiles, other.capacities_.tiles);
  room.candidates = std::max(room.candidates, within(other.capacities_.candidates, mostCandidates()));
  if (tilesBehind(room) + room.tiles <= limit(kTileBytes)) resize(room);
}

void TriangleLists::noteEnough(const Capacities& had, size_t views, bool moved) {
  // If grow() has failed since then, the lists are smaller than those of the submission.
  if (had.projected > capacities_.projected || had.tiles > capacities_.tiles || had.candidates > capacities_.candidates)
    return;
  viewsThatFit_ = std::max(viewsThatFit_, views);
  if (moved) movingViewsThatFit_ = std::max(movingViewsThatFit_, views);
}

}  // namespace gnosphere

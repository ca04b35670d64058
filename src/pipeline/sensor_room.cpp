// SPDX-License-Identifier: Apache-2.0
// Room for the scans of a sensor: arrays with entries per beam and view, and lists of triangles, which grow.
#include <algorithm>
#include <initializer_list>
#include <utility>

#include "base/limits.hpp"
#include "pipeline/scene_arrays.hpp"
#include "pipeline/sensor_arrays.hpp"

namespace gnosphere {
namespace {

using gpu::Array;

// Kernels hold indices in 32 bits, and the top bit is a sign when an array is addressed.
constexpr uint64_t kMostEntries = limits::kEntries.most;
constexpr uint64_t kTileBytes = 4 * sizeof(uint32_t);
// Rows of workgroups that every device can dispatch at once.
constexpr uint64_t kMostGroupRows = 65535;

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

uint64_t SensorArrays::limit(uint64_t entryBytes) const {
  return std::min(kMostEntries, machine_.traits().info.maxBufferBytes / entryBytes);
}

// Returns the arrays with entries per beam and view that stages pass on to each other. Results that stay on the device
// are among them, so all slots share them.
std::vector<ArrayContent> SensorArrays::arraysByBeam(uint32_t views) const {
  const uint64_t beams = uint64_t{this->beams()} * views;
  const bool lists = binning_ == gpu::kBinningLists;
  std::vector<ArrayContent> arrays;
  if (!plan_.bare()) arrays = beamArrays(plan_, entriesOf(views));
  const bool words = !lists || plan_.panes() || (plan_.computesReturns() && !plan_.footprint());
  if (words && !leavesWords_) arrays.push_back({Array::words, beams * sizeof(Word), {}});
  if (lists || plan_.panes() || plan_.footprint()) arrays.push_back({Array::listEnds, beams * 4, {}});
  if (plan_.footprint() && !lists) {
    arrays.push_back({Array::covers, beams * sizeof(gpu::Cover), {}});
    arrays.push_back({Array::ownLinks, beams * gpu::kOwnLinks * 8, {}});
  }
  if (!keepsRecords()) return arrays;
  for (const Output& output : outputs_) arrays.push_back({output.array, entriesOf(views) * output.bytesPerBeam, {}});
  if (plan_.layout.compact) {
    arrays.push_back({Array::recordBlocks, shotsIn(views) * (entries() / gpu::kPrefixBlock + 1) * 4, {}});
    arrays.push_back({Array::recordEntries, shotsIn(views) * entries() * 4, {}});
  }
  return arrays;
}

// Allocates the work arrays that lie view after view.
void SensorArrays::allocateForViews(uint32_t views) {
  allocate(Array::farthest, 4 * (most_.fine + most_.coarse) * views);
  if (binning_ == gpu::kBinningSlabs) {
    allocate(Array::staleEntries, 4 * most_.coarse * views);
    allocate(Array::slabEnds, most_.slabs * (plan_.panes() ? 8 : 4) * views);
  }
  if (binning_ == gpu::kBinningLists) allocate(Array::blockSums, blockSumBytes(views));
  for (const ArrayContent& array : arraysByBeam(views)) allocate(array.array, array.bytes);
}

uint64_t SensorArrays::blockSumBytes(uint32_t views) const {
  return (uint64_t{beams()} * views / gpu::kPrefixBlock + 1) * sizeof(uint32_t);
}

uint32_t SensorArrays::findMostViews(uint64_t room) const {
  uint64_t ofView = 1, mostOfView = 1;       // bytes
  const uint32_t together = fewestGroups();  // views of one shot
  for (const Output& output : outputs_)
    mostOfView = std::max(mostOfView, entriesOf(together) * output.bytesPerBeam / together);
  for (const ArrayContent& array : arraysByBeam(together)) {
    ofView += array.bytes / together;
    mostOfView = std::max(mostOfView, array.bytes / together);
  }
  if (plan_.footprint()) ofView += listBytes(mostOfFootprints(beams()));
  const BeamTables& tables = beamSets_.sets[0][0];
  const uint32_t groupRows = tables.listed ? 1 : std::max(tables.frame.rows, 1u);
  const std::initializer_list<uint64_t> most = {
      gnosphere::mostViews(machine_.traits(), beams()), machine_.traits().info.maxBufferBytes / mostOfView,
      kMostEntries * sizeof(uint32_t) / mostOfView, room / ofView, kMostGroupRows / groupRows};
  return static_cast<uint32_t>(std::max<uint64_t>(std::min(most), 1));
}

// Makes room for views in the arrays that lie view after view.
void SensorArrays::growArrays(uint32_t views) {
  if (views <= viewsWithRoom_) return;
  viewsWithRoom_ = 0;  // should memory run out now, the next scan allocates the arrays again
  allocateForViews(views);
  repeat(Array::startFarthest, views);
  repeat(Array::startWords, views);
  viewsWithRoom_ = views;
}

// Makes an array of each set of tables, with which each scan begins, one that all views begin with.
void SensorArrays::repeat(Array array, uint32_t views) {
  for (size_t set = 0; set < sets(); ++set) {
    if (!setArrays_[set][array]) continue;
    for (const ArrayContent& once : arraysOf(plan_, beamSets_.sets[set])) {
      if (once.array != array) continue;
      std::vector<std::byte> content;
      content.reserve(once.content.size() * views);
      for (uint32_t view = 0; view < views; ++view)
        content.insert(content.end(), once.content.begin(), once.content.end());
      setArrays_[set].upload(machine_, array, content);
    }
  }
}

void SensorArrays::makeRoomForViews(uint32_t views) {
  growArrays(views);
  if (views == 1) return;
  Capacities room = capacities_;
  const uint64_t ofView =
      plan_.footprint() ? firstProjected_ : std::min(firstProjected_, firstProjectedOfView(beams()));
  const uint64_t projected = std::min(ofView * views, mostProjected());
  room.projected = std::max(room.projected, static_cast<uint32_t>(projected));
  room.tiles = std::max(room.tiles, room.projected / 2);
  if (binning_ == gpu::kBinningLists)
    room.candidates = std::max(room.candidates, within(uint64_t{firstCandidates_} * views, mostCandidates()));
  else if (plan_.footprint())
    room.candidates =
        std::max(room.candidates, within(leastWithFootprints(room.projected).candidates, mostCandidates()));
  makeLists(room);
}

// Makes room for the results of views in a slot.
void SensorArrays::makeRoomForViews(Slot& slot, uint32_t views) {
  const auto room = [&](Array array, uint64_t bytes) {
    slot.arrays.makeRoom(machine_, array, bytes, MemoryKind::readback);
  };
  if (!keepsRecords())
    for (const Output& output : outputs_) room(output.array, entriesOf(views) * output.bytesPerBeam);
  if (plan_.computesReturns()) room(Array::viewCauses, uint64_t{gpu::kCauses} * sizeof(uint32_t) * views);
  if (capacities_.projected > 0)
    arrays_.makeRoom(machine_, Array::projectedViews, capacities_.projected * sizeof(uint32_t), MemoryKind::device);
}

uint64_t SensorArrays::mostProjected() const {
  uint64_t bytes = sizeof(gpu::vec4);
  for (const ArrayContent& array : projectedArrays(plan_, 1)) bytes = std::max(bytes, array.bytes);
  return limit(bytes);
}

// In a chain, a candidate has its range and a link to the next.
uint64_t SensorArrays::candidateBytes() const {
  return binning_ == gpu::kBinningLists ? 4 : 12;
}

// Kernels number the words of a chain, not its entries.
uint64_t SensorArrays::mostCandidates() const {
  return limit(sizeof(uint32_t)) / (candidateBytes() / sizeof(uint32_t));
}

uint64_t SensorArrays::listBytes(const Capacities& room) const {
  uint64_t ofProjected = 2 * sizeof(gpu::TaggedCorner) + sizeof(gpu::vec4) + sizeof(gpu::vec2);
  for (const ArrayContent& array : projectedArrays(plan_, 1)) ofProjected += array.bytes;
  return room.projected * ofProjected + (tilesBehind(room) + room.tiles) * kTileBytes +
         room.candidates * candidateBytes();
}

// Number of tiles beyond Capacities::tiles: with slabs every projected triangle has one tile of its own.
uint64_t SensorArrays::tilesBehind(const Capacities& room) const {
  return binning_ == gpu::kBinningSlabs ? room.projected : 0;
}

void SensorArrays::makeFirstLists(uint64_t triangles) {
  Capacities room = firstCapacities(binning_, plan_.panes(), plan_.footprint(), beams(), triangles);
  room.projected = within(room.projected, std::min(mostProjected(), limit(kTileBytes) / 2));
  room.tiles = within(room.tiles, limit(kTileBytes) - tilesBehind(room));
  room.candidates = within(room.candidates, mostCandidates());
  firstProjected_ = room.projected;
  firstCandidates_ = room.candidates;
  makeLists(room);
}

// Reallocates the lists whose capacity changes. If memory runs out, all capacities stay zero, and the next scan makes
// the lists that it needs.
void SensorArrays::makeLists(const Capacities& room) {
  const Capacities had = std::exchange(capacities_, {});
  viewsThatFit_ = movingViewsThatFit_ = 0;
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

bool SensorArrays::cutShort(size_t index) {
  const gpu::Counters& needed = counters(slots_[index]);
  const Capacities& had = slots_[index].capacities;
  return projectedCount(needed) > had.projected || needed.tiles > had.tiles || needed.candidates > had.candidates;
}

void SensorArrays::noteEnough(size_t index, size_t views, bool moved) {
  const Capacities& had = slots_[index].capacities;
  // If growLists() has failed since then, the lists are smaller than those of the submission.
  if (had.projected > capacities_.projected || had.tiles > capacities_.tiles || had.candidates > capacities_.candidates)
    return;
  viewsThatFit_ = std::max(viewsThatFit_, views);
  if (moved) movingViewsThatFit_ = std::max(movingViewsThatFit_, views);
}

// If one list was too small, the counts of later stages are too low; the next run finds out and grows those lists. The
// lists of footprints grow together, because another run takes long.
void SensorArrays::growLists(size_t index) {
  gpu::Counters needed = counters(slots_[index]);
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
  makeLists(room);
}

void SensorArrays::growListsAs(const SensorArrays& other) {
  if (other.binning_ != binning_) return;
  Capacities room = capacities_;
  room.projected = std::max(room.projected, within(other.capacities_.projected, mostProjected()));
  room.tiles = std::max(room.tiles, other.capacities_.tiles);
  room.candidates = std::max(room.candidates, within(other.capacities_.candidates, mostCandidates()));
  if (tilesBehind(room) + room.tiles <= limit(kTileBytes)) makeLists(room);
}

}  // namespace gnosphere

// SPDX-License-Identifier: Apache-2.0
// Room for the scans of a sensor in arrays with entries per beam and view.
#include <algorithm>
#include <initializer_list>

#include "base/limits.hpp"
#include "pipeline/scene_arrays.hpp"
#include "pipeline/sensor_arrays.hpp"

namespace gnosphere {
namespace {

using gpu::Array;

// Rows of workgroups that every device can dispatch at once.
constexpr uint64_t kMostGroupRows = 65535;

}  // namespace

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
  if (plan_.footprint()) ofView += lists_.bytesOf(mostOfFootprints(beams()));
  const BeamTables& tables = beamSets_.sets[0][0];
  const uint32_t groupRows = tables.listed ? 1 : std::max(tables.frame.rows, 1u);
  const std::initializer_list<uint64_t> most = {
      gnosphere::mostViews(machine_.traits(), beams()), machine_.traits().info.maxBufferBytes / mostOfView,
      limits::kEntries.most * sizeof(uint32_t) / mostOfView, room / ofView, kMostGroupRows / groupRows};
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
  if (views > 1) lists_.makeRoomForViews(views);
}

// Makes room for the results of views in a slot.
void SensorArrays::makeRoomForViews(Slot& slot, uint32_t views) {
  const auto room = [&](Array array, uint64_t bytes) {
    slot.arrays.makeRoom(machine_, array, bytes, MemoryKind::readback);
  };
  if (!keepsRecords())
    for (const Output& output : outputs_) room(output.array, entriesOf(views) * output.bytesPerBeam);
  if (plan_.computesReturns()) room(Array::viewCauses, uint64_t{gpu::kCauses} * sizeof(uint32_t) * views);
  lists_.numberViews();
}

}  // namespace gnosphere

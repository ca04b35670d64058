// SPDX-License-Identifier: Apache-2.0
// The device side of a sensor: its tables, the arrays of its scans, and the steps of a scan.
#pragma once

#include <vector>

#include "effects/arrays.hpp"
#include "pipeline/array_table.hpp"
#include "pipeline/beam_sets.hpp"
#include "pipeline/outputs.hpp"
#include "pipeline/record_tables.hpp"
#include "pipeline/results.hpp"
#include "pipeline/scan_options.hpp"
#include "pipeline/shell_choice.hpp"
#include "pipeline/triangle_lists.hpp"

namespace gnosphere {

class SensorArrays {
 public:
  /// Allocates the arrays and compiles the kernels of the scans. `triangles` is the number placed in the scene, and
  /// `deformed` tells whether it has deformable meshes.
  SensorArrays(Machine& machine, const SensorPlan& plan, const SimulatorOptions& options, uint64_t triangles,
               bool deformed);
  /// Tells how many triangles the scene places now.
  void setTriangles(uint64_t triangles) { shells_.setTriangles(triangles); }
  /// Tells whether the scene has deformable meshes now.
  void setDeformed(bool deformed);

  const SensorPlan& sensorPlan() const { return plan_; }
  /// Most beams that are projected at once; in a grid with holes, places.
  uint32_t beams() const { return static_cast<uint32_t>(most_.beams); }
  /// Whether scans leave the nearest hits of all beams, and nothing else, for the host to resolve, each shot as one
  /// view.
  bool leavesHitsAlone() const {
    return leavesWords_ && outputs_.size() == 1 && plan_.returns == 1 && !keepsRecords() && !plan_.computesReturns() &&
           mostGroups() == 1;
  }
  /// Distance in metres beyond which instances cannot be hit.
  double reach() const { return reach_; }
  bool keepsStill() const { return keepsStill_; }

  /// Replaces the optics of the materials, whose number stays. No slot may be running.
  void setOptics(std::span<const gpu::Optics4> optics);

  /// The most views that a submission may have.
  uint32_t mostViews() const { return mostViews_; }
  bool hasRoomForViews(uint32_t views) const { return views <= viewsWithRoom_; }
  /// Makes room for a number of views: exactly in the arrays that lie view after view, and by estimate in the lists of
  /// triangles, which grow when a scan needs more. No slot may be running.
  void makeRoomForViews(uint32_t views);

  /// The groups of beams that scan number `frame` fires, set by set. The views of a submission are of one set.
  std::span<const BeamGroup> groups(uint64_t frame) const {
    return beamSets_.patterns[frame % beamSets_.patterns.size()];
  }
  /// The largest number of groups that any scan fires.
  size_t mostGroups() const;
  /// Number of sets of tables.
  size_t sets() const { return beamSets_.sets.size(); }
  /// Returns the steps of a submission in a slot, which must not be running, and binds the arrays of the sensor and of
  /// the slot. `shots` has the shot of each view; `last` tells whether these are the last views of
  /// their shots.
  std::vector<Step> prepare(size_t slot, std::span<const Shot> shots, std::span<const View> views, bool last,
                            ShotMotions motions, const InstanceEntries& instances, const PlacedGroups& placed,
                            StillImage::Use still, BoundArrays& arrays);
  /// Throws Error(device) if the device has run nothing of the last scan of this slot.
  void checkAlive(size_t slot);
  /// Returns whether a list was too small for the last scan of this slot. The scan must run again after growLists().
  bool cutShort(size_t slot) { return TriangleLists::cutShort(counters(slot), slots_[slot].capacities); }
  /// Grows the lists that were too small to the sizes that the scan has counted. No slot may be running.
  void growLists(size_t slot) { lists_.grow(counters(slot)); }
  /// Grows the lists to those of a sensor with another plan of the same scene, whose scans they have held.
  void growListsAs(const SensorArrays& other) { lists_.growAs(other.lists_); }
  /// Learns from the counters of the last submission of this slot, which has ended.
  void learn(size_t slot) { shells_.learn(counters(slot), slots_[slot].views.size(), slots_[slot].shells); }
  /// Tells that the lists were large enough for the last submission of this slot, of so many views, in which sensor or
  /// instances moved or none did.
  void noteEnough(size_t slot, size_t views, bool moved) { lists_.noteEnough(slots_[slot].capacities, views, moved); }
  /// Whether the lists, as they are now, were large enough for a submission like this one.
  bool hadEnough(size_t views, bool moves) const { return lists_.hadEnough(views, moves); }
  /// Returns the outputs of the last scan of the slot, of all its views, each of which is a shot.
  DeviceResults results(size_t slot);
  /// Returns the outputs of the shot of a view, of which takeShare() has told the counters.
  DeviceResults results(size_t slot, uint32_t view, const gpu::Counters& counted);
  /// Returns what the last scan of the slot has counted, in all its views.
  const gpu::Counters& counters(size_t slot) const;
  /// Whether the device chooses shells, for which it takes a hint.
  bool choosesShells() const { return shells_.count() > 1; }
  /// Whether the results stay on the device, as records.
  bool keepsRecords() const { return !plan_.layout.empty(); }
  /// The caller's memory for the records of a shot.
  struct RecordSpace {
    gpu::RecordBuffers buffers;
    uint64_t bytes;  ///< of the buffer for the records
  };
  /// Whether records hold the classes of surfaces, which the kernels find in the arrays of a ClassTable.
  bool recordsClasses() const { return (records_.held >> gpu::kValueClass & 1) != 0; }
  /// Loads what the records of the next scan of this slot depend on, before prepare(): where those of each shot go.
  /// `classes` is the number of instances that have a class; `continues` tells whether an earlier submission has other
  /// views of these shots.
  void loadRecords(size_t slot, std::span<const Shot> shots, std::span<const RecordSpace> spaces, uint32_t classes,
                   bool continues);
  /// Returns a hint for setShellHint() from the records of the last scan of this slot.
  float recordedHint(size_t slot);
  /// Tells the next scans where to end a shell: at this distance in metres, behind most hits of the last scan; 0 if
  /// nothing is known.
  void setShellHint(float distance) { shellHint_ = distance; }
  void addTo(MemoryUse& use) const;
  /// Returns the plan of a scan with its decisions, stages and buffers.
  Plan plan() const { return planWith(slots_[0], viewsOfScan(0)); }
  /// Makes room for a submission of so many shots, or as many as it may have, compiles its kernels and returns its
  /// plan.
  Plan planOf(size_t shots);

 private:
  /// The arrays that each submission in flight has of its own; all submissions share the work arrays.
  struct Slot {
    ArrayTable arrays;
    Capacities capacities;                  // of the lists when the scan was prepared
    uint32_t shells = 1;                    // of the scan
    bool signsOfLife = false;               // whether kernels run that leave one
    std::vector<View> views;                // of the scan
    std::vector<const BeamTables*> tables;  // of each view
  };

  /// Motion that the kernels of a scan must know.
  enum class Motion { none, lasers, all };  // lasers: only that they have origins

  /// Holds, for each size, the largest that any set of tables has.
  struct Sizes {
    uint64_t beams = 0, fine = 0, coarse = 0, slabs = 0;  // fine and coarse entries of the farthest-range table
    float rangeMax = 0;
  };

  void prepareKernels();
  std::vector<Motion> motions() const;
  static Sizes mostOf(const BeamSets& beamSets);
  uint32_t viewsOfScan(size_t set) const;
  uint32_t fewestGroups() const;
  uint32_t shotsIn(uint32_t views) const;
  uint64_t entriesOf(uint32_t views) const;
  void makeRecordTables();
  Slot& slotAt(size_t index);
  uint64_t entries() const { return uint64_t{plan_.sensor.beamCount()} * plan_.returns; }
  std::vector<Step> steps(const BeamTables& tables, const gpu::Frame& frame, const PlacedGroups& placed,
                          StillImage::Use still, Motion motion, uint32_t shots, bool last) const;
  uint32_t findMostViews(uint64_t room) const;
  uint64_t blockSumBytes(uint32_t views) const;
  std::vector<ArrayContent> arraysByBeam(uint32_t views) const;
  void allocateForViews(uint32_t views);
  void growArrays(uint32_t views);
  void repeat(gpu::Array array, uint32_t views);
  void makeRoomForViews(Slot& slot, uint32_t views);
  gpu::Frame frameOf(const BeamTables& tables, uint32_t views) const;
  std::vector<Step> largestScan(uint32_t views) const;
  Plan planWith(const Slot& slot, uint32_t views) const;
  void allocate(gpu::Array array, uint64_t bytes) { arrays_.allocate(machine_, array, bytes, MemoryKind::device); }
  void addSlot();
  void load(Slot& slot, const std::vector<ArrayContent>& arrays);

  Machine& machine_;
  const SensorPlan& plan_;
  BeamSets beamSets_;
  Sizes most_;
  uint32_t binning_;
  bool leavesWords_, exact_, keepsStill_, float64_, deformed_;
  Options options_;
  ShellChoice shells_;
  uint32_t raysPerLane_;
  float shellHint_ = 0;
  double reach_;
  uint32_t mostViews_ = 1, viewsWithRoom_ = 1;
  std::vector<Output> outputs_;
  RecordTables records_;  // of the layout; empty if the host reads the results
  uint64_t mostWork_;     // of a submission; 0: scans are not divided
  TriangleLists lists_;
  ArrayTable arrays_;
  std::vector<ArrayTable> setArrays_;  // tables of each set
  std::vector<Slot> slots_;            // each one after the first is made at its first use
};

}  // namespace gnosphere

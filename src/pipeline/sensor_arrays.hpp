// SPDX-License-Identifier: Apache-2.0
// The device side of a sensor: its tables, the arrays of its scans, and the steps of a scan.
#pragma once

#include <optional>
#include <vector>

#include "effects/arrays.hpp"
#include "pipeline/beam_tables.hpp"
#include "pipeline/machine.hpp"
#include "pipeline/origin_groups.hpp"
#include "pipeline/outputs.hpp"
#include "pipeline/record_tables.hpp"
#include "pipeline/results.hpp"
#include "pipeline/scan_options.hpp"
#include "scan/class_table.hpp"

namespace gnosphere {

class SensorArrays {
 public:
  /// Allocates the arrays and compiles the kernels of the scans. `triangles` is the number placed in the scene, and
  /// `deformed` tells whether it has deformable meshes.
  SensorArrays(Machine& machine, const SensorPlan& plan, const SimulatorOptions& options, uint64_t triangles,
               bool deformed);
  /// Tells whether the scene has deformable meshes now.
  void setDeformed(bool deformed);

  const SensorPlan& sensorPlan() const { return plan_; }
  /// Most beams that are projected at once; in a grid with holes, places.
  uint32_t beams() const { return static_cast<uint32_t>(most_.beams); }
  /// Whether scans leave the nearest hits of all beams, and nothing else, for the host to resolve.
  bool leavesHitsAlone() const {
    return leavesWords_ && outputs_.size() == 1 && plan_.returns == 1 && !keepsRecords() && !plan_.judged() &&
           mostGroups() == 1;
  }
  /// Distance in metres beyond which instances cannot be hit.
  double reach() const { return reach_; }
  bool keepsStill() const { return keepsStill_; }

  /// The most views that a submission may have. Views are shots with different poses in which no instance moves.
  uint32_t mostViews() const { return mostViews_; }
  bool hasRoomForViews(uint32_t views) const { return views <= viewsWithRoom_; }
  /// Makes room for a number of views: exactly in the arrays that lie view after view, and by estimate in the lists of
  /// triangles, which grow when a scan needs more. No frame may be running.
  void makeRoomForViews(uint32_t views);

  /// The groups of beams that scan number `frame` projects one after the other.
  std::span<const OriginGroup> groups(uint64_t frame) const { return patterns_[frame % patterns_.size()].groups; }
  /// The largest number of groups that any scan projects.
  size_t mostGroups() const;
  /// Returns the steps of a scan of one group as frame in flight `frame`, which must not be running, and binds the
  /// arrays of the sensor and of the frame. Each of several shots is a view.
  std::vector<Step> prepare(size_t frame, std::span<const Shot> shots, size_t group, ShotMotions motions,
                            const InstanceEntries& instances, const PlacedGroups& placed, StillImage::Use still,
                            BoundArrays& arrays);
  /// Throws Error(device) if the device has run nothing of the last scan of this frame.
  void checkAlive(size_t frame);
  /// Returns whether a list was too small for the last scan of this frame. The scan must run again after growLists().
  bool cutShort(size_t frame);
  /// Grows the lists that were too small to the sizes that the scan has counted. No frame may be running.
  void growLists(size_t frame);
  /// Returns the outputs of the last scan of the frame, of all its views.
  DeviceResults results(size_t frame);
  /// Returns those of one of its views.
  DeviceResults results(size_t frame, uint32_t view);
  /// Whether the device chooses shells, for which it takes a hint.
  bool choosesShells() const { return shells_ > 1; }
  /// Whether the results stay on the device, as records.
  bool keepsRecords() const { return !plan_.layout.empty(); }
  /// Loads what the records of the next scan of this frame depend on, before prepare(): the size of the caller's buffer
  /// in bytes, the classes of surfaces, and the number of the scan. `group` is that of prepare().
  void loadRecords(size_t frame, size_t group, uint64_t bytes, const ClassTable& classes, uint64_t number);
  /// Returns a hint for setShellHint() from the records of the last scan of this frame.
  float recordedHint(size_t frame);
  /// Tells the next scans where to end a shell: at this distance in metres, behind most hits of the last scan; 0 if
  /// nothing is known.
  void setShellHint(float distance) { shellHint_ = distance; }
  void addTo(MemoryUse& use) const;
  /// Returns the plan of a scan with its decisions, stages and buffers.
  Plan plan() const { return planWith(frames_[0], 1); }
  /// Makes room for a submission of so many views, or as many as it may have, compiles its kernels and returns its
  /// plan.
  Plan planOf(size_t views);

 private:
  /// The arrays that each frame in flight has of its own; all frames share the work arrays.
  struct Frame {
    std::array<std::unique_ptr<DeviceMemory>, gpu::kArrayCount> arrays;
    Capacities capacities;     // of the lists when the scan was prepared
    bool signsOfLife = false;  // whether kernels run that leave one
    uint32_t views = 1;        // of the scan
    size_t pattern = 0;        // whose beams the scan fires
    BeamTables tables;  // of the group that fires, if the pattern has several; their arrays are those of the frame
    std::optional<std::pair<size_t, size_t>> loaded;  // pattern and group of these tables
  };

  /// The beams of the sensor and their arrays. Only a list has several patterns, one per frame number. If a pattern has
  /// several groups, a frame makes the tables of the one that it fires, because there may be as many groups as beams;
  /// `tables` are those of the first group, and there are no arrays.
  struct Pattern {
    std::vector<OriginGroup> groups;
    BeamTables tables;
    std::array<std::unique_ptr<DeviceMemory>, gpu::kArrayCount> arrays;
  };

  /// Motion that the kernels of a scan must know.
  enum class Motion { none, lasers, all };  // lasers: only that they have origins

  /// Holds, for each size, the largest that any pattern or group has.
  struct Sizes {
    uint64_t beams = 0, fine = 0, coarse = 0, slabs = 0;  // fine and coarse entries of the farthest-range table
    float rangeMax = 0;
  };

  void prepareKernels();
  std::vector<Motion> motions() const;
  std::vector<Pattern> makePatterns();
  void makeRecordArrays();
  Frame& frameAt(size_t index);
  uint64_t entries() const { return uint64_t{plan_.sensor.beamCount()} * plan_.returns; }
  BeamTables tablesOf(uint64_t pattern, const OriginGroup& group) const;
  std::vector<EffectsArray> arraysOf(const BeamTables& tables) const;
  void include(const gpu::Frame& frame);
  const BeamTables& fired(const Frame& frame) const {
    const Pattern& pattern = patterns_[frame.pattern];
    return pattern.groups.size() > 1 ? frame.tables : pattern.tables;
  }
  uint64_t mostBeams() const;
  std::vector<Step> steps(const BeamTables& tables, const gpu::Frame& frame, const PlacedGroups& placed,
                          StillImage::Use still, Motion motion, bool lastGroup) const;
  uint32_t findMostViews(uint64_t room) const;
  uint64_t blockSumBytes(uint32_t views) const;
  std::vector<EffectsArray> arraysByBeam(uint32_t views) const;
  void allocateByBeam(uint32_t views);
  void growArrays(uint32_t views);
  void repeat(gpu::Array array, uint32_t views);
  void makeRoomForViews(Frame& frame, uint32_t views);
  gpu::Frame frameOf(const BeamTables& tables, uint32_t views) const;
  std::vector<Step> largestScan(uint32_t views) const;
  Plan planWith(const Frame& frame, uint32_t views) const;
  PlacedGroups everything() const;
  uint64_t mostProjected() const;
  uint64_t candidateBytes() const;
  uint64_t mostCandidates() const;
  uint64_t tilesBehind(const Capacities& room) const;
  uint64_t listBytes(const Capacities& room) const;
  void makeFirstLists(uint64_t triangles);
  void makeLists(const Capacities& room);
  void allocate(gpu::Array array, uint64_t bytes);
  void addFrame();
  void load(Frame& frame, const std::vector<EffectsArray>& arrays);
  const gpu::Counters& counters(Frame& frame) const;
  uint64_t limit(uint64_t entryBytes) const;
  std::unique_ptr<DeviceMemory>& of(gpu::Array array) { return arrays_[static_cast<size_t>(array)]; }

  Machine& machine_;
  const SensorPlan& plan_;
  Sizes most_;
  std::vector<Pattern> patterns_;
  uint32_t binning_;
  bool leavesWords_, exact_, keepsStill_, float64_, deformed_;
  Options options_;
  uint32_t shells_, shellClusters_;
  uint32_t raysPerLane_;
  float shellHint_ = 0;
  double reach_;
  uint32_t mostViews_ = 1, viewsWithRoom_ = 1;
  std::vector<Output> outputs_;
  RecordTables records_;  // of the layout; empty if the host reads the results
  uint64_t mostWork_;     // of a submission; 0: scans are not divided
  Capacities capacities_;
  // Projected triangles and candidates for which a scan of one view has room at first.
  uint32_t firstProjected_ = 0, firstCandidates_ = 0;
  std::array<std::unique_ptr<DeviceMemory>, gpu::kArrayCount> arrays_;
  std::vector<Frame> frames_;  // each one after the first is made at its first use
};

}  // namespace gnosphere

// SPDX-License-Identifier: Apache-2.0
#include "pipeline/sensor_arrays.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <numeric>
#include <span>
#include <utility>

#include "pipeline/scene_arrays.hpp"
#include "scan/layout.hpp"

namespace gnosphere {
namespace {

using gpu::Array;

// One group with one cluster, for which a scan has all its steps.
constexpr PlacedGroups kEverything = {{0, 1, 1}, {}};

}  // namespace

SensorArrays::SensorArrays(Machine& machine, const SensorPlan& plan, const SimulatorOptions& options,
                           uint64_t triangles, bool deformed)
    : machine_(machine),
      plan_(plan),
      beamSets_(makeBeamSets(plan)),
      most_(mostOf(beamSets_)),
      binning_(chooseBinning(options, machine.traits(), plan.footprint())),
      leavesWords_(leavesWords(binning_, plan) && !(keepsRecords() && mostGroups() > 1)),
      exact_(accuracyPartsOf(options).inside == AccuracyParts::Inside::exact),
      keepsStill_(gnosphere::keepsStill(options, binning_, plan) && mostGroups() == 1),
      float64_(exact_ && options.tuning.float64 && machine.traits().float64 && machine.traits().int64Atomics),
      deformed_(deformed),
      options_(kernelOptions(options, plan)),
      shells_(options, machine.traits(), binning_, beams()),
      raysPerLane_(raysPerLane(options, machine.traits(), placesFor(static_cast<uint32_t>(plan.subRays.size())))),
      reach_(reachOf(options, most_.rangeMax)),
      outputs_(outputsOf(plan, leavesWords_)),
      records_(recordTables(plan.layout)),
      mostWork_(machine.submits() ? mostWork(options, machine.traits()) : 0),
      lists_(machine, plan, binning_, beams(), triangles) {
  options_.BINNING = binning_;
  shells_.setTriangles(triangles);
  if (!leavesWords_) options_.FIELDS |= gpu::kFieldPoints;
  if (keepsRecords() && leavesWords_) records_.held |= gpu::kFromWords;
  mostViews_ = findMostViews(mostListBytes(options, machine.traits()));
  prepareKernels();
  setArrays_.resize(sets());
  for (size_t set = 0; set < sets(); ++set)
    for (const ArrayContent& array : arraysOf(plan_, beamSets_.sets[set]))
      setArrays_[set].upload(machine_, array.array, array.content);
  allocate(Array::shells, sizeof(gpu::Shells));
  allocateForViews(1);
  if (!plan_.bare())
    for (const ArrayContent& array : lastingTables(plan)) {
      allocate(array.array, array.bytes);
      arrays_[array.array]->write(0, array.content);
    }
  if (keepsRecords()) makeRecordTables();
  addSlot();
}

void SensorArrays::prepareKernels() {
  std::vector<Variant> variants;
  for (const Motion motion : motions())
    for (const StillImage::Use still : {StillImage::Use::none, StillImage::Use::make}) {
      if (still == StillImage::Use::make && (!keepsStill_ || motion == Motion::all)) continue;
      for (size_t set = 0; set < sets(); ++set)
        for (const bool last : {false, true}) {
          if (!last && mostGroups() == 1) continue;
          const BeamTables& tables = beamSets_.sets[set][0];
          const gpu::Frame frame = frameOf(tables, viewsOfScan(set));
          for (const Step& step : steps(tables, frame, kEverything, still, motion, shotsIn(frame.views), last))
            if (step.kind == Step::Kind::dispatch) variants.push_back(step.variant);
        }
    }
  machine_.prepare(variants);
}

// Returns what scans of this sensor may have, the most at last.
std::vector<SensorArrays::Motion> SensorArrays::motions() const {
  std::vector<Motion> motions = {plan_.origins ? Motion::lasers : Motion::none};
  if (plan_.moves()) motions.push_back(Motion::all);
  return motions;
}

size_t SensorArrays::mostGroups() const {
  size_t most = 0;
  for (const auto& groups : beamSets_.patterns) most = std::max(most, groups.size());
  return most;
}

void SensorArrays::setDeformed(bool deformed) {
  if (deformed_ == deformed) return;
  deformed_ = deformed;
  try {
    prepareKernels();
  } catch (...) {
    deformed_ = !deformed;
    throw;
  }
}

void SensorArrays::setOptics(std::span<const gpu::Optics4> optics) {
  if (plan_.looksAtOptics()) arrays_[Array::optics]->write(0, std::as_bytes(optics));
}

// Returns the most views that a shot has with tables of a set.
uint32_t SensorArrays::viewsOfScan(size_t set) const {
  uint32_t most = 1;
  for (const auto& groups : beamSets_.patterns)
    most = std::max(most, static_cast<uint32_t>(std::ranges::count(groups, set, &BeamGroup::set)));
  return std::min(most, mostViews_);
}

uint32_t SensorArrays::fewestGroups() const {
  size_t fewest = mostGroups();
  for (const auto& groups : beamSets_.patterns) fewest = std::min(fewest, groups.size());
  return static_cast<uint32_t>(fewest);
}

// Returns to how many shots this number of views belongs at most.
uint32_t SensorArrays::shotsIn(uint32_t views) const {
  return sets() > 1 ? 1 : std::max(1u, views / fewestGroups());
}

SensorArrays::Sizes SensorArrays::mostOf(const BeamSets& beamSets) {
  Sizes most;
  for (const std::vector<BeamTables>& set : beamSets.sets) {
    const gpu::Frame& frame = set[0].frame;
    most.beams = std::max<uint64_t>(most.beams, frame.beams);
    most.fine = std::max(most.fine, tableEntries(frame, gpu::kFineColumns, gpu::kFineRows));
    most.coarse = std::max(most.coarse, tableEntries(frame, gpu::kCoarseColumns, gpu::kCoarseRows));
    most.slabs = std::max<uint64_t>(most.slabs, slabsOf(frame));
    most.rangeMax = std::max(most.rangeMax, frame.rangeMax);
  }
  return most;
}

// Makes what the records of all scans are made with: the layout, and the beams of all patterns.
void SensorArrays::makeRecordTables() {
  arrays_.upload(machine_, Array::recordStreams, records_.streams);
  arrays_.upload(machine_, Array::recordValues, records_.values);
  arrays_.upload(machine_, Array::recordPlaces, records_.places);
  arrays_.upload(machine_, Array::recordGaps, records_.gaps);
  std::vector<uint32_t> places;
  std::vector<gpu::uvec4> facts;
  std::vector<gpu::vec4> directions;
  const auto append = [](auto& all, const auto& ofPattern) {
    all.insert(all.end(), ofPattern.begin(), ofPattern.end());
  };
  for (size_t pattern = 0; pattern < beamSets_.patterns.size(); ++pattern) {
    const BeamGroup& group = beamSets_.patterns[pattern][0];
    if ((records_.held & gpu::kFromWords) != 0)
      append(places, beamPlaces(plan_, beamSets_.sets[group.set][group.table]));
    append(facts, beamFacts(plan_, pattern));
    append(directions, beamDirections(plan_, pattern));
  }
  const auto put = [&](Array array, const auto& content) {
    if (!content.empty()) arrays_.upload(machine_, array, content);
  };
  put(Array::beamPlaces, places);
  put(Array::beamFacts, facts);
  put(Array::beamDirections, directions);
}

std::vector<Step> SensorArrays::steps(const BeamTables& tables, const gpu::Frame& frame, const PlacedGroups& placed,
                                      StillImage::Use still, Motion motion, uint32_t shots, bool last) const {
  Variant variant;
  variant.options = options_;
  variant.options.MOTION = motion != Motion::none;
  variant.options.AZIMUTH_OFFSETS = tables.between;
  variant.options.STAGGERED = tables.staggered;
  variant.options.ORIGINS = tables.apart;
  variant.options.LISTED = tables.listed;
  variant.options.MAPPED = tables.mapped;
  variant.options.VIEWS = frame.views > 1;
  variant.options.RAYS = placesFor(static_cast<uint32_t>(plan_.subRays.size()));
  variant.float64 = float64_;
  const bool footprint = plan_.footprint(), lists = binning_ == gpu::kBinningLists;
  StepsInput input = {variant, dispatchSizesOf(machine_.traits()), frame, shells_.count(), frame.views, shots};
  input.strays = plan_.has(gpu::kStrays);
  input.panes = plan_.panes();
  input.footprint = footprint;
  input.raysPerLane = raysPerLane_;
  input.records = records_.held;
  input.entries = entries();
  input.organised = !plan_.layout.compact;
  input.lastViews = last;
  input.deformed = deformed_;
  input.moves = motion == Motion::all;
  input.looksAtSurfaces = plan_.surfaces() || plan_.panes() || plan_.speeds();
  input.holes = tables.holes;
  const bool hides = binning_ != gpu::kBinningLists && (options_.CULLING & gpu::kCullOccluded) != 0;
  input.sparse = hides && !tables.startFarthest.empty();
  using Returns = StepsInput::Returns;
  input.effects = plan_.computesReturns() ? Returns::all : plan_.panes() ? Returns::listed : Returns::none;
  input.laterWords = leavesWords_ && plan_.returns > 1 && input.effects == Returns::listed;
  // Stage effects reads the nearest hits from the words, which lists have only after stage resolve.
  input.resolve = !footprint && (lists || !(leavesWords_ || plan_.computesReturns()));
  return stepsOf(input, placed, still);
}

// Entries of arrays with an entry per index of a beam and view, or per number of a beam and shot.
uint64_t SensorArrays::entriesOf(uint32_t views) const {
  return std::max(uint64_t{beams()} * views, uint64_t{plan_.sensor.beamCount()} * shotsIn(views));
}

void SensorArrays::addSlot() {
  Slot slot;
  const auto allocate = [&](Array array, uint64_t bytes, MemoryKind kind) {
    slot.arrays.allocate(machine_, array, bytes, kind);
  };
  if (keepsRecords())
    allocate(Array::rangeCounts, gpu::kShellBuckets * sizeof(uint32_t), MemoryKind::readback);
  else
    for (const Output& output : outputs_)
      allocate(output.array, entriesOf(1) * output.bytesPerBeam, MemoryKind::readback);
  allocate(Array::counters, sizeof(gpu::Counters), MemoryKind::readback);
  allocate(Array::frame, sizeof(gpu::Frame), MemoryKind::upload);
  slots_.push_back(std::move(slot));
}

gpu::Frame SensorArrays::frameOf(const BeamTables& tables, uint32_t views) const {
  gpu::Frame frame = tables.frame;
  if (views == 1) return frame;
  frame.views = views;
  frame.slabShift = slabShiftOfViews();
  frame.slabFirst = 0;
  frame.slabCount = slabsOf(frame);
  return frame;
}

void SensorArrays::load(Slot& slot, const std::vector<ArrayContent>& arrays) {
  for (const ArrayContent& array : arrays) slot.arrays.load(machine_, array.array, array.bytes, array.content);
}

std::vector<Step> SensorArrays::prepare(size_t index, std::span<const Shot> shots, std::span<const View> views,
                                        bool last, ShotMotions motions, const InstanceEntries& instances,
                                        const PlacedGroups& placed, StillImage::Use still, BoundArrays& arrays) {
  Slot& slot = slotAt(index);
  const uint32_t number = views[0].group->set;
  const std::vector<BeamTables>& set = beamSets_.sets[number];
  const auto count = static_cast<uint32_t>(views.size());
  slot.capacities = lists_.capacities();
  slot.views.assign(views.begin(), views.end());
  slot.tables.clear();
  for (const View& view : views) slot.tables.push_back(&set[view.group->table]);
  const BeamTables& tables = *slot.tables[0];
  if (still == StillImage::Use::make)
    arrays_.makeRoom(machine_, Array::stillWords, uint64_t{beams()} * sizeof(Word), MemoryKind::device);

  if (count > 1) makeRoomForViews(slot, count);
  if (count > 1 && tables.listed) load(slot, {viewTables(views)});
  if (set.size() > 1 && !tables.startFarthest.empty()) load(slot, {startFarthest(slot.tables)});
  gpu::Frame content = frameOf(tables, count);
  content.projectedCapacity = slot.capacities.projected;
  content.tileCapacity = slot.capacities.tiles;
  content.candidateCapacity = slot.capacities.candidates;
  const DispatchSizes sizes = dispatchSizesOf(machine_.traits());
  content.cullWorkgroups = sizes.cullWorkgroups;
  content.triangleWorkgroups = sizes.triangleWorkgroups;
  content.shellClusters = shells_.firstClusters(count);
  content.moments = motions.size() > 1 ? static_cast<uint32_t>(motions[0].tables.columns.size()) : 0;
  content.shellHint = shellHint_;
  slot.shells = content.shellCount = shells_.count();
  load(slot, {arrayOf(Array::frame, std::array{content})});
  if (!plan_.bare()) load(slot, shotArrays(plan_, shots, motions, instances));

  arrays_.bind(arrays);
  lists_.arrays().bind(arrays);
  slot.arrays.bind(arrays);
  setArrays_[number].bind(arrays);
  const Motion moves = motions.empty() ? Motion::none : motions[0].moves ? Motion::all : Motion::lasers;
  const auto ofShots = static_cast<uint32_t>(views.back().shot - views[0].shot + 1);
  std::vector<Step> result = steps(tables, content, placed, still, moves, ofShots, last);
  slot.signsOfLife = std::any_of(result.begin(), result.end(), [](const Step& step) {
    return step.kind == Step::Kind::dispatch && step.variant.kernel == Kernel::project_groups;
  });
  return mostWork_ > 0 ? inSubmissions(result, mostWork_) : result;
}

void SensorArrays::checkAlive(size_t index) {
  if (slots_[index].signsOfLife && counters(index).alive != gpu::kAlive)
    throw Error(ErrorCode::device,
                "the device '" + machine_.traits().info.name +
                    "' reports a scan as done, but has run no kernel of it; its driver only pretends "
                    "to work");
}

SensorArrays::Slot& SensorArrays::slotAt(size_t index) {
  while (slots_.size() <= index) addSlot();
  return slots_[index];
}

void SensorArrays::loadRecords(size_t index, std::span<const Shot> shots, std::span<const RecordSpace> spaces,
                               uint32_t classes, bool continues) {
  gpu::RecordPlan content = {};
  content.entries = static_cast<uint32_t>(entries());
  content.organised = !plan_.layout.compact;
  content.streams = static_cast<uint32_t>(records_.streams.size());
  content.gaps = static_cast<uint32_t>(records_.gaps.size());
  content.classes = classes;
  content.directions = arrays_[Array::beamDirections] != nullptr;
  content.continues = continues;
  std::vector<gpu::RecordPlan> plans;
  std::vector<gpu::RecordBuffers> buffers;
  for (size_t i = 0; i < shots.size(); ++i) {
    content.capacity = static_cast<uint32_t>(rowsIn(plan_.layout, spaces[i].bytes));
    content.frame = static_cast<uint32_t>(shots[i].frame);
    content.firstBeam = static_cast<uint32_t>(shots[i].frame % beamSets_.patterns.size() * plan_.sensor.beamCount());
    plans.push_back(content);
    buffers.push_back(spaces[i].buffers);
  }
  load(slotAt(index), {arrayOf(Array::recordPlans, plans), arrayOf(Array::recordBuffers, buffers)});
}

// The range within which kHintPercent per cent of the sampled returns lie, rounded up to the end of a bucket.
float SensorArrays::recordedHint(size_t index) {
  DeviceMemory& memory = *slotAt(index).arrays[Array::rangeCounts];
  memory.invalidate();
  const std::span counts(static_cast<const uint32_t*>(memory.host()), gpu::kShellBuckets);
  const uint64_t all = std::accumulate(counts.begin(), counts.end(), uint64_t{0});
  if (all < gpu::kHintReturns) return 0;
  uint64_t sum = 0;
  uint32_t bucket = 0;
  while (sum < all * gpu::kHintPercent / 100) sum += counts[bucket++];
  const uint32_t first = (std::bit_cast<uint32_t>(most_.rangeMax) >> gpu::kBucketShift) - (gpu::kShellBuckets - 1);
  return std::bit_cast<float>((first + bucket) << gpu::kBucketShift);
}

const gpu::Counters& SensorArrays::counters(size_t index) const {
  DeviceMemory& memory = *slots_[index].arrays[Array::counters];
  memory.invalidate();
  return *static_cast<const gpu::Counters*>(memory.host());
}

DeviceResults SensorArrays::results(size_t index) {
  Slot& slot = slots_[index];
  return DeviceResults::from(slot.tables, counters(index), [&](Array array) -> const void* {
    const auto is = [&](const Output& output) { return output.array == array; };
    if (std::none_of(outputs_.begin(), outputs_.end(), is)) return nullptr;
    DeviceMemory& memory = *slot.arrays[array];
    memory.invalidate();
    return memory.host();
  });
}

DeviceResults SensorArrays::results(size_t index, uint32_t view, const gpu::Counters& counted) {
  const Slot& slot = slots_[index];
  DeviceResults results = this->results(index);
  results.counters = counted;
  if (slot.views.size() == 1) return results;
  results.tables = results.tables.subspan(view, 1);
  const uint64_t firstBeam = uint64_t{view} * slot.tables[0]->frame.beams;
  const uint64_t firstEntry = (slot.views[view].shot - slot.views[0].shot) * entries();
  const auto move = [](auto*& output, uint64_t first) {
    if (output) output += first;
  };
  move(results.words, firstBeam);
  move(results.laterWords, firstBeam * (plan_.returns - 1));
  move(results.points, firstEntry);
  move(results.owners, firstEntry);
  move(results.intensities, firstEntry);
  move(results.signals, firstEntry);
  move(results.surfaces, firstEntry);
  move(results.motions, firstEntry);
  move(results.barycentrics, firstEntry);
  if (!plan_.computesReturns()) return results;
  DeviceMemory& memory = *slot.arrays[Array::viewCauses];
  memory.invalidate();
  const uint32_t* const causes = static_cast<const uint32_t*>(memory.host()) + size_t{view} * gpu::kCauses;
  if (plan_.signals())
    std::copy_n(causes, gpu::kCauses, results.counters.causes);
  else
    results.counters.hits = causes[0];
  return results;
}

void SensorArrays::addTo(MemoryUse& use) const {
  for (const ArrayTable& own : setArrays_) use.sensor += own.bytes();
  use.work += arrays_.bytes() + lists_.arrays().bytes();
  for (const Slot& slot : slots_) use.work += slot.arrays.bytes();
}

Plan SensorArrays::planOf(size_t shots) {
  const uint32_t ofScan = viewsOfScan(0);
  const auto views = static_cast<uint32_t>(std::clamp<size_t>(shots, 1, mostViews_ / ofScan) * ofScan);
  Slot& slot = slotAt(0);
  if (views > 1) {
    makeRoomForViews(views);
    makeRoomForViews(slot, views);
    std::vector<Variant> variants;
    for (const Step& step : largestScan(views))
      if (step.kind == Step::Kind::dispatch) variants.push_back(step.variant);
    machine_.prepare(variants);
  }
  return planWith(slot, views);
}

// Returns the steps of a submission in which the sensor and the instances move, as far as the plan simulates that.
std::vector<Step> SensorArrays::largestScan(uint32_t views) const {
  const BeamTables& tables = beamSets_.sets[0][0];
  return steps(tables, frameOf(tables, views), kEverything, StillImage::Use::none, motions().back(), shotsIn(views),
               true);
}

Plan SensorArrays::planWith(const Slot& slot, uint32_t views) const {
  Plan plan;
  plan.views = views / viewsOfScan(0);
  plan.effects = plan_.decisions;
  plan.returns = plan_.returns;
  plan.binning = nameOfBinning(binning_);
  const std::vector<Step> scan = largestScan(views);
  plan.commands = commandsOf(scan);
  plan.stages =
      stagesOf(scan, [&](const Variant& variant, Plan::Pipeline& pipeline) { machine_.describe(variant, pipeline); });
  if (leavesWords_ && !keepsRecords()) plan.stages.push_back({"resolve", 0, {}});
  const auto add = [&](const ArrayTable& own) {
    for (size_t i = 0; i < gpu::kArrayCount; ++i)
      if (const auto& memory = own[static_cast<Array>(i)])
        plan.buffers.push_back({gpu::kArrayNames[i], memory->bytes()});
  };
  add(setArrays_[0]);
  add(arrays_);
  add(lists_.arrays());
  add(slot.arrays);
  return plan;
}

}  // namespace gnosphere

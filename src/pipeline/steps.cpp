// SPDX-License-Identifier: Apache-2.0
#include "pipeline/steps.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace gnosphere {
namespace {

// A guess: in towns a projected triangle is tested against so many beams.
constexpr uint64_t kBeamsPerBox = 8;
// Where a subgroup looks at one beam at a time, more of them are wanted. One beam in eight of a town lies on edges.
constexpr uint32_t kSpreadBeamsPerGroup = 8;

class Steps {
 public:
  explicit Steps(const StepsInput& input) : input_(input), binning_(input.variant.options.BINNING) {}

  std::vector<Step> of(const PlacedGroups& placed, StillImage::Use still) {
    clear(still);
    add({Step::Kind::start});
    if (input_.strays) {
      dispatchOnBeams("effects", Kernel::effects_strays);
      finish("effects");
    }
    if (input_.moves && usesBeamFrames(input_.variant.options)) {
      dispatchOnBeams("project", Kernel::beam_frames);
      finish("project");
    }
    if (still != StillImage::Use::use) scanShells(placed.still);
    if (still == StillImage::Use::make) {
      copy(gpu::Array::words, gpu::Array::stillWords);
      // The table is kept as long as the still image.
      dispatch("bin", Kernel::bin, input_.sizes.cullWorkgroups, {.table = gpu::kTableAll}, gpu::kPassBinTable);
    }
    if (still != StillImage::Use::none) scanMoving(placed.moving);
    if (input_.panes && binning_ != gpu::kBinningLists) binPanes();
    if (input_.resolve) {
      dispatchOnBeams("resolve", Kernel::resolve,
                      computesReturns() ? gpu::kPassResolveWords : gpu::kPassResolveResults);
      finish("resolve");
    }
    runEffects();
    if (input_.records != 0) input_.lastViews ? writeRecords() : noteLists();
    return std::move(steps_);
  }

 private:
  // Arrays that lie view after view may have room for more views than this scan has.
  void clear(StillImage::Use still) {
    const gpu::Frame& frame = input_.frame;
    const uint64_t coarse = tableEntries(frame, gpu::kCoarseColumns, gpu::kCoarseRows),
                   fine = tableEntries(frame, gpu::kFineColumns, gpu::kFineRows);
    fill(gpu::Array::counters, 0);
    fill(gpu::Array::shells, 0);
    if ((input_.shells > 1 || input_.sparse) && still != StillImage::Use::use) {
      // Where no beam looks, everything is hidden from the start.
      input_.sparse ? copy(gpu::Array::startFarthest, gpu::Array::farthest)
                    : fill(gpu::Array::farthest, gpu::kNone, 4 * (fine + coarse));
      if (binning_ == gpu::kBinningSlabs) fill(gpu::Array::staleEntries, 0, 4 * coarse);
    }
    if (still == StillImage::Use::use)
      copy(gpu::Array::stillWords, gpu::Array::words);
    else if (binning_ != gpu::kBinningLists)
      input_.holes ? copy(gpu::Array::startWords, gpu::Array::words)
                   : fill(gpu::Array::words, gpu::kNone, 8 * uint64_t{frame.beams});
    const uint64_t ofBeams = sizeof(uint32_t) * uint64_t{frame.beams};
    if (binning_ == gpu::kBinningLists) fill(gpu::Array::listEnds, 0, ofBeams);
    if (binning_ == gpu::kBinningSlabs) fill(gpu::Array::slabEnds, gpu::kNone);
    if ((input_.panes || input_.footprint) && binning_ != gpu::kBinningLists)
      fill(gpu::Array::listEnds, gpu::kNone, ofBeams);
    if (input_.footprint && binning_ != gpu::kBinningLists)
      fill(gpu::Array::covers, 0, sizeof(gpu::Cover) * uint64_t{frame.beams});
    if (input_.panes && computesReturns())
      fillRun(gpu::Array::echoCounts, gpu::kNone, 0, sizeof(uint32_t) * uint64_t{frame.scanBeams} * input_.shots);
    if (input_.views > 1 && computesReturns()) fill(gpu::Array::viewCauses, 0);
    if (input_.laterWords) fill(gpu::Array::laterWords, gpu::kNone);
  }

  // Scans shell by shell, near shells first, because near triangles hide many of the far ones. The device chooses where
  // the shells end. Kernels of shells that turn out to be empty do not run.
  void scanShells(const PlacedGroups::Run& placed) {
    const bool several = input_.shells > 1;
    list({.placedFirst = placed.first, .placedCount = placed.groups, .last = !several});
    if (several) dispatch("project", Kernel::project_groups, 1, {placed.first, placed.groups}, gpu::kPassGroupsShells);
    for (uint32_t shell = 0; shell < input_.shells; ++shell) {
      const bool last = shell + 1 == input_.shells;
      const uint32_t table = last ? gpu::kTableNone : gpu::kTableLater;
      const gpu::Pass pass = {.placedFirst = placed.first,
                              .placedCount = placed.groups,
                              .shell = shell,
                              .last = last,
                              .occluders = shell > 0 || input_.sparse,
                              .clusters = placed.clusters};
      project(placed, pass);
      bin(pass, table);
    }
  }

  void scanMoving(const PlacedGroups::Run& placed) {
    if (placed.groups == 0) return;
    const gpu::Pass pass = {.placedFirst = placed.first,
                            .placedCount = placed.groups,
                            .shell = gpu::kMostShells,
                            .last = 1,
                            .occluders = 1,
                            .clusters = placed.clusters};
    list(pass);
    project(placed, pass);
    bin(pass, gpu::kTableNone);
  }

  // Whether stage bin writes the farthest-range table: the subgroup that owns a slab then owns whole entries.
  bool tableInBin() const {
    return binning_ == gpu::kBinningSlabs && (1u << input_.frame.slabShift) % gpu::kCoarseColumns == 0;
  }

  void list(const gpu::Pass& pass) {
    dispatch("project", Kernel::project_groups, std::min(input_.sizes.cullWorkgroups, (pass.placedCount + 63) / 64),
             pass, gpu::kPassGroupsList);
  }

  void project(const PlacedGroups::Run& placed, const gpu::Pass& pass) {
    const DispatchSizes& sizes = input_.sizes;
    dispatchInShell("project", Kernel::project_clusters, std::min(sizes.cullWorkgroups, placed.groups), pass,
                    offsetof(gpu::Shell, clusterWork));
    dispatchInShell("project", Kernel::project_triangles, std::min(sizes.triangleWorkgroups, placed.clusters), pass,
                    offsetof(gpu::Shell, triangleWork));
    worksOn(uint64_t{placed.clusters} * gpu::kClusterTriangles);
    finish("project");
  }

  void bin(gpu::Pass shell, uint32_t table) {
    const DispatchSizes& sizes = input_.sizes;
    const uint64_t boxes = kBeamsPerBox * uint64_t{input_.frame.projectedCapacity};
    const uint32_t blocks = std::min(sizes.workgroups, input_.frame.beams * input_.views / gpu::kPrefixBlock + 1);
    shell.table = tableInBin() ? table : gpu::kTableNone;
    const auto pass = [&](Kernel kernel, uint32_t number, uint32_t groups) {
      dispatchInShell("bin", kernel, groups, shell, offsetof(gpu::Shell, binWork), number);
      if (kernel == Kernel::bin && number != gpu::kPassBinTable) worksOn(boxes);
    };
    pass(Kernel::bin, 0, sizes.triangleWorkgroups);
    if (binning_ == gpu::kBinningLists) {
      pass(Kernel::prefix_sum, gpu::kPassSumReduce, blocks);
      pass(Kernel::prefix_sum, gpu::kPassSumBlocks, 1);
      pass(Kernel::prefix_sum, gpu::kPassSumApply, blocks);
      pass(Kernel::bin, gpu::kPassBinFill, sizes.workgroups);
    }
    if (table != gpu::kTableNone && !tableInBin()) {
      shell.table = table;
      pass(Kernel::bin, gpu::kPassBinTable, sizes.triangleWorkgroups);
    }
    finish("bin");
  }

  // Lists the panes before the words, after all shells.
  void binPanes() {
    fillRun(gpu::Array::shells, 0, gpu::kMostShells * sizeof(gpu::Shell) + offsetof(gpu::Shell, nextSlab),
            sizeof(gpu::Shell::nextSlab));
    dispatch("bin", Kernel::bin, input_.sizes.triangleWorkgroups, {.shell = gpu::kMostShells}, gpu::kPassBinPanes);
    finish("bin");
  }

  void runEffects() {
    if (input_.footprint) {
      for (const uint32_t pass : {gpu::kPassFootprintWithinOne, gpu::kPassFootprintOthers})
        dispatchOnList(Kernel::effects_footprint, pass);
      if (input_.variant.options.LAYERS > 1) dispatchOnList(Kernel::effects_footprint, gpu::kPassFootprintPanesToo);
    }
    if (input_.panes) dispatchOnList(Kernel::effects_panes, 0);
    if (computesReturns()) dispatchOnBeams("effects", Kernel::effects);
    if (input_.effects == StepsInput::Returns::listed) dispatchOnList(Kernel::effects, gpu::kPassEffectsListed);
    if (input_.footprint || input_.effects != StepsInput::Returns::none) finish("effects");
  }

  // The records come after the last views of their shots, when the counters of this submission are gone.
  void noteLists() { dispatch("records", Kernel::records, 1, {}, gpu::kPassRecordsNoteLists, input_.shots); }

  void writeRecords() {
    const auto pass = [&](uint32_t number, uint64_t entriesPerGroup) {
      const uint64_t groups = std::min<uint64_t>(input_.sizes.workgroups, input_.entries / entriesPerGroup + 1);
      dispatch("records", Kernel::records, static_cast<uint32_t>(groups), {}, number, input_.shots);
    };
    if (input_.organised) {
      dispatch("records", Kernel::records, 1, {}, gpu::kPassRecordsSample);
      dispatch("records", Kernel::records, 1, {}, gpu::kPassRecordsHeaderOfAll, input_.shots);
    } else {
      const bool oneBlock = input_.entries <= gpu::kPrefixBlock;
      if (!oneBlock) pass(gpu::kPassRecordsCount, gpu::kPrefixBlock);
      dispatch("records", Kernel::records, 1, {}, gpu::kPassRecordsHeader, input_.shots);
      if (!oneBlock) pass(gpu::kPassRecordsEntries, gpu::kPrefixBlock);
    }
    pass(gpu::kPassRecordsWrite, 256);
    finish("records");
  }

  // Dispatches a kernel that processes the beams of `hardBeams`.
  void dispatchOnList(Kernel kernel, uint32_t pass) {
    const uint32_t groups = input_.footprint ? input_.sizes.footprintWorkgroups : input_.sizes.workgroups;
    const uint32_t beamsPerGroup = spreads(kernel, pass) ? kSpreadBeamsPerGroup : 64;
    const uint32_t beams = input_.frame.beams * input_.views;
    dispatch("effects", kernel, std::min(groups, beams / beamsPerGroup + 1), {}, pass);
    const Options& options = steps_.back().variant.options;
    inRuns(uint64_t{beams} * std::max(options.RAYS, options.SPREAD_RAYS) * options.LAYERS);
  }

  // The first pass of footprints finishes most beams by a short test, which an invocation does alone.
  bool spreads(Kernel kernel, uint32_t pass) const {
    return input_.raysPerLane > 0 && kernel == Kernel::effects_footprint && pass != gpu::kPassFootprintWithinOne;
  }

  bool computesReturns() const { return input_.effects == StepsInput::Returns::all; }

  // Dispatches one row of workgroups per channel of each view; the beams of a list are one row.
  void dispatchOnBeams(const char* stage, Kernel kernel, uint32_t pass = 0) {
    const bool listed = input_.variant.options.LISTED != 0;
    const uint32_t columns = listed ? input_.frame.beams : input_.frame.beamColumnCount;
    dispatch(stage, kernel, (columns + gpu::kResolveColumns - 1) / gpu::kResolveColumns, {}, pass,
             (listed ? 1 : input_.frame.rows) * input_.views);
    if (!steps_.empty()) inRuns(uint64_t{input_.frame.beams} * input_.views);
  }

  // With several shells, earlier kernels decide whether the kernels of a shell run. `work` is the place of this
  // kernel's number of workgroups in its shell.
  void dispatchInShell(const char* stage, Kernel kernel, uint32_t groups, const gpu::Pass& pass, uint64_t work,
                       uint32_t number = 0) {
    const size_t before = steps_.size();
    dispatch(stage, kernel, groups, pass, number);
    const bool decided = input_.shells > 1 && pass.shell < gpu::kMostShells;
    if (decided && steps_.size() > before) steps_.back().arguments = pass.shell * sizeof(gpu::Shell) + work;
  }

  void dispatch(const char* stage, Kernel kernel, uint32_t workgroupsX, const gpu::Pass& pass, uint32_t number = 0,
                uint32_t workgroupsY = 1) {
    Step step = {Step::Kind::dispatch, stage};
    step.variant = input_.variant;
    step.variant.kernel = kernel;
    step.variant.options.PASS = number;
    step.variant.float64 = input_.variant.float64 && (kernel == Kernel::project_triangles || kernel == Kernel::bin);
    const bool looksAtRays = kernel == Kernel::effects_footprint || (kernel == Kernel::bin && input_.footprint);
    if (!looksAtRays) step.variant.options.RAYS = 1;
    if (spreads(kernel, number))
      step.variant.options.SPREAD_RAYS = std::exchange(step.variant.options.RAYS, input_.raysPerLane);
    if (kernel == Kernel::effects_footprint && number == gpu::kPassFootprintOthers) step.variant.options.LAYERS = 1;
    // Nothing but the lasers' origins: these kernels need no poses.
    const bool bounds = kernel == Kernel::project_groups || kernel == Kernel::project_clusters ||
                        kernel == Kernel::project_triangles || kernel == Kernel::bin;
    if (bounds && !input_.moves) step.variant.options.MOTION = 0;
    if (step.variant.options.MOTION == 0) step.variant.options.STAGGERED = 0;
    step.variant.options.DEFORMED = input_.deformed ? deformedFor(kernel) : gpu::kDeformsNothing;
    if (kernel == Kernel::records) step.variant.options.RECORDS = input_.records;
    step.pass = pass;
    step.workgroupsX = workgroupsX;
    step.workgroupsY = workgroupsY;
    if (workgroupsX > 0 && workgroupsY > 0) add(step);
  }

  void worksOn(uint64_t work) {
    if (!steps_.empty() && steps_.back().kind == Step::Kind::dispatch) steps_.back().work = work;
  }

  // The last step's kernel divides its beams by runs.glsl.
  void inRuns(uint64_t work) {
    steps_.back().pass.groups = steps_.back().workgroupsX;
    worksOn(work);
  }

  // Kernels that look at surfaces read the positions that `project` stores for them; they need no more unless the
  // vertices move during the scan.
  uint32_t deformedFor(Kernel kernel) const {
    switch (kernel) {
      case Kernel::project_clusters: return gpu::kDeforms;
      case Kernel::project_triangles: return input_.looksAtSurfaces ? gpu::kDeformsAndStores : gpu::kDeforms;
      case Kernel::effects_panes:
      case Kernel::effects: return input_.variant.options.MOTION != 0 ? gpu::kDeforms : gpu::kDeformsNothing;
      default: return gpu::kDeformsNothing;
    }
  }

  // `bytesPerView` is 0 for the whole array.
  void fill(gpu::Array array, uint32_t value, uint64_t bytesPerView = 0) {
    fillRun(array, value, 0, bytesPerView * input_.views);
  }
  void fillRun(gpu::Array array, uint32_t value, uint64_t first, uint64_t bytes) {
    add({.kind = Step::Kind::fill, .array = array, .first = first, .bytes = bytes, .value = value});
  }
  void copy(gpu::Array from, gpu::Array to) { add({.kind = Step::Kind::copy, .array = to, .from = from}); }
  void finish(const char* stage) { add({Step::Kind::finish, stage}); }
  void add(const Step& step) { steps_.push_back(step); }

  const StepsInput& input_;
  uint32_t binning_;
  std::vector<Step> steps_;
};

}  // namespace

uint64_t tableEntries(const gpu::Frame& frame, uint64_t columns, uint64_t rows) {
  return (frame.columns + columns - 1) / columns * ((frame.rows + rows - 1) / rows);
}

std::vector<Step> stepsOf(const StepsInput& input, const PlacedGroups& placed, StillImage::Use still) {
  return Steps(input).of(placed, still);
}

std::vector<Step> inSubmissions(std::span<const Step> steps, uint64_t most) {
  std::vector<Step> result;
  uint64_t left = most;
  for (const Step& step : steps) {
    const uint64_t wanted = (step.work + most - 1) / most;
    const uint64_t parts = step.pass.groups > 0 ? std::clamp<uint64_t>(wanted, 1, step.workgroupsX) : 1;
    for (uint64_t part = 0; part < parts; ++part) {
      Step one = step;
      one.work = step.work / parts;
      if (parts > 1) {
        const auto end = static_cast<uint32_t>(step.workgroupsX * (part + 1) / parts);
        one.pass.firstGroup = static_cast<uint32_t>(step.workgroupsX * part / parts);
        one.workgroupsX = end - one.pass.firstGroup;
      }
      if (one.work > left && left < most) {
        result.push_back({Step::Kind::cut});
        left = most;
      }
      left -= std::min(left, one.work);
      result.push_back(one);
    }
  }
  return result;
}

bool needsBarrier(std::span<const Step> steps, size_t i) {
  const Step::Kind kind = steps[i].kind;
  if (kind == Step::Kind::start || kind == Step::Kind::finish || kind == Step::Kind::cut) return false;
  return kind != Step::Kind::fill || i + 1 == steps.size() || steps[i + 1].kind != kind;
}

Plan::Commands commandsOf(std::span<const Step> steps) {
  Plan::Commands commands;
  for (size_t i = 0; i < steps.size(); ++i) {
    commands.fills += steps[i].kind == Step::Kind::fill;
    commands.copies += steps[i].kind == Step::Kind::copy;
    commands.dispatches += steps[i].kind == Step::Kind::dispatch;
    commands.barriers += needsBarrier(steps, i);
  }
  return commands;
}

std::vector<Plan::Stage> stagesOf(const std::vector<Step>& steps,
                                  const std::function<void(const Variant&, Plan::Pipeline&)>& describe) {
  std::vector<Plan::Stage> stages;
  for (const Step& step : steps) {
    if (step.kind != Step::Kind::dispatch) continue;
    auto stage = std::find_if(stages.begin(), stages.end(), [&](const auto& s) { return s.name == step.stage; });
    if (stage == stages.end()) stage = stages.insert(stages.end(), {step.stage, 0, {}});
    ++stage->dispatches;
    const OptionWords words = wordsOf(step.variant.options);
    Plan::Pipeline pipeline = {nameOf(step.variant.kernel), {words.begin(), words.end()}};
    const auto same = [&](const Plan::Pipeline& other) {
      return other.name == pipeline.name && other.constants == pipeline.constants;
    };
    if (std::any_of(stage->pipelines.begin(), stage->pipelines.end(), same)) continue;
    describe(step.variant, pipeline);
    stage->pipelines.push_back(std::move(pipeline));
  }
  return stages;
}

}  // namespace gnosphere

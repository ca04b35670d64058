// SPDX-License-Identifier: Apache-2.0
// A scan as a list of steps that a device executes in order. Every step sees all writes of the steps before it. Vulkan
// records the list, CUDA launches it, and the stages of a Plan are computed from it.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "common/arrays.h"
#include "common/shared.h"
#include "geometry/instance_table.hpp"
#include "pipeline/kernels.hpp"
#include "pipeline/still_image.hpp"
#include "pipeline/tuning.hpp"

namespace gnosphere {

struct Step {
  enum class Kind {
    fill,      ///< fills `array` from byte `first` on with the 32-bit `value`; 0 bytes means up to the end
    copy,      ///< copies all of `from` to `array`
    start,     ///< timestamp: the first stage starts here
    dispatch,  ///< runs workgroupsX x workgroupsY workgroups of `variant`, or fewer: see `arguments`
    finish,    ///< timestamp: a part of `stage` ends here
    cut,       ///< a submission ends here; a device to which steps are not submitted ignores it
  };
  Kind kind;
  const char* stage = "";
  gpu::Array array = {}, from = {};
  uint64_t first = 0, bytes = 0;
  uint32_t value = 0;
  Variant variant;
  gpu::Pass pass = {};
  uint32_t workgroupsX = 0, workgroupsY = 1;
  /// If set, an offset in bytes into the array `shells`: earlier kernels write the number of workgroups there, none if
  /// there is nothing to do. A device may run `workgroupsX` instead; without work they end at once.
  std::optional<uint64_t> arguments = {};
  /// How many triangles or lines of light a dispatch looks at, at most and roughly. Dispatches that look at few have 0.
  uint64_t work = 0;
};

/// Everything that determines the steps of a sensor's scans.
struct StepsInput {
  Variant variant;  ///< options that all kernels of the scan share
  DispatchSizes sizes;
  const gpu::Frame& frame;
  uint32_t shells;     ///< most shells of the scan
  uint32_t views = 1;  ///< of the submission
  uint32_t shots = 1;  ///< to which the views belong
  bool strays = false, panes = false, footprint = false, resolve = false;
  bool moves = false;     ///< something moves during the scan; otherwise MOTION is about lasers with origins only
  bool deformed = false;  ///< the scene has deformable meshes
  bool looksAtSurfaces = false;  ///< some kernels read the corners of the triangles that are hit
  bool holes = false;            ///< some places of the grid have no beam
  bool sparse = false;           ///< parts of the grid have no beams
  bool laterWords = false;       ///< only listed beams store words of returns after the first
  uint32_t raysPerLane = 0;      ///< see raysPerLane()
  uint32_t records = 0;          ///< if results stay on the device: RecordTables::held
  uint64_t entries = 0;          ///< returns of all beams of a shot, with those that are missing
  bool organised = false;        ///< records of all entries
  bool lastViews = true;         ///< of their shots; after them come the records
  enum class Returns {
    none,
    listed,
    all
  } effects = Returns::none;  ///< the beams whose returns are computed from echoes
};

/// Returns the number of entries of one level of the farthest-range table, each of which covers `columns` x `rows`
/// beams.
uint64_t tableEntries(const gpu::Frame& frame, uint64_t columns, uint64_t rows);

/// Returns the steps of a scan of the placed groups.
std::vector<Step> stepsOf(const StepsInput& input, const PlacedGroups& placed, StillImage::Use still);

/// Returns the steps with cuts, so that no submission has more work than `most`. Steps of kernels that divide their
/// beams by runs.glsl are divided; other steps of more work are submissions of their own.
std::vector<Step> inSubmissions(std::span<const Step> steps, uint64_t most);

/// Whether the step after steps[i] must wait for it. Consecutive fills write different bytes, so they need no order.
bool needsBarrier(std::span<const Step> steps, size_t i);

/// Returns the commands by which Vulkan executes the steps.
Plan::Commands commandsOf(std::span<const Step> steps);

/// Returns the stages with their pipelines and the number of dispatches, counted from the steps. `describe` is called
/// for each pipeline.
std::vector<Plan::Stage> stagesOf(const std::vector<Step>& steps,
                                  const std::function<void(const Variant&, Plan::Pipeline&)>& describe);

}  // namespace gnosphere

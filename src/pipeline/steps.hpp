// SPDX-License-Identifier: Apache-2.0
// A scan as data: what a device does for it, in order. Every step sees what the steps before it have written. Vulkan
// records the list, CUDA launches it, and a Plan is counted from it.
#pragma once

#include <cstdint>
#include <vector>

#include "arrays.h"
#include "geometry/instance_table.hpp"
#include "pipeline/kernels.hpp"
#include "pipeline/still_image.hpp"
#include "pipeline/tuning.hpp"
#include "shared.h"

namespace gnosphere {

struct Step {
  enum class Kind {
    fill,      ///< bytes first..first + bytes of `array` get the 32-bit `value`; 0 bytes: up to the end
    copy,      ///< all of `from` to `array`
    start,     ///< the time of the first stage starts here
    dispatch,  ///< groupsX x groupsY workgroups of `variant`
    finish,    ///< a part of `stage` ends here
  };
  Kind kind;
  const char* stage = "";
  gpu::Array array = {}, from = {};
  uint64_t first = 0, bytes = 0;
  uint32_t value = 0;
  Variant variant;
  gpu::Pass pass = {};
  uint32_t groupsX = 0, groupsY = 1;
};

/// What decides the steps of a sensor's scans.
struct StepsInput {
  Variant variant;  ///< what all kernels of the scan have in common
  DispatchSizes sizes;
  const gpu::Frame& frame;
  const std::vector<float>& shellEnds;  ///< see tuning.hpp
  bool footprint, resolve, surfaces, effects;
};

/// The steps of a scan of what is placed.
std::vector<Step> stepsOf(const StepsInput& input, const PlacedGroups& placed, StillImage::Use still);

/// The stages with their pipelines and the number of dispatches, counted from the steps.
std::vector<Plan::Stage> stagesOf(const std::vector<Step>& steps);

}  // namespace gnosphere

// SPDX-License-Identifier: Apache-2.0
#include "vulkan/kernel.hpp"

#include <algorithm>
#include <set>
#include <span>
#include <utility>

#include "base/clock.hpp"
#include "base/hash.hpp"
#include "base/threads.hpp"
#include "beam_frames.spv.h"
#include "bin.spv.h"
#include "bin_int64.spv.h"
#include "bin_int64_float64.spv.h"
#include "effects.spv.h"
#include "effects_footprint_int64.spv.h"
#include "effects_footprint_looped.spv.h"
#include "effects_panes.spv.h"
#include "effects_strays.spv.h"
#include "fit_clusters.spv.h"
#include "place_instances.spv.h"
#include "prefix_sum.spv.h"
#include "project_clusters.spv.h"
#include "project_clusters_int64.spv.h"
#include "project_groups.spv.h"
#include "project_groups_int64.spv.h"
#include "project_triangles.spv.h"
#include "project_triangles_int64.spv.h"
#include "project_triangles_int64_float64.spv.h"
#include "records.spv.h"
#include "resolve.spv.h"
#include "vulkan/execution_modes.hpp"

namespace gnosphere::vulkan {
namespace {

using Module = std::span<const uint32_t>;

// Returns the module without 64-bit atomics if hits are collected in lists, as on devices without these atomics.
Module byAtomics(const Variant& variant, Module without, Module with) {
  return variant.options.BINNING == gpu::kBinningLists ? without : with;
}

// As above, for a kernel with a further module that uses double precision.
Module byAtomics(const Variant& variant, Module without, Module with, Module withDoubles) {
  return variant.float64 ? withDoubles : byAtomics(variant, without, with);
}

Module moduleOf(const Variant& variant, bool unrolls) {
  switch (variant.kernel) {
    case Kernel::fit_clusters: return fit_clusters;
    case Kernel::place_instances: return place_instances;
    case Kernel::beam_frames: return beam_frames;
    case Kernel::project_groups: return byAtomics(variant, project_groups, project_groups_int64);
    case Kernel::project_clusters: return byAtomics(variant, project_clusters, project_clusters_int64);
    case Kernel::project_triangles:
      return byAtomics(variant, project_triangles, project_triangles_int64, project_triangles_int64_float64);
    case Kernel::bin: return byAtomics(variant, bin, bin_int64, bin_int64_float64);
    case Kernel::prefix_sum: return prefix_sum;
    case Kernel::resolve: return resolve;
    case Kernel::effects_strays: return effects_strays;
    case Kernel::effects_footprint:
      return byAtomics(variant, effects_footprint_looped,
                       unrolls ? Module(effects_footprint_int64) : effects_footprint_looped);
    case Kernel::effects_panes: return effects_panes;
    case Kernel::records: return records;
    case Kernel::effects: break;
  }
  return effects;
}

// A kernel without subgroup operations leaves the size of its subgroups to the driver.
bool usesSubgroups(Kernel kernel) {
  return kernel != Kernel::place_instances && kernel != Kernel::prefix_sum && kernel != Kernel::records;
}

// Returns whether a lane of the kernel holds so many values that fewer lanes are better where registers are short, by
// the table in docs/gpus.md.
bool holdsMuch(const Variant& variant) {
  const Options& options = variant.options;
  if (variant.kernel == Kernel::bin)
    return options.MOTION != 0 || options.RAYS > 1 || options.RANGE == gpu::kRangeExact;
  return variant.kernel == Kernel::project_triangles ||
         (variant.kernel == Kernel::effects_footprint && variant.options.SPREAD_RAYS == 0);
}

uint32_t lanesOf(const FullSubgroups& subgroups, const Variant& variant) {
  return subgroups.few > 0 && holdsMuch(variant) ? subgroups.few : subgroups.size;
}

// Returns kVertexRounds of cluster_corners.glsl: six rounds of 8 lanes hold 48 vertices, which is enough for most
// clusters. Wide subgroups have room for the 96 vertices that a cluster has at most with three rounds, or with two.
uint32_t vertexRounds(uint32_t lanes) {
  return lanes <= 8 ? 6 : std::max(96 / lanes, 2u);
}

constexpr VkPushConstantRange kPushConstants = {VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(PushConstants)};

// The values of a module's specialisation constants, for a driver that puts them into the module.
class Constants {
 public:
  explicit Constants(const std::vector<uint32_t>& values) {
    for (uint32_t i = 0; i < values.size(); ++i)
      places_.push_back({i, i * static_cast<uint32_t>(sizeof values[0]), sizeof values[0]});
    info_ = {static_cast<uint32_t>(places_.size()), places_.data(), values.size() * sizeof values[0], values.data()};
  }
  const VkSpecializationInfo& info() const { return info_; }

 private:
  std::vector<VkSpecializationMapEntry> places_;
  VkSpecializationInfo info_;
};

DeviceHandle<VkShaderEXT> makeShader(const ShaderFiles& files, const Variant& variant, const KernelCode& code,
                                     const KernelDigest& digest) {
  VkShaderCreateInfoEXT create = {VK_STRUCTURE_TYPE_SHADER_CREATE_INFO_EXT};
  if (usesSubgroups(variant.kernel)) create.flags = VK_SHADER_CREATE_REQUIRE_FULL_SUBGROUPS_BIT_EXT;
  create.stage = VK_SHADER_STAGE_COMPUTE_BIT;
  create.codeType = VK_SHADER_CODE_TYPE_SPIRV_EXT;
  create.codeSize = code.words.size() * sizeof code.words[0];
  create.pCode = code.words.data();
  create.pName = "main";
  create.pushConstantRangeCount = 1;
  create.pPushConstantRanges = &kPushConstants;
  const Constants constants(code.constants);
  if (!code.specialised) create.pSpecializationInfo = &constants.info();
  return files.make(digest, create);
}

DeviceHandle<VkPipeline> makePipeline(const Device& device, const Variant& variant, const KernelCode& code,
                                      VkPipelineLayout layout, VkPipelineCache cache) {
  const DeviceFunctions& vk = device.vk();
  const std::vector<uint32_t>& spirv = code.words;
  VkShaderModuleCreateInfo module = {VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
  module.codeSize = spirv.size() * sizeof spirv[0];
  module.pCode = spirv.data();
  const DeviceHandle<VkShaderModule> shader = device.make(vk.vkCreateShaderModule, vk.vkDestroyShaderModule, module);
  VkComputePipelineCreateInfo create = {VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
  create.stage = {VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO};
  create.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
  create.stage.module = shader.get();
  create.stage.pName = "main";
  VkPipelineShaderStageRequiredSubgroupSizeCreateInfoEXT size = {
      VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_REQUIRED_SUBGROUP_SIZE_CREATE_INFO_EXT};
  size.requiredSubgroupSize = code.lanes;
  if (usesSubgroups(variant.kernel)) {
    create.stage.flags = VK_PIPELINE_SHADER_STAGE_CREATE_REQUIRE_FULL_SUBGROUPS_BIT_EXT;
    if (device.capabilities().subgroups.required) create.stage.pNext = &size;
  }
  const Constants constants(code.constants);
  if (!code.specialised) create.stage.pSpecializationInfo = &constants.info();
  create.layout = layout;
  if (device.statistics()) create.flags |= VK_PIPELINE_CREATE_CAPTURE_STATISTICS_BIT_KHR;
  VkPipeline pipeline = VK_NULL_HANDLE;
  VK(vk.vkCreateComputePipelines(device.handle(), cache, 1, &create, nullptr, &pipeline));
  return {pipeline, vk.vkDestroyPipeline, device.handle(), &device.hangs()};
}

double valueOf(const VkPipelineExecutableStatisticKHR& statistic) {
  switch (statistic.format) {
    case VK_PIPELINE_EXECUTABLE_STATISTIC_FORMAT_BOOL32_KHR: return statistic.value.b32;
    case VK_PIPELINE_EXECUTABLE_STATISTIC_FORMAT_INT64_KHR: return static_cast<double>(statistic.value.i64);
    case VK_PIPELINE_EXECUTABLE_STATISTIC_FORMAT_FLOAT64_KHR: return statistic.value.f64;
    default: return static_cast<double>(statistic.value.u64);
  }
}

// Some drivers compile a kernel several times, as Intel's does for each subgroup size: the first executable counts.
void addStatistics(const Device& device, VkPipeline compiled, Plan::Pipeline& pipeline) {
  const DeviceFunctions& vk = device.vk();
  const VkPipelineInfoKHR of = {VK_STRUCTURE_TYPE_PIPELINE_INFO_KHR, nullptr, compiled};
  VkPipelineExecutablePropertiesKHR executable = {VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_PROPERTIES_KHR};
  uint32_t count = 1;
  const VkResult result = vk.vkGetPipelineExecutablePropertiesKHR(device.handle(), &of, &count, &executable);
  if ((result != VK_SUCCESS && result != VK_INCOMPLETE) || count == 0) return;
  if (executable.subgroupSize > 0) pipeline.subgroupSize = executable.subgroupSize;
  const VkPipelineExecutableInfoKHR first = {VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_INFO_KHR, nullptr, compiled, 0};
  VK(vk.vkGetPipelineExecutableStatisticsKHR(device.handle(), &first, &count, nullptr));
  std::vector<VkPipelineExecutableStatisticKHR> statistics(count,
                                                           {VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_STATISTIC_KHR});
  VK(vk.vkGetPipelineExecutableStatisticsKHR(device.handle(), &first, &count, statistics.data()));
  for (const auto& statistic : statistics) pipeline.statistics.push_back({statistic.name, valueOf(statistic)});
}

}  // namespace

KernelCode codeOf(const Capabilities& capabilities, const Variant& variant, Specialise specialise) {
  KernelCode code;
  const OptionWords options = wordsOf(variant.options);
  code.constants.assign(options.begin(), options.end());
  // The constants kVertexRounds, kLanesInStep and kOwnAddresses follow from the device, and not from the scan. Their
  // numbers stand in shaders/cluster_corners.glsl, options.glsl and bindings.glsl.
  static_assert(std::tuple_size_v<OptionWords> == 23);
  code.lanes = lanesOf(capabilities.subgroups, variant);
  code.constants.push_back(vertexRounds(code.lanes));
  code.constants.push_back(capabilities.cpu);
  code.constants.push_back(capabilities.loadsUntaken);
  static_cast<Code&>(code) =
      specialise(moduleOf(variant, capabilities.unrolls), code.constants, capabilities.keepsVectors);
  if (capabilities.keepsSpecialFloats) code.words = keepingSpecialFloats(code.words);
  if (capabilities.uniformControlFlow && usesSubgroups(variant.kernel)) code.words = withUniformControlFlow(code.words);
  return code;
}

KernelDigest digestOf(const KernelCode& code) {
  Hasher hasher;
  hasher.add(code.words);
  if (!code.specialised) hasher.add(code.constants);
  hasher.add(&code.lanes, sizeof code.lanes);
  return hasher.hex();
}

Kernels::Kernels(const Device& device, const PipelineCache& cache, Specialise specialise)
    : device_(device), cache_(cache), specialise_(specialise) {
  VkPipelineLayoutCreateInfo layout = {VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
  layout.pushConstantRangeCount = 1;
  layout.pPushConstantRanges = &kPushConstants;
  layout_ = device.make(device.vk().vkCreatePipelineLayout, device.vk().vkDestroyPipelineLayout, layout);
}

struct Kernels::Missing {
  Variant variant;
  KernelCode code = {};
  KernelDigest digest = {};
  Compiled compiled = {};
};

void Kernels::make(Missing& one) const {
  const Clock::time_point start = Clock::now();
  if (const ShaderFiles* files = cache_.shaders())
    one.compiled.shader = makeShader(*files, one.variant, one.code, one.digest);
  else
    one.compiled.pipeline = makePipeline(device_, one.variant, one.code, layout_.get(), cache_.handle());
  one.compiled.ms = millisecondsSince(start);
}

const Kernels::Compiled* Kernels::find(const Variant& variant) const {
  const std::shared_lock lock(mutex_);
  const auto found = pipelines_.find(variant);
  return found == pipelines_.end() ? nullptr : found->second;
}

size_t Kernels::count() const {
  const std::shared_lock lock(mutex_);
  return compiled_.size();
}

void Kernels::prepare(std::span<const Variant> variants) {
  const std::lock_guard alone(preparing_);
  std::vector<Missing> missing;
  for (const Variant& variant : std::set<Variant>(variants.begin(), variants.end()))
    if (!find(variant)) missing.push_back({variant});
  std::reverse(missing.begin(), missing.end());  // the kernels of effects take longest, so they begin first
  inRuns(missing.size(), 1, threadCount(), [&](uint64_t i, uint64_t) {
    missing[i].code = codeOf(device_.capabilities(), missing[i].variant, specialise_);
    missing[i].digest = digestOf(missing[i].code);
  });
  std::vector<Missing*> different;
  std::set<KernelDigest> digests;
  for (Missing& one : missing)
    if (!compiled_.contains(one.digest) && digests.insert(one.digest).second) different.push_back(&one);
  inRuns(different.size(), 1, threadCount(), [&](uint64_t i, uint64_t) { make(*different[i]); });
  const std::lock_guard lock(mutex_);
  for (Missing* one : different) compiled_[one->digest] = std::move(one->compiled);
  for (const Missing& one : missing) pipelines_[one.variant] = &compiled_.at(one.digest);
}

KernelHandle Kernels::of(const Variant& variant) const {
  const Compiled* const compiled = find(variant);
  return compiled ? KernelHandle{compiled->pipeline.get(), compiled->shader.get()} : KernelHandle();
}

void Kernels::describe(const Variant& variant, Plan::Pipeline& pipeline) const {
  const Compiled* const compiled = find(variant);
  if (!compiled) return;
  pipeline.compileMs = compiled->ms;
  pipeline.subgroupSize = lanesOf(device_.capabilities().subgroups, variant);
  if (device_.statistics()) addStatistics(device_, compiled->pipeline.get(), pipeline);
}

}  // namespace gnosphere::vulkan

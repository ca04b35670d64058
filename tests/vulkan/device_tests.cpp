// SPDX-License-Identifier: Apache-2.0
// The tests create objects on a device, and submit work to it.
#include <unistd.h>

#include <algorithm>
#include <array>
#include <catch2/matchers/catch_matchers.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <cstdio>
#include <cstring>

#include "problem.hpp"
#include "support.hpp"
#include "vulkan/commands.hpp"
#include "vulkan/device_functions.hpp"
#include "vulkan/pipeline_cache.hpp"
#include "vulkan/transfer.hpp"

namespace gnosphere::test {
namespace {

using Catch::Matchers::ContainsSubstring;

// Wraps a device's functions: objects are counted, and one call may be made to fail. Functions that allocate from a
// pool only count as calls, because their objects are destroyed with the pool.
struct Calls {
  vulkan::DeviceFunctions real;
  int failing = -1;  // number of the call that fails, from 0
  int made = 0;      // calls so far
  int alive = 0;     // objects created and not destroyed
  bool fails() { return made++ == failing; }
} calls;

template <auto kFunction, typename Info, typename T>
VKAPI_ATTR VkResult VKAPI_CALL create(VkDevice device, const Info* info, const VkAllocationCallbacks* with, T* object) {
  if (calls.fails()) return VK_ERROR_OUT_OF_HOST_MEMORY;
  const VkResult result = (calls.real.*kFunction)(device, info, with, object);
  calls.alive += result == VK_SUCCESS;
  return result;
}

template <auto kFunction, typename T>
VKAPI_ATTR void VKAPI_CALL destroy(VkDevice device, T object, const VkAllocationCallbacks* with) {
  calls.alive -= object != VK_NULL_HANDLE;
  (calls.real.*kFunction)(device, object, with);
}

template <auto kFunction, typename... Arguments>
VKAPI_ATTR VkResult VKAPI_CALL attempt(Arguments... arguments) {
  return calls.fails() ? VK_ERROR_OUT_OF_HOST_MEMORY : (calls.real.*kFunction)(arguments...);
}

VKAPI_ATTR VkResult VKAPI_CALL createPipelines(VkDevice device, VkPipelineCache cache, uint32_t count,
                                               const VkComputePipelineCreateInfo* infos,
                                               const VkAllocationCallbacks* with, VkPipeline* pipelines) {
  if (calls.fails()) return VK_ERROR_OUT_OF_HOST_MEMORY;
  const VkResult result = calls.real.vkCreateComputePipelines(device, cache, count, infos, with, pipelines);
  calls.alive += result == VK_SUCCESS ? static_cast<int>(count) : 0;
  return result;
}

void countCalls(vulkan::DeviceFunctions& vk) {
  using Table = vulkan::DeviceFunctions;
  calls = {vk};
  vk.vkCreateBuffer = create<&Table::vkCreateBuffer>;
  vk.vkDestroyBuffer = destroy<&Table::vkDestroyBuffer>;
  vk.vkAllocateMemory = create<&Table::vkAllocateMemory>;
  vk.vkFreeMemory = destroy<&Table::vkFreeMemory>;
  vk.vkBindBufferMemory = attempt<&Table::vkBindBufferMemory>;
  vk.vkMapMemory = attempt<&Table::vkMapMemory>;
  vk.vkCreateCommandPool = create<&Table::vkCreateCommandPool>;
  vk.vkDestroyCommandPool = destroy<&Table::vkDestroyCommandPool>;
  vk.vkAllocateCommandBuffers = attempt<&Table::vkAllocateCommandBuffers>;
  vk.vkCreateQueryPool = create<&Table::vkCreateQueryPool>;
  vk.vkDestroyQueryPool = destroy<&Table::vkDestroyQueryPool>;
  vk.vkCreateFence = create<&Table::vkCreateFence>;
  vk.vkDestroyFence = destroy<&Table::vkDestroyFence>;
  vk.vkCreatePipelineLayout = create<&Table::vkCreatePipelineLayout>;
  vk.vkDestroyPipelineLayout = destroy<&Table::vkDestroyPipelineLayout>;
  vk.vkCreateShaderModule = create<&Table::vkCreateShaderModule>;
  vk.vkDestroyShaderModule = destroy<&Table::vkDestroyShaderModule>;
  vk.vkCreatePipelineCache = create<&Table::vkCreatePipelineCache>;
  vk.vkDestroyPipelineCache = destroy<&Table::vkDestroyPipelineCache>;
  vk.vkCreateComputePipelines = createPipelines;
  vk.vkDestroyPipeline = destroy<&Table::vkDestroyPipeline>;
}

// Creates one of every class that owns objects of a device.
void makeEverything(const vulkan::Device& device) {
  const vulkan::PipelineCache cache(device, "off");
  vulkan::Kernels kernels(device, cache);
  for (const Kernel kernel : {Kernel::prefix_sum, Kernel::project_groups}) {
    Variant variant;
    variant.kernel = kernel;
    kernels.prepare({&variant, 1});
  }
  const vulkan::Commands commands(device);
  vulkan::Transfer transfer(device, device.maxBufferBytes());
  const std::vector<uint32_t> numbers = {1, 2, 3};
  std::vector<vulkan::Buffer> buffers;
  buffers.emplace_back(device, "numbers", 12, MemoryKind::device);
  transfer.write(buffers.front(), 0, std::as_bytes(std::span(numbers)));
  buffers.emplace_back(device, "upload", 1000, MemoryKind::upload);
  buffers.front() = vulkan::Buffer(device, "others", 100, MemoryKind::readback);
}

}  // namespace

TEST_CASE("a failing Vulkan call, whichever it is, leaks no object") {
  needVulkan();
  auto device = std::make_unique<vulkan::Device>(DeviceChoice(), vulkanOptions().validation);
  const auto messages = device->messages();
  countCalls(functionsOf(*device));
  makeEverything(*device);
  CHECK(calls.alive == 0);
  const int count = calls.made;
  CHECK(count > 15);
  int thrown = 0;
  for (int failing = 0; failing < count; ++failing) {
    INFO("call " << failing);
    calls.made = 0;
    calls.failing = failing;
    // Some failures are followed by another attempt: of the cache without a file, of memory with a smaller block.
    try {
      makeEverything(*device);
    } catch (const Error&) {
      ++thrown;
    }
    CHECK(calls.alive == 0);
  }
  CHECK(thrown > 10);
  device.reset();
  CHECK_NOTHROW(messages->throwIfAny());
}

TEST_CASE("a lost device is an error that tells what ran, and a wait ends") {
  needVulkan();
  vulkan::Device device({}, vulkanOptions().validation);
  static VkResult result;
  static uint64_t patience;
  calls = {device.vk()};
  const auto text = [&](VkResult of) {
    vulkan::Commands commands(device);
    commands.begin(2);
    commands.start();
    commands.finished("project");
    commands.submit();
    result = of;
    functionsOf(device).vkWaitForFences = [](VkDevice handle, uint32_t count, const VkFence* fences, VkBool32 all,
                                             uint64_t timeout) {
      patience = timeout;
      const VkResult real = calls.real.vkWaitForFences(handle, count, fences, all, UINT64_MAX);
      return result == VK_SUCCESS ? real : result;
    };
    const std::string message = problemOf([&] { commands.wait(); }, ErrorCode::device);
    // The next recording waits for commands that may still run.
    if (of != VK_SUCCESS && of != VK_ERROR_DEVICE_LOST)
      CHECK(problemOf([&] { commands.begin(2); }, ErrorCode::device) == message);
    result = VK_SUCCESS;
    CHECK_NOTHROW(commands.begin(2));
    return message;
  };
  CHECK(text(VK_SUCCESS) == "nothing was wrong");
  CHECK(patience < UINT64_MAX);
  const std::string stages = device.capabilities().timestampBits > 0 ? "stages: project; the last one" : "";
  for (const auto& [of, why] :
       {std::pair(VK_ERROR_DEVICE_LOST, "was lost at its work"), std::pair(VK_TIMEOUT, "did not end its work in time")})
    CHECK_THAT(text(of), ContainsSubstring(why) && ContainsSubstring(stages) && ContainsSubstring("a new one may be") &&
                             ContainsSubstring("less work at a time may help (tuning.max_submission_work, "));
  CHECK_THAT(text(VK_ERROR_OUT_OF_HOST_MEMORY),
             ContainsSubstring("cannot be waited for, VK_ERROR_OUT_OF_HOST_MEMORY") && ContainsSubstring(stages));
  CHECK_NOTHROW(device.throwOnMessages());
}

TEST_CASE("each submission may take as long as any, and work that hangs is told after this time") {
  needVulkan();
  static vulkan::Device& device = *new vulkan::Device({}, vulkanOptions().validation);  // never destroyed: it "hangs"
  static std::vector<uint64_t> waits;
  static size_t hangingFrom;  // the number of waits that succeed
  waits.clear();
  hangingFrom = SIZE_MAX;
  countCalls(functionsOf(device));
  functionsOf(device).vkWaitForFences = [](VkDevice handle, uint32_t count, const VkFence* fences, VkBool32 all,
                                           uint64_t timeout) {
    waits.push_back(timeout);
    const VkResult real = calls.real.vkWaitForFences(handle, count, fences, all, UINT64_MAX);
    return waits.size() <= hangingFrom ? real : VK_TIMEOUT;
  };
  const auto submit = [](vulkan::Commands& commands, int submissions) {
    commands.begin(0);
    for (int i = 1; i < submissions; ++i) commands.cut();
    commands.submit();
  };
  const uint64_t longest = (device.capabilities().cpu ? 3600 : 60) * uint64_t{1'000'000'000};
  {
    vulkan::Commands first(device), second(device);
    submit(first, 2);
    submit(second, 2);
    second.wait();
    first.wait();
    // The third submission waits for those before it, which nobody has waited for; then all are known to have ended.
    CHECK(waits == std::vector<uint64_t>{3 * longest, longest, longest, longest});
  }
  CHECK(calls.alive == 0);
  waits.clear();
  hangingFrom = 2;
  {
    vulkan::Commands commands(device);
    submit(commands, 34);
    CHECK_THROWS_WITH(commands.wait(), ContainsSubstring("did not end its work in time"));
    CHECK(waits == std::vector<uint64_t>(3, longest));
    CHECK(device.hangs() == 1);
    hangingFrom = SIZE_MAX;  // it ends after all
  }
  CHECK(waits == [&] {
    std::vector<uint64_t> all(3 + 34);
    std::fill_n(all.begin(), 3, longest);
    return all;
  }());
  CHECK(calls.alive == 0);
  CHECK(device.hangs() == 0);
  waits.clear();
  hangingFrom = 0;
  int alive = 0;
  {
    const vulkan::Buffer buffer(device, "numbers", 12, MemoryKind::device);
    vulkan::Commands commands(device);
    submit(commands, 3);
    CHECK_THROWS_WITH(commands.wait(), ContainsSubstring("did not end its work in time"));
    alive = calls.alive;
  }
  CHECK(waits == std::vector<uint64_t>{longest, 0});
  CHECK(calls.alive == alive);
  CHECK(alive >= 7);  // the buffer, its memory, the pools of commands and of timestamps, and the fences
}

TEST_CASE("a recording with cuts is several submissions, each with a fence") {
  needVulkan();
  vulkan::Device device({}, vulkanOptions().validation);
  static std::vector<bool> fences;
  static size_t failing;
  calls = {device.vk()};
  functionsOf(device).vkQueueSubmit = [](VkQueue queue, uint32_t count, const VkSubmitInfo* infos, VkFence fence) {
    if (fences.size() == failing) return VK_ERROR_DEVICE_LOST;
    fences.push_back(fence != VK_NULL_HANDLE);
    return calls.real.vkQueueSubmit(queue, count, infos, fence);
  };
  const auto submit = [&](size_t lostAt) {
    fences.clear();
    failing = lostAt;
    vulkan::Commands commands(device);
    for (const int cuts : {2, 0, 3}) {
      commands.begin(4);
      for (int i = 0; i < cuts; ++i) commands.cut();
      commands.submit();
      commands.wait();
    }
  };
  submit(100);
  CHECK(fences == std::vector<bool>(8, true));
  CHECK_THROWS_WITH(submit(1), ContainsSubstring("was lost at its work"));
  CHECK_NOTHROW(device.throwOnMessages());
  // Other simulators do not notice.
  CHECK(scanOf(sceneOf(ball(9, 14, 5)), gridSensor(40, 5, -10, 10), {}, vulkanOptions()).counters.hits == 200);
}

TEST_CASE("a recording that was given up is dropped by the next one") {
  needVulkan();
  vulkan::Device device({}, vulkanOptions().validation);
  vulkan::Commands commands(device);
  commands.begin(2);
  commands.begin(40);  // more timestamps than there was room for
  commands.start();
  for (int i = 0; i < 39; ++i) commands.finished("project");
  commands.submit();
  commands.wait();
  Timings timings;
  commands.readTimings(timings);
  CHECK(timings.stages.size() == (device.capabilities().timestampBits > 0 ? 1 : 0));
  CHECK_NOTHROW(device.throwOnMessages());
}

TEST_CASE("a dispatch of more workgroups than the device allows is divided") {
  needVulkan();
  vulkan::Device device({}, false);
  const_cast<vulkan::Capabilities&>(device.capabilities()).mostGroups = 100;
  static std::vector<std::array<uint32_t, 3>> dispatches;  // first workgroup, and numbers of workgroups
  static uint32_t firstGroup;
  dispatches.clear();
  functionsOf(device).vkCmdDispatch = [](VkCommandBuffer, uint32_t workgroupsX, uint32_t workgroupsY, uint32_t) {
    dispatches.push_back({firstGroup, workgroupsX, workgroupsY});
  };
  functionsOf(device).vkCmdBindPipeline = [](VkCommandBuffer, VkPipelineBindPoint, VkPipeline) {};
  functionsOf(device).vkCmdPushConstants = [](VkCommandBuffer, VkPipelineLayout, VkShaderStageFlags, uint32_t, uint32_t,
                                              const void* constants) {
    firstGroup = static_cast<const vulkan::PushConstants*>(constants)->pass.firstGroup;
  };
  vulkan::CommandBuffer commands(device, VK_NULL_HANDLE);
  using Dispatches = std::vector<std::array<uint32_t, 3>>;
  vulkan::PushConstants constants = {};
  constants.pass.groups = 1000;
  commands.dispatch({}, VK_NULL_HANDLE, constants, 100, 7);
  CHECK(std::exchange(dispatches, {}) == Dispatches{{0, 100, 7}});
  constants.pass.firstGroup = 500;  // as of a part of a step
  commands.dispatch({}, VK_NULL_HANDLE, constants, 250, 1);
  CHECK(dispatches == Dispatches{{500, 100, 1}, {600, 100, 1}, {700, 50, 1}});
}

TEST_CASE("the queue is one for compute alone where there is one") {
  const auto family = [](std::vector<VkQueueFlags> flags) {
    std::vector<VkQueueFamilyProperties> families;
    for (const VkQueueFlags each : flags) families.push_back({each, 1, 64, {1, 1, 1}});
    return vulkan::queueFamilyOf(families);
  };
  constexpr VkQueueFlags kGraphics = VK_QUEUE_GRAPHICS_BIT, kCompute = VK_QUEUE_COMPUTE_BIT;
  CHECK(family({kGraphics | kCompute, kCompute}) == 1);
  CHECK(family({kGraphics | kCompute}) == 0);
  CHECK(family({kGraphics, VK_QUEUE_TRANSFER_BIT, kGraphics | kCompute}) == 2);
  CHECK(family({kGraphics, VK_QUEUE_TRANSFER_BIT}) == -1);
}

TEST_CASE("the validation layer's last message goes to the caller, not to stderr") {
  needVulkan();
  if (!vulkanOptions().validation) SKIP("the validation layer is off");
  auto device = std::make_unique<vulkan::Device>(DeviceChoice(), true);
  const auto messages = device->messages();
  const VkFenceCreateInfo info = {VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
  VkFence lost;
  REQUIRE(device->vk().vkCreateFence(device->handle(), &info, nullptr, &lost) == VK_SUCCESS);
  std::FILE* printed = std::tmpfile();
  const int standardError = dup(2);
  dup2(fileno(printed), 2);
  device.reset();
  dup2(standardError, 2);
  close(standardError);
  std::fseek(printed, 0, SEEK_END);
  CHECK(std::ftell(printed) == 0);
  std::fclose(printed);
  CHECK_THROWS_WITH(messages->throwIfAny(), ContainsSubstring("VkFence"));
  CHECK_NOTHROW(messages->throwIfAny());
}

TEST_CASE("memory that cannot be mapped is reported as out of memory") {
  needVulkan();
  vulkan::Device device({}, vulkanOptions().validation);
  const auto fails = [&](PFN_vkMapMemory map) {
    functionsOf(device).vkMapMemory = map;
    return problemOf([&] { vulkan::Buffer(device, "numbers", 3 << 20, MemoryKind::upload); }, ErrorCode::outOfMemory);
  };
  const auto expected = ContainsSubstring("cannot allocate 3.0 MiB for 'numbers'; the device '");
  CHECK_THAT(fails([](VkDevice, VkDeviceMemory, VkDeviceSize, VkDeviceSize, VkMemoryMapFlags, void** to) {
               *to = reinterpret_cast<void*>(-1);
               return VK_SUCCESS;
             }),
             expected);
  CHECK_THAT(fails([](VkDevice, VkDeviceMemory, VkDeviceSize, VkDeviceSize, VkMemoryMapFlags, void** to) {
               *to = nullptr;
               return VK_SUCCESS;
             }),
             expected);
  CHECK_THAT(fails([](VkDevice, VkDeviceMemory, VkDeviceSize, VkDeviceSize, VkMemoryMapFlags, void**) {
               return VK_ERROR_MEMORY_MAP_FAILED;
             }),
             expected);
}

TEST_CASE("pipelines require full subgroups if their kernels use them, without a message of the validation layer") {
  needVulkan();
  vulkan::Device device({}, vulkanOptions().validation);
  static std::vector<VkPipelineShaderStageCreateFlags> flags;
  flags.clear();
  calls = {device.vk()};
  functionsOf(device).vkCreateComputePipelines = [](VkDevice handle, VkPipelineCache cache, uint32_t count,
                                                    const VkComputePipelineCreateInfo* infos,
                                                    const VkAllocationCallbacks* with, VkPipeline* pipelines) {
    for (uint32_t i = 0; i < count; ++i) flags.push_back(infos[i].stage.flags);
    return calls.real.vkCreateComputePipelines(handle, cache, count, infos, with, pipelines);
  };
  makeEverything(device);
  REQUIRE(flags.size() == 2);
  CHECK(flags[0] == 0);  // prefix_sum has no subgroup operations
  CHECK(flags[1] == VK_PIPELINE_SHADER_STAGE_CREATE_REQUIRE_FULL_SUBGROUPS_BIT_EXT);
  CHECK_NOTHROW(device.throwOnMessages());
}

TEST_CASE("a module that cannot be specialised goes to the driver with its constants") {
  needVulkan();
  vulkan::Device device({}, vulkanOptions().validation);
  static std::vector<uint32_t> constants;
  calls = {device.vk()};
  functionsOf(device).vkCreateComputePipelines = [](VkDevice handle, VkPipelineCache cache, uint32_t count,
                                                    const VkComputePipelineCreateInfo* infos,
                                                    const VkAllocationCallbacks* with, VkPipeline* pipelines) {
    constants.clear();
    if (const VkSpecializationInfo* info = infos[0].stage.pSpecializationInfo) {
      constants.resize(info->mapEntryCount);
      for (uint32_t i = 0; i < info->mapEntryCount; ++i) {
        CHECK(info->pMapEntries[i].constantID == i);
        std::memcpy(&constants[i], static_cast<const char*>(info->pData) + info->pMapEntries[i].offset, 4);
      }
    }
    return calls.real.vkCreateComputePipelines(handle, cache, count, infos, with, pipelines);
  };
  Variant variant;
  variant.kernel = Kernel::resolve;
  variant.options.LAYERS = 3;
  const vulkan::PipelineCache cache(device, "off");
  vulkan::Kernels(device, cache).prepare({&variant, 1});
  CHECK(constants.empty());
  const auto refuses = [](std::span<const uint32_t> module, std::span<const uint32_t>, bool) {
    return vulkan::Code{{module.begin(), module.end()}, false};
  };
  vulkan::Kernels(device, cache, refuses).prepare({&variant, 1});
  CHECK(constants == vulkan::codeOf(device.capabilities(), variant).constants);
  CHECK(std::count(constants.begin(), constants.end(), 3) > 0);
  CHECK_NOTHROW(device.throwOnMessages());
}

TEST_CASE("kernels ask for lanes that meet again and for -0 and NaN, where the device offers both") {
  needVulkan();
  vulkan::Device device({}, false);
  auto& capabilities = const_cast<vulkan::Capabilities&>(device.capabilities());
  static std::vector<uint32_t> modes;
  calls = {device.vk()};
  functionsOf(device).vkCreateShaderModule = [](VkDevice handle, const VkShaderModuleCreateInfo* info,
                                                const VkAllocationCallbacks* with, VkShaderModule* module) {
    constexpr uint32_t kOpExecutionMode = 16;
    for (size_t at = 5; at < info->codeSize / 4; at += info->pCode[at] >> 16)
      if ((info->pCode[at] & 0xffff) == kOpExecutionMode) modes.push_back(info->pCode[at + 2]);
    return calls.real.vkCreateShaderModule(handle, info, with, module);
  };
  functionsOf(device).vkCreateComputePipelines = [](VkDevice, VkPipelineCache, uint32_t,
                                                    const VkComputePipelineCreateInfo*, const VkAllocationCallbacks*,
                                                    VkPipeline*) { return VK_SUCCESS; };
  constexpr uint32_t kLocalSize = 17, kUniformControlFlow = 4421, kSpecialFloats = 4461;
  const auto modesOf = [&](Kernel kernel) {
    modes.clear();
    Variant variant;
    variant.kernel = kernel;
    const vulkan::PipelineCache cache(device, "off");
    vulkan::Kernels(device, cache).prepare({&variant, 1});
    std::sort(modes.begin(), modes.end());
    return modes;
  };
  for (const bool offered : {false, true}) {
    capabilities.uniformControlFlow = capabilities.keepsSpecialFloats = offered;
    for (const Kernel kernel : {Kernel::project_groups, Kernel::project_triangles, Kernel::bin, Kernel::prefix_sum}) {
      std::vector<uint32_t> expected = {kLocalSize};
      // The kernel prefix_sum has no subgroup operations.
      if (offered && kernel != Kernel::prefix_sum) expected.push_back(kUniformControlFlow);
      if (offered) expected.push_back(kSpecialFloats);
      CHECK(modesOf(kernel) == expected);
    }
  }
}

TEST_CASE("kernels of many registers get fewer lanes, where the device is better with them") {
  needVulkan();
  vulkan::Device device({}, false);
  const_cast<vulkan::Capabilities&>(device.capabilities()).subgroups = {16, true, 8};
  static uint32_t lanes;
  functionsOf(device).vkCreateComputePipelines = [](VkDevice, VkPipelineCache, uint32_t,
                                                    const VkComputePipelineCreateInfo* info,
                                                    const VkAllocationCallbacks*, VkPipeline*) {
    const auto* size = static_cast<const VkPipelineShaderStageRequiredSubgroupSizeCreateInfo*>(info->stage.pNext);
    lanes = size ? size->requiredSubgroupSize : 0;
    return VK_SUCCESS;
  };
  const vulkan::PipelineCache cache(device, "off");
  vulkan::Kernels kernels(device, cache);
  const auto lanesOf = [&](Kernel kernel, const Options& options = {}) {
    const Variant variant = {kernel, options, false};
    kernels.prepare({&variant, 1});
    Plan::Pipeline told;
    kernels.describe(variant, told);
    CHECK((lanes == 0 || told.subgroupSize == lanes));
    return lanes;
  };
  Options moving, exact, footprint;
  moving.MOTION = 1, exact.RANGE = gpu::kRangeExact, footprint.RAYS = 7;
  CHECK(lanesOf(Kernel::project_groups) == 16);
  CHECK(lanesOf(Kernel::project_clusters) == 16);
  CHECK(lanesOf(Kernel::project_triangles) == 8);
  CHECK(lanesOf(Kernel::bin) == 16);
  for (const Options& options : {moving, exact, footprint}) CHECK(lanesOf(Kernel::bin, options) == 8);
  CHECK(lanesOf(Kernel::effects_footprint, footprint) == 8);
  CHECK(lanesOf(Kernel::prefix_sum) == 0);
}

TEST_CASE("timestamps of fewer than 64 bits give the same times, also after a wrap-around") {
  vulkan::Capabilities capabilities;
  capabilities.timestampMs = 0.5;
  CHECK(capabilities.elapsedMs(10, 30) == 0);
  for (uint32_t bits : {1u, 8u, 32u, 36u, 63u, 64u}) {
    INFO(bits << " bits");
    capabilities.timestampBits = bits;
    const uint64_t most = ~uint64_t{0} >> (64 - bits), noise = ~most & 0xabcdef0123456789u;
    CHECK(capabilities.elapsedMs(0, 1) == 0.5);
    CHECK(capabilities.elapsedMs(most, 0) == 0.5);
    CHECK(capabilities.elapsedMs(most | noise, 0) == 0.5);
    if (bits >= 8) CHECK(capabilities.elapsedMs((most - 99) | noise, 100) == 100);
    CHECK(capabilities.elapsedMs(0, most | noise) == 0.5 * static_cast<double>(most));
  }
}

}  // namespace gnosphere::test

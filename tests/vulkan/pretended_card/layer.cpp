// SPDX-License-Identifier: Apache-2.0
// A Vulkan layer that makes a CPU's driver look like a discrete graphics card, so that tests take the paths of cards:
// memory that the host does not see, memory that the host sees only after a flush or an invalidation, fresh memory that
// is not zero, and no waiting of a whole workgroup at the barriers of its subgroups, as lavapipe does. Lavapipe ends
// each command before the next; cards need a barrier, without which the layer ends the program.
#include <vulkan/vk_layer.h>
#include <vulkan/vulkan.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <mutex>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

#include "hazards.hpp"
#include "vulkan/spirv.hpp"

namespace {

using namespace gnosphere::vulkan;
using gnosphere::test::Hazards;

enum MemoryType : uint32_t { kLocal, kCached, kCoherent, kTypes };
constexpr VkDeviceSize kAtom = 256;
constexpr int kFreshOnDevice = 0xa5, kFreshOnHost = 0x5b;

struct Memory {
  MemoryType type;
  VkDeviceSize size;
  unsigned char* bytes = nullptr;        // kCached: of the device
  std::vector<unsigned char> copy = {};  // kCached: what the host sees
};

// The functions of the next layer, found before the loader begins with this layer for every name.
struct Instance {
  PFN_vkGetInstanceProcAddr find;
  std::map<std::string_view, PFN_vkVoidFunction> next;
};

struct Device {
  VkDevice handle;
  PFN_vkGetDeviceProcAddr find;
};

struct State {
  std::mutex mutex;
  std::map<void*, Instance> instances;
  std::map<void*, Device> devices;
  std::map<VkDeviceMemory, Memory> memories;
  std::map<VkCommandBuffer, Hazards> commands;
};

// The state is never destroyed, because programs may destroy their devices when they end.
State& state() {
  static State& only = *new State;
  return only;
}

// Returns the loader's table of functions, which an instance and its physical devices share.
template <typename Handle>
void* keyOf(Handle handle) {
  return *reinterpret_cast<void**>(handle);
}

[[noreturn]] void fail(const char* why) {
  std::fprintf(stderr, "pretended card: %s\n", why);
  std::abort();
}

template <typename Function>
Function of(VkPhysicalDevice device, const char* name) {
  const std::lock_guard lock(state().mutex);
  return reinterpret_cast<Function>(state().instances.at(keyOf(device)).next.at(name));
}

template <typename Function>
Function of(VkDevice device, const char* name) {
  const std::lock_guard lock(state().mutex);
  return reinterpret_cast<Function>(state().devices.at(keyOf(device)).find(device, name));
}

// Command buffers have the table of functions of their device.
template <typename Function>
Function of(VkCommandBuffer commands, const char* name) {
  const std::lock_guard lock(state().mutex);
  const Device& device = state().devices.at(keyOf(commands));
  return reinterpret_cast<Function>(device.find(device.handle, name));
}

// Takes this layer off the chain of the next ones, and returns its entry.
template <typename Link>
auto* nextLayer(const void* chain, VkStructureType type) {
  auto* link = static_cast<Link*>(const_cast<void*>(chain));
  while (link && !(link->sType == type && link->function == VK_LAYER_LINK_INFO))
    link = static_cast<Link*>(const_cast<void*>(link->pNext));
  if (!link) fail("the loader has given no next layer");
  auto* next = link->u.pLayerInfo;
  link->u.pLayerInfo = next->pNext;
  return next;
}

VKAPI_ATTR VkResult VKAPI_CALL createInstance(const VkInstanceCreateInfo* info, const VkAllocationCallbacks* callbacks,
                                              VkInstance* to) {
  const auto find = nextLayer<VkLayerInstanceCreateInfo>(info->pNext, VK_STRUCTURE_TYPE_LOADER_INSTANCE_CREATE_INFO)
                        ->pfnNextGetInstanceProcAddr;
  const auto create = reinterpret_cast<PFN_vkCreateInstance>(find(nullptr, "vkCreateInstance"));
  const VkResult result = create(info, callbacks, to);
  if (result != VK_SUCCESS) return result;
  Instance instance = {find, {}};
  for (const char* name : {"vkCreateDevice", "vkGetPhysicalDeviceProperties", "vkGetPhysicalDeviceProperties2",
                           "vkGetPhysicalDeviceMemoryProperties", "vkGetPhysicalDeviceMemoryProperties2"})
    instance.next[name] = find(*to, name);
  const std::lock_guard lock(state().mutex);
  state().instances[keyOf(*to)] = std::move(instance);
  return result;
}

VKAPI_ATTR VkResult VKAPI_CALL createDevice(VkPhysicalDevice physical, const VkDeviceCreateInfo* info,
                                            const VkAllocationCallbacks* callbacks, VkDevice* to) {
  const auto* next = nextLayer<VkLayerDeviceCreateInfo>(info->pNext, VK_STRUCTURE_TYPE_LOADER_DEVICE_CREATE_INFO);
  const auto find = next->pfnNextGetDeviceProcAddr;
  const VkResult result = of<PFN_vkCreateDevice>(physical, "vkCreateDevice")(physical, info, callbacks, to);
  if (result != VK_SUCCESS) return result;
  const std::lock_guard lock(state().mutex);
  state().devices[keyOf(*to)] = {*to, find};
  return result;
}

void pretend(VkPhysicalDeviceProperties& properties) {
  properties.deviceType = VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU;
  properties.limits.nonCoherentAtomSize = kAtom;
}

void pretend(VkPhysicalDeviceMemoryProperties& memory) {
  const VkDeviceSize size = memory.memoryHeaps[0].size;
  memory = {};
  memory.memoryHeapCount = 2;
  memory.memoryHeaps[0] = {size, VK_MEMORY_HEAP_DEVICE_LOCAL_BIT};
  memory.memoryHeaps[1] = {size, 0};
  memory.memoryTypeCount = kTypes;
  memory.memoryTypes[kLocal] = {VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, 0};
  memory.memoryTypes[kCached] = {VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_CACHED_BIT, 1};
  memory.memoryTypes[kCoherent] = {VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT, 1};
}

VKAPI_ATTR void VKAPI_CALL properties(VkPhysicalDevice device, VkPhysicalDeviceProperties* to) {
  of<PFN_vkGetPhysicalDeviceProperties>(device, "vkGetPhysicalDeviceProperties")(device, to);
  pretend(*to);
}

VKAPI_ATTR void VKAPI_CALL properties2(VkPhysicalDevice device, VkPhysicalDeviceProperties2* to) {
  of<PFN_vkGetPhysicalDeviceProperties2>(device, "vkGetPhysicalDeviceProperties2")(device, to);
  pretend(to->properties);
}

VKAPI_ATTR void VKAPI_CALL memoryProperties(VkPhysicalDevice device, VkPhysicalDeviceMemoryProperties* to) {
  of<PFN_vkGetPhysicalDeviceMemoryProperties>(device, "vkGetPhysicalDeviceMemoryProperties")(device, to);
  pretend(*to);
}

VKAPI_ATTR void VKAPI_CALL memoryProperties2(VkPhysicalDevice device, VkPhysicalDeviceMemoryProperties2* to) {
  of<PFN_vkGetPhysicalDeviceMemoryProperties2>(device, "vkGetPhysicalDeviceMemoryProperties2")(device, to);
  pretend(to->memoryProperties);
  for (auto* more = static_cast<VkBaseOutStructure*>(to->pNext); more; more = more->pNext) {
    if (more->sType != VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MEMORY_BUDGET_PROPERTIES_EXT) continue;
    auto& budget = *reinterpret_cast<VkPhysicalDeviceMemoryBudgetPropertiesEXT*>(more);
    budget.heapBudget[1] = budget.heapBudget[0];
    budget.heapUsage[1] = budget.heapUsage[0];
  }
}

VKAPI_ATTR void VKAPI_CALL bufferRequirements(VkDevice device, VkBuffer buffer, VkMemoryRequirements* to) {
  of<PFN_vkGetBufferMemoryRequirements>(device, "vkGetBufferMemoryRequirements")(device, buffer, to);
  to->memoryTypeBits = (1u << kTypes) - 1;
}

bool isImported(const VkMemoryAllocateInfo& info) {
  for (auto* more = static_cast<const VkBaseInStructure*>(info.pNext); more; more = more->pNext)
    if (more->sType == VK_STRUCTURE_TYPE_IMPORT_MEMORY_FD_INFO_KHR) return true;
  return false;
}

VKAPI_ATTR VkResult VKAPI_CALL allocate(VkDevice device, const VkMemoryAllocateInfo* info,
                                        const VkAllocationCallbacks* callbacks, VkDeviceMemory* to) {
  VkMemoryAllocateInfo real = *info;
  real.memoryTypeIndex = 0;
  VkResult result = of<PFN_vkAllocateMemory>(device, "vkAllocateMemory")(device, &real, callbacks, to);
  if (result != VK_SUCCESS) return result;
  Memory memory = {static_cast<MemoryType>(info->memoryTypeIndex), info->allocationSize};
  void* bytes = nullptr;
  result = of<PFN_vkMapMemory>(device, "vkMapMemory")(device, *to, 0, VK_WHOLE_SIZE, 0, &bytes);
  if (result != VK_SUCCESS) {
    of<PFN_vkFreeMemory>(device, "vkFreeMemory")(device, *to, callbacks);
    return result;
  }
  if (!isImported(*info)) std::memset(bytes, kFreshOnDevice, memory.size);
  if (memory.type == kCached) {
    memory.bytes = static_cast<unsigned char*>(bytes);
    memory.copy.assign(memory.size, kFreshOnHost);
  } else {
    of<PFN_vkUnmapMemory>(device, "vkUnmapMemory")(device, *to);
  }
  const std::lock_guard lock(state().mutex);
  state().memories[*to] = std::move(memory);
  return result;
}

VKAPI_ATTR void VKAPI_CALL freeMemory(VkDevice device, VkDeviceMemory memory, const VkAllocationCallbacks* callbacks) {
  {
    const std::lock_guard lock(state().mutex);
    state().memories.erase(memory);
  }
  of<PFN_vkFreeMemory>(device, "vkFreeMemory")(device, memory, callbacks);
}

VKAPI_ATTR VkResult VKAPI_CALL map(VkDevice device, VkDeviceMemory handle, VkDeviceSize offset, VkDeviceSize size,
                                   VkMemoryMapFlags flags, void** to) {
  {
    const std::lock_guard lock(state().mutex);
    Memory& memory = state().memories.at(handle);
    if (memory.type == kLocal) fail("memory is mapped that the host does not see");
    if (memory.type == kCached) {
      *to = memory.copy.data() + offset;
      return VK_SUCCESS;
    }
  }
  return of<PFN_vkMapMemory>(device, "vkMapMemory")(device, handle, offset, size, flags, to);
}

VKAPI_ATTR void VKAPI_CALL unmap(VkDevice device, VkDeviceMemory handle) {
  {
    const std::lock_guard lock(state().mutex);
    if (state().memories.at(handle).type == kCached) return;
  }
  of<PFN_vkUnmapMemory>(device, "vkUnmapMemory")(device, handle);
}

VkResult carry(uint32_t count, const VkMappedMemoryRange* ranges, bool toDevice) {
  const std::lock_guard lock(state().mutex);
  for (uint32_t i = 0; i < count; ++i) {
    Memory& memory = state().memories.at(ranges[i].memory);
    const VkDeviceSize begin = ranges[i].offset;
    const VkDeviceSize end = ranges[i].size == VK_WHOLE_SIZE ? memory.size : begin + ranges[i].size;
    if (begin % kAtom != 0 || (end % kAtom != 0 && end != memory.size) || end > memory.size)
      fail("a range of memory is flushed or invalidated that is not of whole atoms");
    if (memory.type != kCached) continue;
    unsigned char *device = memory.bytes + begin, *host = memory.copy.data() + begin;
    std::memcpy(toDevice ? device : host, toDevice ? host : device, end - begin);
  }
  return VK_SUCCESS;
}

VKAPI_ATTR VkResult VKAPI_CALL flush(VkDevice, uint32_t count, const VkMappedMemoryRange* ranges) {
  return carry(count, ranges, true);
}

VKAPI_ATTR VkResult VKAPI_CALL invalidate(VkDevice, uint32_t count, const VkMappedMemoryRange* ranges) {
  return carry(count, ranges, false);
}

// Leaves out the barriers of subgroups.
VKAPI_ATTR VkResult VKAPI_CALL createModule(VkDevice device, const VkShaderModuleCreateInfo* info,
                                            const VkAllocationCallbacks* callbacks, VkShaderModule* to) {
  const std::span module(info->pCode, info->codeSize / sizeof(uint32_t));
  Words words(module.begin(), module.begin() + kHeaderWords);
  std::set<uint32_t> subgroups;  // the constants that are this scope
  for (const Instruction instruction : instructionsOf(module.subspan(kHeaderWords))) {
    const spv::Op op = opOf(instruction);
    if (op == spv::OpConstant && instruction.size() == 4 && instruction[3] == uint32_t{spv::ScopeSubgroup})
      subgroups.insert(instruction[2]);
    if (op != spv::OpControlBarrier || !subgroups.contains(instruction[1])) append(words, instruction);
  }
  VkShaderModuleCreateInfo changed = *info;
  changed.codeSize = words.size() * sizeof(uint32_t);
  changed.pCode = words.data();
  return of<PFN_vkCreateShaderModule>(device, "vkCreateShaderModule")(device, &changed, callbacks, to);
}

// Ends the program if what a command did to the hazards of its command buffer was wrong.
template <typename Change>
void change(VkCommandBuffer commands, Change change) {
  const std::lock_guard lock(state().mutex);
  if (const char* wrong = change(state().commands[commands])) fail(wrong);
}

VKAPI_ATTR VkResult VKAPI_CALL begin(VkCommandBuffer commands, const VkCommandBufferBeginInfo* info) {
  change(commands, [](Hazards& hazards) {
    hazards = {};
    return nullptr;
  });
  return of<PFN_vkBeginCommandBuffer>(commands, "vkBeginCommandBuffer")(commands, info);
}

VKAPI_ATTR VkResult VKAPI_CALL end(VkCommandBuffer commands) {
  change(commands, [](Hazards& hazards) { return hazards.end(); });
  return of<PFN_vkEndCommandBuffer>(commands, "vkEndCommandBuffer")(commands);
}

VKAPI_ATTR void VKAPI_CALL dispatch(VkCommandBuffer commands, uint32_t x, uint32_t y, uint32_t z) {
  change(commands, [](Hazards& hazards) { return hazards.dispatch(); });
  of<PFN_vkCmdDispatch>(commands, "vkCmdDispatch")(commands, x, y, z);
}

VKAPI_ATTR void VKAPI_CALL dispatchIndirect(VkCommandBuffer commands, VkBuffer buffer, VkDeviceSize offset) {
  change(commands, [](Hazards& hazards) { return hazards.dispatchIndirect(); });
  of<PFN_vkCmdDispatchIndirect>(commands, "vkCmdDispatchIndirect")(commands, buffer, offset);
}

VKAPI_ATTR void VKAPI_CALL fill(VkCommandBuffer commands, VkBuffer buffer, VkDeviceSize offset, VkDeviceSize size,
                                uint32_t data) {
  change(commands, [](Hazards& hazards) { return hazards.transfer(); });
  of<PFN_vkCmdFillBuffer>(commands, "vkCmdFillBuffer")(commands, buffer, offset, size, data);
}

VKAPI_ATTR void VKAPI_CALL copy(VkCommandBuffer commands, VkBuffer from, VkBuffer to, uint32_t count,
                                const VkBufferCopy* regions) {
  change(commands, [](Hazards& hazards) { return hazards.transfer(); });
  of<PFN_vkCmdCopyBuffer>(commands, "vkCmdCopyBuffer")(commands, from, to, count, regions);
}

VKAPI_ATTR void VKAPI_CALL barrier(VkCommandBuffer commands, VkPipelineStageFlags from, VkPipelineStageFlags to,
                                   VkDependencyFlags flags, uint32_t memories, const VkMemoryBarrier* memory,
                                   uint32_t buffers, const VkBufferMemoryBarrier* buffer, uint32_t images,
                                   const VkImageMemoryBarrier* image) {
  change(commands, [&](Hazards& hazards) {
    for (uint32_t i = 0; i < memories; ++i) hazards.barrier(from, to, memory[i]);
    return nullptr;
  });
  of<PFN_vkCmdPipelineBarrier>(commands, "vkCmdPipelineBarrier")(commands, from, to, flags, memories, memory, buffers,
                                                                 buffer, images, image);
}

template <typename Function>
PFN_vkVoidFunction plain(Function function) {
  return reinterpret_cast<PFN_vkVoidFunction>(function);
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL findInDevice(VkDevice device, const char* name) {
  static const std::map<std::string_view, PFN_vkVoidFunction> own = {
      {"vkGetDeviceProcAddr", plain(&findInDevice)},
      {"vkGetBufferMemoryRequirements", plain(&bufferRequirements)},
      {"vkAllocateMemory", plain(&allocate)},
      {"vkFreeMemory", plain(&freeMemory)},
      {"vkMapMemory", plain(&map)},
      {"vkUnmapMemory", plain(&unmap)},
      {"vkFlushMappedMemoryRanges", plain(&flush)},
      {"vkInvalidateMappedMemoryRanges", plain(&invalidate)},
      {"vkCreateShaderModule", plain(&createModule)},
      {"vkBeginCommandBuffer", plain(&begin)},
      {"vkEndCommandBuffer", plain(&end)},
      {"vkCmdDispatch", plain(&dispatch)},
      {"vkCmdDispatchIndirect", plain(&dispatchIndirect)},
      {"vkCmdFillBuffer", plain(&fill)},
      {"vkCmdCopyBuffer", plain(&copy)},
      {"vkCmdPipelineBarrier", plain(&barrier)}};
  if (const auto found = own.find(name); found != own.end()) return found->second;
  return device ? of<PFN_vkVoidFunction>(device, name) : nullptr;
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL findInInstance(VkInstance instance, const char* name) {
  static const std::map<std::string_view, PFN_vkVoidFunction> own = {
      {"vkGetInstanceProcAddr", plain(&findInInstance)},
      {"vkCreateInstance", plain(&createInstance)},
      {"vkCreateDevice", plain(&createDevice)},
      {"vkGetPhysicalDeviceProperties", plain(&properties)},
      {"vkGetPhysicalDeviceProperties2", plain(&properties2)},
      {"vkGetPhysicalDeviceMemoryProperties", plain(&memoryProperties)},
      {"vkGetPhysicalDeviceMemoryProperties2", plain(&memoryProperties2)}};
  if (const auto found = own.find(name); found != own.end()) return found->second;
  if (const PFN_vkVoidFunction inDevice = findInDevice(nullptr, name)) return inDevice;
  if (!instance) return nullptr;
  const std::lock_guard lock(state().mutex);
  return state().instances.at(keyOf(instance)).find(instance, name);
}

}  // namespace

extern "C" __attribute__((visibility("default"))) VKAPI_ATTR VkResult VKAPI_CALL
vkNegotiateLoaderLayerInterfaceVersion(VkNegotiateLayerInterface* loader) {
  loader->loaderLayerInterfaceVersion = 2;
  loader->pfnGetInstanceProcAddr = &findInInstance;
  loader->pfnGetDeviceProcAddr = &findInDevice;
  loader->pfnGetPhysicalDeviceProcAddr = nullptr;
  return VK_SUCCESS;
}

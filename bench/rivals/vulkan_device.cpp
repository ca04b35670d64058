// SPDX-License-Identifier: Apache-2.0
#include "rivals/vulkan_device.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

namespace gnosphere::bench {
namespace {

constexpr uint64_t kStagingBytes = 16 << 20;
constexpr uint64_t kBlockBytes = 64 << 20;
constexpr uint64_t kSliceAlignment = 256;

int findMemory(const RayDevice& device, uint32_t bits, VkMemoryPropertyFlags wanted) {
  const VkPhysicalDeviceMemoryProperties& memory = device.memory();
  for (uint32_t i = 0; i < memory.memoryTypeCount; ++i)
    if ((bits >> i & 1) && (memory.memoryTypes[i].propertyFlags & wanted) == wanted) return static_cast<int>(i);
  return -1;
}

uint32_t chooseMemory(const RayDevice& device, uint32_t bits, MemoryKind memory) {
  constexpr VkMemoryPropertyFlags kLocal = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
  constexpr VkMemoryPropertyFlags kHost = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
  const VkMemoryPropertyFlags best = memory == MemoryKind::device   ? kLocal
                                     : memory == MemoryKind::upload ? kHost | kLocal
                                                                    : kHost | VK_MEMORY_PROPERTY_HOST_CACHED_BIT;
  const VkMemoryPropertyFlags enough = memory == MemoryKind::device ? 0 : kHost;
  const int type = findMemory(device, bits, best);
  return static_cast<uint32_t>(type >= 0 ? type : findMemory(device, bits, enough));
}

std::string inMebibytes(uint64_t bytes) {
  return std::to_string(bytes >> 20) + " MiB";
}

}  // namespace

RayBuffer::RayBuffer(const RayDevice& device, const char* name, uint64_t bytes, MemoryKind memory)
    : device_(device.handle()), bytes_(std::max<uint64_t>(bytes, 16)) {
  const auto refuse = [&] {
    throw Error(ErrorCode::outOfMemory, "cannot allocate " + inMebibytes(bytes_) + " for '" + name + "'; the device '" +
                                            device.capabilities().info.name + "' gives at most " +
                                            inMebibytes(device.maxAllocationBytes()));
  };
  if (bytes_ > device.maxAllocationBytes()) refuse();
  VkBufferCreateInfo create = {VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
  create.size = bytes_;
  create.usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT |
                 VK_BUFFER_USAGE_TRANSFER_DST_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT |
                 VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR |
                 VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR;
  if (device.hasPipeline()) create.usage |= VK_BUFFER_USAGE_SHADER_BINDING_TABLE_BIT_KHR;
  VK(vkCreateBuffer(device_, &create, nullptr, &buffer_));
  VkMemoryRequirements requirements;
  vkGetBufferMemoryRequirements(device_, buffer_, &requirements);
  VkMemoryAllocateFlagsInfo flags = {VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO};
  flags.flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT;
  VkMemoryAllocateInfo allocate = {VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, &flags};
  allocate.allocationSize = requirements.size;
  allocate.memoryTypeIndex = chooseMemory(device, requirements.memoryTypeBits, memory);
  if (vkAllocateMemory(device_, &allocate, nullptr, &memory_) != VK_SUCCESS) {
    vkDestroyBuffer(device_, buffer_, nullptr);
    refuse();
  }
  VK(vkBindBufferMemory(device_, buffer_, memory_, 0));
  constexpr VkMemoryPropertyFlags kHost = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
  if ((device.memory().memoryTypes[allocate.memoryTypeIndex].propertyFlags & kHost) == kHost)
    VK(vkMapMemory(device_, memory_, 0, VK_WHOLE_SIZE, 0, &mapped_));
  const VkBufferDeviceAddressInfo info = {VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO, nullptr, buffer_};
  address_ = vkGetBufferDeviceAddress(device_, &info);
}

RayBuffer::~RayBuffer() {
  if (buffer_) vkDestroyBuffer(device_, buffer_, nullptr);
  if (memory_) vkFreeMemory(device_, memory_, nullptr);
}

void RayBuffer::swap(RayBuffer& other) noexcept {
  std::swap(device_, other.device_);
  std::swap(buffer_, other.buffer_);
  std::swap(memory_, other.memory_);
  std::swap(address_, other.address_);
  std::swap(mapped_, other.mapped_);
  std::swap(bytes_, other.bytes_);
}

Slice Arena::take(uint64_t bytes) {
  const uint64_t padded = (bytes + kSliceAlignment - 1) / kSliceAlignment * kSliceAlignment;
  if (blocks_.empty() || used_ + padded > blocks_.back()->bytes()) {
    const uint64_t size = std::max(padded, std::min(kBlockBytes, device_.maxAllocationBytes()));
    blocks_.push_back(std::make_unique<RayBuffer>(device_, name_, size, MemoryKind::device));
    used_ = 0;
  }
  const Slice slice = {blocks_.back().get(), used_, bytes};
  used_ += padded;
  bytes_ += padded;
  return slice;
}

RayDevice::RayDevice(const VulkanOptions& options, const char* extension) : instance_(options.validation) {
  // The library keeps the functions of its instances and devices in tables of its own.
  VK(volkInitialize());
  volkLoadInstance(instance_.handle());
  physical_ = vulkan::chooseDevice(instance_, options.device);
  capabilities_ = vulkan::capabilitiesOf(instance_.functions(), physical_);
  vkGetPhysicalDeviceMemoryProperties(physical_, &memory_);
  VkPhysicalDeviceAccelerationStructurePropertiesKHR structures = {
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_PROPERTIES_KHR};
  VkPhysicalDeviceMaintenance3Properties maintenance = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_3_PROPERTIES,
                                                        &structures};
  VkPhysicalDeviceProperties2 properties = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &maintenance, {}};
  vkGetPhysicalDeviceProperties2(physical_, &properties);
  maxAllocationBytes_ = maintenance.maxMemoryAllocationSize;
  if (options.maxAllocationBytes > 0) maxAllocationBytes_ = std::min(maxAllocationBytes_, options.maxAllocationBytes);
  scratchAlignment_ = std::max<uint64_t>(structures.minAccelerationStructureScratchOffsetAlignment, 1);
  pipeline_ = std::strcmp(extension, VK_KHR_RAY_TRACING_PIPELINE_EXTENSION_NAME) == 0;
  createDevice(extension);
  createCommands();
}

void RayDevice::createDevice(const char* extension) {
  const char* extensions[] = {VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME,
                              VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME, extension};
  const auto refuse = [&](const std::string& what) {
    throw Error(ErrorCode::device, "the device '" + capabilities_.info.name + "' lacks " + what);
  };
  for (const char* name : extensions)
    if (!vulkan::offers(instance_.functions(), physical_, name)) refuse(name);
  VkPhysicalDeviceRayTracingPipelineFeaturesKHR pipeline = {
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_TRACING_PIPELINE_FEATURES_KHR};
  VkPhysicalDeviceRayQueryFeaturesKHR query = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_QUERY_FEATURES_KHR};
  VkPhysicalDeviceAccelerationStructureFeaturesKHR structures = {
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_FEATURES_KHR};
  structures.pNext = pipeline_ ? static_cast<void*>(&pipeline) : &query;
  VkPhysicalDeviceVulkan12Features features12 = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES, &structures};
  VkPhysicalDeviceFeatures2 features = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, &features12, {}};
  vkGetPhysicalDeviceFeatures2(physical_, &features);
  if (!structures.accelerationStructure || !features12.bufferDeviceAddress) refuse("acceleration structures");
  if (!(pipeline_ ? pipeline.rayTracingPipeline : query.rayQuery)) refuse(std::string("the feature of ") + extension);
  // Only the features that are used are enabled.
  pipeline = {pipeline.sType};
  pipeline.rayTracingPipeline = VK_TRUE;
  structures = {structures.sType, structures.pNext};
  structures.accelerationStructure = VK_TRUE;
  features12 = {features12.sType, features12.pNext};
  features12.bufferDeviceAddress = VK_TRUE;
  features.features = {};
  const float priority = 1;
  VkDeviceQueueCreateInfo queue = {VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO};
  queue.queueFamilyIndex = capabilities_.queueFamily;
  queue.queueCount = 1;
  queue.pQueuePriorities = &priority;
  VkDeviceCreateInfo create = {VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, &features};
  create.queueCreateInfoCount = 1;
  create.pQueueCreateInfos = &queue;
  create.enabledExtensionCount = std::size(extensions);
  create.ppEnabledExtensionNames = extensions;
  VK(vkCreateDevice(physical_, &create, nullptr, &device_));
  vkGetDeviceQueue(device_, capabilities_.queueFamily, 0, &queue_);
}

void RayDevice::createCommands() {
  VkCommandPoolCreateInfo pool = {VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
  pool.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
  pool.queueFamilyIndex = capabilities_.queueFamily;
  VK(vkCreateCommandPool(device_, &pool, nullptr, &pool_));
  VkCommandBufferAllocateInfo allocate = {VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
  allocate.commandPool = pool_;
  allocate.commandBufferCount = 1;
  VK(vkAllocateCommandBuffers(device_, &allocate, &commands_));
  VkQueryPoolCreateInfo queries = {VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO};
  queries.queryType = VK_QUERY_TYPE_TIMESTAMP;
  queries.queryCount = 2;
  VK(vkCreateQueryPool(device_, &queries, nullptr, &queries_));
}

RayDevice::~RayDevice() {
  staging_ = {};
  vkDestroyQueryPool(device_, queries_, nullptr);
  vkDestroyCommandPool(device_, pool_, nullptr);
  vkDestroyDevice(device_, nullptr);
}

double RayDevice::run(const Record& timed, const Record& rest) {
  const auto stamp = [&](uint32_t query) {
    if (capabilities_.timestampBits > 0)
      vkCmdWriteTimestamp(commands_, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, queries_, query);
  };
  VkCommandBufferBeginInfo begin = {VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
  begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  VK(vkBeginCommandBuffer(commands_, &begin));
  vkCmdResetQueryPool(commands_, queries_, 0, 2);
  stamp(0);
  timed(commands_);
  stamp(1);
  barrier(commands_);
  if (rest) {
    rest(commands_);
    barrier(commands_);
  }
  VK(vkEndCommandBuffer(commands_));
  VkSubmitInfo submit = {VK_STRUCTURE_TYPE_SUBMIT_INFO};
  submit.commandBufferCount = 1;
  submit.pCommandBuffers = &commands_;
  VK(vkQueueSubmit(queue_, 1, &submit, VK_NULL_HANDLE));
  VK(vkQueueWaitIdle(queue_));
  if (capabilities_.timestampBits == 0) return 0;
  uint64_t ticks[2];
  VK(vkGetQueryPoolResults(device_, queries_, 0, 2, sizeof ticks, ticks, sizeof ticks[0],
                           VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT));
  return capabilities_.elapsedMs(ticks[0], ticks[1]);
}

void RayDevice::write(const Slice& to, const void* data, uint64_t bytes) {
  if (bytes == 0) return;
  const char* from = static_cast<const char*>(data);
  if (to.buffer->mapped()) {
    std::memcpy(static_cast<char*>(to.buffer->mapped()) + to.offset, from, bytes);
    return;
  }
  if (!staging_.handle()) staging_ = RayBuffer(*this, "staging", kStagingBytes, MemoryKind::upload);
  for (uint64_t done = 0; done < bytes; done += kStagingBytes) {
    const VkBufferCopy copy = {0, to.offset + done, std::min(bytes - done, kStagingBytes)};
    std::memcpy(staging_.mapped(), from + done, copy.size);
    run([&](VkCommandBuffer commands) { vkCmdCopyBuffer(commands, staging_.handle(), to.buffer->handle(), 1, &copy); });
  }
}

void barrier(VkCommandBuffer commands) {
  VkMemoryBarrier memory = {VK_STRUCTURE_TYPE_MEMORY_BARRIER};
  memory.srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT;
  memory.dstAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT;
  vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
                       VK_PIPELINE_STAGE_ALL_COMMANDS_BIT | VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &memory, 0, nullptr, 0,
                       nullptr);
}

}  // namespace gnosphere::bench

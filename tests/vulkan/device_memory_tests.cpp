// SPDX-License-Identifier: Apache-2.0
// Memory of a device: blocks that buffers share, heaps that are full, and types as graphics cards have them.
#include <algorithm>
#include <catch2/generators/catch_generators.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <deque>

#include "problem.hpp"
#include "support.hpp"
#include "vulkan/device_functions.hpp"
#include "vulkan/result_ring.hpp"
#include "vulkan/transfer.hpp"

namespace gnosphere::test {
namespace {

using Catch::Matchers::ContainsSubstring;

/// The memory that a device may still allocate in a test.
struct Heaps {
  vulkan::DeviceFunctions real;
  int allocations = 0;
  VkDeviceSize left = ~VkDeviceSize{0};
  int allowed = 1 << 30;
  std::vector<VkDeviceSize> sizes;
} heaps;

VKAPI_ATTR VkResult VKAPI_CALL allocateFromHeaps(VkDevice device, const VkMemoryAllocateInfo* info,
                                                 const VkAllocationCallbacks* with, VkDeviceMemory* memory) {
  if (heaps.allocations >= heaps.allowed) return VK_ERROR_TOO_MANY_OBJECTS;
  if (info->allocationSize > heaps.left) return VK_ERROR_OUT_OF_DEVICE_MEMORY;
  ++heaps.allocations;
  heaps.left -= info->allocationSize;
  heaps.sizes.push_back(info->allocationSize);
  return heaps.real.vkAllocateMemory(device, info, with, memory);
}

}  // namespace

TEST_CASE("small buffers share allocations, and give them back") {
  needVulkan();
  vulkan::Device device({}, vulkanOptions().validation);
  heaps = {device.vk()};
  functionsOf(device).vkAllocateMemory = allocateFromHeaps;
  {
    vulkan::Transfer transfer(device, device.maxBufferBytes());
    std::vector<vulkan::Buffer> buffers;
    for (uint32_t i = 0; i < 300; ++i) {
      buffers.emplace_back(device, "numbers", 1000 + 7 * i, MemoryKind::device);
      CHECK(buffers.back().address() % 16 == 0);
    }
    CHECK(heaps.allocations <= 3);
    std::vector<std::byte> data(1000), back(1000);
    // Each has its own bytes, also after some in between are gone and others have taken their place.
    const auto fill = [&](uint32_t i) {
      std::fill(data.begin(), data.end(), static_cast<std::byte>(i));
      transfer.write(buffers[i], 0, data);
    };
    for (uint32_t i = 0; i < 300; ++i) fill(i);
    for (uint32_t i = 0; i < 300; i += 3) buffers[i] = {};
    for (uint32_t i = 0; i < 300; i += 3) {
      buffers[i] = vulkan::Buffer(device, "numbers", 1000 + 5 * i, MemoryKind::device);
      fill(i);
    }
    for (uint32_t i = 0; i < 300; ++i) {
      transfer.read(buffers[i], 0, back);
      CHECK(std::all_of(back.begin(), back.end(), [&](std::byte b) { return b == static_cast<std::byte>(i); }));
    }
    CHECK(heaps.allocations <= 4);
  }
  CHECK(device.blocks().count() == 0);
  CHECK_NOTHROW(device.throwOnMessages());
}

TEST_CASE("a device without room for a block gives what is needed, and too many allocations have their own words") {
  needVulkan();
  vulkan::Device device({}, vulkanOptions().validation);
  heaps = {device.vk()};
  heaps.left = 100'000;
  functionsOf(device).vkAllocateMemory = allocateFromHeaps;
  CHECK_NOTHROW(vulkan::Buffer(device, "numbers", 50'000, MemoryKind::device));
  const auto fails = [&] {
    return problemOf([&] { vulkan::Buffer(device, "numbers", 200'000, MemoryKind::device); }, ErrorCode::outOfMemory);
  };
  CHECK_THAT(fails(), ContainsSubstring("cannot allocate 0.2 MiB for 'numbers'; the device '"));
  heaps.allowed = 0;
  CHECK_THAT(fails(), ContainsSubstring("allocations, of which the simulators on it have 0, and others the rest"));
}

TEST_CASE("no more memory is allocated than the device says it allows, and small arrays still share what there is") {
  needVulkan();
  vulkan::Device device({}, false);
  VkPhysicalDeviceProperties properties;
  device.instanceFunctions().vkGetPhysicalDeviceProperties(device.physical(), &properties);
  CHECK(device.capabilities().mostAllocations == properties.limits.maxMemoryAllocationCount);
  heaps = {device.vk()};
  functionsOf(device).vkAllocateMemory = allocateFromHeaps;
  vulkan::MemoryBlocks blocks(device.handle(), device.vk(), 3, device.hangs());
  const VkMemoryRequirements large = {5 << 20, 256, 1}, small = {1000, 256, 1};
  std::vector<vulkan::MemoryBlocks::Piece> pieces(3);
  CHECK(blocks.take(small, 0, false, pieces[0]) == VK_SUCCESS);
  CHECK(blocks.take(large, 0, false, pieces[1]) == VK_SUCCESS);
  CHECK(blocks.take(large, 0, false, pieces[2]) == VK_SUCCESS);
  vulkan::MemoryBlocks::Piece more;
  CHECK(blocks.take(large, 0, false, more) == VK_ERROR_TOO_MANY_OBJECTS);
  CHECK(heaps.allocations == 3);
  CHECK(blocks.take(small, 0, false, more) == VK_SUCCESS);
  blocks.giveBack(more);
  for (const auto& piece : pieces) blocks.giveBack(piece);
  CHECK(blocks.take(large, 0, false, more) == VK_SUCCESS);
  blocks.giveBack(more);
}

TEST_CASE("memory types are tried in the order of the wishes, each once") {
  needVulkan();
  vulkan::Device device({}, false);
  constexpr VkMemoryPropertyFlags kVisible = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT;
  const VkMemoryPropertyFlags wanted[] = {kVisible | VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, kVisible, 0};
  const std::vector<uint32_t> types = device.memoryTypes(~0u, wanted);
  REQUIRE(!types.empty());
  std::vector<uint32_t> sorted = types;
  std::sort(sorted.begin(), sorted.end());
  CHECK(std::adjacent_find(sorted.begin(), sorted.end()) == sorted.end());
  CHECK(device.memoryTypes(0, wanted).empty());

  // AMD's drivers list all types twice, the second time coherent between caches, for which a feature is needed.
  auto& memory = const_cast<VkPhysicalDeviceMemoryProperties&>(device.memory());
  memory = {};
  for (const VkMemoryPropertyFlags flags : {VkMemoryPropertyFlags{VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT}, kVisible})
    memory.memoryTypes[memory.memoryTypeCount++].propertyFlags = flags;
  for (uint32_t i = 0; i < 2; ++i)
    memory.memoryTypes[memory.memoryTypeCount++].propertyFlags =
        memory.memoryTypes[i].propertyFlags | VK_MEMORY_PROPERTY_DEVICE_COHERENT_BIT_AMD;
  CHECK(device.memoryTypes(~0u, wanted) == std::vector<uint32_t>{1, 0});
}

namespace {

enum Type : uint32_t { local, both, host, cached };  // of a graphics card's memory

/// The requests for memory that a graphics card in a test has had.
struct Card {
  vulkan::DeviceFunctions real;
  VkDeviceSize bothLeft = 0;  // bytes that the heap still has which the host and the card see
  std::vector<uint32_t> types;
  int copies = 0;
} card;

/// Makes a device look like a graphics card without resizable BAR: the host sees `visible` bytes of its memory. Buffers
/// need no more than an alignment of 4.
void becomeCard(vulkan::Device& device, VkDeviceSize visible) {
  card = {device.vk(), visible};
  const_cast<vulkan::Capabilities&>(device.capabilities()).info.type = "discrete";
  auto& memory = const_cast<VkPhysicalDeviceMemoryProperties&>(device.memory());
  constexpr VkMemoryPropertyFlags kLocal = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
  constexpr VkMemoryPropertyFlags kHost = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
  memory = {};
  for (const VkMemoryPropertyFlags flags : {kLocal, kLocal | kHost, kHost, kHost | VK_MEMORY_PROPERTY_HOST_CACHED_BIT})
    memory.memoryTypes[memory.memoryTypeCount++].propertyFlags = flags;
  auto& vk = functionsOf(device);
  vk.vkGetBufferMemoryRequirements = [](VkDevice handle, VkBuffer buffer, VkMemoryRequirements* requirements) {
    card.real.vkGetBufferMemoryRequirements(handle, buffer, requirements);
    requirements->memoryTypeBits = 0xf;
    requirements->alignment = 4;
  };
  vk.vkAllocateMemory = [](VkDevice handle, const VkMemoryAllocateInfo* info, const VkAllocationCallbacks* with,
                           VkDeviceMemory* allocated) {
    if (info->memoryTypeIndex == both) {
      if (info->allocationSize > card.bothLeft) return VK_ERROR_OUT_OF_DEVICE_MEMORY;
      card.bothLeft -= info->allocationSize;
    }
    card.types.push_back(info->memoryTypeIndex);
    VkMemoryAllocateInfo real = *info;
    real.memoryTypeIndex = 0;
    return card.real.vkAllocateMemory(handle, &real, with, allocated);
  };
  vk.vkCmdCopyBuffer = [](VkCommandBuffer commands, VkBuffer from, VkBuffer to, uint32_t count,
                          const VkBufferCopy* regions) {
    ++card.copies;
    card.real.vkCmdCopyBuffer(commands, from, to, count, regions);
  };
}

size_t allocationsOf(Type type) {
  return static_cast<size_t>(std::count(card.types.begin(), card.types.end(), type));
}

}  // namespace

TEST_CASE("results of batches on a card are copied to the host as far as it asks for them") {
  needVulkan();
  vulkan::Device device({}, true);
  becomeCard(device, 0);
  const uint64_t bytes = 4096, hostBytes = GENERATE(96, 4096);
  {
    vulkan::VulkanRing ring(device, 2, bytes, hostBytes);
    CHECK(ring.bytes() == 2 * (bytes + hostBytes));
    CHECK(allocationsOf(local) == 2);
    CHECK(allocationsOf(cached) == 1);  // small buffers share it
    CHECK(ring.hostHasAll(1) == (hostBytes == bytes));
    for (uint32_t batch = 0; batch < 4; ++batch) {
      const size_t at = batch % 2;
      ring.wait(at);
      ring.begin(at);
      vulkan::CommandBuffer& commands = ring.commands(at).buffer();
      commands.fill(ring.results(at), 0, VK_WHOLE_SIZE, 0x1000 + batch);
      commands.fullBarrier();
      ring.submit(at, bytes);
      ring.wait(at);
      const auto* const words = reinterpret_cast<const uint32_t*>(ring.host(at));
      CHECK(std::all_of(words, words + hostBytes / 4, [&](uint32_t word) { return word == 0x1000 + batch; }));
    }
  }
  CHECK(card.copies == 4);
  CHECK_FALSE(device.failed());
  device.throwOnMessages();
}

TEST_CASE(
    "result buffers are given to readers outside the device with each batch, and taken back before the next one") {
  needVulkan();
  vulkan::Device device({}, vulkanOptions().validation);
  const vulkan::Capabilities& capabilities = device.capabilities();
  using Way = std::pair<uint32_t, uint32_t>;  // of ownership, from one family of queues to another
  static std::vector<Way> ways;
  static PFN_vkCmdPipelineBarrier real;
  ways.clear();
  real = device.vk().vkCmdPipelineBarrier;
  functionsOf(device).vkCmdPipelineBarrier =
      [](VkCommandBuffer commands, VkPipelineStageFlags before, VkPipelineStageFlags after, VkDependencyFlags flags,
         uint32_t memories, const VkMemoryBarrier* memory, uint32_t buffers, const VkBufferMemoryBarrier* buffer,
         uint32_t images, const VkImageMemoryBarrier* image) {
        for (uint32_t i = 0; i < buffers; ++i)
          ways.emplace_back(buffer[i].srcQueueFamilyIndex, buffer[i].dstQueueFamilyIndex);
        real(commands, before, after, flags, memories, memory, buffers, buffer, images, image);
      };
  vulkan::VulkanRing ring(device, 1, 4096, 4096);
  for (int batch = 0; batch < 2; ++batch) {
    ring.begin(0);
    ring.commands(0).buffer().fill(ring.results(0), 0, VK_WHOLE_SIZE, 1);
    ring.commands(0).cut();
    ring.commands(0).buffer().fullBarrier();
    ring.submit(0, 4096);
    ring.wait(0);
  }
  const Way away = {capabilities.queueFamily, VK_QUEUE_FAMILY_EXTERNAL}, back = {away.second, away.first};
  CHECK(ways == (capabilities.exportsMemory ? std::vector<Way>{away, back, away} : std::vector<Way>()));
  device.throwOnMessages();
}

TEST_CASE("a card whose visible memory is full gives the host's, and staging never takes the card's") {
  needVulkan();
  vulkan::Device device({}, false);
  becomeCard(device, 8 << 20);
  std::deque<vulkan::Buffer> buffers;
  for (int i = 0; i < 4; ++i) buffers.emplace_back(device, "upload", 5 << 20, MemoryKind::upload);
  CHECK(card.types == std::vector<uint32_t>{both, host, host, host});
  for (const vulkan::Buffer& buffer : buffers) CHECK(buffer.mapped());
  card.types.clear();
  buffers.emplace_back(device, "results", 5 << 20, MemoryKind::readback);
  buffers.push_back(vulkan::Buffer::staging(device, 5 << 20, false));
  buffers.push_back(vulkan::Buffer::staging(device, 5 << 20, true));
  buffers.emplace_back(device, "words", 5 << 20, MemoryKind::device);
  CHECK(card.types == std::vector<uint32_t>{cached, host, cached, local});
  CHECK(!buffers.back().mapped());
}

TEST_CASE("arrays of a card begin at multiples of 16 bytes, whatever its buffers need") {
  needVulkan();
  vulkan::Device device({}, false);
  becomeCard(device, 8 << 20);
  std::deque<vulkan::Buffer> buffers;
  for (uint32_t i = 0; i < 100; ++i) {
    buffers.emplace_back(device, "array", 4 * (3 * i + 1), i % 2 ? MemoryKind::device : MemoryKind::upload);
    CHECK(buffers.back().address() % 16 == 0);
  }
}

TEST_CASE("an array of a card grows there, and data go to and fro by memory that is allocated once") {
  needVulkan();
  vulkan::Device device({}, false);
  becomeCard(device, 8 << 20);
  vulkan::Transfer transfer(device, device.maxBufferBytes());
  constexpr size_t kBytes = 40 << 20;
  std::vector<std::byte> data(kBytes), back(kBytes);
  for (size_t i = 0; i < kBytes; ++i) data[i] = static_cast<std::byte>(i * 2654435761u >> 24);
  vulkan::Buffer small(device, "array", kBytes, MemoryKind::device);
  vulkan::Buffer large(device, "array", 2 * kBytes, MemoryKind::device);
  transfer.write(small, 0, data);
  const size_t allocations = card.types.size();
  CHECK(allocationsOf(host) == 1);
  card.copies = 0;
  transfer.copy(small, large, kBytes);
  CHECK(card.copies == 1);
  CHECK(card.types.size() == allocations);
  for (int round = 0; round < 3; ++round) {
    transfer.read(large, 0, back);
    transfer.write(small, 0, data);
  }
  CHECK(back == data);
  CHECK(allocationsOf(host) == 1);
  CHECK(allocationsOf(cached) == 1);
}

}  // namespace gnosphere::test

// SPDX-License-Identifier: Apache-2.0
// Uses of the results of recorded scans that an application makes by means of Vulkan alone: memory that others import,
// and timeline semaphores. The buffers and the submissions are the application's, so the library has no part in it.
#include <cstring>
#include <deque>
#include <string>
#include <vector>

#include "engine/recorded.hpp"

namespace gnosphere::test {
namespace {

constexpr auto kOpaqueFd = VK_EXTERNAL_MEMORY_HANDLE_TYPE_OPAQUE_FD_BIT;

/// A buffer whose memory another device imports, or that is such an import.
class SharedBuffer {
 public:
  SharedBuffer(const VulkanApp& app, VkDeviceSize bytes) : SharedBuffer(app, bytes, -1) {}
  /// Imports the memory of `fd`. The device owns the file descriptor from then on.
  SharedBuffer(const VulkanApp& app, VkDeviceSize bytes, int fd) : app_(app), bytes_(bytes) {
    const auto& vk = app.vk();
    const VkExternalMemoryBufferCreateInfo external = {VK_STRUCTURE_TYPE_EXTERNAL_MEMORY_BUFFER_CREATE_INFO, nullptr,
                                                       kOpaqueFd};
    VkBufferCreateInfo create = {VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, &external};
    create.size = bytes;
    create.usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT;
    REQUIRE(vk.vkCreateBuffer(device(), &create, nullptr, &buffer_) == VK_SUCCESS);
    VkMemoryRequirements requirements;
    vk.vkGetBufferMemoryRequirements(device(), buffer_, &requirements);
    const VkExportMemoryAllocateInfo exported = {VK_STRUCTURE_TYPE_EXPORT_MEMORY_ALLOCATE_INFO, nullptr, kOpaqueFd};
    const VkImportMemoryFdInfoKHR imported = {VK_STRUCTURE_TYPE_IMPORT_MEMORY_FD_INFO_KHR, nullptr, kOpaqueFd, fd};
    VkMemoryAllocateFlagsInfo flags = {VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO};
    flags.pNext = fd < 0 ? static_cast<const void*>(&exported) : &imported;
    flags.flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT;
    VkMemoryAllocateInfo allocate = {VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, &flags};
    allocate.allocationSize = requirements.size;
    allocate.memoryTypeIndex = app.hostMemory(requirements.memoryTypeBits);
    REQUIRE(vk.vkAllocateMemory(device(), &allocate, nullptr, &memory_) == VK_SUCCESS);
    REQUIRE(vk.vkBindBufferMemory(device(), buffer_, memory_, 0) == VK_SUCCESS);
    REQUIRE(vk.vkMapMemory(device(), memory_, 0, VK_WHOLE_SIZE, 0, &host_) == VK_SUCCESS);
  }
  ~SharedBuffer() {
    app_.vk().vkDestroyBuffer(device(), buffer_, nullptr);
    app_.vk().vkFreeMemory(device(), memory_, nullptr);
  }
  SharedBuffer(const SharedBuffer&) = delete;
  SharedBuffer& operator=(const SharedBuffer&) = delete;

  /// A file descriptor that stands for the memory; the caller closes or imports it.
  int fd() const {
    VkMemoryGetFdInfoKHR info = {VK_STRUCTURE_TYPE_MEMORY_GET_FD_INFO_KHR, nullptr, memory_, kOpaqueFd};
    int fd = -1;
    REQUIRE(app_.function<PFN_vkGetMemoryFdKHR>("vkGetMemoryFdKHR")(device(), &info, &fd) == VK_SUCCESS);
    REQUIRE(fd >= 0);
    return fd;
  }
  vulkan::DeviceRange range() const {
    const VkBufferDeviceAddressInfo where = {VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO, nullptr, buffer_};
    return {app_.vk().vkGetBufferDeviceAddress(device(), &where), bytes_};
  }
  const void* host() const { return host_; }

 private:
  VkDevice device() const { return app_.adopted().device; }

  const VulkanApp& app_;
  VkDeviceSize bytes_;
  VkBuffer buffer_ = VK_NULL_HANDLE;
  VkDeviceMemory memory_ = VK_NULL_HANDLE;
  void* host_ = nullptr;
};

/// A semaphore that counts up.
class Timeline {
 public:
  explicit Timeline(const VulkanApp& app) : app_(app) {
    const VkSemaphoreTypeCreateInfo type = {VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO, nullptr,
                                            VK_SEMAPHORE_TYPE_TIMELINE, 0};
    const VkSemaphoreCreateInfo create = {VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO, &type};
    REQUIRE(app.function<PFN_vkCreateSemaphore>("vkCreateSemaphore")(device(), &create, nullptr, &semaphore_) ==
            VK_SUCCESS);
  }
  /// Lavapipe's thread of the queue uses the semaphore for a moment after its count is reached.
  ~Timeline() {
    app_.waitForQueue();
    app_.function<PFN_vkDestroySemaphore>("vkDestroySemaphore")(device(), semaphore_, nullptr);
  }
  Timeline(const Timeline&) = delete;
  Timeline& operator=(const Timeline&) = delete;

  /// Submits commands that begin at one count and end with another.
  void submit(VkCommandBuffer commands, uint64_t from, uint64_t to) const {
    VkTimelineSemaphoreSubmitInfo counts = {VK_STRUCTURE_TYPE_TIMELINE_SEMAPHORE_SUBMIT_INFO};
    counts.waitSemaphoreValueCount = counts.signalSemaphoreValueCount = 1;
    counts.pWaitSemaphoreValues = &from;
    counts.pSignalSemaphoreValues = &to;
    VkSubmitInfo submit = {VK_STRUCTURE_TYPE_SUBMIT_INFO, &counts};
    const VkPipelineStageFlags all = VK_PIPELINE_STAGE_ALL_COMMANDS_BIT;
    submit.waitSemaphoreCount = submit.signalSemaphoreCount = submit.commandBufferCount = 1;
    submit.pWaitSemaphores = submit.pSignalSemaphores = &semaphore_;
    submit.pWaitDstStageMask = &all;
    submit.pCommandBuffers = &commands;
    REQUIRE(app_.vk().vkQueueSubmit(app_.queue(), 1, &submit, VK_NULL_HANDLE) == VK_SUCCESS);
  }
  void wait(uint64_t count) const {
    VkSemaphoreWaitInfo info = {VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO};
    info.semaphoreCount = 1;
    info.pSemaphores = &semaphore_;
    info.pValues = &count;
    REQUIRE(app_.function<PFN_vkWaitSemaphores>("vkWaitSemaphores")(device(), &info, UINT64_MAX) == VK_SUCCESS);
  }

 private:
  VkDevice device() const { return app_.adopted().device; }

  const VulkanApp& app_;
  VkSemaphore semaphore_ = VK_NULL_HANDLE;
};

}  // namespace

TEST_CASE("another device reads recorded results by a file descriptor, as each timeline semaphore's count is reached",
          "[second-driver]") {
  needVulkan();
  const std::string extension = VK_KHR_EXTERNAL_MEMORY_FD_EXTENSION_NAME;
  VulkanApp app("", nullptr, {extension});
  VulkanApp other(app.deviceName(), nullptr, {extension});
  if (!app.has(extension)) SKIP(app.deviceName() << " has no " << extension);

  const RecordLayout layout = layoutOf({Field::x, Field::y, Field::z, Field::instance});
  SensorRequest request = {gridSensor(90, 8, -18, 9), Effects::none()};
  TestOptions own = vulkanOptions();
  own.device = {DeviceChoice::Kind::vulkan, app.deviceName()};
  Simulator expected(boxes(), request, own);
  request.layout = layout;
  SimulatorOptions options;
  options.cache = "off";
  options.device = app.choice();
  Simulator simulator(boxes(), request, options);
  vulkan::Recorder recorder(simulator, 2);

  const VkDeviceSize bytes = layout.bytesFor(720);
  const SharedBuffer mine[] = {{app, bytes}, {app, bytes}};
  const SharedBuffer theirs[] = {{other, bytes, mine[0].fd()}, {other, bytes, mine[1].fd()}};
  const VulkanApp::Buffer header(app, sizeof(RecordHeader));
  VulkanApp::Frame frames[] = {VulkanApp::Frame(app), VulkanApp::Frame(app)};
  const Timeline timeline(app);
  std::vector<std::byte> rows[2];
  for (uint64_t number = 1; number <= 5; ++number) {
    INFO("frame " << number);
    const size_t at = number % 2;
    // The frame in flight is free again once the frame before it has reached its count.
    if (number > 2) {
      timeline.wait(number - 2);
      CHECK(std::memcmp(theirs[at].host(), rows[at].data(), bytes) == 0);
    }
    for (Simulator* each : {&simulator, &expected})
      each->setTransform(1, translation(6, 0.4 * static_cast<double>(number), 0));
    vulkan::RecordedShot shot = {{}, mine[at].range(), header.range()};
    const VkCommandBuffer commands = frames[at].begin();
    recorder.record(commands, at, {&shot, 1});
    REQUIRE(app.vk().vkEndCommandBuffer(commands) == VK_SUCCESS);
    timeline.submit(commands, number - 1, number);
    const Scan scan = expected.scan({});
    rows[at] = rowsOf(scan, layout);
    CHECK(scan.counters.hits == 720);
    CHECK(rows[0] != rows[1]);
  }
  timeline.wait(5);
  CHECK(std::memcmp(theirs[1].host(), rows[1].data(), bytes) == 0);
  CHECK(std::memcmp(theirs[0].host(), rows[0].data(), bytes) == 0);
}

TEST_CASE("another device reads the result buffers of a stream, batch after batch", "[second-driver]") {
  needVulkan();
  const std::string extension = VK_KHR_EXTERNAL_MEMORY_FD_EXTENSION_NAME;
  TestOptions options = vulkanOptions();
  Simulator expected(boxes(), {gridSensor(90, 8, -18, 9), Effects::none()}, options);
  VulkanApp other(expected.device().name, nullptr, {extension});
  if (!other.has(extension)) SKIP(other.deviceName() << " has no " << extension);
  options.resultsOnDevice = true;
  Simulator simulator(boxes(), {gridSensor(90, 8, -18, 9), Effects::none()}, options);
  BatchStream stream(simulator, {3});
  const ResultPlaces places = stream.places();
  std::deque<SharedBuffer> theirs;
  for (size_t buffer = 0; buffer < 2; ++buffer) {
    const ExportedMemory memory = stream.exportMemory(buffer);
    CHECK(memory.bytes >= places.bytes);
    theirs.emplace_back(other, memory.bytes, memory.fd);
  }
  for (uint64_t number = 0; number < 5; ++number) {
    std::vector<Shot> shots(3);
    for (size_t i = 0; i < shots.size(); ++i) {
      shots[i].pose.position.y = 0.1 * static_cast<double>(i + number);
      shots[i].frame = 10 * number + i;
    }
    stream.wait(stream.submit(shots));
    const Batch batch = expected.scanBatch(shots);
    const auto* const bytes = static_cast<const std::byte*>(theirs[number % 2].host());
    const auto* const headers = reinterpret_cast<const RecordHeader*>(bytes + places.headers);
    for (size_t i = 0; i < shots.size(); ++i) {
      CHECK(headers[i].frame == shots[i].frame);
      CHECK(std::memcmp(bytes + places.records + i * places.bytesPerView, batch.ranges().data() + 720 * i, 2880) == 0);
    }
  }
}

}  // namespace gnosphere::test

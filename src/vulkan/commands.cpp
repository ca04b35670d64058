// SPDX-License-Identifier: Apache-2.0
#include "vulkan/commands.hpp"

#include <cstdio>
#include <stdexcept>
#include <utility>

#include "base/decimal_point.hpp"

namespace gnosphere::vulkan {
namespace {

// How long a submission may take. A graphics card is reset by its driver after some seconds; a software device may well
// take minutes.
constexpr uint64_t kSecond = 1'000'000'000, kLongest = 60 * kSecond, kLongestOnCpu = 3600 * kSecond;
constexpr uint32_t kLeastStamps = 32;

constexpr const char* kLessWork = "less work at a time may help (tuning.max_submission_work, fewer beams or sub-rays)";

}  // namespace

Commands::Commands(const Device& device) : device_(device), vk_(device.vk()) {
  VkCommandPoolCreateInfo pool = {VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
  pool.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
  pool.queueFamilyIndex = device_.capabilities().queueFamily;
  pool_ = device.make(vk_.vkCreateCommandPool, vk_.vkDestroyCommandPool, pool);
  makeRoom(kLeastStamps);
}

void Commands::makeRoom(uint32_t stamps) {
  if (stamps <= stampLimit_) return;
  VkQueryPoolCreateInfo queries = {VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO};
  queries.queryType = VK_QUERY_TYPE_TIMESTAMP;
  queries.queryCount = stamps;
  queries_ = device_.make(vk_.vkCreateQueryPool, vk_.vkDestroyQueryPool, queries);
  stampLimit_ = stamps;
}

Commands::~Commands() {
  if (pending_) waitForAll();
}

void Commands::open(size_t submission) {
  if (submission == submissions_.size()) {
    const VkFenceCreateInfo fence = {VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    Submission made = {device_.make(vk_.vkCreateFence, vk_.vkDestroyFence, fence)};
    VkCommandBufferAllocateInfo allocate = {VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
    allocate.commandPool = pool_.get();
    allocate.commandBufferCount = 1;
    VK(vk_.vkAllocateCommandBuffers(device_.handle(), &allocate, &made.commands));
    submissions_.push_back(std::move(made));
  }
  commands_ = {device_, submissions_[submission].commands};
  VK(vk_.vkResetCommandBuffer(commands_.handle(), 0));  // it may hold a recording that was given up
  VkCommandBufferBeginInfo begin = {VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
  begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  VK(vk_.vkBeginCommandBuffer(commands_.handle(), &begin));
  used_ = submission + 1;
}

void Commands::cut() {
  VK(vk_.vkEndCommandBuffer(commands_.handle()));
  open(used_);
}

void Commands::begin(uint32_t stamps) {
  wait();
  makeRoom(stamps);
  open(0);
  vk_.vkCmdResetQueryPool(commands_.handle(), queries_.get(), 0, stampLimit_);
  stamps_.clear();
}

void Commands::stamp(const char* stage, std::string step) {
  if (device_.capabilities().timestampBits == 0) return;
  if (stamps_.size() == stampLimit_) throw std::logic_error("a scan has more timestamps than there is room for");
  vk_.vkCmdWriteTimestamp(commands_.handle(), VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, queries_.get(),
                          static_cast<uint32_t>(stamps_.size()));
  stamps_.push_back({stage, std::move(step)});
}

void Commands::submit() {
  VK(vk_.vkEndCommandBuffer(commands_.handle()));
  const size_t count = std::exchange(used_, 0);
  while (used_ < count) {
    VkSubmitInfo submit = {VK_STRUCTURE_TYPE_SUBMIT_INFO};
    submit.commandBufferCount = 1;
    Submission& next = submissions_[used_];
    submit.pCommandBuffers = &next.commands;
    const VkResult result = device_.submit(submit, next.fence.get(), next.number);
    if (result != VK_SUCCESS && pending_) wait();  // for the submissions before the one that failed
    if (result == VK_ERROR_DEVICE_LOST) refuseLost();
    check(result, "vkQueueSubmit");
    pending_ = true;
    ++used_;
  }
}

VkResult Commands::waitForAll() {
  // A submission that hangs has had its time, and so have those behind it; perhaps all have ended by now.
  const uint64_t longest = device_.hangs() > 0 ? 0 : device_.capabilities().cpu ? kLongestOnCpu : kLongest;
  VkResult result = VK_SUCCESS;
  for (size_t i = 0; i < used_ && result == VK_SUCCESS; ++i) {
    const VkFence fence = submissions_[i].fence.get();
    const uint64_t number = submissions_[i].number;
    result = vk_.vkWaitForFences(device_.handle(), 1, &fence, VK_TRUE, longest * device_.unendedUpTo(number));
    if (result == VK_SUCCESS) device_.noteEnd(number);
  }
  if (result != VK_SUCCESS) device_.noteFailure();
  const bool hangs = result == VK_TIMEOUT;
  if (hangs != hangs_) device_.hangs() += hangs ? 1 : -1;
  hangs_ = hangs;
  // A wait that fails for another reason, such as a lack of memory, does not tell that the device has ended its work.
  pending_ = result != VK_SUCCESS && result != VK_ERROR_DEVICE_LOST;
  return result;
}

void Commands::wait() {
  if (!pending_) return;
  const VkResult result = waitForAll();
  if (result == VK_ERROR_DEVICE_LOST) refuseLost();
  if (result == VK_TIMEOUT) refuse("did not end its work in time", std::string("If it does not hang, ") + kLessWork);
  if (result != VK_SUCCESS) refuse(std::string("cannot be waited for, ") + resultName(result), "");
  for (size_t i = 0; i < used_; ++i) {
    const VkFence fence = submissions_[i].fence.get();
    VK(vk_.vkResetFences(device_.handle(), 1, &fence));
  }
}

void Commands::refuseLost() const {
  refuse("was lost at its work", std::string("Drivers end work that takes them seconds: ") + kLessWork);
}

void Commands::refuse(const std::string& why, const std::string& remedy) const {
  throw Error(ErrorCode::device,
              "the device '" + device_.capabilities().info.name + "' " + why + progress() +
                  (remedy.empty() ? remedy : "; this simulator is of no more use, a new one may be. " + remedy));
}

// A timestamp that is there tells that its stage has ended.
std::string Commands::progress() const {
  std::string last = "none", planned;
  bool all = true;
  for (size_t i = 0; i < stamps_.size(); ++i) {
    const char* stage = stamps_[i].stage;
    if (!stage) continue;
    if (planned.find(stage) == std::string::npos) planned += (planned.empty() ? "" : ", ") + std::string(stage);
    uint64_t ticks[2] = {};
    const VkResult result =
        vk_.vkGetQueryPoolResults(device_.handle(), queries_.get(), static_cast<uint32_t>(i), 1, sizeof ticks, ticks,
                                  sizeof ticks, VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WITH_AVAILABILITY_BIT);
    all = all && result == VK_SUCCESS && ticks[1] != 0;
    if (all) last = stage;
  }
  return planned.empty() ? planned
                         : " (stages: " + planned + "; the last one that is known to have ended: " + last + ")";
}

std::vector<uint64_t> Commands::readTicks() const {
  std::vector<uint64_t> ticks(stamps_.size());
  VK(vk_.vkGetQueryPoolResults(device_.handle(), queries_.get(), 0, static_cast<uint32_t>(ticks.size()),
                               ticks.size() * sizeof ticks[0], ticks.data(), sizeof ticks[0],
                               VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT));
  return ticks;
}

void Commands::readTimings(Timings& timings) {
  if (stamps_.empty()) return;
  const std::vector<uint64_t> ticks = readTicks();
  uint64_t before = 0;
  for (size_t i = 0; i < ticks.size(); ++i) {
    if (!stamps_[i].step.empty()) continue;
    if (stamps_[i].stage) {
      const double ms = device_.capabilities().elapsedMs(before, ticks[i]);
      timings.gpuMs += ms;
      timings.add(stamps_[i].stage, ms);
    }
    before = ticks[i];
  }
}

double Commands::workMs() const {
  if (stamps_.size() < 2) return 0;
  const std::vector<uint64_t> ticks = readTicks();
  return device_.capabilities().elapsedMs(ticks.front(), ticks.back());
}

void Commands::readTrace(const std::function<void(const std::string&)>& receive) {
  if (stamps_.empty()) return receive("the device '" + device_.capabilities().info.name + "' has no timestamps");
  const std::vector<uint64_t> ticks = readTicks();
  for (size_t i = 0; i < ticks.size(); ++i) {
    if (stamps_[i].step.empty()) continue;
    const DecimalPoint point;
    char time[32] = "";
    if (i > 0)
      std::snprintf(time, sizeof time, "%10.4f ms  ", device_.capabilities().elapsedMs(ticks[i - 1], ticks[i]));
    receive(time + stamps_[i].step);
  }
}

}  // namespace gnosphere::vulkan

// SPDX-License-Identifier: Apache-2.0
#include "lanes/schedule.hpp"

#include <algorithm>
#include <boost/context/fiber.hpp>
#include <boost/context/pooled_fixedsize_stack.hpp>
#include <cstring>
#include <deque>
#include <map>
#include <memory>
#include <numeric>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "lanes/accesses.hpp"

namespace gnosphere::lanes {
namespace {

namespace context = boost::context;

constexpr size_t kStackBytes = 256 << 10;

struct Subgroup;
struct Workgroup;

struct Fiber {
  Lane lane;
  Workgroup* workgroup = nullptr;
  Subgroup* subgroup = nullptr;
  context::fiber resume, host;  // one of both is valid: where to go on in the lane, where to go back to
  bool ended = false;
};

/// The operation that waiting lanes have called.
struct Meeting {
  const char* operation = nullptr;
  std::source_location where;
  uint32_t number = 0, first = 0;  // the lane that came first, and its number
  uint32_t arrived = 0;
};

struct Subgroup {
  std::vector<Fiber*> lanes;
  Meeting meeting;
  uint32_t barriers = 0;
  // Lanes may still read what was given to one operation while the first lanes give to the next one.
  std::vector<std::byte> given[2];
  uint32_t turn = 0;
};

struct Workgroup {
  std::vector<std::unique_ptr<Fiber>> fibers;
  std::vector<Subgroup> subgroups;
  Meeting barrier;
  uint32_t barriers = 0, number = 0;
  std::map<std::string, std::vector<std::byte*>> shared;
  uint32_t left = kWorkgroupSize;
};

/// Choices of a seed besides the lanes' order: how often they are interrupted, which lane runs next, and how many
/// workgroups run at a time.
struct Habit {
  enum class Next { any, newest, oldest, starveOne } next;
  uint32_t interruptMask;  // a lane is interrupted if these bits of a random number are 0
  uint32_t atOnce;
};

class Dispatch {
 public:
  Dispatch(uint32_t workgroupsX, uint32_t workgroupsY, const std::function<void()>& main);
  ~Dispatch() { current = nullptr; }

  void run();
  void park() { fiber_->host = std::move(fiber_->host).resume(); }
  void wake(Fiber* fiber) { runnable_.push_back(fiber); }

  Given meet(const char* operation, uint32_t number, const void* value, size_t bytes,
             const std::source_location& where);
  void barrier(const std::source_location& where);
  void interrupt();
  void* sharedMemory(const char* name, size_t bytes);
  Moment now() const {
    return {fiber_->workgroup->number * kWorkgroupSize + fiber_->lane.local, fiber_->workgroup->barriers,
            fiber_->subgroup->barriers};
  }
  [[noreturn]] void fail(const std::string& finding) {
    finding_ = finding;
    while (true) park();
  }

 private:
  void start(uint32_t number);
  Fiber* choose();
  void arrive(Meeting& meeting, const char* operation, uint32_t number, const std::source_location& where,
              const char* scope);
  std::string stuck() const;

  uint32_t groups_[2];
  const std::function<void()>& main_;
  std::mt19937_64 random_;
  Habit habit_ = {};
  std::vector<uint32_t> waiting_;  // numbers of workgroups that have not begun
  std::map<uint32_t, Workgroup> running_;
  std::vector<Fiber*> runnable_;
  Fiber* fiber_ = nullptr;
  std::string finding_;
};

Order chosen;
const char* kernelOfDispatch = "kernel";
std::set<std::string> kernelsRun;
uint64_t dispatches = 0;
Dispatch* active = nullptr;

context::pooled_fixedsize_stack& stacks() {
  static context::pooled_fixedsize_stack pool(kStackBytes);
  return pool;
}

std::string placeOf(const std::source_location& where) {
  const std::string file = where.file_name();
  return file.substr(file.rfind('/') + 1) + ":" + std::to_string(where.line());
}

Dispatch::Dispatch(uint32_t workgroupsX, uint32_t workgroupsY, const std::function<void()>& main)
    : groups_{workgroupsX, workgroupsY}, main_(main), random_(chosen.seed * 1'000'003 + dispatches) {
  constexpr uint32_t kMasks[] = {~0u, 0xff, 0x1f, 0x3};
  habit_.next = static_cast<Habit::Next>(random_() % 4);
  habit_.interruptMask = kMasks[random_() % 4];
  habit_.atOnce = 1 + static_cast<uint32_t>(random_() % 4);
  waiting_.resize(size_t{workgroupsX} * workgroupsY);
  std::iota(waiting_.begin(), waiting_.end(), 0);
  std::shuffle(waiting_.begin(), waiting_.end(), random_);
}

void Dispatch::start(uint32_t number) {
  Workgroup& group = running_[number];
  group.number = number;
  group.subgroups.resize(kWorkgroupSize / chosen.subgroupSize);
  for (uint32_t local = 0; local < kWorkgroupSize; ++local) {
    auto fiber = std::make_unique<Fiber>();
    Subgroup& subgroup = group.subgroups[local / chosen.subgroupSize];
    fiber->lane = {local,
                   local % chosen.subgroupSize,
                   local / chosen.subgroupSize,
                   {number % groups_[0], number / groups_[0]},
                   {groups_[0], groups_[1]}};
    fiber->workgroup = &group;
    fiber->subgroup = &subgroup;
    subgroup.lanes.push_back(fiber.get());
    fiber->resume = context::fiber(std::allocator_arg, stacks(), [this, own = fiber.get()](context::fiber&& host) {
      own->host = std::move(host);
      main_();
      own->ended = true;
      return std::move(own->host);
    });
    wake(fiber.get());
    group.fibers.push_back(std::move(fiber));
  }
  for (Subgroup& subgroup : group.subgroups)
    for (auto& given : subgroup.given) given.resize(size_t{chosen.subgroupSize} * kLargestValue);
}

Fiber* Dispatch::choose() {
  size_t k = runnable_.size() - 1;
  if (habit_.next == Habit::Next::any || habit_.next == Habit::Next::starveOne) k = random_() % runnable_.size();
  if (habit_.next == Habit::Next::oldest) k = 0;
  // The first subgroup waits as long as another lane can run.
  if (habit_.next == Habit::Next::starveOne)
    for (size_t tries = 0; tries < runnable_.size() && runnable_[k]->lane.subgroup == 0; ++tries)
      k = (k + 1) % runnable_.size();
  Fiber* fiber = runnable_[k];
  if (habit_.next == Habit::Next::oldest) {
    runnable_.erase(runnable_.begin());
  } else {
    runnable_[k] = runnable_.back();
    runnable_.pop_back();
  }
  return fiber;
}

void Dispatch::run() {
  while (true) {
    while (!waiting_.empty() && running_.size() < habit_.atOnce) {
      start(waiting_.back());
      waiting_.pop_back();
    }
    if (running_.empty()) return;
    if (runnable_.empty()) finding_ = stuck();
    if (!finding_.empty()) {
      // Lanes that are waiting stay as they are, because to unwind them would end the process.
      new std::map<uint32_t, Workgroup>(std::move(running_));
      throw Finding(finding_);
    }
    fiber_ = choose();
    current = &fiber_->lane;
    fiber_->resume = std::move(fiber_->resume).resume();
    current = nullptr;
    if (!fiber_->ended) continue;
    Workgroup* group = fiber_->workgroup;
    if (--group->left > 0) continue;
    for (auto& [name, blocks] : group->shared)
      for (std::byte* block : blocks) release(block);
    running_.erase(group->number);
  }
}

std::string Dispatch::stuck() const {
  for (const auto& [number, group] : running_) {
    const std::string in = std::string(kernelOfDispatch) + ": workgroup " + std::to_string(number);
    for (size_t i = 0; i < group.subgroups.size(); ++i) {
      const Subgroup& subgroup = group.subgroups[i];
      if (subgroup.meeting.arrived > 0)
        return in + ": " + subgroup.meeting.operation + " at " + placeOf(subgroup.meeting.where) + " was reached by " +
               std::to_string(subgroup.meeting.arrived) + " of " + std::to_string(subgroup.lanes.size()) +
               " lanes of subgroup " + std::to_string(i);
    }
    if (group.barrier.arrived > 0)
      return in + ": barrier() at " + placeOf(group.barrier.where) + " was reached by " +
             std::to_string(group.barrier.arrived) + " of " + std::to_string(kWorkgroupSize) + " lanes";
  }
  return std::string(kernelOfDispatch) + ": no lane can run";
}

void Dispatch::arrive(Meeting& meeting, const char* operation, uint32_t number, const std::source_location& where,
                      const char* scope) {
  if (meeting.arrived++ == 0) {
    meeting.operation = operation;
    meeting.where = where;
    meeting.number = number;
    meeting.first = fiber_->lane.local;
    return;
  }
  const std::string lanes = std::string(kernelOfDispatch) + ": lanes " + std::to_string(meeting.first) + " and " +
                            std::to_string(fiber_->lane.local) + " of a " + scope;
  if (std::strcmp(meeting.operation, operation) != 0 || meeting.where.line() != where.line() ||
      std::strcmp(meeting.where.file_name(), where.file_name()) != 0)
    fail(lanes + " are at different operations: " + meeting.operation + " at " + placeOf(meeting.where) + " and " +
         operation + " at " + placeOf(where));
  if (meeting.number != number)
    fail(lanes + " call " + operation + " at " + placeOf(where) +
         " with different numbers: " + std::to_string(meeting.number) + " and " + std::to_string(number));
}

Given Dispatch::meet(const char* operation, uint32_t number, const void* value, size_t bytes,
                     const std::source_location& where) {
  if (bytes > kLargestValue) fail(std::string(operation) + ": the value is too large for these tests");
  Subgroup& subgroup = *fiber_->subgroup;
  arrive(subgroup.meeting, operation, number, where, "subgroup");
  std::byte* given = subgroup.given[subgroup.turn].data();
  if (bytes > 0) std::memcpy(given + size_t{fiber_->lane.inSubgroup} * kLargestValue, value, bytes);
  if (subgroup.meeting.arrived == subgroup.lanes.size()) {
    subgroup.meeting.arrived = 0;
    subgroup.turn ^= 1;
    for (Fiber* other : subgroup.lanes)
      if (other != fiber_) wake(other);
    if (std::strcmp(operation, "subgroupBarrier") == 0) ++subgroup.barriers;
    wake(fiber_);
  }
  park();
  return Given(given);
}

void Dispatch::barrier(const std::source_location& where) {
  Workgroup& group = *fiber_->workgroup;
  arrive(group.barrier, "barrier", 0, where, "workgroup");
  if (group.barrier.arrived == kWorkgroupSize) {
    group.barrier.arrived = 0;
    ++group.barriers;
    for (auto& other : group.fibers) wake(other.get());
  }
  park();
}

void Dispatch::interrupt() {
  if (habit_.interruptMask == ~0u || (random_() & habit_.interruptMask) != 0) return;
  wake(fiber_);
  park();
}

void* Dispatch::sharedMemory(const char* name, size_t bytes) {
  std::vector<std::byte*>& blocks = fiber_->workgroup->shared[name];
  if (blocks.empty()) blocks.push_back(allocate(name, bytes));
  return blocks.front();
}

}  // namespace

void setOrder(const Order& order) {
  chosen = order;
}
const Order& order() {
  return chosen;
}
void setKernel(const char* name) {
  kernelOfDispatch = name;
  kernelsRun.insert(name);
}
bool hasRun(const std::string& kernel) {
  return kernelsRun.contains(kernel);
}

void dispatch(uint32_t workgroupsX, uint32_t workgroupsY, const std::function<void()>& main) {
  ++dispatches;
  Dispatch dispatch(workgroupsX, workgroupsY, main);
  active = &dispatch;
  try {
    dispatch.run();
  } catch (...) {
    active = nullptr;
    throw;
  }
  active = nullptr;
}

Given meet(const char* operation, const void* value, size_t bytes, const std::source_location& where) {
  return active->meet(operation, 0, value, bytes, where);
}
Given meetWith(const char* operation, uint32_t number, const void* value, size_t bytes,
               const std::source_location& where) {
  return active->meet(operation, number, value, bytes, where);
}
void workgroupBarrier(const std::source_location& where) {
  active->barrier(where);
}
void subgroupMemoryBarrier(const std::source_location& where) {
  active->meet("subgroupBarrier", 0, nullptr, 0, where);
}
void interrupt() {
  active->interrupt();
}
void* sharedMemory(const char* name, size_t bytes) {
  return active->sharedMemory(name, bytes);
}
void fail(const std::string& finding) {
  active->fail(finding);
}
Moment now() {
  return active->now();
}
const char* kernelName() {
  return kernelOfDispatch;
}
uint64_t dispatchNumber() {
  return dispatches;
}

}  // namespace gnosphere::lanes

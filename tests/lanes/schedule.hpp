// SPDX-License-Identifier: Apache-2.0
// Workgroups on the host: each lane is a fiber, and a seed decides which lane runs next and where it is interrupted.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <source_location>
#include <stdexcept>
#include <string>

namespace gnosphere::lanes {

/// A rule of the execution model that the kernels have broken. The text names kernel, lanes and place.
struct Finding : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// How the next dispatches run.
struct Order {
  uint64_t seed = 1;
  uint32_t subgroupSize = 32;  ///< 4, 8, 16, 32 or 64
};

constexpr uint32_t kWorkgroupSize = 64;
constexpr uint32_t kLargestValue = 64;  // bytes that a lane can give to a subgroup operation

/// One invocation of a kernel.
struct Lane {
  uint32_t local = 0;       ///< within the workgroup
  uint32_t inSubgroup = 0;  ///< within the subgroup
  uint32_t subgroup = 0;    ///< within the workgroup
  uint32_t group[2] = {}, groups[2] = {};
};

/// The lane that is running, or null while the host runs.
inline thread_local const Lane* current = nullptr;

/// Sets the order of the dispatches that follow.
void setOrder(const Order& order);
const Order& order();

/// Names the kernel of the next dispatch in findings.
void setKernel(const char* name);
/// Returns whether a kernel of this name has run.
bool hasRun(const std::string& kernel);

/// Runs `main` once per lane of workgroupsX * workgroupsY workgroups. Throws Finding if a subgroup operation or a
/// barrier is reached by some lanes of a subgroup or workgroup only, or if lanes race for memory.
void dispatch(uint32_t workgroupsX, uint32_t workgroupsY, const std::function<void()>& main);

/// Values that the lanes of a subgroup have given to an operation, valid until the lane's next operation.
class Given {
 public:
  explicit Given(const std::byte* values) : values_(values) {}
  template <typename T>
  T of(uint32_t lane) const {
    T value;
    __builtin_memcpy(&value, values_ + size_t{lane} * kLargestValue, sizeof value);
    return value;
  }

 private:
  const std::byte* values_;
};

/// Waits until all lanes of the subgroup have called this at one place with one name, and gives what each has given.
Given meet(const char* operation, const void* value, size_t bytes, const std::source_location& where);
/// The same with a number that must be equal in all lanes, for instance the lane that a broadcast reads.
Given meetWith(const char* operation, uint32_t number, const void* value, size_t bytes,
               const std::source_location& where);
/// Waits until all lanes of the workgroup have called this at one place.
void workgroupBarrier(const std::source_location& where);
/// Waits as meet() does, and orders all earlier writes of the lanes before their later reads and writes.
void subgroupMemoryBarrier(const std::source_location& where);
/// Gives other lanes the chance to run, as the seed decides.
void interrupt();

/// Memory that the lanes of a workgroup share; every lane gets the same address for the same name.
void* sharedMemory(const char* name, size_t bytes);

/// Ends the dispatch with a finding. The lane does not go on, and nothing is unwound, because the compiler takes loads
/// and stores for calls that throw nothing.
[[noreturn]] void fail(const std::string& finding);

/// Numbers that tell which accesses of two lanes are ordered by barriers.
struct Moment {
  uint32_t invocation = 0;                               ///< within the dispatch; kWorkgroupSize per workgroup
  uint32_t workgroupBarriers = 0, subgroupBarriers = 0;  ///< passed so far
};
Moment now();
const char* kernelName();
uint64_t dispatchNumber();

}  // namespace gnosphere::lanes

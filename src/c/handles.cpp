// SPDX-License-Identifier: Apache-2.0
// The table of live objects, and exceptions as statuses.
#include "c/handles.hpp"

#include <algorithm>
#include <new>
#include <unordered_map>

#include "base/os.hpp"

namespace gnosphere::c {
namespace {

struct Entry {
  const char* kind;
  std::shared_ptr<void> object;
  bool borrowed = false;
};

struct Table {
  std::mutex mutex;
  std::unordered_map<uintptr_t, Entry> entries;
  uintptr_t next = 0x10000;  // distinct from small numbers that a caller may take for a handle

  // Returns the entry of a handle, or throws the sentence that says what is wrong with it.
  auto at(const char* kind, uintptr_t handle) {
    if (handle == 0) refuse(std::string("the handle of the ") + kind + " is null");
    const auto found = entries.find(handle);
    if (found == entries.end())
      refuse(std::string("there is no ") + kind + " of this handle: it has been destroyed, or never was a handle");
    if (std::string_view(found->second.kind) != kind)
      refuse(std::string("the handle is that of a ") + found->second.kind + ", not of a " + kind);
    return found;
  }

  uintptr_t add(const Entry& entry) {
    const std::lock_guard lock(mutex);
    const uintptr_t handle = next;
    entries[handle] = entry;
    next += 16;
    return handle;
  }
};

// Never destroyed, because other threads may still call the library while the process ends. A fork waits for the lock,
// which the forked process then finds free.
Table& table() {
  static Table* const theTable = [] {
    os::atFork([] { table().mutex.lock(); }, [] { table().mutex.unlock(); });
    return new Table;
  }();
  return *theTable;
}

thread_local std::string lastError;

gno_status fail(gno_status status, const char* message) noexcept {
  try {
    lastError = message;
  } catch (...) {  // without memory for the sentence, the status says it alone
    lastError.clear();
  }
  return status;
}

gno_status statusOf(ErrorCode code) {
  switch (code) {
    case ErrorCode::invalidArgument: return GNO_INVALID_ARGUMENT;
    case ErrorCode::file: return GNO_FILE;
    case ErrorCode::format: return GNO_FORMAT;
    case ErrorCode::device: return GNO_DEVICE;
    case ErrorCode::outOfMemory: break;
  }
  return GNO_OUT_OF_MEMORY;
}

}  // namespace

uintptr_t keep(const char* kind, std::shared_ptr<void> object) {
  return table().add({kind, std::move(object)});
}

uintptr_t keepBorrowed(const char* kind, std::shared_ptr<void> object) {
  return table().add({kind, std::move(object), true});
}

std::shared_ptr<void> find(const char* kind, uintptr_t handle) {
  Table& all = table();
  const std::lock_guard lock(all.mutex);
  return all.at(kind, handle)->second.object;
}

void forget(const char* kind, uintptr_t handle) {
  Table& all = table();
  std::shared_ptr<void> last;  // destroyed after the lock is released
  const std::lock_guard lock(all.mutex);
  const auto entry = all.at(kind, handle);
  if (entry->second.borrowed)
    refuse(std::string("this ") + kind + " belongs to the library, which destroys it after the call");
  last = std::move(entry->second.object);
  all.entries.erase(entry);
}

void release(uintptr_t handle) noexcept {
  Table& all = table();
  std::shared_ptr<void> last;  // destroyed after the lock is released
  const std::lock_guard lock(all.mutex);
  const auto entry = all.entries.find(handle);
  if (entry == all.entries.end()) return;
  last = std::move(entry->second.object);
  all.entries.erase(entry);
}

gno_status statusOfException() noexcept {
  try {
    throw;
  } catch (const Error& error) {
    return fail(statusOf(error.code()), error.what());
  } catch (const Cancelled& cancelled) {
    return fail(GNO_CANCELLED, cancelled.why.c_str());
  } catch (const std::bad_alloc&) {
    return fail(GNO_OUT_OF_MEMORY, "there is not enough memory");
  } catch (const std::length_error&) {  // a count for which no memory can be enough
    return fail(GNO_OUT_OF_MEMORY, "there is not enough memory for so many elements");
  } catch (const std::exception& error) {
    return fail(GNO_INTERNAL, error.what());
  } catch (...) {
    return fail(GNO_INTERNAL, "an unknown exception");
  }
}

void cancelAfterException(const char* function) {
  std::string what = "an exception";
  try {
    throw;
  } catch (const std::exception& error) {
    what = std::string("the exception '") + error.what() + "'";
  } catch (...) {  // an exception of any other type has no sentence
  }
  throw Cancelled{std::string(function) + " has thrown " + what +
                  ", which ended the call; functions that the library calls must not throw"};
}

void refuse(const std::string& why) {
  throw Error(ErrorCode::invalidArgument, why);
}

void checkSize(size_t given, size_t known, size_t alignment, const char* type) {
  const auto explain = [&](const std::string& why) {
    refuse(std::string(type) + "::struct_size is " + std::to_string(given) + ", " + why + "; make the struct with " +
           type + "_init()");
  };
  if (given < sizeof(size_t) || given % alignment != 0) explain("which is no size of it");
  if (given > known)
    explain("but version " + std::to_string(gno_version()) + " of the library knows only " + std::to_string(known) +
            " bytes of it; a newer library is needed");
}

Pose poseOf(const gno_pose& pose) {
  const auto& q = pose.orientation;
  return {vec3(pose.position), {q[0], q[1], q[2], q[3]}};
}

gno_pose poseOf(const Pose& pose) {
  const auto& [p, q] = pose;
  return {{p.x, p.y, p.z}, {q.x, q.y, q.z, q.w}};
}

Transform transformOf(const gno_transform& transform) {
  Transform result;
  std::copy_n(transform.rows, 12, result.rows.begin());
  return result;
}

}  // namespace gnosphere::c

extern "C" const char* gno_last_error(void) {
  return gnosphere::c::lastError.c_str();
}
extern "C" uint32_t gno_version(void) {
  return GNO_VERSION;
}

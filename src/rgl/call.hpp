// SPDX-License-Identifier: Apache-2.0
// Every function of the interface runs through call(): it lets one call run at a time, turns exceptions into statuses,
// and writes the call to the tape if one is recorded.
#pragma once

#include <rgl/api/core.h>

#include <exception>
#include <mutex>
#include <string>
#include <tuple>

#include "rgl/tape.hpp"

namespace gnosphere::rgl {

/// A failure with the status that the caller gets.
class Failure : public std::exception {
 public:
  Failure(rgl_status_t status, std::string message) : status_(status), message_(std::move(message)) {}
  rgl_status_t status() const { return status_; }
  const char* what() const noexcept override { return message_.c_str(); }

 private:
  rgl_status_t status_;
  std::string message_;
};

/// Refuses an argument unless a condition holds; the message has the condition's text, which callers may look for.
#define RGL_CHECK(condition)                                                                                      \
  do {                                                                                                            \
    if (!(condition))                                                                                             \
      throw Failure(RGL_INVALID_ARGUMENT, "RGL API Error: Invalid argument, condition unsatisfied: " #condition); \
  } while (0)

/// Everything below runs under this lock. The lock is recursive, because a tape that is played calls the interface.
std::recursive_mutex& callMutex();

/// Keeps a status and its sentence for rgl_get_last_error_string() of this thread.
rgl_status_t setStatus(rgl_status_t status, const char* message) noexcept;
/// The status of the exception that is being handled.
rgl_status_t statusOfException() noexcept;

// Functions of messages for people. By default those from RGL_LOG_LEVEL_INFO on go to the standard output, as RGL's do.
void log(rgl_log_level_t level, const std::string& message);
bool logs(rgl_log_level_t level);
void configureLog(rgl_log_level_t level, const char* file, bool standardOutput);

/// The arguments of a call that a tape has.
template <class... Arguments>
using Taped = std::tuple<const Arguments&...>;
template <class... Arguments>
Taped<Arguments...> taped(const Arguments&... arguments) {
  return {arguments...};
}

/// Runs the body of a function of the interface. The tape gets its name, which is the function's, and its arguments if
/// it succeeds.
template <class... Arguments, class Body>
rgl_status_t call(const char* name, const Taped<Arguments...>& arguments, Body body) noexcept {
  try {
    const std::lock_guard lock(callMutex());
    if (logs(RGL_LOG_LEVEL_TRACE)) log(RGL_LOG_LEVEL_TRACE, name);
    body();
    if (tape().recording()) std::apply([&](const auto&... each) { tape().record(name, each...); }, arguments);
    return setStatus(RGL_SUCCESS, "operation successful");
  } catch (...) {
    return statusOfException();
  }
}

/// As call(), without the lock and for functions that a tape does not have.
template <class Body>
rgl_status_t callUnlocked(Body body) noexcept {
  try {
    body();
    return setStatus(RGL_SUCCESS, "operation successful");
  } catch (...) {
    return statusOfException();
  }
}

/// As call(), for functions that a tape does not have.
template <class Body>
rgl_status_t callUnrecorded(Body body) noexcept {
  return callUnlocked([&] {
    const std::lock_guard lock(callMutex());
    body();
  });
}

}  // namespace gnosphere::rgl

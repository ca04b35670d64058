// SPDX-License-Identifier: Apache-2.0
// Statuses, messages and versions: the functions about the library itself.
#include <cstdio>
#include <gnosphere/error.hpp>
#include <gnosphere/ros2.hpp>

#include "base/os.hpp"
#include "base/path.hpp"
#include "rgl/fields.hpp"
#include "rgl/node.hpp"
#include "rgl/scene.hpp"

namespace gnosphere::rgl {
namespace {

thread_local std::string lastMessage = "operation successful";

struct Log {
  rgl_log_level_t level = RGL_LOG_LEVEL_INFO;
  std::FILE* file = nullptr;
  bool standardOutput = true;
};

Log& theLog() {
  static Log log;
  return log;
}

// The extension for weather is there for its snow alone; rain and fog are not implemented.
bool isAvailable(rgl_extension_t extension) {
  switch (extension) {
    case RGL_EXTENSION_PCL:
    case RGL_EXTENSION_WEATHER: return true;
    case RGL_EXTENSION_ROS2: return gnosphere::ros2::unavailable().empty();
    default: return false;
  }
}

}  // namespace

std::recursive_mutex& callMutex() {
  static auto* const mutex = new std::recursive_mutex;
  return *mutex;
}

uintptr_t nextHandle() {
  static uintptr_t next = 0x10000000;
  return next += 16;
}

rgl_status_t setStatus(rgl_status_t status, const char* message) noexcept {
  try {
    lastMessage = message;
    if (status != RGL_SUCCESS) log(RGL_LOG_LEVEL_ERROR, lastMessage);
  } catch (...) {
    lastMessage.clear();
  }
  return status;
}

rgl_status_t statusOfException() noexcept {
  try {
    throw;
  } catch (const Failure& failure) {
    return setStatus(failure.status(), failure.what());
  } catch (const Error& error) {
    return setStatus(error.code() == ErrorCode::file ? RGL_INVALID_FILE_PATH : RGL_INTERNAL_EXCEPTION, error.what());
  } catch (const std::exception& error) {
    return setStatus(RGL_INTERNAL_EXCEPTION, error.what());
  } catch (...) {
    return setStatus(RGL_INTERNAL_EXCEPTION, "an unknown exception");
  }
}

bool logs(rgl_log_level_t level) {
  return level >= theLog().level && level < RGL_LOG_LEVEL_OFF;
}

void log(rgl_log_level_t level, const std::string& message) {
  static const char* const kNames[] = {"trace", "debug", "info", "warning", "error", "critical"};
  const std::lock_guard lock(callMutex());
  const Log& to = theLog();
  if (!logs(level)) return;
  if (to.standardOutput) std::printf("[RGL] [%s] %s\n", kNames[level], message.c_str());
  if (to.file) {
    std::fprintf(to.file, "[RGL] [%s] %s\n", kNames[level], message.c_str());
    std::fflush(to.file);
  }
}

void configureLog(rgl_log_level_t level, const char* file, bool standardOutput) {
  std::FILE* opened = nullptr;
  if (file && level != RGL_LOG_LEVEL_OFF) {
    opened = os::openFile(pathOf(file), "w");
    if (!opened) throw Failure(RGL_LOGGING_ERROR, std::string("the log file ") + file + " cannot be written");
  }
  Log& to = theLog();
  if (to.file) std::fclose(to.file);
  to = {level, opened, standardOutput};
}

}  // namespace gnosphere::rgl

using namespace gnosphere::rgl;

RGL_API rgl_status_t rgl_get_version_info(int32_t* out_major, int32_t* out_minor, int32_t* out_patch) {
  Version told{};
  return call(__func__, taped(told.major, told.minor, told.patch), [&] {
    RGL_CHECK(out_major != nullptr);
    RGL_CHECK(out_minor != nullptr);
    RGL_CHECK(out_patch != nullptr);
    told = version();
    *out_major = told.major;
    *out_minor = told.minor;
    *out_patch = told.patch;
  });
}

RGL_API rgl_status_t rgl_get_extension_info(rgl_extension_t extension, int32_t* out_available) {
  int32_t told = 0;
  return call(__func__, taped(extension, told), [&] {
    RGL_CHECK(out_available != nullptr);
    RGL_CHECK(extension >= 0);
    RGL_CHECK(extension < RGL_EXTENSION_COUNT);
    *out_available = told = isAvailable(extension);
  });
}

RGL_API rgl_status_t rgl_configure_logging(rgl_log_level_t log_level, const char* log_file_path, bool use_stdout) {
  return call(__func__, taped(log_level, std::string(log_file_path ? log_file_path : ""), use_stdout), [&] {
    const bool logLevelKnown = log_level >= RGL_LOG_LEVEL_ALL && log_level <= RGL_LOG_LEVEL_OFF;
    RGL_CHECK(logLevelKnown);
    const bool logFileOrStdout = log_file_path != nullptr || use_stdout || log_level == RGL_LOG_LEVEL_OFF;
    RGL_CHECK(logFileOrStdout);
    configureLog(log_level, log_file_path, use_stdout);
  });
}

RGL_API void rgl_get_last_error_string(const char** out_error_string) {
  if (out_error_string) *out_error_string = lastMessage.c_str();
}

RGL_API rgl_status_t rgl_cleanup(void) {
  return call(__func__, taped(), [] {
    clearNodes();
    scene().clear();
  });
}

/// The version of GnoSphere; RGL has no such function, so it tells the two apart.
RGL_API const char* gnosphere_rgl_build(void) {
  return GNOSPHERE_RGL_BUILD;
}

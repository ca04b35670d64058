// SPDX-License-Identifier: Apache-2.0
// Opens libgnosphere_ros2, so that neither the library nor a program needs Cyclone DDS unless it publishes.
#include <dlfcn.h>

#include <cstdlib>
#include <mutex>

#include "gnosphere/error.hpp"
#include "ros2/wire.hpp"

namespace gnosphere::ros2 {
namespace {

struct Library {
  OpenFunction* open = nullptr;
  std::string missing;  // why it could not be opened
};

// The symbols of another copy of Cyclone DDS in the process, as ROS has one, must not replace those that the library
// was built with. The sanitizers end a process that asks for this.
int flags() {
  const bool sanitized = dlsym(RTLD_DEFAULT, "__asan_init") || dlsym(RTLD_DEFAULT, "__tsan_init");
  return RTLD_NOW | RTLD_LOCAL | (sanitized ? 0 : RTLD_DEEPBIND);
}

Library load() {
  const char* chosen = std::getenv("GNOSPHERE_ROS2_LIBRARY");
  const std::string name = chosen ? chosen : GNOSPHERE_ROS2_LIBRARY;
  void* const handle = dlopen(name.c_str(), flags());
  if (!handle) {
    const char* why = dlerror();
    return {nullptr,
            "GnoSphere cannot publish for ROS 2 (" + std::string(why ? why : name.c_str()) +
                "): install the Debian packages cyclonedds-dev and cyclonedds-tools, and build GnoSphere again"};
  }
  const auto version = reinterpret_cast<VersionFunction*>(dlsym(handle, kVersionName));
  const auto open = reinterpret_cast<OpenFunction*>(dlsym(handle, kOpenName));
  if (!version || !open || version() != std::string(GNOSPHERE_ROS2_VERSION))
    return {nullptr, name + " is of another version of GnoSphere than " + GNOSPHERE_ROS2_VERSION};
  return {open, ""};
}

/// The library stays open until the process ends, because threads of Cyclone DDS run in it.
const Library& library() {
  static const auto* const theLibrary = new Library(load());
  return *theLibrary;
}

}  // namespace

std::string unavailable() {
  return library().missing;
}

std::unique_ptr<Wire> openWire(const Topic& topic) {
  if (!library().open) throw Error(ErrorCode::device, library().missing);
  std::string error;
  std::unique_ptr<Wire> wire(library().open(topic, error));
  if (!wire) throw Error(ErrorCode::device, "the topic " + topic.name + " cannot be published: " + error);
  return wire;
}

}  // namespace gnosphere::ros2

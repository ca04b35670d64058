// SPDX-License-Identifier: Apache-2.0
// Opens libgnosphere_ros2, so that neither the library nor a program needs Cyclone DDS unless it publishes.
#include <cstdlib>
#include <mutex>

#include "base/os.hpp"
#include "gnosphere/error.hpp"
#include "ros2/wire.hpp"

namespace gnosphere::ros2 {
namespace {

struct Library {
  OpenFunction* open = nullptr;
  std::string missing;  // why it could not be opened
};

// The symbols of another copy of Cyclone DDS in the process, as ROS has one, must not replace those that the library
// was built with.
Library load() {
  const char* chosen = std::getenv("GNOSPHERE_ROS2_LIBRARY");
  const std::string name = chosen && *chosen ? chosen : GNOSPHERE_ROS2_LIBRARY;
  void* const handle = os::openLibrary(name, true);
  if (!handle)
    return {nullptr,
            "GnoSphere cannot publish for ROS 2 (" + os::libraryProblem() +
                "): install the Debian packages cyclonedds-dev and cyclonedds-tools, and build GnoSphere again"};
  const auto version = reinterpret_cast<VersionFunction*>(os::symbolOf(handle, kVersionName));
  const auto open = reinterpret_cast<OpenFunction*>(os::symbolOf(handle, kOpenName));
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

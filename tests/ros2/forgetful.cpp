// SPDX-License-Identifier: Apache-2.0
// Stands in for libgnosphere_ros2, and has no memory for a message.
#include <new>

#include "ros2/wire.hpp"

using namespace gnosphere::ros2;

namespace {

struct ForgetfulWire : Wire {
  bool write(const Message&) override { throw std::bad_alloc(); }
  uint32_t subscribers() override { return 0; }
};

}  // namespace

extern "C" __attribute__((visibility("default"))) Wire* gnosphere_ros2_open(const Topic&, std::string&) {
  return new ForgetfulWire;
}

extern "C" __attribute__((visibility("default"))) const char* gnosphere_ros2_version() {
  return GNOSPHERE_ROS2_VERSION;
}

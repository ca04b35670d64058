// SPDX-License-Identifier: Apache-2.0
// Interface of libgnosphere_ros2 to the library, which opens it when it is needed and does not link it.
#pragma once

#include <memory>
#include <string>

#include "gnosphere/ros2.hpp"

namespace gnosphere::ros2 {

/// A topic as subscribers see it.
struct Topic {
  MessageType type = MessageType::pointCloud2;
  std::string name;  ///< on the wire, "rt/points"
  Qos qos;
  uint32_t domain = 0;
  std::string discovery;  ///< configuration of Cyclone DDS before that of CYCLONEDDS_URI; empty for its own
};

/// The writer of one topic.
class Wire {
 public:
  virtual ~Wire() = default;
  /// Gives a message to the network. Returns false if it does not take the message.
  virtual bool write(const Message& message) = 0;
  virtual uint32_t subscribers() = 0;
};

/// Opens libgnosphere_ros2 and makes a writer. Throws Error(device) if it cannot be opened.
std::unique_ptr<Wire> openWire(const Topic& topic);

// The functions of libgnosphere_ros2, which no exception leaves.
using OpenFunction = Wire*(const Topic& topic, std::string& error);  ///< null, and the error, if there is no writer
using VersionFunction = const char*();
inline constexpr const char* kOpenName = "gnosphere_ros2_open";
inline constexpr const char* kVersionName = "gnosphere_ros2_version";

}  // namespace gnosphere::ros2

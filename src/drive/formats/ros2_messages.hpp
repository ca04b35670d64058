// SPDX-License-Identifier: Apache-2.0
// Messages of ROS 2 as bags have them: their definitions, and their bytes in CDR.
#pragma once

#include <string>
#include <vector>

#include "drive/formats/mcap_file.hpp"
#include "gnosphere/ros2.hpp"

namespace gnosphere::drive {

/// Returns the definitions of all types of messages, in the order of ros2::MessageType.
std::vector<McapSchema> messageSchemas();
/// Returns the number of a type's definition among them, from 1 on, as MCAP counts them.
uint16_t schemaOf(ros2::MessageType type);

/// Appends a message in CDR.
void appendMessage(std::string& bytes, const ros2::Message& message);

}  // namespace gnosphere::drive

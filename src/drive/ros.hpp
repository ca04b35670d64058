// SPDX-License-Identifier: Apache-2.0
// The topics and times of a drive as ROS 2 knows them, in bags and in live messages.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "drive/drive.hpp"

namespace gnosphere::drive {

/// Returns the topic "/NAME" + `what` of a sensor. Names of sensors may have hyphens, and topics may not.
std::string topicOf(const RigSensor& sensor, const std::string& what);

/// Returns why ROS 2 cannot have the names of these sensors, by index; empty if it can.
std::string mistakeOfNames(const Drive& drive, std::span<const size_t> sensors);

/// Returns why ROS 2 cannot have the times of the drive, whose seconds are 32 bits; empty if it can.
std::string mistakeOfTimes(const Drive& drive);

/// Returns how many times a frame the pose of the vehicle is told: at least ten, and a hundred a second.
uint64_t posesPerFrame(const Drive& drive);

/// Returns the times in a frame at which this pose is told, on the clock of the trajectories. In the `last` frame they
/// reach to the end of all scans.
std::vector<double> poseTimes(const Drive& drive, uint64_t frame, bool last);

}  // namespace gnosphere::drive

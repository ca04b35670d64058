// SPDX-License-Identifier: Apache-2.0
// Checks and completions of what a caller gives to a simulator. Each throws Error(invalidArgument); `which` is the
// beginning of the message.
#pragma once

#include <string>

#include "gnosphere/simulator.hpp"

namespace gnosphere {

void validate(const AccuracyParts& parts);
void validate(const Pose& pose, const std::string& which);
void validate(const Transform& transform, size_t instance, const std::string& which = "");
void validate(const SensorMotion& motion, const std::string& which);
/// Throws Error(invalidArgument) if the sensor moves only before or only after its beams fire, so that nothing would
/// move: the stamps of a motion count from the start of the scan.
void checkTimes(const SensorMotion& motion, const Sensor& sensor, uint64_t frame, const std::string& which);
/// Checks that the shots of a batch have one sensor.
void checkSensorOfBatch(std::span<const Shot> shots);
/// Returns the fields that a batch of a sensor has: those asked for, or all that its scans have.
std::vector<Field> fieldsOfBatch(const SensorRequest& request, const DeviceChoice& device, size_t sensor,
                                 std::span<const Field> asked);
/// Refuses a motion of an instance whose transform comes from a buffer.
[[noreturn]] void refuseMotion(size_t instance, const std::string& which);
/// Returns the request with the fields of its layout among its fields.
SensorRequest withFieldsOfLayout(SensorRequest request);

}  // namespace gnosphere

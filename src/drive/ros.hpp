// SPDX-License-Identifier: Apache-2.0
// The topics and times of a drive as ROS 2 knows them, in bags and in live messages.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "drive/record.hpp"

namespace gnosphere::drive {

/// Returns the fields of the clouds of these sensors, by index, if the drive file names none. If one of them is a list
/// of beams without a driver, they have the number of the beam, without which a frame does not go back into its grid.
std::vector<Field> usualCloudFields(const Drive& drive, std::span<const size_t> sensors);

/// Returns the fields of a sensor's clouds in live messages: as in the drive's first bag that has the sensor, or else
/// as bags have them by default.
std::vector<Field> liveFieldsOf(const Drive& drive, size_t sensor);

/// Returns the type of the messages that a sensor's clouds are.
ros2::MessageType cloudTypeOf(const RigSensor& sensor);

/// Returns the cloud of a scan, in a message of cloudTypeOf(), as its sensor's driver publishes it, or with
/// these fields, of which an intensity that the scan lacks is left out, and intensities in which a diffuse white
/// surface is 1.
ros2::Message cloudMessage(const Drive& drive, const RecordedScan& recorded, std::vector<Field> fields);

/// Whether a sensor has one channel of evenly spaced beams, so that its scans are laser scans, too.
bool isFlat(const Sensor& sensor);

/// Returns the laser scan of a flat sensor, with intensities in which a diffuse white surface is 1.
ros2::LaserScan laserMessage(const Drive& drive, const RecordedScan& recorded);

/// Returns the pose of the vehicle in the world at a time of the trajectories' clock.
ros2::Transforms vehicleMessage(const Drive& drive, double time);

/// Returns the pose of the vehicle in the world and its velocity along its own axes at a time of the trajectories'
/// clock.
ros2::Odometry odometryMessage(const Drive& drive, double time);

/// Returns what the drive's inertial unit measures, without noise, at a time of the trajectories' clock.
ros2::Imu imuMessage(const Drive& drive, double time);

/// Returns the times in a frame at which the drive's inertial unit measures. In the `last` frame they reach to the end
/// of all scans.
std::vector<double> imuTimes(const Drive& drive, uint64_t frame, bool last);

/// Returns the number of the first measurement of a frame.
uint64_t firstMeasurement(const Drive& drive, uint64_t frame);

/// Returns the topic "/NAME" + `what` of a sensor or an inertial unit, whose names may have hyphens, and topics may
/// not.
std::string topicOf(std::string name, const std::string& what);

/// Returns the poses of the sensors, by index, and of the inertial unit on the vehicle.
ros2::Transforms mountsOf(const Drive& drive, std::span<const size_t> sensors);

/// Returns why ROS 2 cannot have the names of these sensors, by index; empty if it can.
std::string mistakeOfNames(const Drive& drive, std::span<const size_t> sensors);

/// Returns why ROS 2 cannot have the times of the drive, whose seconds are 32 bits; empty if it can.
std::string mistakeOfTimes(const Drive& drive);

/// Returns how many times a frame the pose of the vehicle is told: at least ten, a hundred a second, and as often as
/// its trajectory has stamps, up to a thousand a second.
uint64_t posesPerFrame(const Drive& drive);

/// Returns the times in a frame at which this pose is told, on the clock of the trajectories. In the `last` frame they
/// reach to the end of all scans.
std::vector<double> poseTimes(const Drive& drive, uint64_t frame, bool last);

}  // namespace gnosphere::drive

// SPDX-License-Identifier: Apache-2.0
// Publishes a drive for ROS 2 in its own time.
#pragma once

#include <functional>

#include "drive/drive.hpp"
#include "gnosphere/ros2.hpp"

namespace gnosphere::drive {

struct LiveOptions {
  uint64_t firstFrame = 0, endFrame = UINT64_MAX;  ///< frames firstFrame..endFrame - 1
  double speed = 1;                                ///< seconds of the drive per second
  SimulatorOptions simulator;                      ///< the drive's accuracy and other options replace its own
  /// Called on the caller's thread with the device before the first frame is scanned.
  std::function<void(const DeviceInfo&)> started;
  ros2::Qos qos;  ///< of clouds and laser scans
  /// Called when a frame has been published, with the number of published frames and that of frames to publish. The
  /// calls come one after another from a thread of the run, and not from that of the caller.
  std::function<void(uint64_t done, uint64_t total)> progress;
};

struct LiveReport {
  uint64_t frames = 0, scans = 0, points = 0, messages = 0;
  uint64_t dropped = 0;  ///< messages that newer ones replaced before they went to the network
  double seconds = 0;    ///< from the first message to the last
  double late = 0;       ///< seconds by which the end was late, because scanning took longer than the drive
  std::string device;
};

/// Publishes every scan when it is over: the cloud of each sensor on /NAME/points, and on /NAME/scan the laser scan of
/// one with a single channel (hyphens of NAME become underscores); the vehicle on /tf and the sensors on /tf_static;
/// and the time of the drive on /clock, 100 times a second for 10 frames a second. If scanning takes too long, the
/// clock waits for it. Throws Error(invalidArgument) for an empty range of frames and for a sensor whose name is no
/// name of a topic, and what ros2::Publisher throws.
LiveReport publishLive(const Drive& drive, const LiveOptions& options);

}  // namespace gnosphere::drive

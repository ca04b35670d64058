// SPDX-License-Identifier: Apache-2.0
// Makes the frames of a drive.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "drive/drive.hpp"

namespace gnosphere::drive {

struct RunOptions {
  std::filesystem::path out;                       ///< the folder of the data set; if empty, the current one
  uint64_t firstFrame = 0, endFrame = UINT64_MAX;  ///< frames firstFrame..endFrame - 1
  uint64_t shard = 0, shardCount = 1;              ///< frames whose number modulo shardCount is shard
  bool verify = false;                             ///< whether complete files are read and their hashes compared
  SimulatorOptions simulator;                      ///< the drive's accuracy and other options replace its own
  /// Called when a frame is complete, with the number of frames made and that of frames to make. The calls come one
  /// after another from a thread of the run, and not from that of the caller.
  std::function<void(uint64_t done, uint64_t total)> progress;
  /// Called on the caller's thread with the device before the first frame is made, unless there is nothing to make.
  std::function<void(const DeviceInfo&)> started;
  std::function<void()> beforeFrame;  ///< called on the caller's thread before each frame; an exception ends the run
};

struct RunReport {
  uint64_t chosen = 0;                                   ///< frames of the range and shard
  uint64_t kept = 0;                                     ///< of these, the frames that were complete before
  uint64_t scans = 0, points = 0, files = 0, bytes = 0;  ///< made now
  Counters counters;                                     ///< summed over these scans
  std::vector<std::string> broken;  ///< files that needed every frame, had been written and are removed, see run()
  bool finished = false;  ///< whether all frames of the drive are complete, and the files that need all are written
  uint64_t missing = 0, firstMissing = 0;  ///< the frames of the drive that are not complete, and the first of them
  std::string device;                      ///< its name; empty if nothing had to be made
};

/// Returns why a range of frames has none of a drive, such as "the drive has the frames 0 to 9, so 10:20 is none"; an
/// empty text if it has some.
std::string mistakeOfFrames(const Drive& drive, uint64_t first, uint64_t end);

/// Makes the frames that are not complete. In a drive that was finished, files that need every frame and do not have
/// their size, or with `verify` their hash, are removed first, so that they are made again, and with them the frames
/// of which they are made. A frame has the same bytes wherever and whenever it is made. If this throws,
/// complete frames stay, and a later call goes on from there. Throws Error(invalidArgument) for a shard that there is
/// not, for an empty range of frames and for a folder of another drive, and Error(file).
RunReport run(const Drive& drive, const RunOptions& options);

}  // namespace gnosphere::drive

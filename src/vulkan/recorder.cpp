// SPDX-License-Identifier: Apache-2.0
#include "gnosphere/error.hpp"
#include "gnosphere/vulkan.hpp"
#include "pipeline/recording.hpp"

namespace gnosphere::vulkan {
namespace {

constexpr size_t kMostFrames = 16;

}  // namespace

Recorder::Recorder(Simulator& simulator, size_t framesInFlight) : simulator_(simulator) {
  if (framesInFlight == 0 || framesInFlight > kMostFrames)
    throw Error(ErrorCode::invalidArgument, "a recorder has 1 to " + std::to_string(kMostFrames) +
                                                " frames in flight, not " + std::to_string(framesInFlight));
  Recording nothing;
  simulator_.record(nothing);
  frames_ = framesInFlight;
}

std::vector<RecordedScan> Recorder::record(VkCommandBuffer commands, size_t frame,
                                           std::span<const RecordedShot> shots) {
  if (!commands) throw Error(ErrorCode::invalidArgument, "record() needs a command buffer");
  if (frame >= frames_)
    throw Error(ErrorCode::invalidArgument, "there is no frame in flight " + std::to_string(frame) +
                                                "; the recorder has " + std::to_string(frames_));
  Recording recording;
  recording.commands = commands;
  recording.frame = frame;
  for (const RecordedShot& shot : shots)
    recording.scans.push_back(
        {&shot.shot, {shot.records.address, shot.records.bytes}, {shot.header.address, shot.header.bytes}});
  simulator_.record(recording);
  std::vector<RecordedScan> results;
  for (const Recording::Result& result : recording.results)
    results.push_back({result.sensor, result.frame, result.complete});
  return results;
}

}  // namespace gnosphere::vulkan

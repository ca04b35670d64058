// SPDX-License-Identifier: Apache-2.0
#include "base/limits.hpp"
#include "geometry/transform_sources.hpp"
#include "geometry/vertex_sources.hpp"
#include "gnosphere/vulkan.hpp"
#include "pipeline/recording.hpp"

namespace gnosphere::vulkan {
namespace {

/// A format of vertices: how a device reads it, and the number by which its integers are divided.
struct Format {
  VkFormat three, four;  // with three and with four components
  uint32_t format;
  double divisor;
};
constexpr Format kFormats[] = {{VK_FORMAT_R32G32B32_SFLOAT, VK_FORMAT_R32G32B32A32_SFLOAT, gpu::kVertexF32, 1},
                               {VK_FORMAT_R16G16B16_UNORM, VK_FORMAT_R16G16B16A16_UNORM, gpu::kVertexU16, 65535},
                               {VK_FORMAT_R16G16B16_SNORM, VK_FORMAT_R16G16B16A16_SNORM, gpu::kVertexSnorm16, 32767},
                               {VK_FORMAT_R16G16B16_USCALED, VK_FORMAT_R16G16B16A16_USCALED, gpu::kVertexU16, 1},
                               {VK_FORMAT_R16G16B16_SSCALED, VK_FORMAT_R16G16B16A16_SSCALED, gpu::kVertexS16, 1}};

}  // namespace

Recorder::Recorder(Simulator& simulator, size_t framesInFlight) : simulator_(simulator) {
  if (framesInFlight == 0 || framesInFlight > limits::kFrames.most)
    throw Error(ErrorCode::invalidArgument, "a recorder has 1 to " + std::to_string(limits::kFrames.most) +
                                                " frames in flight, not " + std::to_string(framesInFlight));
  only_ = simulator_.lendToRecorder();
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
  std::vector<RecordedScan> results;
  recording.makeRoom = [&](size_t count) { results.reserve(count); };
  simulator_.record(recording);
  for (const Recording::Result& result : recording.results)
    results.push_back(
        {result.sensor, result.frame, result.complete, result.nonFinite, result.degenerate, result.unplaced});
  return results;
}

void Recorder::abandon(size_t frame) {
  simulator_.abandon(frame);
}

void Recorder::setVertices(size_t mesh, const VertexBuffer& vertices) {
  for (const Format& known : kFormats) {
    if (vertices.format != known.three && vertices.format != known.four) continue;
    CallerVertices buffer = {vertices.address, vertices.bytes, vertices.stride, known.format};
    for (int axis = 0; axis < 3; ++axis) buffer.scale[axis] = static_cast<float>(vertices.scale[axis] / known.divisor);
    buffer.offset = vertices.offset;
    return simulator_.setVertices(mesh, buffer);
  }
  throw Error(ErrorCode::invalidArgument, "mesh " + std::to_string(mesh) + ": positions cannot have the VkFormat " +
                                              std::to_string(vertices.format) +
                                              "; see vulkan::VertexBuffer for those that they can have");
}

void Recorder::setTransforms(const TransformBuffer& transforms) {
  simulator_.setTransforms({transforms.address, transforms.bytes, transforms.stride,
                            transforms.format == TransformFormat::columns4x4, transforms.origin,
                            transforms.firstInstance, transforms.instances});
}

}  // namespace gnosphere::vulkan

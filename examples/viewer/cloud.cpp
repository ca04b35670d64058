// SPDX-License-Identifier: Apache-2.0
#include "cloud.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <cstring>

#include "cloud_fragment.spv.h"
#include "cloud_vertex.spv.h"

namespace viewer {
namespace {

using gnosphere::Field;

// A row of the records is a vertex.
struct Vertex {
  float position[3];  // metres, in the sensor's frame
  float range, intensity;
  uint32_t instance;
};
constexpr VkVertexInputAttributeDescription kAttributes[] = {
    {0, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(Vertex, position)},
    {1, 0, VK_FORMAT_R32_SFLOAT, offsetof(Vertex, range)},
    {2, 0, VK_FORMAT_R32_SFLOAT, offsetof(Vertex, intensity)},
    {3, 0, VK_FORMAT_R32_UINT, offsetof(Vertex, instance)}};

struct Constants {
  glm::mat4 toClip;
  Colouring colouring;
  float farRange = 40;  // metres; the last colour of the ranges
  float size;           // pixels
  float near = static_cast<float>(Camera::kNear);
};

constexpr VkBufferUsageFlags kWritten = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT;

gnosphere::SensorRequest requestOf(const gnosphere::Sensor& sensor) {
  gnosphere::SensorRequest request(sensor);
  request.layout = gnosphere::layoutOf({Field::x, Field::y, Field::z, Field::range, Field::intensity, Field::instance});
  request.layout.compact = true;
  return request;
}

gnosphere::SimulatorOptions optionsOf(const Device& on) {
  gnosphere::SimulatorOptions options;
  options.device = gnosphere::vulkan::adopt(on.adopted());
  options.warn = [](const std::string& message) { std::fprintf(stderr, "viewer: %s\n", message.c_str()); };
  return options;
}

}  // namespace

Cloud::Cloud(const Device& on, VkRenderPass pass, const gnosphere::Scene& scene, const gnosphere::Sensor& sensor)
    : on_(on),
      request_(requestOf(sensor)),
      simulator_(scene, request_, optionsOf(on)),
      recorder_(simulator_, kFramesInFlight),
      records_(on, request_.layout.bytesFor(sensor.beamCount() * sensor.maxReturns),
               kWritten | VK_BUFFER_USAGE_VERTEX_BUFFER_BIT, Buffer::Memory::device),
      header_(on, sizeof(gnosphere::RecordHeader), kWritten | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT,
              Buffer::Memory::host),
      pipeline_(on, pass,
                {cloud_vertex, cloud_fragment, VK_PRIMITIVE_TOPOLOGY_POINT_LIST, sizeof(Vertex), kAttributes,
                 sizeof(Constants)}) {}

// The simulator may be destroyed only when none of its commands is running.
Cloud::~Cloud() {
  vkDeviceWaitIdle(on_.device);
}

void Cloud::scan(const Frames::Frame& frame, const gnosphere::Pose& pose, uint64_t number) {
  pose_ = pose;
  gnosphere::vulkan::RecordedShot shot;
  shot.shot.pose = pose;
  shot.shot.frame = number;
  shot.records = records_.range();
  shot.header = header_.range();
  for (const gnosphere::vulkan::RecordedScan& scan : recorder_.record(frame.commands, frame.number, {&shot, 1}))
    if (!scan.complete)
      std::fprintf(stderr, "viewer: scan %llu lacked room in a list, which has grown\n",
                   static_cast<unsigned long long>(scan.frame));
}

void Cloud::draw(VkCommandBuffer commands, const glm::dmat4& toClip, Colouring colouring, float size) const {
  if (colouring == Colouring::none) return;
  pipeline_.bind(commands, records_);
  Constants constants;
  constants.toClip = glm::mat4(toClip * matrixOf(pose_));
  constants.colouring = colouring;
  constants.size = std::min(size, on_.largestPoint);
  pipeline_.push(commands, constants);
  vkCmdDrawIndirect(commands, header_.buffer, 0, 1, sizeof(VkDrawIndirectCommand));
}

gnosphere::RecordHeader Cloud::header() const {
  gnosphere::RecordHeader result;
  std::memcpy(&result, header_.mapped, sizeof result);
  return result;
}

}  // namespace viewer

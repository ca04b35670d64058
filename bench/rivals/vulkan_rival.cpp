// SPDX-License-Identifier: Apache-2.0
#include "rivals/vulkan_rival.hpp"

#include <algorithm>

#include "base/clock.hpp"

namespace gnosphere::bench {
namespace {

bool sameBeams(const Sensor& a, const Sensor& b) {
  const auto same = [](const Channel& x, const Channel& y) {
    return x.elevationDeg == y.elevationDeg && x.azimuthOffsetDeg == y.azimuthOffsetDeg;
  };
  return a.name == b.name && a.beamCount() == b.beamCount() && a.columns == b.columns &&
         std::equal(a.channels.begin(), a.channels.end(), b.channels.begin(), b.channels.end(), same);
}

}  // namespace

VulkanRival::VulkanRival(const Scene& scene, const Vec3& origin, const VulkanOptions& options, const char* extension,
                         VkShaderStageFlagBits stage)
    : device_(options, extension),
      stage_(stage),
      origin_(origin),
      motion_(options.motion),
      structure_(device_, scene, origin, options.motion) {
  makeLayout();
  makeSet();
}

VulkanRival::~VulkanRival() {
  vkDestroyDescriptorPool(device_.handle(), pool_, nullptr);
  vkDestroyPipelineLayout(device_.handle(), layout_, nullptr);
  vkDestroyDescriptorSetLayout(device_.handle(), setLayout_, nullptr);
}

void VulkanRival::makeLayout() {
  const VkDescriptorSetLayoutBinding binding = {0, VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR, 1,
                                                static_cast<VkShaderStageFlags>(stage_), nullptr};
  VkDescriptorSetLayoutCreateInfo set = {VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
  set.bindingCount = 1;
  set.pBindings = &binding;
  VK(vkCreateDescriptorSetLayout(device_.handle(), &set, nullptr, &setLayout_));
  const VkPushConstantRange constants = {static_cast<VkShaderStageFlags>(stage_), 0, sizeof(Rays)};
  VkPipelineLayoutCreateInfo layout = {VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
  layout.setLayoutCount = 1;
  layout.pSetLayouts = &setLayout_;
  layout.pushConstantRangeCount = 1;
  layout.pPushConstantRanges = &constants;
  VK(vkCreatePipelineLayout(device_.handle(), &layout, nullptr, &layout_));
}

void VulkanRival::makeSet() {
  const VkDescriptorPoolSize size = {VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR, 1};
  VkDescriptorPoolCreateInfo pool = {VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
  pool.maxSets = 1;
  pool.poolSizeCount = 1;
  pool.pPoolSizes = &size;
  VK(vkCreateDescriptorPool(device_.handle(), &pool, nullptr, &pool_));
  VkDescriptorSetAllocateInfo allocate = {VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO};
  allocate.descriptorPool = pool_;
  allocate.descriptorSetCount = 1;
  allocate.pSetLayouts = &setLayout_;
  VK(vkAllocateDescriptorSets(device_.handle(), &allocate, &set_));
  const VkAccelerationStructureKHR top = structure_.top();
  VkWriteDescriptorSetAccelerationStructureKHR structure = {
      VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET_ACCELERATION_STRUCTURE_KHR};
  structure.accelerationStructureCount = 1;
  structure.pAccelerationStructures = &top;
  VkWriteDescriptorSet write = {VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET, &structure};
  write.dstSet = set_;
  write.descriptorCount = 1;
  write.descriptorType = VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR;
  vkUpdateDescriptorSets(device_.handle(), 1, &write, 0, nullptr);
}

VkShaderModule VulkanRival::makeShader(std::span<const uint32_t> spirv) const {
  VkShaderModuleCreateInfo create = {VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
  create.codeSize = spirv.size_bytes();
  create.pCode = spirv.data();
  VkShaderModule shader;
  VK(vkCreateShaderModule(device_.handle(), &create, nullptr, &shader));
  return shader;
}

double VulkanRival::build() {
  const Clock::time_point start = Clock::now();
  deviceMs_ = device_.run([&](VkCommandBuffer commands) {
    structure_.recordMeshes(commands);
    structure_.recordTop(commands);
  });
  const double wallMs = millisecondsSince(start);
  device_.throwOnMessages();
  return wallMs;
}

double VulkanRival::update(std::span<const Moved> moved) {
  const Clock::time_point start = Clock::now();
  structure_.move(moved);
  deviceMs_ = device_.run([&](VkCommandBuffer commands) {
    if (motion_ == Motion::everything) structure_.recordRefit(commands);
    structure_.recordTop(commands);
  });
  const double wallMs = millisecondsSince(start);
  device_.throwOnMessages();
  return wallMs;
}

void VulkanRival::prepare(const Sensor& sensor) {
  const bool same = sameBeams(sensor, sensor_) && hits_.handle();
  sensor_ = sensor;
  if (same) return;
  const size_t beams = sensor.beamCount();
  std::vector<float>& directions = directionsOnHost_;
  directions.clear();
  directions.reserve(3 * beams);
  for (size_t beam = 0; beam < beams; ++beam) {
    const Vec3 d = sensor.direction(beam);
    for (double value : {d.x, d.y, d.z}) directions.push_back(static_cast<float>(value));
  }
  const uint64_t bytes = directions.size() * sizeof(float);
  directions_ = RayBuffer(device_, "directions", bytes, MemoryKind::device);
  device_.write({&directions_, 0, bytes}, directions.data(), bytes);
  hits_ = RayBuffer(device_, "hits", 3 * sizeof(uint32_t) * beams, MemoryKind::device);
  readback_ = hits_.mapped() ? RayBuffer() : RayBuffer(device_, "read-back", hits_.bytes(), MemoryKind::readback);
}

Rays VulkanRival::raysOf(const Pose& pose) const {
  const auto [x, y, z, w] = pose.orientation;
  const double rows[3][4] = {
      {1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y), pose.position.x - origin_.x},
      {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x), pose.position.y - origin_.y},
      {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y), pose.position.z - origin_.z}};
  Rays rays = {};
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column) rays.toScene[row][column] = static_cast<float>(rows[row][column]);
  rays.directions = directions_.address();
  rays.placements = structure_.placements();
  rays.hits = hits_.address();
  rays.rangeMin = static_cast<float>(sensor_.rangeMin);
  rays.rangeMax = static_cast<float>(sensor_.rangeMax);
  rays.columns = sensor_.width();
  rays.channels = sensor_.height();
  return rays;
}

double VulkanRival::trace(const Sensor& sensor, const Pose& pose, Hits& hits) {
  prepare(sensor);
  const Clock::time_point start = Clock::now();
  const Rays rays = raysOf(pose);
  const bool direct = hits_.mapped() != nullptr;
  deviceMs_ = device_.run(
      [&](VkCommandBuffer commands) {
        const VkPipelineBindPoint point = stage_ == VK_SHADER_STAGE_COMPUTE_BIT
                                              ? VK_PIPELINE_BIND_POINT_COMPUTE
                                              : VK_PIPELINE_BIND_POINT_RAY_TRACING_KHR;
        vkCmdBindDescriptorSets(commands, point, layout_, 0, 1, &set_, 0, nullptr);
        vkCmdPushConstants(commands, layout_, static_cast<VkShaderStageFlags>(stage_), 0, sizeof rays, &rays);
        if (sensor.beamCount() > 0) recordRays(commands, rays.columns, rays.channels);
      },
      [&](VkCommandBuffer commands) {
        const VkBufferCopy copy = {0, 0, hits_.bytes()};
        if (!direct) vkCmdCopyBuffer(commands, hits_.handle(), readback_.handle(), 1, &copy);
      });
  const size_t beams = sensor.beamCount();
  const void* words = direct ? hits_.mapped() : readback_.mapped();
  const auto* ranges = static_cast<const float*>(words);
  const auto* ids = static_cast<const uint32_t*>(words);
  hits.resize(beams);
  for (size_t i = 0; i < 3 * beams; ++i) hits.points[i] = directionsOnHost_[i] * ranges[i / 3];
  std::copy_n(ranges, beams, hits.ranges.begin());
  std::copy_n(ids + beams, beams, hits.triangles.begin());
  std::copy_n(ids + 2 * beams, beams, hits.instances.begin());
  const double wallMs = millisecondsSince(start);
  device_.throwOnMessages();
  return wallMs;
}

std::unique_ptr<Rival> makeVulkan(const Scene& scene, const Vec3& origin, VulkanWay way, const VulkanOptions& options) {
  return way == VulkanWay::rayQuery ? makeRayQuery(scene, origin, options)
                                    : makeRayTracingPipeline(scene, origin, options);
}

}  // namespace gnosphere::bench

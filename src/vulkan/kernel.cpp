// SPDX-License-Identifier: Apache-2.0
#include "vulkan/kernel.hpp"

namespace gnosphere::vulkan {

Layout::Layout(const Device& device, VkPipelineCache cache, uint32_t maxSets, bool effects)
    : device_(device),
      cache_(cache),
      bindingCounts_{effects ? gpu::kWorkBindingCountEffects : gpu::kWorkBindingCount,
                     effects ? gpu::kSceneBindingCountEffects : gpu::kSceneBindingCount} {
  const VolkDeviceTable& vk = device.vk();
  for (int set = 0; set < 2; ++set) {
    std::vector<VkDescriptorSetLayoutBinding> bindings(bindingCounts_[set]);
    for (uint32_t i = 0; i < bindingCounts_[set]; ++i)
      bindings[i] = {i, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr};
    VkDescriptorSetLayoutCreateInfo create = {VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
    create.bindingCount = bindingCounts_[set];
    create.pBindings = bindings.data();
    setLayouts_[set] = device.make(vk.vkCreateDescriptorSetLayout, vk.vkDestroyDescriptorSetLayout, create);
  }
  const VkPushConstantRange constants = {VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(gpu::Pass)};
  VkPipelineLayoutCreateInfo layout = {VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
  const VkDescriptorSetLayout setLayouts[] = {setLayouts_[0].get(), setLayouts_[1].get()};
  layout.setLayoutCount = 2;
  layout.pSetLayouts = setLayouts;
  layout.pushConstantRangeCount = 1;
  layout.pPushConstantRanges = &constants;
  pipelineLayout_ = device.make(vk.vkCreatePipelineLayout, vk.vkDestroyPipelineLayout, layout);
  const VkDescriptorPoolSize size = {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
                                     maxSets * (bindingCounts_[0] + bindingCounts_[1])};
  VkDescriptorPoolCreateInfo pool = {VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
  pool.maxSets = maxSets;
  pool.poolSizeCount = 1;
  pool.pPoolSizes = &size;
  pool_ = device.make(vk.vkCreateDescriptorPool, vk.vkDestroyDescriptorPool, pool);
}

VkDescriptorSet Layout::makeSet(uint32_t set) {
  VkDescriptorSetAllocateInfo allocate = {VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO};
  const VkDescriptorSetLayout layout = setLayouts_[set].get();
  allocate.descriptorPool = pool_.get();
  allocate.descriptorSetCount = 1;
  allocate.pSetLayouts = &layout;
  VkDescriptorSet handle;
  VK(device_.vk().vkAllocateDescriptorSets(device_.handle(), &allocate, &handle));
  return handle;
}

void Layout::updateSet(VkDescriptorSet handle, std::span<const Buffer* const> buffers) {
  std::vector<VkDescriptorBufferInfo> infos(buffers.size());
  std::vector<VkWriteDescriptorSet> writes(buffers.size());
  for (uint32_t i = 0; i < buffers.size(); ++i) {
    infos[i] = {buffers[i]->handle(), 0, VK_WHOLE_SIZE};
    writes[i] = {VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
    writes[i].dstSet = handle;
    writes[i].dstBinding = i;
    writes[i].descriptorCount = 1;
    writes[i].descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
    writes[i].pBufferInfo = &infos[i];
  }
  device_.vk().vkUpdateDescriptorSets(device_.handle(), static_cast<uint32_t>(writes.size()), writes.data(), 0,
                                      nullptr);
}

std::array<uint32_t, 12> constantsOf(const Options& options, uint32_t pass) {
  return {/* BOUNDS= */ options.bounds,
          /* CULL= */ options.cull,
          /* INSIDE= */ options.inside,
          /* RANGE= */ options.range,
          /* AZIMUTH_OFFSETS= */ options.azimuthOffsets ? VK_TRUE : VK_FALSE,
          /* FACES= */ options.faces,
          /* PASS= */ pass,
          /* CULLING= */ options.culling,
          /* EFFECTS= */ options.effects,
          /* FIELDS= */ options.fields,
          /* LAYERS= */ options.layers,
          /* RETURNS= */ options.returns};
}

Kernel::Kernel(const Device& device, const Layout& layout, const char* name, std::span<const uint32_t> spirv,
               const Options& options, uint32_t pass)
    : name_(name), constants_(constantsOf(options, pass)) {
  VkShaderModuleCreateInfo module = {VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
  module.codeSize = spirv.size_bytes();
  module.pCode = spirv.data();
  const VolkDeviceTable& vk = device.vk();
  const DeviceHandle<VkShaderModule> shader = device.make(vk.vkCreateShaderModule, vk.vkDestroyShaderModule, module);
  std::array<VkSpecializationMapEntry, std::tuple_size_v<decltype(constants_)>> entries;
  for (uint32_t i = 0; i < entries.size(); ++i) entries[i] = {i + 1, i * 4, 4};
  const VkSpecializationInfo specialization = {static_cast<uint32_t>(entries.size()), entries.data(), sizeof constants_,
                                               constants_.data()};
  VkComputePipelineCreateInfo create = {VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
  create.stage = {VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO};
  create.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
  create.stage.module = shader.get();
  create.stage.pName = "main";
  create.stage.pSpecializationInfo = &specialization;
  const FullSubgroups& subgroups = device.capabilities().subgroups;
  VkPipelineShaderStageRequiredSubgroupSizeCreateInfoEXT size = {
      VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_REQUIRED_SUBGROUP_SIZE_CREATE_INFO_EXT};
  size.requiredSubgroupSize = subgroups.size;
  create.stage.flags = VK_PIPELINE_SHADER_STAGE_CREATE_REQUIRE_FULL_SUBGROUPS_BIT_EXT;
  if (subgroups.required) create.stage.pNext = &size;
  create.layout = layout.handle();
  VkPipeline pipeline = VK_NULL_HANDLE;
  VK(vk.vkCreateComputePipelines(device.handle(), layout.cache(), 1, &create, nullptr, &pipeline));
  pipeline_ = {pipeline, vk.vkDestroyPipeline, device.handle()};
}

}  // namespace gnosphere::vulkan

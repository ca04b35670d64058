// SPDX-License-Identifier: Apache-2.0
#include "vulkan/kernel.hpp"

namespace gnosphere::vulkan {

Layout::Layout(const Device& device, VkPipelineCache cache, uint32_t maxSets, bool effects)
    : device_(device),
      cache_(cache),
      bindingCounts_{effects ? gpu::kWorkBindingCountEffects : gpu::kWorkBindingCount,
                     effects ? gpu::kSceneBindingCountEffects : gpu::kSceneBindingCount} {
  for (int set = 0; set < 2; ++set) {
    std::vector<VkDescriptorSetLayoutBinding> bindings(bindingCounts_[set]);
    for (uint32_t i = 0; i < bindingCounts_[set]; ++i)
      bindings[i] = {i, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr};
    VkDescriptorSetLayoutCreateInfo create = {VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
    create.bindingCount = bindingCounts_[set];
    create.pBindings = bindings.data();
    VK(vkCreateDescriptorSetLayout(device_.handle(), &create, nullptr, &setLayouts_[set]));
  }
  const VkPushConstantRange constants = {VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(gpu::Pass)};
  VkPipelineLayoutCreateInfo layout = {VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
  layout.setLayoutCount = 2;
  layout.pSetLayouts = setLayouts_;
  layout.pushConstantRangeCount = 1;
  layout.pPushConstantRanges = &constants;
  VK(vkCreatePipelineLayout(device_.handle(), &layout, nullptr, &pipelineLayout_));
  const VkDescriptorPoolSize size = {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
                                     maxSets * (bindingCounts_[0] + bindingCounts_[1])};
  VkDescriptorPoolCreateInfo pool = {VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
  pool.maxSets = maxSets;
  pool.poolSizeCount = 1;
  pool.pPoolSizes = &size;
  VK(vkCreateDescriptorPool(device_.handle(), &pool, nullptr, &pool_));
}

Layout::~Layout() {
  vkDestroyDescriptorPool(device_.handle(), pool_, nullptr);
  vkDestroyPipelineLayout(device_.handle(), pipelineLayout_, nullptr);
  for (VkDescriptorSetLayout layout : setLayouts_) vkDestroyDescriptorSetLayout(device_.handle(), layout, nullptr);
}

VkDescriptorSet Layout::makeSet(uint32_t set) {
  VkDescriptorSetAllocateInfo allocate = {VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO};
  allocate.descriptorPool = pool_;
  allocate.descriptorSetCount = 1;
  allocate.pSetLayouts = &setLayouts_[set];
  VkDescriptorSet handle;
  VK(vkAllocateDescriptorSets(device_.handle(), &allocate, &handle));
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
  vkUpdateDescriptorSets(device_.handle(), static_cast<uint32_t>(writes.size()), writes.data(), 0, nullptr);
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
    : device_(device.handle()), name_(name), constants_(constantsOf(options, pass)) {
  VkShaderModuleCreateInfo module = {VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
  module.codeSize = spirv.size_bytes();
  module.pCode = spirv.data();
  VkShaderModule shader;
  VK(vkCreateShaderModule(device_, &module, nullptr, &shader));
  std::array<VkSpecializationMapEntry, std::tuple_size_v<decltype(constants_)>> entries;
  for (uint32_t i = 0; i < entries.size(); ++i) entries[i] = {i + 1, i * 4, 4};
  const VkSpecializationInfo specialization = {static_cast<uint32_t>(entries.size()), entries.data(), sizeof constants_,
                                               constants_.data()};
  VkComputePipelineCreateInfo create = {VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
  create.stage = {VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO};
  create.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
  create.stage.module = shader;
  create.stage.pName = "main";
  create.stage.pSpecializationInfo = &specialization;
  create.layout = layout.handle();
  const VkResult result = vkCreateComputePipelines(device_, layout.cache(), 1, &create, nullptr, &pipeline_);
  vkDestroyShaderModule(device_, shader, nullptr);
  VK(result);
}

Kernel::~Kernel() {
  if (pipeline_) vkDestroyPipeline(device_, pipeline_, nullptr);
}

}  // namespace gnosphere::vulkan

// SPDX-License-Identifier: Apache-2.0
// An application with a Vulkan device of its own lets GnoSphere record a scan into its command buffer, and a compute
// shader of its own reads the points in the same submission: it counts them in the cells of a map. The host sees only
// the map.
#include <vulkan/vulkan.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <exception>
#include <gnosphere/gnosphere.hpp>
#include <gnosphere/vulkan.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "occupancy.spv.h"

namespace {

constexpr uint32_t kWidth = 48;    // cells of the map
constexpr float kCellSize = 0.5f;  // metres
constexpr int kScans = 3;

void require(VkResult result, const char* what) {
  if (result != VK_SUCCESS) throw std::runtime_error(std::string(what) + " failed: " + std::to_string(result));
}

// A Vulkan device with what GnoSphere needs, and whatever else the application wants.
struct Device {
  VkInstance instance = VK_NULL_HANDLE;
  VkPhysicalDevice physical = VK_NULL_HANDLE;
  VkDevice device = VK_NULL_HANDLE;
  VkQueue queue = VK_NULL_HANDLE;
  uint32_t family = 0;
  gnosphere::vulkan::Requirements requirements;

  Device() {
    VkApplicationInfo application = {};
    application.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO;
    application.pApplicationName = "occupancy";
    application.apiVersion = VK_API_VERSION_1_2;
    VkInstanceCreateInfo create = {VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
    create.pApplicationInfo = &application;
    require(vkCreateInstance(&create, nullptr, &instance), "vkCreateInstance");
    choosePhysical();
    createDevice();
  }

  void choosePhysical() {
    uint32_t count = 0;
    vkEnumeratePhysicalDevices(instance, &count, nullptr);
    std::vector<VkPhysicalDevice> all(count);
    vkEnumeratePhysicalDevices(instance, &count, all.data());
    for (VkPhysicalDevice each : all) {
      requirements = gnosphere::vulkan::requirementsOf(vkGetInstanceProcAddr, instance, each);
      if (requirements.missing.empty()) {
        physical = each;
        return;
      }
      for (const std::string& sentence : requirements.missing) std::fprintf(stderr, "%s\n", sentence.c_str());
    }
    throw std::runtime_error("there is no suitable Vulkan device");
  }

  void createDevice() {
    uint32_t count = 0;
    vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, nullptr);
    std::vector<VkQueueFamilyProperties> families(count);
    vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, families.data());
    while (family < count && !(families[family].queueFlags & VK_QUEUE_COMPUTE_BIT)) ++family;
    const float priority = 1;
    VkDeviceQueueCreateInfo queues = {VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO};
    queues.queueFamilyIndex = family;
    queues.queueCount = 1;
    queues.pQueuePriorities = &priority;
    VkPhysicalDeviceSubgroupSizeControlFeaturesEXT sizes = {
        VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_SIZE_CONTROL_FEATURES_EXT};
    VkPhysicalDeviceVulkan12Features features12 = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES, &sizes};
    VkPhysicalDeviceFeatures2 features = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, &features12, {}};
    requirements.addTo(&features.features, &features12, &sizes);
    VkDeviceCreateInfo create = {VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, &features};
    create.queueCreateInfoCount = 1;
    create.pQueueCreateInfos = &queues;
    create.enabledExtensionCount = static_cast<uint32_t>(requirements.extensions.size());
    create.ppEnabledExtensionNames = requirements.extensions.data();
    require(vkCreateDevice(physical, &create, nullptr, &device), "vkCreateDevice");
    vkGetDeviceQueue(device, family, 0, &queue);
  }
};

// A buffer in memory that the host sees, too.
struct Buffer {
  VkBuffer buffer = VK_NULL_HANDLE;
  VkDeviceMemory memory = VK_NULL_HANDLE;
  VkDeviceAddress address = 0;
  VkDeviceSize bytes = 0;
  void* mapped = nullptr;

  Buffer(const Device& on, VkDeviceSize size) : bytes(size) {
    VkBufferCreateInfo create = {VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
    create.size = size;
    create.usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT |
                   VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    require(vkCreateBuffer(on.device, &create, nullptr, &buffer), "vkCreateBuffer");
    VkMemoryRequirements needs;
    vkGetBufferMemoryRequirements(on.device, buffer, &needs);
    VkPhysicalDeviceMemoryProperties types;
    vkGetPhysicalDeviceMemoryProperties(on.physical, &types);
    constexpr VkMemoryPropertyFlags kHost = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    VkMemoryAllocateFlagsInfo flags = {VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO};
    flags.flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT;
    VkMemoryAllocateInfo allocate = {VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, &flags, needs.size};
    while (!(needs.memoryTypeBits >> allocate.memoryTypeIndex & 1) ||
           (types.memoryTypes[allocate.memoryTypeIndex].propertyFlags & kHost) != kHost)
      ++allocate.memoryTypeIndex;
    require(vkAllocateMemory(on.device, &allocate, nullptr, &memory), "vkAllocateMemory");
    require(vkBindBufferMemory(on.device, buffer, memory, 0), "vkBindBufferMemory");
    require(vkMapMemory(on.device, memory, 0, VK_WHOLE_SIZE, 0, &mapped), "vkMapMemory");
    VkBufferDeviceAddressInfo where = {VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO, nullptr, buffer};
    address = vkGetBufferDeviceAddress(on.device, &where);
  }

  gnosphere::vulkan::DeviceRange range() const { return {address, bytes}; }
};

// The application's own compute shader.
struct Occupancy {
  struct Constants {
    VkDeviceAddress points, header, cells;
    uint32_t width = kWidth;
    float cellSize = kCellSize;
  };
  VkPipelineLayout layout = VK_NULL_HANDLE;
  VkPipeline pipeline = VK_NULL_HANDLE;

  explicit Occupancy(const Device& on) {
    VkShaderModuleCreateInfo code = {VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO, nullptr, 0, sizeof occupancy,
                                     occupancy};
    VkShaderModule shader;
    require(vkCreateShaderModule(on.device, &code, nullptr, &shader), "vkCreateShaderModule");
    const VkPushConstantRange constants = {VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(Constants)};
    VkPipelineLayoutCreateInfo layouts = {VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
    layouts.pushConstantRangeCount = 1;
    layouts.pPushConstantRanges = &constants;
    require(vkCreatePipelineLayout(on.device, &layouts, nullptr, &layout), "vkCreatePipelineLayout");
    VkComputePipelineCreateInfo create = {VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
    create.stage = {VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO};
    create.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
    create.stage.module = shader;
    create.stage.pName = "main";
    create.layout = layout;
    require(vkCreateComputePipelines(on.device, VK_NULL_HANDLE, 1, &create, nullptr, &pipeline), "the pipeline");
    vkDestroyShaderModule(on.device, shader, nullptr);
  }

  void record(VkCommandBuffer commands, const Constants& constants) const {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
    vkCmdPushConstants(commands, layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof constants, &constants);
    vkCmdDispatch(commands, 64, 1, 1);
    VkMemoryBarrier toHost = {VK_STRUCTURE_TYPE_MEMORY_BARRIER, nullptr, VK_ACCESS_SHADER_WRITE_BIT,
                              VK_ACCESS_HOST_READ_BIT};
    vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &toHost, 0,
                         nullptr, 0, nullptr);
  }
};

// Four walls around the sensor and a pillar, which is instance 1.
gnosphere::Scene courtyard() {
  const auto wall = [](gnosphere::Mesh& mesh, float x0, float y0, float x1, float y1) {
    const auto first = static_cast<uint32_t>(mesh.vertexCount());
    for (const float z : {-2.0f, 4.0f}) mesh.positions.insert(mesh.positions.end(), {x0, y0, z, x1, y1, z});
    for (const uint32_t corner : {0u, 1u, 2u, 2u, 1u, 3u}) mesh.indices.push_back(first + corner);
  };
  const auto box = [&](float reach) {
    gnosphere::Mesh mesh;
    wall(mesh, -reach, -reach, reach, -reach);
    wall(mesh, reach, -reach, reach, reach);
    wall(mesh, reach, reach, -reach, reach);
    wall(mesh, -reach, reach, -reach, -reach);
    mesh.parts = {{0, static_cast<uint32_t>(mesh.triangleCount()), 0}};
    return mesh;
  };
  gnosphere::Scene scene;
  scene.materials.resize(1);
  scene.materials[0].doubleSided = true;
  scene.meshes = {box(10), box(1)};
  scene.instances = {{"walls", 0, {}}, {"pillar", 1, {}}};
  return scene;
}

void run() {
  const Device device;
  const Occupancy occupancyMap(device);

  // The library works on this device from now on; it submits nothing and waits for nothing.
  gnosphere::vulkan::AdoptedDevice adopted;
  adopted.getInstanceProcAddr = vkGetInstanceProcAddr;
  adopted.instance = device.instance;
  adopted.physicalDevice = device.physical;
  adopted.device = device.device;
  adopted.queueFamily = device.family;
  adopted.enabled = device.requirements;
  gnosphere::SimulatorOptions options;
  options.device = gnosphere::vulkan::adopt(adopted);
  gnosphere::SensorRequest request(gnosphere::builtinSensor("VLP-16"));
  request.layout = gnosphere::layoutOf({gnosphere::Field::x, gnosphere::Field::y, gnosphere::Field::z});
  request.layout.compact = true;
  gnosphere::Simulator simulator(courtyard(), request, options);
  gnosphere::vulkan::Recorder recorder(simulator, 1);

  const Buffer points(device, request.layout.bytesFor(request.sensor.beamCount()));
  const Buffer header(device, sizeof(gnosphere::RecordHeader));
  const Buffer cells(device, kWidth * kWidth * sizeof(uint32_t));
  VkCommandPoolCreateInfo pools = {VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
  pools.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
  pools.queueFamilyIndex = device.family;
  VkCommandPool pool;
  require(vkCreateCommandPool(device.device, &pools, nullptr, &pool), "vkCreateCommandPool");
  VkCommandBufferAllocateInfo allocate = {VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
  allocate.commandPool = pool;
  allocate.commandBufferCount = 1;
  VkCommandBuffer commands;
  require(vkAllocateCommandBuffers(device.device, &allocate, &commands), "vkAllocateCommandBuffers");

  for (int scan = 0; scan < kScans; ++scan) {
    gnosphere::Transform place;
    place.rows[3] = 3.0 * scan - 6;
    place.rows[7] = 5;
    simulator.setTransform(1, place);

    VkCommandBufferBeginInfo begin = {VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    require(vkBeginCommandBuffer(commands, &begin), "vkBeginCommandBuffer");
    vkCmdFillBuffer(commands, cells.buffer, 0, VK_WHOLE_SIZE, 0);
    gnosphere::vulkan::RecordedShot shot;
    shot.shot.frame = static_cast<uint64_t>(scan);
    shot.records = points.range();
    shot.header = header.range();
    recorder.record(commands, 0, {&shot, 1});
    occupancyMap.record(commands, {points.address, header.address, cells.address});
    require(vkEndCommandBuffer(commands), "vkEndCommandBuffer");
    VkSubmitInfo submit = {VK_STRUCTURE_TYPE_SUBMIT_INFO};
    submit.commandBufferCount = 1;
    submit.pCommandBuffers = &commands;
    require(vkQueueSubmit(device.queue, 1, &submit, VK_NULL_HANDLE), "vkQueueSubmit");
    require(vkQueueWaitIdle(device.queue), "vkQueueWaitIdle");

    gnosphere::RecordHeader told;
    std::memcpy(&told, header.mapped, sizeof told);
    std::printf("scan %d: %u points%s\n", scan, told.rows, told.incomplete ? ", incomplete: a list grows" : "");
    const auto* counts = static_cast<const uint32_t*>(cells.mapped);
    for (uint32_t y = kWidth; y-- > 0;) {
      for (uint32_t x = 0; x < kWidth; ++x) std::putchar(counts[y * kWidth + x] > 0 ? '#' : '.');
      std::putchar('\n');
    }
  }
}

}  // namespace

int main() {
  try {
    run();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "occupancy: %s\n", error.what());
    return 1;
  }
}

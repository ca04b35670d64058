/* SPDX-License-Identifier: Apache-2.0
 *
 * record SCENE ROWS: an application with a Vulkan device of its own lets GnoSphere record the scan of a VLP-16, 1.8 m
 * above the origin, into its command buffer, and writes the rows that it finds in its buffer to a file: x, y, z, range
 * and instance of every return. */
#include <gnosphere_vulkan.h>
#include <stdio.h>
#include <stdlib.h>
#include <vulkan/vulkan.h>

static void require(int good, const char* what) {
  if (good) return;
  fprintf(stderr, "record: %s failed\n", what);
  exit(1);
}

/* Ends the program with the sentence of a call of GnoSphere that failed. */
static void done(gno_status status) {
  if (status == GNO_OK) return;
  fprintf(stderr, "record: %s\n", gno_last_error());
  exit(1);
}

/* A Vulkan device with what GnoSphere needs, and whatever else the application wants. */
typedef struct app {
  VkInstance instance;
  VkPhysicalDevice physical;
  VkDevice device;
  VkQueue queue;
  uint32_t family;
  gno_vulkan_requirements requirements;
} app;

static void choose_device(app* app) {
  VkPhysicalDevice all[16];
  uint32_t count = 16, i, k;
  require(vkEnumeratePhysicalDevices(app->instance, &count, all) >= 0, "vkEnumeratePhysicalDevices");
  for (i = 0; i < count && !app->physical; ++i) {
    app->requirements = gno_vulkan_requirements_init();
    done(gno_vulkan_get_requirements(vkGetInstanceProcAddr, app->instance, all[i], &app->requirements));
    for (k = 0; k < app->requirements.missing_count; ++k) fprintf(stderr, "%s\n", app->requirements.missing[k]);
    if (app->requirements.missing_count == 0) app->physical = all[i];
  }
  require(app->physical != VK_NULL_HANDLE, "the search for a suitable Vulkan device");
}

static void create_device(app* app) {
  VkApplicationInfo application = {VK_STRUCTURE_TYPE_APPLICATION_INFO};
  VkInstanceCreateInfo instance = {VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
  VkPhysicalDeviceSubgroupSizeControlFeaturesEXT sizes = {
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_SIZE_CONTROL_FEATURES_EXT};
  VkPhysicalDeviceVulkan12Features features12 = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES, &sizes};
  VkPhysicalDeviceFeatures2 features = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, &features12};
  VkQueueFamilyProperties families[16];
  uint32_t count = 16;
  const float priority = 1;
  VkDeviceQueueCreateInfo queue = {VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO};
  VkDeviceCreateInfo device = {VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, &features};
  application.apiVersion = VK_API_VERSION_1_2;
  instance.pApplicationInfo = &application;
  require(vkCreateInstance(&instance, NULL, &app->instance) == VK_SUCCESS, "vkCreateInstance");
  choose_device(app);
  vkGetPhysicalDeviceQueueFamilyProperties(app->physical, &count, families);
  while (app->family < count && !(families[app->family].queueFlags & VK_QUEUE_COMPUTE_BIT)) ++app->family;
  queue.queueFamilyIndex = app->family;
  queue.queueCount = 1;
  queue.pQueuePriorities = &priority;
  done(gno_vulkan_add_features(&app->requirements, &features.features, &features12, &sizes));
  device.queueCreateInfoCount = 1;
  device.pQueueCreateInfos = &queue;
  device.enabledExtensionCount = app->requirements.extension_count;
  device.ppEnabledExtensionNames = app->requirements.extensions;
  require(vkCreateDevice(app->physical, &device, NULL, &app->device) == VK_SUCCESS, "vkCreateDevice");
  vkGetDeviceQueue(app->device, app->family, 0, &app->queue);
}

/* A buffer in memory that the host sees, too. */
typedef struct buffer {
  VkBuffer handle;
  VkDeviceMemory memory;
  gno_vulkan_range range;
  void* mapped;
} buffer;

static buffer make_buffer(const app* app, VkDeviceSize bytes) {
  const VkMemoryPropertyFlags host = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
  VkBufferCreateInfo create = {VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
  VkMemoryAllocateFlagsInfo flags = {VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO};
  VkMemoryAllocateInfo allocate = {VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, &flags};
  VkBufferDeviceAddressInfo where = {VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO};
  VkMemoryRequirements needs;
  VkPhysicalDeviceMemoryProperties types;
  buffer made;
  create.size = bytes;
  create.usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT;
  require(vkCreateBuffer(app->device, &create, NULL, &made.handle) == VK_SUCCESS, "vkCreateBuffer");
  vkGetBufferMemoryRequirements(app->device, made.handle, &needs);
  vkGetPhysicalDeviceMemoryProperties(app->physical, &types);
  flags.flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT;
  allocate.allocationSize = needs.size;
  while (!(needs.memoryTypeBits >> allocate.memoryTypeIndex & 1) ||
         (types.memoryTypes[allocate.memoryTypeIndex].propertyFlags & host) != host)
    ++allocate.memoryTypeIndex;
  require(vkAllocateMemory(app->device, &allocate, NULL, &made.memory) == VK_SUCCESS, "vkAllocateMemory");
  require(vkBindBufferMemory(app->device, made.handle, made.memory, 0) == VK_SUCCESS, "vkBindBufferMemory");
  require(vkMapMemory(app->device, made.memory, 0, VK_WHOLE_SIZE, 0, &made.mapped) == VK_SUCCESS, "vkMapMemory");
  where.buffer = made.handle;
  made.range.address = vkGetBufferDeviceAddress(app->device, &where);
  made.range.bytes = bytes;
  return made;
}

static void destroy_buffer(const app* app, const buffer* buffer) {
  vkDestroyBuffer(app->device, buffer->handle, NULL);
  vkFreeMemory(app->device, buffer->memory, NULL);
}

/* Makes a simulator on the application's device, with one sensor whose results stay there. */
static gno_simulator make_simulator(const app* app, const char* file, gno_layout* layout, size_t* beams) {
  const gno_field fields[] = {GNO_FIELD_X, GNO_FIELD_Y, GNO_FIELD_Z, GNO_FIELD_RANGE, GNO_FIELD_INSTANCE};
  gno_vulkan_adopted_device adopted = gno_vulkan_adopted_device_init();
  gno_options options = gno_options_init();
  gno_request request = gno_request_init();
  gno_sensor_size size = gno_sensor_size_init();
  gno_scene scene;
  gno_effects effects;
  gno_simulator simulator;
  adopted.get_instance_proc_addr = vkGetInstanceProcAddr;
  adopted.instance = app->instance;
  adopted.physical_device = app->physical;
  adopted.device = app->device;
  adopted.queue_family = app->family;
  adopted.enabled = &app->requirements;
  options.adopted = &adopted;
  done(gno_scene_load(file, NULL, &scene));
  done(gno_sensor_builtin("VLP-16", &request.sensor));
  done(gno_sensor_get_size(request.sensor, &size));
  done(gno_effects_preset("clean", &effects));
  done(gno_layout_of(fields, sizeof fields / sizeof fields[0], layout));
  layout->compact = 1;
  request.effects = effects;
  request.layout = layout;
  done(gno_simulator_create(scene, &request, 1, &options, &simulator));
  gno_effects_destroy(effects);
  gno_sensor_destroy(request.sensor);
  gno_scene_destroy(scene);
  *beams = size.beams;
  return simulator;
}

/* Records a scan, submits it as the application would, and waits. */
static void scan(const app* app, gno_vulkan_recorder recorder, VkCommandBuffer commands, const buffer* records,
                 const buffer* header) {
  VkCommandBufferBeginInfo begin = {VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
  VkSubmitInfo submit = {VK_STRUCTURE_TYPE_SUBMIT_INFO};
  gno_shot shot = gno_shot_init();
  gno_vulkan_recorded_shot recorded;
  shot.pose.position[2] = 1.8;
  recorded.shot = &shot;
  recorded.records = records->range;
  recorded.header = header->range;
  require(vkBeginCommandBuffer(commands, &begin) == VK_SUCCESS, "vkBeginCommandBuffer");
  done(gno_vulkan_record(recorder, commands, 0, &recorded, 1, NULL, NULL));
  require(vkEndCommandBuffer(commands) == VK_SUCCESS, "vkEndCommandBuffer");
  submit.commandBufferCount = 1;
  submit.pCommandBuffers = &commands;
  require(vkQueueSubmit(app->queue, 1, &submit, VK_NULL_HANDLE) == VK_SUCCESS, "vkQueueSubmit");
  require(vkQueueWaitIdle(app->queue) == VK_SUCCESS, "vkQueueWaitIdle");
}

int main(int argc, char** argv) {
  app app = {0};
  gno_layout layout = gno_layout_init();
  gno_simulator simulator;
  gno_vulkan_recorder recorder;
  VkCommandPoolCreateInfo pools = {VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
  VkCommandBufferAllocateInfo allocate = {VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
  VkCommandPool pool;
  VkCommandBuffer commands;
  buffer records, header;
  const gno_vulkan_record_header* told;
  size_t beams;
  uint64_t bytes;
  FILE* file;
  if (argc != 3) {
    fprintf(stderr, "usage: record SCENE ROWS\n");
    return 2;
  }
  create_device(&app);
  simulator = make_simulator(&app, argv[1], &layout, &beams);
  done(gno_vulkan_recorder_create(simulator, 1, &recorder));
  done(gno_layout_bytes_for(&layout, beams, &bytes));
  records = make_buffer(&app, bytes);
  header = make_buffer(&app, sizeof(gno_vulkan_record_header));
  pools.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
  pools.queueFamilyIndex = app.family;
  require(vkCreateCommandPool(app.device, &pools, NULL, &pool) == VK_SUCCESS, "vkCreateCommandPool");
  allocate.commandPool = pool;
  allocate.commandBufferCount = 1;
  require(vkAllocateCommandBuffers(app.device, &allocate, &commands) == VK_SUCCESS, "vkAllocateCommandBuffers");

  /* If a list was too small, it has grown by the next scan. */
  told = (const gno_vulkan_record_header*)header.mapped;
  do scan(&app, recorder, commands, &records, &header);
  while (told->incomplete);

  printf("%u of %zu beams hit\n", (unsigned)told->hits, beams);
  file = fopen(argv[2], "wb");
  require(file && fwrite(records.mapped, layout.stride, told->rows, file) == told->rows && fclose(file) == 0,
          "writing the rows");

  done(gno_vulkan_recorder_destroy(recorder));
  done(gno_simulator_destroy(simulator));
  destroy_buffer(&app, &records);
  destroy_buffer(&app, &header);
  vkDestroyCommandPool(app.device, pool, NULL);
  vkDestroyDevice(app.device, NULL);
  vkDestroyInstance(app.instance, NULL);
  return 0;
}

// SPDX-License-Identifier: Apache-2.0
// gno_vulkan: scans on a Vulkan device of the caller.
#include <gnosphere_vulkan.h>

#include <algorithm>
#include <gnosphere/vulkan.hpp>
#include <memory>
#include <mutex>
#include <tuple>
#include <vector>

#include "c/handles.hpp"

namespace gnosphere::c {

namespace {

static_assert(sizeof(gno_record_header) == sizeof(RecordHeader));
GNO_SAME_ENUM(vulkan::TransformFormat, {GNO_VULKAN_TRANSFORM_ROWS_3X4, rows3x4},
              {GNO_VULKAN_TRANSFORM_COLUMNS_4X4, columns4x4});

/// A recorder, which refers to its simulator as long as the handle is that of a live one.
struct RecorderObject {
  gno_simulator simulator;
  vulkan::Recorder recorder;
  std::vector<gno_vulkan_recorded_scan> results;  ///< of the last recording
  size_t mostShots = 0;                           ///< of any recording
};

}  // namespace

GNO_HELD(gno_vulkan_recorder, RecorderObject, "recorder")

namespace {

// Returns the features alone: neither the names of extensions nor the sentences about missing features are needed.
vulkan::Requirements featuresOf(const gno_vulkan_requirements* requirements) {
  const gno_vulkan_requirements& from = sized(requirements, GNO_TYPE(gno_vulkan_requirements));
  vulkan::Requirements result;
  result.features = from.features;
  result.features12 = from.features12;
  result.subgroupSizeControl = from.subgroup_size_control;
  return result;
}

vulkan::Allocator allocatorOf(const gno_vulkan_adopted_device& device) {
  vulkan::Allocator allocator;
  if (device.allocate)
    allocator.allocate = [allocate = device.allocate, user = device.user](const VkMemoryRequirements& requirements,
                                                                          uint32_t memoryType) {
      gno_vulkan_allocation made = {};
      callBack("gno_vulkan_adopted_device::allocate", allocate, &requirements, memoryType, &made, user);
      return vulkan::Allocation{made.memory, made.offset, made.mapped, made.allocation};
    };
  if (device.release)
    allocator.release = [release = device.release, user = device.user](const vulkan::Allocation& from) {
      const gno_vulkan_allocation made = {from.memory, from.offset, from.mapped, from.user};
      release(&made, user);
    };
  return allocator;
}

vulkan::DeviceRange rangeOf(const gno_vulkan_range& range) {
  return {range.address, range.bytes};
}

// The description of a device by a program in C, and the device that was adopted for it.
struct Adopted {
  gno_vulkan_adopted_device given;
  vulkan::Requirements enabled;
  std::weak_ptr<const vulkan::AdoptedDevice> device;
};

bool areEqual(const vulkan::Requirements& a, const vulkan::Requirements& b) {
  // In each structure the features are VkBool32 from the first member to the last one.
  const auto equal = [](const VkBool32* first, const VkBool32* last, const VkBool32* other) {
    return std::equal(first, last + 1, other);
  };
  return equal(&a.features.robustBufferAccess, &a.features.inheritedQueries, &b.features.robustBufferAccess) &&
         equal(&a.features12.samplerMirrorClampToEdge, &a.features12.subgroupBroadcastDynamicId,
               &b.features12.samplerMirrorClampToEdge) &&
         equal(&a.subgroupSizeControl.subgroupSizeControl, &a.subgroupSizeControl.computeFullSubgroups,
               &b.subgroupSizeControl.subgroupSizeControl);
}

bool isSame(const Adopted& known, const gno_vulkan_adopted_device& given, const vulkan::Requirements& enabled) {
  const auto members = [](const gno_vulkan_adopted_device& of) {
    return std::tie(of.get_instance_proc_addr, of.instance, of.physical_device, of.device, of.queue_family,
                    of.uniform_control_flow, of.allocate, of.release, of.user);
  };
  return members(known.given) == members(given) && areEqual(known.enabled, enabled);
}

}  // namespace

// Simulators on the same device of the caller share what is compiled for it, so that device is adopted once.
DeviceChoice deviceOf(const gno_vulkan_adopted_device& given) {
  static std::mutex mutex;
  static auto& known = *new std::vector<Adopted>;
  const gno_vulkan_adopted_device device = sized(&given, GNO_TYPE(gno_vulkan_adopted_device));
  const vulkan::Requirements enabled = featuresOf(device.enabled);
  const std::lock_guard lock(mutex);
  std::erase_if(known, [](const Adopted& one) { return one.device.expired(); });
  for (const Adopted& one : known) {
    DeviceChoice choice;
    if (isSame(one, device, enabled)) choice.adopted = one.device.lock();
    if (choice.adopted) return choice;
  }
  vulkan::AdoptedDevice adopted;
  adopted.getInstanceProcAddr = device.get_instance_proc_addr;
  adopted.instance = device.instance;
  adopted.physicalDevice = device.physical_device;
  adopted.device = device.device;
  adopted.queueFamily = device.queue_family;
  adopted.enabled = enabled;
  adopted.uniformControlFlow = device.uniform_control_flow != VK_FALSE;
  adopted.allocator = allocatorOf(device);
  const DeviceChoice choice = vulkan::adopt(adopted);
  known.push_back({device, enabled, choice.adopted});
  return choice;
}

}  // namespace gnosphere::c

using namespace gnosphere;
using namespace gnosphere::c;

extern "C" {

gno_status gno_vulkan_get_requirements(PFN_vkGetInstanceProcAddr get_instance_proc_addr, VkInstance instance,
                                       VkPhysicalDevice physical, gno_vulkan_requirements* requirements) {
  return guard([&] {
    const Out to(requirements, GNO_TYPE(gno_vulkan_requirements));
    thread_local vulkan::Requirements from;
    thread_local std::vector<const char*> missing;
    from = vulkan::requirementsOf(get_instance_proc_addr, instance, physical);
    missing.clear();
    for (const std::string& sentence : from.missing) missing.push_back(sentence.c_str());
    to->extensions = from.extensions.data();
    to->extension_count = static_cast<uint32_t>(from.extensions.size());
    to->features = from.features;
    to->features12 = from.features12;
    to->subgroup_size_control = from.subgroupSizeControl;
    to->missing = missing.data();
    to->missing_count = missing.size();
  });
}

gno_status gno_vulkan_add_features(const gno_vulkan_requirements* requirements, VkPhysicalDeviceFeatures* features,
                                   VkPhysicalDeviceVulkan12Features* features12,
                                   VkPhysicalDeviceSubgroupSizeControlFeaturesEXT* subgroup_size_control) {
  return guard([&] { featuresOf(requirements).addTo(features, features12, subgroup_size_control); });
}

#ifdef VK_VERSION_1_3
gno_status gno_vulkan_add_features13(const gno_vulkan_requirements* requirements, VkPhysicalDeviceFeatures* features,
                                     VkPhysicalDeviceVulkan12Features* features12,
                                     VkPhysicalDeviceVulkan13Features* features13) {
  return guard([&] { featuresOf(requirements).addTo(features, features12, features13); });
}
#endif

gno_status gno_vulkan_recorder_create(gno_simulator simulator, size_t frames_in_flight, gno_vulkan_recorder* recorder) {
  return giveHandle(recorder, "recorder", [&] {
    Idle idle(simulator);
    return make<gno_vulkan_recorder>({simulator, vulkan::Recorder(idle.simulator(), frames_in_flight), {}});
  });
}

gno_status gno_vulkan_recorder_destroy(gno_vulkan_recorder recorder) {
  return guard([&] { destroy(recorder); });
}

gno_status gno_vulkan_record(gno_vulkan_recorder recorder, VkCommandBuffer commands, size_t frame_in_flight,
                             const gno_vulkan_recorded_shot* shots, size_t shot_count,
                             const gno_vulkan_recorded_scan** before, size_t* before_count) {
  return guard([&] {
    std::vector<vulkan::RecordedShot> wanted;
    forEntries(array(shots, shot_count, "shots"), "shots", [&](const gno_vulkan_recorded_shot& shot) {
      wanted.push_back({shotOf(shot.shot), rangeOf(shot.records), rangeOf(shot.header)});
    });
    WithSimulator locked(recorder);
    // The room is made before, because what became of earlier scans is told once: of those of one recording at most.
    std::vector<gno_vulkan_recorded_scan> results;
    results.reserve(locked->mostShots);
    const auto made = locked->recorder.record(commands, frame_in_flight, wanted);
    locked->mostShots = std::max(locked->mostShots, wanted.size());
    for (const vulkan::RecordedScan& scan : made)
      results.push_back({scan.sensor, scan.frame, scan.complete, scan.nonFinite, scan.degenerate, scan.unplaced});
    locked->results = std::move(results);
    if (before) *before = locked->results.data();
    if (before_count) *before_count = locked->results.size();
  });
}

gno_status gno_vulkan_abandon(gno_vulkan_recorder recorder, size_t frame_in_flight) {
  return guard([&] {
    WithSimulator locked(recorder);
    locked->recorder.abandon(frame_in_flight);
  });
}

gno_status gno_vulkan_recorder_set_vertices(gno_vulkan_recorder recorder, size_t mesh,
                                            const gno_vulkan_vertex_buffer* vertices) {
  return guard([&] {
    const gno_vulkan_vertex_buffer& from = sized(vertices, GNO_TYPE(gno_vulkan_vertex_buffer));
    vulkan::VertexBuffer buffer;
    buffer.address = from.address;
    buffer.bytes = from.bytes;
    buffer.stride = from.stride;
    buffer.format = from.format;
    std::copy_n(from.scale, 3, buffer.scale.begin());
    std::copy_n(from.offset, 3, buffer.offset.begin());
    WithSimulator locked(recorder);
    locked->recorder.setVertices(mesh, buffer);
  });
}

gno_status gno_vulkan_recorder_set_transforms(gno_vulkan_recorder recorder,
                                              const gno_vulkan_transform_buffer* transforms) {
  return guard([&] {
    const gno_vulkan_transform_buffer& from = sized(transforms, GNO_TYPE(gno_vulkan_transform_buffer));
    vulkan::TransformBuffer buffer;
    buffer.address = from.address;
    buffer.bytes = from.bytes;
    buffer.stride = from.stride;
    buffer.format = enumOf(from.format, vulkan::TransformFormat::columns4x4, "transform format");
    buffer.origin = {from.origin[0], from.origin[1], from.origin[2]};
    buffer.firstInstance = from.first_instance;
    buffer.instances = from.instance_count;
    WithSimulator locked(recorder);
    locked->recorder.setTransforms(buffer);
  });
}

}  // extern "C"

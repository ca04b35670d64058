// SPDX-License-Identifier: Apache-2.0
// Scans on the caller's own Vulkan device: the scans are recorded into the caller's command buffers, and the results
// stay in the caller's buffers. No other public header includes Vulkan's.
#pragma once

#include <vulkan/vulkan_core.h>

#include <array>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "gnosphere/simulator.hpp"

namespace gnosphere::vulkan {

/// Extensions and features that a device must be created with, in the form that vkCreateDevice() takes. The instance
/// must be one of Vulkan 1.2 or later.
struct Requirements {
  std::vector<const char*> extensions;  ///< for VkDeviceCreateInfo::ppEnabledExtensionNames
  VkPhysicalDeviceFeatures features = {};
  VkPhysicalDeviceVulkan12Features features12 = {};
  VkPhysicalDeviceSubgroupSizeControlFeaturesEXT subgroupSizeControl = {};
  /// A sentence for each requirement that the physical device does not meet; empty if it can be used.
  std::vector<std::string> missing;

  Requirements() {
    features12.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES;
    subgroupSizeControl.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_SIZE_CONTROL_FEATURES_EXT;
  }

  /// Sets every required feature in the caller's own structures, which otherwise keep their values. Null for a
  /// structure that the caller's chain does not have; a chain must not hold a structure twice.
  GNOSPHERE_API void addTo(VkPhysicalDeviceFeatures* features, VkPhysicalDeviceVulkan12Features* features12,
                           VkPhysicalDeviceSubgroupSizeControlFeaturesEXT* subgroupSizeControl) const;
#ifdef VK_VERSION_1_3
  /// As above, for a chain that has the features of Vulkan 1.3 in one structure, where those of the extension for the
  /// sizes of subgroups may not stand beside it.
  GNOSPHERE_API void addTo(VkPhysicalDeviceFeatures* features, VkPhysicalDeviceVulkan12Features* features12,
                           VkPhysicalDeviceVulkan13Features* features13) const;
#endif
};

/// Returns what a device on `physical` must be created with. Features without which the library works, but more slowly
/// (64-bit atomics and doubles), are included if the physical device has them.
GNOSPHERE_API Requirements requirementsOf(PFN_vkGetInstanceProcAddr getInstanceProcAddr, VkInstance instance,
                                          VkPhysicalDevice physical);

/// Memory for one buffer, from the caller.
struct Allocation {
  VkDeviceMemory memory = VK_NULL_HANDLE;
  VkDeviceSize offset = 0;
  void* mapped = nullptr;  ///< host address of the first byte; needed if the memory type is host-visible
  void* user = nullptr;    ///< not looked at
};

/// The caller's allocator of device memory, in the manner of the Vulkan Memory Allocator.
struct Allocator {
  /// Returns memory of the type `memoryType` for a buffer, or an Allocation without memory if there is none left. The
  /// memory must have been allocated with VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT. Size and alignment are multiples of
  /// the device's nonCoherentAtomSize, so that the library may flush the whole range.
  std::function<Allocation(const VkMemoryRequirements& requirements, uint32_t memoryType)> allocate;
  std::function<void(const Allocation& allocation)> release;
};

/// A device of the caller. The device must outlive every simulator that uses it, and the objects below must not be
/// destroyed before them.
struct AdoptedDevice {
  PFN_vkGetInstanceProcAddr getInstanceProcAddr = nullptr;
  VkInstance instance = VK_NULL_HANDLE;
  VkPhysicalDevice physicalDevice = VK_NULL_HANDLE;
  VkDevice device = VK_NULL_HANDLE;
  /// Family of the queue to which the caller submits the recorded scans; it must support compute.
  uint32_t queueFamily = 0;
  /// The requirements that the device was created with: requirementsOf(), less the features that the caller left off.
  Requirements enabled;
  /// Whether the device was created with VK_KHR_shader_subgroup_uniform_control_flow and its feature. Where the
  /// physical device offers them, they are worth enabling: without them Vulkan does not promise that the lanes of a
  /// subgroup run together again after a branch, on which the kernels rely.
  bool uniformControlFlow = false;
  Allocator allocator;  ///< if empty, buffers share memory from vkAllocateMemory()
};

/// Returns the choice of the caller's device, for SimulatorOptions::device. A simulator on it records its scans, see
/// Recorder; it never submits anything, never waits, and its scan functions throw Error(invalidArgument). Simulators
/// that are made with copies of one choice share their compiled kernels while one of them lives. Throws
/// Error(invalidArgument) that names what is missing.
GNOSPHERE_API DeviceChoice adopt(const AdoptedDevice& device);

/// A buffer of the caller's device, by address. The buffer was created with VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT
/// and VK_BUFFER_USAGE_STORAGE_BUFFER_BIT.
struct DeviceRange {
  VkDeviceAddress address = 0;  ///< a multiple of 16
  VkDeviceSize bytes = 0;
};

/// The positions of a mesh's vertices in a buffer of the caller's device, which was created with the same usages as
/// that of a DeviceRange. Other attributes may lie between the positions.
struct VertexBuffer {
  VkDeviceAddress address = 0;  ///< of the first position; a multiple of 4
  /// From there to the end of the buffer. The buffer is read in words of 4 bytes, so 16-bit positions that end within a
  /// word need 2 bytes behind them.
  VkDeviceSize bytes = 0;
  uint32_t stride = 12;  ///< bytes from one position to the next; a multiple of 4, or of 2 for 16-bit formats
  /// VK_FORMAT_R32G32B32_SFLOAT, or R16G16B16 with UNORM, SNORM, USCALED or SSCALED; each also with a fourth component,
  /// which is not looked at. Floats are positions in metres relative to Mesh::origin.
  VkFormat format = VK_FORMAT_R32G32B32_SFLOAT;
  /// Of 16-bit formats, by axis: position = value * scale + offset, in metres relative to Mesh::origin. Value is what
  /// the format says; the library computes in single precision integer * (scale / 65535) + offset, or 32767 for SNORM.
  std::array<float, 3> scale = {1, 1, 1}, offset = {};
};

/// How the numbers of a transform, in single precision, lie in memory.
enum class TransformFormat {
  rows3x4,     ///< three rows of four, as in VkTransformMatrixKHR and Transform::rows
  columns4x4,  ///< four columns of four, as a mat4 of GLSL has them; the fourth row is not looked at
};

/// The transforms of instances in a buffer of the caller's device, which was created with the same usages as that of a
/// DeviceRange. A transform takes points of the mesh's frame to the axes of the world, relative to `origin`: near it
/// single precision is enough, wherever in the world it is.
struct TransformBuffer {
  VkDeviceAddress address = 0;  ///< of the first transform; a multiple of 4
  VkDeviceSize bytes = 0;       ///< from there to the end of the buffer
  /// Bytes from one transform to the next; a multiple of 4, for example 64 for an array of
  /// VkAccelerationStructureInstanceKHR.
  uint32_t stride = 48;
  TransformFormat format = TransformFormat::rows3x4;
  Vec3 origin;               ///< in the world, in metres
  size_t firstInstance = 0;  ///< the instance to which the first transform belongs; the next one follows
  size_t instances = 0;      ///< how many; all must exist
};

/// A scan to be recorded, and the buffers for its results.
struct RecordedShot {
  Shot shot;
  DeviceRange records;  ///< gets the records in the layout of SensorRequest::layout
  DeviceRange header;   ///< gets a RecordHeader
};

/// The outcome of a recorded scan.
struct RecordedScan {
  size_t sensor = 0;
  uint64_t frame = 0;  ///< Shot::frame
  /// False if a list was too small: the results may lack hits. The list has grown; the next recorded scan has room.
  bool complete = true;
  /// Triangles of the meshes of Recorder::setVertices() that the scan left out: with a corner that is not finite or
  /// beyond 1e9 m, and others with two corners at one place. Each mesh counts once, however often it is placed.
  uint32_t nonFinite = 0, degenerate = 0;
  /// Instances of Recorder::setTransforms() that the scan left out: with a transform in which a number is not finite or
  /// beyond 1e9.
  uint32_t unplaced = 0;
};

/// Records the scans of a simulator on an adopted device into the caller's command buffers. The caller has several
/// frames in flight, each with a number below `framesInFlight`; when record() is called with a number, the commands
/// recorded with it before must have completed. All commands go to one queue, in the order in which they were recorded.
class GNOSPHERE_API Recorder {
 public:
  /// The simulator must outlive the recorder, must not be moved meanwhile, and has one recorder at a time; copies of a
  /// recorder are the same one.
  /// `framesInFlight` is 1 to 16. Throws Error(invalidArgument) if the simulator has another recorder, if the device is
  /// not an adopted one, or for another number of frames.
  Recorder(Simulator& simulator, size_t framesInFlight = 2);

  /// Records the scans, of sensors that have a layout, into a command buffer in the recording state, outside of a
  /// render pass. Shots of one sensor share dispatches, as those of Simulator::scanBatch() do, unless transforms come
  /// from a buffer of setTransforms(). Earlier commands on the queue that write to the simulator's inputs or read its
  /// results need no barrier, and later commands see the results without one. Returns what became of the scans that
  /// were recorded with this number before, sensor by sensor, each in the order of its shots. Throws
  /// Error(invalidArgument) for invalid shots and buffers, in which case nothing is recorded, and Error(outOfMemory):
  /// then the command buffer must not be submitted, the next call does what this one should have done, and it also
  /// returns what this one would have.
  std::vector<RecordedScan> record(VkCommandBuffer commands, size_t frame, std::span<const RecordedShot> shots);

  /// Says that the commands recorded last with this number have not been submitted and never will be, for example
  /// because the frame was skipped. The next recording uploads again what these commands would have, and nothing tells
  /// what became of their scans. Of several frames the one recorded last must be abandoned first, because its commands
  /// build on those before. Throws Error(invalidArgument) if the frame was not recorded, or another one after it.
  void abandon(size_t frame);

  /// From the next recording on, the vertices of a mesh are those in a buffer of the caller, as
  /// Simulator::setPositions() would set them, but read by the recorded commands. Must be called again whenever the
  /// buffer's content has changed, with the same buffer or with another one. The content must stay until then, because
  /// the library reads it again when its own arrays grow. Simulator::setPositions() ends this, and so does the removal
  /// of the mesh. Throws Error(invalidArgument) for a mesh that does not exist or is deformable, and for a buffer that
  /// cannot have its vertices, and Error(outOfMemory).
  void setVertices(size_t mesh, const VertexBuffer& vertices);

  /// From the next recording on, the transforms of the instances are those in a buffer of the caller, which every
  /// recorded scan reads anew. Its results are those of Simulator::setTransform() with the same numbers, except that
  /// the device composes transform and pose with about 46 instead of 53 bits. Simulator::setTransform() ends this for
  /// an instance, and so does its removal. Until then neither the instance nor its mesh may move during a scan
  /// (Shot::instanceMotions, Shot::meshMotions). Throws Error(invalidArgument) for an instance that does not exist and
  /// for a buffer that cannot have the transforms, and Error(outOfMemory).
  void setTransforms(const TransformBuffer& transforms);

 private:
  Simulator& simulator_;
  std::shared_ptr<const void> only_;  // held by the copies of the simulator's recorder
  size_t frames_ = 0;
};

}  // namespace gnosphere::vulkan

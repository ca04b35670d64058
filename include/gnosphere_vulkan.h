/* SPDX-License-Identifier: Apache-2.0
 *
 * The part of GnoSphere's C interface (see gnosphere.h) that needs Vulkan's headers: scans on the caller's own Vulkan
 * device. They are recorded into the caller's command buffers, and the results stay in the caller's buffers. The
 * library submits nothing and waits for nothing. docs/engine.md shows how to use it, in C++ under the same names.
 */
#ifndef GNOSPHERE_VULKAN_H
#define GNOSPHERE_VULKAN_H

#include <gnosphere.h>
#include <vulkan/vulkan_core.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ------------------------------------------------------------------------------------------------ device */

/* What a device must be created with, in the form that vkCreateDevice() takes. The instance must be one of Vulkan 1.2
 * or later. */
typedef struct gno_vulkan_requirements {
  size_t struct_size;
  const char* const* extensions; /* for VkDeviceCreateInfo::ppEnabledExtensionNames */
  uint32_t extension_count;
  VkPhysicalDeviceFeatures features;
  VkPhysicalDeviceVulkan12Features features12;
  VkPhysicalDeviceSubgroupSizeControlFeaturesEXT subgroup_size_control;
  const char* const* missing; /* a sentence for each requirement that the physical device does not meet */
  size_t missing_count;       /* 0 if it can be used */
} gno_vulkan_requirements;

/* Gives what a device on `physical` must be created with. Features without which the library works, but more slowly
 * (64-bit atomics and doubles), are included if the physical device has them. The names and sentences are valid until
 * the same thread calls this function again. */
GNO_API gno_status gno_vulkan_get_requirements(PFN_vkGetInstanceProcAddr get_instance_proc_addr, VkInstance instance,
                                               VkPhysicalDevice physical, gno_vulkan_requirements* requirements);
/* Sets every required feature in the caller's own structures, which otherwise keep their values. Null for a structure
 * that the caller's chain does not have; a chain must not hold a structure twice. */
GNO_API gno_status gno_vulkan_add_features(const gno_vulkan_requirements* requirements,
                                           VkPhysicalDeviceFeatures* features,
                                           VkPhysicalDeviceVulkan12Features* features12,
                                           VkPhysicalDeviceSubgroupSizeControlFeaturesEXT* subgroup_size_control);
#ifdef VK_VERSION_1_3
/* As above, for a chain that has the features of Vulkan 1.3 in one structure, where those of the extension for the
 * sizes of subgroups may not stand beside it. */
GNO_API gno_status gno_vulkan_add_features13(const gno_vulkan_requirements* requirements,
                                             VkPhysicalDeviceFeatures* features,
                                             VkPhysicalDeviceVulkan12Features* features12,
                                             VkPhysicalDeviceVulkan13Features* features13);
#endif

/* Memory for one buffer, from the caller. */
typedef struct gno_vulkan_allocation {
  VkDeviceMemory memory;
  VkDeviceSize offset;
  void* mapped;     /* host address of the first byte; needed if the memory type is host-visible */
  void* allocation; /* not looked at */
} gno_vulkan_allocation;

/* A device of the caller, for gno_options::adopted. It must outlive every simulator that uses it, and the objects below
 * must not be destroyed before them. */
struct gno_vulkan_adopted_device {
  size_t struct_size;
  PFN_vkGetInstanceProcAddr get_instance_proc_addr;
  VkInstance instance;
  VkPhysicalDevice physical_device;
  VkDevice device;
  uint32_t queue_family; /* of the queue to which the caller submits the recorded scans; it must support compute */
  /* What the device was created with: gno_vulkan_get_requirements(), without the features that the caller has left off.
   */
  const gno_vulkan_requirements* enabled;
  /* The caller's allocator of device memory; if both are null, buffers share memory from
   * vkAllocateMemory(). `allocate` sets *allocation, whose bytes are 0 before, to memory of the type `memory_type` that
   * was allocated with VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT, or leaves it if there is none left. Size and alignment
   * are multiples of the device's nonCoherentAtomSize, so that the library may flush the whole range. */
  void (*allocate)(const VkMemoryRequirements* requirements, uint32_t memory_type, gno_vulkan_allocation* allocation,
                   void* user);
  void (*release)(const gno_vulkan_allocation* allocation, void* user);
  void* user;
  /* Whether the device was created with VK_KHR_shader_subgroup_uniform_control_flow and its feature; see
   * AdoptedDevice::uniformControlFlow. */
  VkBool32 uniform_control_flow;
};

/* --------------------------------------------------------------------------------------------- recording */

/* Records the scans of a simulator on an adopted device. */
typedef struct gno_vulkan_recorder_object* gno_vulkan_recorder;

/* A buffer of the caller's device, by address. The buffer was created with
 * VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT and VK_BUFFER_USAGE_STORAGE_BUFFER_BIT. */
typedef struct gno_vulkan_range {
  VkDeviceAddress address; /* a multiple of 16 */
  VkDeviceSize bytes;
} gno_vulkan_range;

/* The header of the records of a recorded scan. */
typedef gno_record_header gno_vulkan_record_header;

/* A scan to be recorded, and the buffers for its results. */
typedef struct gno_vulkan_recorded_shot {
  const gno_shot* shot;
  gno_vulkan_range records; /* gets the records in the layout of gno_request::layout */
  gno_vulkan_range header;  /* gets a gno_vulkan_record_header */
} gno_vulkan_recorded_shot;

/* What became of a recorded scan. */
typedef struct gno_vulkan_recorded_scan {
  size_t sensor;
  uint64_t frame; /* gno_shot::frame */
  /* 0 if a list was too small: the results may lack hits. The list has grown; the next recorded scan has room. */
  int32_t complete;
  /* Triangles of the meshes of gno_vulkan_recorder_set_vertices() that the scan left out: with a corner that is not
   * finite or beyond 1e9 m, and others with two corners at one place. Each mesh counts once. */
  uint32_t non_finite, degenerate;
  /* Instances of gno_vulkan_recorder_set_transforms() that the scan left out: with a transform in which a number is not
   * finite or beyond 1e9. */
  uint32_t unplaced;
} gno_vulkan_recorded_scan;

/* The positions of a mesh's vertices in a buffer of the caller's device, which was created with the usages of a
 * gno_vulkan_range. Other attributes may lie between the positions. */
typedef struct gno_vulkan_vertex_buffer {
  size_t struct_size;
  VkDeviceAddress address; /* of the first position; a multiple of 4 */
  /* From there to the end of the buffer. It is read in words of 4 bytes, so 16-bit positions that end within a word
   * need 2 bytes behind them. */
  VkDeviceSize bytes;
  uint32_t stride; /* bytes from one position to the next; a multiple of 4, or of 2 for 16-bit formats */
  /* VK_FORMAT_R32G32B32_SFLOAT, or R16G16B16 with UNORM, SNORM, USCALED or SSCALED; each also with a fourth component,
   * which is not looked at. Floats are positions in metres relative to gno_mesh::origin. */
  VkFormat format;
  float scale[3], offset[3]; /* of 16-bit formats, by axis: position = value * scale + offset */
} gno_vulkan_vertex_buffer;

/* How the numbers of a transform, in single precision, lie in memory. */
typedef int32_t gno_vulkan_transform_format;
enum {
  GNO_VULKAN_TRANSFORM_ROWS_3X4 = 0,   /* three rows of four, as in VkTransformMatrixKHR */
  GNO_VULKAN_TRANSFORM_COLUMNS_4X4 = 1 /* four columns of four; the fourth row is not looked at */
};

/* The transforms of instances in a buffer of the caller's device, which was created with the usages of a
 * gno_vulkan_range. A transform takes points of the mesh's frame to the axes of the world, relative to `origin`. */
typedef struct gno_vulkan_transform_buffer {
  size_t struct_size;
  VkDeviceAddress address; /* of the first transform; a multiple of 4 */
  VkDeviceSize bytes;      /* from there to the end of the buffer */
  uint32_t stride;         /* bytes from one transform to the next; a multiple of 4 */
  gno_vulkan_transform_format format;
  double origin[3];      /* in the world, in metres */
  size_t first_instance; /* the instance to which the first transform belongs; the next one follows */
  size_t instance_count; /* all must exist */
} gno_vulkan_transform_buffer;

/* The caller has several frames in flight, at most 16, each with a number below `frames_in_flight`. The simulator must
 * not be destroyed while a recorded command is running. Once it is destroyed, the recorder is of no use. A simulator
 * has one recorder at a time. */
GNO_API gno_status gno_vulkan_recorder_create(gno_simulator simulator, size_t frames_in_flight,
                                              gno_vulkan_recorder* recorder);
GNO_API gno_status gno_vulkan_recorder_destroy(gno_vulkan_recorder recorder);
/* Records the scans, of sensors that have a layout, into a command buffer in the recording state, outside of a render
 * pass. Shots of one sensor share dispatches, as those of gno_simulator_scan_batch() do, unless transforms come from a
 * buffer of the caller. When a frame in flight is recorded, the commands recorded with it before must have completed.
 * All commands go to one queue, in the order in which they were recorded. Earlier commands on the queue that write to
 * the simulator's inputs or read its results need no barrier, and later commands see the results without one. `before`
 * and `before_count` (both may be null) get what became of the scans that were recorded with this frame in flight
 * before, sensor by sensor, each in the order of its shots; the list is valid until this recorder records again. After
 * an error with GNO_INVALID_ARGUMENT nothing is recorded. After any other one the command buffer must not be
 * submitted; the next call does what this one should have done. */
GNO_API gno_status gno_vulkan_record(gno_vulkan_recorder recorder, VkCommandBuffer commands, size_t frame_in_flight,
                                     const gno_vulkan_recorded_shot* shots, size_t shot_count,
                                     const gno_vulkan_recorded_scan** before, size_t* before_count);

/* Says that the commands recorded last with this frame in flight have not been submitted and never will be. The next
 * recording uploads again what they would have. Of several frames the one recorded last must be abandoned first. */
GNO_API gno_status gno_vulkan_abandon(gno_vulkan_recorder recorder, size_t frame_in_flight);

/* From the next recording on, the vertices of a mesh are those in the buffer, as gno_simulator_set_positions() would
 * set them, but read by the recorded commands. Must be called again whenever the buffer's content has changed, with the
 * same buffer or another; until then the content must stay. gno_simulator_set_positions() ends this. */
GNO_API gno_status gno_vulkan_recorder_set_vertices(gno_vulkan_recorder recorder, size_t mesh,
                                                    const gno_vulkan_vertex_buffer* vertices);

/* From the next recording on, the transforms of the instances are those in the buffer, which every recorded scan reads
 * anew, as gno_simulator_set_transform() would set them, except that the device composes transform and pose with about
 * 46 instead of 53 bits. gno_simulator_set_transform() ends this for an instance, and so does its removal. Until then
 * neither the instance nor its mesh may move during a scan. */
GNO_API gno_status gno_vulkan_recorder_set_transforms(gno_vulkan_recorder recorder,
                                                      const gno_vulkan_transform_buffer* transforms);

/* ---------------------------------------------------------------------------------------- default values */

GNO_INIT(gno_vulkan_requirements, value.features12.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES;
         value.subgroup_size_control.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_SIZE_CONTROL_FEATURES_EXT;)
GNO_INIT(gno_vulkan_adopted_device, )
GNO_INIT(gno_vulkan_vertex_buffer, value.stride = 12; value.format = VK_FORMAT_R32G32B32_SFLOAT;
         value.scale[0] = value.scale[1] = value.scale[2] = 1;)
GNO_INIT(gno_vulkan_transform_buffer, value.stride = 48;)

#ifdef __cplusplus
}
#endif

#endif

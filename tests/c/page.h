/* SPDX-License-Identifier: Apache-2.0
 *
 * Programs of the blocks of docs/c.md, which page.c has as C99. */
#pragma once

#include <gnosphere_stream.h>
#include <gnosphere_vulkan.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Returns that a scan has, and the shortest of their ranges. */
typedef struct page_scan {
  size_t entries, hits;
  double nearest;
} page_scan;

/* What the first three blocks find in the file town.glb: at rest, with its clip at `seconds`, and in a batch of three
 * shots whose results stay on the device. */
typedef struct page_scans {
  page_scan still, moved;
  size_t views, hits_of_views[3];
  uint64_t bytes_of_results; /* of a result buffer, and in it of the columns of a view */
  uint64_t bytes_per_view;
} page_scans;

page_scans scan_as_the_page_says(double seconds);

/* An engine of the caller for the last block: its device, a command buffer that is recorded, buffers for rows of
 * `layout` and a header, and a function that submits the commands and waits for them. */
typedef struct page_engine {
  PFN_vkGetInstanceProcAddr get_instance_proc_addr;
  VkInstance instance;
  VkPhysicalDevice physical;
  VkDevice device;
  uint32_t family;
  VkCommandBuffer command_buffer;
  gno_layout layout;
  gno_vulkan_range records, header;
  void (*submit)(void* user);
  void* user;
} page_engine;

void record_as_the_page_says(const page_engine* engine);

#ifdef __cplusplus
}
#endif

/* SPDX-License-Identifier: Apache-2.0
 *
 * The blocks of docs/c.md, word for word, with what they take for granted around them. tests/docs/check_page compares
 * them with the page, and tests/engine/page_tests.cpp runs them. */
#include "c/page.h"

#include <math.h>
#include <stdio.h>

static page_scan look(gno_column ranges) {
  page_scan found = {ranges.entries, 0, INFINITY};
  size_t i;
  for (i = 0; i < ranges.entries; ++i) {
    const double range = ((const float*)ranges.values)[i * ranges.stride];
    if (isnan(range)) continue;
    ++found.hits;
    if (range < found.nearest) found.nearest = range;
  }
  return found;
}

static void move(gno_scene scene, gno_simulator simulator, double seconds) {
  uint32_t clip;
  size_t i;
  gno_scene_state state = gno_scene_state_init();
  gno_scene_find_clip(scene, "walk", &clip);
  gno_scene_get_state(scene, clip, seconds, GNO_CLIP_LOOP, &state);
  for (i = 0; i < state.transform_count; ++i) gno_simulator_set_transform(simulator, i, &state.transforms[i]);
  for (i = 0; i < state.deformation_count; ++i)
    if (state.deformations[i].joint_count + state.deformations[i].morph_weight_count > 0)
      gno_simulator_set_deformation(simulator, i, &state.deformations[i]);
}

static void stream(gno_scene scene, gno_request request, const gno_shot* shots, size_t shot_count, page_scans* found) {
  gno_simulator simulator = NULL;
  size_t i;

  gno_options options = gno_options_init();
  gno_batch_stream_options many = gno_batch_stream_options_init();
  gno_batch_stream stream = NULL;
  gno_streamed_batch batch = gno_streamed_batch_init();
  uint64_t number = 0;

  many.views = 64; /* a result buffer has room for that many: here 74 MB, 4 bytes per entry of the HDL-64E above */
  if (gno_options_set(&options, "results_on_device=true") != GNO_OK ||
      gno_simulator_create(scene, &request, 1, &options, &simulator) != GNO_OK ||
      gno_batch_stream_create(simulator, &many, &stream) != GNO_OK ||
      gno_batch_stream_submit(stream, shots, shot_count, &number) != GNO_OK || /* returns while the device scans */
      gno_batch_stream_wait(stream, number, &batch) != GNO_OK)
    puts(gno_last_error());

  found->views = batch.views;
  for (i = 0; i < batch.views && i < 3; ++i) found->hits_of_views[i] = batch.headers[i].hits;
  if (batch.places) {
    found->bytes_of_results = batch.places->bytes;
    found->bytes_per_view = batch.places->bytes_per_view;
  }
  gno_batch_stream_destroy(stream);
  gno_simulator_destroy(simulator);
}

page_scans scan_as_the_page_says(double seconds) {
  page_scans found = {{0, 0, 0}, {0, 0, 0}, 0, {0, 0, 0}, 0, 0};
  gno_shot shots[3];

  gno_scene scene = NULL;
  gno_sensor sensor = NULL;
  gno_simulator simulator = NULL;
  gno_scan scan = NULL;
  gno_request request = gno_request_init();
  gno_shot shot = gno_shot_init();
  gno_column ranges = gno_column_init();

  if (gno_scene_load("town.glb", NULL, &scene) != GNO_OK) puts(gno_last_error());
  gno_sensor_builtin("HDL-64E", &sensor);
  request.sensor = sensor; /* effects: automatic; fields: points, ranges, triangles and instances */
  gno_simulator_create(scene, &request, 1, NULL, &simulator);
  shot.pose.position[2] = 1.8;
  gno_simulator_scan(simulator, &shot, &scan); /* the next scan uses the same memory */
  gno_scan_get_column(scan, GNO_FIELD_RANGE, &ranges);
  /* ((const float*)ranges.values)[i * ranges.stride] is the range of entry i, or NaN */

  found.still = look(ranges);
  move(scene, simulator, seconds);
  gno_simulator_scan(simulator, &shot, &scan);
  gno_scan_get_column(scan, GNO_FIELD_RANGE, &ranges);
  found.moved = look(ranges);
  shots[0] = shots[1] = shots[2] = shot;
  stream(scene, request, shots, 3, &found);

  gno_scan_destroy(scan);
  gno_simulator_destroy(simulator);
  gno_sensor_destroy(sensor);
  gno_scene_destroy(scene);
  return found;
}

void record_as_the_page_says(const page_engine* engine) {
  const PFN_vkGetInstanceProcAddr vkGetInstanceProcAddr = engine->get_instance_proc_addr;
  const VkInstance instance = engine->instance;
  const VkPhysicalDevice physical = engine->physical;
  const VkDevice device = engine->device;
  const uint32_t family = engine->family;
  const VkCommandBuffer command_buffer = engine->command_buffer;
  const VkDeviceAddress address_of_records = engine->records.address, address_of_header = engine->header.address;
  const VkDeviceSize bytes_of_records = engine->records.bytes;
  const gno_layout layout = engine->layout;
  const size_t frames_in_flight = 2, frame_in_flight = 1;
  gno_scene scene = NULL;
  gno_simulator simulator = NULL;
  gno_request request = gno_request_init();
  gno_shot shot = gno_shot_init();
  gno_scene_load("town.glb", NULL, &scene);
  gno_sensor_builtin("HDL-64E", &request.sensor);
  shot.pose.position[2] = 1.8;

  gno_vulkan_requirements needed = gno_vulkan_requirements_init();
  gno_vulkan_adopted_device adopted = gno_vulkan_adopted_device_init();
  gno_vulkan_recorder recorder = NULL;
  gno_vulkan_recorded_shot recorded = {&shot, {address_of_records, bytes_of_records}, {address_of_header, 32}};
  gno_options options = gno_options_init();

  gno_vulkan_get_requirements(vkGetInstanceProcAddr, instance, physical,
                              &needed); /* what vkCreateDevice() must be given */
  adopted.get_instance_proc_addr = vkGetInstanceProcAddr;
  adopted.instance = instance, adopted.physical_device = physical, adopted.device = device;
  adopted.queue_family = family;
  adopted.enabled = &needed;
  options.adopted = &adopted;
  request.layout = &layout; /* what a scan leaves in your buffer; gno_layout_of() makes rows of fields */
  gno_simulator_create(scene, &request, 1, &options, &simulator);
  gno_vulkan_recorder_create(simulator, frames_in_flight, &recorder);
  gno_vulkan_record(recorder, command_buffer, frame_in_flight, &recorded, 1, NULL, NULL);

  engine->submit(engine->user);
  gno_vulkan_recorder_destroy(recorder);
  gno_simulator_destroy(simulator);
  gno_sensor_destroy(request.sensor);
  gno_scene_destroy(scene);
}

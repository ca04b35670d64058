/* SPDX-License-Identifier: Apache-2.0
 *
 * scan SCENE CLOUD: scans a scene file with a VLP-16 that stands 1.8 m above the origin, and writes a cloud file. A
 * third argument chooses the device, as on the command line. */
#include <gnosphere.h>
#include <math.h>
#include <stdio.h>

/* Prints what is wrong, and returns whether something is. */
static int failed(gno_status status) {
  if (status == GNO_OK) return 0;
  fprintf(stderr, "scan: %s\n", gno_last_error());
  return 1;
}

static int report(gno_scan scan) {
  gno_column ranges = gno_column_init(), instances = gno_column_init();
  const float* range;
  const uint32_t* instance;
  size_t i, hits = 0, nearest = 0;
  if (failed(gno_scan_get_column(scan, GNO_FIELD_RANGE, &ranges))) return 1;
  if (failed(gno_scan_get_column(scan, GNO_FIELD_INSTANCE, &instances))) return 1;
  range = (const float*)ranges.values;
  instance = (const uint32_t*)instances.values;
  for (i = 0; i < ranges.entries; ++i) {
    if (isnan(range[i * ranges.stride])) continue; /* no return */
    if (hits++ == 0 || range[i * ranges.stride] < range[nearest * ranges.stride]) nearest = i;
  }
  printf("%zu of %zu beams hit\n", hits, ranges.entries);
  if (hits > 0)
    printf("the nearest after %g m, on instance %u\n", range[nearest * ranges.stride],
           (unsigned)instance[nearest * instances.stride]);
  return 0;
}

int main(int argc, char** argv) {
  gno_scene scene = NULL;
  gno_sensor sensor = NULL;
  gno_effects effects = NULL;
  gno_simulator simulator = NULL;
  gno_scan scan = NULL;
  gno_request request = gno_request_init();
  gno_options options = gno_options_init();
  gno_shot shot = gno_shot_init();
  int bad;
  if (argc < 3) {
    fprintf(stderr, "usage: scan SCENE CLOUD [DEVICE]\n");
    return 2;
  }
  if (argc > 3) options.device = argv[3];
  shot.pose.position[2] = 1.8;

  bad = failed(gno_scene_load(argv[1], NULL, &scene)) || failed(gno_sensor_builtin("VLP-16", &sensor)) ||
        failed(gno_effects_preset("clean", &effects));
  if (!bad) {
    request.sensor = sensor;
    request.effects = effects; /* geometry alone */
    bad = failed(gno_simulator_create(scene, &request, 1, &options, &simulator)) ||
          failed(gno_simulator_scan(simulator, &shot, &scan)) || report(scan) ||
          failed(gno_scan_write(scan, argv[2], NULL));
  }

  if (scan) gno_scan_destroy(scan);
  if (simulator) gno_simulator_destroy(simulator);
  if (effects) gno_effects_destroy(effects);
  if (sensor) gno_sensor_destroy(sensor);
  if (scene) gno_scene_destroy(scene);
  return bad;
}

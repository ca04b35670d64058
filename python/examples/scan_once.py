# SPDX-License-Identifier: Apache-2.0
"""Scans a file once: scan_once.py town.glb. Writes cloud.pcd and cloud.png."""

import sys

import numpy as np

import gnosphere

if len(sys.argv) != 2:
    sys.exit("usage: scan_once.py town.glb")
scene = gnosphere.load_scene(sys.argv[1])
request = gnosphere.SensorRequest(gnosphere.builtin_sensor("HDL-64E"), fields="intensity")
simulator = gnosphere.Simulator(scene, request)
scan = simulator.scan(gnosphere.Pose((0, 0, 1.8)))

hit = scan.triangles != gnosphere.NO_TRIANGLE
print(f"{hit.sum()} of {scan.beam_count()} beams hit on {simulator.device().name}")
names = [instance.name for instance in scene.instances]
numbers, counts = np.unique(scan.instances[hit], return_counts=True)
for i in np.argsort(-counts)[:5]:
    print(f"{counts[i]:7} points on {names[numbers[i]]}")
for decision in simulator.plan().effects:
    if decision.in_:
        print(f"{decision.effect}: {decision.reason}")

gnosphere.write_cloud(scan, "cloud.pcd")
gnosphere.write_picture(scan, "cloud.png")

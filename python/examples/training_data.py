# SPDX-License-Identifier: Apache-2.0
"""Labelled clouds in a fog that thickens: training_data.py town.glb. Writes fog-0.npz, fog-0.png, ...

While Python writes one cloud, the device works on the next.
"""

import sys

import numpy as np

import gnosphere
from gnosphere import Label

if len(sys.argv) != 2:
    sys.exit("usage: training_data.py town.glb")
VEHICLES = ("bus", "estate", "hatchback", "saloon", "van")  # as the instances of the town are called
scene = gnosphere.load_scene(sys.argv[1])
for instance in scene.instances:
    instance.class_id = 1 if instance.name.startswith(VEHICLES) else 0

request = gnosphere.SensorRequest(
    gnosphere.builtin_sensor("HDL-64E"), fields="intensity,label,class", variable_weather=True
)
simulator = gnosphere.Simulator(scene, request)
visibilities = [400.0, 200.0, 100.0, 50.0]
shots = [
    gnosphere.Shot(gnosphere.Pose((2.0 * i, 0, 1.8)), frame=i, weather=gnosphere.Weather(visibility=visibility))
    for i, visibility in enumerate(visibilities)
]


def receive(shot: int, scan: gnosphere.Scan) -> None:
    returned = ~np.isnan(scan.ranges)
    labels = scan["label"][returned]
    np.savez_compressed(
        f"fog-{shot}.npz",
        points=scan.points[returned],
        intensity=scan["intensity"][returned],
        class_id=scan["class"][returned],
        fog=labels == Label.scatter.value,
    )
    gnosphere.write_picture(scan, f"fog-{shot}.png")
    print(
        f"{visibilities[shot]:.0f} m: {returned.sum()} points, {(labels == Label.scatter.value).mean():.1%} in the fog"
    )


simulator.scan_all(shots, receive)

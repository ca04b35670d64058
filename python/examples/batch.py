# SPDX-License-Identifier: Apache-2.0
"""A robot in each of 4,096 worlds: batch.py [worlds [steps]]. Prints how long a step of all of them takes.

Each robot has a height scan of the ground around its feet, and a LiDAR of 16 channels. All worlds share the ground;
25 boxes move in each of them, and no robot sees the boxes of another world.
"""

import sys
import time

import numpy as np

import gnosphere
from gnosphere import Effects, SensorRequest, patterns, primitives

if len(sys.argv) > 3:
    sys.exit("usage: batch.py [worlds [steps]]")
worlds = int(sys.argv[1]) if len(sys.argv) > 1 else 4096
steps = int(sys.argv[2]) if len(sys.argv) > 2 else 3
random = np.random.default_rng(1)


def mesh(triangles: tuple[np.ndarray, np.ndarray]) -> gnosphere.Mesh:
    return gnosphere.Mesh(*triangles, parts=[gnosphere.MeshPart(0, len(triangles[1]), material=0)])


# Beams from above down to 17 x 11 points that are 0.1 m apart on level ground 0.6 m below the robot's base.
heights = patterns.grid((1.6, 1.0), 0.1, level=-0.6)

head = gnosphere.Sensor()
head.name = "head"
head.columns = 90
head.range_max = 30
head.channels = [gnosphere.Channel(float(elevation)) for elevation in np.linspace(-15, 15, 16)]

bumps = 0.05 * random.random((41, 41))
scene = gnosphere.Scene(
    materials=[gnosphere.Material()],
    meshes=[mesh(primitives.height_field(bumps, 10, 10, 1)), mesh(primitives.box((0.3, 0.3, 0.2)))],
    instances=[gnosphere.Instance(0)],
)
simulator = gnosphere.Simulator(scene, [SensorRequest(heights, Effects.none()), SensorRequest(head, Effects.none())])

places = np.zeros((worlds, 25, 7))
places[..., :2] = random.uniform(-8, 8, (worlds, 25, 2))
places[..., 2] = 0.2
places[..., 6] = 1
number = np.arange(1, worlds + 1)
boxes = simulator.add_instances(1, places.reshape(-1, 7), worlds=np.repeat(number, 25))

robots = np.zeros((worlds, 7))
robots[:, :2] = random.uniform(-1, 1, (worlds, 2))
robots[:, 2] = 0.6
robots[:, 6] = 1
feet, cloud = gnosphere.Batch(), gnosphere.Batch()
for step in range(steps):
    start = time.perf_counter()
    places[..., :2] += random.normal(0, 0.05, (worlds, 25, 2))
    robots[:, 0] += 0.05
    simulator.set_transforms(boxes, places.reshape(-1, 7))
    moved = time.perf_counter()
    simulator.scan_batch_into(robots, feet, sensor=0, worlds=number, fields="x")  # the points
    felt = time.perf_counter()
    simulator.scan_batch_into(robots, cloud, sensor=1, worlds=number, fields="range")
    seen = time.perf_counter()
    ground = feet.points[..., 2] + robots[:, None, 2]  # (worlds, 187): heights of the ground under each robot
    rate = [batch.views * batch.beams / seconds / 1e6 for batch, seconds in ((feet, felt - moved), (cloud, seen - felt))]
    print(
        f"step {step}: boxes {1e3 * (moved - start):.1f} ms; {feet.views} x {feet.beams} heights "
        f"{1e3 * (felt - moved):.1f} ms ({rate[0]:.1f} M rays/s); {cloud.views} x {cloud.beams} ranges "
        f"{1e3 * (seen - felt):.1f} ms ({rate[1]:.1f} M rays/s); ground {np.nanmean(ground):.3f} m"
    )
    del ground  # the next batch has the same memory if no array of it is held

try:
    import torch  # type: ignore[import-not-found, unused-ignore]

    observation = torch.from_dlpack(cloud.ranges)  # no copy
    print(f"an observation of {tuple(observation.shape)}, nearest {observation.nan_to_num(30).amin():.2f} m")
except ImportError:
    print(f"an observation of {cloud.ranges.shape}, nearest {np.nanmin(cloud.ranges):.2f} m; torch is not there")

# SPDX-License-Identifier: Apache-2.0
"""A drive at 20 m/s past a car that moves: moving.py town.glb. Writes skewed.png and deskewed.png.

The head turns once in 0.1 s, and the vehicle covers 2 m meanwhile: the rolling shutter.
"""

import sys

import numpy as np

import gnosphere

if len(sys.argv) != 2:
    sys.exit("usage: moving.py town.glb")
SPEED, PERIOD = 20.0, 0.1
scene = gnosphere.load_scene(sys.argv[1])
sensor = gnosphere.builtin_sensor("HDL-64E")
sensor.rotation_period = PERIOD
skewed, deskewed = gnosphere.Effects(), gnosphere.Effects()
deskewed.sensor_motion.deskew = True
simulator = gnosphere.Simulator(
    scene, [gnosphere.SensorRequest(sensor, skewed), gnosphere.SensorRequest(sensor, deskewed)]
)


def place(x: float, y: float) -> gnosphere.Transform:
    rows = np.eye(4)
    rows[:2, 3] = x, y
    return gnosphere.Transform(rows[:3])


# A box of 4 x 2 x 1.5 m that overtakes: added to the running simulator.
corners = np.array([[x, y, z] for x in (-2, 2) for y in (-1, 1) for z in (0, 1.5)], np.float32)
faces = np.array(
    [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [1, 5, 7], [1, 7, 3]],
    np.uint32,
)
car = simulator.add_instance(
    simulator.add_mesh(gnosphere.Mesh(corners, faces, [gnosphere.MeshPart(0, len(faces), 0)])), place(0, 4), class_id=1
)

scan = gnosphere.Scan()  # its arrays are used again
for frame in range(10):
    start, end = SPEED * PERIOD * frame, SPEED * PERIOD * (frame + 1)
    simulator.set_transform(car, place(1.5 * start - 10, 4))
    shot = gnosphere.Shot(gnosphere.Pose((start, 0, 1.8)), frame=frame)
    shot.motion = gnosphere.SensorMotion(
        [gnosphere.SensorMotion.Stamp(t, gnosphere.Pose((x, 0, 1.8))) for t, x in ((0.0, start), (PERIOD, end))]
    )
    shot.instance_motions = [gnosphere.InstanceMotion(car, place(1.5 * end - 10, 4))]
    for shot.sensor, picture in enumerate(("skewed.png", "deskewed.png")):
        simulator.scan_into(shot, scan)
        print(f"frame {frame}, {picture[:-4]}: {(scan.instances == car).sum()} points on the car")
        if frame == 9:
            gnosphere.write_picture(scan, picture)

# SPDX-License-Identifier: Apache-2.0
"""A sensor and a scene that are NumPy arrays: own_sensor.py. Writes own_sensor.png, and compares with a closed form.

The sensor looks 120 degrees wide and 30 degrees high; the scene is a ground 2 m below it, and a wall 30 m ahead.
"""

import numpy as np

import gnosphere

# 96 rows of 480 beams, each a row of an array.
azimuth, elevation = np.meshgrid(np.radians(np.linspace(60, -60, 480)), np.radians(np.linspace(10, -20, 96)))
directions = np.stack(
    [np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)], axis=-1
)
beams = gnosphere.BeamList(directions.reshape(-1, 3), width=480, height=96)
sensor = gnosphere.Sensor(name="solid state", range_max=200, patterns=[beams])

corners = np.array([[-200, -200, -2], [200, -200, -2], [200, 200, -2], [-200, 200, -2]], np.float32)
wall = np.array([[30, -200, -2], [30, 200, -2], [30, 200, 8], [30, -200, 8]], np.float32)
faces = np.array([[0, 1, 2], [0, 2, 3]], np.uint32)
parts = [gnosphere.MeshPart(0, 2, material=0)]
scene = gnosphere.Scene(
    materials=[gnosphere.Material("concrete", base_color=(0.5, 0.5, 0.5, 1))],
    meshes=[gnosphere.Mesh(corners, faces, parts, name="ground"), gnosphere.Mesh(wall, faces, parts, name="wall")],
    instances=[gnosphere.Instance(0), gnosphere.Instance(1)],
)

simulator = gnosphere.Simulator(scene, gnosphere.SensorRequest(sensor, gnosphere.Effects.none()))
scan = simulator.scan(gnosphere.Pose())
gnosphere.write_picture(scan, "own_sensor.png")

x, z = directions[..., 0].ravel(), directions[..., 2].ravel()
with np.errstate(divide="ignore"):
    to_ground = np.where(z < 0, -2 / z, np.inf)
    to_wall = np.where(30 / x * z <= 8, 30 / x, np.inf)
expected = np.minimum(to_ground, to_wall)
seen = np.isfinite(scan.ranges)
error = np.abs(scan.ranges[seen] - expected[seen]).max()
print(f"{seen.sum()} returns; the largest error against the closed form is {error * 1000:.3f} mm")

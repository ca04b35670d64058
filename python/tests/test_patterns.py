# SPDX-License-Identifier: Apache-2.0
"""Height scans beside closed forms: on level and sloping ground, and on a step."""

import math

import numpy as np
import pytest

import gnosphere
from gnosphere import Effects, Field, patterns

SIZE, RESOLUTION = (1.6, 1.0), 0.1


def simulator(sensor: gnosphere.Sensor, corners: list, device: gnosphere.DeviceChoice) -> gnosphere.Simulator:
    """A square of two triangles."""
    mesh = gnosphere.Mesh(np.float32(corners), [[0, 1, 2], [0, 2, 3]], [gnosphere.MeshPart(0, 2, 0)])
    scene = gnosphere.Scene([gnosphere.Material()], [mesh], [gnosphere.Instance(0)])
    return gnosphere.Simulator(scene, gnosphere.SensorRequest(sensor, Effects.none()), gnosphere.SimulatorOptions(device))


def isaac() -> np.ndarray:
    """The grid of Isaac Lab: patterns.grid_pattern() with ordering "xy"."""
    x, y = (np.arange(-side / 2, side / 2 + 1e-9, RESOLUTION) for side in SIZE)
    return np.stack(np.meshgrid(x, y, indexing="xy"), axis=-1).reshape(-1, 2)


def test_points_on_level_ground_are_those_of_the_grid_whatever_the_yaw(device):
    yaw = 0.7
    pose = gnosphere.Pose((3, -2, 0.6), (0, 0, math.sin(yaw / 2), math.cos(yaw / 2)))
    sensor = patterns.grid(SIZE, RESOLUTION, level=-0.6)
    level = simulator(sensor, [[-9, -9, 0], [9, -9, 0], [9, 9, 0], [-9, 9, 0]], device)
    scan = level.scan(pose)
    assert scan.shape == (11, 17)
    np.testing.assert_allclose(scan.points, np.column_stack([isaac(), np.full(187, -0.6)]), atol=2e-5)
    batch = level.scan_batch(np.tile([*pose.position, *pose.orientation], (3, 1)), fields=[Field.x])
    assert all(np.array_equal(points, scan.points) for points in batch.points)
    assert level.plan(views=64).views == 64  # a view per robot


@pytest.mark.parametrize("altitude", [5.0, 20.0, 100.0])
def test_heights_of_a_slope_are_those_beside_the_points_by_at_most_the_bound(device, altitude):
    slope, level = 0.5, -0.6
    sensor = patterns.grid(SIZE, RESOLUTION, level=level, altitude=altitude)
    ground = [[-9, -9, -9 * slope], [9, -9, 9 * slope], [9, 9, 9 * slope], [-9, 9, -9 * slope]]
    points = simulator(sensor, ground, device).scan(gnosphere.Pose((1, 2, 0.6 + slope))).points
    # From (0, 0, altitude) through (x, y, level) to the plane z = level + slope x.
    ways = np.column_stack([isaac(), np.full(187, level - altitude)])
    lengths = (level - altitude) / (ways[:, 2] - slope * ways[:, 0])
    wanted = np.array([0, 0, altitude]) + lengths[:, None] * ways
    np.testing.assert_allclose(points, wanted, atol=1e-5 * altitude)
    beside = np.linalg.norm(points[:, :2] - isaac(), axis=1)
    bound = np.abs(points[:, 2] - level) / (altitude - level) * np.linalg.norm(isaac(), axis=1)
    assert (beside <= bound + 1e-5 * altitude).all()
    assert beside.max() > 0.5 * bound.max()


def test_impossible_grids_are_refused():
    for size, resolution in (((1, -1), 0.1), ((1, 1), 0.0), ((1, 1), -0.1), ((1, math.inf), 0.1), ((1, 1), math.nan)):
        with pytest.raises(ValueError, match="resolution"):
            patterns.grid(size, resolution)
    with pytest.raises(ValueError, match="below altitude"):
        patterns.grid(SIZE, RESOLUTION, level=20)
    assert patterns.grid((0, 0), 0.1).beam_count() == 1

# SPDX-License-Identifier: Apache-2.0
"""Height scans on level and sloping ground, panoramas, zones and wide beams, beside closed forms."""

import math
import re
from pathlib import Path

import numpy as np
import pytest

import gnosphere
from gnosphere import Effects, Field, patterns

SIZE, RESOLUTION = (1.6, 1.0), 0.1


def simulator(sensor: gnosphere.Sensor, corners: list, device: gnosphere.DeviceChoice) -> gnosphere.Simulator:
    """A square of two triangles."""
    mesh = gnosphere.Mesh(np.float32(corners), [[0, 1, 2], [0, 2, 3]], [gnosphere.MeshPart(0, 2, 0)])
    scene = gnosphere.Scene([gnosphere.Material()], [mesh], [gnosphere.Instance(0)])
    return gnosphere.Simulator(
        scene, gnosphere.SensorRequest(sensor, Effects.none()), gnosphere.SimulatorOptions(device)
    )


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
    for level in (20, math.nan, -math.inf):
        with pytest.raises(ValueError, match="below altitude"):
            patterns.grid(SIZE, RESOLUTION, level=level)
    assert patterns.grid((0, 0), 0.1).beam_count() == 1


def test_a_panorama_has_equal_steps_in_front_of_the_head_and_behind_it(device):
    step = 0.02  # radians
    sensor = patterns.panorama(0.2, at=10)
    low = math.ceil((90 + 60) / math.degrees(step)) - 1  # steps from the zenith down to -60 degrees
    assert low == 130
    assert (sensor.columns, len(sensor.channels)) == (157, 2 * low + 1)
    assert sensor.rotation_period == 0
    zenith = math.pi / 2 - step * np.abs(np.arange(-low, low + 1))
    azimuth = np.arange(157) * math.pi / 157
    behind = np.where(np.arange(2 * low + 1) > low, math.pi, 0)
    e, a = np.meshgrid(zenith, azimuth, indexing="ij")
    a = a + behind[:, None]
    ways = np.stack([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)], axis=-1)
    np.testing.assert_allclose(gnosphere.beams_of(sensor).directions.reshape(ways.shape), ways, atol=1e-6)
    assert math.acos(ways[0, 0] @ ways[1, 0]) == pytest.approx(step)
    # A floor that is wider than the beams reach below 60 degrees: 2 m under the head.
    floor = [[-99, -99, -2], [99, -99, -2], [99, 99, -2], [-99, 99, -2]]
    scan = simulator(sensor, floor, device).scan(gnosphere.Pose((0, 0, 0)))
    assert scan.shape == (261, 157)
    ranges = -2 / np.minimum(ways[..., 2], -1e-9)
    np.testing.assert_allclose(scan.ranges.reshape(261, 157), np.where(ranges > 100, np.nan, ranges), rtol=1e-5)


def test_the_file_of_a_panorama_is_read_back(tmp_path):
    sensor = patterns.panorama(0.2, at=10)
    (tmp_path / "panorama.json").write_text(gnosphere.to_json(sensor))
    read = gnosphere.load_sensor(tmp_path / "panorama.json")
    assert np.array_equal(gnosphere.beams_of(read).directions, gnosphere.beams_of(sensor).directions)


def test_parts_of_a_panorama_are_the_whole():
    resolution = 10 * math.pi / 160  # 1.125 degrees

    def part(*turn: float) -> gnosphere.Sensor:
        return patterns.panorama(resolution, at=10, elevation=(-40, 30), turn=turn)

    assert [(one.elevation_deg, one.azimuth_offset_deg) for one in part(0, 45).channels] == [
        (pytest.approx(30 - 1.125 * (62 - row if row <= 62 else row - 63)), 0 if row <= 62 else 180)
        for row in range(126)
    ]
    whole = gnosphere.beams_of(part(-90, 90)).directions.reshape(126, 160, 3)
    parts = [gnosphere.beams_of(part(start, start + 45)).directions.reshape(126, 40, 3) for start in range(-90, 90, 45)]
    np.testing.assert_allclose(np.concatenate(parts, axis=1), whole, atol=1e-6)


@pytest.mark.parametrize(
    "wrong",
    [
        {"resolution": 0},
        {"at": -1},
        {"elevation": (20, 20)},
        {"elevation": (-91, 0)},
        {"elevation": (0, 91)},
        {"turn": (0, 0)},
        {"turn": (0, 181)},
        {"resolution": math.nan},
    ],
)
def test_impossible_panoramas_are_refused(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong)) if "at" not in wrong else "resolution"):
        patterns.panorama(**({"resolution": 0.006, "at": 10} | wrong))


def test_zones_are_organised_from_the_upper_left_one(device):
    sensor = patterns.zones(8, 4, 45, 20)
    angles = gnosphere.beams_of(sensor)
    ways = angles.directions.reshape(4, 8, 3).astype(float)
    azimuths, elevations = np.degrees(np.arctan2(ways[..., 1], ways[..., 0])), np.degrees(np.arcsin(ways[..., 2]))
    wanted = np.meshgrid(45 / 8 * (3.5 - np.arange(8)), 5 * (1.5 - np.arange(4)))
    np.testing.assert_allclose([azimuths, elevations], wanted, atol=1e-5)
    assert sensor.divergence_horizontal == pytest.approx(math.radians(45 / 8))
    assert sensor.divergence_vertical == pytest.approx(math.radians(5))
    wall = simulator(sensor, [[2, -9, -9], [2, 9, -9], [2, 9, 9], [2, -9, 9]], device)
    scan = wall.scan(gnosphere.Pose((0, 0, 0)))
    assert scan.shape == (4, 8)
    np.testing.assert_allclose(scan.ranges.reshape(4, 8), 2 / ways[..., 0], rtol=1e-5)


def test_impossible_zones_are_refused():
    for wrong in ((0, 8, 45, 45), (8, -1, 45, 45), (8, 8, 0, 45), (8, 8, 45, 181), (8, 8, math.nan, 45)):
        with pytest.raises(ValueError, match="zones"):
            patterns.zones(*wrong)
    with pytest.raises(gnosphere.Error, match="196.3.* so a wider beam is a list of several: docs/limits.md"):
        patterns.zones(4, 4, 45, 45)


def test_the_beam_of_docs_limits_above_a_floor_is_the_integral_over_its_cone(device):
    """8 cm above a floor of 17 %, 2.5 m in front of a wall of 88 %; and 3.5 m in front of one that is too dark."""
    page = (Path(__file__).parents[2] / "docs" / "limits.md").read_text()
    block = re.search(r"^```python\n(.*?)^```$", page, re.M | re.S)[1]
    corners = [
        [[-1, -10, -0.08], [29, -10, -0.08], [29, 10, -0.08], [-1, 10, -0.08]],
        [[2.5, -3, -3], [2.5, 3, -3], [2.5, 3, 3], [2.5, -3, 3]],
    ]
    meshes = [
        gnosphere.Mesh(np.float32(four), [[0, 1, 2], [0, 2, 3]], [gnosphere.MeshPart(0, 2, kind)])
        for kind, four in enumerate(corners)
    ]
    materials = [gnosphere.Material("floor"), gnosphere.Material("wall")]
    scene = gnosphere.Scene(materials, meshes, [gnosphere.Instance(0), gnosphere.Instance(1)])

    def measured(wall: float, pose: gnosphere.Pose) -> dict:
        rows = [gnosphere.MaterialTable.Row("floor", 0.17), gnosphere.MaterialTable.Row("wall", wall)]
        options = gnosphere.SimulatorOptions(device, materials=gnosphere.MaterialTable(rows))
        names = {"np": np, "gnosphere": gnosphere, "scene": scene, "options": options, "pose": pose}
        exec(compile(block, "docs/limits.md", "exec"), names)
        return names

    names = measured(0.88, gnosphere.Pose())

    # Lines of a cone of 13.5 degrees, evenly spread over its cross-section.
    across = np.stack(np.meshgrid(*2 * [np.linspace(-1, 1, 601)]), axis=-1).reshape(-1, 2)
    across = math.tan(math.radians(13.5)) * across[(across**2).sum(axis=1) <= 1]
    ways = np.column_stack([np.ones(len(across)), across])
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    to_wall, to_floor = 2.5 / ways[:, 0], np.where(ways[:, 2] < 0, -0.08 / np.minimum(ways[:, 2], -1e-9), np.inf)
    ranges = np.minimum(to_wall, to_floor)
    powers = np.where(to_floor < to_wall, -0.17 * ways[:, 2], 0.88 * ways[:, 0]) / ranges**2
    integral = powers @ ranges / powers.sum()
    assert integral == pytest.approx(1.98, abs=0.005)
    assert names["distance"] == pytest.approx(integral, abs=0.005)
    assert names["powers"].mean() == pytest.approx(powers.mean(), rel=0.05)
    assert np.fmin.reduce(names["scan"].ranges) == pytest.approx(0.36, abs=0.01)

    assert measured(0.15, gnosphere.Pose((-1, 0, 2)))["distance"] == pytest.approx(3.55, abs=0.01)
    dark = measured(0.05, gnosphere.Pose((-1, 0, 2)))
    assert np.isfinite(dark["scan"].ranges).all() and np.isnan(dark["distance"])

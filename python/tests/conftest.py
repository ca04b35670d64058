# SPDX-License-Identifier: Apache-2.0
"""What the tests share: the command line of the build (GNOSPHERE_PROGRAM), a town, simulators."""

import os
import subprocess
from pathlib import Path

import numpy as np
import pytest

import gnosphere

REPOSITORY = Path(__file__).parents[2]


def program(*arguments: object) -> str:
    """What `gnosphere ARGUMENTS` prints."""
    name = os.environ.get("GNOSPHERE_PROGRAM", "gnosphere")
    return subprocess.run([name, *map(str, arguments)], check=True, capture_output=True, text=True).stdout


@pytest.fixture(scope="session")
def folder(tmp_path_factory) -> Path:
    """A folder with town.glb, and drive.json with what it names."""
    path = tmp_path_factory.mktemp("town")
    program("town", "--triangles", 10000, "-o", path / "town.glb", "--drive", path / "drive.json")
    return path


@pytest.fixture(scope="session")
def town(folder) -> gnosphere.Scene:
    return gnosphere.load_scene(folder / "town.glb")


@pytest.fixture(scope="session")
def device() -> gnosphere.DeviceChoice:
    """The best device, or the reference where there is no Vulkan."""
    if any(info.usable and info.type != "reference" for info in gnosphere.list_devices()):
        return gnosphere.DeviceChoice()
    return gnosphere.device_by_name("reference")


FIELDS = [gnosphere.Field.intensity, gnosphere.Field.normal, gnosphere.Field.class_id, gnosphere.Field.ring]


@pytest.fixture(scope="session")
def simulator(town, device) -> gnosphere.Simulator:
    """A VLP-16 in the town; tests leave it as it is."""
    request = gnosphere.SensorRequest(gnosphere.builtin_sensor("VLP-16"), fields=FIELDS)
    return gnosphere.Simulator(town, request, gnosphere.SimulatorOptions(device))


@pytest.fixture
def pose() -> gnosphere.Pose:
    return gnosphere.Pose((0, 0, 1.8))


@pytest.fixture(scope="session")
def square() -> gnosphere.Mesh:
    """A square of 2 x 2 m, square to the x axis, of two triangles."""
    positions = np.array([[0, -1, -1], [0, 1, -1], [0, 1, 1], [0, -1, 1]], np.float32)
    faces = np.array([[0, 1, 2], [0, 2, 3]], np.uint32)
    return gnosphere.Mesh(positions, faces, [gnosphere.MeshPart(0, 2, 0)], name="square")


def at(x: float) -> gnosphere.Transform:
    return gnosphere.Transform([[1, 0, 0, x], [0, 1, 0, 0], [0, 0, 1, 0]])


def beams(count: int = 9) -> gnosphere.Sensor:
    """`count` beams within 1 degree of the x axis, in its plane with y, 1 ms apart."""
    angles = np.radians(np.linspace(-1, 1, count))
    sensor = gnosphere.Sensor()
    sensor.name = "fan"
    sensor.range_max = 100
    directions = np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1)
    sensor.patterns = [gnosphere.BeamList(directions, times=0.001 * np.arange(count))]
    return sensor


@pytest.fixture
def reference(square) -> gnosphere.Simulator:
    """The square 10 m ahead of a fan of beams, on the reference, which needs no Vulkan. It may be changed."""
    scene = gnosphere.Scene([gnosphere.Material("grey")], [square], [gnosphere.Instance(0, at(10))])
    return gnosphere.Simulator(
        scene,
        gnosphere.SensorRequest(beams(), gnosphere.Effects.none(), [gnosphere.Field.class_id]),
        gnosphere.SimulatorOptions(gnosphere.device_by_name("reference")),
    )

# SPDX-License-Identifier: Apache-2.0
"""Every name of the C++ headers is in Python, in snake_case; and every class says what it is."""

import enum
import re
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import REPOSITORY

import gnosphere
import gnosphere.ros2

HEADERS = "animation batch batch_stream effects error layout output plan ros2 scan scene sensor simulator".split()

# What is left out, because Python has something of its own for it, or because it belongs to adopted devices.
LEFT_OUT = {
    "Vec3", "Quaternion",  # tuples
    "ColumnView", "Iterator", "begin",  # NumPy arrays
    "RecordHeader", "instance_count", "first_vertex", "first_instance", "wanted", "rows", "incomplete",
    "BatchStreamOptions", "in_flight", "to_host",  # arguments of BatchStream
    "ResultRing", "SensorPlan",  # of the library alone
    "AdoptedDevice", "Recorder", "Recording", "CallerVertices", "CallerTransforms", "adopted", "layout",
    "PublisherOptions", "qos", "domain", "localhost_only",  # arguments of Publisher
    "driver_named",  # Driver["ouster"]
    "w",  # a quaternion is x, y, z, w
    "add", "entries",  # results are read only; arrays have shapes
}  # fmt: skip
RENAMED = {
    "in": "in_", "range_at10_percent": "range_at_10_percent", "k_no_triangle": "NO_TRIANGLE", "k_no_image": "NO_IMAGE", "k_no_mesh": "NO_MESH",
    "k_no_node": "NO_NODE", "k_no_skin": "NO_SKIN",
}  # fmt: skip


def snake(name: str) -> str:
    return name if name[0].isupper() else re.sub(r"(?<=[a-z0-9])([A-Z])", lambda m: "_" + m[1].lower(), name)


def names_in(header: str) -> set[str]:
    """Types, functions, members and enumerators that a header declares, in snake_case."""
    text = (REPOSITORY / "include" / "gnosphere" / f"{header}.hpp").read_text()
    text = re.sub(r" *//.*", "", text)
    text = re.sub(r"class GNOSPHERE_API (\w+)", r"class \1", text)
    text = re.sub(r"\n private:.*?\n};", "\n};", text, flags=re.S)
    names = set(re.findall(r"^ *(?:struct|class|enum class) (\w+)", text, re.M))
    names |= set(re.findall(r"^ *GNOSPHERE_API (?:static )?[\w:<>,&*\s]+?[\s&*](\w+)\(", text, re.M))
    names |= set(re.findall(r"^  (?!return)[\w:<>]+[\s&*]+(\w+)\([^;{]*\)(?: const)?(?: noexcept)? ?[;{]", text, re.M))
    for block in re.findall(r"enum class \w+(?: : \w+)? \{([^}]*)\}", text):
        names |= set(re.findall(r"^\s*(\w+)\s*(?:,|$)", block.replace(",", ",\n"), re.M))
    text = re.sub(r"enum class \w+(?: : \w+)? \{[^}]*\}", "Enumeration", text)
    for line in text.splitlines():  # members: indented, a type, then names with defaults
        member = re.fullmatch(
            r" {2,4}(?!return|using|friend|static|template|const auto)([\w:]+(?:<.*>)?) ([^()]+);", line
        )
        if member and not line.startswith("     "):
            names |= set(
                re.findall(r"(?:^|, )(\w+)(?= =|,|$| \{)", re.sub(r"\{[^}]*\}|= [^,]+", "", member[2]).strip())
            )
    return {snake(name) for name in names if re.fullmatch(r"[A-Za-z]\w*[a-z0-9]|[a-z]", name)} - LEFT_OUT


def names_of(holder: object, depth: int = 0) -> set[str]:
    names = {name for name in dir(holder) if not name.startswith("__")}
    for name in list(names):
        value = getattr(holder, name)
        if isinstance(value, type) and depth < 3:
            names |= names_of(value, depth + 1)
    return names


@pytest.mark.parametrize("header", HEADERS)
def test_every_name_of_a_header_is_there(header):
    wanted = {RENAMED.get(name, name) for name in names_in(header)}
    assert len(wanted) > (5 if header in ("animation", "batch", "batch_stream", "error", "layout") else 20)
    assert not sorted(wanted - names_of(gnosphere.ros2 if header == "ros2" else gnosphere))


def test_the_headers_are_all_of_them():
    there = {path.stem for path in (REPOSITORY / "include" / "gnosphere").glob("*.hpp")}
    # In Python the options of the tables are properties and keywords.
    assert there - {"export", "gnosphere", "vulkan", "options"} == set(HEADERS)


def test_functions_have_docstrings():
    for name in sorted(set(dir(gnosphere)) - {"drive", "field_info", "annotations"}):
        value = getattr(gnosphere, name)
        if name.startswith("_") or not callable(value) or isinstance(value, type):
            continue
        text = value.__doc__.split("\n", 1)
        assert len(value.__doc__) > 60, name
        assert len(text) == 2 and text[1].strip(), f"{name} has no docstring beyond its signature"


def test_the_package_ships_its_types():
    package = Path(gnosphere.__file__).parent
    assert (package / "py.typed").exists()
    stub = (package / "_gnosphere" / "__init__.pyi").read_text()
    assert "def scan(self, pose: Pose, sensor: int = 0) -> Scan:" in stub
    assert "def points(self) -> Annotated[NDArray[numpy.float32], dict(shape=(None, 3))]:" in stub


def test_objects_show_themselves(town, simulator):
    for name, kind in vars(gnosphere).items():
        if isinstance(kind, type) and not issubclass(kind, (Exception, enum.Enum)):
            assert kind.__repr__ is not object.__repr__, name
    sensor = gnosphere.Sensor(name="mast", range_max=50, channels=[gnosphere.Channel(3.5)], columns=90)
    assert repr(sensor) == "Sensor(name='mast', columns=90, range_max=50, channels=(Channel(elevation_deg=3.5),))"
    fog = gnosphere.Effects(fog=gnosphere.Effects.Fog(visibility=80), seed=7)
    assert (fog.fog.visibility, fog.seed) == (80, 7) and re.search(r"fog=Fog\(visibility=80\)", repr(fog))
    assert repr(gnosphere.Sensor()) == "Sensor()" and repr(gnosphere.Effects()) == "Effects()"
    assert re.fullmatch(r"Scene\(materials=<\d+ Material>, meshes=<\d+ Mesh>, instances=<\d+ Instance>.*\)", repr(town))
    assert re.fullmatch(r"Mesh\(name='.*', origin=.*, positions=<\d+ x 3 float32>, .*\)", repr(town.meshes[0]))
    assert repr(simulator) == f"Simulator(device={simulator.device().name!r})"
    assert repr(simulator.plan().effects[0]).startswith("Decision(effect='")


def test_import_of_all_names_brings_no_names_of_others():
    names = {}
    exec("from gnosphere import *", names)
    assert "Scan" in names and not {"importlib", "TYPE_CHECKING", "sys", "numpy"} & set(names)


@pytest.mark.parametrize("module", "adapter drive helios patterns pictures primitives robotics ros2".split())
def test_a_module_that_needs_no_other_package_is_there_by_its_name(module):
    """In a process of its own: once a module is imported anywhere, the package has it."""
    code = f"import gnosphere; print(gnosphere.{module}.__doc__[:9])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0 and done.stdout.strip(), done.stderr

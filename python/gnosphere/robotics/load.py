# SPDX-License-Identifier: Apache-2.0
"""Reads a robot or a world by the reader of its format."""

from __future__ import annotations

import importlib
import os
import xml.etree.ElementTree as ET
from collections.abc import Mapping
from pathlib import Path
from typing import Optional, Union

from .. import adapter, primitives
from .resources import Folders, Resources, parse_xml
from .robot_scene import Joints, Parts, RobotScene

USD = (".usd", ".usda", ".usdc", ".usdz")
READERS = {"robot": "urdf", "sdf": "sdf", "gazebo": "sdf", "mujoco": "mjcf"}
"""The reader of an XML file by its outermost element."""
PACKAGES = {"urdf": "yourdfpy", "mjcf": "mujoco", "usd": "usd-core"}


def load(
    file: Union[str, Path],
    *,
    joints: Optional[Joints] = None,
    search: Folders = (),
    classes: Optional[Mapping[str, int]] = None,
    collisions: bool = False,
    tolerance: float = 1e-3,
) -> RobotScene:
    """Reads URDF, SDF, MJCF or USD.

    joints: positions of joints by name, radians or metres; the others are at 0, those of MJCF where the model says. In
        SDF the name of a joint may be with its model's, 'model::joint'.
    search: a folder of packages and models, or several, for package://NAME/... and model://NAME/...; after them those
        of the variables ROS_PACKAGE_PATH, AMENT_PREFIX_PATH, GZ_SIM_RESOURCE_PATH and GAZEBO_MODEL_PATH, and the
        folders around the file.
    classes: class numbers by patterns of the names of links, visuals, meshes or materials, such as {"wheel*": 3}. The
        longest pattern that fits counts, as in drive files; of equally long ones it is the last.
    collisions: whether what collides is read in place of what is seen.
    tolerance: metres: how deep the triangles of curved shapes may lie inside them. Raises ValueError unless it is
        finite and above 0.

    What cannot be there is one warning that names it, and RobotScene.left_out; RobotScene.assumed has what lidars do not
    state.
    """
    primitives.check_tolerance(tolerance)
    path = Path(file)
    reader = "usd" if path.suffix.lower() in USD else _xml_reader(path)
    try:
        module = importlib.import_module(f".{reader}", __package__)
    except ImportError as error:
        package = PACKAGES.get(reader)
        if package is None:
            raise
        raise ImportError(f"{path} is read by the package {package}: pip install {package}") from error
    parts = Parts(classes)
    resources = Resources(path, search, parts, tolerance)
    try:
        frames, limits = module.read(path, parts, resources, collisions)
    except (ValueError, ET.ParseError) as error:
        raise ValueError(f"{path}: {error}") from error
    except RecursionError as error:
        raise ValueError(f"{path}: elements or frames are nested too deep") from error
    result = RobotScene(parts, frames, joints or {}, limits)
    adapter.warn_left_out(os.fspath(path), parts.left_out)
    return result


def _xml_reader(path: Path) -> str:
    try:
        tag = parse_xml(path).tag.rsplit("}")[-1]
    except ET.ParseError as error:
        raise ValueError(f"{path} is neither USD by its ending nor XML: {error}") from error
    if path.suffix.lower() == ".xacro":
        raise ValueError(f"{path} is xacro: run 'xacro {path.name} > robot.urdf' first")
    if tag not in READERS:
        raise ValueError(f"{path} is XML of <{tag}>; <robot> (URDF), <sdf>, <mujoco> and USD files are read")
    return READERS[tag]

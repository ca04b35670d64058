# SPDX-License-Identifier: Apache-2.0
"""<sensor> elements of SDF, also inside <gazebo> of URDF; and the numbers and poses of their kind."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from typing import Any, Optional

import numpy as np

from .. import _gnosphere as gno
from .. import adapter
from .resources import rotation
from .robot_scene import Matrix, Parts

KINDS = ("lidar", "ray", "gpu_lidar", "gpu_ray")


def numbers(text: Optional[str], default: Any) -> Any:
    """The numbers of a text as an array, or `default` if there is none."""
    return np.array(text.split(), np.float64) if text and text.strip() else np.asarray(default, np.float64)


def number(parent: Optional[ET.Element], name: str, default: float) -> float:
    text = parent.findtext(name) if parent is not None else None
    return float(text) if text and text.strip() else default


def pose_of(element: Optional[ET.Element]) -> Matrix:
    """The map (4, 4) of a <pose>; the identity if there is none."""
    result = np.eye(4)
    if element is None:
        return result
    values = numbers(element.text, np.zeros(6))
    if element.get("rotation_format") == "quat_xyzw":
        return adapter.rows_of(gno.Pose(tuple(values[:3].tolist()), tuple(values[3:7].tolist())))
    if len(values) != 6:
        raise ValueError(f"a <pose> has {len(values)} numbers; it must have 6")
    angles = np.radians(values[3:]) if element.get("degrees", "").strip() in ("true", "1") else values[3:]
    result[:3, :3], result[:3, 3] = rotation(*angles), values[:3]
    return result


def is_lidar(sensor: ET.Element) -> bool:
    return sensor.get("type") in KINDS or any(sensor.find(kind) is not None for kind in ("lidar", "ray"))


def mount(sensor: ET.Element, parts: Parts, name: str, frame: Any, frame_to_sensor: Optional[Matrix] = None) -> None:
    """Adds the lidar of a <sensor>, whose <pose> is relative to the frame unless a map is given."""
    try:
        file = gno.read_sensor_file(ET.tostring(sensor), sensor.get("name", "lidar"))
    except gno.Error as error:
        parts.leave_out(f"the lidar {error}")
        return
    for what in file.ignored:
        if not what.startswith(("pose", "update_rate", "the last column")):
            parts.leave_out(f"{what} '{name}'")
    local = pose_of(sensor.find("pose")) if frame_to_sensor is None else frame_to_sensor
    parts.mount(file.sensor, name, frame, local, number(sensor, "update_rate", 0.0))

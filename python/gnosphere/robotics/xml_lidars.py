# SPDX-License-Identifier: Apache-2.0
"""Lidars of <sensor> elements of SDF, also inside <gazebo> of URDF, and the values of XML: numbers, axes, poses."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from typing import Any, Optional

import numpy as np

from .. import _gnosphere as gno
from .. import adapter
from .resources import rotation
from .robot_scene import Matrix, Parts

KINDS = ("lidar", "ray", "gpu_lidar", "gpu_ray")


def numbers(text: Optional[str], default: Any, what: str, counts: tuple[int, ...] = ()) -> Any:
    """The numbers of a text as an array, or `default` if there is none. Raises ValueError that begins with `what` for
    what is no finite number, and for a count that is neither that of `default` nor one of `counts`."""
    if not text or not text.strip():
        return np.asarray(default, np.float64)
    try:
        values = np.array(text.split(), np.float64)
    except ValueError:
        raise ValueError(f"{what} is '{text.strip()}', which are no numbers") from None
    wanted = counts or (len(default),)
    if len(values) not in wanted:
        raise ValueError(f"{what} has {len(values)} numbers; it must have {' or '.join(map(str, wanted))}")
    if not np.isfinite(values).all():
        raise ValueError(f"{what} is '{text.strip()}'; its numbers must be finite")
    return values


def axis_of(text: Optional[str], default: tuple[float, float, float], joint: Optional[str]) -> Matrix:
    """The unit vector along the axis of a joint. Raises ValueError if the text has no direction."""
    axis = numbers(text, default, f"the axis of the joint '{joint}'")
    if not axis.any():
        raise ValueError(f"the axis of the joint '{joint}' is 0 0 0, which has no direction")
    unit: Matrix = axis / np.linalg.norm(axis)
    return unit


def number(parent: Optional[ET.Element], name: str, default: float) -> float:
    text = parent.findtext(name) if parent is not None else None
    if not text or not text.strip():
        return default
    try:
        return float(text)
    except ValueError:
        raise ValueError(f"<{name}> is '{text.strip()}', which is no number") from None


def pose_of(element: Optional[ET.Element]) -> Matrix:
    """The map (4, 4) of a <pose>; the identity if there is none."""
    result = np.eye(4)
    if element is None:
        return result
    if element.get("rotation_format") == "quat_xyzw":
        values = numbers(element.text, (0, 0, 0, 0, 0, 0, 1), "a <pose>")
        return adapter.rows_of(gno.Pose(values[:3], values[3:]))
    values = numbers(element.text, np.zeros(6), "a <pose>")
    angles = np.radians(values[3:]) if element.get("degrees", "").strip() in ("true", "1") else values[3:]
    result[:3, :3], result[:3, 3] = rotation(*angles), values[:3]
    return result


def is_lidar(sensor: ET.Element) -> bool:
    return sensor.get("type") in KINDS or any(sensor.find(kind) is not None for kind in ("lidar", "ray"))


def leave_out_sonar(sensor: ET.Element, parts: Parts, name: str) -> None:
    """Tells that a <sensor> is left out if it is a sonar."""
    if sensor.get("type") == "sonar" or sensor.find("sonar") is not None:
        parts.leave_out(f"the sonar '{name}', whose wide beam would be a list of beams: docs/limits.md")


def mount(sensor: ET.Element, parts: Parts, name: str, frame: Any, frame_to_sensor: Optional[Matrix] = None) -> None:
    """Adds the lidar of a <sensor>, whose <pose> is relative to the frame unless a map is given."""
    try:
        file = gno.read_sensor_file(ET.tostring(sensor), sensor.get("name", "lidar"))
    except gno.Error as error:
        parts.leave_out(f"the lidar {error}")
        return
    for what in file.ignored:
        head, which, effect = what.partition(", which the effect")
        if what.startswith("the last column"):
            parts.leave_out(f"of '{name}' {what}")
        elif not what.startswith("pose"):
            parts.leave_out(f"{head} '{name}'{which}{effect}")
    parts.assume(file, name)
    local = pose_of(sensor.find("pose")) if frame_to_sensor is None else frame_to_sensor
    parts.mount(file.sensor, name, frame, local, number(sensor, "update_rate", 0.0))

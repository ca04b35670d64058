# SPDX-License-Identifier: Apache-2.0
"""OmniLidar prims of Isaac Sim: their attributes as text, for the reader of sensor files."""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from .. import _gnosphere as gno
from .resources import Resources
from .robot_scene import Matrix, Parts

PREFIX = "omni:sensor:Core:"


def is_lidar(prim: Any) -> bool:
    return prim.GetTypeName() == "OmniLidar" or _config(prim) != ""


def _config(prim: Any) -> str:
    """The profile that a Camera prim names, as Isaac Sim's lidars did before version 5."""
    attribute = prim.GetAttribute("sensorModelConfig") if prim.GetTypeName() == "Camera" else None
    return str(attribute.Get() or "") if attribute else ""


def _text(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value)
    if np.ndim(value) == 0:
        return repr(float(value))
    if np.ndim(value) == 1 and not isinstance(value[0] if len(value) else 0, str):
        return "[" + ", ".join(repr(float(number)) for number in value) + "]"
    return "(0, 0)"  # a pair, or texts: what the reader lists as not held


def mount(prim: Any, parts: Parts, resources: Resources, place: Matrix, time: Any) -> None:
    name, path = prim.GetName(), prim.GetPath().pathString
    try:
        if config := _config(prim):
            found = resources.find(f"{config}.json") or resources.find(config)
            if found is None:
                return parts.leave_out(f"the lidar {path}, whose profile {config}.json is not found")
            file = gno.read_sensor_file(found)
        else:
            values = {a.GetName(): a.Get(time) for a in prim.GetAttributes() if a.GetName().startswith(PREFIX)}
            lines = [f"{key} = {_text(value)}" for key, value in values.items() if value is not None]
            text = "#usda 1.0\ndef OmniLidar\n{\n" + "\n".join(lines) + "\n}\n"
            file = gno.read_sensor_file(text.encode(), f"{name}.usda")
    except gno.Error as error:
        return parts.leave_out(f"the lidar {path}: {error}")
    if file.ignored:
        parts.leave_out(f"of the lidar {path}: {', '.join(file.ignored)}")
    parts.assume(file, path)
    turn = place.copy()
    turn[:3, :3] /= np.linalg.norm(place[:3, :3], axis=0)
    period = file.sensor.scan_period or file.sensor.rotation_period
    parts.mount(file.sensor, name, path, turn, 1 / period if period > 0 else 0.0)

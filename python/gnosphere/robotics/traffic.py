# SPDX-License-Identifier: Apache-2.0
"""Traffic as actors of a drive: SUMO's FCD output, and the trajectories of OpenSCENARIO XML."""

from __future__ import annotations

import math
import os
import xml.etree.ElementTree as ET
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Optional, Union

from .. import adapter

Actor = dict[str, Any]
Track = tuple[str, str, list[Actor]]
"""Name, type, and waypoints."""


def read_traffic(
    file: Union[str, Path],
    models: Mapping[str, str],
    classes: Optional[Mapping[str, str]] = None,
    lengths: Optional[Mapping[str, float]] = None,
) -> list[Actor]:
    """The "actors" of a drive file, who are gone before their first and after their last time.

    models, classes: the model and the class of the drive file by patterns of the type: in SUMO that of the vehicle or
        person, in OpenSCENARIO its category, such as car or pedestrian. The longest pattern that fits counts, of
        equally long ones the last; the class is the model if none does, and who fits no pattern of models is left out,
        with a warning.
    lengths: metres, by the same patterns. SUMO places a vehicle by the middle of its front, so it is shifted back by
        half of its length.
    """
    path = Path(file)
    try:
        root = ET.parse(path).getroot()
    except ET.ParseError as error:
        raise ValueError(f"{path} is not XML: {error}") from error
    readers = {"fcd-export": _sumo, "OpenSCENARIO": _open_scenario}
    if root.tag not in readers:
        raise ValueError(f"{path} is XML of <{root.tag}>; SUMO's <fcd-export> and <OpenSCENARIO> are read")
    left_out = Counter[str]()
    actors = []
    for name, kind, waypoints in readers[root.tag](root, lengths or {}, left_out):
        model = adapter.of_longest_pattern(models, kind)
        if model is None:
            left_out[f"the type '{kind}'"] += 1
            continue
        actors.append(
            {
                "name": name,
                "model": model,
                "class": adapter.of_longest_pattern(classes or {}, kind) or model,
                "trajectory": {"waypoints": waypoints},
                "outside": "gone",
            }
        )
    adapter.warn_left_out(os.fspath(path), left_out)
    return actors


def _waypoint(time: float, position: tuple[float, float, float], yaw_deg: float) -> Actor:
    return {"time": time, "position": [round(value, 4) for value in position], "yaw_deg": round(yaw_deg, 3)}


def _sumo(root: ET.Element, lengths: Mapping[str, float], left_out: Counter[str]) -> Iterator[Track]:
    """SUMO's angles are clockwise from north, which is y."""
    tracks: dict[str, Track] = {}
    for step in root.iter("timestep"):
        for thing in step:
            if thing.tag not in ("vehicle", "person"):
                continue
            name, kind = thing.get("id", ""), thing.get("type", thing.tag)
            yaw = 90 - float(thing.get("angle", "90"))
            back = (adapter.of_longest_pattern(lengths, kind) or 0.0) / 2 if thing.tag == "vehicle" else 0.0
            x = float(thing.get("x", "nan")) - back * math.cos(math.radians(yaw))
            y = float(thing.get("y", "nan")) - back * math.sin(math.radians(yaw))
            point = _waypoint(float(step.get("time", "0")), (x, y, float(thing.get("z", "0"))), yaw)
            tracks.setdefault(name, (name, kind, []))[2].append(point)
    yield from tracks.values()


def _open_scenario(root: ET.Element, lengths: Mapping[str, float], left_out: Counter[str]) -> Iterator[Track]:
    kinds = {}
    for thing in root.iter("ScenarioObject"):
        shape = next((child for child in thing if child.tag in ("Vehicle", "Pedestrian", "MiscObject")), None)
        kind = "" if shape is None else shape.get(f"{shape.tag[0].lower()}{shape.tag[1:]}Category", shape.tag.lower())
        kinds[thing.get("name", "")] = kind
    tracks: dict[str, Track] = {}
    for group in root.iter("ManeuverGroup"):
        names = [reference.get("entityRef", "") for reference in group.iter("EntityRef")]
        for trajectory, offset, scale in _trajectories(group, left_out):
            waypoints = []
            for vertex in trajectory.iter("Vertex"):
                place = vertex.find("Position/WorldPosition")
                if place is None or vertex.get("time") is None:
                    left_out["vertices without a time or a WorldPosition"] += 1
                    continue
                x, y, z, turn = (float(place.get(key, "0")) for key in "xyzh")
                time = scale * float(vertex.get("time", "0")) + offset
                waypoints.append(_waypoint(time, (x, y, z), math.degrees(turn)))
            for name in names if waypoints else ():
                tracks.setdefault(name, (name, kinds.get(name, ""), []))[2].extend(waypoints)
            for curve in trajectory.iter("Shape"):
                if curve.find("Polyline") is None:
                    left_out["trajectories that are no polylines"] += 1
    for name, kind, waypoints in tracks.values():
        yield name, kind, sorted(waypoints, key=lambda waypoint: waypoint["time"])


def _trajectories(group: ET.Element, left_out: Counter[str]) -> Iterator[tuple[ET.Element, float, float]]:
    """The trajectories that actors follow, with what is added to their times, in seconds, after these are scaled."""
    for action in group.iter("FollowTrajectoryAction"):
        timing = action.find("TimeReference/Timing")
        offset, scale = 0.0, 1.0
        if timing is not None:
            offset, scale = float(timing.get("offset", "0")), float(timing.get("scale", "1"))
            if timing.get("domainAbsoluteRelative") == "relative":
                left_out["the starts of trajectories with relative times, which are taken as 0"] += 1
        for trajectory in action.iter("Trajectory"):
            yield trajectory, offset, scale

# SPDX-License-Identifier: Apache-2.0
"""Traffic as actors of a drive: SUMO's FCD output, and the trajectories of OpenSCENARIO XML."""

from __future__ import annotations

import cmath
import math
import os
import statistics
import xml.etree.ElementTree as ET
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from itertools import chain
from pathlib import Path
from typing import Any, NamedTuple, Optional, Union

from .. import adapter
from .resources import rotation

Actor = dict[str, Any]
Place = tuple[float, float, float]


class Track(NamedTuple):
    """An actor before it has a model."""

    name: str
    kind: str
    waypoints: list[Actor]
    needs_length: bool = False


def read_traffic(
    file: Union[str, Path],
    models: Mapping[str, str],
    classes: Optional[Mapping[str, str]] = None,
    lengths: Optional[Mapping[str, float]] = None,
    network: Optional[Union[str, Path]] = None,
    centred: bool = True,
) -> list[Actor]:
    """The "actors" of a drive file. Those of SUMO are gone before their first and after their last time; those of
    OpenSCENARIO stand there.

    models, classes: the model and the class of the drive file by patterns of the type: in SUMO that of the vehicle or
        person, in OpenSCENARIO its category, such as car or pedestrian, or its entry in a catalogue. The longest
        pattern that fits counts, of equally long ones the last; the class is the model if none does, and who fits no
        pattern of models is left out, with a warning.
    lengths: metres, by the same patterns. SUMO places a vehicle by the middle of its front, so it is shifted back by
        half of its length. A warning names the types of vehicles that no pattern fits.
    network: the OpenDRIVE file (.xodr) or the SUMO network (.net.xml) in whose own coordinates the traffic is. The
        offset of its header, or its netOffset, moves the traffic to where the network lies on the map, as it moves a
        town.
    centred: OpenSCENARIO places an entity by its origin, for vehicles the middle of the rear axle. If true, the middle
        of its bounding box is in its place, as far as the file states it, because this is where models have theirs.
    """
    path = Path(file)
    try:
        root = ET.parse(path).getroot()
    except ET.ParseError as error:
        raise ValueError(f"{path} is not XML: {error}") from error
    if root.tag not in ("fcd-export", "OpenSCENARIO"):
        raise ValueError(f"{path} is XML of <{root.tag}>; SUMO's <fcd-export> and <OpenSCENARIO> are read")
    is_sumo = root.tag == "fcd-export"
    lengths = lengths or {}
    offset = None if network is None else _offset_of(Path(network))
    left_out = Counter[str]()
    actors = []
    try:
        reader = _sumo(root, lengths, left_out) if is_sumo else _open_scenario(root, centred, left_out)
        tracks = list(reader)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error
    for name, kind, waypoints, needs_length in tracks:
        model = adapter.of_longest_pattern(models, kind)
        if model is None:
            left_out[f"the type '{kind}'"] += 1
            continue
        if needs_length and adapter.of_longest_pattern(lengths, kind) is None:
            left_out[f"the lengths of vehicles of the type '{kind}', which are half of it too far ahead"] += 1
        actors.append(
            {
                "name": name,
                "model": model,
                "class": adapter.of_longest_pattern(classes or {}, kind) or model,
                "trajectory": {"waypoints": [_moved(point, offset) for point in waypoints] if offset else waypoints},
                "outside": "gone" if is_sumo else "hold",
            }
        )
    adapter.warn_left_out(os.fspath(path), +left_out)
    return actors


def _waypoint(time: float, position: Iterable[float], yaw: float, pitch: float = 0.0, roll: float = 0.0) -> Actor:
    """A waypoint whose angles are in radians: turns about the fixed axes x (roll), y (pitch) and z."""
    waypoint: Actor = {"time": time, "position": [round(value, 4) for value in position]}
    if pitch or roll:
        turn = adapter.quaternion(rotation(roll, pitch, yaw))
        return {**waypoint, "orientation": [round(float(value), 9) for value in turn]}
    return {**waypoint, "yaw_deg": round(math.degrees(yaw), 3)}


class _Offset(NamedTuple):
    """How a network is moved to its place on the map: by metres, then by radians about the new origin."""

    x: float
    y: float
    z: float
    turn: float


def _offset_of(path: Path) -> _Offset:
    """The offset of an OpenDRIVE file, or of a network of SUMO, which states what was added to make its coordinates."""
    try:
        root = ET.parse(path).getroot()
    except ET.ParseError as error:
        raise ValueError(f"{path} is not XML: {error}") from error
    tag = root.tag.rpartition("}")[2]
    try:
        if tag == "OpenDRIVE":
            offset = root.find("{*}header/{*}offset")
            stated = ET.Element("offset") if offset is None else offset
            return _Offset(*(_number(stated, key) for key in ("x", "y", "z", "hdg")))
        if tag == "net":
            location = root.find("location")
            text = "0,0" if location is None else location.get("netOffset", "0,0")
            x, y = (float(number) for number in text.split(","))
            return _Offset(-x, -y, 0, 0)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error
    raise ValueError(f"{path} is XML of <{tag}>; <OpenDRIVE> and SUMO's <net> have offsets")


def _moved(waypoint: Actor, offset: _Offset) -> Actor:
    cosine, sine = math.cos(offset.turn), math.sin(offset.turn)
    x, y, z = (a + b for a, b in zip(waypoint["position"], offset[:3]))
    place = cosine * x - sine * y, sine * x + cosine * y, z
    moved = {**waypoint, "position": [round(value, 4) for value in place]}
    if "yaw_deg" in waypoint:
        moved["yaw_deg"] = round(waypoint["yaw_deg"] + math.degrees(offset.turn), 3)
    if "orientation" in waypoint:
        (x, y, z, w), c, s = waypoint["orientation"], math.cos(offset.turn / 2), math.sin(offset.turn / 2)
        moved["orientation"] = [round(v, 9) for v in (c * x - s * y, c * y + s * x, c * z + s * w, c * w - s * z)]
    return moved


class _Sighting(NamedTuple):
    """A vehicle or a person of SUMO at a time."""

    time: float
    place: Place
    element: ET.Element


def _sumo(root: ET.Element, lengths: Mapping[str, float], left_out: Counter[str]) -> Iterator[Track]:
    """Vehicles and persons of SUMO have name spaces of their own. One that is absent for some time steps, or
    teleports, has several tracks."""
    step = _regular_step(root)
    parts = {key: _parts(sightings, step) for key, sightings in _sightings(root, left_out).items()}
    _refuse_degrees(parts.values())
    absent = "the ways of vehicles and persons while they are absent or teleport, who go on as further actors"
    for (tag, name), parts_of_one in parts.items():
        left_out[absent] += len(parts_of_one) - 1
        if tag == "person" and ("vehicle", name) in parts:
            name = f"person {name}"
        for number, part in enumerate(parts_of_one, 1):
            kind = part[0].element.get("type", tag)
            length = adapter.of_longest_pattern(lengths, kind) or 0.0
            waypoints = _way_of_vehicle(part, length) if tag == "vehicle" else _way_of_person(part)
            part_name = name if number == 1 else f"{name} part {number}"
            yield Track(part_name, kind, waypoints, needs_length=tag == "vehicle")


def _regular_step(root: ET.Element) -> float:
    """The usual time from one time step of the file to the next."""
    times = [_time(step) for step in root.iter("timestep")]
    for before, after in zip(times, times[1:]):
        if not before < after:
            raise ValueError(f"<timestep time='{after:g}'> does not come after the one before, {before:g}")
    return statistics.median(after - before for before, after in zip(times, times[1:])) if len(times) > 1 else math.inf


def _time(step: ET.Element) -> float:
    if "time" not in step.keys():
        raise ValueError("a <timestep> has no time")
    return _number(step, "time")


def _sightings(root: ET.Element, left_out: Counter[str]) -> dict[tuple[str, str], list[_Sighting]]:
    """The vehicles and persons by tag and id, without persons while they ride."""
    seen: dict[tuple[str, str], list[_Sighting]] = {}
    unseen = set()
    for step in root.iter("timestep"):
        time = _time(step)
        fronts = {_place(vehicle) for vehicle in step.iter("vehicle")}
        for element in step:
            key = element.tag, element.get("id", "")
            if element.tag not in ("vehicle", "person"):
                unseen.add((f"<{element.tag}>", key))
            elif element.tag == "person" and _rides(element, fronts):
                unseen.add(("persons while they ride", key))
            else:
                seen.setdefault(key, []).append(_Sighting(time, _place(element), element))
    left_out.update(what for what, _ in unseen)
    return seen


def _place(element: ET.Element) -> Place:
    return _number(element, "x", None), _number(element, "y", None), _number(element, "z")


def _rides(person: ET.Element, fronts: set[Place]) -> bool:
    """SUMO places riders at the middle of their vehicle's front. The attribute `vehicle`, which it writes on demand, has
    the vehicle's id, and is empty for others."""
    vehicle = person.get("vehicle")
    return _place(person) in fronts if vehicle is None else vehicle != ""


def _parts(sightings: list[_Sighting], step: float) -> list[list[_Sighting]]:
    """The sightings in parts in which no time step is missing, and nothing teleports. Who is in the file less often than
    its steps has steps of its own."""
    parts = [sightings[:1]]
    if len(sightings) > 2:
        step = max(step, statistics.median_low(now.time - before.time for before, now in zip(sightings, sightings[1:])))
    for before, now in zip(sightings, sightings[1:]):
        if now.time - before.time > 1.5 * step or _teleports(before, now):
            parts.append([])
        parts[-1].append(now)
    return parts


def _teleports(before: _Sighting, now: _Sighting) -> bool:
    """Whether a vehicle or person is more than 10 m beyond the way that its speed allows, which may change by 10 m/s².
    A teleport of SUMO may take no more than one time step."""
    time = now.time - before.time
    speed = max(_number(sighting.element, "speed", "inf") for sighting in (before, now))
    return math.dist(before.place, now.place) > 10 + speed * time + 5 * time**2


def _refuse_degrees(tracks: Iterable[list[list[_Sighting]]]) -> None:
    """Refuses longitudes and latitudes, which change by a tiny part of the metres that vehicles and persons go. A speed
    that is not stated counts as 1 m/s, unless nothing moves."""
    changed = gone = 0.0
    for part in chain.from_iterable(tracks):
        for before, now in zip(part, part[1:]):
            if change := math.dist(before.place[:2], now.place[:2]):
                changed += change
                gone += (now.time - before.time) * _number(now.element, "speed", "1")
    if changed < 0.01 * gone:
        raise ValueError(
            f"x and y change by {changed:.3g} on ways of {gone:.0f} m, so they are degrees, not metres; "
            "write the FCD without --fcd-output.geo"
        )


def _yaws(part: list[_Sighting]) -> Iterator[float]:
    """SUMO's angles are clockwise from north, which is y. Yaws that follow each other are at most half a turn apart."""
    yaw = 0.0
    for sighting in part:
        yaw += math.remainder(90 - _number(sighting.element, "angle", "90") - yaw, 360)
        yield math.radians(yaw)


def _way_of_vehicle(part: list[_Sighting], length: float) -> list[Actor]:
    """SUMO's slopes are positive uphill, and a pitch is positive downhill."""
    waypoints = []
    for (time, (x, y, z), element), yaw in zip(part, _yaws(part)):
        slope = math.radians(_number(element, "slope"))
        back, down = length / 2 * math.cos(slope), length / 2 * math.sin(slope)
        middle = x - back * math.cos(yaw), y - back * math.sin(yaw), z - down
        waypoints.append(_waypoint(time, middle, yaw, -slope))
    return waypoints


def _way_of_person(part: list[_Sighting]) -> list[Actor]:
    """Persons walk upright. Their slope is that of the road, in its direction."""
    return [_waypoint(sighting.time, sighting.place, yaw) for sighting, yaw in zip(part, _yaws(part))]


def _open_scenario(root: ET.Element, centred: bool, left_out: Counter[str]) -> Iterator[Track]:
    """Entities stand where Init puts them until their trajectories begin, and where these end afterwards."""
    _fill_in_parameters(root)
    tracks: dict[str, Track] = {}
    centres: dict[str, ET.Element] = {}
    of_catalogues = set()
    for thing in root.iter("ScenarioObject"):
        name = thing.get("name", "")
        tracks[name] = Track(name, _kind_of(thing), [])
        if (centre := thing.find("*/BoundingBox/Center")) is not None:
            centres[name] = centre
        if thing.find("CatalogReference") is not None:
            of_catalogues.add(name)
    for group in root.iter("ManeuverGroup"):
        names = [reference.get("entityRef", "") for reference in group.iter("EntityRef")]
        for waypoints in _trajectories(group, left_out):
            for name in names:
                tracks.setdefault(name, Track(name, "", [])).waypoints.extend(waypoints)
    starts: dict[str, Actor] = {}
    for private in root.iterfind("Storyboard/Init/Actions/Private"):
        place = private.find(".//TeleportAction/Position")
        if place is None:
            continue
        world, name = place.find("WorldPosition"), private.get("entityRef", "")
        if world is None:
            left_out["places of Init that are no WorldPosition"] += 1
        else:
            starts[name] = _placed(0.0, world, False, left_out)
    for name, kind, waypoints, _ in tracks.values():
        ordered = _in_order(waypoints, left_out)
        if name in starts:
            ordered = _from_init(starts[name], ordered)
        if centred and name in centres:
            ordered = _by_centre(ordered, _number(centres[name], "x"), _number(centres[name], "y"))
        if centred and ordered and name in of_catalogues:
            left_out["the centres of the boxes of entries in catalogues"] += 1
        if ordered:
            yield Track(name, kind, ordered)
    _count_other_actions(root, {name for name, track in tracks.items() if track.waypoints}, left_out)


_OTHER_ACTIONS = (
    "SpeedAction", "SpeedProfileAction", "LongitudinalDistanceAction", "LaneChangeAction", "LaneOffsetAction",
    "LateralDistanceAction", "SynchronizeAction", "AssignRouteAction", "RandomRouteAction", "AcquirePositionAction",
)  # fmt: skip


def _count_other_actions(root: ET.Element, moving: set[str], left_out: Counter[str]) -> None:
    """Counts the actions that move entities, and that only a simulator of traffic can follow. The speed that Init gives
    to an entity with a trajectory is none of them, nor is a speed of 0."""
    for group in root.iter("ManeuverGroup"):
        for tag in (*_OTHER_ACTIONS, "TeleportAction"):
            left_out[f"<{tag}>"] += len(list(group.iter(tag)))
    for private in root.iterfind("Storyboard/Init/Actions/Private"):
        for tag in _OTHER_ACTIONS:
            for action in private.iter(tag):
                speed = action.find("SpeedActionTarget/AbsoluteTargetSpeed") if tag == "SpeedAction" else None
                stands = speed is not None and _number(speed, "value") == 0
                left_out[f"<{tag}>"] += not stands and (tag != "SpeedAction" or private.get("entityRef") not in moving)


def _by_centre(waypoints: list[Actor], x: float, y: float) -> list[Actor]:
    """The waypoints of the point x, y of an entity, which is so far ahead of its origin and to the left of it."""
    moved = []
    for point, yaw in zip(waypoints, _yaws_along(waypoints)):
        if "orientation" in point:
            i, j, k, w = point["orientation"]
            ahead = 1 - 2 * (j * j + k * k), 2 * (i * j + k * w), 2 * (i * k - j * w)
            left = 2 * (i * j - k * w), 1 - 2 * (i * i + k * k), 2 * (j * k + i * w)
        else:
            yaw = math.radians(point["yaw_deg"]) if "yaw_deg" in point else yaw
            ahead, left = (math.cos(yaw), math.sin(yaw), 0.0), (-math.sin(yaw), math.cos(yaw), 0.0)
        place = [round(p + x * a + y * b, 4) for p, a, b in zip(point["position"], ahead, left)]
        moved.append({**point, "position": place})
    return moved


def _yaws_along(waypoints: list[Actor]) -> list[float]:
    """The yaw at each waypoint of an entity that looks along its way: half-way between those of the ways before and
    after it, and where it stands that of the nearest way before, or else after."""
    ways = []
    for before, after in zip(waypoints, waypoints[1:]):
        x, y = (b - a for a, b in zip(before["position"][:2], after["position"][:2]))
        ways.append(complex(x, y) / abs(complex(x, y)) if x or y else 0)
    yaws = []
    for i in range(len(waypoints)):
        along = sum(ways[max(i - 1, 0) : i + 1]) or next((way for way in (*ways[i::-1], *ways[i:]) if way), 1)
        yaws.append(cmath.phase(along))
    return yaws


def _fill_in_parameters(root: ET.Element) -> None:
    """Puts the values of parameters in place of their names, which begin with $. Other names stay as they are."""
    stated: dict[str, set[str]] = {}
    for parameter in root.iter("ParameterDeclaration"):
        stated.setdefault(parameter.get("name", ""), set()).add(parameter.get("value", ""))
    values = {name: texts.pop() for name, texts in stated.items() if len(texts) == 1}
    for element in root.iter():
        for key, text in element.items():
            for _ in values:  # the value may be the name of another one
                if not text.startswith("$") or text[1:] not in values:
                    break
                text = values[text[1:]]
            element.set(key, text)


def _number(element: ET.Element, key: str, usual: Optional[str] = "0") -> float:
    text = element.get(key, usual)
    if text is None:
        raise ValueError(f"<{element.tag}> has no {key}; SUMO writes it if --fcd-output.attributes names it")
    try:
        value = float(text)
    except ValueError:
        why = "is no number, and no parameter with one value" if text.startswith("$") else "is no number"
        raise ValueError(f"<{element.tag} {key}='{text}'> {why}") from None
    if key in element.keys() and not math.isfinite(value):
        raise ValueError(f"<{element.tag} {key}='{text}'> is not finite")
    return value


def _kind_of(thing: ET.Element) -> str:
    """The category of an entity, or the name of its entry in a catalogue."""
    for child in thing:
        if child.tag in ("Vehicle", "Pedestrian", "MiscObject"):
            return child.get(f"{child.tag[0].lower()}{child.tag[1:]}Category", child.tag.lower())
        if child.tag == "CatalogReference":
            return child.get("entryName", "")
    return ""


def _trajectories(group: ET.Element, left_out: Counter[str]) -> Iterator[list[Actor]]:
    """The waypoints of the trajectories that actors follow."""
    for action in group.iter("FollowTrajectoryAction"):
        timing = action.find("TimeReference/Timing")
        mode = action.find("TrajectoryFollowingMode")
        along = mode is not None and mode.get("followingMode") == "follow"
        offset, scale = 0.0, 1.0
        if timing is not None:
            offset, scale = _number(timing, "offset"), _number(timing, "scale", "1")
            if timing.get("domainAbsoluteRelative") == "relative":
                left_out["the starts of trajectories with relative times, which are taken as 0"] += 1
        left_out["trajectories of catalogues"] += len(list(action.iter("CatalogReference")))
        for trajectory in action.iter("Trajectory"):
            left_out["trajectories that are no polylines"] += sum(
                curve.find("Polyline") is None for curve in trajectory.iter("Shape")
            )
            waypoints = []
            for vertex in trajectory.iter("Vertex"):
                place = vertex.find("Position/WorldPosition")
                if place is None or vertex.get("time") is None:
                    left_out["vertices without a time or a WorldPosition"] += 1
                    continue
                waypoints.append(_placed(scale * _number(vertex, "time") + offset, place, along, left_out))
            if waypoints and action.find("TimeReference/None") is not None:
                left_out["TimeReference None, so the times of vertices count all the same"] += 1
            yield waypoints


def _placed(time: float, place: ET.Element, along: bool, left_out: Counter[str]) -> Actor:
    """A waypoint at a WorldPosition. If `along`, one without a heading looks along its way."""
    x, y, z, yaw, pitch, roll = (_number(place, key) for key in "xyzhpr")
    if not along or place.get("h") is not None:
        return _waypoint(time, (x, y, z), yaw, pitch, roll)
    if pitch or roll:
        left_out["the pitch and the roll of vertices without a heading"] += 1
    waypoint = _waypoint(time, (x, y, z), yaw)
    del waypoint["yaw_deg"]
    return waypoint


def _from_init(start: Actor, waypoints: list[Actor]) -> list[Actor]:
    """Waypoints that begin where Init puts the entity, which stands there until its trajectory begins."""
    if not waypoints:
        return [start]
    first = waypoints[0]
    if first["time"] <= 0.001 or math.dist(start["position"], first["position"]) <= 0.01:
        return waypoints
    return [start, {**start, "time": round(first["time"] - 0.001, 6)}, *waypoints]


def _in_order(waypoints: list[Actor], left_out: Counter[str]) -> list[Actor]:
    """Sorted by time. Trajectories that follow each other have a waypoint in common, of which one stays."""
    ordered: list[Actor] = []
    for waypoint in sorted(waypoints, key=lambda waypoint: waypoint["time"]):
        if not ordered or waypoint["time"] > ordered[-1]["time"]:
            ordered.append(waypoint)
        elif math.dist(waypoint["position"], ordered[-1]["position"]) > 0.01:
            left_out["places at times at which an entity is elsewhere, too"] += 1
    return ordered

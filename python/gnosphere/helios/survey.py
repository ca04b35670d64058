# SPDX-License-Identifier: Apache-2.0
"""Surveys of HELIOS++: each leg that scans becomes a drive."""

from __future__ import annotations

import json
import math
import os
import re
import xml.etree.ElementTree as ET
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Optional, Union

import numpy as np

from .. import _gnosphere as gno
from .. import adapter
from ..robotics.resources import Folders
from .assets import Assets, Matrix, Settings, about, number_of, place, quaternion_of, rotation_of
from .scanner import GAP, Scanner, effects_of, ignored_of, scanner_of
from .scene import Part, Surfaces, ground_at, read_parts, scenes_of, surfaces_of

_TO_OURS = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
"""Turns a platform's axes, whose y points forward and x to the right, to ours."""

_RECORDED = "legs along a recorded trajectory are not read; a drive file takes the trajectory as TUM"


@dataclass
class Leg:
    """A leg that scans.

    number: among the legs of the survey, from 0.
    duration: seconds that it takes.
    sensor: the scanner with the settings of the leg.
    drive: a drive file without its scene and sensor.
    """

    number: int
    duration: float
    sensor: gno.Sensor
    drive: dict[str, Any]


@dataclass
class Survey:
    """A survey of HELIOS++.

    name: of the survey.
    leg_count: all legs, also those that do not scan.
    legs: those that do.
    assumed: what the scanner does not state, and what was taken.
    left_out: what is not simulated, and how often it occurs.
    """

    name: str
    leg_count: int
    parts: list[Part]
    surfaces: Surfaces
    legs: list[Leg] = field(default_factory=list)
    assumed: list[str] = field(default_factory=list)
    left_out: Counter[str] = field(default_factory=Counter)

    def write(self, folder: Union[str, Path]) -> list[Path]:
        """Writes leg-NNN.json, the drive of a leg, and leg-NNN-sensor.json for each leg, and materials.json with the
        reflectances. Returns the drive files."""
        folder = Path(folder)
        folder.mkdir(parents=True, exist_ok=True)
        scene: dict[str, Any] = {
            "scenes": scenes_of(self.parts, folder.resolve()),
            "classes": self.surfaces.classes,
        }
        if self.surfaces.reflectances:
            # HELIOS++ does not read how much light a material lets through (d and Tr).
            rows = [
                {"name": name, "reflectance_905": value, "reflectance_1550": value, "transmission": 0}
                for name, value in self.surfaces.reflectances.items()
            ]
            (folder / "materials.json").write_text(json.dumps({"materials": rows}, indent=1), encoding="utf-8")
            scene["material_table"] = "materials.json"
        files = []
        for leg in self.legs:
            name = f"leg-{leg.number:03}"
            (folder / f"{name}-sensor.json").write_text(gno.to_json(leg.sensor), encoding="utf-8")
            drive = {**scene, **leg.drive}
            drive["sensors"] = [{**leg.drive["sensors"][0], "sensor": f"{name}-sensor.json"}]
            files.append(folder / f"{name}.json")
            files[-1].write_text(json.dumps(drive, indent=1), encoding="utf-8")
        return files


def read_survey(file: Union[str, Path], assets: Folders = (), epoch: float = 315964800) -> Survey:
    """Reads the XML of a survey, with the scanner, the platform and the scene that it names.

    assets: a folder in which paths such as data/platforms.xml start, or several; after them the survey's folder and
        those above it are searched.
    epoch: the Unix time at which the survey starts, which a survey does not state; by default that of GPS time.

    A platform flies or drives from each leg's place to that of the next one, straight, level and at the leg's speed; one
    that stands scans a sector at each. Raises ValueError that names what is wrong, or what cannot be simulated, such as
    voxels and Risley prisms. Warns of what is left out, such as noise of the platform.
    """
    found = Assets(file, assets)
    root = found.root(found.survey)
    survey = next(iter(root.iter("survey")), None)
    if survey is None:
        raise ValueError(f"{file} has no <survey>")
    try:
        result = _Reader(found, survey, epoch).read()
    except gno.Error as error:
        raise ValueError(f"{file}: {error}") from error
    adapter.warn_left_out(os.fspath(file), result.left_out)
    return result


class _Reader:
    def __init__(self, assets: Assets, survey: ET.Element, epoch: float) -> None:
        self._assets, self._survey, self._epoch = assets, survey, epoch
        if survey.get("platform", "").endswith("interpolated"):
            raise ValueError(f"{assets.survey}: {_RECORDED}")
        self._platform = assets.element("platform", survey.get("platform", ""))
        self._scanner = assets.element("scanner", survey.get("scanner", ""))
        self._detector = Settings(assets, survey.find("detectorSettings"))
        self._legs = survey.findall("leg")
        self._moves = self._platform.get("type", "static").lower() in ("linearpath", "groundvehicle", "multicopter")
        self._left_out: Counter[str] = Counter()
        self._assumed: dict[str, None] = {}
        self._yaw = 90.0  # degrees: a platform that has not moved yet faces north

    def read(self) -> Survey:
        if not self._legs:
            raise ValueError(f"{self._assets.survey}: the survey has no <leg>")
        name = self._survey.get("name", self._assets.survey.stem)
        parts = read_parts(self._assets, self._survey.get("scene", ""), self._left_out)
        survey = Survey(name, len(self._legs), parts, surfaces_of(parts, self._left_out))
        self._note_left_out()
        places = [self._place(leg, parts) for leg in self._legs]
        waveform = Settings(self._assets, self._survey.find("FWFSettings"), self._scanner.find("FWFSettings"))
        effects = effects_of(self._scanner, self._detector, waveform, self._assumed, self._left_out)
        time = 0.0
        for number, element in enumerate(self._legs):
            settings = Settings(self._assets, element.find("scannerSettings"))
            target = places[number + 1] if self._moves and number + 1 < len(places) else None
            if self._moves and target is None:
                break  # the last leg of a platform that moves is where it ends
            active = settings.flag("active", True)
            speed = Settings(self._assets, element.find("platformSettings")).number("movePerSec_m", 70)
            duration = self._head_for(places[number], target, speed)
            if not active:
                time += duration or 0.0
                continue
            try:
                scanner = scanner_of(self._scanner, self._detector, settings, duration)
            except ValueError as error:
                raise ValueError(f"{self._assets.survey}: leg {number}: {error}") from error
            self._assumed.update(dict.fromkeys(scanner.assumed))
            self._left_out |= ignored_of(scanner)  # once, though each leg has the scanner
            leg = self._leg(number, places[number], target, speed, scanner, effects, time, name)
            survey.legs.append(leg)
            time += duration if duration is not None else leg.duration
        if not survey.legs:
            raise ValueError(f"{self._assets.survey}: no leg scans")
        survey.assumed, survey.left_out = list(self._assumed), self._left_out
        return survey

    def _note_left_out(self) -> None:
        kind = self._platform.get("type", "static").lower()
        if kind in ("groundvehicle", "multicopter"):
            self._left_out[f"speeding up, slowing down and turning of a '{kind}'"] += 1
        for holder in (self._platform, self._survey):
            for tag in ("position", "attitude"):
                if any(holder.find(f"{tag}{axis}Noise") is not None for axis in "XYZ"):
                    self._left_out[f"noise of the platform's {tag}"] += 1
        if self._survey.get("legRandomOffset", "false") in ("true", "1"):
            self._left_out["random offsets of legs"] += 1

    def _place(self, leg: ET.Element, parts: list[Part]) -> Matrix:
        settings = Settings(self._assets, leg.find("platformSettings"))
        if settings.has("trajectory"):
            raise ValueError(f"{self._assets.survey}: {_RECORDED}")
        point = np.array([settings.number(axis) for axis in "xyz"])
        if settings.flag("onGround", False):
            point[2] = ground_at(parts, point[0], point[1])
        return point

    def _head_for(self, start: Matrix, target: Optional[Matrix], speed: float) -> Optional[float]:
        """Turns the platform along its way. Returns the seconds to the target, or None if there is none."""
        if target is None:
            return None
        way = target - start
        if math.hypot(way[0], way[1]) > 0:
            self._yaw = math.degrees(math.atan2(way[1], way[0]))
        if not (speed > 0):
            raise ValueError(f"{self._assets.survey}: movePerSec_m is {speed:g}, so the platform never arrives")
        return float(np.linalg.norm(way)) / speed

    def _leg(
        self,
        number: int,
        start: Matrix,
        target: Optional[Matrix],
        speed: float,
        scanner: Scanner,
        effects: dict[str, Any],
        time: float,
        name: str,
    ) -> Leg:
        duration = scanner.scans / scanner.rate
        if scanner.sensor.divergence_horizontal == 0:  # sub-rays of a footprint that is a point are all one
            effects = {name: values for name, values in effects.items() if name != "divergence"}
        way = np.zeros(3) if target is None else target - start
        length = float(np.linalg.norm(way))
        end = start + way * (speed * duration / length if length > 0 else 0.0)
        yaw = round(self._yaw, 9)
        waypoints = [
            {"time": time, "position": place(start), "yaw_deg": yaw},
            {"time": time + duration, "position": place(end), "yaw_deg": yaw},
        ]
        mount, turn = self._mount(scanner)
        if scanner.step != 0:
            if target is not None:
                raise ValueError(
                    f"{self._assets.survey}: leg {number}: the head takes more than 10 s for a turn, which is read for "
                    "platforms that stand"
                )
            waypoints = _turning_on(time, start, about("z", yaw), scanner, mount, turn)
            effects = {**effects, "sensor-motion": {"use": "off"}}  # it stands still in each scan
        label = _plain(self._scanner.get("id", "scanner"))
        las = {"format": "las", "one_file": True, "flight_line": number + 1, "fields": "range,width,incidence,beam"}
        return Leg(
            number,
            duration,
            scanner.sensor,
            {
                "name": f"{_plain(name)}-leg-{number}",
                "ego": {"trajectory": {"waypoints": waypoints}},
                "epoch": self._epoch,
                "seed": number + 1,
                "rate": scanner.rate,
                "start": time,
                "duration": duration,
                "sensors": [
                    {
                        "name": label,
                        "mount": {"position": place(mount), "orientation": quaternion_of(turn)},
                        "effects": effects,
                    }
                ],
                "outputs": [las],
            },
        )

    def _mount(self, scanner: Scanner) -> tuple[Matrix, Matrix]:
        """Where the scanner is on the platform, and how it is turned, in our axes."""
        mount = self._platform.find("scannerMount")
        position = np.zeros(3)
        if mount is not None:
            position = np.array([number_of(mount.get(axis, "0"), f"{axis} of <scannerMount>") for axis in "xyz"])
        turn = _TO_OURS @ rotation_of(mount) @ scanner.turn @ _TO_OURS.T
        return _TO_OURS @ position, turn


def _plain(name: str) -> str:
    """A name as drive files take it: letters, digits, _ and -, and not too long for names of files."""
    return re.sub(r"[^A-Za-z0-9_-]", "_", name)[:80] or "_"


def _turning_on(
    time: float, position: Matrix, heading: Matrix, scanner: Scanner, mount: Matrix, turn: Matrix
) -> list[dict[str, Any]]:
    """Waypoints of a platform that stands during each scan, and before the next one turns about the axis of the scanner
    as far as its head has turned.

    position, heading: of the platform in the first scan.
    mount, turn: where the scanner is on the platform, and how it is turned.
    """
    waypoints = []
    for scan in range(scanner.scans):
        start, end = time + scan / scanner.rate, time + (scan + 1) / scanner.rate
        # Times are rounded, so a scan begins and ends well within the time for which the platform stands.
        first, last = start - (GAP / 4 if scan else 0), end - (3 * GAP / 4 if scan + 1 < scanner.scans else 0)
        turned = heading @ turn @ about("z", scan * scanner.step) @ turn.T
        stands = {"position": place(position + (heading - turned) @ mount), "orientation": quaternion_of(turned)}
        waypoints += [{"time": first, **stands}, {"time": last, **stands}]
    return waypoints

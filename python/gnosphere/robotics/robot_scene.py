# SPDX-License-Identifier: Apache-2.0
"""What all readers make: shapes on frames, sensors on frames, and where the frames are for positions of joints."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Container, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Optional, Union

import numpy as np
import numpy.typing as npt

from .. import _gnosphere as gno
from .. import adapter

Matrix = npt.NDArray[np.float64]
Joints = Mapping[str, float]
Frames = Callable[[Joints], Mapping[Any, Matrix]]
"""Where each frame is in the world, a map of shape (4, 4), for positions of joints in radians or metres."""
Kinematics = tuple[Frames, Mapping[str, tuple[float, float]]]
"""The frames, and the limits of each joint."""


@dataclass
class MountedSensor:
    """A lidar of a file."""

    name: str
    sensor: gno.Sensor
    frame: Any
    """The link, geom body or prim that carries it."""
    local: Matrix
    """The map (4, 4) from the sensor to its frame; x looks forward, z up."""
    rate: float = 0.0
    """Scans a second; 0 if the file does not say."""


@dataclass
class Parts:
    """What a reader collects."""

    classes: Optional[Mapping[str, int]] = None
    shapes: adapter.Shapes = field(default_factory=adapter.Shapes)
    frames: list[Any] = field(default_factory=list)
    locals: list[Matrix] = field(default_factory=list)
    sensors: list[MountedSensor] = field(default_factory=list)
    left_out: dict[str, int] = field(default_factory=dict)
    assumed: list[str] = field(default_factory=list)

    def leave_out(self, what: str, count: int = 1) -> None:
        self.left_out[what] = self.left_out.get(what, 0) + count

    def assume(self, file: gno.SensorFile, lidar: str) -> None:
        """Keeps what a sensor file does not state, and the value that was taken."""
        self.assumed += [f"{what} (the lidar {lidar})" for what in file.assumed]

    def place(self, mesh: int, frame: Any, local: Matrix, *names: str, class_name: str = "") -> None:
        """Puts a mesh on a frame. The first of the names is that of the instance; patterns of classes are tried with
        all of them."""
        number = adapter.class_of(self.classes, *names, class_name)
        self.shapes.instance(mesh, None, number, names[0], class_name)
        self.frames.append(frame)
        self.locals.append(local)

    def mount(self, sensor: gno.Sensor, name: str, frame: Any, local: Matrix, rate: float = 0.0) -> None:
        unique = unique_name(name, {other.name for other in self.sensors})
        self.sensors.append(MountedSensor(unique, sensor, frame, local, rate))


def unique_name(name: str, taken: Container[str], last: Optional[dict[str, int]] = None) -> str:
    """A name that is not taken: the given one, or else "NAME 2", "NAME 3" and so on. `last` keeps the last number of
    each name, from which the search goes on, since many things may have one name."""
    unique, count = name, (last or {}).get(name, 1)
    while unique in taken:
        count += 1
        unique = f"{name} {count}"
    if last is not None:
        last[name] = count
    return unique


class Mimic(NamedTuple):
    """What a joint follows: its position is that of the other one times the multiplier, plus the offset."""

    joint: str
    multiplier: float
    offset: float


def resolved_mimics(mimics: Mapping[str, Mimic], joints: Container[str], parts: Parts) -> dict[str, Mimic]:
    """What joints follow where those that they mimic may mimic others: joints that mimic none."""
    result = {}
    for name, (leader, multiplier, offset) in mimics.items():
        passed = {name}
        while leader in mimics and leader not in passed:
            passed.add(leader)
            leader, factor, further = mimics[leader]
            multiplier, offset = multiplier * factor, multiplier * further + offset
        if leader in passed:
            parts.leave_out(f"the motion of the joint '{name}', which mimics joints in a circle")
        elif leader not in joints:
            parts.leave_out(f"the motion of the joint '{name}', which mimics '{leader}', which is not there")
        result[name] = Mimic(leader, multiplier, offset) if leader not in passed else Mimic("", 1.0, 0.0)
    return result


class RobotScene:
    """A robot or a world, at rest or with its joints at given positions."""

    def __init__(self, parts: Parts, frames: Frames, joints: Joints, limits: Mapping[str, tuple[float, float]]) -> None:
        self.sensors: list[MountedSensor] = parts.sensors
        """The lidars of the file."""
        self.left_out: dict[str, int] = parts.left_out
        """What the file has and the scene lacks, with how often."""
        self.assumed: list[str] = parts.assumed
        """What the lidars of the file do not state, and the values that were taken."""
        self.joint_limits: dict[str, tuple[float, float]] = dict(limits)
        """The joints that can be moved, with their least and largest position."""
        self.frames: list[Any] = parts.frames
        """The link, geom or prim of each instance."""
        self.joints: dict[str, float] = {}
        """The positions that were given last."""
        self._parts, self._where = parts, frames
        self._now: Mapping[Any, Matrix] = {}
        self._move(joints, stacklevel=4)  # of the caller of load()

    def __repr__(self) -> str:
        counts = (len(self.frames), len(self.sensors), len(self.joint_limits))
        return "<RobotScene of {} instances, {} lidars and {} joints>".format(*counts)

    def move(self, joints: Joints) -> Matrix:
        """Moves joints, by radians or metres; those not named stay. Returns where the instances then are, shape
        (n, 3, 4), for Lidar.move(). A position beyond the limits of its joint is taken, with a warning."""
        return self._move(joints, stacklevel=3)

    def _move(self, joints: Joints, stacklevel: int) -> Matrix:
        positions = {name: self._position(name, value) for name, value in joints.items()}
        for name, position in positions.items():
            low, high = self.joint_limits[name]
            if not low <= position <= high:
                warnings.warn(
                    f"the joint '{name}' is at {position:g}, beyond its limits {low:g}..{high:g}", stacklevel=stacklevel
                )
        self.joints.update(positions)
        self._now = self._where(self.joints)
        rows = np.empty((len(self.frames), 3, 4))
        for row, frame, local, instance in zip(rows, self.frames, self._parts.locals, self._parts.shapes.instances):
            row[:] = (self._now[frame] @ local)[:3]
            instance.transform = gno.Transform(row)
        return rows

    def _position(self, name: str, value: Any) -> float:
        """The position of a joint as a number, where there is such a joint."""
        if not self.joint_limits:
            raise ValueError(f"there is no joint '{name}': the file has none that can be moved")
        if name not in self.joint_limits:
            known, shown = list(self.joint_limits), 8
            names = ", ".join(known[:shown]) + (f" and {len(known) - shown} more" if len(known) > shown else "")
            verb = "is" if len(known) == 1 else "are"
            raise ValueError(f"there is no joint '{name}' that can be moved; there {verb} {names}")
        try:
            position = float(value)
        except (TypeError, ValueError) as error:
            raise type(error)(f"the position of the joint '{name}' must be a number, not {value!r}") from None
        if not math.isfinite(position):
            raise ValueError(f"the position of the joint '{name}' must be finite, is {position:g}")
        return position

    @property
    def scene(self) -> gno.Scene:
        """A new Scene, as the joints are now."""
        return self._parts.shapes.scene()

    def number(self, sensor: Union[int, str]) -> int:
        """The number of a sensor that is given by its name."""
        if isinstance(sensor, str):
            names = [mounted.name for mounted in self.sensors]
            if sensor not in names:
                raise ValueError(f"there is no lidar '{sensor}'; the file has {', '.join(names) or 'none'}")
            return names.index(sensor)
        if not 0 <= sensor < len(self.sensors):
            raise ValueError(f"there is no lidar {sensor}; the file has {len(self.sensors)}")
        return sensor

    def pose(self, sensor: Union[int, str] = 0) -> gno.Pose:
        """Where a sensor is in the world."""
        mounted = self.sensors[self.number(sensor)]
        place = self._now[mounted.frame] @ mounted.local
        turn = place[:3, :3] / np.linalg.norm(place[:3, :3], axis=0)  # frames of USD may be scaled
        return gno.Pose(place[:3, 3], adapter.quaternion(turn))  # the nearest rotation where the frame is sheared

    def shot(self, sensor: Union[int, str] = 0, frame: int = 0) -> gno.Shot:
        """A Shot from where a sensor is, for the Lidar that lidar() makes."""
        return gno.Shot(self.pose(sensor), 0, frame)

    def lidar(
        self,
        sensor: Union[int, str, gno.Sensor] = 0,
        *,
        effects: Optional[gno.Effects] = None,
        fields: adapter.Fields = (),
        ignore: Iterable[Any] = (),
        options: Optional[gno.SimulatorOptions] = None,
    ) -> adapter.Lidar:
        """A Lidar in the scene: a sensor of the file by name or number, or any Sensor. `ignore` are frames, such as
        links, that it does not see. The rest: see adapter.Lidar."""
        chosen = sensor if isinstance(sensor, gno.Sensor) else self.sensors[self.number(sensor)].sensor
        hidden = set(ignore)
        unknown = hidden - set(self.frames)
        if unknown:
            raise ValueError(f"nothing can be seen on {', '.join(sorted(map(str, unknown)))}, so it cannot be ignored")
        unseen = [i for i, frame in enumerate(self.frames) if frame in hidden]
        return adapter.Lidar(
            self._parts.shapes, chosen, effects=effects, fields=fields, ignore=unseen, options=options
        )  # fmt: skip

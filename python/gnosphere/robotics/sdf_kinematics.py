# SPDX-License-Identifier: Apache-2.0
"""Links at known places in the world, moved by joints of which some link is the child."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Optional

import numpy as np

from .robot_scene import Joints, Matrix, Mimic, Parts, resolved_mimics


@dataclass
class Joint:
    """A joint in the world, as all joints are at 0; without an axis it is fixed."""

    slides: bool = False
    origin: Matrix = field(default_factory=lambda: np.zeros(3))
    axis: Matrix = field(default_factory=lambda: np.zeros(3))
    limits: tuple[float, float] = (-math.inf, math.inf)
    mimic: Optional[Mimic] = None

    def motion(self, position: float) -> Matrix:
        """The map (4, 4) of what hangs from the joint, in the world in which all joints are at 0."""
        result = np.eye(4)
        if self.slides:
            result[:3, 3] = position * self.axis
            return result
        x, y, z = self.axis
        cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        result[:3, :3] += math.sin(position) * cross + (1 - math.cos(position)) * cross @ cross
        result[:3, 3] = self.origin - result[:3, :3] @ self.origin
        return result


class Tree:
    def __init__(self, parts: Parts) -> None:
        self.links: dict[str, Matrix] = {}
        self._parts = parts
        self._joints: dict[str, Joint] = {}
        self._above: dict[str, tuple[str, str]] = {}  # joint and parent of a link

    def join(self, name: str, joint: Joint, parent: str, child: str) -> None:
        if child in self._above or parent == child:
            return self._parts.leave_out("joints that close a loop")
        self._joints[name] = joint
        self._above[child] = (name, parent)

    def resolve_mimics(self) -> None:
        """Lets each joint that mimics another follow one that mimics none, when all have been joined."""
        mimics = {name: joint.mimic for name, joint in self._joints.items() if joint.mimic is not None}
        for name, mimic in resolved_mimics(mimics, self._joints, self._parts).items():
            self._joints[name].mimic = mimic

    def _moving(self) -> dict[str, Joint]:
        return {name: joint for name, joint in self._joints.items() if joint.axis.any() and joint.mimic is None}

    def limits(self) -> Mapping[str, tuple[float, float]]:
        """Those that can be moved; by their own name, too, where only one has it."""
        moving = self._moving()
        short = [name.rpartition("::")[2] for name in moving]
        return {own if short.count(own) == 1 else name: moving[name].limits for own, name in zip(short, moving)}

    def frames(self, joints: Joints) -> Mapping[Any, Matrix]:
        moving = self._moving()
        given = {}
        for name, value in joints.items():
            fits = [full for full in moving if name in (full, full.rpartition("::")[2])]
            given[fits[0]] = value
        moved: dict[str, Matrix] = {"": np.eye(4)}

        def of(link: str) -> Matrix:
            chain = []
            while link not in moved:
                chain.append(link)
                link = self._above.get(link, ("", ""))[1]
                if link in chain:
                    raise ValueError(f"the link '{link}' hangs from itself")
            for below in reversed(chain):
                name, parent = self._above.get(below, ("", ""))
                moved[below] = moved[parent] @ self._motion(name, given) if name else moved[parent]
            return moved[chain[0]] if chain else moved[link]

        return {link: of(link) @ place for link, place in self.links.items()}

    def _motion(self, name: str, given: Mapping[str, float]) -> Matrix:
        joint = self._joints[name]
        position = given.get(name, 0.0)
        if joint.mimic is not None:
            position = joint.mimic.multiplier * given.get(joint.mimic.joint, 0.0) + joint.mimic.offset
        return joint.motion(position) if joint.axis.any() else np.eye(4)

# SPDX-License-Identifier: Apache-2.0
"""python -m gnosphere.robotics FILE: tells what a robot or world has, and writes it as .glb."""

from __future__ import annotations

import argparse
import math
import signal
import sys
import warnings
from typing import Any, Iterable

import numpy as np

from .. import _gnosphere as gno
from .load import load
from .robot_scene import Matrix, RobotScene


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m gnosphere.robotics", description=__doc__)
    parser.add_argument("file", help="URDF, SDF, MJCF or USD")
    parser.add_argument(
        "--joint",
        action="append",
        default=[],
        metavar="NAME=POSITION",
        help="position of a joint, in radians or metres; may be given more than once",
    )
    parser.add_argument(
        "--search",
        action="append",
        default=[],
        metavar="FOLDER",
        help="folder of packages and models; may be given more than once",
    )
    parser.add_argument("--collisions", action="store_true", help="take what collides in place of what is seen")
    parser.add_argument("-o", "--output", metavar="FILE.glb", help="write the scene as it is with these joints")
    given = parser.parse_args()
    for joint in given.joint:
        if "=" not in joint:
            parser.error(f"--joint {shown(joint)} states no position; NAME=POSITION does, as {shown(joint)}=0.5")
    try:
        joints: dict[str, Any] = {name: value for name, _, value in (joint.rpartition("=") for joint in given.joint)}
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", ".* leaves out ")  # this is printed
            found = load(given.file, joints=joints, search=given.search, collisions=given.collisions)
        describe(found)
        if given.output:
            gno.write_glb(found.scene, given.output)
    except (OSError, ValueError, ImportError, gno.Error) as error:
        print(f"gnosphere.robotics: {shown(error)}", file=sys.stderr)
        return 1
    return 0


def describe(found: RobotScene) -> None:
    scene = found.scene
    box = gno.world_bounds(scene)
    print(f"{scene.placed_triangle_count():,} triangles, {len(scene.instances)} instances, {len(scene.meshes)} meshes")
    if not box.empty():
        print("from", *(f"{value:.3f}" for value in box.min), "to", *(f"{value:.3f}" for value in box.max), "m")
    for name, (low, high) in found.joint_limits.items():
        limits = "any position" if math.isinf(low) and math.isinf(high) else f"{low:g} to {high:g}"
        print(f"joint {shown(name)}: {limits}")
    for number, mounted in enumerate(found.sensors):
        rate = f", {mounted.rate:g} scans a second" if mounted.rate else ""
        print(f"lidar {shown(mounted.name)}: {mounted.sensor.beam_count():,} beams{rate}")
        position = listed(found.pose(number).position)
        print(f"  on {shown(mounted.frame)} at {place_of(mounted.local)}; in the world at {position}")
    for what in found.assumed:
        print(f"assumed: {shown(what)}")
    for what, count in found.left_out.items():
        print(f"left out: {shown(what)} ({count})")


def shown(text: object) -> str:
    """A text that may come from a file, with a question mark for each character that a terminal would obey."""
    return "".join(letter if letter.isprintable() else "?" for letter in str(text))


def listed(values: Iterable[float]) -> str:
    return ", ".join(f"{value:.3f}" for value in values)


def place_of(local: Matrix) -> str:
    """A mounting as a drive file has it: the position, and the angles where the sensor is turned."""
    (r00, _, _), (r10, _, _), (r20, r21, r22) = local[:3, :3]
    angles = math.atan2(r10, r00), -math.asin(min(max(r20, -1.0), 1.0)), math.atan2(r21, r22)
    turned = f", yaw_pitch_roll_deg {listed(np.degrees(angles))}" if np.abs(angles).max() > 1e-6 else ""
    return listed(local[:3, 3]) + turned


if __name__ == "__main__":
    if hasattr(signal, "SIGPIPE"):  # Windows has none
        signal.signal(signal.SIGPIPE, signal.SIG_DFL)  # ends without a word when nobody reads on, as `gnosphere` does
    sys.exit(main())

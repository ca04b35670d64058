# SPDX-License-Identifier: Apache-2.0
"""MJCF, through mujoco: the geoms of gnosphere.mujoco. Rangefinders of one body are one lidar."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import mujoco as mj
import numpy as np

from .. import _gnosphere as gno
from .. import adapter
from ..mujoco.rays import beams_by_body, rangefinder_sites
from ..mujoco.shapes import VISIBLE_GROUPS, ModelShapes, Tessellation
from .resources import Resources
from .robot_scene import Joints, Kinematics, Matrix, Parts

COLLISION_GROUPS = (0, 0, 0, 1, 0, 0)


def _map(position: Any, quat: Any) -> Matrix:
    w, x, y, z = map(float, quat)
    return adapter.rows_of(gno.Pose(tuple(map(float, position)), (x, y, z, w)))


def read(path: Path, parts: Parts, resources: Resources, collisions: bool) -> Kinematics:
    model = mj.MjModel.from_xml_path(str(path))
    data = mj.MjData(model)
    groups = COLLISION_GROUPS if collisions else VISIBLE_GROUPS
    found = ModelShapes(model, groups, True, parts.classes, Tessellation(resources.tolerance), False)
    parts.shapes = found.shapes
    parts.left_out.update(found.left_out)
    if model.nflex + model.nskin:
        parts.leave_out("flexes and skins, which gnosphere.mujoco has", int(model.nflex + model.nskin))
    bodies = [mj.mj_id2name(model, mj.mjtObj.mjOBJ_BODY, i) or f"body {i}" for i in range(model.nbody)]
    parts.frames = [bodies[model.geom_bodyid[geom]] for geom in found.geoms]
    parts.locals = [_map(model.geom_pos[geom], model.geom_quat[geom]) for geom in found.geoms]
    sites, _, cameras = rangefinder_sites(model)
    if cameras:
        parts.leave_out("rangefinders of cameras", cameras)
    for body, _, sensor in beams_by_body(model, sites):
        parts.mount(sensor, f"rangefinders of {bodies[body]}", bodies[body], np.eye(4))
    places, limits = {}, {}
    for joint in range(model.njnt):
        name = mj.mj_id2name(model, mj.mjtObj.mjOBJ_JOINT, joint)
        if name and mj.mjtJoint(int(model.jnt_type[joint])) in (mj.mjtJoint.mjJNT_HINGE, mj.mjtJoint.mjJNT_SLIDE):
            low, high = model.jnt_range[joint] if model.jnt_limited[joint] else (-math.inf, math.inf)
            limits[name], places[name] = (float(low), float(high)), model.jnt_qposadr[joint]

    def frames(joints: Joints) -> Mapping[Any, Matrix]:
        for name, value in joints.items():
            data.qpos[places[name]] = value
        mj.mj_kinematics(model, data)
        return {name: _map(data.xpos[i], data.xquat[i]) for i, name in enumerate(bodies)}

    return frames, limits

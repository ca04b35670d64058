# SPDX-License-Identifier: Apache-2.0
"""LiDARs in MuJoCo: docs/mujoco.md.

    lidar = gnosphere.mujoco.Lidar(model, "VLP-16", site="lidar", treeexclude="robot")
    mujoco.mj_step(model, data)
    scan = lidar.scan(data)

Needs the package mujoco.
"""

from .lidar import Lidar as Lidar
from .rays import Rangefinders as Rangefinders, Rays as Rays, mj_multiRay as mj_multiRay
from .shapes import VISIBLE_GROUPS as VISIBLE_GROUPS, Tessellation as Tessellation
from .worlds import Worlds as Worlds

# SPDX-License-Identifier: Apache-2.0
"""Robots and worlds from URDF, SDF, MJCF and USD files, with their lidars: docs/robotics.md.

    robot = gnosphere.robotics.load("robot.urdf", joints={"mast": 0.3}, search=["/opt/ros/jazzy/share"])
    lidar = robot.lidar("top", fields="class")
    scan = lidar.cast(robot.shot("top"))

URDF needs the package yourdfpy, MJCF mujoco, USD usd-core; SDF needs none. `python -m gnosphere.robotics FILE` tells
what a file has. read_traffic() makes actors of a drive from SUMO and OpenSCENARIO.
"""

from .load import load as load
from .robot_scene import MountedSensor as MountedSensor, RobotScene as RobotScene
from .traffic import read_traffic as read_traffic

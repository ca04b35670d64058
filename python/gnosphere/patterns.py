# SPDX-License-Identifier: Apache-2.0
"""Patterns of beams that robot learning uses."""

from __future__ import annotations

import math

import numpy as np

from . import BeamList, Sensor


def grid(size: tuple[float, float], resolution: float, *, level: float = 0.0, altitude: float = 20.0) -> Sensor:
    """Returns a height scan: beams from a place above the robot down to points on a grid.

    size: length along x and width along y of the grid, in metres; the robot stands in its middle.
    resolution: metres between two points.
    level: z of the points in the sensor frame, in metres: that of the ground under the robot.
    altitude: how far above the sensor the beams start, in metres. Nothing higher is seen.

    The points are those of Isaac Lab's GridPatternCfg in the order "xy": x changes fastest. The sensor's pose is that of
    the robot's base with the yaw alone, and z of a scan's points is the height of the ground above the base.

    All beams start at one place, because parallel beams take over a hundred times as long. So a surface that is h metres
    above or below `level` is met beside its point of the grid, by at most h / (altitude - level) of the distance from the
    middle. Raises ValueError for sizes that are negative or not finite, a resolution that is not positive, and a grid
    that is not below the beams' start.
    """
    if not (0 < resolution < math.inf and all(0 <= side < math.inf for side in size)):
        raise ValueError(f"size is {size} and resolution {resolution}; sides must be 0 m or more, and steps above 0 m")
    if not level < altitude < math.inf:
        raise ValueError(f"level is {level}; it must be below altitude, {altitude}")
    x, y = np.meshgrid(*(np.arange(-side / 2, side / 2 + 1e-9, resolution) for side in size))
    ways = np.stack([x, y, np.full_like(x, level - altitude)], axis=-1).reshape(-1, 3)
    lengths = np.linalg.norm(ways, axis=1, keepdims=True)
    sensor = Sensor()
    sensor.name = "height scan"
    sensor.range_max = 2 * float(lengths.max())
    origins = np.broadcast_to([0.0, 0.0, altitude], ways.shape)
    sensor.patterns = [BeamList(ways / lengths, origins=origins, width=x.shape[1], height=x.shape[0])]
    return sensor

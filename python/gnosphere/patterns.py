# SPDX-License-Identifier: Apache-2.0
"""Patterns of beams: height scans of robot learning, terrestrial scanners, and zones of time-of-flight sensors."""

from __future__ import annotations

import math

import numpy as np

from . import BeamList, Channel, Sensor, validate


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
    if not -math.inf < level < altitude < math.inf:
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


def panorama(
    resolution: float,
    at: float,
    elevation: tuple[float, float] = (-60.0, 90.0),
    *,
    turn: tuple[float, float] = (0.0, 180.0),
) -> Sensor:
    """Returns a terrestrial scanner: its mirror sweeps a vertical plane while its head makes half a turn.

    resolution, at: metres between two points at a distance of `at` metres, as "6 mm at 10 m".
    elevation: the lowest and the highest elevation in degrees; 90 is the zenith.
    turn: azimuths in degrees, counter-clockwise from the x axis, from which and up to which the head turns. A part of half
        a turn is a scan that needs less memory.

    A column is one sweep: from the lowest elevation in front of the head up to the highest, and down to the lowest one
    behind the head, where azimuths are greater by 180 degrees. The zenith is one beam of a sweep. Elevations have steps of
    resolution / at radians from the highest one down, azimuths the nearest steps that divide `turn`. All beams fire at
    once. Ranges end at 100 m; set range_min, range_max and the divergence of your scanner. Raises ValueError for a
    resolution or a distance that is not positive, elevations that do not increase within -90 to 90, and a turn that does
    not increase by at most 180 degrees.
    """
    if not (0 < resolution < math.inf and 0 < at < math.inf):
        raise ValueError(f"resolution is {resolution} at {at}; both must be above 0 m")
    low, high = elevation
    if not -90 <= low < high <= 90:
        raise ValueError(f"elevation is {elevation}; it must increase, from -90 degrees or more to 90 or less")
    if not 0 < turn[1] - turn[0] <= 180:
        raise ValueError(f"turn is {turn}; it must increase, by at most 180 degrees")
    step = math.degrees(resolution / at)
    down = high - step * np.arange(math.floor((high - low) / step + 1e-9) + 1)
    front = [Channel(one) for one in down[::-1].tolist()]
    behind = [Channel(one, 180) for one in down[int(high == 90) :].tolist()]
    sensor = Sensor()
    sensor.name = "panorama"
    sensor.columns = max(1, round((turn[1] - turn[0]) / step))
    sensor.channels = front + behind
    sensor.azimuth_start_deg, sensor.azimuth_span_deg = turn[0], turn[1] - turn[0]
    sensor.range_max = 100
    return sensor


def zones(columns: int, rows: int, horizontal_deg: float, vertical_deg: float) -> Sensor:
    """Returns a time-of-flight sensor of many zones, such as the VL53L5CX with 8 x 8 zones of 45 x 45 degrees.

    columns, rows: how many zones there are across and one above the other.
    horizontal_deg, vertical_deg: the angles that all zones cover together, in degrees.

    The x axis is the middle. A zone is a beam through its centre, whose divergence is the width and the height of the
    zone; the effect `divergence` with the profile uniform and the shape rectangle has a zone's light. Scans are
    organised: the first row is the highest, the first column the leftmost. All beams fire at once. Ranges end at 4 m;
    set range_min, range_max, max_returns and scan_period of your sensor. Raises ValueError without zones, and for
    angles that are not above 0, or above 180 degrees. Raises Error for zones wider than 100 mrad, which are several
    beams each.
    """
    if not (columns >= 1 and rows >= 1):
        raise ValueError(f"there are {columns} x {rows} zones; there must be one column and one row at least")
    if not (0 < horizontal_deg <= 180 and 0 < vertical_deg <= 180):
        raise ValueError(f"the zones cover {horizontal_deg} x {vertical_deg} degrees; both must be above 0, up to 180")
    width, height = math.radians(horizontal_deg) / columns, math.radians(vertical_deg) / rows
    azimuth, elevation = np.meshgrid(
        ((columns - 1) / 2 - np.arange(columns)) * width, ((rows - 1) / 2 - np.arange(rows)) * height
    )
    directions = np.stack(
        [np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)], axis=-1
    )
    sensor = Sensor()
    sensor.name = "zones"
    sensor.range_max = 4
    sensor.divergence_horizontal, sensor.divergence_vertical = width, height
    sensor.patterns = [BeamList(directions.reshape(-1, 3), width=columns, height=rows)]
    validate(sensor)
    return sensor

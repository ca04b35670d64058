# SPDX-License-Identifier: Apache-2.0
"""Sensors in a MuJoCo model."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple, Optional, Union

import mujoco as mj
import numpy as np
import numpy.typing as npt

from .. import _gnosphere as gno
from .. import adapter
from .shapes import VISIBLE_GROUPS, Bodies, ModelShapes, Tessellation

Rows = npt.NDArray[np.float64]
PoseSource = Union[gno.Pose, Callable[[Any], gno.Pose]]


class Mount:
    """What carries a sensor: a site, the world, or what a function of MjData says."""

    def __init__(self, model: Any, site: Union[int, str, None], pose: Optional[PoseSource]) -> None:
        if site is not None and callable(pose):
            raise TypeError("pose is a Pose in the frame of the site, not a function, where there is a site")
        if pose is not None and not callable(pose) and not isinstance(pose, gno.Pose):
            raise TypeError(f"pose must be a gnosphere.Pose or a function of MjData, not {pose!r}")
        self._site = -1 if site is None else model.site(site).id
        self._pose: Any = adapter.rows_of(pose) if site is not None and isinstance(pose, gno.Pose) else pose

    def pose(self, data: Any) -> gno.Pose:
        if self._site < 0:
            return self._pose(data) if callable(self._pose) else self._pose or gno.Pose()
        position, turn = data.site_xpos[self._site], data.site_xmat[self._site]
        if self._pose is not None:
            matrix = turn.reshape(3, 3)
            position = position + matrix @ self._pose[:3, 3]
            turn = (matrix @ self._pose[:3, :3]).reshape(-1)
        quat = np.empty(4)
        mj.mju_mat2Quat(quat, turn)
        return gno.Pose(tuple(position.tolist()), (float(quat[1]), float(quat[2]), float(quat[3]), float(quat[0])))


class Record(NamedTuple):
    """Where things are at a time in seconds."""

    time: float
    poses: list[gno.Pose]
    """The sensors'."""
    geoms: Rows
    """Maps of shape (geoms, 3, 4)."""


def durations_of(sensor: gno.Sensor) -> list[float]:
    """How long the scans of a sensor last, in seconds, by the frame number modulo their number."""
    if sensor.rotation_period > 0:
        return [sensor.rotation_period]
    if not sensor.patterns:
        return [max((channel.time_offset for channel in sensor.channels), default=0.0)]
    return [float(pattern.times.max(initial=0)) for pattern in sensor.patterns]


def between(first: Rows, last: Rows, share: float) -> Rows:
    """Maps on the way from `first` to `last`, shape (n, 3, 4), or beyond: origins go in straight lines, axes turn about
    a fixed one. The share is 0 at the first and 1 at the last maps."""
    turn = last[:, :, :3] @ np.linalg.inv(first[:, :, :3])
    # The vector of the part without symmetry is the axis of the turn by the sine of its angle.
    skew = (turn - turn.transpose(0, 2, 1)) / 2
    vector = np.stack([skew[:, 2, 1], skew[:, 0, 2], skew[:, 1, 0]], axis=1)
    cosine = (np.trace(turn, axis1=1, axis2=2) - 1) / 2
    angle = share * np.arctan2(np.linalg.norm(vector, axis=1), cosine)
    # Near half a turn that part vanishes, but in the other one each column is a multiple of the axis.
    axes = (turn + turn.transpose(0, 2, 1)) / 2 - cosine[:, None, None] * np.eye(3)
    longest = np.argmax(np.diagonal(axes, axis1=1, axis2=2), axis=1)
    column = np.take_along_axis(axes, longest[:, None, None], axis=2)[:, :, 0]
    column *= np.where(np.sum(column * vector, axis=1) < 0, -1, 1)[:, None]
    vector = np.where((cosine < 0)[:, None], column, vector)
    x, y, z = (vector / np.maximum(np.linalg.norm(vector, axis=1), 1e-300)[:, None]).T
    cross = np.stack([0 * x, -z, y, z, 0 * x, -x, -y, x, 0 * x], axis=1).reshape(-1, 3, 3)
    part = np.eye(3) + np.sin(angle)[:, None, None] * cross + (1 - np.cos(angle))[:, None, None] * (cross @ cross)
    origins = first[:, :, 3] + share * (last[:, :, 3] - first[:, :, 3])
    return np.concatenate([part @ first[:, :, :3], origins[:, :, None]], axis=2)


def pose_between(first: gno.Pose, last: gno.Pose, share: float) -> gno.Pose:
    """As between(), of a pose."""
    rows = between(adapter.rows_of(first)[None, :3], adapter.rows_of(last)[None, :3], share)[0]
    return adapter.pose_of(rows[:, 3], rows[:, :3])


def _geoms_at(time: float, path: Sequence[tuple[float, Rows]]) -> Rows:
    """Where geoms are at a time: interpolated, or before the first place from their mean motion from there to the last
    one. What does not move keeps its bits."""
    later = next(i for i, (at, _) in enumerate(path) if at > time)
    (begin, first), (end, last) = (path[0], path[-1]) if later == 0 else (path[later - 1], path[later])
    moving = np.any(first != last, axis=(1, 2))
    result: Rows = first.copy()
    result[moving] = between(first[moving], last[moving], (time - begin) / (end - begin))
    return result


def _beyond_both_ends(path: Sequence[tuple[float, gno.Pose]], duration: float) -> list[tuple[float, gno.Pose]]:
    """The path of a sensor, from before 0 until after the duration, because some beams of a turn fire a little outside
    of it. Where the path has no places its mean motion goes on, as that of geoms does."""
    (begin, first), (end, last) = path[0], path[-1]
    margin = duration / 10
    longer = list(path)
    while len(longer) > 2 and longer[1][0] <= -margin:
        longer.pop(0)
    if longer[0][0] > -margin:
        longer.insert(0, (-margin, pose_between(first, last, (-margin - begin) / (end - begin))))
    return [*longer, (end + margin, pose_between(first, last, (end + margin - begin) / (end - begin)))]


class Lidar(adapter.Lidar):
    """Sensors in a MuJoCo model: docs/mujoco.md."""

    def __init__(
        self,
        model: Any,
        sensor: Union[str, gno.Sensor],
        *,
        site: Union[int, str, None] = None,
        pose: Optional[PoseSource] = None,
        bodyexclude: Bodies = (),
        treeexclude: Bodies = (),
        effects: Optional[gno.Effects] = None,
        fields: adapter.Fields = (),
        geomgroup: Optional[Sequence[int]] = VISIBLE_GROUPS,
        classes: Optional[Mapping[str, int]] = None,
        tessellation: Optional[Tessellation] = None,
        flg_static: bool = True,
        deformables: bool = True,
        options: Optional[gno.SimulatorOptions] = None,
    ) -> None:
        """
        sensor: a Sensor, or the name of a built-in one, whose x axis looks forward and z axis up.
        site: the site that carries the sensor, by name or number. Without it the sensor is at `pose` in the world.
        pose: a Pose of the sensor in the frame of the site; without a site in the world, or a function of MjData that
            returns it.
        bodyexclude: bodies, by names or numbers, whose geoms the sensor does not see; -1 is none.
        treeexclude: bodies that it does not see with all that hang from them, such as the robot that carries it.
        effects, fields: as in SensorRequest; fields also by name, such as "intensity,class".
        geomgroup: six flags: which groups of geoms, flexes and skins there are. None for all. By default those that
            MuJoCo's viewer shows, usually the visual geoms; (0, 0, 0, 1, 0, 0) are then usually those of collisions.
        classes: class numbers by patterns of the names of geoms, their meshes or bodies, such as {"wall*": 3}. The
            longest pattern that fits counts, as in drive files; of equally long ones it is the last. What fits none
            has 0.
        tessellation: how finely curved geoms become triangles, and how far endless planes reach.
        flg_static: whether geoms are there that are welded to the world, as for mj_multiRay().
        deformables: whether flexes and skins are there; mj_multiRay() sees no skins.

        A geom whose alpha is 0 is not there, as for mj_ray(). What cannot be there is one warning that names it.
        """
        self.model = model
        self._shapes = ModelShapes(model, geomgroup, flg_static, classes, tessellation or Tessellation(), deformables)
        adapter.warn_left_out("gnosphere.mujoco", self._shapes.left_out, stacklevel=2)
        ignore = self._shapes.instances_of(bodyexclude, treeexclude)
        super().__init__(self._shapes.shapes, sensor, effects=effects, fields=fields, ignore=ignore, options=options)
        self._mounts = [Mount(model, site, pose)]
        self._rows = np.tile(np.eye(3, 4), (len(self._shapes.shapes.instances), 1, 1))
        self._durations = [durations_of(self.sensors[0])]
        self._records: list[Record] = []
        self._used: set[int] = set()  # the sensors that have scanned with these records
        self._warned = False
        self._warned_of_speeds = False
        self._middle: tuple[float, float, float] = (0.0, 0.0, 0.0)  # where endless planes are put during records

    @property
    def geoms(self) -> npt.NDArray[np.int32]:
        """The geom of each instance; instances of flexes and skins come after those of geoms."""
        return self._shapes.geoms

    def add(
        self,
        sensor: Union[str, gno.Sensor],
        *,
        site: Union[int, str, None] = None,
        pose: Optional[PoseSource] = None,
        bodyexclude: Bodies = (),
        treeexclude: Bodies = (),
        effects: Optional[gno.Effects] = None,
        fields: adapter.Fields = (),
    ) -> int:
        """Adds another sensor to the same model and returns its number, for scan(). The arguments are those of Lidar. The
        records are dropped, as they lack the new sensor."""
        ignore = self._shapes.instances_of(bodyexclude, treeexclude)
        mount = Mount(self.model, site, pose)
        number = self.add_sensor(sensor, effects=effects, fields=fields, ignore=ignore)
        self._mounts[number : number + 1] = [mount]
        self._durations[number : number + 1] = [durations_of(self.sensors[number])]
        self.reset()
        return number

    def pose(self, data: Any, sensor: int = 0) -> gno.Pose:
        """Where the sensor is in the world."""
        return self._mounts[sensor].pose(data)

    def update(self, data: Any, position: npt.ArrayLike = (0, 0, 0)) -> None:
        """Moves everything to where it is in `data`, of which mj_kinematics() must have been run, as mj_step() and
        mj_forward() do. Planes without an end are put around the place on them that is nearest to `position`."""
        self._shapes.place(data, position, self._rows, self.simulator)
        self.move(self._rows)

    def record(self, data: Any) -> None:
        """Notes where the sensors and geoms are, for a scan during which they move: call it after each step of the
        scan, and once at its start. The turn of the next scan() of each sensor ends where `data` then is, and its
        beginning is interpolated between the records, of which earlier ones count for nothing. If the records span less
        than a turn, the sensor and the geoms come from where their mean motion during the records would have had them.
        Flexes and skins stay as they are at the end. Of two records of one time the later one counts. Records of a
        later time, from before mj_resetData(), are dropped, and so are those with which a sensor has scanned.

        What the effects of a sensor leave out of the motions of the sensor and of objects is as at the end."""
        self._drop_later(data)
        if self._used:
            self.reset()
        if self._records and data.time == self._records[-1].time:
            self._records.pop()
        if not self._warned and not any(map(max, self._durations)):
            self._warned = True
            warnings.warn(
                f"gnosphere.mujoco: record() changes nothing, because {self.sensors[0].name} fires all beams at once; "
                "heads that turn, such as Puck, see things move",
                stacklevel=2,
            )
        if not self._records:
            self._middle = self.pose(data).position
        rows = np.empty((len(self.geoms), 3, 4))
        self._shapes.place_geoms(data, self._middle, rows)
        poses = [self.pose(data, number) for number in range(len(self._mounts))]
        self._records.append(Record(float(data.time), poses, rows))
        oldest = self._records[-1].time - max(map(max, self._durations))
        while len(self._records) > 2 and self._records[1].time <= oldest:
            self._records.pop(0)

    def _drop_later(self, data: Any) -> None:
        if self._records and data.time < self._records[-1].time:
            self.reset()

    def reset(self) -> None:
        """Drops the records, so that the next scan() is one of a standing model."""
        self._records = []
        self._used = set()

    def scan(self, data: Any, sensor: int = 0, *, into: Optional[gno.Scan] = None) -> gno.Scan:
        """Scans the model as `data` has it. Points are in the frame of the sensor; those of a scan with record() each
        in its frame at the time of the point, or with Effects.sensor_motion.deskew in its frame at the end. Each sensor
        scans once with the records. Give a Scan of before as `into` and its memory is used again."""
        self._drop_later(data)
        durations = self._durations[sensor]
        duration = durations[self.frames[sensor] % len(durations)]
        if not self._records or not duration or sensor in self._used:
            pose = self.pose(data, sensor)
            self.update(data, pose.position)
            still = self.cast(gno.Shot(pose, sensor, self.frames[sensor]), into)
            self._warn_of_speeds(data, sensor, still)
            return still
        try:
            shot = self._moving_shot(data, sensor, duration)
        finally:
            self._used.add(sensor)
        return self.cast(shot, into)

    def _warn_of_speeds(self, data: Any, sensor: int, scan: gno.Scan) -> None:
        """Warns once of speeds that are asked for, and are 0 in a scan without records although something moves."""
        asked = scan.has(gno.Field.radial_speed) or scan.has(gno.Field.velocity)
        if self._warned_of_speeds or not asked or not np.any(data.qvel):
            return
        self._warned_of_speeds = True
        name = self.sensors[sensor].name
        if any(self._durations[sensor]):
            why = (
                "a scan without record() is one of a standing model; call record() at the start of the scan and after "
                "each mj_step()"
            )
        else:
            why = (
                f"{name} fires all beams at once; with a rotation_period of 0.001 s, and record() after each mj_step(), "
                "it measures them"
            )
        warnings.warn(
            f"gnosphere.mujoco: radial_speed and velocity are 0, although things move, because {why}", stacklevel=3
        )

    def _moving_shot(self, data: Any, sensor: int, duration: float) -> gno.Shot:
        """A shot whose beams fire during the `duration` seconds before `data`, and its scene as it is at its start."""
        records = [record for record in self._records if record.time < data.time]
        if not records:
            raise ValueError("the scan ends at the time at which its first record() was made")
        now = self.pose(data, sensor)
        self._shapes.place(data, self._middle, self._rows, self.simulator)
        ends = self._rows[: len(self.geoms)]
        start = float(data.time) - duration
        path = [(record.time - start, record.poses[sensor]) for record in records]
        path.append((duration, now))
        starts = ends
        if self.simulator.plan(sensor).has("object-motion"):
            starts = _geoms_at(start, [(record.time, record.geoms) for record in records] + [(float(data.time), ends)])
        moved = np.flatnonzero(np.any(ends != starts, axis=(1, 2)))
        motions = [gno.InstanceMotion(int(i), gno.Transform(ends[i])) for i in moved]
        self._rows[: len(starts)] = starts
        self.move(self._rows)
        stamps = [gno.SensorMotion.Stamp(time, pose) for time, pose in _beyond_both_ends(path, duration)]
        return gno.Shot(now, sensor, self.frames[sensor], gno.SensorMotion(stamps), motions)

    def geom_ids(self, scan: gno.Scan) -> npt.NDArray[np.int32]:
        """The geom of each entry of a scan; -1 without a return, and on flexes and skins."""
        table = np.append(self.geoms, np.int32(-1))
        found: npt.NDArray[np.int32] = table[np.minimum(scan.instances, len(self.geoms))]
        return found

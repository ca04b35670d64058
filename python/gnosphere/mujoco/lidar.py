# SPDX-License-Identifier: Apache-2.0
"""Sensors in a MuJoCo model."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Optional, Union

import mujoco as mj
import numpy as np
import numpy.typing as npt

from .. import _gnosphere as gno
from .. import adapter
from .shapes import VISIBLE_GROUPS, ModelShapes, Tessellation

Body = Union[int, str]
Bodies = Union[Body, Iterable[Body]]
PoseSource = Union[gno.Pose, Callable[[Any], gno.Pose]]


def body_ids(model: Any, bodies: Bodies) -> list[int]:
    listed = [bodies] if isinstance(bodies, (str, int, np.integer)) else list(bodies)
    found = [model.body(body).id if isinstance(body, str) else int(body) for body in listed if body != -1]
    for body in found:
        if not 0 <= body < model.nbody:
            raise ValueError(f"there is no body {body} to exclude; the model has {model.nbody} bodies, and -1 is none")
    return found


class Mount:
    """What carries a sensor: a site, the world, or what a function of MjData says."""

    def __init__(self, model: Any, site: Union[int, str, None], pose: Optional[PoseSource]) -> None:
        if site is not None and callable(pose):
            raise TypeError("pose is a Pose in the frame of the site, not a function, where there is a site")
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
            first pattern that fits counts; what fits none has 0.
        tessellation: how finely curved geoms become triangles, and how far endless planes reach.
        flg_static: whether geoms are there that are welded to the world, as for mj_multiRay().
        deformables: whether flexes and skins are there; mj_multiRay() sees no skins.

        A geom whose alpha is 0 is not there, as for mj_ray(). What cannot be there is one warning that names it.
        """
        self.model = model
        self._shapes = ModelShapes(model, geomgroup, flg_static, classes, tessellation or Tessellation(), deformables)
        adapter.warn_left_out("gnosphere.mujoco", self._shapes.left_out, stacklevel=2)
        ignore = self._shapes.instances_of(body_ids(model, bodyexclude), body_ids(model, treeexclude))
        super().__init__(self._shapes.shapes, sensor, effects=effects, fields=fields, ignore=ignore, options=options)
        self._mounts = [Mount(model, site, pose)]
        count = len(self._shapes.shapes.instances)
        self._rows = np.zeros((count, 3, 4))
        self._rows[:, [0, 1, 2], [0, 1, 2]] = 1
        self._records: list[tuple[float, Any]] = []
        self._start: Optional[npt.NDArray[np.float64]] = None
        self._warned = False
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
        """Adds another sensor to the same model and returns its number, for scan(). The arguments are those of
        Lidar."""
        ignore = self._shapes.instances_of(body_ids(self.model, bodyexclude), body_ids(self.model, treeexclude))
        mount = Mount(self.model, site, pose)
        number = self.add_sensor(sensor, effects=effects, fields=fields, ignore=ignore)
        self._mounts[number:] = [mount]
        return number

    def pose(self, data: Any, sensor: int = 0) -> gno.Pose:
        """Where the sensor is in the world."""
        return self._mounts[sensor].pose(data)

    def update(self, data: Any, position: npt.ArrayLike = (0, 0, 0)) -> None:
        """Moves everything to where it is in `data`, of which mj_kinematics() must have been run, as mj_step() and
        mj_forward() do. Planes without an end are put around the place on them that is nearest to `position`."""
        self._place(data, position)
        self.move(self._rows)

    def _place(self, data: Any, position: npt.ArrayLike) -> None:
        self._shapes.place(data, position, self._rows, self.simulator)

    def record(self, data: Any) -> None:
        """Notes where the sensors and geoms are, for a scan during which they move: call it at the start of the scan
        and after each step of it; the next scan() ends where `data` then is. Flexes and skins stay as they are at its
        end. Records of a later time, from before mj_resetData(), are dropped."""
        self._drop_later(data)
        if not self._warned and all(sensor.rotation_period == 0 for sensor in self.sensors):
            self._warned = True
            warnings.warn(
                f"gnosphere.mujoco: record() changes nothing, because {self.sensors[0].name} fires all beams at once; "
                "heads that turn, such as Puck, see things move",
                stacklevel=2,
            )
        if self._start is None:
            self._middle = self.pose(data).position
            self._place(data, self._middle)
            self._start = self._rows.copy()
        self._records.append((float(data.time), [self.pose(data, number) for number in range(len(self._mounts))]))

    def _drop_later(self, data: Any) -> None:
        if self._records and data.time < self._records[-1][0]:
            self.reset()

    def reset(self) -> None:
        """Drops the records, so that the next scan() is one of a standing model."""
        self._records, self._start = [], None

    def scan(self, data: Any, sensor: int = 0, *, into: Optional[gno.Scan] = None) -> gno.Scan:
        """Scans the model as `data` has it. Points are in the frame of the sensor; those of a scan with record() each
        in its frame at the time of the point, or with Effects.sensor_motion.deskew in its frame at the end. Give a Scan
        of before as `into` and its memory is used again."""
        self._drop_later(data)
        if not self._records:
            pose = self.pose(data, sensor)
            self.update(data, pose.position)
            return self.cast(gno.Shot(pose, sensor, self.frame), into)
        try:
            shot = self._moving_shot(data, sensor)
        finally:
            self.reset()
        return self.cast(shot, into)

    def _moving_shot(self, data: Any, sensor: int) -> gno.Shot:
        start, records = self._start, [record for record in self._records if record[0] < data.time]
        if start is None or not records:
            raise ValueError("the scan ends at the time at which its first record() was made")
        now = self.pose(data, sensor)
        first = records[0][0]
        stamps = [gno.SensorMotion.Stamp(time - first, poses[sensor]) for time, poses in records]
        stamps.append(gno.SensorMotion.Stamp(float(data.time) - first, now))
        self._place(data, self._middle)
        # An instance moves for a turn of the sensor, however long the records are.
        share = self.sensors[sensor].rotation_period / (float(data.time) - first)
        ends = start + share * (self._rows - start)
        count = len(self.geoms)
        moved = np.flatnonzero(np.any(self._rows[:count] != start[:count], axis=(1, 2)))
        start[count:] = self._rows[count:]
        self.move(start)
        motions = [gno.InstanceMotion(int(i), gno.Transform(ends[i])) for i in moved]
        return gno.Shot(now, sensor, self.frame, gno.SensorMotion(stamps), motions)

    def geom_ids(self, scan: gno.Scan) -> npt.NDArray[np.int32]:
        """The geom of each entry of a scan; -1 without a return, and on flexes and skins."""
        table = np.append(self.geoms, np.int32(-1))
        found: npt.NDArray[np.int32] = table[np.minimum(scan.instances, len(self.geoms))]
        return found

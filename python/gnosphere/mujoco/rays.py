# SPDX-License-Identifier: Apache-2.0
"""Distances alone, in place of mj_multiRay() and of rangefinders."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, Optional

import mujoco as mj
import numpy as np
import numpy.typing as npt

from .. import _gnosphere as gno
from .. import adapter
from .lidar import Lidar
from .shapes import Tessellation

FARTHEST = 1e4
"""Metres: how far a ray looks where nothing says so, and at most."""

Distances = npt.NDArray[np.float64]
Geoms = npt.NDArray[np.int32]


def _beams(directions: npt.ArrayLike, origins: Optional[npt.ArrayLike], cutoff: float) -> gno.Sensor:
    sensor = gno.Sensor()
    sensor.name = "rays"
    sensor.range_min = 0
    sensor.range_max = min(cutoff, FARTHEST)
    sensor.patterns = [gno.BeamList(directions, origins)]
    return sensor


class Rays:
    """Rays that keep their directions in a frame that moves, and start at its origin."""

    def __init__(
        self,
        model: Any,
        vec: npt.ArrayLike,
        *,
        geomgroup: Optional[Sequence[int]] = None,
        flg_static: bool = True,
        bodyexclude: int = -1,
        cutoff: float = FARTHEST,
        tessellation: Optional[Tessellation] = None,
        options: Optional[gno.SimulatorOptions] = None,
    ) -> None:
        """`vec` has a direction per ray, shape (n, 3) or (3 n,), of any length but zero; the others are those of
        mj_multiRay() and of Lidar."""
        self._lengths, directions = _split(vec)
        self.lidar = Lidar(
            model, _beams(directions, None, cutoff), effects=gno.Effects.none(), geomgroup=geomgroup,
            bodyexclude=() if bodyexclude < 0 else bodyexclude, tessellation=tessellation, flg_static=flg_static,
            deformables=False, options=options,
        )  # fmt: skip
        self._cutoff, self._bodyexclude, self._sensor = cutoff, bodyexclude, 0
        self._scan = gno.Scan()

    def aim(self, vec: npt.ArrayLike) -> None:
        """Gives the rays other directions, which takes as long as making a sensor. If it raises an error, the rays keep
        those that they have."""
        lengths, directions = _split(vec)
        excluded = () if self._bodyexclude < 0 else self._bodyexclude
        beams = _beams(directions, None, self._cutoff)
        added = self.lidar.add(beams, bodyexclude=excluded, effects=gno.Effects.none())
        self.lidar.simulator.remove_sensor(self._sensor)
        self._lengths, self._sensor = lengths, added

    def cast(self, data: Any, pnt: npt.ArrayLike, mat: Optional[npt.ArrayLike] = None) -> tuple[Distances, Geoms]:
        """Where the rays from `pnt`, turned by the matrix `mat`, meet the first geom: the distance in lengths of
        `vec`, and the geom; -1 and -1 where there is none."""
        self.lidar.update(data, np.reshape(pnt, 3))
        turn = (0, 0, 0, 1) if mat is None else np.asarray(mat, np.float64).reshape(3, 3)
        scan = self.lidar.cast(gno.Shot(adapter.pose_of(np.reshape(pnt, 3), turn), self._sensor), self._scan)
        with np.errstate(invalid="ignore"):
            distances = np.where(np.isnan(scan.ranges), -1.0, scan.ranges / self._lengths)
        return distances, self.lidar.geom_ids(scan)


def _split(vec: npt.ArrayLike) -> tuple[Distances, Distances]:
    directions = np.asarray(vec, np.float64).reshape(-1, 3)
    lengths = np.linalg.norm(directions, axis=1)
    unusable = np.flatnonzero(~((lengths > 0) & np.isfinite(lengths)))
    if len(unusable):
        raise ValueError(f"vec: the direction of ray {unusable[0]} is {directions[unusable[0]]}, which has no length")
    return lengths, directions / lengths[:, None]


_kept: list[tuple[Any, Any, npt.NDArray[Any], Rays]] = []


def mj_multiRay(
    m: Any,
    d: Any,
    pnt: npt.ArrayLike,
    vec: npt.ArrayLike,
    geomgroup: Optional[Sequence[int]],
    flg_static: int,
    bodyexclude: int,
    geomid: npt.NDArray[np.int32],
    dist: npt.NDArray[np.float64],
    normal: Optional[npt.NDArray[np.float64]],
    nray: int,
    cutoff: float,
) -> None:
    """mujoco.mj_multiRay() with the same arguments. The scene is made in the first call for a model, and kept with the
    last few; keep the directions in the frame of the sensor and use Rays if they turn, because other directions are
    another sensor. Geoms are triangles here, see Tessellation. `normal` must be None, and rays look no further than
    FARTHEST. Raises ValueError for a direction without a length, TypeError for `dist` and `geomid` that are no arrays of
    their type whose memory is in order."""
    if normal is not None:
        raise ValueError("mj_multiRay: normals come from Lidar(..., fields='normal'); give None here")
    _check_written("dist", dist, np.float64, nray)
    _check_written("geomid", geomid, np.int32, nray)
    if not cutoff > 0:
        _flat(dist)[:nray] = -1
        _flat(geomid)[:nray] = -1
        return
    given = np.array(vec, np.float64).reshape(-1, 3)[:nray]
    groups = None if geomgroup is None else tuple(int(flag) for flag in np.ravel(geomgroup))
    key = (groups, bool(flg_static), int(bodyexclude), float(cutoff))
    for i, (model, settings, aimed, rays) in enumerate(_kept):
        if model is m and settings == key:
            if not np.array_equal(aimed, given):
                rays.aim(given)
            _kept.pop(i)
            break
    else:
        rays = Rays(m, given, geomgroup=groups, flg_static=bool(flg_static), bodyexclude=bodyexclude, cutoff=cutoff)
    _kept.append((m, key, given, rays))
    del _kept[:-4]
    distances, geoms = rays.cast(d, pnt)
    _flat(dist)[:nray] = distances
    _flat(geomid)[:nray] = geoms


def _check_written(name: str, array: Any, kind: Any, count: int) -> None:
    if not isinstance(array, np.ndarray) or array.dtype != kind or not array.flags.c_contiguous:
        raise TypeError(f"mj_multiRay: {name} must be a contiguous array of {np.dtype(kind).name}")
    if not array.flags.writeable or array.size < count:
        raise TypeError(f"mj_multiRay: {name} must be writable and have {count} entries")


def _flat(array: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """The entries of a contiguous array, in its own memory."""
    return array.reshape(-1)


def rangefinder_sites(model: Any) -> tuple[npt.NDArray[Any], Distances, int]:
    """The sites of the rangefinders of a model and their cutoffs, 0 for none; and how many cameras have instead."""
    finders = np.flatnonzero(model.sensor_type == int(mj.mjtSensor.mjSENS_RANGEFINDER))
    chosen = finders[model.sensor_objtype[finders] == int(mj.mjtObj.mjOBJ_SITE)]
    return model.sensor_objid[chosen], model.sensor_cutoff[chosen], len(finders) - len(chosen)


def beams_by_body(model: Any, sites: npt.NDArray[Any]) -> Iterator[tuple[int, npt.NDArray[Any], gno.Sensor]]:
    """For each body that carries sites: the body, the entries of `sites`, and a sensor in the frame of the body with
    a beam along the z axis of each."""
    bodies = model.site_bodyid[sites]
    for body in np.unique(bodies):
        mine = np.flatnonzero(bodies == body)
        turns = np.zeros((len(mine), 9))
        for row, site in zip(turns, sites[mine]):
            mj.mju_quat2Mat(row, model.site_quat[site])
        yield int(body), mine, _beams(turns[:, [2, 5, 8]], model.site_pos[sites[mine]], FARTHEST)


class Rangefinders:
    """The rangefinders of a model that sites carry, each a beam along the z axis of its site.

    Those whose sites are on one body are scanned together. Remove the rangefinders from the model, or disable sensors,
    and mj_step() no longer pays for them: `sites` names sites instead.
    """

    def __init__(
        self,
        model: Any,
        *,
        sites: Optional[Sequence[str]] = None,
        geomgroup: Optional[Sequence[int]] = None,
        cutoff: float = 0.0,
        tessellation: Optional[Tessellation] = None,
        options: Optional[gno.SimulatorOptions] = None,
    ) -> None:
        """`sites`: the sites, in the order of the answer; None for those of the model's rangefinders. `cutoff` in
        metres, 0 for none, where `sites` are given; rangefinders have their own. As in MuJoCo, a ray does not see
        geoms of the body that carries its site."""
        if sites is None:
            numbers, cutoffs, cameras = rangefinder_sites(model)
            if cameras:
                adapter.warn_left_out("gnosphere.mujoco", {"rangefinders of cameras": cameras})
        else:
            numbers = np.array([model.site(name).id for name in sites], int)
            cutoffs = np.full(len(numbers), float(cutoff))
        self._cutoffs = np.where(cutoffs > 0, cutoffs, np.inf)
        self._lidar: Optional[Lidar] = None
        self._beams: list[tuple[int, npt.NDArray[Any], gno.Scan]] = []  # body, beams, memory
        for body, mine, sensor in beams_by_body(model, numbers):
            if self._lidar is None:
                self._lidar = Lidar(
                    model, sensor, bodyexclude=body, effects=gno.Effects.none(), geomgroup=geomgroup,
                    tessellation=tessellation, deformables=False, options=options,
                )  # fmt: skip
            else:
                self._lidar.add(sensor, bodyexclude=body, effects=gno.Effects.none())
            self._beams.append((body, mine, gno.Scan()))

    def read(self, data: Any) -> Distances:
        """The distance of each rangefinder in metres, its cutoff if that is less; -1 if its ray meets nothing."""
        result = np.full(len(self._cutoffs), -1.0)
        if self._lidar is None:
            return result
        for sensor, (body, mine, scan) in enumerate(self._beams):
            w, x, y, z = data.xquat[body]
            pose = gno.Pose(tuple(data.xpos[body].tolist()), (x, y, z, w))
            self._lidar.update(data, pose.position)
            ranges = self._lidar.cast(gno.Shot(pose, sensor), scan).ranges
            result[mine] = np.where(np.isnan(ranges), -1, np.minimum(ranges, self._cutoffs[mine]))
        return result

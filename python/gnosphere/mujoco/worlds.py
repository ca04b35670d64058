# SPDX-License-Identifier: Apache-2.0
"""Many MuJoCo worlds as one batch."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from types import SimpleNamespace
from typing import Any, Optional, Union

import mujoco as mj
import numpy as np
import numpy.typing as npt

from .. import _gnosphere as gno
from .. import adapter
from .lidar import Mount, PoseSource
from .shapes import VISIBLE_GROUPS, Bodies, ModelShapes, Tessellation

# Numbers per geom or site in the states of all worlds.
_STATE = {"geom_xpos": 3, "geom_xmat": 9, "site_xpos": 3, "site_xmat": 9}


def _states_of(data: Any) -> list[Any]:
    """The state of each world, from one object with those of all worlds."""
    arrays = {}
    for name, numbers in _STATE.items():
        array = np.asarray(getattr(data, name), np.float64)
        if array.ndim < 3:
            raise ValueError(
                f"gnosphere.mujoco.Worlds: {name} has the shape {array.shape}, without a dimension of worlds"
            )
        arrays[name] = array.reshape(*array.shape[:2], numbers)
    return [SimpleNamespace(**dict(zip(arrays, state))) for state in zip(*arrays.values())]


def _fields_of(fields: adapter.Fields) -> list[gno.Field]:
    """The fields of a batch, from which geom_ids() finds its geoms."""
    others = (field for field in gno.parse_fields(fields) if field != gno.Field.instance)
    return [gno.Field.instance, *others]


class Worlds(adapter.Lidar):
    """Sensors in each of many worlds, which scan together: docs/mujoco.md."""

    def __init__(
        self,
        models: Iterable[Any],
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
        """`models` has the MjModel of each world; one model may stand there many times, and its meshes are there once.
        Sites and bodies by name are looked for in each model. The rest: see Lidar."""
        if isinstance(models, mj.MjModel):
            raise TypeError("gnosphere.mujoco.Worlds: models is one MjModel; give one for each world: [model] * n")
        self.models = list(models)
        if not self.models:
            raise ValueError("gnosphere.mujoco.Worlds: there is no model")
        self._mounts = [self._mounts_of(site, pose)]
        self._worlds: list[ModelShapes] = []
        left_out, counted = Counter[str](), set[int]()  # a model that stands in several worlds counts once
        for number, model in enumerate(self.models):
            made = ModelShapes(
                model, geomgroup, flg_static, classes, tessellation or Tessellation(), deformables, number + 1,
                self._worlds[0] if self._worlds else None,
            )  # fmt: skip
            self._worlds.append(made)
            if id(model) not in counted:
                left_out.update(made.left_out)
            counted.add(id(model))
        adapter.warn_left_out("gnosphere.mujoco", left_out, stacklevel=2)
        shapes = self._worlds[0].shapes
        ignore = self._instances_of(bodyexclude, treeexclude)
        super().__init__(shapes, sensor, effects=effects, fields=fields, ignore=ignore, options=options)
        self._rows = np.tile(np.eye(3, 4), (len(shapes.instances), 1, 1))
        self._geoms = np.full(len(shapes.instances) + 1, -1, np.int32)
        for made in self._worlds:
            self._geoms[made.first :][: len(made.geoms)] = made.geoms
        self._poses = np.empty((len(self.models), 7))
        self._fields = [_fields_of(fields)]

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
        """Adds another sensor to each world and returns its number, for scan(). The arguments are those of Worlds."""
        mounts = self._mounts_of(site, pose)
        ignore = self._instances_of(bodyexclude, treeexclude)
        number = self.add_sensor(sensor, effects=effects, fields=fields, ignore=ignore)
        self._mounts[number : number + 1] = [mounts]
        self._fields[number : number + 1] = [_fields_of(fields)]
        return number

    def _mounts_of(self, site: Union[int, str, None], pose: Optional[PoseSource]) -> list[Mount]:
        return [Mount(model, site, pose) for model in self.models]

    def _instances_of(self, bodies: Bodies, trees: Bodies) -> list[int]:
        hidden: list[int] = np.concatenate([made.instances_of(bodies, trees) for made in self._worlds]).tolist()
        return hidden

    def scan(self, datas: Union[Sequence[Any], Any], sensor: int = 0, *, into: Optional[gno.Batch] = None) -> gno.Batch:
        """Scans each world as its MjData has it, of which mj_kinematics() must have been run. The batch has the ranges,
        the instances and the fields that were asked for; a view has the bytes of Lidar.scan() with the same frame.
        `sensor` is a number of add().

        In place of MjData of each world, `datas` may be one object with the states of all: `geom_xpos`, `geom_xmat`,
        `site_xpos` and `site_xmat` with the world as first dimension, as MJX and MuJoCo Warp have them. Flexes and
        skins need MjData."""
        if hasattr(datas, "geom_xpos"):
            if any(made.flexes or made.skins for made in self._worlds):
                raise ValueError(
                    "gnosphere.mujoco.Worlds: a model has flexes or skins, so scan() needs MjData of each world"
                )
            datas = _states_of(datas)
        if len(datas) != len(self.models):
            raise ValueError(f"there are {len(self.models)} worlds, so scan() needs as many MjData, not {len(datas)}")
        for mount, made, data, row in zip(self._mounts[sensor], self._worlds, datas, self._poses):
            pose = mount.pose(data)
            row[:3], row[3:] = pose.position, pose.orientation
            made.place(data, pose.position, self._rows[made.first :], self.simulator)
        for number, row in enumerate(self._poses):
            if not np.isfinite(row).all():
                raise ValueError(f"gnosphere.mujoco.Worlds: the sensor of world {number} has the pose {row.tolist()}")
        self.move(self._rows)
        batch = gno.Batch() if into is None else into
        count = len(self.models)
        worlds = np.arange(1, count + 1, dtype=np.uint32)
        self.simulator.scan_batch_into(
            self._poses, batch, sensor=sensor, worlds=worlds, frame=self.frames[sensor], fields=self._fields[sensor]
        )
        # One more than a multiple of the number of patterns, so that each world goes through all of them.
        self.frames[sensor] += count + (1 - count) % max(1, len(self.sensors[sensor].patterns))
        return batch

    def geom_ids(self, batch: gno.Batch) -> npt.NDArray[np.int32]:
        """The geom of each entry of a batch, in the model of its world; -1 without a return, and on flexes and
        skins."""
        found: npt.NDArray[np.int32] = self._geoms[np.minimum(batch.instances, len(self._geoms) - 1)]
        return found

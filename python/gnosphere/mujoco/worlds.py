# SPDX-License-Identifier: Apache-2.0
"""Many MuJoCo worlds as one batch."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Optional, Union

import mujoco as mj
import numpy as np
import numpy.typing as npt

from .. import _gnosphere as gno
from .. import adapter
from .lidar import Mount, PoseSource
from .shapes import VISIBLE_GROUPS, Bodies, ModelShapes, Tessellation


class Worlds(adapter.Lidar):
    """A sensor in each of many worlds, which scan together: docs/mujoco.md."""

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
        self._mounts = [Mount(model, site, pose) for model in self.models]
        self._worlds: list[ModelShapes] = []
        left_out: dict[str, int] = {}
        for number, model in enumerate(self.models):
            made = ModelShapes(
                model, geomgroup, flg_static, classes, tessellation or Tessellation(), deformables, number + 1,
                self._worlds[0] if self._worlds else None,
            )  # fmt: skip
            self._worlds.append(made)
            left_out.update(made.left_out)
        adapter.warn_left_out("gnosphere.mujoco", left_out, stacklevel=2)
        hidden = [made.instances_of(bodyexclude, treeexclude) for made in self._worlds]
        shapes = self._worlds[0].shapes
        super().__init__(
            shapes, sensor, effects=effects, fields=fields, ignore=np.concatenate(hidden).tolist(), options=options
        )
        self._rows = np.tile(np.eye(3, 4), (len(shapes.instances), 1, 1))
        self._geoms = np.full(len(shapes.instances) + 1, -1, np.int32)
        for made in self._worlds:
            self._geoms[made.first :][: len(made.geoms)] = made.geoms
        self._poses = np.empty((len(self.models), 7))
        listed = gno.parse_fields(fields) if isinstance(fields, str) and fields else tuple(map(gno.Field, fields))
        self._fields = [gno.Field.instance, *(field for field in listed if field != gno.Field.instance)]

    def scan(self, datas: Sequence[Any], *, into: Optional[gno.Batch] = None) -> gno.Batch:
        """Scans each world as its MjData has it, of which mj_kinematics() must have been run. The batch has the ranges,
        the instances and the fields that were asked for; a view has the bytes of Lidar.scan() with the same frame."""
        if len(datas) != len(self.models):
            raise ValueError(f"there are {len(self.models)} worlds, so scan() needs as many MjData, not {len(datas)}")
        for mount, made, data, row in zip(self._mounts, self._worlds, datas, self._poses):
            pose = mount.pose(data)
            row[:3], row[3:] = pose.position, pose.orientation
            made.place(data, pose.position, self._rows[made.first :], self.simulator)
        self.move(self._rows)
        batch = gno.Batch() if into is None else into
        worlds = np.arange(1, len(self.models) + 1, dtype=np.uint32)
        self.simulator.scan_batch_into(self._poses, batch, worlds=worlds, frame=self.frame, fields=self._fields)
        self.frame += len(self.models)
        return batch

    def geom_ids(self, batch: gno.Batch) -> npt.NDArray[np.int32]:
        """The geom of each entry of a batch, in the model of its world; -1 without a return, and on flexes and
        skins."""
        found: npt.NDArray[np.int32] = self._geoms[np.minimum(batch.instances, len(self._geoms) - 1)]
        return found

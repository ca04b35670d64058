# SPDX-License-Identifier: Apache-2.0
"""LiDARs in SAPIEN: what its renderer shows, all bodies that there are when the Lidar is made."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any, Optional

import numpy as np
import sapien

from .. import _gnosphere as gno
from .. import adapter, primitives


class Lidar(adapter.Lidar):
    def __init__(
        self, scene: Any, sensor: Any, *, ignore_entities: Iterable[Any] = (),
        classes: Optional[Mapping[str, int]] = None, **options: Any,
    ) -> None:  # fmt: skip
        """`ignore_entities` are those that the sensor does not see; `classes` are numbers by patterns of entity names.
        The rest: see adapter.Lidar."""
        shapes, ignored = adapter.Shapes(), set(ignore_entities)
        ignore: list[int] = []
        self.entities: list[Any] = []  # the entity of each instance
        for entity in scene.entities:
            for shape in self._shown(entity):
                local = shape.local_pose.to_transformation_matrix() @ np.diag([*self._scale(shape), 1.0])
                for part in shape.parts:
                    triangles = primitives.moved((part.vertices, part.triangles), local)
                    mesh = shapes.mesh(triangles, shapes.material(part.material.base_color))
                    index = shapes.instance(mesh, class_id=adapter.class_of(classes, entity.name), name=entity.name)
                    self.entities.append(entity)
                    if entity in ignored:
                        ignore.append(index)
        super().__init__(shapes, sensor, ignore=ignore, **options)

    @staticmethod
    def _shown(entity: Any) -> Iterator[Any]:
        """The shapes that the renderer shows of an entity, which may have several bodies."""
        for body in entity.components:
            if isinstance(body, sapien.render.RenderBodyComponent) and body.is_enabled and body.visibility > 0:
                yield from body.render_shapes

    @staticmethod
    def _scale(shape: Any) -> Any:
        """SAPIEN keeps most of its shapes in unit size."""
        if isinstance(shape, sapien.render.RenderShapeBox):
            return shape.half_size
        if isinstance(shape, sapien.render.RenderShapeSphere):
            return [shape.radius] * 3
        if isinstance(shape, sapien.render.RenderShapeCylinder):
            return [shape.half_length, shape.radius, shape.radius]
        return getattr(shape, "scale", (1.0, 1.0, 1.0))

    def scan(self, pose: gno.Pose, sensor: int = 0, *, into: Optional[gno.Scan] = None) -> gno.Scan:
        """Scans the entities where they are now."""
        rows = np.empty((len(self.entities), 7))
        for row, entity in zip(rows, self.entities):
            place = entity.pose
            row[:3], row[3:6], row[6] = place.p, place.q[1:], place.q[0]
        return self._scan_at(rows, pose, sensor, into)

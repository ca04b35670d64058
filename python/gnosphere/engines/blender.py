# SPDX-License-Identifier: Apache-2.0
"""LiDARs in Blender (the package bpy): all that a dependency graph shows, with modifiers and instances."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, Optional

import numpy as np

from .. import _gnosphere as gno
from .. import adapter, primitives

SURFACES = ("MESH", "CURVE", "SURFACE", "FONT", "META")


def _triangles(data: Any) -> primitives.Triangles:
    data.calc_loop_triangles()
    vertices = np.empty(3 * len(data.vertices), np.float32)
    faces = np.empty(3 * len(data.loop_triangles), np.int32)
    data.vertices.foreach_get("co", vertices)
    data.loop_triangles.foreach_get("vertices", faces)
    return vertices.reshape(-1, 3), faces.reshape(-1, 3).astype(np.uint32)


class Lidar(adapter.Lidar):
    def __init__(
        self, depsgraph: Any, sensor: Any, *, ignore_objects: Iterable[str] = (),
        classes: Optional[Mapping[str, int]] = None, **options: Any,
    ) -> None:  # fmt: skip
        """`depsgraph` is that of bpy.context.evaluated_depsgraph_get(). `ignore_objects` are names of objects that the
        sensor does not see; `classes` are numbers by patterns of object and collection names. The rest: see
        adapter.Lidar."""
        shapes, hidden = adapter.Shapes(), set(ignore_objects)
        meshes: dict[tuple[str, int], int] = {}  # by object and data: geometry nodes make instances of other data
        self.names: list[str] = []  # of the object of each instance
        for shown in depsgraph.object_instances:
            thing = shown.object
            if thing.type not in SURFACES or not shown.show_self:
                continue
            key = (thing.name_full, thing.data.as_pointer())
            if key not in meshes:
                triangles = _triangles(thing.to_mesh())
                thing.to_mesh_clear()
                material = thing.active_material
                color = material.diffuse_color if material else (0.5, 0.5, 0.5, 1)
                number = shapes.material([*color], material.name if material else "")
                meshes[key] = shapes.mesh(triangles, number) if len(triangles[1]) else -1
            if meshes[key] < 0:
                continue
            collections = [collection.name for collection in thing.original.users_collection]
            kind = adapter.class_of(classes, thing.name, *collections)
            shapes.instance(meshes[key], np.array(shown.matrix_world), class_id=kind, name=thing.name)
            self.names.append(thing.name)
        ignore = [i for i, name in enumerate(self.names) if name in hidden]
        super().__init__(shapes, sensor, ignore=ignore, **options)

    def scan(self, depsgraph: Any, pose: gno.Pose, sensor: int = 0, *, into: Optional[gno.Scan] = None) -> gno.Scan:
        """Scans the objects where they are in the frame of the dependency graph. Where an object appears, goes or
        changes its shape, another Lidar is needed."""
        known = set(self.names)
        maps = [
            np.array(shown.matrix_world)[:3]
            for shown in depsgraph.object_instances
            if shown.object.type in SURFACES and shown.show_self and shown.object.name in known
        ]
        if len(maps) != len(self.names):
            raise ValueError(f"there were {len(self.names)} instances, now there are {len(maps)}; make another Lidar")
        if maps:
            self.move(np.stack(maps))
        return self.cast(gno.Shot(pose, sensor, self.frame), into)

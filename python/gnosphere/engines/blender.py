# SPDX-License-Identifier: Apache-2.0
"""LiDARs in Blender (the package bpy): all that a dependency graph shows, with modifiers and instances."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from typing import Any, Optional

import numpy as np

from .. import _gnosphere as gno
from .. import adapter, primitives

SURFACES = ("MESH", "CURVE", "SURFACE", "FONT", "META")


def _triangles(data: Any) -> tuple[primitives.Triangles, adapter.Array]:
    """The triangles of a mesh, and the material slot of each."""
    data.calc_loop_triangles()
    vertices = np.empty(3 * len(data.vertices), np.float32)
    faces = np.empty(3 * len(data.loop_triangles), np.int32)
    slots = np.empty(len(data.loop_triangles), np.int32)
    data.vertices.foreach_get("co", vertices)
    data.loop_triangles.foreach_get("vertices", faces)
    data.loop_triangles.foreach_get("material_index", slots)
    return (vertices.reshape(-1, 3), faces.reshape(-1, 3).astype(np.uint32)), slots


class Materials:
    """The materials of Blender in the shapes, each once."""

    def __init__(self, shapes: adapter.Shapes) -> None:
        self.left_out = Counter[str]()
        self._shapes = shapes
        self._numbers: dict[str, int] = {}

    def number(self, material: Any) -> int:
        """The number of a material, or of what an empty slot has."""
        name = material.name_full if material else ""
        if name not in self._numbers:
            color = self._color(material) if material else (0.5, 0.5, 0.5, 1)
            self._numbers[name] = self._shapes.material(color, material.name if material else "")
        return self._numbers[name]

    def _color(self, material: Any) -> list[float]:
        """The colour and alpha of the Principled BSDF of a material, or else those that it has in the viewport."""
        output = material.node_tree.get_output_node("ALL") if material.node_tree else None
        links = output.inputs["Surface"].links if output else ()
        if not links or links[0].from_node.type != "BSDF_PRINCIPLED":
            return [*material.diffuse_color]
        color = []
        for name, seen in (("Base Color", [*material.diffuse_color][:3]), ("Alpha", [material.diffuse_color[3]])):
            stated = links[0].from_node.inputs[name]
            if stated.is_linked:
                self.left_out[f"the nodes of the {name} of materials, which are as in the viewport"] += 1
            else:
                seen = np.ravel(stated.default_value)[: len(seen)].tolist()
            color += seen
        return color


class Lidar(adapter.Lidar):
    def __init__(
        self, depsgraph: Any, sensor: Any, *, ignore_objects: Iterable[str] = (),
        classes: Optional[Mapping[str, int]] = None, **options: Any,
    ) -> None:  # fmt: skip
        """`depsgraph` is that of bpy.context.evaluated_depsgraph_get(). `ignore_objects` are names of objects that the
        sensor does not see; `classes` are numbers by patterns of object and collection names. The rest: see
        adapter.Lidar."""
        shapes, hidden = adapter.Shapes(), set(ignore_objects)
        materials = Materials(shapes)
        plain = materials.number(None)
        meshes: dict[tuple[str, int], int] = {}  # by object and data: geometry nodes make instances of other data
        self.names: list[str] = []  # of the object of each instance
        self._known: set[tuple[str, str]] = set()  # objects with their data that have triangles
        for shown in depsgraph.object_instances:
            thing = shown.object
            if thing.type not in SURFACES or not shown.show_self:
                continue
            key = (thing.name_full, thing.data.as_pointer())
            if key not in meshes:
                triangles, slots = _triangles(thing.to_mesh())
                thing.to_mesh_clear()
                numbers = np.array([materials.number(slot.material) for slot in thing.material_slots] or [plain])
                faces = numbers[np.minimum(slots, len(numbers) - 1)]
                meshes[key] = shapes.mesh(triangles, faces) if len(faces) else -1
            if meshes[key] < 0:
                continue
            collections = [collection.name for collection in thing.original.users_collection]
            kind = adapter.class_of(classes, thing.name, *collections)
            shapes.instance(meshes[key], np.array(shown.matrix_world), class_id=kind, name=thing.name)
            self.names.append(thing.name)
            self._known.add((thing.name_full, thing.data.name_full))
        adapter.warn_left_out("gnosphere.engines.blender", materials.left_out)
        ignore = [i for i, name in enumerate(self.names) if name in hidden]
        super().__init__(shapes, sensor, ignore=ignore, **options)

    def scan(self, depsgraph: Any, pose: gno.Pose, sensor: int = 0, *, into: Optional[gno.Scan] = None) -> gno.Scan:
        """Scans the objects where they are in the frame of the dependency graph. Where an object appears, goes or
        changes its shape, another Lidar is needed."""
        maps = [
            np.array(shown.matrix_world)[:3]
            for shown in depsgraph.object_instances
            if shown.object.type in SURFACES and shown.show_self
            and (shown.object.name_full, shown.object.data.name_full) in self._known
        ]  # fmt: skip
        if len(maps) != len(self.names):
            raise ValueError(f"there were {len(self.names)} instances, now there are {len(maps)}; make another Lidar")
        return self._scan_at(np.array(maps), pose, sensor, into)

# SPDX-License-Identifier: Apache-2.0
"""LiDARs in Panda3D: the GeomNodes below a node, as they are when the Lidar is made."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, Optional

import numpy as np
from panda3d import core

from .. import _gnosphere as gno
from .. import adapter, primitives


def _triangles(geom: Any) -> primitives.Triangles:
    """The triangles of a Geom; lines and points have none."""
    geom = geom.decompose()
    data = geom.getVertexData()
    array, column = (
        find(core.InternalName.getVertex()) for find in (data.getFormat().getArrayWith, data.getFormat().getColumn)
    )
    kind = np.float64 if column.getNumericType() == core.GeomEnums.NTFloat64 else np.float32
    rows = np.frombuffer(memoryview(data.getArray(array)).cast("B"), np.uint8).reshape(data.getNumRows(), -1)
    corners = rows[:, column.getStart() :][:, : 3 * np.dtype(kind).itemsize].copy().view(kind)
    faces = [np.zeros((0, 3), np.uint32)]
    for i in range(geom.getNumPrimitives()):
        part = geom.getPrimitive(i)
        if not isinstance(part, core.GeomTriangles):
            continue
        if part.isIndexed():
            bits = f"u{part.getVertices().getArrayFormat().getStride()}"
            numbers = np.frombuffer(memoryview(part.getVertices()).cast("B"), bits)
        else:
            numbers = part.getFirstVertex() + np.arange(part.getNumVertices())
        faces.append(numbers.astype(np.uint32).reshape(-1, 3))
    return corners.astype(np.float32), np.concatenate(faces)


def _shown(path: Any) -> bool:
    """Whether cameras see the node of a NodePath. The nearest node, itself or above it, that states whether it is shown
    decides, and every node above it that shows only one child must show the one on the way to it. A LODNode shows its
    finest level."""
    way = list(path.getAncestors())  # the node itself is the first
    all_cameras = core.PandaNode.getOverallBit()
    for node in (above.node() for above in way):
        if node.getDrawControlMask().hasBitsInCommon(all_cameras):
            if not node.getDrawShowMask().hasBitsInCommon(all_cameras):
                return False
            break
    for child, parent in zip(way, way[1:]):
        node = parent.node()
        if isinstance(node, core.LODNode):
            shown = node.getHighestSwitch()
        elif isinstance(node, core.SwitchNode):
            shown = node.getVisibleChild()
        elif isinstance(node, core.SequenceNode):
            shown = node.getFrame()
        else:
            continue
        if node.findChild(child.node()) != shown:
            return False
    return True


class Lidar(adapter.Lidar):
    def __init__(
        self, root: Any, sensor: Any, *, ignore_below: Iterable[Any] = (),
        classes: Optional[Mapping[str, int]] = None, **options: Any,
    ) -> None:  # fmt: skip
        """`root` is the NodePath whose frame is the world. `ignore_below` are NodePaths that the sensor does not see
        with all below them; `classes` are numbers by patterns of node names. The rest: see adapter.Lidar."""
        shapes, self.root = adapter.Shapes(), root
        self.nodes: list[Any] = []  # the NodePath of each instance
        for path in filter(_shown, root.findAllMatches("**/+GeomNode")):
            state = path.getNetState()
            for i in range(path.node().getNumGeoms()):
                triangles = _triangles(path.node().getGeom(i))
                if not len(triangles[1]):
                    continue
                own = state.compose(path.node().getGeomState(i))
                material, color = own.getAttrib(core.MaterialAttrib), own.getAttrib(core.ColorAttrib)
                rgba = (
                    material.getMaterial().getDiffuse() if material and material.getMaterial() else (0.5, 0.5, 0.5, 1)
                )
                if color and color.getColorType() == core.ColorAttrib.TFlat:
                    rgba = color.getColor()
                mesh = shapes.mesh(triangles, shapes.material([*rgba]))
                names = [ancestor.getName() for ancestor in path.getAncestors()]
                shapes.instance(mesh, class_id=adapter.class_of(classes, *names), name=path.getName())
                self.nodes.append(path)
        hidden = list(ignore_below)
        ignore = [
            i for i, path in enumerate(self.nodes) if any(top.isAncestorOf(path) or top == path for top in hidden)
        ]
        super().__init__(shapes, sensor, ignore=ignore, **options)

    def scan(self, pose: gno.Pose, sensor: int = 0, *, into: Optional[gno.Scan] = None) -> gno.Scan:
        """Scans the nodes where they are now."""
        maps = [[[*row] for row in path.getMat(self.root).rows] for path in self.nodes]
        turned = np.array(maps).reshape(-1, 4, 4).transpose(0, 2, 1)  # Panda3D multiplies rows by matrices
        return self._scan_at(turned[:, :3], pose, sensor, into)

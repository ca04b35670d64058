# SPDX-License-Identifier: Apache-2.0
"""LiDARs in PyBullet: the visual shapes of all bodies that there are when the Lidar is made."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, Optional

import numpy as np
import pybullet as pb

from .. import _gnosphere as gno
from .. import adapter, primitives
from ..robotics.resources import UNREADABLE, read_pieces, reason

MULTIBODY = 2
"""The type of a body in its dynamics information. For others the inertial frame there is not filled in."""
PLANE = 1000.0
"""Metres: half the size of a plane."""


class Lidar(adapter.Lidar):
    def __init__(
        self, sensor: Any, *, client: int = 0, ignore_bodies: Iterable[int] = (), tolerance: float = 1e-3,
        classes: Optional[Mapping[str, int]] = None, folders: Iterable[str] = (), **options: Any,
    ) -> None:  # fmt: skip
        """`ignore_bodies` are bodies that the sensor does not see; `classes` are numbers by patterns of body and link
        names; `folders` are where mesh files are that PyBullet names without a folder. The rest: see adapter.Lidar."""
        shapes, self.client, self._folders = adapter.Shapes(), client, ["", *folders]
        self._places: list[tuple[int, int]] = []  # body and link of each instance
        self._ignored, self._left_out = set(ignore_bodies), Counter[str]()
        for number in range(pb.getNumBodies(client)):
            body = pb.getBodyUniqueId(number, client)
            name = pb.getBodyInfo(body, client)[1].decode()
            if pb.getDynamicsInfo(body, -1, client)[10] != MULTIBODY:
                self._leave_out("bodies with maximal coordinates or soft, whose frames PyBullet does not tell", body)
                continue
            normals: dict[int, list[Any]] = {}  # of the planes of each link
            for _, link, kind, size, file, position, turn, color, *_ in pb.getVisualShapeData(
                body, physicsClientId=client
            ):
                try:
                    triangles = self._triangles(kind, size, file.decode(), tolerance)
                except UNREADABLE as error:
                    self._leave_out(reason(error), body)
                    continue
                local = adapter.rows_of(gno.Pose(position, turn))
                if kind == pb.GEOM_PLANE:
                    local = local @ self._upright(normals.setdefault(link, self._normals(body, link)), body)
                mesh = shapes.mesh(primitives.moved(triangles, local), shapes.material(color))
                of_link = pb.getJointInfo(body, link, client)[12].decode() if link >= 0 else ""
                shapes.instance(mesh, class_id=adapter.class_of(classes, of_link, name), name=of_link or name)
                self._places.append((body, link))
        adapter.warn_left_out("gnosphere.engines.pybullet", self._left_out)
        ignore = [i for i, (body, _) in enumerate(self._places) if body in self._ignored]
        super().__init__(shapes, sensor, ignore=ignore, **options)

    def _normals(self, body: int, link: int) -> list[Any]:
        shapes = pb.getCollisionShapeData(body, link, self.client)
        return [size for _, _, kind, size, *_ in shapes if kind == pb.GEOM_PLANE]

    def _upright(self, normals: list[Any], body: int) -> Any:
        """The map that turns the next plane of a link to its normal, which PyBullet tells of planes that collide."""
        if normals:
            return adapter.upright(normals.pop(0))
        self._leave_out("normals of planes that are only seen, which PyBullet does not tell; they are z", body)
        return np.eye(4)

    def _leave_out(self, what: str, body: int) -> None:
        """Notes what is missing, if the sensor would see it."""
        if body not in self._ignored:
            self._left_out[what] += 1

    def _triangles(self, kind: int, size: Any, file: str, tolerance: float) -> primitives.Triangles:
        if kind == pb.GEOM_SPHERE:
            return primitives.sphere(size[0], tolerance)
        if kind == pb.GEOM_BOX:
            return primitives.box(np.asarray(size) / 2)
        if kind == pb.GEOM_CYLINDER:
            return primitives.cylinder(size[1], size[0] / 2, tolerance)
        if kind == pb.GEOM_CAPSULE:
            return primitives.capsule(size[1], size[0] / 2, tolerance)
        if kind == pb.GEOM_PLANE:
            return primitives.plane(PLANE, PLANE, 1.0)
        if kind != pb.GEOM_MESH or not file:
            raise ValueError(f"shapes of the type {kind}, whose triangles PyBullet does not tell")
        found = [path for path in (Path(folder) / file for folder in self._folders) if path.is_file()]
        if not found:
            raise ValueError(f"the mesh {file}, which is not found")
        triangles = adapter.joined((piece.triangles for piece in read_pieces(found[0])), file)
        return primitives.moved(triangles, np.column_stack([np.diag(size), np.zeros(3)]))

    def scan(self, pose: gno.Pose, sensor: int = 0, *, into: Optional[gno.Scan] = None) -> gno.Scan:
        """Scans the bodies where they are now; for a sensor on a link make `pose` of its state."""
        rows = np.empty((len(self._places), 7))
        frames: dict[tuple[int, int], Any] = {}
        for row, place in zip(rows, self._places):
            if place not in frames:
                frames[place] = self._frame(*place)
            row[:] = frames[place]
        return self._scan_at(rows, pose, sensor, into)

    def _frame(self, body: int, link: int) -> Any:
        if link >= 0:
            state = pb.getLinkState(body, link, computeForwardKinematics=True, physicsClientId=self.client)
            return [*state[4], *state[5]]
        inertia = pb.getDynamicsInfo(body, -1, self.client)[3:5]
        undone = pb.invertTransform(*inertia)
        position, turn = pb.multiplyTransforms(*pb.getBasePositionAndOrientation(body, self.client), *undone)
        return [*position, *turn]

    def body_ids(self, scan: gno.Scan) -> Any:
        """The body of each entry of a scan; -1 without a return."""
        table = np.array([body for body, _ in self._places] + [-1])
        return table[np.minimum(scan.instances, len(self._places))]

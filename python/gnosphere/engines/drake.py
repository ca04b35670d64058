# SPDX-License-Identifier: Apache-2.0
"""LiDARs in Drake: a LeafSystem that scans what a SceneGraph has in a role.

Input port "geometry_query": of the SceneGraph. Output port "point_cloud": a PointCloud in the frame of the sensor.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from typing import Any, Optional

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.geometry import (
    Box, Capsule, Convex, Cylinder, Ellipsoid, HalfSpace, Mesh, QueryObject, Role, Sphere,
)  # fmt: skip
from pydrake.math import RigidTransform
from pydrake.perception import PointCloud
from pydrake.systems.framework import LeafSystem

from .. import _gnosphere as gno
from .. import adapter, primitives

PLANE = 1000.0
"""Metres: half the size of a half space."""


def _triangles(shape: Any, tolerance: float) -> Optional[primitives.Triangles]:
    if isinstance(shape, Box):
        return primitives.box(np.asarray(shape.size()) / 2)
    if isinstance(shape, Sphere):
        return primitives.sphere(shape.radius(), tolerance)
    if isinstance(shape, Ellipsoid):
        return primitives.ellipsoid((shape.a(), shape.b(), shape.c()), tolerance)
    if isinstance(shape, Cylinder):
        return primitives.cylinder(shape.radius(), shape.length() / 2, tolerance)
    if isinstance(shape, Capsule):
        return primitives.capsule(shape.radius(), shape.length() / 2, tolerance)
    if isinstance(shape, HalfSpace):
        return primitives.plane(PLANE, PLANE, 1.0)
    if isinstance(shape, Convex):
        return _fans(shape.GetConvexHull())
    if isinstance(shape, Mesh) and shape.source().is_path():
        return adapter.load_mesh(str(shape.source().path()), shape.scale3().tolist())
    return None


def _fans(hull: Any) -> primitives.Triangles:
    """The triangles of a PolygonSurfaceMesh of convex polygons."""
    vertices = np.array([hull.vertex(i) for i in range(hull.num_vertices())], np.float32)
    faces = []
    for polygon in map(hull.element, range(hull.num_elements())):
        corners = [polygon.vertex(k) for k in range(polygon.num_vertices())]
        faces += [(corners[0], *pair) for pair in zip(corners[1:], corners[2:])]
    return vertices, np.array(faces, np.uint32)


class Lidar(LeafSystem):
    def __init__(
        self, inspector: Any, sensor: Any, *, parent: Any = None, pose: Optional[RigidTransform] = None,
        role: Role = Role.kPerception, tolerance: float = 1e-3, classes: Optional[Mapping[str, int]] = None,
        ignore_frames: Any = (), **options: Any,
    ) -> None:  # fmt: skip
        """The sensor is at `pose` in the frame `parent` (a FrameId; None for the world). It sees the geometries that
        `inspector` has in `role`, but not those of `ignore_frames`; `classes` are numbers by patterns of geometry
        names. The rest: see adapter.Lidar."""
        super().__init__()
        shapes, ignored = adapter.Shapes(), set(ignore_frames)
        ignore: list[int] = []
        self.geometries: list[Any] = []  # the GeometryId of each instance
        for geometry in inspector.GetAllGeometryIds(role):
            triangles = _triangles(inspector.GetShape(geometry), tolerance)
            name = inspector.GetName(geometry)
            if triangles is None:
                warnings.warn(f"gnosphere.engines.drake leaves out the geometry {name}", stacklevel=2)
                continue
            properties = inspector.GetProperties(geometry, role)
            color = properties.GetPropertyOrDefault("phong", "diffuse", None) if properties else None
            rgba = (color.r(), color.g(), color.b(), color.a()) if color else (0.5, 0.5, 0.5, 1)
            mesh = shapes.mesh(triangles, shapes.material(rgba))
            index = shapes.instance(mesh, class_id=adapter.class_of(classes, name), name=name)
            self.geometries.append(geometry)
            if inspector.GetFrameId(geometry) in ignored:
                ignore.append(index)
        self.lidar = adapter.Lidar(shapes, sensor, ignore=ignore, **options)
        self._parent, self._pose = parent, pose or RigidTransform()
        self.DeclareAbstractInputPort("geometry_query", AbstractValue.Make(QueryObject()))
        self.DeclareAbstractOutputPort("point_cloud", lambda: AbstractValue.Make(PointCloud(0)), self._points)

    def scan(self, query: Any, *, into: Optional[gno.Scan] = None) -> gno.Scan:
        """Scans what a QueryObject sees."""
        if self.geometries:
            self.lidar.move(np.stack([query.GetPoseInWorld(geometry).GetAsMatrix34() for geometry in self.geometries]))
        frame = query.GetPoseInWorld(self._parent) if self._parent is not None else RigidTransform()
        place = frame @ self._pose
        pose = adapter.pose_of(place.translation(), place.rotation().matrix())
        return self.lidar.cast(gno.Shot(pose, 0, self.lidar.frames[0]), into)

    def _points(self, context: Any, output: Any) -> None:
        scan = self.scan(self.get_input_port(0).Eval(context))
        points = scan.points[~np.isnan(scan.ranges)]
        cloud = PointCloud(len(points))
        cloud.mutable_xyzs()[:] = points.T
        output.set_value(cloud)

# SPDX-License-Identifier: Apache-2.0
"""USD stages, through usd-core: meshes, shapes, instances, point instancers, materials, classes, OmniLidar prims."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Optional

import numpy as np
from pxr import Tf, Usd, UsdGeom

from .. import primitives
from ..adapter import Array
from . import usd_lidars
from .resources import Resources
from .robot_scene import Kinematics, Matrix, Parts
from .usd_looks import Looks, classes_of

SHAPES = ("Cube", "Sphere", "Cylinder", "Cylinder_1", "Capsule", "Capsule_1", "Cone", "Plane")
FLAT = ("Mesh", "Cube", "Plane")
"""The types whose triangles are exact at any scale."""
NO_SURFACE = (
    "BasisCurves", "HermiteCurves", "NurbsCurves", "NurbsPatch", "Points", "TetMesh", "Volume",
    "ParticleField", "ParticleField3DGaussianSplat",
)  # fmt: skip
OTHER_SENSORS = ("Lidar", "OmniRadar")


def read(path: Path, parts: Parts, resources: Resources, collisions: bool) -> Kinematics:
    with path.open("rb"):
        pass  # USD would not say whether there is such a file
    try:
        stage = Usd.Stage.Open(str(path))
    except Tf.ErrorException as error:
        raise ValueError(f"cannot be opened as USD: {_first_line(error)}") from error
    Reader(stage, parts, resources, collisions).walk()
    return lambda joints: {frame: np.eye(4) for frame in {*parts.frames, *(s.frame for s in parts.sensors)}}, {}


class Reader:
    def __init__(self, stage: Any, parts: Parts, resources: Resources, collisions: bool) -> None:
        self.stage, self.parts, self.resources = stage, parts, resources
        self.time = Usd.TimeCode.EarliestTime()
        self._purposes = {"default", "guide"} if collisions else {"default", "render"}
        self._xforms = UsdGeom.XformCache(self.time)
        self._looks = Looks(parts, self.time)
        self._meshes: dict[Any, Optional[int]] = {}
        unit = UsdGeom.GetStageMetersPerUnit(stage)
        self._to_world = np.diag([unit, unit, unit, 1.0])
        if UsdGeom.GetStageUpAxis(stage) == UsdGeom.Tokens.y:
            self._to_world = np.array([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1.0]]) @ self._to_world

    def walk(self) -> None:
        for error in self.stage.GetCompositionErrors():
            self.parts.leave_out(f"what cannot be composed: {str(error).splitlines()[0]}")
        rules = Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate)
        walk = iter(Usd.PrimRange(self.stage.GetPseudoRoot(), rules))
        for prim in walk:
            if prim.IsA(UsdGeom.PointInstancer):
                self._scatter(UsdGeom.PointInstancer(prim))
                walk.PruneChildren()  # its prototypes are seen where they are scattered
            elif prim.IsA(UsdGeom.Imageable):
                self._prim(prim, self._place(prim), prim.GetPath().pathString)
            else:
                self._sensor(prim)

    def _place(self, prim: Any) -> Matrix:
        place: Matrix = self._to_world @ np.array(self._xforms.GetLocalToWorldTransform(prim)).T
        if prim.IsA(UsdGeom.Xformable):
            return place
        # The type is not known to this USD, as OmniLidar, so its own transform is not in there.
        order = prim.GetAttribute("xformOpOrder")
        for name in (order.Get() if order else None) or ():
            if name == UsdGeom.XformOpTypes.resetXformStack:
                place = self._to_world
                continue
            if not prim.GetAttribute(name.removeprefix("!invert!")):
                continue  # as USD itself does
            operation = UsdGeom.XformOp(prim.GetAttribute(name.removeprefix("!invert!")), name.startswith("!invert!"))
            place = place @ np.array(operation.GetOpTransform(self.time)).T
        return place

    def _seen(self, prim: Any) -> bool:
        imageable = UsdGeom.Imageable(prim)
        if imageable.ComputeVisibility(self.time) == UsdGeom.Tokens.invisible:
            return False
        return imageable.ComputePurpose() in self._purposes

    def _prim(self, prim: Any, place: Matrix, path: str) -> None:
        self._sensor(prim)
        kind = prim.GetTypeName()
        if kind != "Mesh" and kind not in SHAPES + NO_SURFACE or not self._seen(prim):
            return
        if kind in NO_SURFACE:
            return self.parts.leave_out(f"prims of the type {kind}")
        source = prim.GetPrimInPrototype() if prim.IsInstanceProxy() else prim
        material = self._looks.of(prim)
        subsets = self._looks.of_subsets(prim) if kind == "Mesh" else ()
        scale = 1.0 if kind in FLAT else _scale(place)
        key = (source.GetPath(), material, scale, tuple(number for _, number in subsets))
        if key not in self._meshes:
            self._meshes[key] = (
                self._mesh(prim, material, subsets) if kind == "Mesh" else self._shape(prim, material, scale)
            )
        mesh = self._meshes[key]
        if mesh is None:
            return
        local = place @ _axis(prim) if kind in SHAPES else place
        if kind == "Cube":
            half = _value(UsdGeom.Cube(prim).GetSizeAttr(), self.time, 2.0) / 2
            local = local @ np.diag([half, half, half, 1.0])
        names = [*path.strip("/").split("/")][::-1]
        self.parts.place(
            mesh, path, local, path, *names, *classes_of(prim), class_name=next(iter(classes_of(prim)), "")
        )

    def _mesh(self, prim: Any, material: int, subsets: Any) -> Optional[int]:
        mesh = UsdGeom.Mesh(prim)
        points = np.array(mesh.GetPointsAttr().Get(self.time) or (), np.float32).reshape(-1, 3)
        counts = np.array(mesh.GetFaceVertexCountsAttr().Get(self.time) or (), np.int64)
        corners = np.array(mesh.GetFaceVertexIndicesAttr().Get(self.time) or (), np.int64)
        if not len(counts) or not len(points):
            self.parts.leave_out("meshes without faces")
            return None
        if counts.min() < 0 or counts.sum() != len(corners) or corners.min() < 0 or corners.max() >= len(points):
            self.parts.leave_out("meshes whose indices do not fit their points")
            return None
        numbers = np.full(len(counts), material)
        for faces, number in subsets:
            numbers[faces[(faces >= 0) & (faces < len(counts))]] = number
        holes = np.array(mesh.GetHoleIndicesAttr().Get(self.time) or (), np.int64)
        kept = np.ones(len(counts), bool)
        kept[holes[(holes >= 0) & (holes < len(counts))]] = False
        if prim.HasAPI("SkelBindingAPI"):
            self.parts.leave_out("the skinning of meshes, which are as they were bound")
        scheme = mesh.GetSubdivisionSchemeAttr()
        if scheme.Get() != UsdGeom.Tokens.none:  # where it is not stated, it is catmullClark
            self.parts.leave_out("the subdivision of meshes, which are as their points say")
        triangles, of_face = _fans(points, counts, corners, kept)
        if _value(mesh.GetOrientationAttr(), self.time, "rightHanded") == UsdGeom.Tokens.leftHanded:
            triangles = triangles[:, ::-1]
        return self.parts.shapes.mesh((points, triangles), numbers[of_face], prim.GetName())

    def _shape(self, prim: Any, material: int, scale: float) -> Optional[int]:
        def get(name: str, default: float) -> float:
            attribute = prim.GetAttribute(name)
            return float(_value(attribute, self.time, default)) if attribute else default

        kind, unit = prim.GetTypeName(), UsdGeom.GetStageMetersPerUnit(self.stage)
        half, radius = get("height", 2.0) / 2, get("radius", 1.0)
        if kind == "Cube":  # of the unit size: its own is in the map
            return self.resources.primitive("box", [(1, 1, 1)], material)
        if kind == "Plane":
            sides = [get("width", 2.0) / 2, get("length", 2.0) / 2]  # along x and y
            if _axis_name(prim) != "Z":  # _axis() turns x to what the length is along
                sides.reverse()
            return self.resources.primitive("plane", [*sides, 1.0 / unit], material)
        if kind.startswith("Capsule"):
            half, radius = get("height", 1.0) / 2, get("radius", 0.5)
        if kind.endswith("_1"):
            ends = [get("radiusTop", radius), get("radiusBottom", radius)]
            radius = max(ends)
            if min(ends) < radius:
                self.parts.leave_out("the smaller radius of cylinders and capsules, which have the larger at both ends")
        name = {"Sphere": "sphere", "Cylinder": "cylinder", "Capsule": "capsule", "Cone": "cone"}[kind.split("_")[0]]
        sizes = [radius] if name == "sphere" else [radius, half]
        return self.resources.primitive(name, sizes, material, scale)

    def _scatter(self, instancer: Any) -> None:
        if not self._seen(instancer.GetPrim()):
            return
        transforms = instancer.ComputeInstanceTransformsAtTime(
            self.time, self.time, UsdGeom.PointInstancer.IncludeProtoXform, UsdGeom.PointInstancer.ApplyMask
        )
        indices = np.array(instancer.GetProtoIndicesAttr().Get(self.time) or (), np.int64)
        mask = np.array(instancer.ComputeMaskAtTime(self.time) or np.ones(len(indices), bool), bool)
        ids = instancer.GetIdsAttr().Get(self.time) or ()
        numbers = np.array(ids if len(ids) == len(indices) else range(len(indices)), np.int64)
        targets = instancer.GetPrototypesRel().GetTargets()
        if len(transforms) != np.count_nonzero(mask):
            return self.parts.leave_out("point instancers whose prototypes, indices and places do not fit")
        place, path = self._place(instancer.GetPrim()), instancer.GetPath().pathString
        for number, index, transform in zip(numbers[mask], indices[mask], transforms):
            root = self.stage.GetPrimAtPath(targets[index])
            if not root:
                self.parts.leave_out(f"the prototype {targets[index]}, which is not there")
                continue
            at = place @ np.array(transform).T @ np.linalg.inv(np.array(self._xforms.GetLocalToWorldTransform(root)).T)
            for prim in Usd.PrimRange(root, Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate)):
                if prim.IsA(UsdGeom.PointInstancer):
                    self.parts.leave_out("point instancers inside others")
                elif prim.IsA(UsdGeom.Imageable):
                    below = np.array(self._xforms.GetLocalToWorldTransform(prim)).T
                    self._prim(prim, at @ below, f"{path}[{number}]{prim.GetPath().pathString}")

    def _sensor(self, prim: Any) -> None:
        kind = prim.GetTypeName()
        if usd_lidars.is_lidar(prim):
            usd_lidars.mount(prim, self.parts, self.resources, self._place(prim), self.time)
        elif kind in OTHER_SENSORS:
            self.parts.leave_out(f"sensors of the type {kind}")


def _first_line(error: Any) -> str:
    """What USD says first about an error, without where in its sources it stands."""
    said = [str(getattr(each, "commentary", each)) for each in error.args]
    return next((line for text in said for line in text.splitlines() if line), "no error is told")


def _value(attribute: Any, time: Any, default: Any) -> Any:
    value = attribute.Get(time) if attribute else None
    return default if value is None else value


def _scale(place: Matrix) -> float:
    """How many times as long a map makes lengths, as a power of two that is not less: instances whose sizes differ
    little share a mesh, and so do those that are only turned, up to rounding."""
    scale = float(np.linalg.norm(place[:3, :3], axis=0).max())
    return 2.0 ** math.ceil(math.log2(scale) - 1e-6) if scale > 0 else 1.0


def _axis_name(prim: Any) -> str:
    attribute = prim.GetAttribute("axis")
    return str((attribute.Get() if attribute else None) or "Z")


def _axis(prim: Any) -> Matrix:
    """The map from a shape along z to one along the axis that the prim states: a turn of the three axes."""
    order = {"X": [2, 0, 1], "Y": [1, 2, 0], "Z": [0, 1, 2]}[_axis_name(prim)]
    result = np.eye(4)
    result[:3, :3] = np.eye(3)[order]
    return result


def _fans(points: Array, counts: Array, corners: Array, kept: Array) -> tuple[Array, Array]:
    """Triangles of polygons, and the polygon of each. Convex ones are fans; others are cut by their ears."""
    first = np.concatenate([[0], np.cumsum(counts)[:-1]])
    sizes = np.where(kept, np.maximum(counts - 2, 0), 0)
    of_face = np.repeat(np.arange(len(counts)), sizes)
    step = np.arange(len(of_face)) - np.repeat(np.cumsum(sizes) - sizes, sizes)
    start = first[of_face]
    triangles = np.stack([corners[start], corners[start + step + 1], corners[start + step + 2]], axis=1)
    for face in _not_convex(points, triangles, of_face):
        own = corners[first[face] : first[face] + counts[face]]
        triangles[of_face == face] = own[primitives.ears(points[own])]
    return triangles.astype(np.uint32), of_face


def _not_convex(points: Array, triangles: Array, of_face: Array) -> Iterator[int]:
    """Polygons whose fan has triangles that look apart."""
    a, b, c = (points[triangles[:, corner]].astype(np.float64) for corner in range(3))
    normals = np.cross(b - a, c - a)
    total = np.zeros((int(of_face.max(initial=0)) + 1, 3))
    np.add.at(total, of_face, normals)
    against = np.einsum("ij,ij->i", normals, total[of_face]) < 0
    yield from np.unique(of_face[against]).tolist()

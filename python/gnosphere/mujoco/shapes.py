# SPDX-License-Identifier: Apache-2.0
"""The geoms, flexes and skins of a MuJoCo model as shapes of an adapter."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Optional, Union

import mujoco as mj
import numpy as np
import numpy.typing as npt

from .. import _gnosphere as gno
from .. import adapter, primitives

Body = Union[int, str]
Bodies = Union[Body, Iterable[Body]]

VISIBLE_GROUPS = (1, 1, 1, 0, 0, 0)
"""The groups that MuJoCo's viewer shows at first."""
DEFAULT_COLOR = np.array([0.5, 0.5, 0.5, 1], np.float32)


@dataclass(frozen=True)
class Tessellation:
    """How shapes become triangles. Raises ValueError unless the tolerance is finite and above 0."""

    tolerance: float = 1e-3
    """Metres: how deep the triangles of a sphere, capsule, ellipsoid or cylinder may lie inside it."""
    plane: float = 1000.0
    """Metres: half the size of a plane that has no end. It follows the sensor, so a farthest range below it is
    enough."""

    def __post_init__(self) -> None:
        primitives.check_tolerance(self.tolerance)


class ModelShapes:
    """The geoms, flexes and skins of a model as shapes; the instances of geoms come first.

    Several of them may share `shapes`, each in a world of its own, and meshes with `beside`."""

    def __init__(
        self,
        model: Any,
        geomgroup: Optional[Sequence[int]],
        static: bool,
        classes: Optional[Mapping[str, int]],
        tessellation: Tessellation,
        deformables: bool,
        world: int = 0,
        beside: Optional[ModelShapes] = None,
    ) -> None:
        self.model, self.classes, self.tessellation, self.world = model, classes, tessellation, world
        self._groups = geomgroup
        self.shapes: adapter.Shapes = beside.shapes if beside else adapter.Shapes()
        self.first = len(self.shapes.instances)
        self._meshes: dict[Any, int] = beside._meshes if beside else {}
        self._images: dict[Any, Optional[gno.AlphaImage]] = beside._images if beside else {}
        self.left_out: dict[str, int] = {}
        if geomgroup is not None and len(geomgroup) != 6:
            raise ValueError(f"geomgroup has {len(geomgroup)} flags; there are six groups")
        geoms = [geom for geom in range(model.ngeom) if self._seen(geom, static)]
        self.geoms = np.array([geom for geom in geoms if self._add_geom(geom)], np.int32)
        planes = model.geom_type[self.geoms] == int(mj.mjtGeom.mjGEOM_PLANE)
        endless = planes[:, None] & (model.geom_size[self.geoms, :2] <= 0)
        self.endless = [(int(i), endless[i]) for i in np.flatnonzero(endless.any(axis=1))]  # instance; along x and y
        self.flexes: list[tuple[int, int]] = []  # mesh and flex
        self.skins: list[tuple[int, Skin]] = []
        if deformables and model.nflex + model.nskin > 0:
            self._rest = mj.MjData(model)
            mj.mj_forward(model, self._rest)
            for flex in range(model.nflex):
                if self._is_chosen(model.flex_group[flex]):
                    self._add_flex(flex)
            for skin in range(model.nskin):
                if self._is_chosen(model.skin_group[skin]):
                    self._add_skin(skin)

    def _leave_out(self, what: str) -> None:
        self.left_out[what] = self.left_out.get(what, 0) + 1

    def _is_chosen(self, group: int) -> bool:
        """Whether the flag of a group is set, or that of the nearest one of the six groups, as for mj_ray()."""
        return self._groups is None or bool(self._groups[min(max(group, 0), 5)])

    def _seen(self, geom: int, static: bool) -> bool:
        """As mj_ray() chooses."""
        model = self.model
        if not self._is_chosen(model.geom_group[geom]):
            return False
        if not static and model.body_weldid[model.geom_bodyid[geom]] == 0:
            return False
        material = model.geom_matid[geom]
        return bool((model.geom_rgba[geom] if material < 0 else model.mat_rgba[material])[3] > 0)

    def _name(self, kind: Any, number: int) -> str:
        return mj.mj_id2name(self.model, kind, number) or ""

    def _material(self, material: int, rgba: Any, double_sided: bool = True, image: Any = None) -> int:
        model = self.model
        own = material < 0 or not np.array_equal(rgba, DEFAULT_COLOR)
        color = rgba if own else model.mat_rgba[material]
        name = self._name(mj.mjtObj.mjOBJ_MATERIAL, material) if material >= 0 else ""
        return self.shapes.material(color.tolist(), name, double_sided=double_sided, image=image)

    def _add_geom(self, geom: int) -> bool:
        model = self.model
        kind, body = mj.mjtGeom(int(model.geom_type[geom])), model.geom_bodyid[geom]
        data, size = int(model.geom_dataid[geom]), tuple(map(float, model.geom_size[geom]))
        image, repeat = self._alpha(int(model.geom_matid[geom]))
        if image and (kind != mj.mjtGeom.mjGEOM_MESH or model.mesh_texcoordadr[data] < 0):
            self._leave_out("the alpha of textures on geoms without texture coordinates")
            image = None
        material = self._material(
            int(model.geom_matid[geom]), model.geom_rgba[geom], kind != mj.mjtGeom.mjGEOM_PLANE, image
        )
        key = (int(kind), (id(model), data) if data >= 0 else size, material)
        if key not in self._meshes:
            triangles, uvs = self._triangles(kind, data, size, repeat if image else None)
            if not len(triangles[1]):
                self._leave_out(f"geoms of the type {kind.name}")
                return False
            self._meshes[key] = self.shapes.mesh(triangles, material, uvs=uvs)
        name, body_name = self._name(mj.mjtObj.mjOBJ_GEOM, geom), self._name(mj.mjtObj.mjOBJ_BODY, body)
        mesh_name = self._name(mj.mjtObj.mjOBJ_MESH, data) if kind == mj.mjtGeom.mjGEOM_MESH else ""
        number = adapter.class_of(self.classes, name, mesh_name, body_name)
        self.shapes.instance(self._meshes[key], class_id=number, name=name or body_name, world=self.world)
        return True

    def _triangles(
        self, kind: mj.mjtGeom, data: int, size: tuple[float, ...], repeat: Any
    ) -> tuple[primitives.Triangles, Any]:
        model, types, tolerance = self.model, mj.mjtGeom, self.tessellation.tolerance
        far = self.tessellation.plane
        if kind == types.mjGEOM_PLANE:
            return primitives.plane(size[0] or far, size[1] or far, 1.0), None
        if kind == types.mjGEOM_SPHERE:
            return primitives.sphere(size[0], tolerance), None
        if kind == types.mjGEOM_CAPSULE:
            return primitives.capsule(size[0], size[1], tolerance), None
        if kind == types.mjGEOM_ELLIPSOID:
            return primitives.ellipsoid(size, tolerance), None
        if kind == types.mjGEOM_CYLINDER:
            return primitives.cylinder(size[0], size[1], tolerance), None
        if kind == types.mjGEOM_BOX:
            return primitives.box(size), None
        if kind == types.mjGEOM_HFIELD:
            rows, columns, first = model.hfield_nrow[data], model.hfield_ncol[data], model.hfield_adr[data]
            x, y, top, base = model.hfield_size[data]
            heights = top * np.asarray(model.hfield_data[first : first + rows * columns], np.float64)
            return primitives.height_field(heights.reshape(rows, columns), x, y, base), None
        if kind in (types.mjGEOM_MESH, types.mjGEOM_SDF) and data >= 0:
            return self._mesh(data, repeat)
        return (np.zeros((0, 3), np.float32), np.zeros((0, 3), np.uint32)), None

    def _mesh(self, mesh: int, repeat: Any) -> tuple[primitives.Triangles, Any]:
        model = self.model
        first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
        faces = slice(model.mesh_faceadr[mesh], model.mesh_faceadr[mesh] + model.mesh_facenum[mesh])
        vertices = model.mesh_vert[first : first + count]
        indices = model.mesh_face[faces].astype(np.uint32)
        if repeat is None:
            return (vertices, indices), None
        # A corner has a place in the texture of its own, so each becomes a vertex.
        uvs = model.mesh_texcoord[model.mesh_texcoordadr[mesh] + model.mesh_facetexcoord[faces].reshape(-1)] * repeat
        corners = vertices[indices.reshape(-1)]
        return (corners, np.arange(len(corners), dtype=np.uint32).reshape(-1, 3)), uvs

    def _alpha(self, material: int) -> tuple[Optional[gno.AlphaImage], Any]:
        """The alpha channel of the texture of a material, if some of it is not opaque; and how often it repeats."""
        model = self.model
        if material < 0:
            return None, None
        key = (id(model), material)
        if key not in self._images:
            image = None
            for role in (mj.mjtTextureRole.mjTEXROLE_RGBA, mj.mjtTextureRole.mjTEXROLE_RGB):
                texture = model.mat_texid[material, role]
                if texture < 0 or model.tex_nchannel[texture] != 4 or model.tex_type[texture] != 0:
                    continue
                first, shape = model.tex_adr[texture], (model.tex_height[texture], model.tex_width[texture], 4)
                alpha = model.tex_data[first : first + np.prod(shape)].reshape(shape)[..., 3]
                if alpha.min() < 255:
                    image = gno.AlphaImage(np.ascontiguousarray(alpha))
            self._images[key] = image
        return self._images[key], model.mat_texrepeat[material]

    def _add_flex(self, flex: int) -> None:
        model = self.model
        dim = int(model.flex_dim[flex])
        if dim == 1:
            return self._leave_out("flexes of one dimension")
        if dim == 2:
            first, count = model.flex_elemdataadr[flex], model.flex_elemnum[flex]
            faces = model.flex_elem[first : first + 3 * count]
        else:
            first, count = model.flex_shelldataadr[flex], model.flex_shellnum[flex]
            faces = model.flex_shell[first : first + 3 * count]
        material = self._material(int(model.flex_matid[flex]), model.flex_rgba[flex])
        vertices = self._flex_positions(self._rest, flex)
        name = self._name(mj.mjtObj.mjOBJ_FLEX, flex)
        mesh = self.shapes.mesh((vertices, faces.reshape(-1, 3)), material, name)
        self.shapes.instance(mesh, class_id=adapter.class_of(self.classes, name), name=name, world=self.world)
        self.flexes.append((mesh, flex))

    def _add_skin(self, skin: int) -> None:
        model = self.model
        first, count = model.skin_faceadr[skin], model.skin_facenum[skin]
        material = self._material(int(model.skin_matid[skin]), model.skin_rgba[skin])
        moving = Skin(model, skin)
        vertices = moving.positions(self._rest)
        name = self._name(mj.mjtObj.mjOBJ_SKIN, skin)
        mesh = self.shapes.mesh((vertices, model.skin_face[first : first + count]), material, name)
        self.shapes.instance(mesh, class_id=adapter.class_of(self.classes, name), name=name, world=self.world)
        self.skins.append((mesh, moving))

    def _flex_positions(self, data: Any, flex: int) -> npt.NDArray[np.float64]:
        first = self.model.flex_vertadr[flex]
        return np.asarray(data.flexvert_xpos[first : first + self.model.flex_vertnum[flex]])

    def place(
        self, data: Any, position: npt.ArrayLike, rows: npt.NDArray[np.float64], simulator: gno.Simulator
    ) -> None:
        """Writes where the instances are in `data`, shape (n, 3, 4), and gives the simulator the vertices of those that
        deform. Planes without an end are put around the place on them that is nearest to `position`."""
        self.place_geoms(data, position, rows)
        for instance, (mesh, positions) in enumerate(self._deformed(data), len(self.geoms)):
            middle = positions.mean(axis=0)  # so that single precision is enough wherever in the world it is
            rows[instance, :, 3] = middle
            simulator.set_positions(mesh, positions - middle)

    def place_geoms(self, data: Any, position: npt.ArrayLike, rows: npt.NDArray[np.float64]) -> None:
        """As place(), of the geoms alone, whose instances come first."""
        geoms = self.geoms
        if len(data.geom_xpos) != self.model.ngeom:
            raise ValueError(f"the data are of a model of {len(data.geom_xpos)} geoms; this one has {self.model.ngeom}")
        if self.model.ngeom and not data.geom_xmat[0].any():
            raise ValueError("the data say nowhere where geoms are; call mj_forward() or mj_kinematics() first")
        rows[: len(geoms), :, :3] = data.geom_xmat[geoms].reshape(-1, 3, 3)
        rows[: len(geoms), :, 3] = data.geom_xpos[geoms]
        for instance, endless in self.endless:
            axes = rows[instance, :, :2][:, endless]
            rows[instance, :, 3] += axes @ (axes.T @ (np.asarray(position) - rows[instance, :, 3]))

    def _deformed(self, data: Any) -> Iterable[tuple[int, npt.NDArray[np.float64]]]:
        """The meshes of flexes and skins, in the order of their instances, with where their vertices are in the
        world."""
        for mesh, flex in self.flexes:
            yield mesh, self._flex_positions(data, flex)
        for mesh, skin in self.skins:
            yield mesh, skin.positions(data)

    def _body_ids(self, bodies: Bodies) -> list[int]:
        listed = [bodies] if isinstance(bodies, (str, int, np.integer)) else list(bodies)
        found = [self.model.body(body).id if isinstance(body, str) else int(body) for body in listed if body != -1]
        count = self.model.nbody
        for body in found:
            if not 0 <= body < count:
                raise ValueError(f"there is no body {body} to exclude; the model has {count} bodies, and -1 is none")
        return found

    def instances_of(self, bodies: Bodies, trees: Bodies) -> npt.NDArray[np.int64]:
        """The instances of the geoms of bodies, and of bodies with all that hang from them."""
        alone = self._body_ids(bodies)
        chosen = np.zeros(self.model.nbody, bool)
        chosen[self._body_ids(trees)] = True
        for body in range(1, self.model.nbody):  # parents come before their children
            chosen[body] |= chosen[self.model.body_parentid[body]] and self.model.body_parentid[body] != 0
        chosen[alone] = True
        found: npt.NDArray[np.int64] = self.first + np.flatnonzero(chosen[self.model.geom_bodyid[self.geoms]])
        return found


class Skin:
    """The vertices of a skin, each the mean of where its bones take it, as mjv_updateSkin() has them."""

    def __init__(self, model: Any, skin: int) -> None:
        first, count = model.skin_vertadr[skin], model.skin_vertnum[skin]
        self._vertices = model.skin_vert[first : first + count].astype(np.float64)
        self._inflate = float(model.skin_inflate[skin])
        self._faces = model.skin_face[model.skin_faceadr[skin] :][: model.skin_facenum[skin]]
        self._bones = []
        for bone in range(model.skin_boneadr[skin], model.skin_boneadr[skin] + model.skin_bonenum[skin]):
            run = slice(model.skin_bonevertadr[bone], model.skin_bonevertadr[bone] + model.skin_bonevertnum[bone])
            unbind = np.zeros(9)
            mj.mju_quat2Mat(unbind, model.skin_bonebindquat[bone].astype(np.float64))
            local = self._vertices[model.skin_bonevertid[run]] - model.skin_bonebindpos[bone]
            weights = model.skin_bonevertweight[run].astype(np.float64)[:, None]
            body = int(model.skin_bonebodyid[bone])
            self._bones.append((body, model.skin_bonevertid[run], local @ unbind.reshape(3, 3), weights))

    def positions(self, data: Any) -> npt.NDArray[np.float64]:
        result: npt.NDArray[np.float64] = np.zeros_like(self._vertices)
        for body, vertices, local, weights in self._bones:
            result[vertices] += weights * (local @ data.xmat[body].reshape(3, 3).T + data.xpos[body])
        if self._inflate:
            corners = result[self._faces]
            normals = np.zeros_like(result)
            flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
            for corner in range(3):
                np.add.at(normals, self._faces[:, corner], flat)
            result += self._inflate * normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
        return result

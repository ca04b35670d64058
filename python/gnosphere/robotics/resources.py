# SPDX-License-Identifier: Apache-2.0
"""Files that robots name: packages, models, meshes."""

from __future__ import annotations

import codecs
import os
import re
import xml.etree.ElementTree as ET
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Optional, Union
from urllib.parse import unquote

import numpy as np

from .. import _gnosphere as gno
from .. import adapter, primitives
from .robot_scene import Matrix, Parts

OURS = (".obj", ".stl", ".ply", ".gltf", ".glb")
UNREADABLE = (ImportError, OSError, ValueError, RuntimeError, LookupError, TypeError, AttributeError)
"""What libraries raise for a file that they cannot read."""
Folders = Union[str, "os.PathLike[str]", Iterable[Union[str, "os.PathLike[str]"]]]
"""A folder, or several."""
VARIABLES = ("ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH", "GZ_SIM_RESOURCE_PATH", "GAZEBO_MODEL_PATH")


@dataclass
class Piece:
    """Triangles of a file that have one material."""

    triangles: primitives.Triangles
    names: tuple[str, ...]
    """What a <submesh> may call it: first the name that Gazebo does, that of its node."""
    material: str
    color: Optional[tuple[float, ...]]


def folders_of(given: Folders) -> list[Path]:
    """The folders of an argument that is one or several."""
    return [Path(folder) for folder in ([given] if isinstance(given, (str, os.PathLike)) else given)]


class Resources:
    """Finds files and makes meshes of them, each once."""

    def __init__(self, file: Path, search: Folders, parts: Parts, tolerance: float) -> None:
        self.file, self.parts, self.tolerance = file, parts, tolerance
        self.folders = folders_of(search)
        for variable in VARIABLES:
            for folder in os.environ.get(variable, "").split(os.pathsep):
                if folder:
                    self.folders += [Path(folder)] + ([Path(folder) / "share"] if "AMENT" in variable else [])
        self._pieces: dict[Path, list[Piece]] = {}
        self._meshes: dict[Any, int] = {}

    def find(self, uri: str, beside: Optional[Path] = None) -> Optional[Path]:
        """The file or folder of package://, model://, file:// or a path, or None."""
        scheme, _, rest = uri.rpartition("://")
        place = Path(unquote(rest) if scheme else uri)
        if scheme in ("package", "model"):
            place = Path(*place.parts[place.is_absolute() :])  # package:///NAME is written, too
        folder = (beside or self.file).absolute().parent
        if scheme in ("package", "model"):
            # A search folder may hold the package, or be the package itself.
            candidates = [path for root in self.folders for path in self._within(root, place)]
            candidates += [path for root in folder.parents for path in self._within(root, place)]
            candidates += self._within(folder, place)
        elif scheme in ("", "file"):
            candidates = [folder / place] + [root / place for root in self.folders]
        else:
            return None
        return next((path for path in candidates if path.exists()), None)

    @staticmethod
    def _within(root: Path, place: Path) -> list[Path]:
        inside = [root.joinpath(*place.parts[1:])] if place.parts and root.name == place.parts[0] else []
        return [root / place, *inside]

    def mesh(
        self,
        uri: str,
        color: Any = None,
        beside: Optional[Path] = None,
        submesh: str = "",
        centered: bool = False,
    ) -> Optional[int]:
        """The mesh of a file, or None if it is left out. `color` is (rgba, name) in place of the file's materials;
        `centered` moves the middle of the submesh's bounds to the origin."""
        path = self.find(uri, beside)
        if path is None:
            self.parts.leave_out(f"the mesh {uri}, which is not found")
            return None
        key = (path, color, submesh, centered)
        if key not in self._meshes:
            try:
                pieces = self._read(path)
            except UNREADABLE as error:
                self.parts.leave_out(f"the mesh {uri}: {reason(error)}")
                return None
            chosen = _called(pieces, submesh) if submesh else pieces
            if centered:
                chosen = [replace(piece, triangles=_centered(piece.triangles)) for piece in chosen]
            if not any(len(piece.triangles[1]) for piece in chosen):
                self.parts.leave_out(
                    f"the mesh {uri}, which has no triangles" + (f" in '{submesh}'" if submesh else "")
                )
                return None
            self._meshes[key] = self._joined(chosen, color, path.stem)
        return self._meshes[key]

    def _joined(self, pieces: list[Piece], color: Any, name: str) -> int:
        shapes = self.parts.shapes
        looks = [color or (piece.color or (0.5, 0.5, 0.5, 1.0), piece.material) for piece in pieces]
        materials = [shapes.material(*look) for look in looks]
        of_faces = np.repeat(materials, [len(piece.triangles[1]) for piece in pieces])
        return shapes.mesh(adapter.joined((piece.triangles for piece in pieces), name), of_faces, name)

    def _read(self, path: Path) -> list[Piece]:
        if path not in self._pieces:
            self._pieces[path] = read_pieces(path)
        return self._pieces[path]

    def primitive(self, kind: str, sizes: Any, material: int, scale: float = 1.0) -> Optional[int]:
        """The mesh of a shape that `primitives` has, with its arguments, or None if it is left out because of its
        sizes; `scale` is that of its instance."""
        key = (kind, tuple(value for size in sizes for value in np.ravel(size).tolist()), material, scale)
        if key not in self._meshes:
            make = getattr(primitives, kind)
            flat = kind in ("box", "plane")
            try:
                triangles = make(*sizes) if flat else make(*sizes, self.tolerance / scale)
            except ValueError as error:
                self.parts.leave_out(f"a shape: {error}")
                return None
            self._meshes[key] = self.parts.shapes.mesh(triangles, material, kind)
        return self._meshes[key]


def reason(error: Exception) -> str:
    """The first line of an error, or its type if it says nothing."""
    return (str(error) or type(error).__name__).splitlines()[0]


def _called(pieces: list[Piece], name: str) -> list[Piece]:
    """The pieces that have a name as their first one, or else those that have it as their second, and so on."""
    for rank in range(max((len(piece.names) for piece in pieces), default=0)):
        found = [piece for piece in pieces if piece.names[rank : rank + 1] == (name,)]
        if found:
            return found
    return []


def _centered(triangles: primitives.Triangles) -> primitives.Triangles:
    """Gazebo centres each piece of a submesh by itself."""
    corners, faces = triangles
    return (corners - (corners.min(axis=0) + corners.max(axis=0)) / 2 if len(corners) else corners), faces


def read_pieces(path: Path) -> list[Piece]:
    """What stands in a file of triangles. The up axes of glTF and Collada are not applied, as in Gazebo and RViz."""
    return list(_read_ours(path) if path.suffix.lower() in OURS else _read_with_trimesh(path))


def _read_ours(path: Path) -> Iterator[Piece]:
    scene = gno.load_scene(path, gno.LoadOptions(up="z"))  # as the file has it
    for instance in scene.instances:
        mesh = scene.meshes[instance.mesh]
        corners, faces = primitives.moved(
            (mesh.positions + np.array(mesh.origin), mesh.indices), instance.transform.rows
        )
        for part in mesh.parts:
            chosen = faces[part.first_triangle : part.first_triangle + part.triangle_count]
            used, numbers = np.unique(chosen, return_inverse=True)
            material = scene.materials[part.material]
            triangles = corners[used], numbers.reshape(-1, 3).astype(np.uint32)
            stated = material.name and path.suffix.lower() not in (".stl", ".ply")
            names = (instance.name or mesh.name, mesh.name or instance.name)
            yield Piece(triangles, names, material.name, material.base_color if stated else None)


def _read_with_trimesh(path: Path) -> Iterator[Piece]:
    """Collada and OFF."""
    if path.suffix.lower() not in (".dae", ".off"):  # trimesh would unpack archives, too, to any size
        raise ValueError(f"{path.name} is of no kind that is read: {', '.join((*OURS, '.dae', '.off'))}")
    try:
        import trimesh
    except ImportError as error:
        raise ImportError(f"{path.suffix} is read by the package trimesh: pip install trimesh pycollada") from error
    scene = trimesh.load_scene(path)
    words = str(scene.units or "").split()
    unit = float(words[0]) if words[1:] == ["*", "meters"] else 1.0
    names = _collada_names(path, list(map(str, scene.geometry))) if path.suffix.lower() == ".dae" else {}
    for node in scene.graph.nodes_geometry:
        place, name = scene.graph[node]
        geometry = scene.geometry[name]
        if not hasattr(geometry, "faces"):
            continue
        material = getattr(geometry.visual, "material", None)
        color = getattr(material, "baseColorFactor", None)
        if color is None:
            color = getattr(material, "diffuse", None)
        rgba = None if color is None else np.asarray(color, np.float64)
        if rgba is not None and np.asarray(color).dtype == np.uint8:
            rgba = rgba / 255
        scale = np.diag([unit, unit, unit, 1.0])
        triangles = primitives.moved(
            (np.asarray(geometry.vertices), np.asarray(geometry.faces, np.uint32)), scale @ place
        )
        given = None if rgba is None else tuple(rgba.tolist())
        yield Piece(triangles, names.get(str(name), (str(node),)), getattr(material, "name", "") or "", given)


def _collada_names(path: Path, pieces: list[str]) -> dict[str, tuple[str, ...]]:
    """The names of the node and of the geometry of each piece. trimesh calls the pieces of a geometry in their order
    ID, ID_1, ID_2 and so on, over all nodes that place it."""
    try:
        root = parse_xml(path)
    except ET.ParseError:
        return {}
    placed: dict[str, list[str]] = {}
    nodes = {node.get("id", ""): node for node in root.iterfind(".//{*}node")}

    def walk(node: ET.Element, name: str) -> None:
        name = node.get("name") or name  # what has no name belongs to what is around it
        for child in node:
            tag, target = child.tag.rpartition("}")[2], child.get("url", "").removeprefix("#")
            if tag == "node":
                walk(child, name)
            elif tag == "instance_node" and target in nodes:
                walk(nodes[target], name)
            elif tag == "instance_geometry":
                placed.setdefault(target, []).append(name)

    shown = root.find("{*}scene/{*}instance_visual_scene")
    for scene in root.iterfind("{*}library_visual_scenes/{*}visual_scene"):
        if shown is not None and shown.get("url", "").removeprefix("#") == scene.get("id"):
            walk(scene, "")
    parts: dict[str, list[str]] = {}
    names: dict[str, tuple[str, ...]] = {}
    for piece in pieces:
        geometry = piece if piece in placed else piece.rpartition("_")[0]
        parts.setdefault(geometry, []).append(piece)
    for geometry, own in parts.items():
        if geometry in placed and len(own) % len(placed[geometry]) == 0:
            count = len(own) // len(placed[geometry])
            for i, piece in enumerate(own):
                names[piece] = (placed[geometry][i // count], geometry)
    return names


# Each of these texts ends at its first end: a search that may try later ones takes twice the time with each text.
_COMMENT, _INSTRUCTION = rb"<!--(?:(?!-->).)*-->", rb"<\?(?:(?!\?>).)*\?>"
_BEFORE_DECLARATION = re.compile(rb"\A(?:\s|" + _COMMENT + rb")+(?=<\?xml)", re.DOTALL)
_BEFORE_ROOT = re.compile(
    rb"(?:\s|" + _COMMENT + rb"|" + _INSTRUCTION + rb"|<!DOCTYPE[^>]*>)*<[\w.:-]+", re.DOTALL
)


def parse_xml(path: Path) -> ET.Element:
    """The outermost element of a file. Robots' own parsers forgive comments before the XML declaration, a zero at the
    end and prefixes that nobody declares, and so files have them."""
    data = path.read_bytes()
    encoding: Optional[str] = None
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        data, encoding = data.decode("utf-16", "replace").encode(), "utf-8"  # in place of what the file declares
    data = _BEFORE_DECLARATION.sub(b"", data.rstrip(b" \t\r\n\0"))
    try:
        return ET.fromstring(data, ET.XMLParser(encoding=encoding))
    except ET.ParseError as error:
        start = _BEFORE_ROOT.match(data)
        if "unbound prefix" not in str(error) or not start:
            raise
    prefixes = set(re.findall(rb"[<\s/]([A-Za-z_][\w.-]*):\w", data)) - set(re.findall(rb"xmlns:([\w.-]+)", data))
    declared = b"".join(b' xmlns:%s="%s"' % (name, name) for name in sorted(prefixes - {b"xml", b"xmlns"}))
    return ET.fromstring(data[: start.end()] + declared + data[start.end() :], ET.XMLParser(encoding=encoding))


def rotation(roll: float, pitch: float, yaw: float) -> Matrix:
    """The matrix (3, 3) of turns about the fixed axes x, y and z, one after the other."""
    (cr, cp, cy), (sr, sp, sy) = np.cos([roll, pitch, yaw]), np.sin([roll, pitch, yaw])
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )

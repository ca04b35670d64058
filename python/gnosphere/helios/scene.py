# SPDX-License-Identifier: Apache-2.0
"""Scenes of HELIOS++ as the "scenes", "classes" and material table of a drive file."""

from __future__ import annotations

import os
import xml.etree.ElementTree as ET
from collections import Counter
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, Optional

import numpy as np

from .. import _gnosphere as gno
from .assets import Assets, Matrix, number_of, place, quaternion_of, rotation_of


@dataclass
class Part:
    """A file, and where it stands: its points are turned, scaled and moved."""

    file: Path
    up: str = "z"
    turn: Matrix = field(default_factory=lambda: np.eye(3))
    scale: float = 1.0
    offset: Matrix = field(default_factory=lambda: np.zeros(3))
    materials: dict[str, dict[str, str]] = field(default_factory=dict)
    """What HELIOS++ reads of each material, such as {"grass": {"classification": "2"}}."""

    @cached_property
    def ground(self) -> Matrix:
        """The triangles of the ground, of shape (n, 3, 3), where they stand."""
        options = gno.LoadOptions()
        options.up, options.scale = (gno.UpAxis.z if self.up == "z" else gno.UpAxis.y), self.scale
        scene = gno.load_scene(self.file, options)
        names = [material.name for material in scene.materials]
        found = [np.zeros((0, 3, 3))]
        for instance in scene.instances:
            mesh = scene.meshes[instance.mesh]
            rows = np.asarray(instance.transform.rows, np.float64)
            corners = (mesh.positions + np.array(mesh.origin)) @ rows[:, :3].T + rows[:, 3]
            corners = corners @ self.turn.T + self.offset
            ground = np.ones(len(mesh.indices), bool)
            for part in mesh.parts:
                stated = self.materials.get(names[part.material], {}).get("isGround", "true").lower()
                ground[part.first_triangle : part.first_triangle + part.triangle_count] = stated in ("true", "1")
            found.append(corners[mesh.indices[ground]])
        return np.concatenate(found)


def _heights(triangles: Matrix, x: float, y: float) -> Matrix:
    """The heights at which a vertical line meets triangles of shape (n, 3, 3)."""
    a, b, c = (triangles[:, i, :2] - (x, y) for i in range(3))
    cross = [p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0] for p, q in ((b, c), (c, a), (a, b))]
    area = cross[0] + cross[1] + cross[2]
    inside = (area != 0) & ((np.minimum.reduce(cross) >= 0) | (np.maximum.reduce(cross) <= 0))
    weights = np.stack(cross, 1)[inside] / area[inside, None]
    return np.asarray((weights * triangles[inside, :, 2]).sum(1))


def read_parts(assets: Assets, location: str, left_out: Counter[str]) -> list[Part]:
    scene = assets.element("scene", location)
    known: dict[Path, dict[str, dict[str, str]]] = {}
    parts = [_part(assets, part, number, known, left_out) for number, part in enumerate(scene.iter("part"))]
    if not parts:
        raise ValueError(f"the scene '{location}' has no <part>")
    return parts


def _part(
    assets: Assets,
    element: ET.Element,
    number: int,
    known: dict[Path, dict[str, dict[str, str]]],
    left_out: Counter[str],
) -> Part:
    """The part of an element. `known` has the materials of files that parts before it have read."""
    where = f"part {element.get('id', number)} of the scene"
    for tag, what in (("swap", "exchanges of parts"), ("dmotion", "motions of parts")):
        if element.find(tag) is not None:
            left_out[what] += 1
    part: Optional[Part] = None
    for step in element.findall("filter"):
        kind = step.get("type", "").lower()
        values = {param.get("key", ""): param for param in step.findall("param")}
        if kind == "objloader":
            part = _object(assets, values, where)
            if part.file not in known:
                known[part.file] = _materials(part.file)
            part.materials = known[part.file]
        elif kind in ("geotiffloader", "xyzloader", "detailedvoxels"):
            raise ValueError(f"{where} is read by '{kind}'; only triangles are, so make an OBJ of it, for 'objloader'")
        elif kind not in ("scale", "rotate", "translate"):
            raise ValueError(f"{where} has a filter '{kind}'; objloader, scale, rotate and translate are read")
        elif part is None:
            raise ValueError(f"{where} has a filter '{kind}' before there is a file")
        else:
            _move(part, kind, values, where, left_out)
    if part is None:
        raise ValueError(f"{where} has no file")
    return part


def _object(assets: Assets, values: dict[str, ET.Element], where: str) -> Part:
    if "filepath" not in values:
        raise ValueError(f"{where} has no 'filepath'; patterns of files ('efilepath') are not read")
    part = Part(assets.path(values["filepath"].get("value", "")))
    if "up" in values:
        part.up = values["up"].get("value", "z")
    return part


def _move(part: Part, kind: str, values: dict[str, ET.Element], where: str, left_out: Counter[str]) -> None:
    key = {"scale": "scale", "rotate": "rotation", "translate": "offset"}[kind]
    value = values.get(key)
    if value is None:
        raise ValueError(f"{where}: the filter '{kind}' has no '{key}'")
    if kind == "scale":
        part.scale = number_of(value.get("value", ""), f"{where}: scale")
    elif kind == "rotate":
        part.turn = rotation_of(value) @ part.turn
    else:
        numbers = [number_of(text, f"{where}: offset") for text in value.get("value", "").split(";")]
        if len(numbers) != 3:
            raise ValueError(f"{where}: the offset has {len(numbers)} numbers")
        part.offset = np.array(numbers)
        if values.get("onGround") is not None and values["onGround"].get("value") not in ("0", "false"):
            left_out["parts that are put on the ground"] += 1


def _materials(file: Path) -> dict[str, dict[str, str]]:
    """What HELIOS++ reads of each material of an OBJ file in the libraries beside it: its own words, and Ks. Also has
    the materials that no library defines, and '' if faces have none, with no words."""
    found: dict[str, dict[str, str]] = {}
    text = file.read_text(encoding="utf-8", errors="replace")
    for line in text.splitlines():
        if not line.startswith("mtllib"):
            continue
        library = file.parent / line[len("mtllib") :].strip()
        current: dict[str, str] = {}
        if not library.is_file():
            continue  # the reader of OBJ files tells of it
        for words in map(str.split, library.read_text(encoding="utf-8", errors="replace").splitlines()):
            if len(words) > 1 and words[0] == "newmtl":
                current = found.setdefault(" ".join(words[1:]), {})
            elif len(words) > 1 and words[0].startswith("helios_"):
                key = words[0][len("helios_") :]
                number = key == "classification"
                current[key] = str(int(number_of(words[1], f"{words[0]} in {library}"))) if number else words[1]
            elif len(words) > 1 and words[0] == "Ks":
                current["Ks"] = " ".join(words[1:])
    for material in gno.load_scene(file).materials:
        found.setdefault(material.name, {})
    return found


def _is_mirror_like(words: dict[str, str]) -> bool:
    """Whether Ks of a material has a part above 0. HELIOS++ then adds a lobe, whose exponent is Ns."""
    try:
        return any(float(text) > 0 for text in words.get("Ks", "").split())
    except ValueError:
        return False


@dataclass
class Surfaces:
    """What the materials of a scene are in a drive file.

    classes: the "classes" of the drive.
    reflectances: by names of materials in small letters, 1 for white.
    """

    classes: dict[str, dict[str, int]] = field(default_factory=dict)
    reflectances: dict[str, float] = field(default_factory=dict)


def surfaces_of(parts: list[Part], left_out: Counter[str]) -> Surfaces:
    surfaces = Surfaces()
    for part in parts:
        for name, words in part.materials.items():
            if "classification" in words:
                surfaces.classes[_class_of(words)] = {"id": int(words["classification"])}
            percent = number_of(words.get("reflectance", "50"), f"helios_reflectance of '{name}'")
            value = min(max(percent / 100, 0.0), 1.0)
            if surfaces.reflectances.setdefault(name.lower(), value) != value:
                left_out["reflectances of materials that another part has by the same name"] += 1
            if "spectra" in words:
                left_out["spectra of materials"] += 1
            if _is_mirror_like(words):
                left_out["mirror-like reflections of materials (Ks, Ns)"] += 1
    return surfaces


def _class_of(words: dict[str, str]) -> str:
    return f"class {words['classification']}"


def scenes_of(parts: list[Part], folder: Path) -> list[dict[str, Any]]:
    """The "scenes" of a drive file in `folder`."""
    scenes = []
    for part in parts:
        scene: dict[str, Any] = {"file": os.path.relpath(part.file, folder), "up": part.up, "scale": part.scale}
        scene["pose"] = {"position": place(part.offset), "orientation": quaternion_of(part.turn)}
        materials = {name: _class_of(words) for name, words in part.materials.items() if "classification" in words}
        if materials:
            scene["materials"] = materials
        scenes.append(scene)
    return scenes


def ground_at(parts: list[Part], x: float, y: float) -> float:
    """The height of the lowest surface of the ground at a place. Raises ValueError if there is none."""
    heights = np.concatenate([_heights(part.ground, x, y) for part in parts])
    if not len(heights):
        raise ValueError(f"there is no ground at x {x:g}, y {y:g}, where a leg with onGround stands")
    return float(heights.min())

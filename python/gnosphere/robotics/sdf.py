# SPDX-License-Identifier: Apache-2.0
"""SDF worlds and models, of versions 1.4 to 1.12: no library for Python reads them."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Optional

import numpy as np

from .. import adapter
from . import xml_lidars
from .resources import Resources, parse_xml
from .robot_scene import Kinematics, Matrix, Mimic, Parts, unique_name
from .sdf_kinematics import Joint, Tree
from .sdf_merge import merge
from .xml_lidars import number, numbers, pose_of

MOST_INCLUDES = 10_000
"""Of a file, with those of the models that it includes."""
ENDLESS = 1000.0
"""Metres: half the size of the plane of a collision, which has no end; that of a visual has a size."""


def read(path: Path, parts: Parts, resources: Resources, collisions: bool) -> Kinematics:
    reader = Reader(parts, resources, collisions)
    root = _modern(parse_xml(path))
    if root.tag == "gazebo":
        raise ValueError("is of the time before SDF 1.2; 'gz sdf -p' converts it")
    worlds = root.findall("world")
    if len(worlds) > 1:
        parts.leave_out("worlds beyond the first", len(worlds) - 1)
    top = worlds[0] if worlds else root
    reader.expand(top, (path.absolute(),))
    reader.scope(top, "", np.eye(4), path.absolute())
    reader.tree.resolve_mimics()
    return reader.tree.frames, reader.tree.limits()


class Reader:
    def __init__(self, parts: Parts, resources: Resources, collisions: bool) -> None:
        self.parts, self.resources, self.collisions = parts, resources, collisions
        self.tree = Tree(parts)
        self._files: dict[int, Path] = {}  # of included models and links, by the identity of their elements
        self._included_count = 0

    def expand(self, element: ET.Element, files: tuple[Path, ...]) -> None:
        """Puts models in place of <include>, everywhere below an element, and lets all have names of their own."""
        for child in list(element):
            if child.tag == "model":
                self.expand(child, files)
            elif child.tag == "include":
                included = self._included(child, files)
                if included is not None and child.get("merge", "").strip() in ("1", "true"):
                    at = list(element).index(child)
                    element[at:at] = self._merged(*included, element)
                elif included is not None:
                    model, origin = included
                    element.append(model)
                    self._files[id(model)] = origin
                element.remove(child)
        self._tell_apart(element)

    def _tell_apart(self, element: ET.Element) -> None:
        """Gives other names to things of a model or world whose names are taken; who names them means the first."""
        for tags in (("link", "model", "frame"), ("joint",)):
            taken: set[str] = set()
            last: dict[str, int] = {}
            for child in element:
                if child.tag not in tags:
                    continue
                name = child.get("name", "")
                unique = unique_name(name, taken, last)
                taken.add(unique)
                child.set("name", unique)
                if unique != name:
                    self.parts.leave_out(f"the name '{name}' of another {child.tag}, which is '{unique}' here")

    def _merged(self, model: ET.Element, origin: Path, parent: ET.Element) -> list[ET.Element]:
        """What takes the place of an <include> that merges a model of the file `origin` into its parent."""
        poses, result = Poses(model), []
        for element in merge(model, self._included_count, poses.link("__model__"), poses.placed(model)):
            if element.tag == "link" and parent.tag == "world":
                self.parts.leave_out("links of a model that is merged into a world")
                continue
            if element.tag in ("link", "model"):
                self._files.setdefault(id(element), origin)
            result.append(element)
        return result

    def _included(self, include: ET.Element, files: tuple[Path, ...]) -> Optional[tuple[ET.Element, Path]]:
        """The model of an <include>, and its file."""
        uri = (include.findtext("uri") or "").strip()
        origin = self._model_file(uri, files[-1])
        if origin is None:
            self.parts.leave_out(f"the model {uri}, which is not found")
            return None
        if origin in files:
            raise ValueError(f"{origin} includes itself")
        self._included_count += 1
        if self._included_count > MOST_INCLUDES:
            raise ValueError(f"more than {MOST_INCLUDES:,} models are included, the last one from {files[-1]}")
        model = _modern(parse_xml(origin)).find("model")
        if model is None:
            self.parts.leave_out(f"{origin.name}, which has no <model>")
            return None
        placement = (include.findtext("placement_frame") or "").strip()
        if placement:
            model.set("placement_frame", placement)
        self.expand(model, (*files, origin))
        model.set("name", (include.findtext("name") or model.get("name") or "").strip())
        pose = include.find("pose")
        if pose is not None:
            for own in model.findall("pose"):
                model.remove(own)
            model.append(pose)
        return model, origin

    def _model_file(self, uri: str, file: Path) -> Optional[Path]:
        found = self.resources.find(uri, file)
        if found is None or found.is_file():
            return found
        config = found / "model.config"
        if config.is_file():
            listed = [(sdf.get("version", "0"), sdf.text or "") for sdf in parse_xml(config).findall("sdf")]
            files = [found / name.strip() for _, name in sorted(listed, key=_version)]
            existing = [path for path in files if path.is_file()]
            if existing:
                return existing[-1]
        return found / "model.sdf" if (found / "model.sdf").is_file() else None

    def scope(self, element: ET.Element, prefix: str, place: Matrix, file: Path) -> None:
        """Reads a world, a model or a file's root, whose frame is at `place` in the world."""
        file, poses = self._files.get(id(element), file), Poses(element)
        for link in element.findall("link"):
            own = self._files.get(id(link), file)
            self._link(link, prefix, place @ poses.of(link.get("name", "")), poses, own)
        for model in element.findall("model"):
            name = model.get("name", "")
            self.scope(model, f"{prefix}{name}::", place @ poses.of(name), file)
        for joint in element.findall("joint"):
            self._joint(joint, prefix, place, poses)
        self._leave_out(element, "actor", "population", "road", "state", "particle_emitter")

    def _leave_out(self, element: ET.Element, *tags: str) -> None:
        for tag in tags:
            count = len(element.findall(tag))
            if count:
                self.parts.leave_out(f"<{tag}>", count)

    def _link(self, link: ET.Element, prefix: str, place: Matrix, poses: "Poses", file: Path) -> None:
        name = prefix + link.get("name", "")
        self.tree.links[name] = place
        for shape in link.findall("collision" if self.collisions else "visual"):
            self._shape(shape, name, poses.inside(shape, link.get("name", "")), file)
        self._leave_out(link, "particle_emitter")
        for sensor in link.findall("sensor"):
            full = prefix + sensor.get("name", "lidar")
            if xml_lidars.is_lidar(sensor):
                xml_lidars.mount(sensor, self.parts, full, name, poses.inside(sensor, link.get("name", "")))
            else:
                xml_lidars.leave_out_sonar(sensor, self.parts, full)

    def _shape(self, shape: ET.Element, link: str, local: Matrix, file: Path) -> None:
        geometry = shape.find("geometry")
        kind = next((child for child in geometry if child.tag != "empty"), None) if geometry is not None else None
        if kind is None:
            return
        color, label = _color(shape)
        if shape.find("material/pbr") is not None:
            self.parts.leave_out("textures")
        if shape.find("laser_retro") is not None:
            self.parts.leave_out("<laser_retro>, whose scale is the simulator's")
        names = (f"{link}::{shape.get('name', '')}", link, shape.get("name", ""), label)
        if kind.tag == "mesh":
            scale = numbers(kind.findtext("scale"), (1, 1, 1), "a <scale>")
            chosen = None if color is None else (color, label)
            submesh = (kind.findtext("submesh/name") or "").strip()
            centered = bool(submesh) and _is_true(kind.findtext("submesh/center"))
            mesh = self.resources.mesh((kind.findtext("uri") or "").strip(), chosen, file, submesh, centered)
            local = local @ np.diag([*scale, 1.0])
        else:
            material = self.parts.shapes.material(color or (0.5, 0.5, 0.5, 1.0), label)
            mesh = self._primitive(kind, material)
            if kind.tag == "plane":
                local = local @ adapter.upright(numbers(kind.findtext("normal"), (0, 0, 1), "a <normal>"))
        if mesh is not None:
            self.parts.place(mesh, link, local, *names)

    def _primitive(self, kind: ET.Element, material: int) -> Optional[int]:
        radius, half = number(kind, "radius", 1.0), number(kind, "length", 1.0) / 2
        if kind.tag == "box":
            size = numbers(kind.findtext("size"), (1, 1, 1), "the <size> of a <box>") / 2
            return self.resources.primitive("box", [size], material)
        if kind.tag == "sphere":
            return self.resources.primitive("sphere", [radius], material)
        if kind.tag in ("cylinder", "capsule", "cone"):
            return self.resources.primitive(kind.tag, [radius, half], material)
        if kind.tag == "ellipsoid":
            radii = numbers(kind.findtext("radii"), (1, 1, 1), "the <radii> of an <ellipsoid>")
            return self.resources.primitive("ellipsoid", [radii], material)
        if kind.tag == "plane":
            size = numbers(kind.findtext("size"), (1, 1), "the <size> of a <plane>") / 2
            endless = self.collisions or kind.find("size") is None
            return self.resources.primitive("plane", [ENDLESS, ENDLESS, 1.0] if endless else [*size, 1.0], material)
        self.parts.leave_out(f"<{kind.tag}> geometry")
        return None

    def _joint(self, joint: ET.Element, prefix: str, place: Matrix, poses: Poses) -> None:
        kind, name = joint.get("type", ""), joint.get("name", "")
        parent, child = (_end(joint, end) for end in ("parent", "child"))
        if child is None or parent is None or kind == "fixed" and parent == "world":
            return
        links = [prefix + link if link else "" for link in map(poses.link, (parent, child))]
        if links[1] not in self.tree.links:
            return self.parts.leave_out(f"the joint {prefix}{name}, whose child '{child}' is not there")
        if links[0] and links[0] not in self.tree.links:
            return self.parts.leave_out(f"the joint {prefix}{name}, whose parent '{parent}' is not there")
        axis, at = joint.find("axis"), place @ poses.of(name)
        if kind in ("revolute", "continuous", "prismatic") and axis is not None:
            frame, xyz = None, axis.find("xyz")
            if xyz is not None and xyz.get("expressed_in"):
                frame = place @ poses.of(xyz.get("expressed_in", ""))
            elif _is_true(axis.findtext("use_parent_model_frame")):
                frame = place
            direction = xml_lidars.axis_of(xyz.text if xyz is not None else None, (0, 0, 1), name)
            direction = (at if frame is None else frame)[:3, :3] @ direction
            limit = axis.find("limit")
            low, high = number(limit, "lower", -math.inf), number(limit, "upper", math.inf)
            if abs(low) >= 1e16 or abs(high) >= 1e16 or kind == "continuous":
                low, high = -math.inf, math.inf
            made = Joint(kind == "prismatic", at[:3, 3], direction, (low, high))
            mimic = axis.find("mimic")
            if mimic is not None:
                factor, reference = number(mimic, "multiplier", 1.0), number(mimic, "reference", 0.0)
                offset = number(mimic, "offset", 0.0) - factor * reference
                made.mimic = Mimic(prefix + mimic.get("joint", ""), factor, offset)
        else:
            if kind != "fixed":
                self.parts.leave_out(f"the motion of {kind} joints")
            made = Joint()
        self.tree.join(prefix + name, made, links[0], links[1])


class Poses:
    """Where the links, joints, frames and models of a model are in it: the semantics of poses of SDF 1.7. In older
    files no pose names a frame, which is the same."""

    def __init__(self, scope: ET.Element) -> None:
        self._elements: dict[str, tuple[Optional[ET.Element], str]] = {}  # <pose>, and the frame that it is in
        self._attached: dict[str, str] = {}
        self._models = {model.get("name", ""): model for model in scope.findall("model")}
        self._canonical = self._canonical_link(scope) if scope.tag == "model" else "world"
        self._inner: dict[str, Poses] = {}
        self._found: dict[str, Optional[Matrix]] = {name: np.eye(4) for name in ("", "__model__", "world")}
        for child in scope:
            name, pose = child.get("name", ""), child.find("pose")
            if child.tag in ("link", "model"):
                self._elements[name] = (pose, "")
            elif child.tag == "joint":
                self._elements[name] = (pose, _end(child, "child") or "")
                self._attached[name] = _end(child, "child") or ""
            elif child.tag == "frame":
                self._attached[name] = child.get("attached_to", "")
                self._elements[name] = (pose, self._attached[name])
        for child in scope.findall("link"):  # older files have joints with the names of links
            self._attached.pop(child.get("name", ""), None)

    def of(self, name: str) -> Matrix:
        if name not in self._found:
            self._found[name] = None  # until it is known; a frame that leads back here is an error
            self._found[name] = self._place(name)
        found = self._found[name]
        if found is None:
            raise ValueError(f"the pose of '{name}' is relative to itself")
        return found

    def _place(self, name: str) -> Matrix:
        if name in self._elements:
            pose, default = self._elements[name]
            relative = pose.get("relative_to") if pose is not None else None
            model = self._models.get(name)
            own = pose_of(pose) if model is None else self._within(name).placed(model)
            return self.of(relative or default) @ own
        head, _, rest = name.partition("::")
        if head not in self._models or not rest:
            raise ValueError(f"a pose is relative to '{name}', which is not there")
        return self.of(head) @ self._within(head).of(rest)

    def placed(self, model: ET.Element) -> Matrix:
        """Where the model, whose poses these are, is in what its <pose> is relative to; that is the pose of the frame
        by which the model is placed, if it has a `placement_frame`."""
        pose, frame = pose_of(model.find("pose")), model.get("placement_frame", "").strip()
        if not frame:
            return pose
        if frame not in self._found and frame.partition("::")[0] not in self._elements:
            raise ValueError(f"the model '{model.get('name')}' is placed by its frame '{frame}', which is not there")
        return pose @ np.linalg.inv(self.of(frame))

    def _within(self, model: str) -> Poses:
        if model not in self._inner:
            self._inner[model] = Poses(self._models[model])
        return self._inner[model]

    @staticmethod
    def _canonical_link(model: ET.Element) -> str:
        """What the frame of a model is attached to: a link, or a model inside if there is no link."""
        first = next((child.get("name", "") for tag in ("link", "model") for child in model.findall(tag)), "")
        return model.get("canonical_link") or first

    def inside(self, element: ET.Element, link: str) -> Matrix:
        """The map from an element of a link to the link."""
        pose = element.find("pose")
        relative = pose.get("relative_to") if pose is not None else None
        if not relative:
            return pose_of(pose)
        return np.linalg.inv(self.of(link)) @ self.of(relative) @ pose_of(pose)

    def link(self, name: str) -> str:
        """The link to which a frame is attached, with the models inside that it is in; a link is itself, and the world
        is an empty name. What is not there keeps its name."""
        passed = set()
        while name in self._attached or name == "__model__":
            if name in passed:
                raise ValueError(f"the frame '{name}' is attached to itself")
            passed.add(name)
            name = self._canonical if name == "__model__" else self._attached[name] or "__model__"
        head, _, rest = name.partition("::")
        if head in self._models:
            return f"{head}::{self._within(head).link(rest or '__model__')}"
        return "" if name == "world" else name


def _modern(root: ET.Element) -> ET.Element:
    """Says in a file of SDF 1.4 and before what it means: the axes of its joints are in the frame of the model."""
    if _version((root.get("version", "1.5"), "")) < [1, 5]:
        for axis in root.iterfind(".//joint/axis"):
            ET.SubElement(axis, "use_parent_model_frame").text = "1"
    return root


def _is_true(text: Optional[str]) -> bool:
    return (text or "").strip() in ("1", "true")


def _version(entry: tuple[str, str]) -> list[int]:
    return [int(part) if part.isdigit() else 0 for part in entry[0].split(".")]


def _end(joint: ET.Element, end: str) -> Optional[str]:
    found = joint.find(end)
    return None if found is None else (found.text or found.findtext("link_name") or "").strip()


def _color(shape: ET.Element) -> tuple[Optional[tuple[float, ...]], str]:
    """The colour of a visual and the name of its material. A transparency is in its alpha."""
    material, opacity = shape.find("material"), 1 - number(shape, "transparency", 0.0)
    label = (shape.findtext("material/script/name") or "").strip()
    diffuse = material.findtext("diffuse") if material is not None else None
    if diffuse is None:
        known = SCRIPTS.get(label.removeprefix("Gazebo/"))
        if known is None:
            return (None if opacity == 1 else (0.5, 0.5, 0.5, opacity)), label
        return (*known, opacity), label
    rgba = numbers(diffuse, (0.5, 0.5, 0.5, 1), "a <diffuse>", (3, 4))
    return (*map(float, rgba[:3]), float(rgba[3] if len(rgba) > 3 else 1) * opacity), label


SCRIPTS = {
    "White": (1, 1, 1), "Grey": (0.5, 0.5, 0.5), "DarkGrey": (0.175, 0.175, 0.175), "Black": (0, 0, 0),
    "FlatBlack": (0.1, 0.1, 0.1), "Red": (1, 0, 0), "Green": (0, 1, 0), "Blue": (0, 0, 1), "Yellow": (1, 1, 0),
    "Orange": (1, 0.5088, 0.0468), "Wood": (0.5, 0.35, 0.2), "Bricks": (0.6, 0.3, 0.25),
}  # fmt: skip
"""Diffuse colours of Gazebo's material scripts that worlds name most."""

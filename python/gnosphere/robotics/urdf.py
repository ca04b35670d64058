# SPDX-License-Identifier: Apache-2.0
"""URDF, through yourdfpy: visual or collision geometry, joints, and the lidars inside <gazebo>."""

from __future__ import annotations

import io
import logging
import math
import xml.etree.ElementTree as ET
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Optional

import numpy as np
import yourdfpy

from . import xml_lidars
from .resources import Resources, parse_xml, rotation
from .robot_scene import Joints, Kinematics, Matrix, Mimic, Parts, resolved_mimics

GEOMETRY = ("box", "sphere", "cylinder", "mesh")
MOVING = ("revolute", "continuous", "prismatic")


def read(path: Path, parts: Parts, resources: Resources, collisions: bool) -> Kinematics:
    root = parse_xml(path)
    _check_joints(root)
    macros = sum("xacro" in element.tag.rpartition("}")[0] for element in root.iter())
    if macros:
        parts.leave_out(f"elements of xacro, which 'xacro {path.name} > robot.urdf' replaces", macros)
    shared = _materials_of_visuals(root)
    capsules = _drop_unknown(root, parts, "collision" if collisions else "visual")
    alone = ET.Element("robot", {"name": root.get("name", path.stem)})  # other elements may be malformed
    alone.extend(element for element in root if element.tag in ("link", "joint", "material"))
    alone.extend(shared)
    log = logging.getLogger("yourdfpy")
    before, log.level = log.level, logging.ERROR  # what it warns about is counted here
    try:
        robot = yourdfpy.URDF.load(io.BytesIO(ET.tostring(alone)), load_meshes=False, build_scene_graph=True)
    except (KeyError, TypeError, AttributeError) as error:
        raise ValueError(f"yourdfpy cannot read it: {type(error).__name__} {error}") from error
    finally:
        log.level = before
    colors = {material.name: _color(material) for material in robot.robot.materials}
    for link in robot.robot.links:
        for shape in link.collisions if collisions else link.visuals:
            _add(shape, link.name, parts, resources, colors)
    for link_name, shape in capsules:
        _add_capsule(shape, link_name, parts, resources, colors)
    _resolve_mimics(robot.robot.joints, parts)
    limits = {}
    for joint in robot.robot.joints:
        if joint.mimic is not None:
            continue
        if joint.type in MOVING:
            low = joint.limit.lower if joint.limit and joint.limit.lower is not None else -math.inf
            high = joint.limit.upper if joint.limit and joint.limit.upper is not None else math.inf
            limits[joint.name] = (low, high) if joint.type != "continuous" else (-math.inf, math.inf)
    links = [link.name for link in robot.robot.links]
    _lidars(root, parts, set(links))

    children = {joint.child: joint.parent for joint in robot.robot.joints}
    joined = {name for name in links if _top(name, children) == robot.base_link}
    if len(joined) < len(links):
        parts.leave_out("the places of links that no joint joins to the others", len(links) - len(joined))

    def frames(joints: Joints) -> Mapping[Any, Matrix]:
        robot.update_cfg(dict(joints))
        return {name: np.asarray(robot.get_transform(name)) if name in joined else np.eye(4) for name in links}

    return frames, limits


def _check_joints(root: ET.Element) -> None:
    """Raises ValueError if a joint joins what is no link of the robot, or moves along no axis. The link 'world' is there
    for all."""
    links = {link.get("name") for link in root.findall("link")}
    if "world" not in links and root.find("joint/parent[@link='world']") is not None:
        ET.SubElement(root, "link", {"name": "world"})
        links.add("world")
    for joint in root.findall("joint"):
        for end in ("parent", "child"):
            found = joint.find(end)
            link = found.get("link") if found is not None else None
            if link not in links:
                missing = f"has no <{end}> link" if link is None else f"has the {end} '{link}', which is no link"
                raise ValueError(f"the joint '{joint.get('name')}' {missing}")
        axis = joint.find("axis")
        if axis is not None and joint.get("type") in MOVING:
            xml_lidars.axis_of(axis.get("xyz"), (1, 0, 0), joint.get("name"))


def _resolve_mimics(joints: Any, parts: Parts) -> None:
    """Lets each joint that mimics another follow one that mimics none: yourdfpy moves no others."""
    stated = {joint.name: joint.mimic for joint in joints if joint.mimic is not None}
    mimics = {name: Mimic(mimic.joint, mimic.multiplier, mimic.offset) for name, mimic in stated.items()}
    for name, found in resolved_mimics(mimics, {joint.name for joint in joints}, parts).items():
        stated[name].joint, stated[name].multiplier, stated[name].offset = found


def _top(link: str, parents: Mapping[str, str]) -> str:
    """The link above all others of a link's tree."""
    for _ in parents:
        if link not in parents:
            break
        link = parents[link]
    return link


def _materials_of_visuals(root: ET.Element) -> list[ET.Element]:
    """The first material of each name that has its colour inside a visual only, from where other visuals name it."""
    found: dict[str, ET.Element] = {}
    for material in root.iterfind("link/visual/material"):
        if material.find("color") is not None:
            found.setdefault(material.get("name", ""), material)
    known = {material.get("name") for material in root.findall("material") if material.find("color") is not None}
    return [material for name, material in found.items() if name and name not in known]


def _drop_unknown(root: ET.Element, parts: Parts, kept: str) -> list[tuple[str, ET.Element]]:
    """Removes what yourdfpy refuses: geometry and joints that URDF does not have. Returns the capsules, which PyBullet
    and others have, with their links."""
    capsules = []
    for link in root.iter("link"):
        for shape in link.findall("visual") + link.findall("collision"):
            geometry = shape.find("geometry")
            if geometry is None or len(geometry) == 0 or geometry[0].tag not in GEOMETRY:
                link.remove(shape)
                if shape.tag != kept:
                    continue
                if geometry is not None and len(geometry) and geometry[0].tag == "capsule":
                    capsules.append((link.get("name", ""), shape))
                else:
                    parts.leave_out("geometry that is no box, sphere, cylinder, capsule or mesh")
    for joint in root.findall("joint"):
        if joint.get("type") not in (*MOVING, "fixed"):
            parts.leave_out(f"the motion of {joint.get('type')} joints")
            joint.set("type", "fixed")
    return capsules


def _add_capsule(shape: ET.Element, link: str, parts: Parts, resources: Resources, colors: Mapping[str, Any]) -> None:
    capsule, origin, material = shape.find("geometry/capsule"), shape.find("origin"), shape.find("material")
    label = material.get("name", "") if material is not None else ""
    stated = material.find("color") if material is not None else None
    color = colors.get(label)
    if stated is not None:
        color = tuple(xml_lidars.numbers(stated.get("rgba"), (0.5, 0.5, 0.5, 1), "an rgba", (3, 4)).tolist())
    local = np.eye(4)
    if origin is not None:
        local[:3, :3] = rotation(*xml_lidars.numbers(origin.get("rpy"), np.zeros(3), "an rpy"))
        local[:3, 3] = xml_lidars.numbers(origin.get("xyz"), np.zeros(3), "an xyz")
    sizes = [float(capsule.get(name, "0")) for name in ("radius", "length")] if capsule is not None else [0.0, 0.0]
    number = parts.shapes.material(color or (0.5, 0.5, 0.5, 1.0), label)
    mesh = resources.primitive("capsule", [sizes[0], sizes[1] / 2], number)
    if mesh is not None:
        parts.place(mesh, link, local, shape.get("name") or link, link, label)


def _color(material: Any) -> Optional[tuple[float, ...]]:
    return tuple(map(float, material.color.rgba)) if material and material.color is not None else None


def _add(shape: Any, link: str, parts: Parts, resources: Resources, colors: Mapping[str, Any]) -> None:
    material = getattr(shape, "material", None)
    label = (material.name if material else "") or ""
    color = _color(material) or colors.get(label)
    if material is not None and material.texture is not None:
        parts.leave_out("textures")
    local = np.eye(4) if shape.origin is None else np.asarray(shape.origin, np.float64)
    geometry = shape.geometry
    mesh: Optional[int]
    if geometry is not None and geometry.mesh is not None:
        chosen = None if color is None else (color, label)
        mesh = resources.mesh(geometry.mesh.filename, chosen)
        if geometry.mesh.scale is not None:
            local = local @ np.diag([*np.broadcast_to(np.ravel(geometry.mesh.scale)[:3], 3), 1.0])
    else:
        number = parts.shapes.material(color or (0.5, 0.5, 0.5, 1.0), label)
        if geometry is not None and geometry.box is not None:
            mesh = resources.primitive("box", [np.asarray(geometry.box.size) / 2], number)
        elif geometry is not None and geometry.sphere is not None:
            mesh = resources.primitive("sphere", [geometry.sphere.radius], number)
        elif geometry is not None and geometry.cylinder is not None:
            cylinder = geometry.cylinder
            mesh = resources.primitive("cylinder", [cylinder.radius, cylinder.length / 2], number)
        else:
            return
    if mesh is not None:
        parts.place(mesh, link, local, shape.name or link, link, label)


def _lidars(root: ET.Element, parts: Parts, links: set[str]) -> None:
    for gazebo in root.iter("gazebo"):
        link = gazebo.get("reference", "")
        for sensor in gazebo.iter("sensor"):
            name = sensor.get("name", "lidar")
            if not xml_lidars.is_lidar(sensor):
                xml_lidars.leave_out_sonar(sensor, parts, name)
            elif link in links:
                xml_lidars.mount(sensor, parts, name, link)
            else:
                parts.leave_out(f"the lidar {name} on the link '{link}', which is not there")

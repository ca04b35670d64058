# SPDX-License-Identifier: Apache-2.0
"""Included models of SDF whose links, joints, frames and models become those of the model around them."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator

from .. import adapter
from .robot_scene import Matrix

MERGED = ("link", "model", "joint", "frame")
"""What a model gives to the one around it; the rest, such as <static>, is that of the one around."""


def merge(model: ET.Element, number: int, canonical: str, place: Matrix) -> Iterator[ET.Element]:
    """What the model around an included one takes from it: a frame in place of its own one, and all that refers to it.

    number: of the included model among all, since several that are merged may have one name.
    canonical: the link to which the frame of the included model is attached.
    place: where that frame is in what the <pose> of the model is relative to.
    """
    name = f"_merged__{model.get('name', '')}_{number}__model__"
    frame = ET.Element("frame", {"name": name, "attached_to": canonical})
    pose, around = model.find("pose"), adapter.pose_of(place[:3, 3], place[:3, :3])
    relative = pose.get("relative_to") if pose is not None else None
    stated = ET.SubElement(frame, "pose", {"relative_to": relative or "__model__", "rotation_format": "quat_xyzw"})
    stated.text = " ".join(repr(float(value)) for value in (*around.position, *around.orientation))
    yield frame
    for element in model:
        if element.tag in MERGED:
            _refer(element, name)
            yield element


def _refer(element: ET.Element, frame: str) -> None:
    """Lets an element be relative to a frame where it was to its model."""
    if element.tag in ("link", "model"):
        own = element.find("pose")
        own = ET.SubElement(element, "pose") if own is None else own
        _replace(own, "relative_to", frame, implied=True)
    elif element.tag == "frame":
        _replace(element, "attached_to", frame, implied=True)
    if element.tag != "model":  # what is in a model is relative to that model
        for pose in element.iter("pose"):
            _replace(pose, "relative_to", frame)
    if element.tag == "joint":
        for end in (*element.findall("parent"), *element.findall("child")):
            if (end.text or "").strip() == "__model__":
                end.text = frame
        for axis in element.findall("axis"):
            xyz = axis.find("xyz")
            xyz = ET.SubElement(axis, "xyz") if xyz is None else xyz
            in_model = (axis.findtext("use_parent_model_frame") or "").strip() in ("1", "true")
            _replace(xyz, "expressed_in", frame, implied=in_model)


def _replace(element: ET.Element, attribute: str, frame: str, implied: bool = False) -> None:
    stated = element.get(attribute, "")
    if stated == "__model__" or implied and not stated:
        element.set(attribute, frame)

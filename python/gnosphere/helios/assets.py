# SPDX-License-Identifier: Apache-2.0
"""The XML of HELIOS++: files that name parts of other files, and attributes that templates supply."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Iterable
from pathlib import Path
from typing import Optional, Union

import numpy as np
from numpy.typing import NDArray

from .. import adapter
from ..robotics.resources import Folders, folders_of, rotation

Matrix = NDArray[np.float64]


class Assets:
    """Finds the files and elements that a survey names.

    folders: where paths such as data/platforms.xml start, one folder or several. After them come the folder of the
        survey and those above it.
    """

    def __init__(self, survey: Union[str, Path], folders: Folders = ()) -> None:
        self.survey = Path(survey)
        self._folders = [*folders_of(folders), *self.survey.resolve().parents]
        self._roots: dict[Path, ET.Element] = {}

    def path(self, name: str) -> Path:
        """The file of a name. Raises ValueError if there is none."""
        for folder in self._folders:
            if (folder / name).is_file():
                return folder / name
        raise ValueError(f"{self.survey}: '{name}' is in none of the folders {', '.join(map(str, self._folders))}")

    def root(self, file: Path) -> ET.Element:
        if file not in self._roots:
            try:
                self._roots[file] = ET.parse(file).getroot()
            except ET.ParseError as error:
                raise ValueError(f"{file} is not XML: {error}") from error
        return self._roots[file]

    def element(self, tag: str, location: str) -> ET.Element:
        """The element that `location` names: FILE#ID, or #ID or ID in the survey's own file."""
        name, _, identifier = location.rpartition("#")
        file = self.path(name) if name else self.survey
        for found in self.root(file).iter(tag):
            if found.get("id") == identifier:
                return found
        raise ValueError(f"{file} has no <{tag}> whose id is '{identifier}'")


class Settings:
    """Attributes of an element, or where it has none, of the element that it names as its template, and so on, and
    last those of `defaults`."""

    def __init__(self, assets: Assets, element: Optional[ET.Element], defaults: Optional[ET.Element] = None) -> None:
        self._name = "" if element is None else element.tag
        self._attributes: dict[str, str] = {}
        seen: set[int] = set()
        while element is not None and id(element) not in seen:
            seen.add(id(element))
            self._attributes = {**element.attrib, **self._attributes}
            template = element.get("template")
            element = assets.element(element.tag, template) if template else None
        if defaults is not None:
            self._name = self._name or defaults.tag
            self._attributes = {**defaults.attrib, **self._attributes}

    def has(self, name: str) -> bool:
        return name in self._attributes

    def text(self, name: str, default: str = "") -> str:
        return self._attributes.get(name, default)

    def number(self, name: str, default: float = 0.0) -> float:
        text = self._attributes.get(name)
        return default if text is None else number_of(text, f"{name} of <{self._name}>")

    def others(self, read: Iterable[str]) -> list[str]:
        """The names of attributes beside those that are read, and beside those that name elements."""
        return sorted(self._attributes.keys() - {*read, "id", "name", "template"})

    def flag(self, name: str, default: bool) -> bool:
        return self._attributes.get(name, str(default)).lower() in ("true", "1")


def number_of(text: str, what: str) -> float:
    """Raises ValueError that names `what` unless the text is a finite number."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise ValueError(f"{what} is '{text}', which is no number")
    return value


def rotation_of(element: Optional[ET.Element]) -> Matrix:
    """The matrix of the <rot> elements in an element: about its fixed axes one after another, or if its rotations are
    local, about the axes that those before have turned."""
    matrix = np.eye(3)
    if element is None:
        return matrix
    local = element.get("rotations") == "local"
    for turn in element.iter("rot"):
        step = about(turn.get("axis", "").lower(), number_of(turn.get("angle_deg", "0"), "angle_deg of <rot>"))
        matrix = matrix @ step if local else step @ matrix
    return matrix


def about(axis: str, degrees: float) -> Matrix:
    """The matrix that turns about x, y or z."""
    if axis not in ("x", "y", "z"):
        raise ValueError(f"the axis of <rot> is '{axis}', expected is x, y or z")
    return rotation(*(math.radians(degrees) if axis == each else 0.0 for each in "xyz"))


def quaternion_of(matrix: Matrix) -> list[float]:
    """[qx, qy, qz, qw] of a rotation matrix, as a drive file has it."""
    return place(np.round(adapter.quaternion(matrix), 15))


def place(values: Matrix) -> list[float]:
    """The coordinates of a point, as a drive file has them."""
    return [float(value) + 0.0 for value in values]

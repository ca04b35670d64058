# SPDX-License-Identifier: Apache-2.0
"""Assigning to the properties of the library's objects: a value of a wrong type is an error that names the property."""

from __future__ import annotations

import re
from typing import Any

from . import _gnosphere
from ._classes import classes_in


def _type_of(member: Any) -> str:
    """The type of a property in the signature of its setter, without the names of modules."""
    signature = member.fset.__nb_signature__[0][0]  # def f(self, arg: T, /) -> None
    return re.sub(r"gnosphere\._gnosphere\.|collections\.abc\.", "", signature.partition(": ")[2].rpartition(", /)")[0])


def _set(self: Any, name: str, value: Any) -> None:
    try:
        object.__setattr__(self, name, value)
    except TypeError as error:
        kind = next((base for base in type(self).__mro__ if name in vars(base)), None)
        text = str(error)
        if kind is None or not kind.__module__.startswith("gnosphere."):
            raise
        if "incompatible function arguments" in text:
            said = f"{name} must be of the type {_type_of(vars(kind)[name])}, not {value!r}"
        elif name in text:
            raise
        else:
            said = f"{name}: {text}"
        raise TypeError(f"{kind.__name__}: {said}") from None


for _module in (_gnosphere, _gnosphere.drive, _gnosphere._ros2):
    for _kind in classes_in(_module):
        if any(isinstance(member, property) and member.fset for member in vars(_kind).values()):
            setattr(_kind, "__setattr__", _set)

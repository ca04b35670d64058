# SPDX-License-Identifier: Apache-2.0
"""How the objects of the library show themselves: by their properties, but for those that are as in a new object."""

from __future__ import annotations

import enum
from typing import Any

from . import _gnosphere
from ._classes import classes_in


def _shown(value: Any) -> str:
    if hasattr(value, "dtype"):
        return f"<{' x '.join(map(str, value.shape))} {value.dtype}>"
    if isinstance(value, enum.Enum):
        return value.name
    if isinstance(value, float):
        return f"{value:g}"
    if isinstance(value, tuple) and len(value) > 4:
        return f"<{len(value)} {type(value[0]).__name__}>"
    if isinstance(value, tuple):
        return f"({', '.join(map(_shown, value))}{',' if len(value) == 1 else ''})"
    text = repr(value)
    return text if len(text) < 100 else f"<{type(value).__name__} {getattr(value, 'name', '')}".rstrip() + ">"


def _own(kind: Any) -> Any:
    """The class of the library that a class is, or is derived from."""
    return next(base for base in kind.__mro__ if base.__module__.startswith("gnosphere."))


def _properties(thing: Any) -> dict[str, str]:
    values: dict[str, Any] = {}
    for name, member in vars(_own(type(thing))).items():
        if isinstance(member, property):
            try:
                values[name] = getattr(thing, name)
            except _gnosphere.Error:  # it has no such array
                pass
    return {name: _shown(value) for name, value in values.items() if not hasattr(value, "__len__") or len(value)}


def _new(kind: Any) -> dict[str, str]:
    try:
        return _properties(kind())
    except TypeError:  # it cannot be made of nothing
        return {}


def _text(self: Any) -> str:
    new = _new(_own(type(self)))
    said = ", ".join(f"{name}={text}" for name, text in _properties(self).items() if new.get(name) != text)
    return f"{type(self).__name__}({said})"


def _simulator(self: _gnosphere.Simulator) -> str:
    try:
        return f"Simulator(device={self.device().name!r})"
    except _gnosphere.Error:
        return "Simulator(of another process)"


for _module in (_gnosphere, _gnosphere.drive, _gnosphere._ros2):
    for _kind in classes_in(_module):
        if "__repr__" not in vars(_kind):
            setattr(_kind, "__repr__", _simulator if _kind is _gnosphere.Simulator else _text)

# SPDX-License-Identifier: Apache-2.0
"""Copies, pickles and compares objects that are made of keywords, such as sensors, effects, poses and scenes.

An object is its properties: those that the constructor takes, and those that can be assigned. Results and simulators
hold memory of a device or of the library instead, so they are not copied. Answers, such as a DeviceInfo or a Plan, are
compared by all of their properties. What cannot change has a hash of its value.
"""

from __future__ import annotations

import re
from typing import Any

import numpy as np

from . import _gnosphere
from ._classes import classes_in

_RESULTS = {"Simulator", "BatchStream", "StreamedBatch", "Scan", "Batch", "Publisher"}
_keywords: dict[type, set[str]] = {}  # by class: the keywords of its constructor
_properties: dict[type, list[str]] = {}


def _state(self: Any) -> dict[str, Any]:
    kind = next(base for base in type(self).__mro__ if base in _properties)
    return {name: getattr(self, name) for name in _properties[kind]}


def _made(kind: type, state: dict[str, Any]) -> Any:
    made = kind(**{name: value for name, value in state.items() if name in _keywords[kind]})
    for name, value in state.items():
        if name not in _keywords[kind]:
            setattr(made, name, value)
    return made


def _reduce(self: Any) -> tuple[Any, ...]:
    if type(self) not in _keywords:
        raise TypeError(f"cannot copy or pickle {type(self).__name__!r}, a class derived from one of gnosphere")
    return _made, (type(self), _state(self))


def _same(one: Any, other: Any) -> bool:
    if hasattr(one, "dtype"):
        return hasattr(other, "dtype") and np.array_equal(one, other, equal_nan=one.dtype.kind == "f")
    if isinstance(one, (tuple, list)) and isinstance(other, (tuple, list)):
        return len(one) == len(other) and all(map(_same, one, other))
    return bool(one == other or (one != one and other != other))


def _equal(self: Any, other: Any) -> Any:
    if type(self) is not type(other):
        return NotImplemented
    mine, its = _state(self), _state(other)
    return all(_same(mine[name], its[name]) for name in mine)


def _key(value: Any) -> Any:
    """What is equal, and has a hash, for values that _same() takes for equal."""
    if hasattr(value, "dtype"):
        if value.flags.writeable and value.size:
            raise TypeError("unhashable: its arrays can be written")
        if value.dtype.kind == "f":
            value = np.where(np.isnan(value), np.nan, value) + 0  # NaNs have many bytes, and 0 has those of -0, too
        return value.shape, value.tobytes()
    if isinstance(value, (tuple, list)):
        return tuple(map(_key, value))
    return value if value == value else "NaN"


def _hash(self: Any) -> int:
    return hash((type(self), _key(tuple(_state(self).values()))))


def _make_comparable(kind: Any, names: list[str]) -> None:
    _properties[kind] = names
    setattr(kind, "__eq__", _equal)
    changes = any(isinstance(member, property) and member.fset for member in vars(kind).values())
    setattr(kind, "__hash__", None if changes else _hash)


def _make_value(kind: Any) -> None:
    # A class that only the library makes objects of has no constructor in its docstring.
    signatures = re.findall(r"__init__\(self.*", vars(kind)["__init__"].__doc__)
    if not signatures:
        names = [name for name, member in vars(kind).items() if isinstance(member, property)]
        if names and "__eq__" not in vars(kind):
            _make_comparable(kind, names)
        return
    keywords = {name for signature in signatures for name in re.findall(r"(\w+): ", signature)}
    properties = ((name, member) for name, member in vars(kind).items() if isinstance(member, property))
    _keywords[kind] = keywords
    _make_comparable(kind, [name for name, member in properties if member.fset or name in keywords])
    setattr(kind, "__reduce__", _reduce)


for _module in (_gnosphere, _gnosphere.drive, _gnosphere._ros2):
    for _kind in classes_in(_module):
        if _kind.__name__ not in _RESULTS:
            _make_value(_kind)

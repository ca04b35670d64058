# SPDX-License-Identifier: Apache-2.0
"""Copying, pickling and comparing what a constructor makes of keywords, as sensors, effects, poses and scenes.

An object is its properties: those that the constructor takes, and those that can be assigned. Results and simulators
hold memory of a device or of the library instead, so they are not copied.
"""

from __future__ import annotations

import enum
import re
from typing import Any

from . import _gnosphere

_NOT_VALUES = {"Simulator", "BatchStream", "Scan", "Batch"}


def _signatures(kind: Any) -> list[str]:
    """The constructors' first lines in their docstring; none if only the library makes such objects."""
    return re.findall(r"__init__\(self.*", kind.__init__.__doc__)


def _keywords(kind: type) -> set[str]:
    return {name for signature in _signatures(kind) for name in re.findall(r"(\w+): ", signature)}


def _state(self: Any) -> dict[str, Any]:
    keywords = _keywords(type(self))
    return {
        name: getattr(self, name)
        for name, kind in vars(type(self)).items()
        if isinstance(kind, property) and (kind.fset or name in keywords)
    }


def _made(kind: type, state: dict[str, Any]) -> Any:
    keywords = _keywords(kind)
    made = kind(**{name: value for name, value in state.items() if name in keywords})
    for name, value in state.items():
        if name not in keywords:
            setattr(made, name, value)
    return made


def _reduce(self: Any) -> tuple[Any, ...]:
    return _made, (type(self), _state(self))


def _same(one: Any, other: Any) -> bool:
    if hasattr(one, "dtype"):
        return bool(hasattr(other, "dtype") and one.shape == other.shape and one.tobytes() == other.tobytes())
    if isinstance(one, tuple) and isinstance(other, tuple):
        return len(one) == len(other) and all(map(_same, one, other))
    return bool(one == other or (one != one and other != other))


def _equal(self: Any, other: Any) -> Any:
    if type(self) is not type(other):
        return NotImplemented
    mine, its = _state(self), _state(other)
    return all(_same(mine[name], its[name]) for name in mine)


def _give(holder: Any) -> None:
    for kind in list(vars(holder).values()):
        if not isinstance(kind, type) or not kind.__module__.startswith("gnosphere."):
            continue
        if issubclass(kind, (enum.Enum, Exception)) or kind.__name__ in _NOT_VALUES:
            continue
        if _signatures(kind):
            setattr(kind, "__reduce__", _reduce)
            setattr(kind, "__eq__", _equal)
            setattr(kind, "__hash__", None)  # it can change
        _give(kind)


_give(_gnosphere)

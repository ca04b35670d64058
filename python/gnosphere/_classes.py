# SPDX-License-Identifier: Apache-2.0
"""The classes of the extension module, to which Python adds what is the same for all."""

from __future__ import annotations

import enum
from collections.abc import Iterator
from typing import Any


def classes_in(holder: Any) -> Iterator[Any]:
    """The classes of a module or class, and those within them, but for enumerations and errors."""
    for kind in list(vars(holder).values()):
        if isinstance(kind, type) and kind.__module__.startswith("gnosphere."):
            if not issubclass(kind, (enum.Enum, Exception)):
                yield kind
            yield from classes_in(kind)

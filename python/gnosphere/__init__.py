# SPDX-License-Identifier: Apache-2.0
"""A LiDAR simulator that never casts a ray.

Everything of the C++ face under the same names in snake_case: docs/python.md. Frames are right-handed, x forward,
y left, z up, in metres; angles are radians unless a name ends in _deg; times are seconds.
"""

import importlib as _importlib
import typing as _typing

try:
    import gnosphere_cpu as _gnosphere_cpu  # noqa: F401  the Vulkan driver that `pip install gnosphere[cpu]` brings
except ImportError:
    pass

from ._gnosphere import *
from ._gnosphere import __version__ as __version__
from . import _properties as _properties
from . import _text as _text
from . import _values as _values

if _typing.TYPE_CHECKING:
    from . import adapter as adapter, helios as helios, patterns as patterns, pictures as pictures
    from . import primitives as primitives, robotics as robotics, ros2 as ros2
else:

    def __getattr__(name):
        """Imports a module of the package that is named for the first time."""
        if name in ("adapter", "helios", "patterns", "pictures", "primitives", "robotics", "ros2"):
            return _importlib.import_module(f".{name}", __name__)
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")

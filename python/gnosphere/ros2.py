# SPDX-License-Identifier: Apache-2.0
"""Publishes messages that nodes of ROS 2 receive, without ROS: docs/ros2.md."""

import numpy as np

from ._gnosphere._ros2 import *
from ._gnosphere._ros2 import PointCloud2, PointField

_TYPES = {
    "i1": PointField.Type.i8,
    "u1": PointField.Type.u8,
    "i2": PointField.Type.i16,
    "u2": PointField.Type.u16,
    "i4": PointField.Type.i32,
    "u4": PointField.Type.u32,
    "f4": PointField.Type.f32,
    "f8": PointField.Type.f64,
}


def cloud_of_array(points: np.ndarray, frame: str, stamp: int, dense: bool = True) -> PointCloud2:
    """A cloud of an array of records, whose names and types become the fields; a row of the cloud per row of the array.
    `stamp` is in nanoseconds. Raises ValueError for an array that has no fields or more than two dimensions, and for field
    types that a PointCloud2 lacks."""
    points = np.ascontiguousarray(points)
    kinds = points.dtype.fields
    if not kinds or not points.dtype.names or points.ndim not in (1, 2):
        raise ValueError("points: an array of records with one or two dimensions is needed")
    fields = []
    for name in points.dtype.names:  # the titles of fields are further names in `kinds`
        dtype, offset = kinds[name][:2]
        base, shape = dtype.subdtype or (dtype, ())
        if base.str[1:] not in _TYPES or base.str[0] == ">":
            raise ValueError(f"points: the field {name} has the type {base}, which a PointCloud2 cannot have")
        fields.append(PointField(name, offset, _TYPES[base.str[1:]], int(np.prod(shape, dtype=int))))
    height, width = points.shape if points.ndim == 2 else (1, len(points))
    data = np.frombuffer(points.tobytes(), dtype=np.uint8)
    return PointCloud2(data, fields, points.dtype.itemsize, width, height, frame, stamp, dense)

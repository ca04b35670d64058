# SPDX-License-Identifier: Apache-2.0
"""Triangles of the shapes that engines know by their sizes: box, plane, cylinder, cone, sphere, ellipsoid, capsule,
height field.

Each function returns (vertices, faces): float32 of shape (n, 3) in metres, and uint32 of shape (m, 3), whose corners
turn counter-clockwise seen from outside. Shapes stand in the middle of their frame, round ones along its z axis. The
vertices of a curved shape lie on it, its triangles inside, nowhere deeper than `tolerance` metres. So it is too small
by up to that much, half to two thirds of it in the mean: for targets of a calibration, whose radius is fitted, give
1e-5. Sizes that are negative or not finite are a ValueError, and so is a tolerance that is not above 0, or finer than
single precision.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Union

import numpy as np
import numpy.typing as npt

from . import _gnosphere as gno

Triangles = tuple[npt.NDArray[np.float32], npt.NDArray[np.uint32]]

FEWEST_SIDES = 12
"""Even a tiny curved shape has this many sides."""


def check_tolerance(tolerance: float) -> None:
    """Raises ValueError unless a tolerance in metres is finite and above 0."""
    if not 0 < tolerance < math.inf:
        raise ValueError(f"the tolerance must be finite and above 0 m, not {tolerance}")


def _sides(radius: float, tolerance: float, bends: int = 1) -> int:
    """How many sides of a circle keep the triangles of a shape within the tolerance of its surface. The depth of a
    facet follows from the cosine of half its angle, and if the surface bends in two directions, from the product of
    both cosines."""
    check_tolerance(tolerance)
    if tolerance < 1e-7 * radius:
        raise ValueError(
            f"the tolerance {tolerance} m is finer than single precision at a radius of {radius} m; it must be "
            f"{1e-7 * radius} m or more"
        )
    share = max(0.0, 1 - tolerance / radius) if radius > 0 else 0.0
    count = max(FEWEST_SIDES, math.ceil(math.pi / math.acos(share ** (1 / bends))))
    return count + count % 2


def _result(vertices: npt.ArrayLike, faces: npt.ArrayLike) -> Triangles:
    return np.ascontiguousarray(vertices, np.float32), np.ascontiguousarray(faces, np.uint32)


def _quads(quads: npt.ArrayLike) -> npt.NDArray[np.int64]:
    """Two triangles for each row of four corners."""
    corners = np.asarray(quads, np.int64).reshape(-1, 4)
    return np.stack([corners[:, [0, 1, 2]], corners[:, [0, 2, 3]]], axis=1).reshape(-1, 3)


def _check(shape: str, sizes: npt.ArrayLike, count: int) -> None:
    """Raises ValueError unless there are `count` sizes, which are finite and not negative."""
    given = np.asarray(sizes, np.float64)
    if given.shape != (count,):
        raise ValueError(f"{shape} has {count} sizes; {given.tolist()} has the shape {given.shape}")
    if not np.all(np.isfinite(given) & (given >= 0)):
        raise ValueError(f"the sizes of {shape} must be finite and not negative, not {given.tolist()}")


def box(half: npt.ArrayLike) -> Triangles:
    """A box with these half sizes along x, y and z."""
    _check("a box", half, 3)
    signs = np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)], np.float64)
    quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    return _result(signs * np.asarray(half, np.float64), _quads(quads))


def plane(half_x: float, half_y: float, finest: float = 0.0) -> Triangles:
    """A rectangle in the plane z = 0, whose front looks along z. If `finest` is more than 0, it is divided at that
    distance from its middle and at ten times, a hundred times that distance, so that its near parts have near corners:
    single precision is then as fine near the middle as for a small rectangle."""
    _check("a plane", (half_x, half_y), 2)
    steps = [[half] for half in (half_x, half_y)]
    for cuts in steps:
        cut = finest
        while 0 < cut < cuts[0]:
            cuts.append(cut)
            cut *= 10
    x, y = ([-value for value in cuts[:1] + cuts[:0:-1]] + cuts[1:] + cuts[:1] for cuts in steps)
    grid = np.stack([*np.meshgrid(x, y), np.zeros((len(y), len(x)))], axis=-1)
    number = np.arange(grid.size // 3).reshape(len(y), len(x))
    return _result(grid.reshape(-1, 3), _quads(_cells(number)))


def _cells(number: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    """The corners of the cells of a grid of numbered vertices (rows, columns), counter-clockwise."""
    return np.stack([number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]], axis=-1)


def _around(sides: int) -> npt.NDArray[np.float64]:
    angles = 2 * math.pi * np.arange(sides) / sides
    return np.stack([np.cos(angles), np.sin(angles)], axis=1)


def _closed(rings: npt.NDArray[np.float64], low: Sequence[float], high: Sequence[float]) -> Triangles:
    """A surface through rings of vertices (rings, sides, 3), upwards, closed by a point below and a point above."""
    count, sides, _ = rings.shape
    vertices = np.concatenate([[low], rings.reshape(-1, 3), [high]])
    here = np.arange(sides)
    after = (here + 1) % sides
    top = 1 + (count - 1) * sides
    faces = [np.stack([np.zeros(sides, np.int64), 1 + after, 1 + here], axis=1)]
    for ring in range(count - 1):
        first = 1 + ring * sides
        faces.append(_quads(np.stack([first + here, first + after, first + sides + after, first + sides + here], 1)))
    faces.append(np.stack([top + here, top + after, np.full(sides, len(vertices) - 1)], axis=1))
    return _result(vertices, np.concatenate(faces))


def cylinder(radius: float, half: float, tolerance: float = 1e-3) -> Triangles:
    """A closed cylinder that reaches from z = -half to z = half; its sides are up to `tolerance` metres inside."""
    _check("a cylinder", (radius, half), 2)
    circle = _around(_sides(radius, tolerance)) * radius
    rings = np.stack([np.column_stack([circle, np.full(len(circle), z)]) for z in (-half, half)])
    return _closed(rings, [0, 0, -half], [0, 0, half])


def cone(radius: float, half: float, tolerance: float = 1e-3) -> Triangles:
    """A closed cone from z = -half, where it is widest, to its tip at z = half; its sides are up to `tolerance` metres
    inside."""
    _check("a cone", (radius, half), 2)
    circle = _around(_sides(radius, tolerance)) * radius
    rings = np.column_stack([circle, np.full(len(circle), -half)])[None]
    return _closed(rings, [0, 0, -half], [0, 0, half])


def _unit_rings(radius: float, tolerance: float) -> npt.NDArray[np.float64]:
    """The rings of a unit sphere between its poles, an odd number, whose middle one is the equator.

    A facet between two rings is farthest from the sphere at the equator: there it is at the product of the cosines of
    half its two angles, so each cosine is the root of what the tolerance leaves.
    """
    sides = _sides(radius, tolerance, bends=2)
    sides += -sides % 4
    latitudes = math.pi * np.arange(1, sides // 2) / (sides // 2) - math.pi / 2
    circle = _around(sides)
    flat = np.cos(latitudes)[:, None, None] * circle[None]
    heights = np.broadcast_to(np.sin(latitudes)[:, None, None], (*flat.shape[:2], 1))
    return np.concatenate([flat, heights], axis=2)


def ellipsoid(radii: Sequence[float], tolerance: float = 1e-3) -> Triangles:
    """An ellipsoid with these three half axes; its triangles are up to `tolerance` metres inside."""
    _check("an ellipsoid", radii, 3)
    scale = np.asarray(radii, np.float64)
    return _closed(_unit_rings(float(scale.max()), tolerance) * scale, [0, 0, -scale[2]], [0, 0, scale[2]])


def sphere(radius: float, tolerance: float = 1e-3) -> Triangles:
    """A sphere around the origin; its triangles are up to `tolerance` metres inside."""
    _check("a sphere", (radius,), 1)
    return ellipsoid((radius, radius, radius), tolerance)


def capsule(radius: float, half: float, tolerance: float = 1e-3) -> Triangles:
    """A cylinder from z = -half to z = half with a half sphere at each end; its triangles are up to `tolerance` metres
    inside."""
    _check("a capsule", (radius, half), 2)
    rings = _unit_rings(radius, tolerance) * radius
    middle = len(rings) // 2
    up = np.array([0, 0, half])
    return _closed(
        np.concatenate([rings[: middle + 1] - up, rings[middle:] + up]), [0, 0, -half - radius], [0, 0, half + radius]
    )


def height_field(heights: npt.ArrayLike, half_x: float, half_y: float, base: float) -> Triangles:
    """A block from z = -base up to heights in metres, shape (rows along y, columns along x), over a rectangle.

    A cell is divided from its corner of the least x and y to the opposite one. The sides have no corners below but those
    of the base, so that the base has two triangles. Raises ValueError for heights that are not finite or below the base,
    and for fewer than two rows or columns.
    """
    _check("a height field", (half_x, half_y, base), 3)
    z = np.asarray(heights, np.float64)
    if z.ndim != 2 or min(z.shape) < 2:
        raise ValueError(f"the heights of a height field must be two rows and columns or more, not of shape {z.shape}")
    if not np.all(np.isfinite(z)):
        raise ValueError("the heights of a height field must be finite")
    if z.min() < -base:
        raise ValueError(f"the heights of a height field must not be below its base, {-base} m, and {z.min()} m is")
    rows, columns = z.shape
    x, y = np.meshgrid(np.linspace(-half_x, half_x, columns), np.linspace(-half_y, half_y, rows))
    top = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    number = np.arange(rows * columns).reshape(rows, columns)
    rims = [number[0, :], number[:, -1], number[-1, ::-1], number[::-1, 0]]  # against the clock, seen from above
    below = np.column_stack([top[[rim[0] for rim in rims], :2], np.full(4, -base)])
    corners = len(top) + np.arange(4)
    faces = [_quads(_cells(number)), corners[[[0, 2, 1], [0, 3, 2]]]]
    vertices = np.concatenate([top, below])
    for here, after, rim in zip(corners, np.roll(corners, -1), rims):
        chain = np.concatenate([[here], rim, [after]])
        along = np.linalg.norm(vertices[chain, :2] - vertices[here, :2], axis=1)
        faces.append(chain[_under(np.column_stack([along, vertices[chain, 2]]))])
    return _result(vertices, np.concatenate(faces))


def _under(chain: npt.NDArray[np.float64]) -> npt.NDArray[np.int64]:
    """The triangles between a chain of points (x, y) whose x never falls and the line from its first point to its last,
    which no other point lies below. Every corner that is convex can be cut off (a monotone mountain)."""
    kept: list[int] = []
    found = []
    for c in range(len(chain)):
        while len(kept) > 1:
            (ux, uy), (vx, vy) = chain[kept[-1]] - chain[kept[-2]], chain[c] - chain[kept[-1]]
            if ux * vy >= uy * vx:
                break
            found.append((c, kept.pop(), kept[-1]))
        kept.append(c)
    return np.array(found, np.int64).reshape(-1, 3)


def ears(polygon: npt.ArrayLike) -> npt.NDArray[np.int64]:
    """The triangles of a polygon of n corners, shape (n, 3), which may be concave: n - 2 rows of three corners.

    One ear after the other is cut off: a convex corner whose triangle holds no other corner. A polygon that crosses
    itself has no ears at some time; its rest is a fan.
    """
    corners = np.asarray(polygon, np.float64)
    after = np.roll(corners, -1, axis=0)
    normal = np.cross(corners, after).sum(axis=0)  # Newell's
    drop = int(np.argmax(np.abs(normal)))
    flat = np.delete(corners - corners.mean(axis=0), drop, axis=1) * ([1, 1] if drop != 1 else [1, -1])
    flat = flat if normal[drop] > 0 else flat * [1, -1]

    def area(a: npt.NDArray[Any], b: npt.NDArray[Any], c: npt.NDArray[Any]) -> npt.NDArray[Any]:
        u, v = b - a, c - a
        turn: npt.NDArray[Any] = u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]
        return turn

    left, found = list(range(len(flat))), []
    while len(left) > 3:
        for i in range(len(left)):
            a, b, c = (left[(i + step) % len(left)] for step in (-1, 0, 1))
            others = flat[[j for j in left if j not in (a, b, c)]]
            inside = (area(flat[a], flat[b], others) >= 0) & (area(flat[b], flat[c], others) >= 0)
            if area(flat[a], flat[b], flat[c]) > 0 and not np.any(inside & (area(flat[c], flat[a], others) >= 0)):
                found.append((a, b, c))
                left.pop(i)
                break
        else:
            break
    return np.array(found + [(left[0], b, c) for b, c in zip(left[1:], left[2:])], np.int64)


def moved(triangles: Triangles, transform: Union[gno.Transform, npt.ArrayLike]) -> Triangles:
    """The triangles after a Transform, or a map of shape (3, 4) or (4, 4). Raises Error(invalid_argument) for another
    shape, and for a last row that is not 0, 0, 0, 1."""
    rows = (transform if isinstance(transform, gno.Transform) else gno.Transform(transform)).rows
    vertices, faces = triangles
    if np.linalg.det(rows[:3, :3]) < 0:
        faces = faces[:, ::-1]
    return _result(vertices @ rows[:3, :3].T + rows[:3, 3], faces)

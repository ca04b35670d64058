# SPDX-License-Identifier: Apache-2.0
"""What beams from one point meet, in double precision and without GnoSphere, and which answers a precision allows.

An answer of a beam is a range and an owner, or no hit. With a precision of p metres it is allowed if the beam passes
its owner's surface, or p beside it, at that range, and meets no surface further than p inside its edges before that. Where
several answers are allowed there is a tie: the beam passes within p of an edge, or two surfaces are within p.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Callable

import numpy as np

Array = Any
CHUNK = 2_000_000  # pairs of a beam and a triangle that are looked at together


@dataclass
class Answers:
    """Per beam: whether the given answer is allowed, and the nearest hit in double precision."""

    allowed: Array
    ranges: Array
    owners: Array

    @property
    def wrong(self) -> Array:
        return np.flatnonzero(~self.allowed)


@dataclass
class World:
    """Triangles and round solids, each with the number of its owner."""

    meshes: list[tuple[int, Array, bool]] = field(default_factory=list)
    solids: list[tuple[int, Callable[[Array], Array], Array, float, float]] = field(default_factory=list)

    def mesh(self, owner: int, vertices: Any, faces: Any, transform: Any = None, front_only: bool = False) -> None:
        """Triangles; with `front_only` they are there for beams that see their corners turn counter-clockwise."""
        corners = np.asarray(vertices, float)
        if transform is not None:
            rows = np.asarray(transform, float)
            corners = corners @ rows[:3, :3].T + rows[:3, 3]
        self.meshes.append((owner, corners[np.asarray(faces, int)], front_only))

    def solid(
        self, owner: int, distance: Callable[[Array], Array], transform: Any, radius: float, depth: float
    ) -> None:
        """A convex solid within `radius` of its frame's origin. `distance` is how far points of the frame are outside,
        negative inside; triangles in place of the solid lie at most `depth` inside it."""
        rows = np.asarray(transform, float)
        turn, place = rows[:3, :3], rows[:3, 3]
        self.solids.append((owner, lambda points: distance((points - place) @ turn), place, radius, depth))

    def check(self, origin: Any, directions: Any, ranges: Any, owners: Any, precision: Any, farthest: float) -> Answers:
        """Whether answers are allowed; a range that is not finite is no hit. Nothing is expected beyond `farthest`.
        `precision` is one number, or one per beam."""
        start, ways = np.asarray(origin, float), np.asarray(directions, float)
        ways = ways / np.linalg.norm(ways, axis=1, keepdims=True)
        precision = np.broadcast_to(np.asarray(precision, float), len(ways))
        state = _State(np.where(np.isfinite(ranges), ranges, np.inf), np.asarray(owners), len(ways))
        for owner, corners, front_only in self.meshes:
            self._mesh(state, owner, corners - start, front_only, ways, precision)
        for owner, distance, place, radius, depth in self.solids:
            self._solid(state, owner, distance, place, radius, depth + precision, start, ways)
        none = ~np.isfinite(state.given)
        fits = np.where(none, state.certain >= farthest, state.met & (state.given <= state.certain))
        near = state.nearest <= farthest
        return Answers(fits, np.where(near, state.nearest, np.inf), np.where(near, state.owner, -1))

    def _mesh(
        self, state: "_State", owner: int, corners: Array, front_only: bool, ways: Array, precision: Array
    ) -> None:
        middle = corners.reshape(-1, 3).mean(axis=0)
        radius = np.linalg.norm(corners.reshape(-1, 3) - middle, axis=1).max()
        beams = _near(middle, radius + precision.max(initial=0), ways)
        a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
        sides = [np.cross(b, c), np.cross(c, a), np.cross(a, b)]  # planes through the origin and an edge
        lengths = [np.linalg.norm(side, axis=1) for side in sides]
        volume = np.einsum("ij,ij->i", a, sides[0])
        normal = np.cross(b - a, c - a)
        normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
        step = max(1, CHUNK // len(corners))
        for first in range(0, len(beams), step):
            run = beams[first : first + step]
            way, fine = ways[run], precision[run, None]
            weights = [way @ side.T for side in sides]
            total = weights[0] + weights[1] + weights[2]
            with np.errstate(divide="ignore", invalid="ignore"):
                far = volume / total
                facing = np.abs(way @ normal.T)
                # How far the beam passes inside the nearest edge, across the beam; negative outside.
                inside = np.min(
                    [far * np.sign(total) * weight / length for weight, length in zip(weights, lengths)], axis=0
                )
                slack = fine * (1 + 1 / np.maximum(facing, 1e-9))
            there = (far > 0) & np.isfinite(far) & ((volume < 0) | (not front_only))
            state.note(
                run, owner, far, there & (inside >= 0), there & (inside > fine), there & (inside >= -fine), slack
            )

    def _solid(
        self,
        state: "_State",
        owner: int,
        distance: Any,
        place: Array,
        radius: float,
        slack: Array,
        start: Array,
        ways: Array,
    ) -> None:
        beams = _near(place - start, radius + slack.max(initial=0), ways)
        way, slack = ways[beams], slack[beams]
        middle = way @ (place - start)

        def outside(far: Array) -> Array:
            return distance(start + far[:, None] * way)

        low, high = np.maximum(middle - radius - slack, 0), middle + radius + slack
        for _ in range(80):  # the deepest place of a convex solid, by golden section
            third = 0.381966 * (high - low)
            left = outside(low + third) <= outside(high - third)
            low, high = np.where(left, low, low + third), np.where(left, high - third, high)
        deepest = (low + high) / 2
        depth = outside(deepest)

        def entry(level: Array) -> Array:
            """Where beams that reach the level first do."""
            near, far = np.maximum(middle - radius - slack, 0), deepest.copy()
            for _ in range(60):
                half = (near + far) / 2
                in_it = outside(half) <= level
                near, far = np.where(in_it, near, half), np.where(in_it, half, far)
            return np.where(depth <= level, far, np.inf)

        given = state.given[beams]
        with np.errstate(invalid="ignore"):
            near = np.abs(outside(np.where(np.isfinite(given), given, 0))) <= slack
        certain, exact = entry(-slack), entry(np.zeros(len(beams)))
        state.met[beams] |= np.isfinite(given) & near & (state.claimed[beams] == owner) & (given <= certain + slack)
        state.certain[beams] = np.minimum(state.certain[beams], certain + slack)
        closer = exact < state.nearest[beams]
        state.nearest[beams[closer]], state.owner[beams[closer]] = exact[closer], owner


class _State:
    def __init__(self, given: Array, claimed: Array, count: int) -> None:
        self.given, self.claimed = given, claimed
        self.met = np.zeros(count, bool)
        self.certain = np.full(count, np.inf)  # no allowed range is more
        self.nearest, self.owner = np.full(count, np.inf), np.full(count, -1)

    def note(self, run: Array, owner: int, far: Array, hit: Array, sure: Array, touched: Array, slack: Array) -> None:
        given = self.given[run][:, None]
        with np.errstate(invalid="ignore"):
            fits = touched & (np.abs(far - given) <= slack)
        self.met[run] |= fits.any(axis=1) & (self.claimed[run] == owner)
        self.certain[run] = np.minimum(self.certain[run], np.where(sure, far + slack, np.inf).min(axis=1))
        exact = np.where(hit, far, np.inf).min(axis=1)
        closer = exact < self.nearest[run]
        self.nearest[run[closer]], self.owner[run[closer]] = exact[closer], owner


def _near(middle: Array, radius: float, ways: Array) -> Array:
    """The beams that pass the origin-centred ball's place within the radius."""
    along = ways @ middle
    across = np.sqrt(np.maximum(middle @ middle - along**2, 0))
    return np.flatnonzero((across <= radius + 1e-9 * (1 + np.linalg.norm(middle))) & (along > -radius))


def box(half: Any) -> Callable[[Array], Array]:
    sizes = np.asarray(half, float)

    def distance(points: Array) -> Array:
        beyond = np.abs(points) - sizes
        return np.linalg.norm(np.maximum(beyond, 0), axis=1) + np.minimum(beyond.max(axis=1), 0)

    return distance


def sphere(radius: float) -> Callable[[Array], Array]:
    return lambda points: np.linalg.norm(points, axis=1) - radius


def capsule(radius: float, half: float) -> Callable[[Array], Array]:
    return lambda points: (
        np.hypot(np.hypot(points[:, 0], points[:, 1]), np.maximum(np.abs(points[:, 2]) - half, 0)) - radius
    )


def cylinder(radius: float, half: float) -> Callable[[Array], Array]:
    def distance(points: Array) -> Array:
        beyond = np.stack([np.hypot(points[:, 0], points[:, 1]) - radius, np.abs(points[:, 2]) - half], axis=1)
        return np.linalg.norm(np.maximum(beyond, 0), axis=1) + np.minimum(beyond.max(axis=1), 0)

    return distance


def ellipsoid(radii: Any) -> Callable[[Array], Array]:
    """Not the distance, but within a share of it near the surface: the level times its slope."""
    sizes = np.asarray(radii, float)

    def distance(points: Array) -> Array:
        level = np.linalg.norm(points / sizes, axis=1)
        slope = np.linalg.norm(points / sizes**2, axis=1)
        return level * (level - 1) / np.maximum(slope, 1e-300)

    return distance

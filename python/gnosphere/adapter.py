# SPDX-License-Identifier: Apache-2.0
"""What stands between a physics or graphics engine and GnoSphere: shapes in, poses per frame in, arrays out.

An adapter of an engine collects its shapes once (`Shapes`), says in each frame where they are (`Lidar.move`), and scans
by a Shot (`Lidar.cast`). See gnosphere.mujoco, and the modules of gnosphere.engines, about 100 lines each.
"""

from __future__ import annotations

import fnmatch
import warnings
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Optional, TypeVar, Union

import numpy as np
import numpy.typing as npt

from . import _gnosphere as gno
from . import primitives

Array = npt.NDArray[Any]
Fields = Union[str, Sequence[Union[gno.Field, str]]]
Value = TypeVar("Value")

POINT_FIELD_TYPES = {"uint8": 2, "uint16": 4, "uint32": 6, "float32": 7, "float64": 8}
"""The codes of sensor_msgs/PointField."""


class Shapes:
    """Materials, meshes and instances of an engine, on the way to becoming a Scene."""

    def __init__(self) -> None:
        self._materials: list[gno.Material] = []
        self._numbers: dict[Any, int] = {}
        self._images: list[gno.AlphaImage] = []
        self._meshes: list[gno.Mesh] = []
        self.instances: list[gno.Instance] = []

    def material(
        self,
        color: Sequence[float] = (0.5, 0.5, 0.5, 1.0),
        name: str = "",
        *,
        double_sided: bool = True,
        image: Optional[gno.AlphaImage] = None,
        metallic: float = 0.0,
        roughness: float = 1.0,
        alpha_cutoff: Optional[float] = None,
    ) -> int:
        """The number of a material; equal ones are one. `color` is red, green, blue and, if it has it, alpha: less
        than 1 lets light pass. It is taken as linear reflectance, and a MaterialTable may say better by `name`.
        `image` cuts holes; the mesh then needs texture coordinates. `metallic` and `roughness` lie in 0..1. With an
        `image` or an `alpha_cutoff` no light passes, but there is a hole where the alpha is below the cut-off, which is
        0.5 unless it is given. Raises ValueError for a colour of less than 3 numbers or more than 4."""
        given = [*color]
        if len(given) not in (3, 4):
            raise ValueError(f"a colour is red, green, blue and perhaps alpha; {given} has {len(given)} numbers")
        rgba = tuple(float(value) for value in np.clip([*given, 1.0][:4], 0, 1))
        metallic, roughness = (float(value) for value in np.clip([metallic, roughness], 0, 1))
        key = (
            rgba, name, double_sided, id(image) if image is not None else None, metallic, roughness, alpha_cutoff,
        )  # fmt: skip
        if key not in self._numbers:
            masked = image is not None or alpha_cutoff is not None
            mode = gno.AlphaMode.mask if masked else gno.AlphaMode.blend if rgba[3] < 1 else gno.AlphaMode.opaque
            if image:
                self._images.append(image)
            number = len(self._images) - 1 if image else gno.NO_IMAGE
            cutoff = 0.5 if alpha_cutoff is None else alpha_cutoff
            self._materials.append(
                gno.Material(
                    name, rgba, metallic, roughness, alpha_mode=mode, alpha_cutoff=cutoff, alpha_image=number,
                    double_sided=double_sided,
                )
            )  # fmt: skip
            self._numbers[key] = len(self._materials) - 1
        return self._numbers[key]

    def mesh(
        self,
        triangles: tuple[npt.ArrayLike, npt.ArrayLike],
        material: Union[int, npt.ArrayLike, None] = None,
        name: str = "",
        uvs: Optional[npt.ArrayLike] = None,
    ) -> int:
        """Adds a mesh and returns its index. `triangles` are vertices (n, 3) in metres, and faces (m, 3); `material`
        is the number of a material, or of one per face. Scan.triangles are the numbers of these faces. Scans are faster
        if faces of one material stand next to each other."""
        vertices, faces = triangles
        numbers = np.broadcast_to(self.material() if material is None else material, len(np.asarray(faces)))
        first = np.flatnonzero(np.diff(numbers, prepend=numbers[:1] + 1))
        counts = np.diff(first, append=len(numbers))
        parts = [gno.MeshPart(int(at), int(n), int(numbers[at])) for at, n in zip(first, counts)]
        self._meshes.append(gno.Mesh(vertices, faces, parts, uvs, name=name))
        return len(self._meshes) - 1

    def instance(
        self,
        mesh: int,
        transform: Union[gno.Transform, npt.ArrayLike, None] = None,
        class_id: int = 0,
        name: str = "",
        class_name: str = "",
        world: int = 0,
    ) -> int:
        """Places a mesh and returns the index of the instance. `transform` is a Transform, or a map of shape
        (3, 4) or (4, 4); `class_name` is the class that a file states by its name; `world` is as in Instance. Raises
        Error(invalid_argument) for a map of another shape, and for a last row that is not 0, 0, 0, 1."""
        place = gno.Transform() if transform is None else transform
        made = gno.Instance(mesh, place, class_id, name, world)
        made.class_name = class_name
        self.instances.append(made)
        return len(self.instances) - 1

    def scene(self) -> gno.Scene:
        """What has been added, as a scene."""
        return gno.Scene(self._materials, self._meshes, self.instances, self._images)


class Lidar:
    """Sensors in a scene that an engine moves."""

    def __init__(
        self,
        shapes: Shapes,
        sensor: Union[str, gno.Sensor],
        *,
        effects: Optional[gno.Effects] = None,
        fields: Fields = (),
        ignore: Iterable[int] = (),
        options: Optional[gno.SimulatorOptions] = None,
    ) -> None:
        """`sensor` is a Sensor or the name of a built-in one; `fields` are names such as "intensity,ring", or
        a sequence of Field or names; `ignore` are instances that the sensor does not see, such as the robot that
        carries it."""
        request = _request(sensor, effects, fields, ignore)
        self.sensors = [request.sensor]
        self.simulator = gno.Simulator(shapes.scene(), request, options or gno.SimulatorOptions())
        self.frames = [0]  # the number of the next scan of each sensor
        self._all = np.arange(len(shapes.instances), dtype=np.uint32)

    def add_sensor(
        self,
        sensor: Union[str, gno.Sensor],
        *,
        effects: Optional[gno.Effects] = None,
        fields: Fields = (),
        ignore: Iterable[int] = (),
    ) -> int:
        """Adds a sensor to the same scene and returns its number, for Shot.sensor."""
        request = _request(sensor, effects, fields, ignore)
        number = self.simulator.add_sensor(request)
        self.sensors[number : number + 1] = [request.sensor]  # a number that was removed is given again
        self.frames[number : number + 1] = [0]
        return number

    def move(
        self, transforms: Union[npt.ArrayLike, Sequence[gno.Transform]], instances: Optional[npt.ArrayLike] = None
    ) -> None:
        """Moves the instances, all of them by default: maps to the world, as Transforms or of shape (n, 3, 4) or
        (n, 4, 4), or poses of shape (n, 7), position x, y, z in metres and quaternion x, y, z, w."""
        self.simulator.set_transforms(self._all if instances is None else instances, transforms)

    def cast(self, shot: gno.Shot, into: Optional[gno.Scan] = None) -> gno.Scan:
        """Scans what stands where move() has put it. Arrays of `into` are used again, unless a view of them is held."""
        scan = gno.Scan() if into is None else into
        self.simulator.scan_into(shot, scan)
        self.frames[shot.sensor] += 1
        return scan

    def _scan_at(
        self, maps: Union[npt.ArrayLike, Sequence[gno.Transform]], pose: gno.Pose, sensor: int, into: Optional[gno.Scan]
    ) -> gno.Scan:
        """Scans from a pose, with all instances, of which there may be none, where the maps of move() put them."""
        if len(self._all):
            self.move(maps)
        return self.cast(gno.Shot(pose, sensor, self.frames[sensor]), into)


def _request(
    sensor: Union[str, gno.Sensor], effects: Optional[gno.Effects], fields: Fields, ignore: Iterable[int]
) -> gno.SensorRequest:
    chosen = gno.builtin_sensor(sensor) if isinstance(sensor, str) else sensor
    return gno.SensorRequest(chosen, effects or gno.Effects(), fields, ignored_instances=[int(i) for i in ignore])


def pose_of(position: npt.ArrayLike, orientation: Optional[npt.ArrayLike] = None) -> gno.Pose:
    """A pose from a position and a quaternion x, y, z, w, by default 0, 0, 0, 1, or a rotation matrix (3, 3) that maps
    to the world; or from a rigid map (4, 4) or (3, 4) to the world alone: pose_of(matrix). Raises ValueError for arrays
    of other shapes or with masked entries, and for a matrix that is no rotation within 0.001: one that scales, shears or
    mirrors."""
    if np.ma.is_masked(position) or np.ma.is_masked(orientation):
        raise ValueError("a pose has masked entries; numpy.ma.filled() gives them values")
    place = np.asarray(position, np.float64)
    if place.ndim == 2 and orientation is None:
        if place.shape not in ((3, 4), (4, 4)):
            raise ValueError(f"the map of a pose has the shape {place.shape}; it must be (4, 4) or (3, 4)")
        if len(place) == 4 and not np.array_equal(place[3], (0, 0, 0, 1)):
            raise ValueError(f"the last row of the map of a pose is {place[3].tolist()}; it must be [0, 0, 0, 1]")
        place, orientation = place[:3, 3], place[:3, :3]
    turn = np.asarray((0, 0, 0, 1) if orientation is None else orientation, np.float64)
    if place.shape != (3,):
        raise ValueError(f"the position of a pose has the shape {place.shape}; it must be (3,): x, y, z in metres")
    if turn.shape == (3, 3):
        if not np.allclose(turn.T @ turn, np.eye(3), rtol=0, atol=1e-3) or not np.linalg.det(turn) > 0:
            raise ValueError("the matrix of a pose is no rotation: it scales, shears or mirrors, or is not finite")
        turn = quaternion(turn)
    if turn.shape != (4,):
        raise ValueError(
            f"the orientation of a pose has the shape {turn.shape}; it must be (4,), a quaternion x, y, z, w, or "
            "(3, 3), a rotation matrix; a map of shape (4, 4) is given alone, as pose_of(map)"
        )
    return gno.Pose(tuple(map(float, place)), tuple(map(float, turn)))


def quaternion(matrix: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """The quaternion x, y, z, w of a rotation matrix (3, 3): the eigenvector of the largest eigenvalue
    (Bar-Itzhack)."""
    m = np.asarray(matrix, np.float64)
    k = np.array(
        [
            [m[0, 0] - m[1, 1] - m[2, 2], m[1, 0] + m[0, 1], m[2, 0] + m[0, 2], m[2, 1] - m[1, 2]],
            [0, m[1, 1] - m[0, 0] - m[2, 2], m[2, 1] + m[1, 2], m[0, 2] - m[2, 0]],
            [0, 0, m[2, 2] - m[0, 0] - m[1, 1], m[1, 0] - m[0, 1]],
            [0, 0, 0, m[0, 0] + m[1, 1] + m[2, 2]],
        ]
    )
    q: npt.NDArray[np.float64] = np.linalg.eigh(k, UPLO="U")[1][:, 3]
    return q if q[3] >= 0 else -q


def rows_of(pose: gno.Pose) -> npt.NDArray[np.float64]:
    """The map (4, 4) from the frame of a pose to the world."""
    x, y, z, w = np.asarray(pose.orientation) / np.linalg.norm(pose.orientation)
    result = np.eye(4)
    result[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    result[:3, 3] = pose.position
    return result


def rays_of(sensor: gno.Sensor, shot: gno.Shot) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """The rays of all beams of a scan in the world: where they start, in metres, and their unit vectors, each of shape
    (beams, 3), float64, in the order of the beams. A return at `range` is at origin + range * direction, also in a scan
    that is not deskewed; noise of the angles is left out. Every beam leaves from where the motion of the shot has the
    sensor when the beam fires: positions are linear between stamps, and orientations turn by slerp. Where a scan ignores
    the motion, because sensor-motion is off, give a shot without one; sensors whose beams fire at once stand at its pose.
    `shot.frame` chooses the pattern of a list of beams.
    """
    beams = gno.beams_of(sensor, shot.frame)
    stamps = shot.motion.stamps if len(beams.times) else ()
    if stamps:
        positions, orientations = _poses_at(stamps, beams.times)
    else:
        positions, orientations = np.array([shot.pose.position]), _units(np.array([shot.pose.orientation]))
    origins = np.broadcast_to(positions, beams.directions.shape).copy()
    if len(beams.origins):
        origins += _turned(orientations, beams.origins)
    return origins, _turned(orientations, _units(beams.directions))


def _units(vectors: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    units: npt.NDArray[np.float64] = vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
    return units


def _turned(quaternions: npt.NDArray[np.float64], vectors: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """The vectors (n, 3), each turned by a quaternion of length 1, or all by the same one."""
    axes, w = quaternions[:, :3], quaternions[:, 3:]
    across = 2 * np.cross(axes, vectors)
    turned: npt.NDArray[np.float64] = vectors + w * across + np.cross(axes, across)
    return turned


def _poses_at(
    stamps: Sequence[gno.SensorMotion.Stamp], times: npt.NDArray[np.float64]
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Positions (n, 3) and unit quaternions (n, 4) of a motion at times, as scans have them: constant before the first
    and after the last stamp, and along the shorter arc between two."""
    positions = np.array([stamp.pose.position for stamp in stamps])
    orientations = _units(np.array([stamp.pose.orientation for stamp in stamps]))
    places = np.interp(times, [stamp.time for stamp in stamps], np.arange(len(stamps)))
    before = places.astype(np.int64)
    after = np.minimum(before + 1, len(stamps) - 1)
    share = (places - before)[:, None]
    a, b = orientations[before], orientations[after]
    b = np.where((a * b).sum(axis=1, keepdims=True) < 0, -b, b)
    # The angle between both follows from their difference, because that is accurate for small angles.
    angle = 2 * np.arcsin(np.minimum(np.linalg.norm(b - a, axis=1, keepdims=True) / 2, 1))
    near = angle < 1e-9
    sine = np.where(near, 1, np.sin(angle))
    between = np.where(near, 1 - share, np.sin((1 - share) * angle) / sine) * a
    between += np.where(near, share, np.sin(share * angle) / sine) * b
    return (1 - share) * positions[before] + share * positions[after], _units(between)


def upright(normal: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """A map (4, 4) that turns the z axis to a normal of any length above 0 by the least angle, about the axis across
    both; about x if the normal is opposite to z. Gazebo turns planes so."""
    z = np.asarray(normal, np.float64)
    if not np.linalg.norm(z) > 0:
        raise ValueError("a normal must have a length above 0")
    half = z / np.linalg.norm(z) + [0, 0, 1]
    square = half @ half
    result = np.eye(4)
    if square < 2e-6:  # where Gazebo takes the normal as opposite
        result[:3, :3] = np.diag([1.0, -1.0, -1.0])
    else:  # half a turn about z, and half a turn about the middle of z and the normal
        result[:3, :3] = (2 / square * np.outer(half, half) - np.eye(3)) * [-1, -1, 1]
    return result


def class_of(classes: Optional[Mapping[str, int]], *names: str) -> int:
    """The class of the longest pattern (as of a shell) that one of the names fits, of the last one among equally long
    patterns; 0 if none does."""
    return of_longest_pattern(classes or {}, *names) or 0


def of_longest_pattern(values: Mapping[str, Value], *names: str) -> Optional[Value]:
    """The value of the longest pattern (as of a shell) that one of the names fits, of the last one among equally long
    patterns; none if none does. Drive files choose their classes by the same rule."""
    fitting = [p for p in values if any(fnmatch.fnmatchcase(name, p) for name in names if name)]
    return values[max(reversed(fitting), key=len)] if fitting else None


def warn_left_out(who: str, left_out: Mapping[str, int], stacklevel: int = 2) -> None:
    """One warning that names all that a scene lacks, with how often; none if nothing is left out."""
    if left_out:
        listed = ", ".join(f"{what} ({count})" for what, count in left_out.items())
        warnings.warn(f"{who} leaves out {listed}", stacklevel=stacklevel + 1)


def records(scan: gno.Scan, fields: Fields = "x,y,z") -> Array:
    """The returns of a scan as one structured array, a value of the type per field, with the names that the columns of
    write_cloud() have. Fields beyond x, y, z, range, triangle and instance must have been asked for when the sensor was
    made."""
    chosen = gno.parse_fields(fields)
    layout = gno.layout_of(chosen)
    layout.compact = True
    formats = []
    for info in map(gno.field_info, chosen):
        kind = {"f": "float", "u": "uint"}[info.type.name[0]] + info.type.name[1:]
        formats += [kind] * info.components
    result = np.empty(len(scan.ranges), np.dtype(list(zip(gno._column_names(chosen), formats))))
    return result[: gno.pack(scan, layout, result.view(np.uint8))]


def point_cloud2(
    scan: gno.Scan, fields: Fields = "x,y,z", *, frame_id: str = "lidar", stamp: float = 0.0
) -> dict[str, Any]:
    """The returns of a scan as the members of sensor_msgs/PointCloud2; `data` is an array of bytes. `stamp` is in seconds
    (gnosphere.ros2 takes nanoseconds). Needs no ROS."""
    rows = records(scan, fields)
    places: Mapping[str, Any] = rows.dtype.fields or {}
    return {
        "header": header(frame_id, stamp),
        "height": 1,
        "width": len(rows),
        "fields": [
            {"name": name, "offset": offset, "datatype": POINT_FIELD_TYPES[kind.name], "count": 1}
            for name, (kind, offset) in ((name, places[name][:2]) for name in rows.dtype.names or ())
        ],
        "is_bigendian": False,
        "point_step": rows.dtype.itemsize,
        "row_step": rows.dtype.itemsize * len(rows),
        "data": rows.view(np.uint8).reshape(-1),
        "is_dense": True,
    }


def laser_scan(
    scan: gno.Scan,
    sensor: gno.Sensor,
    channel: int = 0,
    *,
    frame_id: str = "lidar",
    stamp: float = 0.0,
    frame: Optional[int] = None,
) -> dict[str, Any]:
    """One channel of a scan as the members of sensor_msgs/LaserScan, in the order in which its beams fire: clockwise if
    `angle_increment` is less than 0. `stamp` is the time of its first beam in seconds. Beams that fire in another order
    than that of their azimuths are sorted by azimuth, and have a `time_increment` of 0. As REP 117 wants it, a beam
    without a return has infinity, and one that the sensor masks NaN; with the field `cause` one that is dead, whose
    return was lost at random, or whose echoes Effects.Returns.mode does not choose has NaN, too, and one that a surface
    nearer than its least range blocks has -infinity. Beams on both sides of 180 degrees have angles beyond it, without
    a gap. `frame` is the number of the scan (Shot.frame), which a sensor with several patterns needs. Raises ValueError
    for a channel that the scan does not have, for a scan of another sensor, and if its beams are not evenly spaced in
    azimuth."""
    if (scan.columns, scan.channels) != (sensor.width(), sensor.height()):
        raise ValueError(
            f"the scan has {scan.channels} x {scan.columns} beams, and the sensor {sensor.name} has {sensor.height()} x "
            f"{sensor.width()}: it is a scan of another sensor"
        )
    if len(sensor.patterns) > 1 and frame is None:
        raise ValueError(
            f"the sensor {sensor.name} has {len(sensor.patterns)} patterns; `frame` chooses that of the scan"
        )
    if not 0 <= channel < scan.channels:
        raise ValueError(f"there is no channel {channel}; the scan has {scan.channels}, counted from 0")
    columns = scan.columns
    entries = slice(channel * columns * scan.returns, (channel + 1) * columns * scan.returns, scan.returns)
    beams = gno.beams_of(sensor, frame or 0)

    def own(values: npt.NDArray[Any]) -> npt.NDArray[Any]:
        return values[channel * columns : (channel + 1) * columns]

    directions = own(beams.directions).astype(np.float64)
    azimuths = np.arctan2(directions[:, 1], directions[:, 0])
    times = own(beams.times) if len(beams.times) else np.zeros(columns)
    # A head fires beam by beam in the order of azimuth. Other beams are sorted by azimuth, and have no time increment.
    order = np.argsort(times, kind="stable")
    angles = np.unwrap(azimuths[order])
    increment = float(np.ptp(times)) / max(columns - 1, 1)
    if len(angles) > 1 and np.ptp(np.diff(angles)) > 1e-4:
        order, increment = _around(azimuths), 0.0
        angles = np.unwrap(azimuths[order])
    steps = np.diff(angles)
    if len(steps) and np.ptp(steps) > 1e-4:
        raise ValueError(f"the beams of channel {channel} are not evenly spaced, so they are no LaserScan")
    ranges = scan.ranges[entries][order]
    invalid = np.isin(order + channel * columns, sensor.masked_beams)
    nothing = np.full(columns, np.inf, np.float32)
    if scan.has(gno.Field.cause):
        causes = scan.column(gno.Field.cause)[entries][order]
        lost = [gno.Cause.dead, gno.Cause.dropped_out, gno.Cause.not_chosen]
        invalid |= np.isin(causes, [int(cause) for cause in lost])
        nothing[causes == int(gno.Cause.too_near)] = -np.inf
    nearest, farthest = own(beams.range_min), own(beams.range_max)
    message: dict[str, Any] = {
        "header": header(frame_id, stamp),
        "angle_min": float(angles[0]),
        "angle_max": float(angles[-1]),
        "angle_increment": float(steps.mean()) if len(steps) else 0.0,
        "time_increment": increment,
        "scan_time": sensor.scan_period or sensor.rotation_period or float(np.max(beams.times, initial=0)),
        "range_min": float(nearest.min()) if len(nearest) else sensor.range_min,
        "range_max": float(farthest.max()) if len(farthest) else sensor.range_max,
        "ranges": np.where(np.isnan(ranges) & ~invalid, nothing, ranges),
        "intensities": np.empty(0, np.float32),
    }
    if scan.has(gno.Field.intensity):
        message["intensities"] = np.nan_to_num(scan.column(gno.Field.intensity)[entries][order])
    return message


def _around(azimuths: npt.NDArray[np.float64]) -> npt.NDArray[np.int64]:
    """The order of azimuths counter-clockwise, from behind the widest gap between two of them."""
    order = np.argsort(azimuths, kind="stable")
    ascending = azimuths[order]
    gaps = np.diff(ascending, append=ascending[:1] + 2 * np.pi)
    return np.roll(order, -1 - int(np.argmax(gaps))) if len(gaps) and gaps.max() > gaps[-1] + 1e-4 else order


def header(frame_id: str, stamp: float) -> dict[str, Any]:
    """The members of std_msgs/Header; `stamp` is in seconds."""
    nanoseconds = round(stamp * 1e9)
    return {"stamp": {"sec": nanoseconds // 10**9, "nanosec": nanoseconds % 10**9}, "frame_id": frame_id}


def load_mesh(file: Union[str, Path], scale: Union[float, Sequence[float]] = 1.0) -> primitives.Triangles:
    """The triangles of a file that load_scene() reads, all in one mesh, as the file has its axes if it is OBJ, PLY or
    STL."""
    scene = gno.load_scene(file)
    placed = []
    for instance in scene.instances:
        mesh = scene.meshes[instance.mesh]
        corners = mesh.positions + np.array(mesh.origin)
        placed.append(primitives.moved((corners, mesh.indices), instance.transform.rows))
    sizes = np.broadcast_to(np.asarray(scale, np.float64), 3)
    return primitives.moved(joined(placed, str(file)), np.column_stack([np.diag(sizes), np.zeros(3)]))


def joined(parts: Iterable[primitives.Triangles], name: str) -> primitives.Triangles:
    """The triangles of several meshes in one. Raises ValueError with the name if they have no corner."""
    vertices, faces, count = [], [], 0
    for corners, triangles in parts:
        vertices.append(corners)
        faces.append(triangles + np.uint32(count))
        count += len(corners)
    if not count:
        raise ValueError(f"{name} has no triangles")
    return np.concatenate(vertices), np.concatenate(faces)

# SPDX-License-Identifier: Apache-2.0
"""The triangles of shapes, and what an engine hands in and gets out."""

import re

import numpy as np
import pytest
from conftest import REPOSITORY, beams

import gnosphere
from gnosphere import adapter, primitives


def volume(triangles) -> float:
    vertices, faces = triangles
    a, b, c = (vertices[faces[:, k]].astype(float) for k in range(3))
    return float(np.sum(np.cross(a, b) * c) / 6)


def is_closed(triangles) -> bool:
    """Whether every edge belongs to two triangles that run along it in opposite directions."""
    faces = triangles[1].astype(np.int64)
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    edges = edges[edges[:, 0] != edges[:, 1]]
    forth, back = (np.sort(a * len(triangles[0]) + b) for a, b in (edges.T, edges[:, ::-1].T))
    return bool((np.diff(forth) > 0).all()) and np.array_equal(forth, back)


def depth(triangles, surface) -> float:
    """How far points of the triangles are from a surface of the given signed distance, at most."""
    vertices, faces = triangles
    weights = np.random.default_rng(0).dirichlet((1, 1, 1), 10)
    points = np.einsum("kc,fcd->fkd", np.concatenate([weights, [[1 / 3] * 3, [0.5, 0.5, 0]]]), vertices[faces])
    return float(np.abs(surface(points.reshape(-1, 3).astype(float))).max())


def segment(points, half):
    return np.linalg.norm(points - np.clip(points, [0, 0, -half], [0, 0, half]), axis=1)


@pytest.mark.parametrize("radius", [0.01, 0.3, 5.0])
@pytest.mark.parametrize("tolerance", [1e-2, 1e-3, 1e-4])
def test_curved_shapes_stay_within_their_tolerance(radius, tolerance):
    sphere = primitives.sphere(radius, tolerance)
    capsule = primitives.capsule(radius, 0.7, tolerance)
    cylinder = primitives.cylinder(radius, 0.7, tolerance)
    rounding = 1e-6 * (1 + radius)
    assert depth(sphere, lambda p: np.linalg.norm(p, axis=1) - radius) <= tolerance + rounding
    assert depth(capsule, lambda p: segment(p, 0.7) - radius) <= tolerance + rounding

    def side(p):
        return np.where(np.abs(np.abs(p[:, 2]) - 0.7) < 1e-6, 0, np.linalg.norm(p[:, :2], axis=1) - radius)

    assert depth(cylinder, side) <= tolerance + rounding
    for triangles in (sphere, capsule, cylinder):
        assert is_closed(triangles) and volume(triangles) > 0
        assert (triangles[0].dtype, triangles[1].dtype) == (np.float32, np.uint32)


def test_an_ellipsoid_stays_within_its_tolerance():
    radii = np.array([0.2, 0.9, 0.5])
    triangles = primitives.ellipsoid(radii, 1e-3)
    assert is_closed(triangles)
    assert volume(triangles) == pytest.approx(4 / 3 * np.pi * radii.prod(), rel=5e-3)
    # The distance is less than that along the line to the middle.
    assert depth(triangles, lambda p: (1 - np.linalg.norm(p / radii, axis=1)) * np.linalg.norm(p, axis=1)) <= 1e-3


@pytest.mark.parametrize("make", [primitives.sphere, lambda *a: primitives.cylinder(a[0], 1, *a[1:])])
def test_tolerances_that_no_shape_can_keep(make):
    for tolerance in (0, -1, float("nan"), float("inf")):
        for radius in (0, 1):
            with pytest.raises(ValueError, match=f"the tolerance must be finite and above 0 m, not {tolerance}"):
                make(radius, tolerance)
    with pytest.raises(ValueError, match="1e-17 m is finer than single precision at a radius of 2.* m; it .* 2e-07 m"):
        make(2, 1e-17)
    assert len(make(0, 1e-17)[1]) == len(make(1e-9)[1]) == len(make(1, 5)[1]) > 0


def test_flat_shapes():
    box = primitives.box((1, 2, 3))
    assert is_closed(box) and volume(box) == pytest.approx(48)
    rows = np.eye(4)
    rows[:3, 3] = (5, 0, 0)
    rows[0, 0] = -1
    mirrored = primitives.moved(box, rows)
    assert is_closed(mirrored) and volume(mirrored) == pytest.approx(48)
    assert mirrored[0].min(axis=0) == pytest.approx([4, -2, -3])
    for plane in (primitives.plane(3, 2), primitives.plane(3000, 20, 1.0)):
        vertices, faces = plane
        a, b, c = (vertices[faces[:, k]] for k in range(3))
        normals = np.cross(b - a, c - a)
        assert np.all(normals[:, 2] > 0)
        assert normals[:, 2].sum() / 2 == pytest.approx(4 * vertices[:, 0].max() * vertices[:, 1].max())
    heights = np.random.default_rng(1).uniform(0, 2, (4, 6))
    field = primitives.height_field(heights, 3, 2, 0.5)
    assert is_closed(field)
    assert np.sum(np.all(field[0][field[1]][:, :, 2] == -0.5, axis=1)) == 2  # triangles of the base
    corners = field[0][field[1]]  # no side is folded where its rim has dips
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2
    for axis, size, length, edges in ((1, 2, 6, heights[[0, -1]]), (0, 3, 4, heights[:, [0, -1]].T)):
        for sign, edge in zip((-1, 1), edges):
            side = np.all(corners[:, :, axis] == sign * size, axis=1)
            assert np.all(sign * normals[side, axis] > 0)
            area = length * np.mean((edge[1:] + edge[:-1]) / 2 + 0.5)
            assert np.sum(sign * normals[side, axis]) == pytest.approx(area)
    cells = 4 * 3 * 2 / (5 * 3)
    lower = (heights[:-1, :-1] + heights[:-1, 1:] + heights[1:, 1:]) / 6
    upper = (heights[:-1, :-1] + heights[1:, 1:] + heights[1:, :-1]) / 6
    assert volume(field) == pytest.approx(4 * 3 * 2 * 0.5 + cells * (lower + upper).sum())


def test_a_cone_and_a_divided_plane():
    cone = primitives.cone(0.5, 2, 1e-4)
    assert is_closed(cone) and volume(cone) == pytest.approx(np.pi * 0.25 * 4 / 3, rel=1e-3)
    assert cone[0][cone[0][:, 2] == 2].tolist() == [[0, 0, 2]]  # its tip
    assert np.linalg.norm(cone[0][cone[0][:, 2] == -2][:, :2], axis=1).max() == pytest.approx(0.5)
    vertices, faces = primitives.plane(3000, 20, 1.0)
    for axis, cuts in ((0, (1, 10, 100, 1000, 3000)), (1, (1, 10, 20))):
        assert np.unique(vertices[:, axis]).tolist() == sorted([*cuts, *np.negative(cuts)])
    assert len(faces) == 2 * 9 * 5


def wall() -> adapter.Shapes:
    """A wall 0.2 m thick, and a pane before it."""
    shapes = adapter.Shapes()
    wall = shapes.mesh(primitives.box((0.1, 5, 5)), shapes.material((0.2, 0.4, 0.6), "paint"), "wall")
    shapes.instance(wall, class_id=7, name="wall")
    shapes.instance(shapes.mesh(primitives.box((0.01, 5, 5)), shapes.material((1, 1, 1, 0.3))))
    return shapes


def test_shapes_become_a_scene():
    shapes = wall()
    assert shapes.material((0.2, 0.4, 0.6), "paint") == 0  # equal materials are one
    holes = gnosphere.AlphaImage(np.zeros((2, 2), np.uint8))
    assert shapes.material(name="net", image=holes) == 2
    scene = shapes.scene()
    assert [material.alpha_mode.name for material in scene.materials] == ["opaque", "blend", "mask"]
    assert scene.materials[0].base_color == pytest.approx((0.2, 0.4, 0.6, 1))
    assert [instance.class_id for instance in scene.instances] == [7, 0]
    gnosphere.validate(scene)


def strips(count: int):
    """Strips of two faces each, side by side at x = 10 m."""
    y = np.arange(count)[:, None]
    x, y, z = np.broadcast_arrays(10.0, y + [0, 0, 1, 1], np.array([-1, 1, 1, -1]))
    faces = 4 * np.arange(count)[:, None, None] + [[0, 1, 2], [0, 2, 3]]
    return np.stack([x, y, z], axis=-1).reshape(-1, 3), faces.reshape(-1, 3)


def test_faces_keep_their_numbers_whatever_their_materials(device):
    shapes = adapter.Shapes()
    dark, bright = shapes.material((0.2, 0.2, 0.2), "dark"), shapes.material((0.9, 0.9, 0.9), "bright")
    shapes.instance(shapes.mesh(strips(4), [bright, bright, dark, dark, bright, bright, dark, dark]))
    parts = shapes.scene().meshes[0].parts
    assert [(part.first_triangle, part.triangle_count, part.material) for part in parts] == [
        (0, 2, bright), (2, 2, dark), (4, 2, bright), (6, 2, dark),
    ]  # fmt: skip
    ways = np.array([[10, k + 0.5, z] for k in range(4) for z in (0.4, -0.4)])
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    sensor = gnosphere.Sensor(range_max=100, patterns=[gnosphere.BeamList(ways)])
    lidar = adapter.Lidar(
        shapes, sensor, effects=gnosphere.Effects.none(), fields="material", options=gnosphere.SimulatorOptions(device)
    )
    scan = lidar.cast(gnosphere.Shot())
    assert scan.triangles.tolist() == list(range(8))
    assert scan["material"].tolist() == [bright, bright, dark, dark] * 2
    shapes.mesh((np.zeros((0, 3)), np.zeros((0, 3), int)))
    assert shapes.scene().meshes[1].parts == ()


def test_a_part_for_each_of_many_faces(device):
    shapes = adapter.Shapes()
    numbers = np.array([shapes.material(name="even"), shapes.material(name="odd")], np.uint8)
    mesh = shapes.mesh(strips(50000), np.tile(numbers, 50000))
    shapes.instance(mesh, [[1, 0, 0, 0], [0, 1, 0, -40000.5], [0, 0, 1, 0]])
    options = gnosphere.SimulatorOptions(device)
    lidar = adapter.Lidar(shapes, beams(1), effects=gnosphere.Effects.none(), fields="material", options=options)
    scan = lidar.cast(gnosphere.Shot())
    assert scan.triangles[0] // 2 == 40000 and scan["material"][0] == scan.triangles[0] % 2


def test_a_lidar_moves_and_scans(device, tmp_path):
    lidar = adapter.Lidar(
        wall(), beams(), effects=gnosphere.Effects.none(), fields="class,normal,barycentrics", ignore=[1],
        options=gnosphere.SimulatorOptions(device),
    )  # fmt: skip
    lidar.move(np.array([[10, 0, 0, 0, 0, 0, 1], [3, 0, 0, 0, 0, 0, 1]]))
    scan = lidar.cast(gnosphere.Shot())
    assert scan.ranges[4] == pytest.approx(9.9)
    other = lidar.add_sensor(beams(3), effects=gnosphere.Effects.none())
    assert lidar.cast(gnosphere.Shot(sensor=other)).ranges[1] == pytest.approx(2.99)
    lidar.move([[20, 0, 0, 0, 0, 0, 1]], [0])
    assert lidar.cast(gnosphere.Shot(), scan) is scan
    assert scan.ranges[4] == pytest.approx(19.9)

    rows = adapter.records(scan, "x,y,z,instance,class")
    assert rows.dtype.names == ("x", "y", "z", "instance", "class")
    assert rows["class"].tolist() == [7] * 9 and rows["x"] == pytest.approx(np.full(9, 19.9))
    several = "x,normal,barycentrics,class,return"
    gnosphere.write_cloud(scan, tmp_path / "cloud.npy", gnosphere.CloudOptions(gnosphere.parse_fields(several)))
    names = adapter.records(scan, several).dtype.names
    assert names == np.load(tmp_path / "cloud.npy").dtype.names
    assert names == ("x", "normal_x", "normal_y", "normal_z", "u", "v", "class", "return")
    cloud = adapter.point_cloud2(scan, "x,y,z,class", frame_id="mast", stamp=2.5)
    assert (cloud["width"], cloud["point_step"], cloud["row_step"]) == (9, 14, 126)
    assert cloud["fields"][3] == {"name": "class", "offset": 12, "datatype": 4, "count": 1}
    assert cloud["header"] == {"stamp": {"sec": 2, "nanosec": 500000000}, "frame_id": "mast"}
    assert cloud["data"].tobytes() == adapter.records(scan, "x,y,z,class").tobytes()

    lidar.move([[20, 5, 0, 0, 0, 0, 1]], [0])
    line = adapter.laser_scan(lidar.cast(gnosphere.Shot()), lidar.sensors[0])
    assert line["angle_min"] == pytest.approx(np.radians(-1)) and line["angle_increment"] > 0
    assert np.isinf(line["ranges"]).tolist() == [True] * 4 + [False] * 5
    uneven = gnosphere.Sensor()
    uneven.range_max = 100
    uneven.patterns = [gnosphere.BeamList([[1, 0, 0], [0.8, 0.6, 0], [0, 1, 0]])]
    with pytest.raises(ValueError, match="not evenly spaced"):
        adapter.laser_scan(lidar.cast(gnosphere.Shot(sensor=lidar.add_sensor(uneven))), uneven)


def test_a_laser_scan_is_of_its_own_sensor_and_pattern(device):
    def beams(offset):
        azimuths = np.radians(np.arange(-40, 41, 20) + offset)
        return gnosphere.BeamList(np.stack([np.cos(azimuths), np.sin(azimuths), 0 * azimuths], axis=1))

    sensor = gnosphere.Sensor(range_max=100, patterns=[beams(0), beams(10)], masked_beams=[3])
    other = gnosphere.Sensor(range_max=100, columns=4, channels=[gnosphere.Channel()])
    lidar = adapter.Lidar(wall(), sensor, effects=gnosphere.Effects.none(), options=gnosphere.SimulatorOptions(device))
    scan = lidar.cast(gnosphere.Shot(frame=1))
    line = adapter.laser_scan(scan, sensor, frame=1)
    assert np.degrees(line["angle_min"]) == pytest.approx(-30, abs=1e-4)
    assert np.isnan(line["ranges"]).tolist() == [False, False, False, True, False]
    with pytest.raises(ValueError, match="2 patterns; `frame` chooses"):
        adapter.laser_scan(scan, sensor)
    with pytest.raises(ValueError, match="a scan of another sensor"):
        adapter.laser_scan(scan, other)


@pytest.mark.parametrize(
    ("start", "span", "columns"),
    [(90, 180, 90), (170, -30, 30), (-180, 360, 360), (-179.5, 360, 360), (-90, 180, 90), (180, -360, 360), (0, -360, 36)],
)
def test_laser_scans_on_both_sides_of_180_degrees(device, start, span, columns):
    """A box at 10 degrees behind the first beam tells which range has which angle."""
    shapes = adapter.Shapes()
    half = np.radians(start) / 2
    place = adapter.rows_of(gnosphere.Pose((0, 0, 0), (0, 0, np.sin(half), np.cos(half))))
    box = primitives.box((0.02, 0.02, 5))
    step = span / columns
    at = np.copysign(np.radians(10), span)
    shapes.instance(shapes.mesh(box), place @ adapter.rows_of(gnosphere.Pose((4 * np.cos(at), 4 * np.sin(at), 0))))
    sensor = gnosphere.Sensor(
        range_max=100, columns=columns, channels=[gnosphere.Channel(range_min=3, range_max=20)], rotation_period=0.1,
        azimuth_start_deg=start, azimuth_span_deg=span,
    )  # fmt: skip
    lidar = adapter.Lidar(
        shapes, sensor, effects=gnosphere.Effects.none(), fields="time", options=gnosphere.SimulatorOptions(device)
    )
    scan = lidar.cast(gnosphere.Shot())
    line = adapter.laser_scan(scan, sensor)
    assert (np.degrees(line["angle_min"]) - start + 1) % 360 == pytest.approx(1, abs=1e-4)
    assert np.degrees(line["angle_increment"]) == pytest.approx(step, abs=1e-4)
    assert line["angle_max"] == pytest.approx(line["angle_min"] + (columns - 1) * line["angle_increment"])
    met = np.flatnonzero(np.isfinite(line["ranges"])).tolist()
    assert met == [round(10 / abs(step))]
    assert line["scan_time"] == 0.1
    sensor.scan_period = 0.125
    assert adapter.laser_scan(scan, sensor)["scan_time"] == 0.125
    assert scan.column(gnosphere.Field.time)[met[0]] == pytest.approx(met[0] * line["time_increment"], abs=1e-6)
    assert (line["range_min"], line["range_max"]) == (3, 20)
    for channel in (-1, 1):
        with pytest.raises(ValueError, match=f"there is no channel {channel}; the scan has 1, counted from 0"):
            adapter.laser_scan(scan, sensor, channel)


def test_a_laser_scan_of_beams_that_fire_in_another_order_is_sorted(device):
    azimuths = np.radians(np.r_[np.arange(-40, 41, 20), np.arange(-30, 31, 20)])
    directions = np.stack([np.cos(azimuths), np.sin(azimuths), 0 * azimuths], axis=1)
    for times in (None, np.arange(9) / 1000):
        sensor = gnosphere.Sensor(range_max=100, patterns=[gnosphere.BeamList(directions, times=times)])
        lidar = adapter.Lidar(wall(), sensor, effects=gnosphere.Effects.none(), options=gnosphere.SimulatorOptions(device))
        line = adapter.laser_scan(lidar.cast(gnosphere.Shot()), sensor)
        assert np.degrees(line["angle_min"]) == pytest.approx(-40, abs=1e-4)
        assert np.degrees(line["angle_increment"]) == pytest.approx(10, abs=1e-4)
        assert line["time_increment"] == 0


def test_sizes_that_no_shape_has():
    for make, sentence in (
        (lambda: primitives.box((1, 1, -1)), r"the sizes of a box must be finite .*, not \[1.0, 1.0, -1.0\]"),
        (lambda: primitives.box((1, 1)), r"a box has 3 sizes; \[1.0, 1.0\] has the shape \(2,\)"),
        (lambda: primitives.sphere(-1), "the sizes of a sphere must be finite and not negative"),
        (lambda: primitives.sphere(float("nan")), "the sizes of a sphere"),
        (lambda: primitives.plane(-1, 2), "the sizes of a plane"),
        (lambda: primitives.cylinder(1, -2), "the sizes of a cylinder"),
        (lambda: primitives.cone(-1, 2), "the sizes of a cone"),
        (lambda: primitives.capsule(-1, 2), "the sizes of a capsule"),
        (lambda: primitives.ellipsoid((1, float("inf"), 1)), "the sizes of an ellipsoid"),
        (lambda: primitives.height_field(np.zeros((2, 2)), -1, 1, 1), "the sizes of a height field"),
        (lambda: primitives.height_field(np.zeros((2, 2)), 1, float("nan"), 1), "the sizes of a height field"),
        (lambda: primitives.height_field(np.zeros((2, 2)), 1, 1, -5), "the sizes of a height field"),
        (lambda: primitives.height_field([[0, np.nan], [0, 0]], 1, 1, 1), "the heights of a height field must be fin"),
        (lambda: primitives.height_field([0, 0], 1, 1, 1), r"two rows and columns or more, not of shape \(2,\)"),
    ):
        with pytest.raises(ValueError, match=sentence):
            make()
    assert len(primitives.box((0, 1, 1))[1]) == 12


def test_a_lidar_moves_by_transforms(device):
    lidar = adapter.Lidar(wall(), beams(), effects=gnosphere.Effects.none(), options=gnosphere.SimulatorOptions(device))
    far = gnosphere.Transform([[1, 0, 0, 20], [0, 1, 0, 0], [0, 0, 1, 0]])
    lidar.move([far, gnosphere.Transform([[1, 0, 0, 6], [0, 1, 0, 0], [0, 0, 1, 0]])])
    assert lidar.cast(gnosphere.Shot()).ranges[4] == pytest.approx(5.99)


def test_the_sensors_behind_a_number_that_is_given_again_stay(device):
    options = gnosphere.SimulatorOptions(device)
    lidar = adapter.Lidar(wall(), beams(2), effects=gnosphere.Effects.none(), options=options)
    for count in (3, 4):
        lidar.add_sensor(beams(count), effects=gnosphere.Effects.none())
    lidar.cast(gnosphere.Shot(sensor=2))
    lidar.simulator.remove_sensor(1)
    assert lidar.add_sensor(beams(5), effects=gnosphere.Effects.none()) == 1
    assert [lidar.cast(gnosphere.Shot(sensor=number)).beam_count() for number in range(3)] == [2, 5, 4]
    assert [sensor.beam_count() for sensor in lidar.sensors] == [2, 5, 4] and lidar.frames == [1, 1, 2]


def test_poses_of_matrices():
    generator = np.random.default_rng(2)
    for _ in range(50):
        turn = generator.normal(size=4)
        matrix = adapter.rows_of(gnosphere.Pose((1, 2, 3), tuple(turn)))
        assert np.linalg.det(matrix[:3, :3]) == pytest.approx(1)
        turn /= np.linalg.norm(turn) * np.sign(turn[3])
        assert adapter.quaternion(matrix[:3, :3]) == pytest.approx(turn)
        assert adapter.pose_of(matrix[:3, 3], matrix[:3, :3]).position == (1, 2, 3)
    assert adapter.class_of({"*": 1, "wall*": 3}, "", "wall-2") == 3
    assert adapter.class_of({"*street *": 40, "*street lamp *": 80}, "street lamp 1") == 80
    assert adapter.class_of({"wall*": 3, "*-two": 5, "wal??two": 0}, "wall-two") == 0  # of equally long ones the last
    assert adapter.class_of({"wall*": 3, "*pane": 4, "pan*": 7}, "wall", "pane") == 4
    assert adapter.class_of({"wall*": 3}, "floor") == adapter.class_of(None, "x") == 0


def test_the_page(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    page = (REPOSITORY / "docs" / "engines.md").read_text()
    blocks = re.findall(r"(?<!-->\n\n)^```python\n(.*?)^```$", page, re.M | re.S)
    assert len(blocks) == 1
    exec(compile(blocks[0], "docs/engines.md", "exec"), {})
    assert all(int(line.split()[0]) > 100 for line in capsys.readouterr().out.splitlines())


@pytest.mark.parametrize("deskew", (False, True))
@pytest.mark.parametrize("name", ("OS1-32:512x10", "Mid-360", "VLP-16"))
def test_rays_in_the_world_end_at_what_they_meet(name, deskew):
    """In a room of known walls, for a head that moves and turns while its beams fire, or stands because all fire at once."""
    half = np.array([9, 7, 3])
    shapes = adapter.Shapes()
    shapes.instance(shapes.mesh(primitives.box(half)))
    sensor = gnosphere.builtin_sensor(name)
    sensor.divergence_horizontal = sensor.divergence_vertical = 0
    sensor.max_returns = 1
    effects = gnosphere.Effects()
    effects.sensor_motion.deskew = deskew
    poses = [
        gnosphere.Pose((1, 2, 0.5), (0, 0, 0.1, 1)),
        gnosphere.Pose((1.5, 1.8, 0.4), (0.1, 0, -0.3, -0.9)),  # of the same sign as the others only when it is turned
        gnosphere.Pose((2.5, 1, 0.2), (0.05, -0.1, 0.6, 0.8)),
    ]
    shot = gnosphere.Shot(poses[0], frame=3)
    shot.motion = gnosphere.SensorMotion([gnosphere.SensorMotion.Stamp(t, p) for t, p in zip((0, 0.04, 0.09), poses)])
    options = gnosphere.SimulatorOptions(device="reference", warn=None)
    scan = gnosphere.Simulator(shapes.scene(), gnosphere.SensorRequest(sensor, effects), options).scan(shot)
    origins, directions = adapter.rays_of(sensor, shot)
    assert origins.shape == directions.shape == (scan.beam_count(), 3) and origins.dtype == directions.dtype == np.float64
    assert np.allclose(np.linalg.norm(directions, axis=1), 1, rtol=0, atol=1e-12)
    met = np.isfinite(scan.ranges)
    assert met.mean() > 0.9
    ends = (origins + scan.ranges[:, None] * directions)[met]
    assert np.abs(np.max(np.abs(ends) / half, axis=1) - 1).max() < 1e-4
    moved = np.ptp(origins, axis=0).max()
    assert moved > 1 if name != "VLP-16" else moved == 0
    if deskew or name == "VLP-16":
        points = scan.points.astype(float) @ adapter.rows_of(scan.pose)[:3, :3].T + scan.pose.position
        assert np.abs(points[met] - ends).max() < 2e-4


def test_rays_of_a_shot_without_motion_or_with_one_stamp_are_those_of_its_pose():
    sensor = gnosphere.builtin_sensor("OS1-32:512x10")
    pose = gnosphere.Pose((3, 4, 5), (0, 0, 2, 2))  # a quarter turn to the left
    shot = gnosphere.Shot(pose)
    beams = gnosphere.beams_of(sensor)
    turned = np.column_stack([-beams.directions[:, 1], beams.directions[:, 0], beams.directions[:, 2]])
    for motion in ([], [gnosphere.SensorMotion.Stamp(0.05, pose)]):
        shot.motion = gnosphere.SensorMotion(motion)
        origins, directions = adapter.rays_of(sensor, shot)
        assert np.allclose(directions, turned, rtol=0, atol=1e-12)
        assert np.allclose(np.linalg.norm(origins - [3, 4, 5], axis=1), np.linalg.norm(beams.origins, axis=1))

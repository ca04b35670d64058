# SPDX-License-Identifier: Apache-2.0
"""Messages and arrays of scans whose sensors have several channels, returns and causes, against closed forms."""

import numpy as np
import pytest
from conftest import at, beams

import gnosphere
from gnosphere import adapter, primitives, ros2


def room(half: float, color=(0.5, 0.5, 0.5, 1.0)) -> adapter.Shapes:
    """A cube around the origin, seen from inside."""
    shapes = adapter.Shapes()
    shapes.instance(shapes.mesh(primitives.box((half,) * 3), shapes.material(color)))
    return shapes


def rows_in_a_room(elevations, azimuths, half: float) -> np.ndarray:
    """How far the walls of room() are, a row for each elevation in degrees."""
    up, around = np.radians(elevations)[:, None], np.radians(azimuths)[None]
    ways = np.stack(np.broadcast_arrays(np.cos(up) * np.cos(around), np.cos(up) * np.sin(around), np.sin(up)))
    return half / np.abs(ways).max(axis=0)


ELEVATIONS = (-20.0, 0.0, 50.0)


def head(**settings) -> gnosphere.Sensor:
    """A head of three channels that turns clockwise from 30 degrees, in steps of 10."""
    channels = [gnosphere.Channel(up, range_max=20 + up / 10) for up in ELEVATIONS]
    return gnosphere.Sensor(
        columns=36, channels=channels, range_max=100, rotation_period=0.1, azimuth_start_deg=30, azimuth_span_deg=-360,
        **settings,
    )  # fmt: skip


def test_each_channel_of_a_head_is_a_laser_scan_of_its_own(device):
    sensor = head(masked_beams=[36 + 5])
    lidar = adapter.Lidar(
        room(4), sensor, effects=gnosphere.Effects.none(), options=gnosphere.SimulatorOptions(device)
    )  # fmt: skip
    scan = lidar.cast(gnosphere.Shot())
    expected = rows_in_a_room(ELEVATIONS, 30 - 10 * np.arange(36), 4)
    expected[1, 5] = np.nan
    for channel, (up, ranges) in enumerate(zip(ELEVATIONS, expected)):
        line = adapter.laser_scan(scan, sensor, channel, frame_id="mast", stamp=7.25)
        np.testing.assert_allclose(line["ranges"], ranges, rtol=1e-5)
        assert np.degrees([line["angle_min"], line["angle_increment"]]) == pytest.approx([30, -10], abs=1e-4)
        assert (line["range_min"], line["range_max"]) == (sensor.range_min, pytest.approx(20 + up / 10))
        assert line["header"] == {"stamp": {"sec": 7, "nanosec": 250_000_000}, "frame_id": "mast"}


def test_a_laser_scan_has_the_first_of_several_returns(device):
    shapes = room(9)
    glass = shapes.material((1, 1, 1, 0.1))
    shapes.instance(shapes.mesh(primitives.box((4, 4, 4)), glass))
    effects = gnosphere.Effects.none()
    effects.transmission.use = effects.returns.use = effects.intensity.use = gnosphere.EffectUse.on
    sensor = head(max_returns=2)
    lidar = adapter.Lidar(shapes, sensor, effects=effects, options=gnosphere.SimulatorOptions(device))
    scan = lidar.cast(gnosphere.Shot())
    assert scan.returns == 2
    for channel, ranges in enumerate(rows_in_a_room(ELEVATIONS, 30 - 10 * np.arange(36), 4)):
        line = adapter.laser_scan(scan, sensor, channel)
        np.testing.assert_allclose(line["ranges"], ranges, rtol=1e-5)


def test_laser_scans_tell_beams_that_cannot_answer_from_those_that_meet_nothing(device):
    """Beam 5 is dead, beams that look to the left meet nothing; then every return is lost at random."""
    shapes = adapter.Shapes()
    shapes.instance(shapes.mesh(primitives.box((1, 50, 50))), np.eye(4) + 20 * np.eye(4, k=3))
    azimuths = np.radians([0, 90, 30, 120, 60, -30])  # fired in this order
    directions = np.stack([np.cos(azimuths), np.sin(azimuths), 0 * azimuths], axis=1)
    sensor = gnosphere.Sensor(range_max=100, patterns=[gnosphere.BeamList(directions)])
    effects = gnosphere.Effects.none()
    effects.drop_out.use, effects.drop_out.dead_beams = gnosphere.EffectUse.on, [5]
    options = {"fields": "cause", "options": gnosphere.SimulatorOptions(device)}
    scan = adapter.Lidar(shapes, sensor, effects=effects, **options).cast(gnosphere.Shot())
    line = adapter.laser_scan(scan, sensor)
    assert np.degrees(line["angle_min"]) == pytest.approx(-30, abs=1e-4)
    expected = 19 / np.cos(np.radians([0, 30, 60]))
    np.testing.assert_allclose(line["ranges"], [np.nan, *expected, np.inf, np.inf], rtol=1e-5)
    effects.drop_out.general_rate = 1.0
    lost = adapter.laser_scan(adapter.Lidar(shapes, sensor, effects=effects, **options).cast(gnosphere.Shot()), sensor)
    assert np.isnan(lost["ranges"]).tolist() == [True] * 4 + [False] * 2


def test_the_time_of_a_list_of_beams_is_that_of_its_last_one(device):
    azimuths = np.radians(np.arange(-20, 21, 10))
    directions = np.stack([np.cos(azimuths), np.sin(azimuths), 0 * azimuths], axis=1)
    sensor = gnosphere.Sensor(range_max=100, patterns=[gnosphere.BeamList(directions, times=0.01 * np.arange(5))])
    options = gnosphere.SimulatorOptions(device)
    scan = adapter.Lidar(room(4), sensor, effects=gnosphere.Effects.none(), options=options).cast(gnosphere.Shot())
    line, message = adapter.laser_scan(scan, sensor), ros2.laser_scan_of(sensor, scan, 0, "mast", 0)
    for name, value in (("scan_time", 0.04), ("time_increment", 0.01), ("angle_min", azimuths[0])):
        assert line[name] == pytest.approx(value, rel=1e-5) and getattr(message, name) == pytest.approx(value, rel=1e-5)


def test_laser_scans_tell_what_is_too_near(device):
    """A wall 10 m ahead, beside it a box at 2 m, which is nearer than the least range of 3 m and hides the wall."""
    shapes = adapter.Shapes()
    for half, place in (((1, 50, 50), (11, 0, 0)), ((0.5, 1, 1), (2.5, 1.05, 0))):
        shapes.instance(shapes.mesh(primitives.box(half)), np.column_stack([np.eye(3), place]))
    sensor = gnosphere.Sensor(
        columns=12, channels=[gnosphere.Channel()], range_min=3, range_max=100, near_hits="hide", azimuth_start_deg=-90
    )
    ahead, beside = 10 / np.cos(np.radians([-60, -30, 0, 60])), np.full(5, np.inf)
    for fields, near in (("cause", -np.inf), ("", np.inf)):
        lidar = adapter.Lidar(
            shapes, sensor, effects=gnosphere.Effects.none(), fields=fields, options=gnosphere.SimulatorOptions(device)
        )
        scan = lidar.cast(gnosphere.Shot())
        expected = [np.inf, *ahead[:3], near, ahead[3], np.inf, *beside]
        np.testing.assert_allclose(adapter.laser_scan(scan, sensor)["ranges"], expected, rtol=1e-5)
        # As the message of gnosphere.ros2 has it.
        np.testing.assert_allclose(ros2.laser_scan_of(sensor, scan, 0, "mast", 0).ranges, expected, rtol=1e-5)


def test_the_intensities_of_a_laser_scan_belong_to_its_ranges(device):
    """Walls of two reflectances, seen by beams that fire in another order than that of their azimuths."""
    shapes = adapter.Shapes()
    for number, y in enumerate((-5, 5)):
        wall = shapes.mesh(primitives.box((1, 4.99, 50)), shapes.material((0.2 + 0.6 * number,) * 3))
        shapes.instance(wall, [[1, 0, 0, 11], [0, 1, 0, y], [0, 0, 1, 0]])
    azimuths = np.radians([30, -10, 10, -30, 50, -50])
    directions = np.stack([np.cos(azimuths), np.sin(azimuths), 0 * azimuths], axis=1)
    sensor = gnosphere.Sensor(range_max=100, patterns=[gnosphere.BeamList(directions)])
    effects = gnosphere.Effects.none()
    effects.intensity.use = gnosphere.EffectUse.on
    options = gnosphere.SimulatorOptions(device)
    scan = adapter.Lidar(shapes, sensor, effects=effects, fields="intensity", options=options).cast(gnosphere.Shot())
    line = adapter.laser_scan(scan, sensor)
    assert np.degrees(line["angle_increment"]) == pytest.approx(20, abs=1e-4)
    np.testing.assert_allclose(line["ranges"], [np.inf, *10 / np.cos(np.radians([30, 10, 10, 30])), np.inf], rtol=1e-5)
    dark, light = line["intensities"][[2, 3]]  # of the same range
    assert light > 3 * dark > 0 and line["intensities"][4] > 3 * line["intensities"][1] > 0
    assert line["intensities"][[0, 5]].tolist() == [0, 0]  # not NaN, for beams without a return


def test_beams_to_both_sides_of_180_degrees_that_fire_in_another_order(device):
    """They are sorted from behind the widest gap, which is not at 180 degrees."""
    azimuths = np.radians([-170, 160, 180, -160, 170])
    directions = np.stack([np.cos(azimuths), np.sin(azimuths), 0 * azimuths], axis=1)
    sensor = gnosphere.Sensor(range_max=100, patterns=[gnosphere.BeamList(directions)])
    lidar = adapter.Lidar(
        room(4), sensor, effects=gnosphere.Effects.none(), options=gnosphere.SimulatorOptions(device)
    )  # fmt: skip
    line = adapter.laser_scan(lidar._scan_at([at(1)], gnosphere.Pose(), 0, None), sensor)  # the room has moved
    assert np.degrees([line["angle_min"], line["angle_max"]]) % 360 == pytest.approx([160, 200], abs=1e-4)
    np.testing.assert_allclose(line["ranges"], 3 / np.cos(np.radians([20, 10, 0, 10, 20])), rtol=1e-5)


def test_records_are_of_returns_alone(device):
    shapes = adapter.Shapes()
    shapes.instance(shapes.mesh(primitives.box((1, 5, 5))), [[1, 0, 0, 11], [0, 1, 0, 5], [0, 0, 1, 0]])
    options = gnosphere.SimulatorOptions(device)
    lidar = adapter.Lidar(shapes, beams(9), effects=gnosphere.Effects.none(), options=options)
    scan = lidar.cast(gnosphere.Shot())
    met = np.flatnonzero(~np.isnan(scan.ranges))
    assert met.tolist() in ([4, 5, 6, 7, 8], [5, 6, 7, 8])  # the beam in the middle passes along an edge
    rows = adapter.records(scan, "x,y,range")
    assert rows["x"] == pytest.approx(np.full(len(met), 10))
    assert rows["y"] == pytest.approx(10 * np.tan(np.radians(np.linspace(-1, 1, 9)[met])), abs=1e-5)
    cloud = adapter.point_cloud2(scan)
    assert (cloud["width"], cloud["height"], cloud["is_dense"], cloud["is_bigendian"]) == (len(met), 1, True, False)
    assert len(cloud["data"]) == len(met) * cloud["point_step"] == cloud["row_step"]


def test_stamps_are_whole_nanoseconds():
    """Seconds in double precision are rounded, not cut: 1.1 s may be a little less than 1100 million nanoseconds."""
    for stamp, sec, nanosec in (
        (1.1, 1, 100_000_000), (0.3, 0, 300_000_000), (4.35, 4, 350_000_000), (1.9999999999, 2, 0),
        (-0.25, -1, 750_000_000),
    ):  # fmt: skip
        assert adapter.header("", stamp)["stamp"] == {"sec": sec, "nanosec": nanosec}


def test_each_sensor_counts_its_own_scans_and_has_its_own_settings(device):
    """Two patterns take turns; another sensor scans in between, and does not see what it is told to ignore."""
    turns = np.radians([0, 40])
    patterns = [gnosphere.BeamList([[np.cos(turn), np.sin(turn), 0]]) for turn in turns]
    sensor = gnosphere.Sensor(range_max=100, patterns=patterns)
    shapes = room(8)
    pane = shapes.instance(shapes.mesh(primitives.box((0.1, 0.1, 0.1))))
    options = gnosphere.SimulatorOptions(device)
    lidar = adapter.Lidar(shapes, sensor, effects=gnosphere.Effects.none(), options=options)
    places = [at(0), at(2)]
    other = lidar.add_sensor(sensor, effects=gnosphere.Effects.none(), fields="class", ignore=[pane])
    for frame in range(4):
        for number in (0, other, other):
            scan = lidar._scan_at(places, gnosphere.Pose(), number, None)
            pattern = (frame if number == 0 else 2 * frame + lidar.frames[other] % 2 ^ 1) % 2
            ahead = 1.9 if number == 0 and pattern == 0 else 8 / np.cos(turns[pattern])
            assert scan.ranges[0] == pytest.approx(ahead, rel=1e-5)
            assert scan.has(gnosphere.Field.class_id) == (number == other)
    assert lidar.frames == [4, 8]
    lidar.simulator.remove_sensor(other)
    assert lidar.add_sensor(beams(), effects=gnosphere.Effects.none()) == other
    assert lidar.frames == [4, 0] and [own.name for own in lidar.sensors] == ["", "fan"]


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (((0, 0, 0), np.diag([1, -1, 1])), "is no rotation: it scales, shears or mirrors"),
        (((0, 0, 0), np.zeros((3, 3))), "is no rotation"),
        (((0, 0, 0), 2 * np.eye(3)), "is no rotation"),
        (((0, 0, 0), [[1, 0.1, 0], [0, 1, 0], [0, 0, 1]]), "is no rotation"),
        (((0, 0, 0), np.full((3, 3), np.nan)), "is no rotation"),
        ((np.diag([1, 1, -1, 1]),), "is no rotation"),
        ((np.diag([1, 1, 1, 2]),), r"the last row of the map of a pose is \[0.0, 0.0, 0.0, 2.0\]"),
        ((np.eye(3),), r"the map of a pose has the shape \(3, 3\); it must be \(4, 4\) or \(3, 4\)"),
        (((0, 0, 0), np.eye(4)), r"the orientation of a pose has the shape \(4, 4\); .* as pose_of\(map\)"),
        (((0, 0, 0), (1, 0, 0)), r"the orientation of a pose has the shape \(3,\)"),
        (((0, 0),), r"the position of a pose has the shape \(2,\)"),
    ],
)
def test_what_is_no_pose_is_a_value_error(arguments, sentence):
    with pytest.raises(ValueError, match=sentence):
        adapter.pose_of(*arguments)


def test_a_rigid_map_is_a_pose():
    pose = gnosphere.Pose((1, 2, 3), (0.1, 0.2, 0.3, 0.9))
    rows = adapter.rows_of(pose)
    for given in (rows, rows[:3], rows.astype(np.float32), rows.tolist()):
        made = adapter.pose_of(given)
        assert made.position == (1, 2, 3)
        assert adapter.rows_of(made) == pytest.approx(rows, abs=1e-6)


def test_a_position_alone_is_a_pose_that_is_not_turned():
    assert adapter.pose_of(np.array([1, 2, 3])).orientation == (0, 0, 0, 1)
    assert adapter.pose_of((1, 2, 3), (0.1, 0.2, 0.3, 0.9)).orientation == pytest.approx((0.1, 0.2, 0.3, 0.9))


@pytest.mark.parametrize("normal", ((0, 0, 1), (0, 5, 0), (0, -1, 0), (1, 0, 0), (0.3, -0.4, -0.5)))
def test_upright_is_a_turn_that_takes_z_to_the_normal(normal):
    turn = adapter.upright(normal)
    np.testing.assert_allclose(turn[:3, :3] @ turn[:3, :3].T, np.eye(3), atol=1e-12)
    assert np.linalg.det(turn) == pytest.approx(1)
    np.testing.assert_allclose(turn @ [0, 0, 1, 0], [*np.array(normal) / np.linalg.norm(normal), 0], atol=1e-12)


def test_a_mesh_file_is_one_mesh_of_all_its_instances(tmp_path):
    """Two boxes in a file of glTF, far from its origin, each scaled and moved; then scaled again."""
    mesh = gnosphere.Mesh(*primitives.box((1, 1, 1)), [gnosphere.MeshPart(0, 12, 0)], origin=(1000, 0, 0))
    instances = [
        gnosphere.Instance(0, gnosphere.Transform([[2, 0, 0, 5], [0, 1, 0, 0], [0, 0, 1, 0]])),
        gnosphere.Instance(0, gnosphere.Transform([[1, 0, 0, 0], [0, 1, 0, 7], [0, 0, 1, 0]])),
    ]
    gnosphere.write_glb(gnosphere.Scene([gnosphere.Material()], [mesh], instances), tmp_path / "boxes.glb")
    vertices, faces = adapter.load_mesh(tmp_path / "boxes.glb", (1, 10, 1))
    assert len(faces) == 24
    found = sorted((vertices[part].min(axis=(0, 1)).tolist(), vertices[part].max(axis=(0, 1)).tolist())
                   for part in (faces[:12], faces[12:]))  # fmt: skip
    np.testing.assert_allclose(found, [[[999, 60, -1], [1001, 80, 1]], [[2003, -10, -1], [2007, 10, 1]]], atol=1e-3)


def test_a_mesh_file_far_from_its_origin(tmp_path):
    """Its coordinates are no numbers of single precision, so they are kept beside an origin."""
    (tmp_path / "far.obj").write_text("v 500000.3 0 0\nv 500001.3 0 0\nv 500000.3 2 0\nf 1 2 3\n")
    assert gnosphere.load_scene(tmp_path / "far.obj").meshes[0].origin[0] > 400000
    vertices, _ = adapter.load_mesh(tmp_path / "far.obj", 0.5)
    np.testing.assert_allclose(
        sorted(vertices.tolist()), [[250000.15, 0, 0], [250000.15, 1, 0], [250000.65, 0, 0]], atol=0.02
    )


def test_materials_of_one_colour_that_differ_otherwise_are_several():
    shapes = adapter.Shapes()
    images = [gnosphere.AlphaImage(np.full((2, 2), value, np.uint8)) for value in (0, 255)]
    numbers = [
        shapes.material((1, 0, 0)), shapes.material((1, 0, 0, 0.75)), shapes.material((1, 0, 0), double_sided=False),
        *(shapes.material((1, 0, 0), image=image) for image in images), shapes.material((1, 0, 0), image=images[0]),
        shapes.material((3, -1, 0)),
        shapes.material((1, 0, 0), "paint"),
    ]  # fmt: skip
    assert numbers == [0, 1, 2, 3, 4, 3, 0, 5]  # colours end at 0 and 1
    scene = shapes.scene()
    assert [material.double_sided for material in scene.materials] == [True, True, False, True, True, True]
    assert [material.alpha_image for material in scene.materials] == [gnosphere.NO_IMAGE] * 3 + [
        0, 1, gnosphere.NO_IMAGE,
    ]  # fmt: skip
    assert [material.alpha_mode.name for material in scene.materials] == [
        "opaque",
        "blend",
        "opaque",
        "mask",
        "mask",
        "opaque",
    ]


def test_metalness_roughness_and_cut_offs_of_materials():
    shapes = adapter.Shapes()
    numbers = [
        shapes.material((1, 0, 0)), shapes.material((1, 0, 0), metallic=0.5), shapes.material((1, 0, 0), roughness=0.5),
        shapes.material((1, 0, 0, 0.25), alpha_cutoff=0.75), shapes.material((1, 0, 0), metallic=-1, roughness=2),
    ]  # fmt: skip
    assert numbers == [0, 1, 2, 3, 0]
    materials = shapes.scene().materials
    assert [material.metallic for material in materials] == [0, 0.5, 0, 0]
    assert [material.roughness for material in materials] == [1, 1, 0.5, 1]
    assert [material.alpha_mode.name for material in materials] == ["opaque"] * 3 + ["mask"]
    assert [material.alpha_cutoff for material in materials] == [0.5] * 3 + [0.75]
    assert gnosphere.optics_of(materials[3]).transmission == 0


def test_instances_and_meshes_keep_their_names_classes_and_texture_coordinates():
    shapes = adapter.Shapes()
    uvs = [[0, 0], [1, 0], [0, 1]]
    mesh = shapes.mesh((np.eye(3), [[0, 1, 2]]), name="sheet", uvs=uvs)
    shapes.instance(mesh, name="first", class_id=3, class_name="fence", world=2)
    scene = shapes.scene()
    (instance,) = scene.instances
    assert (instance.name, instance.class_id, instance.class_name, instance.world) == ("first", 3, "fence", 2)
    assert scene.meshes[0].name == "sheet" and scene.meshes[0].uvs.tolist() == uvs


def test_effects_are_automatic_unless_they_are_given(device):
    options = gnosphere.SimulatorOptions(device)
    lidar = adapter.Lidar(room(4), "VLP-16", options=options)
    lidar.add_sensor("VLP-16")
    lidar.add_sensor("VLP-16", effects=gnosphere.Effects.none())
    for number, use in ((0, "automatic"), (1, "automatic"), (2, "off")):
        assert {decision.request.name for decision in lidar.simulator.plan(number).effects} == {use}


def test_what_is_left_out_is_told_where_the_caller_stands():
    def reader():
        adapter.warn_left_out("a reader", {"lines": 2, "points": 1})

    with pytest.warns(UserWarning, match=r"^a reader leaves out lines \(2\), points \(1\)$") as told:
        reader()
    assert len(told) == 1 and told[0].filename == __file__ and told[0].lineno == reader.__code__.co_firstlineno + 4

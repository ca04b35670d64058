# SPDX-License-Identifier: Apache-2.0
"""Scenes, sensors and effects that are changed, in Python and in a running simulator."""

import subprocess
import sys

import numpy as np
import pytest
from conftest import at, beams

import gnosphere
from gnosphere import Field

MIDDLE = 4  # the beam along x


def distance(simulator: gnosphere.Simulator, sensor: int = 0) -> float:
    return float(simulator.scan(gnosphere.Pose(), sensor).ranges[MIDDLE])


def test_instances_and_meshes_come_move_and_go(reference, square):
    assert distance(reference) == pytest.approx(10)
    reference.set_transform(0, at(20))
    assert distance(reference) == pytest.approx(20)
    mesh = reference.add_mesh(square)
    near = reference.add_instance(mesh, at(5), class_id=9)
    scan = reference.scan(gnosphere.Pose())
    assert scan.ranges[MIDDLE] == pytest.approx(5)
    assert scan.instances[MIDDLE] == near
    assert scan.column(Field.class_id)[MIDDLE] == 9
    reference.set_positions(mesh, square.positions + np.float32([1, 0, 0]))
    assert distance(reference) == pytest.approx(6)
    reference.remove_instance(near)
    reference.remove_mesh(mesh)
    assert distance(reference) == pytest.approx(20)
    with pytest.raises(gnosphere.Error, match="instance"):
        reference.set_transform(near, at(1))
    with pytest.raises(gnosphere.Error, match="mesh"):
        reference.remove_mesh(0)


def test_a_scene_is_added_and_joined(reference, square):
    car = gnosphere.Scene([gnosphere.Material()], [square], [gnosphere.Instance(mesh=0, transform=at(1), class_id=7)])
    added = reference.add_scene(car, at(4))
    assert [list(added.materials), list(added.meshes), list(added.instances)] == [[1], [1], [1]]
    scan = reference.scan(gnosphere.Pose())
    assert scan.ranges[MIDDLE] == pytest.approx(5) and scan["class"][MIDDLE] == 7
    reference.set_transforms(added.instances, [at(2) * instance.transform for instance in car.instances])
    assert distance(reference) == pytest.approx(3)
    both = gnosphere.joined(gnosphere.Scene([gnosphere.Material()], [square], [gnosphere.Instance(mesh=0)]), car, at(4))
    assert [instance.mesh for instance in both.instances] == [0, 1] and both.instances[1].transform.rows[0, 3] == 5
    with pytest.raises(gnosphere.Error, match="joined: the transform is not finite"):
        gnosphere.joined(both, car, at(float("nan")))


def test_a_device_is_chosen_by_a_word(square):
    scene = gnosphere.Scene([gnosphere.Material()], [square], [gnosphere.Instance(mesh=0)])
    for device in ("reference", gnosphere.list_devices()[-1], gnosphere.device_by_name("reference")):
        options = gnosphere.SimulatorOptions(device=device)
        assert options.device.kind == gnosphere.DeviceChoice.Kind.reference
    options.device = "auto"
    assert options.device.kind == gnosphere.DeviceChoice.Kind.vulkan
    simulator = gnosphere.Simulator(scene, beams(5), gnosphere.SimulatorOptions(device="reference"))
    assert simulator.device().name == "reference"


def test_a_built_in_sensor_is_chosen_by_its_name(square):
    scene = gnosphere.Scene([gnosphere.Material()], [square], [gnosphere.Instance(mesh=0)])
    reference = gnosphere.SimulatorOptions(device="reference")
    simulator = gnosphere.Simulator(scene, "VLP-16", reference)
    other = gnosphere.Simulator(scene, gnosphere.builtin_sensor("VLP-16"), reference)
    np.testing.assert_array_equal(simulator.scan(gnosphere.Pose()).ranges, other.scan(gnosphere.Pose()).ranges)
    assert simulator.add_sensor("puck:20hz") == 1
    puck = gnosphere.builtin_sensor("Puck:20Hz")
    assert simulator.scan(gnosphere.Pose(), 1).shape[:2] == (len(puck.channels), puck.columns)
    pair = gnosphere.Simulator(scene, ["VLP-16", beams(5)], reference)
    assert pair.scan(gnosphere.Pose(), 1).beam_count() == 5
    for call in (
        lambda: gnosphere.Simulator(scene, "VLP16", reference),
        lambda: gnosphere.Simulator(scene, [beams(5), "VLP16"], reference),
        lambda: simulator.add_sensor("VLP16"),
    ):
        with pytest.raises(gnosphere.Error, match="no built-in sensor is called 'VLP16'; the nearest are VLP-16"):
            call()


def test_modules_are_there_without_an_import_of_their_own():
    for name in ("pictures", "patterns", "robotics", "helios"):
        command = [sys.executable, "-c", f"import gnosphere; print(gnosphere.{name}.__name__)"]
        assert subprocess.run(command, capture_output=True, text=True, check=True).stdout == f"gnosphere.{name}\n"
    with pytest.raises(AttributeError, match="no attribute 'pictues'"):
        gnosphere.pictues


def test_sensors_and_materials_come_and_go(reference, square):
    second = reference.add_sensor(gnosphere.SensorRequest(beams(5), gnosphere.Effects.none()))
    assert reference.scan(gnosphere.Pose(), second).beam_count() == 5
    reference.remove_sensor(second)
    with pytest.raises(gnosphere.Error, match="sensor"):
        reference.scan(gnosphere.Pose(), second)
    holes = gnosphere.AlphaImage(np.zeros((2, 3), np.uint8), gnosphere.AlphaImage.Wrap.clamp)
    assert holes.alpha.shape == (holes.height, holes.width) == (2, 3)
    material = reference.add_material(gnosphere.Material("net", alpha_mode=gnosphere.AlphaMode.mask), holes)
    reference.set_material(material, gnosphere.Material("other", roughness=0.5), None)
    reference.remove_material(material)
    with pytest.raises(gnosphere.Error, match="material 0 has another class"):
        reference.set_material(0, gnosphere.Material(class_id=3))
    assert reference.cluster_count() == 0  # the reference has none


def test_the_class_of_a_material_counts_before_that_of_an_instance(reference, square):
    road = reference.add_material(gnosphere.Material("road", class_id=40))
    mesh = gnosphere.Mesh(square.positions, square.indices, [gnosphere.MeshPart(0, 2, road)])
    reference.add_instance(reference.add_mesh(mesh), at(5), class_id=9)
    assert reference.scan(gnosphere.Pose()).column(Field.class_id)[MIDDLE] == 40


def test_positions_are_taken_in_any_layout(reference, square):
    moved = np.asarray(square.positions + np.float32([2, 0, 0]))
    for positions in (moved, moved.astype(np.float64), np.asfortranarray(moved), moved.tolist(), moved[::-1][::-1]):
        reference.set_positions(0, square.positions)
        assert distance(reference) == pytest.approx(10)
        reference.set_positions(0, positions)
        assert distance(reference) == pytest.approx(12)
    moved.flags.writeable = False
    reference.set_positions(0, moved)


def test_a_scene_is_changed_in_place(square):
    scene = gnosphere.Scene([gnosphere.Material("grey")], [square, square], [gnosphere.Instance(0, at(3), name="a")])
    instance = scene.instances[0]
    instance.class_id = 4
    instance.transform = at(8)
    scene.materials[0].retro = 30
    scene.materials[0].class_id = 7
    scene.materials[0].class_name = "road"
    scene.meshes[1].positions[:, 0] = 1
    assert scene.instances[0].class_id == 4
    assert scene.instances[0].transform.rows[0, 3] == 8
    assert scene.materials[0].retro == 30
    assert (scene.materials[0].class_id, scene.materials[0].class_name) == (7, "road")
    assert gnosphere.world_bounds(scene).max == (8, 1, 1)
    assert square.positions[0, 0] == 0  # the scene has copied it
    assert scene.placed_triangle_count() == 2 and scene.unique_triangle_count() == 4
    positions = scene.meshes[1].positions
    del scene
    assert positions[0, 0] == 1  # the view keeps the mesh, the mesh keeps the scene
    with pytest.raises(AttributeError):
        instance.nmae = "b"


def test_what_would_change_a_copy_is_refused():
    pose, transform = gnosphere.Pose((1, 2, 3)), at(1)
    sensor = gnosphere.builtin_sensor("VLP-16")
    sensor.masked_beams = [1, 2]
    with pytest.raises(TypeError):
        pose.position[0] = 5
    with pytest.raises(AttributeError):
        pose.position = (0, 0, 0)
    with pytest.raises(ValueError, match="read-only"):
        transform.rows[0, 3] = 5
    with pytest.raises(AttributeError):
        sensor.channels[0].elevation_deg = 3
    with pytest.raises(AttributeError):
        sensor.channels.append(gnosphere.Channel())
    with pytest.raises(ValueError, match="read-only"):
        sensor.masked_beams[:] = 1
    sensor.channels = sensor.channels[:8]
    assert sensor.height() == 8 and sensor.beam_count() == 8 * 1800


def test_effects_weather_and_motion(square, device):
    effects = gnosphere.Effects()
    effects.range_noise.use = gnosphere.EffectUse.on
    effects.range_noise.sigma = 0.02
    gnosphere.assign(effects, "angle-noise.azimuth=0.001")
    assert effects.angle_noise.use == gnosphere.EffectUse.on
    effects.drop_out.dead_beams = [1, 2]
    effects.volumes.boxes = [gnosphere.Effects.Volume((0, 0, 0), (1, 1, 1), 0.1)]
    copy = gnosphere.effects_from_json(gnosphere.to_json(effects), "here")
    assert copy.range_noise.sigma == 0.02
    assert copy.drop_out.dead_beams.tolist() == [1, 2]
    assert copy.volumes.boxes[0].max == (1, 1, 1)

    scene = gnosphere.Scene([gnosphere.Material()], [square], [gnosphere.Instance(0, at(40))])
    request = gnosphere.SensorRequest(beams(), variable_weather=True, fields=[Field.label])
    request.effects.sensor_motion.use = gnosphere.EffectUse.on
    simulator = gnosphere.Simulator(scene, request, gnosphere.SimulatorOptions(device))
    scan = gnosphere.Scan()
    simulator.scan_into(gnosphere.Shot(), scan)
    assert (scan.column(Field.label) == gnosphere.Label.solid.value).all()
    simulator.scan_into(gnosphere.Shot(weather=gnosphere.Weather(visibility=5)), scan)
    assert not (scan.column(Field.label) == gnosphere.Label.solid.value).any()

    shot = gnosphere.Shot(frame=3)
    shot.motion = gnosphere.SensorMotion([gnosphere.SensorMotion.Stamp(0, gnosphere.Pose((20, 0, 0)))])
    shot.instance_motions = [gnosphere.InstanceMotion(0, at(41))]
    assert shot.motion.stamps[0].pose.position == (20, 0, 0)
    simulator.scan_into(shot, scan)
    assert scan.ranges[MIDDLE] == pytest.approx(20.5)  # half-way through the scan


def test_a_list_of_beams_is_what_it_was_made_of():
    rng = np.random.default_rng(1)
    directions = rng.normal(size=(50, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    made = gnosphere.BeamList(
        directions, origins=np.zeros((50, 3)), times=np.linspace(0, 0.1, 50), range_min=np.full(50, 0.5),
        range_max=np.full(50, 9, np.float64), rings=np.arange(50) % 7, width=10, height=5,
    )  # fmt: skip
    assert np.array_equal(made.directions, directions)
    assert made.rings.dtype == np.uint16 and made.rings[13] == 6
    assert made.range_max.dtype == np.float32 and made.times[-1] == 0.1
    sensor = gnosphere.Sensor()
    sensor.range_max = 10
    sensor.patterns = [made]
    gnosphere.validate(sensor)
    view = gnosphere.beams_of(sensor).directions
    assert np.array_equal(view, directions) and not view.flags.writeable
    again = gnosphere.sensor_from_json(gnosphere.to_json(sensor), "here")
    assert np.array_equal(again.patterns[0].directions, directions)


def test_transforms_compose():
    turn = gnosphere.Transform([[0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 3]])
    assert turn * (1, 0, 0) == (1, 3, 3)
    assert (turn * turn) * (1, 0, 0) == turn * (turn * np.array([1.0, 0, 0]))
    assert repr(gnosphere.Pose()) == "Pose((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))"


def test_materials_and_tables(town):
    unused: list[str] = []
    table = gnosphere.MaterialTable([gnosphere.MaterialTable.Row("no such material", 0.5)])
    optics = gnosphere.optics_of(town, table, 905, unused)
    assert len(optics) == len(town.materials)
    assert unused == ["no such material"]
    assert 0 <= gnosphere.optics_of(town.materials[0]).reflectance <= 1


def test_many_transforms_at_once(reference, square):
    mesh = reference.add_mesh(square)
    far = reference.add_instance(mesh, at(50))
    rows = np.stack([at(30).rows, at(8).rows])
    poses = np.array([[40, 0, 0, 0, 0, 0, 2], [7, 0, 0, 0, 0, 0, 1]], np.float64)  # a quaternion of any length
    for values, expected in ((rows, 8), (poses, 7)):
        for kind in (np.float64, np.float32):
            reference.set_transforms([far, 0], np.zeros_like(rows) + at(20).rows)
            assert distance(reference) == pytest.approx(20)
            reference.set_transforms(np.array([0, far]), values.astype(kind))
            assert distance(reference) == pytest.approx(expected)
    reference.set_transforms([], [])
    reference.set_transforms([0, 0], np.stack([at(9).rows, at(6).rows])[:, :, ::-1][:, :, ::-1])  # the last one counts
    assert distance(reference) == pytest.approx(6)
    wrong = poses.copy()
    wrong[1, 4] = np.nan
    for instances, values, sentence in (
        ([0, far], wrong, f"entry 1: the transform of instance {far} is not finite"),
        ([0, 7], poses, "entry 1: instance 7 does not exist, there are 2"),
        ([0], poses, "there are 1 instances, but 2 transforms"),
        ([0, far], np.zeros((2, 4, 5)), r"has the shape \(2, 4, 5\); it must be \(n, 3, 4\), \(n, 4, 4\) or \(n, 7\)"),
        ([0, far], np.zeros((2, 3, 3)), r"has the shape \(2, 3, 3\); it must be"),
        ([0, far], [np.eye(4), np.diag([1, 1, 1, 2])], r"the last row of entry 1 is \[0.0, 0.0, 0.0, 2.0\]"),
        ([0, -1], poses, "holds -1"),
        ([0, far], [["x"] * 7] * 2, "it must hold numbers"),
        ([0.5, 1], poses, "it must hold integers"),
    ):
        with pytest.raises(gnosphere.Error, match=sentence):
            reference.set_transforms(instances, values)
        assert distance(reference) == pytest.approx(6)


def test_maps_are_transforms_or_have_a_last_row(reference, square):
    mesh = reference.add_mesh(square)
    far = reference.add_instance(mesh, at(50))
    whole = np.stack([np.vstack([at(x).rows, [0, 0, 0, 1]]) for x in (30, 8)])
    for maps, expected in (
        ([at(30), at(9)], 9),
        ((at(30), at(7)), 7),
        (whole, 8),
        (whole.astype(np.float32)[::-1][::-1], 8),
        (whole.tolist(), 8),
    ):
        reference.set_transforms([0, far], [at(20), at(20)])
        assert distance(reference) == pytest.approx(20)
        reference.set_transforms([0, far], maps)
        assert distance(reference) == pytest.approx(expected)
    added = reference.add_instances(mesh, [at(6), at(5)])
    assert added.tolist() == [2, 3] and distance(reference) == pytest.approx(5)
    for other in (whole[0], None):
        sentence = f"entry 0 is of the type Transform, but entry 1 of the type {type(other).__name__}"
        with pytest.raises(TypeError, match=f"set_transforms: transforms: {sentence}"):
            reference.set_transforms([0, far], [at(1), other])
    assert gnosphere.Transform(whole[1]) == at(8)
    moved = gnosphere.Deformation(whole)
    assert moved == gnosphere.Deformation([at(30), at(8)]) and moved == gnosphere.Deformation(whole[:, :3])


def test_a_sensor_ignores_instances(reference, square):
    near = reference.add_instance(reference.add_mesh(square), at(4))
    request = gnosphere.SensorRequest(beams(), gnosphere.Effects.none(), ignored_instances=[near])
    assert request.ignored_instances == (near,)
    blind = reference.add_sensor(request)
    assert distance(reference) == pytest.approx(4)
    assert distance(reference, blind) == pytest.approx(10)
    request.ignored_instances = [0, near]
    assert np.isnan(distance(reference, reference.add_sensor(request)))
    request.ignored_instances = [9]
    with pytest.raises(gnosphere.Error, match="instance 9 does not exist"):
        reference.add_sensor(request)

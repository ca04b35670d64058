# SPDX-License-Identifier: Apache-2.0
"""Settings and scenes are copied, pickled and compared by their values; results and simulators are not."""

import copy
import enum
import multiprocessing
import pickle
import weakref

import numpy as np
import pytest
from conftest import at, beams

import gnosphere
from gnosphere import Effects, Field

STEP = gnosphere.Track.Interpolation.step
TARGET = np.float32([[0, 0, 1], [0, 0, 0], [0, 0, 0]])


def bent(square: gnosphere.Mesh) -> gnosphere.Mesh:
    """A triangle with a joint and a morph target."""
    return gnosphere.Mesh(
        square.positions[:3],
        [[0, 1, 2]],
        [gnosphere.MeshPart(0, 1, 0)],
        uvs=[[0, 0], [1, 0], [0, 1]],
        origin=(1, 2, 3),
        name="bent",
        joint_count=1,
        joints=[[0], [0], [0]],
        joint_weights=[[1], [1], [1]],
        morph_targets=[TARGET],
        deformation=gnosphere.Deformation([at(1)], [0.5]),
    )


def animation() -> gnosphere.SceneAnimation:
    track = gnosphere.Track(0, gnosphere.Track.Property.translation, [0, 1], [[0, 0, 0], [1, 0, 0]], STEP)
    return gnosphere.SceneAnimation(
        nodes=[gnosphere.Node("root"), gnosphere.Node("arm", 0, (1, 2, 3), scale=(2, 2, 2))],
        clips=[gnosphere.Clip("wave", 1.0, [track])],
        instances=[gnosphere.AnimatedInstance(0, 1)],
        skins=[gnosphere.Skin([0], [at(2)], "skin")],
    )


def scene_of(square: gnosphere.Mesh) -> gnosphere.Scene:
    net = gnosphere.Material("net", (0.1, 0.2, 0.3, 1), alpha_mode=gnosphere.AlphaMode.mask, alpha_image=0, class_id=3)
    return gnosphere.Scene(
        [gnosphere.Material("wall"), net],
        [square, bent(square)],
        [gnosphere.Instance(0, at(5), name="front"), gnosphere.Instance(1, at(7), class_id=9)],
        alpha_images=[gnosphere.AlphaImage(np.eye(3, dtype=np.uint8), wrap_v=gnosphere.AlphaImage.Wrap.clamp)],
        animation=animation(),
    )


def effects() -> Effects:
    made = gnosphere.effect_preset("os1-rain")
    made.volumes.boxes = [Effects.Volume((0, 0, 0), (1, 2, 3), 0.1)]
    made.intensity.model = Effects.Intensity.Model.carla
    made.range_noise.sigma = 0.03
    return made


def options() -> gnosphere.SimulatorOptions:
    made = gnosphere.SimulatorOptions(gnosphere.DeviceChoice(name="llvm", uuid=bytes(range(16))))
    made.accuracy_parts = gnosphere.AccuracyParts(range=gnosphere.AccuracyParts.Range.exact)
    made.tuning.culling.cones = False
    made.tuning.max_batch_bytes = 12345
    made.materials = gnosphere.MaterialTable([gnosphere.MaterialTable.Row("wall", 0.4)])
    return made


def shot() -> gnosphere.Shot:
    stamps = [gnosphere.SensorMotion.Stamp(0.1 * i, gnosphere.Pose((i, 0, 0), (0, 0, 0.6, 0.8))) for i in range(2)]
    made = gnosphere.Shot(gnosphere.Pose((1, 2, 3)), frame=7, motion=gnosphere.SensorMotion(stamps))
    made.instance_motions = [gnosphere.InstanceMotion(0, at(6))]
    made.mesh_motions = [gnosphere.MeshMotion(1, gnosphere.Deformation([at(2)], [0.1]))]
    made.weather = gnosphere.Weather(rain_rate=4, volumes=[Effects.Volume((0, 0, 0), (1, 1, 1), 0.2)])
    return made


def layout() -> gnosphere.RecordLayout:
    column = gnosphere.RecordLayout.Value(Field.normal, 1, 64, stride=12)
    return gnosphere.RecordLayout([gnosphere.RecordLayout.Value(Field.range, 0, 4), column], 8, True)


def values(square: gnosphere.Mesh) -> list:
    """Objects that differ from new ones, of every class that a constructor makes of keywords."""
    heads = [gnosphere.builtin_sensor(name) for name in ("Puck", "AT128", "Avia")]
    request = gnosphere.SensorRequest(heads[0], effects(), [Field.intensity], ignored_instances=[1])
    others = [
        gnosphere.LoadOptions(gnosphere.UpAxis.y, 0.01),
        gnosphere.CloudOptions([Field.ring], compact=True),
        gnosphere.SensorFileOptions("OS1", columns=512),
        gnosphere.drive.RunOptions("out", 3, shard=1, shard_count=2, simulator=options(), progress=print),
    ]
    return [scene_of(square), *heads, beams(5), request, options(), shot(), layout(), *others]


def properties(value: object) -> dict[str, object]:
    return {name: getattr(value, name) for name, kind in vars(type(value)).items() if isinstance(kind, property)}


def inside(value: object) -> list:
    """The object and what it consists of."""
    if isinstance(value, tuple):
        return [part for element in value for part in inside(element)]
    if isinstance(value, enum.Enum) or not type(value).__module__.startswith("gnosphere."):
        return []
    return [value, *(part for one in properties(value).values() for part in inside(one))]


def numbers(value: object) -> object:
    """An object as numbers and texts, without the comparison that is tested."""
    if hasattr(value, "dtype"):
        return value.dtype, value.shape, value.tobytes()
    if isinstance(value, tuple):
        return tuple(map(numbers, value))
    if isinstance(value, enum.Enum) or not type(value).__module__.startswith("gnosphere."):
        return repr(value)
    return type(value), tuple((name, numbers(one)) for name, one in properties(value).items())


def made_by_keywords(holder: object) -> set[type]:
    kinds = {kind for kind in vars(holder).values() if isinstance(kind, type)}
    kinds = {kind for kind in kinds if kind.__module__.startswith("gnosphere._gnosphere")}
    kinds = {kind for kind in kinds if not issubclass(kind, (enum.Enum, Exception))}
    return {kind for kind in kinds if "__init__(self" in kind.__init__.__doc__}.union(*map(made_by_keywords, kinds))


def test_copies_have_the_values_of_what_they_are_copies_of(square):
    seen = set()
    for value in inside(tuple(values(square))):
        seen.add(type(value))
        for again in (copy.copy(value), copy.deepcopy(value), pickle.loads(pickle.dumps(value))):
            assert again is not value
            assert numbers(again) == numbers(value)
            assert again == value
    results = {gnosphere.Simulator, gnosphere.BatchStream, gnosphere.Scan, gnosphere.Batch}
    assert (made_by_keywords(gnosphere._gnosphere) | made_by_keywords(gnosphere._gnosphere.drive)) - results == seen


def test_a_change_of_a_copy_leaves_the_original(square):
    head = gnosphere.builtin_sensor("OS1-64")
    other = copy.copy(head)
    other.columns = 7
    assert head.columns == 1024 and head != other
    rain = effects()
    for again in (copy.copy(rain), copy.deepcopy(rain)):
        assert again == rain
        again.rain.rate = 90
        assert rain.rain.rate != 90 and again != rain
    scene = scene_of(square)
    again = copy.deepcopy(scene)
    again.meshes[0].positions[0] = 77
    again.instances[0].transform = at(8)
    assert 77 not in scene.meshes[0].positions
    assert scene.instances[0].transform == at(5)


def test_values_are_compared():
    pose = gnosphere.Pose((1, 2, 3))
    assert pose == gnosphere.Pose((1, 2, 3)) and not pose != gnosphere.Pose((1, 2, 3))
    assert pose != gnosphere.Pose((1, 2, 4)) and pose != (1, 2, 3) and pose != at(1)
    nan = gnosphere.Channel(range_max=float("nan"))
    assert nan == copy.copy(nan) and nan != gnosphere.Channel()


def test_counters_are_values(simulator, pose, reference):
    counters = simulator.scan(pose).counters
    assert counters.hits > 0 and counters != reference.scan(pose).counters and counters != 5
    for again in (copy.copy(counters), copy.deepcopy(counters), pickle.loads(pickle.dumps(counters))):
        assert again is not counters
        assert again == counters and numbers(again) == numbers(counters)
    with pytest.raises(TypeError, match="unhashable"):
        hash(counters)
    with pytest.raises(gnosphere.Error, match="Counters: they were pickled by another version of gnosphere"):
        gnosphere.Counters.__new__(gnosphere.Counters).__setstate__(([1], []))


def test_what_holds_memory_can_be_referenced_weakly(simulator, pose, square):
    for thing in (simulator, simulator.scan(pose), simulator.scan_batch([pose]), gnosphere.Scene()):
        assert weakref.ref(thing)() is thing


def test_results_and_simulators_are_not_copied(simulator, pose):
    for one in (simulator, simulator.scan(pose)):
        for way in (copy.copy, copy.deepcopy, pickle.dumps):
            with pytest.raises(TypeError):
                way(one)


def test_a_derived_class_is_compared_but_not_copied():
    class Named(gnosphere.Pose):
        pass

    pose = Named((1, 2, 3))
    assert pose == Named((1, 2, 3)) and pose != Named((1, 2, 4))
    for way in (copy.copy, copy.deepcopy, pickle.dumps):
        with pytest.raises(TypeError, match="'Named', a class derived from one of gnosphere"):
            way(pose)


def ranges_of(scene: gnosphere.Scene, request: gnosphere.SensorRequest, one: gnosphere.Shot) -> bytes:
    reference = gnosphere.SimulatorOptions(gnosphere.device_by_name("reference"))
    scan = gnosphere.Simulator(scene, request, reference).scan(one)
    assert scan.counters.hits > 0
    return scan.ranges.tobytes()


def test_a_worker_process_scans_what_it_is_sent(square):
    asked = gnosphere.SensorRequest(beams(9), effects()), gnosphere.Shot(gnosphere.Pose(), frame=3)
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        assert pool.apply(ranges_of, (scene_of(square), *asked)) == ranges_of(scene_of(square), *asked)


def test_what_never_changes_has_the_hash_of_its_value():
    """In the words of the class: it is never changed after it is made. Other values have no hash."""
    unchanged = 0
    for value in inside(tuple(values(gnosphere.Mesh(np.zeros((3, 3)), [[0, 1, 2]], [gnosphere.MeshPart(0, 1, 0)])))):
        if "never changed after it is" in type(value).__doc__.replace("\n", " "):
            unchanged += 1
            assert hash(value) == hash(copy.deepcopy(value))
        elif any(isinstance(member, property) and member.fset for member in vars(type(value)).values()):
            with pytest.raises(TypeError, match="unhashable"):
                hash(value)
    assert unchanged > 50
    poses = {gnosphere.Pose((1, 2, 3)): "here", gnosphere.Pose((0.0, 0, 0)): "there"}
    assert poses[gnosphere.Pose((1, 2, 3))] == "here" and poses[gnosphere.Pose((-0.0, 0, 0))] == "there"
    assert len({at(1), at(1), at(2), gnosphere.Transform()}) == 3
    nan = gnosphere.Channel(range_max=float("nan"))
    assert hash(nan) == hash(copy.copy(nan))


def test_answers_are_compared_by_value(simulator, town, pose):
    first, second = simulator.scan(pose), simulator.scan(gnosphere.Pose((30, 0, 1.8)))
    for ask in (
        lambda: gnosphere.list_devices()[0],
        lambda: gnosphere.world_bounds(town),
        lambda: gnosphere.compare(first, first),
        lambda: gnosphere.field_info(Field.normal),
        lambda: gnosphere.sensor_catalogue()[0],
        lambda: simulator.plan(),
        lambda: simulator.plan().effects[0],
        lambda: simulator.memory(),
        lambda: gnosphere.optics_of(town, gnosphere.MaterialTable(), 905)[0],
    ):
        one, other = ask(), ask()
        assert one is not other and one == other and not one != other and one != 5
        assert hash(one) == hash(other)
    assert gnosphere.field_info(Field.x) != gnosphere.field_info(Field.y)
    assert gnosphere.compare(first, first) != gnosphere.compare(first, second)


def test_answers_of_numbers_are_copied_and_pickled(simulator, town, pose):
    scan = simulator.scan(pose)
    table = gnosphere.MaterialTable([gnosphere.MaterialTable.Row("wall", 0.4)])
    for value in (
        *gnosphere.list_devices(),
        gnosphere.compare(scan, simulator.scan(gnosphere.Pose((30, 0, 1.8)))),
        scan.timings,
        simulator.memory(),
        gnosphere.world_bounds(town),
        gnosphere.optics_of(town, table, 905)[0],
    ):
        for again in (copy.copy(value), copy.deepcopy(value), pickle.loads(pickle.dumps(value))):
            assert again is not value and numbers(again) == numbers(value) and again == value


def test_a_scene_keeps_what_its_file_has_more(square):
    scene = scene_of(square)
    scene.left_out, scene.unread_images = ("a camera (2)", "a light"), 3
    for again in (copy.copy(scene), copy.deepcopy(scene), pickle.loads(pickle.dumps(scene))):
        assert (again.left_out, again.unread_images) == (("a camera (2)", "a light"), 3)
    assert scene != scene_of(square)


def test_a_derived_class_shows_its_properties():
    class Tick(gnosphere.Shot):
        def __init__(self, number):
            super().__init__(frame=number)
            self.note = "kept"

    assert repr(Tick(7)) == "Tick(frame=7)" and Tick(7).note == "kept"

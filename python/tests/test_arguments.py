# SPDX-License-Identifier: Apache-2.0
"""Bad input is an exception with a sentence, and never a crash."""

import gc
import importlib.util
import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest

import gnosphere
from gnosphere import ErrorCode

PARTS = [gnosphere.MeshPart(0, 1, 0)]
CORNERS = np.zeros((3, 3), np.float32)
FACES = np.array([[0, 1, 2]], np.uint32)


def refused(code: ErrorCode, sentence: str):
    """Whether the block raises an Error of this code whose message has the sentence."""

    class Refused:
        def __enter__(self):
            return self

        def __exit__(self, kind, error, trace):
            assert kind is not None, f"nothing was raised; expected: {sentence}"
            if kind is not gnosphere.Error:
                return False
            assert sentence in str(error)
            assert error.code == code
            return True

    return Refused()


@pytest.mark.parametrize(
    ("positions", "sentence"),
    [
        (np.zeros((4, 2), np.float32), "positions has the shape (4, 2); it must be (n, 3)"),
        (np.zeros(9, np.float32), "positions has the shape (9,)"),
        (np.zeros((2, 2, 3)), "positions has the shape (2, 2, 3)"),
        (5, "positions has the shape ()"),
        ("abc", "positions has the shape ()"),
        ([["a", "b", "c"]], "positions has the type <U1; it must hold numbers"),
        ([[1j, 0, 0]], "positions has the type complex128"),
        ([[1, 2, 3], [4, 5]], "positions cannot be made an array"),
        ([[None, None, None]], "positions has the type object"),
        (np.zeros((3, 3), bool), "positions has the type bool"),
        (np.zeros((3, 3), "datetime64[s]"), "positions has the type datetime64"),
    ],
)
def test_arrays_of_the_wrong_kind(positions, sentence, reference):
    with refused(ErrorCode.invalid_argument, "Mesh: " + sentence):
        gnosphere.Mesh(positions, FACES, PARTS)
    with refused(ErrorCode.invalid_argument, "set_positions: " + sentence):
        reference.set_positions(0, positions)


@pytest.mark.parametrize(
    ("indices", "sentence"),
    [
        ([[0, 1, -2]], "holds -2, which does not fit the type uint32"),
        ([[0, 1, 2**32]], "holds 4294967296, which does not fit"),
        ([[0, 1, 2.5]], "has the type float64; it must hold integers"),
        (FACES.T, "has the shape (3, 1)"),
    ],
)
def test_indices_that_are_none(indices, sentence):
    with refused(ErrorCode.invalid_argument, "Mesh: indices " + sentence):
        gnosphere.Mesh(CORNERS, indices, PARTS)


def test_arrays_that_have_to_be_converted_are():
    wide = np.zeros((3, 6))
    frozen = CORNERS.copy()
    frozen.flags.writeable = False
    swapped = CORNERS.astype(">f4")
    for positions in (
        wide[:, ::2],
        frozen,
        swapped,
        np.asfortranarray(CORNERS),
        CORNERS.astype(np.float16),
        [[0, 0, 0]] * 3,
    ):
        assert np.array_equal(gnosphere.Mesh(positions, FACES, PARTS).positions, CORNERS)
    for indices in (FACES.astype(np.int64), FACES.astype(">u2"), FACES.tolist(), np.repeat(FACES, 2, axis=0)[::2]):
        assert np.array_equal(gnosphere.Mesh(CORNERS, indices, PARTS).indices, FACES)
    empty = gnosphere.Mesh([], [], [])
    assert empty.positions.shape == empty.indices.shape == (0, 3) and empty.uvs.shape == (0, 2)


def test_wrong_indices_of_a_scene(square):
    scene = gnosphere.Scene([gnosphere.Material()], [square], [gnosphere.Instance(3)])
    with refused(ErrorCode.invalid_argument, "mesh 3"):
        gnosphere.validate(scene)
    square_beyond = gnosphere.Mesh(CORNERS, [[0, 1, 7]], PARTS, name="beyond")
    with refused(ErrorCode.invalid_argument, "7"):
        gnosphere.validate(gnosphere.Scene([gnosphere.Material()], [square_beyond], [gnosphere.Instance(0)]))


def test_fields_are_names_or_a_sequence():
    Field = gnosphere.Field
    sensor = gnosphere.builtin_sensor("VLP-16")
    alike = ["ring,class", " Ring, CLASS ", ["ring", "class"], (Field.ring, "class"), np.array(["ring", "class"])]
    for fields in [*alike, [Field.ring, Field.class_id]]:
        assert gnosphere.SensorRequest(sensor, fields=fields).fields == (Field.ring, Field.class_id)
        assert gnosphere.parse_fields(fields) == (Field.ring, Field.class_id)
    assert gnosphere.parse_fields("") == gnosphere.parse_fields([]) == gnosphere.SensorRequest(sensor).fields == ()

    request = gnosphere.SensorRequest(sensor, fields="ring")
    options = gnosphere.CloudOptions(fields=["x", Field.y])
    assert options.fields == (Field.x, Field.y)
    for target in (request, options):
        target.fields = "intensity"
        assert target.fields == (Field.intensity,)
        with refused(ErrorCode.invalid_argument, "'rnge'; the nearest are range, "):
            target.fields = ["rnge"]
        assert target.fields == (Field.intensity,)
    for wrong, culprit in [(3, "fields is an int"), ({"x"}, "fields is a set"), (b"x", "fields is a bytes")]:
        with pytest.raises(TypeError, match=culprit):
            gnosphere.SensorRequest(sensor, fields=wrong)
    with pytest.raises(TypeError, match="fields holds a float; it must hold Field or names"):
        gnosphere.layout_of(["x", 1.5])
    layout = gnosphere.layout_of("x,ring")
    assert [value.offset for value in layout.values] == [0, 4]


def test_names_that_are_unknown(tmp_path):
    with refused(ErrorCode.invalid_argument, "HDL-64E"):
        gnosphere.builtin_sensor("HDL-65")
    with refused(ErrorCode.invalid_argument, "range-noise"):
        gnosphere.assign(gnosphere.Effects(), "range-nose.sigma=1")
    with refused(ErrorCode.format, "visibility"):
        gnosphere.effects_from_json('{"fog": {"visibilty": 5}}', "mine.json")
    with refused(ErrorCode.invalid_argument, "range"):
        gnosphere.parse_fields("x,y,rnge")
    with refused(ErrorCode.invalid_argument, "os1-rain"):
        gnosphere.effect_preset("os2-rain")
    with refused(ErrorCode.invalid_argument, "no such card"):
        gnosphere.Simulator(
            gnosphere.Scene(),
            gnosphere.SensorRequest(gnosphere.builtin_sensor("VLP-16")),
            gnosphere.SimulatorOptions(gnosphere.device_by_name("no such card")),
        )
    with pytest.raises(AttributeError, match="intensty"):
        gnosphere.Field.intensty
    with pytest.raises(AttributeError):
        gnosphere.Effects().fgo = 1


def test_the_options_of_a_sensor_file():
    scanner = b'<document><scanner id="a" optics="rotating" pulseFreqs_Hz="1000,2000" scanAngleMax_deg="45"/></document>'
    for options in (
        gnosphere.SensorFileOptions(mode="a:2000", columns=20, scan_rate=10),
        gnosphere.SensorFileOptions("", "a:2000", 10, 20, 0, ""),
    ):
        file = gnosphere.read_sensor_file(scanner, "a.xml", options)
        assert file.sensor.beam_count() == 200
    options.fire_times = Path()
    assert gnosphere.read_sensor_file(scanner, "a.xml", options).sensor.beam_count() == 200
    options.fire_times = Path("times.csv")
    with refused(ErrorCode.invalid_argument, "--fire-times does not apply"):
        gnosphere.read_sensor_file(scanner, "a.xml", options)


def test_a_sensor_file_tells_what_it_leaves_open(tmp_path):
    angles = tmp_path / "angles.csv"
    angles.write_text("Channel,Elevation,Azimuth\n" + "".join(f"{row},{64 - row},0\n" for row in range(1, 129)))
    with pytest.warns(UserWarning) as told:
        assert gnosphere.load_sensor(angles).columns == 1800
    texts = [str(warning.message) for warning in told]
    assert f"{angles}: assumed: 1800 columns in a turn of 360 degrees" in texts[0]
    assert all(warning.filename == __file__ for warning in told)
    with pytest.warns(UserWarning) as told:
        sensor = gnosphere.load_sensor(angles, columns=90, scan_rate=20)
    assert len(told) == len(texts) - 2
    assert (sensor.columns, sensor.rotation_period) == (90, 0.05)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sensor = gnosphere.load_sensor(angles, head="AT128")
        assert (sensor.azimuth_span_deg, sensor.range_at_10_percent) == (-120, 200)
        own = tmp_path / "own.json"
        own.write_text(gnosphere.to_json(gnosphere.builtin_sensor("VLP-16")))
        assert gnosphere.load_sensor(own).name == "VLP-16"
        with pytest.raises(UserWarning, match="a turn of 360 degrees"):
            gnosphere.load_sensor(angles)
    with refused(ErrorCode.invalid_argument, "--mode is an operational state"):
        gnosphere.load_sensor(angles, mode="2")


def test_files_that_cannot_be_read(tmp_path, simulator, pose):
    with refused(ErrorCode.file, "nothing.glb"):
        gnosphere.load_scene(tmp_path / "nothing.glb")
    (tmp_path / "bad.glb").write_bytes(b"no scene")
    with refused(ErrorCode.format, "bad.glb"):
        gnosphere.load_scene(str(tmp_path / "bad.glb"))
    with refused(ErrorCode.file, "nothing.json"):
        gnosphere.load_sensor(tmp_path / "nothing.json")
    with refused(ErrorCode.format, "mine.json: is not JSON"):
        gnosphere.read_sensor_file(b"{", "mine.json")
    scan = simulator.scan(pose)
    with refused(ErrorCode.invalid_argument, ".xyz"):
        gnosphere.write_cloud(scan, tmp_path / "cloud.xyz")
    with refused(ErrorCode.file, "nowhere"):
        gnosphere.write_cloud(scan, tmp_path / "nowhere" / "cloud.npy")
    for name in ("cloud.jpg", "cloud"):
        with refused(ErrorCode.invalid_argument, f"{tmp_path / name} must end in .png"):
            gnosphere.write_picture(scan, tmp_path / name)
    with refused(ErrorCode.invalid_argument, "velocity"):
        gnosphere.write_cloud(scan, tmp_path / "cloud.npy", gnosphere.CloudOptions([gnosphere.Field.velocity]))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["bad.glb"]


def test_calls_that_are_wrong(reference, simulator, pose):
    with refused(ErrorCode.invalid_argument, "pose"):
        simulator.scan(gnosphere.Pose((np.nan, 0, 0)))
    with refused(ErrorCode.invalid_argument, "intensity"):
        reference.scan(gnosphere.Pose()).column(gnosphere.Field.intensity)
    with refused(ErrorCode.invalid_argument, "fog, which is not planned"):
        simulator.scan_into(gnosphere.Shot(pose, weather=gnosphere.Weather(visibility=9)), gnosphere.Scan())
    with refused(ErrorCode.invalid_argument, "beams"):
        gnosphere.compare(simulator.scan(pose), reference.scan(gnosphere.Pose()))
    with refused(ErrorCode.invalid_argument, "has the shape (3, 3); it must be (3, 4) or (4, 4)"):
        gnosphere.Transform(np.eye(3))
    with refused(ErrorCode.invalid_argument, "the last row of entry 0 is [0.0, 0.0, 0.0, 2.0]"):
        gnosphere.Transform(np.diag([1, 1, 1, 2.0]))
    with refused(ErrorCode.invalid_argument, "AlphaImage: alpha"):
        gnosphere.AlphaImage([1, 2])
    with refused(ErrorCode.invalid_argument, "AlphaImage: alpha"):
        gnosphere.AlphaImage([[300]])
    frozen = np.zeros(10**6, np.uint8)
    frozen.flags.writeable = False
    for out in (frozen, b"bytes", 5):
        with refused(ErrorCode.invalid_argument, "pack: `out` must be"):
            gnosphere.pack(simulator.scan(pose), gnosphere.layout_of([gnosphere.Field.x]), out)


def test_errors_are_one_line():
    for make in (
        lambda: gnosphere.Mesh([[1, 2, 3], [4, 5]], FACES, PARTS),
        lambda: gnosphere.Deformation([[[1, 2]], 5]),
        lambda: gnosphere.Transform([[1, 2], 3]),
    ):
        with pytest.raises(gnosphere.Error, match="cannot be made an array.*: ValueError: ") as error:
            make()
        assert "Traceback" not in str(error.value) and "\n" not in str(error.value)


class Tensor:
    """As a tensor of PyTorch: no sequence, but an array for whoever asks."""

    def __init__(self, values, how):
        array = np.array(values, np.float32)
        names = {"__array__": lambda self, dtype=None, copy=None: array}
        if how == "dlpack":
            names = {name: lambda self, *_, name=name, **__: getattr(array, name)() for name in ("__dlpack__",)}
            names["__dlpack_device__"] = lambda self: array.__dlpack_device__()
        names["size"] = lambda self: array.shape
        self.__class__ = type("Tensor", (Tensor,), names)


@pytest.mark.parametrize("how", ["array", "dlpack"])
def test_whatever_becomes_an_array_is_taken(how):
    position, turn = Tensor([1, 2, 3], how), Tensor([0, 0, 0.6, 0.8], how)
    pose = gnosphere.Pose(position, turn)
    assert pose.position == (1, 2, 3) and pose.orientation == pytest.approx((0, 0, 0.6, 0.8))
    assert gnosphere.Channel(origin=position).origin == (1, 2, 3)
    assert gnosphere.Transform(Tensor(np.eye(4), how)) == gnosphere.Transform()
    weights = np.ones((len(CORNERS), 1))
    mesh = gnosphere.Mesh(
        Tensor(CORNERS, how), FACES, PARTS, joint_count=1, joints=0 * weights.astype(int), joint_weights=Tensor(weights, how)
    )
    assert np.array_equal(mesh.positions, CORNERS) and np.array_equal(mesh.joint_weights, weights)
    with pytest.raises(gnosphere.Error, match="given together or not at all"):
        gnosphere.Mesh(CORNERS, FACES, PARTS, joints=Tensor([], how), joint_weights=weights)
    with pytest.raises(TypeError, match=r"3 numbers \(x, y, z\) is wanted, not one of 4"):
        gnosphere.Pose(turn)


def test_vectors_of_the_wrong_length():
    for make in (gnosphere.Pose, lambda v: gnosphere.Channel(origin=v), lambda v: gnosphere.Transform() * v):
        for wrong in ((1, 2), [1, 2, 3, 4], np.zeros(2), ()):
            with pytest.raises(TypeError, match=rf"3 numbers \(x, y, z\) is wanted, not one of {len(wrong)}"):
                make(wrong)
    with pytest.raises(TypeError, match=r"4 numbers \(x, y, z, w\) is wanted, not one of 3"):
        gnosphere.Pose((1, 2, 3), (0, 0, 0))
    mesh = gnosphere.Mesh(CORNERS, FACES, PARTS)
    with pytest.raises(TypeError, match="is wanted, not one of 2"):
        mesh.origin = (1, 2)
    for other in ("abc", b"abc", 5, {1, 2, 3}, ["a", "b", "c"], Tensor([[1, 2, 3]], "array")):
        with pytest.raises(TypeError):
            gnosphere.Pose(other)


def test_keywords_of_the_wrong_type_are_named():
    for make, sentence in (
        (lambda: gnosphere.Tuning(culling=5), "Tuning: culling must be of the type Culling, not 5"),
        (lambda: gnosphere.Effects(fog=3), "Effects: fog must be of the type Effects.Fog, not 3"),
        (lambda: gnosphere.Effects.Fog(use=3), r"Fog: use must be of the type EffectUse \| str, not 3"),
        (lambda: gnosphere.Sensor(range_max="far"), "Sensor: range_max must be of the type float, not 'far'"),
        (lambda: gnosphere.Sensor(channels=[3]), r"channels must be of the type Sequence\[Channel\], not \[3\]"),
        (lambda: gnosphere.Sensor("mast"), "Sensor takes its properties by their names alone"),
        (lambda: gnosphere.Material(3), "Material: name must be of the type str, not 3"),
        (lambda: gnosphere.Material("a", name="b"), "'name' is given twice"),
        (lambda: gnosphere.Material(*range(12)), "Material takes at most 11 arguments without a name, not 12"),
        (lambda: gnosphere.SimulatorOptions(3), r"SimulatorOptions: device must be .* \| str, not 3"),
        (lambda: gnosphere.SimulatorOptions(tuning=3), "SimulatorOptions: tuning must be of the type Tuning, not 3"),
        (lambda: gnosphere.Effects.Fog(visibility="far"), "Fog: visibility must be of the type float, not 'far'"),
    ):
        with pytest.raises(TypeError, match=sentence):
            make()


def test_whole_numbers_out_of_range_are_named_with_their_limits(reference):
    instance, shot, sensor = gnosphere.Instance(0), gnosphere.Shot(), gnosphere.Sensor()
    for call, sentence in (
        (lambda: gnosphere.Instance(0, class_id=70000), "Instance: class_id must be a whole number, 0..65535, is 7000"),
        (lambda: gnosphere.Instance(-1), "Instance: mesh must be a whole number, 0..4294967295, is -1"),
        (lambda: setattr(instance, "class_id", -1), "Instance: class_id must be a whole number, 0..65535, is -1"),
        (lambda: setattr(instance, "world", 2**32), "Instance: world must be a whole number, 0..4294967295, is 429496"),
        (lambda: gnosphere.Material(class_id=65536), "Material: class_id must be a whole number, 0..65535, is 65536"),
        (lambda: gnosphere.Shot(frame=-1), "Shot: frame must be a whole number, 0..18446744073709551615, is -1"),
        (lambda: setattr(shot, "frame", 2**64), "Shot: frame must be a whole number, 0..18446744073709551615, is 1844"),
        (lambda: setattr(sensor, "columns", 2**32), "Sensor: columns must be a whole number, 0..4294967295, is 429496"),
        (lambda: gnosphere.Effects(seed=-1), "Effects: seed must be a whole number, 0..18446744073709551615, is -1"),
        (
            lambda: reference.add_instance(0, gnosphere.Transform(), 70000),
            "add_instance: class_id must be a whole number, 0..65535, is 70000",
        ),
    ):
        with refused(ErrorCode.invalid_argument, sentence):
            call()
    instance.class_id = np.uint16(7)
    assert instance.class_id == 7 and gnosphere.Shot(frame=np.int64(5)).frame == 5
    for wrong in (1.0, np.float64(7), "7", None):
        with pytest.raises(TypeError):
            instance.class_id = wrong


class Labelled:
    """As a table or a column of pandas: a sequence whose entries are found by labels, and an array for whoever asks."""

    def __init__(self, values, labels, **types):
        self.values, self.labels = np.array(values), list(labels)
        self.__dict__.update(types)

    def __len__(self):
        return len(self.values)

    def __getitem__(self, label):
        return self.values[self.labels.index(label)]

    def __array__(self, dtype=None, copy=None):
        return self.values


def column(values, labels):
    """A column of objects, which has a dtype as a Series does; a DataFrame has none."""
    objects = np.empty(len(values), object)
    objects[:] = values
    return Labelled(objects, labels, dtype=objects.dtype)


def test_labels_are_no_indices(reference):
    pose = [1, 0, 0, 0, 0, 0, 1]
    near = reference.scan_batch(np.array([pose], float)).ranges
    assert np.isfinite(near).any()
    for shots in (
        Labelled([[1.0, 0, 0, 0, 0, 0, 1]], "a"),
        column([gnosphere.Pose((1, 0, 0))], "a"),
        column([gnosphere.Shot(gnosphere.Pose((1, 0, 0)))], "a"),
    ):
        assert np.array_equal(reference.scan_batch(shots).ranges, near, equal_nan=True)
    still = gnosphere.Transform([[1, 0, 0, 10], [0, 1, 0, 0], [0, 0, 1, 0]])
    reference.set_transforms([0], column([still], [4]))
    reference.set_transforms(Labelled([0], "a"), Labelled([[10.0, 0, 0, 0, 0, 0, 1]], "a"))
    assert len(gnosphere.Deformation(column([still], "a")).joints) == 1
    with refused(ErrorCode.invalid_argument, "Deformation: joints has the shape (1, 7)"):
        gnosphere.Deformation(Labelled([pose], "a"))
    for labels in ("xyz", [2, 1, 0]):
        assert gnosphere.Pose(Labelled([1.0, 2, 3], labels)).position == (1, 2, 3)


def test_masked_entries_are_refused(reference, square):
    corners = np.ma.array(square.positions, mask=square.positions > 0)
    poses = np.ma.array([[1.0, 0, 0, 0, 0, 0, 1]], mask=False)
    assert reference.scan_batch(poses).views == 1 and gnosphere.Pose(poses[0, :3]).position == (1, 0, 0)
    poses.mask = [[True] + [False] * 6]
    said = "ValueError: some of its entries are masked; numpy.ma.filled() gives them values"
    for call, sentence in (
        (lambda: reference.scan_batch(poses), f"scan_batch: shots cannot be made an array of shape (n, 7): {said}"),
        (lambda: reference.set_transforms([0], poses), f"set_transforms: transforms cannot be made an array: {said}"),
        (
            lambda: reference.scan_batch(poses.data, worlds=np.ma.array([0], mask=[1])),
            f"scan_batch: worlds cannot be made an array: {said}",
        ),
        (
            lambda: gnosphere.Mesh(corners, square.indices, square.parts),
            f"Mesh: positions cannot be made an array of shape (n, 3): {said}",
        ),
    ):
        with refused(ErrorCode.invalid_argument, sentence):
            call()
    with pytest.raises(TypeError, match="^a vector has masked entries; numpy.ma.filled.. gives them values$"):
        gnosphere.Pose(poses[0, :3])


def test_a_second_import_is_an_import_error():
    line = "import sys, gnosphere; [sys.modules.pop(n) for n in list(sys.modules) if n.split('.')[0] == 'gnosphere']"
    again = subprocess.run([sys.executable, "-c", f"{line}; import gnosphere"], capture_output=True, text=True)
    assert again.returncode == 1
    last = again.stderr.splitlines()[-1]
    assert last.startswith("ImportError: gnosphere._gnosphere cannot be initialised a second time in one process")


OTHER_INTERPRETER = """
import gnosphere
try:
    import _interpreters as interpreters
except ImportError:
    import _xxsubinterpreters as interpreters
other = interpreters.create()
code = "import sys; sys.path[:] = PATH; import gnosphere._gnosphere".replace("PATH", repr(__import__("sys").path))
try:
    failed = interpreters.run_string(other, code)
except interpreters.RunFailedError as error:
    failed = error
print(failed and getattr(failed, "formatted", failed))
print(gnosphere.Pose((1, 2, 3)), gnosphere.Sensor(range_max=5), gnosphere.builtin_sensor("Puck").name)
reference = gnosphere.SimulatorOptions(device="reference")
print(gnosphere.Simulator(gnosphere.Scene(), gnosphere.builtin_sensor("Puck"), reference).scan(gnosphere.Pose()))
"""


def test_an_import_in_another_interpreter_is_refused_and_harms_none():
    """What the first interpreter has goes on, and so does its end."""
    if not any(importlib.util.find_spec(name) for name in ("_interpreters", "_xxsubinterpreters")):
        pytest.skip("this Python has no module of interpreters")
    done = subprocess.run([sys.executable, "-c", OTHER_INTERPRETER], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    refused, values, scan = done.stdout.splitlines()
    assert "gnosphere._gnosphere cannot be initialised a second time in one process, in another interpreter" in refused
    assert values == "Pose((1.0, 2.0, 3.0), (0.0, 0.0, 0.0, 1.0)) Sensor(range_max=5) Puck:10Hz" and "0 returns" in scan


def test_values_of_the_wrong_type_name_the_property():
    class Mine(gnosphere.Material):
        pass

    mesh = gnosphere.Mesh(CORNERS, FACES, PARTS)
    for target, name, value, sentence in (
        (gnosphere.Material(), "roughness", "x", "^Material: roughness must be of the type float, not 'x'$"),
        (Mine(), "roughness", "x", "^Material: roughness must be of the type float, not 'x'$"),
        (gnosphere.Shot(), "pose", 3, "^Shot: pose must be of the type Pose, not 3$"),
        (gnosphere.Scene(), "animation", None, "^Scene: animation must be of the type SceneAnimation, not None$"),
        (mesh, "origin", (1, 2), r"^Mesh: origin: a vector of 3 numbers \(x, y, z\) is wanted, not one of 2$"),
        (gnosphere.CloudOptions(), "fields", 3, "^fields is an int; it must be"),
        (
            gnosphere.drive.RunOptions("out"),
            "progress",
            3,
            r"^RunOptions: progress must be of the type Callable\[\[int, ",
        ),
        (
            gnosphere.Instance(0),
            "transform",
            "abc",
            "^Instance: transform: a transform is|^a transform is a Transform, or",
        ),
    ):
        with pytest.raises(TypeError, match=sentence):
            setattr(target, name, value)
    with pytest.raises(AttributeError):
        gnosphere.Pose().position = (1, 2, 3)
    for color in ((1, 1, 1), np.ones(3)):
        wanted = r"^Material: base_color: a vector of 4 numbers \(red, green, blue, alpha\) is wanted, not one of 3$"
        with pytest.raises(TypeError, match=wanted):
            gnosphere.Material(base_color=color)
    assert gnosphere.Material(base_color=np.float32([0.5, 1, 0, 1])).base_color == (0.5, 1, 0, 1)


def test_words_stand_for_enumerators(town):
    Track, Image = gnosphere.Track, gnosphere.AlphaImage
    track = Track(0, "translation", [0, 1], [[0, 0, 0], [1, 0, 0]], "step")
    assert (track.property, track.interpolation) == (Track.Property.translation, Track.Interpolation.step)
    image = Image([[1]], "clamp", wrap_v="mirror")
    assert (image.wrap_u, image.wrap_v) == (Image.Wrap.clamp, Image.Wrap.mirror)
    image.wrap_u = "repeat"
    assert image.wrap_u == Image.Wrap.repeat
    clip = gnosphere.Clip("wave", 1.0)
    assert gnosphere.state_at(town, clip, 3, end="hold") == gnosphere.state_at(town, clip, 3, gnosphere.ClipEnd.hold)
    assert gnosphere.DeviceChoice("reference") == gnosphere.DeviceChoice(gnosphere.DeviceChoice.Kind.reference)
    assert gnosphere.AccuracyParts(range="exact").range == gnosphere.AccuracyParts.Range.exact
    for call, sentence in (
        (lambda: Track(0, "turn", [0], [[0, 0, 0]]), "Track: property must be translation, .* is 'turn'"),
        (lambda: setattr(image, "wrap_u", "clmp"), "AlphaImage: wrap_u must be repeat, mirror or clamp, is 'clmp'"),
        (lambda: gnosphere.state_at(town, clip, 3, "stop"), "state_at: end must be loop or hold, is 'stop'"),
    ):
        with pytest.raises(gnosphere.Error, match=sentence):
            call()


def test_maps_are_transforms_or_arrays(reference, square):
    rows = np.eye(4) + 7 * np.eye(4, k=3)
    place = gnosphere.Transform(rows)
    for given in (place, rows, rows[:3], rows.tolist()):
        instance = gnosphere.Instance(0, given)
        assert instance.transform == place
        instance.transform = np.eye(4)
        assert instance.transform == gnosphere.Transform()
        instance.transform = given
        assert instance.transform == place and gnosphere.InstanceMotion(0, given).end == place
        reference.set_transform(0, given)
        assert reference.scan(gnosphere.Pose()).ranges[4] == pytest.approx(7)
        reference.remove_instance(reference.add_instance(0, given))
        scene = gnosphere.Scene([gnosphere.Material()], [square], [gnosphere.Instance(0)])
        assert gnosphere.joined(scene, scene, given).instances[1].transform == place
    for call in (
        lambda: gnosphere.Instance(0, np.eye(3)),
        lambda: reference.set_transform(0, np.eye(3)),
        lambda: setattr(instance, "transform", np.eye(3)),
    ):
        with refused(ErrorCode.invalid_argument, "transform has the shape (3, 3); it must be (3, 4) or (4, 4)"):
            call()


def test_a_transform_has_an_inverse_and_a_product():
    turned = gnosphere.Transform([[0, -2, 0, 1], [1, 0, 0, 2], [0, 0, 3, 4]])
    back = turned.inverse()
    assert (turned @ back).rows == pytest.approx(np.eye(4)[:3]) and turned @ back == turned * back
    assert back * (turned * (5, 6, 7)) == pytest.approx((5, 6, 7))
    for flat in (np.diag([1, 1, 0, 1]), np.diag([np.nan, 1, 1, 1])):
        with refused(ErrorCode.invalid_argument, "Transform: the map has no inverse; its determinant is "):
            gnosphere.Transform(flat).inverse()


@pytest.mark.filterwarnings("ignore:nanobind. attempted to access an uninitialized instance")
@pytest.mark.parametrize(
    "call",
    [
        lambda s: s.scan(None),
        lambda s: s.scan((0, 0, 0)),
        lambda s: s.scan(gnosphere.Pose(), 1.5),
        lambda s: s.scan_into(None, None),
        lambda s: s.scan_into(gnosphere.Shot(), None),
        lambda s: s.scan_all([None], print),
        lambda s: s.scan_all([gnosphere.Shot()], None),
        lambda s: s.add_mesh(None),
        lambda s: s.set_positions(0, None),
        lambda s: gnosphere.Mesh(None, FACES, PARTS),
        lambda s: gnosphere.AlphaImage(None),
        lambda s: s.add_instance(0, None),
        lambda s: s.set_transform(0, None),
        lambda s: s.set_transform(0, 5),
        lambda s: setattr(gnosphere.Instance(0), "transform", "abc"),
        lambda s: s.add_sensor(gnosphere.Pose()),
        lambda s: s.add_sensor(gnosphere.Sensor.__new__(gnosphere.Sensor)),
        lambda s: gnosphere.Simulator(gnosphere.Scene(), [gnosphere.Sensor(), None]),
        lambda s: gnosphere.Simulator(None, None),
        lambda s: gnosphere.Pose((1, 2)),
        lambda s: gnosphere.Pose("abc"),
        lambda s: gnosphere.Pose((1, 2, 3), (0, 0, 0)),
        lambda s: gnosphere.load_scene(None),
        lambda s: gnosphere.SensorRequest(None),
        lambda s: gnosphere.SimulatorOptions(warn=5),
        lambda s: gnosphere.write_cloud(None, "x.npy"),
        lambda s: gnosphere.pack(gnosphere.Scan(), gnosphere.RecordLayout(), None),
        lambda s: gnosphere.Mesh.positions.fget(42),
        lambda s: gnosphere.Scene.meshes.fget(gnosphere.Pose()),
        lambda s: gnosphere.Mesh.__new__(gnosphere.Mesh).positions,
        lambda s: gnosphere.Simulator.__new__(gnosphere.Simulator).scan(gnosphere.Pose()),
        lambda s: gnosphere.Scan.__new__(gnosphere.Scan).points,
    ],
)
def test_arguments_of_the_wrong_type(call, reference):
    with pytest.raises(TypeError):
        call(reference)
    gc.collect()
    assert reference.scan(gnosphere.Pose()).beam_count() == 9

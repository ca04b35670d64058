# SPDX-License-Identifier: Apache-2.0
"""Arguments that are nearly what is asked for: none is taken for something else, and each error names its argument."""

import os
import re
import shutil
import threading
import time
import warnings

import numpy as np
import pytest
from conftest import REPOSITORY, at, beams
from test_arguments import refused

import gnosphere
from gnosphere import Effects, ErrorCode, Field, adapter, primitives, ros2


def test_a_message_is_made_of_the_scan_as_it_was_when_it_was_asked_for(reference):
    """While another thread scans into it."""
    wide = reference.add_sensor(gnosphere.SensorRequest(beams(9000), Effects.none()))
    scan, stop, widths = reference.scan(gnosphere.Pose()), threading.Event(), set()

    def read():
        while not stop.is_set():
            try:
                widths.add(ros2.cloud_of(scan, "x,y,z,range,triangle,instance", "f", 0).width)
            except gnosphere.Error as error:
                widths.add(str(error))

    threads = [threading.Thread(target=read) for _ in range(2)]
    for thread in threads:
        thread.start()
    for shot in range(200):
        time.sleep(0.0005)  # so that the others read a scan that is complete when the next one begins
        reference.scan_into(gnosphere.Shot(sensor=wide if shot % 2 else 0), scan)
    stop.set()
    for thread in threads:
        thread.join()
    assert widths <= {0, 9, 9000} and len(widths) > 1


def test_no_binding_reads_its_arguments_without_the_gil():
    """Another thread may change them, so bindings copy or share them first."""
    for file in (REPOSITORY / "python" / "src").glob("*.[ch]pp"):
        assert "call_guard" not in file.read_text(encoding="utf-8"), file.name


def test_objects_of_python_are_not_packed_over(reference):
    scan, layout = reference.scan(gnosphere.Pose()), gnosphere.layout_of("x,y,z")
    for dtype in (object, [("a", "f4"), ("b", object)], [("O", "O", (2,))]):
        kept = np.zeros(200, dtype)
        with refused(ErrorCode.invalid_argument, "pack: `out` must be a contiguous array of numbers"):
            gnosphere.pack(scan, layout, kept)
    for dtype in ("u1", "f2", [("O", "f4"), ("xOy", "f8")], "V4"):
        assert gnosphere.pack(scan, layout, np.zeros(200, dtype)) == 9


def test_a_series_has_lists_in_its_own_order(reference):
    pandas = pytest.importorskip("pandas")
    lists = pandas.Series([[0], []], index=[1, 0])
    batch = reference.scan_batch([gnosphere.Pose()] * 2, ignored_instances=lists)
    assert np.isfinite(batch.ranges).sum(axis=1).tolist() == [0, 9]
    lists.index = ["a", "b"]
    assert np.isfinite(reference.scan_batch([gnosphere.Pose()] * 2, ignored_instances=lists).ranges).sum() == 9


def test_maps_are_not_cut_or_transposed():
    shifted = np.eye(4)
    shifted[:3, 3] = (10, 20, 30)
    shapes, box = adapter.Shapes(), primitives.box((1, 1, 1))
    mesh = shapes.mesh(box)
    for given in (shifted, shifted[:3], gnosphere.Transform(shifted)):
        shapes.instance(mesh, given)
        assert shapes.instances[-1].transform == gnosphere.Transform(shifted)
        assert primitives.moved(box, given)[0].mean(axis=0).tolist() == [10, 20, 30]
    for call in (lambda given: shapes.instance(mesh, given), lambda given: primitives.moved(box, given)):
        with refused(ErrorCode.invalid_argument, "the last row of entry 0 is [10.0, 20.0, 30.0, 1.0]"):
            call(shifted.T)
        with refused(ErrorCode.invalid_argument, "has the shape (5, 4); it must be (3, 4) or (4, 4)"):
            call(np.ones((5, 4)))
        with refused(ErrorCode.invalid_argument, "some of its entries are masked"):
            call(np.ma.array(shifted, mask=shifted == 10))


SENSOR_NAME = b"\xe9"  # e with an accent in Latin-1, which is no UTF-8


def test_texts_that_are_no_utf_8_have_their_bytes(tmp_path, reference):
    sensor = tmp_path / "HDL.csv"
    sensor.write_text("channel,elevation,azimuth\n1,-2,0\n2,2,0\n")
    file = os.path.join(os.fsencode(tmp_path), SENSOR_NAME + b".csv")
    shutil.copy(sensor, file)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        gnosphere.load_sensor(os.fsdecode(file))
    assert told and all(str(warning.message).startswith(os.fsdecode(file) + ": ") for warning in told)
    with warnings.catch_warnings(), pytest.raises(UserWarning):
        warnings.simplefilter("error")  # which docs/python.md says
        gnosphere.load_sensor(os.fsdecode(file))
    # A name that a property returns can be given to other objects.
    material = gnosphere.Material(os.fsdecode(SENSOR_NAME))
    assert gnosphere.Scene([material]).materials[0].name.encode("utf-8", "surrogateescape") == SENSOR_NAME
    heard = []
    (tmp_path / os.fsdecode(SENSOR_NAME)).touch()
    options = gnosphere.SimulatorOptions("reference", materials=gnosphere.MaterialTable(
        [gnosphere.MaterialTable.Row(os.fsdecode(SENSOR_NAME), 0.5)]), warn=heard.append)  # fmt: skip
    gnosphere.Simulator(gnosphere.Scene([gnosphere.Material("grey")]), beams(), options)
    assert any(os.fsdecode(SENSOR_NAME) in sentence for sentence in heard)


class Raises:
    """An array, a sequence and a number whose values end in an exception."""

    def __init__(self, error):
        self.error = error

    def __len__(self):
        return 3

    def fail(self, *_, **__):
        raise self.error

    __array__ = __getitem__ = __index__ = __float__ = fail


class Masked(Raises):
    mask = property(Raises.fail)

    def __array__(self, *_, **__):
        return np.zeros(3)


class Sequence(Raises):
    __array__ = property(lambda self: self.missing)  # it has none, so the entries are read


@pytest.mark.parametrize("error", [KeyboardInterrupt(), SystemExit(3), MemoryError("mine")])
@pytest.mark.parametrize(
    "call",
    [
        lambda odd, simulator: gnosphere.Mesh(odd, [[0, 1, 2]], [gnosphere.MeshPart(0, 1, 0)]),
        lambda odd, simulator: gnosphere.Pose(odd),
        lambda odd, simulator: gnosphere.Pose(Sequence(odd.error)),
        lambda odd, simulator: gnosphere.Pose(Masked(odd.error)),
        lambda odd, simulator: gnosphere.Pose((1, 2, odd)),
        lambda odd, simulator: simulator.scan_batch(odd),
        lambda odd, simulator: simulator.scan(gnosphere.Pose(), odd),
        lambda odd, simulator: gnosphere.Transform(odd),
    ],
)
def test_what_is_no_fault_of_an_argument_is_passed_on(error, call, reference):
    with pytest.raises(type(error)) as raised:
        call(Raises(error), reference)
    assert raised.value is error


def test_faults_of_an_argument_are_named(reference):
    with refused(
        ErrorCode.invalid_argument, "Mesh: positions cannot be made an array of shape (n, 3): RuntimeError: x"
    ):
        gnosphere.Mesh(Raises(RuntimeError("x")), [[0, 1, 2]], [gnosphere.MeshPart(0, 1, 0)])
    with pytest.raises(TypeError, match="incompatible function arguments"):
        gnosphere.Pose(Raises(RuntimeError("x")))


def test_numbers_and_other_enumerators_are_no_choices(reference):
    for odd in (1, True, gnosphere.Label.solid, gnosphere.Cause.weak, np.int64(1), Field.y, 1.0):
        with pytest.raises(TypeError, match=r"Fog: use must be of the type EffectUse \| str"):
            Effects.Fog(use=odd)
        with pytest.raises(TypeError, match="incompatible function arguments"):
            gnosphere.AccuracyParts(cull=odd)
    assert Effects.Fog(use=gnosphere.EffectUse.on) == Effects.Fog(use="on")
    for odd in (17, True, gnosphere.Cause.weak, np.int64(17)):
        for call in (
            lambda odd=odd: gnosphere.parse_fields([odd]),
            lambda odd=odd: reference.scan_batch([gnosphere.Pose()], fields=[odd]),
            lambda odd=odd: gnosphere.SensorRequest(beams(), fields=["ring", odd]),
        ):
            with pytest.raises(TypeError, match="fields holds an? .*; it must hold Field or names of fields"):
                call()
        for call in (gnosphere.field_info, gnosphere.name_of, gnosphere.accuracy_parts_of):
            with pytest.raises(TypeError):
                call(odd)
    with pytest.raises(TypeError):
        gnosphere.parse_fields(np.array([17]))


def test_scenes_with_wrong_indices_are_not_joined(square):
    right = gnosphere.Scene([gnosphere.Material()], [square], [gnosphere.Instance(0)])
    wrong = gnosphere.Scene([], [], [gnosphere.Instance(0)])
    with refused(ErrorCode.invalid_argument, "joined: `scene`: instance 0: mesh 0 does not exist, the scene has 0"):
        gnosphere.joined(wrong, right)
    with refused(ErrorCode.invalid_argument, "joined: `other`: instance 0: mesh 0 does not exist, the scene has 0"):
        gnosphere.joined(right, wrong)


def test_frame_numbers_do_not_begin_again(reference):
    last = 2**64 - 1
    assert reference.scan_batch([gnosphere.Pose()], frame=last).views == 1
    assert reference.scan_batch([], frame=last).views == 0
    with refused(ErrorCode.invalid_argument, f"scan_batch: frame is {last - 1}, so that of the last of 3 views"):
        reference.scan_batch([gnosphere.Pose()] * 3, frame=last - 1)


def test_lone_surrogates_name_no_field(reference):
    scan = reference.scan(gnosphere.Pose())
    for result in (scan, reference.scan_batch([gnosphere.Pose()])):
        assert "\ud800" not in result
        with pytest.raises(KeyError, match=re.escape(r"has no field '\\ud800'; it has ")):
            result["\ud800"]
        with refused(ErrorCode.invalid_argument, r"'\ud800'"):
            result.column("\ud800")
    with refused(ErrorCode.invalid_argument, r"'\ud800'"):
        gnosphere.SensorRequest(beams(), fields=["\ud800"])
    with refused(ErrorCode.invalid_argument, r"Fog: use must be off, on or automatic, is '\udce9'"):
        Effects.Fog(use="\udce9")


def test_objects_that_were_not_made_say_so(reference):
    class Unmade(gnosphere.Pose):
        def __init__(self):
            pass

    class Empty(gnosphere.Transform):
        def __init__(self):
            pass

    with pytest.raises(TypeError, match=r"class Unmade was not made: Unmade.__init__\(\) must call super\(\).__init__"):
        reference.scan_batch([Unmade()])
    with pytest.raises(TypeError, match="class Empty was not made"):
        gnosphere.Instance(0, Empty())
    with pytest.raises(TypeError, match="class Empty was not made"):
        reference.set_transforms([0], [Empty()])


def test_whole_numbers_are_named(reference):
    scan, sensor = reference.scan(gnosphere.Pose()), beams()
    for call, name in (
        (scan.hit, "entry"),
        (scan.returned, "entry"),
        (gnosphere.MeshPart, "MeshPart: first_triangle"),
        (lambda odd: gnosphere.Material(alpha_image=odd), "Material: alpha_image"),
        (sensor.direction, "Sensor: beam"),
        (lambda odd: gnosphere.beams_of(sensor, odd), "beams_of: frame"),
        (lambda odd: gnosphere.BeamList([[1, 0, 0]], width=odd), "BeamList: width"),
        (lambda odd: gnosphere.BatchStream(reference, odd), "BatchStream: views"),
        (lambda odd: ros2.laser_scan_of(sensor, scan, odd, "f", 0), "laser_scan_of: channel"),
    ):
        for odd in (-1, 2**64):
            with refused(ErrorCode.invalid_argument, f"{name} must be a whole number, 0.."):
                call(odd)


def test_images_and_colours_and_poses_are_named():
    with refused(ErrorCode.invalid_argument, "AlphaImage: alpha cannot be made an array of shape (height, width): V"):
        gnosphere.AlphaImage([[1], [1, 2]])
    with refused(ErrorCode.invalid_argument, "AlphaImage: alpha has the shape (3,); it must be (height, width)"):
        gnosphere.AlphaImage([1, 2, 3])

    array = np.arange(6, dtype=np.uint8).reshape(2, 3)

    class Tensor:
        def __dlpack__(self, **options):
            return array.__dlpack__(**options)

        def __dlpack_device__(self):
            return array.__dlpack_device__()

    assert gnosphere.AlphaImage(Tensor()).alpha.tolist() == array.tolist()
    for color in ((1,), (1, 1), (1, 1, 1, 1, 1)):
        with pytest.raises(ValueError, match=f"red, green, blue and perhaps alpha; .* has {len(color)} numbers"):
            adapter.Shapes().material(color)
    for position, orientation in (((1, 2, 3), np.ma.array([0, 0, 0, 1.0], mask=[1, 0, 0, 0])),
                                  (np.ma.array([1.0, 2, 3], mask=[0, 1, 0]), None)):  # fmt: skip
        with pytest.raises(ValueError, match="a pose has masked entries"):
            adapter.pose_of(position, orientation)
    with pytest.raises(ValueError, match=r"must not be below its base, -1 m, and -5.0 m is"):
        primitives.height_field(-5 * np.ones((2, 2)), 1, 1, 1)


def test_more_beams_than_a_sensor_may_have():
    sensor = gnosphere.Sensor(columns=2**32 - 1, channels=[gnosphere.Channel()] * 3)
    with refused(ErrorCode.invalid_argument, "beams_of: the columns and channels make 12884901885 beams of a s"):
        gnosphere.beams_of(sensor)


def test_zeros_and_nans_are_equal_whatever_their_bytes():
    nothing = np.zeros((3, 4))
    for make in (gnosphere.Transform, lambda rows: gnosphere.Deformation([rows], [rows[0, 0]])):
        assert make(nothing) == make(-nothing) != make(nothing + 1)
        assert hash(make(nothing)) == hash(make(-nothing))
        for nan in (np.nan, -np.nan):
            assert make(nothing + np.nan) == make(nothing + nan)
            assert hash(make(nothing + np.nan)) == hash(make(nothing + nan))
    unit = gnosphere.Transform()
    assert unit == unit.inverse() and len({unit, unit.inverse()}) == 1 and unit != at(1)


def test_messages_take_words_and_square_covariances():
    scan = gnosphere.Scan()
    with refused(ErrorCode.invalid_argument, "driver_cloud_of: driver must be velodyne, ouster, hesai"):
        ros2.driver_cloud_of(scan, "osuter", "f", 0)
    imu = ros2.Imu(0, "f", orientation_covariance=np.diag([1.0, 2, 3]), angular_velocity_covariance=range(9))
    assert list(imu.orientation_covariance) == [1, 0, 0, 0, 2, 0, 0, 0, 3]
    assert list(imu.angular_velocity_covariance) == list(range(9))
    odometry = ros2.Odometry(0, "f", "g", twist_covariance=np.eye(6))
    assert list(odometry.twist_covariance) == np.eye(6).ravel().tolist()
    with refused(ErrorCode.invalid_argument, "Imu: orientation_covariance has 8 numbers; it must have 9, or the sh"):
        ros2.Imu(0, "f", orientation_covariance=[1] * 8)
    with refused(ErrorCode.invalid_argument, "Odometry: pose_covariance has the shape (3, 3); it must be (n,)"):
        ros2.Odometry(0, "f", "g", pose_covariance=np.eye(3))


def test_titles_of_fields_are_no_fields():
    points = np.ones(3, [(("distance in metres", "range"), "f4")])
    assert [field.name for field in ros2.cloud_of_array(points, "f", 0).fields] == ["range"]
    with pytest.raises(ValueError, match="an array of records"):
        ros2.cloud_of_array(np.zeros(3, []), "f", 0)

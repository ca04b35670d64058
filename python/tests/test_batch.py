# SPDX-License-Identifier: Apache-2.0
"""Batches: the bytes of single scans, shapes, memory that is used again, worlds."""

import signal
import subprocess
import sys
import time

import numpy as np
import pytest

import gnosphere
import gnosphere.adapter
from gnosphere import Batch, Effects, Field, SensorRequest, Shot


def square(x: float) -> gnosphere.Mesh:
    corners = np.array([[x, -9, -9], [x, 9, -9], [x, 9, 9], [x, -9, 9]], np.float32)
    return gnosphere.Mesh(corners, np.array([[0, 1, 2], [0, 2, 3]], np.uint32), [gnosphere.MeshPart(0, 2, material=0)])


def small_scene():
    """A square, and two requests of a sensor with 120 beams."""
    sensor = gnosphere.Sensor()
    sensor.columns = 40
    sensor.range_max = 100
    sensor.channels = [gnosphere.Channel(elevation) for elevation in (-10.0, 0.0, 10.0)]
    scene = gnosphere.Scene([gnosphere.Material()], [square(8)], [gnosphere.Instance(0)])
    requests = [SensorRequest(sensor, Effects.none()), SensorRequest(sensor, Effects.none(), fields=[Field.normal])]
    return scene, requests


@pytest.fixture
def simulator(device):
    return gnosphere.Simulator(*small_scene(), gnosphere.SimulatorOptions(device))


def test_views_are_single_scans(simulator):
    near = np.tile([0, 0, 0, 0, 0, 0, 1.0], (3, 1))
    near[:, 0] = [-4, -5, -6]
    added = simulator.add_instances(0, near, worlds=[1, 2, 2])
    assert added.tolist() == [1, 2, 3]
    poses = np.tile([0, 0, 0, 0, 0, 0, 1.0], (5, 1))
    poses[:, 1] = np.arange(5) / 10
    worlds = np.array([0, 1, 2, 1, 7])
    for sensor in (0, 1):
        batch = simulator.scan_batch(poses, sensor=sensor, worlds=worlds, frame=9)
        assert batch.ranges.shape == (5, 120) and batch.points.shape == (5, 120, 3)
        assert batch.views == 5 and batch.beams == 120 and batch.counters.beams == 600
        shots = []
        for view in range(5):
            pose = gnosphere.Pose(poses[view, :3])
            shots.append(Shot(pose, sensor=sensor, frame=9 + view, world=int(worlds[view])))
            scan = gnosphere.Scan()
            simulator.scan_into(shots[view], scan)
            assert batch.ranges[view].tobytes() == scan.ranges.tobytes()
            assert batch.points[view].tobytes() == scan.points.tobytes()
            assert batch.instances[view].tobytes() == scan.instances.tobytes()
            if sensor == 1:
                assert batch.column(Field.normal)[view].tobytes() == scan.column(Field.normal).tobytes()
        assert simulator.scan_batch(shots).ranges.tobytes() == batch.ranges.tobytes()
        assert np.nanmin(batch.ranges[2]) < np.nanmin(batch.ranges[1]) < np.nanmin(batch.ranges[0])
    assert batch.column(Field.y).tobytes() == np.ascontiguousarray(batch.points[..., 1]).tobytes()


def test_the_plan_of_a_batch(simulator):
    one, many = simulator.plan(), simulator.plan(sensor=1, views=5)
    assert one.views == 1
    if not one.stages or one.binning == "lists":
        assert many.views == 1
        return
    assert many.views == 5
    assert many.dispatches() == simulator.plan(1).dispatches()
    assert many.bytes() > simulator.plan(1).bytes()


def test_signals_are_handled_while_a_batch_runs(device):
    """A signal after 0.15 s ends a batch that would take more than 2.4 s. Each view is a submission, because those in
    flight end before the call does."""
    options = gnosphere.SimulatorOptions(device)
    options.tuning.max_batch_bytes = 1
    simulator = gnosphere.Simulator(*small_scene(), options)
    count, took = 256, 0.0
    while took < 0.3:
        count *= 2
        poses = np.tile([0, 0, 0, 0, 0, 0, 1.0], (count, 1))
        poses[:, 0] = np.arange(count) / count
        for _ in range(2):  # the first run may compile kernels, in which no signal is seen
            start = time.perf_counter()
            simulator.scan_batch(poses, fields=[Field.range])
            took = time.perf_counter() - start
    handled = []

    def stop(*_):
        handled.append(time.perf_counter())
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGALRM, stop)
    try:
        start = time.perf_counter()
        signal.setitimer(signal.ITIMER_REAL, 0.15)
        with pytest.raises(KeyboardInterrupt):
            simulator.scan_batch(np.tile(poses, (8, 1)), fields=[Field.range])
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
    assert len(handled) == 1 and time.perf_counter() - start < 4 * took
    assert simulator.scan_batch(poses[:3]).views == 3


def test_memory_is_used_again(simulator):
    poses = np.tile([0, 0, 0, 0, 0, 0, 1.0], (4, 1))
    poses[:, 0] = np.arange(4)
    batch = Batch()
    simulator.scan_batch_into(poses, batch, fields=[Field.range])
    assert not batch.has(Field.x)
    address = batch.ranges.__array_interface__["data"][0]
    simulator.scan_batch_into(poses, batch, fields=[Field.range])
    assert batch.ranges.__array_interface__["data"][0] == address
    held = batch.ranges
    copy = held.copy()
    simulator.scan_batch_into(poses + [1, 0, 0, 0, 0, 0, 0], batch, fields=[Field.range])
    assert held.tobytes() == copy.tobytes() != batch.ranges.tobytes()
    shown = np.from_dlpack(batch.ranges)
    assert shown.__array_interface__["data"][0] == batch.ranges.__array_interface__["data"][0]


def test_errors_name_the_shot(simulator):
    poses = np.tile([0, 0, 0, 0, 0, 0, 1.0], (4, 1))
    poses[2, 1] = np.nan
    with pytest.raises(gnosphere.Error, match="shot 2: the pose has a value that is not finite"):
        simulator.scan_batch(poses)
    with pytest.raises(gnosphere.Error, match="worlds has 2 entries; it must be one number, or have 4"):
        simulator.scan_batch(poses, worlds=[1, 2])
    with pytest.raises(gnosphere.Error, match="field 'intensity', which sensor 0 does not report"):
        simulator.scan_batch(poses[:2], fields=[Field.intensity])
    with pytest.raises(gnosphere.Error, match="mesh 4 does not exist"):
        simulator.add_instances(4, poses[:2])


def test_numbers_of_numpy_are_numbers(simulator):
    poses = np.tile([0, 0, 0, 0, 0, 0, 1.0], (2, 1))
    simulator.add_instances(np.int64(0), poses + [-4, 0, 0, 0, 0, 0, 0], worlds=np.array(3), class_ids=np.uint16(2))
    expected = simulator.scan_batch(poses, worlds=3).ranges.tobytes()
    for world in (np.int64(3), np.uint8(3), np.array(3), [3, 3]):
        assert simulator.scan_batch(poses, worlds=world).ranges.tobytes() == expected
    for wrong in (-1, 2**32, 1.5, "a"):
        with pytest.raises((gnosphere.Error, TypeError)):
            simulator.scan_batch(poses, worlds=wrong)


def test_shots_are_shots_poses_or_an_array(simulator):
    array = np.tile([0, 0, 0, 0, 0, 0, 1.0], (3, 1))
    array[:, 0] = np.arange(3)
    poses = [gnosphere.Pose(row[:3], row[3:]) for row in array]
    expected = simulator.scan_batch(array, sensor=1, worlds=[0, 1, 2], frame=5).column(Field.normal).tobytes()
    for given in (poses, tuple(poses), array.tolist(), array.astype(np.float32)):
        batch = simulator.scan_batch(given, sensor=1, worlds=[0, 1, 2], frame=5)
        assert batch.column(Field.normal).tobytes() == expected
    assert simulator.scan_batch([]).views == 0
    wanted = "it must be a sequence, such as a list, of Shot or of Pose, or an array of shape"
    for given, sentence in (
        ([Shot(), poses[0]], "scan_batch: shots: entry 0 is of the type Shot, but entry 1 of the type Pose; all must"),
        ([poses[0], None], "scan_batch: shots: entry 0 is of the type Pose, but entry 1 of the type NoneType"),
        ((pose for pose in poses), f"scan_batch: shots is a generator; {wanted}"),
        (Shot(), f"scan_batch: shots is a Shot; {wanted}"),
        (poses[0], f"scan_batch: shots is a Pose; {wanted}"),
        (len, f"scan_batch: shots is a builtin_function_or_method; {wanted}"),
    ):
        with pytest.raises(TypeError, match=sentence):
            simulator.scan_batch(given)
    with pytest.raises(gnosphere.Error, match=r"scan_batch: shots has the shape \(3, 6\); it must be \(n, 7\)"):
        simulator.scan_batch(array[:, :6])


def test_worlds_that_are_none(simulator):
    poses = np.tile([0, 0, 0, 0, 0, 0, 1.0], (2, 1))
    for worlds, sentence in (
        (-1, "scan_batch: worlds holds -1, which does not fit the type uint32"),
        (2**32, "scan_batch: worlds holds 4294967296, which does not fit"),
        (1.0, "scan_batch: worlds has the type float64; it must hold integers"),
        ("a", "scan_batch: worlds has the type <U1; it must hold integers"),
        ([0, -1], "scan_batch: worlds holds -1"),
    ):
        with pytest.raises(gnosphere.Error, match=sentence):
            simulator.scan_batch(poses, worlds=worlds)


def test_a_frame_number_has_the_same_noise_each_time(device):
    effects = Effects.none()
    effects.range_noise.use, effects.range_noise.sigma = gnosphere.EffectUse.on, 0.05
    sensor = gnosphere.Sensor(range_max=100, columns=40, channels=[gnosphere.Channel()])
    scene = gnosphere.Scene([gnosphere.Material()], [square(8)], [gnosphere.Instance(0)])
    noisy = gnosphere.Simulator(scene, SensorRequest(sensor, effects), gnosphere.SimulatorOptions(device))
    poses = np.tile([0, 0, 0, 0, 0, 0, 1.0], (2, 1))
    first = noisy.scan_batch(poses).ranges
    assert noisy.scan_batch(poses).ranges.tobytes() == first.tobytes()
    assert noisy.scan_batch(poses, frame=2).ranges.tobytes() != first.tobytes()
    assert noisy.scan_batch(poses, frame=1).ranges[0].tobytes() == first[1].tobytes() != first[0].tobytes()
    assert noisy.scan(gnosphere.Pose()).ranges.tobytes() == first[0].tobytes()


def test_a_batch_has_the_names_of_its_fields(simulator):
    poses = np.tile([0, 0, 0, 0, 0, 0, 1.0], (2, 1))
    batch = simulator.scan_batch(poses, sensor=1, fields=[Field.normal])
    assert {"range", "normal"} <= set(batch.keys()) and "x" not in batch.keys()
    assert "normal" in batch and "intensity" not in batch and "nonsense" not in batch
    assert batch["normal"].tobytes() == batch.column(Field.normal).tobytes() and batch["normal"].shape == (2, 120, 3)
    assert batch["range"].flags.writeable and batch.column(Field.normal).flags.writeable
    with pytest.raises(KeyError, match="the batch has no field 'intensity'; it has .*range.*`fields` of scan_batch"):
        batch["intensity"]
    with pytest.raises(gnosphere.Error, match=r"the batch does not have the field 'x'; .*fields=\[Field.x\]") as error:
        batch.points
    assert error.value.code == gnosphere.ErrorCode.invalid_argument
    with pytest.raises(gnosphere.Error, match=r"fields=\[Field.class_id\]"):
        batch.column(Field.class_id)


TOO_LARGE = """
import resource
import numpy as np
import gnosphere
sensor = gnosphere.Sensor(range_max=100, patterns=[gnosphere.BeamList(np.tile([1.0, 0, 0], (2**20, 1)))])
request = gnosphere.SensorRequest(sensor, gnosphere.Effects.none())
simulator = gnosphere.Simulator(gnosphere.Scene(), request)
poses = np.tile([0, 0, 0, 0, 0, 0, 1.0], (2048, 1))
simulator.scan_batch(poses[:1], fields=[gnosphere.Field.range])
used = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (used + 3 * 2**30, -1))
try:
    simulator.scan_batch(poses, fields=[gnosphere.Field.range])
except gnosphere.Error as error:
    print(error.code.name, error)
print(simulator.scan_batch(poses[:1], fields=[gnosphere.Field.range]).ranges.shape)
"""


def test_a_batch_that_does_not_fit_into_the_memory():
    """Ranges of 8 GiB where 3 GiB are left: an Error, and the simulator can be used."""
    done = subprocess.run([sys.executable, "-c", TOO_LARGE], capture_output=True, text=True, timeout=300, check=False)
    first, last = done.stdout.splitlines() or [done.stderr, ""]
    assert first.startswith("out_of_memory scan_batch: the host has no memory for the results of 2048 views; scan fewer")
    assert last == "(1, 1048576)"


def test_shots_have_their_own_sensor_world_and_frame(simulator):
    for more in ({"sensor": 1}, {"worlds": 2}, {"worlds": [2]}, {"frame": 9}, {"ignored_instances": [[0]]}):
        with pytest.raises(gnosphere.Error, match="scan_batch: each Shot has its own sensor, world, frame and ignored"):
            simulator.scan_batch([Shot()], **more)


def test_views_ignore_instances(simulator):
    """Each pose its own: an array, lists of several lengths, and those of a Shot."""
    poses = np.tile([0, 0, 0, 0, 0, 0, 1.0], (3, 1))
    near = poses.copy()
    near[:, 0] = [-4, -5, -6]
    one, two, three = simulator.add_instances(0, near).tolist()
    lists = [[one, two, three], [two], []]

    def seen(batch):
        return [set(of[hit].tolist()) for of, hit in zip(batch.instances, np.isfinite(batch.ranges))]

    batch = simulator.scan_batch(poses, ignored_instances=lists)
    assert seen(batch) == [{0}, {three}, {three}]
    shots = [Shot(frame=view, ignored_instances=ignored) for view, ignored in enumerate(lists)]
    assert simulator.scan_batch(shots).ranges.tobytes() == batch.ranges.tobytes()
    assert shots[0].ignored_instances == (one, two, three)
    for array in (np.array([[three], [two], [0]]), np.array([[three], [two], [0]], np.uint8).tolist()):
        batch = simulator.scan_batch(poses, ignored_instances=array)
        assert seen(batch) == [{two}, {three}, {three}]
    none = gnosphere.NO_TRIANGLE  # fills up rows
    padded = [[one, two, three], [none, two, none], [none, none, none]]
    for filled in (padded, np.array(padded), np.array(padded, np.uint32), [*padded[:2], [none]]):
        assert seen(simulator.scan_batch(poses, ignored_instances=filled)) == [{0}, {three}, {three}]
    for wrong, sentence in (
        ([[0]], "scan_batch: ignored_instances has 1 entries; it must have 3"),
        ([[0], [-1], []], "scan_batch: ignored_instances: entry 1 holds -1, which does not fit"),
        (np.zeros((2, 1), int), "scan_batch: ignored_instances has 2 entries; it must have 3"),
        ([0, 1, 2], "scan_batch: ignored_instances: entry 0 has the shape \\(\\); it must be \\(n,\\)"),
        ([[0], [9], []], "shot 1: it ignores an instance, but instance 9 does not exist"),
    ):
        with pytest.raises(gnosphere.Error, match=sentence):
            simulator.scan_batch(poses, ignored_instances=wrong)


def test_many_instances_are_removed_together_or_not_at_all(simulator):
    poses = np.tile([0, 0, 0, 0, 0, 0, 1.0], (3, 1))
    near = poses.copy()
    near[:, 0] = [-4, -5, -6]

    def seen():
        return set(np.unique(simulator.scan(gnosphere.Pose()).instances).tolist()) - {gnosphere.NO_TRIANGLE}

    added = simulator.add_instances(0, near)
    one, two, three = added.tolist()
    assert seen() == {three}
    added[:] = added[::-1].copy()  # an array of the caller's
    for wrong, sentence in (
        ([one, 99], "entry 1: instance 99 does not exist"),
        ([one, two, one], f"entry 2: instance {one} stands in an entry before it, too; name it once"),
        ([-1], "remove_instances: instances holds -1, which does not fit"),
        ([[one]], "remove_instances: instances has the shape"),
    ):
        with pytest.raises(gnosphere.Error, match=sentence):
            simulator.remove_instances(wrong)
    assert seen() == {three}
    simulator.remove_instances([])
    simulator.remove_instances(added[:2])  # three, two
    assert seen() == {one}
    assert simulator.add_instances(0, near[1:]).tolist() == [three, two]
    assert seen() == {two}


def test_a_batch_shows_the_fields_that_it_has(simulator):
    text = repr(simulator.scan_batch(np.array([[0, 0, 0, 0, 0, 0, 1.0]]), fields=[Field.range]))
    assert text.startswith("Batch(") and "ranges=<1 x 120 float32>" in text and "points" not in text


def test_a_batch_without_views_is_one_of_its_sensor(simulator):
    """Also when sensor 0 is gone: it has the sensor's shape, and the fields that were asked for."""
    one, none = np.array([[0, 0, 0, 0, 0, 0, 1.0]]), np.zeros((0, 7))
    every = {"x", "y", "z", "range", "triangle", "instance"}
    for shots in (none, []):
        empty, batch = simulator.scan_batch(shots, sensor=1), simulator.scan_batch(one, sensor=1)
        assert (empty.sensor, empty.views, empty.beams) == (batch.sensor, 0, 120)
        assert empty.keys() == batch.keys() and {"normal", *every} <= set(empty.keys()) and "intensity" not in empty
        for name in empty.keys():
            assert empty[name].shape == (0, *batch[name].shape[1:]) and empty[name].dtype == batch[name].dtype
        assert set(simulator.scan_batch(shots).keys()) - {"tie", "tolerance"} == every
        assert simulator.scan_batch(shots, sensor=1, fields="normal").keys() == ("range", "normal")
        assert simulator.scan_batch(shots, fields="instance").keys() == ("range", "instance")
        with pytest.raises(gnosphere.Error, match="field 'normal', which sensor 0 does not report"):
            simulator.scan_batch(shots, fields="normal")
    simulator.remove_sensor(0)
    into = Batch()
    simulator.scan_batch_into(none, into, sensor=1, fields="x")
    assert into.keys() == ("x", "y", "z", "range") and into.points.shape == (0, 120, 3)
    for sensor in (0, 7):
        with pytest.raises(gnosphere.Error, match=f"sensor {sensor} "):
            simulator.scan_batch(none, sensor=sensor)


def test_a_new_batch_has_ranges_alone():
    assert Batch().keys() == ("range",) and Batch()["range"].shape == (0, 0)


def test_poses_of_a_batch_are_rigid_maps_too(simulator):
    poses = np.tile([1.0, 2, 0, 0, 0, 0, 1], (40, 1))
    poses[:, 3:] = np.random.default_rng(5).normal(size=(40, 4))
    poses[:4, 3:] = np.eye(4)  # half turns about each axis, and none
    maps = np.array([gnosphere.adapter.rows_of(gnosphere.Pose(pose[:3], pose[3:])) for pose in poses])
    expected = simulator.scan_batch(poses, sensor=1)
    for given in (maps, maps[:, :3], maps.tolist(), maps.astype(np.float32)):
        batch = simulator.scan_batch(given, sensor=1)
        assert np.isfinite(batch.ranges).any()
        seen = np.isfinite(batch.ranges) & np.isfinite(expected.ranges)
        assert seen.sum() > 0.99 * np.isfinite(expected.ranges).sum()
        np.testing.assert_allclose(batch.ranges[seen], expected.ranges[seen], rtol=1e-3)
    for wrong, sentence in (
        (np.diag([1, -1, 1, 1.0]), "shots: entry 1 is no pose; the first three columns of its rows must be a rotation"),
        (np.diag([2, 2, 2, 1.0]), "entry 1 is no pose"),
        (np.eye(4) + np.eye(4, k=1) * [[1], [0], [0], [0]], "entry 1 is no pose"),
        (np.full((4, 4), np.nan) * np.diag([1, 1, 1, 0]), "shots"),
        (np.zeros((4, 4)), r"the last row of entry 1 is \[0.0, 0.0, 0.0, 0.0\]"),
    ):
        with pytest.raises(gnosphere.Error, match=sentence):
            simulator.scan_batch(np.array([np.eye(4), wrong]))


def test_numbers_below_0_are_named(simulator):
    for call, sentence in (
        (lambda: simulator.scan_batch([], frame=-1), "scan_batch: frame must be a whole number, 0.*, is -1"),
        (lambda: simulator.scan_batch([], sensor=-1), "scan_batch: sensor must be a whole number, 0.*, is -1"),
        (lambda: simulator.scan(gnosphere.Pose(), -1), "scan: sensor must be a whole number, 0.*, is -1"),
        (lambda: simulator.plan(-1), "plan: sensor must be a whole number"),
        (lambda: simulator.remove_instance(-1), "remove_instance: instance must be a whole number"),
        (lambda: simulator.set_transform(-1, gnosphere.Transform()), "set_transform: instance must be a whole number"),
    ):
        with pytest.raises(gnosphere.Error, match=sentence):
            call()

# SPDX-License-Identifier: Apache-2.0
"""Batches whose results stay on the device, against batches on the host."""

import gc
import os
import pickle
import weakref

import numpy as np
import pytest

import gnosphere
from gnosphere import BatchStream, Effects, Field, SensorRequest, SimulatorOptions


@pytest.fixture
def request_of_normals():
    sensor = gnosphere.Sensor()
    sensor.columns = 40
    sensor.range_max = 100
    sensor.channels = [gnosphere.Channel(elevation) for elevation in (-10.0, 0.0, 10.0)]
    return SensorRequest(sensor, Effects.none(), fields=[Field.instance, Field.x, Field.normal, Field.class_id])


@pytest.fixture
def scene():
    corners = np.array([[8, -9, -9], [8, 9, -9], [8, 9, 9], [8, -9, 9]], np.float32)
    parts = [gnosphere.MeshPart(0, 2, material=0)]
    mesh = gnosphere.Mesh(corners, np.array([[0, 1, 2], [0, 2, 3]], np.uint32), parts)
    return gnosphere.Scene([gnosphere.Material()], [mesh], [gnosphere.Instance(0)])


@pytest.fixture
def options(device):
    if device.kind != gnosphere.DeviceChoice.Kind.vulkan:
        pytest.skip("results stay on Vulkan devices only")
    return SimulatorOptions(device, results_on_device=True)


def poses(count: int, offset: float) -> np.ndarray:
    made = np.tile([0, 0, 0, 0, 0, 0, 1.0], (count, 1))
    made[:, 1] = offset + np.arange(count) / 10
    return made


def test_batches_in_flight_are_those_of_the_host(scene, request_of_normals, options):
    on_device = gnosphere.Simulator(scene, request_of_normals, options)
    on_host = gnosphere.Simulator(scene, request_of_normals, SimulatorOptions(options.device))
    stream = BatchStream(on_device, views=5, in_flight=2, to_host=True)
    expected = {}
    for number in range(6):
        for each in (on_device, on_host):
            each.set_transform(0, gnosphere.Transform([[1, 0, 0, number / 4], [0, 1, 0, 0], [0, 0, 1, 0]]))
        assert stream.submit(poses(5, number), frame=10 * number) == number
        expected[number] = on_host.scan_batch(poses(5, number), frame=10 * number)
        if number == 0:
            continue
        batch = stream.wait(number - 1)
        host = expected[batch.number]
        assert batch.complete and batch.views == 5 and batch.beams == 120 and batch.returns == 1
        assert batch.ranges.shape == (5, 120) and batch.ranges.tobytes() == host.ranges.tobytes()
        assert batch.points.shape == (5, 120, 3) and batch.points.tobytes() == host.points.tobytes()
        assert batch.hits.tolist() == np.isfinite(host.ranges).sum(axis=1).tolist()
        for field in (Field.x, Field.z, Field.instance, Field.normal, Field.class_id):
            assert batch.has(field)
            assert batch.column(field).tobytes() == host.column(field).tobytes(), field
    with pytest.raises(gnosphere.Error, match="the results of batch 3 are gone"):
        stream.wait(3)
    assert batch.number == 4 and batch.ranges.shape == (5, 120)
    assert "hits=<5 uint32>" in repr(batch) and "points=" in repr(batch)
    last = stream.wait(5)
    for frame in (60, 70):
        stream.submit(poses(5, 0), frame=frame)
    for stale in (batch, last):  # their buffers have later batches
        with pytest.raises(gnosphere.Error, match=f"the results of batch {stale.number} are gone"):
            stale.column(Field.range)
        assert "ranges" not in repr(stale)
    assert stream.wait(6).ranges.shape == (5, 120)
    with pytest.raises(gnosphere.Error, match="does not have the field 'intensity'"):
        stream.wait(7).column(Field.intensity)


def test_a_batch_has_the_shape_of_its_sensor_whichever_gets_the_index(scene, request_of_normals, options):
    """The array of a sensor of 200,000 columns would reach far beyond the records of 40."""
    simulator = gnosphere.Simulator(scene, request_of_normals, options)
    stream = BatchStream(simulator, views=2, in_flight=2, to_host=True)
    before = stream.wait(stream.submit(poses(2, 0)))
    expected = {name: before[name].copy() for name in ("range", "normal")}
    places = stream.places()

    def check(batch):
        assert (batch.sensor, batch.beams, batch.returns) == (0, 120, 1)
        assert batch.places == places and len(batch.layout.values) == 1 + 1 + 3 + 3 + 1
        assert "normal" in batch and batch.points.shape == (2, 120, 3)
        for name, values in expected.items():
            assert batch[name].tobytes() == values.tobytes() and batch[name].shape == values.shape

    number = stream.submit(poses(2, 0))
    simulator.remove_sensor(0)
    check(stream.wait(number))
    large = gnosphere.Sensor(range_max=9, columns=200000, channels=[gnosphere.Channel()])
    assert simulator.add_sensor(SensorRequest(large, Effects.none())) == 0
    batch = stream.wait(number)
    check(batch)
    assert stream.places().rows_per_view == 200000
    batch.hits[0] = 7  # a copy, which can be written as every array of a batch
    assert batch.hits.tolist() == np.isfinite(batch.ranges).sum(axis=1).tolist()


def test_an_array_keeps_its_memory(scene, request_of_normals, options):
    stream = BatchStream(gnosphere.Simulator(scene, request_of_normals, options), views=2, to_host=True)
    ranges = stream.wait(stream.submit(poses(2, 0))).ranges
    copy = ranges.copy()
    shown = np.from_dlpack(ranges)
    del stream, ranges
    gc.collect()
    assert shown.tobytes() == copy.tobytes()


def test_memory_is_handed_out(scene, request_of_normals, options):
    stream = BatchStream(gnosphere.Simulator(scene, request_of_normals, options), views=2)
    layout = stream.layout()
    assert [value.field for value in layout.values][:2] == [Field.range, Field.instance] and layout.stride == 0
    strides = {Field.range: 4, Field.instance: 4, Field.x: 12, Field.normal: 12, Field.class_id: 2}  # bytes
    assert {value.field: value.stride for value in layout.values if value.field in strides} == strides
    assert pickle.loads(pickle.dumps(layout)) == layout
    batch = stream.wait(stream.submit(poses(2, 0)))
    try:
        memory = stream.export_memory(batch.buffer)
    except gnosphere.Error as error:
        assert "does not export memory" in str(error)
    else:
        assert memory.bytes >= stream.places().bytes >= 2 * stream.places().bytes_per_view
        os.close(memory.fd)
    try:
        column = batch.cuda_column(Field.range)
    except gnosphere.Error as error:
        assert "CUDA cannot have the results" in str(error)
    else:
        assert column.__dlpack_device__()[0] == 2  # kDLCUDA


def test_misuse_has_a_sentence(scene, request_of_normals, options):
    simulator = gnosphere.Simulator(scene, request_of_normals, options)
    with pytest.raises(gnosphere.Error, match="so a BatchStream submits its scans"):
        simulator.scan(gnosphere.Pose())
    with pytest.raises(gnosphere.Error, match="results_on_device"):
        BatchStream(gnosphere.Simulator(scene, request_of_normals, SimulatorOptions(options.device)), views=2)
    stream = BatchStream(simulator, views=2)
    with pytest.raises(gnosphere.Error, match="has a BatchStream already"):
        BatchStream(simulator, views=2)
    with pytest.raises(gnosphere.Error, match="the batch has 3 shots; the stream is made for 2"):
        stream.submit(poses(3, 0))
    with pytest.raises(gnosphere.Error, match="submit: worlds has 3 entries"):
        stream.submit(poses(2, 0), worlds=[1, 2, 3])
    del stream
    gc.collect()
    BatchStream(simulator, views=2)


def test_a_streamed_batch_has_the_names_of_its_fields(scene, request_of_normals, options):
    stream = BatchStream(gnosphere.Simulator(scene, request_of_normals, options), views=2, to_host=True)
    batch = stream.wait(stream.submit([gnosphere.Pose(), gnosphere.Pose((1, 0, 0))]))
    assert {"range", "instance", "x", "normal", "class"} <= set(batch.keys())
    assert "normal" in batch and "intensity" not in batch
    assert batch["normal"].tobytes() == batch.column(Field.normal).tobytes()
    with pytest.raises(KeyError, match="the batch has no field 'intensity'"):
        batch["intensity"]


def test_a_stream_whose_simulator_warns_its_owner_is_freed(scene, request_of_normals, options):
    class Owner:
        def __init__(self):
            options.warn = self.warn
            self.simulator = gnosphere.Simulator(scene, request_of_normals, options)
            options.warn = None
            self.stream = BatchStream(self.simulator, views=2, to_host=True)
            self.batch = self.stream.wait(self.stream.submit(poses(2, 0)))

        def warn(self, sentence):
            pass

    gone = weakref.ref(Owner())
    gc.collect()
    assert gone() is None


def test_a_batch_without_views_is_one_of_its_sensor(scene, request_of_normals, options):
    small = SensorRequest(gnosphere.Sensor(range_max=9, columns=5, channels=[gnosphere.Channel()]), Effects.none())
    simulator = gnosphere.Simulator(scene, [request_of_normals, small], options)
    stream = BatchStream(simulator, views=3, to_host=True)
    for sensor, beams in ((1, 5), (0, 120)):
        batch = stream.wait(stream.submit(np.zeros((0, 7)), sensor=sensor))
        assert (batch.sensor, batch.views, batch.beams) == (sensor, 0, beams)
        assert batch.ranges.shape == (0, beams) and (Field.normal in batch) == ("normal" in batch) == (sensor == 0)
    simulator.remove_sensor(0)
    assert stream.wait(stream.submit([], sensor=1)).beams == 5
    for sensor in (0, 7):
        with pytest.raises(gnosphere.Error, match=f"there is no sensor {sensor}"):
            stream.submit([], sensor=sensor)
    with pytest.raises(gnosphere.Error, match="submit: frame must be a whole number, 0.*, is -1"):
        stream.submit([], sensor=1, frame=-1)

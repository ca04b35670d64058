# SPDX-License-Identifier: Apache-2.0
"""Messages of ROS 2. What is on the wire is tested from C++; here only what Python adds."""

import copy
import os
import pickle
import re
import subprocess
import sys

import numpy as np
import pytest
from conftest import REPOSITORY

import gnosphere
from gnosphere import ros2

os.environ["ROS_LOCALHOST_ONLY"] = "1"
needs_wire = pytest.mark.skipif(ros2.unavailable() != "", reason="no libgnosphere_ros2")


def test_messages_and_settings_are_values():
    qos = ros2.Qos(depth=7)
    assert pickle.loads(pickle.dumps(qos)) == qos != ros2.Qos()
    assert repr(qos) == "Qos(depth=7)" and repr(ros2.Clock(5)) == "Clock(time=5)"
    imu = ros2.Imu(5, "imu", angular_velocity=(0, 0, 1), linear_acceleration=[0, 0, 9.8])
    assert pickle.loads(pickle.dumps(imu)) == imu != ros2.Imu(5, "imu") and imu.linear_acceleration == (0, 0, 9.8)
    assert imu.orientation == (0, 0, 0, 1) and list(imu.orientation_covariance) == [0] * 9
    odometry = ros2.Odometry(5, "odom", "base_link", gnosphere.Pose((1, 2, 3)), linear_velocity=(4, 0, 0))
    assert pickle.loads(pickle.dumps(odometry)) == odometry != ros2.Odometry(5, "odom", "base_link")
    assert odometry.child_frame == "base_link" and odometry.linear_velocity == (4, 0, 0)
    assert list(odometry.twist_covariance) == [0] * 36
    assert copy.deepcopy(ros2.Clock(5)) == ros2.Clock(5) != ros2.Clock(6)
    assert hash(copy.deepcopy(imu)) == hash(imu) and len({odometry, copy.deepcopy(odometry)}) == 1
    laser = ros2.LaserScan()
    laser.ranges = [float("nan"), 2]
    assert copy.deepcopy(laser) == laser != ros2.LaserScan()


@needs_wire
def test_times_beyond_the_seconds_of_ros_are_refused():
    clock = ros2.Publisher(ros2.MessageType.clock, "clock")
    clock.publish(ros2.Clock(-(2**31) * 10**9))
    for time in (2**31 * 10**9, -(2**31) * 10**9 - 1):
        with pytest.raises(gnosphere.Error, match=f"Clock::time is {time} ns, and ROS has 32 bits for seconds"):
            clock.publish(ros2.Clock(time))


FORKED = """
import os, sys
from gnosphere import ros2
publisher = ros2.Publisher(ros2.MessageType.clock, "clock")
publisher.publish(ros2.Clock(5))
child = os.fork()
if child == 0:
    wrong = [lambda: publisher.publish(ros2.Clock(6)), publisher.counts, lambda: publisher.flush(1),
             lambda: ros2.Publisher(ros2.MessageType.clock, "other")]
    refused = 0
    for call in wrong:
        try:
            call()
        except Exception as error:
            refused += "forked" in str(error)
    del publisher
    sys.exit(refused)
print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), publisher.flush(5))
"""


@needs_wire
def test_a_forked_process_is_refused_and_ends():
    result = subprocess.run([sys.executable, "-W", "ignore", "-c", FORKED], capture_output=True, text=True, timeout=60)
    assert result.stdout == "4 True\n", result.stderr


def test_an_array_of_records_becomes_a_cloud():
    dtype = np.dtype({"names": ["x", "normal", "ring"], "formats": ["<f4", ("<f4", 3), "<u2"], "offsets": [0, 4, 16],
                      "itemsize": 20})  # fmt: skip
    points = np.zeros((2, 3), dtype)
    points["ring"][1, 2] = 7
    cloud = ros2.cloud_of_array(points, "top", 5)
    assert (cloud.height, cloud.width, cloud.point_step, cloud.frame, cloud.stamp) == (2, 3, 20, "top", 5)
    assert [(f.name, f.offset, f.type.name, f.count) for f in cloud.fields] == [
        ("x", 0, "f32", 1), ("normal", 4, "f32", 3), ("ring", 16, "u16", 1)]  # fmt: skip
    assert cloud.data == points.tobytes()
    with pytest.raises(ValueError, match="records"):
        ros2.cloud_of_array(np.zeros(3), "top", 0)
    with pytest.raises(ValueError, match="the field t has the type"):
        ros2.cloud_of_array(np.zeros(3, [("t", "<i8")]), "top", 0)


def test_the_rows_of_an_array_are_dense_unless_they_are_not():
    points = np.array([(1.5, 2), (2.5, 3)], [("x", "<f8"), ("n", "u1")])
    cloud = ros2.cloud_of_array(points, "top", 5)
    assert (cloud.height, cloud.width, cloud.point_step, cloud.dense) == (1, 2, 9, True)
    assert not ros2.cloud_of_array(points, "top", 5, False).dense
    every_other = np.zeros(4, points.dtype)
    every_other[::2] = points
    assert ros2.cloud_of_array(every_other[::2], "top", 5).data == points.tobytes()
    for wrong in (points.astype([("x", ">f8"), ("n", "u1")]), np.zeros(2, [("x", "?")]), np.zeros(2, [("x", "<f2")])):
        with pytest.raises(ValueError, match="the field x has the type .*, which a PointCloud2 cannot have"):
            ros2.cloud_of_array(wrong, "top", 5)
    with pytest.raises(ValueError, match="records with one or two dimensions"):
        ros2.cloud_of_array(np.zeros((2, 2, 2), points.dtype), "top", 5)


def test_a_scan_becomes_a_cloud_and_a_laser_scan(town, device):
    sensor = gnosphere.builtin_sensor("VLP-16")
    simulator = gnosphere.Simulator(town, [gnosphere.SensorRequest(sensor, gnosphere.Effects.none())],
                                    gnosphere.SimulatorOptions(device=device))  # fmt: skip
    scan = simulator.scan(gnosphere.Pose((0, 0, 1.8)))
    cloud = ros2.cloud_of(scan, [gnosphere.Field.x, gnosphere.Field.ring], "top", 9)
    assert cloud.width == scan.counters.hits and cloud.point_step == 6
    records = np.frombuffer(cloud.data, [("x", "<f4"), ("ring", "<u2")])
    assert (records["x"] == scan.points[~np.isnan(scan.ranges), 0]).all()
    assert ros2.has_laser_scan(sensor, 8) and not ros2.has_laser_scan(sensor, 16)
    laser = ros2.laser_scan_of(sensor, scan, 8, "top", 9)
    assert len(laser.ranges) == sensor.columns and laser.range_max == pytest.approx(sensor.range_max)
    with pytest.raises(gnosphere.Error, match="no channel 16"):
        ros2.laser_scan_of(sensor, scan, 16, "top", 9)


OUSTER = np.dtype(
    {"names": ["x", "t", "ring", "range"], "formats": ["<f4", "<u4", "<u2", "<u4"], "offsets": [0, 20, 26, 32],
     "itemsize": 48}
)  # fmt: skip


def test_a_scan_becomes_the_cloud_of_a_driver(town, device):
    def scan(fields):
        request = gnosphere.SensorRequest(gnosphere.builtin_sensor("Puck"), gnosphere.Effects.none(), fields=fields)
        return gnosphere.Simulator(town, request, gnosphere.SimulatorOptions(device)).scan(gnosphere.Pose((0, 0, 1.8)))

    with pytest.raises(gnosphere.Error, match="'time'"):
        ros2.driver_cloud_of(scan(""), ros2.Driver.ouster, "top", 9)
    timed = scan("time,ring")
    cloud = ros2.driver_cloud_of(timed, ros2.Driver.ouster, "top", 9, gnosphere.Effects.none())
    points = np.frombuffer(cloud.data, OUSTER)
    assert cloud.stamp == 9 and len(points) == timed.counters.hits
    hits = np.flatnonzero(~np.isnan(timed.ranges))
    order = hits[np.argsort(timed["time"][hits], kind="stable")]
    assert (np.diff(points["t"].astype(np.int64)) >= 0).all() and points["t"][-1] > 90_000_000
    assert (points["x"] == timed.points[order, 0]).all() and (points["ring"] == timed["ring"][order]).all()
    assert np.abs(points["range"] / 1000 - timed.ranges[order]).max() < 6e-4


@needs_wire
def test_messages_are_sent():
    options = ros2.Qos(durability=ros2.Qos.Durability.transient_local, depth=1)
    publisher = ros2.Publisher(ros2.MessageType.transforms, "/tf_static", options, domain=99)
    publisher.publish([ros2.StampedTransform(1, "map", "base_link", gnosphere.Pose((1, 2, 3)))])
    assert publisher.flush(10)
    counts = publisher.counts()
    assert (counts.published, counts.sent, counts.dropped, counts.waiting) == (1, 1, 0, 0)
    with pytest.raises(gnosphere.Error, match="another type"):
        publisher.publish(ros2.Clock(5))
    with pytest.raises(gnosphere.Error, match="no name of a topic"):
        ros2.Publisher(ros2.MessageType.clock, "a b")
    with pytest.raises(gnosphere.Error, match="depth"):
        ros2.Publisher(ros2.MessageType.clock, "clock", ros2.Qos(depth=0))


@needs_wire
def test_the_page_of_ros2(reference):
    """The block of docs/ros2.md publishes both of its clouds."""
    block = re.search(r"^```python\n(.*?)^```$", (REPOSITORY / "docs" / "ros2.md").read_text(), re.M | re.S)[1]
    records = np.array([(1, 2, 3), (4, 5, 6)], [("x", "f4"), ("y", "f4"), ("z", "f4")])
    names: dict = {"scan": reference.scan(gnosphere.Pose()), "stamp": 1_700_000_000 * 10**9, "records": records}
    exec(compile(block, "docs/ros2.md", "exec"), names)
    assert names["points"].flush(10)
    assert (names["points"].counts().published, names["points"].counts().dropped) == (2, 0)

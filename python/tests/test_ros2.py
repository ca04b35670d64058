# SPDX-License-Identifier: Apache-2.0
"""Messages of ROS 2. What is on the wire is tested from C++; here only what Python adds."""

import os

import numpy as np
import pytest

import gnosphere
from gnosphere import ros2

os.environ["ROS_LOCALHOST_ONLY"] = "1"
needs_wire = pytest.mark.skipif(ros2.unavailable() != "", reason="no libgnosphere_ros2")


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


def test_a_scan_becomes_a_cloud_and_a_laser_scan(town, device):
    sensor = gnosphere.builtin_sensor("VLP-16")
    simulator = gnosphere.Simulator(town, [gnosphere.SensorRequest(sensor, gnosphere.Effects.none())],
                                    gnosphere.SimulatorOptions(device=device))  # fmt: skip
    scan = simulator.scan(gnosphere.Pose((0, 0, 1.8)))
    cloud = ros2.cloud_of(scan, [gnosphere.Field.x, gnosphere.Field.ring], "top", 9)
    assert cloud.width == scan.counters.hits and cloud.point_step == 6
    records = np.frombuffer(cloud.data, [("x", "<f4"), ("ring", "<u2")])
    assert (records["x"] == scan.points[~np.isnan(scan.ranges), 0]).all()
    laser = ros2.laser_scan_of(sensor, scan, 8, "top", 9)
    assert len(laser.ranges) == sensor.columns and laser.range_max == pytest.approx(sensor.range_max)
    with pytest.raises(gnosphere.Error, match="no channel 16"):
        ros2.laser_scan_of(sensor, scan, 16, "top", 9)


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

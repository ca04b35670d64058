# SPDX-License-Identifier: Apache-2.0
"""Scans: the same bytes as the command line's, views that keep their memory, packed rows, files."""

import gc
import os
import subprocess
import sys
import warnings

import numpy as np
import pytest
from conftest import at, beams, program

import gnosphere
from gnosphere import Field
from gnosphere.adapter import rows_of


def address(array: np.ndarray) -> int:
    return array.__array_interface__["data"][0]


def same(a: np.ndarray, b: np.ndarray) -> bool:
    return a.dtype == b.dtype and a.tobytes() == b.tobytes()


def test_arrays_and_files_have_the_bytes_of_the_command_line(folder, town, device, tmp_path):
    names = "x,y,z,range,triangle,instance,intensity,normal,ring,class"
    program("scan", folder / "town.glb", "--sensor", "VLP-16", "--pose", "1,2,1.8", "--fields", names, "--device",
            gnosphere.name_of(device), "-o", tmp_path / "cli.npy")  # fmt: skip
    fields = gnosphere.parse_fields(names)
    request = gnosphere.SensorRequest(gnosphere.builtin_sensor("VLP-16"), fields=fields)
    simulator = gnosphere.Simulator(town, request, gnosphere.SimulatorOptions(device))
    scan = simulator.scan(gnosphere.Pose((1, 2, 1.8)))

    rows = np.load(tmp_path / "cli.npy").ravel()
    assert len(rows) == len(scan.ranges) == 28800
    assert np.count_nonzero(scan.triangles != gnosphere.NO_TRIANGLE) > 10000
    for i, axis in enumerate("xyz"):
        assert same(rows[axis], scan.points[:, i])
        assert same(rows[axis], scan.column(Field.normal)[:, i]) is False
        assert same(rows["normal_" + axis], scan.column(Field.normal)[:, i])
    assert same(rows["range"], scan.ranges)
    assert same(rows["triangle"], scan.triangles)
    assert same(rows["instance"], scan.instances)
    for field in (Field.intensity, Field.ring, Field.class_id):
        assert same(rows[gnosphere.field_info(field).name], scan.column(field))

    gnosphere.write_cloud(scan, tmp_path / "python.npy", gnosphere.CloudOptions(fields))
    assert (tmp_path / "python.npy").read_bytes() == (tmp_path / "cli.npy").read_bytes()
    read = gnosphere.read_cloud(tmp_path / "cli.npy")
    assert same(read.points, scan.points)
    assert gnosphere.compare(scan, read).same()
    gnosphere.write_picture(scan, tmp_path / "cloud.png")
    assert (tmp_path / "cloud.png").read_bytes().startswith(b"\x89PNG")


def test_a_view_keeps_its_memory_after_the_scan_is_deleted(simulator, pose):
    scan = simulator.scan(pose)
    views = [scan.points, scan.ranges, scan.triangles, scan.instances] + [
        scan.column(field) for field in (Field.x, Field.normal, Field.intensity, Field.ring)
    ]
    slices = [view[::7] for view in views]
    copies = [view.copy() for view in slices]
    del scan, views
    gc.collect()
    churn = [simulator.scan(gnosphere.Pose((x, 0, 1.8))) for x in range(1, 6)]  # into memory that is free
    for kept, copied in zip(slices, copies, strict=True):
        assert same(kept, copied)
    assert len(churn) == 5


def test_views_are_not_copies_and_go_on_by_dlpack(simulator, pose):
    scan = simulator.scan(pose)
    assert address(scan.points) == address(scan.points) == address(scan.column(Field.x))
    assert address(scan.column(Field.y)) == address(scan.points) + 4
    assert scan.column(Field.x).strides == (12,)
    assert np.shares_memory(np.from_dlpack(scan.ranges), scan.ranges)
    assert np.shares_memory(np.from_dlpack(scan.points), scan.column(Field.z))
    normal = scan.column(Field.normal)
    assert normal.shape == (28800, 3) and not normal.flags.writeable
    scan.points[0] = 7  # as in C++, the arrays that every scan has can be written
    assert scan.column(Field.z)[0] == 7
    held = memoryview(scan.ranges)
    del scan
    gc.collect()
    assert held.nbytes == 4 * 28800


def test_scan_into_uses_its_arrays_again_unless_a_view_is_held(simulator, pose):
    scan = gnosphere.Scan()
    assert scan.points.shape == (0, 3) and scan.ranges.shape == (0,)
    simulator.scan_into(gnosphere.Shot(pose), scan)
    first = address(scan.points)
    simulator.scan_into(gnosphere.Shot(pose), scan)
    assert address(scan.points) == first

    held = scan.points
    copied = held.copy()
    simulator.scan_into(gnosphere.Shot(gnosphere.Pose((5, 0, 1.8))), scan)
    assert same(held, copied)
    assert address(scan.points) != first
    assert not same(scan.points, copied)


def test_a_failed_scan_into_leaves_a_scan_that_can_be_used(simulator, pose):
    scan = simulator.scan(pose)
    with pytest.raises(gnosphere.Error, match="sensor"):
        simulator.scan_into(gnosphere.Shot(pose, sensor=7), scan)
    simulator.scan_into(gnosphere.Shot(pose), scan)
    assert scan.beam_count() == 28800


def test_scan_all_gives_what_scan_gives_and_what_is_kept_stays(simulator):
    poses = [gnosphere.Pose((x, 0, 1.8)) for x in range(6)]
    kept = []
    simulator.scan_all([gnosphere.Shot(pose) for pose in poses], lambda shot, scan: kept.append((shot, scan)))
    assert [shot for shot, _ in kept] == list(range(6))
    assert len({address(scan.points) for _, scan in kept}) == 6
    for (_, scan), pose in zip(kept, poses, strict=True):
        assert same(scan.points, simulator.scan(pose).points)

    addresses = []
    simulator.scan_all([gnosphere.Shot(pose) for pose in poses], lambda _, scan: addresses.append(address(scan.points)))
    assert len(set(addresses)) == 1


def test_scan_all_passes_an_exception_on(simulator, pose):
    calls = []

    def receive(shot, scan):
        calls.append(shot)
        raise KeyError("mine")

    with pytest.raises(KeyError, match="mine"):
        simulator.scan_all([gnosphere.Shot(pose)] * 3, receive)
    assert calls == [0]
    assert simulator.scan(pose).beam_count() == 28800


def test_pack_fills_a_structured_array(simulator, pose):
    scan = simulator.scan(pose)
    layout = gnosphere.layout_of([Field.x, Field.y, Field.z, Field.ring])
    layout.compact = True
    rows = np.zeros(len(scan.ranges), np.dtype("<f4,<f4,<f4,<u2"))
    assert layout.stride == rows.itemsize == 14
    rows = rows[: gnosphere.pack(scan, layout, rows)]
    returned = ~np.isnan(scan.ranges)
    assert len(rows) == returned.sum()
    assert same(rows["f1"], scan.points[returned, 1])
    assert same(rows["f3"], scan.column(Field.ring)[returned])

    value = gnosphere.RecordLayout.Value(Field.normal, 2, 4, gnosphere.ValueType.f64)
    layout = gnosphere.RecordLayout([value], stride=16)
    doubles = np.zeros((len(scan.ranges), 2))
    with pytest.raises(gnosphere.Error, match="460800"):
        gnosphere.pack(scan, layout, doubles[1:].copy())
    gnosphere.pack(scan, layout, doubles.view(np.uint8).ravel())
    assert layout.values[0].component == 2
    with pytest.raises(gnosphere.Error, match="contiguous"):
        gnosphere.pack(scan, layout, doubles[:, ::2])


def test_memory_stays_the_same(town, device):
    def resident() -> int:
        with open("/proc/self/statm", encoding="ascii") as file:
            return int(file.read().split()[1]) * 4096

    sensor = gnosphere.builtin_sensor("VLP-16")
    sensor.columns = 180
    request = gnosphere.SensorRequest(sensor, fields=[Field.normal])
    simulator = gnosphere.Simulator(town, request, gnosphere.SimulatorOptions(device))

    def scans(count: int) -> None:
        for i in range(count // 4):
            scan = simulator.scan(gnosphere.Pose((0.01 * i, 0, 1.8)))
            views = scan.points[::9], scan.column(Field.normal)
            simulator.scan_into(gnosphere.Shot(frame=i), scan)
            assert len(views) == 2
            simulator.scan_all([gnosphere.Shot(frame=i)] * 2, lambda _, made: made.ranges)

    scans(40)
    before = resident()
    scans(2000)
    # A view that leaked would keep 2880 x 40 bytes; 1000 of them are 115 MB.
    assert resident() - before < 16e6


def test_a_scan_tells_what_happened(simulator, pose):
    scan = simulator.scan(pose)
    assert (scan.sensor, scan.columns, scan.channels, scan.returns) == ("VLP-16", 1800, 16, 1)
    assert scan.pose.position == (0, 0, 1.8)
    counters = scan.counters
    assert counters.beams == counters.hits + counters.misses == scan.beam_count()
    assert len(counters.causes) == len(gnosphere.Cause)
    assert scan.timings.wall_ms > 0
    entry = int(np.flatnonzero(scan.triangles != gnosphere.NO_TRIANGLE)[0])
    assert scan.hit(entry) and scan.returned(entry)
    with pytest.raises(gnosphere.Error, match="28800"):
        scan.hit(28800)
    plan = simulator.plan()
    assert [decision.effect for decision in plan.effects] == list(gnosphere.effect_names())
    assert plan.has("intensity") and next(d for d in plan.effects if d.effect == "intensity").in_
    assert plan.bytes() == sum(buffer.bytes for buffer in plan.buffers)
    assert simulator.device().name


def test_columns_by_name(simulator, pose):
    scan = simulator.scan(pose)
    assert same(scan["ring"], scan.column(Field.ring)) and scan["ring"].max() == 15
    assert same(scan["range"], scan.ranges) and scan["normal"].shape == (28800, 3)
    assert same(scan["class"], scan.column(Field.class_id))
    assert scan["range"].reshape(scan.shape).shape == scan.shape == (16, 1800)
    assert {"x", "range", "ring", "intensity", "class"} <= set(scan.keys())
    assert list(scan) == list(scan.keys()) and set(dict(scan)) == set(scan)
    assert "intensity" in scan and "velocity" not in scan and "no" not in scan
    with pytest.raises(KeyError, match="the scan has no field 'rnage'; it has x, y, z, range, "):
        scan["rnage"]


def test_a_scan_says_what_it_is(simulator, pose):
    scan = simulator.scan(pose)
    returns = np.isfinite(scan.ranges).sum()
    assert repr(scan).startswith(f"<Scan of VLP-16: 16 x 1800 beams, {returns} returns from ")
    assert repr(gnosphere.Scan()) == "<Scan without beams>"


def test_without_a_vulkan_driver_one_line_names_the_package_that_brings_one(folder, tmp_path):
    absent = {"VK_DRIVER_FILES": "/nonexistent", "VK_ICD_FILENAMES": "/nonexistent"}
    words = [sys.executable, "-m", "gnosphere", "scan", str(folder / "town.glb"), "-o", str(tmp_path / "a.pcd")]
    done = subprocess.run(words, env=os.environ | absent, capture_output=True, text=True)
    assert done.returncode == 1
    assert done.stderr.endswith("pip install 'gnosphere[cpu]' brings one that runs on the CPU\n"), done.stderr
    assert done.stderr.count("\n") == 1


def test_in_world_maps_points_normals_and_velocities_by_the_pose(simulator, town):
    pose = gnosphere.Pose((3, -2, 1.8), (0, 0, 0.6, 0.8))
    scan = simulator.scan(pose)
    before = scan.points.copy()
    world = scan.in_world()
    turned = np.array([[0.28, -0.96, 0], [0.96, 0.28, 0], [0, 0, 1]])
    np.testing.assert_allclose(world.points, scan.points @ turned.T + pose.position, rtol=0, atol=2e-5)
    np.testing.assert_allclose(world["normal"], scan["normal"] @ turned.T, rtol=0, atol=1e-6)
    assert world.pose == gnosphere.Pose() and scan.pose == pose
    assert np.array_equal(world.ranges, scan.ranges, equal_nan=True)
    assert np.array_equal(scan.points, before, equal_nan=True)
    low, high = np.nanmin(world.points, 0), np.nanmax(world.points, 0)
    bounds = gnosphere.world_bounds(town)
    assert (low > np.array(bounds.min) - 1e-3).all() and (high < np.array(bounds.max) + 1e-3).all()


def test_points_and_files_that_have_steps_of_single_precision_are_warned_of(square, reference, tmp_path):
    far = gnosphere.Pose((500_000.25, 6_000_000.25, 100), (0, 0, 0.6, 0.8))
    to_world = rows_of(far)
    scene = gnosphere.Scene(
        [gnosphere.Material()], [square], [gnosphere.Instance(0, gnosphere.Transform(to_world) * at(10))]
    )
    scan = gnosphere.Simulator(scene, beams(), gnosphere.SimulatorOptions(device="reference")).scan(far)
    steps = "in single precision, which has steps of 0.5 m at 6000010 m; "
    with pytest.warns(UserWarning) as told:
        world = scan.in_world()
    assert [str(one.message).startswith(f"points in the world frame are {steps}the scan's") for one in told] == [True]
    assert told[0].filename == __file__
    doubles = scan.points.astype(float) @ to_world[:3, :3].T + scan.pose.position
    assert 0.1 < np.abs(world.points - doubles).max() < 0.26
    np.testing.assert_allclose((doubles - far.position) @ [0.28, 0.96, 0], 10, atol=1e-6)  # the square
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(UserWarning, match="single precision"):
            scan.in_world()
        reference.scan(gnosphere.Pose()).in_world()

    corners = "".join(f"vertex {x} 6000000 0\n" for x in (0, 1)) + "vertex 0 6000001 0\n"
    stl, obj = tmp_path / "far.stl", tmp_path / "far.obj"
    stl.write_text(f"solid\nfacet normal 0 0 1\nouter loop\n{corners}endloop\nendfacet\nendsolid\n")
    with pytest.warns(UserWarning) as told:
        assert len(gnosphere.load_scene(stl).meshes) == 1
    steps = steps.replace("6000010", "6000001")
    assert [str(one.message).startswith(f"{stl}: its positions are {steps}give them in") for one in told] == [True]
    assert told[0].filename == __file__
    obj.write_text("v 0 6000000 0\nv 1 6000000 0\nv 0 6000001 0\nf 1 2 3\n")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(UserWarning, match="single precision"):
            gnosphere.load_scene(stl)
        gnosphere.load_scene(stl, gnosphere.LoadOptions(scale=0.001))
        gnosphere.load_scene(obj)


def test_a_new_scan_has_what_every_scan_has():
    scan = gnosphere.Scan()
    assert scan.keys() == ("x", "y", "z", "range", "triangle", "instance")
    assert scan["x"].shape == scan.ranges.shape == (0,) and scan.has(Field.y)
    for name in ("intensity", "normal", "tie", "class"):
        assert name not in scan and not scan.has(name)


def test_fields_have_either_spelling(reference):
    """The names of columns, those of Field, and Field itself."""
    for field in map(Field, range(27)):
        column = gnosphere.field_info(field).name
        assert gnosphere.parse_fields(column) == gnosphere.parse_fields(field.name) == (field,)
    with pytest.raises(gnosphere.Error, match="'class' is asked for twice|'class_id' is asked for twice"):
        gnosphere.parse_fields("class,class_id")
    scan, batch = reference.scan(gnosphere.Pose()), reference.scan_batch(np.array([[0, 0, 0, 0, 0, 0, 1.0]]))
    for result in (scan, batch):
        wanted = result.column(Field.class_id)
        for name in ("class", "class_id", Field.class_id):
            assert name in result and result.has(name)
            assert same(result[name], wanted) and same(result.column(name), wanted)
        assert Field.x in result and same(result[Field.range], result.ranges)
        for name in ("intensity", Field.intensity, "nonsense", None, 3):
            assert name not in result
        with pytest.raises(KeyError, match="has no field 'intensity'; it has"):
            result[Field.intensity]
        with pytest.raises(gnosphere.Error, match="no field is called 'rnge'; the nearest are range"):
            result.column("rnge")
        with pytest.raises(
            TypeError, match="a field is a Field or the name of one, such as 'intensity', and not an int"
        ):
            result[0]
        assert result._ipython_key_completions_() == list(result.keys())


def test_a_cloud_without_points_has_the_fields_of_its_file(tmp_path):
    (tmp_path / "empty.csv").write_text("range,intensity,class\n")
    scan = gnosphere.read_cloud(tmp_path / "empty.csv")
    assert scan.beam_count() == 0 and scan.keys() == ("range", "intensity", "class")
    gnosphere.write_cloud(scan, tmp_path / "again.csv", gnosphere.CloudOptions("range,class_id"))
    assert (tmp_path / "again.csv").read_text() == "range,class\n"

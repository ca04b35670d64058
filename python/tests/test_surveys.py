# SPDX-License-Identifier: Apache-2.0
"""The blocks of docs/surveys.md."""

import re
import shutil
import struct

import numpy as np
import pytest
from conftest import REPOSITORY

import gnosphere
from gnosphere.adapter import rows_of


def block(words: str) -> str:
    """The only block of Python that has these words."""
    blocks = re.findall(r"^```python\n(.*?)^```$", (REPOSITORY / "docs" / "surveys.md").read_text(), re.M | re.S)
    (found,) = (one for one in blocks if words in one)
    return found


def axes(orientation: np.ndarray) -> np.ndarray:
    """The axes of a vehicle, as columns, by its quaternion x, y, z, w."""
    x, y, z, w = orientation
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def test_a_trajectory_of_sbet_has_its_axes_on_the_grid(tmp_path, monkeypatch):
    """North and east on the grid are where small steps of latitude and longitude go; zone 32 has its meridian at 9 degrees."""
    pyproj = pytest.importorskip("pyproj")
    pytest.importorskip("scipy")
    monkeypatch.chdir(tmp_path)
    # Roll, pitch, heading and wander of an aircraft that flies north, and of one that banks, climbs and flies elsewhere.
    angles = np.array([(0, 0, 0, 0), (0.2, 0.1, 0, 0), (0, 0, 1.9, 0.3), (-0.1, 0.05, 1.2, 0)])
    records = np.zeros((4, 17))
    records[:, 0] = 345600.25 + np.arange(4)
    records[:, 1], records[:, 2], records[:, 3] = np.radians([48, 51.5, 51.5, 54]), np.radians([9, 7, 11.5, 6.1]), 812.5
    records[:, 7:11] = angles
    records.tofile("sbet.out")
    exec(compile(block("sbet.out"), "docs/surveys.md", "exec"), {})
    lines = np.loadtxt("line.tum")
    assert np.allclose(lines[:, 0], records[:, 0], rtol=0, atol=1e-6) and (lines[:, 3] == 812.5).all()
    utm = pyproj.Transformer.from_crs(4258, 25832, always_xy=True).transform
    for line, record, (roll, pitch, heading, wander) in zip(lines, records, angles):
        lat, lon = np.degrees(record[1]), np.degrees(record[2])
        assert np.allclose(line[1:3], utm(lon, lat), rtol=0, atol=1e-5)
        north = np.subtract(utm(lon, lat + 1e-5), utm(lon, lat - 1e-5))
        east = np.subtract(utm(lon + 1e-5, lat), utm(lon - 1e-5, lat))
        north, east = np.r_[north / np.linalg.norm(north), 0], np.r_[east / np.linalg.norm(east), 0]
        level = np.cos(heading - wander) * north + np.sin(heading - wander) * east
        right = np.cross(level, (0, 0, 1))
        forward = np.cos(pitch) * level + np.sin(pitch) * np.array([0, 0, 1])
        # The right side is down, so the left one is up.
        left = -np.cos(roll) * right + np.sin(roll) * np.cross(right, forward)
        assert np.allclose(axes(line[4:])[:, :2].T, [forward, left], rtol=0, atol=1e-5)


def test_a_flight_log_of_px4_has_its_poses(tmp_path, monkeypatch):
    """A log of three messages, of a drone that looks east, one that looks north and up, and one whose right side is down."""
    pytest.importorskip("pyulog")
    pytest.importorskip("scipy")
    monkeypatch.chdir(tmp_path)

    def message(kind: bytes, content: bytes) -> bytes:
        return struct.pack("<H", len(content)) + kind + content

    half = np.sqrt(0.5)
    poses = [
        ((1, 2, -3), (half, 0, 0, half)),  # a quarter turn about down, from north to east
        ((4, 5, -6), (np.cos(0.1), 0, np.sin(0.1), 0)),  # nose up by 0.2
        ((7, 8, -9), (np.cos(0.15), np.sin(0.15), 0, 0)),  # right side down by 0.3
    ]
    log = b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 0)
    members = b"uint64_t timestamp;uint64_t timestamp_sample;float[3] position;float[4] q;"
    log += message(b"F", b"vehicle_odometry:" + members) + message(b"A", struct.pack("<BH", 0, 0) + b"vehicle_odometry")
    for number, (position, quaternion) in enumerate(poses):
        log += message(b"D", struct.pack("<HQQ7f", 0, 5_000_000, 1_250_000 + 20_000 * number, *position, *quaternion))
    (tmp_path / "flight.ulg").write_bytes(log)
    exec(compile(block("flight.ulg"), "docs/surveys.md", "exec"), {})
    lines = np.loadtxt("flight.tum")
    assert np.allclose(lines[:, :4], [[1.25, 2, 1, 3], [1.27, 5, 4, 6], [1.29, 8, 7, 9]], rtol=0, atol=1e-6)
    east, north, up = np.eye(3)
    expected = (  # forward and left
        (east, north),
        (np.cos(0.2) * north + np.sin(0.2) * up, -east),
        (north, -np.cos(0.3) * east + np.sin(0.3) * up),
    )
    for line, columns in zip(lines, expected):
        assert np.allclose(axes(line[4:])[:, :2].T, columns, rtol=0, atol=1e-6)


def test_stations_of_e57_have_rows_and_local_bounds_and_noise_of_their_own(folder, tmp_path, monkeypatch):
    pye57 = pytest.importorskip("pye57")
    monkeypatch.chdir(tmp_path)
    shutil.copyfile(folder / "town.glb", tmp_path / "town.glb")
    names: dict = {}
    exec(compile(block("pye57"), "docs/surveys.md", "exec"), names)
    file = pye57.E57("stations.e57")
    assert file.scan_count == 2
    request, noises = names["request"], []
    request.fields = "true_range"
    simulator = gnosphere.Simulator(gnosphere.load_scene("town.glb"), request)
    for number, pose in enumerate(names["stations"]):
        scan = simulator.scan(gnosphere.Shot(pose, frame=number))
        seen = ~np.isnan(scan.ranges)
        read = file.read_scan(number, intensity=True, row_column=True, ignore_missing_fields=True)
        beams = np.flatnonzero(seen)
        np.testing.assert_array_equal(read["rowIndex"], beams // 1024)
        np.testing.assert_array_equal(read["columnIndex"], beams % 1024)
        points = np.column_stack([read[f"cartesian{axis}"] for axis in "XYZ"])
        doubles = scan.points[seen].astype(float) @ rows_of(pose)[:3, :3].T + pose.position
        np.testing.assert_allclose(points, doubles, atol=8e-6)
        header = file.get_header(number)
        assert header["name"].value() == f"station {number}"
        bounds = [[getattr(header, f"{axis}{end}") for axis in "xyz"] for end in ("Minimum", "Maximum")]
        np.testing.assert_allclose(bounds, [np.nanmin(scan.points, 0), np.nanmax(scan.points, 0)], atol=1e-4)
        noises.append(scan.ranges - scan["true_range"])
    both = ~np.isnan(noises[0] + noises[1])
    assert abs(np.corrcoef(noises[0][both], noises[1][both])[0, 1]) < 0.05


def put_building(path) -> None:
    """An IFC file in millimetres with a slab of 8 x 6 m, and a pane of glass that stands on it."""
    ifcopenshell = pytest.importorskip("ifcopenshell")
    import ifcopenshell.api

    def run(usecase: str, **keywords):
        return ifcopenshell.api.run(usecase, model, **keywords)

    model = ifcopenshell.file(schema="IFC4")
    run("root.create_entity", ifc_class="IfcProject", name="project")
    run("unit.assign_unit", units=[run("unit.add_si_unit", unit_type="LENGTHUNIT", prefix="MILLI")])
    context = run("context.add_context", context_type="Model")
    body = run("context.add_context", context_type="Model", context_identifier="Body", target_view="MODEL_VIEW",
               parent=context)  # fmt: skip
    styles = {}
    for name, transparency in (("concrete", 0.0), ("glass", 0.8)):
        styles[name] = run("style.add_style", name=name)
        colour = {"Name": None, "Red": 0.4, "Green": 0.4, "Blue": 0.4}
        attributes = {"SurfaceColour": colour, "Transparency": transparency, "ReflectanceMethod": "NOTDEFINED"}
        run("style.add_surface_style", style=styles[name], ifc_class="IfcSurfaceStyleRendering", attributes=attributes)
    for name, kind, style, corner, size in (
        ("floor", "IfcSlab", "concrete", (0, 0, -0.3), (8, 6, 0.3)),
        ("pane", "IfcWindow", "glass", (7, 0, 0), (0.02, 6, 3)),
    ):
        element = run("root.create_entity", ifc_class=kind, name=name)
        x, y, z = (1000.0 * side for side in size)
        middle = model.createIfcAxis2Placement2D(model.createIfcCartesianPoint((x / 2, y / 2)))
        solid = model.createIfcExtrudedAreaSolid(
            model.createIfcRectangleProfileDef("AREA", None, middle, x, y),
            model.createIfcAxis2Placement3D(model.createIfcCartesianPoint((0.0, 0.0, 0.0))),
            model.createIfcDirection((0.0, 0.0, 1.0)),
            z,
        )
        shape = model.createIfcShapeRepresentation(body, "Body", "SweptSolid", [solid])
        run("geometry.assign_representation", product=element, representation=shape)
        run("style.assign_representation_styles", shape_representation=shape, styles=[styles[style]])
        place = np.eye(4)
        place[:3, 3] = corner
        run("geometry.edit_object_placement", product=element, matrix=place, is_si=True)
    model.write(str(path))


def test_a_building_of_ifc_is_scanned_in_parts(tmp_path, monkeypatch):
    pytest.importorskip("ifcopenshell")
    monkeypatch.chdir(tmp_path)
    put_building(tmp_path / "building.ifc")
    exec(compile(block("ifcopenshell"), "docs/surveys.md", "exec"), {})
    scene = gnosphere.load_scene("building.glb")
    assert [instance.name for instance in scene.instances] == ["floor", "pane"]
    bounds = gnosphere.world_bounds(scene)
    np.testing.assert_allclose([bounds.min, bounds.max], [(0, 0, -0.3), (8, 6, 3)], atol=1e-6)
    panoramas = block("patterns.panorama")
    assert "(0.006, at=10" in panoramas
    names: dict = {}
    exec(compile(panoramas.replace("(0.006, at=10", "(0.2, at=10"), "docs/surveys.md", "exec"), names)
    assert [path.name for path in sorted(tmp_path.glob("*.pcd"))] == [f"part-{part}.pcd" for part in range(8)]
    whole = gnosphere.patterns.panorama(0.2, at=10, turn=(157.5, 180))
    assert names["scan"].shape == (len(whole.channels), whole.columns)
    effects = names["simulator"].add_sensor(names["scanner"])
    assert {one.effect: one.in_ for one in names["simulator"].plan(effects).effects}["transmission"]

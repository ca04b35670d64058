# SPDX-License-Identifier: Apache-2.0
"""The blocks of docs/surveys.md that scan stations."""

import re
import shutil

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

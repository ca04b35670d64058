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

# SPDX-License-Identifier: Apache-2.0
"""Surfaces of HELIOS++ reflect what it reads of their materials: helios_reflectance, or 50 % without it."""

import numpy as np
import pytest
from helios_surveys import LIBRARY, made, write_surveys

from gnosphere import helios

CORNERS = "v -3 10 -2\nv 3 10 -2\nv 3 10 2\nv -3 10 2\n"


@pytest.fixture
def surveys(tmp_path):
    return write_surveys(tmp_path)


@pytest.mark.parametrize(
    ("plate", "library", "reflectance"),
    [
        (CORNERS + "f 1 2 3 4\n", "", 0.5),
        (f"mtllib m.mtl\n{CORNERS}usemtl nowhere\nf 1 2 3 4\n", "", 0.5),
        (f"mtllib no.mtl\n{CORNERS}usemtl roof\nf 1 2 3 4\n", "", 0.5),
        (f"mtllib m.mtl\n{CORNERS}usemtl pane\nf 1 2 3 4\n", "newmtl pane\nd 0.0\nhelios_reflectance 40\n", 0.4),
        (f"mtllib m.mtl\n{CORNERS}usemtl pane\nf 1 2 3 4\n", "newmtl pane\nTr 0.7\nillum 4\nTf 1 1 1\n", 0.5),
    ],
)
@pytest.mark.filterwarnings("ignore:.*which cannot be read")
def test_a_plate_reflects_and_hides_the_ground(surveys, plate, library, reflectance):
    (surveys / "data" / "plate.obj").write_text(plate)
    (surveys / "data" / "m.mtl").write_text(LIBRARY.split("newmtl roof")[0] + library)
    survey = helios.read_survey(surveys / "air.xml")
    assert not survey.left_out
    # The second line flies above y 0 and z 105.7, and sweeps across; the plate is 90.7 m below.
    points, intensities, *_ = made(survey.write(surveys / "out")[1], surveys / "two")
    on_plate = abs(points[:, 2] - 15) < 0.2
    assert on_plate.sum() >= 10
    cosine = 90.7 / np.hypot(90.7, points[on_plate, 1])
    assert np.median(intensities[on_plate] / cosine) == pytest.approx(reflectance, rel=0.01)
    # The shadow of the plate is 100.7 m below the head, and the plate spans 4 x 6 m around (0, 30).
    ground = points[abs(points[:, 2] - 5) < 0.2]
    behind = (abs(ground[:, 0]) < 1.5) & (abs(ground[:, 1] * 90.7 / 100.7 - 30) < 2.5)
    assert len(ground) > 1000 and not behind.any()


def test_what_is_left_out_of_materials(surveys):
    text = LIBRARY.replace("newmtl roof\n", "newmtl roof\nKs 0.5 0.5 0.5\nNs 10\n").replace("Kd 1 1 1\n", "Ks 0 0 0\n")
    (surveys / "data" / "m.mtl").write_text(text)
    with pytest.warns(UserWarning, match="mirror-like reflections"):
        survey = helios.read_survey(surveys / "air.xml")
    # One of the library's two materials has a lobe, and the files of both parts name the library.
    assert survey.left_out == {"mirror-like reflections of materials (Ks, Ns)": 2}

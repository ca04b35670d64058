# SPDX-License-Identifier: Apache-2.0
"""Surveys of HELIOS++ become drives whose points are where the survey's geometry says."""

import json
import os
import re
import signal
import subprocess
import sys

import numpy as np
import pytest
from helios_surveys import AIRBORNE, SCANNERS, SCENE, made, write_surveys

from gnosphere import Error, drive, helios


@pytest.fixture
def surveys(tmp_path):
    return write_surveys(tmp_path)


def test_flight_lines(surveys):
    survey = helios.read_survey(surveys / "air.xml")
    assert (survey.name, survey.leg_count, [leg.number for leg in survey.legs]) == ("lines", 4, [0, 2])
    assert not survey.left_out
    # 100 m at 30 m/s are 133.3 lines of 40 a second; 50 pulses each, of which those within 20 of 45 degrees leave.
    first, second = survey.legs
    assert first.duration == pytest.approx(133 / 40)
    assert first.sensor.beam_count() * round(first.duration * first.drive["rate"]) == 133 * 23
    # The leg that does not scan takes 50 m at 30 m/s.
    assert second.drive["start"] == pytest.approx(150 / 30)
    files = survey.write(surveys / "out")
    assert [file.name for file in files] == ["leg-000.json", "leg-002.json"]

    points, intensities, classes, *_ = made(files[0], surveys / "one")
    assert len(points) == 133 * 23 and set(classes) == {2}
    assert abs(points[:, 2] - 5).max() < 0.15 and points[:, 2].std() == pytest.approx(0.02, rel=0.1)
    # The head is 0.7 m above the aircraft, which flies to the east over y -50, and its lines are across.
    half = (105.7 - 5) * np.tan(np.radians(19.8))
    assert points[:, 1].min() == pytest.approx(-50 - half, abs=0.1)
    assert points[:, 1].max() == pytest.approx(-50 + half, abs=0.1)
    assert points[:, 0].min() == pytest.approx(-30, abs=0.5) and points[:, 0].max() == pytest.approx(69.75, abs=0.5)
    assert intensities.mean() == pytest.approx(0.3, rel=0.05)
    points, _, classes, *_ = made(files[1], surveys / "two")
    assert points[0, 0] > points[-1, 0]  # it flies back
    plate = points[classes == 6]
    assert len(plate) > 0 and abs(plate[:, 2] - 15).max() < 0.15
    assert (abs(plate[:, 0]) < 2.1).all() and (abs(plate[:, 1] - 30) < 3.1).all()


def test_names_that_drives_do_not_take(surveys):
    (surveys / "air.xml").write_text(AIRBORNE.replace('name="lines"', 'name="Flüge 1/2"'), encoding="utf-8")
    survey = helios.read_survey(surveys / "air.xml")
    assert survey.name == "Flüge 1/2"
    assert [leg.drive["name"] for leg in survey.legs] == ["Fl_ge_1_2-leg-0", "Fl_ge_1_2-leg-2"]
    drive.read_drive(survey.write(surveys / "out")[0])


def test_a_sector_of_a_tripod(surveys):
    survey = helios.read_survey(surveys / "ground.xml")
    (leg,) = survey.legs
    assert leg.duration == pytest.approx(12, abs=1e-4)  # 120 degrees at 10 a second
    # A scan takes at most 10 s, so there are two, with the 20 lines of a second in each.
    assert leg.sensor.columns == 120 and leg.sensor.azimuth_span_deg == pytest.approx(60)
    assert leg.sensor.scan_period == pytest.approx(6, abs=1e-4)
    waypoint = leg.drive["ego"]["trajectory"]["waypoints"][0]
    assert waypoint["position"] == [0, 0, 5]  # on the ground, to the north
    assert waypoint["orientation"] == pytest.approx([0, 0, 0.5**0.5, 0.5**0.5])
    (file,) = survey.write(surveys / "out")
    points, _, classes, *_ = made(file, surveys / "one")
    # Angles of the head are counter-clockwise from north.
    turn = np.degrees(np.arctan2(-points[:, 0], points[:, 1]))
    assert turn.min() > -30.5 and turn.max() < 90.5 and np.ptp(turn) > 119
    up = np.degrees(np.arctan2(points[:, 2] - 6.7, np.hypot(points[:, 0], points[:, 1])))
    assert up.min() == pytest.approx(-39, abs=1) and up.max() < 30
    assert {2, 6} == set(classes) and abs(points[classes == 6][:, 2] - 15).max() < 0.01


def test_what_is_left_out(surveys):
    text = AIRBORNE.replace("#aircraft", "#copter").replace(
        "</survey>", '<FWFSettings binSize_ns="0.2" beamSampleQuality="4"/></survey>'
    )
    (surveys / "air.xml").write_text(text)
    with pytest.warns(UserWarning, match="leaves out speeding up, slowing down and turning of a 'multicopter'"):
        survey = helios.read_survey(surveys / "air.xml")
    assert survey.left_out["noise of the platform's attitude"] == survey.left_out["settings of full waveforms"] == 1


def test_what_is_left_out_of_the_scanner(surveys):
    stated = {"atmosphericVisibility_km": 5, "averagePower_w": 4, "receiverDiameter_m": 0.15, "wavelength_nm": 905}
    words = " ".join(f'{name}="{value}"' for name, value in stated.items())
    (surveys / "data" / "scanners.xml").write_text(SCANNERS.replace('id="polygon"', f'id="polygon" {words}'))
    with pytest.warns(UserWarning, match="averagePower_w of the scanner"):
        survey = helios.read_survey(surveys / "air.xml")
    # Two legs have the scanner, whose wavelength is that of the intensities.
    names = ("atmosphericVisibility_km", "averagePower_w", "receiverDiameter_m")
    assert survey.left_out == {f"{name} of the scanner": 1 for name in names}


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("#polygon", "#none", "has no <scanner> whose id is 'none'"),
        ("#polygon", "#prism", "risley optics"),
        ("data/scene.xml", "data/none.xml", "'data/none.xml' is in none of the folders"),
        ('scanFreq_hz="40"', 'scanFreq_hz="fast"', "leg 0: scanFreq_hz of <scannerSettings> is 'fast', which is no number"),
        ('scanFreq_hz="40"', 'scanFreq_hz="400"', "those of the scanner 'polygon' are 10 to 200"),
        ('movePerSec_m="30"', 'movePerSec_m="0"', "movePerSec_m is 0, so the platform never arrives"),
        ('<platformSettings template="fast" x="-30"', '<platformSettings trajectory="t.txt"', "a recorded trajectory"),
        ("<survey", "<surveys><survey", "is not XML"),
    ],
)  # fmt: skip
def test_mistakes(surveys, old, new, sentence):
    (surveys / "air.xml").write_text(AIRBORNE.replace(old, new))
    with pytest.raises(ValueError, match=r"(?s).*") as told:
        helios.read_survey(surveys / "air.xml")
    assert sentence in str(told.value) and not isinstance(told.value, Error)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ([("<part>", "<thing>"), ("</part>", "</thing>")], "the scene 'data/scene.xml#yard' has no <part>"),
        ([('<scene id="yard">', '<scene id="yard"><part/>')], "part 0 of the scene has no file"),
        (
            [('type="objloader"', 'type="objloder"')],
            "part 0 of the scene has a filter 'objloder'; objloader, scale, rotate and translate are read",
        ),
        ([('type="objloader"', 'type="scale"')], "part 0 of the scene has a filter 'scale' before there is a file"),
        ([('key="filepath"', 'key="efilepath"')], "part 0 of the scene has no 'filepath'; patterns of files"),
        ([('key="scale"', 'key="factor"')], "part 0 of the scene: the filter 'scale' has no 'scale'"),
        ([('value="0;0;5"', 'value="0;5"')], "part 0 of the scene: the offset has 2 numbers"),
    ],
)
def test_mistakes_in_scenes(surveys, changes, sentence):
    text = SCENE
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    (surveys / "data" / "scene.xml").write_text(text)
    with pytest.raises(ValueError, match=re.escape(sentence)):
        helios.read_survey(surveys / "air.xml")


def test_surveys_without_legs_that_scan(surveys):
    for text, sentence in (
        (AIRBORNE.replace("<survey ", "<plan ").replace("</survey>", "</plan>"), "air.xml has no <survey>"),
        (re.sub("<leg>.*</leg>", "", AIRBORNE, flags=re.S), "air.xml: the survey has no <leg>"),
        (AIRBORNE.replace('active="true"', 'active="false"'), "air.xml: no leg scans"),
    ):
        (surveys / "air.xml").write_text(text)
        with pytest.raises(ValueError, match=re.escape(sentence)):
            helios.read_survey(surveys / "air.xml")


def test_scenes_that_are_no_triangles(surveys):
    (surveys / "data" / "scene.xml").write_text(SCENE.replace("objloader", "geotiffloader", 1))
    with pytest.raises(ValueError, match="part 0 of the scene is read by 'geotiffloader'; only triangles are"):
        helios.read_survey(surveys / "air.xml")


def test_the_command(surveys):
    command = [sys.executable, "-m", "gnosphere.helios", surveys / "ground.xml", "-o", surveys / "out"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0 and "survey stations: 1 of 1 legs scan" in done.stdout, done.stderr
    assert json.loads((surveys / "out" / "materials.json").read_text())["materials"][0]["reflectance_905"] == 0.3
    done = subprocess.run([*command[:3], surveys / "no.xml"], capture_output=True, text=True)
    assert done.returncode == 1 and "no.xml" in done.stderr and "Traceback" not in done.stderr


def test_the_command_without_a_reader(surveys):
    reader, writer = os.pipe()
    os.close(reader)
    command = [sys.executable, "-m", "gnosphere.helios", surveys / "ground.xml"]
    done = subprocess.run(command, stdout=writer, stderr=subprocess.PIPE)
    os.close(writer)
    assert (done.returncode, done.stderr) == (-signal.SIGPIPE, b"")  # so does the program `gnosphere`

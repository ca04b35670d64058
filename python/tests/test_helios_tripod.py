# SPDX-License-Identifier: Apache-2.0
"""Tripods of HELIOS++: a head that turns at a constant speed looks at each time where that speed says."""

import numpy as np
import pytest
from helios_surveys import PLATFORMS, TERRESTRIAL, made, write_surveys

from gnosphere import helios


@pytest.fixture
def surveys(tmp_path):
    return write_surveys(tmp_path)


@pytest.mark.parametrize(
    ("start", "stop", "speed", "scans"),
    [
        (-40, 40, 20, 1),  # a turn takes 18 s, the sector 4 s
        (-30, 90, 10, 2),  # 12 s
        (90, -30, -10, 2),  # clockwise
        (0, 360, 20, 2),  # 18 s
        (0, 720, 60, 2),  # turns of 6 s
    ],
)
def test_pulses_have_times_of_their_own(surveys, start, stop, speed, scans):
    text = TERRESTRIAL.replace('headRotateStart_deg="-30"', f'headRotateStart_deg="{start}"')
    text = text.replace('headRotateStop_deg="90"', f'headRotateStop_deg="{stop}"')
    text = text.replace('headRotatePerSec_deg="10"', f'headRotatePerSec_deg="{speed}"')
    (surveys / "ground.xml").write_text(text)
    survey = helios.read_survey(surveys / "ground.xml")
    (leg,) = survey.legs
    duration = (stop - start) / speed
    assert leg.duration == pytest.approx(duration, abs=1e-4)
    assert round(leg.drive["duration"] * leg.drive["rate"]) == scans
    assert leg.sensor.rotation_period <= 10
    (file,) = survey.write(surveys / "out")
    points = made(file, surveys / "one")
    times = points.times - points.times.min()
    # The head has one return, so a pulse has one point; pulses are 0.5 ms apart.
    assert len(np.unique(np.round(times, 5))) == len(times) > 3000
    assert np.ptp(times) == pytest.approx(duration, abs=0.06)  # a line takes 0.05 s
    # The lowest pulse of a line, of -39 degrees, is the 12th: the first point is 11 pulses after the start.
    turn = np.degrees(np.arctan2(-points.xyz[:, 0], points.xyz[:, 1]))  # counter-clockwise from north
    off = (turn - (start + speed * (times + 11 / 2000)) + 180) % 360 - 180
    assert abs(off).max() < 0.04  # a point 2 m away is known to 1 mm


def test_a_head_whose_axis_leans(surveys):
    mount = '<scannerMount x="0.8" y="-0.4" z="1.5"><rot axis="x" angle_deg="-20"/></scannerMount>'
    text = PLATFORMS.replace('<scannerMount z="1.5"/>', mount)
    assert text != PLATFORMS
    (surveys / "data" / "platforms.xml").write_text(text)
    survey = helios.read_survey(surveys / "ground.xml")
    points = made(survey.write(surveys / "out")[0], surveys / "one")
    # The tripod stands on the ground, at z 5, and its axes are those of the world: y to the north.
    c, s = np.cos(np.radians(-20)), np.sin(np.radians(-20))
    leans = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
    seen = (points.xyz - (0.8, -0.4, 6.5)) @ leans  # from the axis of the head
    turn, times = np.degrees(np.arctan2(-seen[:, 0], seen[:, 1])), points.times - points.times.min()
    assert np.ptp(times) > 11.5
    # The first pulse with a return is not known: it is within the first line, in which the head turns by half a degree.
    off = (turn - 10 * times + 30 + 180) % 360 - 180
    assert np.ptp(off) < 0.05 and 0 < np.median(off) < 0.5


def test_a_slow_head_on_a_platform_that_moves(surveys):
    text = TERRESTRIAL.replace("#tripod", "#aircraft").replace(
        "<leg><platformSettings", '<leg><platformSettings z="50"'
    )
    text = text.replace("</survey>", '<leg><platformSettings x="900" z="50"/></leg></survey>').replace(
        ' onGround="true"', ""
    )
    (surveys / "ground.xml").write_text(text)
    with pytest.raises(
        ValueError, match="leg 0: the head takes more than 10 s for a turn, which is read for platforms"
    ):
        helios.read_survey(surveys / "ground.xml")

# SPDX-License-Identifier: Apache-2.0
"""Pulses of HELIOS++: how far apart two surfaces have two echoes, and with how many sub-rays they are looked at."""

import math

import pytest
from helios_surveys import AIRBORNE, SCANNERS, made, write_surveys

from gnosphere import helios


@pytest.fixture
def surveys(tmp_path):
    return write_surveys(tmp_path)


def with_waveform(*settings):
    """The airborne survey with <FWFSettings>."""
    return AIRBORNE.replace("</survey>", f"<FWFSettings {' '.join(settings)}/></survey>")


def sub_rays_of(survey):
    return survey.legs[0].drive["sensors"][0]["effects"].get("divergence", {}).get("sub_rays")


@pytest.mark.parametrize(
    ("pulse", "window", "gap", "returns"),
    [
        (4, None, 0.5, 1),  # half the way of light in 4 ns is 0.600 m
        (4, None, 0.7, 2),
        (10, None, 1.3, 1),  # 1.499 m
        (10, None, 1.7, 2),
        (10, 14, 1.9, 1),  # 2.098 m, in which HELIOS++ looks for a maximum of the waveform
        (10, 14, 2.3, 2),
    ],
)
def test_surfaces_that_a_pulse_tells_apart(surveys, pulse, window, gap, returns):
    # Strips 2 cm wide, 2 cm apart, above a plate: each footprint of 5 cm has parts of both. Ranges are 1.06 gaps apart.
    lines = ["mtllib m.mtl", "usemtl roof"]
    for z in range(-200, 200, 4):
        lines += [f"v {x} 10 {y / 100}" for x, y in ((-3, z), (3, z), (3, z + 2), (-3, z + 2))]
    lines += [f"v {x} {10 - gap} {y}" for x, y in ((-4, -3), (4, -3), (4, 3), (-4, 3))]
    lines += [f"f {k} {k + 1} {k + 2} {k + 3}" for k in range(1, len(lines) - 2, 4)]
    (surveys / "data" / "plate.obj").write_text("\n".join(lines))
    scanners = SCANNERS.replace('pulseLength_ns="4"', f'pulseLength_ns="{pulse}"')
    (surveys / "data" / "scanners.xml").write_text(scanners)
    if window:
        (surveys / "air.xml").write_text(with_waveform(f'winSize_ns="{window}"'))
    survey = helios.read_survey(surveys / "air.xml")
    points = made(survey.write(surveys / "out")[1], surveys / "two")
    x, y, z = points.xyz.T
    inside = (abs(x) < 1.8) & (abs(y - 30) < 2.5) & (z > 10)
    assert inside.sum() >= 5 and set(points.returns[inside]) == {returns}


@pytest.mark.parametrize("quality", [1, 2, 3, 4])
def test_sub_rays(surveys, quality):
    (surveys / "air.xml").write_text(with_waveform(f'beamSampleQuality="{quality}"'))
    survey = helios.read_survey(surveys / "air.xml")
    # The documentation of HELIOS++: one, and floor(2 pi i) in the circle i.
    assert sub_rays_of(survey) == 1 + sum(math.floor(2 * math.pi * i) for i in range(1, quality))
    assert not survey.left_out


def test_beams_without_a_divergence_have_no_sub_rays(surveys):
    """Whatever beamSampleQuality is; a leg may have a divergence of its own."""
    scanners = SCANNERS.replace('beamDivergence_rad="0.0005"', 'beamDivergence_rad="0"')
    (surveys / "data" / "scanners.xml").write_text(scanners)
    wide, waveform = '<scannerSettings template="wide"/>', '<FWFSettings beamSampleQuality="2"/></survey>'
    before, text = AIRBORNE.replace("</survey>", waveform).rsplit(wide, 1)
    (surveys / "air.xml").write_text(before + wide.replace("/>", ' beamDivergence_rad="0.002"/>') + text)
    survey = helios.read_survey(surveys / "air.xml")
    assert [leg.sensor.divergence_horizontal for leg in survey.legs] == [0, 0.002]
    assert [leg.drive["sensors"][0]["effects"].get("divergence") for leg in survey.legs] == [None, {"sub_rays": 7}]
    assert not survey.left_out
    for number, file in enumerate(survey.write(surveys / "out")):
        assert len(made(file, surveys / str(number)).xyz)


def test_defaults_of_a_scanner_are_those_of_helios_and_told(surveys):
    divergence, pulse = "a divergence of 0.0003 rad, as HELIOS++ does", "pulses of 4 ns, as HELIOS++ does"
    others = set(helios.read_survey(surveys / "air.xml").assumed)
    assert not others & {divergence, pulse}
    scanners = SCANNERS.replace(' beamDivergence_rad="0.0005"', "").replace('\n  pulseLength_ns="4"', "")
    (surveys / "data" / "scanners.xml").write_text(scanners)
    survey = helios.read_survey(surveys / "air.xml")
    assert set(survey.assumed) - others == {divergence, pulse}
    for leg in survey.legs:
        assert leg.sensor.divergence_horizontal == leg.sensor.divergence_vertical == 0.0003
        assert leg.drive["sensors"][0]["effects"]["returns"] == {"pulse_width": 4e-9, "separation": 0.5996}
    own = AIRBORNE.replace('<scannerSettings id="wide"', '<scannerSettings id="wide" beamDivergence_rad="0.002"')
    (surveys / "air.xml").write_text(own)
    survey = helios.read_survey(surveys / "air.xml")
    assert set(survey.assumed) - others == {pulse} and survey.legs[0].sensor.divergence_vertical == 0.002


def test_more_sub_rays_than_devices_take(surveys):
    (surveys / "air.xml").write_text(with_waveform('beamSampleQuality="6"'))
    with pytest.warns(UserWarning, match="sub-rays of a pulse beyond 61"):
        assert sub_rays_of(helios.read_survey(surveys / "air.xml")) == 61


def test_settings_of_the_survey_come_before_those_of_the_scanner(surveys):
    assert sub_rays_of(helios.read_survey(surveys / "air.xml")) is None
    old = 'pulseLength_ns="4"/>'
    assert old in SCANNERS
    scanners = SCANNERS.replace(old, 'pulseLength_ns="4"><FWFSettings beamSampleQuality="2"/></scanner>')
    (surveys / "data" / "scanners.xml").write_text(scanners)
    assert sub_rays_of(helios.read_survey(surveys / "air.xml")) == 7
    (surveys / "air.xml").write_text(with_waveform('winSize_ns="20"'))
    assert sub_rays_of(helios.read_survey(surveys / "air.xml")) == 7
    (surveys / "air.xml").write_text(with_waveform('beamSampleQuality="4"'))
    assert sub_rays_of(helios.read_survey(surveys / "air.xml")) == 37

# SPDX-License-Identifier: Apache-2.0
"""What attributes of HELIOS++ surveys mean, one by one: turns, mounts, sectors, mirrors, the ground, materials."""

import json
import math

import numpy as np
import pytest
from helios_surveys import AIRBORNE, PLATFORMS, SCANNERS, SCENE, TERRESTRIAL, write_surveys

from gnosphere import adapter, helios
from gnosphere.helios.assets import Assets, Settings, rotation_of
from gnosphere.helios.survey import ET


@pytest.fixture
def surveys(tmp_path):
    return write_surveys(tmp_path)


def turned(mount) -> np.ndarray:
    """The matrix of a mount of a drive file."""
    x, y, z, w = mount["orientation"]
    axis, sine = np.array([x, y, z]), math.hypot(x, y, z)
    angle = 2 * math.atan2(sine, w)
    cross = np.cross(np.eye(3), axis / (sine or 1))
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def read(folder, text, old="", new=""):
    (folder / "survey.xml").write_text(text.replace(old, new, 1) if old else text)
    return helios.read_survey(folder / "survey.xml")


def mounted(folder, platform, settings=""):
    """The mount of a scanner that sweeps lines from a platform of these elements."""
    (folder / "data" / "platforms.xml").write_text(
        f'<document><platform id="aircraft" type="linearpath">{platform}</platform></document>'
    )
    return (
        read(folder, AIRBORNE, 'scanFreq_hz="40"', f'scanFreq_hz="40" {settings}').legs[0].drive["sensors"][0]["mount"]
    )


def test_turns_about_fixed_axes_and_about_their_own():
    two = '<m {}><rot axis="x" angle_deg="90"/><rot axis="Z" angle_deg="90"/></m>'
    # About x and then about z: y goes up and stays there. About x and the z that lies along -y then: x goes up.
    fixed, own = (rotation_of(ET.fromstring(two.format(how))) for how in ("", 'rotations="local"'))
    np.testing.assert_allclose(fixed @ np.eye(3), [[0, 0, 1], [1, 0, 0], [0, 1, 0]], atol=1e-12)
    np.testing.assert_allclose(own @ np.eye(3), [[0, -1, 0], [0, 0, -1], [1, 0, 0]], atol=1e-12)


def test_a_mount_goes_from_the_axes_of_helios_to_those_of_drives(surveys):
    """There y looks forward and x to the right; here x looks forward and y to the left."""
    mount = mounted(surveys, '<scannerMount x="1" y="2" z="3"><rot axis="x" angle_deg="90"/></scannerMount>')
    assert mount["position"] == [2, -1, 3]
    np.testing.assert_allclose(turned(mount), [[0, 0, -1], [0, 1, 0], [1, 0, 0]], atol=1e-9)  # forward is up
    # A head that does not turn looks to the left in its own frame, which the mount tilts down.
    mount = mounted(surveys, '<scannerMount><rot axis="x" angle_deg="-90"/></scannerMount>', 'headRotateStart_deg="90"')
    np.testing.assert_allclose(turned(mount) @ [1, 0, 0], [0, 1, 0], atol=1e-9)
    np.testing.assert_allclose(turned(mount) @ [0, 0, 1], [1, 0, 0], atol=1e-9)


def test_settings_come_before_those_of_templates_and_these_before_theirs(surveys):
    text = """<document><s id="far" a="1" b="2" c="3" d="1"/><s id="near" template="far" b="20" c="30" e="true" f="0"/>
        <survey/></document>"""
    (surveys / "s.xml").write_text(text)
    assets = Assets(surveys / "s.xml")
    settings = Settings(assets, ET.fromstring('<s template="near" c="300"/>'))
    assert [settings.number(name) for name in "abc"] == [1, 20, 300] and settings.number("z", 7) == 7
    assert [settings.flag(name, False) for name in "defz"] == [True, True, False, False]


def test_folders_of_assets_are_searched_before_those_around_the_survey(surveys, tmp_path_factory):
    other = tmp_path_factory.mktemp("assets")
    (other / "data").mkdir()
    (other / "data" / "platforms.xml").write_text(PLATFORMS.replace('z="1.5"', 'z="2.5"'))
    for assets, height in (((), 1.5), ((other,), 2.5), (other, 2.5), (str(other), 2.5)):
        (leg,) = helios.read_survey(surveys / "ground.xml", assets).legs
        assert leg.drive["sensors"][0]["mount"]["position"] == [0, 0, height]


def test_the_way_of_a_leg(surveys):
    """133 lines take a little less than the way; the next leg climbs straight up and keeps the heading."""
    climb = AIRBORNE.replace('x="70" y="0"', 'x="70" y="-50" z="135"').replace(' active="false"', "")
    survey = helios.read_survey(surveys / "air.xml", epoch=1e9)
    assert survey.legs[0].drive["epoch"] == 1e9 and survey.legs[1].drive["outputs"][0]["flight_line"] == 3
    assert survey.legs[0].drive["seed"] != survey.legs[1].drive["seed"]  # lines have noise of their own
    first, second, third = read(surveys, climb).legs
    assert first.drive["epoch"] == 315964800
    start, end = first.drive["ego"]["trajectory"]["waypoints"]
    assert (start["position"], end["time"]) == ([-30, -50, 105], pytest.approx(3.325))
    assert end["position"] == pytest.approx([-30 + 30 * 3.325, -50, 105])
    start, end = second.drive["ego"]["trajectory"]["waypoints"]
    assert start["yaw_deg"] == end["yaw_deg"] == 0  # to the east, as before
    assert second.duration == pytest.approx(1) and end["position"] == pytest.approx([70, -50, 135])
    assert end["time"] == pytest.approx(100 / 30 + second.duration)
    # The third leg goes 100 m to the west and 50 m to the north, and down by 30 m; its speed is along the slope.
    assert third.drive["start"] == pytest.approx(100 / 30 + 1)
    way = np.array([-100, 50, -30])
    start, end = third.drive["ego"]["trajectory"]["waypoints"]
    assert third.duration == pytest.approx(np.linalg.norm(way) / 30, abs=1 / 40)
    along = np.subtract(end["position"], start["position"])
    assert along == pytest.approx(30 * third.duration * way / np.linalg.norm(way))
    assert start["yaw_deg"] == pytest.approx(np.degrees(np.arctan2(50, -100)))
    first = read(surveys, AIRBORNE, 'x="70" y="-50"', 'x="-30" y="-50" z="135"').legs[0]
    assert first.drive["ego"]["trajectory"]["waypoints"][0]["yaw_deg"] == 90  # it has not moved yet


def test_a_platform_without_a_speed_goes_70_metres_a_second(surveys):
    for kind in ("linearpath", "groundvehicle", "multicopter"):
        (surveys / "data" / "platforms.xml").write_text(PLATFORMS.replace("linearpath", kind))
        text = AIRBORNE.replace(' movePerSec_m="30"', "")
        if kind == "linearpath":
            survey = read(surveys, text)
        else:
            with pytest.warns(UserWarning, match=f"leaves out speeding up, slowing down and turning of a '{kind}'"):
                survey = read(surveys, text)
        assert survey.legs[1].drive["start"] == pytest.approx(150 / 70)


def test_random_offsets_of_legs_are_told(surveys):
    with pytest.warns(UserWarning, match=r"leaves out random offsets of legs \(1\)"):
        read(surveys, AIRBORNE, "<survey ", '<survey legRandomOffset="true" ')


def sector(folder, **settings):
    """The leg of a tripod, whose head turns by 10 degrees a second from -30 to 90."""
    given = {
        "pulseFreq_hz": 2000, "scanFreq_hz": 20, "headRotatePerSec_deg": 10, "headRotateStart_deg": -30,
        "headRotateStop_deg": 90, **settings,
    }  # fmt: skip
    attributes = " ".join(f'{name}="{value}"' for name, value in given.items() if value is not None)
    first = TERRESTRIAL.index("<scannerSettings")
    text = TERRESTRIAL[:first] + f"<scannerSettings {attributes}/></leg></survey></document>"
    (leg,) = read(folder, text).legs
    return leg


def test_sectors_of_a_head(surveys):
    def numbers(leg):
        """Seconds, lines, and degrees from where to how far, of all scans, which are no longer than 10 s."""
        sensor, scans = leg.sensor, round(leg.drive["duration"] * leg.drive["rate"])
        assert sensor.rotation_period <= 10
        span = scans * sensor.azimuth_span_deg
        return round(leg.duration, 4), scans * sensor.columns, sensor.azimuth_start_deg, span

    assert numbers(sector(surveys)) == pytest.approx((12, 240, -30, 120))
    assert numbers(sector(surveys, max_duration=6)) == pytest.approx((6, 120, -30, 60))
    assert numbers(sector(surveys, max_duration=60)) == pytest.approx((12, 240, -30, 120))
    # It turns no faster than it can, 60 degrees a second, in either direction.
    for speed, sign in ((100, 1), (-100, -1), (-60, -1)):
        assert numbers(sector(surveys, headRotatePerSec_deg=speed)) == pytest.approx((2, 40, -30, sign * 120))
    # Angles between pulses and between lines are other words for speeds: 100 degrees of 100 pulses, 20 times a second.
    for speed, sign in ((1, 1), (-1, -1)):
        angles = {"verticalResolution_deg": 1, "horizontalResolution_deg": 0.5, "scanFreq_hz": None}
        leg = sector(surveys, headRotatePerSec_deg=speed, **angles)
        assert numbers(leg) == pytest.approx((12, 240, -30, sign * 120))
        assert len(leg.sensor.channels) == 100
    # Two turns are two scans.
    leg = sector(surveys, headRotatePerSec_deg=60, headRotateStart_deg=370, headRotateStop_deg=370 + 720)
    assert numbers(leg) == pytest.approx((12, 240, 10, 720))
    assert (leg.drive["rate"], leg.drive["duration"]) == pytest.approx((1 / 6, 12))


def test_elevations_of_a_head_may_end_on_one_side_alone(surveys):
    def elevations(**settings):
        return [channel.elevation_deg for channel in sector(surveys, **settings).sensor.channels]

    everything = elevations()
    assert (min(everything), max(everything), len(everything)) == pytest.approx((-50, 49, 100))
    assert elevations(verticalAngleMax_deg=10.5) == [up for up in everything if up < 10.5]
    assert elevations(verticalAngleMin_deg=-10.5) == [up for up in everything if up > -10.5]


def test_pulses_a_second_are_the_first_that_the_scanner_has(surveys):
    (surveys / "data" / "scanners.xml").write_text(
        SCANNERS.replace('pulseFreqs_Hz="2000"', 'pulseFreqs_Hz="1000,2000"')
    )
    for rate, pulses in ((2000, 100), (1000, 50), (None, 50), (0, 50)):
        assert len(sector(surveys, pulseFreq_hz=rate).sensor.channels) == pulses


def test_lines_of_a_mirror_are_no_faster_than_it_can_be(surveys):
    """120 lines a second of 2000 pulses would be 16 2/3 pulses each; with 16 they would be 125."""
    text = AIRBORNE.replace("#polygon", "#head").replace('scanFreq_hz="40"', 'scanFreq_hz="120"')
    leg = read(surveys, text, 'scanAngle_deg="20" ').legs[0]
    scans = round(leg.duration * leg.drive["rate"])
    assert leg.sensor.beam_count() * scans == round(100 / 30 / (17 / 2000)) * 17


def test_a_scan_angle_is_no_wider_than_the_mirror_lets_out(surveys):
    def beams(angle, **scanner):
        text = SCANNERS
        for name, value in scanner.items():
            text = text.replace(f'id="polygon" optics="rotating"', f'id="polygon" optics="rotating" {name}="{value}"')
        (surveys / "data" / "scanners.xml").write_text(
            text.replace("rotating", scanner and "oscillating" or "rotating", 1)
        )
        return read(surveys, AIRBORNE, 'scanAngle_deg="20"', f'scanAngle_deg="{angle}"').legs[0].sensor

    assert beams(40) == beams(30) != beams(20)
    # The product of the angle and the frequency of 40 Hz may be limited, too.
    for angle, widest in ((20, 10), (5, 5)):
        directions = beams(angle, scanProduct=400).patterns[0].directions
        opened = np.degrees(np.arccos((directions.astype(float) @ directions.T).min()))
        assert opened == pytest.approx(2 * widest, rel=0.05)  # but for the step between two pulses


def test_settings_of_the_survey_replace_those_of_the_scanner(surveys):
    own = read(surveys, AIRBORNE)
    first, second = own.legs
    assert (first.sensor.range_min, first.sensor.divergence_horizontal) == (10, 0.0005)
    assert first.drive["sensors"][0]["effects"]["range-noise"]["sigma"] == 0.02
    detector = '<detectorSettings accuracy_m="0.5" rangeMin_m="3" rangeMax_m="700"/><leg>'
    text = AIRBORNE.replace("<leg>", detector, 1)
    wide = '<scannerSettings template="wide" beamDivergence_rad="0.002"/>'
    changed, unchanged = read(surveys, text, '<scannerSettings template="wide"/>', wide).legs
    assert (changed.sensor.range_min, changed.sensor.range_max) == (3, 700)
    assert changed.sensor.divergence_horizontal == 0.002
    assert unchanged.sensor.divergence_horizontal == 0.0005  # another leg has the scanner as it was
    assert changed.drive["sensors"][0]["effects"]["range-noise"]["sigma"] == 0.5


@pytest.mark.parametrize(
    ("wavelength", "taken", "told"), ((905, 905, 0), (1064, 905, 1), (1300, 1550, 1), (1550, 1550, 0), (532, 905, 1))
)
def test_wavelengths(surveys, wavelength, taken, told):
    (surveys / "data" / "scanners.xml").write_text(
        SCANNERS.replace('id="head"', f'id="head" wavelength_nm="{wavelength}"')
    )
    text = TERRESTRIAL
    if told:
        with pytest.warns(UserWarning, match=r"wavelengths that are taken as 905 or 1550 nm \(1\)"):
            survey = read(surveys, text)
    else:
        survey = read(surveys, text)
    assert survey.legs[0].drive["sensors"][0]["effects"]["intensity"] == {"wavelength": taken}


def test_the_ground_below_a_leg_is_where_its_filters_put_it(surveys):
    """A square far from the origin of its file, which is turned about x and then about z, scaled and moved. What is no
    ground lies below it."""
    corners = [(x, y, 2) for x, y in ((500000.3, -1), (500002.3, -1), (500002.3, 1), (500000.3, 1))]
    lines = [f"v {x} {y} {z}" for x, y, z in corners]
    (surveys / "data" / "ground.obj").write_text("\n".join([*lines, "f 1 2 3 4", ""]))
    (surveys / "data" / "plate.obj").write_text(
        "mtllib m.mtl\nusemtl roof\nv -300 -30 -300\nv 300 -30 -300\nv 300 -30 300\nv -300 -30 300\nf 1 2 3 4\n"
    )
    turns = [
        f'<filter type="rotate"><param key="rotation" type="rotation"><rot axis="{axis}" angle_deg="{angle}"/></param>'
        "</filter>"
        for axis, angle in (("x", 10), ("z", 60))
    ]
    scene = SCENE.replace('<filter type="scale">', "".join(turns) + '<filter type="scale">', 1)
    (surveys / "data" / "scene.xml").write_text(scene.replace('value="200"', 'value="5"').replace("0;0;5", "7;-3;5"))
    tilt, around = np.radians([10, 60])
    about_x = np.array([[1, 0, 0], [0, np.cos(tilt), -np.sin(tilt)], [0, np.sin(tilt), np.cos(tilt)]])
    about_z = np.array([[np.cos(around), -np.sin(around), 0], [np.sin(around), np.cos(around), 0], [0, 0, 1]])
    turn = about_z @ about_x
    for place in ((2500005, 0), (2500002, 3), (2500011, -4)):  # in the file's axes, scaled
        x, y, z = turn @ [*place, 10] + [7, -3, 5]
        text = TERRESTRIAL.replace('x="0" y="0"', f'x="{x}" y="{y}" z="50"')
        assert read(surveys, text).legs[0].drive["ego"]["trajectory"]["waypoints"][0]["position"] == pytest.approx(
            [x, y, z], abs=1e-3
        )
    with pytest.raises(ValueError, match="there is no ground at x 0, y 0, where a leg with onGround stands"):
        read(surveys, TERRESTRIAL)


def test_of_several_grounds_the_lowest_counts(surveys):
    (surveys / "data" / "m.mtl").write_text("newmtl soil\nnewmtl roof\nhelios_reflectance 150\n")
    survey = read(surveys, TERRESTRIAL, 'x="0" y="0"', 'x="0" y="30"')  # under the plate, which is ground now
    assert survey.legs[0].drive["ego"]["trajectory"]["waypoints"][0]["position"] == [0, 30, 5]
    # A reflectance that is not stated is a half, and none is more than 1.
    survey.write(surveys / "out")
    rows = json.loads((surveys / "out" / "materials.json").read_text())["materials"]
    expected = {"soil": 0.5, "roof": 1.0}
    assert {row["name"]: (row["reflectance_905"], row["reflectance_1550"]) for row in rows} == {
        name: (value, value) for name, value in expected.items()
    }


def test_parts_that_are_put_on_the_ground_are_told(surveys):
    for value, told in (("-1", True), ("0", False), ("false", False)):
        param = f'<param type="integer" key="onGround" value="{value}"/></filter></part>'
        (surveys / "data" / "scene.xml").write_text(SCENE.replace("</filter></part>", param, 1))
        if told:
            with pytest.warns(UserWarning, match=r"leaves out parts that are put on the ground \(1\)"):
                read(surveys, AIRBORNE)
        else:
            assert not read(surveys, AIRBORNE).left_out


def test_orientations_of_drives_are_those_of_their_matrices():
    turn = rotation_of(ET.fromstring('<m><rot axis="x" angle_deg="40"/><rot axis="y" angle_deg="-70"/></m>'))
    assert helios.survey.quaternion_of(turn) == pytest.approx(adapter.quaternion(turn))
    np.testing.assert_allclose(turned({"orientation": helios.survey.quaternion_of(turn)}), turn, atol=1e-9)

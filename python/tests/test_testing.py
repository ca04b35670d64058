# SPDX-License-Identifier: Apache-2.0
"""The plug-in gnosphere.testing: golden clouds that are the same, that differ, that are written anew."""

import base64
import re
import struct
import zlib
from pathlib import Path

import numpy as np
import pytest
from conftest import REPOSITORY, at, beams

import gnosphere
from gnosphere import pictures, primitives, testing

pytest_plugins = ["pytester"]

# A wall at x metres, seen by a fan of nine beams, on the reference.
SCENE = """
import gnosphere, numpy, pytest
from gnosphere import primitives
from gnosphere.testing import difference

def wall(x, width=1.0, beams=9, z=0.0):
    positions = numpy.array([[0, -width, -1], [0, width, -1], [0, width, 1], [0, -width, 1]], numpy.float32)
    mesh = gnosphere.Mesh(positions, [[0, 1, 2], [0, 2, 3]], [gnosphere.MeshPart(0, 2, 0)], name="wall")
    place = gnosphere.Transform([[1, 0, 0, x], [0, 1, 0, 0], [0, 0, 1, 0]])
    scene = gnosphere.Scene([gnosphere.Material("grey")], [mesh], [gnosphere.Instance(0, place)])
    angles = numpy.radians(numpy.linspace(-1, 1, beams))
    sensor = gnosphere.Sensor()
    sensor.name, sensor.range_max = "fan", 100
    sensor.patterns = [gnosphere.BeamList(numpy.stack([numpy.cos(angles), numpy.sin(angles), 0 * angles], axis=1))]
    request = gnosphere.SensorRequest(sensor, gnosphere.Effects.none(), [gnosphere.Field.incidence])
    options = gnosphere.SimulatorOptions(gnosphere.device_by_name("reference"))
    return gnosphere.Simulator(scene, request, options).scan(gnosphere.Pose())

def panes(x, reflectance=0.5):
    # A Puck, whose beams have two returns, in a box of glass 5 m around it, and in one of walls x metres around it.
    boxes = [primitives.box((half, half, half)) for half in (5, x)]
    meshes = [gnosphere.Mesh(*box, [gnosphere.MeshPart(0, 12, i)]) for i, box in enumerate(boxes)]
    materials = [gnosphere.Material("glass", transmission=0.9), gnosphere.Material("wall", [reflectance] * 3 + [1])]
    scene = gnosphere.Scene(materials, meshes, [gnosphere.Instance(0), gnosphere.Instance(1)])
    effects = gnosphere.Effects.none()
    effects.transmission.use = effects.returns.use = effects.intensity.use = gnosphere.EffectUse.on
    request = gnosphere.SensorRequest(gnosphere.builtin_sensor("Puck"), effects, [gnosphere.Field.intensity])
    options = gnosphere.SimulatorOptions(gnosphere.device_by_name("reference"))
    scan = gnosphere.Simulator(scene, request, options).scan(gnosphere.Pose())
    assert scan.returns == 2 and numpy.isfinite(scan.ranges.reshape(-1, 2)).all(axis=1).sum() > 10000
    return scan
"""


@pytest.fixture(scope="module")
def wall_bytes() -> list[bytes]:
    """The golden cloud of a wall at 10 m, once a test has written it."""
    return []


@pytest.fixture
def run(pytester, wall_bytes):
    """Runs a test of one line, in a process whose folder has the golden cloud of a wall at 10 m."""

    def run_line(line: str, *options: str):
        pytester.makepyfile(test_wall=SCENE + f"\ndef test_wall(golden_cloud):\n    {line}\n")
        return pytester.runpytest_subprocess("-p", "no:cacheprovider", *options)

    golden = Path(pytester.path) / "golden"
    if not wall_bytes:
        done = run_line('golden_cloud("wall", wall(10))', "--gnosphere-update")
        done.assert_outcomes(passed=1)
        done.stdout.fnmatch_lines(["wrote the golden cloud *golden/wall.npy"])
        wall_bytes.append((golden / "wall.npy").read_bytes())
    else:
        golden.mkdir()
        (golden / "wall.npy").write_bytes(wall_bytes[0])
    return run_line


def page(pytester) -> str:
    return (Path(pytester.path) / "gnosphere-pages" / "wall.html").read_text()


def test_the_same_scan_passes_and_leaves_nothing(run, pytester):
    run('golden_cloud("wall", wall(10), exact=True)').assert_outcomes(passed=1)
    run('golden_cloud("wall", wall(10.0004))').assert_outcomes(passed=1)
    run('golden_cloud("wall", wall(10.05), tolerance=0.1)').assert_outcomes(passed=1)
    assert not list((Path(pytester.path) / "gnosphere-pages").glob("*"))


def test_a_scan_is_compared_where_no_page_can_be_written(run, pytester):
    (Path(pytester.path) / "gnosphere-pages").write_text("no folder")
    run('golden_cloud("wall", wall(10))').assert_outcomes(passed=1)
    done = run('golden_cloud("wall", wall(10.05))')
    done.assert_outcomes(failed=1)
    done.stdout.fnmatch_lines(["*another range; a page that shows it cannot be written (*--gnosphere-pages"])


def test_another_range_fails_and_leaves_a_page(run, pytester):
    done = run('golden_cloud("wall", wall(10.05))')
    done.assert_outcomes(failed=1)
    done.stdout.fnmatch_lines(["*wall differs from its golden cloud: 9 another range; look at *wall.html*"])
    text = page(pytester)
    assert re.search(r"<td>range</td><td>0\.05\d*</td>", text)
    assert text.count('<img src="data:image/png;base64,') == 5
    assert (Path(pytester.path) / "gnosphere-pages" / "wall.npy").exists()
    run('golden_cloud("wall", wall(10.0004), exact=True)').assert_outcomes(failed=1)


def test_beams_that_miss_are_named_and_may_be_allowed(run, pytester):
    done = run('golden_cloud("wall", wall(10, width=0.1))')
    done.assert_outcomes(failed=1)
    done.stdout.fnmatch_lines(["*4 only in the golden cloud*"])
    run('golden_cloud("wall", wall(10, width=0.1), allowed=4)').assert_outcomes(passed=1)
    run('golden_cloud("wall", wall(10, width=0.1), allowed=3)').assert_outcomes(failed=1)


def test_other_fields_have_tolerances_of_their_own(run):
    line = 'golden_cloud("wall", wall({}), tolerances={{"incidence": 1e-6}}, tolerance=1)'
    done = run(line.format(10))
    done.stdout.fnmatch_lines(["*has no incidence; run pytest --gnosphere-update*"])
    run(line.format(10), "--gnosphere-update").assert_outcomes(passed=1)
    run(line.format(10.1)).assert_outcomes(passed=1)
    done = run('golden_cloud("wall", wall(10.1), tolerances={"incidence": -1}, tolerance=1)')
    done.stdout.fnmatch_lines(["*9 another value*"])


def test_a_tolerance_of_the_range_is_refused_beside_tolerance(run):
    done = run('golden_cloud("wall", wall(10.05), tolerances={"range": 0.5})')
    done.assert_outcomes(failed=1)
    done.stdout.fnmatch_lines(["*ValueError: golden_cloud: `tolerances` has a range; state it as `tolerance`*"])


def test_beams_with_several_returns(run, pytester):
    update = 'golden_cloud("puck", panes(9), fields="intensity")'
    run(update, "--gnosphere-update").stdout.fnmatch_lines(["wrote the golden cloud *golden/puck.pcd"])
    kept = gnosphere.read_cloud(Path(pytester.path) / "golden" / "puck.pcd")
    assert (kept.channels, kept.columns, kept.returns) == (16, 1808, 2)
    lines = [
        "same, near, far, dark = panes(9), panes(9.0004), panes(9.05), panes(9, 0.4)",
        'golden_cloud("puck", same, fields="intensity", exact=True)',
        'golden_cloud("puck", near, fields="intensity")',
        'golden_cloud("puck", far, fields="intensity", tolerance=0.2)',
        'golden_cloud("puck", dark, fields="intensity")',
        'golden_cloud("puck", dark, tolerances={"intensity": 0.9})',
        "walls = int((far.instances == 1).sum())",
        'golden_cloud("puck", far, fields="intensity", allowed=walls)',
        'for wrong in ({"exact": True}, {"allowed": walls - 1}, {"tolerances": {"intensity": 1e-9}}):',
        '    with pytest.raises(pytest.fail.Exception, match="another range"):',
        '        golden_cloud("puck", far, fields="intensity", **wrong)',
        'with pytest.raises(pytest.fail.Exception, match="another value"):',
        '    golden_cloud("puck", dark, tolerances={"intensity": 1e-9})',
        'with pytest.raises(pytest.fail.Exception, match="differ"):',
        '    golden_cloud("puck", dark, fields="intensity", exact=True)',
        'golden_cloud("puck", far, fields="intensity")',
    ]
    done = run("\n    ".join(lines))
    done.assert_outcomes(failed=1)
    done.stdout.fnmatch_lines(["*puck differs from its golden cloud: * another range; look at *puck.html*"])
    text = (Path(pytester.path) / "gnosphere-pages" / "puck.html").read_text()
    assert text.count('<img src="data:image/png;base64,') == 5 and "golden/puck.pcd" in text


def test_update_writes_what_the_scan_is(run):
    run('golden_cloud("wall", wall(12))').assert_outcomes(failed=1)
    run('golden_cloud("wall", wall(12))', "--gnosphere-update").assert_outcomes(passed=1)
    run('golden_cloud("wall", wall(12), exact=True)').assert_outcomes(passed=1)
    run('golden_cloud("wall", wall(10))').assert_outcomes(failed=1)


def test_what_cannot_be_compared_is_said(run):
    run('golden_cloud("door", wall(10))').stdout.fnmatch_lines(["*there is no golden cloud *golden/door.npy; *"])
    run('golden_cloud("wall", wall(10, beams=5))').stdout.fnmatch_lines(
        ["*the golden cloud *wall.npy has 1 x 9 x 1 channels x columns x returns, the scan 1 x 5 x 1: another sensor*"]
    )


def decode(png: bytes) -> np.ndarray:
    """The pixels of a PNG without filters."""
    width, height = struct.unpack(">II", png[16:24])
    size = struct.unpack(">I", png[33:37])[0]
    rows = np.frombuffer(zlib.decompress(png[41 : 41 + size]), np.uint8).reshape(height, 1 + 3 * width)
    assert not rows[:, 0].any()
    return rows[:, 1:].reshape(height, width, 3)


def test_pictures(reference, simulator, pose):
    scan = reference.scan(gnosphere.Pose())
    image = pictures.range_image(scan)
    assert image.shape == (128, 9, 3)
    assert (decode(pictures.png(image)) == image).all()
    assert pictures.from_above(scan).shape == (400, 400, 3)
    big = simulator.scan(pose)
    image = pictures.range_image(big)
    assert image.shape == (128, 900, 3)
    # The highest channel is on top, the first column on the right; of two columns the nearer range is shown.
    pair = big.ranges.reshape(big.shape)[-1, ::-1].reshape(-1, 2)
    nearest = np.fmin(pair[:, 0], pair[:, 1])
    assert (image[0] == pictures.colours(nearest, 0, pictures.farthest_of(big))).all()
    # Of a head whose channels count from the top and which turns clockwise, as Ouster's do, the picture is the same.
    sensor = gnosphere.builtin_sensor("VLP-16")
    sensor.channels = sensor.channels[::-1]
    sensor.azimuth_start_deg, sensor.azimuth_span_deg = 180 - 360 / sensor.columns, -360
    simulator.add_sensor(gnosphere.SensorRequest(sensor, gnosphere.Effects.none()))
    downwards, upwards = simulator.scan(pose, 1), simulator.scan(pose)
    simulator.remove_sensor(1)
    assert downwards.first_row_on_top and not upwards.first_row_on_top
    assert downwards.first_column_on_left and not upwards.first_column_on_left
    a, b = pictures.beam_image(downwards, downwards.ranges), pictures.beam_image(upwards, upwards.ranges)
    assert (a == b)[~np.isnan(b)].mean() > 0.95  # but for beams that meet glass
    html = big._repr_html_()
    assert html.startswith("<p>Scan of VLP-16: 16 x 1800 beams, ") and html.count("<img ") == 1
    assert gnosphere.Scan()._repr_html_() == "<p>Scan without beams</p>"


def test_differences_entry_by_entry(square):
    def scan(x: float) -> gnosphere.Scan:
        scene = gnosphere.Scene([gnosphere.Material("grey")], [square], [gnosphere.Instance(0, at(x))])
        options = gnosphere.SimulatorOptions(gnosphere.device_by_name("reference"))
        return gnosphere.Simulator(scene, gnosphere.SensorRequest(beams()), options).scan(gnosphere.Pose())

    a, b = scan(10), scan(10)
    b.ranges[0] += 0.5
    b.instances[1] = 3
    b.ranges[2] = np.nan
    a.ranges[3] = np.nan
    found = testing.difference(a, b, {"range": 0.001})
    assert [list(testing.KINDS)[kind] for kind in found.kinds[:5]] == [
        "another range", "another owner", "only in the golden cloud", "only in the scan", "the same",
    ]  # fmt: skip
    assert found.worst == {"range": 0.5, "point": 0}


class Cloud(dict):
    """What difference() asks of a scan: fields by name, and the arrays that every scan has."""

    def __init__(self, count: int, x: float, **fields: list) -> None:
        super().__init__({name: np.array(values, float) for name, values in fields.items()})
        self.ranges = self["range"] = np.full(count, x, np.float32)
        self.points = np.tile(np.float32([x, 0, 0]), (count, 1))
        self.triangles, self.instances = np.zeros((2, count), np.uint32)


def test_differences_of_fields_owners_and_what_is_absent():
    a, b = (Cloud(6, 10, normal=[[1, 0, 0]] * 6, incidence=[0.5] * 6) for _ in range(2))
    b.triangles[0] += 1
    b["normal"][1, 2] += 0.5  # in one of three components
    b["incidence"][2] = np.nan  # absent in one of them
    a["incidence"][3] = b["incidence"][3] = np.nan  # absent in both
    a.ranges[4] = np.nan
    b["incidence"][4] += 1  # of a beam that only one of them has
    a.ranges[5] = b.ranges[5] = np.nan
    b["incidence"][5] += 1  # of a beam that none of them has
    found = testing.difference(a, b, {"normal": 0.1, "incidence": 0.1})
    assert [list(testing.KINDS)[kind] for kind in found.kinds] == [
        "another owner", "another value", "another value", "the same", "only in the scan", "the same",
    ]  # fmt: skip
    assert found.worst == {"normal": 0.5, "incidence": np.inf}
    assert found.counts() == {"another value": 2, "another owner": 1, "only in the scan": 1}


def test_points_far_away_may_be_apart_by_what_rounding_adds():
    """Single precision has steps of 4e-6 m at 50 m, and so points of one range may be apart."""
    for x, allowed in ((50.0, True), (1.0, False)):
        a, b = Cloud(9, x), Cloud(9, x)
        b.points[:, 1] += np.float32(4e-5)
        counts = testing.difference(a, b, {"range": 0.0}).counts()
        assert counts == ({} if allowed else {"another place": 9})


def cells(text: str) -> list[list[str]]:
    """The rows of the tables of a page."""
    rows = re.findall(r"<tr>(.*?)</tr>", text)
    return [re.findall(r"<td>(.*?)</td>", row) for row in rows if "<td>" in row]


def test_the_page_lists_entries_by_beam_and_the_gravest_first(tmp_path):
    """Of a head of three channels with two returns."""
    wall = gnosphere.Mesh(*primitives.box((9, 9, 9)), [gnosphere.MeshPart(0, 12, 1)])
    pane = gnosphere.Mesh(*primitives.box((4, 4, 4)), [gnosphere.MeshPart(0, 12, 0)])
    materials = [gnosphere.Material("glass", (1, 1, 1, 0.1), alpha_mode="blend"), gnosphere.Material("wall")]
    scene = gnosphere.Scene(materials, [wall, pane], [gnosphere.Instance(0), gnosphere.Instance(1)])
    sensor = gnosphere.Sensor(
        columns=5, channels=[gnosphere.Channel(up) for up in (-5, 0, 5)], range_max=100, max_returns=2,
        azimuth_span_deg=-90,
    )  # fmt: skip
    effects = gnosphere.Effects.none()
    effects.transmission.use = effects.returns.use = effects.intensity.use = gnosphere.EffectUse.on
    options = gnosphere.SimulatorOptions(gnosphere.device_by_name("reference"))
    simulator = gnosphere.Simulator(scene, gnosphere.SensorRequest(sensor, effects), options)
    before, scan = simulator.scan(gnosphere.Pose()), simulator.scan(gnosphere.Pose())
    assert scan.returns == 2 and np.isfinite(scan.ranges).all()
    changed, gone = 2 * (1 * 5 + 3) + 1, 2 * (2 * 5 + 4)  # the second return of a beam, the first one of another
    scan.ranges[changed] += 0.25
    scan.instances[gone] = gnosphere.NO_TRIANGLE
    scan.triangles[gone], scan.ranges[gone] = gnosphere.NO_TRIANGLE, np.nan
    found = testing.difference(before, scan, {"range": 0.01})
    text = testing.page_of("name", tmp_path / "a.pcd", tmp_path / "b.pcd", before, scan, found, "said")
    listed = [row for row in cells(text) if len(row) == 7]
    expected = [
        ["2", "4", "only in the golden cloud", f"{before.ranges[gone]:.6g}", "nan",
         f"instance 1, triangle {before.triangles[gone]}", "none"],
        ["1", "3", "another range", f"{before.ranges[changed]:.6g}", f"{before.ranges[changed] + 0.25:.6g}",
         *[f"instance 0, triangle {before.triangles[changed]}"] * 2],
    ]  # fmt: skip
    assert listed == expected
    # The picture of what differs has a pixel of each beam, which has the colour of its gravest entry.
    data = re.search(r'base64,([^"]*)" title="What differs"', text)
    assert data
    picture = decode(base64.b64decode(data[1]))
    rows = picture[len(picture) // 6 :: len(picture) // 3]
    pixels = [tuple(pixel) for row in rows for pixel in row.tolist()]
    kinds = testing.KINDS
    assert pixels == [  # the highest channel on top, columns from left to right
        *[kinds["the same"]] * 4, kinds["only in the golden cloud"],
        *[kinds["the same"]] * 3, kinds["another range"], kinds["the same"], *[kinds["the same"]] * 5,
    ]  # fmt: skip


def test_of_beams_that_share_a_pixel_the_page_shows_the_gravest(tmp_path):
    """Of 1800 columns two share a pixel, whichever of them differs."""
    box = gnosphere.Mesh(*primitives.box((9, 9, 9)), [gnosphere.MeshPart(0, 12, 0)])
    scene = gnosphere.Scene([gnosphere.Material()], [box], [gnosphere.Instance(0)])
    sensor = gnosphere.Sensor(columns=1800, channels=[gnosphere.Channel()], range_max=100)
    options = gnosphere.SimulatorOptions(gnosphere.device_by_name("reference"))
    simulator = gnosphere.Simulator(scene, gnosphere.SensorRequest(sensor, gnosphere.Effects.none()), options)
    before, scan = simulator.scan(gnosphere.Pose()), simulator.scan(gnosphere.Pose())
    scan.ranges[[100, 501]] += 0.25
    found = testing.difference(before, scan, {"range": 0.01})
    text = testing.page_of("name", tmp_path / "a.npy", tmp_path / "b.npy", before, scan, found, "said")
    data = re.search(r'base64,([^"]*)" title="What differs"', text)
    assert data
    (row,) = np.unique(decode(base64.b64decode(data[1])), axis=0)
    assert np.flatnonzero((row == testing.KINDS["another range"]).all(axis=1)).tolist() == [899 - 250, 899 - 50]


def test_points_elsewhere_at_the_same_range_differ():
    plane = gnosphere.Mesh(
        np.array([[10, -99, -99], [10, 99, -99], [10, 0, 99]], np.float32), np.array([[0, 1, 2]], np.uint32),
        [gnosphere.MeshPart(0, 1, 0)],
    )  # fmt: skip
    scene = gnosphere.Scene([gnosphere.Material("grey")], [plane], [gnosphere.Instance(0)])
    angles, still = np.radians(np.linspace(-3, 3, 7)), np.zeros(7)
    clouds = []
    for rest in ((np.sin(angles), still), (still, np.sin(angles))):
        sensor = gnosphere.Sensor()
        sensor.range_max = 100
        sensor.patterns = [gnosphere.BeamList(np.stack([np.cos(angles), *rest], axis=1))]
        request = gnosphere.SensorRequest(sensor, gnosphere.Effects.none())
        options = gnosphere.SimulatorOptions(gnosphere.device_by_name("reference"))
        clouds.append(gnosphere.Simulator(scene, request, options).scan(gnosphere.Pose()))
    assert clouds[0].ranges == pytest.approx(clouds[1].ranges, abs=1e-5)
    assert testing.difference(*clouds, {"range": 0.001}).counts() == {"another place": 6}
    assert testing.difference(*clouds, {}).counts() == {}


def test_the_page(folder, pytester, device):
    """The test of docs/ci.md: written, the same, and another one after the scene has changed."""
    block = re.search(r"^```python\n(.*?)^```$", (REPOSITORY / "docs" / "ci.md").read_text(), re.M | re.S)
    assert block
    if gnosphere.name_of(device) == "reference":
        pytest.skip("accuracy exact needs a Vulkan device")
    pytester.makepyfile(test_lidar=block[1])
    Path(pytester.path, "scene.glb").symlink_to(folder / "town.glb")
    pytester.runpytest_subprocess("--gnosphere-update").assert_outcomes(passed=1)
    assert Path(pytester.path, "golden", "street.npy").stat().st_size < 30 * 28800
    pytester.runpytest_subprocess().assert_outcomes(passed=1)
    pytester.makepyfile(test_lidar=block[1].replace("(0, 0, 1.8)", "(0, 0, 1.9)"))
    pytester.runpytest_subprocess().assert_outcomes(failed=1)

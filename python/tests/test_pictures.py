# SPDX-License-Identifier: Apache-2.0
"""Pictures of scans, pixel by pixel where closed forms say what is seen."""

import re

import numpy as np
import pytest

import gnosphere
from gnosphere import adapter, pictures, primitives

BRIGHT, DARK = (253, 231, 37), (68, 1, 84)


def scan_of(shapes: adapter.Shapes, sensor: gnosphere.Sensor, effects=None) -> gnosphere.Scan:
    """A scan on the reference, which needs no Vulkan."""
    options = gnosphere.SimulatorOptions(gnosphere.device_by_name("reference"))
    return adapter.Lidar(shapes, sensor, effects=effects or gnosphere.Effects.none(), options=options).cast(
        gnosphere.Shot()
    )


def box(half, place=(0, 0, 0), alpha=1.0) -> adapter.Shapes:
    shapes = adapter.Shapes()
    rows = np.column_stack([np.eye(3), place])
    shapes.instance(shapes.mesh(primitives.box(half), shapes.material((0.5, 0.5, 0.5, alpha))), rows)
    return shapes


def listed(azimuths, elevations) -> gnosphere.Sensor:
    """A list of beams, angles in degrees."""
    around, up = np.broadcast_arrays(np.radians(azimuths), np.radians(elevations))
    directions = np.stack([np.cos(up) * np.cos(around), np.cos(up) * np.sin(around), np.sin(up)], axis=-1)
    return gnosphere.Sensor(range_max=100, patterns=[gnosphere.BeamList(directions)])


def test_colours_reach_from_low_to_high():
    found = pictures.colours(np.array([2, 8, -1, 9, np.nan, 3.2]), 2, 8)
    expected = [BRIGHT, DARK, BRIGHT, DARK, pictures.NOTHING, (122, 209, 81)]
    assert np.abs(found.astype(int) - expected).max() <= 1  # they are cut to whole numbers


def test_the_farthest_range_is_above_98_of_100():
    scan = scan_of(box((1, 500, 500), (11, 0, 0)), listed(np.linspace(0, 60, 1000), 0))
    assert (scan.ranges < pictures.farthest_of(scan)).sum() == 980


def test_from_above_x_is_up_and_y_is_left():
    azimuths = np.array([3, 30, -20, 93, 135, 175, 260])
    scan = scan_of(box((9.7, 9.7, 9.7)), listed(azimuths, 0))
    x, y = np.cos(np.radians(azimuths)), np.sin(np.radians(azimuths))
    x, y = np.stack([x, y]) * 9.7 / np.maximum(np.abs(x), np.abs(y))
    for farthest in (20.0, 9.0):  # at 9 m no point of this box is in the picture
        image = pictures.from_above(scan, farthest, 40)
        expected = {(int((1 - a / farthest) * 20), int((1 - b / farthest) * 20)) for a, b in zip(x, y)}
        drawn = np.argwhere((image != pictures.NOTHING).any(axis=2))
        assert {tuple(place) for place in drawn.tolist()} == (expected if farthest == 20 else set())
    # Without a range the picture reaches as far as the returns.
    assert np.array_equal(pictures.from_above(scan), pictures.from_above(scan, pictures.farthest_of(scan)))


def test_from_above_the_highest_point_of_a_pixel_is_seen_and_bright():
    """A wall before the sensor has many points above each other; another one, whose beams are level, is darker."""
    shapes = box((1, 500, 500), (11, 0, 0))
    elevations = np.linspace(-10, 10, 100)
    for turned in (elevations, -elevations):
        scan = scan_of(shapes, listed(np.r_[np.zeros(100), [40]], np.r_[turned, [-10]]))
        image = pictures.from_above(scan, 20.0, 40)
        assert image[10, 20].tolist() == [*BRIGHT]
        assert image[10, int((1 - 10 * np.tan(np.radians(40)) / 20) * 20)].tolist() == [*DARK]


def test_from_above_heights_have_colours_between_bright_and_dark():
    """A third of the points each 1 m below, at and 1 m above the sensor, on a wall 10 m ahead."""
    azimuths = np.repeat([0, 20, -20], 100)
    heights = np.repeat([-1, 0, 1], 100)
    elevations = np.degrees(np.arctan(heights / 10 * np.cos(np.radians(azimuths))))
    image = pictures.from_above(scan_of(box((1, 500, 500), (11, 0, 0)), listed(azimuths, elevations)), 20.0, 40)
    aside = int((1 - 10 * np.tan(np.radians(20)) / 20) * 20)
    for column, colour in ((20, DARK), (aside, (38, 144, 137)), (39 - aside, BRIGHT)):
        assert np.abs(image[10, column].astype(int) - colour).max() <= 1


def test_a_range_image_has_the_first_returns_and_nothing_where_there_is_none():
    shapes = box((9, 9, 9))
    shapes.instance(
        shapes.mesh(primitives.box((1, 2, 2)), shapes.material((1, 1, 1, 0.1))), np.eye(4) + 5 * np.eye(4, k=3)
    )
    effects = gnosphere.Effects.none()
    effects.transmission.use = effects.returns.use = effects.intensity.use = gnosphere.EffectUse.on
    sensor = gnosphere.Sensor(
        columns=12, channels=[gnosphere.Channel()], range_max=11, max_returns=2, azimuth_start_deg=90,
        azimuth_span_deg=-360,
    )  # fmt: skip
    scan = scan_of(shapes, sensor, effects)
    assert scan.returns == 2 and np.isfinite(scan.ranges.reshape(-1, 2)[:, 1]).any()
    azimuths = np.radians(90 - 30 * np.arange(12))
    expected = 9 / np.maximum(np.abs(np.cos(azimuths)), np.abs(np.sin(azimuths)))
    expected[3] = 4  # the pane
    image = pictures.range_image(scan, 11.0)
    assert image.shape == (128, 12, 3)
    found = image[0].astype(int) - pictures.colours(expected, 0, 11.0)
    assert np.abs(found).max() <= 1
    # The beams within 25 degrees of an axis, of 24 in all, see the walls within 10 m.
    sensor.columns, sensor.range_max = 24, 10
    unseen = (pictures.range_image(scan_of(box((9, 9, 9)), sensor))[0] == pictures.NOTHING).all(axis=1)
    assert unseen.tolist() == [column % 6 not in (0, 1, 5) for column in range(24)]


@pytest.mark.parametrize("name", ["RS-Bpearl", "HDL-64E", "HDL-32E", "Waymo-Top", "QT128", "Puck", "OS1-64", "VLP-16"])
def test_an_image_lies_as_the_beams_do_whatever_they_hit(name):
    sensor = gnosphere.builtin_sensor(name)
    directions = gnosphere.beams_of(sensor).directions.reshape(sensor.height(), sensor.width(), 3)
    top = directions[0, :, 2].mean() > directions[-1, :, 2].mean()
    left = np.cross(directions[0, :-1], directions[0, 1:])[:, 2].sum() < 0
    hits = []
    for place in ((4, 0, -0.14), (4, 0, -0.9), (5, 0, 0.09), (0, 0, 5000)):
        scan = scan_of(box((0.4, 0.4, 0.4), place), sensor)
        assert (scan.first_row_on_top, scan.first_column_on_left) == (top, left)
        hits.append(np.isfinite(scan.ranges).sum())
    assert max(hits) > 10 and hits[-1] == 0


@pytest.mark.parametrize("downwards", (False, True))
@pytest.mark.parametrize("clockwise", (False, True))
def test_a_field_image_is_upright_and_destaggered(downwards, clockwise):
    """Elevations fall from row to row, and azimuths from column to column, those of a column within half a step."""
    offsets = [-6.1, 0, 2.9, 47, -1]
    channels = [gnosphere.Channel(up, offset) for up, offset in zip((-20, -9, 3, 11, 20), offsets)]
    span = -360 if clockwise else 360
    sensor = gnosphere.Sensor(
        columns=120, channels=channels[::-1] if downwards else channels, range_max=100, azimuth_start_deg=37,
        azimuth_span_deg=span, max_returns=2,
    )  # fmt: skip
    options = gnosphere.SimulatorOptions(device="reference")
    effects = gnosphere.Effects.none()
    effects.returns.use = effects.intensity.use = "on"
    request = gnosphere.SensorRequest(sensor, effects, fields="azimuth,elevation,normal,class")
    scan = gnosphere.Simulator(box((9, 9, 9)).scene(), request, options).scan(gnosphere.Pose())
    assert scan.returns == 2
    up = np.degrees(pictures.field_image(scan, "elevation", sensor))
    assert np.allclose(up, np.array([[20], [11], [3], [-9], [-20]]), atol=1e-4)
    around = np.degrees(pictures.field_image(scan, "azimuth", sensor))
    assert np.allclose((np.diff(around, axis=1) + 180) % 360 - 180, -3, atol=1e-3)
    apart = (around - around[3] + 180) % 360 - 180  # row 3 is the channel without an offset
    assert np.abs(apart).max() <= 1.5 + 1e-3
    staggered = np.degrees(pictures.field_image(scan, gnosphere.Field.azimuth))
    assert np.abs((staggered - staggered[3] + 180) % 360 - 180).max() == pytest.approx(47, abs=1e-3)
    assert pictures.field_image(scan, "class").dtype == np.uint16
    normals = pictures.field_image(scan, "normal", sensor)
    assert normals.shape == (5, 120, 3)
    ahead = np.abs(around[2]) < 40
    assert np.allclose(normals[2, ahead], [-1, 0, 0])


def test_images_that_cannot_be_are_refused():
    sensor = gnosphere.Sensor(columns=12, channels=[gnosphere.Channel()], range_max=100, max_returns=2)
    effects = gnosphere.Effects.none()
    effects.returns.use = effects.intensity.use = "on"
    scan = scan_of(box((9, 9, 9)), sensor, effects)
    first = re.escape("of 2 returns per beam the first are values.reshape(-1, 2)[:, 0]")
    with pytest.raises(ValueError, match="values has 24 values, and the scan 12 beams, .*; " + first):
        pictures.beam_image(scan, scan.ranges)
    with pytest.raises(ValueError, match="it is a scan of another sensor"):
        pictures.field_image(scan, "range", gnosphere.builtin_sensor("Puck"))
    single = scan_of(box((9, 9, 9)), listed([0, 1], 0))
    assert pictures.field_image(single).shape == (1, 2)
    with pytest.raises(ValueError, match="no grid of a full turn, so its rows cannot be destaggered"):
        pictures.field_image(single, "range", listed([0, 1], 0))


def test_the_name_of_a_sensor_is_text_in_a_page():
    sensor = listed([0], 0)
    sensor.name = "<b>&"
    line = scan_of(box((9, 9, 9)), sensor)._repr_html_().partition("</p>")[0]
    assert "&lt;b>&amp;" in line and "<b>" not in line


@pytest.mark.parametrize("downwards", (False, True))
@pytest.mark.parametrize("clockwise", (False, True))
def test_the_axes_of_a_shown_scan_count_channels_and_columns(monkeypatch, downwards, clockwise):
    """Whatever the order of the beams, the value over a column and a channel is that of their beam."""
    plt = pytest.importorskip("matplotlib.pyplot")
    plt.switch_backend("agg")
    monkeypatch.setattr(plt, "show", lambda: None)
    channels = [gnosphere.Channel(up) for up in ((20, 5, -10) if downwards else (-10, 5, 20))]
    span = -90 if clockwise else 90
    sensor = gnosphere.Sensor(
        columns=8, channels=channels, range_max=100, azimuth_start_deg=-span / 2, azimuth_span_deg=span, max_returns=2,
    )  # fmt: skip
    shapes = box((9, 9, 9))
    shapes.instance(
        shapes.mesh(primitives.box((1, 2, 2)), shapes.material((1, 1, 1, 0.1))), np.eye(4) + 5 * np.eye(4, k=3)
    )
    effects = gnosphere.Effects.none()
    effects.transmission.use = effects.returns.use = effects.intensity.use = gnosphere.EffectUse.on
    scan = scan_of(shapes, sensor, effects)
    figure = pictures.show(scan)
    (shown,) = figure.axes[0].images
    left, right, bottom, top = shown.get_extent()
    values = np.asarray(shown.get_array())
    around = np.radians(-span / 2 + span / 8 * np.arange(8))
    up = np.radians([channel.elevation_deg for channel in channels])[:, None]
    ways = np.abs(np.stack(np.broadcast_arrays(np.cos(up) * np.cos(around), np.cos(up) * np.sin(around), np.sin(up))))
    expected = 9 / ways.max(axis=0)
    pane = 4 / ways[0]
    expected = np.where((pane * ways[1] < 2) & (pane * ways[2] < 2), pane, expected)  # its front; no beam meets a side
    for channel in range(3):
        for column in range(8):
            row = int((top - channel - 0.5) / (top - bottom) * len(values))
            place = int((column + 0.5 - left) / (right - left) * values.shape[1])
            assert values[row, place] == pytest.approx(expected[channel, column], rel=1e-5)
    plt.close("all")


def test_there_is_no_picture_of_a_scan_without_beams():
    scan = gnosphere.Scan()
    images = pictures.range_image, pictures.field_image, lambda scan: pictures.beam_image(scan, [])
    for draw in (*images, pictures.show, gnosphere.Scan.show):
        if draw in (pictures.show, gnosphere.Scan.show):
            pytest.importorskip("matplotlib")
        with pytest.raises(ValueError, match="the scan has no beams, so there is no picture of it"):
            draw(scan)
    assert (pictures.from_above(scan, 5.0) == pictures.NOTHING).all() and "<img" not in scan._repr_html_()


def test_a_cloud_of_ranges_alone_is_not_seen_from_above(tmp_path):
    gnosphere.write_cloud(scan_of(box((9, 9, 9)), listed([0, 1], 0)), tmp_path / "a.npy", gnosphere.CloudOptions("range"))
    scan = gnosphere.read_cloud(tmp_path / "a.npy")
    assert pictures.range_image(scan).shape == (128, 2, 3) and "<img" in scan._repr_html_()
    with pytest.raises(ValueError, match="ranges without points, so it cannot be seen from above"):
        pictures.from_above(scan)
    pytest.importorskip("matplotlib")
    with pytest.raises(ValueError, match="ranges without points"):
        scan.show()


def test_a_shown_figure_is_returned_and_not_kept(monkeypatch, tmp_path):
    plt = pytest.importorskip("matplotlib.pyplot")
    plt.switch_backend("agg")
    monkeypatch.setattr(plt, "show", lambda: None)
    scan = scan_of(box((9, 9, 9)), listed([0, 1, 2], 0))
    for field in ("range", gnosphere.Field.range):
        figure = scan.show(field)
        assert not plt.get_fignums() and figure.axes[0].get_title().endswith(": range")
    figure.savefig(tmp_path / "scan.png")
    assert (tmp_path / "scan.png").read_bytes().startswith(b"\x89PNG")

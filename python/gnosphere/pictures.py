# SPDX-License-Identifier: Apache-2.0
"""Pictures of scans for notebooks, plots and pages, made with NumPy alone: docs/python.md.

A picture is an array of shape (height, width, 3), uint8. `gnosphere.write_picture` writes larger ones with axes.
"""

import base64
import struct
import sys
import zlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._gnosphere import Field, Scan, Sensor, field_info

Pixels = NDArray[np.uint8]

NOTHING = (24, 24, 28)  # the colour of beams without a return
_WIDTH, _HEIGHT = 900, 128  # pixels: the most columns, and the least rows, of a range image
# Matplotlib's viridis at equal distances, reversed: what is near is bright.
_VIRIDIS = np.array([[253, 231, 37], [122, 209, 81], [34, 168, 132], [42, 120, 142], [65, 68, 135], [68, 1, 84]])


def colours(values: NDArray[Any], low: float, high: float) -> Pixels:
    """The colours of values between `low` (bright) and `high` (dark); NaN has the colour of nothing."""
    places = np.clip((np.asarray(values, float) - low) / max(high - low, 1e-9), 0, 1) * (len(_VIRIDIS) - 1)
    known = np.nan_to_num(places)
    pixels = np.stack([np.interp(known, np.arange(len(_VIRIDIS)), channel) for channel in _VIRIDIS.T], axis=-1)
    pixels[np.isnan(places)] = NOTHING
    return pixels.astype(np.uint8)


def farthest_of(scan: Scan) -> float:
    """A range, in metres, that 98 of 100 returns are below; 1 without returns."""
    ranges = scan.ranges[~np.isnan(scan.ranges)]
    return float(np.percentile(ranges, 98)) if len(ranges) else 1.0


def field_image(scan: Scan, field: str | Field = "range", sensor: Sensor | None = None) -> NDArray[Any]:
    """The values of a field of the first returns as an image of what the sensor sees, shape (channels, columns), or
    (channels, columns, components) of a vector: a range image without resampling. The uppermost channel is on top, and
    the columns are from left to right. Lists of beams without rows are one row.

    `sensor`, that of the scan, is given to destagger: the rows of channels with azimuth offsets are rotated by whole
    columns, so that all beams of a column of the image have the same azimuth within half a column. Raises ValueError
    for a scan without beams, for a sensor with other beams, and for one to destagger that is no grid of a full turn.
    """
    _require_beams(scan)
    values = scan[field]
    image = values.reshape(scan.channels, scan.columns, scan.returns, *values.shape[1:])[:, :, 0]
    if sensor is not None:
        image = _destaggered(scan, image, sensor)
    return _upright(scan, image)


def _destaggered(scan: Scan, image: NDArray[Any], sensor: Sensor) -> NDArray[Any]:
    if (scan.columns, scan.channels) != (sensor.width(), sensor.height()):
        raise ValueError(
            f"the scan has {scan.channels} x {scan.columns} beams, and the sensor {sensor.name} has {sensor.height()} x "
            f"{sensor.width()}: it is a scan of another sensor"
        )
    if not sensor.is_grid() or abs(sensor.azimuth_span_deg) != 360:
        raise ValueError(f"the sensor {sensor.name} is no grid of a full turn, so its rows cannot be destaggered")
    step = sensor.azimuth_span_deg / sensor.columns
    shifts = [round(channel.azimuth_offset_deg / step) for channel in sensor.channels]
    return np.stack([np.roll(row, shift, axis=0) for row, shift in zip(image, shifts)])


def _upright(scan: Scan, image: NDArray[Any]) -> NDArray[Any]:
    """The image of channels x columns with the uppermost channel on top and the leftmost column on the left."""
    image = image if scan.first_row_on_top else image[::-1]
    return image if scan.first_column_on_left else image[:, ::-1]


def beam_image(scan: Scan, values: NDArray[Any]) -> NDArray[Any]:
    """One value per beam as an image to look at, the uppermost channel on top, the columns from left to right as the
    sensor sees them: of more than 900 columns several share a pixel, which shows the least value that is not NaN, and of
    fewer than 128 channels each is repeated in as many rows as reach 128. field_image() does not resample. Lists of
    beams without rows are one row. Raises ValueError for a scan without beams, and if there is not one value per beam.
    """
    _require_beams(scan)
    given = np.asarray(values)
    if given.size != scan.beam_count():
        first = f"; of {scan.returns} returns per beam the first are values.reshape(-1, {scan.returns})[:, 0]"
        raise ValueError(
            f"values has {given.size} values, and the scan {scan.beam_count()} beams, of which a picture shows one value "
            f"each{first if scan.returns > 1 else ''}"
        )
    image = _upright(scan, given.reshape(scan.channels, scan.columns))
    step = -(-scan.columns // _WIDTH)
    if step > 1:
        starts = np.arange(0, scan.columns, step)
        image = np.fmin.reduceat(image, starts, axis=1)
    return np.repeat(image, max(1, -(-_HEIGHT // scan.channels)), axis=0)


def _require_beams(scan: Scan) -> None:
    if not scan.beam_count():
        raise ValueError("the scan has no beams, so there is no picture of it")


def _points_of(scan: Scan) -> NDArray[np.float32]:
    """The points of the returns."""
    if len(scan.points) != len(scan.ranges):
        raise ValueError("the scan is a cloud of ranges without points, so it cannot be seen from above")
    return scan.points[~np.isnan(scan.ranges)]


def range_image(scan: Scan, farthest: float | None = None) -> Pixels:
    """The ranges of the first returns, as beam_image() arranges them."""
    ranges = scan.ranges.reshape(-1, scan.returns)[:, 0]
    return colours(beam_image(scan, ranges), 0, farthest_of(scan) if farthest is None else farthest)


def from_above(scan: Scan, farthest: float | None = None, size: int = 400) -> Pixels:
    """The points within the range `farthest`, seen from above: x up, y to the left, coloured by height. Raises
    ValueError for a cloud of ranges without points."""
    reach = farthest_of(scan) if farthest is None else farthest
    points = _points_of(scan)
    places = np.floor((1 - points[:, :2] / max(reach, 1e-9)) * size / 2).astype(int)
    inside = ((places >= 0) & (places < size)).all(axis=1)
    points, places = points[inside], places[inside]
    order = np.argsort(points[:, 2], kind="stable")  # the highest point of a pixel is drawn last
    heights = np.full((size, size), np.nan)
    heights[places[order, 0], places[order, 1]] = points[order, 2]
    low, high = np.percentile(points[:, 2], [2, 98]) if len(points) else (0.0, 1.0)
    return colours(-heights, -float(high), -float(low))


def png(pixels: Pixels) -> bytes:
    """The picture as a PNG file."""
    height, width, _ = pixels.shape
    rows = np.concatenate([np.zeros((height, 1), np.uint8), pixels.reshape(height, -1)], axis=1)  # filter 0: none

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        chunk(kind, data)
        for kind, data in ((b"IHDR", header), (b"IDAT", zlib.compress(rows.tobytes(), 9)), (b"IEND", b""))
    )


def image_tag(pixels: Pixels, title: str) -> str:
    """The picture as an HTML element that holds it."""
    data = base64.b64encode(png(pixels)).decode()
    return f'<img src="data:image/png;base64,{data}" title="{title}" alt="{title}" style="max-width: 100%">'


def html_of(scan: Scan) -> str:
    """What a notebook shows of a scan: a line about it, and its range image."""
    line = repr(scan).strip("<>").replace("&", "&amp;").replace("<", "&lt;")
    if not scan.beam_count():
        return f"<p>{line}</p>"
    title = f"Ranges from 0 (bright) to {farthest_of(scan):.3g} m (dark)"
    return f"<p>{line}</p>{image_tag(range_image(scan), title)}"


def show(scan: Scan, field: str | Field = "range") -> Any:
    """Opens a window, or fills the cell of a notebook, with the beams and the points from above, coloured by a field.
    Returns the figure of Matplotlib, for savefig() and the like. Where no window stays open, Matplotlib keeps no
    reference to it. Raises ValueError for a scan without beams or points, and for a field with several components.
    """
    try:
        import matplotlib.pyplot as plt
    except ImportError:
        raise ImportError("Scan.show() draws with Matplotlib, which is not installed; pip install matplotlib") from None
    _require_beams(scan)
    points = _points_of(scan)
    values = np.asarray(scan[field], float)
    field = field if isinstance(field, str) else field_info(field).name
    if values.ndim > 1:
        raise ValueError(f"the field {field} has {values.shape[1]} components; show() takes fields with one")
    returned = ~np.isnan(scan.ranges)
    values = np.where(returned, values, np.nan)
    figure, (beams, above) = plt.subplots(2, 1, figsize=(9, 9), height_ratios=(1, 3), layout="constrained")
    first = beam_image(scan, values.reshape(-1, scan.returns)[:, 0])
    columns = (0, scan.columns) if scan.first_column_on_left else (scan.columns, 0)
    rows = (scan.channels, 0) if scan.first_row_on_top else (0, scan.channels)
    shown = beams.imshow(first, aspect="auto", interpolation="nearest", extent=(*columns, *rows))
    beams.set(title=f"{scan.sensor}: {field}", xlabel="column", ylabel="channel")
    above.scatter(*points.T[:2], c=values[returned], s=0.5, norm=shown.norm)
    above.set(xlabel="x (m)", ylabel="y (m)", aspect="equal")
    figure.colorbar(shown, ax=[beams, above], label=field)
    plt.show()
    if not plt.isinteractive():  # else the window is open, and a notebook has closed the figure that it has drawn
        plt.close(figure)
    _draw_once(figure)
    return figure


def _draw_once(figure: Any) -> None:
    """Keeps a notebook from drawing the figure a second time where it is what the cell ends with."""
    python = sys.modules.get("IPython")
    shell = python and python.get_ipython()
    if not python or not shell:
        return
    cell = shell.execution_count

    def display() -> None:
        if shell.execution_count != cell:
            del figure._ipython_display_
            python.display.display(figure)

    figure._ipython_display_ = display

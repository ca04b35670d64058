# SPDX-License-Identifier: Apache-2.0
"""The scanner of HELIOS++ with the settings of a leg as a Sensor."""

from __future__ import annotations

import copy
import math
import xml.etree.ElementTree as ET
from collections import Counter
from dataclasses import dataclass
from typing import Any, Optional

import numpy as np

from .. import _gnosphere as gno
from .assets import Matrix, Settings, about, number_of, rotation_of

_MOST_BEAMS = 1_000_000
"""Pulses of a scan that is a list, which lasts for a second otherwise."""

_READ_HERE = {
    *("accuracy_m", "pulseLength_ns", "wavelength_nm", "scanProduct"),
    *("scanAngleMax_deg", "scanAngleEffectiveMax_deg", "scanFreqMin_Hz", "scanFreqMax_Hz"),
}
"""Attributes of a scanner that a sensor does not hold: effects have them, or they are about a mirror that it lacks."""

_DIVERGENCE, _PULSE = 0.0003, 4.0
"""Radians and nanoseconds of scanners that do not state them, in HELIOS++."""

_LIGHT = 299792458.0
"""Metres a second."""

_MOST_RINGS = 5
"""Of sub-rays of a pulse, with the one in the middle: 1, 7, 19, 37 and 61 sub-rays."""

_SCAN_SECONDS = 0.05
"""About what a scan of a mirror's lines takes, or a line if that takes longer. All lines have the same directions, so over
trees a long scan tries each leaf on the beams of many lines, and a short one has few beams for what each scan costs."""

_MOST_SECONDS = 10
"""What a scan of a sensor takes at most."""

GAP = 1e-5
"""Seconds between two scans in which a platform that stands turns on, so that it stands still within each."""


@dataclass
class Scanner:
    """What a leg scans with."""

    sensor: gno.Sensor
    rate: float  # scans a second
    scans: int
    turn: Matrix  # of a head that stands still, in the axes of HELIOS++
    step: float  # degrees by which the head has turned on at the start of the next scan, counter-clockwise
    assumed: tuple[str, ...]
    ignored: tuple[str, ...]


@dataclass
class Sweep:
    """What a leg asks of the head and its mirror: degrees, Hz, seconds."""

    pulse_rate: float
    mirror_rate: float
    head_speed: float
    head_start: float
    duration: float


def scanner_of(element: ET.Element, detector: Settings, settings: Settings, duration: Optional[float]) -> Scanner:
    """The scanner of an element for a leg.

    detector: <detectorSettings> of the survey, which replace some of the scanner's.
    duration: seconds that the leg takes; None if it takes as long as the head needs for its sector.
    """
    element = copy.deepcopy(element)
    for name in ("rangeMin_m", "rangeMax_m"):
        if detector.has(name):
            element.set(name, detector.text(name))
    if settings.has("beamDivergence_rad"):
        element.set("beamDivergence_rad", settings.text("beamDivergence_rad"))
    assumed = element.get("beamDivergence_rad") is None
    if assumed:
        element.set("beamDivergence_rad", repr(_DIVERGENCE))
    sweep = _sweep(element, settings, duration)
    _set_scan_angle(element, settings, sweep)
    channels = element.find("channels") is not None
    stands = sweep.head_speed == 0
    if stands:
        element.attrib.pop("headRotatePerSecMax_deg", None)
    if channels and stands and _first(element, "scanFreqMax_Hz") == 0:
        raise ValueError(f"the scanner '{element.get('id')}' neither turns nor has a mirror that moves")
    scanner = _lines(element, sweep) if stands else _turning(element, sweep, channels)
    _cut_vertically(element, scanner.sensor, settings)
    if assumed:
        scanner.assumed += (f"a divergence of {_DIVERGENCE:g} rad, as HELIOS++ does",)
    return scanner


def _sweep(element: ET.Element, settings: Settings, duration: Optional[float]) -> Sweep:
    pulse_rate = settings.number("pulseFreq_hz")
    if pulse_rate <= 0:
        pulse_rate = _first(element, "pulseFreqs_Hz")
    most, speed = _first(element, "headRotatePerSecMax_deg"), settings.number("headRotatePerSec_deg")
    mirror_rate = settings.number("scanFreq_hz")
    # Angles between pulses and between lines give the speeds of the mirror and of the head.
    if settings.number("verticalResolution_deg") > 0:
        swept = 2 * _first(element, "scanAngleMax_deg")
        mirror_rate = settings.number("verticalResolution_deg") * pulse_rate / swept if swept else mirror_rate
    if settings.number("horizontalResolution_deg") > 0:
        speed = math.copysign(settings.number("horizontalResolution_deg") * mirror_rate, speed)
    speed = min(max(speed, -most), most)
    start, stop = settings.number("headRotateStart_deg"), settings.number("headRotateStop_deg")
    if duration is None:
        if speed == 0 or start == stop:
            raise ValueError(
                "a leg of a platform that stands needs headRotatePerSec_deg, headRotateStart_deg and headRotateStop_deg"
            )
        duration = abs(stop - start) / abs(speed)
    most_seconds = settings.number("max_duration")
    if most_seconds > 0:
        duration = min(duration, most_seconds)
    return Sweep(pulse_rate, mirror_rate, speed, start, duration)


def _first(element: ET.Element, name: str) -> float:
    """The number in an attribute of the scanner, the first one if commas separate several; 0 if there is none."""
    return number_of(element.get(name, "0").split(",")[0], f"{name} of the scanner '{element.get('id')}'")


def _set_scan_angle(element: ET.Element, settings: Settings, sweep: Sweep) -> None:
    """A polygon sweeps all its angles and lets fewer out; the other mirrors sweep less."""
    angle, most = settings.number("scanAngle_deg"), _first(element, "scanAngleMax_deg")
    if angle <= 0 or most <= 0:
        return
    if element.get("optics", "").lower() == "rotating":
        if element.get("scanAngleEffectiveMax_deg") is not None:
            most = _first(element, "scanAngleEffectiveMax_deg")
        element.set("scanAngleEffectiveMax_deg", repr(min(angle, most)))
        return
    product = _first(element, "scanProduct")
    if product > 0 and sweep.mirror_rate > 0:
        angle = min(angle, product / sweep.mirror_rate)
    element.set("scanAngleMax_deg", repr(min(angle, most)))


def _read(element: ET.Element, sweep: Sweep, **options: Any) -> gno.SensorFile:
    identifier = element.get("id", "")
    chosen = gno.SensorFileOptions(mode=f"{identifier}:{sweep.pulse_rate!r}", **options)
    document = ET.Element("document")
    document.append(element)
    return gno.read_sensor_file(ET.tostring(document), f"{identifier}.xml", chosen)


def _mirror_rate_of(element: ET.Element, sweep: Sweep) -> float:
    rate = sweep.mirror_rate or _first(element, "scanFreqMax_Hz")
    if rate <= 0:
        raise ValueError(f"the scanner '{element.get('id')}' needs scanFreq_hz")
    return rate


def _lines(element: ET.Element, sweep: Sweep) -> Scanner:
    """A mirror that sweeps lines while the head stands: a scan is several lines, and the leg is a number of scans."""
    most, mirror_rate = _first(element, "scanFreqMax_Hz"), _mirror_rate_of(element, sweep)
    # Pulses are whole in a period, which must not make the mirror faster than it can be.
    pulses = max(math.floor(sweep.pulse_rate / mirror_rate + 1e-9), 1)
    if most > 0 and sweep.pulse_rate / pulses > most * (1 + 1e-9):
        pulses += 1
    period = pulses / sweep.pulse_rate
    channels = element.find("channels")
    beams = pulses * (len(channels) if channels is not None else 1)
    lines = max(round(sweep.duration / period), 1)
    fewest = math.ceil(lines / max(min(round(_SCAN_SECONDS / period), _MOST_BEAMS // beams), 1))
    scans = _scans_of(lines, fewest)
    rate = 1 / (max(round(lines / scans), 1) * period)
    found = _read(element, sweep, columns=pulses, scan_rate=rate)
    assumed = tuple(what for what in found.assumed if not what.startswith("scans of"))
    return Scanner(found.sensor, rate, scans, about("z", sweep.head_start), 0, assumed, found.ignored)


def _scans_of(lines: int, fewest: int) -> int:
    """The number of equal scans, at least the fewest, that have the wanted number of lines most nearly."""
    return min(range(fewest, 2 * fewest + 1), key=lambda count: abs(count * max(round(lines / count), 1) - lines))


def _turning(element: ET.Element, sweep: Sweep, channels: bool) -> Scanner:
    """A head that turns: a scan is a turn of it, or a sector. Turns and sectors of more than 10 s are several scans."""
    speed, turns = sweep.head_speed, abs(sweep.head_speed) / 360
    options: dict[str, Any] = {}
    line_rate = sweep.pulse_rate
    if not channels:
        line_rate = max(math.floor(_mirror_rate_of(element, sweep) / turns + 1e-6), 1) * turns
        options["columns"] = 1
    # A head that turns once in a line is read, because a turn of more than 10 s would have no times.
    found = _read(element, sweep, scan_rate=line_rate, **options)
    sensor = found.sensor
    sensor.channels = tuple(
        gno.Channel(
            channel.elevation_deg,
            channel.azimuth_offset_deg + (speed - 360 * line_rate) * channel.time_offset,
            channel.origin,
            channel.time_offset,
            channel.range_min,
            channel.range_max,
        )
        for channel in sensor.channels
    )
    in_turn = max(math.floor(line_rate / turns + 1e-6), 1)
    if 1 / turns <= _MOST_SECONDS and sweep.duration * turns >= 1:
        columns, scans, rate, step = in_turn, round(sweep.duration * turns), turns, 0.0
    else:
        lines = max(round(line_rate * sweep.duration), 1)
        scans = _scans_of(lines, math.ceil(lines / max(math.floor(_MOST_SECONDS * line_rate + 1e-6), 1)))
        columns = max(round(lines / scans), 1)
        rate = 1 / (columns / line_rate + (GAP if scans > 1 else 0))
        step = speed * columns / line_rate if scans > 1 else 0.0
    sensor.columns = columns
    sensor.rotation_period = columns / line_rate
    sensor.azimuth_start_deg = math.remainder(sweep.head_start, 360)
    sensor.azimuth_span_deg = min(max(speed * columns / line_rate, -360.0), 360.0)
    sensor.scan_period = max(1 / rate, sensor.rotation_period)
    return Scanner(sensor, rate, scans, np.eye(3), step, found.assumed, found.ignored)


def _cut_vertically(element: ET.Element, sensor: gno.Sensor, settings: Settings) -> None:
    """Leaves the pulses between verticalAngleMin_deg and verticalAngleMax_deg of the mirror."""
    if not (settings.has("verticalAngleMin_deg") or settings.has("verticalAngleMax_deg")):
        return
    low, high = settings.number("verticalAngleMin_deg", -180), settings.number("verticalAngleMax_deg", 180)
    if not np.array_equal(rotation_of(element.find("beamOrigin")), np.eye(3)) or not sensor.is_grid():
        raise ValueError(
            f"verticalAngleMin_deg and verticalAngleMax_deg are read for heads that turn and whose beam's origin does "
            f"not, which the scanner '{element.get('id')}' is not"
        )
    kept = tuple(channel for channel in sensor.channels if low < channel.elevation_deg <= high)
    if not kept:
        raise ValueError(f"no pulse of the scanner '{element.get('id')}' is from {low:g} to {high:g} degrees")
    sensor.channels = kept


def ignored_of(scanner: Scanner) -> Counter[str]:
    """What the element of a scanner states and nothing here reads, such as the power of its laser."""
    counts: Counter[str] = Counter()
    for text in scanner.ignored:
        name, _, channel = text.partition(" of the channel ")
        if channel:
            counts[f"{name} of channels"] += 1
        elif name not in _READ_HERE:
            counts[f"{name} of the scanner"] += 1
    return counts


def effects_of(
    element: ET.Element, detector: Settings, waveform: Settings, assumed: dict[str, None], left_out: Counter[str]
) -> dict[str, Any]:
    """Effects of a drive file: those that the head calls for, with what its element states. Those of `divergence` are for
    legs whose sensor has one.

    waveform: <FWFSettings>.
    """
    effects: dict[str, Any] = {}
    pulse, window = _first(element, "pulseLength_ns"), waveform.number("winSize_ns")
    if element.get("pulseLength_ns") is None:
        pulse = _PULSE
        assumed[f"pulses of {_PULSE:g} ns, as HELIOS++ does"] = None
    if pulse > 0:
        effects["returns"] = {"pulse_width": pulse * 1e-9}
    if max(pulse, window) > 0:
        separation = min(max(pulse, window) * 1e-9 * _LIGHT / 2, 100.0)
        effects.setdefault("returns", {})["separation"] = round(separation, 4)
    if waveform.has("beamSampleQuality"):
        rings = max(round(waveform.number("beamSampleQuality")), 1)
        if rings > _MOST_RINGS:
            left_out["sub-rays of a pulse beyond 61 (beamSampleQuality)"] += 1
            rings = _MOST_RINGS
        effects["divergence"] = {"sub_rays": 3 * rings * rings - 3 * rings + 1}
    others = waveform.others({"winSize_ns", "beamSampleQuality"})
    if others:
        left_out["settings of full waveforms"] += len(others)
    accuracy = detector.number("accuracy_m", _first(element, "accuracy_m"))
    if accuracy > 0:
        effects["range-noise"] = {"use": "on", "sigma": accuracy}
    wavelength = _first(element, "wavelength_nm")
    if wavelength > 0:
        effects["intensity"] = {"wavelength": 1550 if wavelength > 1200 else 905}
        if wavelength not in (905, 1550):
            left_out["wavelengths that are taken as 905 or 1550 nm"] += 1
    return effects

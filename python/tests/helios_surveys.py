# SPDX-License-Identifier: Apache-2.0
"""Surveys of HELIOS++ that tests read, and the points of the LAS that their drives make."""

import struct
from typing import NamedTuple

import numpy as np
from conftest import program

PLATFORMS = """<document>
<platform id="aircraft" type="linearpath"><scannerMount z="0.7"><rot axis="x" angle_deg="-90"/>
  <rot axis="z" angle_deg="90"/></scannerMount></platform>
<platform id="tripod" type="static"><scannerMount z="1.5"/></platform>
<platform id="copter" type="multicopter"><attitudeXNoise type="NORMAL"/></platform></document>"""

SCANNERS = """<document>
<scanner id="polygon" optics="rotating" pulseFreqs_Hz="2000" scanAngleMax_deg="45" scanAngleEffectiveMax_deg="30"
  scanFreqMin_Hz="10" scanFreqMax_Hz="200" beamDivergence_rad="0.0005" rangeMin_m="10" maxNOR="4" accuracy_m="0.02"
  pulseLength_ns="4"/>
<scanner id="head" optics="rotating" pulseFreqs_Hz="2000" scanAngleMax_deg="50" headRotatePerSecMax_deg="60"
  scanFreqMin_Hz="3" scanFreqMax_Hz="120" rangeMin_m="0.5" maxNOR="1"><beamOrigin z="0.2"/></scanner>
<scanner id="prism" optics="risley" pulseFreqs_Hz="2000"/></document>"""

# A ground of 400 x 400 m at z 5, and a plate of 4 x 6 m at (0, 30), z 15. The plate's file has y upwards.
SCENE = """<document><scene id="yard">
<part><filter type="objloader"><param type="string" key="filepath" value="data/ground.obj"/></filter>
  <filter type="scale"><param type="double" key="scale" value="200"/></filter>
  <filter type="translate"><param type="vec3" key="offset" value="0;0;5"/></filter></part>
<part><filter type="objloader"><param type="string" key="filepath" value="data/plate.obj"/>
    <param type="string" key="up" value="y"/></filter>
  <filter type="rotate"><param key="rotation" type="rotation"><rot axis="z" angle_deg="90"/></param></filter>
  <filter type="translate"><param type="vec3" key="offset" value="0;30;5"/></filter></part></scene></document>"""

LIBRARY = """newmtl soil
Kd 1 1 1
helios_classification 2
helios_reflectance 30
newmtl roof
helios_isGround false
helios_classification 6
"""

AIRBORNE = """<document><platformSettings id="fast" movePerSec_m="30" z="105"/>
<scannerSettings id="wide" active="true" pulseFreq_hz="2000" scanAngle_deg="20" scanFreq_hz="40"/>
<survey name="lines" platform="data/platforms.xml#aircraft" scanner="data/scanners.xml#polygon"
  scene="data/scene.xml#yard">
<leg><platformSettings template="fast" x="-30" y="-50"/><scannerSettings template="wide"/></leg>
<leg><platformSettings template="fast" x="70" y="-50"/><scannerSettings template="wide" active="false"/></leg>
<leg><platformSettings template="fast" x="70" y="0"/><scannerSettings template="wide"/></leg>
<leg><platformSettings template="fast" x="-30" y="0"/></leg></survey></document>"""

TERRESTRIAL = """<document><survey name="stations" platform="data/platforms.xml#tripod" scanner="data/scanners.xml#head"
  scene="data/scene.xml#yard"><leg><platformSettings x="0" y="0" onGround="true"/><scannerSettings pulseFreq_hz="2000"
  scanFreq_hz="20" verticalAngleMin_deg="-40" verticalAngleMax_deg="30" headRotatePerSec_deg="10"
  headRotateStart_deg="-30" headRotateStop_deg="90"/></leg></survey></document>"""


def write_surveys(folder):
    """Writes two surveys, air.xml and ground.xml, and the folder data with what they name. Returns the folder."""
    (folder / "data").mkdir()
    files = {
        "data/platforms.xml": PLATFORMS, "data/scanners.xml": SCANNERS, "data/scene.xml": SCENE, "data/m.mtl": LIBRARY,
        "data/ground.obj": "mtllib m.mtl\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nusemtl soil\nf 1 2 3 4\n",
        "data/plate.obj": "mtllib m.mtl\nusemtl roof\nv -3 10 -2\nv 3 10 -2\nv 3 10 2\nv -3 10 2\nf 1 2 3 4\n",
        "air.xml": AIRBORNE, "ground.xml": TERRESTRIAL,
    }  # fmt: skip
    for name, text in files.items():
        (folder / name).write_text(text)
    return folder


class Points(NamedTuple):
    """Points of LAS: coordinates (n, 3), intensities (1 is white), classes, GPS times in seconds,
    numbers of returns of their pulses."""

    xyz: np.ndarray
    intensities: np.ndarray
    classes: np.ndarray
    times: np.ndarray
    returns: np.ndarray


def points_of(file):
    """The points of LAS 1.4 with data records of format 6."""
    data = file.read_bytes()
    start, length = struct.unpack_from("<I", data, 96)[0], struct.unpack_from("<H", data, 105)[0]
    scale, offset = np.frombuffer(data, "<f8", 3, 131), np.frombuffer(data, "<f8", 3, 155)
    rows = np.frombuffer(data, np.uint8, offset=start)[: struct.unpack_from("<Q", data, 247)[0] * length]
    rows = rows.reshape(-1, length)

    def column(first, end, kind):
        return np.ascontiguousarray(rows[:, first:end]).view(kind)

    xyz = column(0, 12, "<i4") * scale + offset
    return Points(xyz, column(12, 14, "<u2")[:, 0] / 65535, rows[:, 16], column(22, 30, "<f8")[:, 0], rows[:, 14] >> 4)


def made(file, folder):
    """The points of a drive file's one scanner."""
    program("drive", file, "-o", folder)
    (cloud,) = (folder / "las").glob("*.las")
    return points_of(cloud)

# SPDX-License-Identifier: Apache-2.0
"""python -m gnosphere.helios SURVEY: tells what a survey of HELIOS++ has, and writes a drive file for each leg."""

from __future__ import annotations

import argparse
import signal
import sys
import warnings

from .. import _gnosphere as gno
from .survey import Survey, read_survey


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m gnosphere.helios", description=__doc__)
    parser.add_argument("survey", help="XML of a survey")
    parser.add_argument(
        "--assets", action="append", default=[], metavar="FOLDER", help="where paths such as data/platforms.xml start"
    )
    parser.add_argument("-o", "--output", metavar="FOLDER", help="write leg-000.json and so on, for gnosphere drive")
    parser.add_argument(
        "--epoch",
        type=float,
        default=315964800,
        metavar="SECONDS",
        help="Unix time of the start, for LAS; 315964800 if not given, the epoch of GPS in 1980",
    )
    given = parser.parse_args()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # what is left out is printed
            found = read_survey(given.survey, given.assets, given.epoch)
        describe(found)
        if given.output:
            for file in found.write(given.output):
                print(f"wrote {file}")
    except (OSError, ValueError, gno.Error) as error:
        print(f"gnosphere.helios: {error}", file=sys.stderr)
        return 1
    return 0


def describe(survey: Survey) -> None:
    print(f"survey {survey.name}: {len(survey.legs)} of {survey.leg_count} legs scan")
    for leg in survey.legs:
        scans = round(leg.drive["duration"] * leg.drive["rate"])
        print(f"leg {leg.number}: {leg.duration:.3f} s, {scans} scans of {leg.sensor.beam_count():,} pulses")
    for what in survey.assumed:
        print(f"assumed: {what}")
    for what, count in survey.left_out.items():
        print(f"left out: {what} ({count})")


if __name__ == "__main__":
    if hasattr(signal, "SIGPIPE"):  # Windows has none
        signal.signal(signal.SIGPIPE, signal.SIG_DFL)  # ends without a word when nobody reads on, as `gnosphere` does
    sys.exit(main())

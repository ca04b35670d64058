# SPDX-License-Identifier: Apache-2.0
"""A plug-in of pytest that compares scans with golden clouds: docs/ci.md.

    def test_street(golden_cloud):
        golden_cloud("street", simulator.scan(pose))

pytest finds it where gnosphere is installed. `pytest --gnosphere-update` writes the golden clouds.
"""

import html
import os
import shlex
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from . import pictures
from ._gnosphere import NO_TRIANGLE, CloudOptions, Scan, read_cloud, write_cloud

# What may be different about an entry of two clouds, the gravest last, with the colour that it has on the page.
KINDS = {
    "the same": (70, 70, 76),
    "another value": (255, 214, 64),
    "another place": (255, 170, 32),
    "another range": (255, 128, 0),
    "another owner": (226, 64, 226),
    "only in the golden cloud": (255, 48, 48),
    "only in the scan": (64, 160, 255),
}
_WRITTEN = pytest.StashKey[list[Path]]()
_ALWAYS = ("x", "y", "z", "range", "triangle", "instance")
_WHOSE = ("beam", "return")  # Files of several returns have a row per return, which says whose it is.


@dataclass
class Difference:
    """What differs between a golden cloud and a scan, entry by entry."""

    kinds: NDArray[np.uint8]  # an index into KINDS per entry
    worst: dict[str, float]  # the largest difference of each field, over entries that both have

    def counts(self) -> dict[str, int]:
        """How many entries differ in each way, of those in which some do."""
        found = np.bincount(self.kinds, minlength=len(KINDS))
        return {kind: int(count) for kind, count in zip(list(KINDS)[1:], found[1:], strict=True) if count}


def difference(golden: Scan, scan: Scan, tolerances: Mapping[str, float]) -> Difference:
    """Compares two clouds of the same beams, entry by entry. `tolerances`: the largest difference of a field, in its
    unit, that is still the same. With one for the range, points may be as far apart, and by what rounding adds."""
    there, here = ~np.isnan(golden.ranges), ~np.isnan(scan.ranges)
    kinds = np.zeros(len(there), np.uint8)
    names = list(KINDS)
    both = there & here
    worst = {}
    if "range" in tolerances:
        apart = np.linalg.norm(np.asarray(scan.points, float) - golden.points, axis=1)
        worst["point"] = float(apart[both].max(initial=0))
        kinds[both & (apart > tolerances["range"] + 1e-6 * golden.ranges)] = names.index("another place")
    for name, tolerance in sorted(tolerances.items(), key=lambda entry: entry[0] == "range"):
        off = np.abs(np.asarray(scan[name], float) - np.asarray(golden[name], float))
        off = off if off.ndim == 1 else off.max(axis=1)
        # A value that one of them does not have, such as NaN, is as far off as can be.
        off = np.where(np.isnan(off), np.where(_absent(golden[name]) & _absent(scan[name]), 0, np.inf), off)
        worst[name] = float(off[both].max(initial=0))
        kinds[both & (off > tolerance)] = names.index("another range" if name == "range" else "another value")
    owner = (golden.triangles != scan.triangles) | (golden.instances != scan.instances)
    kinds[both & owner] = names.index("another owner")
    kinds[there & ~here] = names.index("only in the golden cloud")
    kinds[here & ~there] = names.index("only in the scan")
    return Difference(kinds, worst)


def _absent(values: NDArray[Any]) -> NDArray[np.bool_]:
    absent: NDArray[np.bool_] = np.isnan(np.asarray(values, float).reshape(len(values), -1)).any(axis=1)
    return absent


class GoldenCloud:
    """Compares scans with the clouds in the folder `golden` beside the test's file."""

    def __init__(self, folder: Path, config: pytest.Config) -> None:
        self.folder = folder
        self.pages = Path(os.path.abspath(config.getoption("--gnosphere-pages")))
        self.update = bool(config.getoption("--gnosphere-update"))
        self.written = config.stash.setdefault(_WRITTEN, [])

    def __call__(
        self,
        name: str,
        scan: Scan,
        *,
        exact: bool = False,
        tolerance: float = 1e-3,
        tolerances: Mapping[str, float] | None = None,
        allowed: int = 0,
        fields: str = "",
    ) -> None:
        """Fails unless the scan is the golden cloud `name`, golden/NAME.npy beside the test's file; golden/NAME.pcd if
        its beams have several returns. Raises ValueError for `tolerances` with a range.

        exact: every byte is the same; scan with Accuracy.exact, which has the same bytes on every device.
        tolerance: metres that ranges may differ, and points may be apart, if not exact; owners and the beams with a
            return must be the same.
        tolerances: the same for fields other than the range, by name, in their units: {"intensity": 0.01}.
        allowed: entries that may differ in whatever way, if not exact.
        fields: more fields that the golden cloud keeps, such as "intensity,class"; those of `tolerances` are added.
        """
        if "range" in (tolerances or {}):
            raise ValueError("golden_cloud: `tolerances` has a range; state it as `tolerance`, in metres")
        limits = {**(tolerances or {}), "range": tolerance}
        always = _ALWAYS if scan.returns == 1 else (*_ALWAYS, *_WHOSE)
        kept = dict.fromkeys([*always, *filter(None, fields.split(",")), *limits])  # each of them once
        options = CloudOptions(tuple(kept))
        file = f"{name}.npy" if scan.returns == 1 else f"{name}.pcd"
        golden = self.folder / file
        if self.update:
            golden.parent.mkdir(parents=True, exist_ok=True)
            write_cloud(scan, golden, options)
            self.written.append(golden)
            return
        if not golden.exists():
            pytest.fail(f"there is no golden cloud {golden}; look at the scan, then run pytest --gnosphere-update", False)
        content = _bytes_of(scan, file, options)
        if content == golden.read_bytes():
            return
        before = read_cloud(golden)
        shapes = [(cloud.channels, cloud.columns, cloud.returns) for cloud in (before, scan)]
        if shapes[0] != shapes[1]:
            kept_shape, shape = (" x ".join(map(str, each)) for each in shapes)
            pytest.fail(
                f"the golden cloud {golden} has {kept_shape} channels x columns x returns, the scan {shape}: another "
                "sensor",
                False,
            )
        absent = [n for n in limits if n not in before]
        if absent:
            pytest.fail(f"the golden cloud {golden} has no {absent[0]}; run pytest --gnosphere-update", False)
        found = difference(before, scan, {} if exact else limits)
        counts = found.counts()
        if not exact and sum(counts.values()) <= allowed:
            return
        if exact:
            found = difference(before, scan, dict.fromkeys(limits, 0.0))
            counts = found.counts()
        said = ", ".join(f"{count} {kind}" for kind, count in counts.items()) or "values of other fields differ"
        made, page = self.pages / file, self.pages / f"{name}.html"
        try:
            made.parent.mkdir(parents=True, exist_ok=True)
            made.write_bytes(content)
            page.write_text(page_of(name, golden, made, before, scan, found, said))
            where = f"look at {page}"
        except OSError as error:
            where = f"a page that shows it cannot be written ({error}); name a folder with --gnosphere-pages"
        pytest.fail(f"{name} differs from its golden cloud: {said}; {where}", False)


def _bytes_of(scan: Scan, file: str, options: CloudOptions) -> bytes:
    """The file of a cloud, which is written nowhere near the tests: their folder may be read-only, or shared."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / Path(file).name
        write_cloud(scan, path, options)
        return path.read_bytes()


def page_of(name: str, golden: Path, made: Path, before: Scan, scan: Scan, found: Difference, said: str) -> str:
    """An HTML page with both clouds and what differs."""
    farthest = max(pictures.farthest_of(before), pictures.farthest_of(scan))
    palette = np.array(list(KINDS.values()), np.uint8)
    # The gravest of a beam's entries; beam_image() shows the least of a pixel, hence the signs.
    gravest = found.kinds.reshape(-1, scan.returns).max(axis=1).astype(float)
    gravest[np.isnan(before.ranges.reshape(-1, scan.returns)[:, 0]) & (gravest == 0)] = np.nan
    image = -pictures.beam_image(scan, -gravest)
    differing = palette[np.nan_to_num(image).astype(int)]
    differing[np.isnan(image)] = pictures.NOTHING
    swatch = '<span style="background: rgb{}">&emsp;</span> {}'
    legend = " &emsp; ".join(swatch.format(colour, kind) for kind, colour in KINDS.items())
    rows = "".join(f"<tr><td>{html.escape(n)}</td><td>{value:.6g}</td></tr>" for n, value in found.worst.items())
    entries = np.flatnonzero(found.kinds)
    entries = entries[np.argsort(-found.kinds[entries], kind="stable")]
    shown = entries[np.unique(np.linspace(0, len(entries) - 1, 20).astype(int))] if len(entries) else entries
    listed = "".join(
        f"<tr><td>{entry // scan.returns // scan.columns}</td><td>{entry // scan.returns % scan.columns}</td>"
        f"<td>{list(KINDS)[found.kinds[entry]]}</td><td>{before.ranges[entry]:.6g}</td><td>{scan.ranges[entry]:.6g}</td>"
        f"<td>{_owner(before, entry)}</td><td>{_owner(scan, entry)}</td></tr>"
        for entry in map(int, shown)
    )
    both = "".join(
        f"<figure>{pictures.image_tag(pictures.from_above(cloud, farthest), title)}<figcaption>{title}, from above"
        "</figcaption></figure>"
        for title, cloud in (("The golden cloud", before), ("The scan", scan))
    )
    command = f"gnosphere view {shlex.quote(str(golden))} {shlex.quote(str(made))} -o difference.html"
    return f"""<!doctype html>
<html lang="en">
<meta charset="utf-8">
<title>{html.escape(name)}: {html.escape(said)}</title>
<style>
  body {{ font: 15px/1.5 sans-serif; max-width: 920px; margin: 2em auto; padding: 0 1em }}
  img {{ image-rendering: pixelated; width: 100% }}
  figure {{ margin: 1em 0 }}
  .pair {{ display: flex; gap: 1em }}
  .pair figure {{ flex: 1 }}
  td, th {{ padding: 0 1em 0 0; text-align: left }}
</style>
<h1>{html.escape(name)}</h1>
<p>{html.escape(said)}, of {len(found.kinds)} entries.</p>
<figure>{pictures.image_tag(pictures.range_image(before, farthest), "The golden cloud")}
<figcaption>The golden cloud: ranges from 0 (bright) to {farthest:.3g} m (dark)</figcaption></figure>
<figure>{pictures.image_tag(pictures.range_image(scan, farthest), "The scan")}
<figcaption>The scan</figcaption></figure>
<figure>{pictures.image_tag(differing, "What differs")}
<figcaption>{legend}</figcaption></figure>
<div class="pair">{both}</div>
<table><tr><th>field</th><th>largest difference where both have a return</th></tr>{rows}</table>
<h2>{len(shown)} of the {len(entries)}, the gravest first</h2>
<table><tr><th>channel</th><th>column</th><th></th><th>golden range</th><th>range</th><th>golden owner</th><th>owner</th></tr>
{listed}</table>
<p>In three dimensions: <code>{html.escape(command)}</code>. If the scan is right: <code>pytest --gnosphere-update</code>.</p>
</html>
"""


def _owner(scan: Scan, entry: int) -> str:
    if scan.triangles[entry] == NO_TRIANGLE:
        return "none"
    return f"instance {scan.instances[entry]}, triangle {scan.triangles[entry]}"


def pytest_addoption(parser: pytest.Parser) -> None:
    group = parser.getgroup("gnosphere")
    group.addoption("--gnosphere-update", action="store_true", help="write the golden clouds anew, from the scans")
    group.addoption(
        "--gnosphere-pages",
        default="gnosphere-pages",
        metavar="FOLDER",
        help="where the page and the cloud of a scan that differs are left (gnosphere-pages)",
    )


@pytest.fixture
def golden_cloud(request: pytest.FixtureRequest) -> GoldenCloud:
    """A function that fails unless a scan is a golden cloud: golden_cloud("street", scan)."""
    return GoldenCloud(request.path.parent / "golden", request.config)


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    for path in config.stash.get(_WRITTEN, []):
        terminalreporter.write_line(f"wrote the golden cloud {path}")

# SPDX-License-Identifier: Apache-2.0
"""The examples and the blocks of docs/python.md run, and their types are right."""

import re
import subprocess
import sys

import numpy as np
import pytest
from conftest import REPOSITORY, program

from gnosphere import Error
from gnosphere import drive as drives

EXAMPLES = REPOSITORY / "python" / "examples"


def example(folder, name: str, *arguments: object) -> str:
    command = [sys.executable, EXAMPLES / f"{name}.py", *map(str, arguments)]
    return subprocess.run(command, cwd=folder, check=True, capture_output=True, text=True).stdout


def test_scan_once(folder, tmp_path):
    assert "of 288000 beams hit" in example(tmp_path, "scan_once", folder / "town.glb")
    assert (tmp_path / "cloud.pcd").stat().st_size > 1e6
    assert (tmp_path / "cloud.png").exists()


def test_own_sensor(tmp_path):
    printed = example(tmp_path, "own_sensor")
    returns, error = re.fullmatch(r"(\d+) returns; .* is ([\d.]+) mm\n", printed).groups()
    assert int(returns) > 45000 and float(error) < 0.1
    assert (tmp_path / "own_sensor.png").exists()


def test_moving(folder, tmp_path):
    printed = example(tmp_path, "moving", folder / "town.glb")
    counts = [int(count) for count in re.findall(r": (\d+) points on the car", printed)]
    assert len(counts) == 20 and min(counts) > 1000
    assert counts[0::2] == counts[1::2]  # deskewing moves points, and adds none
    assert (tmp_path / "skewed.png").read_bytes() != (tmp_path / "deskewed.png").read_bytes()


def test_training_data(folder, tmp_path):
    example(tmp_path, "training_data", folder / "town.glb")
    clouds = [np.load(tmp_path / f"fog-{i}.npz") for i in range(4)]
    shares = [cloud["fog"].mean() for cloud in clouds]
    assert shares == sorted(shares) and shares[3] > 0.2
    assert all(len(cloud["points"]) == len(cloud["intensity"]) == len(cloud["class_id"]) for cloud in clouds)


def test_dataset(folder, tmp_path):
    drive = folder / "drive.json"
    printed = example(tmp_path, "dataset", drive, "out", 2)
    assert printed.endswith("2 of 2 frames\ntown: 0 of 2 frames were there, 10 files were made\n")
    assert "2 of 2 frames were there, 0 files" in example(tmp_path, "dataset", drive, "out", 2)
    # The same bytes as the command line's.
    program("drive", drive, "-o", tmp_path / "cli", "--frames", "0:2")
    made = {path.relative_to(tmp_path / "out"): path.read_bytes() for path in (tmp_path / "out").rglob("*.bin")}
    assert len(made) > 1
    assert made == {path.relative_to(tmp_path / "cli"): path.read_bytes() for path in (tmp_path / "cli").rglob("*.bin")}
    for options, sentence in (
        (drives.RunOptions(tmp_path / "out", shard_count=0), "no shard 0 of 0"),
        (drives.RunOptions(tmp_path / "out", shard=2, shard_count=2), "no shard 2 of 2"),
        (drives.RunOptions(tmp_path / "out", first_frame=3, end_frame=3), "the first frame is 3"),
    ):
        with pytest.raises(Error, match=sentence):
            drives.run(drives.read_drive(drive), options)
    (tmp_path / "bad.json").write_text('{"scnes": []}')
    with pytest.raises(Error, match="scenes"):
        drives.read_drive(tmp_path / "bad.json")


def test_types(tmp_path):
    pytest.importorskip("mypy")
    command = [sys.executable, "-m", "mypy", "--strict", "--cache-dir", tmp_path, *sorted(EXAMPLES.glob("*.py"))]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout
    (tmp_path / "wrong.py").write_text("import gnosphere\ngnosphere.load_scene(5)\n")
    done = subprocess.run([*command[:6], "wrong.py"], cwd=tmp_path, capture_output=True, text=True)
    assert 'Argument 1 to "load_scene" has incompatible type "int"' in done.stdout


def test_the_page(folder, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "town.glb").symlink_to(folder / "town.glb")
    page = (REPOSITORY / "docs" / "python.md").read_text()
    blocks = re.findall(r"^```python\n(.*?)^```$", page, re.M | re.S)
    assert len(blocks) > 3
    names: dict = {}
    for block in blocks:
        exec(compile(block, "docs/python.md", "exec"), names)


def test_batch(tmp_path):
    printed = example(tmp_path, "batch", 16, 2)
    assert "step 1: " in printed and "an observation of (16, 1440)" in printed


def test_localise(folder, tmp_path):
    printed = example(tmp_path, "localise", folder / "town.glb")
    errors = [float(error) for error in re.findall(r": ([\d.]+) m and", printed)]
    assert len(errors) == 8 and errors[-1] < 0.3
    assert (tmp_path / "localise.png").read_bytes().startswith(b"\x89PNG")

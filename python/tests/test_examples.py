# SPDX-License-Identifier: Apache-2.0
"""The examples, the blocks of pages and of the tutorials, and a notebook run; types are right."""

import base64
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from conftest import REPOSITORY, at, program

import gnosphere
from gnosphere import Error
from gnosphere import drive as drives

EXAMPLES = REPOSITORY / "python" / "examples"


def example(folder, name: str, *arguments: object) -> str:
    command = [sys.executable, EXAMPLES / f"{name}.py", *map(str, arguments)]
    return subprocess.run(command, cwd=folder, check=True, capture_output=True, text=True).stdout


@pytest.mark.parametrize(
    "words",
    [
        "batch 2 1 too_many",
        "dataset",
        "dataset drive.json",
        "localise",
        "moving",
        "scan_once",
        "scan_once one.glb two.glb",
        "training_data",
    ],
)
def test_wrong_number_of_arguments(tmp_path, words):
    name, *arguments = words.split()
    command = [sys.executable, EXAMPLES / f"{name}.py", *arguments]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 1 and done.stdout == ""
    assert re.fullmatch(rf"usage: {name}\.py .*\n", done.stderr)
    # The first sentence of the example has the same usage.
    assert done.stderr.removeprefix("usage: ").strip() + "." in (EXAMPLES / f"{name}.py").read_text()
    assert not list(tmp_path.iterdir())


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


def test_training_data(tmp_path):
    program("town", "--triangles", 30000, "-o", tmp_path / "town.glb")  # the smallest town with vehicles
    example(tmp_path, "training_data", tmp_path / "town.glb")
    clouds = [np.load(tmp_path / f"fog-{i}.npz") for i in range(4)]
    shares = [cloud["fog"].mean() for cloud in clouds]
    assert shares == sorted(shares) and shares[3] > 0.2
    assert all(len(cloud["points"]) == len(cloud["intensity"]) == len(cloud["class_id"]) for cloud in clouds)
    assert set(np.concatenate([cloud["class_id"] for cloud in clouds])) == {0, 1}


def test_dataset(folder, tmp_path, monkeypatch):
    drive = folder / "drive.json"
    printed = example(tmp_path, "dataset", drive, "out", 2)
    assert printed.endswith("2 of 2 frames\ntown: 0 of 2 frames were there, 10 files were made\n")
    assert "2 of 2 frames were there, 0 files" in example(tmp_path, "dataset", drive, "out", 2)
    # The same bytes as the command line's.
    program("drive", drive, "-o", tmp_path / "cli", "--frames", "0:2")
    made = {path.relative_to(tmp_path / "out"): path.read_bytes() for path in (tmp_path / "out").rglob("*.bin")}
    assert len(made) > 1
    assert made == {path.relative_to(tmp_path / "cli"): path.read_bytes() for path in (tmp_path / "cli").rglob("*.bin")}
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    assert drives.run(drives.read_drive(drive), drives.RunOptions("", end_frame=1)).files > 0
    assert list((tmp_path / "here").rglob("*.bin"))
    for options, sentence in (
        (drives.RunOptions(tmp_path / "out", shard_count=0), "no shard 0 of 0"),
        (drives.RunOptions(tmp_path / "out", shard=2, shard_count=2), "no shard 2 of 2"),
        (drives.RunOptions(tmp_path / "out", first_frame=3, end_frame=3), "the first frame is 3"),
    ):
        with pytest.raises(Error, match=sentence):
            drives.run(drives.read_drive(drive), options)
    assert drives.read_drive(drive).seed == 1
    seeded = drives.read_drive(drive, seed=7)
    assert seeded.seed == 7 and seeded.fingerprint != drives.read_drive(drive).fingerprint
    assert drives.read_drive(drive, name="scene-0061").name == "scene-0061"
    with pytest.raises(Error, match="name: must have letters, digits, _ and - only"):
        drives.read_drive(drive, name="../other")
    (tmp_path / "bad.json").write_text('{"scnes": []}')
    with pytest.raises(Error, match="scenes"):
        drives.read_drive(tmp_path / "bad.json")


def checked(folder, *command: object) -> str:
    """What a type checker, run by this Python, finds."""
    done = subprocess.run([sys.executable, "-m", *map(str, command)], cwd=folder, capture_output=True, text=True)
    return done.stdout if done.returncode else ""


def test_types_by_mypy(tmp_path):
    pytest.importorskip("mypy")
    strict = ["mypy", "--strict", "--cache-dir", tmp_path]
    assert not checked(tmp_path, *strict, *sorted(EXAMPLES.glob("*.py")))
    # The stubs and the package's own code; the packages of engines need not be there.
    assert not checked(tmp_path, *strict, "--ignore-missing-imports", "--allow-subclassing-any", "-p", "gnosphere")
    (tmp_path / "wrong.py").write_text("import gnosphere\ngnosphere.load_scene(5)\ngnosphere.nonsense\n")
    (tmp_path / "unions.py").write_text(
        "from gnosphere import Batch, Field, Instance, Scan\nfrom gnosphere.drive import RunOptions\nimport numpy as np\n"
        'progress = RunOptions("out", progress=lambda done, total: done < total).progress\n'
        "if progress is not None:\n    progress(1, 2)\n"
        'Scan()[Field.x], Scan()["x"], Batch().column("range"), Field.x in Scan(), Instance(0, np.eye(4))\n'
        "Instance(0).transform = np.eye(4)\nprogress(1, 2)\n"
    )
    (tmp_path / "keywords.py").write_text(
        "from gnosphere import Effects, EffectUse, Tuning\n"
        'Effects(fog=Effects.Fog(use="on", visibility=80), seed=7)\n'
        'Effects.Returns(use=EffectUse.on, mode="dual")\nTuning(binning="lists", keep_still=False)\n'
        "Effects(range_nois=3)\nEffects.RangeNoise(sigm=3)\nTuning(bining=3)\nEffects.Fog(visibility='far')\n"
        "from gnosphere import Scene, Sensor, Simulator, SimulatorOptions\n"
        'Effects().fog.use = "on"\noptions = SimulatorOptions(accuracy="exact", warn=None)\n'
        "Simulator(Scene(), Sensor(), options)\nSimulator(Scene(), [Sensor()])\nSensor(range_mx=3)\n"
    )
    found = checked(tmp_path, *strict, "wrong.py", "unions.py", "keywords.py")
    assert 'Argument 1 to "load_scene" has incompatible type "int"' in found
    assert 'Module has no attribute "nonsense"' in found
    places = {re.sub(": error: .*", "", line) for line in found.splitlines() if ": error: " in line}
    assert places == {
        "wrong.py:2", "wrong.py:3", "unions.py:9", *(f"keywords.py:{line}" for line in (5, 6, 7, 8, 14)),
    }  # fmt: skip


def test_types_by_pyright(tmp_path):
    pytest.importorskip("pyright")
    stubs = (Path(gnosphere.__file__).parent / "_gnosphere").glob("*.pyi")
    command = ["pyright", "--pythonpath", sys.executable]
    assert not checked(tmp_path, *command, *sorted(EXAMPLES.glob("*.py")), *stubs)
    (tmp_path / "wrong.py").write_text("import gnosphere\nprint(gnosphere.Scan().rangs)\n")
    assert 'Cannot access attribute "rangs"' in checked(tmp_path, *command, "wrong.py")


PAGES = [
    "../README.md",
    "python.md",
    "batches.md",
    "instead-of.md",
    *(f"tutorials/{page.name}" for page in sorted((REPOSITORY / "docs" / "tutorials").glob("*.md"))),
]


def blocks_of(page: str) -> list[tuple[str, str, str]]:
    """The blocks of Python and of the shell of a page: why it is not run, its language, its text."""
    text = (REPOSITORY / "docs" / page).read_text()
    return re.findall(r"(<!-- not run: .*? -->\s*)?^```(python|sh)\n(.*?)^```$", text, re.M | re.S)


@pytest.fixture
def run_page(folder, tmp_path, monkeypatch):
    """Runs the blocks of a page, or of these the ones that have a word, one after the other, in one folder with a town.
    Answers the names that they leave."""
    monkeypatch.chdir(tmp_path)
    for name in ("town.glb", "scene.glb"):
        shutil.copyfile(folder / "town.glb", tmp_path / name)  # pages write towns of these names
    programs = Path(os.environ.get("GNOSPHERE_PROGRAM", sys.executable)).parent
    monkeypatch.setenv("PATH", str(programs), prepend=os.pathsep)

    def run(page: str, word: str = "") -> dict:
        blocks = [block for block in blocks_of(page) if word in block[2]]
        assert len(blocks) == 1 if word else len(blocks) > 1
        names: dict = {}
        for unrun, language, block in blocks:
            if language == "python":
                exec(compile(block, f"docs/{page}", "exec"), names)
            elif not unrun and page.startswith("tutorials"):  # tests/docs/check_page runs those of the other pages
                subprocess.run(["bash", "-euo", "pipefail", "-c", block], check=True)
        return names

    return run


@pytest.mark.parametrize("page", PAGES)
def test_the_page(page, run_page):
    """The blocks of Python and of the shell run, one after the other, in one folder."""
    if any("import mujoco" in block for _, _, block in blocks_of(page)):
        pytest.importorskip("mujoco")
    run_page(page)


def test_the_page_of_scenes(run_page, square, device):
    """A file in centimetres, two scenes in one, and a scene whose instances are merged, which has the same scans."""
    Path("scene.obj").write_text("v -900 -200 -900\nv 900 -200 -900\nv 900 -200 900\nf 1 3 2\n")
    names = run_page("scenes.md")
    corners = {}
    for scene in ("scene", "both"):
        placed = names[scene].instances[-1]
        mesh, rows = names[scene].meshes[placed.mesh], np.array(placed.transform.rows)
        corners[scene] = (np.array(mesh.positions, float) + mesh.origin) @ rows[:, :3].T + rows[:, 3]
    assert np.allclose(corners["scene"], [[-9, 9, -2], [9, 9, -2], [9, -9, -2]], atol=1e-5)  # x, -z, y in metres
    assert np.allclose(corners["both"], corners["scene"] + [8, 2, 0], atol=1e-5)

    # One side of a square is seen, whether a map mirrors or turns it; instances of a kind become one.
    mirrored = gnosphere.Transform([[-1, 0, 0, 9], [0, 1, 0, 3], [0, 0, 1, 0]])
    turned = gnosphere.Transform([[-1, 0, 0, 9], [0, -1, 0, 0], [0, 0, 1, 0]])
    maps = [mirrored, at(9), turned]
    squares = gnosphere.Scene(
        [gnosphere.Material("grey", double_sided=False)], [square], [gnosphere.Instance(0, one, 7) for one in maps]
    )
    merged = names["merged"](squares)
    assert len(merged.instances) == 1 and merged.unique_triangle_count() == 6
    request = gnosphere.SensorRequest(gnosphere.builtin_sensor("VLP-16"), gnosphere.Effects.none(), ["class"])
    for scene, other in ((gnosphere.load_scene("town.glb"), names["town"]), (squares, merged)):
        scans = [
            gnosphere.Simulator(each, request, gnosphere.SimulatorOptions(device)).scan(gnosphere.Pose((0, 0, 0.1)))
            for each in (scene, other)
        ]
        assert np.isfinite(scans[0].ranges).any() and (scans[0]["class"] == scans[1]["class"]).all()
        assert np.allclose(scans[0].ranges, scans[1].ranges, rtol=0, atol=1e-4, equal_nan=True)
    assert len(names["town"].instances) <= len(gnosphere.load_scene("town.glb").instances)


@pytest.fixture
def two_frames(folder, tmp_path):
    """Makes a data set of two frames of one sensor in a folder."""

    def make(name: str, *outputs: dict) -> Path:
        drive = json.loads((folder / "drive.json").read_text())
        drive |= {"duration": 0.2, "epoch": 1700000000, "outputs": outputs}
        drive["sensors"] = [{"name": "top", "sensor": "VLP-16", "mount": {"position": [0, 0, 1.8]}}]
        for file in folder.iterdir():
            if file.is_file() and not (tmp_path / file.name).exists():
                shutil.copyfile(file, tmp_path / file.name)
        (tmp_path / "two.json").write_text(json.dumps(drive))
        program("drive", tmp_path / "two.json", "-o", tmp_path / name, "--name", name)
        return tmp_path / name

    return make


def test_drives_are_joined_as_their_page_says(run_page, two_frames):
    parts = [two_frames(name, {"format": "nuscenes", "version": "v1.0-mini"}) for name in ("first", "second")]
    run_page("drives.md", "first/nuscenes")
    tables = {file.stem: json.loads(file.read_text()) for file in Path("joined", "v1.0-mini").glob("*.json")}
    assert [scene["name"] for scene in tables["scene"]] == ["first", "second"]
    known = [row["token"] for rows in tables.values() for row in rows]
    for rows in tables.values():
        for row in rows:
            wanted = [row[key] for key in row if key.endswith("_token") and key not in ("prev", "next")]
            wanted += [token for key in row if key.endswith("_tokens") for token in row[key]]
            assert set(wanted) <= {*known, ""}
    for name, rows in tables.items():  # but for the levels of visibility, both drives' rows are there
        one = [json.loads((part / "nuscenes" / "v1.0-mini" / f"{name}.json").read_text()) for part in parts]
        assert len(rows) == (4 if name == "visibility" else len(one[0]) + len(one[1]))
    files = [Path("joined", row["filename"]) for row in tables["sample_data"]]
    assert len(files) == 4 and all(file.stat().st_size > 1e5 for file in files)


def test_las_becomes_laz_as_the_page_of_drives_says(run_page, two_frames):
    laspy = pytest.importorskip("laspy")
    pytest.importorskip("lazrs")
    two_frames("dataset", {"format": "las"})
    run_page("drives.md", "laspy")
    files = sorted(Path("dataset", "las").rglob("*.las"))
    assert len(files) == 2
    for file in files:
        assert (laspy.read(file).points.array == laspy.read(file.with_suffix(".laz")).points.array).all()
        assert file.with_suffix(".laz").stat().st_size < 0.5 * file.stat().st_size


def test_poses_of_argoverse_become_a_trajectory_as_the_page_of_drives_says(run_page):
    pandas = pytest.importorskip("pandas")
    pytest.importorskip("pyarrow")
    poses = {"timestamp_ns": [315966070559696000, 315966070569696000], "qw": [1.0, 0.5], "qx": [0.0, 0.5]}
    poses |= {"qy": [0.0, 0.5], "qz": [0.0, 0.5], "tx_m": [1.25, 1.5], "ty_m": [2.0, 2.0], "tz_m": [3.0, 3.0]}
    pandas.DataFrame(poses).to_feather("city_SE3_egovehicle.feather")
    run_page("drives.md", "read_feather")
    rows = np.loadtxt("ego.tum")
    assert np.allclose(rows[:, 1:], [[1.25, 2, 3, 0, 0, 0, 1], [1.5, 2, 3, 0.5, 0.5, 0.5, 0.5]], rtol=0, atol=0)
    assert np.allclose(rows[:, 0], [315966070.559696, 315966070.569696], rtol=0, atol=1e-6)


def test_a_notebook(folder, tmp_path):
    """A notebook shows a scan as a picture, and draws it by show(). GNOSPHERE_PICTURES names a folder for the pictures."""
    nbformat, nbclient = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")
    pytest.importorskip("ipykernel")
    pytest.importorskip("matplotlib")
    cells = [
        "%matplotlib inline\nimport gnosphere",
        f"scene = gnosphere.load_scene({str(folder / 'town.glb')!r})\n"
        "request = gnosphere.SensorRequest(gnosphere.builtin_sensor('OS1-64'), fields=[gnosphere.Field.intensity])\n"
        "scan = gnosphere.Simulator(scene, request).scan(gnosphere.Pose((0, 0, 1.8)))\nscan",
        "figure = scan.show('intensity')\nfigure",
        "figure",
    ]
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(cell) for cell in cells])
    nbclient.NotebookClient(notebook, timeout=120, resources={"metadata": {"path": str(tmp_path)}}).execute()
    shown, drawn = (cell.outputs[-1].data for cell in notebook.cells[1:3])
    # The figure is drawn once, though the cell ends with it; a later cell that ends with it shows it again.
    assert [len([one for one in cell.outputs if "image/png" in one.data]) for cell in notebook.cells[2:]] == [1, 1]
    pictures = [shown["text/html"].split("base64,")[1].split('"')[0], drawn["image/png"]]
    kept = Path(os.environ.get("GNOSPHERE_PICTURES", tmp_path))
    for number, picture in enumerate(map(base64.b64decode, pictures)):
        assert picture.startswith(b"\x89PNG") and len(picture) > 4_000
        (kept / f"notebook-{number}.png").write_bytes(picture)
    assert "OS1-64" in shown["text/html"] and shown["text/plain"].startswith("<")


def test_the_site():
    """tests/docs/check_site with the names of the installed package."""
    pytest.importorskip("mkdocs")
    check, package = REPOSITORY / "tests" / "docs" / "check_site", Path(gnosphere.__file__).parent
    here = {**os.environ, "GNOSPHERE_PYTHON": sys.executable}
    done = subprocess.run([sys.executable, check, REPOSITORY, package], env=here, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


def test_batch(tmp_path):
    printed = example(tmp_path, "batch", 16, 2)
    assert "step 1: " in printed and "an observation of (16, 1440)" in printed


def test_localise(folder, tmp_path):
    printed = example(tmp_path, "localise", folder / "town.glb")
    errors = [float(error) for error in re.findall(r": ([\d.]+) m and", printed)]
    assert len(errors) == 8 and errors[-1] < 0.3
    assert (tmp_path / "localise.png").read_bytes().startswith(b"\x89PNG")

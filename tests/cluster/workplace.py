# SPDX-License-Identifier: Apache-2.0
"""A drive through a small town for tests with schedulers: what one process makes of it, and whether others make the
same."""
import filecmp
import glob
import json
import os
import signal
import subprocess
import tempfile
import time

FRAMES, SHARDS = 200, 4
HEAD = {"name": "small", "columns": 360, "rotation_period": 0.1, "range": {"min": 0.1, "max": 100},
        "elevation_deg": [-24, -18, -12, -9, -6, -4, -2, 0]}


class Workplace:
    """A folder with drive.json and the data set `whole`, made by one process. At its end the daemons are ended."""

    def __init__(self, program):
        self.temporary = tempfile.TemporaryDirectory(prefix="gnosphere-cluster-")
        self.folder = self.temporary.name
        self.environment = dict(os.environ, PATH=os.path.dirname(program) + os.pathsep + os.environ["PATH"])
        self.daemons = []

    def __enter__(self):
        self.run(["gnosphere", "town", "--triangles", "10000", "-o", "town.glb", "--drive", "drive.json"])
        with open(self.path("drive.json"), encoding="utf-8") as file:
            drive = json.load(file)
        drive["duration"] = FRAMES / 10
        drive["weather"] = [{"time": FRAMES / 20}, {"time": FRAMES / 20, "rain": 20}]
        drive["sensors"] = [{"name": name, "sensor": HEAD, "mount": {"position": [x, 0, z]}}
                            for name, x, z in (("top", 0, 1.8), ("front", 2.2, 0.6), ("rear", -2.2, 0.6))]
        drive["outputs"] = [{"format": "semantickitti", "sensors": ["top"]}, {"format": "boxes"}, {"format": "mcap"},
                            {"format": "osi"}]
        with open(self.path("drive.json"), "w", encoding="utf-8") as file:
            json.dump(drive, file)
        self.run(["gnosphere", "drive", "drive.json", "-o", "whole"])
        return self

    def __exit__(self, *_):
        for daemon in reversed(self.daemons):
            daemon.terminate()
        for daemon in self.daemons:
            try:
                daemon.wait(10)
            except subprocess.TimeoutExpired:
                os.killpg(daemon.pid, signal.SIGKILL)
        self.temporary.cleanup()

    def path(self, *names):
        return os.path.join(self.folder, *names)

    def start(self, command):
        """Starts a process that leads a group of its own; its output is in a log that is named for it."""
        with open(self.path(f"{os.path.basename(command[0])}-{len(self.daemons)}.log"), "w", encoding="utf-8") as log:
            self.daemons.append(subprocess.Popen(command, cwd=self.folder, env=self.environment, stdout=log,
                                                 stderr=subprocess.STDOUT, start_new_session=True))
        return self.daemons[-1]

    def run(self, command):
        """Returns what a command prints; ends the test with the logs if it fails."""
        done = subprocess.run(command, cwd=self.folder, env=self.environment, capture_output=True, text=True,
                              check=False)
        if done.returncode:
            self.fail(f"status {done.returncode} from {command}\n{done.stdout}{done.stderr}")
        return done.stdout

    def wait_for(self, what, condition, seconds=200):
        end = time.monotonic() + seconds
        while not condition():
            if time.monotonic() > end:
                self.fail(f"after {seconds} s there is still no sign of: {what}")
            time.sleep(0.01)

    def fail(self, text):
        """Ends the test with the logs."""
        for name in glob.glob(self.path("*.log")) + glob.glob(self.path("*.out")):
            with open(name, encoding="utf-8", errors="replace") as file:
                text += f"\n{os.path.basename(name)}:\n{file.read()}"
        raise SystemExit(text)

    def complete(self, dataset, shard):
        """Which frames of a shard are complete."""
        files = [self.path(dataset, "manifest", "frames", f"{frame:06}.json") for frame in range(shard, FRAMES, SHARDS)]
        return [file for file in files if os.path.exists(file)]

    def check_same(self, dataset):
        """Ends the test unless a data set has the files of `whole`, with the same bytes."""
        def files_of(folder):
            return sorted(os.path.relpath(os.path.join(place, name), folder)
                          for place, _, names in os.walk(folder) for name in names if name != "lock")

        wanted, made = files_of(self.path("whole")), files_of(self.path(dataset))
        if wanted != made:
            self.fail(f"{dataset}: missing {set(wanted) - set(made)}, too many {set(made) - set(wanted)}")
        _, wrong, lost = filecmp.cmpfiles(self.path("whole"), self.path(dataset), wanted, shallow=False)
        if wrong or lost:
            self.fail(f"{dataset}: other bytes in {wrong + lost}")
        print(f"{dataset}: {len(made)} files with the bytes of one process")

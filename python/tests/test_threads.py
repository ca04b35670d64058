# SPDX-License-Identifier: Apache-2.0
"""Threads: no call holds the GIL while it works, and a simulator belongs to one thread at a time."""

import os
import signal
import subprocess
import sys
import threading
import time

import pytest

import gnosphere
import gnosphere.drive


@pytest.fixture(scope="module")
def slow(town):
    """A simulator on the reference whose scan takes a while, and that scan's bytes."""
    request = gnosphere.SensorRequest(gnosphere.builtin_sensor("HDL-64E"), gnosphere.Effects.none())
    simulator = gnosphere.Simulator(town, request, gnosphere.SimulatorOptions(gnosphere.device_by_name("reference")))
    return simulator, simulator.scan(gnosphere.Pose((0, 0, 1.8))).points.tobytes()


def in_thread(work):
    thread = threading.Thread(target=work)
    thread.start()
    return thread


def test_other_threads_run_while_a_scan_is_made(slow, pose):
    counted, stop = [0], threading.Event()

    def count():
        while not stop.is_set():
            counted[0] += 1
            time.sleep(0.001)

    counter = in_thread(count)
    before = counted[0]
    start = time.monotonic()
    slow[0].scan(pose)
    during, seconds = counted[0] - before, time.monotonic() - start
    stop.set()
    counter.join()
    print(f"{during} turns of another thread during a scan of {seconds:.2f} s")
    assert during > 3  # at most 1 if the GIL were held


def test_two_simulators_scan_at_once(slow, simulator, pose):
    events, started = [], threading.Event()
    bytes_of = {}

    def long():
        started.set()
        bytes_of["slow"] = slow[0].scan(pose).points.tobytes()
        events.append("slow")

    expected = simulator.scan(pose).points.tobytes()
    thread = in_thread(long)
    started.wait()
    bytes_of["fast"] = simulator.scan(pose).points.tobytes()
    events.append("fast")
    thread.join()
    assert events == ["fast", "slow"]  # the short scan began after the long one and ended before it
    assert bytes_of == {"slow": slow[1], "fast": expected}


def test_a_second_thread_is_refused(slow, pose):
    started = threading.Event()

    def long():
        started.set()
        slow[0].scan(pose)

    thread = in_thread(long)
    started.wait()
    with pytest.raises(gnosphere.Error, match="one thread at a time"):
        for _ in range(1000):  # the other thread may need a moment to begin
            slow[0].memory()
            time.sleep(0.0001)
    thread.join()
    assert slow[0].scan(pose).points.tobytes() == slow[1]


def test_receive_may_not_call_its_simulator(simulator, pose):
    with pytest.raises(gnosphere.Error, match="a function that it calls may only read it"):
        simulator.scan_all([gnosphere.Shot(pose)], lambda shot, scan: simulator.scan(pose))
    plans = []
    simulator.scan_all([gnosphere.Shot(pose)], lambda shot, scan: plans.append(simulator.plan()))
    assert len(plans) == 1
    assert simulator.scan(pose).beam_count() == 28800


def test_warn_gets_what_is_no_error(town, device, tmp_path, monkeypatch):
    (tmp_path / "file").touch()
    said = []
    request = gnosphere.SensorRequest(gnosphere.builtin_sensor("VLP-16"))
    options = gnosphere.SimulatorOptions(device, cache=str(tmp_path / "file"), warn=said.append)
    assert options.warn == said.append
    gnosphere.Simulator(town, request, options)
    options.warn = None
    assert options.warn is None

    def angry(sentence):
        raise ValueError("mine")

    options.warn = angry
    assert bool(said) == (device != gnosphere.device_by_name("reference"))  # which keeps no kernels
    if said:
        assert str(tmp_path / "file") in said[0]
        # A simulator with the same cache folder would take over the first one's device, which has given its warning.
        (tmp_path / "other").touch()
        options.cache = str(tmp_path / "other")
        printed = []
        monkeypatch.setattr(sys, "unraisablehook", printed.append)
        gnosphere.Simulator(town, request, options)
        assert [type(of.exc_value) for of in printed] == [ValueError]


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system has no fork()")
def test_a_forked_process_cannot_use_the_simulators_of_its_parent(slow, pose):
    child = os.fork()
    if child == 0:
        try:
            slow[0].scan(pose)
        except gnosphere.Error as error:
            os._exit(7 if "make a simulator after the fork" in str(error) else 8)
        os._exit(9)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7


@pytest.mark.parametrize(
    "call", ["scan(gnosphere.Pose())", "scan_all([gnosphere.Shot()] * 2000, lambda shot, scan: None)"]
)
def test_a_process_may_end_while_a_daemon_thread_scans(call):
    program = """
import threading, time, gnosphere
scene = gnosphere.Scene([gnosphere.Material()], [], [])
request = gnosphere.SensorRequest(gnosphere.builtin_sensor("VLP-16"), gnosphere.Effects.none())
simulator = gnosphere.Simulator(scene, request, gnosphere.SimulatorOptions(gnosphere.device_by_name("reference")))
def scan():
    while True:
        simulator.CALL
threading.Thread(target=scan, daemon=True).start()
time.sleep(0.2)
""".replace("CALL", call)
    for _ in range(4):
        done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=False)
        assert (done.returncode, done.stderr) == (0, "")


def test_ctrl_c_ends_a_drive(folder, device, tmp_path):
    made = []

    def progress(done, total):
        made.append((done, total))
        if done == 2:
            signal.raise_signal(signal.SIGINT)

    options = gnosphere.drive.RunOptions(
        tmp_path / "out", end_frame=30, simulator=gnosphere.SimulatorOptions(device), progress=progress
    )
    with pytest.raises(KeyboardInterrupt):
        gnosphere.drive.run(gnosphere.drive.read_drive(folder / "drive.json"), options)
    assert 2 <= len(made) < 15 and made[0][1] == 30
    assert not any((tmp_path / "out").glob("**/*.part"))

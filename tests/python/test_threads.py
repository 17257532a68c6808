"""Python's other threads run while the module works."""

import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import tactile


@pytest.fixture
def turns():
    """How often another thread had its turn; it gets one only while this thread gives up the GIL."""
    count, ends = [0], threading.Event()

    def work():
        while not ends.is_set():
            count[0] += 1
            time.sleep(0)

    interval = sys.getswitchinterval()
    worker = threading.Thread(target=work)
    worker.start()
    sys.setswitchinterval(1000)
    yield lambda: count[0]
    sys.setswitchinterval(interval)
    ends.set()
    worker.join()


def has_turns_during(turns, work, seconds):
    """Repeats the work, since another thread may wake too late, up to this time."""
    before, begun = turns(), time.monotonic()
    while time.monotonic() < begun + seconds:
        work()
        if turns() > before:
            return True
    return False


def test_have_no_turn_during_a_loop_of_python(turns):
    assert not has_turns_during(turns, lambda: sum(range(10_000)), 0.5)


def test_have_turns_while_events_are_added_and_rendered(lab, turns):
    recording = tactile.Recording(lab.recording)
    events = recording.events()
    engine, rendered = tactile.Engine(lab.bundle), tactile.HeatmapRenderer((640, 480), 40)
    for work in (
        lambda: tactile.HeatmapRenderer((640, 480), 40).add(events),
        lambda: engine.stream((640, 480)).add(events),
        rendered.render,
        lambda: engine.probabilities(np.zeros((100_000, 3), np.float32)),
        recording.events,
        lambda: recording.problems,
        lambda: tactile.heatmaps(recording, th_ms=40),
        lambda: engine.predict(recording),
        lambda: tactile.Dataset(lab.folder / "data/dataset.h5", 40),
    ):
        assert has_turns_during(turns, work, 60)


def test_may_share_a_renderer(lab):
    events = tactile.Recording(lab.recording).events()
    renderer = tactile.HeatmapRenderer((640, 480), 40)
    renderer.add(events)
    renderer.move_to(int(events["t"][-1]))
    expected, found = renderer.render(), []
    workers = [threading.Thread(target=lambda: found.extend(renderer.render() for _ in range(100))) for _ in range(4)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    assert len(found) == 400 and all(np.array_equal(one, expected) for one in found)


def run_python(code, *arguments):
    return subprocess.run([sys.executable, "-c", code, *map(str, arguments)], capture_output=True, text=True, timeout=120)


def test_end_quietly_with_python(lab):
    code = """
import sys, threading, time, tactile
recording, engine = tactile.Recording(sys.argv[1]), tactile.Engine(sys.argv[2])
def loop():
    while True:
        engine.predict(recording)
for _ in range(2):
    threading.Thread(target=loop, daemon=True).start()
time.sleep(float(sys.argv[3]))
"""
    for seconds in (0.05, 0.3, 0.5):
        done = run_python(code, lab.recording, lab.bundle, seconds)
        assert done.returncode == 0 and "Fatal" not in done.stderr, done.stderr

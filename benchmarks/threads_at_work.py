"""How many threads of a command run, or wait only for a core, at each moment: what more cores would bring, measured on few."""

import glob
import os
import subprocess
import time
from pathlib import Path

CORES = len(os.sched_getaffinity(0))
EVERY_S = 0.02
Path("/proc/thread-self/children").read_text(encoding="utf-8")  # not every kernel has it


def states_below(process):
    """The states of all threads of a process and of the processes that it started: R if one runs or waits only for a core."""
    waiting, states = [process], []
    while waiting:
        for thread in glob.glob(f"/proc/{waiting.pop()}/task/*"):
            try:
                states.append(Path(thread, "stat").read_text(encoding="utf-8").rsplit(")", 1)[1].split()[0])
                waiting += Path(thread, "children").read_text(encoding="utf-8").split()
            except (FileNotFoundError, ProcessLookupError):  # it has ended
                continue
    return states


def at_work(command, **options):
    """Runs a command on an idle machine. Returns its status, its wall-clock time [s], the mean number of threads at work, the time [s]
    with at most one of them at work, and an estimate of the time [s] with a core for each.

    While k threads share c cores, each does c / k of what it would do alone; so an interval would take c / k of its time. Where threads
    wait for each other every few milliseconds, fewer are seen at work than there is work for, and the estimate is too long. It is too
    short where memory, caches or a disk are the limit, and where threads wait in a loop."""
    last = time.monotonic()
    wall_s = sum_s = alone_s = with_all_s = 0.0
    with subprocess.Popen([str(word) for word in command], **options) as running:
        while True:
            try:
                running.wait(EVERY_S)
                return running.returncode, wall_s, sum_s / max(wall_s, EVERY_S), alone_s, with_all_s
            except subprocess.TimeoutExpired:
                count = states_below(running.pid).count("R")
            now = time.monotonic()
            passed_s, last = now - last, now
            wall_s += passed_s
            sum_s += count * passed_s
            alone_s += passed_s if count <= 1 else 0
            with_all_s += passed_s * min(count, CORES) / count if count > 0 else passed_s

"""How many threads of a command run, or wait for a core only, at each moment: what more cores would bring, measured on few."""

import os
import subprocess
import time
from pathlib import Path

EVERY_S = 0.02


def threads_of(process):
    """The states of all threads of a process and of the processes that it started: R if one runs or waits for a core."""
    waiting, states = [process], []
    while waiting:
        for thread in Path(f"/proc/{waiting.pop()}/task").glob("*"):
            try:
                states.append((thread / "stat").read_text(encoding="utf-8").rsplit(")", 1)[1].split()[0])
                waiting += (thread / "children").read_text(encoding="utf-8").split()
            except OSError:  # it has ended
                continue
    return states


def at_work(command, **options):
    """Runs a command. Returns its status, its wall-clock time [s], the mean number of threads at work, the time [s] with at most one of
    them at work, and the time [s] that it would take with a core for each: while k threads share c cores, they do c / k of what they
    would do then. That neglects caches, memory and locks."""
    cores = len(os.sched_getaffinity(0))
    begin = last = time.monotonic()
    sum_s = alone_s = with_all_s = 0.0
    with subprocess.Popen([str(word) for word in command], **options) as running:
        while running.poll() is None:
            time.sleep(EVERY_S)
            count = threads_of(running.pid).count("R")
            now = time.monotonic()
            passed_s, last = now - last, now
            sum_s += count * passed_s
            alone_s += passed_s if count <= 1 else 0
            with_all_s += passed_s * min(count, cores) / count if count > 0 else passed_s
        wall_s = time.monotonic() - begin
        return running.returncode, wall_s, sum_s / wall_s, alone_s, with_all_s

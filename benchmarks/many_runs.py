#!/usr/bin/env python3
"""Measures how the memory of `windows`, `heatmaps`, `train` and `eval` grows with the number of runs. Prints a table.

    many_runs.py TACTILE FOLDER RUNS...

For each number it makes this many labelled runs in FOLDER, measures the commands on them, and removes them. A run is as small as the
commands accept: 0.3 s of a sensor of 80 x 80 pixels, with a press and a slip of 12 ms each. It has 18 samples, so what is measured
is the cost of a run, not that of its events or samples. TOUCH_MS in the environment makes the touches longer, up to 40 ms.
"""

import json
import os
import random
import shutil
import subprocess
import sys
from pathlib import Path

from loads import cost_of

RUN_US = 300_000
TOUCH_US = 1000 * int(os.environ.get("TOUCH_MS", "12"))
FIRST_US = 1_000_000
RUNS_OF_OBJECT = 99
RUNS_OF_RECORDING = 20 * RUNS_OF_OBJECT
COMMANDS = {
    "windows": ["windows", "--guard-ms", "10"],
    "heatmaps": ["heatmaps", "--th", "10"],
    "train": ["train", "--th", "10", "--epochs", "1"],
    "eval": ["eval"],
}


def write_recording(file, runs):
    """One recording of these runs: noise everywhere, more of it during a press, and in another place during a slip."""
    draw = random.Random(runs.start)
    with open(file, "w", encoding="utf-8") as out:
        out.write("t,x,y,p\n")
        for run in runs:
            begin = FIRST_US + run * RUN_US
            for ms in range(1, RUN_US // 1000):
                at = begin + 1000 * ms
                lines = [(draw.randrange(80), draw.randrange(80))]
                if 120_000 < 1000 * ms <= 120_000 + TOUCH_US:
                    lines += [(draw.randrange(40), draw.randrange(80)) for _ in range(4)]
                if 200_000 < 1000 * ms <= 200_000 + TOUCH_US:
                    lines += [(40 + draw.randrange(40), draw.randrange(80)) for _ in range(4)]
                out.writelines(f"{at},{x},{y},{draw.randrange(2)}\n" for x, y in lines)


def interval(name, touch, start):
    end = start + TOUCH_US
    return {
        "id": name, "class": touch, "confirmed": False, "source": "events",
        "start_us": start, "start_low_us": start - 2000, "start_high_us": start + 2000,
        "end_us": end, "end_low_us": end - 1000, "end_high_us": end + 1000,
        "evidence": {"events_us": start, "robot_us": None, "video_us": None, "imu_us": None},
    }


def make_runs(tactile, folder, count):
    folder.mkdir(parents=True)
    for first in range(0, count, RUNS_OF_RECORDING):
        make_runs_of_recording(tactile, folder, range(first, min(count, first + RUNS_OF_RECORDING)))


def make_runs_of_recording(tactile, folder, runs):
    write_recording(folder / "all.csv", runs)
    objects = [f"object-{run // RUNS_OF_OBJECT + 1}" for run in range(runs.stop)]
    settings = {"object": objects[runs.start:], "at": [1e-6 * RUN_US * run - 0.0005 for run in range(1, len(runs))]}
    (folder / "split.json").write_text(json.dumps(settings))
    here = {"cwd": folder, "check": True, "stdout": subprocess.DEVNULL}
    subprocess.run([tactile, "convert", "all.csv", "all.aedat4", "--size", "80x80", "--quiet", "--force"], **here)
    subprocess.run([tactile, "split", "all.aedat4", "--config", "split.json", "--quiet"], **here)
    for run in runs:
        begin = FIRST_US + run * RUN_US
        intervals = [interval("press-1", "press", begin + 120_000), interval("slip-1", "slip", begin + 200_000)]
        labels = {"intervals": intervals, "releases": [], "rejected": [], "flags": [], "remarks": [], "clocks": {}, "provenance": {}}
        place = folder / "data" / objects[run] / f"{run % RUNS_OF_OBJECT + 1:02}"
        (place / "labels.json").write_text(json.dumps(labels))


def main():
    tactile, folder = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()
    print("| runs |" + "".join(f" {name} [MiB] | [s] |" for name in COMMANDS))
    print("| ---: |" + " ---: | ---: |" * len(COMMANDS), flush=True)
    for runs in map(int, sys.argv[3:]):
        place = folder / str(runs)
        make_runs(tactile, place, runs)
        row = f"| {runs} |"
        for options in COMMANDS.values():
            status, wall_s, _, memory_mib = cost_of([tactile, *options, "--quiet"], cwd=place, stdout=subprocess.DEVNULL)
            if status != 0:
                return status
            row += f" {memory_mib:.0f} | {wall_s:.1f} |"
        print(row, flush=True)
        shutil.rmtree(place)
    return 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""Measures how much faster commands are with more threads, and whether their results stay the same. Prints two tables.

    threads.py TACTILE FOLDER [THREADS…]

THREADS are 1, 2, 4, … up to the number of cores by default; the first is what the others are compared with. FOLDER is emptied, and
gets simulated runs and all that is made of them. Each command runs once for each number. Then one process of one thread per core runs at
the same time, each on a copy of FOLDER beside it: the column of processes is their work in the time of one alone, which is what the
machine allows. A copy has links to the inputs, and results of its own. In the environment: TACTILE_BENCH_RUNS of each
object (5); TACTILE_BENCH_TURNS repeats each command, and the shortest time counts; TACTILE_BENCH_STUDY has options of `reproduce`, which
is then measured with the most threads. With more threads than cores, a third table has the threads at work, in one more run of each.
"""

import csv
import hashlib
import json
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

from loads import cost_of
from threads_at_work import CORES, at_work

RUNS = os.environ.get("TACTILE_BENCH_RUNS", "5")  # of each object
TURNS = int(os.environ.get("TACTILE_BENCH_TURNS", "1"))
NOT_RESULTS = {"seconds", "elapsed_s", "images_per_s", "cpu_s", "revision", "utc"}


class Work:
    """One command: what it writes, which must not be there before it runs, and which of its files must stay the same."""

    def __init__(self, words, writes, results):
        self.words, self.writes, self.results = words, writes, results

    def clear(self):
        for path in self.writes():
            shutil.rmtree(path) if path.is_dir() else path.unlink(missing_ok=True)

    def digest(self):
        total = hashlib.sha256()
        for file in sorted(self.results()):
            total.update(file.name.encode())
            total.update(content_of(file))
        return total.hexdigest()


def without_times(value):
    if isinstance(value, dict):
        return {key: without_times(part) for key, part in value.items() if key not in NOT_RESULTS and not key.endswith("_us_per_tick")}
    return [without_times(part) for part in value] if isinstance(value, list) else value


def content_of(file):
    content = file.read_bytes()
    return json.dumps(without_times(json.loads(content))).encode() if file.suffix == ".json" else content


def works(folder):
    data, models = folder / "data", folder / "models"
    bundle, long_run, converted = models / "threads", folder / "long/textured-box/01/events.aedat4", folder / "converted.aedat4"
    return {
        "simulate": Work(["simulate", data, "--preset", "paper", "--runs", RUNS], lambda: [data], lambda: data.glob("*/*/events.aedat4")),
        "label": Work(["label", data, "--no-pictures"], lambda: [*data.glob("*/*/labels.json")], lambda: data.glob("*/*/labels.json")),
        "windows": Work(["windows", data], lambda: [*data.glob("dataset*.h5")], lambda: data.glob("dataset*.h5")),
        "heatmaps": Work(["heatmaps", data, "--th", "40"], lambda: [*data.glob("dataset.th_*.h5")], lambda: data.glob("dataset.th_*.h5")),
        "train": Work(["train", data, "--th", "40", "--epochs", "4", "--models", models, "--name", "threads"], lambda: [models],
                                lambda: [bundle / "weights.safetensors"]),
        "eval": Work(["eval", data, "--model", bundle], lambda: [*bundle.glob("eval*")], lambda: [bundle / "eval.json", bundle / "eval-cells.csv"]),
        "convert": Work(["convert", long_run, converted, "--compression", "zstd"], lambda: [converted], lambda: [converted]),
        "info": Work(["info", long_run], lambda: [], lambda: []),
    }


def seconds_of_last_epoch(folder):
    with open(folder / "models" / "threads" / "history.csv", encoding="utf-8") as table:
        return float([*csv.DictReader(table)][-1]["seconds"])


def measure(tactile, work, threads):
    """The shortest of TURNS runs: wall-clock s, CPU s, peak MiB, digest of the results."""
    best = None
    for _ in range(TURNS):
        work.clear()
        status, *cost = cost_of([tactile, *work.words, "--threads", threads, "--quiet"], stdout=subprocess.DEVNULL)
        if status != 0:
            sys.exit(f"threads.py: {tactile} {work.words[0]} --threads {threads} ended with {status}")
        best = min(best or cost, cost)
    return (*best, work.digest())


def measure_at_work(tactile, work, threads):
    """As `at_work`, without the status."""
    work.clear()
    status, *result = at_work([tactile, *work.words, "--threads", threads, "--quiet"], stdout=subprocess.DEVNULL)
    if status != 0:
        sys.exit(f"threads.py: {tactile} {work.words[0]} --threads {threads} ended with {status}")
    return result


def measure_independent(tactile, folder, name, processes):
    """The shortest of TURNS runs of so many independent processes at the same time, with one thread each [s]."""
    copies = [folder.with_name(f"{folder.name}-{number}") for number in range(processes)]
    try:
        return min(seconds_side_by_side(tactile, folder, copies, name) for _ in range(TURNS))
    finally:
        for copy in copies:
            shutil.rmtree(copy, ignore_errors=True)


def seconds_side_by_side(tactile, folder, copies, name):
    commands = []
    for copy in copies:
        shutil.rmtree(copy, ignore_errors=True)
        shutil.copytree(folder, copy, copy_function=os.link)
        work = works(copy)[name]
        work.clear()
        commands.append([str(word) for word in (tactile, *work.words, "--threads", 1, "--quiet")])
    begin = time.monotonic()
    running = [subprocess.Popen(command, stdout=subprocess.DEVNULL) for command in commands]
    failed = [process.args for process in running if process.wait() != 0]
    if failed:
        sys.exit(f"threads.py: {' '.join(failed[0])} failed")
    return time.monotonic() - begin


def simulate_long_run(tactile, folder):
    """A run of about 45 s by a camera with much noise, in one recording."""
    physics = folder / "long.json"
    physics.write_text(json.dumps({"presets": {"quick": {"timings": {"quiet_s": [40, 40]}}}}))
    subprocess.run([tactile, "simulate", folder / "long", "--preset", "quick", "--runs", "1", "--objects", "textured-box", "--camera", "noisy",
                    "--physics", physics, "--quiet"], stdout=subprocess.DEVNULL, check=True)


def numbers_of_threads():
    powers = [1]
    while powers[-1] * 2 < CORES:
        powers.append(powers[-1] * 2)
    return powers + [CORES] * (CORES > 1)


def table(title, columns, rows):
    print(f"| {title} | " + " | ".join(columns) + " |\n| --- |" + " ---: |" * len(columns))
    for name, cells in rows:
        print(f"| {name} | " + " | ".join(cells) + " |", flush=True)


def measure_study(tactile, folder, options, threads):
    command = [tactile, "reproduce", *options, folder / "study", "--models", folder / "study-models", "--out", folder / "study-out", "--threads",
               threads, "--quiet"]
    title = f"\n`reproduce {' '.join(options)}` with {threads} threads"
    if threads > CORES:
        status, wall_s, mean, alone_s, with_all_s = at_work(command, stdout=subprocess.DEVNULL)
        print(f"{title}: {wall_s:.0f} s, {mean:.1f} of them at work on average, at most one for {alone_s:.1f} s; "
              f"with a core for each an estimated {with_all_s:.0f} s (status {status}).")
    else:
        status, wall_s, cpu_s, _ = cost_of(command, stdout=subprocess.DEVNULL)
        print(f"{title}: {wall_s:.0f} s, {cpu_s:.0f} s of CPU time (status {status}).")


def main():
    tactile, folder = sys.argv[1], Path(sys.argv[2]).resolve()
    counts = [int(word) for word in sys.argv[3:]] or numbers_of_threads()
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    measured, shared, epochs_s, independent = {}, {}, [], {}
    together = min(CORES, counts[-1])
    for name, work in works(folder).items():
        if name == "convert":
            simulate_long_run(tactile, folder)
        measured[name] = []
        for count in counts:
            measured[name].append(measure(tactile, work, count))
            if name == "train":
                epochs_s.append(seconds_of_last_epoch(folder))
        if counts[0] == 1 and together > 1:
            independent[name] = measured[name][0][0] / measure_independent(tactile, folder, name, together) * together
        if counts[-1] > CORES:
            shared[name] = measure_at_work(tactile, work, counts[-1])
        print(f"{name}: {' '.join(f'{cost[0]:.2f}' for cost in measured[name])} s", file=sys.stderr, flush=True)

    first, last = counts[0], counts[-1]
    columns = [f"{count} threads" for count in counts[1:]] + [f"{together} processes"] * bool(independent)
    table("times as fast with", columns + [f"{first} thread [s]", "CPU time [s]", f"CPU with {last} [s]", "results"],
          [(f"`{name}`", [f"{costs[0][0] / cost[0]:.2f}" for cost in costs[1:]]
            + [f"{independent[name]:.2f}"] * bool(independent) + [f"{costs[0][0]:.2f}", f"{costs[0][1]:.2f}", f"{costs[-1][1]:.2f}",
               "-" if name == "info" else "equal" if len({cost[3] for cost in costs}) == 1 else "**differ**"])
           for name, costs in measured.items()])
    print()
    table("memory with [MiB]", [f"{count} threads" for count in counts] + ["more per thread"],
          [(f"`{name}`", [f"{cost[2]:.0f}" for cost in costs] + [f"{(costs[-1][2] - costs[0][2]) / max(1, last - first):.1f}"])
           for name, costs in measured.items()])
    print(f"\nAn epoch of `train`, batches of 32: {epochs_s[0]:.2f} s, and times as fast: " + ", ".join(f"{epochs_s[0] / one:.2f}" for one in epochs_s[1:]))
    if shared:
        print()
        table(f"{last} threads on {CORES} cores",
              ["at work on average", "at most one at work [s]", "with a core for each, estimated [s]",
               f"times as fast as with {first}, estimated"],
              [(f"`{name}`", [f"{mean:.1f}", f"{alone_s:.2f}", f"{with_all_s:.2f}", f"{measured[name][0][0] / with_all_s:.1f}"])
               for name, (_, mean, alone_s, with_all_s) in shared.items()])
    if "TACTILE_BENCH_STUDY" in os.environ:
        measure_study(tactile, folder, os.environ["TACTILE_BENCH_STUDY"].split(), last)
    return 0


sys.exit(main())

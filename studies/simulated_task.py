"""Prints the tables of docs/simulation.md from the folder of scripts/simulation-study.

    simulated_task.py TACTILE FOLDER TITLE
"""

import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

TICK_US = 2000
QUIET_DISTANCE_US = 100_000  # events are quiet if they are at least this far from any motion


def figure(value, low, high):
    """A share in percent, with its confidence interval if there is one."""
    return f"{100 * value:.1f} [{100 * low:.1f}, {100 * high:.1f}]" if low is not None else f"{100 * value:.1f}"


def task_table(evaluation):
    rows = [("LeNet", evaluation["accuracy"]["mean"])]
    rows += [(name, score["accuracy"]) for name, score in evaluation["baselines"].items()]
    print("| on held-out runs | accuracy, mean over objects [%] |\n| --- | ---: |")
    for name, accuracy in rows:
        print(f"| {name} | {figure(accuracy['value'], accuracy['low'], accuracy['high'])} |")
    print("\n| object | LeNet | " + " | ".join(list(evaluation["baselines"])[1:]) + " |\n| --- |" + " ---: |" * len(evaluation["baselines"]))
    for name, accuracy in evaluation["accuracy"]["objects"].items():
        others = [score["objects"][name]["value"] for score in list(evaluation["baselines"].values())[1:]]
        print(f"| {name} | {100 * accuracy['value']:.1f} | " + " | ".join(f"{100 * value:.1f}" for value in others) + " |")
    print("\n| true \\ predicted | none | press | slip |\n| --- | ---: | ---: | ---: |")
    for name, row in zip(("none", "press", "slip"), evaluation["confusion"]):
        print(f"| {name} | " + " | ".join(f"{100 * value / max(sum(row), 1):.1f} %" for value in row) + " |")


def events_of(tactile, run, folder):
    file = pathlib.Path(folder) / "events.npz"
    file.unlink(missing_ok=True)
    subprocess.run([tactile, "convert", "--quiet", run / "events.aedat4", file], check=True, stdout=subprocess.DEVNULL)
    loaded = np.load(file)
    return loaded["events"], loaded["sensor_size"]


def statistics_of(events, size, truth):
    """Statistics of the events of one run. Hot pixels are counted separately."""
    t = events["t_us"].astype(np.int64)
    pixel = events["y"].astype(np.int64) * size[0] + events["x"]
    hot = np.array([y * size[0] + x for x, y in ((p["x"], p["y"]) for p in truth.get("hot_pixels", []))], dtype=np.int64)
    is_hot = np.isin(pixel, hot)
    seconds = (t[-1] - t[0]) / 1e6
    found = {"hot_hz": np.bincount(np.searchsorted(np.sort(hot), pixel[is_hot]), minlength=len(hot)) / seconds if len(hot) else np.array([])}

    quiet = np.ones(len(t), bool)
    quiet_us = t[-1] - t[0]
    moving = sorted((i["start_us"] - QUIET_DISTANCE_US, i["end_us"] + QUIET_DISTANCE_US) for i in truth["intervals"])
    merged = []
    for start, end in moving:
        if merged and start <= merged[-1][1]:
            merged[-1][1] = max(merged[-1][1], end)
        else:
            merged.append([start, end])
    for start, end in merged:
        quiet &= ~((t >= start) & (t < end))
        quiet_us -= max(0, min(end, t[-1]) - max(start, t[0]))
    if quiet_us > 0:
        found["quiet_rate"] = quiet.sum() / quiet_us * 1e6
        found["quiet_rate_without_hot"] = (quiet & ~is_hot).sum() / quiet_us * 1e6

    for interval in truth["intervals"]:
        if not interval["labelled"]:
            continue
        name = interval["class"]
        inside = (t >= interval["start_us"]) & (t < interval["end_us"])
        ms = (interval["end_us"] - interval["start_us"]) / 1e3
        found.setdefault(name + "_ms", []).append(ms)
        found.setdefault(name + "_rate", []).append(inside.sum() / ms * 1e3)
        chosen = inside & ~is_hot
        tick = (t[chosen] - interval["start_us"]) // TICK_US
        _, counts = np.unique(tick * (size[0] * size[1]) + pixel[chosen], return_counts=True)
        found.setdefault(name + "_per_pixel_tick", []).append(counts)
        order = np.lexsort((t[chosen], pixel[chosen]))
        same = np.diff(pixel[chosen][order]) == 0
        found.setdefault(name + "_between_us", []).append(np.diff(t[chosen][order])[same])
        found.setdefault(name + "_on", []).append(events["on"][chosen].mean())
    return found


def spread(values, scale=1.0, digits=0):
    """Two cells of a table: the median, and the 5th to 95th percentile."""
    values = np.asarray(values, float) * scale
    low, middle, high = np.percentile(values, [5, 50, 95])
    return f"{middle:,.{digits}f} | {low:,.{digits}f} to {high:,.{digits}f}"


def event_table(tactile, folder):
    found = {}
    with tempfile.TemporaryDirectory() as scratch:
        for file in sorted(pathlib.Path(folder, "data").glob("*/*/truth.json")):
            truth = json.loads(file.read_text())
            events, size = events_of(tactile, file.parent, scratch)
            for key, value in statistics_of(events, size, truth).items():
                found.setdefault(key, []).extend(np.atleast_1d(value) if not isinstance(value, list) else value)
    action = np.concatenate([found["press_rate"], found["slip_rate"]])
    rows = [
        ("quiet rate, per run [kev/s]", spread(found["quiet_rate"], 1e-3), "167, measured here (still scene)"),
        ("quiet rate without hot pixels [kev/s]", spread(found["quiet_rate_without_hot"], 1e-3, 1), "131, measured here (still scene)"),
        ("mean rate of a press or slip over the quiet one", spread(action / np.median(found["quiet_rate"]), 1, 1), "0.3 to 18, derived (rates below over 167 kev/s)"),
    ]
    if found["hot_hz"]:
        rows.append(("a hot pixel's rate [ev/s]", spread(found["hot_hz"]), "5 to 1311, median 18, measured here (still scene)"))
    for name in ("press", "slip"):
        counts = np.concatenate(found[name + "_per_pixel_tick"])
        between = np.concatenate(found[name + "_between_us"])
        rows += [
            (f"{name}: lasts [ms]", spread(found[name + "_ms"]), "100 to 500, derived (2 mm at 4 to 20 mm/s)" if name == "press" else ""),
            (f"{name}: mean rate [kev/s]", spread(found[name + "_rate"], 1e-3), "50 to 3000, derived (edges × speed × contrast / threshold)"),
            (f"{name}: events per pixel and 2 ms tick, of those with any (mean {counts.mean():.2f}, most {counts.max()})", spread(counts), "at most 11, measured here (moving scene)"),
            (f"{name}: from one event of a pixel to its next [ms]", spread(between, 1e-3, 1), "from 0.195, derived (one read-out)"),
            (f"{name}: share of brighter events [%]", spread(found[name + "_on"], 100), ""),
        ]
    print("| what | median | 5 % to 95 % | reference |\n| --- | ---: | ---: | ---: |")
    for row in rows:
        print("| " + " | ".join(row) + " |")


def main():
    tactile, folder, title = sys.argv[1:]
    folder = pathlib.Path(folder)
    evaluation = json.loads((folder / "eval.json").read_text())
    labels = json.loads((folder / "label.json").read_text())
    print(f"### {title}\n")
    task_table(evaluation)
    print()
    event_table(tactile, folder)
    print("\n| labels against truth [ms] | median | p95 | max | n |\n| --- | ---: | ---: | ---: | ---: |")
    for name, error in labels["truth"]["errors_ms"].items():
        print(f"| {name} | {error['median']:.2f} | {error['p95']:.2f} | {error['max']:.2f} | {error['n']} |")
    print(f"\n{labels['truth']['onsets_covered']} onsets inside their 95 % interval, {labels['truth']['missed']} missed, {labels['truth']['spurious']} spurious; "
          f"{sum(bool(run['flags']) for run in labels['runs'])} of {len(labels['runs'])} runs flagged")


main()

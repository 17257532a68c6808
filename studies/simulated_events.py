"""Statistics of the events of simulated runs, in the time of each press and slip and where nothing moves."""

import json
import pathlib
import subprocess
import tempfile

import numpy as np

TICK_US = 2000
QUIET_DISTANCE_US = 100_000  # events are quiet if they are at least this far from any motion


def events_of(tactile, run, folder):
    file = pathlib.Path(folder) / "events.npz"
    file.unlink(missing_ok=True)
    subprocess.run([tactile, "convert", "--quiet", run / "events.aedat4", file], check=True, stdout=subprocess.DEVNULL)
    loaded = np.load(file)
    return loaded["events"], loaded["sensor_size"]


def quiet_part(t, truth):
    """Which events lie far from any motion, and how long that is."""
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
    return quiet, quiet_us


def statistics_of(events, size, truth):
    """Statistics of the events of one run. Hot pixels are counted separately."""
    t = events["t_us"].astype(np.int64)
    pixel = events["y"].astype(np.int64) * size[0] + events["x"]
    hot = np.array([y * size[0] + x for x, y in ((p["x"], p["y"]) for p in truth.get("hot_pixels", []))], dtype=np.int64)
    is_hot = np.isin(pixel, hot)
    seconds = (t[-1] - t[0]) / 1e6
    found = {"hot_hz": np.bincount(np.searchsorted(np.sort(hot), pixel[is_hot]), minlength=len(hot)) / seconds if len(hot) else np.array([])}

    quiet, quiet_us = quiet_part(t, truth)
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


def spread(values):
    low, middle, high = np.percentile(np.asarray(values, float), [5, 50, 95])
    return {"median": float(middle), "p5": float(low), "p95": float(high)}


def event_statistics(tactile, data):
    """The median and the 5th to 95th percentile of each statistic, over all runs below `data`."""
    found = {}
    with tempfile.TemporaryDirectory() as scratch:
        for file in sorted(pathlib.Path(data).glob("*/*/truth.json")):
            truth = json.loads(file.read_text())
            events, size = events_of(tactile, file.parent, scratch)
            for key, value in statistics_of(events, size, truth).items():
                found.setdefault(key, []).extend(np.atleast_1d(value) if not isinstance(value, list) else value)
    found["rate_over_quiet"] = np.concatenate([found["press_rate"], found["slip_rate"]]) / np.median(found["quiet_rate"])
    for name in ("press_per_pixel_tick", "slip_per_pixel_tick", "press_between_us", "slip_between_us"):
        found[name] = np.concatenate(found[name])
    statistics = {key: spread(values) for key, values in found.items() if len(values)}
    for name in ("press_per_pixel_tick", "slip_per_pixel_tick"):
        statistics[name].update(mean=float(found[name].mean()), most=int(found[name].max()))
    return statistics

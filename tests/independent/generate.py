#!/usr/bin/env python3
"""Draws runs of a tactile sensor with exact truth, independently of `tactile simulate`.

  generate.py FOLDER [--ordinary N] [--cases all|none|NAME,...] [--repeats N] [--seed N] [--jobs N] [--tactile PATH]
"""
import argparse
import concurrent.futures
import hashlib
import json
import pathlib
import shutil
import subprocess
import sys
import time

import cv2
import numpy as np

import cases
import devices
import pixels
import skin
from ranges import HEIGHT, WIDTH, draw


def seeded(*parts):
    return np.random.default_rng(int.from_bytes(hashlib.sha256("/".join(map(str, parts)).encode()).digest()[:8], "little"))


def signal_events(motion, numbers, rng, background):
    surface, camera = skin.Skin(numbers, rng), pixels.Pixels(numbers, rng, background)
    for t in pixels.frame_times(motion, numbers):
        at = lambda x: float(np.interp(t, motion.t, x))
        camera.see(t, surface.render(at(motion.depth), at(motion.shear), at(motion.limit), at(motion.gross), at(motion.slid)))
    return camera.events()


def cut(table, from_us, to_us):
    """Leaves out what came before the recording began and after it ended."""
    keep = (table["t_us"] >= from_us) & (table["t_us"] < to_us)
    return {name: values[keep] for name, values in table.items()}


def visible_us(events, start, end):
    """When an observer who knows place and noise of a motion can be sure that it began: 4 standard deviations of the noise above its mean."""
    block = (events["y"] // 32).astype(int) * (WIDTH // 32) + events["x"] // 32
    stop = min(end, start + 100_000)
    caused = np.bincount(block[events["skin"] & (events["t_us"] >= start) & (events["t_us"] < stop)], minlength=300)
    there = np.isin(block, np.argsort(caused)[::-1][: 1 + int(np.searchsorted(np.cumsum(np.sort(caused)[::-1]), 0.8 * caused.sum()))])
    quiet = there & ~events["skin"]
    rate = np.count_nonzero(quiet) / (events["t_us"][-1] - events["t_us"][0])
    mine = events["t_us"][there & (events["t_us"] >= start) & (events["t_us"] < stop)]
    expected = rate * (mine - start)
    sure = np.flatnonzero(np.arange(1, len(mine) + 1) - expected > 4 * np.sqrt(expected) + 4)
    return int(mine[sure[0]]) if len(sure) else None


def truth_of(motion, events, epoch_us, from_us, to_us, clocks, hot, numbers, made):
    us = lambda seconds: None if seconds is None else int(round(epoch_us + seconds * 1e6))
    skin_times = events["t_us"][events["skin"]]
    intervals = []
    for x in motion.truths:
        start, end = us(x["start"]), min(us(x["end"]), to_us)
        if end <= from_us or start >= to_us:
            continue
        first = np.searchsorted(skin_times, start)
        first_us = int(skin_times[first]) if first < len(skin_times) and skin_times[first] <= end + 20000 else None
        begun = start < from_us
        intervals.append({"what": x["what"], "class": x["class"], "labelled": bool(x["labelled"] and not begun), "start_us": max(start, from_us),
                          "end_us": end, "first_event_us": None if begun else first_us, "gross_us": us(x["gross"])})
    return {"intervals": intervals, "lift_start_us": us(motion.lift_start), "clocks": {k: c and c.truth() for k, c in clocks.items()},
            "hot_pixels": [{"x": p % WIDTH, "y": p // WIDTH, "hz": hz} for p, hz in hot], "dead_pixels": [],
            "parameters": {**{k: float(v) for k, v in numbers.items()}, **made, "press_speeds_mm_s": motion.press_speeds,
                           "visible_us": [visible_us(events, x["start_us"], x["end_us"]) if x["labelled"] else None for x in intervals]}}


def make_run(folder, object_name, run, case, seed, tactile):
    rng = seeded(seed, object_name, run)
    numbers = draw(rng)
    scene = cases.CASES[case](numbers, rng)
    motion, numbers = scene.motion, scene.numbers
    epoch_us = int(1.7e15) + int(rng.integers(0, int(1e13)))
    from_us = epoch_us + int(scene.begins_at * 1e6)
    to_us = epoch_us + int((scene.ends_at or motion.t[-1]) * 1e6)
    background, hot = pixels.noise(numbers, rng, motion.t[-1])
    signal = signal_events(motion, numbers, seeded(seed, object_name, run, "pixels"), background)
    events = pixels.read_out(numbers, rng, signal, background, epoch_us)
    imu = devices.imu_samples(motion, numbers, rng, epoch_us, scene.camera_on_stage) if scene.imu else None
    events, imu = cut(events, from_us, to_us), imu and cut(imu, from_us, to_us)
    target = pathlib.Path(folder) / object_name / run
    part = target.with_name(run + ".part")
    shutil.rmtree(part, ignore_errors=True)
    part.mkdir(parents=True)
    clocks, kind = {"robot": None, "video": None}, "none"
    if scene.robot:
        clocks["robot"], kind = devices.write_robot_log(part / "robot.csv", motion, numbers, rng, epoch_us, numbers["drift_ppm"], scene.commands)
    if scene.film:
        clocks["video"] = devices.write_film(part / "video.mp4", part / "video.csv", motion, numbers, rng, epoch_us, rng.uniform(-60, 60),
                                             motion.lift if scene.firm else np.zeros_like(motion.lift))
    made = {"case": case, "seed": seed, "robot_log": kind, "imu": scene.imu, "commands": scene.commands}
    (part / "truth.json").write_text(json.dumps(truth_of(motion, events, epoch_us, from_us, to_us, clocks, hot, numbers, made), indent=1))
    (part / "run.json").write_text(json.dumps({"object": object_name, "run": run, "simulated": True, "complete": True,
                                               "sensor": {"width": WIDTH, "height": HEIGHT}}))
    devices.write_recording(part / "recording.h5", events, imu)
    subprocess.run([tactile, "convert", part / "recording.h5", part / "events.aedat4", "--quiet"], check=True, stdout=subprocess.DEVNULL)
    (part / "recording.h5").unlink()
    shutil.rmtree(target, ignore_errors=True)
    part.rename(target)
    return len(events["t_us"]), (to_us - from_us) / 1e6, len(signal[0])


def make_and_tell(job):
    """One run in a process of its own; a run that is complete is kept."""
    folder, object_name, run, case, seed, tactile = job
    if (pathlib.Path(folder) / object_name / run / "events.aedat4").exists():
        return f"{object_name}/{run}: kept"
    cv2.setNumThreads(1)
    start = time.time()
    count, seconds, signal = make_run(*job)
    return f"{object_name}/{run}: {seconds:.1f} s, {count} events, {signal} of the skin, made in {time.time() - start:.1f} s"


def add_options(parser):
    parser.add_argument("folder")
    parser.add_argument("--ordinary", type=int, default=12, help="ordinary runs, three of each object")
    parser.add_argument("--cases", default="none", help="special cases: all, none, or names with commas between")
    parser.add_argument("--repeats", type=int, default=2, help="runs of each special case")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=2, help="runs that are made at the same time")
    parser.add_argument("--tactile", default="build/release/bin/tactile")


def make_all(options):
    wanted = [(f"ordinary-{i // 3 + 1}", f"{i % 3 + 1:02d}", "ordinary") for i in range(options.ordinary)]
    names = {"all": [c for c in cases.CASES if c != "ordinary"], "none": []}.get(options.cases, options.cases.split(","))
    wanted += [(name, f"{k + 1:02d}", name) for name in names for k in range(options.repeats)]
    work = [(options.folder, object_name, run, case, options.seed, options.tactile) for object_name, run, case in wanted]
    with concurrent.futures.ProcessPoolExecutor(options.jobs) as pool:
        for line in pool.map(make_and_tell, work):
            print(line, file=sys.stderr, flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_options(parser)
    make_all(parser.parse_args())


if __name__ == "__main__":
    main()

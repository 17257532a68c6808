#!/usr/bin/env python3
"""Draws runs of a tactile sensor with exact truth, independently of `tactile simulate`.

  generate.py FOLDER [--ordinary N] [--cases all|none|NAME,...] [--repeats N] [--session N] [--seed N] [--jobs N] [--tactile PATH]
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
        camera.see(t, surface.render(at(motion.depth), at(motion.shear), at(motion.limit), at(motion.gross), at(motion.slid), at(motion.turn),
                                     at(motion.sway)))
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
            "parameters": {**{k: v if isinstance(v, str) else float(v) for k, v in numbers.items()}, **made, "press_speeds_mm_s": motion.press_speeds,
                           "visible_us": [visible_us(events, x["start_us"], x["end_us"]) if x["labelled"] else None for x in intervals]}}


def begin_of(rig, rng, run, in_session):
    """Camera times at which the session and the run begin. Runs of a session begin 40 to 60 s after one another; all others are alone in theirs."""
    session_us = int(1.7e15) + int(rig.integers(0, int(1e13)))
    return session_us, session_us + (int(run) * 50_000_000 + int(rng.integers(-5_000_000, 5_000_000)) if in_session else 0)


def host_from_camera(clock, from_us, to_us):
    """What `tactile record` writes: for each second, camera and host time of the packet that came with the shortest delay."""
    return [[t, int(round(clock.stamp(t)))] for t in range(int(from_us) + 1_000_000, int(to_us), 1_000_000)]


def write_devices(folder, scene, motion, numbers, rng, epoch_us, clocks, in_session):
    """Robot's log and film, if the scene has them. Returns the true clocks from their first stamps on."""
    found = {"robot": None, "video": None, "host": clocks["host"], "imu": clocks["imu"] if scene.imu else None}
    if scene.robot:
        found["robot"] = devices.write_robot_log(folder / "robot.csv", motion, numbers, rng, epoch_us, clocks, scene.commands, scene.log)
    if scene.film:
        found["video"] = devices.write_film(folder / "video.mp4", folder / "video.csv", motion, numbers, rng, epoch_us, clocks, scene.film_kind,
                                            in_session)
    return found


def make_run(folder, object_name, run, case, seed, tactile, session):
    rng, rig = seeded(seed, object_name, run), seeded(seed, session or f"{object_name}/{run}", "rig")
    numbers = draw(rng, rig=rig)
    session_us, epoch_us = begin_of(rig, rng, run, session is not None)
    clocks = devices.clocks_of(numbers, rig, session_us)
    scene = cases.CASES[case](numbers, rng)
    motion, numbers = scene.motion, scene.numbers
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
    found = write_devices(part, scene, motion, numbers, rng, epoch_us, clocks, session is not None)
    made = {"case": case, "seed": seed, "imu": scene.imu, "commands": scene.commands, "log": scene.log, "film": scene.film_kind}
    (part / "truth.json").write_text(json.dumps(truth_of(motion, events, epoch_us, from_us, to_us, found, hot, numbers, made), indent=1))
    about = {"object": object_name, "run": run, "simulated": True, "complete": True, "sensor": {"width": WIDTH, "height": HEIGHT}}
    if session:
        about["session"] = session
    if scene.robot and numbers["recorder"] == "tactile record":
        about["host_from_camera"] = host_from_camera(clocks["host"], from_us, to_us)
    (part / "run.json").write_text(json.dumps(about))
    devices.write_recording(part / "recording.h5", events, imu)
    subprocess.run([tactile, "convert", part / "recording.h5", part / "events.aedat4", "--quiet"], check=True, stdout=subprocess.DEVNULL)
    (part / "recording.h5").unlink()
    shutil.rmtree(target, ignore_errors=True)
    part.rename(target)
    return len(events["t_us"]), (to_us - from_us) / 1e6, len(signal[0])


def make_and_tell(job):
    """One run in a process of its own; a run that is complete is kept."""
    folder, object_name, run = job[:3]
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
    parser.add_argument("--session", type=int, default=0, help="ordinary runs of one session: one camera and skin, and the same clocks")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=2, help="runs that are made at the same time")
    parser.add_argument("--tactile", default="build/release/bin/tactile")


def make_all(options):
    wanted = [(f"ordinary-{i // 3 + 1}", f"{i % 3 + 1:02d}", "ordinary", None) for i in range(options.ordinary)]
    names = {"all": [c for c in cases.CASES if c != "ordinary"], "none": []}.get(options.cases, options.cases.split(","))
    wanted += [(name, f"{k + 1:02d}", name, None) for name in names for k in range(options.repeats)]
    wanted += [("session", f"{k + 1:02d}", "ordinary", f"session-{options.seed}") for k in range(options.session)]
    work = [(options.folder, object_name, run, case, options.seed, options.tactile, session) for object_name, run, case, session in wanted]
    with concurrent.futures.ProcessPoolExecutor(options.jobs) as pool:
        for line in pool.map(make_and_tell, work):
            print(line, file=sys.stderr, flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_options(parser)
    make_all(parser.parse_args())


if __name__ == "__main__":
    main()

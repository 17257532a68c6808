#!/usr/bin/env python3
"""Labels runs with `tactile label` and compares the labels with the truth, by its own rules. Generates the runs that are missing.

  judge.py FOLDER [--ordinary N] [--cases all|NAME,...|none] [--repeats N] [--seed N] [--jobs N] [--tactile PATH] [--json FILE]

Exits with 1 if a goal is missed.
"""
import argparse
import collections
import json
import math
import pathlib
import re
import subprocess
import sys

import h5py
import numpy as np

import generate

NEAR_US = 150_000   # a label and a truth of one class belong together if they overlap, or begin this near to each other
WRONG_US = 30_000   # an error above this needs a flag
CLOCK_WORDS = {"robot": ("robot's clock", "match of the arm", "match of arm"), "IMU": ("robot's clock", "match of arm"), "film": ("film",)}


def pairs_of(truths, labels):
    """Pairs (truth, label) of one class, the nearest onsets first; each is used once."""
    near = []
    for i, truth in enumerate(truths):
        for k, label in enumerate(labels):
            gap = abs(label["start_us"] - truth["start_us"])
            overlap = min(label["end_us"], truth["end_us"]) - max(label["start_us"], truth["start_us"])
            if truth["class"] == label["class"] and (overlap > 0 or gap < NEAR_US):
                near.append((gap, i, k))
    found, used = {}, set()
    for _, i, k in sorted(near):
        if i not in found and k not in used:
            found[i] = k
            used.add(k)
    return found, [k for k in range(len(labels)) if k not in used]


def middle_of_clock(path, column):
    """The middle of a table's stamps [us]."""
    with open(path, newline="") as file:
        names, *rows = [re.split("[, ]", line.strip()) for line in file if line.strip()]
    k = names.index(column)
    return 0.5 * (float(rows[0][k]) + float(rows[-1][k])) * (1e6 if column == "timestamp" else 1)


def judge_clocks(folder, truth, labels, flags):
    """Each clock's error in the middle of its stamps and the half-width that the labels state. The IMU has the camera's clock: what it relates is
    the robot's."""
    found = []
    for key, table, column in (("robot", "robot.csv", "timestamp"), ("video", "video.csv", "pts_us")):
        stated, true = labels["clocks"][key], truth["clocks"].get(key)
        if stated is None or true is None:
            continue
        middle = middle_of_clock(folder / table, column)
        for clock in stated if isinstance(stated, list) else [stated]:
            at = lambda c: c["offset_us"] + c["drift_ppm"] * 1e-6 * (middle - c["reference_us"])
            drift = clock.get("drift_within_ppm", 0) * 1e-6 * (middle - clock.get("found_at_us", middle))
            low = -math.hypot(clock["offset_low_us"] - clock["offset_us"], drift)
            high = math.hypot(clock["offset_high_us"] - clock["offset_us"], drift)
            name = "film" if key == "video" else "IMU" if "IMU" in clock["method"] else "robot"
            named = any(word in remark for remark in labels["remarks"] for word in CLOCK_WORDS[name])
            error = at(clock) - at(true)
            found.append({"clock": name, "error": error, "half_width": 0.5 * (high - low), "covered": bool(low <= -error <= high),
                          "reported": bool(flags) or named})
    return found


def is_certain_and_wrong(clock):
    return abs(clock["error"]) > 2 * clock["half_width"] and not clock["reported"]


def judge_run(folder):
    """What is right and wrong about the labels of one run."""
    truth = json.loads((folder / "truth.json").read_text())
    labels = json.loads((folder / "labels.json").read_text())
    truths = [x for x in truth["intervals"] if x["labelled"]]
    found, spurious = pairs_of(truths, labels["intervals"])
    flags = [f for f in labels["flags"] if not f["confirmed"]]
    run_flagged = any(f["interval"] is None for f in flags)
    flagged = lambda k: run_flagged or any(f["interval"] == k for f in flags)
    visible = dict(zip(map(id, truth["intervals"]), truth["parameters"].get("visible_us", [None] * len(truth["intervals"]))))
    presses = iter(truth["parameters"]["press_speeds_mm_s"][-sum(x["class"] == "press" for x in truths):])
    onsets = []
    for i, x in enumerate(truths):
        speed = next(presses, None) if x["class"] == "press" else None
        label = labels["intervals"][found[i]] if i in found else None
        onsets.append({"class": x["class"], "speed": speed, "found": label is not None,
                       "error": label and label["start_us"] - x["start_us"], "end_error": label and label["end_us"] - x["end_us"],
                       "visible_error": label and x["first_event_us"] and label["start_us"] - x["first_event_us"],
                       "visible": visible[id(x)] and visible[id(x)] - x["start_us"],
                       "covered": label and label["start_low_us"] <= x["start_us"] <= label["start_high_us"],
                       "width": label and label["start_high_us"] - label["start_low_us"],
                       "flagged": flagged(found[i]) if i in found else run_flagged})
    false = [{"class": labels["intervals"][k]["class"], "flagged": flagged(k), "on": on_what(truth, labels["intervals"][k])} for k in spurious]
    return {"run": f"{folder.parent.name}/{folder.name}", "case": truth["parameters"]["case"], "onsets": onsets, "spurious": false,
            "clocks": judge_clocks(folder, truth, labels, flags),
            "flags": [("run: " if f["interval"] is None else labels["intervals"][f["interval"]]["class"] + ": ") + f["reason"] for f in flags]}


def on_what(truth, label):
    """The true motion that a superfluous label overlaps most."""
    best = max(truth["intervals"], default=None, key=lambda x: min(x["end_us"], label["end_us"]) - max(x["start_us"], label["start_us"]))
    if best is None or min(best["end_us"], label["end_us"]) <= max(best["start_us"], label["start_us"]):
        return "nothing"
    return best["what"]


def runs_with_samples(tactile, folder):
    """Names of the runs that `tactile windows` draws samples from, with its default settings."""
    dataset = pathlib.Path(folder) / "dataset.h5"
    if subprocess.run([tactile, "windows", folder, "--quiet"], stdout=subprocess.DEVNULL).returncode != 0:
        return set()
    with h5py.File(dataset) as file:
        names = [f"{o}/{r}" for o, r in zip(file["/runs/object"].asstr()[:], file["/runs/run"].asstr()[:])]
        return {names[i] for i in np.unique(file["/samples/run"][:])}


def quantiles(values):
    v = np.abs(np.array(values, float)) / 1000
    return (float(np.median(v)), float(np.quantile(v, 0.95)), float(v.max())) if len(v) else (float("nan"),) * 3


def print_errors(title, onsets):
    print(f"\n{title}\n{'':28}{'n':>4} {'found':>6} {'flagged':>8} {'median':>8} {'p95':>8} {'max':>9} {'covered':>8} {'width':>7}  [ms]")
    for kind in ("press", "slip"):
        mine = [o for o in onsets if o["class"] == kind]
        for name, some in ((f"{kind} onset", mine), ("  without a flag", [o for o in mine if not o["flagged"]])):
            hit = [o for o in some if o["found"]]
            row = quantiles([o["error"] for o in hit])
            cover = np.mean([o["covered"] for o in hit]) if hit else np.nan
            width = np.median([o["width"] for o in hit]) / 1000 if hit else np.nan
            print(f"{name:28}{len(some):4} {len(hit):6} {sum(o['flagged'] for o in some):8} {row[0]:8.2f} {row[1]:8.2f} {row[2]:9.2f}"
                  f" {cover:8.0%} {width:7.1f}")
        hit = [o for o in mine if o["found"]]
        for key, name in (("visible_error", f"{kind} onset, first event"), ("visible", f"{kind} visible after"), ("end_error", f"{kind} end")):
            values = [o[key] for o in hit if o[key] is not None]
            row = quantiles(values)
            print(f"{name:28}{len(values):4} {'':6} {'':8} {row[0]:8.2f} {row[1]:8.2f} {row[2]:9.2f}")


def print_speeds(onsets):
    print("\npresses by speed of the stage at the first contact\n  mm/s      n  missed  median error [ms]")
    for low, high in ((0, 2), (2, 4), (4, 8), (8, 100)):
        mine = [o for o in onsets if o["class"] == "press" and low <= (o["speed"] or 0) < high]
        hit = [o["error"] for o in mine if o["found"]]
        print(f"  {low:>2}-{high:<4} {len(mine):4}  {len(mine) - len(hit):6}  {quantiles(hit)[0]:8.2f}")


def print_clocks(runs):
    print(f"\nclocks of all runs\n{'':10}{'n':>4} {'median':>8} {'p95':>8} {'max':>9} {'half-width':>11} {'covered':>8}"
          f" {'beyond twice, untold':>21}  [ms]")
    for name in CLOCK_WORDS:
        mine = [c for r in runs for c in r["clocks"] if c["clock"] == name]
        if mine:
            row = quantiles([c["error"] for c in mine])
            print(f"{name:10}{len(mine):4} {row[0]:8.2f} {row[1]:8.2f} {row[2]:9.2f} {np.median([c['half_width'] for c in mine]) / 1000:11.2f}"
                  f" {np.mean([c['covered'] for c in mine]):8.0%} {sum(map(is_certain_and_wrong, mine)):21}")
    for r in runs:
        for c in r["clocks"]:
            if not c["covered"]:
                print(f"  {r['run']:26} {c['clock']} off by {c['error'] / 1000:.1f} ms, stated ± {c['half_width'] / 1000:.1f} ms"
                      + ("" if c["reported"] else ", NO REMARK OR FLAG"))


def clock_goals_of(runs):
    goals = []
    for name in CLOCK_WORDS:
        mine = [c for r in runs for c in r["clocks"] if c["clock"] == name]
        if mine:
            covered, wrong = np.mean([c["covered"] for c in mine]), sum(map(is_certain_and_wrong, mine))
            goals += [(f"{name} clocks inside their interval", covered, ">= 0.90", covered >= 0.9),
                      (f"{name} clocks beyond twice it, untold", wrong, "0", wrong == 0)]
    return goals


def goals_of(ordinary, sampled):
    onsets = [o for r in ordinary for o in r["onsets"]]
    errors = lambda kind: [o["error"] for o in onsets if o["class"] == kind and o["found"]]
    covered = [o["covered"] for o in onsets if o["found"]] or [False]
    missed = [o for o in onsets if o["class"] == "press" and not o["found"] and o["speed"] >= 2]
    wrong = [o for r in ordinary for o in r["onsets"] if o["found"] and abs(o["error"]) > WRONG_US and not o["flagged"]]
    wrong += [o for r in ordinary for o in r["onsets"] if not o["found"] and not o["flagged"]]
    wrong += [s for r in ordinary for s in r["spurious"] if not s["flagged"]]
    press, slip, both = quantiles(errors("press")), quantiles(errors("slip")), quantiles(errors("press") + errors("slip"))
    flagged, giving = np.mean([bool(r["flags"]) for r in ordinary]), np.mean([r["run"] in sampled for r in ordinary])
    return [("press onset, median", press[0], "<= 5 ms", press[0] <= 5),
            ("slip onset, median", slip[0], "<= 5 ms", slip[0] <= 5),
            ("both onsets, p95", both[1], "<= 20 ms", both[1] <= 20),
            ("onsets inside their interval", np.mean(covered), ">= 0.90", np.mean(covered) >= 0.9),
            ("wrong, missed or superfluous without a flag", len(wrong), "0", not wrong),
            ("ordinary runs flagged", flagged, "<= 0.20", flagged <= 0.2),
            ("ordinary runs that give samples", giving, ">= 0.80", giving >= 0.8), ("presses of 2 mm/s or more missed", len(missed), "0", not missed)]


def print_flags(title, runs):
    kinds = collections.Counter(re.sub(r"[0-9]+(\.[0-9]+)?", "N", f) for r in runs for f in r["flags"])
    print(f"\n{title}: {sum(bool(r['flags']) for r in runs)} of {len(runs)} runs")
    for reason, count in kinds.most_common():
        print(f"  {count:3}  {reason}")


def print_defects(runs):
    """Every onset that is missed, superfluous or more than 30 ms off, and whether a flag says so."""
    for r in runs:
        lines = [f"{o['class']} missed" + (f" ({o['speed']:.1f} mm/s)" if o["speed"] else "") + ("" if o["flagged"] else ", NO FLAG")
                 for o in r["onsets"] if not o["found"]]
        lines += [f"{o['class']} off by {o['error'] / 1000:.0f} ms" + ("" if o["flagged"] else ", NO FLAG")
                  for o in r["onsets"] if o["found"] and abs(o["error"]) > WRONG_US]
        lines += [f"superfluous {s['class']} on {s['on']}" + ("" if s["flagged"] else ", NO FLAG") for s in r["spurious"]]
        print(f"  {r['run']:26} {'; '.join(lines) or 'right'}" + (f" [{len(r['flags'])} flags]" if r["flags"] else ""))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    generate.add_options(parser)
    parser.add_argument("--json", help="also write all results here")
    options = parser.parse_args()
    generate.make_all(options)
    done = subprocess.run([options.tactile, "label", options.folder, "--force", "--no-pictures", "--quiet"], stdout=subprocess.DEVNULL)
    if done.returncode != 0:
        print(f"judge: 'tactile label' ended with {done.returncode}", file=sys.stderr)
    runs = [judge_run(f.parent) for f in sorted(pathlib.Path(options.folder).glob("*/*/labels.json"))]
    sampled = runs_with_samples(options.tactile, options.folder)
    ordinary = [r for r in runs if r["case"] == "ordinary"]
    special = [r for r in runs if r["case"] != "ordinary"]
    goals = (goals_of(ordinary, sampled) if ordinary else []) + clock_goals_of(runs)
    print(f"{len(ordinary)} ordinary runs, {len(special)} special ones")
    print_speeds([o for r in runs for o in r["onsets"]])
    for title, some in (("ordinary runs", ordinary), ("special cases", special)):
        if some:
            print_errors(title, [o for r in some for o in r["onsets"]])
            print_flags(f"flags of {title}", some)
            print(f"\n{title}, one by one")
            print_defects(some)
    print_clocks(runs)
    print("\ngoals, on ordinary runs; of clocks, on all" if goals else "")
    for name, value, limit, kept in goals:
        print(f"  {'kept  ' if kept else 'MISSED'}  {name:44} {value:8.2f}  {limit}")
    if options.json:
        pathlib.Path(options.json).write_text(json.dumps({"runs": runs, "sampled": sorted(sampled)}, indent=1))
    return 0 if all(kept for *_, kept in goals) else 1


if __name__ == "__main__":
    sys.exit(main())

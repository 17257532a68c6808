#!/usr/bin/env python3
"""Labels runs with `tactile label` and compares the labels with the truth, by its own rules. Generates the runs that are missing.

  judge.py FOLDER [--ordinary N] [--cases all|NAME,...|none] [--repeats N] [--session N] [--seed N] [--jobs N] [--tactile PATH]
           [--without robot,film,imu] [--json FILE]

Exits with 1 if a goal is missed.
"""
import argparse
import collections
import json
import math
import os
import pathlib
import re
import shutil
import subprocess
import sys

import h5py
import numpy as np

import generate

NEAR_US = 150_000   # a label and a truth belong together if they overlap, or begin this near to each other
WRONG_US = 30_000   # an error above this needs a flag
WITHOUT_RUNS = 20   # ordinary runs that are labelled again without a witness
BINS = ((0.5, 0.7), (0.7, 0.9), (0.9, 0.99), (0.99, 1.0))  # of the probability of a label's class
CLOCK_WORDS = {"robot": ("robot's clock", "match of the arm", "match of arm"), "IMU": ("robot's clock", "match of arm"), "film": ("film",)}
FILES = {"robot": ("robot.csv",), "film": ("video.mp4", "video.csv"), "imu": ()}


def pairs_of(truths, labels, alike=lambda truth, label: truth["class"] == label["class"]):
    """Pairs (truth, label) that are alike, the nearest onsets first; each is used once."""
    near = []
    for i, truth in enumerate(truths):
        for k, label in enumerate(labels):
            gap = abs(label["start_us"] - truth["start_us"])
            overlap = min(label["end_us"], truth["end_us"]) - max(label["start_us"], truth["start_us"])
            if alike(truth, label) and (overlap > 0 or gap < NEAR_US):
                near.append((gap, i, k))
    found, used = {}, set()
    for _, i, k in sorted(near):
        if i not in found and k not in used:
            found[i] = k
            used.add(k)
    return found, [k for k in range(len(labels)) if k not in used]


def of_wrong_class(truths, labels, found, spurious):
    """Truths without a label, each with the label of the other class that stands in its place."""
    missed = [i for i in range(len(truths)) if i not in found]
    pairs, _ = pairs_of([truths[i] for i in missed], [labels[k] for k in spurious], lambda truth, label: truth["class"] != label["class"])
    return {missed[i]: spurious[k] for i, k in pairs.items()}


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


def judge_onset(truth, label, visible_us, speed, flagged, mistaken):
    """A true touch and its label; without a label the errors are None."""
    inside = lambda end: label and label[f"{end}_low_us"] <= truth[f"{end}_us"] <= label[f"{end}_high_us"]
    return {"class": truth["class"], "speed": speed, "found": label is not None, "mistaken": mistaken,
            "error": label and label["start_us"] - truth["start_us"], "end_error": label and label["end_us"] - truth["end_us"],
            "visible": visible_us and visible_us - truth["start_us"], "covered": inside("start"), "end_covered": inside("end"),
            "width": label and label["start_high_us"] - label["start_low_us"], "flagged": flagged}


def judge_run(folder):
    """What is right and wrong about the labels of one run."""
    truth, name = json.loads((folder / "truth.json").read_text()), f"{folder.parent.name}/{folder.name}"
    labels = json.loads((folder / "labels.json").read_text())
    truths, made = [x for x in truth["intervals"] if x["labelled"]], labels["intervals"]
    found, spurious = pairs_of(truths, made)
    mistaken = of_wrong_class(truths, made, found, spurious)
    flags = [f for f in labels["flags"] if not f["confirmed"]]
    flagged = lambda k: any(f["interval"] in (None, k) for f in flags)
    visible = dict(zip(map(id, truth["intervals"]), truth["parameters"].get("visible_us", [None] * len(truth["intervals"]))))
    presses = sum(x["class"] == "press" for x in truths)
    speeds = iter(truth["parameters"]["press_speeds_mm_s"][-presses:] if presses else [])
    onsets = [judge_onset(x, made[found[i]] if i in found else None, visible[id(x)], next(speeds, None) if x["class"] == "press" else None,
                          flagged({**mistaken, **found}.get(i)), i in mistaken) for i, x in enumerate(truths)]
    false = [{"class": made[k]["class"], "flagged": flagged(k), "on": on_what(truth, made[k]), "mistaken": k in mistaken.values()} for k in spurious]
    sure = [{"probability": x["probability"], "right": k in found.values()} for k, x in enumerate(made) if x.get("probability") is not None]
    return {"run": name, "case": truth["parameters"]["case"], "onsets": onsets, "spurious": false, "sure": sure,
            "clocks": judge_clocks(folder, truth, labels, flags),
            "flags": [("run: " if f["interval"] is None else made[f["interval"]]["class"] + ": ") + f["reason"] for f in flags]}


def on_what(truth, label):
    """The true motion that a superfluous label overlaps most."""
    best = max(truth["intervals"], default=None, key=lambda x: min(x["end_us"], label["end_us"]) - max(x["start_us"], label["start_us"]))
    if best is None or min(best["end_us"], label["end_us"]) <= max(best["start_us"], label["start_us"]):
        return "nothing"
    return best["what"]


def label_runs(tactile, folder):
    done = subprocess.run([tactile, "label", folder, "--force", "--no-pictures", "--quiet"], stdout=subprocess.DEVNULL)
    if done.returncode != 0:
        print(f"judge: 'tactile label' ended with {done.returncode}", file=sys.stderr)


def runs_with_samples(tactile, folder):
    """Names of the runs that `tactile windows` draws samples from, with its default settings."""
    dataset = pathlib.Path(folder) / "dataset.h5"
    dataset.unlink(missing_ok=True)
    if subprocess.run([tactile, "windows", folder, "--quiet"], stdout=subprocess.DEVNULL).returncode != 0:
        return set()
    with h5py.File(dataset) as file:
        names = [f"{o}/{r}" for o, r in zip(file["/runs/object"].asstr()[:], file["/runs/run"].asstr()[:])]
        return {names[i] for i in np.unique(file["/samples/run"][:])}


def judge_folder(tactile, folder):
    """Labels all runs of a folder. Returns what is right and wrong about each, and the names of those that give samples."""
    label_runs(tactile, folder)
    made = [f.parent for f in sorted(pathlib.Path(folder).glob("*/*/truth.json"))]
    for run in made:
        if not (run / "labels.json").exists():
            print(f"judge: {run} has no labels", file=sys.stderr)
    return [judge_run(run) for run in made if (run / "labels.json").exists()], runs_with_samples(tactile, folder)


def has(run, witness):
    about = json.loads((run / "truth.json").read_text())["parameters"]
    return about["case"] == "ordinary" and (about["imu"] if witness == "imu" else (run / FILES[witness][0]).exists())


def leave_out_imu(tactile, run):
    events, table = run / "events.aedat4", run / "events.h5"
    subprocess.run([tactile, "convert", events, table, "--quiet"], check=True, stdout=subprocess.DEVNULL)
    with h5py.File(table, "a") as file:
        for name in [n for n in file if n.startswith("imu")]:
            del file[name]
    events.unlink()
    subprocess.run([tactile, "convert", table, events, "--quiet"], check=True, stdout=subprocess.DEVNULL)
    table.unlink()


def copied_without(tactile, folder, witness):
    """A folder of links to ordinary runs that have a witness, without the files of this witness."""
    target = pathlib.Path(f"{folder}-without-{witness}")
    shutil.rmtree(target, ignore_errors=True)
    runs = [f.parent for f in sorted(pathlib.Path(folder).glob("*/*/truth.json"))]
    for run in [r for r in runs if has(r, witness)][:WITHOUT_RUNS]:
        ignore = shutil.ignore_patterns("labels*", *FILES[witness])
        copy = shutil.copytree(run, target / run.parent.name / run.name, copy_function=os.link, ignore=ignore)
        if witness == "imu":
            leave_out_imu(tactile, copy)
    return target


def errors_of(onsets, error="error", covered="covered"):
    """Of the absolute errors, the median and the 95th percentile; the bias is the median of the errors. [ms]"""
    values = np.array([o[error] for o in onsets if o[error] is not None], float) / 1000
    inside = [o[covered] for o in onsets if o[error] is not None]
    if not len(values):
        return {"n": 0, "median_ms": None, "p95_ms": None, "bias_ms": None, "inside": None}
    return {"n": len(values), "median_ms": float(np.median(np.abs(values))), "p95_ms": float(np.quantile(np.abs(values), 0.95)),
            "bias_ms": float(np.median(values)), "inside": float(np.mean(inside))}


def defects_of(run):
    """(kind, text, flagged) of everything that is wrong with a run's labels."""
    for o in run["onsets"]:
        if o["mistaken"]:
            yield "wrong class", f"{o['class']} has the wrong class", o["flagged"]
        elif not o["found"]:
            yield "missed", f"{o['class']} missed" + (f" ({o['speed']:.1f} mm/s)" if o["speed"] else ""), o["flagged"]
        elif abs(o["error"]) > WRONG_US:
            yield "off by more than 30 ms", f"{o['class']} off by {o['error'] / 1000:.0f} ms", o["flagged"]
    for s in run["spurious"]:
        if not s["mistaken"]:
            yield "superfluous", f"superfluous {s['class']} on {s['on']}", s["flagged"]


def reliability_of(runs):
    """Of the labels whose class has a probability in a bin: how many, the mean probability, and the share that is right."""
    rows = []
    for low, high in BINS:
        mine = [x for r in runs for x in r["sure"] if low <= x["probability"] < high or x["probability"] == high == 1]
        rows.append({"from": low, "to": high, "n": len(mine), "mean": float(np.mean([x["probability"] for x in mine])) if mine else None,
                     "right": float(np.mean([x["right"] for x in mine])) if mine else None})
    return rows


def summary_of(runs, sampled):
    """Everything about a group of runs, by name."""
    onsets, defects = [o for r in runs for o in r["onsets"]], [d for r in runs for d in defects_of(r)]
    found = {"runs": len(runs), "flagged": sum(bool(r["flags"]) for r in runs), "give samples": sum(r["run"] in sampled for r in runs)}
    for kind in ("press", "slip"):
        mine = [o for o in onsets if o["class"] == kind]
        found[f"{kind} onset"], found[f"{kind} end"] = errors_of(mine), errors_of(mine, "end_error", "end_covered")
    for name in CLOCK_WORDS:
        found[f"{name} clock"] = errors_of([c for r in runs for c in r["clocks"] if c["clock"] == name])
    found["touches"] = len(onsets)
    for kind in ("missed", "superfluous", "wrong class", "off by more than 30 ms"):
        mine = [flagged for name, _, flagged in defects if name == kind]
        found[kind] = {"with a flag": sum(mine), "without": len(mine) - sum(mine)}
    found["reliability"] = reliability_of(runs)
    found["reasons"] = dict(collections.Counter(re.sub(r"[0-9]+(\.[0-9]+)?", "N", f) for r in runs for f in r["flags"]).most_common())
    return found


def rows_of(summary):
    """(title, text) of each row of a printed column."""
    for name, value in summary.items():
        if isinstance(value, int):
            yield name, str(value)
        elif "inside" in value:
            numbers = [f"{value[k]:.2f}" if value["n"] else "-" for k in ("median_ms", "p95_ms", "bias_ms")]
            yield from zip((f"{name}: found", "  median [ms]", "  95th percentile [ms]", "  bias [ms]"), [str(value["n"]), *numbers])
            yield "  inside its 95 % interval", f"{value['inside']:.0%}" if value["n"] else "-"
        elif "without" in value:
            yield f"{name}: with, without a flag", f"{value['with a flag']}, {value['without']}"


def print_groups(groups):
    columns = {name: list(rows_of(summary)) for name, summary in groups.items()}
    widths = {name: max(12, len(name) + 2) for name in groups}
    print(f"{'':42}" + "".join(f"{name:>{widths[name]}}" for name in groups))
    for i, (title, _) in enumerate(next(iter(columns.values()))):
        print(f"{title:42}" + "".join(f"{rows[i][1]:>{widths[name]}}" for name, rows in columns.items()))
    for name, summary in groups.items():
        print(f"\nflags, {name}: {summary['flagged']} of {summary['runs']} runs")
        for reason, count in summary["reasons"].items():
            print(f"  {count:3}  {reason}")
        rows = [r for r in summary["reliability"] if r["n"]]
        if rows:
            print(f"\nprobability of the class, {name}\n  from    to      n    mean   right")
            for r in rows:
                print(f"  {r['from']:.2f}  {r['to']:.2f}  {r['n']:5}  {r['mean']:6.3f}  {r['right']:6.3f}")


def print_speeds(onsets):
    print("\npresses by speed at the first contact\n  mm/s      n  missed  median error [ms]")
    for low, high in ((0, 1), (1, 2), (2, 4), (4, 8), (8, 100)):
        mine = [o for o in onsets if o["class"] == "press" and low <= (o["speed"] or 0) < high]
        row = errors_of(mine)
        print(f"  {low:>2}-{high:<4} {len(mine):4}  {len(mine) - row['n']:6}  {row['median_ms'] or math.nan:8.2f}")


def print_clocks(runs):
    print("\nclocks outside their interval")
    for r in runs:
        for c in r["clocks"]:
            if not c["covered"]:
                print(f"  {r['run']:26} {c['clock']} off by {c['error'] / 1000:.1f} ms, stated ± {c['half_width'] / 1000:.1f} ms"
                      + ("" if c["reported"] else ", NO REMARK OR FLAG"))


def print_defects(title, runs):
    """Every onset that is missed, superfluous, of the wrong class or more than 30 ms off, and whether a flag says so."""
    print(f"\n{title}, one by one")
    for r in runs:
        lines = [text + ("" if flagged else ", NO FLAG") for _, text, flagged in defects_of(r)]
        print(f"  {r['run']:26} {'; '.join(lines) or 'right'}" + (f" [{len(r['flags'])} flags]" if r["flags"] else ""))


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
    errors = lambda *kinds: errors_of([o for o in onsets if o["class"] in kinds])
    missed = [o for o in onsets if o["class"] == "press" and not o["found"] and o["speed"] >= 2]
    wrong = sum(not flagged for r in ordinary for _, _, flagged in defects_of(r))
    nan = lambda value: math.nan if value is None else value
    press, slip, both = nan(errors("press")["median_ms"]), nan(errors("slip")["median_ms"]), errors("press", "slip")
    covered, late = nan(both["inside"]), nan(both["p95_ms"])
    flagged, giving = np.mean([bool(r["flags"]) for r in ordinary]), np.mean([r["run"] in sampled for r in ordinary])
    return [("press onset, median", press, "<= 5 ms", press <= 5), ("slip onset, median", slip, "<= 5 ms", slip <= 5),
            ("both onsets, p95", late, "<= 20 ms", late <= 20), ("onsets inside their interval", covered, ">= 0.90", covered >= 0.9),
            ("wrong, missed or superfluous without a flag", wrong, "0", wrong == 0),
            ("ordinary runs flagged", flagged, "<= 0.20", flagged <= 0.2),
            ("ordinary runs that give samples", giving, ">= 0.80", giving >= 0.8), ("presses of 2 mm/s or more missed", len(missed), "0", not missed)]


def options_of_command():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    generate.add_options(parser)
    parser.add_argument("--without", default="", help=f"label {WITHOUT_RUNS} ordinary runs again without robot, film or imu; commas between")
    parser.add_argument("--json", help="also write all results here")
    return parser.parse_args()


def main():
    options = options_of_command()
    generate.make_all(options)
    runs, sampled = judge_folder(options.tactile, options.folder)
    ordinary, special = ([r for r in runs if (r["case"] == "ordinary") == usual] for usual in (True, False))
    groups = {name: summary_of(some, sampled) for name, some in (("ordinary", ordinary), ("special", special)) if some}
    for witness in filter(None, options.without.split(",")):
        groups[f"without {witness}"] = summary_of(*judge_folder(options.tactile, copied_without(options.tactile, options.folder, witness)))
    print_groups(groups)
    print_speeds([o for r in runs for o in r["onsets"]])
    for title, some in (("ordinary runs", ordinary), ("special cases", special)):
        print_defects(title, some)
    print_clocks(runs)
    goals = (goals_of(ordinary, sampled) if ordinary else []) + clock_goals_of(runs)
    print("\ngoals, on ordinary runs; of clocks, on all")
    for name, value, limit, kept in goals:
        print(f"  {'kept  ' if kept else 'MISSED'}  {name:44} {value:8.2f}  {limit}")
    if options.json:
        pathlib.Path(options.json).write_text(json.dumps({"groups": groups, "runs": runs, "sampled": sorted(sampled)}, indent=1))
    return 0 if all(kept for *_, kept in goals) else 1


if __name__ == "__main__":
    sys.exit(main())

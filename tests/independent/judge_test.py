#!/usr/bin/env python3
"""Judges the labels of six ordinary runs, and fails if they miss a goal of judge.py by far. Joins the runs in one recording, and
fails if `tactile split` does not find most of them again.

  judge_test.py TACTILE

Installs what the generator needs as scripts/judge-labels does. Ends with 77 if pip reaches no registry.
"""
import json
import pathlib
import statistics
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
SOURCES = HERE.parent.parent
SEED = 20261124
FAR_US = 30_000  # as judge.py: an error above this needs a flag
PAUSE_US = 4_000_000  # between two runs of the joined recording
# What the present `label` and `split` reach with these runs. The goals are those of judge.py, six runs and twelve touches.
LEAST_SAMPLED, LEAST_COVERED, MOST_MEDIAN_MS = 3, 0.7, 20
LEAST_RUNS, LEAST_TOUCHES = 4, 10


def missed_by_far(results):
    """What is wrong, one line each; fewer than ten onsets allow no narrow limits."""
    runs = results["runs"]
    onsets = [(r["run"], o) for r in runs for o in r["onsets"]]
    wrong = [f"{run}: {o['class']} without a flag: " + ("missed" if not o["found"] else f"off by {o['error'] / 1000:.0f} ms")
             for run, o in onsets if not o["flagged"] and (not o["found"] or abs(o["error"]) > FAR_US)]
    wrong += [f"{r['run']}: superfluous {s['class']} without a flag" for r in runs for s in r["spurious"] if not s["flagged"]]
    for kind in ("press", "slip"):
        errors = [abs(o["error"]) / 1000 for _, o in onsets if o["class"] == kind and o["found"]]
        median = statistics.median(errors) if errors else float("inf")
        if median > MOST_MEDIAN_MS:
            wrong.append(f"{kind} onset, median: {median:.1f} ms; expected {MOST_MEDIAN_MS} at most (the goal is 5)")
    covered = statistics.mean(o["covered"] for _, o in onsets if o["found"]) if any(o["found"] for _, o in onsets) else 0
    if covered < LEAST_COVERED:
        wrong.append(f"onsets inside their interval: {covered:.2f}; expected {LEAST_COVERED} at least (the goal is 0.90)")
    sampled = sum(r["run"] in results["sampled"] for r in runs)
    if sampled < LEAST_SAMPLED:
        wrong.append(f"runs that give samples: {sampled} of {len(runs)}; expected {LEAST_SAMPLED} at least (the goal is 0.80)")
    return wrong


def joined(tactile, runs, folder):
    """Writes one recording of all runs. Returns its path, the begin of each run in it, and the touches (run, class, start, end)."""
    begins, touches, rows, next_begin = [], [], [], 0
    for run in runs:
        subprocess.run([tactile, "convert", run / "events.aedat4", folder / "run.csv", "--force", "--quiet"], check=True,
                       stdout=subprocess.DEVNULL)
        header, *lines = (folder / "run.csv").read_text().splitlines()
        events = [line.split(",", 1) for line in lines]
        shift = next_begin - int(events[0][0])
        rows += [f"{int(t) + shift},{rest}" for t, rest in events]
        begins.append(next_begin)
        touches += [(len(begins) - 1, i["class"], i["start_us"] + shift, i["end_us"] + shift)
                    for i in json.loads((run / "truth.json").read_text())["intervals"] if i.get("labelled", True)]
        next_begin = int(events[-1][0]) + shift + PAUSE_US
    (folder / "joined.csv").write_text("\n".join([header, *rows]) + "\n")
    return folder / "joined.csv", begins, touches


def wrong_cuts(tactile, runs, folder):
    """What is wrong with the runs that `tactile split` proposes for a recording of all of them. Their skins and their noise differ."""
    path, begins, touches = joined(tactile, runs, folder)
    proposed = json.loads(subprocess.run([tactile, "split", path, "--dry-run", "--json", "--quiet"], check=True, capture_output=True,
                                         text=True).stdout)["proposal"]["runs"]
    wrong = [f"split cuts {1e-6 * cut['begin_us']:.1f} s after the begin, within a run" for cut in proposed
             if not any(0 <= begin - cut["begin_us"] <= PAUSE_US for begin in begins)]
    if not LEAST_RUNS <= len(proposed) <= len(runs):
        wrong.append(f"split proposes {len(proposed)} runs for {len(runs)}; expected {LEAST_RUNS} at least")
    seen = [t for run in proposed for t in run["touches"]]
    unseen = [f"run {i + 1}: split sees no touch at the {what}" for i, what, start, end in touches
              if not any(t["begin_us"] < end and t["end_us"] > start for t in seen)]
    return wrong + (unseen if len(touches) - len(unseen) < LEAST_TOUCHES else [])


def python_with_packages():
    """The interpreter of the generator's environment; None if a package cannot be installed."""
    environment = SOURCES / "build/independent"
    made = subprocess.run([SOURCES / "scripts/virtual-environment", environment, "numpy", "h5py", "opencv-python-headless", "av"],
                          capture_output=True, text=True)
    if made.returncode != 0 or made.stdout.strip():
        print("SKIPPED:", made.stderr.strip() or f"pip could not install {' '.join(made.stdout.split())}")
        return None
    return environment / "bin/python"


def main():
    python = python_with_packages()
    if python is None:
        return 77
    with tempfile.TemporaryDirectory(prefix="judged-runs-") as folder:
        results = pathlib.Path(folder) / "results.json"
        subprocess.run([python, HERE / "judge.py", pathlib.Path(folder) / "runs", "--ordinary", "6", "--seed", str(SEED),
                        "--tactile", sys.argv[1], "--json", results])
        if not results.exists():
            print("FAILED: judge.py wrote no results")
            return 1
        wrong = missed_by_far(json.loads(results.read_text()))
        runs = sorted(truth.parent for truth in (pathlib.Path(folder) / "runs").glob("*/*/truth.json"))
        wrong += wrong_cuts(sys.argv[1], runs, pathlib.Path(folder))
    for line in wrong:
        print("FAILED:", line)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""Judges the labels of six ordinary runs, and fails if they miss a goal of judge.py by far.

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
        if median > 20:
            wrong.append(f"{kind} onset, median: {median:.1f} ms; expected 20 at most (the goal is 5)")
    covered = statistics.mean(o["covered"] for _, o in onsets if o["found"]) if any(o["found"] for _, o in onsets) else 0
    if covered < 0.7:
        wrong.append(f"onsets inside their interval: {covered:.2f}; expected 0.70 at least (the goal is 0.90)")
    sampled = sum(r["run"] in results["sampled"] for r in runs)
    if 2 * sampled < len(runs) or not runs:
        wrong.append(f"runs that give samples: {sampled} of {len(runs)}; expected half at least (the goal is 0.80)")
    return wrong


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
    for line in wrong:
        print("FAILED:", line)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())

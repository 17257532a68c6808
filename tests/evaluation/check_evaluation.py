#!/usr/bin/env python3
"""Computes what `tactile eval` says once more, from the definitions alone, and compares.

    check_evaluation.py EVAL.json RUNS DATA

RUNS holds the CSV that `tactile eval --run` wrote of every test run, by the same model and the same --confirm; DATA holds the run folders
with labels.json and truth.json. Ends with 1 and names every figure that differs. Needs NumPy, and nothing of tactile.
"""

import csv
import json
import math
import os
import sys

import numpy as np

CLASSES = ["none", "press", "slip"]
WINDOW, HEAD_START = 500_000, 10_000  # us


class Run:
    def __init__(self, name, runs, data):
        self.object, self.id = name.split("/")
        with open(os.path.join(runs, name.replace("/", "-") + ".csv"), newline="") as file:
            rows = list(csv.DictReader(file))
        self.t = np.array([int(row["t_us"]) for row in rows])
        self.p = np.array([[np.float32(row["p_" + c]) for c in CLASSES] for row in rows]).astype(float)
        self.predicted = [row["verdict"] for row in rows]
        self.sample = [row["sample"] for row in rows]
        self.true = [row["truth"] for row in rows]
        self.label_column = [row["label"] for row in rows]
        labels = json.load(open(os.path.join(data, name, "labels.json")))
        doubt = {flag["interval"] for flag in labels["flags"] if not flag["confirmed"]}
        self.labels = [(i["class"], i["start_us"], i["end_us"]) for i in labels["intervals"]]
        self.used = [interval for k, interval in enumerate(self.labels) if k not in doubt]
        # Releases, and from each end until its 95 % interval is over.
        self.unclear = [("none", i["start_us"], i["end_us"]) for i in labels.get("releases", [])]
        self.unclear += [("none", i["end_us"], i["end_high_us"]) for i in labels["intervals"]]
        self.releases = [("none", i["start_us"], i["end_us"], "release") for i in labels.get("releases", [])]
        self.truth, self.unlabelled, self.motions, self.lift = None, [], [], None
        file = os.path.join(data, name, "truth.json")
        if os.path.exists(file):
            truth = json.load(open(file))
            true = truth["intervals"]
            self.truth = [(i["class"], i["start_us"], i["end_us"]) for i in true if i["labelled"]]
            self.gross = [i["gross_us"] for i in true if i["labelled"]]
            self.unlabelled = [(i["class"], i["start_us"], i["end_us"]) for i in true
                               if not i["labelled"] and i["first_event_us"] is not None]
            names = {"": "unlabelled motion", "firm shear": "firm lift"}
            self.motions = [(i["class"], i["start_us"], i["end_us"], names.get(i.get("what", ""), i.get("what", ""))) for i in true
                            if not i["labelled"] and i["first_event_us"] is not None]
            if not any(i[0] == "slip" for i in self.truth):
                self.lift = truth["lift_start_us"]


def inside(t, interval):
    return interval[1] < t <= interval[2]


def class_at(t, intervals):
    return next((i[0] for i in intervals if inside(t, i)), "none")


def confirm(predicted, k, n):
    verdicts = []
    for i in range(len(predicted)):
        last = predicted[max(0, i - n + 1) : i + 1]
        verdicts.append(next((c for c in CLASSES[1:] if last.count(c) >= k), "none"))
    return verdicts


def detect(t, tick, predicted, interval):
    """(outcome, delay in us, the index at which the episode that ran into the onset begins, or None)"""
    what, start, end = interval
    first_after = (start // tick + 1) * tick
    at = {int(time): k for k, time in enumerate(t)}
    says = lambda time: time in at and predicted[at[time]] == what
    leading = None
    if says(first_after) and says(first_after - tick):
        begin = first_after - tick
        while says(begin - tick):
            begin -= tick
        leading = at[begin]
        if first_after - begin > HEAD_START:
            return "early", None, leading
        if first_after <= min(end, start + WINDOW):
            return "detected", tick, leading
    time = first_after
    while time <= min(end, start + WINDOW):
        if says(time):
            return "detected", time - first_after + tick, leading
        time += tick
    return "missed", None, leading


def quantile_of_all(found, q):
    """Of (interval, detection): one that is not detected is later than all others. The longest limit where the quantile is one of them."""
    times = sorted(d[1] / 1000 if d[0] == "detected" else math.inf for _, d in found)
    value = times[max(1, math.ceil(q * len(times) - 1e-9)) - 1]
    limits = [min(i[2] - i[1], WINDOW) / 1000 for i, d in found if d[0] != "detected"]
    return (max(limits + [time for time in times if not math.isinf(time)]), True) if math.isinf(value) else (value, False)


def episodes_of(predicted):
    begins = [k for k in range(len(predicted)) if predicted[k] != "none" and (k == 0 or predicted[k - 1] != predicted[k])]
    for begin in begins:
        end = begin
        while end < len(predicted) and predicted[end] == predicted[begin]:
            end += 1
        yield predicted[begin], begin, end


def by_two_thresholds(p, on, off, hold, confirmed=math.inf):
    """Verdicts by thresholds on log p / (1 - p), with a hold of so many ticks, and whether each is a confirmed slip."""
    tiny = np.finfo(np.float32).tiny
    odds = {c: [math.log(max(row[k], tiny)) - math.log(max(sum(row) - row[k], tiny)) for row in p] for k, c in ((1, "press"), (2, "slip"))}
    now, below, verdicts, sure, sures = "none", 0, [], False, []
    for press, slip in zip(odds["press"], odds["slip"]):
        best = "slip" if slip > press else "press"
        if now != "none":
            below = below + 1 if (slip if now == "slip" else press) < off else 0
            now = "none" if below >= hold else now
        if best != now and max(press, slip) >= (on if now == "none" else on + (on - off)):
            now, below = best, 0
        verdicts.append(now)
        sure = now == "slip" and (sure or slip >= confirmed)
        sures.append(sure)
    return verdicts if math.isinf(confirmed) else ["slip" if sure else "none" for sure in sures]


def judge(run, tick, predicted, kinds=frozenset(CLASSES)):
    """A whole run, by its truth if it has one, else by its labels. Delays are of touches of these kinds."""
    touches, doubt = (run.truth, []) if run.truth is not None else (run.used, [i for i in run.labels if i not in run.used])
    motions = run.motions if run.truth is not None else run.releases
    met = [(i, detect(run.t, tick, predicted, i)) for i in touches]
    ahead = [(i[0], i[1] - HEAD_START, i[2]) for i in doubt]
    outside = [not any(inside(t, i) for i in touches + ahead) for t in run.t]

    def cause(t):
        going_on = [m for m in motions if inside(t, m)]
        if going_on:
            return max(going_on, key=lambda m: m[1])[3]
        ended = [(m[2], m[3]) for m in motions if t - 100_000 <= m[2] < t] + [(i[2], "after an end") for i in touches + doubt if t - 100_000 <= i[2] < t]
        return max(ended, key=lambda e: e[0])[1] if ended else "quiet"

    alarms, wrong, slips, in_alarm = {}, 0, 0, 0
    for what, begin, end in episodes_of(predicted):
        led = [outcome for _, (outcome, _, leading) in met if leading == begin]
        ticks = [k for k in range(begin, end) if outside[k]]
        in_alarm += tick * len(ticks)
        if "early" in led or ("detected" not in led and outside[begin]):
            count = max(1, -(-tick * len(ticks) // WINDOW))
        else:
            count = tick * len(ticks) // WINDOW
        if count:
            where = cause(run.t[ticks[0] if ticks else begin])
            alarms[where] = alarms.get(where, 0) + count
        wrong += not led and any(i[0] != what and inside(run.t[begin], i) for i in touches)
        if run.lift is not None and what == "slip" and run.t[end - 1] > run.lift and run.t[begin] <= run.lift + 500_000:
            slips += 1
    met, limits = [m for m in met if m[0][0] in kinds], [min(i[2] - i[1], WINDOW) / 1000 for i in touches if i[0] in kinds]
    delays = [d[1] / 1000 if d[0] == "detected" else math.inf for _, d in met]
    gross = []
    for (i, d), start in zip(met, [gross for i, gross in zip(touches, run.gross) if i[0] in kinds] if run.truth is not None else []):
        if i[0] == "slip" and start is not None:
            found = (i[1] // tick) * tick + d[1] if d[0] == "detected" else None
            gross.append(math.inf if found is None else (found - (start // tick) * tick) / 1000)
    return {"gross": gross, "alarms": alarms, "outside": tick * sum(outside), "in_alarm": in_alarm, "wrong": wrong, "delays": delays,
            "missed": sum(d[0] == "missed" for _, d in met), "early": sum(d[0] == "early" for _, d in met),
            "lift": None if run.lift is None else slips, "limits": limits}


def compare_whole_runs(check, name, judged, theirs, wrong_class=True):
    alarms, minutes = sum(sum(r["alarms"].values()) for r in judged), sum(r["outside"] for r in judged) / 60e6
    delays = sorted(delay for r in judged for delay in r["delays"])
    check.same(name + ": alarms", alarms, theirs["alarms"])
    check.same(name + ": minutes", minutes, theirs["outside_min"])
    check.same(name + ": alarms a minute", share(alarms, minutes), theirs["alarms_per_min"]["value"])
    check.same(name + ": in alarm", share(sum(r["in_alarm"] for r in judged) / 60e6, minutes), theirs["in_alarm"])
    check.same(name + ": touches", len(delays), theirs["touches"])
    for key in ("missed", "early"):
        check.same(f"{name}: {key}", sum(r[key] for r in judged), theirs["misses" if key == "missed" else key])
    check.same(name + ": share missed", share(sum(math.isinf(d) for d in delays), len(delays)), theirs["missed"]["value"])
    check.same(name + ": within 50 ms", share(sum(d <= 50 for d in delays), len(delays)), theirs["within_50_ms"]["value"])
    if wrong_class:
        check.same(name + ": wrong class", share(sum(r["wrong"] for r in judged), len(delays)), theirs["wrong_class"]["value"])
    lifts = [r["lift"] for r in judged if r["lift"] is not None]
    check.same(name + ": lifts", len(lifts), theirs["lifts"])
    check.same(name + ": lifts with slip", sum(slips > 0 for slips in lifts), theirs["lifts_with_slip"])
    quantiles = [(0.5, "median_ms", delays), (0.9, "p90_ms", delays)]
    quantiles.append((0.5, "gross_median_ms", sorted(delay for r in judged for delay in r["gross"])))
    for q, key, delays in quantiles:
        if not delays:
            continue
        value = delays[max(1, math.ceil(q * len(delays) - 1e-9)) - 1]
        check.same(f"{name}: {key} is a bound", int(math.isinf(value)), int(theirs[key]["is_lower_bound"]))
        if not math.isinf(value):
            check.same(f"{name}: {key}", value, theirs[key]["value"])


class Comparison:
    def __init__(self):
        self.count, self.wrong = 0, []

    def same(self, name, ours, theirs):
        self.count += 1
        ours = None if ours is None or (isinstance(ours, float) and math.isnan(ours)) else ours
        if (ours is None) != (theirs is None) or (ours is not None and abs(ours - theirs) > 1e-9 * max(1, abs(ours))):
            self.wrong.append(f"{name}: {theirs}; expected {ours}")


def share(part, whole):
    return part / whole if whole else None


def mean(values):
    values = [value for value in values if value is not None]
    return sum(values) / len(values) if values else None


def compare_accuracy(check, name, runs, classes_of, theirs, confusion):
    """classes_of(run) gives (true, predicted) of each balanced sample."""
    objects, counts = {}, np.zeros((3, 3), int)
    for run in runs:
        for true, predicted in classes_of(run):
            objects.setdefault(run.object, []).append(true == predicted)
            counts[CLASSES.index(true)][CLASSES.index(predicted)] += 1
    for which, right in objects.items():
        check.same(f"{name} of {which}", float(np.mean(right)), theirs["objects"][which]["value"])
    check.same(f"objects of {name}", len(objects), len(theirs["objects"]))
    check.same(f"mean {name}", mean([float(np.mean(right)) for right in objects.values()]), theirs["mean"]["value"])
    for i in range(3):
        for j in range(3):
            check.same(f"{name}, {CLASSES[i]} predicted {CLASSES[j]}", int(counts[i][j]), confusion[i][j])
    return counts


def compare_delays(check, name, runs, found, theirs):
    for what in CLASSES[1:]:
        of_runs = [(run.object, [d for i, d in found[k] if i[0] == what]) for k, run in enumerate(runs)]
        for which in [None] + sorted({o for o, d in of_runs if d}):
            entry = theirs[what] if which is None else theirs[what]["objects"][which]
            all_of = [d for o, ds in of_runs if which in (None, o) for d in ds]
            delays = [d[1] / 1000 for d in all_of if d[0] == "detected"]
            where = f"{name} of {what}, {which or 'all'}"
            check.same(where + ": intervals", len(all_of), entry["intervals"])
            check.same(where + ": misses", sum(d[0] == "missed" for d in all_of), entry["misses"])
            check.same(where + ": early", sum(d[0] == "early" for d in all_of), entry["early"])
            check.same(where + ": mean", float(np.mean(delays)) if delays else None, entry["mean"]["value"])
            check.same(where + ": median", float(np.median(delays)) if delays else None, entry["median"]["value"])
            sem = float(np.std(delays, ddof=1) / math.sqrt(len(delays))) if len(delays) > 1 else None
            check.same(where + ": sem", sem, entry["sem"])
            here = [(i, d) for k, run in enumerate(runs) for i, d in found[k] if i[0] == what and which in (None, run.object)]
            if not here:
                continue
            check.same(where + ": share of misses", np.mean([d[0] == "missed" for _, d in here]), entry["missed"]["value"])
            for q, key in ((0.5, "median_of_all"), (0.9, "p90_of_all")):
                value, is_bound = quantile_of_all(here, q)
                check.same(f"{where}: {key}", value, entry[key]["value"])
                check.same(f"{where}: {key} is a bound", int(is_bound), int(entry[key]["is_lower_bound"]))


def compare_cells(check, runs, tick, rows):
    """Right ticks of touches, by the table of cells: in the first 500 ms; of touches longer than 200 ms, in the last 200 and before."""
    rows = {f"{row['object']}/{row['run']}": row for row in rows if not row["threshold"] and row["answer"] == "touch"}
    for run in runs:
        counts = dict.fromkeys(("first_ticks", "first_right", "before_last_ticks", "before_last_right", "last_ticks", "last_right"), 0)
        for t, predicted in zip(run.t, run.predicted):
            touch = next((i for i in (run.truth if run.truth is not None else run.used) if inside(t, i)), None)
            if touch is None:
                continue
            parts = ["first"] if t - touch[1] <= 500_000 else []
            if touch[2] - touch[1] > 200_000:
                parts.append("last" if touch[2] - t < 200_000 else "before_last")
            for part in parts:
                counts[part + "_ticks"] += 1
                counts[part + "_right"] += predicted == touch[0]
        for name, count in counts.items():
            check.same(f"{name} of {run.object}/{run.id}", count, int(rows[f"{run.object}/{run.id}"][name]))


def main():
    theirs = json.load(open(sys.argv[1]))
    runs = [Run(name, sys.argv[2], sys.argv[3]) for name in theirs["test_runs"]]
    tick = round(1000 * theirs["tick_ms"])
    k, n = (int(part) for part in theirs["confirm"].split("/"))
    check = Comparison()

    # What the files say of themselves: verdicts follow from probabilities, labels and truth from the intervals.
    for run in runs:
        likeliest = [CLASSES[int(np.argmax(p))] for p in run.p]
        check.same("verdicts that differ from their probabilities", sum(a != b for a, b in zip(confirm(likeliest, k, n), run.predicted)), 0)
        wrong = sum(class_at(t, run.labels) != label for t, label in zip(run.t, run.label_column))
        check.same("labels that differ", wrong, 0)

    samples = lambda run: [i for i, sample in enumerate(run.sample) if sample]
    compare_accuracy(check, "accuracy", runs, lambda run: [(run.sample[i], run.predicted[i]) for i in samples(run)],
                     theirs["accuracy"], theirs["confusion"])
    confidence = np.concatenate([run.p[samples(run)].max(axis=1) for run in runs if samples(run)])
    right = np.concatenate([[CLASSES[int(np.argmax(run.p[i]))] == run.sample[i] for i in samples(run)] for run in runs if samples(run)])
    edges = np.linspace(0, 1, 16)
    bins = np.clip(np.searchsorted(edges, confidence, side="left") - 1, 0, 14)
    error = sum(abs(right[bins == b].mean() - confidence[bins == b].mean()) * np.mean(bins == b) for b in range(15) if np.any(bins == b))
    check.same("calibration error", float(error), theirs["calibration"]["ece"]["value"])

    sure = [(run.p[k].max(), CLASSES[int(np.argmax(run.p[k]))] == class_at(run.t[k], run.used))
            for run in runs for k in range(len(run.t))
            if class_at(run.t[k], run.used) != "none" or not any(inside(run.t[k], i) for i in run.unclear + run.labels)]
    confidence, right = (np.array(column, float) for column in zip(*sure))
    bins = np.clip(np.searchsorted(edges, confidence, side="left") - 1, 0, 14)
    error = sum(abs(right[bins == b].mean() - confidence[bins == b].mean()) * np.mean(bins == b) for b in range(15) if np.any(bins == b))
    check.same("calibration error of whole runs", float(error), theirs["calibration_whole_runs"]["ece"]["value"])

    found = [[(i, detect(run.t, tick, run.predicted, i)) for i in run.used] for run in runs]
    compare_delays(check, "delay", runs, found, theirs["delay_ms"])

    for always in CLASSES[1:]:
        met = [[(i, detect(run.t, tick, [always] * len(run.t), i)) for i in run.used] for run in runs]
        compare_delays(check, f"delay of always_{always}", runs, met, theirs["trivial"][f"always_{always}"])

    # Every run, whole; those without samples too.
    whole = theirs["whole_runs"]
    runs = [Run(name, sys.argv[2], sys.argv[3]) for name in whole["runs"]]
    check.same("runs judged by the truth", sum(run.truth is not None for run in runs), len(whole["by_truth"]))
    judged = [judge(run, tick, run.predicted) for run in runs]
    compare_whole_runs(check, "whole runs", judged, whole["decided"])
    for name in sorted({run.object for run in runs}):
        compare_whole_runs(check, "whole runs of " + name, [j for run, j in zip(runs, judged) if run.object == name], whole["objects"][name])
    for cause in set(whole["causes"]) | {cause for of_run in judged for cause in of_run["alarms"]}:
        check.same("alarms by " + cause, sum(of_run["alarms"].get(cause, 0) for of_run in judged), whole["causes"].get(cause, 0))
    points = [point for point in whole["curve"] if point["threshold"] in (-2, 0, 1.5, 4)]
    check.same("points of the curve", 4, len(points))
    for point in points:
        of_point = [judge(run, tick, by_two_thresholds(run.p, point["threshold"], point["threshold"] - 4, -(-20_000 // tick))) for run in runs]
        compare_whole_runs(check, f"whole runs at {point['threshold']}", of_point, point)
    with open(sys.argv[1].replace(".json", "-cells.csv"), newline="") as file:
        compare_cells(check, runs, tick, [row for row in csv.DictReader(file) if row["setting"] == theirs["model"]["name"]])
    on, off, hold, confirmed = map(float, (theirs["thresholds"] or "0:0:0:0").split(":"))
    for point in ([whole["confirmed"]] if theirs["thresholds"] else []) + [point for point in whole["confirmed_curve"] if point["threshold"] in (2, 3.5, 8)]:
        sure = confirmed if point["threshold"] is None else point["threshold"]
        of_point = [judge(run, tick, by_two_thresholds(run.p, on, off, -(-round(1000 * hold) // tick), sure), {"slip"}) for run in runs]
        compare_whole_runs(check, f"slips confirmed from {sure} on", of_point, point, wrong_class=False)
    for calm in whole["calm"]:
        few = []
        for point in reversed(whole["curve"]):
            if point["alarms_per_min"]["value"] > calm["at_most_per_min"]:
                break
            few.append(point)
        threshold = few[-1]["threshold"] if few and few[-1]["misses"] + few[-1]["early"] < few[-1]["touches"] else None
        check.same(f"at most {calm['at_most_per_min']} a minute", threshold, calm["point"]["threshold"] if calm["point"] else None)
    runs = [run for run in runs if f"{run.object}/{run.id}" in theirs["test_runs"]]

    true_runs = [run for run in runs if run.truth is not None]
    if true_runs:
        compare_accuracy(check, "accuracy by the truth", true_runs,
                         lambda run: [(class_at(run.t[i], run.truth), run.predicted[i]) for i in samples(run)],
                         theirs["truth"]["accuracy"], theirs["truth"]["confusion"])
        met = [[(i, detect(run.t, tick, run.predicted, i)) for i in run.truth] for run in true_runs]
        compare_delays(check, "delay by the truth", true_runs, met, theirs["truth"]["delay_ms"])
        for run in true_runs:
            wrong = sum(true.replace("unlabelled", "none") != class_at(t, run.truth) for t, true in zip(run.t, run.true))
            check.same("truths that differ", wrong, 0)

    for difference in check.wrong:
        print(difference)
    print(f"{check.count - len(check.wrong)} of {check.count} figures agree")
    return 1 if check.wrong else 0


sys.exit(main())

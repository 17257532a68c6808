"""Writes a study as `tactile reproduce` does, its figures made up by formulas: every part of a report has something to show."""

import json
import math
import os

OBJECTS = ["3d-printed-object", "fan", "plastic-container", "small-box", "sprayer", "textured-box", "uhu-glue-stick", "usb-hub",
           "water-bottle", "white-box"]
HELD_OUT = ["fan", "plastic-container", "small-box", "sprayer", "textured-box"]
HISTORIES = [2, 10, 20, 30, 40, 50]


def figure(value, half=0.01, n=7, top=1.0):
    return {"value": value, "low": value - half, "high": min(top, value + half), "n": n}


def accuracy(history):
    base = {2: 0.84, 10: 0.93, 20: 0.957, 30: 0.961, 40: 0.968, 50: 0.964}[history]
    objects = {name: figure(base + 0.003 * ((3 * i + history) % 7) - 0.008) for i, name in enumerate(OBJECTS)}
    return {"mean": figure(base, 0.006, len(OBJECTS)), "objects": objects}


def delays(scale, objects=OBJECTS):
    def one(i):
        mean = scale * (2 + 0.7 * (i % 5))
        return {"mean": figure(mean, 0.8, 7, 1e9), "median": figure(2.0, 0, 7, 1e9), "sem": 0.3 * scale, "intervals": 7, "misses": i % 4 // 3,
                "early": i % 5 // 4}
    return dict(one(2), objects={name: one(i) for i, name in enumerate(objects)}, intervals=7 * len(objects))


def over_time(begin, end):
    def bins(reverse):
        return [{"from_ms": 50.0 * k, "to_ms": 50.0 * (k + 1), "ticks": 250, "intervals": 10,
                 "accuracy": figure(begin + (end - begin) * (10 - k if reverse else k) / 10, 0.02)} for k in range(10)]
    return {"first": figure(begin), "later": figure(end), "last": figure(end), "before_last": figure(begin),
            "last_minus_before": figure(end - begin, 0.01, 10), "still_predicted": figure(0.4), "intervals": 70, "short_ones": 30,
            "since_onset": bins(False), "before_end": bins(True)}


def evaluation(model, history):
    confusion = [[1010, 12, 5], [25, 990, 12], [8, 31, 988]]
    bins = []
    for k in range(15):
        low, high = k / 15, (k + 1) / 15
        samples = 0 if high < 0.4 else int(2000 * math.exp(-6 * (1 - high)))
        middle = (low + high) / 2
        bins.append({"from": low, "to": high, "samples": samples, "confidence": middle if samples else None,
                     "accuracy": figure(min(1.0, middle * 0.97), 0.03) if samples else {"value": None, "low": None, "high": None, "n": 10}})
    def point(threshold, alarms, ms):
        return {"threshold": threshold, "alarms_per_min": figure(alarms, 0.2, 10, 1e9), "median_ms": figure(ms, 1, 10, 1e9),
                "p90_ms": figure(2.5 * ms, 1, 10, 1e9), "missed": figure(0.002 * ms), "wrong_class": figure(0.01), "outside_min": 20.1,
                "alarms": int(20.1 * alarms), "touches": 160, "misses": 1, "lifts": 10, "lifts_with_slip": 4}
    curve = [point(-4 + k / 2, 200 * math.exp(-k / 4), 3 + k / 3) for k in range(41)]
    whole = {"runs": ["fan/02", "sprayer/02"], "by_truth": ["fan/02", "sprayer/02"], "left_out": [], "units": "objects",
             "decided": point(None, 21, 4), "objects": {o: point(None, 20 + i, 4 + i / 2) for i, o in enumerate(OBJECTS)},
             "causes": {"firm lift": 120, "re-contact": 90, "quiet": 12}, "curve": curve,
             "calm": [{"at_most_per_min": rate, "point": next((p for p in curve if p["alarms_per_min"]["value"] <= rate), None)}
                      for rate in (20, 6, 2, 0.6)]}
    result = accuracy(history)
    return {
        "title": "Evaluation (simulated runs)", "simulated": True, "tick_ms": 2.0, "confirm": "1/1",
        "model": {"name": model, "settings": {"rendering": {"history_us": 1000 * history}}},
        "accuracy": result, "confusion": confusion,
        "accuracy_by_guard": [{"guard_ms": 100.0, **result}, {"guard_ms": 0.0, **accuracy(20)}],
        "baselines": {name: {"accuracy": figure(value), "objects": {o: figure(value) for o in OBJECTS}}
                      for name, value in (("majority", 1 / 3), ("event_count", 0.75), ("logistic_moments", 0.86))},
        "per_class": {touch: {"precision": figure(0.97), "recall": figure(0.96), "f1": figure(0.965)} for touch in ("none", "press", "slip")},
        "calibration": {"ece": figure(0.021), "bins": bins},
        "delay_ms": {"press": delays(0.9), "slip": delays(1.1)},
        "delay_true_ms": {"press": delays(1.0), "slip": delays(1.3)}, "delay_gross_ms": {"slip": delays(-2.0)},
        "false_alarms_per_min": figure(21, 0.4, 10, 1e9), "whole_runs": whole,
        "trivial": {name: {"delay_ms": {"press": delays(0.5), "slip": delays(9)}} for name in ("always_press", "always_slip", "random")},
        "over_time": {"press": over_time(0.97, 0.7), "slip": over_time(0.98, 0.85), "both": over_time(0.975, 0.78)},
    }


def run_over_time():
    rows = ["t_us,p_none,p_press,p_slip,verdict,label,truth,events,sample"]
    for k in range(1500):
        press, slip = 300 < k <= 520, 800 < k <= 1200
        p_press = 0.95 if press and k < 500 else 0.02
        p_slip = 0.97 if slip else 0.01
        predicted = "press" if p_press > 0.5 else "slip" if p_slip > 0.5 else "none"
        label = "press" if press else "slip" if slip else "none"
        truth = label if label != "none" else "unlabelled" if 600 < k <= 640 else "none"
        label = "slip" if 1300 < k <= 1400 else label  # that is not true
        rows.append(f"{1700000000000000 + 2000 * k},{1 - p_press - p_slip:.3f},{p_press},{p_slip},{predicted},{label},{truth},"
                    f"{400 + (2500 if label != 'none' else 0) + 7 * (k % 13)},")
    return "\n".join(rows) + "\n"


def unseen():
    objects = {}
    for i, name in enumerate(HELD_OUT):
        loss = 0.19 if name == "plastic-container" else 0.012 + 0.004 * i
        objects[name] = {"seen": figure(0.97), "held_out": figure(0.97 - loss, 0.02), "difference": figure(-loss, 0.015)}
    mean = {"seen": figure(0.97, 0.01, 5), "held_out": figure(0.92, 0.03, 5), "difference": figure(-0.05, 0.03, 5)}
    return {"runs": [f"{name}/04" for name in HELD_OUT], "mean": mean, "objects": objects}


def claim(name, words, paper, unit, asked, limit, value, half, outcome, note="", objects=None):
    side = {"measured": figure(value, half, 10, 1e9), "verdict": outcome, "objects": objects or {}, "note": note,
            "in_words": "The claim is true for 7 of 10 objects; the lowest is white-box.", "kept": 7, "of": 10, "can_be_decided": True,
            "why": "the interval lies across the limit" if outcome == "cannot tell" else ""}
    return {"id": name, "claim": words, "paper": paper, "unit": unit, "asked": asked, "limit": limit, **side, "all_test": side}


def write_study(folder, mark=""):
    """`mark` goes into every name that a person or a file could have chosen."""
    def put(path, text):
        path = os.path.join(folder, path)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "w", encoding="utf-8") as file:
            file.write(text if isinstance(text, str) else json.dumps(text, indent=1))

    histories = []
    for history in HISTORIES:
        name = f"th{history:03d}-single-run-01-s1{mark}"
        put(f"models/th{history:03d}/history.csv",
            "epoch,loss,accuracy,validation_loss,validation_accuracy,learning_rate,gradient_norm,images_per_s,seconds\n" +
            "".join(f"{e},{0.5 * 0.6 ** e + 0.01 * (60 - history) / 60:.6f},{1 - 0.2 * 0.55 ** e - 0.0005 * (50 - history):.6f},,,0.001,1,400,9\n"
                    for e in range(1, 11)))
        histories.append({"th_ms": history,
                          "models": [{"seed": 1, "name": name, "folder": f"models/th{history:03d}", "history": f"models/th{history:03d}/history.csv",
                                      "weights_sha256": "ab" * 32, "accuracy": figure(0.96)}],
                          "accuracy": {"choice": accuracy(history), "reported": accuracy(history), "all_test": accuracy(history)}})
    model = f"th040-single-run-01-s1{mark}"
    for name in ("reported", "all_test"):
        put(f"evaluations/{name}.json", evaluation(model, 40))
    put("runs/water-bottle-04.csv", run_over_time())
    start = 1700000000000000
    put("runs/water-bottle-04.json", {
        "run": f"water-bottle/04{mark}", "simulated": True, "tick_ms": 2.0, "confirm": "1/1",
        "intervals": [{"class": "press", "start_us": start + 600000, "end_us": start + 1040000, "outcome": "detected", "delay_ms": 2.0},
                      {"class": "slip", "start_us": start + 1600000, "end_us": start + 2400000, "outcome": "missed", "delay_ms": None},
                      {"class": "slip", "start_us": start + 2600000, "end_us": start + 2800000, "outcome": "detected", "delay_ms": 2.0}],
        "true_intervals": [{"class": "press", "start_us": start + 600000, "end_us": start + 1040000, "outcome": "detected", "delay_ms": 4.0},
                           {"class": "slip", "start_us": start + 1600000, "end_us": start + 2400000, "outcome": "missed", "delay_ms": None}],
        "whole_run": {"by_truth": True, "outside_s": 4.2, "in_alarm_s": 0.1, "alarms": {"release": 3, "quiet": 1}, "wrong_class": 0}})
    put("models/unseen/history.csv", "epoch,loss,accuracy\n1,0.4,0.85\n2,0.1,0.97\n")
    put("models/th040/model.json", {"training": {"batch": 32, "optimizer": "adam" + mark, "from": None}, "rendering": {"denoise": "mean"},
                                    "network": {"name": "lenet-5", "input": {"width": 128}, "layers": ["conv 6@5x5", "relu"]}})
    held_out_model = {"seed": 1, "name": f"th040-unseen-01-s1{mark}", "folder": "models/unseen", "history": "models/unseen/history.csv",
                      "weights_sha256": "ab" * 32}
    best = {"objects": {name: 40 if i % 2 else 50 for i, name in enumerate(OBJECTS)}, "counts": {"40": 5, "50": 5}, "th_ms": 40}
    names = [f"{name}/{run:02d}" for name in OBJECTS for run in range(4, 11)]
    put("study.json", {
        "format": "tactile-study-1", "title": f"The paper's study on simulated runs{mark}", "simulated": True,
        "settings": {"data": "data", "models": "models", "preset": "paper", "seed": 1, "trainings": 1, "train_run": "01",
                     "histories_ms": HISTORIES, "epochs": 10, "splits": 2, "objects": None, "runs": None},
        "software": {"name": "tactile", "version": "0.1.0", "revision": "0123456789ab", "libtorch": "1.13.1"},
        "machine": {"cpu": f"A processor{mark}", "system": "Debian GNU/Linux 12 (bookworm)", "cores": 2, "memory_bytes": 25769803776, "threads": 2},
        "bootstrap": {"draws": 2000, "confidence": 0.95, "seed": 1, "trainings": "One training each."},
        "left_out": [{"run": f"usb-hub/02{mark}", "what": "run", "reason": "no samples: it lacks press"}],
        "steps": [{"name": f"train-th{h:03d}{mark}", "command": f"tactile train data --th {h}", "seconds": 90.0 + h, "finished_at": "2026-01-02T03:04:05Z"}
                  for h in HISTORIES] + [{"name": "report", "command": None, "seconds": 12.5, "finished_at": "2026-01-02T04:04:05Z"}],
        "dataset": {"file": "data/dataset.h5", "manifest_hash": "cd" * 32, "samples": 61234, "tick_ms": 2.0, "guard_ms": 100.0},
        "trainings": [{"seed": 1, "train_run": "01", "th_ms": 40, "runs": {
            "train": [f"{name}/01" for name in OBJECTS], "choice": [f"{name}/02" for name in OBJECTS], "reported": names, "all_test": names}}],
        "histories": histories,
        "variance": {"training": 0.48, "object": 0.45, "run": 0.07},
        "choice": {"th_ms": 40, "model": model, "chosen_on": "choice", "why": "It is the best for most objects.",
                   "best": {"choice": best, "reported": best, "all_test": best}},
        "paper_way": {"th_ms": 40, "model": model, "why": "Chosen on the test runs."},
        "evaluations": [{"id": name, "th_ms": 40, "seed": 1, "model": model, "runs": name, "json": f"evaluations/{name}.json",
                         "csv": f"evaluations/{name}.csv"} for name in ("reported", "all_test")],
        "full_runs": [{"run": f"water-bottle/04{mark}", "model": model, "th_ms": 40, "csv": "runs/water-bottle-04.csv"}],
        "unseen": {"th_ms": 40, "held_out": HELD_OUT, "models": {"seen": model, "held_out": f"th040-unseen-01-s1{mark}"},
                   "trainings": [held_out_model],
                   "reported": unseen(), "all_test": unseen()},
        "splits": [{"name": f"split-00{k}", "held_out": HELD_OUT, "model": model, "reported": unseen(), "all_test": unseen()} for k in (1, 2)],
        "splits_mean": {"reported": figure(-0.04), "all_test": figure(-0.04)},
        "claims": [
            claim("history-2-worst", f"A history of 2 ms is the worst for every object{mark}.", "worst for all ten", "points", "below", 0, -3.1, 1.2, "holds"),
            claim("accuracy-at-40", "At 40 ms every object is above 95 %.", "above 95 %", "%", "above", 95, 93.5, 1.1, "does not",
                  objects={name: figure(96 - i, 1.0, 7, 100) for i, name in enumerate(OBJECTS)}),
            claim("slip-delay", "The mean delay of slip is below 5 ms for every object.", "below 5 ms", "ms", "below", 5, 4.2, 1.5, "cannot tell",
                  "Of white-box one was missed."),
        ],
        "summary": "On simulated runs 1 of the paper's 3 claims holds, 1 does not, and of 1 one cannot tell.",
    })
    return folder

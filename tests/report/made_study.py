"""Writes a study as `tactile reproduce` does, and a model with its evaluation.

Figures are made up by formulas: every part of a report has something to show.
"""

import json
import math
import os

OBJECTS = ["3d-printed-object", "fan", "plastic-container", "small-box", "sprayer", "textured-box", "uhu-glue-stick", "usb-hub",
           "water-bottle", "white-box"]
HELD_OUT = ["fan", "plastic-container", "small-box", "sprayer", "textured-box"]
HISTORIES = [2, 10, 20, 30, 40, 50]
WORLDS = ["501", "502", "503"]
START_US = 1700000000000000


def figure(value, half=0.01, n=7, top=1.0, trainings=1):
    return {"value": value, "low": value - half, "high": min(top, value + half), "n": n, "trainings": trainings}


def unknown(n=0):
    return {"value": None, "low": None, "high": None, "n": n, "trainings": 1}


def quantile(ms, half=1.0, is_lower_bound=False):
    return dict(figure(ms, half, len(WORLDS), 1e9), is_lower_bound=is_lower_bound)


def accuracy(base, objects=OBJECTS, shift=0):
    of_objects = {name: figure(base + 0.003 * ((3 * i + shift) % 7) - 0.008) for i, name in enumerate(objects)}
    return {"mean": figure(base, 0.006, len(objects)), "objects": of_objects}


def accuracy_of(history):
    return accuracy({2: 0.84, 10: 0.93, 20: 0.957, 30: 0.961, 40: 0.968, 50: 0.964}[history], shift=history)


def delays(scale):
    def one(i):
        mean = scale * (2 + 0.7 * (i % 5))
        return {"mean": figure(mean, 0.8, 7, 1e9), "sem": 0.3 * scale, "median": figure(2.0, 0, 7, 1e9), "intervals": 7,
                "misses": i % 4 // 3, "early": i % 5 // 4, "missed": figure(0.01 * (i % 4)), "median_of_all": quantile(mean),
                "p90_of_all": quantile(400.0, 20, i % 4 == 3)}
    return dict(one(2), objects={name: one(i) for i, name in enumerate(OBJECTS)}, intervals=7 * len(OBJECTS))


def operating_point(threshold, alarms, ms):
    return {"threshold": threshold, "alarms_per_min": figure(alarms, 0.2, len(WORLDS), 1e9), "alarms": int(20.1 * alarms),
            "outside_min": 20.1, "in_alarm": 0.03, "median_ms": quantile(ms), "p90_ms": quantile(2.5 * ms, 1, ms > 15),
            "press_median_ms": quantile(ms), "press_p90_ms": quantile(2 * ms), "slip_median_ms": quantile(ms + 1),
            "slip_p90_ms": quantile(3 * ms), "gross_median_ms": quantile(ms - 90), "within_50_ms": figure(0.97),
            "missed": figure(0.002 * ms), "touches": 160, "misses": 1, "early": 2, "wrong_class": figure(0.01),
            "wrong_classes": 2,
            "false_slips": figure(0.4, 0.2), "lifts": 10, "lifts_with_slip": 4}


def whole_runs(names, slower=0.0, mark=""):
    curve = [operating_point(-4 + k / 2, 200 * math.exp(-k / 4), 3 + k / 3 + slower) for k in range(41)]
    decided = operating_point(None, 21, 4 + slower)
    return {"runs": names, "by_truth": names, "left_out": [{"run": f"world 501, fan/09{mark}", "why": "it has no labels"}],
            "units": "worlds", "decided": decided,
            "objects": {name: operating_point(None, 20 + i, 4 + i / 2 + slower) for i, name in enumerate(OBJECTS)},
            "causes": {f"firm lift{mark}": 120, "re-contact": 90, "quiet": 12}, "curve": curve,
            "calm": [{"at_most_per_min": rate, "point": next((p for p in curve if p["alarms_per_min"]["value"] <= rate), None)}
                     for rate in (20, 6, 2, 0.6, 0.001)],
            "confirmed": operating_point(None, 0.5, 90),
            "confirmed_curve": [operating_point(k / 2, 4 - k / 2, 40 + 5 * k) for k in range(8)]}


def unseen(base):
    objects = {}
    for i, name in enumerate(HELD_OUT):
        loss = 0.19 if name == "plastic-container" else 0.012 + 0.004 * i
        objects[name] = {"seen": figure(base), "held_out": figure(base - loss, 0.02), "difference": figure(-loss, 0.015)}
    mean = {"seen": figure(base, 0.01, 5), "held_out": figure(base - 0.05, 0.03, 5), "difference": figure(-0.05, 0.03, 5)}
    return {"models": None, "runs": [f"{name}/04" for name in HELD_OUT], "mean": mean, "objects": objects}


def reliability():
    bins = []
    for k in range(15):
        low, high = k / 15, (k + 1) / 15
        samples = 0 if high < 0.4 else int(2000 * math.exp(-6 * (1 - high)))
        middle = (low + high) / 2
        bins.append({"from": low, "to": high, "samples": samples, "confidence": middle if samples else None,
                     "accuracy": figure(min(1.0, middle * 0.97), 0.03) if samples else unknown(10)})
    return {"ece": figure(0.021), "objects": {}, "bins": bins}


def evaluation(name, mark=""):
    """eval.json of a LeNet."""
    confusion = [[1010, 12, 5], [25, 990, 12], [8, 31, 988]]
    model = {"name": name, "settings": {"rendering": {"history_us": 40000}}, "weights_sha256": "ab" * 32}
    runs = [f"{name}/{run:02d}{mark}" for name in OBJECTS for run in range(2, 4)]
    return {
        "title": f"Evaluation of {name} on simulated runs", "model": model, "trainings": [{**model, "test_runs": runs}],
        "test_runs": runs, "dataset": {"file": "data/dataset.h5", "manifest_hash": "cd" * 32}, "simulated": True,
        "sampling_guard_ms": 100.0, "tick_ms": 2.0, "confirm": "1/1", "thresholds": "",
        "bootstrap": {"draws": 2000, "confidence": 0.95, "seed": 1},
        "engine": {"name": "fast", "ticks": 90000, "close_ticks": 1},
        "accuracy": accuracy_of(40), "confusion": confusion, "calibration": reliability(),
        "calibration_whole_runs": {"ece": figure(0.043), "objects": {}, "bins": []},
        "baselines": {by: {key: whole_runs(runs)[key] for key in ("decided", "calm")}
                      for by in ("event_rate", "cusum", "features")},
        "delay_ms": {"press": delays(0.9), "slip": delays(1.1)},
        "trivial": {name: {"press": delays(0.5), "slip": delays(9)} for name in ("always_press", "always_slip", "random")},
        "whole_runs": whole_runs(runs, mark=mark),
        "truth": {"accuracy": accuracy_of(20), "confusion": confusion, "delay_ms": {"press": delays(1.0), "slip": delays(1.3)}},
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
        rows.append(f"{START_US + 2000 * k},{1 - p_press - p_slip:.3f},{p_press},{p_slip},{predicted},{label},{truth},"
                    f"{400 + (2500 if label != 'none' else 0) + 7 * (k % 13)},")
    return "\n".join(rows) + "\n"


def detection(touch, begin_ms, end_ms, delay_ms):
    return {"class": touch, "start_us": START_US + 1000 * begin_ms, "end_us": START_US + 1000 * end_ms, "delay_ms": delay_ms,
            "outcome": "missed" if delay_ms is None else "detected"}


def outcome(run):
    press, slip = ("press", 600, 1040), ("slip", 1600, 2400)
    return {"run": run, "simulated": True, "tick_ms": 2.0, "confirm": "1/1",
            "intervals": [detection(*press, 2.0), detection(*slip, None), detection("slip", 2600, 2800, 2.0)],
            "true_intervals": [detection(*press, 4.0), detection(*slip, None)],
            "whole_run": {"by_truth": True, "outside_s": 4.2, "in_alarm_s": 0.1, "alarms": {"release": 3, "quiet": 1},
                          "wrong_class": 0}}


def history_csv(history):
    rows = "epoch,loss,accuracy,validation_loss,validation_accuracy,learning_rate,gradient_norm,images_per_s,seconds\n"
    for e in range(1, 11):
        loss, right = 0.5 * 0.6 ** e + 0.01 * (60 - history) / 60, 1 - 0.2 * 0.55 ** e - 0.0005 * (50 - history)
        rows += f"{e},{loss:.6f},{right:.6f},,,0.001,1,400,9\n"
    return rows


def claim(name, paper, measure, unit, limit, is_below, written, measured, outcome, is_by_margin=False):
    return {"id": name, "figure": "8", "paper": paper, "measure": measure, "unit": unit, "is_below": is_below, "limit": limit,
            "is_by_margin": is_by_margin, "written": written, "replicates": 0 if measured["value"] is None else 8,
            "measured": measured, "outcome": outcome}


def claims(mark=""):
    return [
        claim("history-2-worst", f"Instantaneous heatmaps (2 ms) are worst for all ten objects{mark}.",
              "the number of objects for which another history is worse than 2 ms", "objects", 1, True, 8, figure(0.1, 0.1),
              "holds"),
        claim("accuracy-at-40", "The average accuracy of the nine test runs exceeds 95 % for all ten objects.",
              "the lowest accuracy of an object at 40 ms", "%", 95, False, 1, figure(93.5, 1.1, 8, 100), "does not"),
        claim("marginal-past-20", "Improvements become marginal after 20 ms.",
              "the highest mean accuracy past 20 ms, less that at 20 ms,", "points", 1, True, 5, figure(1.1, 0.4, 8, 100),
              "cannot tell", True),
        claim("slip-delay", "The average delay is below 5 ms for press and slip and for all ten objects.",
              "the mean delay of detected slips of the slowest object", "ms", 5, True, 0, unknown(), "cannot tell"),
    ]


def settings():
    """The settings of a study, in the order of its results: name, text, whether its objects were held out, t_h, accuracy."""
    all_settings = [(f"th{h:03d}", f"LeNet, t_h {h} ms", False, float(h), accuracy_of(h)) for h in HISTORIES]
    all_settings.append(("stream", "stream", False, None, accuracy(0.98)))
    all_settings.append(("th040-unseen", "LeNet, t_h 40 ms, objects never seen", True, 40.0, accuracy(0.92, HELD_OUT)))
    all_settings.append(("stream-unseen", "stream, objects never seen", True, None, accuracy(0.94, HELD_OUT)))
    return all_settings


def results(mark=""):
    whole = {"stream": 0, "stream-unseen": 2, "th040": 4, "th040-unseen": 8}  # and how much slower each is [ms]
    names = [f"{world}/{name}/{run:02d}" for world in WORLDS for name in OBJECTS for run in range(2, 11)]
    return [{"setting": name, "text": text, "is_unseen": is_unseen, "th_ms": th_ms, "accuracy": found,
             "whole_runs": whole_runs(names, whole[name], mark) if name in whole else {"runs": []}}
            for name, text, is_unseen, th_ms, found in settings()]


def models(mark=""):
    """One of each setting and world."""
    return [{"world": k, "training": 0, "setting": setting[0], "name": f"{setting[0]}-01-s{world}{mark}",
             "folder": f"models/{setting[0]}-{world}", "history": f"models/{setting[0]}-{world}/history.csv", "train_run": "01",
             "seed": int(world), "weights_sha256": "ab" * 32}
            for k, world in enumerate(WORLDS) for setting in settings()]


def steps(mark=""):
    done = [{"name": f"train-{model['name']}", "command": f"tactile train data --th 40{mark}", "seconds": 90.0 + k,
             "finished_at": "2026-01-02T03:04:05Z"} for k, model in enumerate(models(mark))]
    return done + [{"name": "report", "command": None, "seconds": 12.5, "finished_at": "2026-01-02T04:04:05Z"}]


def study_json(mark=""):
    """`mark` goes into every name that a person or a file could have chosen."""
    runs = [("th040", 40.0, "water-bottle/04"), ("stream", 2.0, "water-bottle/04"), ("stream", 2.0, "fan/05")]
    return {
        "format": "tactile-study-2", "title": f"The paper's study on simulated runs (paper){mark}", "simulated": True,
        "settings": {"data": "data", "models": "models", "preset": "paper", "seed": 501, "worlds": len(WORLDS), "trainings": 1,
                     "train_run": "01", "histories_ms": HISTORIES, "epochs": 10, "steps": 1600, "engine": "fast",
                     "include_flagged": False, "tick_ms": 2.0, "guard_ms": 100.0, "objects": None, "runs": None},
        "software": {"name": "tactile", "version": "0.1.0", "revision": "0123456789ab"},
        "machine": {"cpu": f"A processor{mark}", "system": "Debian GNU/Linux 12", "cores": 2, "memory_bytes": 2 ** 34},
        "bootstrap": {"draws": 2000, "confidence": 0.95, "seed": 1},
        "intervals": "3 worlds, each with objects and a sensor of its own, and one training of each setting in each.",
        "steps": steps(mark),
        "worlds": [{"name": world, "data": f"data/{world}", "manifest_hash": "cd" * 32, "runs": 98, "samples": 61234,
                    "held_out": HELD_OUT,
                    "left_out": [{"run": f"usb-hub/02{mark}", "what": "run", "reason": "no samples: it lacks press"}]}
                   for world in WORLDS],
        "models": models(mark), "cells": "cells.csv", "results": results(mark),
        "unseen": [{"setting": "th040", "text": "LeNet, t_h 40 ms", "accuracy": unseen(0.968)},
                   {"setting": "stream", "text": "stream", "accuracy": unseen(0.98)}],
        "full_runs": [{"run": run + mark, "model": f"{setting}-01-s501{mark}", "th_ms": th_ms,
                       "csv": f"runs/{setting}/{run.replace('/', '-')}.csv"} for setting, th_ms, run in runs],
        "claims": claims(mark),
        "found": ["stream, on 270 whole runs of all kinds: 21.0 false alarms a minute.",
                  "Of the paper's 4 sentences 1 would usually be written, 1 seldom; of 2 this study cannot tell."],
        "remarks": [f"world 502, usb-hub{mark} learned from run 02 instead of 01"],
    }


class Folder:
    def __init__(self, path):
        self.path = path

    def put(self, name, content):
        path = os.path.join(self.path, name)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "w", encoding="utf-8") as file:
            file.write(content if isinstance(content, str) else json.dumps(content, indent=1))


def write_study(folder, mark=""):
    study = study_json(mark)
    made = Folder(folder)
    for model in study["models"]:
        made.put(model["history"], history_csv(int(model["setting"][2:5]) if model["setting"].startswith("th") else 45))
    for run in study["full_runs"]:
        made.put(run["csv"], run_over_time())
        made.put(run["csv"].replace(".csv", ".json"), outcome(run["run"]))
    made.put("study.json", study)
    return folder


def write_model(folder, mark=""):
    """A LeNet with all that `tactile eval` writes. Its folder is its name."""
    made = Folder(folder)
    made.put("model.json", {"dataset": {"file": f"data{mark}/dataset.h5", "manifest_hash": "cd" * 32, "simulated": True},
                            "rendering": {"history_us": 40000, "denoise": "mean"}, "split": {"kind": "single-run"},
                            "training": {"batch": 32, "optimizer": "adam" + mark}, "trained_at": "2026-01-02T03:04:05Z",
                            "network": {"name": "lenet-5", "input": {"width": 128}, "layers": ["conv 6@5x5", "relu"]},
                            "train_runs": [f"{name}/01" for name in OBJECTS], "samples": 5012, "weights_sha256": "ab" * 32})
    made.put("history.csv", history_csv(40))
    made.put("eval.json", evaluation(os.path.basename(folder) + mark, mark))
    made.put("eval-unseen.json", {"unseen": dict(unseen(0.968), models={"seen": f"m{mark}", "held_out": f"u{mark}"})})
    made.put("runs/water-bottle-04.csv", run_over_time())
    made.put("runs/water-bottle-04.json", outcome(f"water-bottle/04{mark}"))
    return folder

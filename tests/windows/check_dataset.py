#!/usr/bin/env python3
"""Checks a dataset against the run folders that it was made from, in plain h5py and NumPy.

    check_dataset.py DATASET RUNS EVENTS

RUNS is the folder of runs; EVENTS holds the events of each run as EVENTS/<object>-<run>.npz, as `tactile convert` writes them. Written from
the definition of samples alone, tick by tick and event by event, with nothing of tactile's own code. Ends with 1 and a line for each fault.
"""

import hashlib
import itertools
import json
import os
import sys

import h5py
import numpy as np

NONE, PRESS, SLIP = 0, 1, 2
faults = []


def expect(holds, what):
    if not holds:
        faults.append(what)


def sha256(path):
    with open(path, "rb") as file:
        return hashlib.sha256(file.read()).hexdigest()


def touches_sha256(path):
    labels = json.load(open(path, encoding="utf-8"))
    flagged = {flag["interval"] for flag in labels["flags"] if not flag["confirmed"]}
    times = ("start_us", "start_low_us", "start_high_us", "end_us", "end_low_us", "end_high_us")
    touches = {"flagged": None in flagged,
               "intervals": [[i["class"], *(i[t] for t in times), n in flagged] for n, i in enumerate(labels["intervals"])],
               "releases": [[r["start_us"], r["end_us"]] for r in labels["releases"]]}
    return hashlib.sha256(json.dumps(touches, sort_keys=True, separators=(",", ":")).encode()).hexdigest()


def plain_filters(name, table):
    """Whatever every HDF5 comes with: no plug-in is wanted."""
    if isinstance(table, h5py.Dataset):
        settings = table.id.get_create_plist()
        filters = {settings.get_filter(i)[0] for i in range(settings.get_nfilters())}
        expect(filters <= {h5py.h5z.FILTER_DEFLATE, h5py.h5z.FILTER_FLETCHER32, h5py.h5z.FILTER_SHUFFLE}, f"{name}: filters {filters}")


def labels_of(folder, include_flagged):
    """Intervals as (class, start, end, used), and whether the run is left out whole."""
    labels = json.load(open(os.path.join(folder, "labels.json"), encoding="utf-8"))
    flags = [] if include_flagged else [f for f in labels["flags"] if not f["confirmed"]]
    flagged = {f["interval"] for f in flags}
    intervals = [({"press": PRESS, "slip": SLIP}[i["class"]], i["start_us"], i["end_us"], n not in flagged)
                 for n, i in enumerate(labels["intervals"])]
    return intervals, None in flagged


def ticks_of(intervals, t, sampling):
    """Every tick of the run that a sample may lie at, by class."""
    tick, guard, history, window = (sampling[k] for k in ("tick_us", "guard_us", "history_us", "window_us"))
    first = -((-(int(t[0]) + history)) // tick) * tick
    ticks = np.arange(first, int(t[-1]) + 1, tick, dtype=np.int64)
    free = np.ones(len(ticks), bool)
    of_class = {NONE: None, PRESS: np.zeros(len(ticks), bool), SLIP: np.zeros(len(ticks), bool)}
    for kind, start, end, used in intervals:
        free &= (ticks <= start - guard) | (ticks > end + guard)
        if used:
            of_class[kind] |= (start < ticks) & (ticks <= min(end, start + window))
    of_class[NONE] = free
    return {kind: set(ticks[is_in].tolist()) for kind, is_in in of_class.items()}


def check_run(f, index, name, runs, events_folder, settings):
    folder = os.path.join(runs, name)
    expect(f["/runs/events_sha256"].asstr()[index] == sha256(os.path.join(folder, "events.aedat4")), f"{name}: hash of its events")
    expect(f["/runs/labels_sha256"].asstr()[index] == touches_sha256(os.path.join(folder, "labels.json")), f"{name}: hash of its labels")
    expect(os.path.samefile(os.path.join(os.path.dirname(f.filename), f["/runs/folder"].asstr()[index]), folder), f"{name}: its folder")
    sampling = settings["sampling"]
    intervals, left_out = labels_of(folder, settings["include_flagged"])
    expect(not left_out, f"{name}: is flagged, and in the dataset")

    rows = np.flatnonzero(f["/intervals/run"][:] == index)
    stored = list(zip(*(f["/intervals/" + c][:][rows].tolist() for c in ("class", "start_us", "end_us"))))
    expect(stored == [i[:3] for i in intervals if i[3]], f"{name}: its intervals")

    recorded = np.load(os.path.join(events_folder, name.replace("/", "-") + ".npz"))["events"]
    offered = ticks_of(intervals, recorded["t_us"], sampling)
    rows = np.flatnonzero(f["/samples/run"][:] == index)
    times, classes = f["/samples/t_us"][:][rows], f["/samples/label"][:][rows]
    expect((np.diff(times) > 0).all(), f"{name}: its samples are not in order of time, each tick once")
    smallest = min(len(ticks) for ticks in offered.values())
    for kind, ticks in offered.items():
        drawn = times[classes == kind].tolist()
        expect(len(drawn) == smallest, f"{name}: {len(drawn)} samples of class {kind}, the scarcest class offers {smallest}")
        expect(set(drawn) <= ticks, f"{name}: samples of class {kind} at {sorted(set(drawn) - ticks)[:5]}")

    # The union of the windows, event by event: +1 where a window begins, -1 where it ends.
    t = recorded["t_us"]
    depth = np.zeros(len(t) + 1, np.int64)
    np.add.at(depth, np.searchsorted(t, times - sampling["history_us"]), 1)
    np.add.at(depth, np.searchsorted(t, times), -1)
    kept = recorded[np.cumsum(depth)[:-1] > 0]
    first, count = int(f["/runs/first_event"][index]), int(f["/runs/events"][index])
    expect(count == len(kept), f"{name}: {count} events stored, its windows hold {len(kept)}")
    for column in ("t_us", "x", "y", "on"):
        same = np.array_equal(f["/events/" + column][first:first + count], kept[column])
        expect(same, f"{name}: /events/{column} is not what its windows hold")
    return smallest


def check_splits(f, names):
    """No event of a window of one run is one of another run, except for a few that are equal by chance; so no split by run shares events."""
    kind = np.dtype([("t", "<i8"), ("x", "<u2"), ("y", "<u2"), ("on", "u1")])
    events = []
    for index in range(len(names)):
        rows = slice(int(f["/runs/first_event"][index]), int(f["/runs/first_event"][index] + f["/runs/events"][index]))
        of_run = np.empty(rows.stop - rows.start, kind)
        for field, column in (("t", "t_us"), ("x", "x"), ("y", "y"), ("on", "on")):
            of_run[field] = f["/events/" + column][rows]
        events.append(np.unique(of_run))
    for a, b in itertools.combinations(range(len(names)), 2):
        shared = len(np.intersect1d(events[a], events[b], assume_unique=True))
        expect(shared <= 0.01 * min(len(events[a]), len(events[b])), f"{names[a]} and {names[b]} share {shared} events")


def main():
    dataset, runs, events_folder = sys.argv[1:]
    f = h5py.File(dataset, "r")
    settings = json.loads(f.attrs["settings"])
    for group in ("events", "runs", "intervals", "samples", "heatmaps"):
        f[group].visititems(plain_filters)
        expect(group != "events" or f.get(group, getlink=True).filename == "dataset.events.h5", "/events is no link to its own file")

    names = [f"{o}/{r}" for o, r in zip(f["/runs/object"].asstr(), f["/runs/run"].asstr())]
    expect(names == sorted(names), "runs are not in order")
    manifest = dict(settings, format=int(f.attrs["format"]), simulated=bool(f.attrs["simulated"]),
                    sensor={"width": int(f.attrs["sensor_width"]), "height": int(f.attrs["sensor_height"])},
                    runs=[dict(zip(("object", "run", "events_sha256", "labels_sha256"), row)) for row in zip(
                        *(f["/runs/" + c].asstr()[:].tolist() for c in ("object", "run", "events_sha256", "labels_sha256")))])
    text = json.dumps(manifest, sort_keys=True, separators=(",", ":"), ensure_ascii=False)
    expect(hashlib.sha256(text.encode()).hexdigest() == f.attrs["manifest_sha256"].decode(), "the manifest's hash")

    for folder in sorted(os.listdir(runs)):
        for run in sorted(os.listdir(os.path.join(runs, folder))) if os.path.isdir(os.path.join(runs, folder)) else []:
            labelled = os.path.exists(os.path.join(runs, folder, run, "labels.json"))
            usable = labelled and not labels_of(os.path.join(runs, folder, run), settings["include_flagged"])[1]
            expect(usable == (f"{folder}/{run}" in names), f"{folder}/{run}: usable {usable}, but not so in the dataset")

    smallest = [check_run(f, index, name, runs, events_folder, settings) for index, name in enumerate(names)]
    expect((np.diff(f["/samples/run"][:].astype(np.int64)) >= 0).all(), "samples are not in order of run")
    expect(len(f["/samples/run"]) == 3 * sum(smallest), "samples of no run")
    ends = np.cumsum(f["/runs/events"][:])
    expect((f["/runs/first_event"][:] == ends - f["/runs/events"][:]).all(), "slices of /events do not lie end to end")
    expect(f["/events/t_us"].shape == (ends[-1],), "/events is not as long as the runs' slices")
    check_splits(f, names)
    for fault in faults:
        print(fault)
    print(f"{len(names)} runs, {len(f['/samples/run'])} samples, {ends[-1]} events: {'faults' if faults else 'all as defined'}")
    return 1 if faults else 0


sys.exit(main())

"""Writes the tables of docs/simulation.md and docs/simulation/*.md from the folder of scripts/simulation-study.

    simulation_page.py TACTILE FOLDER DOCS [PART]    reads PART of FOLDER (all by default), writes DOCS/simulation/tables.json and the tables of the pages
    simulation_page.py --check DOCS                  fails if a page has other tables than DOCS/simulation/tables.json gives

The pages are DOCS/simulation.md and DOCS/simulation/*.md. A table is what lies between `<!-- table: NAME -->` and `<!-- end -->`. Other parts stay as they are in tables.json.
"""

import csv
import json
import math
import pathlib
import re
import subprocess
import sys

from page_text import wrapped
from publish_study import STUDY_FORMAT, figure, number, read as read_results, table

OF_SETTINGS = ("preset", "seed", "worlds", "trainings", "epochs")
WORST_LABELS_MS = ("press_onset", "press_end", "slip_onset", "slip_end", "robot_clock", "video_clock")

# The sensors of the table: folder below sensors/, and head of the column.
SENSORS = {"still": "DVXplorer 640 × 480, still scene", "measured": "simulated, camera `measured`", "physics": "simulated, `physics.json` of the still scene"}
COMPARED = ("still", "physics")  # the last column is their difference
# What a row says, where sensor.json has it, and the factor to its unit.
SENSOR_ROWS = (("recorded [s]", "seconds", 1), ("rate [kev/s]", "rate_hz", 1e-3), ("rate without hot pixels [kev/s]", "rate_without_hot_hz", 1e-3),
               ("read-out [µs]", "readout.period_us", 1), ("time per column [µs]", "readout.us_per_line", -1), ("jitter [ns]", "readout.jitter_us", 1e3),
               ("slow wander [ns]", "readout.wander_us", 1e3), ("background ON per pixel [1/s]", "background.on_hz", 1),
               ("background OFF per pixel [1/s]", "background.off_hz", 1), ("spread between pixels [decades]", "background.spread_decades", 1),
               ("regularity (1: Poisson)", "background.regularity", 1), ("hot pixels", "unusual_pixels.hot", 1),
               ("share of the events in hot pixels [%]", "unusual_pixels.hot_share_of_events", 100), ("warm pixels", "unusual_pixels.warm", 1),
               ("stuck pixels", "unusual_pixels.stuck", 1), ("share of ON of hot and warm pixels [%]", "unusual_pixels.on_share", 100),
               ("regularity of hot and warm pixels (0: Poisson)", "unusual_pixels.regularity", 1),
               ("correlation of neighbours across in 2 ms", "neighbours.horizontal", 1), ("correlation of neighbours down in 2 ms", "neighbours.vertical", 1),
               ("shortest interval of a pixel [µs]", "shortest_interval_us", 1), ("most events of a pixel in 2 ms", "largest_count.all.tick", 1),
               ("most events of a pixel in 40 ms", "largest_count.all.history", 1), ("of an ordinary pixel in 2 ms", "largest_count.ordinary.tick", 1),
               ("of an ordinary pixel in 40 ms", "largest_count.ordinary.history", 1), ("wait for the end of a packet [ms]", "packets.wait_us", 1e-3))

# What a row says, its statistic, the factor to its unit, digits, and the reference.
STILL, MOVING = "measured here (still scene)", "at most 11, measured here (moving scene)"
EDGES = "50 to 3000, derived (edges × speed × contrast / threshold)"
EVENT_ROWS = (("quiet rate, per run [kev/s]", "quiet_rate", 1e-3, 0, f"167, {STILL}"),
              ("quiet rate without hot pixels [kev/s]", "quiet_rate_without_hot", 1e-3, 1, f"131, {STILL}"),
              ("mean rate of a press or slip over the quiet one", "rate_over_quiet", 1, 1, "0.3 to 18, derived (rates below over 167 kev/s)"),
              ("a hot pixel's rate [ev/s]", "hot_hz", 1, 0, f"5 to 1311, median 18, {STILL}"),
              ("press: lasts [ms]", "press_ms", 1, 0, "100 to 500, derived (2 mm at 4 to 20 mm/s)"), ("press: mean rate [kev/s]", "press_rate", 1e-3, 0, EDGES),
              ("press: events per pixel and 2 ms tick, of those with any", "press_per_pixel_tick", 1, 0, MOVING),
              ("press: from one event of a pixel to its next [ms]", "press_between_us", 1e-3, 1, "from 0.195, derived (one read-out)"),
              ("press: share of brighter events [%]", "press_on", 100, 0, ""),
              ("slip: lasts [ms]", "slip_ms", 1, 0, ""), ("slip: mean rate [kev/s]", "slip_rate", 1e-3, 0, EDGES),
              ("slip: events per pixel and 2 ms tick, of those with any", "slip_per_pixel_tick", 1, 0, MOVING),
              ("slip: from one event of a pixel to its next [ms]", "slip_between_us", 1e-3, 1, "from 0.195, derived (one read-out)"),
              ("slip: share of brighter events [%]", "slip_on", 100, 0, ""))


# What the folder has.


def read(file):
    return json.loads(file.read_text())


def delays_in(cells):
    """By class and object, from the true onset: the mean delay of detected touches, and its standard error, the mean over trainings."""
    delays = {}
    for touch in ("press", "slip"):
        of_objects = {}
        for cell in cells:
            of_objects.setdefault(cell["object"], {}).setdefault((cell["world"], cell["training"]), []).extend(
                (word, float(cell["tick_ms"])) for word in cell[touch + "_ms"].split())
        delays[touch] = {}
        for name, of_trainings in of_objects.items():
            times, errors, missed, touches = [], [], 0, 0
            for words in of_trainings.values():
                missed += sum(word.startswith(">") for word, _ in words)
                touches += len(words)
                own = [math.ceil(float(word) / tick_ms - 1e-6) * tick_ms for word, tick_ms in words if ">" not in word]
                times += own
                if len(own) > 1:
                    mean = sum(own) / len(own)
                    errors.append(math.sqrt(sum((ms - mean) ** 2 for ms in own) / (len(own) - 1) / len(own)))
            delays[touch][name] = {"mean": {"value": sum(times) / len(times) if times else None, "low": None, "high": None},
                                   "sem": sum(errors) / len(errors) if errors else None, "misses": missed, "intervals": touches}
    return delays


def study_part(tactile, folder):
    """LeNet of each history on all runs that a training did not learn from; delays of the one that is judged on whole runs."""
    study = read_results(folder / "study" / "study.json", STUDY_FORMAT)
    lenets = [setting for setting in study["results"] if setting["th_ms"] is not None and not setting["is_unseen"]]
    main = next(setting for setting in lenets if setting["whole_runs"]["runs"])
    with open(folder / "study" / study["cells"], newline="") as file:
        cells = [cell for cell in csv.DictReader(file) if cell["setting"] == main["setting"] and cell["answer"] == "touch" and not cell["threshold"]]
    # Baselines are of its first training.
    model = next(model for model in study["models"] if model["setting"] == main["setting"])
    data = folder / "study" / study["worlds"][model["world"]]["data"]
    evaluated = subprocess.run([tactile, "eval", data, "--model", folder / "study" / model["folder"], "--json", "--quiet"], check=True, stdout=subprocess.PIPE)
    evaluation = json.loads(evaluated.stdout)
    part = {"settings": {key: study["settings"][key] for key in OF_SETTINGS}, "software": study["software"], "th_ms": main["th_ms"]}
    part["histories"] = [{"th_ms": setting["th_ms"], "accuracy": setting["accuracy"]} for setting in lenets]
    part["unseen"] = next(unseen for unseen in study["unseen"] if unseen["setting"] == main["setting"])["accuracy"]["objects"]
    part["delays"], part["delays_by"] = delays_in(cells), "truth"
    part["evaluated_trainings"] = len(evaluation["trainings"])
    part.update({key: evaluation[key] for key in ("accuracy", "confusion")})
    return part


def data_of(folder):
    """The runs of the study's first world."""
    study = read_results(folder / "study" / "study.json", STUDY_FORMAT)
    return folder / "study" / study["worlds"][0]["data"]


def worlds_part(folder):
    worlds = {}
    for file in sorted(folder.glob("worlds/*/eval.json")):
        evaluation = read(file)
        worlds[file.parent.name] = {"accuracy": evaluation["accuracy"]}
    return worlds


def labels_part(folder, preset):
    """@return  by the name of the data: errors, and how many runs are flagged"""
    labels = {}
    for file in (folder / "label.json", *sorted(folder.glob("out-of-range/*/label.json"))):
        found = read(file)
        name = preset if file.parent == folder else file.parent.name
        truth = found["truth"]
        labels[name] = {"errors_ms": {what: truth["errors_ms"][what] for what in WORST_LABELS_MS if what in truth["errors_ms"]}, "missed": truth["missed"],
                        "spurious": truth["spurious"], "unflagged_errors": truth["unflagged_errors"], "runs": len(found["runs"]),
                        "flagged": sum(bool(run["flags"]) for run in found["runs"])}
    return labels


def at(sensor, place):
    for key in place.split("."):
        sensor = sensor and sensor[key]
    return sensor


def sensors_part(folder, known):
    """Columns that were not measured again are kept, and named as kept."""
    sensors = {name: {**column, "kept": True} for name, column in known.items()}
    for name in SENSORS:
        file = folder / "sensors" / name / "sensor.json"
        if file.exists():
            sensor = read(file)
            sensors[name] = {"kept": False, **{place: at(sensor, place) for _, place, _ in SENSOR_ROWS}}
    return sensors


def gather(tactile, folder, part, known):
    tables = dict(known)
    if part in (None, "study"):
        from simulated_events import event_statistics  # needs numpy
        tables["study"] = study_part(tactile, folder)
        tables["events"] = event_statistics(tactile, data_of(folder))
    if part in (None, "worlds"):
        tables["worlds"] = worlds_part(folder)
    if part in (None, "labels"):
        tables["labels"] = labels_part(folder, tables["study"]["settings"]["preset"])
    if part in (None, "sensors"):
        tables["sensors"] = sensors_part(folder, known.get("sensors", {}))
    return tables


# What the page shows.


def about_text(tables):
    settings = tables["study"]["settings"]
    return (f"All tables are of `{settings['preset']}`, seed {settings['seed']}, revision {tables['study']['software']['revision']}, unless they say otherwise. "
            f"`scripts/simulation-study --preset {settings['preset']} --seed {settings['seed']}` makes them.\n")


def protocol_text(tables):
    study = tables["study"]
    settings = study["settings"]
    count = settings["worlds"] * settings["trainings"]
    trained = "LeNet is trained on one run of each object," if count == 1 else (
        f"LeNet is trained {count} times, each time on another run of each object," if settings["worlds"] == 1 else
        f"LeNet is trained {count} times in {settings['worlds']} worlds, each time on one run of each object,")
    return (f"{trained} for {settings['epochs']} epochs, and tested on all other runs. The tables use a history of {study['th_ms']:g} ms, unless they say otherwise."
            + (" Figures are over all trainings.\n" if count > 1 else "\n"))


def events_text(tables):
    rows = []
    for words, key, factor, digits, reference in EVENT_ROWS:
        found = tables["events"].get(key)
        if not found:
            continue
        if "most" in found:
            words += f" (mean {found['mean']:.2f}, most {found['most']})"
        low, middle, high = (f"{factor * found[of]:,.{digits}f}" for of in ("p5", "median", "p95"))
        rows.append((words, middle, f"{low} to {high}", reference))
    return table(("what", "median", "5 % to 95 %", "reference"), rows)


def measured_text(measured, factor):
    """The value with its uncertainty, to two digits of the uncertainty."""
    if measured is None:
        return "-"
    if not isinstance(measured, dict):
        return f"{factor * measured:.4g}"
    value, uncertainty = factor * measured["value"], abs(factor) * (measured["uncertainty"] or 0)
    if uncertainty == 0:
        return f"{value:.6g}"
    digits = max(0, 1 - math.floor(math.log10(uncertainty)))
    return f"{value:.{digits}f} ± {uncertainty:.{digits}f}"


def difference_text(one, other):
    """In standard uncertainties of the difference."""
    if not (isinstance(one, dict) and isinstance(other, dict)):
        return ""
    uncertainty = math.hypot(one["uncertainty"] or 0, other["uncertainty"] or 0)
    if uncertainty == 0:
        return "same" if one["value"] == other["value"] else "another"
    return f"{round((other['value'] - one['value']) / uncertainty, 1) + 0.0:.1f}"  # no -0.0


def sensors_text(tables):
    sensors = tables["sensors"]
    names = [name for name in SENSORS if name in sensors]
    rows = []
    for words, place, factor in SENSOR_ROWS:
        compared = difference_text(*(sensors[name][place] for name in COMPARED)) if all(name in sensors for name in COMPARED) else ""
        rows.append((words, *(measured_text(sensors[name][place], factor) for name in names), compared))
    text = table(("", *(SENSORS[name] for name in names), "difference [uncertainties]"), rows)
    kept = [SENSORS[name] for name in names if sensors[name]["kept"]]
    return text + (f"\nThe last run of the script did not measure these again, because their files were not at hand: {'; '.join(kept)}.\n" if kept else "")


def histories_text(tables):
    histories = tables["study"]["histories"]
    rows = [(name, *(number(history["accuracy"]["objects"][name]["value"], 100) for history in histories)) for name in sorted(histories[0]["accuracy"]["objects"])]
    rows.append(("mean", *(figure(history["accuracy"]["mean"], 100) for history in histories)))
    return table(("accuracy [%] with a history of", *(f"{history['th_ms']:g} ms" for history in histories)), rows)


def delays_text(tables):
    def cells(delay):
        return number(delay["mean"]["value"]) + ("" if delay["sem"] is None else f" ± {delay['sem']:.1f}"), f"{delay['misses']} of {delay['intervals']}"

    press, slip = (tables["study"]["delays"][touch] for touch in ("press", "slip"))
    onset = "true" if tables["study"]["delays_by"] == "truth" else "labelled"
    return table((f"mean delay ± standard error from the {onset} onset [ms]", "press", "missed", "slip", "missed"), [(name, *cells(press[name]), *cells(slip[name])) for name in sorted(press)])


def unseen_text(tables):
    rows = [(name, *(figure(of[key], 100) for key in ("seen", "held_out", "difference"))) for name, of in sorted(tables["study"]["unseen"].items())]
    return table(("accuracy [%]", "in training", "not in training", "difference"), rows)


def confusion_text(tables):
    rows = [(name, *(f"{100 * value / max(sum(row), 1):.1f} %" for value in row)) for name, row in zip(("none", "press", "slip"), tables["study"]["confusion"])]
    return table(("true \\ predicted", "none", "press", "slip"), rows)


def worlds_text(tables):
    rows = []
    for name, world in sorted(tables["worlds"].items()):
        objects = world["accuracy"]["objects"]
        worst = min(objects, key=lambda name: objects[name]["value"])
        rows.append((name, figure(world["accuracy"]["mean"], 100), f"{worst}, {number(objects[worst]['value'], 100)}"))
    return table(("`quick`, t_h 40 ms", "LeNet, mean [%]", "worst object [%]"), rows)


def labels_text(tables):
    def cell(error):
        return f"{error['median']:.2f} / {error['p95']:.1f}, {error['covered']} of {error['n']}" if error.get("n") else "-"

    rows, unflagged = [], []
    for name, of in sorted(tables["labels"].items(), key=lambda item: (item[0] != tables["study"]["settings"]["preset"], item[0])):
        rows.append((f"`{name}`", *(cell(of["errors_ms"].get(what, {})) for what in WORST_LABELS_MS), f"{of['missed']} / {of['spurious']}",
                     f"{of['flagged']} of {of['runs']}"))
        if of["unflagged_errors"]:
            unflagged.append(f"- `{name}`: {'; '.join(of['unflagged_errors'])}.\n")
    text = table(("errors [ms]: median / p95, inside the 95 % interval", *(what.replace("_", " ") for what in WORST_LABELS_MS), "missed / spurious", "flagged"), rows)
    return text + ("\nThese labels are wrong **without a flag**:\n\n" + "".join(unflagged) if unflagged else "\nNo label is wrong without a flag.\n")


BLOCKS = {"about": about_text, "events": events_text, "sensors": sensors_text, "protocol": protocol_text, "histories": histories_text,
          "delays": delays_text, "unseen": unseen_text, "confusion": confusion_text,
          "worlds": worlds_text, "labels": labels_text}


def pages(docs):
    """The pages with their tables, by file."""
    tables = read(docs / "simulation" / "tables.json")
    texts = {file: file.read_text() for file in (docs / "simulation.md", *sorted((docs / "simulation").glob("*.md")))}
    block = re.compile(r"(<!-- table: (.+?) -->\n\n).*?(<!-- end -->)", re.DOTALL)
    names = [match[2] for text in texts.values() for match in block.finditer(text)]
    if sorted(names) != sorted(BLOCKS):
        sys.exit(f"the pages have the tables {sorted(names)}; expected each of {sorted(BLOCKS)} once")
    for file, text in texts.items():
        if "\n| ---" in block.sub("", text):
            sys.exit(f"{file} has a table that no block makes; expected each table between '<!-- table: NAME -->' and '<!-- end -->'")
    return {file: block.sub(lambda match: match[1] + wrapped(BLOCKS[match[2]](tables)) + "\n" + match[3], text)
            for file, text in texts.items()}


def main():
    if len(sys.argv) == 3 and sys.argv[1] == "--check":
        for file, text in pages(pathlib.Path(sys.argv[2])).items():
            if text != file.read_text():
                sys.exit(f"{file}: a table differs from docs/simulation/tables.json; expected what this script makes of it")
        return
    if len(sys.argv) not in (4, 5):
        sys.exit(__doc__)
    tactile, folder, docs = sys.argv[1], *map(pathlib.Path, sys.argv[2:4])
    part = sys.argv[4] if len(sys.argv) == 5 else None
    file = docs / "simulation" / "tables.json"
    tables = gather(tactile, folder, part, read(file) if file.exists() else {})
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(json.dumps(tables, indent=1, sort_keys=True, ensure_ascii=False) + "\n")
    for page, text in pages(docs).items():
        page.write_text(text)


if __name__ == "__main__":
    main()

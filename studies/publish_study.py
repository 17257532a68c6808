"""Writes docs/study.md, its figures and its JSON from the folders of `tactile reproduce` and `tactile trade`.

    publish_study.py STUDY TRADE DOCS    reads study.json and trade.json, writes DOCS/study/ and DOCS/study.md
    publish_study.py --page DOCS         prints the page that DOCS/study/ gives; a test compares it with DOCS/study.md
"""

import json
import pathlib
import re
import shutil
import sys

from page_text import wrapped

STUDY_FORMAT, TRADE_FORMAT = "tactile-study-2", "tactile-trade-2"
PICTURES = ("settings-curve", "accuracy-by-history")
TRADE_PICTURES = ("trade-accuracy", "trade-delay")
MOST_TRADED_SETTINGS, MOST_CAUSES = 5, 5
OF_A_WORLD = ("name", "runs", "samples", "held_out")
OF_WHOLE_RUNS = ("units", "decided", "causes", "calm", "confirmed")


def number(value, factor=1.0, digits=1):
    """Without the sign of a number that is rounded to 0."""
    return "-" if value is None else f"{round(factor * value, digits) + 0.0:.{digits}f}"


def figure(measured, factor=1.0, digits=1):
    """The value and its 95 % interval."""
    if measured is None or measured["value"] is None:
        return "-"
    text = number(measured["value"], factor, digits)
    if measured["low"] is None:
        return text
    return f"{text} [{number(measured['low'], factor, digits)}, {number(measured['high'], factor, digits)}]"


def quantile(measured):
    """A delay in ms; one among touches that are not detected is a lower bound."""
    return ("> " if measured["is_lower_bound"] else "") + figure(measured, 1, 0)


def table(head, rows, alignment="---:"):
    lines = ["| " + " | ".join(head) + " |", "| --- |" + f" {alignment} |" * (len(head) - 1)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows]) + "\n"


def picture(name, words):
    return f"![{words}](study/{name}.svg)\n"


def counted(count, noun):
    return f"{count} {noun}" + ("" if count == 1 else "s")


# What the folders have.


def read(file, form):
    content = json.loads(file.read_text())
    if content.get("format") != form:
        sys.exit(f"{file}: the format {content.get('format')!r}; expected {form!r}")
    return content


def name_part(text):
    """The part of a figure's name for an id, as `tactile report` makes it."""
    return re.sub("[^a-z0-9]+", "-", text).strip("-")[:40]


def pictures_of_runs(study):
    """For each run over time: its figure in the report, its name here, the run and the setting."""
    names = []
    for run in study["full_runs"]:
        setting = pathlib.Path(run["csv"]).parent.name
        names.append((f"run-{name_part(run['run'])}-{name_part(run['model'])}", f"run-{setting}-{name_part(run['run'])}", run["run"], setting))
    return names


def pictures_of_unseen(study):
    """For each comparison: its figure in the report, its name here, the setting in words."""
    return [("unseen-" + name_part(unseen["setting"]), f"unseen-{unseen['setting']}", unseen["text"]) for unseen in study["unseen"]]


def reduced_study(study):
    """What the page needs."""
    kept = {key: study[key] for key in ("title", "simulated", "settings", "software", "machine", "bootstrap", "intervals", "found", "claims", "unseen")}
    kept["worlds"] = [{key: world[key] for key in OF_A_WORLD} for world in study["worlds"]]
    kept["minutes"] = sum(step["seconds"] for step in study["steps"]) / 60
    kept["results"] = []
    for setting in study["results"]:
        whole = setting["whole_runs"]
        judged = {key: whole[key] for key in OF_WHOLE_RUNS} | {"runs": len(whole["runs"]), "left_out": len(whole["left_out"])}
        kept["results"].append(setting | {"whole_runs": judged if whole["runs"] else None})
    kept["pictures"] = {"runs": [names[1:] for names in pictures_of_runs(study)], "unseen": [names[1:] for names in pictures_of_unseen(study)]}
    return kept


def reduced_trade(trade):
    kept = {key: trade[key] for key in ("title", "simulated", "software", "machine", "busy", "interrupted")}
    kept["recommendation"] = {key: trade["recommendation"][key] for key in ("wish", "id", "met", "sentence")}
    kept["minutes"] = sum(step["seconds"] for step in trade["steps"]) / 60
    kept["settings"] = len(trade["points"])
    kept["options"] = {key: trade["settings"][key] for key in ("trainings", "seed", "budget_minutes")}
    kept["front"] = [{"text": point["text"], "is_usual": point["id"] == trade["usual"], "trainings": point["trainings"], "reported": point["reported"],
                      "on_accuracy_front": point["on_accuracy_front"], "on_delay_front": point["on_delay_front"]}
                     for point in trade["points"] if point["on_accuracy_front"] or point["on_delay_front"] or point["id"] == trade["usual"]]
    return kept


# What the page shows.


def judged_settings(study):
    """Streams first: they are what a robot acts on."""
    return sorted((setting for setting in study["results"] if setting["whole_runs"]), key=lambda setting: not setting["setting"].startswith("stream"))


def curve_part(study):
    rows = []
    for setting in judged_settings(study):
        whole = setting["whole_runs"]
        points = [("as decided", whole["decided"])] + [(f"at most {calm['at_most_per_min']:g}", calm["point"]) for calm in whole["calm"]]
        for name, point in points:
            if point is None:
                rows.append((setting["text"], name, *["-"] * 5))
                continue
            rows.append((setting["text"], name, figure(point["alarms_per_min"]), quantile(point["median_ms"]), quantile(point["p90_ms"]),
                         figure(point["missed"], 100), figure(point["false_slips"], 100)))
    return table(("setting", "alarms a minute", "measured", "half of the touches within [ms]", "90 % within [ms]", "missed [%]",
                  "slip in lifts without slip [%]"), rows)


def confirmed_sentences(study):
    texts = []
    for setting in judged_settings(study):
        point = setting["whole_runs"]["confirmed"]
        if point is None or point["median_ms"]["value"] is None:
            continue
        lifts = f", confirmed in {point['lifts_with_slip']} of {point['lifts']} lifts without slip" if point["lifts"] else ""
        texts.append(f"{setting['text']}, median {quantile(point['median_ms'])} ms, 90 % within {quantile(point['p90_ms'])} ms, "
                     f"{point['misses'] + point['early']} of {point['touches']} slips missed{lifts}")
    return f"Slips that `detect` confirms: {'; '.join(texts)}." if texts else ""


BASELINES = {"event_rate": "event rate (Rigi et al. 2018)", "cusum": "CUSUM of event counts (Page 1954)", "features": "features and a small network (Funk et al. 2024)"}
COMPARED_RATE = 6


def baselines_part(study):
    """Published detectors beside the stream that learned from the same runs."""
    rows = []
    for setting in judged_settings(study):
        for name, baseline in ({"": setting["whole_runs"]} | setting["baselines"]).items() if setting["baselines"] else ():
            decided = baseline["decided"]
            calm = next((entry["point"] for entry in baseline["calm"] if entry["at_most_per_min"] == COMPARED_RATE), None)
            text = setting["text"] if not name else BASELINES[name] + (", objects never seen" if setting["is_unseen"] else "")
            rows.append((text, figure(decided["alarms_per_min"]), quantile(decided["median_ms"]), quantile(decided["p90_ms"]), missed(decided),
                         *((quantile(calm["median_ms"]), quantile(calm["p90_ms"]), missed(calm)) if calm else ("none", "-", "-"))))
    if not rows:
        return ""
    return (f"[Published detectors](cli/eval.md#baselines), which learned from the same runs, as decided and with at most {COMPARED_RATE} false alarms a minute:\n\n"
            + table(("detector", "alarms a minute", "median [ms]", "90 %", "missed", "calm: median [ms]", "90 %", "missed"), rows))


def missed(point):
    return f"{point['misses'] + point['early']} of {point['touches']}"


def causes_part(study):
    settings = judged_settings(study)
    total = {}
    for setting in settings:
        for cause, alarms in setting["whole_runs"]["causes"].items():
            total[cause] = total.get(cause, 0) + alarms
    order = sorted(total, key=lambda cause: (-total[cause], cause))

    def row(name, causes):
        texts = []
        for setting in settings:
            alarms, minutes = (sum(setting["whole_runs"]["causes"].get(cause, 0) for cause in causes), setting["whole_runs"]["decided"]["outside_min"])
            texts.append(number(alarms / minutes if minutes else None, 1, 2))
        return name, *texts

    rows = [row(cause, [cause]) for cause in order[:MOST_CAUSES]]
    if order[MOST_CAUSES:]:
        rows.append(row("others", order[MOST_CAUSES:]))
    return table(("false alarms a minute by cause", *(setting["text"] for setting in settings)), rows)


def accuracy_part(study):
    rows = []
    for setting in study["results"]:
        if setting["is_unseen"]:
            continue
        objects = setting["accuracy"]["objects"]
        lowest = min((name for name in objects if objects[name]["value"] is not None), key=lambda name: objects[name]["value"], default=None)
        rows.append((setting["text"], figure(setting["accuracy"]["mean"], 100), f"{lowest}, {number(objects[lowest]['value'], 100)}" if lowest else "-"))
    return table(("accuracy on balanced samples [%]", "mean over objects", "lowest object"), rows)


def limit_of(claim):
    return f"{'below' if claim['is_below'] else 'above'} {claim['limit']:g} {claim['unit']}"


def claims_part(study):
    rows = []
    for claim in study["claims"]:
        outcome = "does not hold" if claim["outcome"] == "does not" else claim["outcome"]
        measure = f"{claim['measure'].rstrip(',')}, {'by a margin ' if claim['is_by_margin'] else ''}{limit_of(claim)}"
        measured = f"{figure(claim['measured'])} {claim['unit']}" if claim["replicates"] else "not measured"
        rows.append((claim["figure"], claim["paper"], f"{claim['written']} of {claim['replicates']}, {outcome}", f"{measure}: **{measured}**"))
    return table(("figure", "sentence", "written in", "measured"), rows, "---")


def unseen_sentences(study):
    if not study["unseen"]:
        return "No object was held out of training.\n"
    texts = ["On the same runs, with their objects in training and without."]
    for unseen in study["unseen"]:
        objects, mean = unseen["accuracy"]["objects"], unseen["accuracy"]["mean"]
        known = [name for name in objects if objects[name]["difference"]["value"] is not None]
        losing = sorted(known, key=lambda name: objects[name]["difference"]["value"])
        texts.append(f"{unseen['text']}: {figure(mean['seen'], 100)} % and {figure(mean['held_out'], 100)} %, a change of {figure(mean['difference'], 100)} points, "
                     f"the mean over {counted(len(objects), 'object')}."
                     + (f" It is lowest for {losing[0]}, {figure(objects[losing[0]]['difference'], 100)}, and highest for {losing[-1]}, "
                        f"{figure(objects[losing[-1]]['difference'], 100)}." if losing else ""))
    return " ".join(texts) + "\n"


def traded_settings(trade):
    """The usual one, then those with the most trainings: the others were given up early."""
    return sorted(trade["front"], key=lambda point: (not point["is_usual"], -point["trainings"]))


def front_part(trade):
    rows = []
    for point in traded_settings(trade)[:MOST_TRADED_SETTINGS]:
        reported = point["reported"]
        median = reported["whole_runs"]["median_ms"]
        rows.append((point["text"], figure(reported["accuracy"], 100), number(reported["us_p50"]["value"], 1, 0), number(reported["us_p99"]["value"], 1, 0),
                     ("> " if median["is_lower_bound"] else "") + number(median["value"]), figure(reported["whole_runs"]["missed"], 100), figure(reported["whole_runs"]["alarms_per_min"])))
    return table(("setting", "accuracy [%]", "time of a tick [µs]", "of 99 % of them", "median delay [ms]", "missed [%]", "alarms a minute"), rows)


def first_sentence(text):
    return re.split(r"(?<=\.) (?=[A-Z])", text)[0]


def speed_sentences(study, trade):
    hidden = len(trade["front"]) - MOST_TRADED_SETTINGS
    texts = [f"{counted(trade['settings'], 'setting')} were measured on the first world. The table has the usual setting and those on a front: no other one has a higher accuracy in a "
             "shorter time, or fewer false alarms with a shorter delay and fewer misses."]
    if hidden > 0:
        texts.append(f"{hidden} more, with fewer trainings, are in [trade.json](study/trade.json).")
    texts.append(f"Other programs interrupted {100 * trade['interrupted']:.2g} % of the timed ticks." if trade["interrupted"] is not None else "")
    texts.append(first_sentence(trade["recommendation"]["sentence"]))
    if trade["software"]["revision"] != study["software"]["revision"]:
        texts.append(f"The trade is of revision {trade['software']['revision']}: where a later one decides otherwise, its false alarms differ from those above.")
    return " ".join(filter(None, texts)) + "\n"


def about_part(study, trade):
    settings, machine, worlds = study["settings"], study["machine"], study["worlds"]
    seeds = [world["name"] for world in worlds if world["name"]] or [str(settings["seed"])]
    seeds = f"{seeds[0]} to {seeds[-1]}" if len(seeds) > 1 else seeds[0]
    where = f"{counted(len(worlds), 'world')}, seed {seeds}, " if study["simulated"] else ""
    return [f"- Revision {study['software']['revision']}; {where}{sum(world['runs'] for world in worlds)} runs with samples; {counted(settings['trainings'], 'training')} "
            f"of each setting in each world, {settings['epochs']} epochs of a LeNet, {settings['steps']} steps of a stream.\n"
            f"- {machine['cpu']}, {machine['threads']} threads; {study['minutes']:.0f} min of work for the study, {trade['minutes']:.0f} min for the trade.\n"
            f"- Brackets are 95 % intervals. {study['intervals']} [Intervals](numerics/figures.md#intervals) says how they are made.\n"
            "- [`eval`](cli/eval.md) defines the figures, [`reproduce`](cli/reproduce.md#how-it-works) the settings. Figures of the paper (Faris et al., "
            "arXiv:2403.10120) are numbered as in its LaTeX source. Defaults are ours where the paper gives no value; [configs](../configs/README.md) has "
            "two that follow its words where they differ.\n"]


def repeating(settings, trade):
    budget = trade["options"]["budget_minutes"]
    return (f"--preset {settings['preset']} --worlds {settings['worlds']} --seed {settings['seed']} --trainings {trade['options']['trainings']}"
            + (f" --budget-minutes {budget:g}" if budget else ""))


def page(folder):
    study = json.loads((folder / "study.json").read_text())
    trade = json.loads((folder / "trade.json").read_text())
    text_of = {setting["setting"]: setting["text"] for setting in study["results"]}
    kind = "simulated" if study["simulated"] else "real"
    parts = [
        "# A study\n",
        f"This page is made by `scripts/publish-study` from one `tactile reproduce --preset {study['settings']['preset']}` and one `tactile trade` on the "
        f"runs of its first world. Its numbers are in [`docs/study/`](study). The runs are **{kind}**"
        + (": they compare methods, and do not predict what a method does on a real sensor.\n" if study["simulated"] else ".\n"),
        *about_part(study, trade),
        "## Delay against false alarms\n",
        picture("settings-curve", "Delay against false alarms, for each setting"),
        curve_part(study),
        "The thresholds of the rows \"at most\" are chosen on the same runs. " + confirmed_sentences(study) + "\n",
        causes_part(study),
        baselines_part(study),
        "".join(picture(name, f"{run} over time, by {text_of.get(setting, setting)}") for name, run, setting in study["pictures"]["runs"]),
        "## The paper's sentences\n",
        study["found"][-1] + "\n",
        claims_part(study),
        "A replicate is one training of each setting in one world: a study like the paper's. A sentence holds if more than half of all replicates would write it, "
        "with 95 % confidence, and does not hold if fewer would. Of a margin, the interval of the measure decides.\n",
        "## Accuracy and unseen objects\n",
        accuracy_part(study),
        picture("accuracy-by-history", "Accuracy by history t_h for each object"),
        unseen_sentences(study),
        "".join(picture(name, f"Accuracy on objects seen and never seen, {text}") for name, text in study["pictures"]["unseen"]),
        "## What speed costs\n",
        speed_sentences(study, trade),
        front_part(trade),
        "".join(picture(name, words) for name, words in zip(TRADE_PICTURES, ("Accuracy against time per tick", "Delay against false alarms of the traded settings"))),
        "## To repeat it\n",
        f"    scripts/publish-study {repeating(study['settings'], trade)}\n"
        "    scripts/publish-study STUDY TRADE    # this page from folders that exist\n",
    ]
    return wrapped("\n".join(part for part in parts if part))


def publish(study_folder, trade_folder, docs):
    study = read(study_folder / "study.json", STUDY_FORMAT)
    trade = read(trade_folder / "trade.json", TRADE_FORMAT)
    figures = study_folder / "report" / "figures"
    copies = {name: figures / f"{name}.svg" for name in PICTURES}
    copies |= {names[1]: figures / f"{names[0]}.svg" for names in pictures_of_runs(study) + pictures_of_unseen(study)}
    copies |= {name: trade_folder / "figures" / f"{name}.svg" for name in TRADE_PICTURES}
    missing = [str(source) for source in copies.values() if not source.exists()]
    if missing:
        sys.exit(f"{', '.join(missing)}: no such figure; 'tactile report {study_folder}' and 'tactile trade' draw them")
    folder = docs / "study"
    shutil.rmtree(folder, ignore_errors=True)  # figures of an earlier study
    folder.mkdir(parents=True)
    for name, source in copies.items():
        shutil.copyfile(source, folder / f"{name}.svg")
    for name, content in (("study", reduced_study(study)), ("trade", reduced_trade(trade))):
        (folder / f"{name}.json").write_text(json.dumps(content, indent=1, sort_keys=True, ensure_ascii=False) + "\n")
    (docs / "study.md").write_text(page(folder))


def main():
    if len(sys.argv) == 3 and sys.argv[1] == "--page":
        sys.stdout.write(page(pathlib.Path(sys.argv[2]) / "study"))
    elif len(sys.argv) == 4:
        publish(*map(pathlib.Path, sys.argv[1:]))
    else:
        sys.exit(__doc__)


if __name__ == "__main__":
    main()

"""Writes docs/study.md, its figures and its JSON from the folders of `tactile reproduce` and `tactile trade`.

    publish_study.py STUDY TRADE DOCS    reads study.json and trade.json, writes DOCS/study/ and DOCS/study.md
    publish_study.py --page DOCS         prints the page that DOCS/study/ gives; a test compares it with DOCS/study.md
"""

import json
import pathlib
import shutil
import sys

from page_text import wrapped

PICTURES = ("accuracy-by-history", "detection-curve", "delays", "over-time", "unseen", "variance")
TRADE_PICTURES = ("trade-accuracy", "trade-delay", "trade-budgets")
CURVE_MS = (0, 10, 20, 50, 100, 200, 500)
PAPER = {"history-2-worst": 8, "longer-is-better": 8, "best-history-40": 8, "marginal-past-20": 8, "accuracy-at-40": 8, "press-delay": 9, "slip-delay": 9,
         "slip-at-once": 9, "right-at-first": 10, "worse-near-the-end": 10, "seen-better": 11, "unseen-near-seen": 11, "unseen-accurate": 11,
         "unseen-plastic-container": 11}


def number(value, factor=1.0, digits=1):
    return "-" if value is None else f"{factor * value:.{digits}f}"


def figure(measured, factor=1.0, digits=1):
    """The value and its 95 % interval."""
    if measured is None or measured["value"] is None:
        return "-"
    text = number(measured["value"], factor, digits)
    if measured["low"] is None:
        return text
    return f"{text} [{number(measured['low'], factor, digits)}, {number(measured['high'], factor, digits)}]"


def table(head, rows, alignment="---:"):
    lines = ["| " + " | ".join(head) + " |", "| --- |" + f" {alignment} |" * (len(head) - 1)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows]) + "\n"


def picture(name, words):
    return f"![{words}](study/{name}.svg)\n"


def reduced_study(study, evaluation):
    """What the page needs."""
    kept = {key: study[key] for key in ("title", "simulated", "settings", "software", "machine", "bootstrap", "found", "variance", "claims", "choice",
                                        "paper_way", "splits_mean")}
    kept["trainings"] = [{key: training[key] for key in ("seed", "train_run", "th_ms")} for training in study["trainings"]]
    kept["training_spread"] = study.get("training_spread")  # not in older studies
    kept["splits"] = len(study["splits"])
    kept["minutes"] = sum(step["seconds"] for step in study["steps"]) / 60
    kept["histories"] = [{"th_ms": history["th_ms"], "accuracy": history["accuracy"]["reported"]} for history in study["histories"]]
    kept["unseen"] = study["unseen"] and {"held_out": study["unseen"]["held_out"], "reported": study["unseen"]["reported"]}
    kept["reported"] = {key: evaluation[key] for key in ("accuracy", "confusion", "delay_ms", "false_alarms", "baselines", "label_uncertainty")}
    return kept


def reduced_trade(trade):
    kept = {key: trade[key] for key in ("title", "simulated", "software", "machine", "busy", "usual_is", "recommendation")}
    kept["recommendation"] = {key: trade["recommendation"][key] for key in ("wish", "id", "met", "sentence")}
    kept["interrupted"] = trade.get("interrupted")  # not in older trades
    kept["minutes"] = sum(step["seconds"] for step in trade["steps"]) / 60
    kept["settings"] = len(trade["points"])
    kept["options"] = {key: trade["settings"][key] for key in ("trainings", "seed", "budget_minutes")}
    kept["front"] = [{"text": point["text"], "trainings": point["trainings"], "reported": point["reported"], "front": point["front"]}
                     for point in trade["points"] if point["front"]["accuracy"] or point["front"]["delay"] or point["id"] == trade["usual"]]
    return kept


def claims_part(study):
    items = []
    for claim in study["claims"]:
        if not claim["in_words"]:
            items.append(claim_item(f"Figure {PAPER[claim['id']]}", claim, "Not measured."))
            continue
        words = claim["in_words"]
        if claim["measured"]["low"] is not None and claim["measured"]["high"] is not None:
            side = "above" if claim["asked"] == "above" else "below"
            words += f" Figure: {figure(claim['measured'], 1, 2)} {claim['unit']}, claimed {side} {claim['limit']:g}."
        reason = f" Why: {claim['why']}." if claim["why"] else ""
        items.append(claim_item(f"Figure {PAPER[claim['id']]}", claim, " ".join(filter(None, (words, claim["note"]))) + reason))
    return "\n".join(items) + "\n"


def claim_item(head, claim, words):
    """A claim of the paper, its outcome, and what was measured."""
    if claim["id"].endswith("-delay"):  # the paper makes it of both touches
        words = f"{claim['id'].split('-')[0].capitalize()}: {words[0].lower()}{words[1:]}"
    outcome = "does not hold" if claim["verdict"] == "does not" else claim["verdict"]
    return f"- {head}, **{outcome}**. The paper: *{claim['paper']}.* {words}"


def histories_part(study):
    histories = study["histories"]
    names = sorted(histories[0]["accuracy"]["objects"])
    rows = [(name, *(number(history["accuracy"]["objects"][name]["value"], 100) for history in histories)) for name in names]
    rows.append(("mean over objects", *(figure(history["accuracy"]["mean"], 100) for history in histories)))
    return table(("accuracy [%] with t_h", *(f"{history['th_ms']:g} ms" for history in histories)), rows)


def baselines_part(study):
    reported = study["reported"]
    rows = [("LeNet", figure(reported["accuracy"]["mean"], 100))]
    rows += [(f"`{name}`", figure(score["accuracy"], 100)) for name, score in sorted(reported["baselines"].items())]
    return table(("detector", "accuracy, mean over objects [%]"), rows)


def detection_part(study):
    delays = study["reported"]["delay_ms"]
    rows = []
    for ms in CURVE_MS:
        rows.append((f"detected within {ms} ms, Kaplan and Meier [%]" if ms else "predicted ahead of the onset [%]",
                     *(figure(next(point["share"] for point in delays[touch]["detected_within"] if point["ms"] == ms), 100) for touch in ("press", "slip"))))

    def detected(delays):
        return number(1 - (delays["misses"] + delays["early"]) / delays["intervals"] if delays["intervals"] else None, 100)

    rows.append(("detected in time, of all [%]", *(detected(delays[touch]) for touch in ("press", "slip"))))

    def quantile(touch, key):
        found = delays[touch][key]
        return ("at least " if found["is_lower_bound"] else "") + figure(found, 1, 0)

    rows.append(("median delay of all, misses included [ms]", *(quantile(touch, "median_of_all") for touch in ("press", "slip"))))
    rows.append(("90 % quantile [ms]", *(quantile(touch, "p90_of_all") for touch in ("press", "slip"))))
    rows.append(("missed [%]", *(figure(delays[touch]["missed"], 100) for touch in ("press", "slip"))))
    rows.append(("predicted more than 10 ms too early, counted as false alarms [%]",
                 *(number(delays[touch]["early"] / delays[touch]["intervals"] if delays[touch]["intervals"] else None, 100) for touch in ("press", "slip"))))
    rows.append(("the paper's mean ± SEM, of detected ones [ms]",
                 *(f"{number(delays[touch]['mean']['value'])} ± {number(delays[touch]['sem'])}" for touch in ("press", "slip"))))
    return table(("", "press", "slip"), rows)


def alarms_part(study):
    alarms = study["reported"]["false_alarms"]
    rows = [("episodes per minute outside labels", figure(alarms["outside_labels"]["per_min"])),
            ("share of the time outside labels in alarm [%]", figure(alarms["outside_labels"]["share"], 100, 1)),
            ("episodes per minute outside labels, without unlabelled true motion", figure(alarms["outside_motion"]["per_min"])),
            ("share of that time in alarm [%]", figure(alarms["outside_motion"]["share"], 100, 2)),
            ("share of the time without touch in alarm [%]", figure(alarms["none_in_alarm"]["share"], 100, 2)),
            ("episodes of the wrong class, per minute of touch", figure(alarms["wrong_class"]["per_min"])),
            ("share of the time of touch with the wrong class [%]", figure(alarms["wrong_class"]["share"], 100, 1))]
    text = table(("false alarms", "LeNet"), rows)
    if "of_runs" in alarms:  # not in older studies
        text += (f"\nThese alarms are counted on {alarms['runs']} of {alarms['of_runs']} runs: only on those with a press and a slip whose labels are not flagged.\n")
    return text


def labels_sentence(study):
    uncertainty = study["reported"]["label_uncertainty"]
    if not uncertainty["draws"]:
        return ""
    accuracy = uncertainty["accuracy"]
    return (f"Labels are uncertain, too. With onsets and ends drawn {uncertainty['draws']} times from their 95 % intervals the accuracy is "
            f"{number(accuracy['mean'], 100)} [{number(accuracy['low'], 100)}, {number(accuracy['high'], 100)}] % instead of "
            f"{number(study['reported']['accuracy']['mean']['value'], 100)} %: a drawn label lies further from the truth than the label itself. With this spread the "
            f"95 % interval is [{number(accuracy['with_runs']['low'], 100)}, {number(accuracy['with_runs']['high'], 100)}] %.\n")


def unseen_part(study):
    if not study["unseen"] or not study["unseen"]["reported"]:
        return "No object was held out of training.\n"
    compared = study["unseen"]["reported"]
    rows = [(name, *(figure(of[key], 100) for key in ("seen", "held_out", "difference"))) for name, of in sorted(compared["objects"].items())]
    rows.append(("mean over objects", *(figure(compared["mean"][key], 100) for key in ("seen", "held_out", "difference"))))
    text = table(("accuracy [%]", "in training", "never seen", "difference"), rows)
    exception = "plastic-container"  # of the paper
    others = [name for name in compared["objects"] if name != exception]
    losing = sum(compared["objects"][name]["difference"]["value"] <= -0.05 for name in others)
    if exception in compared["objects"] and losing:
        text += f"\nUnlike in the paper, {exception} is not the only exception: {losing} of the {len(others)} other objects lose 5 points or more, too.\n"
    if study["splits"] and study["splits_mean"]:
        text += f"\nOver {study['splits']} random ways to hold out as many objects, the difference is {figure(study['splits_mean']['reported'], 100)} points.\n"
    return text


def front_part(trade):
    rows = []
    for point in trade["front"]:
        reported, front = point["reported"], point["front"]
        chance = "-" if front["probability"]["accuracy"] is None else f"{100 * front['probability']['accuracy']:.0f}, {100 * front['probability']['delay']:.0f}"
        rows.append((point["text"], str(point["trainings"]), figure(reported["accuracy"], 100), number(reported["us"]["p50"]["value"], 1, 0),
                     number(reported["us"]["p99"]["value"], 1, 0), number(reported["delay_us"]["median"]["value"], 1e-3),
                     number(reported["delay_us"]["missed"]["value"], 100), number(reported["episodes_per_min"]["value"]), chance))
    return table(("setting", "trainings", "accuracy [%]", "p50 [µs]", "p99 [µs]", "median delay [ms]", "missed or early [%]", "false alarms per min",
                  "on the fronts of accuracy, delay [%]"), rows)


def load_sentence(trade):
    if trade.get("interrupted") is None:
        return ""
    text = f"Other programs interrupted {100 * trade['interrupted']:.2g} % of the timed ticks."
    return text + (f" Of {trade['busy']} settings it was more than 1 %: compare their p50, since their p99 is the machine's.\n" if trade["busy"] else "\n")


def variance_sentence(study):
    shares = study["variance"]
    if not shares or "training_on_object" not in shares:  # older studies count the last among the objects
        return ""
    return (f"Of the variance of the mean accuracy, {100 * shares['training']:.0f} % comes from trainings (alike for all objects), {100 * shares['object']:.0f} % from objects "
            f"(alike for all trainings), {100 * shares['training_on_object']:.0f} % from trainings on single objects and {100 * shares['run']:.0f} % from runs of an object.\n\n"
            + picture("variance", "Shares of trainings, objects, trainings on single objects, and runs in the variance"))


def spread_sentence(study):
    spread = study.get("training_spread")
    return spread["in_words"] + "\n" if spread else ""


def repeating(settings, trade):
    budget = trade["options"]["budget_minutes"]
    return f"--preset {settings['preset']} --seed {settings['seed']}" + (f" --budget-minutes {budget:g}" if budget else "")


def page(folder):
    study = json.loads((folder / "study.json").read_text())
    trade = json.loads((folder / "trade.json").read_text())
    settings, machine = study["settings"], study["machine"]
    kind = "simulated" if study["simulated"] else "real"
    seeds = ", ".join(str(training["seed"]) for training in study["trainings"])
    histories = ", ".join(f"{training['th_ms']:g}" for training in study["trainings"])
    parts = [
        "# A study\n",
        f"This page is made by `scripts/publish-study` from one `tactile reproduce --preset {settings['preset']}` and one `tactile trade` on "
        f"its data. Its numbers are in [`docs/study/`](study). The runs are **{kind}**"
        + (": they compare methods, and do not predict what a method does on a real sensor.\n" if study["simulated"] else ".\n"),
        f"- Revision {study['software']['revision']}, seed {settings['seed']}; {settings['trainings']} trainings of each setting, with the seeds {seeds}, each on "
        "another run. No network is judged on a run that it learned from or was chosen on.\n"
        f"- {machine['cpu']}, {machine['threads']} threads; {study['minutes']:.0f} min of work for the study, {trade['minutes']:.0f} min for the trade.\n"
        "- Brackets are 95 % intervals over trainings, objects and runs. [Intervals](numerics/figures.md#intervals) says how often they contain the true value.\n"
        "- Figures of the paper (Faris et al., arXiv:2403.10120) are numbered as in its LaTeX source: accuracy 8, delay 9, a run over time 10, unseen objects 11.\n",
        "## What was found\n",
        "".join(f"- {sentence}\n" for sentence in study["found"]),
        "## The paper's claims\n",
        claims_part(study),
        "The figure decides: a claim holds if its whole interval is on the claimed side. A claim about every object is decided by the outermost object or the mean.\n",
        "## Accuracy by history\n",
        histories_part(study),
        picture("accuracy-by-history", "Accuracy by history t_h for each object"),
        f"On its own runs to choose on, each training chose: {histories} ms. {study['choice']['why']} The next tables use these choices.\n",
        baselines_part(study),
        variance_sentence(study),
        spread_sentence(study),
        "## Detection\n",
        detection_part(study),
        picture("detection-curve", "Share of presses and slips detected within a time"),
        picture("delays", "Mean delay of each object, as in figure 9 of the paper"),
        labels_sentence(study),
        picture("run", "One run at every tick, as in figure 10 of the paper"),
        picture("over-time", "Correct ticks by the time since the onset and before the end"),
        alarms_part(study),
        "An episode counts again for each further 500 ms. In quantiles a miss counts with the end of its touch, at most 500 ms. The curve is that of Kaplan and Meier. For "
        "this curve a touch that ends undetected might have been detected later, so the curve may end above the share that was detected.\n",
        "## Unseen objects\n",
        unseen_part(study),
        picture("unseen", "Accuracy on objects seen and never seen") if study["unseen"] else "",
        "## What speed costs\n",
        f"{trade['settings']} settings were measured. The table has the usual setting, and the settings on a front: on the runs to choose on, no other setting has a higher accuracy "
        "with a shorter p99, or fewer false alarms with a shorter delay and fewer misses. The figures are of the reported runs. The last column is the share of draws in "
        "which a setting is on a front; the fastest one is always on the first. The trade may train each setting "
        f"{trade['options']['trainings']} times. The intervals of settings with one training are over objects and runs only.\n",
        front_part(trade),
        load_sentence(trade),
        picture("trade-accuracy", "Accuracy against time per tick"),
        picture("trade-delay", "Delay against false alarms"),
        picture("trade-budgets", "The best of each kind of model within a time per tick"),
        f"{trade['usual_is']} {trade['recommendation']['sentence']}\n",
        "## What the paper does not specify\n",
        "The paper names LeNet, t_h, the tick of 2 ms and the factor 0.2. These defaults are ours: ReLU and max-pooling, Adam with a learning rate "
        f"of 0.001 and batches of 32, {settings['epochs']} epochs, area interpolation.\n",
        "## Where the defaults differ from the paper\n",
        "- **Samples of *none*.** The paper draws them from all remaining times. Here they keep 100 ms from every touch, and from every release, "
        "which the paper does not mention. `configs/windows-as-paper.json` lets them reach the edges of both.\n"
        "- **Noise reduction.** The paper's equations 3 and 4 as printed give D = E / (1 + e^(E + b)), which is nearly 0 for every count: it decreases from a count of 1 on. Its text says that "
        "counts well above b become almost 0, and counts well below b stay. The default follows the text: D = E / (1 + e^(E − b)). `configs/heatmaps-as-printed.json` follows the equations.\n",
        "## To repeat it\n",
        f"    scripts/publish-study {repeating(settings, trade)}\n"
        "    scripts/publish-study STUDY TRADE    # this page from folders that exist\n",
    ]
    return wrapped("\n".join(part for part in parts if part))


def publish(study_folder, trade_folder, docs):
    study = json.loads((study_folder / "study.json").read_text())
    trade = json.loads((trade_folder / "trade.json").read_text())
    reported = next(entry for entry in study["evaluations"] if entry["id"] == "reported")
    evaluation = json.loads((study_folder / reported["json"]).read_text())
    folder = docs / "study"
    folder.mkdir(parents=True, exist_ok=True)
    for name, content in (("study", reduced_study(study, evaluation)), ("trade", reduced_trade(trade))):
        (folder / f"{name}.json").write_text(json.dumps(content, indent=1, sort_keys=True) + "\n")
    for source, names in ((study_folder / "report" / "figures", PICTURES), (trade_folder / "figures", TRADE_PICTURES)):
        for name in names:
            if (source / f"{name}.svg").exists():
                shutil.copyfile(source / f"{name}.svg", folder / f"{name}.svg")
    for run in sorted((study_folder / "report" / "figures").glob("run-*.svg"))[:1]:
        shutil.copyfile(run, folder / "run.svg")
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

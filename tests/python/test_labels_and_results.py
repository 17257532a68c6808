import json

import pytest

import tactile


def test_labels_are_those_of_the_file(lab):
    labels = tactile.read_labels(lab.folder / "data/fan/02")
    content = json.loads((lab.folder / "data/fan/02/labels.json").read_text())
    assert [interval.start_us for interval in labels.intervals] == [entry["start_us"] for entry in content["intervals"]]
    assert {interval.touch for interval in labels.intervals} == {"press", "slip"}
    for interval in labels.intervals:
        assert interval.start_low_us <= interval.start_us <= interval.start_high_us < interval.end_us
        assert 0.5 <= interval.probability <= 1
        assert interval.start_low_us <= interval.visible_us <= interval.end_us
    assert labels.flagged == any(not flag["confirmed"] for flag in content["flags"])
    assert labels.remarks == content["remarks"]


def test_labels_that_overlap_are_refused_with_the_sentence_of_the_program(lab, tmp_path):
    content = json.loads((lab.folder / "data/fan/02/labels.json").read_text())
    content["intervals"][1]["start_us"] = content["intervals"][0]["start_us"] + 1
    (tmp_path / "labels.json").write_text(json.dumps(content))
    with pytest.raises(tactile.Error, match="expected"):
        tactile.read_labels(tmp_path / "labels.json")


def test_results_are_those_of_eval(lab):
    result = tactile.read_evaluation(lab.bundle)
    content = json.loads((lab.bundle / "eval.json").read_text())
    assert result.accuracy.value == content["accuracy"]["mean"]["value"]
    assert result.delay["slip"].median_of_all_ms.value == content["delay_ms"]["slip"]["median_of_all"]["value"]
    whole = content["whole_runs"]
    assert result.whole_runs.decided.alarms_per_min.value == whole["decided"]["alarms_per_min"]["value"]
    assert [point.threshold for point in result.whole_runs.curve] == [point["threshold"] for point in whole["curve"]]
    assert list(result.whole_runs.calm) == [20, 6, 2, 0.6] and result.whole_runs.runs == whole["runs"]
    assert result.whole_runs.units == whole["units"] and result.whole_runs.confirmed is None, "a LeNet confirms no slip"
    assert result.whole_runs.left_out == [(run["run"], run["why"]) for run in whole["left_out"]]
    assert set(result.accuracy_by_object) == {"fan", "usb-hub"} and result.baselines["event_rate"].alarms_per_min.value >= 0
    assert sum(map(sum, result.confusion)) == sum(map(sum, content["confusion"]))
    assert result.everything == content


def test_results_are_those_of_a_study(lab):
    short = ("--epochs", "1", "--steps", "2", "--trainings", "1")
    lab.run("reproduce", "--th", "20,40", *short, "--held-out", "fan", "--no-report")
    study = tactile.read_study(lab.folder / "study")
    content = json.loads((lab.folder / "study/study.json").read_text())
    results = {entry["setting"]: entry for entry in content["results"]}
    assert list(study.settings) == ["th020", "th040", "stream", "th040-unseen", "stream-unseen"]
    for name, setting in study.settings.items():
        assert setting.text == results[name]["text"] and setting.is_unseen == name.endswith("-unseen")
        assert setting.accuracy.value == results[name]["accuracy"]["mean"]["value"]
        assert set(setting.accuracy_by_object) == ({"fan"} if setting.is_unseen else {"fan", "usb-hub"})
    assert study.settings["th020"].th_ms == 20 and study.settings["stream"].th_ms is None
    assert study.settings["th020"].whole_runs is None, "only samples are judged"
    stream = results["stream"]["whole_runs"]
    assert study.settings["stream"].whole_runs.runs == stream["runs"] != []
    assert study.settings["stream"].whole_runs.decided.missed.value == stream["decided"]["missed"]["value"]
    assert study.settings["stream"].whole_runs.confirmed.threshold is None
    assert study.unseen_difference["th040"].value == content["unseen"][0]["accuracy"]["mean"]["difference"]["value"]
    (world,) = study.worlds
    assert (world.name, world.held_out) == ("", ["fan"]) and world.samples == content["worlds"][0]["samples"]
    assert len(study.claims) == 14 and {claim.outcome for claim in study.claims} <= {"holds", "does not", "cannot tell"}
    claims = {claim.id: claim for claim in study.claims}
    assert claims["accuracy-at-40"].replicates == 1 and claims["accuracy-at-40"].limit == 95
    assert claims["history-2-worst"].replicates == 0 and claims["history-2-worst"].measured.value is None
    assert study.found == content["found"] and study.cells == "cells.csv" and study.everything == content


def test_results_are_those_of_a_trade(lab):
    trade = tactile.read_trade(lab.folder / "trade/trade.json")
    usual = json.loads((lab.folder / "trade/trade.json").read_text())["points"][0]
    assert trade.points[0].id == usual["id"] and trade.points[0].setting["th_ms"] == 40
    assert trade.points[0].p99_tick_us.value == usual["reported"]["us_p99"]["value"]
    assert trade.points[0].whole_runs.missed.n == usual["reported"]["whole_runs"]["missed"]["n"]
    assert trade.points[0].whole_runs.alarms_per_min.value == usual["reported"]["whole_runs"]["alarms_per_min"]["value"]
    assert trade.points[0].is_on_accuracy_front == usual["on_accuracy_front"]
    assert "No constraint given" in trade.recommendation
    with pytest.raises(tactile.Error, match="is of format 'tactile-trade-2'; expected 'tactile-study-2'"):
        tactile.read_study(lab.folder / "trade/trade.json")
    with pytest.raises(tactile.Error, match="is no JSON text") as error:
        tactile.read_stress(lab.folder / "data/dataset.h5")
    assert len(str(error.value)) < 300


def test_results_are_those_of_a_stress(lab):
    lab.run("stress", "--recipe", "noise:50", "--no-figures", "--model", lab.bundle)
    (curve,) = tactile.read_stress(lab.folder / "stress").curves
    content = json.loads((lab.folder / "stress/stress.json").read_text())["models"][0]["curves"][0]
    assert (curve.name, curve.unit, curve.points[0].severity) == ("noise", content["unit"], 0)
    assert [point.accuracy.value for point in curve.points] == [point["accuracy"]["value"] for point in content["points"]]
    assert curve.points[-1].accuracy_change.value == content["points"][-1]["accuracy_change"]["value"]


def test_a_file_that_is_no_result_is_named(tmp_path):
    with pytest.raises(tactile.Error, match="eval.json: No such file or directory; expected eval.json; 'tactile eval"):
        tactile.read_evaluation(tmp_path)
    (tmp_path / "eval.json").write_text("{}")
    with pytest.raises(tactile.Error, match="'title'"):
        tactile.read_evaluation(tmp_path)
    with pytest.raises(tactile.Error, match="study.json: No such file or directory; expected study.json of 'tactile reproduce'"):
        tactile.read_study(tmp_path)
    (tmp_path / "eval.json").write_text("[1]")
    with pytest.raises(tactile.Error, match="its contents cannot be used"):
        tactile.read_evaluation(tmp_path)

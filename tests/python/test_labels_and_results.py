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
    assert set(result.accuracy_by_object) == {"fan", "usb-hub"} and "majority" in result.baselines
    assert sum(map(sum, result.confusion)) == sum(map(sum, content["confusion"]))
    assert result.everything == content


def test_results_are_those_of_a_study(lab):
    lab.run("reproduce", "--th", "20,40", "--epochs", "1", "--trainings", "1", "--held-out", "fan", "--splits", "0", "--no-report")
    study = tactile.read_study(lab.folder / "study")
    content = json.loads((lab.folder / "study/study.json").read_text())
    assert study.th_ms == content["choice"]["th_ms"] and list(study.accuracy) == [20, 40]
    assert study.accuracy[40].value == content["histories"][1]["accuracy"]["reported"]["mean"]["value"]
    assert study.unseen_difference.value == content["unseen"]["reported"]["mean"]["difference"]["value"]
    assert len(study.claims) == 14 and {claim.verdict for claim in study.claims} <= {"holds", "does not", "cannot tell"}
    assert study.everything == content


def test_results_are_those_of_a_trade(lab):
    trade = tactile.read_trade(lab.folder / "trade/trade.json")
    usual = json.loads((lab.folder / "trade/trade.json").read_text())["points"][0]
    assert trade.points[0].id == usual["id"] and trade.points[0].setting["th_ms"] == 40
    assert trade.points[0].p99_tick_us.value == usual["reported"]["us"]["p99"]["value"]
    assert trade.points[0].missed.n == usual["reported"]["delay_us"]["missed"]["n"]
    assert trade.points[0].false_alarms_per_min.value == usual["reported"]["episodes_per_min"]["value"]
    assert trade.points[0].is_on_accuracy_front == usual["front"]["accuracy"]
    assert "No constraint given" in trade.recommendation
    with pytest.raises(tactile.Error, match="is of format 'tactile-trade-1'; expected 'tactile-study-1'"):
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

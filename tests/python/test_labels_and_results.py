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
    assert result.false_alarms.wrong_class_per_min.value == content["false_alarms"]["wrong_class"]["per_min"]["value"]
    assert set(result.accuracy_by_object) == {"fan", "usb-hub"} and "majority" in result.baselines
    assert sum(map(sum, result.confusion)) == sum(map(sum, content["confusion"]))
    assert result.everything == content


def test_a_file_that_is_no_result_is_named(tmp_path):
    with pytest.raises(tactile.Error, match="eval.json: No such file or directory; expected eval.json of 'tactile eval'"):
        tactile.read_evaluation(tmp_path)
    (tmp_path / "eval.json").write_text("{}")
    with pytest.raises(tactile.Error, match="not as 'tactile eval' writes it"):
        tactile.read_evaluation(tmp_path)

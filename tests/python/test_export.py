"""Exported models in another runtime."""

import pathlib
import re

import numpy as np
import pytest

import tactile

SOURCES = pathlib.Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def stream(lab):
    lab.run("train", "--kind", "stream", "--steps", "10", "--name", "of-ticks")
    lab.run("export", "--model", "of-ticks", "--onnx", "stream.onnx")
    return lab.folder / "models/of-ticks"


def test_a_stream_has_the_engines_logits_in_onnxruntime(lab, stream, monkeypatch):
    pytest.importorskip("onnxruntime")
    monkeypatch.chdir(lab.folder)
    page = (SOURCES / "docs/cli/export.md").read_text()
    (code,) = [block for block in re.findall(r"```py\n(.*?)```", page, re.DOTALL) if "stream.onnx" in block]
    names = {}
    exec(compile(code, "docs/cli/export.md", "exec"), names)

    engine, recording = tactile.Engine(stream), tactile.Recording(lab.recording)
    predicted, tick_us = engine.predict(recording), round(1000 * engine.tick_ms)
    events = recording.events(recording.first_us, recording.last_us + 1)
    tick = events["t"][0] // tick_us * tick_us + tick_us  # the first one after the first event
    ticks = np.arange(tick, predicted.t_us[-1] + 1, tick_us)
    begins = np.concatenate([[0], np.searchsorted(events["t"], ticks)])
    logits = {}
    for t, begin, end in zip(ticks, begins, begins[1:]):
        of_tick = events[begin:end]
        logits[int(t)] = names["logits_of"](of_tick["x"], of_tick["y"], of_tick["on"])
    found = np.array([logits[int(t)] for t in predicted.t_us])
    assert len(found) > 1000 and np.ptp(predicted.logits) > 0.1
    assert np.abs(found - predicted.logits).max() < 1e-5


def test_an_exported_model_is_judged_as_the_model_is(lab, stream):
    lab.run("export", "--model", lab.bundle, "--onnx", "lenet.onnx")
    for bundle, onnx in ((stream, "stream.onnx"), (lab.bundle, "lenet.onnx")):
        lab.run("eval", "--model", bundle)
        lab.run("eval", "--model", onnx)
        trained, exported = (tactile.read_evaluation(folder) for folder in (bundle, lab.folder / f"{onnx}.results"))
        for key in ("accuracy", "confusion", "delay_ms"):
            assert exported.everything[key] == trained.everything[key], key
        assert exported.everything["whole_runs"]["decided"] == trained.everything["whole_runs"]["decided"]

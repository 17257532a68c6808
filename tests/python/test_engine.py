import csv
import shutil
import signal
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import tactile


@pytest.fixture(scope="module")
def engine(lab):
    return tactile.Engine(lab.bundle)


def test_predictions_equal_those_of_eval(lab, engine):
    lab.run("eval", "--model", lab.bundle, "--run", "fan/02")
    (table,) = lab.bundle.rglob("fan-02.csv")
    with open(table) as file:
        rows = list(csv.DictReader(file))
    predicted = engine.predict(tactile.Recording(lab.recording))
    assert [int(row["t_us"]) for row in rows] == predicted.t_us.tolist()
    assert [int(row["events"]) for row in rows] == predicted.events.tolist()
    probabilities = np.array([[float(row[f"p_{name}"]) for name in tactile.CLASSES] for row in rows])
    assert np.abs(probabilities - predicted.probabilities).max() < 2e-6  # as the table rounds them
    assert [row["verdict"] for row in rows] == [tactile.CLASSES[touch] for touch in predicted.classes]


def test_predictions_equal_those_of_detect(lab, engine):
    lab.run("detect", "--model", lab.bundle, "--from", f"file:{lab.recording}", "--speed", "0", "--ticks", "ticks.csv", "--camera-time")
    with open(lab.folder / "ticks.csv") as file:
        detected = {int(row["t_us"]): row for row in csv.DictReader(file)}
    predicted = engine.predict(tactile.Recording(lab.recording))
    both = [i for i, t_us in enumerate(predicted.t_us) if t_us in detected]
    assert len(both) > 0.95 * len(predicted.t_us)  # the first ticks of a stream have no whole history
    rows = [detected[predicted.t_us[i]] for i in both]
    probabilities = np.array([[float(row[f"p_{name}"]) for name in tactile.CLASSES] for row in rows])
    assert np.abs(probabilities - predicted.probabilities[both]).max() < 2e-6  # as the table rounds them
    assert set(np.diff([predicted.t_us[i] for i in both])) == {1000 * engine.tick_ms}
    assert [row["verdict"] for row in rows] == decided_by_two_thresholds(probabilities, engine.tick_ms)


def decided_by_two_thresholds(probabilities, tick_ms, on=2.5, off=-1.5, hold_ms=20):
    """The verdicts of `detect` as `tactile detect --help` and docs/ tell them."""
    p = np.clip(probabilities, 1e-38, None)
    log_odds = {name: np.log(p[:, i] / np.clip(1 - p[:, i], 1e-38, None)) for i, name in enumerate(tactile.CLASSES) if name != "none"}
    verdicts, reported, below_ms = [], "none", 0
    for i in range(len(p)):
        if reported != "none":
            below_ms = below_ms + tick_ms if log_odds[reported][i] < off else 0
            if below_ms >= hold_ms:
                reported = "none"
        likelier = max(log_odds, key=lambda name: log_odds[name][i])
        if likelier != reported and log_odds[likelier][i] >= (on if reported == "none" else 2 * on - off):
            reported, below_ms = likelier, 0
        verdicts.append(reported)
    return verdicts


def test_heatmaps_are_classified_as_events_are(lab, engine):
    recording = tactile.Recording(lab.recording)
    predicted = engine.predict(recording)
    logits = engine.classify(tactile.heatmaps(recording, engine.th_ms, tick_ms=engine.tick_ms).values)
    assert np.array_equal(logits, predicted.logits)
    p = np.exp(logits.astype(np.float64) / engine.temperature)
    assert np.abs(engine.probabilities(logits) - p / p.sum(1, keepdims=True)).max() < 1e-6


def test_a_live_stream_is_classified_as_the_recording_is(lab, engine):
    recording = tactile.Recording(lab.recording)
    predicted = engine.predict(recording)
    stream, logits, next_tick = engine.stream(recording.size), [], 0
    for events in recording.chunks():
        stream.add(events)
        while next_tick < len(predicted.t_us) and predicted.t_us[next_tick] <= events["t"][-1]:
            logits.append(stream.classify(int(predicted.t_us[next_tick])))
            assert stream.events == predicted.events[next_tick]
            next_tick += 1
    assert np.array_equal(np.array(logits), predicted.logits)


def test_threads_may_share_an_engine(lab, engine):
    expected = engine.predict(tactile.Recording(lab.recording)).logits
    with ThreadPoolExecutor(4) as threads:
        for predicted in threads.map(lambda _: engine.predict(tactile.Recording(lab.recording)), range(4)):
            assert np.array_equal(predicted.logits, expected)


def test_other_kinds_and_precisions_are_models_too(lab, engine):
    lab.run("train", "--kind", "stream", "--steps", "10")
    (stream,) = [bundle for bundle in lab.bundles() if bundle != lab.bundle]
    assert tactile.Engine(stream).predict(tactile.Recording(lab.recording)).logits.shape[1] == 3
    with pytest.raises(tactile.Error):
        tactile.Engine(stream).classify(np.zeros((1, 96, 128), np.uint8))
    exact = engine.predict(tactile.Recording(lab.recording))
    for precision in ("bf16", "int8"):
        rounded = tactile.Engine(lab.bundle, precision=precision).predict(tactile.Recording(lab.recording))
        assert 0 < np.abs(rounded.logits - exact.logits).max() < 0.1 * np.abs(exact.logits).max()


def test_what_cannot_be_used_is_named(lab, engine, tmp_path):
    with pytest.raises(tactile.Error, match="expected uint8"):
        engine.classify(np.zeros((1, 96, 128), np.float32))
    with pytest.raises(tactile.Error, match="heatmaps have 95 rows of 128; expected 96 rows of 128"):
        engine.classify(np.zeros((1, 95, 128), np.uint8))
    with pytest.raises(tactile.Error):
        tactile.Engine(tmp_path)
    with pytest.raises(tactile.Error, match="int4"):
        tactile.Engine(lab.bundle, precision="int4")


def test_the_probabilities_of_one_verdict_are_those_of_a_row(lab):
    engine = tactile.Engine(lab.bundle)
    one = engine.probabilities([1, 2, 4])
    assert one.shape == (3,) and np.array_equal(engine.probabilities([[1, 2, 4]])[0], one)
    with pytest.raises(tactile.Error, match="have 3 dimensions"):
        engine.probabilities(np.zeros((1, 1, 3)))


def test_what_is_no_recording_or_time_is_named(lab):
    engine = tactile.Engine(lab.bundle)
    with pytest.raises(tactile.Error, match=r"'events.aedat4' is no recording; expected tactile.Recording\(path\)"):
        engine.predict("events.aedat4")
    with pytest.raises(tactile.Error, match="is no recording"):
        tactile.heatmaps("events.aedat4")
    with pytest.raises(tactile.Error, match="tick_ms -1: expected"):
        engine.predict(tactile.Recording(lab.recording), tick_ms=-1)


@pytest.mark.parametrize(
    "work",
    [
        lambda engine, recording: engine.predict(recording, tick_ms=0.02),
        lambda engine, recording: tactile.heatmaps(recording, tick_ms=0.1),
        lambda engine, recording: tactile.heatmaps(recording, ticks_us=range(recording.first_us + 40_000, recording.last_us, 100)),
    ],
)
def test_a_signal_ends_long_work(lab, engine, work):
    """Without a look at signals, the handler is called once, when the work is done, and raises nothing."""
    calls = []

    def handler(*_):
        calls.append(1)
        if len(calls) == 3:
            raise KeyboardInterrupt

    recording = tactile.Recording(lab.recording)
    before = signal.signal(signal.SIGALRM, handler)
    signal.setitimer(signal.ITIMER_REAL, 0.02, 0.02)
    try:
        with pytest.raises(KeyboardInterrupt):
            work(engine, recording)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
    assert len(engine.predict(recording).t_us) > 1000  # the recording can still be read


def test_reports_a_recording_that_is_replaced_while_it_is_open(lab, tmp_path):
    file = tmp_path / "events.aedat4"
    shutil.copyfile(lab.recording, file)
    recording = tactile.Recording(file)
    shutil.copyfile(lab.folder / "data/usb-hub/01/events.aedat4", file)
    with pytest.raises(tactile.Error, match=f"{file}: (was written to|became shorter) while it was read"):
        tactile.Engine(lab.bundle).predict(recording)

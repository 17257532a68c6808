import csv
import json
import pathlib
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import tactile


def events_of_csv(lab, tmp_path):
    lab.run("convert", lab.recording, tmp_path / "events.csv")
    with open(tmp_path / "events.csv") as file:
        rows = list(csv.reader(file))
    return rows[0], np.array(rows[1:], np.int64)


def test_events_equal_those_that_the_program_converts(lab, tmp_path):
    header, rows = events_of_csv(lab, tmp_path)
    recording = tactile.Recording(lab.recording)
    events = recording.events()
    assert header[1:3] == ["x", "y"]
    assert np.array_equal(np.stack([events["t"], events["x"], events["y"], events["on"]], 1), rows)
    assert (len(recording), recording.first_us, recording.last_us) == (len(rows), rows[0, 0], rows[-1, 0])
    assert recording.size == (640, 480) and recording.problems == {}


def test_a_chunk_is_the_memory_of_its_packet_and_stays_as_it_is(lab):
    recording = tactile.Recording(lab.recording)
    kept = list(recording.chunks())
    assert len(kept) > 10
    for chunk in kept:
        assert not chunk.flags.owndata and chunk.dtype == tactile.EVENT
    assert np.array_equal(np.concatenate(kept), tactile.Recording(lab.recording).events())


def test_a_part_has_the_events_from_its_begin_to_before_its_end(lab):
    recording = tactile.Recording(lab.recording)
    everything = recording.events()
    begin, end = recording.first_us + 500_000, recording.first_us + 700_001
    part = recording.events(begin, end)
    assert np.array_equal(part, everything[(everything["t"] >= begin) & (everything["t"] < end)])
    assert len(part) and len(recording.events(end, begin)) == 0


@pytest.mark.parametrize("listed", [1, 10**15])
def test_the_list_of_packets_may_be_wrong_about_their_events(lab, listed):
    recording = tactile.Recording(lab.recording)
    everything = recording.events()
    (packet, _, first, last), *others = recording._packets
    recording._packets = [(packet, listed, first, last), *others]
    assert np.array_equal(recording.events(), everything)


VENDOR = pathlib.Path(__file__).resolve().parents[1] / "data/aedat4"


@pytest.mark.parametrize("name", ["dv-none", "dv-lz4", "dv-lz4-high", "dv-zstd", "dv-zstd-high"])
def test_all_streams_are_what_the_vendors_library_wrote(name):
    truth = json.loads((VENDOR / "truth.json").read_text())[name]
    recording = tactile.Recording(VENDOR / f"{name}.aedat4")
    events, imu = recording.events(), recording.imu()
    assert (len(events), int(events["on"].sum())) == (truth["events"], truth["on"])
    assert (int(events["x"].sum()), int(events["y"].sum())) == (truth["sum_x"], truth["sum_y"])
    assert (int(events["t"][0]), int(events["t"][-1])) == (truth["first_us"], truth["last_us"])
    assert (len(imu.t), int(imu.t[-1])) == (truth["imu"], truth["imu_last_us"])
    assert imu.acceleration_g.shape == imu.angular_rate_dps.shape == (truth["imu"], 3)
    assert len(recording.triggers().t) == len(recording.triggers().type) == truth["triggers"]
    frames = list(recording.frames())
    assert len(frames) == truth["frames"] and all(frame.pixels.ndim == 3 for frame in frames)
    assert recording.source == truth["source"] and recording.size == (truth["width"], truth["height"])


def test_threads_may_share_a_recording(lab):
    recording = tactile.Recording(lab.recording)
    expected = recording.events()
    with ThreadPoolExecutor(4) as threads:
        for events in threads.map(lambda _: recording.events(), range(8)):
            assert np.array_equal(events, expected)


def test_an_error_is_the_sentence_of_the_program(lab, tmp_path):
    (tmp_path / "no.aedat4").write_bytes(b"nothing of the kind" * 100)
    with pytest.raises(tactile.Error) as error:
        tactile.Recording(tmp_path / "no.aedat4")
    assert str(error.value) in lab.error_of("info", tmp_path / "no.aedat4")
    assert isinstance(error.value, ValueError)


def test_a_damaged_packet_is_left_out_and_counted(lab, tmp_path):
    content = bytearray(lab.recording.read_bytes())
    content[len(content) // 2 : len(content) // 2 + 64] = bytes(64)
    (tmp_path / "damaged.aedat4").write_bytes(content)
    recording = tactile.Recording(tmp_path / "damaged.aedat4")
    assert 0 < len(recording.events()) < len(tactile.Recording(lab.recording).events())
    assert recording.problems


def test_events_are_made_from_columns():
    events = tactile.event_array([1, 2], [3, 4], [5, 6], [True, False])
    assert events.tolist() == [(1, 3, 5, 1), (2, 4, 6, 0)]
    with pytest.raises(tactile.Error, match=r"x: has the shape \(1,\); expected \(2,\)"):
        tactile.event_array([1, 2], [3], [5, 6], [1, 0])
    with pytest.raises(tactile.Error, match="x: 3 to 40000; expected -32768 to 32767"):
        tactile.event_array([1, 2], [3, 40000], [5, 6], [1, 0])


def test_times_in_seconds_are_refused():
    with pytest.raises(tactile.Error, match="t: has values that are no whole numbers; expected microseconds"):
        tactile.event_array([0.5, 1.7], [1, 2], [3, 4], [0, 1])
    with pytest.raises(tactile.Error, match="x: has values that are no whole numbers; expected pixels"):
        tactile.event_array([5, 17], [float("nan"), 2], [3, 4], [0, 1])
    assert tactile.event_array([5.0, 17.0], [1, 2], [3, 4], [0, 1])["t"].tolist() == [5, 17]

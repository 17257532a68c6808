import h5py
import numpy as np
import pytest

import tactile


@pytest.mark.parametrize("th_ms", [20, 40])
def test_heatmaps_equal_those_of_the_dataset_to_the_last_bit(lab, th_ms):
    with h5py.File(lab.folder / "data/dataset.h5") as file:
        stored = file[f"/heatmaps/th_{th_ms:03d}"][:]
        runs = list(zip(file["/runs/object"].asstr()[:], file["/runs/run"].asstr()[:]))
        of_run, ticks = file["/samples/run"][:], file["/samples/t_us"][:]
    for number, (name, run) in enumerate(runs):
        recording = tactile.Recording(lab.folder / "data" / name / run / "events.aedat4")
        rendered = tactile.heatmaps(recording, th_ms, ticks_us=ticks[of_run == number])
        assert np.array_equal(rendered.values, stored[of_run == number])
        assert np.array_equal(rendered.t_us, ticks[of_run == number])


def test_every_tick_is_rendered_as_single_ticks_are(lab):
    recording = tactile.Recording(lab.recording)
    rendered = tactile.heatmaps(recording, 40)
    assert rendered.values.shape == (len(rendered.t_us), 96, 128)
    assert np.array_equal(np.diff(rendered.t_us), np.full(len(rendered.t_us) - 1, 2000))
    some = tactile.heatmaps(recording, 40, ticks_us=rendered.t_us[::97])
    assert np.array_equal(some.values, rendered.values[::97]) and np.array_equal(some.events, rendered.events[::97])
    t = recording.events()["t"]
    assert rendered.events[5] == ((t >= rendered.t_us[5] - 40_000) & (t < rendered.t_us[5])).sum()


def test_a_renderer_of_a_stream_gives_the_same(lab):
    recording = tactile.Recording(lab.recording)
    rendered = tactile.heatmaps(recording, 40)
    renderer = tactile.HeatmapRenderer(recording.size, 40)
    renderer.add(recording.events())
    for tick in (10, 200, 201):
        renderer.move_to(int(rendered.t_us[tick]))
        assert np.array_equal(renderer.render(), rendered.values[tick])
        assert np.abs(renderer.render_exact() - rendered.values[tick]).max() <= 0.5
        assert renderer.events == rendered.events[tick]


def test_events_of_other_libraries_are_taken(lab):
    renderer = tactile.HeatmapRenderer((640, 480), 40)
    events = np.zeros(2, [("timestamp", "<i8"), ("x", "<i2"), ("y", "<i2"), ("polarity", "?")])
    events["timestamp"], events["x"] = [1, 2], [10, 20]
    renderer.add(events)
    renderer.move_to(3)
    assert renderer.events == 2
    with pytest.raises(tactile.Error, match="have no field on; expected t, x, y and on"):
        renderer.add(np.zeros(1, [("t", "<i8"), ("x", "<i2"), ("y", "<i2")]))


def test_settings_and_ticks_that_cannot_be_used_are_named(lab):
    recording = tactile.Recording(lab.recording)
    with pytest.raises(tactile.Error, match="th_ms: 0.0001 is no whole number of us"):
        tactile.heatmaps(recording, 0.0001)
    with pytest.raises(tactile.Error, match="denoise"):
        tactile.heatmaps(recording, denoise="median")
    with pytest.raises(tactile.Error, match="is not inside the recording with its history"):
        tactile.heatmaps(recording, 40, ticks_us=[recording.first_us])
    with pytest.raises(tactile.Error, match="ticks_us descend"):
        tactile.heatmaps(recording, 40, ticks_us=[recording.last_us, recording.first_us + 40_000])
    assert tactile.heatmaps(recording, 40, ticks_us=[]).values.shape == (0, 96, 128)


def test_a_mask_is_given_as_pixels_as_an_array_or_as_a_file(lab):
    recording = tactile.Recording(lab.recording)
    pixels = [(100, 50), (320, 240), (321, 240)]
    masked = tactile.heatmaps(recording, mask=pixels).events
    at = recording.events()
    covered = np.zeros(len(at), bool)
    for x, y in pixels:
        covered |= (at["x"] == x) & (at["y"] == y)
    all_events = tactile.heatmaps(recording)
    tick = all_events.t_us[-1]
    inside = (at["t"] >= tick - 40_000) & (at["t"] < tick)
    assert masked[-1] == (inside & ~covered).sum()
    file = lab.folder / "mask.csv"
    file.write_text("x,y,rate_hz\n" + "".join(f"{x},{y},90\n" for x, y in pixels))
    for mask in (np.array(pixels), file, str(file)):
        assert np.array_equal(tactile.heatmaps(recording, mask=mask).events, masked)
    for none in (None, [], np.empty((0, 2), int)):
        assert np.array_equal(tactile.heatmaps(recording, mask=none).events, all_events.events)
    with pytest.raises(tactile.Error, match="no-mask.csv: "):
        tactile.heatmaps(recording, mask="no-mask.csv")

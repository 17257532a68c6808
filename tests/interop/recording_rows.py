"""Rows about recordings: each side reads the files that the other side has written."""

import importlib.util
import json
import sys

import numpy as np

import contents as c
from made_events import CAMERA, SIZE, dv_events, dv_imu_sample, made_events
from programs import RECORDINGS, contents_by_tactile, run, simulated_run, tactile
from table import Difference, expect_equal, row

COMPRESSIONS = ("none", "lz4", "lz4-high", "zstd", "zstd-high")


@row("recordings of the vendor, read by tactile: digest of all events")
def vendor_files(folder):
    truth = (RECORDINGS / "truth.json").read_text()
    for recording in sorted(RECORDINGS.glob("*.aedat4")):
        digest = contents_by_tactile(recording, folder).digest()
        if digest not in truth:
            raise Difference(f"{recording.name}: digest {digest} is not in truth.json")


def compare_files_of_tactile(folder, read, parts):
    for source in (RECORDINGS / "dv-zstd.aedat4", simulated_run(folder) / "events.aedat4"):
        expected = read(source)
        expected.events = contents_by_tactile(source, folder).events
        for compression in COMPRESSIONS:
            converted = folder / f"{source.stem}-{compression}.aedat4"
            tactile("convert", source, converted, "--compression", compression)
            expect_equal(expected, read(converted), f"{source.name}, {compression}", parts)


@row("files of tactile, read by dv-processing, all compressions", "dv_processing")
def read_by_dv(folder):
    compare_files_of_tactile(folder, c.read_dv, ("events", "imu", "triggers", "frames"))


@row("files of tactile, read by aedat, all compressions", "aedat")
def read_by_aedat(folder):
    compare_files_of_tactile(folder, c.read_aedat, ("events", "imu", "triggers", "frames"))


@row("files of tactile, read by faery, all compressions", "faery")
def read_by_faery(folder):
    compare_files_of_tactile(folder, c.read_faery, ("events",))


@row("files of dv-processing, read by tactile, all compressions", "dv_processing")
def written_by_dv(folder):
    import dv_processing as dv
    events = made_events(20_000)
    for name, compression in dv.CompressionType.__members__.items():
        path = folder / f"dv-{name}.aedat4"
        writer = dv.io.MonoCameraWriter(str(path), dv.io.MonoCameraWriter.DVSConfig(CAMERA, SIZE, compression))
        writer.writeEvents(dv_events(events))
        samples = [dv_imu_sample(int(t)) for t in events["t"][::500]]
        for sample in samples:
            writer.writeImu(sample)
        del writer  # which closes the file
        expect_equal(c.Contents(events), contents_by_tactile(path, folder), name, ("events",))
        converted = folder / f"converted-{name}.aedat4"
        tactile("convert", path, converted)
        expected = c.read_dv(path)
        if len(expected.imu) != len(samples):
            raise Difference(f"{name}: dv-processing wrote {len(expected.imu)} of {len(samples)} IMU samples")
        expect_equal(expected, c.read_dv(converted), f"{name}, converted")


@row("files of faery, read by tactile", "faery")
def written_by_faery(folder):
    import faery
    events = made_events(20_000)
    rows = np.zeros(len(events), faery.EVENTS_DTYPE)
    for name in ("t", "x", "y", "on"):
        rows[name] = events[name]
    for name, compression in (("none", None), ("lz4", ("lz4", 1)), ("zstd", ("zstd", 3))):
        path = folder / f"faery-{name}.aedat4"
        faery.events_stream_from_array(rows, SIZE).to_file(path, compression=compression)
        expect_equal(c.Contents(events), contents_by_tactile(path, folder), name, ("events",))


@row("CSV, NPZ and HDF5 of tactile, read by NumPy and h5py", "h5py")
def other_formats(folder):
    for source in (RECORDINGS / "dv-lz4.aedat4", simulated_run(folder) / "events.aedat4"):
        expected = contents_by_tactile(source, folder)
        npz, hdf5, back = (folder / (source.stem + end) for end in (".npz", ".h5", "-back.aedat4"))
        tactile("convert", source, npz)
        tactile("convert", source, hdf5)
        expect_equal(expected, c.read_npz(npz), "NPZ", ("events",))
        found = c.read_hdf5(hdf5)
        expect_equal(expected, found, "HDF5", ("events",))
        if importlib.util.find_spec("dv_processing"):
            original = c.read_dv(source)
            expect_equal(original, found, "HDF5", ("imu", "triggers"))
            tactile("convert", hdf5, back)
            expect_equal(original, c.read_dv(back), "HDF5 and back", ("events", "imu", "triggers"))


@row("bags of rosbags, converted to runs and read by dv-processing", "rosbags", "dv_processing")
def bags(folder):
    run(sys.executable, RECORDINGS.parent / "bags" / "make_bags.py", folder / "bags")
    truth = json.loads((folder / "bags" / "truth.json").read_text())
    for number, (name, expected) in enumerate(truth.items(), 1):
        place = folder / "runs" / "fan" / f"{number:02}"
        tactile("convert", folder / "bags" / name, place)
        found = c.read_dv(place / "events.aedat4")
        for key, value in (("events", len(found.events)), ("on", int(found.events["on"].sum())),
                           ("sum_x", int(found.events["x"].sum())), ("sum_y", int(found.events["y"].sum()))):
            if expected[key] != value:
                raise Difference(f"{name}: {key} {value}, expected {expected[key]}")

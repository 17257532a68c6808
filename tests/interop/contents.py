"""The contents of a recording in one form, whichever library reads them."""

import hashlib

import numpy as np

EVENT = np.dtype([("t", "<i8"), ("x", "<i4"), ("y", "<i4"), ("on", "u1")])


class Contents:
    """Events in file order; IMU samples as rows of t and ten numbers; triggers as rows of t and type; frames as (t, pixels)."""

    def __init__(self, events=None):
        self.events = np.empty(0, EVENT) if events is None else events
        self.imu = np.empty((0, 11))
        self.triggers = np.empty((0, 2), np.int64)
        self.frames = []
        self.source = None
        self.size = None

    def digest(self):
        """SHA-256 of the events as truth.json of the recordings defines it: per event int64 t, int16 x, int16 y, uint8 on."""
        packed = np.empty(len(self.events), np.dtype([("t", "<i8"), ("x", "<i2"), ("y", "<i2"), ("on", "u1")]))
        for name in packed.dtype.names:
            packed[name] = self.events[name]
        return hashlib.sha256(packed.tobytes()).hexdigest()


def events_from(t, x, y, on):
    events = np.empty(len(t), EVENT)
    events["t"], events["x"], events["y"], events["on"] = t, x, y, on
    return events


def joined(parts, dtype=EVENT):
    return np.concatenate(parts) if parts else np.empty(0, dtype)


def imu_row(sample):
    return [sample.timestamp, sample.temperature,
            sample.accelerometerX, sample.accelerometerY, sample.accelerometerZ,
            sample.gyroscopeX, sample.gyroscopeY, sample.gyroscopeZ,
            sample.magnetometerX, sample.magnetometerY, sample.magnetometerZ]


def events_of_store(store):
    rows = store.numpy()
    return events_from(rows["timestamp"], rows["x"], rows["y"], rows["polarity"])


def read_dv(path):
    import dv_processing as dv
    recording = dv.io.MonoCameraRecording(str(path))
    contents = Contents()
    contents.source = recording.getCameraName()
    events, imu, triggers = [], [], []
    if recording.isEventStreamAvailable():
        contents.size = tuple(recording.getEventResolution())
        while (batch := recording.getNextEventBatch()) is not None:
            events.append(events_of_store(batch))
    if recording.isImuStreamAvailable():
        while (batch := recording.getNextImuBatch()) is not None:
            imu += [imu_row(sample) for sample in batch]
    if recording.isTriggerStreamAvailable():
        while (batch := recording.getNextTriggerBatch()) is not None:
            triggers += [[trigger.timestamp, trigger.type.value] for trigger in batch]
    if recording.isFrameStreamAvailable():
        while (frame := recording.getNextFrame()) is not None:
            contents.frames.append((frame.timestamp, np.array(frame.image)))
    contents.events = joined(events)
    contents.imu = np.array(imu, float).reshape(-1, 11)
    contents.triggers = np.array(triggers, np.int64).reshape(-1, 2)
    return contents


def read_aedat(path):
    """The package numbers the types of triggers itself, in the order of the format."""
    import aedat
    decoder = aedat.Decoder(str(path))
    contents = Contents()
    for stream in decoder.id_to_stream().values():
        if stream["type"] == "events":
            contents.size = (stream["width"], stream["height"])
    events, imu, triggers = [], [], []
    for packet in decoder:
        if "events" in packet:
            rows = packet["events"]
            events.append(events_from(rows["t"].astype(np.int64), rows["x"], rows["y"], rows["on"]))
        elif "imus" in packet:
            rows = packet["imus"]
            imu.append(np.stack([rows[name].astype(float) for name in rows.dtype.names], axis=1))
        elif "triggers" in packet:
            rows = packet["triggers"]
            triggers.append(np.stack([rows[name].astype(np.int64) for name in rows.dtype.names], axis=1))
        elif "frame" in packet:
            contents.frames.append((packet["frame"]["t"], np.array(packet["frame"]["pixels"])))
    contents.events = joined(events)
    contents.imu = np.concatenate(imu) if imu else contents.imu
    contents.triggers = np.concatenate(triggers) if triggers else contents.triggers
    return contents


def read_faery(path):
    import faery
    stream = faery.events_stream_from_file(str(path))
    contents = Contents()
    contents.size = tuple(stream.dimensions())
    rows = stream.to_array()
    contents.events = events_from(rows["t"].astype(np.int64), rows["x"], rows["y"], rows["on"])
    return contents


def read_csv(path):
    """A CSV file of tactile."""
    contents = Contents()
    rows = np.loadtxt(path, dtype=np.int64, delimiter=",", skiprows=1, ndmin=2)
    contents.events = events_from(rows[:, 0], rows[:, 1], rows[:, 2], rows[:, 3])
    return contents


def read_npz(path):
    contents = Contents()
    with np.load(path) as file:
        rows = file["events"]
        contents.events = events_from(rows["t_us"], rows["x"], rows["y"], rows["on"])
        contents.size = tuple(int(side) for side in file["sensor_size"])
    return contents


def read_hdf5(path):
    import h5py
    contents = Contents()
    with h5py.File(path) as file:
        columns = [file["/events/" + name][:] for name in ("t_us", "x", "y", "on")]
        contents.events = events_from(*columns)
        if "/imu/t_us" in file:
            contents.imu = np.column_stack(
                [file["/imu/t_us"][:], file["/imu/temperature_c"][:], file["/imu/acceleration_g"][:],
                 file["/imu/angular_rate_dps"][:], file["/imu/magnetic_field_ut"][:]])
        if "/triggers/t_us" in file:
            contents.triggers = np.column_stack([file["/triggers/t_us"][:], file["/triggers/type"][:]]).astype(np.int64)
    return contents


def difference(expected, found, parts=("events", "imu", "triggers", "frames")):
    """The first difference in words; empty if all named parts are equal."""
    for part in parts:
        a, b = getattr(expected, part), getattr(found, part)
        if len(a) != len(b):
            return f"{len(b)} {part}, expected {len(a)}"
        if part == "frames":
            for i, ((t, pixels), (u, other)) in enumerate(zip(a, b)):
                if t != u or pixels.tobytes() != other.tobytes():
                    return f"frame {i} differs"
        elif part == "imu":
            if not np.array_equal(a.astype(np.float32), b.astype(np.float32)) or not np.array_equal(a[:, 0], b[:, 0]):
                return "IMU samples differ"
        elif not np.array_equal(a, b):
            return f"{part} differ, first at {int(np.argmax(a != b) if part == 'events' else 0)}"
    for part in ("source", "size"):
        a, b = getattr(expected, part), getattr(found, part)
        if a is not None and b is not None and a != b:
            return f"{part} {b}, expected {a}"
    return ""

#!/usr/bin/env python3
"""Shows, as one table, that files and streams of ours and of other libraries' are read by each other with equal contents.

    interop.py TACTILE FAKE_CONTROLLER MODEL_LOGITS TEST_DATA [ROW…]

Ends with 0 if every row is equal, 1 if one is not, 77 if a row could not run because its library is missing.
"""

import importlib.util
import json
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import traceback
from pathlib import Path

import numpy as np

import contents as c
import networks

HERE = Path(__file__).resolve().parent
TACTILE, FAKE, MODEL_LOGITS, DATA = (Path(argument).resolve() for argument in sys.argv[1:5])
COMPRESSIONS = ("none", "lz4", "lz4-high", "zstd", "zstd-high")
PATIENCE = 60  # seconds that anything may take before it counts as stuck
ROWS = []


class Differs(Exception):
    pass


class NoWholeRound(Differs):
    pass


class CannotRun(Exception):
    pass


def row(name, *needs):
    def add(work):
        ROWS.append((name, needs, work))
        return work
    return add


def expect_equal(expected, found, what, parts=("events", "imu", "triggers", "frames")):
    if why := c.difference(expected, found, parts):
        raise Differs(f"{what}: {why}")


def run(*command, cwd=None, expected=0):
    result = subprocess.run([str(part) for part in command], cwd=cwd, capture_output=True, text=True, timeout=5 * PATIENCE,
                            stdin=subprocess.DEVNULL)
    if result.returncode != expected:
        raise Differs(f"{' '.join(map(str, command))}: ended with {result.returncode}: {result.stderr.strip()[-300:]}")
    return result.stdout


def tactile(*arguments, **options):
    return run(TACTILE, *arguments, **options)


class Process:
    """A program that runs beside, ended at the latest when the block is left; its stderr is read all along."""

    def __init__(self, *command):
        self.command = [str(part) for part in command]
        self.text = ""

    def __enter__(self):
        self.process = subprocess.Popen(self.command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                        text=True)
        self.reader = threading.Thread(target=self._read, daemon=True)
        self.reader.start()
        return self

    def _read(self):
        for line in self.process.stdout:
            self.text += line

    def wait_for(self, pattern):
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            if found := re.search(pattern, self.text):
                return found
            if self.process.poll() is not None:
                self.reader.join(PATIENCE)
                if found := re.search(pattern, self.text):
                    return found
                break
            time.sleep(0.02)
        raise Differs(f"{' '.join(self.command)}: never said '{pattern}': {self.text.strip()[-300:]}")

    def ended(self, expected=0):
        code = self.process.wait(PATIENCE)
        self.reader.join(PATIENCE)
        if code != expected:
            raise Differs(f"{' '.join(self.command)}: ended with {code}: {self.text.strip()[-300:]}")

    def interrupt(self):
        self.process.send_signal(signal.SIGINT)

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait()


def free_port():
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


def as_csv(recording, folder):
    """What our own reader says, by way of text."""
    csv = folder / (recording.stem + ".csv")
    tactile("convert", recording, csv, "--force")
    return c.read_csv(csv)


def simulated_run(folder):
    """A run of the simulator's, made once."""
    data = folder.parent / "simulated"
    if not data.exists():
        tactile("simulate", data, "--preset", "tiny", "--objects", "fan", "--runs", "1")
    return data / "fan" / "01"


@row("the vendor's recordings, by our reader: digest of every event as it was written")
def vendor_files(folder):
    truth = json.loads((DATA / "truth.json").read_text())
    text = json.dumps(truth)
    for recording in sorted(DATA.glob("*.aedat4")):
        digest = as_csv(recording, folder).digest()
        if digest not in text:
            raise Differs(f"{recording.name}: digest {digest} is not the truth's")


def files_written_here(folder, read, parts):
    for source in (DATA / "dv-zstd.aedat4", simulated_run(folder) / "events.aedat4"):
        expected = read(source)
        expected.events = as_csv(source, folder).events
        for compression in COMPRESSIONS:
            ours = folder / f"{source.stem}-{compression}.aedat4"
            tactile("convert", source, ours, "--compression", compression)
            expect_equal(expected, read(ours), f"{source.name}, {compression}", parts)


@row("files written here, read by dv-processing, all compressions", "dv_processing")
def ours_by_dv(folder):
    files_written_here(folder, c.read_dv, ("events", "imu", "triggers", "frames"))


@row("files written here, read by aedat, all compressions", "aedat")
def ours_by_aedat(folder):
    files_written_here(folder, c.read_aedat, ("events", "imu", "triggers", "frames"))


@row("files written here, read by faery, all compressions", "faery")
def ours_by_faery(folder):
    files_written_here(folder, c.read_faery, ("events",))


def made_events(count, step_us=7, first_us=1_700_000_000_000_000, size=(640, 480), seed=5):
    random = np.random.default_rng(seed)
    t = first_us + np.cumsum(random.integers(0, 2 * step_us, count))
    return c.events_from(t, random.integers(0, size[0], count), random.integers(0, size[1], count), random.integers(0, 2, count))


def store_of(events):
    import dv_processing as dv
    store = dv.EventStore()
    for t, x, y, on in events.tolist():
        store.push_back(t, x, y, bool(on))
    return store


def imu_of(t):
    import dv_processing as dv
    value = float(t % 1000) / 8
    sample = dv.IMU(t, value, value + 1, value + 2, value + 3, value + 4, value + 5, value + 6, value + 7, value + 8, value + 9)
    return sample


@row("files of dv-processing's writer, read here, all compressions", "dv_processing")
def dv_writes(folder):
    import dv_processing as dv
    events = made_events(20_000)
    for name, compression in dv.CompressionType.__members__.items():
        path = folder / f"dv-{name}.aedat4"
        writer = dv.io.MonoCameraWriter(str(path), dv.io.MonoCameraWriter.DVSConfig("DVXplorer_DXA00007", (640, 480), compression))
        writer.writeEvents(store_of(events))
        samples = [imu_of(int(t)) for t in events["t"][::500]]
        for sample in samples:
            writer.writeImu(sample)
        del writer
        expected = c.Contents()
        expected.events = events
        expect_equal(expected, as_csv(path, folder), name, ("events",))
        ours = folder / f"again-{name}.aedat4"
        tactile("convert", path, ours)
        expected = c.read_dv(path)
        if len(expected.imu) != len(samples):
            raise Differs(f"{name}: the writer lost IMU samples itself")
        expect_equal(expected, c.read_dv(ours), f"{name}, written again")


@row("files of faery's writer, read here", "faery")
def faery_writes(folder):
    import faery
    events = made_events(20_000)
    rows = np.zeros(len(events), faery.EVENTS_DTYPE)
    for name in ("t", "x", "y", "on"):
        rows[name] = events[name]
    expected = c.Contents()
    expected.events = events
    for name, compression in (("none", None), ("lz4", ("lz4", 1)), ("zstd", ("zstd", 3))):
        path = folder / f"faery-{name}.aedat4"
        faery.events_stream_from_array(rows, (640, 480)).to_file(path, compression=compression)
        expect_equal(expected, as_csv(path, folder), name, ("events",))


@row("CSV, NPZ and HDF5 of ours, read by NumPy and h5py", "h5py")
def other_formats(folder):
    for source in (DATA / "dv-lz4.aedat4", simulated_run(folder) / "events.aedat4"):
        expected = as_csv(source, folder)
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


def batches(count, events_each, gap_us):
    """Packets of events laid end to end in time."""
    events = made_events(count * events_each, step_us=max(1, gap_us // events_each))
    return events, [events[i:i + events_each] for i in range(0, len(events), events_each)]


def wait_until(condition):
    """Until it holds, or patience is at its end: what follows then shows what is missing."""
    end = time.monotonic() + PATIENCE
    while not condition() and time.monotonic() < end:
        time.sleep(0.02)


class Child:
    """A copy of this process that does some work and ends."""

    def __init__(self, work):
        self.pid = os.fork()
        if self.pid:
            return
        try:
            work()
            os._exit(0)
        except BaseException:
            traceback.print_exc()
        os._exit(1)

    def __enter__(self):
        return self

    def ended(self):
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            pid, status = os.waitpid(self.pid, os.WNOHANG)
            if pid:
                self.pid = 0
                if status:
                    raise Differs(f"the other library's server ended with status {status}")
                return
            time.sleep(0.02)
        raise Differs("the other library's server does not end")

    def __exit__(self, *_):
        if self.pid:
            os.kill(self.pid, signal.SIGKILL)
            os.waitpid(self.pid, 0)


def serve_by_dv(kind, places, packets, samples, ready, begun, received):
    """Two of dv-processing's servers, for events and IMU of one camera; plays once their clients have begun, and stays until all is `received`."""
    import dv_processing as dv
    event_stream = dv.io.Stream.EventStream(0, "events", "DVXplorer_DXA00007", (640, 480))
    imu_stream = dv.io.Stream.IMUStream(0, "imu", "DVXplorer_DXA00007")
    event_stream.addMetadata("readoutMode", "variable-5000")
    if kind == "unix":
        writers = [dv.io.NetworkWriter(place, stream) for place, stream in zip(places, (event_stream, imu_stream))]
    else:
        for stream in (event_stream, imu_stream):
            stream.setCompression(dv.CompressionType.__members__[kind])
        writers = [dv.io.NetworkWriter("127.0.0.1", place, stream) for place, stream in zip(places, (event_stream, imu_stream))]
    ready.touch()
    wait_until(begun)  # the server counts a client before it serves it; one that has begun to record has read its header
    for packet, pair in zip(packets, samples):
        writers[0].writeEvents(store_of(packet))
        writers[1].writeImu(dv.IMUPacket.ImuVector([imu_of(t) for t in pair]))
    wait_until(received.exists)  # what has left the writers' queues may still be on its way to the socket
    os._exit(0)  # destroying the writers can wait for ever


def network_writers(folder, kind):
    events, packets = batches(200, 500, 5_000)
    samples = [[int(packet["t"][0]), int(packet["t"][-1])] for packet in packets]
    if kind == "unix":
        places = [str(folder / name) for name in ("events.sock", "imu.sock")]
        addresses = [f"unix:{place}" for place in places]
    else:
        places = [free_port(), free_port()]
        addresses = [f"tcp://127.0.0.1:{place}" for place in places]

    out = folder / "runs"
    ready, received = folder / "ready", folder / "received"

    def recorded():
        found = subprocess.run([TACTILE, "info", "--json", out / "fan" / "01" / "events.aedat4"], capture_output=True, text=True, check=False)
        told = json.loads(found.stdout)["recordings"] if found.stdout else []
        return sum(stream["elements"] for recording in told for stream in recording["streams"]) == len(events) + sum(len(pair) for pair in samples)

    begun = (out / "fan" / "01" / "events.aedat4").exists
    with Child(lambda: serve_by_dv(kind, places, packets, samples, ready, begun, received)) as server:
        wait_until(ready.exists)
        with Process(TACTILE, "record", "--from", addresses[0], "--from", addresses[1], "--out", out, "--object", "fan",
                     "--run", "01") as record:
            wait_until(recorded)
            received.touch()
            server.ended()
            record.ended()
    expected = c.Contents()
    expected.events = events
    expected.imu = np.array([c.imu_row(imu_of(t)) for pair in samples for t in pair], float)
    expected.source, expected.size = "DVXplorer_DXA00007", (640, 480)
    expect_equal(expected, c.read_dv(out / "fan" / "01" / "events.aedat4"), kind, ("events", "imu"))
    told = json.loads((out / "fan" / "01" / "run.json").read_text())
    if "variable-5000" not in json.dumps(told["camera"]):
        raise Differs(f"run.json does not tell the read-out mode: {told['camera']}")
    tactile("info", "--check", out / "fan" / "01")


@row("dv-processing's NetworkWriter feeds record: events and IMU, over TCP in every compression, over a socket file", "dv_processing")
def their_writer(folder):
    for kind in ("NONE", "LZ4", "LZ4_HIGH", "ZSTD", "ZSTD_HIGH", "unix"):
        place = folder / kind
        place.mkdir()
        network_writers(place, kind)


def read_network(reader, found, counted):
    """Everything that comes until `counted` events are there."""
    end = time.monotonic() + PATIENCE
    count = 0
    while count < counted and time.monotonic() < end:
        batch = reader.getNextEventBatch()
        if batch is None:
            if not reader.isRunning():
                return
            time.sleep(0.001)
            continue
        found.append(c.events_of_store(batch))
        count += len(found[-1])


@row("serve feeds dv-processing's NetworkReader, two at once, in every compression", "dv_processing")
def their_readers(folder):
    recording = simulated_run(folder) / "events.aedat4"
    expected = as_csv(recording, folder)
    for compression in COMPRESSIONS:
        # A reader that is held up leaves out what its queue cannot hold; of more rounds it has a whole one all the same.
        for rounds in (2, 4, 8):
            try:
                read_by_two(recording, expected, compression, rounds)
                break
            except NoWholeRound:
                if rounds == 8:
                    raise


def read_by_two(recording, expected, compression, rounds):
    """Two readers of one server at once, each of which gets as many events as are in so many rounds."""
    import dv_processing as dv
    with Process(TACTILE, "serve", recording, "--port", "0", "--compression", compression, "--no-wait", "--loop",
                 "--packet-us", "10000") as serve:
        port = int(serve.wait_for(r"tcp://127\.0\.0\.1:(\d+)").group(1))
        readers = [dv.io.NetworkReader("127.0.0.1", port) for _ in range(2)]
        for reader in readers:
            if tuple(reader.getEventResolution()) != (640, 480):
                raise Differs(f"{compression}: the reader sees another resolution")
        found = [[], []]
        threads = [threading.Thread(target=read_network, args=(reader, part, rounds * len(expected.events)))
                   for reader, part in zip(readers, found)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        del readers, reader
        serve.interrupt()
        serve.ended()
    for parts in found:
        check_looped(expected.events, c.joined(parts), compression)


@row("a recording that serve plays once is whole with dv-processing's NetworkReader", "dv_processing")
def served_once(folder):
    import dv_processing as dv
    recording = simulated_run(folder) / "events.aedat4"
    expected = as_csv(recording, folder)
    with Process(TACTILE, "serve", recording, "--port", "0") as serve:
        port = int(serve.wait_for(r"tcp://127\.0\.0\.1:(\d+)").group(1))
        reader = dv.io.NetworkReader("127.0.0.1", port)
        parts = []
        read_network(reader, parts, len(expected.events))
        serve.ended()
    found = c.Contents()
    found.events = c.joined(parts)
    expect_equal(expected, found, "played once", ("events",))


def check_looped(expected, found, what):
    """`found` began anywhere in the recording that goes round: one whole round of it, from its first event on, must be there."""
    key = expected[["x", "y", "on"]]
    rounds = found[["x", "y", "on"]]
    head = key[:2000]
    for start in np.flatnonzero(rounds == key[0]):
        if np.array_equal(rounds[start:start + len(head)], head):
            whole = found[start:start + len(expected)]
            if len(whole) < len(expected):
                continue
            if not np.array_equal(whole[["x", "y", "on"]], key):
                continue  # a reader that was held up lost some of it
            if not np.array_equal(whole["t"] - whole["t"][0], expected["t"] - expected["t"][0]):
                raise Differs(f"{what}: times of a round differ from the recording's")
            if np.any(np.diff(found["t"]) < 0):
                raise Differs(f"{what}: times go back from round to round")
            return
    raise NoWholeRound(f"{what}: no whole round among {len(found)} events")


@row("a bag of rosbags' writer, made into a run and read by dv-processing", "rosbags", "dv_processing")
def bags(folder):
    script = DATA.parent / "bags" / "make_bags.py"
    run(sys.executable, script, folder / "bags")
    truth = json.loads((folder / "bags" / "truth.json").read_text())
    for name, expected in truth.items():
        place = folder / "runs" / "fan" / f"{1 + list(truth).index(name):02}"
        tactile("convert", folder / "bags" / name, place)
        found = c.read_dv(place / "events.aedat4")
        for key, value in (("events", len(found.events)), ("on", int(found.events["on"].sum())),
                           ("sum_x", int(found.events["x"].sum())), ("sum_y", int(found.events["y"].sum()))):
            if expected[key] != value:
                raise Differs(f"{name}: {key} {value}, expected {expected[key]}")


@row("record of a controller beside ur-rtde's own log of it", "rtde_receive")
def robot_log(folder):
    with socket.socket() as probe:  # ur-rtde knows no other port
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind(("127.0.0.1", 30004))
        except OSError as why:
            raise CannotRun(f"port 30004, the only one that ur-rtde asks, is taken: {why}")
    with Process(FAKE, "--port", "30004", "--seconds", "12") as fake:
        fake.wait_for(r"30004")
        theirs = folder / "theirs.csv"
        out = folder / "runs"
        with Process(sys.executable, HERE / "ur_rtde_log.py", "127.0.0.1", "6", theirs) as log:
            with Process(TACTILE, "record", "--from", f"file:{DATA / 'dv-lz4.aedat4'}", "--speed", "0.003", "--robot",
                         "127.0.0.1:30004", "--out", out, "--object", "fan", "--run", "01", "--duration", "5") as record:
                record.ended()
            log.ended()
    run(sys.executable, HERE / "compare_robot_logs.py", out / "fan" / "01" / "robot.csv", theirs)


@row("dv-bridge feeds record, from a recording in the camera's place", "dv_processing")
def bridge(folder):
    recording = DATA / "dv-lz4.aedat4"
    ports = free_port(), free_port()
    out = folder / "runs"
    with Process(sys.executable, HERE.parent.parent / "scripts" / "dv-bridge", "--file", recording, "--port", ports[0],
                 "--imu-port", ports[1]) as source:
        source.wait_for(str(ports[1]))
        with Process(TACTILE, "record", "--from", f"tcp://127.0.0.1:{ports[0]}", "--from", f"tcp://127.0.0.1:{ports[1]}",
                     "--out", out, "--object", "fan", "--run", "01") as record:
            record.ended()
    expect_equal(c.read_dv(recording), c.read_dv(out / "fan" / "01" / "events.aedat4"), "bridge", ("events", "imu"))


HEATMAPS = 1000  # of each kind that a model is asked about
LOGIT_TOLERANCE = 1e-4
NETWORKS = [(activation, pool, 0.2) for activation in ("relu", "tanh", "sigmoid") for pool in ("max", "average")] + [("relu", "max", 0.25)]


class Model:
    """One that was trained here for an epoch, exported, and asked about heatmaps of its dataset's and random ones."""

    def __init__(self, folder, data, activation, pool, factor):
        self.name = f"{activation}-{pool}-{factor}"
        rendering = ("--th", "40", "--factor", factor)
        if not (folder / self.name).exists():
            # Sigmoids learn so slowly that at first they only unlearn what tells heatmaps apart: they are to keep it.
            rate = "1e-5" if activation == "sigmoid" else "1e-3"
            tactile("train", data, "--epochs", "1", "--lr", rate, "--activation", activation, "--pool", pool, "--models", folder, "--name", self.name, *rendering)
        self.onnx, self.safetensors = folder / f"{self.name}.onnx", folder / f"{self.name}.safetensors"
        tactile("export", "--models", folder, "--model", self.name, "--onnx", self.onnx, "--safetensors", self.safetensors, "--force")
        real = real_heatmaps(data, rendering)
        random = np.random.default_rng(1)
        noise = random.integers(0, 256, (HEATMAPS, *real.shape[1:])) * (random.random((HEATMAPS, *real.shape[1:])) < random.random((HEATMAPS, 1, 1)))
        self.heatmaps = np.concatenate([real, noise.astype(np.uint8)])
        self.heatmaps.tofile(folder / "heatmaps")
        run(MODEL_LOGITS, folder / self.name, folder / "heatmaps", folder / "logits")
        self.logits = np.fromfile(folder / "logits", np.float32).reshape(-1, 3)

    def expect_same(self, found, whose):
        if found.shape != self.logits.shape or len(found) < 2 * HEATMAPS:
            raise Differs(f"{self.name}: {whose} {found.shape} logits, ours {self.logits.shape}; wanted for {2 * HEATMAPS} heatmaps")
        apart = float(np.abs(found - self.logits).max())
        # A network of sigmoids that has learned little says nearly the same of all heatmaps: then the logits must be closer still.
        allowed = min(LOGIT_TOLERANCE, float(np.ptp(self.logits, axis=0).min()) / 20)
        if not apart <= allowed:  # NaN is apart too
            raise Differs(f"{self.name}: {whose} logits are up to {apart:.2g} apart from ours, allowed {allowed:.2g}")
        print(f"    {self.name}: {whose} logits of {len(found)} heatmaps are within {apart:.1g} of ours, which span {np.ptp(self.logits):.3g}", flush=True)


def real_heatmaps(data, rendering):
    """Some of every run's."""
    import h5py
    name = json.loads(tactile("heatmaps", data, "--json", *rendering))["histories"][0]["name"]
    with h5py.File(data / "dataset.h5") as file:
        heatmaps = file["heatmaps"][name][:]
    if len(heatmaps) < HEATMAPS:
        raise Differs(f"{data}: {len(heatmaps)} heatmaps, wanted {HEATMAPS}")
    return heatmaps[np.linspace(0, len(heatmaps) - 1, HEATMAPS).astype(int)]


def models(folder):
    """Of every activation and pooling, and of another input size; made once."""
    data, place = folder.parent / "model-data", folder.parent / "models"
    if not data.exists():
        tactile("simulate", data, "--preset", "tiny", "--objects", "fan,sprayer")
        tactile("label", data)
        tactile("windows", data)
    for activation, pool, factor in NETWORKS:
        yield Model(place, data, activation, pool, factor)


@row("models exported to ONNX, run by onnxruntime: logits of real and random heatmaps, every activation and pooling", "onnxruntime", "onnx", "h5py")
def onnx_models(folder):
    import onnx
    import onnxruntime
    onnxruntime.set_default_logger_severity(3)
    for model in models(folder):
        onnx.checker.check_model(onnx.load(model.onnx), full_check=True)
        session = onnxruntime.InferenceSession(str(model.onnx), providers=["CPUExecutionProvider"])
        x = model.heatmaps[:, np.newaxis].astype(np.float32) / np.float32(255)
        found = [session.run(["logits", "probabilities"], {"heatmaps": part}) for part in np.array_split(x, 19)]  # batches of two sizes
        logits, probabilities = (np.concatenate(parts) for parts in zip(*found))
        model.expect_same(logits, "onnxruntime's")
        exponentials = np.exp(logits.astype(float) - logits.max(axis=1, keepdims=True))
        if np.abs(probabilities - exponentials / exponentials.sum(axis=1, keepdims=True)).max() > 1e-5:
            raise Differs(f"{model.name}: the probabilities are not the softmax of the logits")
        told = session.get_modelmeta().custom_metadata_map
        if json.loads(told["classes"]) != ["none", "press", "slip"] or json.loads(told["rendering"])["history_us"] != 40_000:
            raise Differs(f"{model.name}: onnxruntime reads other metadata: {told}")


@row("models exported to safetensors, read by its own library: logits by NumPy, every activation and pooling", "safetensors", "h5py")
def safetensors_models(folder):
    import safetensors
    import safetensors.numpy
    for model in models(folder):
        weights = safetensors.numpy.load_file(model.safetensors)
        with safetensors.safe_open(model.safetensors, "numpy") as file:
            metadata = file.metadata()
        model.expect_same(networks.logits_of(weights, metadata, model.heatmaps), "NumPy's")


def main():
    wanted = sys.argv[5:]
    folder = Path(tempfile.mkdtemp(prefix="tactile-interop-"))
    outcomes = []
    try:
        for number, (name, needs, work) in enumerate(ROWS, 1):
            if wanted and not any(word in name for word in wanted):
                continue
            missing = [need for need in needs if importlib.util.find_spec(need) is None]
            if missing:
                outcomes.append(("SKIPPED", name, f"no {', '.join(missing)} for this Python"))
                continue
            place = folder / f"{number:02}"
            place.mkdir()
            begun = time.monotonic()
            try:
                work(place)
                outcomes.append(("equal", name, f"{time.monotonic() - begun:.1f} s"))
            except CannotRun as why:
                outcomes.append(("SKIPPED", name, str(why)))
            except Differs as why:
                outcomes.append(("DIFFERS", name, str(why)))
            except Exception as error:  # a library's own failure is a row that failed, not the end of the table
                traceback.print_exc()
                outcomes.append(("DIFFERS", name, f"{type(error).__name__}: {error}"))
            print(f"{outcomes[-1][0]:8}{name}  {outcomes[-1][2]}", flush=True)
    finally:
        shutil.rmtree(folder, ignore_errors=True)

    print(f"\n{'':-<100}")
    for outcome, name, why in outcomes:
        print(f"{outcome:8}{name}" + (f"\n        {why}" if outcome != "equal" else ""))
    counts = {kind: sum(outcome == kind for outcome, _, _ in outcomes) for kind in ("equal", "DIFFERS", "SKIPPED")}
    print(f"{counts['equal']} rows equal, {counts['DIFFERS']} differ, {counts['SKIPPED']} skipped")
    return 1 if counts["DIFFERS"] else 77 if counts["SKIPPED"] else 0


sys.exit(main())

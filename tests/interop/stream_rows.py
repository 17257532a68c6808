"""Rows about streams: each side receives what the other side sends."""

import json
import os
import subprocess
import sys
import threading
import time

import numpy as np

import contents as c
from made_events import CAMERA, SIZE, dv_events, dv_imu_sample, made_packets
from programs import RECORDINGS, ROOT, TACTILE, TIMEOUT_S, Child, Process, contents_by_tactile, free_port, simulated_run, tactile, wait_until
from recording_rows import COMPRESSIONS
from table import Difference, expect_equal, row

READOUT_MODE = "variable-5000"
SERVED_AT = r"tcp://127\.0\.0\.1:(\d+)"


class NoWholeRound(Difference):
    """No round of a repeated recording arrived whole."""


def serve_by_dv(kind, places, packets, samples, ready, has_begun, received):
    """Serves events and IMU samples of one camera by two NetworkWriters. Sends once the client has begun; stays until `received` exists."""
    import dv_processing as dv
    streams = dv.io.Stream.EventStream(0, "events", CAMERA, SIZE), dv.io.Stream.IMUStream(0, "imu", CAMERA)
    streams[0].addMetadata("readoutMode", READOUT_MODE)
    if kind == "unix":
        writers = [dv.io.NetworkWriter(place, stream) for place, stream in zip(places, streams)]
    else:
        for stream in streams:
            stream.setCompression(dv.CompressionType.__members__[kind])
        writers = [dv.io.NetworkWriter("127.0.0.1", place, stream) for place, stream in zip(places, streams)]
    ready.touch()
    wait_until(has_begun)  # the writer counts a client before it serves it; a client that records has read the header
    for packet, times in zip(packets, samples):
        writers[0].writeEvents(dv_events(packet))
        writers[1].writeImu(dv.IMUPacket.ImuVector([dv_imu_sample(t) for t in times]))
    wait_until(received.exists)  # a packet that has left the queue of a writer may still be on its way to the socket
    os._exit(0)  # destroying the writers can wait for ever


def elements_in(recording):
    """Events and IMU samples in a file that may still be written."""
    found = subprocess.run([TACTILE, "info", "--json", recording], capture_output=True, text=True, check=False)
    recordings = json.loads(found.stdout)["recordings"] if found.stdout else []
    return sum(stream["elements"] for each in recordings for stream in each["streams"])


def record_from_dv(folder, kind):
    events, packets = made_packets(200, 500, 5_000)
    samples = [[int(packet["t"][0]), int(packet["t"][-1])] for packet in packets]
    if kind == "unix":
        places = [str(folder / name) for name in ("events.sock", "imu.sock")]
        addresses = [f"unix:{place}" for place in places]
    else:
        places = [free_port(), free_port()]
        addresses = [f"tcp://127.0.0.1:{place}" for place in places]

    run = folder / "runs" / "fan" / "01"
    recording = run / "events.aedat4"
    ready, received = folder / "ready", folder / "received"
    with Child(lambda: serve_by_dv(kind, places, packets, samples, ready, recording.exists, received)) as server:
        wait_until(ready.exists)
        with Process(TACTILE, "record", "--from", addresses[0], "--from", addresses[1], "--out", folder / "runs", "--object", "fan",
                     "--run", "01") as record:
            wait_until(lambda: elements_in(recording) == len(events) + 2 * len(packets))
            received.touch()
            server.wait()
            record.wait()
    expected = c.Contents(events)
    expected.imu = np.array([c.imu_row(dv_imu_sample(t)) for times in samples for t in times], float)
    expected.source, expected.size = CAMERA, SIZE
    expect_equal(expected, c.read_dv(recording), kind, ("events", "imu"))
    camera = json.loads((run / "run.json").read_text())["camera"]
    if READOUT_MODE not in json.dumps(camera):
        raise Difference(f"{kind}: run.json does not contain the read-out mode {READOUT_MODE}: {camera}")
    tactile("info", "--check", run)


@row("record from NetworkWriter of dv-processing: events and IMU, by TCP in every compression, by a Unix socket", "dv_processing")
def recorded_from_dv(folder):
    for kind in ("NONE", "LZ4", "LZ4_HIGH", "ZSTD", "ZSTD_HIGH", "unix"):
        place = folder / kind
        place.mkdir()
        record_from_dv(place, kind)


def read_network(reader, batches, count):
    """Adds batches until they hold `count` events, the server ends, or TIMEOUT_S has passed."""
    end = time.monotonic() + TIMEOUT_S
    received = 0
    while received < count and time.monotonic() < end:
        batch = reader.getNextEventBatch()
        if batch is None:
            if not reader.isRunning():
                return
            time.sleep(0.001)
            continue
        batches.append(c.events_of_store(batch))
        received += len(batches[-1])


@row("serve to two NetworkReaders of dv-processing at once, in every compression", "dv_processing")
def served_to_two(folder):
    recording = simulated_run(folder) / "events.aedat4"
    expected = contents_by_tactile(recording, folder)
    for compression in COMPRESSIONS:
        # A reader that is delayed leaves out what its queue cannot hold. Among more rounds one is whole.
        for rounds in (2, 4, 8):
            try:
                serve_to_two(recording, expected, compression, rounds)
                break
            except NoWholeRound:
                if rounds == 8:
                    raise


def serve_to_two(recording, expected, compression, rounds):
    """Two readers receive as many events as the recording has in so many rounds."""
    import dv_processing as dv
    with Process(TACTILE, "serve", recording, "--port", "0", "--compression", compression, "--no-wait", "--loop",
                 "--packet-us", "10000") as serve:
        port = int(serve.wait_for(SERVED_AT).group(1))
        readers = [dv.io.NetworkReader("127.0.0.1", port) for _ in range(2)]
        for reader in readers:
            if tuple(reader.getEventResolution()) != SIZE:
                raise Difference(f"{compression}: the reader gets the resolution {reader.getEventResolution()}, expected {SIZE}")
        received = [[], []]
        threads = [threading.Thread(target=read_network, args=(reader, batches, rounds * len(expected.events)))
                   for reader, batches in zip(readers, received)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        del readers, reader
        serve.interrupt()
        serve.wait()
    for batches in received:
        check_rounds(expected.events, c.joined(batches), compression)


def check_rounds(expected, found, what):
    """`found` begins anywhere in a recording that is repeated. It must contain one whole round, from the first event on."""
    key = expected[["x", "y", "on"]]
    rounds = found[["x", "y", "on"]]
    head = key[:2000]
    for start in np.flatnonzero(rounds == key[0]):
        if not np.array_equal(rounds[start:start + len(head)], head):
            continue
        whole = found[start:start + len(expected)]
        if len(whole) < len(expected) or not np.array_equal(whole[["x", "y", "on"]], key):
            continue  # the end, or a round of which a delayed reader left something out
        if not np.array_equal(whole["t"] - whole["t"][0], expected["t"] - expected["t"][0]):
            raise Difference(f"{what}: times of a round differ from those of the recording")
        if np.any(np.diff(found["t"]) < 0):
            raise Difference(f"{what}: times descend from one round to the next")
        return
    raise NoWholeRound(f"{what}: no whole round among {len(found)} events")


@row("serve a recording once to NetworkReader of dv-processing: every event arrives", "dv_processing")
def served_once(folder):
    import dv_processing as dv
    recording = simulated_run(folder) / "events.aedat4"
    expected = contents_by_tactile(recording, folder)
    with Process(TACTILE, "serve", recording, "--port", "0") as serve:
        port = int(serve.wait_for(SERVED_AT).group(1))
        reader = dv.io.NetworkReader("127.0.0.1", port)
        batches = []
        read_network(reader, batches, len(expected.events))
        serve.wait()
    expect_equal(expected, c.Contents(c.joined(batches)), "played once", ("events",))


@row("record from dv-bridge, which serves a recording instead of a camera", "dv_processing")
def recorded_from_bridge(folder):
    recording = RECORDINGS / "dv-lz4.aedat4"
    ports = free_port(), free_port()
    with Process(sys.executable, ROOT / "scripts" / "dv-bridge", "--file", recording, "--port", ports[0], "--imu-port", ports[1]) as bridge:
        bridge.wait_for(str(ports[1]))
        with Process(TACTILE, "record", "--from", f"tcp://127.0.0.1:{ports[0]}", "--from", f"tcp://127.0.0.1:{ports[1]}",
                     "--out", folder / "runs", "--object", "fan", "--run", "01") as record:
            record.wait()
    expect_equal(c.read_dv(recording), c.read_dv(folder / "runs" / "fan" / "01" / "events.aedat4"), "bridge", ("events", "imu"))

"""Reads one recording with other libraries and with tactile, in turn. Prints a table of the medians.

    recording_peers.py RECORDING RECORDING_BENCHMARK [REPETITIONS]

Every reader reads all events of the file once. The start of Python or of a process is not counted.
"""

import statistics
import subprocess
import sys
import time


def dv_processing(path):
    import dv_processing

    recording = dv_processing.io.MonoCameraRecording(path)
    count = 0
    while True:
        batch = recording.getNextEventBatch()
        if batch is None:
            return count
        count += batch.size()


def aedat(path):
    import aedat

    return sum(len(packet["events"]) for packet in aedat.Decoder(path) if "events" in packet)


def faery(path):
    import faery

    return sum(len(packet) for packet in faery.events_stream_from_file(path))


def tactile(benchmark, threads):
    def read(path):
        count, seconds = subprocess.run([benchmark, "--read", path, str(threads)], check=True, capture_output=True, text=True).stdout.split()
        return int(count), float(seconds)

    return read


def timed(read, path):
    """(events, seconds)"""
    begin = time.perf_counter()
    result = read(path)
    seconds = time.perf_counter() - begin
    return result if isinstance(result, tuple) else (result, seconds)


def main():
    path, benchmark = sys.argv[1:3]
    repetitions = int(sys.argv[3]) if len(sys.argv) > 3 else 9
    readers = {
        "tactile, one thread": tactile(benchmark, 1),
        "tactile, two threads": tactile(benchmark, 2),
        "dv-processing": dv_processing,
        "faery": faery,
        "aedat": aedat,
    }
    seconds = {name: [] for name in readers}
    counts = {}
    for _ in range(repetitions):
        for name, read in list(readers.items()):
            try:
                counts[name], elapsed = timed(read, path)
            except Exception as error:  # another library failed: the others are still measured
                print(f"bench: {name} failed: {error}", file=sys.stderr)
                del readers[name]
                continue
            seconds[name].append(elapsed)
    if len(set(counts.values())) > 1:
        print(f"bench: the readers found different numbers of events: {counts}", file=sys.stderr)
    print("| reader | million events/s |\n| --- | ---: |")
    for name in readers:
        print(f"| {name} | {counts[name] / statistics.median(seconds[name]) / 1e6:.0f} |")


main()

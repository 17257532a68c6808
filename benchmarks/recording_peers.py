"""Reads one recording with other libraries and with tactile, in turn. Prints a table of the medians.

    recording_peers.py RECORDING RECORDING_BENCHMARK [REPETITIONS]

Every reader reads all events of the file once. The start of Python or of a process is not counted.
"""

import statistics
import subprocess
import sys
import time


def dv_processing(path):
    """The events, a packet at a time, as the library gives them. So do `aedat` and `faery`."""
    import dv_processing

    recording = dv_processing.io.MonoCameraRecording(path)
    while (batch := recording.getNextEventBatch()) is not None:
        yield batch


def aedat(path):
    import aedat

    return (packet["events"] for packet in aedat.Decoder(path) if "events" in packet)


def faery(path):
    import faery

    return faery.events_stream_from_file(path)


def tactile(benchmark, threads):
    def read(path):
        count, seconds = subprocess.run([benchmark, "--read", path, str(threads)], check=True, capture_output=True, text=True).stdout.split()
        return int(count), float(seconds)

    return read


def timed(packets_of):
    def read(path):
        begin = time.perf_counter()
        count = sum(len(packet) for packet in packets_of(path))
        return count, time.perf_counter() - begin

    return read


def main():
    path, benchmark = sys.argv[1:3]
    repetitions = int(sys.argv[3]) if len(sys.argv) > 3 else 9
    readers = {  # path -> (events, seconds)
        "tactile, one thread": tactile(benchmark, 1),
        "tactile, two threads": tactile(benchmark, 2),
        "dv-processing": timed(dv_processing),
        "faery": timed(faery),
        "aedat": timed(aedat),
    }
    seconds = {name: [] for name in readers}
    counts = {}
    for _ in range(repetitions):
        for name, read in list(readers.items()):
            try:
                counts[name], elapsed = read(path)
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


if __name__ == "__main__":
    main()

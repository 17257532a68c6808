#!/usr/bin/env python3
"""Reads recordings with the Python module of tactile and with other libraries, and makes pictures of one. Prints tables.

    python_peers.py SHORT_RECORDING RECORDING…     with a Python that has the module tactile, tonic, aedat, dv-processing and faery

Each RECORDING is read into NumPy arrays, opening included: into one array, and packet by packet. SHORT_RECORDING is read and rendered: one picture
every 2 ms of the 40 ms before it, all in one array. Every library has a process of its own; all work in turn. Times are CPU times of the process
with all its threads, imports not included. A ratio is the median of the ratios of neighbours. Memory is the peak beyond that of the imported
library. A library that finds other events, or puts others into its pictures, is named.
"""

import importlib.metadata
import os
import pathlib
import platform
import statistics
import sys
import time

import recording_peers
from workers import Worker, answer_each_line, in_turn, median_ratio

ROUNDS = 11
EVENTS_A_TURN = 2_000_000  # small recordings are read several times in a turn
HISTORY_US, TICK_US = 40_000, 2_000
PACKAGES = ("tactile", "tonic", "aedat", "dv-processing", "faery", "numpy")


# Readers: what reads a path into one array, or into an array per packet.


def tactile_whole():
    import tactile
    return lambda path: [tactile.Recording(path).events()]


def tactile_packets():
    import tactile
    return lambda path: tactile.Recording(path).chunks()


def dv_store(path):
    import dv_processing
    store = dv_processing.EventStore()
    for batch in recording_peers.dv_processing(path):
        store.add(batch)
    return store


def dv_whole():
    import dv_processing  # noqa: F401
    return lambda path: [dv_store(path).numpy()]


def dv_packets():
    import dv_processing  # noqa: F401
    return lambda path: (batch.numpy() for batch in recording_peers.dv_processing(path))


def faery_whole():
    import faery
    return lambda path: [faery.events_stream_from_file(path).to_array()]


def faery_packets():
    import faery  # noqa: F401
    return recording_peers.faery


def tonic_whole():
    import tonic.io
    return lambda path: [tonic.io.read_aedat4(path)]


READERS = {
    "one array": {"tactile": tactile_whole, "dv-processing": dv_whole, "faery": faery_whole, "tonic": tonic_whole},
    "an array per packet": {"tactile": tactile_packets, "dv-processing": dv_packets, "faery": faery_packets},
}


# Renderers: each makes pictures of a path, the size of its sensor and the ticks, and returns a function. After the clock has
# stopped, that gives the number of pictures, the number of events in all of them, and the number of pixels that are not 0; None
# stands for what a library does not give.


def of_counts(pictures):
    import numpy as np
    return len(pictures), int(pictures.sum(dtype=np.int64)), int(np.count_nonzero(pictures))


def tactile_heatmaps():
    import tactile

    def render(path, size, ticks):
        rendered = tactile.heatmaps(tactile.Recording(path), HISTORY_US / 1000, tick_ms=TICK_US / 1000)
        return lambda: (len(rendered.values), int(rendered.events.sum()), None)
    return render


def tactile_full_size():
    import numpy as np
    import tactile

    def render(path, size, ticks):
        rendered = tactile.heatmaps(tactile.Recording(path), HISTORY_US / 1000, tick_ms=TICK_US / 1000, denoise="none", factor=1)
        return lambda: (len(rendered.values), int(rendered.events.sum()), int(np.count_nonzero(rendered.values)))
    return render


def tonic_frames():
    import numpy as np
    import tonic.io
    import tonic.transforms

    def render(path, size, ticks):
        events = tonic.io.read_aedat4(path)
        events.dtype = np.dtype([("t", "u8"), ("x", "u2"), ("y", "u2"), ("p", "?")])  # ToFrame needs p, which its own reader calls on
        events["p"] = 0  # one channel: brighter and darker count alike
        to_frame = tonic.transforms.ToFrame((*size, 1), time_window=HISTORY_US, overlap=HISTORY_US - TICK_US,
                                            start_time=ticks[0] - HISTORY_US, end_time=ticks[-1])
        frames = to_frame(events)
        return lambda: of_counts(frames)
    return render


def dv_frames(accumulate):
    """Pictures by `accumulate`, of slices of an EventStore."""
    import numpy as np

    def render(path, size, ticks):
        store, picture_of = dv_store(path), accumulate(size)
        frames = np.empty((len(ticks), size[1], size[0]), np.uint8)
        for frame, tick in zip(frames, ticks):
            frame[:] = picture_of(store.sliceTime(tick - HISTORY_US, tick))
        return lambda: of_counts(frames)
    return render


def dv_accumulator():
    import dv_processing

    def accumulate(size):
        accumulator = dv_processing.Accumulator(size, dv_processing.Accumulator.Decay.NONE, decayParam=0, synchronousDecay=False,
                                                eventContribution=1, maxPotential=255, neutralPotential=0, minPotential=0, rectifyPolarity=True)

        def picture_of(events):
            accumulator.clear()
            accumulator.accept(events)
            return accumulator.generateFrame().image
        return picture_of
    return dv_frames(accumulate)


def dv_edge_map():
    import dv_processing

    def accumulate(size):
        accumulator = dv_processing.EdgeMapAccumulator(size, contribution=1 / 255, ignorePolarity=True, neutralValue=0, decay=1)

        def picture_of(events):
            accumulator.accept(events)
            return accumulator.generateFrame().image
        return picture_of
    return dv_frames(accumulate)


def faery_render():
    import faery
    import numpy as np

    def render(path, size, ticks):
        stream = faery.events_stream_from_file(path).regularize(1e6 / TICK_US)
        frames = stream.render(decay="window", tau=HISTORY_US * faery.us, colormap=faery.colormaps_list()[0])
        pictures = np.empty((len(ticks), size[1], size[0], 4), np.uint8)
        for picture, frame in zip(pictures, frames):
            picture[:] = frame.pixels
        return lambda: (len(pictures), None, None)
    return render


RENDERERS = {
    "tactile.heatmaps, full size, not denoised": tactile_full_size,
    "tactile.heatmaps": tactile_heatmaps,
    "tonic ToFrame": tonic_frames,
    "dv-processing Accumulator": dv_accumulator,
    "dv-processing EdgeMapAccumulator": dv_edge_map,
    "faery render": faery_render,
}


# In the process of a library.


def memory_kib(key):
    with open("/proc/self/status") as status:
        return next(int(line.split()[1]) for line in status if line.startswith(key))


class Cost:
    """CPU seconds of what runs inside, and the peak of memory [MiB] beyond that before it."""

    def __enter__(self):
        with open("/proc/self/clear_refs", "w") as refs:
            refs.write("5")  # the peak begins at what is used now
        self.memory = memory_kib("VmRSS")
        self.begin = time.process_time()
        return self

    def __exit__(self, *_):
        self.seconds = time.process_time() - self.begin
        self.mib = (memory_kib("VmHWM") - self.memory) / 1024


def sums_of(arrays):
    """The number of events, and the sums of t, x and y."""
    sums = [0, 0, 0, 0]
    for events in arrays:
        time_name = "timestamp" if "timestamp" in events.dtype.names else "t"
        sums = [a + b for a, b in zip(sums, (len(events), *(int(events[name].sum(dtype="i8")) for name in (time_name, "x", "y"))))]
    return ",".join(map(str, sums))


def work(kind, name, path, *arguments):
    """For each line: CPU seconds for one reading or one picture, memory [MiB], and what was found."""
    if kind == "pictures":
        width, height, first, count = map(int, arguments)
        ticks = [first + TICK_US * i for i in range(count)]
        render = RENDERERS[name]()

        def answer(_):
            with Cost() as cost:
                found = render(path, (width, height), ticks)
            return f"{cost.seconds / count} {cost.mib} {','.join(map(str, found()))}"
    else:
        read = READERS[kind][name]()
        times = int(arguments[0])
        found = sums_of(read(path))

        def answer(_):
            with Cost() as cost:
                for _ in range(times):
                    for events in read(path):
                        len(events)
                    del events
            return f"{cost.seconds / times} {cost.mib} {found}"
    answer_each_line(answer)


# In the process that prints.


def measured(kind, names, *arguments):
    """{name: (seconds of each round, largest memory [MiB], what was found)} of the libraries that work."""
    workers, results = {}, {}
    for name in names:
        workers[name] = Worker((sys.executable, __file__, "--work", kind, name, *arguments), {})
        if not (workers[name].is_ready and workers[name].ask()):  # the first time is not measured
            print(f"bench: SKIPPED {name}: it fails on {arguments[0]}", file=sys.stderr)
            del workers[name]
    for name in in_turn(workers, ROUNDS):
        seconds, mib, found = workers[name].ask()
        times, most, _ = results.setdefault(name, ([], 0, ""))
        times.append(float(seconds))
        results[name] = (times, max(most, float(mib)), found)
    for worker in workers.values():
        worker.end()
    return {name: results[name] for name in names if name in results}


def name_differences(kind, path, results):
    """Names the libraries that found something else than the first one did."""
    first, *others = results
    for name in others:
        ours, theirs = results[first][2].split(","), results[name][2].split(",")
        if any(a != b for a, b in zip(ours, theirs) if "None" not in (a, b)):
            print(f"bench: {kind}, {path}: {name} found {results[name][2]}; {first} {results[first][2]}", file=sys.stderr)


def print_readers(paths, counts):
    print("| million events/s (ratio of times) | " + " | ".join(pathlib.Path(path).stem for path in paths) + " | memory [MiB] |")
    print("| --- |" + " ---: |" * (len(paths) + 1))
    for kind, readers in READERS.items():
        results = []
        for path, count in zip(paths, counts):
            results.append(measured(kind, readers, path, max(1, round(EVENTS_A_TURN / count))))
            name_differences(kind, path, results[-1])
        for name in readers:
            cells = []
            for result, count in zip(results, counts):
                if name not in result:
                    cells.append("–")
                    continue
                times = result[name][0]
                ratio = "" if name == "tactile" else f" ({median_ratio(times, result['tactile'][0]):.1f})"
                cells.append(f"{count / statistics.median(times) / 1e6:.0f}{ratio}")
            memory = f"{results[0][name][1]:.0f}" if name in results[0] else "–"
            print(f"| {name}, {kind} | " + " | ".join(cells) + f" | {memory} |", flush=True)


def print_renderers(path):
    import tactile
    recording = tactile.Recording(path)
    ticks = tactile.heatmaps(recording, HISTORY_US / 1000, tick_ms=TICK_US / 1000).t_us
    results = measured("pictures", RENDERERS, path, *recording.size, ticks[0], len(ticks))
    name_differences("pictures", path, results)
    base = results["tactile.heatmaps, full size, not denoised"][0]
    print(f"\n{len(ticks)} pictures of {len(recording)} events, {(recording.last_us - recording.first_us) / 1e6:.1f} s:\n")
    print("| pictures | ms each | interquartile range | ratio to full size | memory [MiB] |\n| --- | ---: | ---: | ---: | ---: |")
    for name, (times, mib, _) in results.items():
        ms = sorted(1000 * seconds for seconds in times)
        quarter = len(ms) // 4
        print(f"| {name} | {statistics.median(ms):.3f} | {ms[quarter]:.3f}–{ms[-1 - quarter]:.3f} | {median_ratio(times, base):.1f} | {mib:.0f} |")


def main():
    if sys.argv[1] == "--work":
        return work(*sys.argv[2:])
    import tactile
    short, *paths = sys.argv[1:]
    counts = [len(tactile.Recording(path)) for path in paths]
    print(", ".join(f"{package} {importlib.metadata.version(package)}" for package in PACKAGES) + f", Python {platform.python_version()}")
    print("; ".join(f"{path}: {count} events, {os.path.getsize(path)} bytes" for path, count in zip(paths, counts)) + "\n")
    print_readers(paths, counts)
    print_renderers(short)


main()

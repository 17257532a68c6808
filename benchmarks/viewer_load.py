#!/usr/bin/env python3
"""Measures what the live page costs: `tactile record` of 10 million events/s and `tactile detect` of 0.3 million, each without a page,
with a page without a viewer, and with one viewer, in turn. Prints two tables: the median of the turns [the lowest, the highest].

    viewer_load.py PROGRAMS RECORDING MODEL SECONDS FOLDER     FOLDER takes the recorded runs; each measurement takes SECONDS

TACTILE_BENCH_TURNS is the number of turns (3).

The viewer takes what a browser takes: every message, and after each new number both pictures. It draws nothing.
"""

import http.client
import json
import os
import pathlib
import re
import shutil
import statistics
import subprocess
import sys
import threading
import time

from loads import StreamGenerator

TURNS = int(os.environ.get("TACTILE_BENCH_TURNS", "3"))
PAGES = ["no page", "page, no viewer", "page, one viewer"]


class Viewer:
    """Looks at a page until the program ends."""

    def __init__(self, port):
        self.port, self.messages, self.pictures, self.bytes = port, 0, 0, 0
        self.thread = threading.Thread(target=self.look, daemon=True)
        self.thread.start()

    def look(self):
        stream = http.client.HTTPConnection("127.0.0.1", self.port)
        stream.request("GET", "/api/live")
        answer, seen = stream.getresponse(), 0
        pictures = http.client.HTTPConnection("127.0.0.1", self.port)
        try:
            while line := answer.readline():
                if not line.startswith(b"data: "):
                    continue
                message = json.loads(line[6:])
                self.messages += 1
                self.bytes += len(line)
                number = message["live"]["picture"]
                if message["ended"]:
                    return
                if number == seen:
                    continue
                seen = number
                self.pictures += 1
                for kind in ("events", "heatmap"):
                    pictures.request("GET", f"/api/live/{kind}")
                    self.bytes += len(pictures.getresponse().read())
        except (OSError, http.client.HTTPException):
            pass  # the program has ended


def run(command, page, option):
    """Runs a command with or without a page. Returns what it printed, its duration [s], and the viewer."""
    if page != PAGES[0]:
        command = [*command, option, "0"]
    begin = time.monotonic()
    process = subprocess.Popen([str(part) for part in command], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, stdin=subprocess.DEVNULL)
    viewer, log = None, []

    def read_log():
        nonlocal viewer
        for line in process.stderr:
            log.append(line)
            if page == PAGES[2] and viewer is None and (found := re.search(r"http://127\.0\.0\.1:(\d+)/", line)):
                viewer = Viewer(int(found.group(1)))

    reader = threading.Thread(target=read_log, daemon=True)
    reader.start()
    out = process.stdout.read()
    status = process.wait()
    reader.join()
    if status != 0:
        sys.exit("bench: " + "".join(log))
    return json.loads(out), time.monotonic() - begin, viewer


def seen_by(viewer, seconds):
    """Messages, pictures and MB per second; nothing without a viewer."""
    return (None,) * 3 if viewer is None else (viewer.messages / seconds, viewer.pictures / seconds, viewer.bytes / seconds / 1e6)


def record_row(programs, recording, seconds, folder, page):
    run_folder = folder / "viewer" / "01"
    shutil.rmtree(run_folder.parent, ignore_errors=True)
    with StreamGenerator(programs, recording, 10, seconds) as generator:
        _, passed, viewer = run([f"{programs}/tactile", "record", "--from", f"tcp://127.0.0.1:{generator.port}", "--duration", seconds + 10, "--object",
                                 "viewer", "--run", "01", "--out", folder, "--json"], page, "--preview")
        sent = generator.sent()
    info = json.loads((run_folder / "run.json").read_text())
    recorded = sum(stream["elements"] for stream in json.loads(
        subprocess.run([f"{programs}/tactile", "info", "--json", run_folder], stdout=subprocess.PIPE).stdout)["recordings"][0]["streams"])
    shutil.rmtree(run_folder.parent)
    return (sent["events"] / sent["seconds"] / 1e6, sent["latest_ms"], sent["events"] - recorded, info["dropped"].get("events", 0),
            *seen_by(viewer, passed))


def detect_row(programs, recording, model, seconds, page):
    with StreamGenerator(programs, recording, 0.3, seconds) as generator:
        found, passed, viewer = run([f"{programs}/tactile", "detect", "--model", model, "--from", f"tcp://127.0.0.1:{generator.port}", "--reconnect", "0",
                                     "--json"], page, "--page")
        generator.sent()
    work, answer = found["latency_us"]["work"], found["latency_us"]["answer"]
    return (work["p50"], work["p99"], work["p999"], answer["p99"], 100 * found["ticks"]["missed_share"], 100 * found["cpu_s"] / found["elapsed_s"],
            *seen_by(viewer, passed))


def words_of(values, digits):
    """The median of the turns, and the lowest and the highest where they differ."""
    if values[0] is None:
        return "-"
    low, middle, high = (f"{value:.{digits}f}" for value in (min(values), statistics.median(values), max(values)))
    return middle if low == high else f"{middle} [{low}, {high}]"


def table(title, columns, digits, row_of):
    """Measures each page in turn, TURNS times, so that other load meets all of them."""
    rows = {page: [] for page in PAGES}
    for _ in range(TURNS):
        for page in PAGES:
            rows[page].append(row_of(page))
    print(f"| {title} | " + " | ".join(columns) + " |\n| --- |" + " ---: |" * len(columns))
    for page, turns in rows.items():
        print(f"| {page} | " + " | ".join(words_of(values, places) for values, places in zip(zip(*turns), digits)) + " |", flush=True)


def main():
    programs, recording, model, seconds, folder = sys.argv[1:6]
    table("`record`, 10 million events/s", ["sent [million/s]", "latest [ms]", "missing", "dropped", "messages/s", "pictures/s", "MB/s"],
          [2, 1, 0, 0, 1, 1, 1], lambda page: record_row(programs, recording, int(seconds), pathlib.Path(folder), page))
    print()
    table("`detect`, 0.3 million events/s",
          ["work p50 [µs]", "p99", "p99.9", "closed to reported p99", "missed [%]", "CPU [%]", "messages/s", "pictures/s", "MB/s"],
          [0, 0, 0, 0, 3, 1, 1, 1, 1], lambda page: detect_row(programs, recording, model, int(seconds), page))


main()

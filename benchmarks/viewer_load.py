#!/usr/bin/env python3
"""Measures what the live page costs: `tactile record` of 10 million events/s and `tactile detect` of 0.3 million, each without a page,
with a page without a viewer, and with one viewer. Prints two tables.

    viewer_load.py PROGRAMS RECORDING MODEL SECONDS FOLDER     FOLDER takes the recorded runs; each row takes SECONDS

The viewer takes what a browser takes: every message, and after each new number both pictures. It draws nothing.
"""

import http.client
import json
import pathlib
import re
import shutil
import subprocess
import sys
import threading
import time

from loads import StreamGenerator

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


def words_of(viewer, seconds):
    if viewer is None:
        return "- | - | -"
    return f"{viewer.messages / seconds:.1f} | {viewer.pictures / seconds:.1f} | {viewer.bytes / seconds / 1e6:.1f}"


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
    print(f"| {page} | {sent['events'] / sent['seconds'] / 1e6:.2f} | {sent['latest_ms']} | {sent['events'] - recorded} | "
          f"{info['dropped'].get('events', 0)} | {words_of(viewer, passed)} |", flush=True)


def detect_row(programs, recording, model, seconds, page):
    with StreamGenerator(programs, recording, 0.3, seconds) as generator:
        found, passed, viewer = run([f"{programs}/tactile", "detect", "--model", model, "--from", f"tcp://127.0.0.1:{generator.port}", "--reconnect", "0",
                                     "--json"], page, "--page")
        generator.sent()
    work, answer, ticks = found["latency_us"]["work"], found["latency_us"]["answer"], found["ticks"]
    print(f"| {page} | {work['p50']:.0f} | {work['p99']:.0f} | {work['p999']:.0f} | {answer['p99']:.0f} | {100 * ticks['missed_share']:.3f} | "
          f"{100 * found['cpu_s'] / found['elapsed_s']:.1f} | {words_of(viewer, passed)} |", flush=True)


def main():
    programs, recording, model, seconds, folder = sys.argv[1:6]
    print("| `record`, 10 million events/s | sent [million/s] | latest [ms] | missing | dropped | messages/s | pictures/s | MB/s |")
    print("| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |", flush=True)
    for page in PAGES:
        record_row(programs, recording, int(seconds), pathlib.Path(folder), page)
    print("\n| `detect`, 0.3 million events/s | work p50 [µs] | p99 | p99.9 | closed to reported p99 | missed [%] | CPU [%] | messages/s | pictures/s | MB/s |")
    print("| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |", flush=True)
    for page in PAGES:
        detect_row(programs, recording, model, int(seconds), page)


main()

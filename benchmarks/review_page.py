#!/usr/bin/env python3
"""Measures the page of `tactile review` in a real browser: a long run of many events, and the correction of ten wrong onsets. Prints two
tables.

    review_page.py PROGRAMS RECORDING FOLDER MILLION_EVENTS_PER_S SECONDS

Ten onsets of simulated runs are moved by 15 to 25 ms in their labels.json and corrected on the page: key f goes to the next run, key n to its
first onset, the onset is dragged to its place, Shift+C confirms the run. The page's part is measured. The person's part is computed by the
keystroke-level model (Card, Moran and Newell, 1980): no person was timed.

Then the long run is looked at: the events of RECORDING, again and again.
"""

import json
import pathlib
import random
import shutil
import statistics
import subprocess
import sys
import time

HERE = pathlib.Path(__file__).resolve().parent
sys.path += [str(HERE.parent / "tests" / part) for part in ("support", "report", "review/page")]
from browser import SHIFT, Browser, Tab, chromium  # noqa: E402
from review_world import Server, handle, view  # noqa: E402

# Of the keystroke-level model [s]: a key of an average typist, pointing with the mouse, a mouse button down or up, a hand moved between
# keyboard and mouse, a decision.
KEY, POINT, BUTTON, HAND, DECIDE = 0.28, 1.10, 0.10, 0.40, 1.35
PERSON_S = (
    DECIDE + KEY  # f
    + DECIDE + KEY  # n
    + DECIDE + HAND + POINT + BUTTON + POINT + BUTTON  # the drag
    + DECIDE + HAND + 2 * KEY  # Shift+C
)
REQUESTS = ("signals", "event_times", "events", "heatmap")


def peak_mb(pid):
    """The largest memory of a process so far."""
    for line in pathlib.Path(f"/proc/{pid}/status").read_text().splitlines():
        if line.startswith("VmHWM:"):
            return int(line.split()[1]) / 1e3
    return 0.0


def renderer_mb(home):
    """The largest peak memory of the browser's renderers."""
    peaks = []
    for folder in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            command = (folder / "cmdline").read_bytes().decode(errors="replace")
            if "--type=renderer" in command and str(home) in command:
                peaks.append(peak_mb(folder.name))
        except OSError:
            pass  # it has ended
    return max(peaks, default=0.0)


def quantile(values, share):
    return sorted(values)[min(len(values) - 1, int(share * len(values)))]


def settled(tab):
    """Waits until the page asks for nothing more, and returns the requests since the last call: {name: [ms, …]}."""
    seen = -1
    while True:
        count, open_ = tab.js("[performance.getEntriesByType('resource').length, document.querySelectorAll('.pending').length]")
        if count == seen and open_ == 0:
            break
        seen = count
        time.sleep(0.4)
    entries = tab.js("performance.getEntriesByType('resource').map(r => [r.name, r.duration])")
    tab.js("performance.clearResourceTimings()")
    found = {name: [] for name in REQUESTS}
    for url, duration in entries:
        name = url.split("?")[0].rsplit("/", 1)[-1]
        if name in found:
            found[name].append(duration)
    return found


def look_at_long_run(programs, recording, folder, rate, seconds):
    data = folder / "long"
    run = data / "long" / "01"
    shutil.rmtree(data, ignore_errors=True)
    run.mkdir(parents=True)
    subprocess.run([f"{programs}/long_recording", recording, str(rate), str(seconds), run / "events.aedat4"], check=True)
    size_gb = (run / "events.aedat4").stat().st_size / 1e9
    server = Server(f"{programs}/tactile", str(data), "--port", "0")
    browser = Browser(chromium(), str(folder))
    try:
        tab = Tab(browser)
        begin = time.monotonic()
        tab.go(server.url + "#/run/long/01")
        tab.wait("document.querySelector('.timeline') && /\\d/.test(document.querySelector('.strip .value')?.textContent)", "the run is shown")
        opened_s = time.monotonic() - begin
        tab.js("performance.setResourceTimingBufferSize(10000)")
        settled(tab)
        answers = {name: [] for name in REQUESTS}
        chance = random.Random(1)
        left, top, width, _ = tab.box(".surface")

        def note():
            for name, values in settled(tab).items():
                answers[name] += values

        for _ in range(20):  # somewhere into the run, and out again
            tab.key("0")
            x = left + width * chance.uniform(0.05, 0.95)
            for _ in range(11):
                tab.wheel(x, top + 60, -300)
                note()
            tab.click_at(left + width * chance.uniform(0.1, 0.9), top + 60)
            note()
            tab.drag(left + width * 0.8, top + 60, left + width * 0.3)
            note()
        print(f"{rate} million events/s for {seconds} s: {rate * seconds:.0f} million events, {size_gb:.1f} GB. "
              f"Shown {opened_s:.0f} s after its address was entered. Most memory: server {peak_mb(server.process.pid):.0f} MB, "
              f"page {renderer_mb(folder):.0f} MB.\n")
        print("| requests of the page | number | p50 [ms] | p95 | p99 | max |\n| --- | ---: | ---: | ---: | ---: | ---: |")
        for name in REQUESTS:
            values = answers[name]
            print(f"| `{name}` | {len(values)} | {statistics.median(values):.0f} | {quantile(values, 0.95):.0f} | {quantile(values, 0.99):.0f} | {max(values):.0f} |",
                  flush=True)
    finally:
        browser.close()
        server.end()
        shutil.rmtree(data)


def move_onset(run, by_us):
    """Makes the first press' onset wrong. Returns where it was, after the first event."""
    file = run / "labels.json"
    labels = json.loads(file.read_text())
    press = next(interval for interval in labels["intervals"] if interval["class"] == "press")
    right = press["start_us"] - labels["provenance"]["first_event_us"]
    for key in ("start_us", "start_low_us", "start_high_us"):
        press[key] += by_us
    file.write_text(json.dumps(labels))
    return right


def correct_onsets(programs, folder):
    data = folder / "wrong"
    shutil.rmtree(data, ignore_errors=True)
    tactile = f"{programs}/tactile"
    objects = ["fan", "usb-hub", "sprayer", "small-box", "white-box"]
    subprocess.run([tactile, "simulate", data, "--preset", "quick", "--runs", "2", "--objects", ",".join(objects), "--quiet"], check=True,
                   stdout=subprocess.DEVNULL)
    subprocess.run([tactile, "label", data, "--quiet"], check=True, stdout=subprocess.DEVNULL)
    chance = random.Random(2)
    right = {}
    for name in (f"{object_}/{run:02}" for object_ in objects for run in (1, 2)):
        right[name] = move_onset(data / name, chance.choice((-1, 1)) * chance.randint(15_000, 25_000))
    server = Server(tactile, str(data), "--port", "0")
    browser = Browser(chromium(), str(folder))
    page_s, errors_ms = [], []
    try:
        tab = Tab(browser)
        tab.go(server.url)
        tab.wait("document.querySelectorAll('tbody tr').length === 10", "the runs are listed")
        tab.wait("[...document.querySelectorAll('.thumb img')].every(i => i.naturalWidth > 0)", "their pictures are there")
        for _ in range(10):
            waited = 0.0

            def until(expression, words):
                nonlocal waited
                begin = time.monotonic()
                tab.wait(expression, words)
                waited += time.monotonic() - begin

            before = tab.text("h1")
            tab.key("f")
            until(f"document.querySelector('h1').textContent !== {json.dumps(before)} && document.querySelector('.handle')", "the next run is shown")
            name = tab.text("h1")
            tab.key("n")
            start = handle("press-1", "start")
            until(f"document.querySelector(\"{start}\").classList.contains('selected') && !document.querySelector('.strip.pending')", "its onset is shown")
            until("/\\d/.test(document.querySelector('.strip .value')?.textContent)", "and the rate around it")
            left, top, width, _ = tab.box(start)
            shown, (_, _, axis, _) = view(tab), tab.box(".surface")
            by = (right[name] - sum(shown) / 2) / (shown[1] - shown[0]) * axis
            tab.drag(left + width / 2, top + 60, left + width / 2 + by)
            tab.key("C", SHIFT)
            until("document.querySelector('.saved')?.textContent === 'All saved'", "all is saved")
            labels = json.loads((data / name / "labels.json").read_text())
            press = next(interval for interval in labels["intervals"] if interval["id"] == "press-1")
            errors_ms.append(abs(press["start_us"] - labels["provenance"]["first_event_us"] - right[name]) / 1e3)
            assert press["source"] == "person" and all(interval["confirmed"] for interval in labels["intervals"]), f"{name} is not confirmed"
            page_s.append(waited)
        print("\n| ten wrong onsets, each found, dragged, confirmed | median | most |\n| --- | ---: | ---: |")
        print(f"| waiting for the page, measured [s] | {statistics.median(page_s):.2f} | {max(page_s):.2f} |")
        print(f"| the person, by the keystroke-level model [s] | {PERSON_S:.2f} | {PERSON_S:.2f} |")
        print(f"| both [s] | {statistics.median(page_s) + PERSON_S:.2f} | {max(page_s) + PERSON_S:.2f} |")
        print(f"| the corrected onset's distance from its place [ms] | {statistics.median(errors_ms):.2f} | {max(errors_ms):.2f} |", flush=True)
    finally:
        browser.close()
        server.end()
        shutil.rmtree(data)


def main():
    programs, recording, folder, rate, seconds = sys.argv[1:6]
    folder = pathlib.Path(folder).resolve()
    if not chromium():
        sys.exit("bench: there is no Chromium; scripts/setup installs it")
    correct_onsets(programs, folder)
    print()
    look_at_long_run(programs, recording, folder, float(rate), int(seconds))


main()

"""What a person does to watch a recording and a detection: steps of review_page_test.py."""

import os
import re
import signal
import subprocess
import threading

from browser import Tab
from page_checks import problems_of, unreachable
from review_world import NOT_THERE, check


class Live:
    """A running `tactile record --preview` or `tactile detect --page`."""

    def __init__(self, world, *arguments):
        self.process = subprocess.Popen(
            [world.tactile, *arguments], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
        )
        lines = []
        for line in self.process.stdout:
            lines.append(line)
            if address := re.search(r"http://[\d.]+:\d+/", line):
                self.url = address.group(0)
                break
        else:
            raise AssertionError(f"tactile {arguments[0]} ended: " + "".join(lines))
        threading.Thread(target=self.process.stdout.read, daemon=True).start()

    def end(self, number=signal.SIGINT):
        if self.process.poll() is None:
            self.process.send_signal(number)
        return self.process.wait(60)


def leave(world, live, tab):
    live.end()
    world.browser.left.add(tab.session)  # it may have asked for a picture after its program had ended
    tab.close()
    world.browser.events = []
    world.allowed = []


def picture_is_drawn(tab, kind):
    tab.wait(
        f"(() => {{ const c = document.querySelector('.picture.{kind} canvas'); return c.width > 30 &&"
        " new Set(c.getContext('2d').getImageData(0, 0, c.width, c.height).data).size > 3; })()",
        f"the {kind} are drawn",
    )


def is_sound(world, live, name, ready):
    """The page has its charts and pictures, and no problem, on wide and narrow screens, light and dark."""
    for width, dark in ((1280, False), (1280, True), (390, False), (390, True)):
        look = Tab(world.browser, width, dark)
        look.go(live.url)
        look.wait(ready, "the charts are there")
        picture_is_drawn(look, "events")
        problems = problems_of(look, width, dark, world.axe)
        look.picture(os.path.join(world.home, f"{name}-{width}{'-dark' if dark else ''}.png"))
        look.close()
        check(not problems, f"page {name} at {width} px: {problems}")


def watches_a_recording(world):
    film = os.path.join(world.data, "fan", "01", "video.mp4")
    out = os.path.join(world.home, "live")
    live = Live(world, "record", "--from", "sim", "--object", "fan", "--out", out, "--speed", "0.02", "--video", film, "--preview", "0")
    tab = Tab(world.browser)
    try:
        tab.go(live.url)
        tab.wait("document.querySelector('h1')?.textContent === 'Recording fan/01'", "the page says what is recorded")
        picture_is_drawn(tab, "events")
        picture_is_drawn(tab, "heatmap")
        tab.wait("document.querySelector('.picture.film:not([hidden]) img')?.naturalWidth > 100", "the film is shown")
        tab.wait("/events\\/s/.test(document.querySelector('.live-facts')?.textContent)", "the event rate is there")
        tab.wait("document.querySelectorAll('.live-chart canvas').length > 0", "the last minute is a chart")
        before = tab.text(".live-detail")
        tab.wait(f"document.querySelector('.live-detail').textContent !== '{before}'", "the time advances")
        is_sound(world, live, "live", "document.querySelectorAll('.live-chart canvas').length > 0")
        problems = unreachable(tab)
        check(not problems, f"live page: {problems}")
        world.quiet("watching a recording")
        world.allowed = NOT_THERE  # a picture that is asked for at this moment
        check(live.end() == 0, "the recording ends well")
        tab.wait("/^Recording has ended, with 1 run/.test(document.querySelector('h1').textContent)", "the page says that it has ended")
        tab.wait("!document.getElementById('lost').hidden", "and that it shows its last state")
        world.quiet("the end of a recording")
    finally:
        leave(world, live, tab)


def records_a_session_on_the_page(world):
    """Start, stop, redo and the end by keys and buttons alone: the program has no standard input."""
    plan = os.path.join(world.home, "plan.json")
    with open(plan, "w", encoding="utf-8") as file:
        file.write('{"session": "monday", "objects": [{"name": "fan", "runs": 1}, {"name": "mug", "runs": 2}]}')
    live = Live(world, "record", "--from", "sim", "--session", plan, "--out", os.path.join(world.home, "session"), "--speed", "0.2",
                "--preview", "0")
    tab = Tab(world.browser)

    def offers(*words):
        buttons = "[...document.querySelectorAll('.live-choices button')].map((b) => b.firstChild.textContent).join('; ')"
        tab.wait(f"{buttons} === '{'; '.join(words)}'", f"the page offers {words}")

    try:
        tab.go(live.url)
        offers("Start fan, run 1", "Skip fan", "End the session")
        tab.key("Enter")
        offers("Stop fan/01")
        tab.wait("document.querySelector('.live-detail').textContent >= '0:01'", "the run lasts a second")
        tab.key("Enter")
        offers("Start mug, run 1", "Redo fan/01", "Skip mug", "End the session")
        tab.key("r")
        offers("Start fan, run 1", "Skip fan", "End the session")
        tab.click(".live-choices .start")
        offers("Stop fan/01")
        tab.picture(os.path.join(world.home, "live-session.png"))
        tab.click(".live-choices .stop")
        offers("Start mug, run 1", "Redo fan/01", "Skip mug", "End the session")
        tab.key("s")
        offers("Redo fan/01", "End the session")
        problems = problems_of(tab, 1280, False, world.axe) + unreachable(tab)
        check(not problems, f"the page of a session: {problems}")
        world.quiet("recording a session")
        world.allowed = NOT_THERE
        tab.click(".live-choices .end")
        tab.wait("/^Recording has ended, with 1 run/.test(document.querySelector('h1').textContent)", "the session ends")
        check(live.process.wait(60) == 0, "the session ends well")
    finally:
        leave(world, live, tab)


def watches_a_detection(world):
    live = Live(world, "detect", "--from", "sim:fan", "--model", os.path.join(world.models, "first"), "--speed", "0.5", "--page", "0")
    tab = Tab(world.browser)
    try:
        tab.go(live.url)
        tab.wait("['none', 'press', 'slip'].includes(document.querySelector('h1')?.textContent)", "the present class is there")
        tab.wait("document.querySelectorAll('.live-charts figure').length === 3", "three charts")
        picture_is_drawn(tab, "heatmap")
        tab.wait("/none \\d\\.\\d\\d, press/.test(document.querySelector('.live-facts').textContent)", "probabilities")
        is_sound(world, live, "detection", "document.querySelectorAll('.live-charts figure').length === 3")
        problems = unreachable(tab)
        check(not problems, f"page of a detection: {problems}")
        world.quiet("watching a detection")
        live.end(signal.SIGKILL)
        world.allowed = list(NOT_THERE) + ["ERR_INCOMPLETE_CHUNKED_ENCODING"]
        tab.wait("/^The program does not answer/.test(document.getElementById('lost').textContent)", "a killed program is named")
        world.quiet("a killed detection")
    finally:
        leave(world, live, tab)

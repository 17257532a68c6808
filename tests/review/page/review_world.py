"""Runs, models and studies, a running `tactile review` and a browser, and what the steps of review_page_test.py ask of them."""

import json
import os
import re
import shutil
import signal
import subprocess
import threading
import time

from browser import PATIENCE_S, Browser, chromium
from made_study import write_study

RUN, OTHER = "fan/01", "usb-hub/01"
MARKUP = "<img src=x onerror=alert(1)>"
NOT_THERE = ("ERR_CONNECTION_REFUSED", "ERR_CONNECTION_RESET", "ERR_EMPTY_RESPONSE", "ERR_SOCKET_NOT_CONNECTED", "ERR_CONNECTION_CLOSED")


def check(condition, words):
    if not condition:
        raise AssertionError(words)


class Server:
    """A running `tactile review`."""

    def __init__(self, tactile, *arguments):
        self.process = subprocess.Popen(
            [tactile, "review", *arguments, "--who", "ada"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
        )
        self.lines = []
        for line in self.process.stdout:
            self.lines.append(line)
            if address := re.search(r"http://[\d.]+:(\d+)/\S*", line):
                self.url, self.port = address.group(0), int(address.group(1))
                break
        else:
            raise AssertionError("tactile review ended: " + "".join(self.lines))
        threading.Thread(target=lambda: self.lines.extend(self.process.stdout), daemon=True).start()

    def kill(self):
        self.process.send_signal(signal.SIGKILL)
        self.process.wait()

    def end(self):
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
            self.process.wait(60)


class World:
    def __init__(self, tactile, home, axe=None):
        self.tactile, self.home, self.axe = tactile, home, axe
        self.data, self.pieces = os.path.join(home, "data"), os.path.join(home, "pieces")
        self.made("simulate", self.data, "--preset", "tiny", "--runs", "1", "--objects", "fan,usb-hub")
        os.remove(os.path.join(self.data, OTHER, "robot.csv"))  # its labels are flagged
        self.made("label", self.data, "--no-pictures")
        self.add_markup()
        self.models, self.studies = os.path.join(home, "models"), os.path.join(home, "studies")
        self.made("windows", self.data, "--include-flagged")
        for name, history in (("first", "40"), ("second", "20")):
            self.made(
                "train",
                self.data,
                "--th",
                history,
                "--epochs",
                "2",
                "--split",
                "unseen",
                "--held-out",
                "usb-hub",
                "--models",
                self.models,
                "--name",
                name,
            )
        self.made("eval", self.data, "--model", os.path.join(self.models, "first"), "--models", self.models)
        write_study(os.path.join(self.studies, "plain"), "")
        write_study(os.path.join(self.studies, "hostile"), " <b onerror=alert(1)>\"quoted\" & 'single'</b>")
        self.server = self.new_server()
        self.browser = Browser(chromium(), home)
        self.allowed = []

    def add_markup(self):
        """A flag and a folder whose words would be elements of a page that does not escape them."""
        file = os.path.join(self.data, OTHER, "labels.json")
        with open(file, encoding="utf-8") as saved:
            labels = json.load(saved)
        labels["flags"][0]["reason"] += f": {MARKUP}"
        with open(file, "w", encoding="utf-8") as saved:
            json.dump(labels, saved)
        os.makedirs(os.path.join(self.data, MARKUP, "01"))
        shutil.copy(os.path.join(self.data, OTHER, "events.aedat4"), os.path.join(self.data, MARKUP, "01"))

    def new_server(self, port=0):
        return Server(self.tactile, self.data, "--models", self.models, "--studies", self.studies, "--pieces", self.pieces, "--port", str(port))

    def made(self, *arguments):
        result = subprocess.run([self.tactile, *arguments, "--quiet"], capture_output=True, text=True)
        check(result.returncode == 0, f"tactile {arguments[0]} ended with {result.returncode}: {result.stderr}")

    def saved(self, run=RUN):
        with open(os.path.join(self.data, run, "labels.json"), encoding="utf-8") as file:
            return json.load(file)

    def interval(self, name, run=RUN):
        """An interval as the file has it, in µs after the first event; None if there is none."""
        labels = self.saved(run)
        first = labels["provenance"]["first_event_us"]
        for interval in labels["intervals"]:
            if interval["id"] == name:
                return {key: value - first if key.startswith(("start", "end")) else value for key, value in interval.items()}
        return None

    def until(self, condition, words):
        end = time.monotonic() + PATIENCE_S
        while not condition():
            check(time.monotonic() < end, f"{words}: never so")
            time.sleep(0.02)

    def quiet(self, step):
        """The console must be silent, but for what a step expects."""
        for words in self.browser.complaints():
            check(any(expected in words for expected in self.allowed), f"{step}: console: {words}")
        self.browser.events = []

    def end(self):
        self.browser.close()
        self.server.end()


def open_run(world, tab, run=RUN, at=None):
    tab.go(world.server.url + f"#/run/{run}" + (f"?t={at}" if at is not None else ""))
    tab.wait(f"document.querySelector('h1')?.textContent === '{run}' && document.querySelector('.handle')", f"run {run} is shown")
    tab.wait("document.querySelector('.saved')?.textContent.startsWith('All saved')", "all is saved")


def view(tab):
    return tab.js("(({from_us, to_us}) => [Number(from_us), Number(to_us)])(document.querySelector('.timeline').dataset)")


def cursor_us(tab):
    return round(float(tab.text(".time-now").rstrip(" s")) * 1e6)


def saved_in_page(tab):
    tab.wait("document.querySelector('.saved')?.textContent === 'All saved'", "the page has saved all")


def handle(name, end):
    return f".handle[data-id='{name}'][data-end='{end}']"


def without_news(world, tab):
    """The page does not learn of changes until it is allowed to."""
    world.browser.ask("Network.setBlockedURLs", tab.session, urls=["*/labels"])


def with_news(world, tab):
    world.browser.ask("Network.setBlockedURLs", tab.session, urls=[])

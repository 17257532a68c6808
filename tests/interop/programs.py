"""The programs that are compared, and the processes that run them."""

import os
import random
import re
import signal
import socket
import subprocess
import sys
import threading
import time
import traceback
from pathlib import Path

import contents as c
from table import Difference

ROOT = Path(__file__).resolve().parent.parent.parent
TACTILE, FAKE_CONTROLLER, MODEL_LOGITS, RECORDINGS = (Path(argument).resolve() for argument in sys.argv[1:5])
TIMEOUT_S = 60  # of every single wait: whatever takes longer is stuck


def run(*command, expected=0):
    """Runs a command to its end and returns its stdout."""
    result = subprocess.run([str(part) for part in command], capture_output=True, text=True, timeout=5 * TIMEOUT_S, stdin=subprocess.DEVNULL)
    if result.returncode != expected:
        raise Difference(f"{' '.join(map(str, command))}: ended with {result.returncode}: {result.stderr.strip()[-300:]}")
    return result.stdout


def tactile(*arguments):
    return run(TACTILE, *arguments)


def wait_until(condition):
    """Returns once the condition holds, or after TIMEOUT_S: then the comparison shows what is missing."""
    end = time.monotonic() + TIMEOUT_S
    while not condition() and time.monotonic() < end:
        time.sleep(0.02)


class Process:
    """A program that runs in the background. Its output is read all the time; it is killed at the end of the block if it still runs."""

    def __init__(self, *command):
        self.command = [str(part) for part in command]
        self.text = ""

    def __enter__(self):
        self.process = subprocess.Popen(self.command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        self.reader = threading.Thread(target=self._read, daemon=True)
        self.reader.start()
        return self

    def _read(self):
        for line in self.process.stdout:
            self.text += line

    def wait_for(self, pattern):
        """The first match of the pattern in the output."""
        wait_until(lambda: re.search(pattern, self.text) or self.process.poll() is not None)
        if self.process.poll() is not None:
            self.reader.join(TIMEOUT_S)
        if found := re.search(pattern, self.text):
            return found
        raise Difference(f"{' '.join(self.command)}: printed no '{pattern}': {self.text.strip()[-300:]}")

    def wait(self):
        """Waits for its end, which must be a success."""
        code = self.process.wait(TIMEOUT_S)
        self.reader.join(TIMEOUT_S)
        if code != 0:
            raise Difference(f"{' '.join(self.command)}: ended with {code}: {self.text.strip()[-300:]}")

    def interrupt(self):
        self.process.send_signal(signal.SIGINT)

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait()


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

    def wait(self):
        """Waits for its end, which must be a success."""
        status = 0

        def has_ended():
            nonlocal status
            pid, status = os.waitpid(self.pid, os.WNOHANG)
            self.pid = 0 if pid else self.pid
            return not self.pid

        wait_until(has_ended)
        if self.pid:
            raise Difference("the server of the other library does not end")
        if status:
            raise Difference(f"the server of the other library ended with status {status}")

    def __exit__(self, *_):
        if self.pid:
            os.kill(self.pid, signal.SIGKILL)
            os.waitpid(self.pid, 0)


def free_port():
    """A free port outside the range from which the system chooses ports: no program gets it before the test uses it."""
    first = int(Path("/proc/sys/net/ipv4/ip_local_port_range").read_text().split()[0])
    while True:
        port = random.randrange(min(10000, first - 1000), first)
        with socket.socket() as s:
            try:
                s.bind(("127.0.0.1", port))
                return port
            except OSError:
                pass


def contents_by_tactile(recording, folder):
    """The events that tactile reads, by way of a CSV file."""
    csv = folder / (recording.stem + ".csv")
    tactile("convert", recording, csv, "--force")
    return c.read_csv(csv)


def simulated_run(folder):
    """A run of the simulator, made once for all rows."""
    data = folder.parent / "simulated"
    if not data.exists():
        tactile("simulate", data, "--preset", "tiny", "--objects", "fan", "--runs", "1")
    return data / "fan" / "01"

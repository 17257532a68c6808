"""What the benchmarks of running commands share: a sender of events, and what a command costs."""

import json
import os
import subprocess
import time


class StreamGenerator:
    """stream_generator, which sends events over loopback at a fixed rate to the first client."""

    def __init__(self, programs, recording, rate, seconds, packet_ms=1, prefix=()):
        self.process = subprocess.Popen([*prefix, f"{programs}/stream_generator", recording, str(rate), str(seconds), str(packet_ms)],
                                        stdout=subprocess.PIPE, text=True)
        self.port = int(self.process.stdout.readline())

    def __enter__(self):
        return self

    def sent(self):
        """What was sent, after the end; empty if the generator failed."""
        return json.loads(self.process.stdout.readline() or "{}")

    def __exit__(self, failure, *_):
        if failure:
            self.process.kill()  # its client may never have come
        self.process.stdout.close()
        self.process.wait()


def cost_of(command, **options):
    """Runs a command. Returns its exit status, wall-clock seconds, CPU seconds of all cores, and largest memory in MiB."""
    begin = time.monotonic()
    process = subprocess.Popen([str(part) for part in command], **options)
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    return process.returncode, time.monotonic() - begin, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024

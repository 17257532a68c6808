"""Programs that wait for work, so that several can be measured in turn: what else the machine does then affects all of them alike."""

import os
import statistics
import subprocess
import sys


def answer_each_line(answer):
    """The worker's side: prints "ready", then one line for each line of standard input."""
    print("ready", flush=True)
    for line in sys.stdin:
        print(answer(line), flush=True)


class Worker:
    """A program that runs `answer_each_line`, or does the same in C++."""

    def __init__(self, command, environment):
        self.process = subprocess.Popen([str(part) for part in command], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
                                        env={**os.environ, **environment})
        self.is_ready = self.process.stdout.readline().strip() == "ready"

    def ask(self, line=""):
        """The answer to a line, as words."""
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()
        return self.process.stdout.readline().split()

    def end(self):
        self.process.stdin.close()
        self.process.wait()


def in_turn(items, rounds):
    """Each item once per round; another item comes first in each round."""
    items = list(items)
    for turn in range(rounds):
        first = turn % len(items)
        yield from items[first:] + items[:first]


def median_ratio(values, others):
    """The median of the ratios of values that were measured one after the other."""
    return statistics.median(a / b for a, b in zip(values, others))

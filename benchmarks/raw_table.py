#!/usr/bin/env python3
"""Measures how fast Prophesee RAW files are read on one thread, opening included, and prints a table.

    raw_table.py FOLDER BENCHMARK FILE.raw…

The words of each file are repeated until there are 10 million events, because the known files are short.
"""

import os
import statistics
import subprocess
import sys


def header_length(data):
    at = 0
    while data[at:at + 2] == b"% ":
        at = data.index(b"\n", at) + 1
    return at


def read(benchmark, file):
    count, seconds = subprocess.run([benchmark, "--read", file], check=True, capture_output=True, text=True).stdout.split()
    return int(count), float(seconds)


def main():
    folder, benchmark, *files = sys.argv[1:]
    print("| file | events | million events/s |\n| --- | ---: | ---: |")
    for file in files:
        with open(file, "rb") as source:
            data = source.read()
        begin = header_length(data)
        events, _ = read(benchmark, file)
        long_file = os.path.join(folder, "repeated.raw")
        with open(long_file, "wb") as out:
            out.write(data[:begin])
            for _ in range(max(1, 10_000_000 // max(events, 1))):
                out.write(data[begin:])
        rates = []
        for _ in range(9):
            events, seconds = read(benchmark, long_file)
            rates.append(events / seconds / 1e6)
        os.remove(long_file)
        print(f"| {os.path.basename(file)} | {events} | {statistics.median(rates):.0f} |")


main()

"""Prints the table of docs/performance/ from the JSON of recording_benchmark.

    recording_table.py RESULT.json
"""

import json
import sys

# Benchmark: its name, what it is compared with, the goal of the ratio.
ROWS = {
    "read_lz4": ("read LZ4, one thread", "LZ4F", 0.9),
    "read_lz4_two_threads": ("read LZ4, two threads", "LZ4F on two threads", 0.9),
    "read_none": ("read uncompressed", "read() and a sum", 0.9),
    "read_zstd": ("read ZSTD, one thread", "zstd", 0.95),
    "write_lz4": ("write LZ4, one thread", "LZ4F, nothing written", 0.9),
    "write_none": ("write uncompressed", "write()", None),
}

with open(sys.argv[1]) as file:
    benchmarks = json.load(file)["benchmarks"]
print("| | tactile | alone | | ratio | interquartile range | goal |\n| --- | ---: | ---: | --- | ---: | ---: | ---: |")
for benchmark in benchmarks:
    row = ROWS.get(benchmark["name"].split("/")[0])
    if row:
        name, alone, goal = row
        print(f"| {name} | {benchmark['ours']:.0f} | {benchmark['alone']:.0f} | {alone} | **{benchmark['ratio']:.2f}** "
              f"| {benchmark['ratio_low']:.2f}–{benchmark['ratio_high']:.2f} | {goal or ''} |")

#!/usr/bin/env python3
"""Measures `tactile windows` and `tactile heatmaps` over a folder of labelled runs that has no dataset yet. Prints a table.

    dataset_cost.py PROGRAMS FOLDER
"""

import subprocess
import sys

from loads import cost_of

COMMANDS = ("windows", "heatmaps --th 2,10,20,30,40,50")


def main():
    programs, folder = sys.argv[1:3]
    print("| | wall-clock time [s] | CPU time of both cores [s] | memory, peak [MiB] |\n| --- | ---: | ---: | ---: |", flush=True)
    for command in COMMANDS:
        name, *options = command.split()
        status, wall_s, cpu_s, memory_mib = cost_of([f"{programs}/tactile", name, folder, *options, "--quiet"], stdout=subprocess.DEVNULL)
        if status != 0:
            return status
        print(f"| `tactile {command}` | {wall_s:.1f} | {cpu_s:.1f} | {memory_mib:.0f} |", flush=True)
    return 0


sys.exit(main())

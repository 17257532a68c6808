"""Checks that a program has every function of ours that a part calls: `check_part.py PART PROGRAM`. The loader would find a missing
one only when the part is loaded."""

import subprocess
import sys


def ours(file, *options):
    """Our symbols among the dynamic ones."""
    lines = subprocess.run(["nm", "--dynamic", "--format=posix", *options, file], check=True, capture_output=True, text=True).stdout
    return {line.split()[0] for line in lines.splitlines() if "7tactile" in line}


def main():
    part, program = sys.argv[1:]
    called = ours(part, "--undefined-only")
    missing = sorted(called - ours(program, "--defined-only"))
    for symbol in missing:
        print(f"{program} has no {symbol}; expected it in 'called_by_part', beside what loads {part}")
    if not called:
        print(f"{part} calls nothing of ours; expected some functions")
    return 1 if missing or not called else 0


sys.exit(main())

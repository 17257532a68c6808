#!/usr/bin/env python3
"""compare_robot_logs.py OURS.csv THEIRS.csv: the same robot logged by tactile and by ur-rtde must be the same, package for package.

ur-rtde writes six decimals, on a period of its own: it repeats and skips packages, and a row may begin with one package and end with
a later one. So each of its values must be that of our row of the same timestamp, of the one before it, or of the 25 behind it. Ends
with 1 if one is not.
"""
import csv
import sys

LATER_ROWS = 25


def rows_of(path):
    with open(path, newline="") as file:
        return [row for row in csv.DictReader(line for line in file if line.strip())]


def main():
    if len(sys.argv) != 3:
        sys.exit("usage: compare_robot_logs.py OURS.csv THEIRS.csv")
    ours, theirs = rows_of(sys.argv[1]), rows_of(sys.argv[2])
    if not ours or not theirs:
        sys.exit("compare_robot_logs.py: a log without rows")
    columns = [name for name in theirs[0] if name in ours[0] and name != "timestamp"]
    at = {f"{float(row['timestamp']):.6f}": i for i, row in enumerate(ours)}
    first, last = float(ours[0]["timestamp"]), float(ours[-1]["timestamp"])
    compared, wrong = 0, 0
    for row in theirs:
        time = float(row["timestamp"])
        if not first < time < last:
            continue
        i = at.get(f"{time:.6f}")
        near = [] if i is None else ours[max(0, i - 1):i + 1 + LATER_ROWS]
        compared += 1
        for name in columns:
            if not any(abs(float(row[name]) - float(other[name])) <= 1e-6 for other in near):
                wrong += 1
                here = near[min(1, len(near) - 1)][name] if near else "no such row"
                print(f"{row['timestamp']} s, {name}: {row[name]} there, {here} here", file=sys.stderr)
    print(f"{compared} rows, {len(columns)} columns compared, {wrong} values differ")
    sys.exit(1 if wrong or compared == 0 or not columns else 0)


if __name__ == "__main__":
    main()

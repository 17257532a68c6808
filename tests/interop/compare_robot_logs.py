"""Compares two logs of one robot: robot.csv of tactile, and the log of ur-rtde.

ur-rtde writes six decimals and has a period of its own: it repeats and skips packages, and a row may begin with one package and end
with a later one. Therefore each of its values must equal that of the row of tactile with the same timestamp, of the row before it, or
of one of the LATER_ROWS rows after it.
"""

import csv

LATER_ROWS = 25


def rows_of(path):
    with open(path, newline="") as file:
        rows = list(csv.DictReader(line for line in file if line.strip()))
    if not rows:
        raise ValueError(f"{path}: no rows; expected a robot log")
    return rows


def differences(our_file, their_file):
    """A line for each value of ur-rtde that tactile has not logged. Raises ValueError if the logs have no time or no column in common."""
    ours, theirs = rows_of(our_file), rows_of(their_file)
    columns = [name for name in theirs[0] if name in ours[0] and name != "timestamp"]
    index_at = {f"{float(row['timestamp']):.6f}": i for i, row in enumerate(ours)}
    first, last = float(ours[0]["timestamp"]), float(ours[-1]["timestamp"])
    compared = [row for row in theirs if first < float(row["timestamp"]) < last]
    if not compared or not columns:
        raise ValueError(f"{their_file}: no time or no column in common with {our_file}")
    found = []
    for row in compared:
        i = index_at.get(f"{float(row['timestamp']):.6f}")
        near = [] if i is None else ours[max(0, i - 1):i + 1 + LATER_ROWS]
        for name in columns:
            if not any(abs(float(row[name]) - float(other[name])) <= 1e-6 for other in near):
                our_value = near[min(1, len(near) - 1)][name] if near else "no row"
                found.append(f"{row['timestamp']} s, {name}: {row[name]} by ur-rtde, {our_value} by tactile")
    print(f"    {len(compared)} rows, {len(columns)} columns compared, {len(found)} values differ", flush=True)
    return found

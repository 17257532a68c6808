"""The rows of the comparison: what each compares, and how it ends."""

import importlib.util
import shutil
import tempfile
import time
import traceback
from pathlib import Path

import contents as c

ROWS = []


class Difference(Exception):
    """The two sides are not equal."""


class Skipped(Exception):
    """This machine cannot make the comparison."""


def row(name, *modules):
    """Adds a function to the table. It gets an empty folder; it is skipped if one of the Python modules is missing."""
    def add(compare):
        ROWS.append((name, modules, compare))
        return compare
    return add


def expect_equal(expected, found, what, parts=("events", "imu", "triggers", "frames")):
    if difference := c.difference(expected, found, parts):
        raise Difference(f"{what}: {difference}")


def outcome_of(compare, folder):
    """(outcome, details) of one row."""
    begin = time.monotonic()
    try:
        compare(folder)
    except Skipped as reason:
        return "SKIPPED", str(reason)
    except Difference as difference:
        return "DIFFERS", str(difference)
    except Exception as error:  # another library failed: the other rows are still compared
        traceback.print_exc()
        return "DIFFERS", f"{type(error).__name__}: {error}"
    return "equal", f"{time.monotonic() - begin:.1f} s"


def compare_rows(words):
    """Compares the rows whose name contains one of the words, all rows without any. Returns the exit status."""
    folder = Path(tempfile.mkdtemp(prefix="tactile-interop-"))
    outcomes = []
    try:
        for number, (name, modules, compare) in enumerate(ROWS, 1):
            if words and not any(word in name for word in words):
                continue
            missing = [module for module in modules if importlib.util.find_spec(module) is None]
            place = folder / f"{number:02}"
            place.mkdir()
            outcome, details = ("SKIPPED", f"no {', '.join(missing)} for this Python") if missing else outcome_of(compare, place)
            outcomes.append((outcome, name, details))
            print(f"{outcome:8}{name}  {details}", flush=True)
    finally:
        shutil.rmtree(folder, ignore_errors=True)

    print(f"\n{'':-<100}")
    for outcome, name, details in outcomes:
        print(f"{outcome:8}{name}" + (f"\n        {details}" if outcome != "equal" else ""))
    counts = {kind: sum(outcome == kind for outcome, _, _ in outcomes) for kind in ("equal", "DIFFERS", "SKIPPED")}
    print(f"{counts['equal']} rows equal, {counts['DIFFERS']} differ, {counts['SKIPPED']} skipped")
    return 1 if counts["DIFFERS"] else 77 if counts["SKIPPED"] else 0

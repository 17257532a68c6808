#!/usr/bin/env python3
"""Compares tactile with other libraries: each side reads the files and streams of the other. Prints one table.

    interop.py TACTILE FAKE_CONTROLLER MODEL_LOGITS RECORDINGS [WORD…]     only rows whose name contains one of the words

Ends with 0 if every row is equal, with 1 if one differs, and with 77 if a row was skipped because its library is missing.
"""

import sys

if len(sys.argv) < 5:
    sys.exit(__doc__.split("\n\n")[1].strip())

import table

# Each module adds its rows to the table.
import recording_rows  # noqa: F401
import stream_rows  # noqa: F401
import robot_rows  # noqa: F401
import model_rows  # noqa: F401

sys.exit(table.compare_rows(sys.argv[5:]))

#!/usr/bin/env python3
"""Uses the page of `tactile review` as a person does, in a real browser, against the real server.

    review_page_test.py TACTILE [--keep FOLDER] [--axe axe.min.js]

Ends with 77 where there is no Chromium. --keep keeps data and screenshots. --axe also runs axe-core (from npm, not part of this repository) on
each page; a serious finding is an error.
"""

import os
import shutil
import sys
import tempfile
import time

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path += [HERE, os.path.join(HERE, "..", "..", "support"), os.path.join(HERE, "..", "..", "report")]
from browser import chromium  # noqa: E402
import editing_steps as editing  # noqa: E402
import live_steps as live  # noqa: E402
import looking_steps as looking  # noqa: E402
from review_world import World  # noqa: E402


def main():
    tactile = sys.argv[1]
    option = lambda name: sys.argv[sys.argv.index(name) + 1] if name in sys.argv else None  # noqa: E731
    if not chromium():
        print("SKIPPED LOUDLY: there is no Chromium; 'apt install chromium' or scripts/setup installs it")
        return 77
    keep = option("--keep")
    axe = open(option("--axe"), encoding="utf-8").read() if option("--axe") else None
    home = keep or tempfile.mkdtemp(prefix="tactile-review-")
    os.makedirs(home, exist_ok=True)
    world = World(tactile, home, axe)
    try:
        for step in (
            looking.browses,
            looking.shows_two_hundred_runs,
            looking.zooms_and_plays,
            editing.drags_and_undoes,
            editing.edits_by_key,
            editing.reloads_during_an_edit,
            editing.provokes_a_conflict,
            editing.outlives_the_server,
            editing.reaches_all_by_keyboard,
            editing.lifts_and_goes_on,
            editing.is_used_by_finger,
            looking.compares_models_and_studies,
            looking.shows_what_has_no_labels,
            looking.cuts_a_recording,
            looking.zooms_on_cuts,
            live.watches_a_recording,
            live.records_a_session_on_the_page,
            live.watches_a_detection,
        ):
            begun = time.monotonic()
            step(world)
            print(f"ok  {step.__name__.replace('_', ' ')} ({time.monotonic() - begun:.1f} s)", flush=True)
        looking.is_sound_on_every_screen(world)
        print("ok  is sound on every screen" + (", by axe-core too" if axe else ""))
        return 0
    finally:
        world.end()
        if not keep:
            shutil.rmtree(home, ignore_errors=True)


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""Measures `tactile record` for 30 s from loopback: 10 million events/s to LZ4, 30 million to NONE. Prints a line for each.

    record_load.py PROGRAMS RECORDING FOLDER     FOLDER takes the recorded runs
"""

import json
import pathlib
import shutil
import subprocess
import sys

from loads import StreamGenerator, cost_of

SECONDS = 30


def measure(programs, recording, folder, compression, rate):
    run = folder / f"bench-{compression}" / "01"
    shutil.rmtree(run.parent, ignore_errors=True)
    with StreamGenerator(programs, recording, rate, SECONDS) as generator:
        status, _, _, memory_mib = cost_of([f"{programs}/tactile", "record", "--from", f"tcp://127.0.0.1:{generator.port}", "--duration", "40",
                                            "--object", run.parent.name, "--run", run.name, "--out", folder,
                                            "--compression", compression, "--quiet"])
        sent = generator.sent()
    if status != 0:
        print(f"bench: record ended with {status}")
    info = json.loads(subprocess.run([f"{programs}/tactile", "info", "--json", run], stdout=subprocess.PIPE).stdout)
    recorded = sum(stream["elements"] for stream in info["recordings"][0]["streams"])
    dropped = {key: value for key, value in json.loads((run / "run.json").read_text()).items() if "drop" in key or "lost" in key}
    print(f"record to {compression} at {rate} million events/s: sent {sent.get('events')} in {sent.get('seconds')} s, at most "
          f"{sent.get('latest_ms')} ms late; recorded {recorded}, missing {sent.get('events', 0) - recorded}; "
          f"run.json has {json.dumps(dropped)}; peak memory {memory_mib:.0f} MiB", flush=True)


def main():
    programs, recording, folder = sys.argv[1:4]
    for compression, rate in (("lz4", 10), ("none", 30)):
        measure(programs, recording, pathlib.Path(folder), compression, rate)


main()

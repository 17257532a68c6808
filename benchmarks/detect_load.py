#!/usr/bin/env python3
"""Measures `tactile detect` on one core at several event rates; another core sends the events. Prints a table.

    detect_load.py PROGRAMS RECORDING MODEL SECONDS FOLDER     FOLDER takes detect.json and the log; each row takes SECONDS
"""

import json
import os
import resource
import socket
import subprocess
import sys
import time

from loads import StreamGenerator

SENDER_CORE, DETECTOR_CORE = 0, 1
TICK_S = 0.002
# Million events/s, ms per packet, options of detect.
LOADS = [("0.02", 1, ""), ("0.3", 1, ""), ("0.3", 1, "--awake"), ("0.3", 1, "--no-rehearsal"), ("0.3", 1, "--precision int8"),
         ("3", 1, ""), ("3", 1, "--awake"), ("20", 1, ""), ("20", 1, "--awake")]


def cpu_s():
    used = resource.getrusage(resource.RUSAGE_SELF)
    return used.ru_utime + used.ru_stime


def print_bare_ticks(seconds, label):
    """Lower limit: wakes up at every tick and does nothing. A tick is late if it begins after the next one; then the next ones are skipped."""
    begin, cpu_begin, due, ticks, late, skipped = time.monotonic(), cpu_s(), 1, 0, 0, 0
    while due * TICK_S < seconds:
        time.sleep(max(0, begin + due * TICK_S - time.monotonic()))
        newest = int((time.monotonic() - begin) / TICK_S)
        ticks, skipped = ticks + 1, skipped + max(0, newest - due)
        late += newest > due
        due = max(due, newest) + 1
    print(f"| 0 | - | {label} | - | - | - | - | - | {100 * (late + skipped) / (ticks + skipped):.3f} | {skipped} | {late} | - | "
          f"{100 * (cpu_s() - cpu_begin) / seconds:.1f} |", flush=True)


def print_bare_client(port, rate, packet_ms):
    """Lower limit: receives every packet and does nothing."""
    stream = socket.create_connection(("127.0.0.1", port))
    begin, cpu_begin = time.monotonic(), cpu_s()
    while stream.recv(1 << 20):
        pass
    print(f"| {rate} | {packet_ms} | only received | - | - | - | - | - | - | - | - | - | "
          f"{100 * (cpu_s() - cpu_begin) / (time.monotonic() - begin):.1f} |", flush=True)


def print_lower_limits(programs, recording, seconds):
    os.sched_setaffinity(0, {DETECTOR_CORE})
    print_bare_ticks(seconds, "only woken every 2 ms")
    try:
        with open("/dev/cpu_dma_latency", "wb", buffering=0) as latency:  # the cores stay awake while it is open
            latency.write(bytes(4))
            print_bare_ticks(seconds, "only woken every 2 ms --awake")
    except OSError as error:
        print(f"bench: SKIPPED ticks with --awake: {error}", file=sys.stderr)
    with sender(programs, recording, "0.02", seconds, 1) as generator:
        print_bare_client(generator.port, "0.02", 1)
    os.sched_setaffinity(0, range(os.cpu_count()))


def sender(programs, recording, rate, seconds, packet_ms):
    return StreamGenerator(programs, recording, rate, seconds, packet_ms, prefix=("taskset", "-c", str(SENDER_CORE)))


def print_detection(programs, recording, model, seconds, folder, rate, packet_ms, options):
    with sender(programs, recording, rate, seconds, packet_ms) as generator, \
            open(f"{folder}/detect.json", "w+") as out, open(f"{folder}/log", "w+") as log:
        status = subprocess.call(["taskset", "-c", str(DETECTOR_CORE), f"{programs}/tactile", "detect", "--model", model,
                                  "--from", f"tcp://127.0.0.1:{generator.port}", "--reconnect", "0", "--json", "--quiet", *options.split()],
                                 stdout=out, stderr=log)
        sent = generator.sent()
        out.seek(0)
        log.seek(0)
        if status != 0:
            sys.stderr.write(log.read())
        found = json.load(out)
    work, answer, ticks = found["latency_us"]["work"], found["latency_us"]["answer"], found["ticks"]
    print(f"| {rate} | {packet_ms} | {options} | {work['p50']:.0f} | {work['p99']:.0f} | {work['p999']:.0f} | {work['max']:.0f} | "
          f"{answer['p99']:.0f} | {100 * ticks['missed_share']:.3f} | {ticks['skipped']} | {ticks['late']} | "
          f"{found['events']['dropped']} | {100 * found['cpu_s'] / found['elapsed_s']:.1f} |", flush=True)
    if sent.get("latest_ms", 0) > 2:
        print(f"bench: the generator sent one packet {sent['latest_ms']} ms late", file=sys.stderr)


def main():
    programs, recording, model, seconds, folder = sys.argv[1:6]
    print("| million events/s | packet [ms] | | work p50 [µs] | p99 | p99.9 | max | closed to reported p99 | missed [%] | skipped | late | "
          "dropped events | CPU [%] |")
    print("| ---: | ---: | --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |", flush=True)
    print_lower_limits(programs, recording, int(seconds))
    for load in LOADS:
        print_detection(programs, recording, model, seconds, folder, *load)


main()

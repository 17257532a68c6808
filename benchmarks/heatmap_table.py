"""Prints the tables of docs/performance/ from the JSON of heatmap_benchmark, and draws their picture with gnuplot.

    heatmap_table.py RESULT.json [PICTURE.svg]
"""

import json
import shutil
import subprocess
import sys

rows = [b for b in json.load(open(sys.argv[1]))["benchmarks"] if "ours_us" in b]


def curve(name):
    return [b for b in rows if b["name"].startswith(name + "/")]


def table(curve_name, key, head, text):
    print(f"| {head} | active pixels | tactile [µs] | longest | dense, images kept [µs] | ratio | dense, plainly [µs] | ratio |")
    print("| ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |")
    for b in curve(curve_name):
        ours, kept, plain = b["ours_us"], b["kept_us"], b["plain_us"]
        print(f"| {text(b[key])} | {b['active_pixels']:,.0f} | {ours:.1f} | {b['ours_longest_us']:.1f} | {kept:.0f} | **{kept / ours:.1f}** "
              f"| {plain:.0f} | **{plain / ours:.1f}** |".replace(",", " "))
    print()


for events, title in (("simulated", "Events of simulated runs while the skin moves"), ("anywhere", "Events anywhere on the sensor")):
    print(f"{title}, t_h = 40 ms:\n")
    table(f"rate/{events}", "events_per_s", "events/s", lambda v: f"{v:,.0f}")
    print(f"{title}, 300 000 events/s:\n")
    table(f"history/{events}", "history_ms", "t_h [ms]", lambda v: f"{v:.0f}")

if len(sys.argv) > 2:
    if not shutil.which("gnuplot"):
        sys.exit("heatmap_table.py: gnuplot is missing, so the picture is not drawn; install the package gnuplot-nox")

    def data(name, key, column, least):
        points = "".join(f"{max(b[key], least)} {b[column]}\n" for b in curve(name))
        return points + "e\n"

    def plot(key, curve_name, least):
        lines = [("tactile, simulated", f"{curve_name}/simulated", "ours_us"), ("tactile, anywhere", f"{curve_name}/anywhere", "ours_us"),
                 ("dense, images kept", f"{curve_name}/simulated", "kept_us"), ("dense, plainly", f"{curve_name}/simulated", "plain_us")]
        command = "plot " + ", ".join(f"'-' with linespoints title '{title}'" for title, _, _ in lines) + "\n"
        return command + "".join(data(name, key, column, least) for _, name, column in lines)

    script = (f"set terminal svg size 900,360 enhanced background 'white' font 'sans,12'\nset output '{sys.argv[2]}'\nset multiplot layout 1,2\n"
              "set logscale xy\nset yrange [0.1:5000]\nset grid\nset key bottom right\nset format x '10^{%T}'\n"
              "set ylabel 'one tick [µs]'\nset title 't_h = 40 ms'\nset xlabel 'events/s (0 drawn at 1000)'\n" + plot("events_per_s", "rate", 1000)
              + "set title '300 000 events/s'\nset xlabel 't_h [ms]'\nset format x '%g'\n" + plot("history_ms", "history", 1))
    subprocess.run(["gnuplot"], input=script, text=True, check=True)

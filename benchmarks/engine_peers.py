#!/usr/bin/env python3
"""Measures LeNet on one heatmap at a time, on one core: tactile, libtorch, oneDNN, ONNX Runtime and OpenVINO. Prints tables.

    engine_peers.py ENGINE_BENCHMARK MODEL ONNX HEATMAPS PEERS_PYTHON     PEERS_PYTHON: a Python with onnxruntime and openvino, or ""

All engines work in turn. A ratio is the median of the ratios of neighbours. The first logit of one heatmap is compared: an engine with
another logit is named.
"""

import json
import statistics
import sys
import time

from workers import Worker, answer_each_line, in_turn, median_ratio

ROUNDS = 15
CALLS = {"action": 64, "empty": 64}
GROUP = 16
ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "OMP_WAIT_POLICY": "passive"}
NAMES = {"fast": "tactile", "dense": "tactile, nothing skipped", "bf16": "tactile, bf16",
         "int8": "tactile, int8", "libtorch": "libtorch (`--engine libtorch`)",
         "onednn": "oneDNN", "onnxruntime": "ONNX Runtime", "openvino": "OpenVINO, f32", "openvino-bf16": "OpenVINO, bf16",
         "reading": "only reading the big layer's weights", "multiply-adds": "only the multiply-adds"}
IN_TACTILE = ("fast", "dense", "bf16", "int8", "libtorch", "onednn", "reading", "multiply-adds")
IN_PYTHON = ("onnxruntime", "openvino", "openvino-bf16")
LIMITS = ("reading", "multiply-adds")  # which classify nothing
TOLERANCES = {"bf16": 0.05, "int8": 0.05, "openvino-bf16": 0.05}  # of a logit; 1e-4 for float32


def onnxruntime_engine(model):
    import numpy as np
    import onnxruntime
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    session = onnxruntime.InferenceSession(model, options, providers=["CPUExecutionProvider"])
    logits = np.zeros((1, 3), np.float32)
    binding = session.io_binding()

    def classify(heatmap):
        binding.bind_cpu_input("heatmaps", heatmap)
        binding.bind_output("logits", "cpu", 0, np.float32, logits.shape, logits.ctypes.data)
        session.run_with_iobinding(binding)
        return logits[0, 0]
    return classify


def openvino_engine(model, precision):
    import openvino
    core = openvino.Core()
    compiled = core.compile_model(model, "CPU", {"INFERENCE_NUM_THREADS": 1, "PERFORMANCE_HINT": "LATENCY", "NUM_STREAMS": 1,
                                                 "INFERENCE_PRECISION_HINT": precision})
    request, logits = compiled.create_infer_request(), compiled.output("logits")

    def classify(heatmap):
        request.set_input_tensor(openvino.Tensor(heatmap, shared_memory=True))
        request.infer()
        return request.get_tensor(logits).data[0, 0]
    return classify


def work(engine, model, folder):
    """Runs as a worker: for each line "GROUP CALLS" the microseconds per heatmap and the first logit."""
    import numpy as np
    with open(f"{folder}/groups.json") as file:
        groups = json.load(file)
    classify = onnxruntime_engine(model) if engine == "onnxruntime" else openvino_engine(model, "bf16" if engine == "openvino-bf16" else "f32")

    def answer(line):
        group, calls = line.split()
        heatmaps = np.fromfile(f"{folder}/{group}.bin", np.uint8).reshape(-1, 1, 1, groups["height"], groups["width"])
        inputs = [np.ascontiguousarray(heatmap) for heatmap in heatmaps.astype(np.float32) / np.float32(255)]
        for each in inputs:
            classify(each)
        begin = time.perf_counter()
        for i in range(int(calls)):
            classify(inputs[i % len(inputs)])
        us = (time.perf_counter() - begin) / int(calls) * 1e6
        return f"{us:.4f} {float(classify(inputs[0])):.9g}"

    answer_each_line(answer)


def started(engines):
    """The workers that are ready, by engine; the others are named."""
    workers = {}
    for engine, command in engines.items():
        worker = Worker(command, ONE_THREAD)
        if worker.is_ready:
            workers[engine] = worker
        else:
            print(f"bench: SKIPPED {NAMES[engine]}: it does not start", file=sys.stderr)
    return workers


def measured(workers, group, calls, rounds):
    """{engine: microseconds per heatmap in each round}"""
    times, logits = {engine: [] for engine in workers}, {}
    for engine in in_turn(workers, rounds):
        us, logit = workers[engine].ask(f"{group} {calls}")
        times[engine].append(float(us))
        logits[engine] = float(logit)
    for engine, logit in logits.items():
        allowed = TOLERANCES.get(engine, 1e-4) * max(1, abs(logits["fast"]))
        if engine not in LIMITS and abs(logit - logits["fast"]) > allowed:
            print(f"bench: {group}: the logit of {NAMES[engine]} is {logit}, that of tactile {logits['fast']}", file=sys.stderr)
    return times


def print_engines(action, empty, lit_share):
    print(f"| µs a heatmap | in action, {100 * lit_share:.1f} % of cells lit | tactile's share | interquartile range | empty | tactile's share |")
    print("| --- | ---: | ---: | ---: | ---: | ---: |")
    for engine in sorted(action, key=list(NAMES).index):
        ratios = sorted(a / b for a, b in zip(action["fast"], action[engine]))
        quarter = len(ratios) // 4
        print(f"| {NAMES[engine]} | {statistics.median(action[engine]):.0f} | **{statistics.median(ratios):.2f}** | "
              f"{ratios[quarter]:.2f}–{ratios[-1 - quarter]:.2f} | {statistics.median(empty[engine]):.2f} | "
              f"**{median_ratio(empty['fast'], empty[engine]):.4f}** |", flush=True)


def print_goals(action, empty):
    share = median_ratio(action["fast"], action["onnxruntime"])
    share_when_empty = median_ratio(empty["fast"], empty["onnxruntime"])
    limits = {limit: statistics.median(action[limit]) / statistics.median(action["onnxruntime"]) for limit in LIMITS}
    print()
    for goal, limit, value in (("half of ONNX Runtime's time in action", 0.5, share), ("a third of it", 1 / 3, share),
                               ("a hundredth of it on an empty heatmap", 0.01, share_when_empty)):
        print(f"- {goal}: {'met' if value <= limit else 'NOT met'} ({value:.4f}); the bare multiply-adds take "
              f"{limits['multiply-adds']:.2f} of it, reading the weights {limits['reading']:.2f}")


def print_by_lit_share(workers, groups):
    print("\n| share of cells lit | noise-like: tactile [µs] | nothing skipped | int8 | marker-like: tactile [µs] | nothing skipped | int8 |")
    print("| ---: | ---: | ---: | ---: | ---: | ---: | ---: |")
    engines = ("fast", "dense", "int8")
    for share in sorted({float(name.split("-")[1]) for name in groups if "-" in name}):
        row = [f"{100 * share:g} %"]
        for kind in ("noise", "marker"):
            times = measured({engine: workers[engine] for engine in engines}, f"{kind}-{share:g}", GROUP * 2, 5)
            row += [f"{statistics.median(times[engine]):.1f}" for engine in engines]
        print("| " + " | ".join(row) + " |", flush=True)


def main():
    if sys.argv[1] == "--work":
        return work(*sys.argv[2:5])
    benchmark, model, onnx, folder, python = sys.argv[1:6]
    with open(f"{folder}/groups.json") as file:
        groups = json.load(file)["groups"]
    engines = {engine: (benchmark, engine, model, folder) for engine in IN_TACTILE}
    if python:
        engines.update({engine: (python, __file__, "--work", engine, onnx, folder) for engine in IN_PYTHON})
    workers = started(engines)
    action, empty = (measured(workers, group, CALLS[group], ROUNDS) for group in ("action", "empty"))
    print_engines(action, empty, groups["action"])
    if "onnxruntime" in workers:
        print_goals(action, empty)
    print_by_lit_share(workers, groups)
    for worker in workers.values():
        worker.end()


main()

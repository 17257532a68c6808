#!/usr/bin/env python3
"""LeNet on one heatmap at a time, on one core: ours, libtorch, oneDNN, ONNX Runtime and OpenVINO from one run, as tables.

    engine_peers.py ENGINE_BENCHMARK MODEL ONNX HEATMAPS PEERS_PYTHON     PEERS_PYTHON may be "" where there is none

All stand ready at once and work in turn, which first changing each time; a ratio is the median of those of neighbours. The first logit
of one heatmap is compared: who says another thing is named.
"""

import json
import os
import statistics
import subprocess
import sys
import time

ROUNDS = 15
CALLS = {"action": 64, "empty": 64}
GROUP = 16
ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "OMP_WAIT_POLICY": "passive"}
NAMES = {"fast": "tactile", "dense": "tactile, nothing skipped", "int8": "tactile, int8", "libtorch": "libtorch (`--engine libtorch`)",
         "onednn": "oneDNN", "onnxruntime": "ONNX Runtime", "openvino": "OpenVINO, f32", "openvino-bf16": "OpenVINO, bf16",
         "reading": "only reading the big layer's weights", "multiply-adds": "only the multiply-adds"}


def answer_each_line(folder, shape, work):
    import numpy as np
    print("ready", flush=True)
    for line in sys.stdin:
        group, calls = line.split()
        inputs = np.fromfile(f"{folder}/{group}.bin", np.uint8).reshape(-1, 1, 1, *shape).astype(np.float32) / np.float32(255)
        inputs = [np.ascontiguousarray(one) for one in inputs]
        for one in inputs:
            work(one)
        begun = time.perf_counter()
        for i in range(int(calls)):
            work(inputs[i % len(inputs)])
        us = (time.perf_counter() - begun) / int(calls) * 1e6
        print(f"{us:.4f} {float(work(inputs[0])):.9g}", flush=True)


def work_in_onnxruntime(model):
    import numpy as np
    import onnxruntime
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    session = onnxruntime.InferenceSession(model, options, providers=["CPUExecutionProvider"])
    logits = np.zeros((1, 3), np.float32)
    binding = session.io_binding()

    def work(heatmap):
        binding.bind_cpu_input("heatmaps", heatmap)
        binding.bind_output("logits", "cpu", 0, np.float32, logits.shape, logits.ctypes.data)
        session.run_with_iobinding(binding)
        return logits[0, 0]
    return work


def work_in_openvino(model, precision):
    import openvino
    core = openvino.Core()
    compiled = core.compile_model(model, "CPU", {"INFERENCE_NUM_THREADS": 1, "PERFORMANCE_HINT": "LATENCY", "NUM_STREAMS": 1,
                                                 "INFERENCE_PRECISION_HINT": precision})
    request, logits = compiled.create_infer_request(), compiled.output("logits")

    def work(heatmap):
        request.set_input_tensor(openvino.Tensor(heatmap, shared_memory=True))
        request.infer()
        return request.get_tensor(logits).data[0, 0]
    return work


class Worker:
    def __init__(self, name, *command):
        self.name = name
        self.process = subprocess.Popen([str(part) for part in command], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
                                        env=dict(os.environ, **ONE_THREAD))
        self.ready = self.process.stdout.readline().strip() == "ready"
        if not self.ready:
            print(f"bench: SKIPPED {NAMES.get(name, name)}, it did not start", file=sys.stderr)

    def answer(self, group, calls):
        self.process.stdin.write(f"{group} {calls}\n")
        self.process.stdin.flush()
        us, logit = self.process.stdout.readline().split()
        return float(us), float(logit)

    def end(self):
        self.process.stdin.close()
        self.process.wait()


def measured(workers, group, calls, rounds):
    """{name: [microseconds of each round]}"""
    times, logits = {worker.name: [] for worker in workers}, {}
    for turn in range(rounds):
        for worker in workers[turn % len(workers):] + workers[:turn % len(workers)]:
            us, logits[worker.name] = worker.answer(group, calls)
            times[worker.name].append(us)
    bare = ("reading", "multiply-adds")
    for name, logit in logits.items():
        allowed = {"int8": 0.05, "openvino-bf16": 0.05}.get(name, 1e-4)
        if name not in bare and abs(logit - logits["fast"]) > allowed * max(1, abs(logits["fast"])):
            print(f"bench: {NAMES.get(name, name)} says {logit} of {group}, tactile {logits['fast']}", file=sys.stderr)
    return times


def main():
    if sys.argv[1] == "--work":
        whose, model, folder = sys.argv[2:5]
        shape = [json.load(open(f"{folder}/groups.json"))[side] for side in ("height", "width")]
        work = work_in_onnxruntime(model) if whose == "onnxruntime" else work_in_openvino(
            model, "bf16" if whose == "openvino-bf16" else "f32")
        return answer_each_line(folder, shape, work)
    benchmark, model, onnx, folder, python = sys.argv[1:6]
    groups = json.load(open(f"{folder}/groups.json"))["groups"]
    ways = ["fast", "dense", "int8", "libtorch", "onednn", "reading", "multiply-adds"]
    workers = [Worker(way, benchmark, way, model, folder) for way in ways]
    if python:
        workers += [Worker(way, python, __file__, "--work", way, onnx, folder) for way in ("onnxruntime", "openvino", "openvino-bf16")]
    workers = [worker for worker in workers if worker.ready]
    names = [worker.name for worker in workers]
    action, empty = (measured(workers, group, CALLS[group], ROUNDS) for group in ("action", "empty"))
    print(f"| µs a heatmap | in action, {100 * groups['action']:.1f} % of cells lit | tactile's share | interquartile range | empty | tactile's share |")
    print("| --- | ---: | ---: | ---: | ---: | ---: |")
    for name in sorted(names, key=list(NAMES).index):
        ratios = sorted(a / b for a, b in zip(action["fast"], action[name]))
        quarter = len(ratios) // 4
        print(f"| {NAMES[name]} | {statistics.median(action[name]):.0f} | **{statistics.median(ratios):.2f}** | "
              f"{ratios[quarter]:.2f}–{ratios[-1 - quarter]:.2f} | {statistics.median(empty[name]):.2f} | "
              f"**{statistics.median(a / b for a, b in zip(empty['fast'], empty[name])):.4f}** |", flush=True)

    if "onnxruntime" in names:
        ratio = lambda times: statistics.median(a / b for a, b in zip(times["fast"], times["onnxruntime"]))
        print()
        for what, limit, value in (("half of ONNX Runtime's time in action", 0.5, ratio(action)),
                                   ("a third of it", 1 / 3, ratio(action)),
                                   ("a hundredth of it on an empty heatmap", 0.01, ratio(empty))):
            print(f"- {what}: {'met' if value <= limit else 'NOT met'} ({value:.4f}); the bare multiply-adds take "
                  f"{statistics.median(action['multiply-adds']) / statistics.median(action['onnxruntime']):.2f} of it, reading the weights "
                  f"{statistics.median(action['reading']) / statistics.median(action['onnxruntime']):.2f}")

    print("\n| share of cells lit | noise-like: tactile [µs] | nothing skipped | int8 | marker-like: tactile [µs] | nothing skipped | int8 |")
    print("| ---: | ---: | ---: | ---: | ---: | ---: | ---: |")
    ours = [worker for worker in workers if worker.name in ("fast", "dense", "int8")]
    for share in sorted({float(name.split("-")[1]) for name in groups if "-" in name}):
        row = [f"{100 * share:g} %"]
        for kind in ("noise", "marker"):
            times = measured(ours, f"{kind}-{share:g}", GROUP * 2, 5)
            row += [f"{statistics.median(times[way]):.1f}" for way in ("fast", "dense", "int8")]
        print("| " + " | ".join(row) + " |", flush=True)
    for worker in workers:
        worker.end()


main()

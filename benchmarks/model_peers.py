#!/usr/bin/env python3
"""Training and inference of LeNet on heatmaps of 128 x 96: ours, and the same network in PyTorch and onnxruntime, as tables.

    model_peers.py MODEL_BENCHMARK ONNX TORCH_PYTHON ONNXRUNTIME_PYTHON     either Python may be "" where it has not got the library

All stand ready at once and work in turn, which first changing each time; a ratio is the median of those of neighbours.
"""

import itertools
import os
import statistics
import subprocess
import sys
import time

ROUNDS = 11
IMAGES = {"train": 320, "infer": 512}
SIZE = (96, 128)
BATCH, BATCHES, CALL = 32, 64, 256
SHARES = (0.2, 0.065)  # of cells active, to learn from: a fifth, and as many as simulated runs have in 40 ms


def answer_each_line(images, at_once, work):
    work()
    print("ready", flush=True)
    for _ in sys.stdin:
        begun, done = time.perf_counter(), 0
        while done < images:
            work()
            done += at_once
        print(f"{done / (time.perf_counter() - begun):.3f}", flush=True)


def heatmaps_at_random(count, share=0.2):
    import numpy as np
    random = np.random.default_rng(1)
    shape = (count, 1, *SIZE)
    return (random.integers(0, 256, shape) * (random.random(shape) < share)).astype(np.uint8)


def work_in_torch(what, threads, images, share):
    """The same network, written as PyTorch's own examples are."""
    import torch
    from torch import nn
    torch.set_num_threads(threads)
    torch.manual_seed(1)
    network = nn.Sequential(
        nn.Conv2d(1, 6, 5), nn.ReLU(), nn.MaxPool2d(2), nn.Conv2d(6, 16, 5), nn.ReLU(), nn.MaxPool2d(2), nn.Flatten(),
        nn.Linear(9744, 120), nn.ReLU(), nn.Linear(120, 84), nn.ReLU(), nn.Linear(84, 3))
    if what == "infer":
        heatmaps = torch.from_numpy(heatmaps_at_random(CALL)).split(BATCH)  # twice as fast as all at once
        network.eval()

        def judge():
            with torch.no_grad():
                return [network(some.float() / 255) for some in heatmaps]
        return answer_each_line(images, CALL, judge)
    heatmaps = torch.from_numpy(heatmaps_at_random(BATCHES * BATCH, share)).split(BATCH)
    truth = (torch.arange(BATCHES * BATCH) % 3).split(BATCH)
    order = itertools.cycle(range(BATCHES))
    optimizer = torch.optim.Adam(network.parameters(), lr=1e-3)

    def learn():
        i = next(order)
        optimizer.zero_grad()
        loss = nn.functional.cross_entropy(network(heatmaps[i].float() / 255), truth[i])
        loss.backward()
        optimizer.step()
        return loss.item()
    return answer_each_line(images, BATCH, learn)


def work_in_onnxruntime(threads, images, model):
    import numpy as np
    import onnxruntime
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = threads
    options.add_session_config_entry("session.intra_op.allow_spinning", "0")  # or it would take the others' time
    session = onnxruntime.InferenceSession(model, options, providers=["CPUExecutionProvider"])
    heatmaps = heatmaps_at_random(CALL)
    answer_each_line(images, CALL, lambda: session.run(["logits"], {"heatmaps": heatmaps.astype(np.float32) / np.float32(255)}))


class Worker:
    def __init__(self, *command, **environment):
        self.process = subprocess.Popen([str(part) for part in command], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
                                        env=dict(os.environ, **environment))
        if self.process.stdout.readline().strip() != "ready":
            sys.exit(f"bench: {' '.join(map(str, command))} did not start")

    def images_per_s(self):
        self.process.stdin.write("\n")
        self.process.stdin.flush()
        return float(self.process.stdout.readline())

    def end(self):
        self.process.stdin.close()
        self.process.wait()


def compare(workers):
    """Lets all work in turn; gives each one's rates."""
    rates = {name: [] for name in workers}
    names = list(workers)
    for turn in range(ROUNDS):
        for name in names[turn % len(names):] + names[:turn % len(names)]:
            rates[name].append(workers[name].images_per_s())
    for worker in workers.values():
        worker.end()
    return rates


def print_row(what, rates, names):
    row = [what]
    for name in names:
        row.append(f"{statistics.median(rates[name]):.0f}" if name in rates else "-")
    for name in names[1:]:
        row.append(f"{statistics.median(a / b for a, b in zip(rates['tactile'], rates[name])):.2f}" if name in rates else "-")
    print("| " + " | ".join(row) + " |", flush=True)


def compare_training(threads, share, benchmark, torch_python):
    arguments = (threads, IMAGES["train"], share)
    workers = {"tactile": Worker(benchmark, "train", *arguments, OMP_WAIT_POLICY="passive"),  # as the commands set it
               "libtorch": Worker(benchmark, "train-libtorch", *arguments, OMP_WAIT_POLICY="passive")}
    if torch_python:
        workers["PyTorch"] = Worker(torch_python, __file__, "--work", "torch", "train", *arguments,
                                    OPENBLAS_NUM_THREADS=str(threads))  # which torch.set_num_threads does not reach
    print_row(f"{100 * share:g} % of cells active, {threads} thread{'s' if threads > 1 else ''}", compare(workers),
              ["tactile", "libtorch", "PyTorch"])


def compare_inference(threads, benchmark, onnx, torch_python, onnxruntime_python):
    images = IMAGES["infer"]
    workers = {"tactile": Worker(benchmark, "infer", threads, images, OMP_WAIT_POLICY="passive")}
    if torch_python:
        workers["PyTorch"] = Worker(torch_python, __file__, "--work", "torch", "infer", threads, images, 0.2,
                                    OPENBLAS_NUM_THREADS=str(threads))
    if onnxruntime_python:
        workers["onnxruntime"] = Worker(onnxruntime_python, __file__, "--work", "onnxruntime", "infer", threads, images, onnx)
    print_row(f"{threads} thread{'s' if threads > 1 else ''}", compare(workers), ["tactile", "PyTorch", "onnxruntime"])


def main():
    if sys.argv[1] == "--work":
        whose, what, threads, images = sys.argv[2], sys.argv[3], int(sys.argv[4]), int(sys.argv[5])
        if whose == "torch":
            return work_in_torch(what, threads, images, float(sys.argv[6]))
        return work_in_onnxruntime(threads, images, sys.argv[6])
    benchmark, onnx, torch_python, onnxruntime_python = sys.argv[1:5]
    print("| training, batches of 32 [images/s] | tactile | --engine libtorch | PyTorch | ratio to libtorch | to PyTorch |")
    print("| --- | ---: | ---: | ---: | ---: | ---: |")
    for share in SHARES:
        for threads in (1, 2):
            compare_training(threads, share, benchmark, torch_python)
    print("\n| inference [images/s] | tactile | PyTorch | onnxruntime | ratio to PyTorch | to onnxruntime |")
    print("| --- | ---: | ---: | ---: | ---: | ---: |")
    for threads in (1, 2):
        compare_inference(threads, benchmark, onnx, torch_python, onnxruntime_python)


main()

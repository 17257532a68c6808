#!/usr/bin/env python3
"""Measures training and inference of LeNet on heatmaps of 128 x 96: tactile, and the same network in PyTorch and onnxruntime. Prints tables.

    model_peers.py MODEL_BENCHMARK ONNX TORCH_PYTHON ONNXRUNTIME_PYTHON     a Python may be "" if it lacks the library

All work in turn. A ratio is the median of the ratios of neighbours.
"""

import itertools
import statistics
import sys
import time

from workers import Worker, answer_each_line, in_turn, median_ratio

ROUNDS = 11
IMAGES = {"train": 320, "infer": 512}
SIZE = (96, 128)
BATCH, BATCHES, CALL = 32, 64, 256
SHARES = (0.2, 0.065)  # of cells active in training: a fifth, and as many as in simulated runs of 40 ms


def answer_with_rate(images, images_per_call, call):
    """Runs as a worker: for each line the images/s."""
    call()

    def answer(_):
        begin, done = time.perf_counter(), 0
        while done < images:
            call()
            done += images_per_call
        return f"{done / (time.perf_counter() - begin):.3f}"

    answer_each_line(answer)


def random_heatmaps(count, share=0.2):
    import numpy as np
    random = np.random.default_rng(1)
    shape = (count, 1, *SIZE)
    return (random.integers(0, 256, shape) * (random.random(shape) < share)).astype(np.uint8)


def work_in_torch(task, threads, images, share):
    """The same network, written as in the examples of PyTorch."""
    import torch
    from torch import nn
    torch.set_num_threads(threads)
    torch.manual_seed(1)
    network = nn.Sequential(
        nn.Conv2d(1, 6, 5), nn.ReLU(), nn.MaxPool2d(2), nn.Conv2d(6, 16, 5), nn.ReLU(), nn.MaxPool2d(2), nn.Flatten(),
        nn.Linear(9744, 120), nn.ReLU(), nn.Linear(120, 84), nn.ReLU(), nn.Linear(84, 3))
    if task == "infer":
        heatmaps = torch.from_numpy(random_heatmaps(CALL)).split(BATCH)  # twice as fast as one batch
        network.eval()

        def infer():
            with torch.no_grad():
                return [network(batch.float() / 255) for batch in heatmaps]
        return answer_with_rate(images, CALL, infer)
    heatmaps = torch.from_numpy(random_heatmaps(BATCHES * BATCH, share)).split(BATCH)
    truth = (torch.arange(BATCHES * BATCH) % 3).split(BATCH)
    order = itertools.cycle(range(BATCHES))
    optimizer = torch.optim.Adam(network.parameters(), lr=1e-3)

    def train():
        i = next(order)
        optimizer.zero_grad()
        loss = nn.functional.cross_entropy(network(heatmaps[i].float() / 255), truth[i])
        loss.backward()
        optimizer.step()
        return loss.item()
    return answer_with_rate(images, BATCH, train)


def work_in_onnxruntime(threads, images, model):
    import numpy as np
    import onnxruntime
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = threads
    options.add_session_config_entry("session.intra_op.allow_spinning", "0")  # spinning would slow the others down
    session = onnxruntime.InferenceSession(model, options, providers=["CPUExecutionProvider"])
    heatmaps = random_heatmaps(CALL)
    answer_with_rate(images, CALL, lambda: session.run(["logits"], {"heatmaps": heatmaps.astype(np.float32) / np.float32(255)}))


def started(*command, **environment):
    worker = Worker(command, environment)
    if not worker.is_ready:
        sys.exit(f"bench: {' '.join(map(str, command))}: it does not start")
    return worker


def print_row(title, workers, names):
    """Measures the workers in turn and prints their rates, and the ratios of tactile to the others."""
    rates = {name: [] for name in workers}
    for name in in_turn(workers, ROUNDS):
        rates[name].append(float(workers[name].ask()[0]))
    for worker in workers.values():
        worker.end()
    row = [title]
    row += [f"{statistics.median(rates[name]):.0f}" if name in rates else "-" for name in names]
    row += [f"{median_ratio(rates['tactile'], rates[name]):.2f}" if name in rates else "-" for name in names[1:]]
    print("| " + " | ".join(row) + " |", flush=True)


def threads_text(threads):
    return f"{threads} thread{'s' if threads > 1 else ''}"


def compare_training(threads, share, benchmark, torch_python):
    arguments = (threads, IMAGES["train"], share)
    workers = {"tactile": started(benchmark, "train", *arguments, OMP_WAIT_POLICY="passive"),  # as the commands set it
               "libtorch": started(benchmark, "train-libtorch", *arguments, OMP_WAIT_POLICY="passive")}
    if torch_python:
        workers["PyTorch"] = started(torch_python, __file__, "--work", "torch", "train", *arguments,
                                     OPENBLAS_NUM_THREADS=str(threads))  # which torch.set_num_threads does not change
    print_row(f"{100 * share:g} % of cells active, {threads_text(threads)}", workers, ["tactile", "libtorch", "PyTorch"])


def compare_inference(threads, benchmark, onnx, torch_python, onnxruntime_python):
    images = IMAGES["infer"]
    workers = {"tactile": started(benchmark, "infer", threads, images, OMP_WAIT_POLICY="passive")}
    if torch_python:
        workers["PyTorch"] = started(torch_python, __file__, "--work", "torch", "infer", threads, images, 0.2,
                                     OPENBLAS_NUM_THREADS=str(threads))
    if onnxruntime_python:
        workers["onnxruntime"] = started(onnxruntime_python, __file__, "--work", "onnxruntime", "infer", threads, images, onnx)
    print_row(threads_text(threads), workers, ["tactile", "PyTorch", "onnxruntime"])


def main():
    if sys.argv[1] == "--work":
        library, task, threads, images, last = sys.argv[2:7]
        if library == "torch":
            return work_in_torch(task, int(threads), int(images), float(last))
        return work_in_onnxruntime(int(threads), int(images), last)
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

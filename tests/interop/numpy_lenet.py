"""LeNet in NumPy, written from its definition. It runs the weights of exported models."""

import json

import numpy as np

ACTIVATIONS = {"relu": lambda x: np.maximum(x, 0), "tanh": np.tanh, "sigmoid": lambda x: 1 / (1 + np.exp(-x))}
BATCH = 100  # heatmaps; a larger batch only takes more memory


def pooled(x, kind):
    n, c, h, w = x.shape
    blocks = x[:, :, :h // 2 * 2, :w // 2 * 2].reshape(n, c, h // 2, 2, w // 2, 2)
    return blocks.max(axis=(3, 5)) if kind == "max" else blocks.mean(axis=(3, 5))


def convolved(x, weight, bias):
    """Convolution of machine learning: the kernel is not flipped."""
    n, c, h, w = x.shape
    out, _, kh, kw = weight.shape
    windows = np.lib.stride_tricks.sliding_window_view(x, (kh, kw), axis=(2, 3))  # [n, c, y, x, kh, kw]
    rows = windows.transpose(0, 2, 3, 1, 4, 5).reshape(-1, c * kh * kw)
    y = rows @ weight.reshape(out, -1).T + bias
    return y.reshape(n, h - kh + 1, w - kw + 1, out).transpose(0, 3, 1, 2)


def logits_of(weights, metadata, heatmaps):
    """Logits, float64 [n, 3], of heatmaps, uint8 [n, height, width], by the weights and the metadata of a safetensors file."""
    network, described = json.loads(metadata["network"]), json.loads(metadata["input"])
    if list(heatmaps.shape[1:]) != described["shape"][1:] or described["scale"] != "heatmap / 255, in [0, 1]":
        raise ValueError(f"the input described in the file is {described}")
    activation, weights = ACTIVATIONS[network["activation"]], {name: value.astype(np.float64) for name, value in weights.items()}
    parts = []
    for first in range(0, len(heatmaps), BATCH):
        x = heatmaps[first:first + BATCH, np.newaxis].astype(np.float64) / 255
        for layer in ("conv1", "conv2"):
            x = pooled(activation(convolved(x, weights[layer + ".weight"], weights[layer + ".bias"])), network["pool"])
        x = x.reshape(len(x), -1)
        for layer in ("fc1", "fc2", "fc3"):
            x = x @ weights[layer + ".weight"].T + weights[layer + ".bias"]
            x = x if layer == "fc3" else activation(x)
        parts.append(x)
    return np.concatenate(parts)

"""Rows about exported models: other runtimes must compute the same logits."""

import json

import numpy as np

import numpy_lenet
from programs import MODEL_LOGITS, TACTILE, Process, run, tactile, wait_until
from table import Difference, row

HEATMAPS = 1000  # of the dataset, and as many random ones
LOGIT_TOLERANCE = 1e-4
NETWORKS = [(activation, pool, 0.2) for activation in ("relu", "tanh", "sigmoid") for pool in ("max", "average")] + [("relu", "max", 0.25)]


class Model:
    """A model that is trained for one epoch and exported, with its logits of heatmaps of its dataset and of random ones."""

    def __init__(self, folder, data, activation, pool, factor):
        self.name = f"{activation}-{pool}-{factor}"
        rendering = ("--th", "40", "--factor", factor)
        if not (folder / self.name).exists():
            # At first sigmoids only unlearn what distinguishes heatmaps. At a low rate they keep it.
            rate = "1e-5" if activation == "sigmoid" else "1e-3"
            tactile("train", data, "--epochs", "1", "--lr", rate, "--activation", activation, "--pool", pool, "--models", folder,
                    "--name", self.name, *rendering)
        self.onnx, self.safetensors = folder / f"{self.name}.onnx", folder / f"{self.name}.safetensors"
        tactile("export", "--models", folder, "--model", self.name, "--onnx", self.onnx, "--safetensors", self.safetensors, "--force")
        stored = stored_heatmaps(data, rendering)
        random = np.random.default_rng(1)
        shape = (HEATMAPS, *stored.shape[1:])
        noise = random.integers(0, 256, shape) * (random.random(shape) < random.random((HEATMAPS, 1, 1)))
        self.heatmaps = np.concatenate([stored, noise.astype(np.uint8)])
        self.heatmaps.tofile(folder / "heatmaps")
        run(MODEL_LOGITS, folder / self.name, folder / "heatmaps", folder / "logits")
        self.logits = np.fromfile(folder / "logits", np.float32).reshape(-1, 3)

    def expect_same(self, found, runtime):
        if found.shape != self.logits.shape or len(found) < 2 * HEATMAPS:
            raise Difference(f"{self.name}: {runtime} has {found.shape} logits, tactile {self.logits.shape}; expected {2 * HEATMAPS} rows")
        largest = float(np.abs(found - self.logits).max())
        # A network of sigmoids that has learned little has nearly the same logits for all heatmaps: then the tolerance is smaller.
        allowed = min(LOGIT_TOLERANCE, float(np.ptp(self.logits, axis=0).min()) / 20)
        if not largest <= allowed:  # NaN differs, too
            raise Difference(f"{self.name}: logits of {runtime} differ by up to {largest:.2g} from those of tactile, allowed {allowed:.2g}")
        print(f"    {self.name}: logits of {runtime} for {len(found)} heatmaps differ by at most {largest:.1g}; "
              f"those of tactile span {np.ptp(self.logits):.3g}", flush=True)


def stored_heatmaps(data, rendering):
    """HEATMAPS heatmaps, evenly spread over the samples of the dataset."""
    import h5py
    name = json.loads(tactile("heatmaps", data, "--json", *rendering))["histories"][0]["name"]
    with h5py.File(data / "dataset.h5") as file:
        heatmaps = file["heatmaps"][name][:]
    if len(heatmaps) < HEATMAPS:
        raise Difference(f"{data}: {len(heatmaps)} heatmaps, expected at least {HEATMAPS}")
    return heatmaps[np.linspace(0, len(heatmaps) - 1, HEATMAPS).astype(int)]


def models(folder):
    """Models of every activation and pooling, and of another input size; trained once for both rows."""
    data, place = folder.parent / "model-data", folder.parent / "models"
    if not data.exists():
        tactile("simulate", data, "--preset", "tiny", "--objects", "fan,sprayer,usb-hub")
        tactile("label", data)
        tactile("windows", data)
    for activation, pool, factor in NETWORKS:
        yield Model(place, data, activation, pool, factor)


@row("models in ONNX, run by onnxruntime: logits of stored and random heatmaps, every activation and pooling", "onnxruntime", "onnx", "h5py")
def onnx_models(folder):
    import onnx
    import onnxruntime
    onnxruntime.set_default_logger_severity(3)
    for model in models(folder):
        onnx.checker.check_model(onnx.load(model.onnx), full_check=True)
        session = onnxruntime.InferenceSession(str(model.onnx), providers=["CPUExecutionProvider"])
        x = model.heatmaps[:, np.newaxis].astype(np.float32) / np.float32(255)
        batches = np.array_split(x, 19)  # of two sizes
        found = [session.run(["logits", "probabilities"], {"heatmaps": batch}) for batch in batches]
        logits, probabilities = (np.concatenate(parts) for parts in zip(*found))
        model.expect_same(logits, "onnxruntime")
        exponentials = np.exp(logits.astype(float) - logits.max(axis=1, keepdims=True))
        if np.abs(probabilities - exponentials / exponentials.sum(axis=1, keepdims=True)).max() > 1e-5:
            raise Difference(f"{model.name}: the probabilities are not the softmax of the logits")
        metadata = session.get_modelmeta().custom_metadata_map
        if json.loads(metadata["classes"]) != ["none", "press", "slip"] or json.loads(metadata["rendering"])["history_us"] != 40_000:
            raise Difference(f"{model.name}: onnxruntime reads other metadata: {metadata}")


@row("models in safetensors, read by its library: logits by NumPy, every activation and pooling", "safetensors", "h5py")
def safetensors_models(folder):
    import safetensors
    import safetensors.numpy
    for model in models(folder):
        weights = safetensors.numpy.load_file(model.safetensors)
        with safetensors.safe_open(model.safetensors, "numpy") as file:
            metadata = file.metadata()
        model.expect_same(numpy_lenet.logits_of(weights, metadata, model.heatmaps), "NumPy")


@row("scalars of train --tensorboard, read by TensorBoard: those of history.csv, also of a training that was resumed", "tensorboard")
def tensorboard_scalars(folder):
    import csv
    from tensorboard.backend.event_processing.event_accumulator import EventAccumulator
    data = folder / "data"
    tactile("simulate", data, "--preset", "tiny", "--objects", "fan,sprayer,usb-hub")
    tactile("label", data, "--no-pictures")
    arguments = ("train", data, "--epochs", "4", "--validation", "0.2", "--models", folder / "models", "--name", "mine",
                 "--tensorboard", folder / "logs")
    # The first training is killed after an epoch: the second one resumes it, in a second event file.
    state = folder / "models" / "mine.training" / "last.safetensors"
    with Process(TACTILE, *arguments):
        wait_until(state.exists)
    tactile(*arguments, "--resume")
    if len(list((folder / "logs" / "mine").iterdir())) != 2:
        raise Difference("expected the event files of two processes")
    scalars = EventAccumulator(str(folder / "logs" / "mine"))
    scalars.Reload()
    with open(folder / "models" / "mine" / "history.csv", newline="") as file:
        epochs = list(csv.DictReader(file))
    columns = {"train/loss": "loss", "train/accuracy": "accuracy", "validation/loss": "validation_loss",
               "validation/accuracy": "validation_accuracy", "learning_rate": "learning_rate", "gradient_norm": "gradient_norm",
               "images_per_s": "images_per_s"}
    if set(scalars.Tags()["scalars"]) != set(columns):
        raise Difference(f"TensorBoard reads the tags {scalars.Tags()['scalars']}, expected {list(columns)}")
    for tag, column in columns.items():
        found = [(event.step, event.value) for event in scalars.Scalars(tag)]
        expected = [(int(epoch["epoch"]), float(epoch[column])) for epoch in epochs]
        if [step for step, _ in found] != [step for step, _ in expected]:
            raise Difference(f"{tag}: TensorBoard reads the epochs {[step for step, _ in found]}")
        # A scalar is a float32; history.csv has one digit after the point of images per second.
        if not np.allclose([value for _, value in found], [value for _, value in expected], rtol=1e-6, atol=0.051 if "images" in tag else 0):
            raise Difference(f"{tag}: TensorBoard reads {found}, history.csv has {expected}")
    print(f"    {len(columns)} scalars of {len(epochs)} epochs from two event files", flush=True)

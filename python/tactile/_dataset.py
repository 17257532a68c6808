"""A dataset of `tactile windows` and `tactile heatmaps`, for PyTorch or any other library."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactile import _tactile
from tactile._events import EVENT


class Dataset:
    """Heatmaps and classes of balanced samples: a map-style dataset, as torch.utils.data.DataLoader takes it.

    `dataset[i]` is a heatmap, float32 [1, height, width] in [0, 1], and its class: 0 none, 1 press, 2 slip. Workers of a
    DataLoader each open the file for themselves.
    """

    def __init__(
        self,
        path: str | os.PathLike[str] = "data/dataset.h5",
        history: float | str = 40,
        split: str | None = None,
        *,
        part: str = "train",
        train_run: str = "01",
        held_out: Sequence[str] | None = None,
    ) -> None:
        """Opens a dataset.

        history    t_h [ms] of the default rendering, a whole number, or the name of stored heatmaps, such as "th_040-1a2b3c4d"
        split      "single-run", "unseen", or None for all samples; the splits of `tactile train`
        part       "train" or "test"
        train_run  the run of each object to train on
        held_out   objects of the unseen test; if None, those of the paper's five that the file has

        Raises Error.
        """
        if part not in ("train", "test"):
            raise _tactile.Error(f"part '{part}': expected train or test")
        if isinstance(held_out, str):
            raise _tactile.Error(f"held_out '{held_out}': expected a list of objects")
        if not isinstance(history, str) and history != round(history):
            raise _tactile.Error(f"history {history}: expected whole milliseconds, or the name of stored heatmaps")
        self.path = os.fspath(path)
        self.history = history if isinstance(history, str) else f"th_{round(history):03d}"
        self._open()
        self._file.heatmap_size(self.history)
        self.runs: list[tuple[str, str]] = self._file.runs
        """(object, run) of every run of the file"""
        run, t_us, label = self._file.samples()
        rows = np.arange(len(run), dtype=np.uint32)
        if split is not None:
            train, test = self._file.split_runs(split, self._known_run(train_run), self._held_out(held_out))
            rows = rows[np.isin(run, train if part == "train" else test)]
        self.rows: NDArray[np.uint32] = rows
        """[n] the rows of the file's samples"""
        self.run: NDArray[np.uint32] = run[rows]
        """[n] index into `runs`"""
        self.t_us: NDArray[np.int64] = t_us[rows]
        """[n] the ticks, us of camera time"""
        self.labels: NDArray[np.uint8] = label[rows]
        """[n] 0 none, 1 press, 2 slip"""

    def _known_run(self, train_run: str) -> str:
        names = sorted({run for _, run in self.runs})
        if train_run not in names:
            raise _tactile.Error(f"train_run {train_run!r}: no object has such a run; expected one of {', '.join(names)}")
        return train_run

    def _held_out(self, held_out: Sequence[str] | None) -> list[str]:
        if held_out is not None:
            return list(held_out)
        objects = {name for name, _ in self.runs}
        return [name for name in _tactile.default_held_out if name in objects]

    def _open(self) -> None:
        self._file = _tactile.DatasetFile(self.path)
        self._process = os.getpid()

    def _of_this_process(self) -> Any:
        if self._process != os.getpid():  # HDF5 files do not survive a fork
            self._open()
        return self._file

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name not in ("_file", "_process")}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._open()

    def __repr__(self) -> str:
        return f"<tactile.Dataset {self.path!r} {self.history}: {len(self)} samples>"

    def __len__(self) -> int:
        return len(self.rows)

    def __getitem__(self, i: int) -> tuple[NDArray[np.float32], int]:
        if not -len(self) <= i < len(self):
            raise IndexError(f"sample {i} of {len(self)}")
        return self.__getitems__([i])[0]

    def __getitems__(self, indexes: Sequence[int]) -> list[tuple[NDArray[np.float32], int]]:
        """Several samples at once; a DataLoader calls it for a batch."""
        values = self.heatmaps(indexes)[:, None].astype(np.float32) / np.float32(255)
        return [(heatmap, int(self.labels[i])) for heatmap, i in zip(values, indexes)]

    def heatmaps(self, indexes: Sequence[int] | NDArray[Any] | None = None) -> NDArray[np.uint8]:
        """The heatmaps of samples, of all samples if None: [n, height, width], 0 to 255, as the file has them."""
        rows = self.rows if indexes is None else self.rows[np.asarray(indexes, np.int64)]
        return self._of_this_process().heatmaps(self.history, np.ascontiguousarray(rows))

    def events(self, run: int) -> NDArray[Any]:
        """The stored events of a run, an array of EVENT. `run`: index into `runs`."""
        if not 0 <= run < len(self.runs):
            raise IndexError(f"run {run} of {len(self.runs)}")
        return self._of_this_process().events(run).view(EVENT)[:, 0]

    def network_description(self) -> dict[str, Any]:
        """What a network that learned from these samples reads. Saved as NAME.json beside NAME.pt (TorchScript) or NAME.onnx,
        it lets `tactile eval` and `tactile detect` run the network; `eval` leaves out the runs of these samples."""
        runs = [int(run) for run in np.unique(self.run)]
        return json.loads(self._of_this_process().network_description(self.history, runs))

    @property
    def simulated(self) -> bool:
        """Whether it was made from simulated runs."""
        return self._of_this_process().simulated

    @property
    def manifest_hash(self) -> str:
        """Names the contents: settings, recordings and labels."""
        return self._of_this_process().manifest_hash

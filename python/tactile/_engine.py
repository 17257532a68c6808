"""Trained models, without libtorch."""

from __future__ import annotations

import json
import os
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tactile import _tactile
from tactile._events import Recording, _event_bytes, file_of


class Predictions(NamedTuple):
    """What a model predicts, one row per tick."""

    t_us: NDArray[np.int64]
    """[n] the ticks, us of camera time"""
    logits: NDArray[np.float32]
    """[n, 3] of none, press, slip"""
    probabilities: NDArray[np.float32]
    """[n, 3] of none, press, slip"""
    classes: NDArray[np.uint8]
    """[n] 0 none, 1 press, 2 slip: the largest logit"""
    events: NDArray[np.uint64]
    """[n] events in the history"""


class Engine:
    """A model bundle that `tactile train` made, of any kind. Its logits are those of `tactile detect`.

    Threads may share an engine.
    """

    def __init__(self, bundle: str | os.PathLike[str], *, precision: str = "fp32", threads: int = 0) -> None:
        """Opens the folder models/NAME. `precision`: "fp32", "bf16" or "int8"; `threads`: of `classify`, 0 is one per core. Raises Error."""
        self.path = os.fspath(bundle)
        self._classifier = _tactile.Classifier(self.path, precision, threads)
        self.description: dict[str, Any] = json.loads(self._classifier.description)
        """model.json"""

    def __repr__(self) -> str:
        return f"tactile.Engine({self.path!r})"

    @property
    def th_ms(self) -> float:
        """The history that the model was trained with [ms]."""
        return self.description["rendering"]["history_us"] / 1000

    @property
    def tick_ms(self) -> float:
        """The time between two ticks [ms]."""
        return self.description["rendering"]["tick_us"] / 1000

    @property
    def input_size(self) -> tuple[int, int]:
        """Height and width of its heatmaps [cells]; of the sensor [px] for a kind that reads no heatmaps."""
        return self._classifier.input_size

    @property
    def temperature(self) -> float:
        """The logits are divided by it before the softmax."""
        return self._classifier.temperature

    def classify(self, heatmaps: ArrayLike) -> NDArray[np.float32]:
        """The logits of heatmaps. [n, height, width] uint8, 0 to 255 -> [n, 3] of none, press, slip. Raises Error."""
        heatmaps = np.asarray(heatmaps)
        if heatmaps.dtype != np.uint8 or heatmaps.ndim != 3:
            raise _tactile.Error(f"heatmaps: {heatmaps.dtype} with {heatmaps.ndim} dimensions; expected uint8 [n, height, width]")
        return self._classifier.classify(np.ascontiguousarray(heatmaps))

    def probabilities(self, logits: ArrayLike) -> NDArray[np.float32]:
        """The probabilities of logits: [n, 3] -> [n, 3], or [3] -> [3]. Raises Error."""
        logits = np.ascontiguousarray(logits, np.float32)
        if logits.ndim not in (1, 2):
            raise _tactile.Error(f"logits: have {logits.ndim} dimensions; expected [n, 3] or [3]")
        return self._classifier.probabilities(np.atleast_2d(logits)).reshape(logits.shape)

    def predict(self, recording: Recording, *, tick_ms: float = 0) -> Predictions:
        """The predictions at every full tick of a recording. `tick_ms`: another time between ticks; 0 is the model's. Raises Error."""
        if not tick_ms >= 0:
            raise _tactile.Error(f"tick_ms {tick_ms}: expected a time in milliseconds, or 0 for the model's")
        t_us, logits, events = self._classifier.predict(file_of(recording), tick_ms)
        return Predictions(t_us, logits, self.probabilities(logits), logits.argmax(axis=1).astype(np.uint8), events)

    def stream(self, size: tuple[int, int]) -> EventStream:
        """The model on a live stream of a sensor of this width and height [px]."""
        return EventStream(self, size)


class EventStream:
    """A model that follows a live stream: add events as they arrive, and classify once those before a tick are complete."""

    def __init__(self, engine: Engine, size: tuple[int, int]) -> None:
        self._engine = engine
        self._stream = _tactile.EventStream(engine._classifier, *size)

    def add(self, events: NDArray[Any]) -> None:
        """Appends events, ascending in time. Raises Error if they go back in time or lie outside the sensor."""
        self._stream.add(_event_bytes(events))

    def classify(self, t_us: int) -> NDArray[np.float32]:
        """The logits of the history before t_us: [3], none, press, slip. Raises Error if t_us is before the last one."""
        return self._stream.classify(t_us)

    @property
    def events(self) -> int:
        """The number of events in the history."""
        return self._stream.events

    def restart(self) -> None:
        """Forgets all events: the next ones may have any time."""
        self._stream.restart()

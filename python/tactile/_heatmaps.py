"""The heatmaps of a recording, by the renderer of `tactile heatmaps` and `tactile detect`."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from typing import Any, NamedTuple, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tactile import _tactile
from tactile._events import Recording, _event_bytes, file_of


Mask = Union[str, "os.PathLike[str]", Sequence[tuple[int, int]], NDArray[np.integer[Any]], None]


class Heatmaps(NamedTuple):
    """Heatmaps of a recording, one per tick."""

    t_us: NDArray[np.int64]
    """[n] the ticks t_c, us of camera time"""
    values: NDArray[np.uint8]
    """[n, height, width] 0 to 255; the network's input is values / 255"""
    events: NDArray[np.uint64]
    """[n] events in [t_c - t_h, t_c)"""


def _settings(
    th_ms: float, tick_ms: float, denoise: str, resize: str, factor: float, mask: Mask
) -> str:
    def microseconds(name: str, ms: float) -> int:
        us = round(1000 * ms)
        if abs(us - 1000 * ms) > 1e-6:
            raise _tactile.Error(f"{name}: {ms} is no whole number of us; expected one")
        return us

    settings: dict[str, Any] = {
        "history_us": microseconds("th_ms", th_ms),
        "tick_us": microseconds("tick_ms", tick_ms),
        "denoise": denoise,
        "resize": resize,
        "factor": factor,
    }
    if isinstance(mask, (str, os.PathLike)):
        mask = _tactile.read_mask(os.fspath(mask))
    if mask is not None and len(mask) > 0:
        settings["mask"] = [[int(x), int(y)] for x, y in mask]
    return json.dumps(settings)


def heatmaps(
    recording: Recording,
    th_ms: float = 40,
    *,
    tick_ms: float = 2,
    denoise: str = "mean",
    resize: str = "area",
    factor: float = 0.2,
    mask: Mask = None,
    ticks_us: ArrayLike | None = None,
) -> Heatmaps:
    """The heatmaps of a recording: at every full tick, or at the times `ticks_us`, which ascend.

    th_ms    history t_h [ms]
    tick_ms  time between two ticks [ms]
    denoise  "mean" (the paper's text), "literal" (its equation as printed) or "none"
    resize   "area" or "linear"
    factor   size of a heatmap / size of the sensor; 1 / factor is a whole number
    mask     pixels whose events do not count: their (x, y), or the path of a table of them, such as the mask.csv of
             `tactile characterise`

    A heatmap of a DVXplorer Mini takes 12 kB. The values equal those of `dataset.h5`. Raises Error.
    """
    settings = _settings(th_ms, tick_ms, denoise, resize, factor, mask)
    if ticks_us is None:
        return Heatmaps(*_tactile.render_every_tick(file_of(recording), settings))
    return Heatmaps(*_tactile.render_ticks(file_of(recording), settings, np.ascontiguousarray(ticks_us, np.int64)))


class HeatmapRenderer:
    """Renders heatmaps of a live stream. Add events as they arrive, then move to a tick and render."""

    def __init__(
        self,
        size: tuple[int, int],
        th_ms: float = 40,
        *,
        denoise: str = "mean",
        resize: str = "area",
        factor: float = 0.2,
        mask: Mask = None,
    ) -> None:
        """`size`: width and height of the sensor [px]. The other arguments are those of `heatmaps`. Raises Error."""
        self._renderer = _tactile.Renderer(*size, _settings(th_ms, th_ms, denoise, resize, factor, mask))

    def add(self, events: NDArray[Any]) -> None:
        """Appends events, ascending in time. Raises Error if they go back in time or lie outside the sensor."""
        self._renderer.add(_event_bytes(events))

    def move_to(self, t_us: int) -> None:
        """Moves the history to [t_us - t_h, t_us). Raises Error if t_us is before the last one."""
        self._renderer.move_to(t_us)

    @property
    def events(self) -> int:
        """The number of events in the history."""
        return self._renderer.events

    def render(self) -> NDArray[np.uint8]:
        """The heatmap of the history: [height, width], 0 to 255."""
        return self._renderer.render()

    def render_exact(self) -> NDArray[np.float32]:
        """The same, not rounded."""
        return self._renderer.render_exact()

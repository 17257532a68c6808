"""Recordings as NumPy arrays."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tactile import _tactile

EVENT = np.dtype({"names": ["t", "x", "y", "on"], "formats": ["<i8", "<i2", "<i2", "u1"], "offsets": [0, 8, 10, 12], "itemsize": 16})
"""An event: t [us of camera time], x from the left [px], y from the top [px], on (1 brighter, 0 darker)."""

_ROW = np.dtype("V16")
"""An event as bytes: NumPy copies these at once, but fields one by one."""
_MOST_IN_PACKET = 2**28 // EVENT.itemsize
"""Events of the largest packet that is decompressed, whatever the recording's list says."""

_NAMES = {"t": ("t", "timestamp", "t_us"), "x": ("x",), "y": ("y",), "on": ("on", "polarity", "p")}


def event_array(t: ArrayLike, x: ArrayLike, y: ArrayLike, on: ArrayLike) -> NDArray[Any]:
    """Events from four columns of equal length: an array of EVENT. `t` in us, `x` and `y` in px. Raises Error."""
    columns = {"t": np.asarray(t), "x": np.asarray(x), "y": np.asarray(y), "on": np.asarray(on)}
    events = np.zeros(columns["t"].shape, EVENT)
    for name, values in columns.items():
        if values.shape != events.shape:
            raise _tactile.Error(f"{name}: has the shape {values.shape}; expected {events.shape}, as t has")
        if values.size and name != "on":
            if not np.array_equal(values, np.trunc(values)):
                raise _tactile.Error(f"{name}: has values that are no whole numbers; expected {'microseconds' if name == 't' else 'pixels'}")
            info = np.iinfo(EVENT[name])
            if values.min() < info.min or values.max() > info.max:
                raise _tactile.Error(f"{name}: {values.min()} to {values.max()}; expected {info.min} to {info.max}")
        events[name] = values != 0 if name == "on" else values
    return events


def _event_bytes(events: NDArray[Any]) -> NDArray[np.uint8]:
    """Events as the compiled part takes them. Not copied if they are a contiguous array of EVENT."""
    events = np.asarray(events)
    if events.dtype != EVENT:
        fields = events.dtype.names or ()
        found = {name: next((known for known in names if known in fields), None) for name, names in _NAMES.items()}
        missing = [name for name, field in found.items() if field is None]
        if missing:
            raise _tactile.Error(f"events: have no field {missing[0]}; expected t, x, y and on, as tactile.EVENT has")
        events = event_array(*(events[found[name]] for name in ("t", "x", "y", "on")))
    if events.ndim != 1:
        raise _tactile.Error(f"events: have {events.ndim} dimensions; expected 1")
    return np.ascontiguousarray(events).view(np.uint8).reshape(-1, EVENT.itemsize)


@dataclass(frozen=True)
class ImuSample:
    """The samples of the inertial sensor, in arrays with a row for each."""

    t: NDArray[np.int64]
    """[n] us of camera time"""
    temperature_c: NDArray[np.float32]
    """[n] degrees Celsius"""
    acceleration_g: NDArray[np.float32]
    """[n, 3] x, y, z; g"""
    angular_rate_dps: NDArray[np.float32]
    """[n, 3] degrees/s"""
    magnetic_field_ut: NDArray[np.float32]
    """[n, 3] microtesla"""


@dataclass(frozen=True)
class Trigger:
    """Signals at the camera's trigger input."""

    t: NDArray[np.int64]
    """[n] us of camera time"""
    type: NDArray[np.int8]
    """[n] 1 rising edge, 2 falling edge, 3 pulse; others as AEDAT4 numbers them"""


@dataclass(frozen=True)
class Frame:
    """A picture of the camera."""

    t: int
    """us of camera time"""
    pixels: NDArray[np.uint8]
    """[height, width, channels]; colours in the order blue, green, red"""


class Recording:
    """An AEDAT4 recording, or a Prophesee RAW file of EVT2 or EVT3. Damaged packets are left out and counted in `problems`.

    Threads may share a recording; one of them reads at a time.
    """

    def __init__(self, path: str | os.PathLike[str], stream: str = "") -> None:
        """Opens a recording. `stream` chooses one of several event streams, by its id or source. Raises Error."""
        self.path = os.fspath(path)
        self._file = _tactile.Recording(self.path, stream)
        self._packets = self._file.packets()

    def __repr__(self) -> str:
        return f"tactile.Recording({self.path!r})"

    @property
    def size(self) -> tuple[int, int] | None:
        """Width and height of the sensor [px]; None if the recording does not declare them."""
        return self._file.size

    @property
    def source(self) -> str:
        """The camera, such as "DVXplorer_DXA00000"."""
        return self._file.source

    @property
    def problems(self) -> dict[str, Any]:
        """What is wrong with the recording; empty for a sound one. Counts are complete once all events have been read."""
        return self._file.problems

    @property
    def first_us(self) -> int | None:
        """Time of the first event [us]; None without events."""
        return min((first for _, _, first, _ in self._packets), default=None)

    @property
    def last_us(self) -> int | None:
        """Time of the last event [us]; None without events."""
        return max((last for _, _, _, last in self._packets), default=None)

    def __len__(self) -> int:
        """The number of events, by the recording's list of packets."""
        return sum(count for _, count, _, _ in self._packets)

    def _packets_between(self, begin_us: int | None, end_us: int | None) -> list[tuple[int, int, int, int]]:
        """Index, number of events, first and last time of each packet that overlaps begin_us <= t < end_us."""
        return [
            packet
            for packet in self._packets
            if (end_us is None or packet[2] < end_us) and (begin_us is None or packet[3] >= begin_us)
        ]

    def chunks(self, begin_us: int | None = None, end_us: int | None = None) -> Iterator[NDArray[Any]]:
        """The events with begin_us <= t < end_us, one packet of the recording after the other: arrays of EVENT.

        An array owns its memory, into which the packet was decompressed. It is not copied.
        """
        for packet, _, first, last in self._packets_between(begin_us, end_us):
            events = self._file.take_events(packet).view(EVENT)[:, 0]
            is_part = (begin_us is not None and first < begin_us) or (end_us is not None and last >= end_us)
            if is_part:
                t = events["t"]
                keep = np.ones(len(t), bool)
                if begin_us is not None:
                    keep &= t >= begin_us
                if end_us is not None:
                    keep &= t < end_us
                events = events[keep]
            if len(events):
                yield events

    def events(self, begin_us: int | None = None, end_us: int | None = None) -> NDArray[Any]:
        """All events with begin_us <= t < end_us: one array of EVENT, 16 bytes per event."""
        listed = sum(min(count, _MOST_IN_PACKET) for _, count, _, _ in self._packets_between(begin_us, end_us))
        rows, count = np.empty(listed, _ROW), 0
        for chunk in self.chunks(begin_us, end_us):
            end = count + len(chunk)
            if end > len(rows):  # the list says too little
                rows.resize(2 * end, refcheck=False)
            rows[count:end] = chunk.view(_ROW)
            count = end
        rows.resize(count, refcheck=False)
        return rows.view(EVENT)

    def imu(self) -> ImuSample:
        """All samples of the inertial sensor."""
        t, values = self._file.imu()
        return ImuSample(t, values[:, 0], values[:, 1:4], values[:, 4:7], values[:, 7:10])

    def triggers(self) -> Trigger:
        """All triggers."""
        return Trigger(*self._file.triggers())

    def frames(self) -> Iterator[Frame]:
        """The camera's pictures, one after the other."""
        for packet in self._file.frame_packets():
            frame = self._file.frame(packet)
            if frame is not None:
                yield Frame(*frame)


def file_of(recording: Recording) -> Any:
    """The compiled part of a recording. Raises Error if it is something else, such as a path."""
    if not isinstance(recording, Recording):
        raise _tactile.Error(f"{recording!r} is no recording; expected tactile.Recording(path)")
    return recording._file

"""Labels of a run."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass, field

from tactile import _tactile


@dataclass(frozen=True)
class Interval:
    """A press or a slip. A tick t_c is in it if start_us < t_c <= end_us."""

    id: str
    touch: str
    """ "press" or "slip" """
    start_us: int
    start_low_us: int
    """95 % interval of the onset"""
    start_high_us: int
    end_us: int
    end_low_us: int
    end_high_us: int
    source: str
    """where the onset comes from, such as "events" or "person" """
    confirmed: bool
    """a person has looked at it"""
    probability: float | None = None
    """that it is a touch of this class; None: a person added it"""
    visible_us: int | None = None
    """the first time at which a person would see it in the events; None: there is none"""


@dataclass(frozen=True)
class Flag:
    """A doubt that a person should check."""

    interval: int | None
    """index into the intervals; None: of the whole run"""
    reason: str
    confirmed: bool


@dataclass(frozen=True)
class Labels:
    """The labels of a run, as labels.json has them. Times are us of camera time."""

    intervals: list[Interval]
    flags: list[Flag] = field(default_factory=list)
    releases: list[tuple[int, int]] = field(default_factory=list)
    """start and end of motion without a class"""
    remarks: list[str] = field(default_factory=list)

    @property
    def flagged(self) -> bool:
        """Whether a flag is not confirmed."""
        return any(not flag.confirmed for flag in self.flags)


def read_labels(path: str | os.PathLike[str]) -> Labels:
    """The labels in labels.json, or of the folder of a run. Raises Error."""
    path = os.fspath(path)
    if os.path.isdir(path):
        path = os.path.join(path, "labels.json")
    content = json.loads(_tactile.labels_text(path))

    def interval(entry: dict) -> Interval:
        same = {name: entry[name] for name in ("id", "source", "confirmed")}
        times = {f"{which}{bound}_us": entry[f"{which}{bound}_us"] for which in ("start", "end") for bound in ("", "_low", "_high")}
        of_model = {name: entry.get(name) for name in ("probability", "visible_us")}
        return Interval(touch=entry["class"], **same, **times, **of_model)

    return Labels(
        intervals=[interval(entry) for entry in content["intervals"]],
        flags=[Flag(entry["interval"], entry["reason"], entry["confirmed"]) for entry in content.get("flags", [])],
        releases=[(entry["start_us"], entry["end_us"]) for entry in content.get("releases", [])],
        remarks=content.get("remarks", []),
    )

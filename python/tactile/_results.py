"""Results of `tactile eval`."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar

from tactile import _tactile

T = TypeVar("T")


@dataclass(frozen=True)
class Figure:
    """A value and its 95 % interval.

    value      None where nothing was there to measure
    low, high  None also where too few objects or runs were there for an interval
    n          the runs or objects that the interval is drawn from
    """

    value: float | None
    low: float | None
    high: float | None
    n: int


@dataclass(frozen=True)
class Delay:
    """Detection delay of one class, from the labelled onset."""

    median_of_all_ms: Figure
    """over all intervals; a missed one counts with its limit"""
    p90_of_all_ms: Figure
    mean_ms: Figure
    """over the detected intervals, as the paper has it"""
    missed: Figure
    """share of the intervals"""
    intervals: int


@dataclass(frozen=True)
class FalseAlarms:
    """False alarms in the three forms that are reported together, and episodes of the wrong class."""

    outside_labels_per_min: Figure
    outside_motion_per_min: Figure
    none_in_alarm: Figure
    """share of the time without motion that is in alarm"""
    wrong_class_per_min: Figure


@dataclass(frozen=True)
class Evaluation:
    """How a model does on runs that it was not trained on."""

    title: str
    simulated: bool
    accuracy: Figure
    accuracy_by_object: dict[str, Figure]
    delay: dict[str, Delay]
    """of "press" and "slip" """
    false_alarms: FalseAlarms
    baselines: dict[str, Figure]
    """accuracy of simpler methods, by name"""
    calibration_error: Figure
    confusion: list[list[int]]
    """[true class][predicted class], in the order none, press, slip"""
    everything: dict[str, Any]
    """eval.json"""


def figure(entry: Any) -> Figure:
    return Figure(entry["value"], entry["low"], entry["high"], entry["n"])


def _delay(entry: dict[str, Any]) -> Delay:
    median, p90, mean, missed = (figure(entry[name]) for name in ("median_of_all", "p90_of_all", "mean", "missed"))
    return Delay(median, p90, mean, missed, entry["intervals"])


def read_json(path: str, written_as: str, build: Callable[[dict[str, Any]], T], format: str | None = None) -> T:
    """What `build` makes of a file that the program writes. Raises Error.

    written_as  "eval.json of 'tactile eval'"
    format      what the file says of itself; None: it says nothing
    """
    try:
        with open(path, encoding="utf-8") as file:
            content = json.load(file)
    except OSError as error:
        raise _tactile.Error(f"{path}: {error.strerror}; expected {written_as}") from None
    except ValueError:
        raise _tactile.Error(f"{path}: is no JSON text; expected {written_as}") from None
    found = content.get("format") if isinstance(content, dict) else None
    if format is not None and found != format:
        raise _tactile.Error(f"{path}: is of format {found!r}; expected {format!r}, as in {written_as}")
    try:
        return build(content)
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise _tactile.Error(f"{path}: its contents cannot be used ({error!r:.80}); expected {written_as}") from None


def _evaluation(content: dict[str, Any]) -> Evaluation:
    alarms = content["false_alarms"]
    return Evaluation(
        title=content["title"],
        simulated=content["simulated"],
        accuracy=figure(content["accuracy"]["mean"]),
        accuracy_by_object={name: figure(entry) for name, entry in content["accuracy"]["objects"].items()},
        delay={name: _delay(content["delay_ms"][name]) for name in ("press", "slip")},
        false_alarms=FalseAlarms(
            figure(alarms["outside_labels"]["per_min"]),
            figure(alarms["outside_motion"]["per_min"]),
            figure(alarms["none_in_alarm"]["share"]),
            figure(alarms["wrong_class"]["per_min"]),
        ),
        baselines={name: figure(entry["accuracy"]) for name, entry in content["baselines"].items()},
        calibration_error=figure(content["calibration"]["ece"]),
        confusion=content["confusion"],
        everything=content,
    )


def read_evaluation(path: str | os.PathLike[str]) -> Evaluation:
    """The results in eval.json, or the newest results in the folder of a model. Raises Error."""
    path = os.fspath(path)
    if os.path.isdir(path):
        found = [name for name in os.listdir(path) if re.fullmatch(r"eval(-on-[0-9a-f]{8})?\.json", name)]
        files = [os.path.join(path, name) for name in found]
        path = max(files, key=os.path.getmtime, default=os.path.join(path, "eval.json"))
    return read_json(path, "eval.json; 'tactile eval --model MODEL' writes it", _evaluation)

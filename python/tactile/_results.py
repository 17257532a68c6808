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
    low, high  None also where there were too few objects or runs for an interval
    n          the runs, objects or worlds that the interval is over
    """

    value: float | None
    low: float | None
    high: float | None
    n: int


@dataclass(frozen=True)
class Delay:
    """Detection delay of one class, from the labelled onset."""

    median_of_all_ms: Figure
    """over all touches; one that is missed or early is later than all others. A quantile among these is a lower bound,
    without an interval"""
    p90_of_all_ms: Figure
    mean_ms: Figure
    """over the detected touches, as the paper has it"""
    missed: Figure
    """share of the touches"""
    intervals: int
    """all touches"""


@dataclass(frozen=True)
class OperatingPoint:
    """A detector on whole runs, at one threshold."""

    threshold: float | None
    """log-odds from which a touch is reported; None: the verdicts as they were decided"""
    alarms_per_min: Figure
    """false alarms, of the time outside of touches"""
    median_ms: Figure
    p90_ms: Figure
    """delay over all touches; one that is not detected is later than all others"""
    median_is_lower_bound: bool
    p90_is_lower_bound: bool
    """too few touches are detected for the quantile: the true one is longer"""
    missed: Figure
    """share of touches that are missed, or in alarm since before their onset"""
    wrong_class: Figure
    """episodes of the other class per touch"""
    false_slips: Figure
    """share of lifts without slip in which slip is reported"""


@dataclass(frozen=True)
class WholeRuns:
    """A detector on every run: also those without a press or a slip, firm lifts, and flagged ones."""

    runs: list[str]
    """as "fan/03" or, of several worlds, as "501/fan/03" """
    left_out: list[tuple[str, str]]
    """runs that are not judged, and why; the run is empty where the reason is about a folder"""
    units: str
    """what intervals are over: "worlds", "objects", or "runs" of one or two objects"""
    decided: OperatingPoint
    causes: dict[str, int]
    """false alarms of `decided` by cause"""
    curve: list[OperatingPoint]
    """by ascending threshold"""
    calm: dict[float, OperatingPoint | None]
    """the lowest threshold from which on there are at most so many false alarms a minute; None: there is none"""
    confirmed: OperatingPoint | None
    """confirmed slips alone, without presses; None where verdicts are not decided by two thresholds"""


@dataclass(frozen=True)
class Evaluation:
    """How a model does on runs that it was not trained on."""

    title: str
    simulated: bool
    accuracy: Figure
    accuracy_by_object: dict[str, Figure]
    delay: dict[str, Delay]
    """of "press" and "slip" """
    whole_runs: WholeRuns
    baselines: dict[str, OperatingPoint]
    """published detectors on the same runs, by name, as decided"""
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


def operating_point(entry: dict[str, Any]) -> OperatingPoint:
    names = ("alarms_per_min", "median_ms", "p90_ms", "missed", "wrong_class", "false_slips")
    return OperatingPoint(
        threshold=entry["threshold"],
        median_is_lower_bound=entry["median_ms"]["is_lower_bound"],
        p90_is_lower_bound=entry["p90_ms"]["is_lower_bound"],
        **{name: figure(entry[name]) for name in names},
    )


def whole_runs(content: dict[str, Any]) -> WholeRuns:
    return WholeRuns(
        runs=content["runs"],
        left_out=[(run["run"], run["why"]) for run in content["left_out"]],
        units=content["units"],
        decided=operating_point(content["decided"]),
        causes=content["causes"],
        curve=[operating_point(entry) for entry in content["curve"]],
        calm={entry["at_most_per_min"]: entry["point"] and operating_point(entry["point"]) for entry in content["calm"]},
        confirmed=content["confirmed"] and operating_point(content["confirmed"]),
    )


def _evaluation(content: dict[str, Any]) -> Evaluation:
    return Evaluation(
        title=content["title"],
        simulated=content["simulated"],
        accuracy=figure(content["accuracy"]["mean"]),
        accuracy_by_object={name: figure(entry) for name, entry in content["accuracy"]["objects"].items()},
        delay={name: _delay(content["delay_ms"][name]) for name in ("press", "slip")},
        whole_runs=whole_runs(content["whole_runs"]),
        baselines={name: operating_point(entry["decided"]) for name, entry in content["baselines"].items()},
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

"""Results of `tactile reproduce`, `trade` and `stress`."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any

from tactile._results import Figure, figure, read_json


@dataclass(frozen=True)
class Claim:
    """A claim of the paper, and what was measured.

    paper     the paper's figures
    measured  holds if it is `asked` ("below" or "above") the `limit`
    unit      %, points (of percent), ms or objects
    verdict   holds, does not, or cannot tell
    why       why the claim cannot be decided; empty if it can
    """

    id: str
    claim: str
    paper: str
    measured: Figure
    asked: str
    limit: float
    unit: str
    verdict: str
    why: str


@dataclass(frozen=True)
class Study:
    """What `tactile reproduce` found.

    th_ms              the history to use
    model              a model with this history: that of the first training, in the study's folder `models`
    accuracy           by history [ms], on the runs that no training learned from or chose on
    unseen_difference  accuracy on objects held out of training minus that of models trained on them; None: none held out
    everything         study.json
    """

    title: str
    simulated: bool
    th_ms: float
    model: str
    accuracy: dict[float, Figure]
    unseen_difference: Figure | None
    claims: list[Claim]
    everything: dict[str, Any]


@dataclass(frozen=True)
class TradePoint:
    """A setting, and how it does on the reported runs.

    text                   its differences from the usual setting
    setting                the value of each option
    median_delay_us        over all presses and slips; a missed one counts with its limit
    p90_delay_us           as above, the delay that 90 % do not exceed
    missed                 share of presses and slips
    false_alarms_per_min   false alarms, of the time outside of touches
    median_tick_us, p99_tick_us   time of a tick
    is_on_accuracy_front   on the front of accuracy and p99_tick_us, on the runs to choose on
    is_on_delay_front      on the front of false alarms, median delay and misses, on the runs to choose on
    """

    id: str
    text: str
    setting: dict[str, Any]
    accuracy: Figure
    median_delay_us: Figure
    p90_delay_us: Figure
    missed: Figure
    false_alarms_per_min: Figure
    median_tick_us: Figure
    p99_tick_us: Figure
    is_on_accuracy_front: bool
    is_on_delay_front: bool


@dataclass(frozen=True)
class Trade:
    """What `tactile trade` found. The usual setting is the first point."""

    title: str
    simulated: bool
    points: list[TradePoint]
    recommendation: str
    everything: dict[str, Any]
    """trade.json"""


@dataclass(frozen=True)
class StressPoint:
    """Accuracy at one severity."""

    severity: float
    """0: the unchanged runs"""
    accuracy: Figure
    accuracy_change: Figure
    """from severity 0, paired over runs and trainings; without a value at severity 0"""


@dataclass(frozen=True)
class StressCurve:
    """A model on runs that a recipe or a simulated world worsens more and more."""

    model: str
    name: str
    """of the recipe or world"""
    unit: str
    points: list[StressPoint]


@dataclass(frozen=True)
class Stress:
    """What `tactile stress` found on runs; `everything` also has quiet recordings, delays and false alarms."""

    title: str
    simulated: bool
    curves: list[StressCurve]
    everything: dict[str, Any]
    """stress.json"""


def _study(content: dict[str, Any]) -> Study:
    unseen = content["unseen"] and content["unseen"]["reported"]
    return Study(
        title=content["title"],
        simulated=content["simulated"],
        th_ms=content["choice"]["th_ms"],
        model=content["choice"]["model"],
        accuracy={entry["th_ms"]: figure(entry["accuracy"]["reported"]["mean"]) for entry in content["histories"]},
        unseen_difference=figure(unseen["mean"]["difference"]) if unseen else None,
        claims=[
            Claim(**{**{name: entry[name] for name in Claim.__dataclass_fields__}, "measured": figure(entry["measured"])})
            for entry in content["claims"]
        ],
        everything=content,
    )


def _point(entry: dict[str, Any]) -> TradePoint:
    reported = entry["reported"]
    return TradePoint(
        id=entry["id"],
        text=entry["text"],
        setting=entry["setting"],
        accuracy=figure(reported["accuracy"]),
        median_delay_us=figure(reported["delay_us"]["median"]),
        p90_delay_us=figure(reported["delay_us"]["p90"]),
        missed=figure(reported["delay_us"]["missed"]),
        false_alarms_per_min=figure(reported["episodes_per_min"]),
        median_tick_us=figure(reported["us"]["p50"]),
        p99_tick_us=figure(reported["us"]["p99"]),
        is_on_accuracy_front=entry["front"]["accuracy"],
        is_on_delay_front=entry["front"]["delay"],
    )


def _trade(content: dict[str, Any]) -> Trade:
    points = [_point(entry) for entry in content["points"]]
    return Trade(content["title"], content["simulated"], points, content["recommendation"]["sentence"], content)


def _curve(model: str, entry: dict[str, Any]) -> StressCurve:
    points = [
        StressPoint(point["severity"], figure(point["accuracy"]), figure(point["accuracy_change"]))
        for point in entry["points"]
    ]
    return StressCurve(model, entry["name"], entry["unit"], points)


def _stress(content: dict[str, Any]) -> Stress:
    curves = [_curve(model["name"], entry) for model in content["models"] for entry in model["curves"]]
    return Stress(content["title"], content["simulated"], curves, content)


def _file(path: str | os.PathLike[str], name: str) -> str:
    return os.path.join(path, name) if os.path.isdir(path) else os.fspath(path)


def read_study(path: str | os.PathLike[str] = "study") -> Study:
    """The results in study.json, or in the folder that has it. Raises Error."""
    return read_json(_file(path, "study.json"), "study.json of 'tactile reproduce'", _study, "tactile-study-1")


def read_trade(path: str | os.PathLike[str] = "trade") -> Trade:
    """The results in trade.json, or in the folder that has it. Raises Error."""
    return read_json(_file(path, "trade.json"), "trade.json of 'tactile trade'", _trade, "tactile-trade-1")


def read_stress(path: str | os.PathLike[str] = "stress") -> Stress:
    """The results in stress.json, or in the folder that has it. Raises Error."""
    return read_json(_file(path, "stress.json"), "stress.json of 'tactile stress'", _stress, "tactile-stress-1")

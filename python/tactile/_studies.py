"""Results of `tactile reproduce`, `trade` and `stress`."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any

from tactile._results import Figure, figure, read_json


@dataclass(frozen=True)
class Claim:
    """A claim of the paper, and what was measured."""

    id: str
    claim: str
    measured: Figure
    unit: str
    """%, points (of percent), ms or objects"""
    verdict: str
    """holds, does not, or cannot tell"""
    why: str
    """why the claim cannot be decided; empty if it can"""


@dataclass(frozen=True)
class Study:
    """What `tactile reproduce` found."""

    title: str
    simulated: bool
    th_ms: float
    """the history to use"""
    model: str
    """its model of the first training"""
    accuracy: dict[float, Figure]
    """by history [ms], on the runs that no training learned from or chose on"""
    unseen_difference: Figure | None
    """accuracy on objects held out of training minus that on the same objects in training; None if none was held out"""
    claims: list[Claim]
    everything: dict[str, Any]
    """study.json"""


@dataclass(frozen=True)
class TradePoint:
    """A setting, and how it does on the reported runs."""

    id: str
    text: str
    """its differences from the usual setting"""
    setting: dict[str, Any]
    accuracy: Figure
    median_delay_us: Figure
    """over all presses and slips; a missed one counts with its limit"""
    missed: Figure
    """share of presses and slips"""
    false_alarms_per_min: Figure
    median_us: Figure
    """time of a tick"""
    p99_us: Figure
    is_on_front: bool
    """no other setting is more accurate and as fast, on the runs to choose on"""


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
            Claim(entry["id"], entry["claim"], figure(entry["measured"]), entry["unit"], entry["verdict"], entry["why"])
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
        missed=figure(reported["delay_us"]["missed"]),
        false_alarms_per_min=figure(reported["false_alarms_per_min"]),
        median_us=figure(reported["us"]["p50"]),
        p99_us=figure(reported["us"]["p99"]),
        is_on_front=entry["front"]["accuracy"],
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
    return read_json(_file(path, "study.json"), "study.json of 'tactile reproduce'", _study)


def read_trade(path: str | os.PathLike[str] = "trade") -> Trade:
    """The results in trade.json, or in the folder that has it. Raises Error."""
    return read_json(_file(path, "trade.json"), "trade.json of 'tactile trade'", _trade)


def read_stress(path: str | os.PathLike[str] = "stress") -> Stress:
    """The results in stress.json, or in the folder that has it. Raises Error."""
    return read_json(_file(path, "stress.json"), "stress.json of 'tactile stress'", _stress)

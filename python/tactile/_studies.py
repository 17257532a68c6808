"""Results of `tactile reproduce`, `trade` and `stress`."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any

from tactile._results import Figure, OperatingPoint, WholeRuns, figure, operating_point, read_json, whole_runs


@dataclass(frozen=True)
class Claim:
    """A sentence of the paper. It is tested in each replicate of its study: one training of each setting in one world.

    paper         the sentence
    figure        of the paper: "8"
    measure       what decides whether a replicate would write the sentence
    is_below      the sentence is written where the measure is below `limit`; else where it is above
    is_by_margin  the interval of `measured` decides the outcome, and `limit` is its margin
    unit          of `limit` and `measured`: %, points (of percent), ms or objects
    written       in so many of `replicates` the sentence would be written
    measured      the mean over replicates
    outcome       holds, does not, or cannot tell
    """

    id: str
    figure: str
    paper: str
    measure: str
    is_below: bool
    limit: float
    is_by_margin: bool
    unit: str
    written: int
    replicates: int
    measured: Figure
    outcome: str


@dataclass(frozen=True)
class StudyWorld:
    """Runs that share their objects and their sensor.

    name      the seed of a simulated world; empty if the study has one world only
    data      folder of its runs, relative to the study's folder
    runs      with samples
    held_out  objects that are held out of training for the test of unseen objects
    """

    name: str
    data: str
    runs: int
    samples: int
    held_out: list[str]


@dataclass(frozen=True)
class StudySetting:
    """What a setting gives over all worlds and trainings.

    text                in words
    is_unseen           on objects that were held out of training
    th_ms               history of a LeNet; None: a stream
    accuracy            of balanced samples, the mean over objects
    whole_runs          None where only samples were judged
    """

    text: str
    is_unseen: bool
    th_ms: float | None
    accuracy: Figure
    accuracy_by_object: dict[str, Figure]
    whole_runs: WholeRuns | None


@dataclass(frozen=True)
class Study:
    """What `tactile reproduce` found.

    settings           by name: "th040", "stream", "th040-unseen", "stream-unseen"
    unseen_difference  by the name of the setting: accuracy on objects held out of training minus that with them in
                       training, on the same runs; empty if none could be held out
    found              sentences
    cells              the table that every figure is made from, a CSV in the study's folder
    everything         study.json
    """

    title: str
    simulated: bool
    worlds: list[StudyWorld]
    settings: dict[str, StudySetting]
    unseen_difference: dict[str, Figure]
    claims: list[Claim]
    found: list[str]
    cells: str
    everything: dict[str, Any]


@dataclass(frozen=True)
class TradePoint:
    """A setting, and how it does on the reported runs.

    text                   its differences from the usual setting
    setting                the value of each option
    accuracy               of balanced samples
    whole_runs             false alarms, delays and misses; delays include the median time of a tick
    median_tick_us, p99_tick_us   time of a tick
    is_on_accuracy_front   on the front of accuracy and p99_tick_us, on the runs to choose on
    is_on_delay_front      on the front of false alarms, median delay and misses, on the runs to choose on
    """

    id: str
    text: str
    setting: dict[str, Any]
    accuracy: Figure
    whole_runs: OperatingPoint
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


def _setting(entry: dict[str, Any]) -> StudySetting:
    return StudySetting(
        text=entry["text"],
        is_unseen=entry["is_unseen"],
        th_ms=entry["th_ms"],
        accuracy=figure(entry["accuracy"]["mean"]),
        accuracy_by_object={name: figure(of) for name, of in entry["accuracy"]["objects"].items()},
        whole_runs=whole_runs(entry["whole_runs"]) if entry["whole_runs"]["runs"] else None,
    )


def _study(content: dict[str, Any]) -> Study:
    return Study(
        title=content["title"],
        simulated=content["simulated"],
        worlds=[StudyWorld(**{name: world[name] for name in StudyWorld.__dataclass_fields__}) for world in content["worlds"]],
        settings={entry["setting"]: _setting(entry) for entry in content["results"]},
        unseen_difference={
            entry["setting"]: figure(entry["accuracy"]["mean"]["difference"]) for entry in content["unseen"]
        },
        claims=[
            Claim(**{**{name: entry[name] for name in Claim.__dataclass_fields__}, "measured": figure(entry["measured"])})
            for entry in content["claims"]
        ],
        found=content["found"],
        cells=content["cells"],
        everything=content,
    )


def _point(entry: dict[str, Any]) -> TradePoint:
    reported = entry["reported"]
    return TradePoint(
        id=entry["id"],
        text=entry["text"],
        setting=entry["setting"],
        accuracy=figure(reported["accuracy"]),
        whole_runs=operating_point(reported["whole_runs"]),
        median_tick_us=figure(reported["us_p50"]),
        p99_tick_us=figure(reported["us_p99"]),
        is_on_accuracy_front=entry["on_accuracy_front"],
        is_on_delay_front=entry["on_delay_front"],
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
    return read_json(_file(path, "study.json"), "study.json of 'tactile reproduce'", _study, "tactile-study-2")


def read_trade(path: str | os.PathLike[str] = "trade") -> Trade:
    """The results in trade.json, or in the folder that has it. Raises Error."""
    return read_json(_file(path, "trade.json"), "trade.json of 'tactile trade'", _trade, "tactile-trade-2")


def read_stress(path: str | os.PathLike[str] = "stress") -> Stress:
    """The results in stress.json, or in the folder that has it. Raises Error."""
    return read_json(_file(path, "stress.json"), "stress.json of 'tactile stress'", _stress, "tactile-stress-2")

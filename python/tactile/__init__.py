"""Recordings of event-camera tactile sensors, their heatmaps, and models that detect press and slip.

    recording = tactile.Recording("data/fan/02/events.aedat4")
    rendered = tactile.heatmaps(recording, th_ms=40)
    engine = tactile.Engine("models/NAME")
    predicted = engine.predict(recording)

Times are whole microseconds of the camera's clock. docs/python.md describes the module.
"""

from tactile._dataset import Dataset
from tactile._engine import Engine, EventStream, Predictions
from tactile._events import EVENT, Frame, ImuSample, Recording, Trigger, event_array
from tactile._heatmaps import HeatmapRenderer, Heatmaps, heatmaps
from tactile._labels import Flag, Interval, Labels, read_labels
from tactile._results import Delay, Evaluation, Figure, OperatingPoint, WholeRuns, read_evaluation
from tactile._studies import (
    Claim,
    Stress,
    StressCurve,
    StressPoint,
    Study,
    StudySetting,
    StudyWorld,
    Trade,
    TradePoint,
    read_stress,
    read_study,
    read_trade,
)
from tactile._tactile import Error
from tactile._tactile import version as __version__

CLASSES = ("none", "press", "slip")

__all__ = [
    "CLASSES",
    "EVENT",
    "Claim",
    "Dataset",
    "Delay",
    "Engine",
    "Error",
    "Evaluation",
    "EventStream",
    "Figure",
    "Flag",
    "Frame",
    "HeatmapRenderer",
    "Heatmaps",
    "ImuSample",
    "Interval",
    "Labels",
    "OperatingPoint",
    "Predictions",
    "Recording",
    "Stress",
    "StressCurve",
    "StressPoint",
    "Study",
    "StudySetting",
    "StudyWorld",
    "Trade",
    "TradePoint",
    "Trigger",
    "WholeRuns",
    "__version__",
    "event_array",
    "heatmaps",
    "read_evaluation",
    "read_labels",
    "read_stress",
    "read_study",
    "read_trade",
]

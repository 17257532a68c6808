"""A folder with simulated runs, a dataset and trained models, made once by the program TACTILE."""

import os
import pathlib
import subprocess

import pytest

TACTILE = os.environ.get("TACTILE", str(pathlib.Path(__file__).resolve().parents[2] / "build/release/bin/tactile"))

# One setting alone.
TRADE = (
    "--tick-us 2000 --factor 0.2 --resize area --denoise mean --augment none --engine fast --precision fp32 "
    "--kind lenet --epochs 1 --trainings 1 --timed-ticks 600 "
    "--no-figures"
).split()


class Lab:
    def __init__(self, folder):
        self.folder = folder
        self.run("simulate", "--preset", "tiny", "--objects", "fan,usb-hub", "--runs", "3", "--seed", "1")
        self.run("label")
        self.run("windows")
        self.run("heatmaps", "--th", "40,20")
        self.run("train", "--th", "40", "--epochs", "1")
        (self.bundle,) = self.bundles()
        self.run("eval", "--model", self.bundle)
        self.run("trade", "--th", "40", *TRADE)
        self.recording = folder / "data/fan/02/events.aedat4"

    def run(self, *arguments):
        done = subprocess.run([TACTILE, *map(str, arguments), "--quiet"], cwd=self.folder, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return done.stdout

    def bundles(self):
        return [description.parent for description in (self.folder / "models").glob("*/model.json")]

    def error_of(self, *arguments):
        done = subprocess.run([TACTILE, *map(str, arguments)], cwd=self.folder, capture_output=True, text=True)
        assert done.returncode != 0
        return done.stderr


@pytest.fixture(scope="session")
def lab(tmp_path_factory):
    return Lab(tmp_path_factory.mktemp("lab"))

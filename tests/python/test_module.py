"""The module as a whole: its page, its size, its types."""

import csv
import pathlib
import re
import shlex
import subprocess
import sys

import pytest

import tactile

SOURCES = pathlib.Path(__file__).resolve().parents[2]


def run_the_code_of_the_page(bundle, *, with_pytorch):
    text = (SOURCES / "docs/python.md").read_text()
    blocks = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    names = {}
    for block in blocks:
        if with_pytorch or "import torch" not in block:
            exec(compile(block.replace("models/NAME", str(bundle)), "docs/python.md", "exec"), names)
    return names


def test_the_code_of_the_page_runs(lab, monkeypatch, capsys):
    monkeypatch.chdir(lab.folder)
    assert "trade" in run_the_code_of_the_page(lab.bundle, with_pytorch=False)
    assert "events brighter" in capsys.readouterr().out


def test_the_code_of_the_page_runs_with_pytorch(lab, monkeypatch):
    pytest.importorskip("torch")
    monkeypatch.chdir(lab.folder)
    assert 0 < run_the_code_of_the_page(lab.bundle, with_pytorch=True)["loss"].item() < 10


def ticks_in(file):
    """The rows of a table of ticks, by their time."""
    with open(file) as rows:
        return {row["t_us"]: row for row in csv.DictReader(rows)}


def test_the_network_of_the_page_is_judged_and_runs_live_with_pytorch(lab, monkeypatch):
    torch = pytest.importorskip("torch")
    monkeypatch.chdir(lab.folder)
    names = run_the_code_of_the_page(lab.bundle, with_pytorch=True)
    page = (SOURCES / "docs/python.md").read_text()
    (commands,) = re.findall(r"```\n(tactile eval --model nets/touch.pt\n.*?)```", page, re.DOTALL)
    for line in commands.splitlines():
        lab.run(*shlex.split(line)[1:])

    (file,) = (lab.folder / "nets/touch.pt.results").glob("eval-on-????????.json")
    result = tactile.read_evaluation(file)
    test, network = names["test"], names["network"].eval()
    assert sorted(result.everything["test_runs"]) == sorted({"/".join(test.runs[run]) for run in test.run})
    with torch.no_grad():
        found = network(torch.from_numpy(test.heatmaps()[:, None].astype("float32") / 255)).argmax(1).numpy()
    by_object = {}
    for predicted, label, run in zip(found, test.labels, test.run):
        by_object.setdefault(test.runs[run][0], []).append(predicted == label)
    accuracy = sum(sum(right) / len(right) for right in by_object.values()) / len(by_object)
    assert abs(result.accuracy.value - accuracy) < 0.01

    offline, live = ticks_in(lab.folder / "ticks/fan-02.csv"), ticks_in(lab.folder / "ticks/live.csv")
    assert len(live) > 0.95 * len(offline)
    for t_us, row in live.items():
        assert [row[f"p_{name}"] for name in tactile.CLASSES] == [offline[t_us][f"p_{name}"] for name in tactile.CLASSES]


def test_it_loads_neither_libtorch_nor_opencv():
    code = "import tactile; print(*{line.split()[-1] for line in open('/proc/self/maps') if '/' in line}, sep='\\n')"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert "_tactile" in loaded
    assert not re.search(r"libtorch|libopencv|libavcodec", loaded)


def test_everything_public_says_what_it_is():
    for name in tactile.__all__:
        thing = getattr(tactile, name)
        if callable(thing):
            assert thing.__doc__, name
    package = pathlib.Path(tactile.__file__).parent
    assert (package / "py.typed").exists() and "def take_events" in (package / "_tactile.pyi").read_text()


def test_its_version_is_that_of_the_program(lab):
    assert lab.run("--version").split()[1].startswith(tactile.__version__)

import json
import multiprocessing
import pickle

import h5py
import numpy as np
import pytest

import tactile


def test_samples_equal_what_h5py_reads(lab):
    dataset = tactile.Dataset(lab.folder / "data/dataset.h5")
    with h5py.File(lab.folder / "data/dataset.h5") as file:
        assert np.array_equal(dataset.heatmaps(), file["/heatmaps/th_040"][:])
        assert np.array_equal(dataset.labels, file["/samples/label"][:])
        assert np.array_equal(dataset.t_us, file["/samples/t_us"][:])
        assert dataset.manifest_hash == file.attrs["manifest_sha256"].decode()
        first, count = file["/runs/first_event"][1], file["/runs/events"][1]
        assert np.array_equal(dataset.events(1)["t"], file["/events/t_us"][first : first + count])
    heatmap, label = dataset[3]
    assert heatmap.shape == (1, 96, 128) and heatmap.dtype == np.float32 and label == dataset.labels[3]
    assert np.array_equal(heatmap[0], dataset.heatmaps([3])[0] / np.float32(255))
    assert dataset.simulated


def test_a_split_is_that_of_the_model_trained_by_the_program(lab):
    model = json.loads((lab.bundle / "model.json").read_text())
    for part in ("train", "test"):
        dataset = tactile.Dataset(lab.folder / "data/dataset.h5", split="single-run", part=part)
        assert sorted({"/".join(dataset.runs[run]) for run in dataset.run}) == sorted(model[f"{part}_runs"])
    unseen = tactile.Dataset(lab.folder / "data/dataset.h5", split="unseen", part="test", held_out=["fan"])
    assert {dataset.runs[run][0] for run in unseen.run} == {"fan"}


def test_a_split_without_such_a_run_or_object_is_refused(lab):
    file = lab.folder / "data/dataset.h5"
    with pytest.raises(tactile.Error, match="train_run '2': no object has such a run; expected one of 01, 02, 03"):
        tactile.Dataset(file, split="single-run", train_run="2")
    with pytest.raises(tactile.Error, match="held_out 'fan': expected a list of objects"):
        tactile.Dataset(file, split="unseen", held_out="fan")
    with pytest.raises(tactile.Error, match="history 40.4: expected whole milliseconds"):
        tactile.Dataset(file, history=40.4)
    with pytest.raises(IndexError, match="run 99 of 6"):
        tactile.Dataset(file).events(99)
    unseen = tactile.Dataset(file, split="unseen", part="test")  # of the paper's five there is one
    assert {unseen.runs[run][0] for run in unseen.run} == {"fan"}


def shape_of_sample(dataset, i):
    return dataset[i][0].shape, dataset.heatmaps([i]).sum()


@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_workers_of_a_loader_read_for_themselves(lab, method):
    dataset = tactile.Dataset(lab.folder / "data/dataset.h5")
    with multiprocessing.get_context(method).Pool(2) as workers:
        found = workers.starmap(shape_of_sample, [(dataset, i) for i in range(20)])
    assert found == [shape_of_sample(dataset, i) for i in range(20)]
    assert np.array_equal(pickle.loads(pickle.dumps(dataset)).heatmaps([5]), dataset.heatmaps([5]))


def test_pytorch_loads_it_with_workers(lab):
    torch = pytest.importorskip("torch")
    dataset = tactile.Dataset(lab.folder / "data/dataset.h5", split="single-run")
    loader = torch.utils.data.DataLoader(dataset, batch_size=8, num_workers=2)
    heatmaps, labels = zip(*loader)
    assert torch.cat(heatmaps).shape == (len(dataset), 1, 96, 128)
    assert np.array_equal(torch.cat(labels).numpy(), dataset.labels)
    assert np.array_equal(torch.cat(heatmaps)[11].numpy(), dataset[11][0])


def test_a_batch_has_what_single_samples_have(lab):
    dataset = tactile.Dataset(lab.folder / "data/dataset.h5", split="single-run")
    batch = dataset.__getitems__([4, 0, 4])
    for (heatmap, label), i in zip(batch, [4, 0, 4]):
        assert np.array_equal(heatmap, dataset[i][0]) and label == dataset[i][1]
    assert dataset[-1][1] == dataset.labels[-1]
    with pytest.raises(IndexError):
        dataset[len(dataset)]


def test_what_is_not_there_is_named(lab, tmp_path):
    with pytest.raises(tactile.Error, match="has no heatmaps th_030; expected one of th_020, th_040"):
        tactile.Dataset(lab.folder / "data/dataset.h5", history=30)
    with pytest.raises(tactile.Error, match="part 'validation': expected train or test"):
        tactile.Dataset(lab.folder / "data/dataset.h5", part="validation")
    with pytest.raises(tactile.Error, match="split"):
        tactile.Dataset(lab.folder / "data/dataset.h5", split="half")
    with pytest.raises(tactile.Error, match="held-out object 'teapot'"):
        tactile.Dataset(lab.folder / "data/dataset.h5", split="unseen", held_out=["teapot"])
    with pytest.raises(tactile.Error):
        tactile.Dataset(tmp_path / "dataset.h5")

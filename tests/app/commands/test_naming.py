"""One function names instances: `run --vocabulary`, `label` and `eval --names text` give the very same names."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from app.evaluation.prediction import read_prediction
from data_tools.synthetic.synthetic_room import SyntheticRoom
from data_tools.truth.open_truth import open_truth
from data_tools.writers.own_folder import write_folder
from tests.support.cli import QUICK, call


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """(recording, file with the truth's names, run that was named while it was mapped)."""
    place = tmp_path_factory.mktemp("naming")
    room, recording, vocabulary = SyntheticRoom(0, 12, 160, 120), place / "recording", place / "names.txt"
    write_folder(room, recording, truth=room.truth(0.05))
    names = sorted(set(open_truth(recording).class_names.values()), reverse=True)
    vocabulary.write_text("\n".join(names) + "\n")
    models = ("--segmenter", "oracle", "--embedder", "oracle", "--vocabulary", vocabulary)
    assert call("run", recording, "-o", place / "run", *models, *QUICK, "--no-timeline") == 0
    return recording, vocabulary, place / "run"


def given_names(run: Path) -> dict[int, str]:
    content = json.loads((run / "instances.json").read_text())
    return {entry["id"]: entry["class"] for entry in content["instances"] if entry["class"]}


def by_text(run: Path, recording: Path) -> dict[int, str]:
    truth = open_truth(recording)
    return dict(read_prediction(run, truth.class_names, len(truth.vertices), naming="text").class_names)


def give_a_neighbours_vector(run: Path) -> None:
    """Each instance gets a second, weak hypothesis that is exactly the vector of another one's name."""
    with np.load(run / "embeddings.npz") as stored:
        parts = dict(stored)
    ids, vectors = parts["ids"], parts["embeddings"]
    first = np.unique(ids, return_index=True)[1]
    strong, owners = vectors[first], ids[first]
    others = np.roll(strong, 1, axis=0)
    order = np.argsort(np.concatenate([owners, owners]), kind="stable")
    blurred = strong + 0.4 * np.roll(strong, 2, axis=0)
    blurred /= np.linalg.norm(blurred, axis=1, keepdims=True)
    parts["ids"] = np.concatenate([owners, owners])[order]
    parts["embeddings"] = np.concatenate([blurred, others])[order].astype(vectors.dtype)
    weights = np.concatenate([np.full(len(owners), 0.7), np.full(len(owners), 0.3)])[order]
    parts["weights"] = weights.astype(parts["weights"].dtype)
    np.savez_compressed(run / "embeddings.npz", **parts)


@pytest.mark.parametrize("spoil", [lambda run: None, give_a_neighbours_vector], ids=["as mapped", "with neighbours"])
def test_run_label_and_eval_by_text_give_the_same_names(made, tmp_path, spoil):
    recording, vocabulary, named = made
    run = Path(shutil.copytree(named, tmp_path / "run"))
    mapped = given_names(run)
    assert len(mapped) > 8
    spoil(run)
    assert call("label", run, "--vocabulary", vocabulary) == 0
    labelled = given_names(run)
    assert by_text(run, recording) == labelled
    assert labelled == mapped  # what a weak hypothesis says alone names nothing


def test_a_run_that_cannot_be_named_is_refused_before_it_starts(made, tmp_path, capsys):
    recording, vocabulary, _ = made
    models = ("--segmenter", "oracle", "--embedder", "appearance")
    assert call("run", recording, "-o", tmp_path / "run", *models, "--vocabulary", vocabulary) == 2
    assert "no text encoder" in capsys.readouterr().err
    assert call("run", recording, "-o", tmp_path / "run", "--vocabulary", "nonsense") == 2
    assert "is no vocabulary" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []

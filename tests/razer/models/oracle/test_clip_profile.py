"""The profile `clip`: exemplars with context and errors of thing, side and frame, as strong as is fixed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from data_tools.synthetic.objects.catalogue import PIECES
from razer.errors import BadInput
from razer.frame import Frame, Masks
from razer.models import NameTable, make_embedder, make_segmenter, unrelated_cosine
from razer.models.name_vectors.name_table import bare_name
from razer.models.oracle.embedder import OracleEmbedder
from razer.models.oracle.profiles.clip_profile import CONTEXT, ClipProfile
from razer.models.oracle.profiles.exemplar_table import SUBSTITUTES, ExemplarTable
from tests.support.profile_frames import looking, squares, true_frame

NAMES = ("chair", "table", "lamp", "cup", "tapestry", "mat (gym equipment)", "bed", "vase", "box", "plate")


def unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


@pytest.fixture(scope="module")
def table(tmp_path_factory):
    """Vectors in a cone, as CLIP's are: those of pictures have cosines of about 0.7 to each other."""
    rng = np.random.default_rng(0)
    common, other = unit(rng.standard_normal((2, 128)))
    images, texts = (unit(v + 0.65 * unit(rng.standard_normal((200, 128)))) for v in (common, other))
    names = np.array([*NAMES, *(f"thing {i}" for i in range(200 - len(NAMES)))])
    file = tmp_path_factory.mktemp("table") / "exemplars.npz"
    np.savez(file, names=names, synonyms=names, text=texts, image=images)
    return file


def wall_of_chairs(index: int, azimuth_deg: float = 0.0) -> Frame:
    ids = squares(3, 4, 30, 10)
    ids[ids == 0] = 13
    names = {i: NAMES[i % 4] for i in range(1, 13)} | {13: "wall"}
    return true_frame(ids, names, index, world_from_camera=looking(azimuth_deg))


def cosines(embedder: OracleEmbedder, frame: Frame, masks: Masks) -> np.ndarray:
    things = [np.bincount(frame.instance_ids[mask]).argmax() for mask in masks.masks]
    exemplars = np.stack([embedder.profile.exemplar(frame.instance_classes[int(i)]) for i in things])
    return (exemplars * embedder.embed(frame, masks)).sum(axis=1)


def test_the_mean_cosine_to_the_exemplar_is_as_fixed(table):
    embedder = make_embedder("oracle", {"profile": "clip", "table": str(table), "seed": 3})
    found = []
    for index in range(20):
        frame = wall_of_chairs(index, 35 * index)
        found.append(cosines(embedder, frame, Masks.from_ids(frame.instance_ids)))
    assert np.mean(found) == pytest.approx(0.62, abs=0.02)


def test_it_is_so_with_real_exemplars_and_the_masks_of_each_profile(real_data):
    table = str(real_data / "clip-vit-b32" / "lvis.npz")
    embedder = make_embedder("oracle", {"profile": "clip", "table": table})
    for profile in ("sam", "detector", "panoptic"):
        segmenter = make_segmenter("oracle", {"profile": profile})
        found = []
        for index in range(12):
            ids = squares(3, 4, 60, 12)
            ids[ids == 0] = 13
            names = {i: sorted(PIECES)[(7 * i + 13 * index) % len(PIECES)] for i in range(1, 13)} | {13: "wall"}
            parts = (np.mgrid[: ids.shape[0], : ids.shape[1]][0] // 20 % 3 + 1).astype(np.uint8)
            frame = true_frame(ids, names, index, parts=parts, world_from_camera=looking(40 * index))
            masks = segmenter.segment(frame)
            found += cosines(embedder, frame, masks).tolist()
        assert np.mean(found) == pytest.approx(0.62, abs=0.02), profile


def test_errors_are_those_of_the_thing_of_its_side_and_of_the_frame(table):
    profile = ClipProfile(table, 1)
    frames = {(turn, index): wall_of_chairs(index, turn) for turn in (0, 180) for index in (0, 1)}
    vectors = {key: profile.embed(frame, Masks.from_ids(frame.instance_ids))[:12] for key, frame in frames.items()}
    first = vectors[0, 0]
    same_side = (first * vectors[0, 1]).sum(axis=1).mean()
    other_side = (first * vectors[180, 1]).sum(axis=1).mean()
    other_thing = np.mean(
        [first[i] @ vectors[0, 1][j] for i in range(12) for j in range(12) if i != j and not (i - j) % 4]
    )
    other_class = np.mean([first[i] @ vectors[0, 1][j] for i in range(12) for j in range(12) if (i - j) % 4])
    assert same_side > other_side + 0.1
    assert other_side > other_thing + 0.1
    assert other_thing > other_class + 0.03
    # The error has 1 / 0.62^2 - 1 = 1.6 of the exemplar's squared length, a third of it for each of the three.
    assert same_side == pytest.approx(0.38 + 0.62 * 2 / 3, abs=0.06)
    assert other_class == pytest.approx(profile.unrelated_cosine, abs=0.03)


def test_errors_lie_where_exemplars_differ(table):
    with np.load(table) as archive:
        flat = {name: archive[name].copy() for name in archive.files}
    # One direction in which all exemplars are the same.
    flat["image"][:, 5] = 0.2 * np.linalg.norm(np.delete(flat["image"], 5, axis=1), axis=1)
    file = table.parent / "flat.npz"
    np.savez(file, **flat)
    frame = wall_of_chairs(0)
    vectors = ClipProfile(file, 2).embed(frame, Masks.from_ids(frame.instance_ids))
    # The same part of each exemplar and no error: that of the exemplar in the vector.
    expected = 0.62 * 0.2 / np.sqrt(1.04)
    assert np.abs(vectors[:, 5] / expected - 1).mean() < 0.12


def test_a_quarter_is_what_the_crop_shows_beside_the_mask(table):
    """Means over many seeds: errors cancel, and what is left is the blend."""
    ids = np.ones((60, 80), np.int32)
    ids[20:40, 30:50] = 2
    names = {1: "bed", 2: "lamp"}
    total = np.zeros(128)
    for seed in range(150):
        total += ClipProfile(table, seed).embed(true_frame(ids, names), Masks.from_ids(ids))[1]
    exemplars = ExemplarTable(table)
    lamp, bed = (exemplars.images[exemplars.row(name)] for name in ("lamp", "bed"))
    share = np.linalg.lstsq(np.stack([lamp, bed], axis=1), total, rcond=None)[0]
    assert share[1] / share.sum() == pytest.approx(CONTEXT, abs=0.08)
    alone = np.full_like(ids, 2)
    without = sum(
        ClipProfile(table, seed).embed(true_frame(alone, names), Masks.from_ids(alone))[0] for seed in range(50)
    )
    assert unit(without) @ lamp > 0.95, "a mask that fills its crop has no context"


def test_it_sees_the_thing_and_not_what_a_detector_calls_it(table):
    profile = ClipProfile(table, 4)
    frame = wall_of_chairs(3)
    masks = Masks.from_ids(frame.instance_ids)
    called = Masks(masks.masks, masks.scores, tuple("plate" for _ in range(len(masks))))
    assert np.array_equal(profile.embed(frame, masks), profile.embed(frame, called))
    order = np.array([5, 2, 9])
    assert np.array_equal(profile.embed(frame, masks.select(order)), profile.embed(frame, masks)[order])


def test_it_answers_names_of_the_table_and_those_with_a_substitute(table):
    embedder = make_embedder("oracle", {"profile": "clip", "table": str(table)})
    assert isinstance(embedder, NameTable)
    assert {"chair", "wall"} <= set(embedder.known_names)
    assert "door" not in embedder.known_names, "the table has no doorknob"
    wall, tapestry, floor, mat = embedder.embed_texts(["wall", "tapestry", "floor", "mat (gym equipment)"])
    assert np.array_equal(wall, tapestry)
    assert np.array_equal(floor, mat)
    with pytest.raises(BadInput, match="zebra"):
        embedder.embed_texts(["zebra"])
    assert 0.1 < unrelated_cosine(embedder) < 0.5


def test_every_class_of_the_worlds_has_a_row_of_its_own_in_lvis(real_data):
    table = ExemplarTable(real_data / "clip-vit-b32" / "lvis.npz")
    classes = sorted({*PIECES, "wall", "floor", "ceiling"})
    assert {bare_name(name) for name in classes} <= table._rows.keys()
    assert len({table.row(name) for name in classes}) == len(classes)
    assert SUBSTITUTES.items() == {name: table.names[table.row(name)] for name in SUBSTITUTES}.items()


def test_substitutes_are_listed_in_the_docs():
    docs = " ".join((Path(__file__).parents[4] / "docs" / "evaluation.md").read_text(encoding="utf-8").split())
    assert [f"{name} → {other}" for name, other in SUBSTITUTES.items() if f"{name} → {other}" not in docs] == []


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"profile": "clip"}, "needs option table"),
        ({"profile": "siglip"}, "no profile 'siglip'"),
        ({"table": "x.npz"}, "only for profile clip"),
        ({"profile": "clip", "table": "/nowhere.npz"}, "/nowhere.npz"),
    ],
)
def test_impossible_options_are_one_line(options, message):
    with pytest.raises(BadInput, match=message) as error:
        make_embedder("oracle", options)
    assert "\n" not in str(error.value)


def test_a_table_without_pictures_is_refused(tmp_path):
    file = tmp_path / "names.npz"
    np.savez(file, names=np.array(["a", "b"]), text=np.eye(2, 4))
    with pytest.raises(BadInput, match=r"names.npz has no vectors of pictures"):
        make_embedder("oracle", {"profile": "clip", "table": str(file)})

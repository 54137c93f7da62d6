"""Class names as vectors: from a table, from a text encoder, and for names that nothing is known of."""

from __future__ import annotations

import pickle
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from razer.errors import BadInput
from razer.frame import Frame, Intrinsics, Masks
from razer.models import TextEncoder, make_embedder, unrelated_cosine
from razer.models.name_vectors.embedder import NamesEmbedder
from razer.models.name_vectors.name_table import bare_name, median_cosine
from razer.plugins import FULL_TRUST

NAMES = ("chair", "dining table", "cell phone", "cup")
SYNONYMS = ("chair|seat", "dining table", "cell phone|mobile_phone", "cup|seat")
TEXT = np.random.default_rng(0).normal(1, 1, (4, 64)).astype(np.float16)
FRAME = Frame(0, 0.0, np.zeros((4, 5, 3), np.uint8), np.ones((4, 5), np.float32), Intrinsics(5, 4, 5, 5, 2, 2))


class Encoder:
    """A text encoder that counts letters, and sees a large constant in all texts."""

    def __init__(self, constant: float = 3.0) -> None:
        self.constant, self.asked = constant, []

    def embed(self, frame: Frame, masks: Masks) -> np.ndarray:
        return np.zeros((len(masks), 4), np.float32)

    def embed_texts(self, texts: Sequence[str]) -> np.ndarray:
        self.asked += texts
        counts = [[text.count(letter) for letter in "abcdefghijklmnopqrstuvwxyz"] + [self.constant] for text in texts]
        return unit(np.array(counts, np.float32))


def unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


@pytest.fixture
def table(tmp_path: Path) -> Path:
    np.savez(tmp_path / "table.npz", names=np.array(NAMES), synonyms=np.array(SYNONYMS), text=TEXT)
    return tmp_path / "table.npz"


def masks(*names: str) -> Masks:
    return Masks(np.ones((len(names), 4, 5), bool), np.ones(len(names), np.float32), names)


def test_masks_get_the_vector_of_their_name(table: Path) -> None:
    embedder = make_embedder("names", {"table": str(table)})
    vectors = embedder.embed(FRAME, masks("cup", "chair", "cup", "Dining_Table"))
    assert vectors.dtype == np.float32
    np.testing.assert_allclose(vectors, unit(TEXT.astype(np.float64))[[3, 0, 3, 1]], atol=1e-6)
    assert embedder.embed(FRAME, Masks.none(4, 5)).shape == (0, 64)
    assert isinstance(embedder, TextEncoder)
    assert embedder.known_names == NAMES


@pytest.mark.parametrize(
    ("text", "row"),
    [
        ("chair", 0),
        ("A  Chair.", 0),
        ("the dining_table", 1),
        ("a photo of a mobile phone.", 2),
        ("an image of cup", 3),
        ("seat", 3),  # of several names with a synonym the last
    ],
)
def test_a_text_is_found_by_name_or_synonym(table: Path, text: str, row: int) -> None:
    np.testing.assert_array_equal(
        NamesEmbedder(table).embed_texts([text]), NamesEmbedder(table).embed_texts([NAMES[row]])
    )


def test_a_name_goes_before_a_synonym_of_another(tmp_path: Path) -> None:
    np.savez(tmp_path / "t.npz", names=["sofa", "couch"], synonyms=["sofa|couch", "couch|sofa"], text=np.eye(2))
    np.testing.assert_array_equal(NamesEmbedder(tmp_path / "t.npz").embed_texts(["couch", "sofa"]), [[0, 1], [1, 0]])


def test_plain_names() -> None:
    assert bare_name("A photo of the Theatre_Chair.") == "theatre chair"
    assert bare_name("anchor") == "anchor"
    assert bare_name("a") == "a"


def test_an_unknown_word_is_refused_with_the_nearest(table: Path) -> None:
    with pytest.raises(BadInput, match=r"table\.npz has no 'chairs': the nearest names it knows are chair") as refused:
        NamesEmbedder(table).embed_texts(["cup", "chairs"])
    assert "\n" not in str(refused.value)
    with pytest.raises(BadInput, match="has no 'zorb'"):
        NamesEmbedder(table).embed_texts(["zorb"])


def test_names_that_the_table_lacks_are_alike_to_themselves_and_to_no_name(table: Path) -> None:
    embedder = NamesEmbedder(table)
    vectors = embedder.embed(FRAME, masks("fire pit", "", "fire_pit", "lawn"))
    np.testing.assert_allclose(np.linalg.norm(vectors, axis=1), 1, atol=1e-6)
    np.testing.assert_array_equal(vectors[0], vectors[2])
    np.testing.assert_array_equal(vectors, NamesEmbedder(table).embed(FRAME, masks("fire pit", "", "fire_pit", "lawn")))
    assert (vectors[[0, 0, 1]] * vectors[[1, 3, 3]]).sum(axis=1).max() < 0.9
    assert np.abs(vectors @ embedder.embed_texts(NAMES).T).max() < 1e-6


def test_masks_of_a_model_that_names_nothing_are_refused(table: Path) -> None:
    nameless = Masks(np.ones((1, 4, 5), bool), np.ones(1, np.float32))
    with pytest.raises(BadInput, match="needs masks with class names"):
        NamesEmbedder(table).embed(FRAME, nameless)


def test_an_encoder_takes_any_name_in_captions(monkeypatch: pytest.MonkeyPatch) -> None:
    embedder = make_embedder(
        "names", {"embedder": f"{__name__}:Encoder", "embedder_options": {"constant": 1.0}}, FULL_TRUST
    )
    vectors = embedder.embed(FRAME, masks("zebra", "chair", "zebra", ""))
    np.testing.assert_allclose(np.linalg.norm(vectors, axis=1), 1, atol=1e-6)
    np.testing.assert_array_equal(vectors[0], vectors[2])
    np.testing.assert_array_equal(vectors[[0, 3]], embedder.embed_texts(["a zebra", "thing"]))
    asked = embedder._source._encoder.asked
    assert all(len(text.split()) > 2 for text in asked)
    assert len(asked) == 5 * len({text.split("zebra")[0] for text in asked if "zebra" in text})
    assert embedder.known_names == ()


def test_the_cosine_of_unrelated_names_is_their_median(table: Path) -> None:
    vectors = unit(TEXT.astype(np.float64))
    cosines = [vectors[i] @ vectors[j] for i in range(4) for j in range(i)]
    assert unrelated_cosine(NamesEmbedder(table)) == pytest.approx(np.median(cosines), abs=1e-6)
    assert median_cosine(unit(np.array([[1, 0], [1, 0], [1, 1]], np.float32))) == pytest.approx(np.sqrt(0.5))
    assert median_cosine(np.ones((3, 1), np.float32)) == 0
    near, far = (NamesEmbedder(embedder=Encoder(c)) for c in (10, 1))
    assert unrelated_cosine(near) > unrelated_cosine(far) > 0
    assert unrelated_cosine(make_embedder("appearance", {})) == 0


def test_it_travels_to_another_process(table: Path) -> None:
    embedder = NamesEmbedder(table)
    embedder.embed(FRAME, masks("cup", "zorb"))
    other = pickle.loads(pickle.dumps(embedder))
    np.testing.assert_array_equal(other.embed_texts(["cup"]), embedder.embed_texts(["cup"]))


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({}, "either option table"),
        ({"table": "t.npz", "embedder": "oracle"}, "either option table"),
        ({"table": "nowhere.npz"}, r"nowhere\.npz"),
        ({"embedder": "appearance"}, "'appearance' has no text encoder"),
        ({"embedder": "nobody"}, "unknown embedder 'nobody'"),
        ({"tables": "t.npz"}, "tables"),
    ],
)
def test_impossible_options_are_refused(options: dict, said: str) -> None:
    with pytest.raises(BadInput, match=said):
        make_embedder("names", options)


@pytest.mark.parametrize(
    "arrays",
    [
        {"names": np.array(NAMES)},
        {"names": np.array(NAMES), "text": TEXT[:3]},
        {"names": np.array(NAMES), "text": TEXT[0]},
        {"names": np.array(NAMES), "text": TEXT * np.array([[0], [1], [1], [1]])},
        {"names": np.array(NAMES), "text": np.full((4, 3), np.nan)},
        {"names": np.array(NAMES), "text": np.array([["x"]] * 4)},
        {"names": np.array(NAMES), "text": TEXT, "synonyms": np.array(SYNONYMS[:2])},
        {"names": np.array([]), "text": np.zeros((0, 4))},
        {"names": np.array([None] * 4), "text": TEXT},
    ],
)
def test_a_table_that_is_none_is_named(tmp_path: Path, arrays: dict[str, np.ndarray]) -> None:
    np.savez(tmp_path / "bad.npz", **arrays)
    with pytest.raises(BadInput, match=r"bad\.npz"):
        NamesEmbedder(tmp_path / "bad.npz")


@pytest.mark.parametrize("content", ["empty", "text", "one array", "cut short"])
def test_a_damaged_table_is_named(tmp_path: Path, table: Path, content: str) -> None:
    bad = tmp_path / "bad.npz"
    bad.write_bytes({"empty": b"", "text": b"chair", "cut short": table.read_bytes()[:200]}.get(content, b""))
    if content == "one array":
        with bad.open("wb") as file:
            np.save(file, TEXT)
    with pytest.raises(BadInput, match=r"bad\.npz"):
        NamesEmbedder(bad)


@pytest.mark.parametrize("name", ["coco", "lvis", "scannet200"])
def test_real_tables_find_their_own_names_and_no_stranger(real_data: Path, name: str) -> None:
    file = real_data / "clip-vit-b32" / f"{name}.npz"
    if not file.is_file():
        pytest.skip(f"no {file}: the real text vectors are not here")
    embedder = NamesEmbedder(file)
    vectors = embedder.embed_texts(embedder.known_names)
    assert ((vectors @ vectors.T).argmax(axis=1) == np.arange(len(vectors))).mean() > 0.98  # some names are doubles
    assert 0.7 < unrelated_cosine(embedder) < 0.85
    stranger = embedder.embed(FRAME, masks("zorb"))[0]
    assert np.abs(vectors @ stranger).max() < 0.02


def test_tables_of_one_space_are_joined(table: Path, tmp_path: Path) -> None:
    more = np.random.default_rng(1).normal(1, 1, (3, 64))
    other = tmp_path / "other.npz"
    names, synonyms = np.array(["wall", "Chair", "mug"]), np.array(["wall|seat", "Chair|throne", "mug|cup"])
    np.savez(other, names=names, synonyms=synonyms, text=more)
    for joined in (f"{table},{other}", [table, str(other)]):
        embedder = NamesEmbedder(joined)
        assert embedder.known_names == (*NAMES, "wall", "mug")
        vectors = embedder.embed_texts(["chair", "wall", "mug", "cup", "seat", "throne"])
        first = unit(TEXT.astype(np.float64))
        expected = [
            first[0],
            *unit(more)[[0, 2]],
            first[3],
            first[3],
            first[0],
        ]  # a synonym of the first table as before
        np.testing.assert_allclose(vectors, expected, atol=1e-6)
    assert NamesEmbedder(f"{other},{table}").known_names == (
        "wall",
        "Chair",
        "mug",
        "dining table",
        "cell phone",
        "cup",
    )
    with pytest.raises(BadInput, match=r"table\.npz and .*other\.npz has no 'sofa'"):
        NamesEmbedder([table, other]).embed_texts(["sofa"])


def test_tables_of_different_spaces_are_refused(table: Path, tmp_path: Path) -> None:
    np.savez(tmp_path / "other.npz", names=np.array(["wall"]), text=np.ones((1, 8)))
    with pytest.raises(BadInput, match="vectors of 8 and 64 numbers: tables must be of one space"):
        NamesEmbedder([table, tmp_path / "other.npz"])
    with pytest.raises(BadInput, match=r"no file .*missing\.npz"):
        NamesEmbedder(f"{table},missing.npz")


def test_a_name_with_a_comma_in_its_path_is_one_table(table: Path, tmp_path: Path) -> None:
    table.rename(tmp_path / "a,b.npz")
    assert NamesEmbedder(str(tmp_path / "a,b.npz")).known_names == NAMES

"""The names that queries are set against are embedded once for each encoder."""

from __future__ import annotations

import numpy as np
import pytest

from app.query.negative_prompt_cache import negative_prompts_of
from razer.errors import BadInput
from razer.models.appearance import AppearanceEmbedder
from razer.models.oracle.embedder import OracleEmbedder
from razer.plugins import EmbedderSettings
from razer.query.text_queries import TEMPLATES, TextQueryEncoder
from tests.support.named_vectors import unit_rows


class Encoder:
    """A text encoder that counts what it is asked."""

    def __init__(self):
        self.n_asked = 0

    def embed_texts(self, texts):
        self.n_asked += len(texts)
        return unit_rows([np.bincount(np.frombuffer(t.encode(), np.uint8), minlength=256) for t in texts])


@pytest.fixture
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    return tmp_path / "razer"


def embedded_texts(**options):
    """What a new encoder with these options was asked for, and the vectors."""
    encoder = Encoder()
    contrast = negative_prompts_of(TextQueryEncoder(encoder), EmbedderSettings(name="some:Encoder", options=options))
    assert len(contrast.vectors) == len(contrast.names)
    return encoder.n_asked, contrast.vectors


def test_names_are_embedded_once(cache):
    first, vectors = embedded_texts()
    second, kept = embedded_texts()
    assert (first, second) == (len(TEMPLATES) * len(vectors), 0)
    np.testing.assert_array_equal(kept, vectors)
    assert len(list(cache.iterdir())) == 1


def test_another_encoder_or_other_weights_are_embedded_anew(cache, tmp_path):
    weights = tmp_path / "weights.onnx"
    weights.write_bytes(b"one")
    assert embedded_texts()[0] > 0
    assert embedded_texts(weights=str(weights))[0] > 0
    assert embedded_texts(weights=str(weights))[0] == 0
    weights.write_bytes(b"two or more")
    assert embedded_texts(weights=str(weights))[0] > 0


def test_a_file_changed_inside_a_folder_is_noticed(cache, tmp_path):
    folder = tmp_path / "model"
    folder.mkdir()
    (folder / "model.safetensors").write_bytes(b"one")
    inner = {"embedder": "some:Encoder", "embedder_options": {"weights": str(folder)}}
    assert embedded_texts(**inner)[0] > 0
    assert embedded_texts(**inner)[0] == 0
    (folder / "model.safetensors").write_bytes(b"two or more")
    assert embedded_texts(**inner)[0] > 0


class NamesOverEncoder(Encoder):
    """Names of any kind: a table's protocol, without a table."""

    known_names = ()
    takes_any_name = True


def test_names_over_an_encoder_are_kept_as_the_encoders_own(cache):
    encoders = [NamesOverEncoder(), NamesOverEncoder()]
    for encoder in encoders:
        words = TextQueryEncoder(encoder)
        negative_prompts_of(words, EmbedderSettings(name="names", options={"embedder": "some:Encoder"}))
        assert words.knows("anything at all")
    assert encoders[0].n_asked > 0
    assert encoders[1].n_asked == 0


@pytest.mark.parametrize("content", [b"", b"no archive"])
def test_a_damaged_file_is_made_anew(cache, content):
    embedded_texts()
    (file,) = cache.iterdir()
    file.write_bytes(content)
    assert embedded_texts()[0] > 0
    assert embedded_texts()[0] == 0


def test_a_cache_that_cannot_be_written_is_done_without(cache):
    cache.write_text("a file where the folder should be")
    assert embedded_texts()[0] > 0
    assert embedded_texts()[0] > 0


def test_tables_are_not_kept_and_those_without_words_refuse(cache):
    negative_prompts_of(TextQueryEncoder(OracleEmbedder()), EmbedderSettings(name="oracle"))
    assert not cache.exists()
    with pytest.raises(BadInput, match="no text encoder"):
        negative_prompts_of(TextQueryEncoder(AppearanceEmbedder()), EmbedderSettings())

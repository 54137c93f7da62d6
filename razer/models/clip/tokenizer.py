"""Tokenisation for an exported text tower, by the tokenizer.json beside it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from razer.arrays import Int64Array
from razer.errors import BadInput, one_line
from razer.files import MALFORMED, read_text
from razer.models.hub.sidecar_files import find_sidecar, read_json

_CLIP_LENGTH = 77
_LONGEST = 1024  # tokenizers that know no limit name an astronomic one


class ClipTokens:
    """Rows of one length, padded as the model was trained; length None = as in the files beside the tower.

    Raises BadInput for a missing or unreadable tokenizer.
    """

    def __init__(self, text_tower: Path, length: int | None) -> None:
        try:
            from tokenizers import Tokenizer
        except ImportError:
            raise BadInput(
                "texts for an ONNX model need the package tokenizers: pip install 'razer[transformers]'"
            ) from None
        file = find_sidecar(text_tower, "tokenizer.json")
        if file is None:
            raise BadInput(f"{text_tower} has no tokenizer.json beside it: texts cannot be read without one")
        try:
            self._tokenizer = Tokenizer.from_str(read_text(file))
        except BadInput:
            raise
        except Exception as error:  # the library raises bare Exception
            raise BadInput(f"{file} is no tokenizer: {one_line(error)}") from error
        try:
            self._shape(text_tower, length or _length(text_tower))
        except BadInput:
            raise
        except MALFORMED as error:
            told = f"{file} and the files beside it do not say how texts are cut and padded"
            raise BadInput(f"{told} ({one_line(error)}): correct them") from None

    def _shape(self, text_tower: Path, length: int) -> None:
        """Have all rows of one length."""
        self._tokenizer.enable_truncation(length)
        padding = self._tokenizer.padding or {}
        pad = padding.get("pad_token") or _pad_token(text_tower)
        number = padding.get("pad_id", self._tokenizer.token_to_id(pad) or 0)
        self._tokenizer.enable_padding(pad_id=number, pad_token=pad, length=length)

    def __call__(self, texts: Sequence[str]) -> tuple[Int64Array, Int64Array]:
        """Token ids (N, length), and the attention mask, 0 for padding. Texts are lower-cased, as these models were
        trained."""
        encodings = self._tokenizer.encode_batch([text.lower() for text in texts])
        ids, attention = ([e.ids for e in encodings], [e.attention_mask for e in encodings])
        return np.array(ids, np.int64), np.array(attention, np.int64)


def _length(text_tower: Path) -> int:
    config, tokenizer = (_beside(text_tower, name) for name in ("config.json", "tokenizer_config.json"))
    lengths = (config.get("text_config", {}).get("max_position_embeddings"), tokenizer.get("model_max_length"))
    return next((int(length) for length in lengths if length and length <= _LONGEST), _CLIP_LENGTH)


def _pad_token(text_tower: Path) -> str:
    token = _beside(text_tower, "tokenizer_config.json").get("pad_token", "<|endoftext|>")
    return token["content"] if isinstance(token, dict) else token


def _beside(text_tower: Path, name: str) -> dict:
    file = find_sidecar(text_tower, name)
    return read_json(file) if file else {}

"""What a folder's open_clip_config.json may not ask for."""

from __future__ import annotations

import json

import pytest

from razer.errors import BadInput
from razer.models.clip.open_clip_config import check_open_clip_config


def written(folder, text_cfg):
    (folder / "open_clip_config.json").write_text(json.dumps({"model_cfg": {"text_cfg": text_cfg}}))
    return folder


@pytest.mark.parametrize("text_cfg", [{}, {"context_length": 77}, {"tokenizer_kwargs": {"clean": "canonicalize"}}])
def test_what_published_models_have_is_accepted(tmp_path, text_cfg):
    check_open_clip_config(written(tmp_path, text_cfg))


@pytest.mark.parametrize(
    ("text_cfg", "words"),
    [
        ({"tokenizer_kwargs": {"trust_remote_code": True}}, "trust_remote_code"),
        ({"tokenizer_kwargs": {"clean": "lower", "auto_map": {}}}, "auto_map"),
        ({"tokenizer_kwargs": ["trust_remote_code"]}, "trust_remote_code"),
        ({"hf_model_name": "someone/model"}, "someone/model"),
        (["text"], "text_cfg"),
    ],
)
def test_what_would_run_code_or_reach_the_network_is_refused(tmp_path, text_cfg, words):
    with pytest.raises(BadInput, match=words):
        check_open_clip_config(written(tmp_path, text_cfg))


@pytest.mark.parametrize("content", ["", "{", "[]", "{}", "[" * 100_000])
def test_what_is_no_configuration_is_refused(tmp_path, content):
    (tmp_path / "open_clip_config.json").write_text(content)
    with pytest.raises(BadInput, match="no configuration"):
        check_open_clip_config(tmp_path)

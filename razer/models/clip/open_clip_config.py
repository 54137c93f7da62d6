"""What open_clip_config.json of a folder may ask open_clip to do: nothing that runs code or reaches the network."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from razer.errors import BadInput, one_line
from razer.files import MALFORMED, read_json

CONFIG = "open_clip_config.json"
# Of what open_clip hands on to a tokenizer; others reach transformers, trust_remote_code among them.
TOKENIZER_OPTIONS = {"clean", "language", "reduction_mask", "strip_sep_token"}


def check_open_clip_config(folder: Path) -> None:
    """Raise BadInput if the configuration in a folder names a text encoder of another library, which is fetched and may
    bring code along, or options of a tokenizer that open_clip itself does not have."""
    text = _text_config(folder / CONFIG)
    if foreign := text.get("hf_model_name"):
        raise BadInput(f"{folder / CONFIG} names the text encoder {foreign} of another library: export it to ONNX")
    options = text.get("tokenizer_kwargs") or {}
    unknown = set(options) - TOKENIZER_OPTIONS if isinstance(options, dict) else {str(options)}
    if unknown:
        raise BadInput(f"{folder / CONFIG} sets {', '.join(sorted(unknown))} of its tokenizer: take that out")


def _text_config(path: Path) -> dict[str, Any]:
    try:
        text = read_json(path)["model_cfg"]["text_cfg"]
    except MALFORMED as error:
        raise BadInput(f"{path} is no configuration of open_clip: {one_line(error)}") from error
    if not isinstance(text, dict):
        raise BadInput(f"{path} is no configuration of open_clip: text_cfg is {text}")
    return text

"""Preprocessing and activation of open_clip's published weights, which a file of weights does not contain."""

from __future__ import annotations

from difflib import get_close_matches
from typing import Any

import open_clip

from razer.errors import BadInput


def model_arguments(architecture: str) -> dict[str, Any]:
    """Arguments of create_model for weights of "MODEL" or "MODEL:TAG", by open_clip's names.

    The tag is needed where published weights of one architecture need different colour normalisation or activations:
    with the wrong ones a model computes nonsense without an error. Raises BadInput.
    """
    model, _, tag = architecture.partition(":")
    if model not in open_clip.list_models():
        nearest = get_close_matches(model, open_clip.list_models(), cutoff=0.3) or open_clip.list_models()[:5]
        raise BadInput(f"open_clip knows no architecture '{model}': it has {', '.join(nearest)}")
    tags = open_clip.list_pretrained_tags_by_model(model)
    if tag and tag not in tags:
        raise BadInput(f"open_clip knows no weights '{tag}' of {model}: it has {', '.join(tags) or 'none'}")
    trainings = [_training(model, each) for each in ([tag] if tag else tags)]
    if any(training != trainings[0] for training in trainings):
        raise BadInput(
            f"weights of {model} were trained in different ways: set embedder option architecture to {model}:TAG, "
            f"with one of {', '.join(tags)}"
        )
    return {"model_name": model, **(trainings[0] if trainings else {})}


def _training(model: str, tag: str) -> dict[str, Any]:
    published = open_clip.get_pretrained_cfg(model, tag)
    colours = {name: published[name] for name in ("mean", "std")}
    return {"force_preprocess_cfg": colours, "force_quick_gelu": bool(published.get("quick_gelu"))}

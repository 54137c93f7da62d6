"""Text prompts of a segmenter: a list, a text with commas, or a vocabulary."""

from __future__ import annotations

from collections.abc import Sequence

from razer.errors import BadInput
from razer.vocabulary import vocabulary


def prompt_phrases(words: str | Sequence[str]) -> tuple[str, ...]:
    """The phrases of a list, of a text with commas, or of a vocabulary by name or file (see `vocabulary`), without
    repetitions; raises BadInput if there are none."""
    if isinstance(words, str):
        words = words.split(",") if "," in words else vocabulary(words).names
    if not all(isinstance(word, str) for word in words):
        raise BadInput(f"option words is a list of names, not {list(words)}")
    cleaned = tuple(dict.fromkeys(word.strip() for word in words if word.strip()))
    if not cleaned:
        raise BadInput("option words is empty: give the names of things to look for, or a vocabulary such as scannet20")
    return cleaned

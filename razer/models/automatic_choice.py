"""Automatic choice of segmenter and embedder, by which models are in the cache."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any, TypeVar

from razer.errors import BadInput
from razer.models.hub.catalogue import CatalogueEntry, entry
from razer.models.hub.model_sets import STARTER
from razer.plugins import AUTO, EmbedderSettings, SegmenterSettings

# What is taken first stands first. SAM is not among them: it says neither what is one thing nor what it is called.
THINGS = ("rf-detr-seg-small", "yolo11m-seg", "yolo11n-seg", "yolov8n-seg")
STUFF = ("upernet-convnext-tiny", "mask2former-coco", "oneformer-coco")
WORDS = ("clip-vit-b32", "siglip2-base")
_WITHOUT_WEIGHTS = {"geometric": "shapes in depth and colour", "appearance": "looks, no words"}
_GIVES = {"things": "names of things", "surfaces": "a class for every pixel", "words": "words to ask by"}

AnySettings = TypeVar("AnySettings", SegmenterSettings, EmbedderSettings)


@dataclass(frozen=True)
class AutomaticChoice:
    """What "auto" stands for here.

    Args:
        segmenter: settings with the choice made; those that name a segmenter stay as they are.
        embedder: likewise.
        note: in one line what was chosen, and what would be better and how to get it; '' where nothing was to choose.
    """

    segmenter: SegmenterSettings
    embedder: EmbedderSettings
    note: str


@dataclass(frozen=True)
class _Found:
    """The entry of a kind of model that is used; None, and what is in the cache but lacks its package, otherwise."""

    entry: CatalogueEntry | None
    unusable: CatalogueEntry | None


def automatic_choice(segmenter: SegmenterSettings, embedder: EmbedderSettings) -> AutomaticChoice:
    """The choice for settings of which either may say "auto": detectors for things over a model that names surfaces,
    and a model of words, as far as they are in the Hugging Face cache; else the ways that need no weights.

    Raises BadInput for options without the name of what they are for.
    """
    kinds: dict[str, _Found] = {}
    chosen: list[str] = []
    if segmenter.name == AUTO:
        kinds |= {"things": _first(THINGS), "surfaces": _first(STUFF)}
        name, options = _segmenter(kinds["things"].entry, kinds["surfaces"].entry)
        segmenter = _resolved(segmenter, name, options)
        chosen.append(_said("segmenter", name, kinds["things"].entry, kinds["surfaces"].entry))
    if embedder.name == AUTO:
        words = kinds["words"] = _first(WORDS)
        name = words.entry.part if words.entry else "appearance"
        embedder = _resolved(embedder, name, {"weights": words.entry.name} if words.entry else {})
        chosen.append(_said("embedder", name, words.entry))
    return AutomaticChoice(segmenter, embedder, _note(chosen, kinds))


def _first(names: Sequence[str]) -> _Found:
    cached = [each for each in map(entry, names) if _is_cached(each)]
    usable = [each for each in cached if not each.needs or find_spec(each.needs) is not None]
    return _Found(next(iter(usable), None), next(iter(cached), None) if not usable else None)


def _is_cached(model: CatalogueEntry) -> bool:
    from razer.models.hub.cache import cached_model  # late: the hub's library takes a moment

    try:
        return cached_model(model) is not None
    except (OSError, ValueError):  # who asked for no model is not stopped by a cache that cannot be read
        return False


def _segmenter(things: CatalogueEntry | None, stuff: CatalogueEntry | None) -> tuple[str, dict[str, Any]]:
    """Name and options. What no model finds is left to geometry, but where a panoptic model finds everything."""
    if stuff is not None and stuff.part == "panoptic" and things is None:
        return "panoptic", {"weights": stuff.name}
    models = [each for each in (things, stuff) if each is not None]
    names = [each.part for each in models]
    if things is None or stuff is None:
        names.insert(0 if things is None else 1, "geometric")
    return "+".join(names), {each.part: {"weights": each.name} for each in models}


def _resolved(settings: AnySettings, name: str, options: dict[str, Any]) -> AnySettings:
    if settings.options:
        section = "segmenter" if isinstance(settings, SegmenterSettings) else "embedder"
        first = next(iter(settings.options))
        raise BadInput(f"{section}.options.{first} is an option of one {section}: name it, as in --{section} {name}")
    return settings.model_copy(update={"name": name, "options": options, "asked": AUTO})


def _said(section: str, name: str, *entries: CatalogueEntry | None) -> str:
    """The option that stands for the choice, and its weights or what it goes by."""
    names = [each.name for each in entries if each is not None] or [_WITHOUT_WEIGHTS[name]]
    return f"--{section} {name} ({', '.join(names)})"


def _note(chosen: Sequence[str], kinds: dict[str, _Found]) -> str:
    if not chosen:
        return ""
    missing = [kind for kind, found in kinds.items() if found.entry is None]
    if not missing:
        return f"auto: {' '.join(chosen)}"
    lacking = ", ".join(_GIVES[kind] for kind in missing)
    return f"auto: {' '.join(chosen)}; it lacks {lacking}; better: {_how(kinds)}"


def _how(kinds: dict[str, _Found]) -> str:
    """Commands that bring what is missing."""
    members = {"things": THINGS[0], "surfaces": STUFF[0], "words": WORDS[0]}
    to_pull = [entry(members[kind]) for kind, found in kinds.items() if found.entry is None and found.unusable is None]
    unusable = [found.unusable for found in kinds.values() if found.unusable is not None]
    lacks_package = any(each.needs and find_spec(each.needs) is None for each in (*to_pull, *unusable))
    steps = ["pip install 'razer[transformers]'"] if lacks_package else []
    if to_pull:
        megabytes = sum(each.megabytes for each in to_pull)
        steps.append(f"razer models pull {STARTER.name} ({megabytes} MB)")
    return " and ".join(steps)

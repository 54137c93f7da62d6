"""Which 2D models a mapper uses: those its settings name, or others that it is given."""

from __future__ import annotations

from collections.abc import Mapping

from razer.config import MapperConfig
from razer.models import EMBEDDERS, SEGMENTERS, Embedder, Segmenter, embedder_of, make_segmenter
from razer.models.automatic_choice import automatic_choice
from razer.plugins import EmbedderSettings, SegmenterSettings


def choose_models(
    config: MapperConfig, segmenter: Segmenter | str | None, embedder: Embedder | str | None
) -> tuple[MapperConfig, Segmenter, Embedder]:
    """The two models, objects or made by name, and the settings that say which they are; None = as the settings say.
    "auto" becomes what it stands for here. Raises BadInput for a name that there is not, or that is not trusted."""
    choice = automatic_choice(
        _segmenter_settings(config.segmenter, segmenter), _embedder_settings(config.embedder, embedder)
    )
    config = config.model_copy(update={"segmenter": choice.segmenter, "embedder": choice.embedder})
    if segmenter is None or isinstance(segmenter, str):
        segmenter = make_segmenter(config.segmenter.name, config.segmenter.options, config.segmenter.trust)
    if embedder is None or isinstance(embedder, str):
        embedder = embedder_of(config.embedder)
    return config, segmenter, embedder


def _segmenter_settings(settings: SegmenterSettings, chosen: Segmenter | str | None) -> SegmenterSettings:
    if chosen is None:
        return settings
    return SegmenterSettings(name=_name_of(chosen, SEGMENTERS)).with_trust(settings.trust)


def _embedder_settings(settings: EmbedderSettings, chosen: Embedder | str | None) -> EmbedderSettings:
    if chosen is None:
        return settings
    return EmbedderSettings(name=_name_of(chosen, EMBEDDERS)).with_trust(settings.trust)


def _name_of(chosen: object, table: Mapping[str, str]) -> str:
    """The name under which a part can be asked for: of the table, or its module:Class."""
    if isinstance(chosen, str):
        return chosen
    path = f"{type(chosen).__module__}:{type(chosen).__qualname__}"
    return next((name for name, target in table.items() if target == path), path)

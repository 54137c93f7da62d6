"""Options of the oracle models for each kind of simulated errors that the command line names."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal

OracleErrors = Literal["none", "full", "sam", "detector", "detector-hard", "panoptic", "panoptic-hard"]
OracleOptions = tuple[dict[str, Any], dict[str, Any]]  # of the segmenter and of the embedder


def oracle_options(errors: OracleErrors, table: Path | None = None) -> OracleOptions:
    """The options of the segmenter and of the embedder.

    Args:
        errors: "none" or "full" noise of both; or a profile of the masks. What names things (detector, panoptic) comes
            with vectors as CLIP's, `sam` with those of "full".
        table: of names, text and image vectors; then vectors are as CLIP's in any case.
    """
    noise = errors if errors in ("none", "full") else None
    segmenter = {"noise": noise} if noise else {"profile": errors}
    if table is not None:
        return segmenter, {"profile": "clip", "table": str(table)}
    if noise or errors == "sam":
        return segmenter, {"noise": noise or "full"}
    return segmenter, {"profile": "clip"}


def oracle_flags(errors: OracleErrors | None) -> dict[str, Any]:
    """The settings of a run that map by the truth with such errors, by dotted name; none for None."""
    if errors is None:
        return {}
    segmenter, embedder = oracle_options(errors)
    names = {"segmenter.name": "oracle", "embedder.name": "oracle"}
    options = {f"segmenter.options.{key}": value for key, value in segmenter.items()}
    return names | options | {f"embedder.options.{key}": value for key, value in embedder.items()}

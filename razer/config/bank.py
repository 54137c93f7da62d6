"""Settings of the embedding bank."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from razer.settings import Settings


class BankSettings(Settings):
    """The embedding bank E_i (RAZER section IV-E)."""

    hypotheses: int = Field(3, ge=1, le=8, description="Most hypotheses a track keeps. 1 = running mean.")
    similarity: float = Field(
        0.75,
        gt=0,
        lt=1,
        description="sigma_sim: above this similarity an observation joins a hypothesis; 0 = as alike as unlike things "
        "are on average, 1 = as two views of one thing. Higher: more hypotheses; 0.5 to 0.85 do the same on CLIP's.",
    )
    outlier: float = Field(
        0.2,
        ge=-1,
        lt=1,
        description="Observations less similar than this (0 = unlike, 1 = same) to every hypothesis of a well-known "
        "track are not fused. Higher: fewer vectors of other things, and a side never seen before may be refused; -1 = "
        "all are fused, as in the paper.",
    )
    similarity_scale: Literal["calibrated", "cosine"] = Field(
        "calibrated",
        description="What sigma_sim is compared with: similarity in units of unlike ... same, or the raw cosine to the "
        "hypothesis, as the paper: what it means depends on the embedder.",
    )
    when_full: Literal["replace", "drop"] = Field(
        "replace",
        description="A vector unlike all hypotheses of a full bank replaces the weakest if it is stronger, and else "
        "joins the nearest; or is dropped, as the paper knows no rule for it: late views count less.",
    )
    merge_hypotheses: bool = Field(
        True,
        description="Whether hypotheses whose directions agree beneath their noise are read as one. Off: as they are, "
        "as in the paper; noisy views of one thing stay apart.",
    )

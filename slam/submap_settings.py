"""Settings of submaps: when they are begun and merged."""

from __future__ import annotations

from pydantic import Field

from razer.settings import Settings


class SubmapSettings(Settings):
    """When tracking that was lost begins a submap of its own, and when submaps are merged."""

    patience_frames: int = Field(
        2,
        ge=0,
        description="Frames that show something but nothing known, after which a new submap is begun. Larger: fewer "
        "submaps, later ones; 0: at once.",
    )
    resume_frames: int = Field(
        30,
        ge=0,
        description="Frames after which a camera that was lost may be anywhere; until then it is looked for near its "
        "last keyframe. Larger: goes on after longer gaps, and sooner at a wrong place.",
    )
    min_hypotheses: int = Field(
        3,
        ge=1,
        description="Views that must agree before two submaps are merged. Smaller: look-alike rooms are merged; "
        "larger: submaps stay unanchored.",
    )
    max_contradiction: float = Field(
        0.05,
        ge=0,
        le=1,
        description="Mean contradiction of all views in reach above which a merge is refused; look-alikes have 0.3 or "
        "more, true merges 0.003. Larger: look-alikes pass; smaller: moved things keep submaps apart.",
    )
    max_color_excess: float = Field(
        3.0,
        ge=1,
        description="How many times as many colours as usual may differ from those of all views in reach; with more a "
        "merge is refused. Look-alikes have 10 or more, true merges 1. Larger: look-alikes pass; smaller: changes of "
        "light keep submaps apart.",
    )

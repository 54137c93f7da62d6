"""Settings of reintegration: how the map follows corrected poses, with what each direction costs."""

from __future__ import annotations

from pydantic import Field

from razer.settings import Settings


class ReintegrationSettings(Settings):
    """How the map follows poses that are corrected after their frames were fused."""

    enabled: bool = Field(
        False,
        description="Keep frames, so that the map can be rebuilt. Costs some 5 ms and 65 KB for each one "
        "kept, and a second volume while it is rebuilt; given poses need none of it.",
    )
    frames_per_keyframe: int = Field(
        2,
        ge=1,
        le=10,
        description="Every how many fused frames one is kept. Larger: less time and memory, ragged edges where the "
        "camera moved fast (F-score at 2 cm against all frames: 0.995 for 1, 0.991 for 2, 0.985 for 3).",
    )
    keyframe_stride: int = Field(
        4,
        ge=1,
        description="Of how many kept frames a rebuild during the run replays one; at the end all are mapped again. "
        "Larger: sooner done, rougher until the end.",
    )
    replays_per_frame: float = Field(
        0.2,
        ge=0,
        description="Frames replayed during the run for each frame fused, on average; one takes about a third of the "
        "time of a frame. 0 = the map follows at the end only.",
    )
    max_replays_per_frame: int = Field(
        2, ge=1, description="Most frames replayed after a fused one. Larger: a rebuild is done sooner, but stutters."
    )
    min_shift_voxels: float = Field(
        1.0,
        ge=0,
        description="Rebuild during the run when frames have moved by this on average, voxels at 2 m depth. Smaller: "
        "time is spent on shifts that hardly show.",
    )
    min_final_shift_voxels: float = Field(
        0.25,
        ge=0,
        description="Rebuild at the end when any frame has moved by this, voxels at 2 m depth. Smaller: more time at "
        "the end for a surface no better.",
    )
    fuse_shared_votes: float = Field(
        0.3,
        gt=0,
        le=1,
        description="After a rebuild two tracks that look alike and that no frame shows together are fused when this "
        "share of the votes of one lies in voxels the other claims too. Larger: duplicates stay.",
    )
    memory_mb: int = Field(
        512,
        ge=0,
        description="Kept frames beyond this go to a temporary file, units of 10^6 bytes: about 20,000 frames of a "
        "run. Smaller: less memory, slower rebuilds.",
    )

"""Settings of the timeline: how often and how finely it is logged, which is what it costs."""

from __future__ import annotations

from pydantic import Field

from razer.settings import Settings


class TimelineConfig(Settings):
    """What goes onto the timeline. The defaults take some 60 KB a frame of 640x480, and 4 MB for the map."""

    image_every: int = Field(
        4, ge=1, description="Frames between logged colour images. Smaller: smoother, larger file."
    )
    image_max_edge: int = Field(
        512, ge=64, description="Longest edge of logged colour images, pixels; larger ones are scaled down."
    )
    jpeg_quality: int = Field(70, ge=1, le=100, description="JPEG quality of colour images. Higher: larger file.")
    ids_every: int = Field(2, ge=1, description="Frames between logged images with instances outlined and named.")
    depth_every: int = Field(10, ge=1, description="Frames between logged depth images.")
    raster_max_edge: int = Field(
        320, ge=64, description="Longest edge of logged depth images, pixels; larger ones keep every n-th pixel."
    )
    decisions: bool = Field(True, description="Log, for each frame, why each detection went where it went.")
    surface_every: int = Field(
        5, ge=1, description="Frames between checks of which parts of the map changed enough to log, with the boxes."
    )
    surface_growth: float = Field(
        2.5, gt=1, le=10,
        description="A part of the map is logged again when it has been observed this many times as often. "
        "Smaller: livelier surface, larger file.",
    )  # fmt: skip
    surface_cell_m: float = Field(
        0.06, gt=0, description="Edge of the cells that the growing surface is simplified by, metres. Larger: coarser."
    )
    mesh_max_vertices: int = Field(
        120_000, ge=1000, description="The final mesh is logged coarser if it has more vertices; the saved one stays."
    )
    path_every: int = Field(
        3, ge=1, description="Frames between logged additions to the camera's path where poses are estimated."
    )
    ellipsoid_sigmas: float = Field(
        1.0,
        gt=0,
        description="Size of the ellipsoids round estimated positions of keyframes, standard deviations. Larger: "
        "easier to see, and to mistake for a larger uncertainty.",
    )
    shown_move_m: float = Field(
        0.01,
        ge=0,
        description="Minimum move of a keyframe, metres, for an optimisation of poses to be shown before and after.",
    )
    close_timeout_s: float = Field(
        20.0, gt=0, description="Longest wait, seconds, for the file to be written out at the end of a run."
    )

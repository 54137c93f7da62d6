"""Configuration of a run: the method's own sections, input, models, pose estimation, timeline."""

from __future__ import annotations

from typing import Literal

from pydantic import Field, ValidationInfo, field_validator
from pydantic_core import PydanticCustomError

from app.timeline.config import TimelineConfig
from data_tools.recordings.camera import GUESS
from razer.config import MapperConfig
from razer.plugins import PluginSettings
from razer.settings import Settings
from slam.config import SlamConfig


class InputSettings(PluginSettings):
    """Input: the recording's layout, frames and poses, and the camera parameters that it does not state itself."""

    reader: str | None = Field(
        None, description="Layout of the folder: a reader's name, or module:function. Not set: recognised."
    )
    folder: str | None = Field(None, description="The recording, as a run records it. Has no effect on a new run.")
    start: int = Field(0, ge=0, description="Index of the first frame to use.")
    end: int | None = Field(
        None, ge=1, description="Index one past the last frame to use. Not set, or past the end: all to the end."
    )
    stride: int = Field(
        1, ge=1, description="Use every n-th frame. Larger: faster, with less overlap between frames in fast motion."
    )
    max_frames: int | None = Field(None, ge=1, description="Use at most this many frames. Not set: all.")
    poses: Literal["given", "slam", "refine", "auto"] = Field(
        "auto",
        description="Where poses come from: 'given' with the folder, 'slam' from its images, 'refine' from both: those "
        "given, corrected by registration; 'auto' takes those given if there are any.",
    )
    sparse: bool | None = Field(
        None,
        description="Whether poses are estimated by matching all pictures with each other, in any order, not by "
        "following the camera. Not set: below 2 pictures a second, and where following it fails.",
    )
    poses_from: str | None = Field(
        None,
        description="File whose poses stand for those given with the folder: TUM, KITTI, COLMAP's images.txt or "
        "transforms.json. Not set: the folder's own.",
    )
    max_bad: float = Field(0.5, ge=0, le=1, description="Share of unusable frames above which the run gives up.")
    intrinsics: str | None = Field(
        None,
        description="Camera: 'fx,fy,cx,cy[,k1,k2,p1,p2,k3]' in pixels, a JSON file, or 'guess': nobody knows them, and "
        "they are estimated from pairs of views. Not set: the folder's.",
    )
    refine_intrinsics: bool = Field(
        False, description="Whether the intrinsics are a guess, which pairs of views are to refine before the run."
    )
    intrinsics_note: str | None = Field(
        None, description="How refined intrinsics came about, as a run records it. Has no effect on a new run."
    )
    depth_scale: float | None = Field(
        None, gt=0, description="Units of the depth images in a metre. Not set: from the folder or its layout."
    )
    rgbd_calibration: str = Field(
        "auto",
        description="Colour camera beside the depth camera: 'auto' estimates it and uses it where colour surely does "
        "not fit depth, 'off' takes colour as it is, or a file as `razer inspect --write` makes it.",
    )
    depth_to_color: str | None = Field(
        None, description="File with the 4x4 transform from the depth to the colour camera, if not registered."
    )

    @property
    def guess_intrinsics(self) -> bool:
        """Whether the intrinsics that the settings lead to are a guess, to be refined."""
        return self.refine_intrinsics or self.intrinsics == GUESS

    @field_validator("end")
    @classmethod
    def _check_end(cls, end: int | None, info: ValidationInfo) -> int | None:
        start = info.data.get("start")  # none if that was refused
        if end is not None and start is not None and end <= start:
            raise PydanticCustomError("empty_range", "should be greater than input.start, {start}", {"start": start})
        return end


class RunSettings(Settings):
    """How the program runs."""

    device: Literal["auto", "cpu", "cuda"] = Field(
        "auto", description="Where voxels live; 'auto' takes CUDA where Open3D and the machine have it."
    )
    checkpoint_every: int | None = Field(
        None,
        ge=0,
        description="Frames between checkpoints, from which a killed run can be resumed; 0: none. Not set: by time, "
        "every minute, or more rarely where that would take more than 3 % of the run's time. Smaller: less is lost, "
        "at more time.",
    )
    timeline: bool = Field(True, description="Write timeline.rrd. Costs up to 15 % of the run's time.")


class RunConfig(MapperConfig):
    """All settings of a run; the sections of MapperConfig lie beside those of the program."""

    format: Literal[1] = Field(1, description="Version of this set of names.")
    input: InputSettings = InputSettings()
    slam: SlamConfig = SlamConfig()
    run: RunSettings = RunSettings()
    timeline: TimelineConfig = TimelineConfig()

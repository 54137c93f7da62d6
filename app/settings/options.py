"""Command-line options that several verbs share."""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import Parameter

from app.settings.config_file import read_config
from app.settings.oracle_options import OracleErrors, oracle_flags
from app.settings.run_config import InputSettings, RunConfig
from razer.errors import BadInput
from razer.plugins import FULL_TRUST, NO_TRUST, Trust

Assignments = Annotated[
    tuple[str, ...], Parameter(name="--set", negative="", show_default=False, consume_multiple=False)
]
PosesName = Literal["given", "slam", "auto", "both"]
BOTH: tuple[PosesName, ...] = ("given", "slam")
DEFAULT_PORT = 8700
Flag = Annotated[bool, Parameter(negative="", show_default=False)]


@Parameter(name="*")
@dataclass(frozen=True)
class TrustOptions:
    """Which code may be loaded that is not part of the project."""

    trust_plugins: Flag = False
    """Load module:Class also where a file names it, not only the command line. It runs with your rights."""

    @property
    def trust(self) -> Trust:
        """The trust that these options grant."""
        return FULL_TRUST if self.trust_plugins else NO_TRUST


@Parameter(name="*")
@dataclass(frozen=True)
class SettingOptions(TrustOptions):
    """Settings from a preset, from a file and from the command line; later ones win."""

    preset: str | None = None
    """A named set of settings to start from: paper, everything as the paper says it."""
    config: Path | None = None
    """TOML file with settings, such as the config.toml of an earlier run."""
    set: Assignments = ()
    """One setting as section.key=value; may be repeated. `razer config` lists them all."""


@Parameter(name="*")
@dataclass(frozen=True)
class SourceOptions:
    """Reader and camera parameters, where the recording does not state them."""

    reader: str | None = None
    """Layout of the recording: a reader's name or module:function; detected if not given."""
    intrinsics: str | None = None
    """fx,fy,cx,cy[,k1,k2,p1,p2,k3] in pixels, or a JSON file."""
    depth_scale: float | None = None
    """Depth image units per metre: 1000 for millimetres."""
    depth_to_color: str | None = None
    """File with the 4x4 extrinsic transform from the depth to the colour camera."""

    def input_settings(self) -> InputSettings:
        """The settings these options lead to; raises BadInput."""
        return read_config(None, (), self._recording_flags()).input

    def _recording_flags(self) -> dict[str, Any]:
        known = {field.name for field in fields(self)} & set(InputSettings.model_fields)
        return {f"input.{name}": getattr(self, name) for name in known}


@Parameter(name="*")
@dataclass(frozen=True)
class RecordingOptions(SourceOptions):
    """Which frames of a recording are read, and how."""

    start: int | None = None
    """Index of the first frame to use."""
    end: int | None = None
    """Index one past the last frame to use; all to the end if not given."""
    stride: int | None = None
    """Use every n-th frame."""
    max_frames: Annotated[int | None, Parameter(name=("--max-frames", "--frames"))] = None
    """Use at most this many frames."""


@Parameter(name="*")
@dataclass(frozen=True)
class TrackOptions(RecordingOptions, SettingOptions):
    """A recording, and settings of which those of the pose estimation count."""

    def read(self) -> RunConfig:
        """The settings these options lead to; raises BadInput."""
        flags = self._recording_flags()
        return read_config(self.config, self.set, flags, trust=self.trust, preset=self.preset)


@Parameter(name="*")
@dataclass(frozen=True)
class RunOptions(RecordingOptions, SettingOptions):
    """Options that are shorter names for settings; those not given leave the setting as it is."""

    poses: PosesName | None = None
    """given with the recording, estimated by slam, or auto: given if there are any; both: two runs, compared."""
    max_bad: float | None = None
    """Largest share of unusable frames before the run is given up."""
    rgbd_calibration: str | None = None
    """auto: where colour does not fit depth, its camera is estimated; off; or a file of `razer inspect --write`."""
    segmenter: str | None = None
    """2D segmenter: a name or module:Class; auto, as if not given, takes the models that are here."""
    embedder: str | None = None
    """Embedder of masks: a name or module:Class; auto, as if not given, takes a model of words that is here."""
    oracle: OracleErrors | None = None
    """Instead of both the recording's truth with simulated errors, as of a SAM, a detector or a panoptic model."""
    device: Literal["auto", "cpu", "cuda"] | None = None
    """Device of the voxel map."""
    timeline: bool | None = None
    """Write the timeline (the default) or not."""

    def read(self) -> RunConfig:
        """The settings these options lead to; raises BadInput."""
        return read_config(self.config, self.set, self.flags(), trust=self.trust, preset=self.preset)

    def flags(self) -> dict[str, Any]:
        """Dotted names of settings with the values of these options, None = not given; raises BadInput."""
        if self.poses == "both":
            raise BadInput("--poses both means two runs, which only `razer run` and `razer reproduce` make")
        models = {"segmenter.name": self.segmenter, "embedder.name": self.embedder}
        if self.oracle is not None:
            if self.segmenter or self.embedder:
                raise BadInput(f"--oracle {self.oracle} stands for --segmenter and --embedder: leave them out")
            models = oracle_flags(self.oracle)
        return self._recording_flags() | models | {"run.device": self.device, "run.timeline": self.timeline}

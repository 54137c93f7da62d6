"""Command-line options that several verbs share."""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path
from typing import Annotated, Any, Literal, get_args

from cyclopts import Group, Parameter

from app.settings.config_file import read_config
from app.settings.oracle_options import OracleErrors, oracle_flags
from app.settings.run_config import InputSettings, RunConfig
from razer.errors import BadInput
from razer.plugins import FULL_TRUST, NO_TRUST, Trust

Assignments = Annotated[
    tuple[str, ...], Parameter(name="--set", negative="", show_default=False, consume_multiple=False)
]
PosesName = Literal["given", "slam", "refine", "auto", "both"]
BOTH: tuple[PosesName, ...] = ("given", "slam")
DEFAULT_PORT = 8700
Flag = Annotated[bool, Parameter(negative="", show_default=False)]
POSES, MODELS, WATCHING, RECORDING, SETTINGS = (
    Group(name, sort_key=place)
    for place, name in enumerate(("Poses", "Models", "While it runs", "Recording", "Settings"), start=1)
)


def _in(group: Group, default: str = "", name: str | tuple[str, ...] | None = None) -> Parameter:
    """An option of a group of the help; `default` says what holds where it is not given, which a setting knows."""
    return Parameter(name=name, group=group, show_default=default or False)


def _word(name: str, value: object) -> str:
    """An option as it is typed."""
    if isinstance(value, bool):
        return f"--{name}" if value else f"--no-{name}"
    return f"--{name}={value}"


@Parameter(name="*")
@dataclass(frozen=True)
class TrustOptions:
    """Which code may be loaded that is not part of the project."""

    trust_plugins: Annotated[Flag, _in(SETTINGS)] = False
    """Load module:Class also where a file names it, not only the command line. It runs with your rights."""

    @property
    def trust(self) -> Trust:
        """The trust that these options grant."""
        return FULL_TRUST if self.trust_plugins else NO_TRUST


@Parameter(name="*")
@dataclass(frozen=True)
class SettingOptions(TrustOptions):
    """Settings from a preset, from a file and from the command line; later ones win."""

    preset: Annotated[str | None, _in(SETTINGS)] = None
    """A named set of settings to start from: paper, everything as the paper says it."""
    config: Annotated[Path | None, _in(SETTINGS)] = None
    """TOML file with settings, such as the config.toml of an earlier run."""
    set: Annotated[Assignments, Parameter(group=SETTINGS)] = ()
    """One setting as section.key=value; may be repeated. `razer config` lists them all."""


@Parameter(name="*")
@dataclass(frozen=True)
class SourceOptions:
    """Reader and camera parameters, where the recording does not state them."""

    reader: Annotated[str | None, _in(RECORDING, "detected")] = None
    """Layout of the recording: a reader's name or module:function."""
    intrinsics: Annotated[str | None, _in(RECORDING, "the recording's")] = None
    """fx,fy,cx,cy[,k1,k2,p1,p2,k3] in pixels, a JSON file, or guess: estimated from the views."""
    refine_intrinsics: Annotated[Flag | None, _in(RECORDING)] = None
    """The intrinsics are a guess: refined from pairs of views, where these tell them."""
    depth_scale: Annotated[float | None, _in(RECORDING, "the recording's")] = None
    """Depth image units per metre: 1000 for millimetres."""
    depth_to_color: Annotated[str | None, _in(RECORDING, "the recording's")] = None
    """File with the 4x4 extrinsic transform from the depth to the colour camera."""
    poses_from: Annotated[Path | None, _in(RECORDING, "the recording's")] = None
    """File with other poses: TUM, KITTI, COLMAP's images.txt or transforms.json; its content tells which."""

    def input_settings(self) -> InputSettings:
        """The settings these options lead to; raises BadInput."""
        return read_config(None, (), self._recording_flags()).input

    def words(self) -> tuple[str, ...]:
        """The options of the recording that were given, as another verb takes them: --reader NAME ..."""
        given = {name.removeprefix("input."): value for name, value in self._recording_flags().items()}
        return tuple(_word(name.replace("_", "-"), given[name]) for name in sorted(given) if given[name] is not None)

    def _recording_flags(self) -> dict[str, Any]:
        known = {field.name for field in fields(self)} & set(InputSettings.model_fields)
        elsewhere = None if self.poses_from is None else str(self.poses_from.absolute())  # a run may go on elsewhere
        return {f"input.{name}": getattr(self, name) for name in known} | {"input.poses_from": elsewhere}


@Parameter(name="*")
@dataclass(frozen=True)
class RecordingOptions(SourceOptions):
    """Which frames of a recording are read, and how."""

    start: Annotated[int | None, _in(RECORDING, "0")] = None
    """Index of the first frame to use."""
    end: Annotated[int | None, _in(RECORDING, "all")] = None
    """Index one past the last frame to use."""
    stride: Annotated[int | None, _in(RECORDING, "1")] = None
    """Use every n-th frame."""
    max_frames: Annotated[int | None, _in(RECORDING, "all", ("--max-frames", "--frames"))] = None
    """Use at most this many frames."""


@Parameter(name="*")
@dataclass(frozen=True)
class TrackOptions(RecordingOptions, SettingOptions):
    """A recording, and settings of which those of the pose estimation count."""

    poses: Annotated[Literal["slam", "refine"] | None, _in(POSES, "slam")] = None
    """Estimated by slam from the images alone, or refine: the given ones, corrected."""
    sparse: Annotated[bool | None, _in(POSES, "auto")] = None
    """Match all pictures with each other, in any order, in place of following the camera, or not; auto: below 2
    pictures a second, and where the camera is lost too often."""

    def read(self) -> RunConfig:
        """The settings these options lead to; raises BadInput."""
        flags = self._recording_flags()
        return read_config(self.config, self.set, flags, trust=self.trust, preset=self.preset)


@Parameter(name="*")
@dataclass(frozen=True)
class RunOptions(RecordingOptions, SettingOptions):
    """Options that are shorter names for settings; those not given leave the setting as it is."""

    poses: Annotated[PosesName | Path | None, _in(POSES, "auto")] = None
    """given with the recording, estimated by slam, refine: given and corrected, or auto: given if there are any; both:
    given and slam, two runs, compared; a file: given by it, as with --poses-from."""
    sparse: Annotated[bool | None, _in(POSES, "auto")] = None
    """Match all pictures with each other, in any order, in place of following the camera, or not; auto: below 2
    pictures a second, and where the camera is lost too often."""
    max_bad: Annotated[float | None, _in(RECORDING, "0.5")] = None
    """Largest share of unusable frames before the run is given up."""
    rgbd_calibration: Annotated[str | None, _in(RECORDING, "auto")] = None
    """auto: where colour does not fit depth, its camera is estimated; off; or a file of `razer inspect --write`."""
    segmenter: Annotated[str | None, _in(MODELS, "auto")] = None
    """2D segmenter: a name or module:Class; auto takes the models that are here."""
    embedder: Annotated[str | None, _in(MODELS, "auto")] = None
    """Embedder of masks: a name or module:Class; auto takes a model of words that is here."""
    oracle: Annotated[OracleErrors | None, _in(MODELS, "none")] = None
    """Instead of both the recording's truth with simulated errors, as of a SAM, a detector or a panoptic model."""
    device: Annotated[Literal["auto", "cpu", "cuda"] | None, _in(SETTINGS, "auto")] = None
    """Device of the voxel map."""
    timeline: Annotated[bool | None, _in(SETTINGS, "--timeline")] = None
    """Write the timeline or not."""
    checkpoint_every: Annotated[int | None, _in(SETTINGS, "every minute")] = None
    """Frames between checkpoints, from which a killed run can be resumed; 0: none."""

    def read(self) -> RunConfig:
        """The settings these options lead to; raises BadInput."""
        return read_config(self.config, self.set, self.flags(), trust=self.trust, preset=self.preset)

    def words(self) -> tuple[str, ...]:
        """The options that were given, as another verb takes them."""
        shared: dict[str, object] = {
            "oracle": self.oracle,
            "segmenter": self.segmenter,
            "embedder": self.embedder,
            "poses": self.poses,
        }
        shared |= {"rgbd-calibration": self.rgbd_calibration, "device": self.device, "preset": self.preset}
        shared |= {"config": self.config}
        given = tuple(f"--{name}={value}" for name, value in shared.items() if value is not None)
        return (*super().words(), *given, *(f"--set={text}" for text in self.set))

    def flags(self) -> dict[str, Any]:
        """Dotted names of settings with the values of these options, None = not given; raises BadInput."""
        models = {"segmenter.name": self.segmenter, "embedder.name": self.embedder}
        if self.oracle is not None:
            if self.segmenter or self.embedder:
                raise BadInput(f"--oracle {self.oracle} stands for --segmenter and --embedder: leave them out")
            models = oracle_flags(self.oracle)
        return (
            self._recording_flags()
            | self._poses_flags()
            | models
            | {"run.device": self.device, "run.timeline": self.timeline, "run.checkpoint_every": self.checkpoint_every}
        )

    def _poses_flags(self) -> dict[str, Any]:
        """What --poses sets: which poses are used, or the file whose poses are."""
        if self.poses == "both":
            raise BadInput("--poses both means two runs, which only `razer run` and `razer reproduce` make")
        if not isinstance(self.poses, Path):
            return {}
        if self.poses_from is not None:
            raise BadInput(f"--poses {self.poses} and --poses-from {self.poses_from} both name a file: leave one out")
        if not self.poses.exists():
            choices = ", ".join(get_args(PosesName))
            raise BadInput(f"--poses {self.poses}: there is no such file, and it is none of {choices} (see --help)")
        return {"input.poses": "given", "input.poses_from": str(self.poses.absolute())}

"""Command-line options of a synthetic recording: of what, by which camera, on which walk."""

from __future__ import annotations

import re
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from app.settings.assignments import split_assignment
from app.settings.options import Assignments
from razer.errors import BadInput
from razer.storage.file_names import EDITS, is_map_folder

if TYPE_CHECKING:
    from collections.abc import Callable

    from data_tools.synthetic.camera.rgbd_misalignment import RgbdMisalignment
    from data_tools.synthetic.camera.sensor_model import SensorModel
    from data_tools.synthetic.rendered_frames import RenderedFrames

MOST_FRAMES = 1_000_000
_DEFAULT_SCENE = "room"
MOST_PEOPLE = 20
# Negative numbers begin as options do.
Text = Annotated[str, Parameter(allow_leading_hyphen=True)]


@Parameter(name="*")
@dataclass(frozen=True)
class MisalignmentOptions:
    """The true colour camera, where it is not the declared one."""

    rgb_zoom: float = 1.0
    """Focal length of colour relative to depth's. What is declared stays one camera for both; the truth says which."""
    rgb_shift: Text = "0,0"
    """X,Y: by how many pixels of the image colour lies further to the right and down than depth."""
    rgb_baseline: Text = "0,0,0"
    """X,Y,Z: where the colour camera stands in the depth camera (right, down, forward), metres."""

    def misalignment(self) -> RgbdMisalignment:
        """How the colour camera differs from the depth camera; raises BadInput."""
        from data_tools.synthetic.camera.rgbd_misalignment import RgbdMisalignment

        right, down = _numbers("--rgb-shift", self.rgb_shift, "X,Y")
        x, y, z = _numbers("--rgb-baseline", self.rgb_baseline, "X,Y,Z")
        return RgbdMisalignment(self.rgb_zoom, (right, down), (x, y, z))


@Parameter(name="*")
@dataclass(frozen=True)
class SceneOptions(MisalignmentOptions):
    """Synthetic scene or labelled mesh, camera path and sensor model."""

    scene: str = _DEFAULT_SCENE
    """room, apartment, corridor-loop, tabletop, warehouse, corridors or twin-rooms."""
    extent: str = ""
    """Length x width of a warehouse or of corridors, metres, such as 60x60; their usual size if not given."""
    light: Literal["day", "evening"] = "day"
    """day: light from the windows; evening: from lamps and ceilings."""
    people: int = 0
    """How many people walk about in a scene. They are in the frames, with instance id 0, and not in the truth."""
    walls: Literal["painted", "textured", "bare"] = "painted"
    """Walls and ceilings of a scene. painted: a faint grain; textured: bricks, wood and such; bare: one even colour."""
    mesh: Path | None = None
    """Instead of a scene a labelled mesh: a PLY file, or a folder with a truth (ScanNet, Replica, SceneNN, own)."""
    mesh_scale: float = 1.0
    """Metres per unit of the mesh: 0.001 for millimetres."""
    up: Text = "auto"
    """Which way is up in the mesh: x, y, z, -x, -y, -z or three numbers; auto: by its level surfaces."""
    seed: int = 0
    """Seed of layout, colours, the walk through a mesh, and camera shake."""
    frames: int = 0
    """Frames, spread evenly over the camera path; 0 = 15 a second."""
    size: str = "640x480"
    """Width x height of the images, pixels."""
    sensor: Literal["kinect", "plain", "none"] = "kinect"
    """kinect: every error of such a camera; plain: depth noise and missing edges; none: an ideal camera."""
    set: Assignments = ()
    """One error of the sensor model as name=strength; may be repeated. 0 switches it off."""

    def sequence(self, report: Callable[[str], None] | None = None) -> RenderedFrames:
        """The recording; `report` is told what takes long; raises BadInput."""
        match = re.fullmatch(r"(\d+)x(\d+)", self.size)
        if not match or not all(8 <= int(n) <= 8192 for n in match.groups()):
            raise BadInput(f"--size {self.size}: write it as 640x480")
        if self.seed < 0:
            raise BadInput(f"seed {self.seed} is negative: give 0 or more")
        if not 0 <= self.frames <= MOST_FRAMES:
            raise BadInput(f"--frames {self.frames}: give 0 to {MOST_FRAMES:,}")
        walk = self.seed, self.frames, int(match[1]), int(match[2])
        cameras: dict[str, Any] = {"sensor": self.sensor_model(), "misalignment": self.misalignment()}
        if not 0 <= self.people <= MOST_PEOPLE:
            raise BadInput(f"--people {self.people}: give 0 to {MOST_PEOPLE}")
        if self.mesh is None:
            from data_tools.synthetic.synthetic_scene import SyntheticScene

            cameras |= {"light": self.light, "people": self.people, "extent_m": self._extent_m()}
            cameras |= {"walls": self.walls}
            return SyntheticScene(self.scene, *walk, **cameras)
        from data_tools.synthetic.mesh_sequence import MeshSequence

        self._check_mesh()
        return MeshSequence(self.mesh, *walk, **cameras, up=self.up, scale=self.mesh_scale, report=report)

    def sensor_model(self) -> SensorModel:
        """The sensor with some errors of another strength; raises BadInput."""
        from data_tools.synthetic.camera.sensor_model import SensorModel

        changes: dict[str, Any] = {}
        known = [field.name for field in fields(SensorModel) if field.name != "range_m"]
        for assignment in self.set:
            name, text = split_assignment(assignment, f"error=strength, with one of {', '.join(known)}", known)
            try:
                changes[name] = float(text)
            except ValueError:
                raise BadInput(f"--set {assignment}: {text} is no number") from None
        model: SensorModel = getattr(SensorModel, self.sensor)()
        return replace(model, **changes)

    def _extent_m(self) -> tuple[float, float] | None:
        if not self.extent:
            return None
        match = re.fullmatch(r"(\d+(?:\.\d+)?)x(\d+(?:\.\d+)?)", self.extent)
        if not match:
            raise BadInput(f"--extent {self.extent}: write it in metres as 60x60")
        return float(match[1]), float(match[2])

    def _check_mesh(self) -> None:
        if self.scene != _DEFAULT_SCENE:
            raise BadInput(f"--scene {self.scene} and --mesh {self.mesh}: give one of them")
        if self.extent or self.people or self.light != "day" or self.walls != "painted":
            raise BadInput("--extent, --light, --people and --walls are for scenes: a mesh has its own size and looks")
        if not 0 < self.mesh_scale < float("inf"):
            raise BadInput(f"--mesh-scale {self.mesh_scale:g}: give metres per unit, such as 0.001 for millimetres")
        assert self.mesh is not None
        folder = self.mesh if self.mesh.is_dir() else self.mesh.parent
        if is_map_folder(folder) and (folder / EDITS).is_file():
            raise BadInput(
                f"{folder} has hand edits, which a mesh file does not show: save the edited map elsewhere, by "
                "razer.load_map(RUN).save(DIR), and give that"
            )


def _numbers(option: str, text: str, form: str) -> list[float]:
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) != form.count(",") + 1:
        raise BadInput(f"{option} {text}: write it as {form}")
    return numbers
